// uses: surface, gltf
// What the material of a surface says besides a color, `lobe_scene::Scene::finish`: its numbers, times its textures. A
// program binds the finishes of materials as `finishes`: FINISH texels for each, so many in a row as fit.

// Of a texture: its first texel in steps of TEXTURE_STEP, width, height, ways to continue; then the rows of its map,
// each with the set of coordinates.
struct FinishTexture {
    picture: vec4f,
    u: vec4f,
    v: vec4f,
}

fn finish_number(mesh: u32, k: u32) -> vec4f {
    let columns = textureDimensions(finishes).x / FINISH;
    return textureLoad(finishes, vec2u(mesh % columns * FINISH + k, mesh / columns), 0);
}

fn finish_texture(mesh: u32, number: u32) -> FinishTexture {
    let first = 2u + 3u * number;
    return FinishTexture(finish_number(mesh, first), finish_number(mesh, first + 1u), finish_number(mesh, first + 2u));
}

// A texture between texels; 1 without one.
fn finish_texel(used: FinishTexture, uvs: vec4f, is_stored: bool) -> vec4f {
    if used.picture.y == 0.0 {
        return vec4f(1.0);
    }
    let uv = vec3f(select(uvs.xy, uvs.zw, used.u.w == 1.0), 1.0);
    let p = vec4u(used.picture);
    let picture = vec4u(p.x * TEXTURE_STEP, p.yzw);
    return picture_between(picture, vec2f(dot(used.u.xyz, uv), dot(used.v.xyz, uv)), is_stored);
}

fn finish_of(s: Surface) -> Finish {
    let mesh = corners[s.triangle].w;
    let numbers = finish_number(mesh, 0u);
    let a = paints[s.corners.x];
    let b = paints[s.corners.y];
    let c = paints[s.corners.z];
    let w = s.weights;
    let first = w.x * a.place.zw + w.y * b.place.zw + w.z * c.place.zw;
    let second = w.x * a.lightmap.zw + w.y * b.lightmap.zw + w.z * c.lightmap.zw;
    let uvs = vec4f(first, second);
    return Finish(
        numbers.x * finish_texel(finish_texture(mesh, 0u), uvs, true).b,
        numbers.y * finish_texel(finish_texture(mesh, 1u), uvs, true).g,
        1.0 + numbers.z * (finish_texel(finish_texture(mesh, 2u), uvs, true).r - 1.0),
        finish_number(mesh, 1u).rgb * finish_texel(finish_texture(mesh, 3u), uvs, false).rgb
    );
}
