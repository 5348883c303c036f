//! Area lights: closed forms against quadrature over the light, and the error of taking lights as points or beams.
use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::OnceLock;

use lobe_env::{
    AreaLight, DiscLight, EnvError, ParallelBeam, PolygonLight, SphereLight, VectorIrradiance, compare_approximations,
};
use lobe_sh::Dir;
use lobe_sh::sphere::gauss_legendre;
use lobe_testkit::{Random, directions};

const ORIGIN: [f64; 3] = [0.0; 3];

/// The tolerance. The requirement is 1e-6; the rest is the rounding of both routes and the quadrature near the rim.
const LIMIT: f64 = 1e-11;

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn normals() -> Vec<Dir> {
    directions().into_iter().map(|v| Dir::new(v).unwrap()).collect()
}

/// `∫_a^b f` where `f` may have square roots at both ends.
fn integrate(a: f64, b: f64, mut f: impl FnMut(f64) -> f64) -> f64 {
    let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
    let node = |(x, weight): (f64, f64)| {
        let (sin, cos) = (FRAC_PI_2 * x).sin_cos();
        weight * half * FRAC_PI_2 * cos * f(middle + half * sin)
    };
    static RULE: OnceLock<Vec<(f64, f64)>> = OnceLock::new();
    RULE.get_or_init(|| gauss_legendre(48)).iter().copied().map(node).sum()
}

/// `∫ max(n·s, 0) ds` over the cap of angular radius `sigma` around `c`, ring by ring.
fn cap_by_quadrature(c: Dir, sigma: f64, n: Dir) -> f64 {
    let theta = n.angle_to(c);
    let ring = |alpha: f64| {
        let (up, aside) = (alpha.cos() * theta.cos(), alpha.sin() * theta.sin());
        let last = if up >= aside { PI } else { (-up / aside).clamp(-1.0, 1.0).acos() };
        alpha.sin() * 2.0 * integrate(0.0, last, |phi| up + aside * phi.cos())
    };
    let touched = (theta - FRAC_PI_2).abs().min(sigma);
    let inner = if theta < FRAC_PI_2 { integrate(0.0, touched, ring) } else { 0.0 };
    inner + integrate(touched, sigma, ring)
}

#[test]
fn a_sphere_equals_quadrature_for_every_normal() {
    for (center, radius) in
        [([0.3, -1.0, 2.0], 0.7), ([0.0, 0.0, 5.0], 0.01), ([-1.0, 0.1, 0.2], 1.0), ([2.0, 0.0, 0.0], 2.0)]
    {
        let light = SphereLight { center, radius };
        let sigma = (radius / dot(center, center).sqrt()).asin();
        let c = Dir::new(center).unwrap();
        for n in normals() {
            let (found, expected) = (light.irradiance(ORIGIN, n), cap_by_quadrature(c, sigma, n));
            assert!((found - expected).abs() < LIMIT, "{light:?} facing {n:?}: {found} against {expected}");
        }
    }
}

#[test]
fn a_sphere_at_the_horizon_has_its_known_value() {
    // Cut in half: σ - sin σ cos σ. With the receiver on it: the integral over the common part of two hemispheres.
    for sigma in [1e-4, 0.1, 0.8, FRAC_PI_2] {
        let light = SphereLight { center: [1.0, 0.0, 0.0], radius: sigma.sin() };
        let (found, expected) = (light.irradiance(ORIGIN, Dir::Z), sigma - sigma.sin() * sigma.cos());
        assert!((found - expected).abs() < 1e-15 + 1e-10 * expected, "σ = {sigma}: {found} against {expected}");
    }
}

#[test]
fn receivers_on_a_sphere_are_all_lit_alike() {
    let light = SphereLight { center: [0.3, -1.0, 2.0], radius: 0.7 };
    for n in normals() {
        let point = std::array::from_fn(|k| light.center[k] - light.radius * n.to_array()[k]);
        let (found, vector) = (light.irradiance(point, n), light.vector_irradiance(point).magnitude(0));
        // Half of all directions are light.
        assert!((found - PI).abs() < 1e-12 && (vector - PI).abs() < 1e-12, "facing {n:?}: {found} and {vector}, not π");
    }
}

/// A flat light for quadrature: the plane `center + t x + y (w × x)`, its normal, and for each direction `x` in the
/// plane the places where the chords at `t` change, and those chords.
struct Flat<'a> {
    center: [f64; 3],
    normal: Dir,
    breaks: &'a dyn Fn([f64; 3]) -> Vec<f64>,
    chords: &'a dyn Fn([f64; 3], f64) -> Vec<[f64; 2]>,
}

/// `∫ cos⁺ cos / d² dA`, swept along the direction in which the height above the horizon grows fastest.
fn flat_by_quadrature(flat: &Flat<'_>, n: Dir) -> f64 {
    let (m, n) = (flat.normal.to_array(), n.to_array());
    let slope = dot(n, m);
    let gradient: [f64; 3] = std::array::from_fn(|k| n[k] - slope * m[k]);
    let steep = dot(gradient, gradient).sqrt();
    let x = if steep > 1e-9 {
        gradient.map(|g| g / steep)
    } else {
        let any = if m[0].abs() < 0.7 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
        Dir::new(cross(m, any)).unwrap().to_array()
    };
    let y = cross(m, x);
    let height = dot(n, flat.center);
    let horizon = if steep > 1e-9 { -height / steep } else { height.signum() * -1e9 };
    let mut breaks = (flat.breaks)(x);
    breaks.push(horizon);
    breaks.sort_by(f64::total_cmp);
    let panels = breaks.windows(2).filter(|pair| pair[0] >= horizon && pair[1] > pair[0]);
    let strip = |t: f64| -> f64 {
        let row = |s: f64| {
            let r: [f64; 3] = std::array::from_fn(|k| flat.center[k] + t * x[k] + s * y[k]);
            let square = dot(r, r);
            dot(n, r).max(0.0) * -dot(m, r) / (square * square)
        };
        (flat.chords)(x, t).into_iter().map(|[a, b]| integrate(a, b, row)).sum()
    };
    panels.map(|pair| integrate(pair[0], pair[1], strip)).sum()
}

#[test]
fn a_disc_equals_quadrature_for_every_normal() {
    let cases = [
        ([0.0, 0.0, 2.0], -Dir::Z, 1.0),
        ([0.4, -1.0, 1.5], Dir::new([0.1, 0.5, -1.0]).unwrap(), 0.8),
        ([3.0, 0.2, 0.1], Dir::new([-0.4, 0.0, 1.0]).unwrap(), 0.5),
        ([3.0, 4.0, 12.0], Dir::new([-3.0, -4.0, -12.0]).unwrap(), 1e-3),
    ];
    for (center, normal, radius) in cases {
        let light = DiscLight { center, normal, radius };
        let flat = Flat {
            center,
            normal,
            breaks: &|_| vec![-radius, radius],
            chords: &|_, t| {
                let half = (radius * radius - t * t).max(0.0).sqrt();
                vec![[-half, half]]
            },
        };
        for n in normals() {
            let (found, expected) = (light.irradiance(ORIGIN, n), flat_by_quadrature(&flat, n));
            assert!((found - expected).abs() < LIMIT, "{light:?} facing {n:?}: {found} against {expected}");
        }
    }
}

/// The inside of a polygon along the line at `t` in direction `x`, by counting its edges.
fn chords_of(vertices: &[[f64; 3]], center: [f64; 3], x: [f64; 3], y: [f64; 3], t: f64) -> Vec<[f64; 2]> {
    let at = |v: [f64; 3]| {
        let r: [f64; 3] = std::array::from_fn(|k| v[k] - center[k]);
        (dot(r, x), dot(r, y))
    };
    let mut crossings: Vec<f64> = Vec::new();
    for (i, &v) in vertices.iter().enumerate() {
        let (a, b) = (at(v), at(vertices[(i + 1) % vertices.len()]));
        if (a.0 > t) != (b.0 > t) {
            crossings.push(a.1 + (t - a.0) / (b.0 - a.0) * (b.1 - a.1));
        }
    }
    crossings.sort_by(f64::total_cmp);
    crossings.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect()
}

fn polygons() -> Vec<(&'static str, PolygonLight)> {
    let square = PolygonLight::rectangle([0.0, 0.0, 1.0], [0.5, 0.0, 0.0], [0.0, -0.5, 0.0]).unwrap();
    let tilted = PolygonLight::rectangle([1.0, 0.3, 0.2], [0.0, 0.6, 0.2], [0.1, -0.3, 0.9]).unwrap();
    let tilted = if dot(cross([0.0, 0.6, 0.2], [0.1, -0.3, 0.9]), [-1.0, -0.3, -0.2]) > 0.0 {
        tilted
    } else {
        PolygonLight::new(tilted.vertices().iter().rev().copied().collect()).unwrap()
    };
    let triangle = PolygonLight::new(vec![[2.0, 0.0, 0.0], [0.0, 0.0, 2.0], [0.0, 2.0, 0.0]]).unwrap();
    // A star with five arms in the plane z = -0.7, counter-clockwise from above.
    let arm = |k: usize| {
        let (radius, phi) = (if k.is_multiple_of(2) { 1.5 } else { 0.5 }, PI * k as f64 / 5.0);
        [radius * phi.cos() + 0.4, radius * phi.sin(), -0.7]
    };
    let star = PolygonLight::new((0..10).map(arm).collect()).unwrap();
    vec![("square", square), ("tilted rectangle", tilted), ("triangle", triangle), ("concave star", star)]
}

#[test]
fn a_polygon_equals_quadrature_for_every_normal() {
    for (name, light) in polygons() {
        let center = light.as_point().position;
        let normal = light.as_point().normal.unwrap();
        let vertices = light.vertices();
        let flat = Flat {
            center,
            normal,
            breaks: &|x| vertices.iter().map(|v| dot(*v, x) - dot(center, x)).collect(),
            chords: &|x, t| chords_of(vertices, center, x, cross(normal.to_array(), x), t),
        };
        assert!(light.vector_irradiance(ORIGIN).magnitude(0) > 0.1, "{name} shines on the origin");
        for n in normals() {
            let (found, expected) = (light.irradiance(ORIGIN, n), flat_by_quadrature(&flat, n));
            assert!((found - expected).abs() < LIMIT, "{name} facing {n:?}: {found} against {expected}");
        }
    }
}

#[test]
fn a_rectangle_has_the_view_factor_of_the_textbooks() {
    // A corner above the receiver, parallel to it: E/π = (1/2π) (A/√(1+A²) atan(B/√(1+A²)) + B/√(1+B²)
    // atan(A/√(1+B²))).
    for (a, b) in [(1.0_f64, 1.0_f64), (0.1, 3.0), (20.0, 7.0), (1e-3, 1e-3)] {
        let (ra, rb) = ((1.0 + a * a).sqrt(), (1.0 + b * b).sqrt());
        let expected = 0.5 * (a / ra * (b / ra).atan() + b / rb * (a / rb).atan());
        let light =
            PolygonLight::rectangle([0.5 * a, 0.5 * b, 1.0], [0.5 * a, 0.0, 0.0], [0.0, -0.5 * b, 0.0]).unwrap();
        let found = light.irradiance(ORIGIN, Dir::Z);
        assert!((found / expected - 1.0).abs() < 1e-12, "{a} x {b}: {found} against {expected}");
    }
}

fn lights() -> Vec<(String, Box<dyn AreaLight>)> {
    let mut lights: Vec<(String, Box<dyn AreaLight>)> = vec![
        ("sphere".into(), Box::new(SphereLight { center: [1.0, 0.5, 1.0], radius: 0.8 })),
        (
            "disc".into(),
            Box::new(DiscLight { center: [0.3, 0.2, 1.0], normal: Dir::new([0.2, 0.1, -1.0]).unwrap(), radius: 1.2 }),
        ),
    ];
    lights
        .extend(polygons().into_iter().map(|(name, light)| (name.to_string(), Box::new(light) as Box<dyn AreaLight>)));
    lights
}

#[test]
fn the_net_irradiance_of_every_light_is_that_of_its_vector() {
    for (name, light) in lights() {
        let e = light.vector_irradiance(ORIGIN);
        for n in normals() {
            let (net, sides) = (e.net(n), light.irradiance(ORIGIN, n) - light.irradiance(ORIGIN, -n));
            assert!((net - sides).abs() < 1e-13, "{name} facing {n:?}: {net} against {sides}");
        }
    }
}

#[test]
fn a_closed_box_of_light_leaves_pi_everywhere_and_no_net_flow() {
    // The white furnace: six faces of radiance 1 around receivers anywhere inside.
    let mut faces = Vec::new();
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let (mut center, mut u, mut v) = ([0.0; 3], [0.0; 3], [0.0; 3]);
            (center[axis], u[(axis + 1) % 3], v[(axis + 2) % 3]) = (sign, 1.0, -sign);
            faces.push(PolygonLight::rectangle(center, u, v).unwrap());
        }
    }
    let mut random = Random::new(5);
    for _ in 0..20 {
        let point = [(); 3].map(|()| 0.95 * random.signed());
        let mut net = [0.0; 3];
        for face in &faces {
            let e: VectorIrradiance<f64> = face.vector_irradiance(point);
            for (sum, part) in net.iter_mut().zip(e.to_array()) {
                *sum += part;
            }
        }
        assert!(net.iter().all(|c| c.abs() < 1e-13), "at {point:?}: {net:?}");
        for n in normals() {
            let sum: f64 = faces.iter().map(|face| face.irradiance(point, n)).sum();
            assert!((sum - PI).abs() < 1e-12, "at {point:?} facing {n:?}: {sum}");
        }
    }
}

#[test]
fn polygons_of_many_sides_tend_to_the_disc() {
    let normal = Dir::new([0.2, -0.3, -1.0]).unwrap();
    let disc = DiscLight { center: [0.5, 0.1, 1.0], normal, radius: 0.9 };
    let u = Dir::new(cross(normal.to_array(), [1.0, 0.0, 0.0])).unwrap().to_array();
    let v = cross(normal.to_array(), u);
    let sides = 2000;
    let vertex = |k: usize| -> [f64; 3] {
        let (sin, cos) = (2.0 * PI * k as f64 / sides as f64).sin_cos();
        std::array::from_fn(|i| disc.center[i] + disc.radius * (cos * u[i] + sin * v[i]))
    };
    let polygon = PolygonLight::new((0..sides).map(vertex).collect()).unwrap();
    for n in normals() {
        let (found, expected) = (polygon.irradiance(ORIGIN, n), disc.irradiance(ORIGIN, n));
        assert!((found - expected).abs() < 1e-5, "facing {n:?}: {found} against {expected}");
    }
}

#[test]
fn small_polygons_keep_their_digits() {
    for size in [1e-2, 1e-4, 1e-6] {
        let light = PolygonLight::rectangle([0.0, 0.0, 1.0], [size, 0.0, 0.0], [0.0, -size, 0.0]).unwrap();
        let (found, expected) = (light.irradiance(ORIGIN, Dir::Z), 4.0 * size * size * (1.0 - 4.0 / 3.0 * size * size));
        let limit = 2.0 * size.powi(4) + 4e-16 / size;
        assert!((found / expected - 1.0).abs() < limit, "{size}: {found} against {expected}");
    }
}

#[test]
fn lights_seen_from_behind_edge_on_or_from_inside_are_dark() {
    let disc = DiscLight { center: ORIGIN, normal: Dir::Z, radius: 1.0 };
    let square = PolygonLight::rectangle(ORIGIN, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]).unwrap();
    let sphere = SphereLight { center: ORIGIN, radius: 1.0 };
    let flat: [&dyn AreaLight; 2] = [&disc, &square];
    for n in normals() {
        for light in flat {
            for (point, place) in
                [([0.1, 0.2, -0.5], "behind"), ([3.0, 0.0, 0.0], "edge-on"), ([0.2, 0.0, 0.0], "on it")]
            {
                let e = light.irradiance(point, n);
                assert!(e == 0.0 && light.vector_irradiance(point).magnitude(0) == 0.0, "{place}: {e}");
            }
        }
        assert_eq!(sphere.irradiance([0.1, 0.2, 0.3], n), 0.0, "inside the sphere");
        assert_eq!(sphere.irradiance(ORIGIN, n), 0.0, "at the center of the sphere");
    }
    assert!((disc.irradiance([0.2, 0.0, 1e-9], -Dir::Z) - PI).abs() < 1e-7, "just in front of the disc");
}

#[test]
fn lights_without_area_give_nothing() {
    let line = PolygonLight::new(vec![[-1.0, 0.0, 1.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0]]).unwrap();
    let disc = DiscLight { center: [0.0, 0.0, 1.0], normal: -Dir::Z, radius: 0.0 };
    let sphere = SphereLight { center: [0.0, 0.0, 1.0], radius: 0.0 };
    let lights: [&dyn AreaLight; 3] = [&line, &disc, &sphere];
    for light in lights {
        assert_eq!(light.irradiance(ORIGIN, Dir::Z), 0.0, "irradiance");
        assert_eq!(light.vector_irradiance(ORIGIN).magnitude(0), 0.0, "vector");
        assert_eq!(light.as_point().irradiance(ORIGIN, Dir::Z), 0.0, "as a point");
    }
}

#[test]
fn polygons_of_too_few_or_infinite_vertices_are_refused() {
    for vertices in [vec![], vec![ORIGIN, [1.0, 0.0, 0.0]], vec![ORIGIN, [1.0, 0.0, 0.0], [f64::NAN, 0.0, 1.0]]] {
        let found = PolygonLight::new(vertices.clone());
        assert!(matches!(found, Err(EnvError::Options(_))), "{vertices:?}: {found:?}");
    }
}

#[test]
fn far_lights_are_points_within_their_squared_size() {
    for ratio in [0.5, 0.2, 0.1, 0.05, 0.01] {
        let d = 1.0 / ratio;
        let disc = DiscLight { center: [0.0, 0.0, d], normal: -Dir::Z, radius: 1.0 };
        let error = compare_approximations(&disc, ORIGIN, ORIGIN, Dir::Z).point_error();
        assert!((error / (ratio * ratio) - 1.0).abs() < 1e-9, "disc at {d} radii: {error}");

        let square = PolygonLight::rectangle([0.0, 0.0, d], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]).unwrap();
        let error = compare_approximations(&square, ORIGIN, ORIGIN, Dir::Z).point_error();
        let law = 4.0 / 3.0 * ratio * ratio;
        assert!((error - law).abs() < law * ratio * ratio, "square at {d} half sides: {error} against {law}");

        let sphere = SphereLight { center: [0.0, 0.0, d], radius: 1.0 };
        for n in [Dir::Z, Dir::from_angles(0.9, 0.3)] {
            let error = compare_approximations(&sphere, ORIGIN, ORIGIN, n).point_error();
            assert!(error.abs() < 1e-14, "sphere at {d} radii facing {n:?}: {error}");
        }
        let cut = compare_approximations(&sphere, ORIGIN, ORIGIN, Dir::X);
        assert!(cut.point == 0.0 && cut.exact > 0.0, "the horizon cuts the sphere in half: {cut:?}");
    }
}

#[test]
fn a_beam_is_exact_where_it_was_made_and_its_error_grows_with_the_offset() {
    let d = 10.0;
    let disc = DiscLight { center: [0.0, 0.0, d], normal: -Dir::Z, radius: 1.0 };
    let at = |point: [f64; 3]| compare_approximations(&disc, ORIGIN, point, Dir::Z);
    assert!(at(ORIGIN).directional_error().abs() < 1e-15, "{:?}", at(ORIGIN));
    for offset in [0.1, 0.5, 1.0] {
        let error = at([0.0, 0.0, -offset]).directional_error();
        let law = ((d + offset).powi(2) + 1.0) / (d * d + 1.0) - 1.0;
        assert!((error - law).abs() < 1e-13, "{offset} further away: {error} against {law}");
    }
    let aside = ParallelBeam::of(&disc, [1.0, 0.0, 0.0]).unwrap();
    let turned = aside.direction.angle_to(Dir::Z);
    assert!((turned / 0.1_f64.atan() - 1.0).abs() < 0.02, "the direction one unit to the side: {turned}");
    assert_eq!(ParallelBeam::of(&disc, [0.0, 0.0, 11.0]), None, "behind the disc");
}
