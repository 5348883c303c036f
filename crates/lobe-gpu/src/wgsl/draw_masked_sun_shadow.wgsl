// uses: surface, sun_shadow
// What a sun sees, as `draw_sun_shadow`, through the holes of surfaces.

@group(0) @binding(0) var<uniform> sun: Sun;

struct Shadow {
    @builtin(position) position: vec4f,
    @location(0) weights: vec3f,
    @location(1) @interpolate(flat) triangle: u32,
}

@vertex
fn vertex(@builtin(vertex_index) number: u32) -> Shadow {
    let triangle = number / 3u;
    let corner = number % 3u;
    var weights = vec3f(0.0);
    weights[corner] = 1.0;
    return Shadow(sun_clip(sun, vertices[corners[triangle][corner]].position.xyz), weights, triangle);
}

@fragment
fn fragment(in: Shadow) -> @location(0) vec4f {
    let triangle = corners[in.triangle];
    let material = materials[triangle.w];
    if material.flags.z == 1u && color_at(material, triangle.xyz, in.weights).a < material.numbers.x {
        discard;
    }
    return stored_depth(in.position.z);
}
