// uses: environment, lobe_table
// The split-sum approximation: a prefiltered environment about the mean of the lobe, times its reflectance in even
// light, `lobe_env::LobeTable`.

// The level of a prefiltered environment for a roughness, `lobe_env::RoughnessLevels::level_for_roughness`.
fn level_for_roughness(environment: Environment, roughness: f32) -> f32 {
    let r = clamp(roughness, 0.0, 1.0);
    return f32(LEVELS - 1u) * select(r, r * (2.0 - r), environment.quadratic == 1u);
}

// What a surface of GGX microfacets with reflectance f0 along its normal sends towards the eye.
fn split_sum(
    texels: texture_2d<f32>, environment: Environment, table: texture_2d<f32>, n: vec3f, v: vec3f, roughness: f32, f0: vec3f
) -> vec3f {
    let cos_v = dot(n, v);
    let lobe = lobe_lookup(table, cos_v, roughness);
    let axis = lobe_axis(lobe, normalize(2.0 * cos_v * n - v), n);
    let light = environment_radiance(texels, environment, axis, level_for_roughness(environment, roughness));
    return light * (f0 * lobe.dfg.x + lobe.dfg.y);
}
