//! Polygon lights against quadrature, known solid angles and the disc.

use std::f64::consts::PI;

use lobe_sh::basis::{band_range, legendre};
use lobe_sh::light::SphericalPolygon;
use lobe_sh::sphere::gauss_legendre;
use lobe_sh::{Dir, Expansion as _, Rotation, ShVec, Zonal, eval_basis};
use lobe_testkit::{Random, directions, golden_f64s};
use nalgebra::{DMatrix, DVector};

type Vec3 = [f64; 3];

fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn sub(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `∫ y_i ds` over the plane triangle as seen from the origin, negative if it runs clockwise: `ds = n·p dA / |p|³`.
/// Split into `4^depth` and integrated by a Gauss rule on each, collapsed at a corner.
fn by_quadrature([a, b, c]: [Vec3; 3], order: usize, depth: usize, out: &mut [f64]) {
    if depth > 0 {
        let middle = |p: Vec3, q: Vec3| [0, 1, 2].map(|k| 0.5 * (p[k] + q[k]));
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        for part in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
            by_quadrature(part, order, depth - 1, out);
        }
        return;
    }
    let normal = cross(sub(b, a), sub(c, a));
    let rule = gauss_legendre(20);
    for (x, wx) in &rule {
        for (y, wy) in &rule {
            let (u, v) = (0.5 * (1.0 + x), 0.5 * (1.0 + y));
            let p = [0, 1, 2].map(|k| a[k] + u * (b[k] - a[k] + v * (c[k] - b[k])));
            let weight = 0.25 * wx * wy * u * dot(normal, p) / dot(p, p).powf(1.5);
            let y = eval_basis(Dir::new(p).unwrap(), order);
            for (out, y) in out.iter_mut().zip(y) {
                *out += weight * y;
            }
        }
    }
}

/// The expansion of a plane polygon by a fan of triangles, turned positive.
fn expected(vertices: &[Vec3], order: usize) -> ShVec<f64> {
    let mut f = vec![0.0; order * order];
    for pair in vertices[1..].windows(2) {
        by_quadrature([vertices[0], pair[0], pair[1]], order, 2, &mut f);
    }
    let sign = f[0].signum();
    ShVec::from_vec(f.into_iter().map(|c| c * sign).collect()).unwrap()
}

fn assert_close(found: &ShVec<f64>, expected: &ShVec<f64>, tolerance: f64, what: &str) {
    for (i, (a, b)) in found.coefficients().iter().zip(expected.coefficients()).enumerate() {
        assert!((a - b).abs() <= tolerance, "{what}, i {i}: {a} against {b}");
    }
}

fn polygon(vertices: &[Vec3]) -> SphericalPolygon {
    SphericalPolygon::new(vertices.to_vec()).unwrap()
}

/// A plane polygon of random shape around `axis`: `corners` corners, star-shaped, so concave as a rule.
fn star(random: &mut Random, corners: usize, axis: Dir) -> Vec<Vec3> {
    let n = axis.to_array();
    let u = Dir::new(cross(n, random.direction())).unwrap().to_array();
    let v = cross(n, u);
    let offset = [random.signed(), random.signed()];
    (0..corners)
        .map(|k| {
            let (sin, cos) = (2.0 * PI * (k as f64 + 0.5 * random.unit()) / corners as f64).sin_cos();
            let r = 0.3 + random.unit();
            [0, 1, 2].map(|i| 1.5 * n[i] + (r * cos + offset[0]) * u[i] + (r * sin + offset[1]) * v[i])
        })
        .collect()
}

#[test]
fn polygons_equal_quadrature_over_their_triangles() {
    let mut random = Random::new(1);
    // Around both poles, over the horizon, across the seam, and elsewhere.
    let axes = [Dir::Z, -Dir::Z, Dir::X, -Dir::X, Dir::Y].into_iter();
    for (k, axis) in axes.chain(directions().into_iter().step_by(20).map(Dir::from_unit)).enumerate() {
        let vertices = star(&mut random, 3 + k % 4, axis);
        let expected = expected(&vertices, 10);
        let found = polygon(&vertices).project(10);
        assert_close(&found, &expected, 1e-12, &format!("{vertices:?}"));
        let backwards: Vec<Vec3> = vertices.iter().rev().copied().collect();
        assert_close(&polygon(&backwards).project(10), &found, 1e-14, "the other way round");
        for order in 1..10 {
            assert_close(&polygon(&vertices).project(order), &found.resized(order), 1e-14, "lower orders");
        }
    }
}

#[test]
fn an_octant_has_its_known_moments() {
    let octant = polygon(&[[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 0.5]]);
    // ∫ P_l(z) over the octant.
    let f = octant.project(6);
    for (l, expected) in [PI / 2.0, PI / 4.0, 0.0, -PI / 16.0, 0.0, PI / 32.0].into_iter().enumerate() {
        let moment = f[l * (l + 1)] / ((2 * l + 1) as f64 / (4.0 * PI)).sqrt();
        assert!((moment - expected).abs() < 1e-14, "band {l}: {moment} against {expected}");
    }
    assert!((octant.solid_angle() - PI / 2.0).abs() < 1e-14, "{}", octant.solid_angle());
}

#[test]
fn a_disc_is_the_limit_of_regular_polygons() {
    let (a, order) = (0.6_f64, 8);
    let cone = Zonal::cone(order, a).towards(Dir::from_angles(2.0, 1.0), 1.0);
    let turn = Rotation::from_euler_zyz(1.0, 2.0, 0.0);
    let with_corners = |n: u32| {
        let vertex = |k: u32| turn.rotate_dir(Dir::from_angles(a, 2.0 * PI * f64::from(k) / f64::from(n))).to_array();
        polygon(&(0..n).map(vertex).collect::<Vec<_>>()).project(order)
    };
    let off = |f: &ShVec<f64>| (f - &cone).dot(&(f - &cone)).sqrt();
    let (coarse, fine) = (with_corners(256), with_corners(512));
    let ratio = off(&coarse) / off(&fine);
    assert!((ratio - 4.0).abs() < 1e-3, "the error falls with the square of the corners: {ratio}");
    // Two extrapolations remove the errors of second and fourth order.
    let finest = with_corners(1024);
    let step = |a: &ShVec<f64>, b: &ShVec<f64>, power: f64| &(&(b * power) - a) * (1.0 / (power - 1.0));
    let limit = step(&step(&coarse, &fine, 4.0), &step(&fine, &finest, 4.0), 16.0);
    assert!(off(&limit) < 1e-12, "the limit is {} off the disc", off(&limit));
}

#[test]
fn the_horizon_cuts_what_a_surface_cannot_see() {
    let mut random = Random::new(5);
    for v in directions().into_iter().step_by(9) {
        let normal = Dir::from_unit(v);
        let axis = Dir::from_unit(random.direction());
        let vertices = star(&mut random, 5, axis);
        let whole = polygon(&vertices);
        let (above, below) = (whole.above(normal), whole.above(-normal));
        let parts = &above.project(7) + &below.project(7);
        assert_close(&parts, &whole.project(7), 1e-13, &format!("cut by {v:?}"));
        let total = above.solid_angle() + below.solid_angle();
        assert!((total - whole.solid_angle()).abs() < 1e-13, "{total} against {}", whole.solid_angle());
        // Its irradiance by Lambert and by many bands.
        let exact = dot(above.vector_irradiance(), v);
        let bands = Zonal::clamped_cosine(64).towards(normal, 1.0).dot(&whole.project(64));
        assert!((exact - bands).abs() < 2e-4, "irradiance {exact} against {bands}");
    }
    let under = polygon(&[[1.0, 0.0, -1.0], [0.0, 1.0, -1.0], [-1.0, -1.0, -1.0]]).above(Dir::Z);
    assert_eq!(under.project(4), ShVec::zero(4), "nothing is above");
    assert_eq!((under.solid_angle(), under.vector_irradiance()), (0.0, [0.0; 3]), "nothing is above");
}

#[test]
fn more_than_half_of_the_sphere_is_the_other_side() {
    // A contour around a cap of 70°, walked with the cap outside: still the cap, the smaller side.
    let cap = |n: u32, sign: f64| {
        let vertex = |k: u32| Dir::from_angles(1.2, sign * 2.0 * PI * f64::from(k) / f64::from(n)).to_array();
        polygon(&(0..n).map(vertex).collect::<Vec<_>>())
    };
    let (left, right) = (cap(40, 1.0), cap(40, -1.0));
    assert!((left.solid_angle() - right.solid_angle()).abs() < 1e-14, "{}", left.solid_angle());
    assert!(left.solid_angle() < 2.0 * PI && left.vector_irradiance()[2] > 0.0, "{left:?}");
    assert_close(&left.project(6), &right.project(6), 1e-14, "both ways round");
}

#[test]
fn a_receiver_inside_the_plane_of_a_polygon_sees_a_hemisphere() {
    let square = vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]];
    let triangle = vec![[1.0, 0.0, 0.0], [-1.0, 1.0, 0.0], [-1.0, -1.0, 0.0]];
    // Off its center, and turned, so that rounding decides on which side of the plane everything lies.
    let flat = [[3.0, 0.1, 0.0], [0.2, 1.0, 0.0], [-1.0, 0.3, 0.0], [-0.1, -2.0, 0.0]];
    let turns = [[0.0; 3], [0.3, 0.9, -2.0], [-1.0, 2.5, 0.4], [2.0, 1.3, 0.7]];
    for contour in [square, triangle, flat.to_vec()] {
        for [a, b, c] in turns {
            let turn = Rotation::from_euler_zyz(a, b, c);
            let up = turn.rotate_dir(Dir::Z);
            let turned = |v: &Vec3| turn.rotate_dir(Dir::new(*v).unwrap()).to_array().map(|x| x * dot(*v, *v).sqrt());
            let left: Vec<Vec3> = contour.iter().map(turned).collect();
            let right: Vec<Vec3> = left.iter().rev().copied().collect();
            for (vertices, axis) in [(left, up), (right, -up)] {
                let polygon = polygon(&vertices);
                let hemisphere = Zonal::cone(8, PI / 2.0).towards(axis, 1.0);
                assert!((hemisphere[0] - PI.sqrt()).abs() < 1e-14, "half of the sphere: {}", hemisphere[0]);
                assert_close(&polygon.project(8), &hemisphere, 1e-12, &format!("{vertices:?} to the left"));
                assert!((polygon.solid_angle() - 2.0 * PI).abs() < 1e-12, "{}", polygon.solid_angle());
                let flow = sub(polygon.vector_irradiance(), axis.to_array().map(|x| PI * x));
                assert!(dot(flow, flow).sqrt() < 1e-12, "the vector irradiance of {vertices:?} is {flow:?} off");
            }
        }
    }
}

#[test]
fn small_polygons_keep_their_digits() {
    for size in [1e-2, 1e-4, 1e-6] {
        let corner = [0.48, 0.6, 0.64];
        let vertices = [corner, [0.48 + size, 0.6, 0.64], [0.48, 0.6, 0.64 + size]];
        let found = polygon(&vertices).project(5);
        let expected = expected(&vertices, 5);
        let scale = expected[0];
        assert!((found[0] / expected[0] - 1.0).abs() < 4e-15 / size, "size {size}: {} {}", found[0], expected[0]);
        for i in 1..25 {
            let error = (found[i] - expected[i]).abs() / scale;
            assert!(error < 4e-15 / size, "size {size}, i {i}: relative error {error:e}");
        }
    }
}

#[test]
fn degenerate_contours_have_their_answers() {
    let square = [[1.0, -1.0, -1.0], [1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [1.0, -1.0, 1.0]];
    let plain = polygon(&square).project(6);
    let doubled: Vec<Vec3> = square.iter().flat_map(|v| [*v, *v]).collect();
    assert_close(&polygon(&doubled).project(6), &plain, 1e-14, "vertices given twice");
    let mut spike = square.to_vec();
    spike.insert(1, [1.0, 3.0, -2.0]);
    spike.insert(1, square[0]);
    spike.insert(3, square[0]);
    assert_close(&polygon(&spike).project(6), &plain, 1e-14, "an edge that runs out and back");
    let line = polygon(&[[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 2.0, 0.0]]);
    assert_close(&line.project(6), &ShVec::zero(6), 1e-15, "a line");
    let scaled: Vec<Vec3> = square.iter().map(|v| v.map(|c| c * 1e-200)).collect();
    assert_close(&polygon(&scaled).project(6), &plain, 1e-14, "tiny coordinates");
    assert_eq!(polygon(&square).project(0).order(), 0, "order 0");
}

#[test]
fn what_is_no_polygon_is_refused_in_one_line() {
    for (vertices, what) in [
        (vec![], "three vertices"),
        (vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], "three vertices"),
        (vec![[1.0, 0.0, 0.0], [0.0, f64::NAN, 0.0], [0.0, 0.0, 1.0]], "not finite"),
        (vec![[1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]], "vertex 1 of the polygon is the receiver"),
        (vec![[1.0, 0.0, 0.0], [-2.0, 0.0, 0.0], [0.0, 0.0, 1.0]], "edge 0 of the polygon passes through"),
    ] {
        let error = SphericalPolygon::new(vertices.clone()).unwrap_err().to_string();
        assert!(error.contains(what) && !error.contains('\n'), "{vertices:?}: {error}");
    }
}

/// `∫ P_l(w·s) ds` over the inside, the contour running left around it, for `l` from 1: the recurrences of Wang and
/// Ramamoorthi 2018 for the integrals along an edge, summed by Stokes' theorem as `1/(l(l+1)) Σ c D_l`.
fn zonal_moments(vertices: &[Vec3], w: Vec3, count: usize) -> Vec<f64> {
    let unit = |v: Vec3| v.map(|c| c / dot(v, v).sqrt());
    let mut moments = vec![0.0; count];
    for k in 0..vertices.len() {
        let (start, end) = (unit(vertices[k]), unit(vertices[(k + 1) % vertices.len()]));
        let normal = unit(cross(start, end));
        let (a, b, c) = (dot(w, start), dot(w, cross(normal, start)), dot(w, normal));
        let gamma = dot(normal, cross(start, end)).atan2(dot(start, end));
        let (sin, cos) = gamma.sin_cos();
        let p = |l: usize, t: f64| legendre(l, 0, t);
        let mut big_b = vec![gamma, a * sin - b * cos + b];
        let mut d = vec![0.0, gamma];
        for l in 2..=count {
            let lf = l as f64;
            let ends = (a * sin - b * cos) * p(l - 1, a * cos + b * sin) + b * p(l - 1, a);
            let big_c = (ends + (a * a + b * b - 1.0) * d[l - 1] + (lf - 1.0) * big_b[l - 2]) / lf;
            big_b.push(((2.0 * lf - 1.0) * big_c - (lf - 1.0) * big_b[l - 2]) / lf);
            d.push((2.0 * lf - 1.0) * big_b[l - 1] + d[l - 2]);
        }
        for (l, moment) in moments.iter_mut().enumerate() {
            *moment += c * d[l + 1] / ((l + 1) * (l + 2)) as f64;
        }
    }
    moments
}

/// The way of Wang and Ramamoorthi 2018: zonal moments along the lobes of Nowrouzezahrai and others 2012, whose matrix
/// is then undone.
#[test]
fn coefficients_follow_from_moments_along_zonal_lobes() {
    const BANDS: usize = 8;
    let polygon = [[1.0, -0.4, 0.1], [1.0, 0.5, 0.0], [1.1, 0.6, 0.9], [0.9, -0.5, 1.0]];
    let f = SphericalPolygon::new(polygon.to_vec()).unwrap().project(BANDS);
    for l in 1..BANDS {
        let angles = golden_f64s(&format!("/zonal_lobes/bands/{l}"));
        let lobes: Vec<Dir> = angles.chunks(2).map(|a| Dir::from_angles(a[0], a[1])).collect();
        assert_eq!(lobes.len(), 2 * l + 1, "lobes of band {l}");
        // ∫ P_l(d·s) f = 4π/(2l+1) Σ_m y_lm(d) f_lm
        let scale = 4.0 * PI / (2 * l + 1) as f64;
        let matrix = DMatrix::from_fn(2 * l + 1, 2 * l + 1, |i, m| scale * eval_basis(lobes[i], l + 1)[l * l + m]);
        let moments = lobes.iter().map(|d| zonal_moments(&polygon, d.to_array(), l)[l - 1]);
        let solved = matrix.lu().solve(&DVector::from_iterator(2 * l + 1, moments)).expect("lobes are independent");
        for (found, expected) in solved.iter().zip(&f.coefficients()[band_range(l)]) {
            assert!((found - expected).abs() < 1e-12, "band {l}: {found} against {expected}");
        }
    }
}
