// Tone mapping, `lobe_image::Tone`: exposure, curve, sRGB. Figures of the curves are those of `lobe_image::Curve`.

const REC_709_LUMINANCE: vec3f = vec3f(0.2126, 0.7152, 0.0722);

// `tone` is the exposure, the number of the curve, 0 to clip, and for Reinhard's the reciprocal square of the least
// luminance that is shown white. Test `pictures_by_transfer_are_those_of_the_processor` compares all curves.
fn tone_curve(tone: vec4f, exposed: vec3f) -> vec3f {
    // Infinite light would be no number further on.
    let light = clamp(exposed, vec3f(0.0), vec3f(1e15));
    var c = exposed;
    switch u32(tone.y) {
        case 1u: {
            let y = max(dot(c, REC_709_LUMINANCE), 0.0);
            // The limit of the factor, where infinite light would be no number.
            c *= select((1.0 + y * tone.z) / (1.0 + y), tone.z, y > 1e30);
        }
        case 2u: { c = tone_aces(light); }
        case 3u: { c = tone_agx(min(exposed, vec3f(1e15))); }
        case 4u: { c = tone_neutral(light); }
        default: {}
    }
    return clamp(c, vec3f(0.0), vec3f(1.0));
}

// Columns of the matrices of Hill's fit.
fn tone_aces(light: vec3f) -> vec3f {
    let to_film = mat3x3f(0.59719, 0.07600, 0.02840, 0.35458, 0.90834, 0.13383, 0.04823, 0.01566, 0.83777);
    let from_film = mat3x3f(1.60475, -0.10208, -0.00327, -0.53108, 1.10813, -0.07276, -0.07367, -0.00605, 1.07602);
    let v = to_film * (light / 0.6);
    return from_film * ((v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.4329510) + 0.238081));
}

fn tone_agx(light: vec3f) -> vec3f {
    let from_rec_2020 = mat3x3f(1.6605, -0.1246, -0.0182, -0.5876, 1.1329, -0.1006, -0.0728, -0.0083, 1.1187);
    let to_rec_2020 = mat3x3f(
        0.627409440462, 0.0691248390442, 0.0164233580265, 0.329260252194, 0.919548613786,
        0.0880478476239, 0.0432718935897, 0.0113207667622, 0.895616713685
    );
    let inset = mat3x3f(
        0.856627153315983, 0.137318972929847, 0.11189821299995, 0.0951212405381588, 0.761241990602591,
        0.0767994186031903, 0.0482516061458583, 0.101439036467562, 0.811302368396859
    );
    let outset = mat3x3f(
        1.12710058181, -0.141329763498, -0.141329763498, -0.110606643097, 1.15782370222,
        -0.110606643097, -0.0164939387178, -0.0164939387178, 1.2519364066
    );
    let stops = log2(max(inset * max(to_rec_2020 * light, vec3f(0.0)), vec3f(1e-10)));
    let x = clamp((stops + 12.47393) / (4.026069 + 12.47393), vec3f(0.0), vec3f(1.0));
    let contrast = (((((15.5 * x - 40.14) * x + 31.96) * x - 6.868) * x + 0.4298) * x + 0.1191) * x - 0.00232;
    return from_rec_2020 * pow(max(outset * contrast, vec3f(0.0)), vec3f(2.2));
}

fn tone_neutral(light: vec3f) -> vec3f {
    let least = min(light.x, min(light.y, light.z));
    let base = light - select(0.04, least - 6.25 * least * least, least < 0.08);
    let peak = max(base.x, max(base.y, base.z));
    let start = 0.8 - 0.04;
    let compressed = 1.0 - (1.0 - start) * (1.0 - start) / (max(peak, start) + 1.0 - 2.0 * start);
    let part = 1.0 - 1.0 / (0.15 * (peak - compressed) + 1.0);
    return select(mix(base * (compressed / peak), vec3f(compressed), part), base, peak < start);
}

fn srgb_encode(c: vec3f) -> vec3f {
    return select(1.055 * pow(c, vec3f(1.0 / 2.4)) - 0.055, 12.92 * c, c <= vec3f(0.0031308));
}

fn displayed(tone: vec4f, light: vec3f) -> vec3f {
    return srgb_encode(tone_curve(tone, tone.x * light));
}
