// The table of `lobe_env::DfgTable`.

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
