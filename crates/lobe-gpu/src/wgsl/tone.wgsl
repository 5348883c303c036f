// Tone mapping, `lobe_image::Tone`: exposure, curve, sRGB.

// Of a tone: the exposure; 1 for Reinhard's curve, 0 to clip; the reciprocal square of the least luminance shown white.
fn tone_curve(tone: vec4f, exposed: vec3f) -> vec3f {
    var c = exposed;
    if tone.y == 1.0 {
        let y = max(dot(c, vec3f(0.2126, 0.7152, 0.0722)), 0.0);
        // The limit of the factor, where infinite light would be no number.
        c *= select((1.0 + y * tone.z) / (1.0 + y), tone.z, y > 1e30);
    }
    return clamp(c, vec3f(0.0), vec3f(1.0));
}

fn srgb_encode(c: vec3f) -> vec3f {
    return select(1.055 * pow(c, vec3f(1.0 / 2.4)) - 0.055, 12.92 * c, c <= vec3f(0.0031308));
}

fn displayed(tone: vec4f, light: vec3f) -> vec3f {
    return srgb_encode(tone_curve(tone, tone.x * light));
}
