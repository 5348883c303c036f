// uses: sunlit_surface
// What a matte surface sends back of the suns of a light: albedo / pi * E.

fn sunlight(s: Surface) -> vec3f {
    let at = sunlit_place(s);
    return s.albedo.rgb * suns_irradiance(at.p, at.plane, s.normal) / 3.14159265358979;
}
