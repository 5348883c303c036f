// uses: camera
// What a display shows of a picture of light, texel by texel; `shown` maps its tones.

@group(0) @binding(0) var light: texture_2d<f32>;

@vertex
fn vertex(@builtin(vertex_index) number: u32) -> @builtin(position) vec4f {
    return whole_picture(number);
}

@fragment
fn fragment(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return shown(textureLoad(light, vec2u(position.xy), 0).rgb);
}
