// uses: dispatch, shadow_receiver, product
// What stands still leaves of the sky at receivers that move, `lobe_render::VisibilityGrid`: linear between the points of a grid along
// each axis, turned to the frame of the receivers, times what they see already, cut off at the order.

struct Grid {
    // From positions in the frame of the receivers to places in the grid: rows.
    to_place: array<vec4f, 3>,
    // Points along each axis, numbers of a point.
    counts: vec4u,
    // Receivers of this piece; 1 if the frame is turned; 1 if they have visibility before.
    receivers: vec4u,
}

@group(0) @binding(0) var<uniform> grid: Grid;
@group(0) @binding(1) var<storage, read> receivers: array<Receiver>;
@group(0) @binding(2) var<storage, read> rows: array<f32>;
// The rotation from the world to the frame, band after band and row after row.
@group(0) @binding(3) var<storage, read> turn: array<f32>;
// Number i of receiver r is at i * receivers + r.
@group(0) @binding(4) var<storage, read> before: array<f32>;
@group(0) @binding(5) var<storage, read_write> visibility: array<f32>;

fn seen_at(position: vec4f) -> array<f32, COEFFICIENTS> {
    var low: vec3u;
    var part: vec3f;
    for (var k = 0u; k < 3u; k++) {
        let at = clamp(dot(grid.to_place[k], position), 0.0, f32(grid.counts[k] - 1u));
        low[k] = min(u32(at), grid.counts[k] - 2u);
        part[k] = at - f32(low[k]);
    }
    var sum: array<f32, COEFFICIENTS>;
    for (var corner = 0u; corner < 8u; corner++) {
        let up = vec3u(corner & 1u, (corner >> 1u) & 1u, corner >> 2u);
        let weights = select(1.0 - part, part, up == vec3u(1u));
        let weight = weights.x * weights.y * weights.z;
        let place = low + up;
        let first = ((place.z * grid.counts.y + place.y) * grid.counts.x + place.x) * grid.counts.w;
        for (var i = 0u; i < COEFFICIENTS; i++) {
            sum[i] += weight * rows[first + i];
        }
    }
    return sum;
}

fn turned(seen: array<f32, COEFFICIENTS>) -> array<f32, COEFFICIENTS> {
    var from_world = seen;
    var out: array<f32, COEFFICIENTS>;
    var entry = 0u;
    for (var l = 0u; l < ORDER; l++) {
        for (var i = l * l; i < (l + 1u) * (l + 1u); i++) {
            var sum = 0.0;
            for (var j = l * l; j < (l + 1u) * (l + 1u); j++) {
                sum += turn[entry] * from_world[j];
                entry++;
            }
            out[i] = sum;
        }
    }
    return out;
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let r = item_of(id, groups);
    let count = grid.receivers.x;
    if r >= count {
        return;
    }
    let position = receivers[r].position;
    var seen = seen_at(vec4f(position.xyz, 1.0));
    if grid.receivers.y == 1u {
        seen = turned(seen);
    }
    if grid.receivers.z == 1u {
        var already: array<f32, COEFFICIENTS>;
        for (var i = 0u; i < COEFFICIENTS; i++) {
            already[i] = before[i * count + r];
        }
        seen = product(seen, already);
    }
    for (var i = 0u; i < COEFFICIENTS; i++) {
        visibility[i * count + r] = seen[i];
    }
}
