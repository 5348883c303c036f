// uses: surface
// Irradiance without shadows, `lobe_render::light_by_irradiance`: B = albedo / pi * E(n).

@group(0) @binding(6) var<uniform> irradiance: array<vec4f, COEFFICIENTS>;

fn shade(s: Surface) -> vec3f {
    var y = basis(s.normal);
    var sum = vec3f(0.0);
    for (var i = 0u; i < COEFFICIENTS; i++) {
        sum += y[i] * irradiance[i].rgb;
    }
    return s.albedo.rgb * sum / 3.14159265358979;
}
