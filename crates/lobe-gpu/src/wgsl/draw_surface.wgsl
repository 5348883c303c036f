// The fragment of a surface: what `shade` says, black from behind, nothing in holes.

@fragment
fn fragment(in: Varying) -> @location(0) vec4f {
    let s = surface_at(in);
    if !s.is_there {
        discard;
    }
    if !s.is_lit {
        return shown(vec3f(0.0));
    }
    return shown(shade(s));
}
