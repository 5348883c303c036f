// uses: dispatch, shadow_receiver
// From visibility to irradiance under one sky, `lobe_shadow::SkyLight`: E(n) = sum_j y_j(n) sum_i (A_j G_ji) V_i, times the albedo of
// the receiver, with a row of COEFFICIENTS colors for each function y_j of which the clamped cosine has a band; its number is in the fourth place of each.
// `seen_by` and `along` are written out for each order, place by place, by moving/straight_line.

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
    // A variable, as everywhere: of a list without a place in memory compilers make a copy for each place that a loop asks for.
    var y = order_9_basis(receivers[r].normal.xyz);
    let v = seen_by(r, count);
    var sum = vec3f(0.0);
    for (var row = 0u; row < arrayLength(&operator_rows) / COEFFICIENTS; row++) {
        let first = row * COEFFICIENTS;
        sum += y[u32(operator_rows[first].w)] * along(v, first);
    }
    irradiance[r] = vec4f(sum * receivers[r].albedo.rgb, 1.0);
}
