// uses: basis
// How open a point is towards a lobe of directions, by transfer without reflections: the counterpart of
// `lobe_render`'s openness, of order 3. A program binds the factors of lobes as `lobe_factors`, at LOBE_LEVELS levels
// of roughness; the limits LEAST_ABOVE and LEAST_HIDDEN are those of `lobe_env::LobeFactors`.

// The nine coefficients of the transfer of visibility.
struct Visibility {
    first: vec4f,
    second: vec4f,
    last: f32,
}

struct Around {
    // The part of the lobe, and of the hemisphere, that leaves the scene.
    open: f32,
    ambient: f32,
    // The mean radiance of what hides the rest.
    others: vec3f,
}

// The factors of the bands of a lobe of this roughness.
fn lobe_factors_at(roughness: f32) -> vec3f {
    let place = clamp(roughness, 0.0, 1.0) * f32(LOBE_LEVELS - 1u);
    let low = min(u32(place), LOBE_LEVELS - 2u);
    return mix(lobe_factors[low].xyz, lobe_factors[low + 1u].xyz, place - f32(low));
}

// Of a surface of this normal and albedo for a lobe about an axis; `sent_back` is what it sends back of all others.
fn around_at(d: Visibility, axis: vec3f, n: vec3f, roughness: f32, albedo: vec3f, sent_back: vec3f) -> Around {
    let k = lobe_factors_at(roughness);
    let y = order_3_basis(axis);
    let first = dot(d.first.yzw, vec3f(y[1], y[2], y[3]));
    let second = dot(d.second, vec4f(y[4], y[5], y[6], y[7])) + d.last * y[8];
    let along = dot(k, vec3f(d.first.x * y[0], first, second));
    // sqrt(4 pi)
    let ambient = clamp(d.first.x * 3.5449077018110318, 0.0, 1.0);
    // The clamped cosine: bands of 1/4, 1/2, 5/16.
    let c = dot(n, axis);
    let above = dot(k, vec3f(0.25, 0.5 * c, 0.3125 * (1.5 * c * c - 0.5)));
    let part = clamp(along * 3.14159265358979 / max(above, LEAST_ABOVE), 0.0, 1.0);
    let open = select(ambient, part, above > LEAST_ABOVE);
    let others = max(sent_back / max(albedo, vec3f(1e-30)), vec3f(0.0)) / max(1.0 - ambient, LEAST_HIDDEN);
    return Around(open, ambient, select(vec3f(0.0), others, albedo > vec3f(0.0)));
}
