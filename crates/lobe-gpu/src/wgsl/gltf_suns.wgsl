// uses: gltf, sun_light
// Suns on surfaces of the metallic-roughness model, `lobe_render::GltfSurfaces`:
//
//   B = sum_suns E_sun ((1 - F) (1 - metallic) c / pi + F D V)          alpha^2 = roughness^4 + sin^2(radius) / (4 v.h)

// D V of GGX with height-correlated masking; zero if the light is below the surface.
fn facets(n: vec3f, v: vec3f, l: vec3f, h: vec3f, width: f32) -> f32 {
    let cos_v = dot(n, v);
    let cos_l = dot(n, l);
    if cos_v <= 0.0 || cos_l <= 0.0 {
        return 0.0;
    }
    let across = cross(n, h);
    let cos_h = dot(n, h);
    let lobe = dot(across, across) + width * cos_h * cos_h;
    let root_v = sqrt(width + (1.0 - width) * cos_v * cos_v);
    let root_l = sqrt(width + (1.0 - width) * cos_l * cos_l);
    let masked = cos_l * root_v + cos_v * root_l;
    return width / (3.14159265358979 * lobe * lobe * 2.0 * masked);
}

// What is sent to the eye of a sun whose irradiance is 1.
fn gltf_sun(sun: Sun, n: vec3f, v: vec3f, albedo: vec3f, finish: Finish) -> vec3f {
    let matte = albedo * (1.0 - finish.metallic) / 3.14159265358979;
    if dot(n, v) <= 0.0 {
        return matte;
    }
    let l = sun.towards.xyz;
    let between = v + l;
    let h = between / max(length(between), 1e-20);
    let cos_h = clamp(dot(v, h), 0.0, 1.0);
    let f0 = along_normal(albedo, finish.metallic);
    let fresnel = f0 + (1.0 - f0) * pow(1.0 - cos_h, 5.0);
    let radius = sun.irradiance.w;
    let wider = 0.25 * radius * radius / max(max(cos_h, radius), 1e-9);
    let width = min(pow(finish.roughness, 4.0) + wider, 1.0);
    return (1.0 - fresnel) * matte + fresnel * facets(n, v, l, h, width);
}

fn gltf_suns(p: vec3f, plane: vec3f, n: vec3f, v: vec3f, albedo: vec3f, finish: Finish) -> vec3f {
    var sum = vec3f(0.0);
    for (var k = 0u; k < suns.count.x; k++) {
        let sun = suns.all[k];
        let facing = disc_cosine(dot(n, sun.towards.xyz), sun.irradiance.w);
        if facing > 0.0 {
            let irradiance = facing * sun_part(sun, p, plane) * sun.irradiance.rgb;
            sum += irradiance * gltf_sun(sun, n, v, albedo, finish);
        }
    }
    return sum;
}
