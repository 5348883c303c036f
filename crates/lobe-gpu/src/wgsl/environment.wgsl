// uses: elementary, octahedral
// Lookups of an environment map in every mapping of `lobe_env::Mapping`, as `lobe_env::MappedMap::radiance`: bilinear
// between the centers of texels and across every seam. Levels of a map lie below each other in one texture.
//
// MAPPING is one of those below, and LEVELS the number of levels: compilers of shaders copy every function to where it is called, so
// that all mappings in one shader, or texels read in many places, take them minutes.

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
    // 1 if levels are quadratic in roughness.
    quadratic: u32,
    // The factor of the radiance.
    strength: f32,
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
    if LEVELS == 1u {
        return environment.strength * level_radiance(texels, environment.level[0], d);
    }
    let place = clamp(lod, 0.0, f32(LEVELS - 1u));
    let low = u32(place);
    let t = place - f32(low);
    var sum = vec3f(0.0);
    let count = select(2u, 1u, t == 0.0);
    for (var k = 0u; k < count; k++) {
        sum += select(t, 1.0 - t, k == 0u) * level_radiance(texels, environment.level[low + k], d);
    }
    return environment.strength * sum;
}

fn level_radiance(texels: texture_2d<f32>, level: EnvironmentLevel, s: vec3f) -> vec3f {
    switch MAPPING {
        case LAT_LONG: { return lat_long_radiance(texels, level, s); }
        case CUBE: { return cube_radiance(texels, level, s); }
        case OCTAHEDRAL: { return folded_radiance(texels, level, octahedral_uv_from_dir(s)); }
        case EQUAL_AREA: { return folded_radiance(texels, level, equal_area_point(s)); }
        case DUAL_PARABOLOID: { return paraboloid_radiance(texels, level, s); }
        case SPHERE: { return ball_radiance(texels, level, ball_point(vec3f(-s.y, s.x, s.z))); }
        case MIRROR_BALL: { return ball_radiance(texels, level, ball_point(vec3f(-s.x, -s.y, s.z))); }
        default: { return ball_radiance(texels, level, angular_point(vec3f(s.x, -s.y, s.z))); }
    }
}

// Columns wrap around; beyond the first and the last row comes the same row, half a turn further.
fn lat_long_radiance(texels: texture_2d<f32>, level: EnvironmentLevel, s: vec3f) -> vec3f {
    let width = f32(level.width);
    let height = f32(level.height);
    let across = length(s.xy);
    let column = width * (0.5 - 0.5 / PI * angle_of(s.y, s.x)) - 0.5;
    var row = height / PI * angle_of(across, s.z) - 0.5;
    // Bend the fraction of a row, by the cotangent at the edge between two rows: that of s, turned on to the edge.
    let edge = floor(row);
    let fraction = row - edge;
    if edge >= 0.0 && edge + 1.0 < height {
        let turn = sin_cos_eighth((0.5 - fraction) * PI / height);
        let cotangent = (s.z * turn.y - across * turn.x) / (across * turn.y + s.z * turn.x);
        row += level.bend * cotangent * fraction * (1.0 - fraction);
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
    // From -1 to 3/2 w: at most once around. Remainders of whole numbers take processors longer than all else here.
    let turned = i32(left) + select(0, w, left < 0.0);
    let x = turned - select(0, w, turned >= w);
    let next = select(x + 1, 0, x + 1 == w);
    let y = i32(clamp(row, 0.0, last));
    return mix(environment_texel(texels, level, x, y), environment_texel(texels, level, next, y), f);
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
    let size = i32(level.width);
    let p = f32(size) * (0.5 * local.yz / local.x + 0.5) - 0.5;
    let first = vec2i(floor(p));
    let f = p - floor(p);
    let last = vec2i(size - 1);
    var sum = vec3f(0.0);
    for (var k = 0; k < 4; k++) {
        let at = first + vec2i(k & 1, k >> 1u);
        let inner = clamp(at, vec2i(0), last);
        let is_corner = at.x != inner.x && at.y != inner.y;
        let weight = select(1.0 - f.x, f.x, (k & 1) == 1) * select(1.0 - f.y, f.y, k > 1);
        let count = select(1, 3, is_corner);
        for (var j = 0; j < count; j++) {
            // At a corner the texel of this face, and one of each neighbor.
            var place = at;
            if is_corner && j != 1 {
                place.y = inner.y;
            }
            if is_corner && j != 2 {
                place.x = inner.x;
            }
            let texel = cube_texel(level, face, place);
            sum += weight / f32(count) * environment_texel(texels, level, texel.x, texel.y);
        }
    }
    return sum;
}

// The place in the picture of a texel of a face or next to it: the middle of the edge between the two lies on both faces.
fn cube_texel(level: EnvironmentLevel, face: i32, at: vec2i) -> vec2i {
    let size = i32(level.width);
    if all(at == clamp(at, vec2i(0), vec2i(size - 1))) {
        return vec2i(at.x, face * size + at.y);
    }
    let axes = cube_axes(face);
    let a = clamp((2.0 * vec2f(at) + 1.0) / f32(size) - 1.0, vec2f(-1.0), vec2f(1.0));
    // Towards the neighbor: the edge without the center of this face.
    let beyond = select(vec3f(0.0), a.x * axes[1], abs(a.x) == 1.0) + select(vec3f(0.0), a.y * axes[2], abs(a.y) == 1.0);
    let other = cube_face(beyond);
    let local = transpose(cube_axes(other)) * (axes[0] + a.x * axes[1] + a.y * axes[2]);
    let place = clamp(vec2i(0.5 * (local.yz + 1.0) * f32(size)), vec2i(0), vec2i(size - 1));
    return vec2i(place.x, other * size + place.y);
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
    let side = side_of(s.x);
    let p = vec2f(-side * s.y, -s.z) / (1.0 + abs(s.x));
    let back = select(0u, 1u, s.x < 0.0);
    return across_rim(texels, level, p, half_disc(level, back), half_disc(level, 1u - back), vec2f(-p.x, p.y));
}

fn half_disc(level: EnvironmentLevel, back: u32) -> Disc {
    let width = 0.5 * f32(level.width);
    let w = i32(level.width);
    return Disc(f32(back) * width, width, select(0, w / 2, back == 1u), select((w + 1) / 2, w, back == 1u));
}

// Blends over the last half texel before the rim: at the rim both sides have the same weight. On each side the value is that of the
// four texels around the point that touch the disc.
fn across_rim(
    texels: texture_2d<f32>, level: EnvironmentLevel, p: vec2f, own: Disc, other: Disc, beyond: vec2f
) -> vec3f {
    let height = f32(level.height);
    let inner = max(1.0 - 1.0 / min(own.width, height), 0.0);
    let r = length(p);
    let is_near = r > inner;
    let scale = select(1.0, inner / r, is_near);
    let t = select(0.0, 0.5 * min((r - inner) / (1.0 - inner), 1.0), is_near);
    let sides = select(1, 2, is_near);
    var total = vec3f(0.0);
    for (var side = 0; side < sides; side++) {
        var disc = own;
        var at = scale * p;
        if side == 1 {
            disc = other;
            at = scale * beyond;
        }
        let place = vec2f(disc.start + 0.5 * (at.x + 1.0) * disc.width, 0.5 * (at.y + 1.0) * height) - 0.5;
        let f = place - floor(place);
        var sum = vec4f(0.0);
        for (var k = 0; k < 4; k++) {
            let texel = vec2i(floor(place)) + vec2i(k & 1, k >> 1u);
            let weight = select(1.0 - f.x, f.x, (k & 1) == 1) * select(1.0 - f.y, f.y, k > 1);
            let nearest = vec2f(
                nearest_to_middle(f32(texel.x) - disc.start, disc.width), nearest_to_middle(f32(texel.y), height)
            );
            let exists = texel.x >= disc.first && texel.x < disc.end && texel.y >= 0 && texel.y < i32(level.height);
            if exists && dot(nearest, nearest) < 1.0 && weight > 0.0 {
                sum += weight * vec4f(environment_texel(texels, level, texel.x, texel.y), 1.0);
            }
        }
        total += select(1.0 - t, t, side == 1) * sum.rgb / max(sum.a, 1e-30);
    }
    return total;
}

// The point of texel i of n nearest to the middle, where the picture reaches from -1 to 1.
fn nearest_to_middle(i: f32, n: f32) -> f32 {
    return clamp(0.0, 2.0 * i / n - 1.0, 2.0 * (i + 1.0) / n - 1.0);
}
