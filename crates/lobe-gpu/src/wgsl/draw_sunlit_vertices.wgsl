// uses: sunlit_vertices
// Exit radiance of vertices, interpolated, by an index buffer, as `draw_vertices`, and suns beside it.

@vertex
fn vertex(
    @location(0) position: vec3f,
    @location(1) radiance: vec3f,
    @location(2) normal: vec3f,
    @location(3) albedo: vec3f,
) -> Varying {
    return Varying(camera_clip(camera, position), radiance, position, normal, albedo);
}
