// uses: specular, openness
// The metallic-roughness model of glTF 2.0, `lobe_render::GltfSurfaces`:
//
//   B = o (1 - F0) (1 - metallic) B_matte + (F0 scale + bias) (o O P(a, roughness) + (1 - O) B_others) + emission
//
// A program binds the prefiltered light as `reflected_texels` and `reflected`, the table of lobes as `lobes`.

// The reflectance along the normal of what is no metal.
const DIELECTRIC = 0.04;

// What a material says of a point besides a color.
struct Finish {
    metallic: f32,
    roughness: f32,
    occlusion: f32,
    emission: vec3f,
}

// A point that is seen, and what is known of its light.
struct Shiny {
    // To shade with, on the side that is seen, and towards the eye.
    n: vec3f,
    v: vec3f,
    albedo: vec3f,
    finish: Finish,
    // What a matte surface sends to the eye, and what it sends back of other surfaces.
    matte: vec3f,
    sent_back: vec3f,
    visibility: Visibility,
    // Whether what is around is known.
    is_known: bool,
}

fn along_normal(albedo: vec3f, metallic: f32) -> vec3f {
    return DIELECTRIC + (albedo - DIELECTRIC) * metallic;
}

// All but suns.
fn gltf_radiance(s: Shiny) -> vec3f {
    let finish = s.finish;
    let cos_v = dot(s.n, s.v);
    let lobe = lobe_lookup(lobes, cos_v, finish.roughness);
    var axis = s.n;
    if cos_v > 0.0 {
        axis = lobe_axis(lobe, normalize(2.0 * cos_v * s.n - s.v), s.n);
    }
    var around = Around(1.0, 1.0, vec3f(0.0));
    // A black surface sends nothing back that tells of others.
    let albedo = select(s.albedo, vec3f(1.0), WITHOUT_ALBEDO == 1u);
    if s.is_known && any(albedo > vec3f(0.0)) {
        around = around_at(s.visibility, axis, s.n, finish.roughness, albedo, s.sent_back);
    }
    // Hidden by what triangles do not show alone.
    let occlusion = min(finish.occlusion / max(around.ambient, 1e-30), 1.0);
    let matte = occlusion * (1.0 - finish.metallic) * s.matte;
    if cos_v <= 0.0 {
        return matte + finish.emission;
    }
    let f0 = along_normal(s.albedo, finish.metallic);
    let level = level_for_roughness(reflected, finish.roughness);
    let light = environment_radiance(reflected_texels, reflected, axis, level);
    let seen = occlusion * around.open * light + (1.0 - around.open) * around.others;
    return (1.0 - f0) * matte + (f0 * lobe.dfg.x + lobe.dfg.y) * seen + finish.emission;
}
