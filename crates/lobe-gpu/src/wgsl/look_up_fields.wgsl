// uses: field_stencil
// What receivers find in one part of the numbers of all fields, added to what they found in the parts before: where not all fit one
// binding. Points of a stencil lie behind each other in a field, so that sums are taken in the order of `shadow_fields`.

struct Part {
    // Of its numbers among those of all fields.
    first: u32,
    end: u32,
    receivers: u32,
    entities: u32,
}

@group(0) @binding(0) var<uniform> part: Part;
@group(0) @binding(1) var<storage, read> receivers: array<Receiver>;
@group(0) @binding(2) var<storage, read> entities: array<Entity>;
@group(0) @binding(3) var<storage, read> numbers: array<f32>;
// Number i of receiver r and entity k is at (k * ROW + i) * receivers + r.
@group(0) @binding(4) var<storage, read_write> found: array<f32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let item = item_of(id, groups);
    if item >= part.receivers * part.entities {
        return;
    }
    let r = item % part.receivers;
    let k = item / part.receivers;
    let place = k * ROW * part.receivers + r;
    let entity = entities[k];
    var sum: array<f32, ROW>;
    if part.first > 0u {
        for (var i = 0u; i < ROW; i++) {
            sum[i] = found[place + i * part.receivers];
        }
    }
    var stencil = stencil_at(entity, own_of(entity, receivers[r].position.xyz - entity.center.xyz));
    let order = entity.grid.w;
    for (var j = 0u; j < stencil.len; j++) {
        let weight = stencil.weights[j];
        let number = entity.grid.z + stencil.points[j] * (order + order * order);
        if number < part.first || number >= part.end {
            continue;
        }
        let first = number - part.first;
        for (var l = 0u; l < ORDER; l++) {
            sum[l] += weight * numbers[first + l];
        }
        for (var i = 0u; i < COEFFICIENTS; i++) {
            sum[ORDER + i] += weight * numbers[first + order + i];
        }
    }
    for (var i = 0u; i < ROW; i++) {
        found[place + i * part.receivers] = sum[i];
    }
}
