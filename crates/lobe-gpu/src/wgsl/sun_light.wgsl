// uses: sun_shadow
// Irradiance by the suns of a light, `lobe_render::SunRays`: E = sum_suns E_sun max(n.s, 0) V. What a program binds
// as `suns`, and what V is, `sun_part`, stands beside this.

struct Suns {
    // How many there are.
    count: vec4u,
    all: array<Sun, 4>,
}

// The cosine of the middle of a disc, and between the horizon and that, smoothly, what of it is above the horizon.
fn disc_cosine(cosine: f32, sine: f32) -> f32 {
    let low = cosine + sine;
    return select(select(0.0, 0.25 * low * low / max(sine, 1e-9), low > 0.0), cosine, cosine >= sine);
}

fn suns_irradiance(p: vec3f, plane: vec3f, normal: vec3f) -> vec3f {
    var sum = vec3f(0.0);
    for (var k = 0u; k < suns.count.x; k++) {
        let sun = suns.all[k];
        let facing = disc_cosine(dot(normal, sun.towards.xyz), sun.irradiance.w);
        if facing > 0.0 {
            sum += facing * sun_part(sun, p, plane) * sun.irradiance.rgb;
        }
    }
    return sum;
}
