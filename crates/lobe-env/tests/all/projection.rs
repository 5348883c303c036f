//! Projection against slow references, closed forms and known expansions.

use std::f64::consts::PI;

use lobe_env::{EnvMap, irradiance_sh, lat_long, project_env, reconstruct};
use lobe_sh::basis::{Basis, coefficient_count};
use lobe_sh::sphere::gauss_legendre;
use lobe_sh::{Coefficient, Dir, Expansion, Rgb, ShVec};
use lobe_testkit::{Random, directions};

/// The tolerance relative to the largest coefficient: both sides are exact up to the rounding of sums over all texels.
const ROUNDING: f64 = 1e-12;

/// `Σ_texels L ∫_texel y_i ds` of maps of one size, by a double loop with `nodes²` Gauss nodes in every texel.
fn slow_projections(maps: &[&EnvMap], order: usize, nodes: usize) -> Vec<ShVec<Rgb<f64>>> {
    let rule = gauss_legendre(nodes);
    let basis = Basis::<f64>::new(order);
    let (width, height) = (maps[0].width(), maps[0].height());
    let (w, h) = (width as f64, height as f64);
    let mut sums = vec![ShVec::zero(order); maps.len()];
    let mut y_i = vec![0.0; coefficient_count(order)];
    for y in 0..height {
        for x in 0..width {
            let mut texel_integral = vec![0.0; coefficient_count(order)];
            for &(t, weight_t) in &rule {
                let v = (y as f64 + 0.5 + 0.5 * t) / h;
                for &(p, weight_p) in &rule {
                    let u = (x as f64 + 0.5 + 0.5 * p) / w;
                    basis.eval_into(lat_long::dir_from_uv(u, v).to_array(), &mut y_i);
                    let weight = weight_t * weight_p * (PI / (2.0 * h)) * (PI / w) * (PI * v).sin();
                    for (sum, value) in texel_integral.iter_mut().zip(&y_i) {
                        *sum += weight * value;
                    }
                }
            }
            for (map, f) in maps.iter().zip(&mut sums) {
                let texel = map.texel(x, y).widen();
                for (f, integral) in f.coefficients_mut().iter_mut().zip(&texel_integral) {
                    *f += texel.scale(*integral);
                }
            }
        }
    }
    sums
}

fn slow_projection(map: &EnvMap, order: usize, nodes: usize) -> ShVec<Rgb<f64>> {
    slow_projections(&[map], order, nodes).remove(0)
}

fn largest(f: &ShVec<Rgb<f64>>) -> f64 {
    f.coefficients().iter().flat_map(|c| c.to_array()).fold(0.0, |a, c| c.abs().max(a))
}

fn difference(a: &ShVec<Rgb<f64>>, b: &ShVec<Rgb<f64>>) -> f64 {
    largest(&(a - b))
}

fn random_map(width: usize, height: usize, seed: u64) -> EnvMap {
    let mut random = Random::new(seed);
    let texels = (0..width * height).map(|_| Rgb::from([(); 3].map(|()| random.unit() as f32))).collect();
    EnvMap::new(width, height, texels).unwrap()
}

#[test]
fn real_maps_project_as_the_double_loop_does() {
    let maps = crate::common::real_maps();
    // Maps of one size share the integrals of the basis over their texels.
    for same_size in maps.chunk_by(|(_, a), (_, b)| (a.width(), a.height()) == (b.width(), b.height())) {
        let pictures: Vec<&EnvMap> = same_size.iter().map(|(_, map)| map).collect();
        // Three nodes leave 2e-13 of a wave of order 6 across a texel of 512 x 256.
        for ((name, map), slow) in same_size.iter().zip(slow_projections(&pictures, 6, 3)) {
            let error = difference(&project_env(map, 6), &slow) / largest(&slow);
            println!("{name}: {error:e} of the largest coefficient");
            assert!(error < ROUNDING, "{name}: {error:e} of the largest coefficient");
        }
    }
}

#[test]
fn maps_of_any_size_project_as_the_double_loop_does() {
    for (w, h) in [(1, 1), (2, 1), (1, 2), (3, 2), (4, 2), (5, 3), (6, 3), (7, 4), (8, 4), (36, 17), (10, 20)] {
        for order in [1, 2, 3, 6, 13] {
            let map = random_map(w, h, 5);
            let nodes = if w * h < 50 { 60 } else { 16 };
            let (fast, slow) = (project_env(&map, order), slow_projection(&map, order, nodes));
            let error = difference(&fast, &slow) / largest(&slow);
            assert!(error < ROUNDING, "{w} x {h} at order {order}: {error:e} of the largest coefficient");
        }
    }
}

#[test]
fn orders_of_64_and_beyond_project_as_the_double_loop_does() {
    for (w, h, order, nodes) in [(8, 4, 64, 44), (6, 3, 70, 60)] {
        let map = random_map(w, h, 9);
        let (fast, slow) = (project_env(&map, order), slow_projection(&map, order, nodes));
        let error = difference(&fast, &slow) / largest(&slow);
        assert!(error < ROUNDING, "{w} x {h} at order {order}: {error:e} of the largest coefficient");
    }
}

#[test]
fn a_constant_map_of_any_size_has_only_a_mean() {
    for (w, h) in [(1, 1), (2, 1), (3, 1), (3, 5), (7, 4), (64, 32), (511, 256), (1024, 512)] {
        let f = project_env(&EnvMap::from_fn(w, h, |_| Rgb::new(1.0, 0.5, 2.0)), 9);
        let dc = (4.0 * PI).sqrt();
        assert!((f[0].b - 2.0 * dc).abs() < ROUNDING, "{w} x {h}: {:?} against {dc}", f[0]);
        for i in 1..coefficient_count(9) {
            assert!(f[i].b.abs() < ROUNDING, "{w} x {h}, coefficient {i}: {:?}", f[i]);
        }
    }
}

#[test]
fn irradiance_of_a_constant_sky_is_pi() {
    for (w, h) in [(2, 1), (7, 3), (512, 256)] {
        let irradiance = irradiance_sh(&EnvMap::from_fn(w, h, |_| Rgb::new(1.0, 1.0, 1.0)), 6);
        for v in directions() {
            let e = irradiance.eval(Dir::new(v).unwrap()).g;
            assert!((e - PI).abs() < ROUNDING, "{w} x {h} facing {v:?}: {e}");
        }
    }
}

#[test]
fn a_sky_brighter_towards_an_axis_lights_the_side_that_faces_it() {
    type Component = fn(Dir) -> f64;
    let cases: [(&str, Component, Dir); 3] = [("x", Dir::x, Dir::X), ("y", Dir::y, Dir::Y), ("z", Dir::z, Dir::Z)];
    for (name, component, axis) in cases {
        let map = EnvMap::from_fn(256, 128, |s| Rgb::new(1.0 + component(s) as f32, 1.0, 1.0));
        let irradiance = irradiance_sh(&map, 3);
        for (facing, expected) in [(axis, PI + 2.0 * PI / 3.0), (-axis, PI - 2.0 * PI / 3.0)] {
            let e = irradiance.eval(facing).r;
            assert!((e - expected).abs() < 1e-3, "1 + {name} facing {facing:?}: {e} against {expected}");
        }
    }
}

/// The mean direction of a texel by quadrature, and its distance from the origin relative to the solid angle.
fn mean_direction(map: &EnvMap, x: usize, y: usize) -> Dir {
    let rule = gauss_legendre(24);
    let mut mean = [0.0; 3];
    for &(t, weight_t) in &rule {
        let v = (y as f64 + 0.5 + 0.5 * t) / map.height() as f64;
        for &(p, weight_p) in &rule {
            let u = (x as f64 + 0.5 + 0.5 * p) / map.width() as f64;
            let s = lat_long::dir_from_uv(u, v).to_array();
            for c in 0..3 {
                mean[c] += weight_t * weight_p * (PI * v).sin() * s[c];
            }
        }
    }
    Dir::new(mean).unwrap()
}

/// Checks one sun; returns whether its direction was compared with the center of the texel too.
fn check_sun(map: &mut EnvMap, x: usize, y: usize) -> bool {
    let (w, h) = (map.width(), map.height());
    let i = y * w + x;
    map.texels_mut()[i] = Rgb::new(1000.0, 10.0, 1.0);
    let f = project_env(map, 2);
    map.texels_mut()[i] = Rgb::ZERO;
    let energy = f[0].r * (4.0 * PI).sqrt();
    let expected = 1000.0 * lat_long::solid_angle(w, h, y);
    assert!((energy / expected - 1.0).abs() < ROUNDING, "{w} x {h} at ({x}, {y}): energy {energy}, not {expected}");
    let direction = Dir::new([-f[3].r, -f[1].r, f[2].r]).unwrap();
    let angle = direction.angle_to(mean_direction(map, x, y));
    assert!(angle < 1e-9, "{w} x {h} at ({x}, {y}): {angle} rad from the mean direction");
    // By area the mean of a texel lies off its center, away from the pole by Δθ²/12 cot θ, and its arc bends inwards
    // by Δφ²/24 sin θ cos θ: more than 1e-4 rad only in the rows next to a pole, or where texels are large.
    let (sin, cos) = (PI * (y as f64 + 0.5) / h as f64).sin_cos();
    let off = (PI / h as f64).powi(2) / 12.0 * cos.abs() / sin + (2.0 * PI / w as f64).powi(2) / 24.0 * sin * cos.abs();
    let angle = direction.angle_to(map.dir(x, y));
    let near = off < 0.9e-4;
    assert!(!near || angle < 1e-4, "{w} x {h} at ({x}, {y}): {angle} rad from the center");
    near
}

#[test]
fn a_sun_of_one_texel_keeps_its_energy_and_its_direction() {
    for (w, h) in [(4, 2), (7, 5), (16, 8), (34, 17)] {
        let mut map = EnvMap::from_fn(w, h, |_| Rgb::ZERO);
        for y in 0..h {
            for x in 0..w {
                check_sun(&mut map, x, y);
            }
        }
    }
    let (w, h) = (512, 256);
    let mut map = EnvMap::from_fn(w, h, |_| Rgb::ZERO);
    let mut near = 0;
    for y in 0..h {
        near += usize::from([0, (37 * y + 100) % w, w - 1].map(|x| check_sun(&mut map, x, y)) == [true; 3]);
    }
    assert!(
        near > 230,
        "in {near} of 256 rows the direction was compared with the center; all but the polar ones expected"
    );
}

#[test]
fn a_band_limited_map_has_its_coefficients_up_to_the_squared_texel_size() {
    let order = 5;
    let mut random = Random::new(11);
    let planted: Vec<_> = (0..coefficient_count(order)).map(|_| Rgb::from([(); 3].map(|()| random.signed()))).collect();
    let planted = ShVec::from_vec(planted).unwrap();
    let mut errors = Vec::new();
    for h in [32, 64, 128] {
        let error = difference(&project_env(&reconstruct(&planted, 2 * h, h), order), &planted);
        // Sampling at centers against averaging over texels: Δ²/24 times the Laplacian, l (l + 1) <= 20.
        let limit = 2.0 * 20.0 / 24.0 * (PI / h as f64).powi(2) * largest(&planted);
        assert!(error < limit, "{h} rows: {error:e} against {limit:e}");
        errors.push(error);
    }
    assert!(errors[0] / errors[2] > 12.0, "halving the texels must quarter the error: {errors:?}");
}

#[test]
fn the_projection_has_the_same_bits_for_any_number_of_threads() {
    let map = random_map(300, 333, 1);
    let bits = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let f = pool.install(|| project_env(&map, 11));
        f.coefficients().iter().flat_map(|c| c.to_array()).map(f64::to_bits).collect::<Vec<_>>()
    };
    let one = bits(1);
    for threads in [2, 5] {
        assert!(one == bits(threads), "{threads} threads differ from one");
    }
}

#[test]
fn order_zero_has_no_coefficients() {
    let map = random_map(4, 2, 1);
    assert_eq!(project_env(&map, 0).coefficients().len(), 0, "order 0");
    assert_eq!(reconstruct(&project_env(&map, 0), 4, 2).texel(1, 1), Rgb::ZERO, "the picture of nothing");
}
