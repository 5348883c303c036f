// uses: surface, dfg
// Glossy surfaces: the blurred incident light of vertices, interpolated, in the mirrored direction, times the directional
// albedo: the base color, or for microfacets that of the split sum at their roughness.

struct Gloss {
    is_microfacets: u32,
    // The first of the vertices whose incident light is known.
    first: u32,
    roughness: f32,
    unused: u32,
}

@group(0) @binding(6) var<storage, read> incident: array<vec4f>;
@group(0) @binding(7) var<uniform> gloss: Gloss;
@group(0) @binding(8) var dfg: texture_2d<f32>;

fn shade(s: Surface) -> vec3f {
    if !s.is_front {
        return vec3f(0.0);
    }
    let known = (s.corners - gloss.first) * COEFFICIENTS;
    var y = basis(mirrored(s));
    var sum = vec3f(0.0);
    for (var i = 0u; i < COEFFICIENTS; i++) {
        let at = known + i;
        let light = s.weights.x * incident[at.x].rgb + s.weights.y * incident[at.y].rgb + s.weights.z * incident[at.z].rgb;
        sum += y[i] * light;
    }
    var albedo = s.albedo.rgb;
    if gloss.is_microfacets == 1u {
        let scale = dfg_lookup(dfg, max(dot(s.normal, s.view), 0.0), gloss.roughness);
        albedo = albedo * scale.x + scale.y;
    }
    return albedo * sum;
}
