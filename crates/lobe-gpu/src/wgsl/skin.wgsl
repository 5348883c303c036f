// uses: dispatch
// Vertices that joints carry and morph targets deform, as `lobe_scene::AnimatedScene` poses them:
//
//   p' = M (p_0 + sum_k w_k dp_k)        n' ~ M^-T (n_0 + sum_k w_k dn_k)        M = sum_j w_j M_j

struct Vertex {
    position: vec4f,
    normal: vec4f,
}

struct Joint {
    rows: array<vec4f, 3>,
}

// Vertices and targets.
@group(0) @binding(0) var<uniform> sizes: vec4u;
@group(0) @binding(1) var<storage, read> rest: array<Vertex>;
// The first pair of each vertex and the end; then pairs of a joint and its weight.
@group(0) @binding(2) var<storage, read> influences: array<u32>;
@group(0) @binding(3) var<storage, read> joints: array<Joint>;
// Target by target what a weight of one adds.
@group(0) @binding(4) var<storage, read> targets: array<Vertex>;
@group(0) @binding(5) var<storage, read> weights: array<f32>;
@group(0) @binding(6) var<storage, read_write> posed: array<Vertex>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let v = item_of(id, groups);
    if v >= sizes.x {
        return;
    }
    var p = rest[v].position.xyz;
    var n = rest[v].normal.xyz;
    for (var k = 0u; k < sizes.y; k++) {
        let weight = weights[k];
        if weight != 0.0 {
            p += weight * targets[k * sizes.x + v].position.xyz;
            n += weight * targets[k * sizes.x + v].normal.xyz;
        }
    }
    var x = vec4f(0.0);
    var y = vec4f(0.0);
    var z = vec4f(0.0);
    for (var pair = influences[v]; pair < influences[v + 1u]; pair++) {
        let at = sizes.x + 1u + 2u * pair;
        let joint = joints[influences[at]];
        let weight = bitcast<f32>(influences[at + 1u]);
        x += weight * joint.rows[0];
        y += weight * joint.rows[1];
        z += weight * joint.rows[2];
    }
    let q = vec4f(p, 1.0);
    // Rows of the cofactors are cross products of rows; a mirror changes their sign.
    let cofactors = vec3f(dot(cross(y.xyz, z.xyz), n), dot(cross(z.xyz, x.xyz), n), dot(cross(x.xyz, y.xyz), n));
    let normal = select(cofactors, -cofactors, dot(x.xyz, cross(y.xyz, z.xyz)) < 0.0);
    let size = length(normal);
    posed[v] = Vertex(
        vec4f(dot(x, q), dot(y, q), dot(z, q), 1.0),
        vec4f(select(vec3f(0.0), normal / size, size > 0.0), 0.0)
    );
}
