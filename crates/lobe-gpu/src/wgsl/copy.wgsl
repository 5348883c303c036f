// uses: dispatch
// One buffer into another, to measure how fast the device moves bytes.

@group(0) @binding(0) var<storage, read> from_here: array<vec4f>;
@group(0) @binding(1) var<storage, read_write> to_there: array<vec4f>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = item_of(id, groups);
    if i < arrayLength(&to_there) {
        to_there[i] = from_here[i];
    }
}
