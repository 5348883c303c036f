// uses: sunlit_vertices, transfer_texture
// Exit radiance of matte vertices by transfer in a texture, as `draw_transfer`, and suns beside it.

@vertex
fn vertex(
    @builtin(vertex_index) number: u32,
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) albedo: vec3f,
) -> Varying {
    return Varying(camera_clip(camera, position), sent_back(number), position, normal, albedo);
}
