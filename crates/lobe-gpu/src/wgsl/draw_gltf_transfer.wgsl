// uses: camera, facing, transfer_texture, gltf
// Surfaces of the metallic-roughness model by transfer in a texture, as `shade_gltf`, for devices whose shaders read no
// buffers. Finish and color are those of vertices, and what lights a vertex is summed where it is drawn. `sunlight` of
// suns stands beside this.

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(4) var<uniform> light_of_others: array<vec4f, COEFFICIENTS>;
@group(0) @binding(5) var reflected_texels: texture_2d<f32>;
@group(0) @binding(6) var<uniform> reflected: Environment;
@group(0) @binding(7) var lobes: texture_2d<f32>;
@group(0) @binding(8) var<uniform> lobe_factors: array<vec4f, LOBE_LEVELS>;

struct Varying {
    @builtin(position) position: vec4f,
    @location(0) at: vec3f,
    @location(1) @interpolate(perspective, centroid) normal: vec3f,
    @location(2) @interpolate(perspective, centroid) albedo: vec3f,
    // Metallic, roughness, occlusion, and the last number of the visibility.
    @location(3) @interpolate(perspective, centroid) finish: vec4f,
    @location(4) @interpolate(perspective, centroid) emission: vec3f,
    @location(5) @interpolate(perspective, centroid) radiance: vec3f,
    @location(6) @interpolate(perspective, centroid) others: vec3f,
    @location(7) @interpolate(perspective, centroid) first: vec4f,
    @location(8) @interpolate(perspective, centroid) second: vec4f,
}

fn sent_back_of_others(number: u32) -> vec3f {
    var sum = vec3f(0.0);
    if HAS_OTHERS == 1u {
        for (var i = 0u; i < COEFFICIENTS; i++) {
            sum += light_of_others[i].rgb * transferred(number, i);
        }
    }
    return sum;
}

// Coefficient i of the transfer of visibility: that without reflections, from coefficient DIRECT on, over the albedo in
// the channel that is known best; open where all are black.
fn visible(number: u32, i: u32, albedo: vec3f) -> f32 {
    if HAS_VISIBILITY == 0u || i >= KNOWN {
        return 0.0;
    }
    let all = transferred(number, DIRECT + i);
    if WITHOUT_ALBEDO == 1u {
        return all.r;
    }
    let best = max(albedo.r, max(albedo.g, albedo.b));
    if best <= 0.0 {
        // 1/sqrt(4 pi)
        return select(0.0, 0.28209479177387814, i == 0u);
    }
    return select(select(all.b, all.g, albedo.g >= best), all.r, albedo.r >= best) / best;
}

fn four_visible(number: u32, i: u32, albedo: vec3f) -> vec4f {
    return vec4f(
        visible(number, i, albedo),
        visible(number, i + 1u, albedo),
        visible(number, i + 2u, albedo),
        visible(number, i + 3u, albedo)
    );
}

@vertex
fn vertex(
    @builtin(vertex_index) number: u32,
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) albedo: vec3f,
    @location(3) finish: vec3f,
    @location(4) emission: vec3f,
) -> Varying {
    return Varying(
        camera_clip(camera, position),
        position,
        normal,
        albedo,
        vec4f(finish, visible(number, 8u, albedo)),
        emission,
        sent_back(number),
        sent_back_of_others(number),
        four_visible(number, 0u, albedo),
        four_visible(number, 4u, albedo)
    );
}

@fragment
fn fragment(in: Varying, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    // Derivatives are those of all fragments.
    let facing = facing_of(in.at, in.normal, is_front);
    if !is_front && DOUBLE_SIDED == 0u {
        return shown(vec3f(0.0));
    }
    let finish = Finish(in.finish.x, in.finish.y, in.finish.z, in.emission);
    let matte = select(in.radiance, in.albedo * in.radiance, WITHOUT_ALBEDO == 1u);
    let point = Shiny(
        facing.normal,
        -camera_towards(camera, in.position.xy),
        in.albedo,
        finish,
        // From behind no transfer is known.
        select(vec3f(0.0), matte, is_front),
        in.others,
        Visibility(in.first, in.second, in.finish.w),
        is_front && HAS_VISIBILITY == 1u
    );
    return shown(gltf_radiance(point) + sunlight(in.at, facing.plane, point));
}
