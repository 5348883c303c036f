// uses: camera
// Tone mapping, `lobe_image::Tone`: exposure, curve, sRGB.

// Exposure; 1 for Reinhard's curve, 0 to clip; the reciprocal square of the least luminance shown white.
@group(0) @binding(0) var<uniform> tone: vec4f;
@group(0) @binding(1) var light: texture_2d<f32>;

fn tone_curve(exposed: vec3f) -> vec3f {
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

@vertex
fn vertex(@builtin(vertex_index) number: u32) -> @builtin(position) vec4f {
    return whole_picture(number);
}

@fragment
fn fragment(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let radiance = textureLoad(light, vec2u(position.xy), 0).rgb;
    return vec4f(srgb_encode(tone_curve(tone.x * radiance)), 1.0);
}
