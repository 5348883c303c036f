// uses: dispatch, receiver
// From visibility to irradiance under one sky, `lobe_shadow::SkyLight`: E(n) = sum_j y_j(n) sum_i (A_j G_ji) V_i, with a row of
// COEFFICIENTS colors for each function y_j of which the clamped cosine has a band; its number is in the fourth place of each.

// The receivers of this piece, and what else `accumulate` is told.
@group(0) @binding(0) var<uniform> sizes: vec4u;
@group(0) @binding(1) var<storage, read> operator_rows: array<vec4f>;
@group(0) @binding(2) var<storage, read> receivers: array<Receiver>;
@group(0) @binding(3) var<storage, read> visibility: array<f32>;
@group(0) @binding(4) var<storage, read_write> irradiance: array<vec4f>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let r = item_of(id, groups);
    let count = sizes.x;
    if r >= count {
        return;
    }
    let y = basis_9(receivers[r].normal.xyz);
    var sum = vec3f(0.0);
    for (var row = 0u; row < arrayLength(&operator_rows) / COEFFICIENTS; row++) {
        var along = vec3f(0.0);
        for (var i = 0u; i < COEFFICIENTS; i++) {
            along += visibility[i * count + r] * operator_rows[row * COEFFICIENTS + i].rgb;
        }
        sum += y[u32(operator_rows[row * COEFFICIENTS].w)] * along;
    }
    irradiance[r] = vec4f(sum, 1.0);
}
