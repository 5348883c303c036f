// uses: surface
// Exit radiance of vertices whose transfer leaves out the albedo, interpolated, times the base color of the pixel, so that textures
// keep their detail; black from behind, where no transfer is known.

@group(0) @binding(6) var<storage, read> radiance: array<vec4f>;

fn shade(s: Surface) -> vec3f {
    if !s.is_front {
        return vec3f(0.0);
    }
    let w = s.weights;
    let light = w.x * radiance[s.corners.x].rgb + w.y * radiance[s.corners.y].rgb + w.z * radiance[s.corners.z].rgb;
    return s.albedo.rgb * light;
}
