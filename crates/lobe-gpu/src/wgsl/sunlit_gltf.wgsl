// uses: sunlit_surface, finish, gltf_suns
// What a surface of the metallic-roughness model sends to the eye of the suns of a light.

fn sunlight(s: Surface) -> vec3f {
    let at = sunlit_place(s);
    return gltf_suns(at.p, at.plane, s.normal, s.view, s.albedo.rgb, finish_of(s));
}
