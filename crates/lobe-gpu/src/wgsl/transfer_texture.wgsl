// Transfer of matte vertices in a texture: that of a vertex is COEFFICIENTS texels side by side.

@group(0) @binding(1) var transfer: texture_2d<f32>;
@group(0) @binding(2) var<uniform> light: array<vec4f, COEFFICIENTS>;
// The first vertex of the texture.
@group(0) @binding(3) var<uniform> piece: vec4u;

// Coefficient i of a vertex.
fn transferred(number: u32, i: u32) -> vec3f {
    let columns = textureDimensions(transfer).x / COEFFICIENTS;
    let own = number - piece.x;
    return textureLoad(transfer, vec2u(own % columns * COEFFICIENTS + i, own / columns), 0).rgb;
}

fn sent_back(number: u32) -> vec3f {
    var radiance = vec3f(0.0);
    for (var i = 0u; i < COEFFICIENTS; i++) {
        radiance += light[i].rgb * transferred(number, i);
    }
    return radiance;
}
