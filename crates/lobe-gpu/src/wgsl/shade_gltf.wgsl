// uses: surface, finish, gltf
// Surfaces of the metallic-roughness model: the exit radiance of vertices for what is matte, and around each vertex
// what hides reflections.

@group(0) @binding(6) var<storage, read> radiance: array<vec4f>;
// What vertices send back of other surfaces, and their transfer of visibility, three for each.
@group(0) @binding(7) var<storage, read> others: array<vec4f>;
@group(0) @binding(8) var<storage, read> visibility: array<vec4f>;
@group(0) @binding(9) var reflected_texels: texture_2d<f32>;
@group(0) @binding(10) var<uniform> reflected: Environment;
@group(0) @binding(11) var lobes: texture_2d<f32>;
@group(0) @binding(12) var finishes: texture_2d<f32>;
@group(0) @binding(13) var<uniform> lobe_factors: array<vec4f, LOBE_LEVELS>;

fn visibility_at(s: Surface, k: u32) -> vec4f {
    let at = 3u * s.corners + k;
    return s.weights.x * visibility[at.x] + s.weights.y * visibility[at.y] + s.weights.z * visibility[at.z];
}

fn shiny(s: Surface) -> Shiny {
    let w = s.weights;
    let around = Visibility(vec4f(0.0), vec4f(0.0), 0.0);
    var point = Shiny(s.normal, s.view, s.albedo.rgb, finish_of(s), vec3f(0.0), vec3f(0.0), around, false);
    // From behind no transfer is known.
    if !s.is_front {
        return point;
    }
    let light = w.x * radiance[s.corners.x].rgb + w.y * radiance[s.corners.y].rgb + w.z * radiance[s.corners.z].rgb;
    point.matte = select(light, s.albedo.rgb * light, WITHOUT_ALBEDO == 1u);
    if HAS_VISIBILITY == 1u {
        point.visibility = Visibility(visibility_at(s, 0u), visibility_at(s, 1u), visibility_at(s, 2u).x);
        point.is_known = true;
    }
    if HAS_OTHERS == 1u {
        point.sent_back = w.x * others[s.corners.x].rgb + w.y * others[s.corners.y].rgb + w.z * others[s.corners.z].rgb;
    }
    return point;
}

fn shade(s: Surface) -> vec3f {
    return gltf_radiance(shiny(s));
}
