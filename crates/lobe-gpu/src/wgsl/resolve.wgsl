// uses: camera
// Pixels as means over rays * rays samples each.

@group(0) @binding(0) var<uniform> rays: vec4u;
@group(0) @binding(1) var samples: texture_2d<f32>;

@vertex
fn vertex(@builtin(vertex_index) number: u32) -> @builtin(position) vec4f {
    return whole_picture(number);
}

@fragment
fn fragment(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let first = vec2u(position.xy) * rays.x;
    var sum = vec3f(0.0);
    for (var y = 0u; y < rays.x; y++) {
        for (var x = 0u; x < rays.x; x++) {
            sum += textureLoad(samples, first + vec2u(x, y), 0).rgb;
        }
    }
    return shown(sum / f32(rays.x * rays.x));
}
