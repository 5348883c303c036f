// The surface that a pixel shows: what `lit` says, black from behind, nothing in holes.

@vertex
fn vertex(@builtin(vertex_index) number: u32) -> Varying {
    let triangle = number / 3u;
    let corner = number % 3u;
    let p = vertices[corners[triangle][corner]].position.xyz;
    var weights = vec3f(0.0);
    weights[corner] = 1.0;
    return Varying(camera_clip(camera, p), weights, triangle);
}

@fragment
fn fragment(in: Varying) -> @location(0) vec4f {
    let s = surface_at(in);
    if !s.is_there {
        discard;
    }
    if !s.is_lit {
        return shown(vec3f(0.0));
    }
    return shown(lit(s));
}
