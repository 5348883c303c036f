// Irradiance of order 3 from seven vectors, `lobe_sh::PackedIrradiance`: Sloan 2008, A10.

struct PackedIrradiance {
    ar: vec4f,
    ag: vec4f,
    ab: vec4f,
    br: vec4f,
    bg: vec4f,
    bb: vec4f,
    c: vec4f,
}

fn packed_irradiance(p: PackedIrradiance, n: vec3f) -> vec3f {
    let linear = vec4f(n, 1.0);
    let quadratic = n.xyzz * n.yzzx;
    let first = vec3f(dot(p.ar, linear), dot(p.ag, linear), dot(p.ab, linear));
    let second = vec3f(dot(p.br, quadratic), dot(p.bg, quadratic), dot(p.bb, quadratic));
    return first + second + p.c.rgb * (n.x * n.x - n.y * n.y);
}
