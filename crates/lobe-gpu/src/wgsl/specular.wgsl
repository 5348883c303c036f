// uses: environment
// The split-sum approximation: a prefiltered environment times the directional albedo of `lobe_env::DfgTable`.

// Scale and bias at the cosine of the view and the roughness, bilinear in a table of size * size.
fn dfg_lookup(table: texture_2d<f32>, cos_v: f32, roughness: f32) -> vec2f {
    let size = f32(textureDimensions(table).x);
    let place = clamp(vec2f(cos_v, roughness) * size - 0.5, vec2f(0.0), vec2f(size - 1.0));
    let low = vec2i(place);
    let high = min(low + 1, vec2i(i32(size) - 1));
    let f = place - vec2f(low);
    let above = mix(textureLoad(table, low, 0).rg, textureLoad(table, vec2i(high.x, low.y), 0).rg, f.x);
    let below = mix(textureLoad(table, vec2i(low.x, high.y), 0).rg, textureLoad(table, high, 0).rg, f.x);
    return mix(above, below, f.y);
}

// The level of a prefiltered environment for a roughness, `lobe_env::RoughnessLevels::level_for_roughness`.
fn level_for_roughness(environment: Environment, roughness: f32) -> f32 {
    let r = clamp(roughness, 0.0, 1.0);
    return f32(environment.levels - 1u) * select(r, r * (2.0 - r), environment.quadratic == 1u);
}

// What a surface of GGX microfacets with reflectance f0 along its normal sends towards the eye.
fn split_sum(
    texels: texture_2d<f32>, environment: Environment, table: texture_2d<f32>, n: vec3f, v: vec3f, roughness: f32, f0: vec3f
) -> vec3f {
    let cos_v = dot(n, v);
    let reflected = normalize(2.0 * cos_v * n - v);
    let dfg = dfg_lookup(table, cos_v, roughness);
    let light = environment_radiance(texels, environment, reflected, level_for_roughness(environment, roughness));
    return light * (f0 * dfg.x + dfg.y);
}
