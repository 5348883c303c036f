// uses: camera
// Exit radiance of vertices, interpolated, by an index buffer: as `shade_vertices`, where no surface has holes, at a fraction of the
// work. Black from behind, where no transfer is known.

struct Vertex {
    position: vec4f,
    normal: vec4f,
}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<storage, read> vertices: array<Vertex>;
@group(0) @binding(2) var<storage, read> radiance: array<vec4f>;

struct Varying {
    @builtin(position) position: vec4f,
    @location(0) radiance: vec3f,
}

@vertex
fn vertex(@builtin(vertex_index) number: u32) -> Varying {
    return Varying(camera_clip(camera, vertices[number].position.xyz), radiance[number].rgb);
}

@fragment
fn fragment(in: Varying, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    return vec4f(select(vec3f(0.0), in.radiance, is_front), 1.0);
}
