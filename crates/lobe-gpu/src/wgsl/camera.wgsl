// The camera of `lobe_gpu::GpuCamera`: what it projects, and the rays through its pixels.

struct Camera {
    // Axes of the picture, and what it looks at, in the coordinates of the scene.
    right: vec4f,
    up: vec4f,
    towards_eye: vec4f,
    middle: vec4f,
    // Distance of the eye from what it looks at; tangent of half the angle of view; the nearest distance that is drawn.
    lens: vec4f,
    // Width and height of the picture in pixels.
    size: vec4f,
}

// Depth is reversed: 1 at the nearest distance, 0 infinitely far.
fn camera_clip(camera: Camera, p: vec3f) -> vec4f {
    let d = p - camera.middle.xyz;
    let along = vec3f(dot(d, camera.right.xyz), dot(d, camera.up.xyz), dot(d, camera.towards_eye.xyz));
    let scale = vec2f(camera.size.y / camera.size.x, 1.0) / camera.lens.y;
    return vec4f(along.xy * scale, camera.lens.z, camera.lens.x - along.z);
}

fn camera_eye(camera: Camera) -> vec3f {
    return camera.middle.xyz + camera.lens.x * camera.towards_eye.xyz;
}

// The direction of the ray through a point of the picture, in pixels from its top left corner.
fn camera_towards(camera: Camera, pixel: vec2f) -> vec3f {
    let half = 0.5 * camera.size.xy;
    let place = vec2f(pixel.x - half.x, half.y - pixel.y) / half.y;
    return normalize(camera.lens.y * (place.x * camera.right.xyz + place.y * camera.up.xyz) - camera.towards_eye.xyz);
}

// A triangle that covers the picture.
fn whole_picture(number: u32) -> vec4f {
    let corner = vec2f(f32((number << 1u) & 2u), f32(number & 2u));
    return vec4f(2.0 * corner - 1.0, 0.0, 1.0);
}
