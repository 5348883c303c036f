// uses: camera, environment
// What is behind all surfaces: the environment as the eye sees it.

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var environment_texels: texture_2d<f32>;
@group(0) @binding(2) var<uniform> environment: Environment;

@vertex
fn vertex(@builtin(vertex_index) number: u32) -> @builtin(position) vec4f {
    return whole_picture(number);
}

@fragment
fn fragment(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let towards = camera_towards(camera, position.xy);
    return shown(environment_radiance(environment_texels, environment, towards, 0.0));
}
