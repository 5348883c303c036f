// The lobes of GGX by the angle of view and the roughness, `lobe_env::LobeTable`.

// Up to this roughness a surface is a mirror, whose reflectance has a formula.
const MIRROR = 0.01;

struct Lobe {
    // Of even light: the factor of the reflectance along the normal, and the summand.
    dfg: vec2f,
    lean: f32,
}

// Bilinear between nodes at the root of the cosine and at the roughness.
fn lobe_lookup(table: texture_2d<f32>, cos_v: f32, roughness: f32) -> Lobe {
    let last = i32(textureDimensions(table).x) - 1;
    let place = clamp(vec2f(sqrt(max(cos_v, 0.0)), roughness), vec2f(0.0), vec2f(1.0)) * f32(last);
    let low = min(vec2i(place), vec2i(last - 1));
    let f = place - vec2f(low);
    let above = mix(textureLoad(table, low, 0), textureLoad(table, low + vec2i(1, 0), 0), f.x);
    let below = mix(textureLoad(table, low + vec2i(0, 1), 0), textureLoad(table, low + 1, 0), f.x);
    let node = mix(above, below, f.y);
    let grazing = pow(1.0 - clamp(cos_v, 0.0, 1.0), 5.0);
    return Lobe(select(node.xy, vec2f(1.0 - grazing, grazing), roughness <= MIRROR), node.z);
}

// The mean direction of a lobe whose mirrored direction is r.
fn lobe_axis(lobe: Lobe, r: vec3f, n: vec3f) -> vec3f {
    let along = lobe.lean * (r - dot(n, r) * n);
    return normalize(along + sqrt(max(1.0 - dot(along, along), 0.0)) * n);
}
