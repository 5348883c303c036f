// uses: dispatch, receiver
// What glossy receivers send towards the eye: their blurred incident light in the mirrored direction r = 2 (n.v) n - v,
// nothing below the surface.

@group(0) @binding(0) var<uniform> eye: vec4f;
// Receivers in this piece.
@group(0) @binding(1) var<uniform> piece: vec4u;
@group(0) @binding(2) var<storage, read> receivers: array<Receiver>;
@group(0) @binding(3) var<storage, read> incident: array<vec4f>;
@group(0) @binding(4) var<storage, read_write> radiance: array<vec4f>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let r = item_of(id, groups);
    if r >= piece.x {
        return;
    }
    let n = receivers[r].normal.xyz;
    let v = normalize(eye.xyz - receivers[r].position.xyz);
    let cosine = dot(n, v);
    var sum = vec3f(0.0);
    if cosine > 0.0 {
        var y = basis(normalize(2.0 * cosine * n - v));
        for (var i = 0u; i < COEFFICIENTS; i++) {
            sum += y[i] * incident[r * COEFFICIENTS + i].rgb;
        }
    }
    radiance[r] = vec4f(sum, 1.0);
}
