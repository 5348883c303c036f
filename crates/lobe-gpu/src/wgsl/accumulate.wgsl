// uses: dispatch, shadow_receiver
// What many spheres together leave of the sky, `lobe_shadow::SphereShadows` without tree and groups (Ren et al. 2006): the sum of the
// logarithms of all spheres, each from the table by its size and turned to where the receiver sees it, and its
// exponential on a grid; then irradiance by the operator of `lobe_shadow::SkyLight`.

// Center and radius; the factors of 1, x, y, z, xy, yz, z*z, xz, x*x - y*y in the part of the disc that counts; the square of the
// radius of the solid whose part it is, over that of its own.
struct Sphere {
    center: vec4f,
    share_0: vec4f,
    share_1: vec4f,
    share_2: vec4f,
}

struct Sizes {
    receivers: u32,
    spheres: u32,
    intervals: u32,
    // The end of the polynomials, in the square of the sine.
    fit_end: f32,
    // Of the grid.
    points: u32,
}

@group(0) @binding(0) var<uniform> sizes: Sizes;
@group(0) @binding(1) var<storage, read> receivers: array<Receiver>;
@group(0) @binding(2) var<storage, read> spheres: array<Sphere>;
// FIT coefficients of a polynomial for each band, as in lobe-shadow/accumulate/log_table, which then has rows for equal steps of 1 - cos.
@group(0) @binding(3) var<uniform> polynomials: array<vec4f, POLYNOMIALS>;
@group(0) @binding(4) var<storage, read> log_table: array<f32>;
// For each point of the grid the basis, then the weight.
@group(0) @binding(5) var<storage, read> grid: array<vec4f>;
@group(0) @binding(6) var<storage, read_write> visibility: array<f32>;

// The height at which a sinking sphere counts, as a part of that of its top; the part of the radius by which it reaches out of a
// surface and hides nothing yet; how it sinks; and the least square of a distance, as in lobe-shadow/accumulate/aim.
const SUNK = 0.25;
const RIM = 0.125;
const SLOPE = 0.8275862;
const NO_DISTANCE = 1e-30;

struct Aim {
    towards: vec3f,
    sin_squared: f32,
}

fn aim(at: Receiver, sphere: Sphere) -> Aim {
    let r = sphere.center.w;
    let n = at.normal.xyz;
    var c = sphere.center.xyz - at.position.xyz;
    let h = dot(n, c);
    let top = h + r;
    let hiding = r * clamp(SLOPE * (top - RIM * r), 0.0, r);
    c += max(SUNK * top - h, 0.0) * n;
    let squared = dot(c, c);
    let inverse = inverseSqrt(max(squared, NO_DISTANCE));
    return Aim(c * inverse, select(hiding, 0.0, squared < NO_DISTANCE) * min(inverse * inverse, 1.0 / max(r * r, NO_DISTANCE)));
}

fn share_towards(sphere: Sphere, s: vec3f) -> f32 {
    let first = dot(sphere.share_0, vec4f(1.0, s));
    let second = dot(sphere.share_1, vec4f(s.x * s.y, s.y * s.z, s.z * s.z, s.x * s.z));
    return clamp(first + second + sphere.share_2.x * (s.x * s.x - s.y * s.y), 0.0, 1.0);
}

// F_l of one sphere of sin^2 = u. Here and below, functions that are not in this module are written out for each order, place by
// place, by moving/straight_line.
fn log_factors(u: f32) -> array<f32, ORDER> {
    if u <= sizes.fit_end {
        return fitted(u * (2.0 / sizes.fit_end) - 1.0, u);
    }
    let place = (1.0 - sqrt(max(1.0 - u, 0.0))) * f32(sizes.intervals);
    let row = min(u32(place), sizes.intervals - 1u);
    return between_rows(ORDER * row, place - f32(row));
}

// F_0/u of one sphere, by the polynomial alone.
fn mean_of_unit(u: f32) -> f32 {
    return fitted(min(u, sizes.fit_end) * (2.0 / sizes.fit_end) - 1.0, 1.0)[0];
}

// How much deeper the logarithm of a part of a solid is than that of a sphere alone, as in lobe-shadow/accumulate/sum_logarithms.
fn gain(u: f32, ratio: f32) -> f32 {
    if ratio <= 1.0 {
        return 1.0;
    }
    return mean_of_unit(u * ratio) / mean_of_unit(u);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let r = item_of(id, groups);
    if r >= sizes.receivers {
        return;
    }
    let at = receivers[r];
    var f: array<f32, COEFFICIENTS>;
    for (var k = 0u; k < sizes.spheres; k++) {
        let sphere = spheres[k];
        let seen = aim(at, sphere);
        let share = share_towards(sphere, seen.towards) * gain(seen.sin_squared, sphere.share_2.y);
        f = with_sphere(f, share, log_factors(seen.sin_squared), basis(seen.towards));
    }
    // The mean is taken out of the grid.
    var v: array<f32, COEFFICIENTS>;
    for (var p = 0u; p < sizes.points; p++) {
        v = with_point(v, f, p);
    }
    // y_0 = 1/sqrt(4 pi)
    leave(v, exp(0.282094791773878 * f[0]), r, sizes.receivers);
}
