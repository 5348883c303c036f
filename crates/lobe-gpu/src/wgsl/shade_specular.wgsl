// uses: surface, specular
// Microfacets by the split sum: a prefiltered environment about the mean of the lobe, with the base color as reflectance
// along the normal.

@group(0) @binding(6) var environment_texels: texture_2d<f32>;
@group(0) @binding(7) var<uniform> environment: Environment;
@group(0) @binding(8) var<uniform> gloss: vec4f;
@group(0) @binding(9) var lobes: texture_2d<f32>;

fn shade(s: Surface) -> vec3f {
    return split_sum(environment_texels, environment, lobes, s.normal, s.view, gloss.y, s.albedo.rgb);
}
