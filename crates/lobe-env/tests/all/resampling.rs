//! Resampling: constants, energy, direction and mean are kept through every pair of mappings.

use std::f64::consts::PI;
use std::ops::ControlFlow;

use lobe_env::{EnvError, MappedMap, Mapping, Resample, bundled, project_map, resample, rotate_map};
use lobe_io::{Job, Progress};
use lobe_sh::{Coefficient, Dir, Expansion, Rgb, Rotation, ShVec};
use lobe_testkit::Random;

/// The tolerance: single precision, and the convergence of the balanced weights.
const ROUNDING: f64 = 1e-3;

/// A map of about `texels` texels in natural proportions.
pub(crate) fn size(mapping: Mapping, texels: usize) -> (usize, usize) {
    let aspect = mapping.height_for(12) as f64 / 12.0;
    let width = (texels as f64 / aspect).sqrt().round() as usize;
    (width, mapping.height_for(width))
}

pub(crate) fn to(mapping: Mapping, texels: usize) -> Resample {
    let (width, height) = size(mapping, texels);
    Resample::to(mapping, width, height)
}

/// The largest difference of coefficients, relative to the norm.
fn relative_difference(a: &ShVec<Rgb<f64>>, b: &ShVec<Rgb<f64>>) -> f64 {
    let g = |f: &ShVec<Rgb<f64>>| f.coefficients().iter().map(|c| c.g).collect::<Vec<_>>();
    let (a, b) = (g(a), g(b));
    let norm = b.iter().map(|c| c * c).sum::<f64>().sqrt();
    a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / norm
}

/// The largest difference of coefficients in any band, relative to that band's norm.
fn difference_by_band(a: &ShVec<Rgb<f64>>, b: &ShVec<Rgb<f64>>) -> f64 {
    let error = |l: usize| {
        let band = l * l..(l + 1) * (l + 1);
        let (a, b) = (&a.coefficients()[band.clone()], &b.coefficients()[band]);
        let norm = b.iter().map(|c| c.g * c.g).sum::<f64>().sqrt();
        a.iter().zip(b).map(|(a, b)| (a.g - b.g).abs()).fold(0.0, f64::max) / norm
    };
    (0..a.order()).map(error).fold(0.0, f64::max)
}

fn band_limited(order: usize) -> ShVec<f64> {
    let mut f = ShVec::from_vec(Random::new(9).signed_vec(order * order)).expect("n² numbers");
    f.coefficients_mut()[0] = 8.0;
    f
}

fn light(f: &ShVec<f64>, s: Dir) -> Rgb<f32> {
    let value = f.eval(s) as f32;
    Rgb::new(1.0, value, 0.5 * value)
}

/// Random light in each texel, and 1 in the red channel.
fn random_map(mapping: Mapping, width: usize, seed: u64) -> MappedMap {
    let mut random = Random::new(seed);
    let height = mapping.height_for(width);
    let texels = (0..width * height).map(|_| Rgb::new(1.0, random.unit() as f32, 0.0)).collect();
    MappedMap::new(mapping, width, height, texels).unwrap()
}

#[test]
fn expansions_of_small_maps_are_right_to_the_stated_error() {
    small_maps_have_right_expansions(&[(2, 6), (5, 6), (8, 6), (13, 6), (3, 24)]);
}

#[test]
#[ignore = "long: of the nightly group"]
fn expansions_of_small_maps_to_high_orders_are_right_to_the_stated_error() {
    small_maps_have_right_expansions(&[(2, 64), (3, 40)]);
}

/// Maps of random texels against the same texels in parts, by their width and the order of the expansion.
fn small_maps_have_right_expansions(sizes: &[(usize, usize)]) {
    let mut worst = 0.0_f64;
    for mapping in Mapping::ALL {
        // The highest order needs the most nodes in the largest texels.
        for &(width, order) in sizes {
            let map = random_map(mapping, width, width as u64);
            let (w, h) = (map.width(), map.height());
            // The same piecewise constant function on a map whose texels are parts of this one's.
            let parts = 3;
            let texels = (0..parts * parts * w * h)
                .map(|i| map.texel(i % (parts * w) / parts, i / (parts * w) / parts))
                .collect();
            let fine = MappedMap::new(mapping, parts * w, parts * h, texels).unwrap();
            let (found, expected) = (project_map(&map, order), project_map(&fine, order));
            let error = relative_difference(&found, &expected);
            assert!(error < 1e-9, "{mapping} {w} x {h}, order {order}: {error:e}");
            worst = worst.max(error);
            let mean = found.mean();
            assert!((mean.r - 1.0).abs() < 1e-12, "{mapping} {w} x {h}: a constant channel has mean {}", mean.r);
            let largest = found.coefficients()[1..].iter().map(|c| c.r.abs()).fold(0.0, f64::max);
            assert!(largest < 1e-8, "{mapping} {w} x {h}: a constant channel has a coefficient {largest:e}");
        }
    }
    println!("worst difference between texels and their parts: {worst:e}");
}

#[test]
fn band_1_of_a_cube_is_the_closed_form_of_its_texels() {
    // ∫ s ds over a polygon of great circles is half the sum of its edges' angles times their normals.
    for width in [1, 2, 5, 13] {
        let map = random_map(Mapping::Cube, width, 40 + width as u64);
        let mut vector = [0.0; 3];
        for i in 0..map.texels().len() {
            let (x, y) = (i % width, i / width);
            let at = |i: usize| i as f64 / width as f64;
            let corners = [(0, 0), (1, 0), (1, 1), (0, 1)]
                .map(|(a, b)| lobe_env::cube::dir_from_face(y / width, at(x + a), at(y % width + b)).to_array());
            let mut polygon = [0.0; 3];
            for k in 0..4 {
                let (a, b) = (corners[k], corners[(k + 1) % 4]);
                let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
                let (sin, cos) =
                    (cross.iter().map(|c| c * c).sum::<f64>().sqrt(), a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>());
                polygon = [0, 1, 2].map(|c| polygon[c] + 0.5 * sin.atan2(cos) * cross[c] / sin);
            }
            // The order of the corners may go round either way: the integral points towards the texel.
            let towards: f64 = polygon.iter().zip(corners[0]).map(|(p, c)| p * c).sum();
            let scale = f64::from(map.texel(x, y).g) * towards.signum();
            vector = [0, 1, 2].map(|c| vector[c] + scale * polygon[c]);
        }
        let f = project_map(&map, 2);
        let factor = (4.0 * PI / 3.0).sqrt();
        let found = [-factor * f[3].g, -factor * f[1].g, factor * f[2].g];
        for c in 0..3 {
            assert!((found[c] - vector[c]).abs() < 1e-9, "{width}, axis {c}: {} against {}", found[c], vector[c]);
        }
    }
}

// Interpolation and the mean over a texel blur: hats have the variance δ²/6 along each axis, boxes δ²/12, and a blur of
// variance σ² weakens band l by l(l+1) σ²/2. There and back again that is l(l+1) δ²/4, δ² = 4π/40000 on average:
// 4.7e-4 of band 2, three times as much where a ball's texels are long.
#[test]
fn band_limited_maps_keep_their_coefficients_from_and_to_the_usual_mappings() {
    coefficients_are_kept(&[(&[Mapping::LatLong], &Mapping::ALL), (&Mapping::ALL, &[Mapping::Cube])]);
}

#[test]
#[ignore = "long: of the nightly group"]
fn band_limited_maps_keep_their_coefficients_through_every_pair() {
    coefficients_are_kept(&[(&Mapping::ALL, &Mapping::ALL)]);
}

/// There and back again, between each of some mappings and each of others.
fn coefficients_are_kept(pairs: &[(&[Mapping], &[Mapping])]) {
    let order = 3;
    let f = band_limited(order);
    let planted = ShVec::from_vec(f.coefficients().iter().map(|c| Rgb::new(0.0, *c, 0.0)).collect()).unwrap();
    let texels = 40_000;
    let mut worst = (0.0_f64, String::new());
    for (&from, there) in pairs.iter().flat_map(|(from, there)| from.iter().map(move |f| (f, *there))) {
        let (w, h) = size(from, texels);
        let source = MappedMap::from_fn(from, w, h, |s| light(&f, s));
        for &there in there {
            let other = resample(&source, &to(there, texels), Job::default()).unwrap();
            let back = resample(&other, &Resample::to(from, w, h), Job::default()).unwrap();
            for (name, map) in [("there", &other), ("back", &back)] {
                let error = difference_by_band(&project_map(map, order), &planted);
                if error > worst.0 {
                    worst = (error, format!("{from} {there} {name}"));
                }
                assert!(error < 2.2e-3, "{from} to {there}, {name}: {error:e}");
            }
        }
    }
    println!("worst relative error of a coefficient: {:e} ({})", worst.0, worst.1);
}

#[test]
#[ignore = "long: of the nightly group"]
fn the_mean_is_kept_through_chains_of_mappings() {
    let f = band_limited(5);
    let smooth = MappedMap::from_fn(Mapping::LatLong, 256, 128, |s| light(&f, s));
    // The sunset's sun and the studio's lamps, a thousand times as bright as their means and some texels wide.
    let maps =
        [("smooth", smooth), ("sunset", bundled::sunset().map().into()), ("studio", bundled::studio().map().into())];
    for (name, source) in maps {
        let mean = source.mean();
        let mut map = source;
        for (k, mapping) in Mapping::ALL.into_iter().cycle().skip(3).take(10).enumerate() {
            map = resample(&map, &to(mapping, 4_000 + 1_500 * (k % 3)), Job::default()).unwrap();
            let found = map.mean();
            let error = (0..3).map(|c| (found.channel(c) / mean.channel(c) - 1.0).abs()).fold(0.0, f64::max);
            println!("{name}, step {k} {mapping}: {error:e}");
            assert!(error < 1e-4, "{name} after step {k}, {mapping}: {error:e}");
        }
    }
}

#[test]
fn the_mean_is_kept_through_any_chain() {
    // Random mappings, sizes and turns; small maps, in which every texel counts.
    let mut random = Random::new(77);
    let mut worst = 0.0_f64;
    for chain in 0..6 {
        let mut map = random_map(Mapping::ALL[chain], 24, chain as u64);
        let mean = map.mean().g;
        for step in 0..12 {
            let there = Mapping::ALL[(random.unit() * 8.0) as usize];
            let turn = Rotation::from_axis_angle(Dir::from_angles(3.0 * random.unit(), 6.0 * random.unit()), 2.0);
            let to = to(there, (60.0 * (40.0_f64).powf(random.unit())) as usize);
            map = resample(&map, &if step % 3 == 0 { to.rotated(turn) } else { to }, Job::default()).unwrap();
            let error = (map.mean().g / mean - 1.0).abs();
            worst = worst.max(error);
            let size = (map.width(), map.height());
            assert!(error < 1e-4, "chain {chain}, step {step}, {there} {size:?}: {error:e}");
        }
    }
    println!("the mean is off by {worst:.1e} at most");
}

#[test]
fn constant_maps_stay_constant_at_every_size() {
    for from in Mapping::ALL {
        let (w, h) = size(from, 500);
        let source = MappedMap::from_fn(from, w, h, |_| Rgb::new(1.0, 2.0, 3.0));
        for there in Mapping::ALL {
            for texels in [6, 40, 1_500] {
                let map = resample(&source, &to(there, texels), Job::default()).unwrap();
                for y in 0..map.height() {
                    for x in 0..map.width() {
                        let shows = map.solid_angle(x, y) > 0.0;
                        let found = map.texel(x, y);
                        assert!(!shows || (found.b - 3.0).abs() < 2e-6, "{from} to {there} ({x}, {y}): {found:?}");
                    }
                }
            }
        }
    }
}

#[test]
fn turned_maps_have_turned_expansions() {
    let order = 3;
    let f = band_limited(order);
    let rotation = Rotation::from_axis_angle(Dir::from_angles(1.0, 2.0), 0.9);
    for mapping in Mapping::ALL {
        let (w, h) = size(mapping, 16_000);
        let map = MappedMap::from_fn(mapping, w, h, |s| light(&f, s));
        let expected = project_map(&map, order).rotated(&rotation);
        let error =
            relative_difference(&project_map(&rotate_map(&map, &rotation, Job::default()).unwrap(), order), &expected);
        assert!(error < 1e-3, "{mapping}: {error:e}");
    }
}

/// Half a texel: the largest angle from the direction `s` to a point of the texel that contains it.
///
/// Light in a texel has no finer place than that. At the rim of a ball or an angular map texels are long, and all end
/// in one direction.
pub(crate) fn half_texel(map: &MappedMap, s: Dir) -> f64 {
    const STEPS: usize = 8;
    let (x, y) = map.texel_at(s);
    let mut farthest = 0.0_f64;
    for j in 0..=STEPS {
        for i in 0..=STEPS {
            let at = |x: usize, i: usize, n: usize| (x as f64 + i as f64 / STEPS as f64) / n as f64;
            let (u, v) = (at(x, i, map.width()), at(y, j, map.height()));
            let Some(p) = map.mapping().dir_from_uv(u, v) else { continue };
            // The end of a texel on a seam may be read as that of the other side.
            if p.angle_to(s) < 1.2 {
                farthest = farthest.max(p.angle_to(s));
            }
        }
    }
    farthest
}

/// The distance over which values are interpolated: to the centers of the texel's neighbors in the picture, at least
/// half a texel.
fn reach(map: &MappedMap, s: Dir) -> f64 {
    let (x, y) = map.texel_at(s);
    let middle = map.dir(x, y).expect("a texel that contains a direction shows something");
    let neighbors = [(x.wrapping_sub(1), y), (x + 1, y), (x, y.wrapping_sub(1)), (x, y + 1)];
    let inside = neighbors.into_iter().filter(|(x, y)| *x < map.width() && *y < map.height());
    // Across a seam lies another part of the sphere.
    let angles = inside.filter_map(|(x, y)| map.dir(x, y)).map(|s| s.angle_to(middle)).filter(|a| *a < 0.8);
    angles.fold(half_texel(map, s), f64::max)
}

/// Whether a texel lies partly outside the discs.
fn is_cut(map: &MappedMap, x: usize, y: usize) -> bool {
    let at = |i: usize, n: usize| i as f64 / n as f64;
    [(0, 0), (1, 0), (0, 1), (1, 1)]
        .into_iter()
        .any(|(i, j)| map.mapping().dir_from_uv(at(x + i, map.width()), at(y + j, map.height())).is_none())
}

/// The steepest slope of a function, and the sharpest bend of it along any great circle.
fn slope_and_bend(f: &ShVec<f64>) -> (f64, f64) {
    const STEP: f64 = 1e-3;
    let (mut slope, mut bend) = (0.0_f64, 0.0_f64);
    let grid = MappedMap::from_fn(Mapping::EqualArea, 40, 40, |_| Rgb::new(0.0, 0.0, 0.0));
    for i in 0..1600 {
        let s = grid.dir(i % 40, i / 40).unwrap();
        for turn in 0..4 {
            // A great circle through s, perpendicular to an axis that is perpendicular to s.
            let other = Rotation::from_axis_angle(s, 0.25 * PI * turn as f64).rotate_dir(perpendicular(s));
            let along = |t: f64| f.eval(Rotation::from_axis_angle(other, t).rotate_dir(s));
            let (before, here, after) = (along(-STEP), along(0.0), along(STEP));
            slope = slope.max((after - before).abs() / (2.0 * STEP));
            bend = bend.max((after - 2.0 * here + before).abs() / (STEP * STEP));
        }
    }
    (slope, bend)
}

fn perpendicular(s: Dir) -> Dir {
    let axis = if s.z().abs() < 0.7 { [0.0, 0.0, 1.0] } else { [1.0, 0.0, 0.0] };
    let [x, y, z] = s.to_array();
    Dir::new([y * axis[2] - z * axis[1], z * axis[0] - x * axis[2], x * axis[1] - y * axis[0]]).unwrap()
}

// Interpolation mixes the values at texel centers. Where a mapping is smooth, the mean of their directions is the
// direction of the lookup, and the error is of second order: half the curvature times the mean square of their
// distances. Where grid lines bend, at the folds of the two squares and on the axes of the equal-area one, that mean is
// off by 0.03 at this size, and the value with it, however it is interpolated: the limit allows for it there.
#[test]
fn enlarged_maps_are_smooth_across_seams() {
    let f = band_limited(4);
    let (slope, bend) = slope_and_bend(&f);
    for from in Mapping::ALL {
        let (w, h) = size(from, 2_000);
        let small = MappedMap::from_fn(from, w, h, |s| light(&f, s));
        // The mean direction, interpolated in the same way.
        let places = MappedMap::from_fn(from, w, h, |s| Rgb::from(s.to_array().map(|c| 2.0 + c as f32)));
        let (ew, eh) = (120, 60);
        let to = Resample::to(Mapping::LatLong, ew, eh);
        let (large, places) =
            (resample(&small, &to, Job::default()).unwrap(), resample(&places, &to, Job::default()).unwrap());
        let (mut worst, mut part, mut farthest) = (0.0_f64, 0.0_f64, 0.0_f64);
        for y in 0..eh {
            for x in 0..ew {
                let s = large.dir(x, y).unwrap();
                // The texels at the rim of a ball all reach to one direction, from up to 0.6 away.
                let (column, row) = small.texel_at(s);
                let is_ball = matches!(from, Mapping::Sphere | Mapping::MirrorBall);
                if is_ball && is_cut(&small, column, row) {
                    continue;
                }
                let error = (f64::from(large.texel(x, y).g) - f.eval(s)).abs();
                let place = places.texel(x, y).to_array();
                let aside = (0..3).map(|k| (f64::from(place[k]) - 2.0 - s.to_array()[k]).powi(2)).sum::<f64>().sqrt();
                let limit = ROUNDING + slope * aside + 0.25 * bend * reach(&small, s).powi(2);
                assert!(error < limit, "{from} towards {s:?}: off by {error}, not {limit}");
                (worst, part, farthest) = (worst.max(error), part.max(error / limit), farthest.max(aside));
            }
        }
        println!("{from}: off by up to {worst:.3}, {part:.2} of what is allowed there; places by up to {farthest:.3}");
    }
}

#[test]
fn the_same_grid_is_copied_bit_for_bit() {
    let mut random = Random::new(2);
    for mapping in Mapping::ALL {
        let (w, h) = size(mapping, 400);
        let texels = (0..w * h).map(|_| Rgb::new(random.unit() as f32, 1.0, 0.0)).collect();
        let map = MappedMap::new(mapping, w, h, texels).unwrap();
        assert!(resample(&map, &Resample::to(mapping, w, h), Job::default()).unwrap() == map, "{mapping}");
    }
}

#[test]
fn a_quarter_turn_about_z_shifts_the_columns_of_a_lat_long_map() {
    let mut random = Random::new(2);
    let texels = (0..32 * 16).map(|_| Rgb::new(random.unit() as f32, 1.0, 0.0)).collect();
    let map = MappedMap::new(Mapping::LatLong, 32, 16, texels).unwrap();
    let turned = rotate_map(&map, &Rotation::from_axis_angle(Dir::Z, 0.5 * PI), Job::default()).unwrap();
    // The light at +x, in the middle, has moved to +y, a quarter to the left.
    for i in 0..32 * 16 {
        let (x, y) = (i % 32, i / 32);
        assert_eq!(turned.texel((x + 24) % 32, y), map.texel(x, y), "({x}, {y})");
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let source = MappedMap::from(bundled::sunset().map());
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let map = resample(&source, &Resample::to(Mapping::Octahedral, 91, 91), Job::default()).unwrap();
            (project_map(&map, 4), map)
        })
    };
    let (one, three) = (run(1), run(3));
    assert!(one.1 == three.1 && one.0 == three.0, "one thread and three threads differ");
}

#[test]
fn a_resampling_says_how_far_it_is_and_stops_where_it_is_told_to() {
    let map = MappedMap::from_fn(Mapping::LatLong, 64, 32, |s| Rgb::splat(1.0 + s.x() as f32));
    let to = Resample::to(Mapping::Cube, 12, 72);
    let mut seen = Vec::new();
    let mut watch = |progress: &Progress| {
        seen.push((progress.done, progress.total));
        ControlFlow::Continue(())
    };
    let whole = resample(&map, &to, Job::default().watched_by(&mut watch)).unwrap();
    assert_eq!(whole, resample(&map, &to, Job::default()).unwrap(), "nobody watches");
    let (first, last) = (seen[0], seen[seen.len() - 1]);
    assert!(first.0 == 0 && last.0 == last.1 && last.0 >= 3 * 72, "{seen:?}");
    assert!(seen.windows(2).all(|two| two[0].0 <= two[1].0 && two[0].1 <= two[1].1), "{seen:?}");
    for stop_at in 1..=seen.len() {
        let mut calls = 0;
        let mut watch = |_: &Progress| {
            calls += 1;
            if calls == stop_at { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let stopped = resample(&map, &to, Job::default().watched_by(&mut watch));
        assert!(matches!(stopped, Err(EnvError::Cancelled)), "call {stop_at}: {stopped:?}");
        assert_eq!(calls, stop_at, "calls");
    }
    let refused = resample(&map, &to, Job::default().kept_in("c.checkpoint"));
    assert!(matches!(refused, Err(EnvError::Options(_))), "{refused:?}");
}

#[test]
fn finite_light_is_refused_rather_than_turned_into_infinite() {
    // Each alone among black ones: what such a texel would lose by interpolation is added to it, and there is no room.
    let sparse = |i: usize| if i.is_multiple_of(7) { f32::MAX } else { 0.0 };
    let texels = (0..32 * 16).map(|i| Rgb::splat(sparse(i))).collect();
    let map = MappedMap::new(Mapping::LatLong, 32, 16, texels).unwrap();
    let turn = Rotation::from_axis_angle(Dir::from_angles(1.0, 2.0), 0.9);
    match rotate_map(&map, &turn, Job::default()) {
        Ok(turned) => assert!(turned.texels().iter().all(|t| t.g.is_finite()), "an infinite texel"),
        Err(error) => assert!(error.to_string().contains("the resampled light"), "{error}"),
    }
}
