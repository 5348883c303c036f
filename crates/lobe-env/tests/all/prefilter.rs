//! Prefiltering: white furnace, linearity, seams, and comparison with brute force.

use std::f64::consts::TAU;
use std::ops::ControlFlow;

use lobe_env::{
    Brdf, CubeMap, EnvError, Ggx, PrefilterOptions, RoughnessLevels, SpecularLobe, bundled, cube, dfg, filter_lobe,
    filter_lobe_lat_long, filter_zonal, prefilter_ggx,
};
use lobe_io::{Job, Progress};
use lobe_sh::sphere::gauss_legendre;
use lobe_sh::sphere::vector::tangents_along_axis;
use lobe_sh::{Coefficient, Dir, Rgb};
use lobe_testkit::Random;

/// The default of the options.
const TOLERANCE: f64 = 0.02;

/// The largest error relative to the brightest texel. Peers at 1024 samples with a real sun: 0.08 to 0.13.
const OF_THE_PEAK: f64 = 3e-3;

/// The same beside samples of the lobe, most of which miss a sun of one texel.
const BESIDE_SAMPLES: f64 = 0.04;
const SAMPLES: usize = 1 << 20;

/// The largest error relative to a texel's own value, beside lamps 10⁵ times as bright; 2.1e-3 is measured.
const OF_DARK_TEXELS: f64 = 3e-3;

fn ggx(alpha: f64) -> SpecularLobe {
    SpecularLobe::Ggx { alpha }
}

fn options(size: usize, last_size: usize) -> PrefilterOptions {
    PrefilterOptions::default().size(size).last_size(last_size)
}

fn chain(source: &CubeMap, options: &PrefilterOptions) -> Vec<CubeMap> {
    prefilter_ggx(source, options, Job::default()).unwrap().levels().to_vec()
}

fn noise(size: usize, seed: u64) -> CubeMap {
    let mut random = Random::new(seed);
    let mut value = || random.unit().powi(8) as f32 * 100.0;
    CubeMap::new(size, (0..6 * size * size).map(|_| Rgb::new(value(), value(), value())).collect()).unwrap()
}

/// A smooth sky with a sun of one texel, 1e5 times as bright.
fn one_texel_sun(size: usize) -> CubeMap {
    let mut map = CubeMap::from_fn(size, |s| Rgb::splat(1.0 + 0.3 * s.z() as f32));
    map.texels_mut()[(size + size / 6) * size + size / 3] = Rgb::splat(1e5);
    map
}

/// The texels of a map as points: `points²` each, with the texel's light and the solid angle.
fn brute_force_points(source: &CubeMap, points: usize) -> Vec<(Dir, f64, f64)> {
    let size = source.size();
    let rule = gauss_legendre(points);
    let at = |i: usize, t: f64| (i as f64 + 0.5 + 0.5 * t) / size as f64;
    let mut out = Vec::new();
    for (i, texel) in source.texels().iter().enumerate() {
        let (face, x, y) = (i / (size * size), i % size, i / size % size);
        for (a, p) in &rule {
            for (b, q) in &rule {
                let (s, t) = (at(x, *a), at(y, *b));
                let r2 = 1.0 + (2.0 * s - 1.0).powi(2) + (2.0 * t - 1.0).powi(2);
                out.push((cube::dir_from_face(face, s, t), p * q / (r2 * r2.sqrt()), f64::from(texel.g)));
            }
        }
    }
    out
}

fn brute_force(points: &[(Dir, f64, f64)], r: Dir, weight: impl Fn(Dir) -> f64) -> f64 {
    let (mut sum, mut weights) = (0.0, 0.0);
    for (s, area, light) in points {
        if s.dot(r) > -0.1 {
            let w = area * weight(*s);
            (sum, weights) = (sum + w * light, weights + w);
        }
    }
    sum / weights
}

/// The average about `r` by samples of a GGX lobe, a witness that shares nothing with the quadrature: half vectors drawn with
/// the density `D(h) (r·h)`, the light in the mirrored direction weighted by `r·l` ([Karis 2013]).
///
/// [Karis 2013]: https://blog.selfshadow.com/publications/s2013-shading-course/karis/s2013_pbs_epic_notes_v2.pdf
fn by_importance(source: &CubeMap, alpha: f64, r: Dir) -> f64 {
    const GOLDEN_RATIO: f64 = 1.618_033_988_749_895;
    let (size, n) = (source.size(), r.to_array());
    let [u, v] = tangents_along_axis(n);
    let texel = |c: f64| ((c * size as f64) as usize).min(size - 1);
    let (mut sum, mut weights) = (0.0, 0.0);
    for i in 0..SAMPLES {
        let share = (i as f64 + 0.5) / SAMPLES as f64;
        let cos = ((1.0 - share) / (1.0 - share * (1.0 - alpha * alpha))).sqrt();
        let (aside, along) = (2.0 * cos * (1.0 - cos * cos).max(0.0).sqrt(), 2.0 * cos * cos - 1.0);
        let (sin_phi, cos_phi) = (TAU * GOLDEN_RATIO * i as f64).sin_cos();
        let l = Dir::from_unit([0, 1, 2].map(|k| aside * (cos_phi * u[k] + sin_phi * v[k]) + along * n[k]));
        let (face, s, t) = cube::face_from_dir(l);
        let weight = along.max(0.0);
        (sum, weights) = (sum + weight * f64::from(source.texel(face, texel(s), texel(t)).g), weights + weight);
    }
    sum / weights
}

/// The largest error over some texels, the brightest and its neighbors among them, relative to the brightest.
fn error_of_peak(found: &CubeMap, truth: impl Fn(Dir) -> f64) -> f64 {
    let size = found.size();
    let texels = found.texels();
    let best = (0..texels.len()).max_by(|a, b| texels[*a].g.total_cmp(&texels[*b].g)).unwrap();
    let picks =
        [best, best + 1, best + size, best.saturating_sub(2), 7, 5 * size * size + size / 2, 3 * size * size - 1];
    let error = |i: usize| {
        let r = found.dir(i / (size * size), i % size, i / size % size);
        (f64::from(texels[i].g) - truth(r)).abs()
    };
    picks.iter().map(|i| error(i % texels.len())).fold(0.0, f64::max) / f64::from(texels[best].g)
}

#[test]
fn the_white_furnace_is_exactly_one() {
    for size in [32, 21] {
        let white = CubeMap::from_fn(size, |_| Rgb::splat(1.0));
        for (k, level) in chain(&white, &options(16, 2)).iter().enumerate() {
            assert!(level.texels().iter().all(|t| *t == Rgb::splat(1.0)), "{size}, level {k}");
        }
        for lobe in [SpecularLobe::Phong { exponent: 40.0 }, SpecularLobe::BlinnPhong { exponent: 900.0 }] {
            let map = filter_lobe(&white, lobe, 8, TOLERANCE, Job::default()).unwrap();
            assert!(map.texels().iter().all(|t| *t == Rgb::splat(1.0)), "{size}, {lobe:?}");
        }
    }
}

#[test]
fn filtered_maps_against_brute_force_and_samples() {
    let cube = |map: &lobe_env::EnvMap| CubeMap::from_fn(256, |s| map.radiance(s));
    let mut maps: Vec<_> = bundled::all().iter().map(|b| (b.name, cube(&b.map()), 1)).collect();
    maps.push(("a sun of one texel", one_texel_sun(64), 3));
    for (name, source, per_texel) in maps {
        let points = brute_force_points(&source, per_texel);
        for alpha in [0.0625, 0.25, 0.5625, 1.0] {
            let lobe = ggx(alpha);
            let found = filter_lobe(&source, lobe, 16, TOLERANCE, Job::default()).unwrap();
            let by_points = error_of_peak(&found, |r| brute_force(&points, r, |s| lobe.value(s.dot(r))));
            let by_samples = error_of_peak(&found, |r| by_importance(&source, alpha, r));
            println!("{name}, α = {alpha}: of the peak, {by_points:.1e} by points, {by_samples:.1e} by samples");
            assert!(by_points < OF_THE_PEAK, "{name}, α = {alpha}: {by_points} of the peak from points");
            assert!(by_samples < BESIDE_SAMPLES, "{name}, α = {alpha}: {by_samples} of the peak from samples");
        }
    }
}

#[test]
fn lamps_do_not_spoil_the_dark() {
    // Half of the studio is less than a hundred-thousandth as bright as its lamps. Relative to the peak, an error as
    // large as the light in dark texels would vanish.
    let studio = bundled::studio().map();
    let mut lamp = CubeMap::from_fn(128, |s| Rgb::splat(0.01 + 0.005 * s.x() as f32));
    for (x, y) in (40..60).flat_map(|x| (70..90).map(move |y| (x, y))) {
        lamp.texels_mut()[y * 128 + x] = Rgb::splat(5000.0);
    }
    for (name, source) in [("the studio", CubeMap::from_fn(128, |s| studio.radiance(s))), ("a lamp", lamp)] {
        let points = brute_force_points(&source, 4);
        for alpha in [0.0625, 0.25, 0.5625] {
            let lobe = ggx(alpha);
            let found = filter_lobe(&source, lobe, 16, TOLERANCE, Job::default()).unwrap();
            let mut order: Vec<usize> = (0..found.texels().len()).collect();
            order.sort_by(|a, b| found.texels()[*a].g.total_cmp(&found.texels()[*b].g));
            // The darkest, and some of all others.
            let picks: Vec<usize> = order.iter().take(12).chain(order.iter().step_by(97)).copied().collect();
            let error = |i: usize| {
                let r = found.dir(i / 256, i % 16, i / 16 % 16);
                let expected = brute_force(&points, r, |s| lobe.value(s.dot(r)));
                (f64::from(found.texels()[i].g) / expected - 1.0).abs()
            };
            let worst = picks.iter().map(|i| error(*i)).fold(0.0, f64::max);
            println!("{name}, α = {alpha}: {worst:.1e} of a texel's own value");
            assert!(worst < OF_DARK_TEXELS, "{name}, α = {alpha}: {worst} of a texel's own value");
        }
    }
}

#[test]
fn highlight_maps_against_brute_force() {
    let source = one_texel_sun(64);
    let points = brute_force_points(&source, 4);
    let lobes = [
        SpecularLobe::Phong { exponent: 1.0 },
        SpecularLobe::Phong { exponent: 12.5 },
        SpecularLobe::Phong { exponent: 400.0 },
        SpecularLobe::BlinnPhong { exponent: 60.0 },
        ggx(0.02),
    ];
    for lobe in lobes {
        let found = filter_lobe(&source, lobe, 32, TOLERANCE, Job::default()).unwrap();
        let error = error_of_peak(&found, |r| brute_force(&points, r, |s| lobe.value(s.dot(r))));
        println!("{lobe:?}: {error:.1e} of the peak");
        assert!(error < OF_THE_PEAK, "{lobe:?}: {error} of the peak");
    }
    let kernel = |cos: f64| (30.0 * (cos - 1.0)).exp();
    let found = filter_zonal(&source, 16, 1e-3, kernel, Job::default()).unwrap();
    let error = error_of_peak(&found, |r| brute_force(&points, r, |s| kernel(s.dot(r))));
    assert!(error < 1e-3, "a spherical Gaussian: {error} of the peak");
}

#[test]
fn a_smaller_tolerance_has_a_smaller_error() {
    let source = one_texel_sun(64);
    let points = brute_force_points(&source, 3);
    for tolerance in [1e-2, 1e-3] {
        let lobe = ggx(0.25);
        let found = filter_lobe(&source, lobe, 16, tolerance, Job::default()).unwrap();
        let error = error_of_peak(&found, |r| brute_force(&points, r, |s| lobe.value(s.dot(r))));
        println!("tolerance {tolerance}: {error:.1e} of the peak");
        assert!(error < tolerance, "tolerance {tolerance}: {error} of the peak");
    }
}

#[test]
fn filtering_is_linear_in_the_source() {
    let (a, b) = (noise(24, 1), noise(24, 2));
    let both = a.texels().iter().zip(b.texels()).map(|(a, b)| a.scale(2.0) + b.scale(-0.5)).collect();
    let both = CubeMap::new(24, both).unwrap();
    let [a, b, both] = [&a, &b, &both].map(|map| filter_lobe(map, ggx(0.2), 8, TOLERANCE, Job::default()).unwrap());
    for ((a, b), both) in a.texels().iter().zip(b.texels()).zip(both.texels()) {
        let expected = 2.0 * a.g - 0.5 * b.g;
        assert!((both.g - expected).abs() < 1e-5 * (2.0 * a.g + 0.5 * b.g), "{} and {expected}", both.g);
    }
}

#[test]
fn the_chain_has_the_same_bits_for_any_number_of_threads() {
    let source = noise(32, 3);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| chain(&source, &options(32, 4)))
    };
    assert!(run(1) == run(3), "one thread and three differ");
}

#[test]
fn no_seam_shows_where_faces_meet() {
    let size = 32;
    let map = filter_lobe(&noise(32, 4), ggx(0.25), size, TOLERANCE, Job::default()).unwrap();
    let (mut inside, mut across) = (0.0_f32, 0.0_f32);
    for face in 0..6 {
        for k in 0..size {
            for i in 1..size {
                inside = inside.max((map.texel(face, i, k).g - map.texel(face, i - 1, k).g).abs());
            }
            let t = (k as f64 + 0.5) / size as f64;
            let beyond = -0.5 / size as f64;
            for (s, t, own) in [(beyond, t, (0, k)), (t, beyond, (k, 0))] {
                let (other, s, t) = cube::face_from_dir(cube::dir_from_face(face, s, t));
                let at = |c: f64| ((c * size as f64) as usize).min(size - 1);
                across = across.max((map.texel(face, own.0, own.1).g - map.texel(other, at(s), at(t)).g).abs());
            }
        }
    }
    assert!(across < 1.3 * inside, "a step of {across} between faces, {inside} inside");
}

/// The light that a GGX mirror with normal `n` reflects towards `v`, by brute force.
fn reflected(points: &[(Dir, f64, f64)], brdf: &Ggx, n: Dir, v: Dir) -> f64 {
    let turn = |s: Dir| {
        // A frame about n with v in its plane y = 0.
        let cos = n.dot(v);
        let x: [f64; 3] = std::array::from_fn(|k| v.to_array()[k] - cos * n.to_array()[k]);
        let Some(x) = Dir::new(x) else { panic!("v and n are one direction") };
        let y = [n.y() * x.z() - n.z() * x.y(), n.z() * x.x() - n.x() * x.z(), n.x() * x.y() - n.y() * x.x()];
        Dir::from_unit([s.dot(x), s.x() * y[0] + s.y() * y[1] + s.z() * y[2], s.dot(n)])
    };
    let v = turn(v);
    let (mut sum, mut total) = (0.0, 0.0);
    for (s, area, light) in points {
        let l = turn(*s);
        sum += area * light * brdf.eval(v, l) * l.z().max(0.0);
        total += area;
    }
    sum * 4.0 * std::f64::consts::PI / total
}

#[test]
fn the_split_sum_is_exact_in_even_light_and_near_it_elsewhere() {
    let sunset = bundled::sunset().map();
    let white = CubeMap::from_fn(64, |_| Rgb::splat(1.0));
    let real = CubeMap::from_fn(64, |s| sunset.radiance(s));
    for (alpha, tolerances) in [(0.25, [0.08, 0.2]), (0.5625, [0.12, 0.35])] {
        for (cos_v, tolerance) in [(0.95, tolerances[0]), (0.3, tolerances[1])] {
            let (n, v) = (Dir::Z, Dir::from_angles(f64::acos(cos_v), 0.7));
            let r = Dir::from_angles(f64::acos(cos_v), 0.7 + std::f64::consts::PI);
            let table = dfg(cos_v, alpha);
            let brdf = Ggx { alpha, f0: 0.5 };
            let factor = brdf.f0 * table.scale + table.bias;
            let split = |map: &CubeMap| {
                f64::from(filter_lobe(map, ggx(alpha), 64, TOLERANCE, Job::default()).unwrap().radiance(r).g) * factor
            };
            let truth = |map: &CubeMap| reflected(&brute_force_points(map, 1), &brdf, n, v);
            let even = split(&white) / truth(&white) - 1.0;
            let error = split(&real) / truth(&real) - 1.0;
            println!("α {alpha}, n·v {cos_v}: even light {even:.1e}, sunset {:.1} %", 100.0 * error);
            assert!(even.abs() < 2e-3, "α {alpha}, n·v {cos_v}: {even} in even light");
            assert!(error.abs() < tolerance, "α {alpha}, n·v {cos_v}: {error} in the sunset");
        }
    }
}

#[test]
fn level_zero_is_the_source_averaged_over_each_texel() {
    let source = noise(24, 5);
    let same = chain(&source, &options(24, 24));
    assert!(same.len() == 1 && same[0] == source, "the same size is the same map");
    for size in [12, 7] {
        let level = &chain(&source, &options(size, size))[0];
        let (found, expected) = (level.mean().g, source.mean().g);
        assert!((found / expected - 1.0).abs() < 1e-6, "24 to {size}: {found} against {expected}");
    }
    let narrow = filter_lobe(&source, SpecularLobe::Phong { exponent: 1e9 }, 24, TOLERANCE, Job::default()).unwrap();
    assert!(narrow == source, "a lobe far narrower than texels is a mirror");
}

#[test]
fn a_lat_long_highlight_map_shows_the_same() {
    let source = noise(16, 6);
    let lobe = SpecularLobe::Phong { exponent: 20.0 };
    let (cube, map) = (
        filter_lobe(&source, lobe, 64, 1e-4, Job::default()).unwrap(),
        filter_lobe_lat_long(&source, lobe, [16, 8], 1e-4, Job::default()).unwrap(),
    );
    for y in 0..8 {
        for x in 0..16 {
            let (found, expected) = (map.texel(x, y).g, cube.radiance(map.dir(x, y)).g);
            // The cube is interpolated between its texels.
            assert!((found / expected - 1.0).abs() < 2e-3, "({x}, {y}): {found} against {expected}");
        }
    }
}

#[test]
fn the_usual_levels_are_linear() {
    let options = PrefilterOptions::default();
    assert!((0..5).all(|k| options.alpha_of_level(k) == (k as f64 / 4.0).powi(2)), "α = (level/last)²");
}

#[test]
fn wrong_options_are_refused_and_the_work_can_be_stopped() {
    let source = noise(8, 7);
    let run = |options: &PrefilterOptions| prefilter_ggx(&source, options, Job::default());
    let bad = [
        options(0, 1),
        options(8, 16),
        options(8, 0),
        options(8, 2).tolerance(0.0),
        options(8, 2).roughness(RoughnessLevels::Babylon),
        options(32, 1).roughness(RoughnessLevels::Unity),
        options(8, 2).tolerance(f64::NAN),
        options(1 << 20, 2),
        options(usize::MAX, 2),
    ];
    for options in bad {
        assert!(matches!(run(&options), Err(EnvError::Options(_))), "{options:?} was taken");
    }
    for lobe in [ggx(1.5), ggx(f64::NAN), SpecularLobe::Phong { exponent: -1.0 }] {
        assert!(
            matches!(filter_lobe(&source, lobe, 8, TOLERANCE, Job::default()), Err(EnvError::Options(_))),
            "{lobe:?} was taken"
        );
    }
    assert!(
        matches!(filter_zonal(&source, 8, 1e-3, |_| 0.0, Job::default()), Err(EnvError::Options(_))),
        "a kernel of nothing"
    );
    for size in [0, 1 << 20, usize::MAX] {
        let phong = SpecularLobe::Phong { exponent: 5.0 };
        let cube = filter_lobe(&source, phong, size, TOLERANCE, Job::default()).map(|_| ());
        let picture = filter_lobe_lat_long(&source, phong, [size, size], 0.02, Job::default()).map(|_| ());
        assert!(matches!(cube, Err(EnvError::Options(_))), "a cube of {size}: {cube:?}");
        assert!(matches!(picture, Err(EnvError::Options(_))), "{size} x {size}: {picture:?}");
    }
    let mut heard = Vec::new();
    let mut watch = |progress: &Progress| {
        heard.push(progress.done as f64 / progress.total as f64);
        if heard.len() < 3 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    };
    let stopped = prefilter_ggx(&source, &options(8, 2), Job::default().watched_by(&mut watch));
    assert!(matches!(stopped, Err(EnvError::Cancelled)), "stopped: {stopped:?}");
    let kept = prefilter_ggx(&source, &options(8, 2), Job::default().kept_in("a.checkpoint"));
    assert!(matches!(kept, Err(EnvError::Options(_))), "a checkpoint: {kept:?}");
    assert!(heard.is_sorted() && heard.iter().all(|p| (0.0..=1.0).contains(p)), "parts done: {heard:?}");
}

#[test]
fn finite_light_is_refused_rather_than_filtered_to_infinite() {
    let sky = CubeMap::from_fn(8, |_| Rgb::splat(f32::MAX));
    for lobe in [SpecularLobe::Phong { exponent: 1.0 }, ggx(1.0), ggx(0.3)] {
        match filter_lobe(&sky, lobe, 4, TOLERANCE, Job::default()) {
            Ok(map) => assert!(map.texels().iter().all(|t| t.g.is_finite()), "{lobe:?}: an infinite texel"),
            Err(error) => assert!(error.to_string().contains("the filtered light"), "{lobe:?}: {error}"),
        }
    }
}

#[test]
fn a_mirror_is_watched_and_its_light_is_finite_as_that_of_any_lobe() {
    let sky = CubeMap::from_fn(7, |_| Rgb::splat(f32::MAX));
    let picture = |source: &CubeMap, job: Job<'_>| filter_lobe_lat_long(source, ggx(0.0), [64, 32], 0.02, job);
    // Between texels the weights sum to 1 but for rounding.
    let refused = picture(&sky, Job::default()).map(|_| ());
    assert!(
        matches!(&refused, Err(EnvError::Options(message)) if message.contains("the filtered light")),
        "as bright as it can be: {refused:?}"
    );
    let source = noise(8, 9);
    let mut heard = Vec::new();
    let mut watch = |progress: &Progress| {
        heard.push((progress.done, progress.total));
        ControlFlow::Continue(())
    };
    picture(&source, Job::default().watched_by(&mut watch)).unwrap();
    assert_eq!(heard, [(0, 64 * 32), (64 * 32, 64 * 32)], "what is done before and after");
    let mut stop = |_: &Progress| -> ControlFlow<()> { ControlFlow::Break(()) };
    let stopped = picture(&source, Job::default().watched_by(&mut stop)).map(|_| ());
    assert!(matches!(stopped, Err(EnvError::Cancelled)), "a picture: {stopped:?}");
    let stopped = filter_lobe(&source, ggx(0.0), 8, TOLERANCE, Job::default().watched_by(&mut stop)).map(|_| ());
    assert!(matches!(stopped, Err(EnvError::Cancelled)), "a cube: {stopped:?}");
}
