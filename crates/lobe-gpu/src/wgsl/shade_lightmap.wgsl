// uses: surface
// Exit radiance of the texels of a lightmap, as `lobe_prt::Lightmap::texels_at`: bilinear between the texels of one chart.

@group(0) @binding(6) var<storage, read> radiance: array<vec4f>;
// The chart of every texel and of every triangle.
@group(0) @binding(7) var<storage, read> charts: array<u32>;
@group(0) @binding(8) var<storage, read> charts_of_triangles: array<u32>;
// The width of the lightmap, and the first row that is bound.
@group(0) @binding(9) var<uniform> lightmap: vec4u;

fn shade(s: Surface) -> vec3f {
    if !s.is_front {
        return vec3f(0.0);
    }
    let width = lightmap.x;
    let last = f32(width - 1u);
    let w = s.weights;
    let place = w.x * paints[s.corners.x].lightmap.xy + w.y * paints[s.corners.y].lightmap.xy
        + w.z * paints[s.corners.z].lightmap.xy;
    let p = clamp(place * f32(width) - 0.5, vec2f(0.0), vec2f(last));
    let low = min(floor(p), vec2f(max(last - 1.0, 0.0)));
    let f = p - low;
    let first = (u32(low.y) - lightmap.y) * width + u32(low.x);
    let next = min(width - 1u, 1u);
    let around = vec4u(first, first + next, first + next * width, first + next * width + next);
    let parts = vec4f((1.0 - f.x) * (1.0 - f.y), f.x * (1.0 - f.y), (1.0 - f.x) * f.y, f.x * f.y);
    let chart = charts_of_triangles[s.triangle];
    var own = parts;
    for (var k = 0; k < 4; k++) {
        own[k] = select(0.0, parts[k], charts[around[k]] == chart);
    }
    let sum = own.x + own.y + own.z + own.w;
    let weights = select(parts, own / sum, sum > 0.0);
    var light = vec3f(0.0);
    for (var k = 0; k < 4; k++) {
        light += weights[k] * radiance[around[k]].rgb;
    }
    return light;
}
