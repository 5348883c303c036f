// uses: sun_shadow
// What a sun sees, from far away, by an index buffer: its heights for `sun_visible`. Both sides of surfaces cast
// shadows.

@group(0) @binding(0) var<uniform> sun: Sun;

@vertex
fn vertex(@location(0) position: vec3f) -> @builtin(position) vec4f {
    return sun_clip(sun, position);
}

@fragment
fn fragment(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return stored_depth(position.z);
}
