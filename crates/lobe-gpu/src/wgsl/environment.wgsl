// uses: elementary
// Lookups of an environment map in every mapping of `lobe_env::Mapping`, as `lobe_env::MappedMap::radiance`: bilinear
// between the centers of texels and across every seam. Levels of a map lie below each other in one texture.

const LAT_LONG = 0u;
const SPHERE = 1u;
const MIRROR_BALL = 2u;
const ANGULAR = 3u;
const DUAL_PARABOLOID = 4u;
const OCTAHEDRAL = 5u;
const EQUAL_AREA = 6u;
const CUBE = 7u;

const MOST_LEVELS = 16;

struct EnvironmentLevel {
    width: u32,
    height: u32,
    // The first row in the texture.
    row: u32,
    // Lat-long: the bend of rows over the cotangent at their edge, which gives each row its solid angle.
    bend: f32,
}

struct Environment {
    mapping: u32,
    levels: u32,
    // Whether levels are quadratic in roughness.
    quadratic: u32,
    pad: u32,
    // From the world to the frame of the map: three columns.
    turn: mat3x3f,
    level: array<EnvironmentLevel, MOST_LEVELS>,
}

fn environment_texel(texels: texture_2d<f32>, level: EnvironmentLevel, x: i32, y: i32) -> vec3f {
    return textureLoad(texels, vec2i(x, y + i32(level.row)), 0).rgb;
}

// The radiance from direction s of the world, at a level between 0 and the last.
fn environment_radiance(texels: texture_2d<f32>, environment: Environment, s: vec3f, lod: f32) -> vec3f {
    let d = environment.turn * s;
    let last = f32(environment.levels - 1u);
    let place = clamp(lod, 0.0, last);
    let low = u32(place);
    let t = place - f32(low);
    let first = level_radiance(texels, environment.mapping, environment.level[low], d);
    if t == 0.0 {
        return first;
    }
    return mix(first, level_radiance(texels, environment.mapping, environment.level[low + 1u], d), t);
}

fn level_radiance(texels: texture_2d<f32>, mapping: u32, level: EnvironmentLevel, s: vec3f) -> vec3f {
    switch mapping {
        case LAT_LONG: { return lat_long_radiance(texels, level, s); }
        case CUBE: { return cube_radiance(texels, level, s); }
        case OCTAHEDRAL: { return folded_radiance(texels, level, octahedral_point(s)); }
        case EQUAL_AREA: { return folded_radiance(texels, level, equal_area_point(s)); }
        case DUAL_PARABOLOID: { return paraboloid_radiance(texels, level, s); }
        case SPHERE: { return ball_radiance(texels, level, ball_point(vec3f(-s.y, s.x, s.z))); }
        case MIRROR_BALL: { return ball_radiance(texels, level, ball_point(vec3f(-s.x, -s.y, s.z))); }
        default: { return ball_radiance(texels, level, angular_point(vec3f(s.x, -s.y, s.z))); }
    }
}

// Bilinear between four texels that are neighbors in the picture.
fn bilinear(texels: texture_2d<f32>, level: EnvironmentLevel, x: vec2i, y: vec2i, f: vec2f) -> vec3f {
    let above = mix(environment_texel(texels, level, x.x, y.x), environment_texel(texels, level, x.y, y.x), f.x);
    let below = mix(environment_texel(texels, level, x.x, y.y), environment_texel(texels, level, x.y, y.y), f.x);
    return mix(above, below, f.y);
}

// Columns wrap around; beyond the first and the last row comes the same row, half a turn further.
fn lat_long_radiance(texels: texture_2d<f32>, level: EnvironmentLevel, s: vec3f) -> vec3f {
    let width = f32(level.width);
    let height = f32(level.height);
    let column = width * (0.5 - 0.5 / PI * angle_of(s.y, s.x)) - 0.5;
    var row = height / PI * angle_of(length(s.xy), s.z) - 0.5;
    // Bend the fraction of a row.
    let edge = floor(row);
    let fraction = row - edge;
    if edge >= 0.0 && edge + 1.0 < height {
        let turn = sin_cos_pi((edge + 1.0) / height);
        row += level.bend * turn.y / turn.x * fraction * (1.0 - fraction);
    }
    let above = floor(row);
    let t = row - above;
    return mix(lat_long_row(texels, level, above, column), lat_long_row(texels, level, above + 1.0, column), t);
}

fn lat_long_row(texels: texture_2d<f32>, level: EnvironmentLevel, row: f32, column: f32) -> vec3f {
    let width = f32(level.width);
    let last = f32(level.height) - 1.0;
    let place = column + select(0.0, 0.5 * width, row < 0.0 || row > last);
    let left = floor(place);
    let f = place - left;
    let w = i32(level.width);
    let x = ((i32(left) % w) + w) % w;
    let y = i32(clamp(row, 0.0, last));
    return mix(environment_texel(texels, level, x, y), environment_texel(texels, level, (x + 1) % w, y), f);
}

// Center, direction of the columns, direction of the rows of a face.
fn cube_axes(face: i32) -> mat3x3f {
    switch face {
        case 0: { return mat3x3f(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0); }
        case 1: { return mat3x3f(-1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0); }
        case 2: { return mat3x3f(0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, -1.0, 0.0); }
        case 3: { return mat3x3f(0.0, 0.0, -1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0); }
        case 4: { return mat3x3f(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0); }
        default: { return mat3x3f(0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, -1.0); }
    }
}

// The face towards a point: X wins over Z over Y, in Lobe's axes.
fn cube_face(p: vec3f) -> i32 {
    let a = abs(p);
    if a.x >= a.z && a.x >= a.y {
        return select(1, 0, p.x > 0.0);
    }
    if a.z >= a.y {
        return select(3, 2, p.z > 0.0);
    }
    return select(5, 4, p.y < 0.0);
}

// Beyond an edge of a face comes its neighbor, beyond a corner the mean of the three texels that meet there.
fn cube_radiance(texels: texture_2d<f32>, level: EnvironmentLevel, s: vec3f) -> vec3f {
    let face = cube_face(s);
    let local = transpose(cube_axes(face)) * s;
    let size = f32(level.width);
    let p = size * (0.5 * local.yz / local.x + 0.5) - 0.5;
    let first = floor(p);
    let f = p - first;
    let x = i32(first.x);
    let y = i32(first.y);
    let above = mix(cube_texel(texels, level, face, x, y), cube_texel(texels, level, face, x + 1, y), f.x);
    let below = mix(cube_texel(texels, level, face, x, y + 1), cube_texel(texels, level, face, x + 1, y + 1), f.x);
    return mix(above, below, f.y);
}

fn cube_texel(texels: texture_2d<f32>, level: EnvironmentLevel, face: i32, x: i32, y: i32) -> vec3f {
    let size = i32(level.width);
    let cx = clamp(x, 0, size - 1);
    let cy = clamp(y, 0, size - 1);
    let own = environment_texel(texels, level, cx, face * size + cy);
    if cx == x && cy == y {
        return own;
    }
    if cx != x && cy != y {
        return (own + cube_neighbor(texels, level, face, x, cy) + cube_neighbor(texels, level, face, cx, y)) / 3.0;
    }
    return cube_neighbor(texels, level, face, x, y);
}

// The texel next to a face: the middle of the edge between the two lies on both faces.
fn cube_neighbor(texels: texture_2d<f32>, level: EnvironmentLevel, face: i32, x: i32, y: i32) -> vec3f {
    let size = f32(level.width);
    let axes = cube_axes(face);
    let a = clamp((2.0 * vec2f(f32(x), f32(y)) + 1.0) / size - 1.0, vec2f(-1.0), vec2f(1.0));
    // Towards the neighbor: the edge without the center of this face.
    let beyond = select(vec3f(0.0), a.x * axes[1], abs(a.x) == 1.0) + select(vec3f(0.0), a.y * axes[2], abs(a.y) == 1.0);
    let other = cube_face(beyond);
    let local = transpose(cube_axes(other)) * (axes[0] + a.x * axes[1] + a.y * axes[2]);
    let place = clamp(vec2i(0.5 * (local.yz + 1.0) * size), vec2i(0), vec2i(i32(level.width) - 1));
    return environment_texel(texels, level, place.x, other * i32(level.width) + place.y);
}

fn octahedral_point(s: vec3f) -> vec2f {
    let p = s.xy / (abs(s.x) + abs(s.y) + abs(s.z));
    let folded = (1.0 - abs(p.yx)) * vec2f(side_of(p.x), side_of(p.y));
    return 0.5 + 0.5 * select(p, folded, s.z < 0.0);
}

fn equal_area_point(s: vec3f) -> vec2f {
    let r = length(s.xy) / sqrt(1.0 + abs(s.z));
    let b = r * angle_of(abs(s.y), abs(s.x)) * 2.0 / PI;
    let p = vec2f(r - b, b);
    let folded = select(p, 1.0 - p.yx, s.z < 0.0);
    return 0.5 + 0.5 * folded * vec2f(side_of(s.x), side_of(s.y));
}

// Beyond a side comes the same side, rotated about its middle.
fn folded_radiance(texels: texture_2d<f32>, level: EnvironmentLevel, uv: vec2f) -> vec3f {
    let p = uv * vec2f(f32(level.width), f32(level.height)) - 0.5;
    let first = floor(p);
    let f = p - first;
    let x = i32(first.x);
    let y = i32(first.y);
    let above = mix(folded_texel(texels, level, x, y), folded_texel(texels, level, x + 1, y), f.x);
    let below = mix(folded_texel(texels, level, x, y + 1), folded_texel(texels, level, x + 1, y + 1), f.x);
    return mix(above, below, f.y);
}

fn folded_texel(texels: texture_2d<f32>, level: EnvironmentLevel, x: i32, y: i32) -> vec3f {
    let w = i32(level.width);
    let h = i32(level.height);
    let cx = clamp(x, 0, w - 1);
    let cy = clamp(y, 0, h - 1);
    return environment_texel(texels, level, select(w - 1 - cx, cx, cy == y), select(h - 1 - cy, cy, cx == x));
}

// Points of the unit disc, x to the right and y downwards, of a direction along (center, right, up); opposite the center
// the right end of the rim.
fn disc_point(d: vec3f, r: f32) -> vec2f {
    let sine = length(d.yz);
    return select(vec2f(r, 0.0), r * vec2f(d.y, -d.z) / sine, sine > 0.0);
}

// r = sin(theta/2), without cancellation on either half.
fn ball_point(d: vec3f) -> vec2f {
    let near = length(d.yz) / sqrt(2.0 * (1.0 + max(d.x, 0.0)));
    return disc_point(d, select(sqrt(min(0.5 * (1.0 - d.x), 1.0)), near, d.x > 0.0));
}

// r = theta/pi.
fn angular_point(d: vec3f) -> vec2f {
    return disc_point(d, min(angle_of(length(d.yz), d.x) / PI, 1.0));
}

struct Disc {
    start: f32,
    width: f32,
    first: i32,
    end: i32,
}

// A disc whose rim is one direction: across the rim lies the opposite point of the rim.
fn ball_radiance(texels: texture_2d<f32>, level: EnvironmentLevel, p: vec2f) -> vec3f {
    let disc = Disc(0.0, f32(level.width), 0, i32(level.width));
    return across_rim(texels, level, p, disc, disc, -p);
}

// Two discs, r = tan(theta/2): across the rim of one lies the mirror image of the point in the other.
fn paraboloid_radiance(texels: texture_2d<f32>, level: EnvironmentLevel, s: vec3f) -> vec3f {
    let back = s.x < 0.0;
    let side = side_of(s.x);
    let p = vec2f(-side * s.y, -s.z) / (1.0 + abs(s.x));
    let width = 0.5 * f32(level.width);
    let w = i32(level.width);
    let front_disc = Disc(0.0, width, 0, (w + 1) / 2);
    let back_disc = Disc(width, width, w / 2, w);
    let beyond = vec2f(-p.x, p.y);
    if back {
        return across_rim(texels, level, p, back_disc, front_disc, beyond);
    }
    return across_rim(texels, level, p, front_disc, back_disc, beyond);
}

// Blends over the last half texel before the rim: at the rim both sides have the same weight.
fn across_rim(
    texels: texture_2d<f32>, level: EnvironmentLevel, p: vec2f, disc: Disc, other: Disc, beyond: vec2f
) -> vec3f {
    let inner = max(1.0 - 1.0 / min(disc.width, f32(level.height)), 0.0);
    let r = length(p);
    if r <= inner {
        return on_disc(texels, level, p, disc);
    }
    let scale = inner / r;
    let t = 0.5 * min((r - inner) / (1.0 - inner), 1.0);
    return mix(on_disc(texels, level, scale * p, disc), on_disc(texels, level, scale * beyond, other), t);
}

// The value at point p of a disc, from those of the four texels around it that touch the disc.
fn on_disc(texels: texture_2d<f32>, level: EnvironmentLevel, p: vec2f, disc: Disc) -> vec3f {
    let height = f32(level.height);
    let place = vec2f(disc.start + 0.5 * (p.x + 1.0) * disc.width, 0.5 * (p.y + 1.0) * height) - 0.5;
    let first = floor(place);
    let f = place - first;
    var sum = vec4f(0.0);
    for (var k = 0; k < 4; k++) {
        let dx = k & 1;
        let dy = k >> 1u;
        let x = i32(first.x) + dx;
        let y = i32(first.y) + dy;
        let weight = select(1.0 - f.x, f.x, dx == 1) * select(1.0 - f.y, f.y, dy == 1);
        let nearest = vec2f(
            nearest_to_middle(f32(x) - disc.start, disc.width), nearest_to_middle(f32(y), height)
        );
        let exists = x >= disc.first && x < disc.end && y >= 0 && y < i32(level.height);
        if exists && dot(nearest, nearest) < 1.0 && weight > 0.0 {
            sum += weight * vec4f(environment_texel(texels, level, x, y), 1.0);
        }
    }
    return sum.rgb / max(sum.a, 1e-30);
}

// The point of texel i of n nearest to the middle, where the picture reaches from -1 to 1.
fn nearest_to_middle(i: f32, n: f32) -> f32 {
    return clamp(0.0, 2.0 * i / n - 1.0, 2.0 * (i + 1.0) / n - 1.0);
}
