//! Irradiance by brute force and by spherical harmonics.
use std::f64::consts::PI;
use std::ops::ControlFlow;

use lobe_env::{
    EnvError, EnvMap, bundled, irradiance_at, irradiance_map, irradiance_map_brute_force, irradiance_sh, lat_long,
};
use lobe_io::{Job, Progress};
use lobe_sh::{Coefficient, Dir, Expansion, Rgb};
use lobe_testkit::directions;

fn normals() -> Vec<Dir> {
    directions().into_iter().map(|v| Dir::new(v).unwrap()).collect()
}

#[test]
fn brute_force_irradiance_of_a_constant_sky_is_pi() {
    // Sums of a row in f32 lose 1e-6; the nodes in the texels that the horizon cuts leave less but for few rows.
    for (w, h, limit) in
        [(8, 4, 2e-3), (32, 16, 5e-5), (33, 17, 5e-5), (64, 32, 1e-5), (512, 256, 2e-6), (511, 255, 2e-6)]
    {
        let map = EnvMap::from_fn(w, h, |_| Rgb::new(1.0, 2.0, 0.5));
        let mut worst = 0.0_f64;
        for (n, e) in normals().iter().zip(irradiance_at(&map, &normals())) {
            worst = worst.max((e.r / PI - 1.0).abs());
            assert!((e.r / PI - 1.0).abs() < limit, "{w} x {h} facing {n:?}: {e:?}");
            assert!((e.g / e.r - 2.0).abs() < 1e-6, "{w} x {h} facing {n:?}: {e:?}");
        }
        println!("{w} x {h}: off by {worst:.1e}");
    }
}

#[test]
fn few_columns_see_a_constant_sky_too() {
    // As exact as eight columns: the same map in finer ones.
    for (w, h, limit) in [(1, 64, 5e-5), (2, 64, 5e-5), (7, 64, 5e-5), (2, 1, 1.5e-2), (1, 1, 1.5e-2)] {
        let map = EnvMap::from_fn(w, h, |_| Rgb::splat(1.0));
        for (n, e) in normals().iter().zip(irradiance_at(&map, &normals())) {
            assert!((e.g / PI - 1.0).abs() < limit, "{w} x {h} facing {n:?}: {e:?}");
        }
    }
}

#[test]
fn long_rows_lose_no_digits() {
    // No texel is cut by the horizon of a normal that points up or down, so nothing but rounding is left.
    let (w, h) = (16384, 16);
    for radiance in [0.1_f32, 0.7, 3.3] {
        let map = EnvMap::from_fn(w, h, |_| Rgb::new(radiance, radiance, radiance));
        for (n, e) in [Dir::Z, -Dir::Z].iter().zip(irradiance_at(&map, &[Dir::Z, -Dir::Z])) {
            let error = e.g / (PI * f64::from(radiance)) - 1.0;
            assert!(error.abs() < 1e-6, "radiance {radiance} facing {n:?}: off by {error:e}");
        }
    }
}

#[test]
fn a_sun_of_one_texel_gives_its_solid_angle_times_the_cosine() {
    let (w, h) = (512, 256);
    for (x, y) in [(0, 0), (511, 100), (256, 127), (77, 255)] {
        let mut map = EnvMap::from_fn(w, h, |_| Rgb::ZERO);
        map.texels_mut()[y * w + x] = Rgb::new(1000.0, 0.0, 0.0);
        let sun = map.dir(x, y);
        for (n, e) in normals().iter().zip(irradiance_at(&map, &normals())) {
            let expected = 1000.0 * lat_long::solid_angle(w, h, y) * n.dot(sun).max(0.0);
            // The mean direction of a texel is not quite its center.
            let limit = 1000.0 * lat_long::solid_angle(w, h, y) * 0.01;
            assert!((e.r - expected).abs() < limit, "sun at ({x}, {y}), facing {n:?}: {} against {expected}", e.r);
        }
    }
}

#[test]
fn both_routes_agree_where_the_order_suffices() {
    // Radiance of order 3: its irradiance of order 3 is exact, and only the texels differ.
    let map = EnvMap::from_fn(256, 128, |s| {
        let (x, y, z) = (s.x(), s.y(), s.z());
        Rgb::from([2.0 + x, 2.0 + y * z, 2.0 + z * z - x * y].map(|c| c as f32))
    });
    let sh = irradiance_sh(&map, 3);
    for (n, e) in normals().iter().zip(irradiance_at(&map, &normals())) {
        let expected = sh.eval(*n);
        let error = (e - expected).to_array().map(f64::abs);
        assert!(error.iter().all(|d| *d < 1e-3), "facing {n:?}: {e:?} against {expected:?}");
    }
}

#[test]
fn brute_force_agrees_with_a_high_order_of_the_same_texels() {
    // The texels of a coarse map differ from their neighbors by much, so that a cut one counts. The factors of the
    // cosine fall as l^-5/2 and the coefficients of a map of steps fall too: order 48 leaves little.
    let map = EnvMap::from_fn(32, 16, |s| {
        let c = 2.0 + (3.0 * s.x()).sin() + (4.0 * s.y() * s.z()).cos();
        Rgb::new(c as f32, (c * c) as f32, 1.0 + s.z().max(0.0) as f32)
    });
    let sh = irradiance_sh(&map, 48);
    let mut worst = 0.0_f64;
    for (n, e) in normals().iter().zip(irradiance_at(&map, &normals())) {
        let expected = sh.eval(*n);
        let error = (e - expected).to_array().into_iter().zip(expected.to_array()).map(|(d, e)| (d / e).abs());
        worst = error.fold(worst, f64::max);
    }
    println!("off by {worst:.1e}");
    assert!(worst < 3e-5, "off by {worst:.1e}");
}

#[test]
fn irradiance_pictures_of_a_real_map_agree_within_the_error_of_order_3() {
    for bundled in bundled::all() {
        let map = bundled.map();
        let slow = irradiance_map_brute_force(&map, 32, 16, Job::default()).unwrap();
        let fast = irradiance_map(&map, 3, 32, 16).unwrap();
        let brightest = slow.texels().iter().map(|t| t.luminance()).fold(0.0, f32::max);
        for (i, (a, b)) in slow.texels().iter().zip(fast.texels()).enumerate() {
            // The cosine kernel of order 3 is off by at most 3/32 of its height at one place.
            let error = (a.luminance() - b.luminance()).abs() / brightest;
            assert!(error < 0.1, "{} at {i}: {a:?} against {b:?}", bundled.name);
        }
    }
}

#[test]
fn the_irradiance_has_the_same_bits_for_any_number_of_threads() {
    let map = bundled::studio().map();
    let bits = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let e = pool.install(|| irradiance_at(&map, &normals()));
        e.iter().flat_map(|c| c.to_array()).map(f64::to_bits).collect::<Vec<_>>()
    };
    assert!(bits(1) == bits(5), "5 threads differ from one");
}

#[test]
fn irradiance_is_linear_in_the_light() {
    let map = bundled::sunset().map();
    let mut twice = map.clone();
    twice.texels_mut().iter_mut().for_each(|t| *t = t.scale(2.0));
    let n = normals();
    for (a, b) in irradiance_at(&map, &n).iter().zip(irradiance_at(&twice, &n)) {
        assert!((b.r - 2.0 * a.r).abs() <= 1e-12 * a.r.abs(), "{a:?} and {b:?}");
    }
}

#[test]
fn brute_force_reports_its_progress_and_stops_when_told() {
    let map = bundled::sunset().map();
    let mut seen = Vec::new();
    let mut watch = |progress: &Progress| {
        seen.push((progress.done, progress.total));
        if seen.len() < 3 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    };
    let stopped = irradiance_map_brute_force(&map, 128, 64, Job::default().watched_by(&mut watch));
    assert!(matches!(stopped, Err(EnvError::Cancelled)), "told to stop");
    assert_eq!(seen, [(0, 8192), (1024, 8192), (2048, 8192)], "texels that were done");
    let refused = irradiance_map_brute_force(&map, 0, 64, Job::default());
    assert!(matches!(refused, Err(EnvError::Options(_))), "no texels");
}

#[test]
fn irradiance_beyond_the_largest_number_is_refused() {
    // π times 3e38 is no number of single precision; π times 1e38 is.
    let sky = |radiance: f32| EnvMap::from_fn(8, 4, |_| Rgb::new(1.0, radiance, 1.0));
    let is_finite = |found: Result<EnvMap, EnvError>| match found {
        Ok(map) => Ok(map.texels().iter().all(|t| t.g.is_finite())),
        Err(EnvError::Options(message)) => Err(message),
        Err(error) => panic!("{error}"),
    };
    let both = |map: &EnvMap| {
        let brute_force = irradiance_map_brute_force(map, 16, 8, Job::default());
        [irradiance_map(map, 3, 16, 8), brute_force].map(is_finite)
    };
    for refused in both(&sky(3e38)) {
        let message = refused.expect_err("not even as infinity");
        assert!(message.contains("the irradiance") && message.contains("128 texels"), "{message}");
    }
    assert_eq!(both(&sky(1e38)), [Ok(true), Ok(true)], "as bright as it can be");
    // Light that is infinite has an infinite irradiance.
    assert!(both(&sky(f32::INFINITY)).iter().all(Result::is_ok), "infinite before");
    for (width, height) in [(0, 8), (16, 0)] {
        let refused = irradiance_map(&sky(1.0), 3, width, height);
        assert!(matches!(refused, Err(EnvError::Options(_))), "{width} x {height}: no texels");
    }
}
