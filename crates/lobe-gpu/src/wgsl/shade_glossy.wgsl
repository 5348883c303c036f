// uses: surface, dfg
// Glossy surfaces: the blurred incident light of vertices, interpolated, in the mirrored direction, times the directional
// albedo: the base color, or for microfacets (gloss.x = 1) that of the split sum at the roughness gloss.y.

@group(0) @binding(6) var<storage, read> incident: array<vec4f>;
@group(0) @binding(7) var<uniform> gloss: vec4f;
@group(0) @binding(8) var dfg: texture_2d<f32>;

fn shade(s: Surface) -> vec3f {
    if !s.is_front {
        return vec3f(0.0);
    }
    let count = arrayLength(&vertices);
    let y = basis(mirrored(s));
    var sum = vec3f(0.0);
    for (var i = 0u; i < COEFFICIENTS; i++) {
        let first = i * count;
        let at = s.weights.x * incident[first + s.corners.x].rgb + s.weights.y * incident[first + s.corners.y].rgb
            + s.weights.z * incident[first + s.corners.z].rgb;
        sum += y[i] * at;
    }
    var albedo = s.albedo.rgb;
    if gloss.x == 1.0 {
        let scale = dfg_lookup(dfg, max(dot(s.normal, s.view), 0.0), gloss.y);
        albedo = albedo * scale.x + scale.y;
    }
    return albedo * sum;
}
