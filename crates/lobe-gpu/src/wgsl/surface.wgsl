// uses: camera
// The surface that a pixel shows, as `lobe_scene::Scene::surface`: triangles without an index buffer, so that a fragment knows
// its triangle and the weights of its corners.

struct Vertex {
    position: vec4f,
    normal: vec4f,
}

// Color; the place in the texture of that, and in a lightmap, each with a set of coordinates as they are.
struct Paint {
    color: vec4f,
    place: vec4f,
    lightmap: vec4f,
}

struct Material {
    base_color: vec4f,
    // First word, width, height; ways to continue along u and v: 0 repeat, 1 mirror, 2 clamp, 3 * v + u.
    picture: vec4u,
    // 1 with a texture; 1 if double-sided; 1 if alpha is a mask.
    flags: vec4u,
    // The cutoff of the mask.
    numbers: vec4f,
}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var<storage, read> vertices: array<Vertex>;
// Three vertices and the material.
@group(0) @binding(2) var<storage, read> corners: array<vec4u>;
@group(0) @binding(3) var<storage, read> paints: array<Paint>;
@group(0) @binding(4) var<storage, read> materials: array<Material>;
@group(0) @binding(5) var<storage, read> texels: array<u32>;

struct Varying {
    @builtin(position) position: vec4f,
    @location(0) weights: vec3f,
    @location(1) @interpolate(flat) triangle: u32,
}

// The square of the sine between a triangle and a ray under which its plane is met with less than four of seven digits.
const EDGE_ON = 1e-6;

// The weights of the corners where a ray meets the plane of a triangle (Moeller and Trumbore 1997). Devices interpolate weights to some
// 17 bits and from corners that they snap to a grid, which shows where a texture varies from pixel to pixel. Rounding moves what is
// computed by some 2^-24 of the distance, `2^-24 h / (2 tan a)` pixels in a picture of h rows and half the angle of view a, whatever the
// size of the triangle: below a ten-thousandth of a pixel at a thousand rows.
fn weights_along(origin: vec3f, towards: vec3f, a: Vertex, b: Vertex, c: Vertex, interpolated: vec3f) -> vec3f {
    let ab = b.position.xyz - a.position.xyz;
    let ac = c.position.xyz - a.position.xyz;
    let across = cross(ab, ac);
    let to_plane = dot(across, towards);
    let at = origin - a.position.xyz;
    let turned = cross(at, towards);
    let met = vec2f(dot(ac, turned), -dot(ab, turned)) / -to_plane;
    let is_edge_on = to_plane * to_plane <= EDGE_ON * dot(across, across);
    // Beyond the edges, where they are snapped, as at them.
    let found = max(select(vec3f(1.0 - met.x - met.y, met), interpolated, is_edge_on), vec3f(0.0));
    return found / (found.x + found.y + found.z);
}

struct Surface {
    triangle: u32,
    corners: vec3u,
    weights: vec3f,
    // Towards the eye.
    view: vec3f,
    // To shade with, on the side that is seen.
    normal: vec3f,
    albedo: vec4f,
    is_front: bool,
    is_lit: bool,
    is_there: bool,
}

fn surface_at(in: Varying) -> Surface {
    let triangle = corners[in.triangle];
    let a = vertices[triangle.x];
    let b = vertices[triangle.y];
    let c = vertices[triangle.z];
    let towards = camera_towards(camera, in.position.xy);
    let weights = weights_along(camera_eye(camera), towards, a, b, c, in.weights);
    let geometric = normalize(cross(b.position.xyz - a.position.xyz, c.position.xyz - a.position.xyz));
    let blended = weights.x * a.normal.xyz + weights.y * b.normal.xyz + weights.z * c.normal.xyz;
    let length_of = length(blended);
    let shading = select(geometric, blended / length_of, length_of > 0.0);
    let is_front = dot(towards, geometric) < 0.0;
    let material = materials[triangle.w];
    let color = color_at(material, triangle.xyz, weights);
    return Surface(
        in.triangle,
        triangle.xyz,
        weights,
        -towards,
        select(-shading, shading, is_front),
        color,
        is_front,
        is_front || material.flags.y == 1u,
        material.flags.z == 0u || color.a >= material.numbers.x
    );
}

// The direction from which a mirror would show the eye its light.
fn mirrored(s: Surface) -> vec3f {
    return normalize(2.0 * dot(s.normal, s.view) * s.normal - s.view);
}

fn color_at(material: Material, corner: vec3u, weights: vec3f) -> vec4f {
    let a = paints[corner.x];
    let b = paints[corner.y];
    let c = paints[corner.z];
    var color = material.base_color * (weights.x * a.color + weights.y * b.color + weights.z * c.color);
    if material.flags.x > 0u {
        color *= picture_at(material.picture, weights.x * a.place.xy + weights.y * b.place.xy + weights.z * c.place.xy);
    }
    return color;
}

// Bilinear in linear light, `lobe_scene::Texture::sample`.
fn picture_at(picture: vec4u, uv: vec2f) -> vec4f {
    return picture_between(picture, uv, false);
}

// The same, or of the numbers as they are stored.
fn picture_between(picture: vec4u, uv: vec2f, is_stored: bool) -> vec4f {
    let x = neighbors(uv.x, i32(picture.y), picture.w % 3u);
    let y = neighbors(uv.y, i32(picture.z), picture.w / 3u);
    let a = picture_texel(picture, x.low, y.low, is_stored);
    let b = picture_texel(picture, x.high, y.low, is_stored);
    let c = picture_texel(picture, x.low, y.high, is_stored);
    let d = picture_texel(picture, x.high, y.high, is_stored);
    return mix(mix(a, b, x.f), mix(c, d, x.f), y.f);
}

struct Neighbors {
    low: i32,
    high: i32,
    f: f32,
}

fn neighbors(coordinate: f32, size: i32, wrap: u32) -> Neighbors {
    var u = coordinate;
    switch wrap {
        case 0u: { u = u - floor(u); }
        case 1u: { u = u - 2.0 * floor(0.5 * u); }
        default: { u = clamp(u, 0.0, 1.0); }
    }
    let x = u * f32(size) - 0.5;
    let below = floor(x);
    return Neighbors(continued(i32(below), size, wrap), continued(i32(below) + 1, size, wrap), x - below);
}

// Of a texel from -1 on: remainders of negative numbers are undefined in OpenGL.
fn continued(k: i32, size: i32, wrap: u32) -> i32 {
    switch wrap {
        case 0u: { return (k + size) % size; }
        case 1u: {
            let period = 2 * size;
            let j = (k + period) % period;
            return select(period - 1 - j, j, j < size);
        }
        default: { return clamp(k, 0, size - 1); }
    }
}

fn picture_texel(picture: vec4u, x: i32, y: i32, is_stored: bool) -> vec4f {
    let s = unpack4x8unorm(texels[picture.x + u32(y) * picture.y + u32(x)]);
    let linear = select(pow((s.rgb + 0.055) / 1.055, vec3f(2.4)), s.rgb / 12.92, s.rgb <= vec3f(0.04045));
    return vec4f(select(linear, s.rgb, is_stored), s.a);
}
