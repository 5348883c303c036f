// uses: camera
// Exit radiance of matte vertices, interpolated, by an index buffer: as `draw_vertices`, for devices whose shaders read no buffers.
// The transfer of a vertex is COEFFICIENTS texels side by side; what lights it is summed where the vertex is drawn.

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var transfer: texture_2d<f32>;
@group(0) @binding(2) var<uniform> light: array<vec4f, COEFFICIENTS>;
// The first vertex of the texture.
@group(0) @binding(3) var<uniform> piece: vec4u;

struct Varying {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(perspective, centroid) radiance: vec3f,
}

@vertex
fn vertex(@builtin(vertex_index) number: u32, @location(0) position: vec3f) -> Varying {
    let columns = textureDimensions(transfer).x / COEFFICIENTS;
    let own = number - piece.x;
    let first = vec2u(own % columns * COEFFICIENTS, own / columns);
    var radiance = vec3f(0.0);
    for (var i = 0u; i < COEFFICIENTS; i++) {
        radiance += light[i].rgb * textureLoad(transfer, first + vec2u(i, 0u), 0).rgb;
    }
    return Varying(camera_clip(camera, position), radiance);
}

@fragment
fn fragment(in: Varying, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    return shown(select(vec3f(0.0), in.radiance, is_front));
}
