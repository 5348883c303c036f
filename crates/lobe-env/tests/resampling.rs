//! Maps keep what matters when they become other maps.

use std::f64::consts::PI;

use lobe_env::{MappedMap, Mapping, Resample, bundled, project_env, project_map, resample, rotate_map};
use lobe_sh::{Dir, Expansion, Rgb, Rotation, ShVec};
use lobe_testkit::Random;

/// A map of about `texels` texels in natural proportions.
fn size(mapping: Mapping, texels: usize) -> (usize, usize) {
    let aspect = mapping.height_for(12) as f64 / 12.0;
    let width = (texels as f64 / aspect).sqrt().round() as usize;
    (width, mapping.height_for(width))
}

fn to(mapping: Mapping, texels: usize) -> Resample {
    let (width, height) = size(mapping, texels);
    Resample::to(mapping, width, height)
}

/// The largest difference of coefficients, in parts of the norm.
fn relative_difference(a: &ShVec<Rgb<f64>>, b: &ShVec<Rgb<f64>>) -> f64 {
    let g = |f: &ShVec<Rgb<f64>>| f.coefficients().iter().map(|c| c.g).collect::<Vec<_>>();
    let (a, b) = (g(a), g(b));
    let norm = b.iter().map(|c| c * c).sum::<f64>().sqrt();
    a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / norm
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

#[test]
fn expansions_of_small_maps_are_right_to_the_stated_error() {
    let order = 6;
    for mapping in Mapping::ALL {
        for width in [2, 5, 8, 13] {
            let (w, h) = (width, mapping.height_for(width));
            let mut random = Random::new(width as u64);
            let texels = (0..w * h).map(|_| Rgb::new(1.0, random.unit() as f32, 0.0)).collect();
            let map = MappedMap::new(mapping, w, h, texels).unwrap();
            // The independent way: the same piecewise constant function on a fine lat-long map.
            let (fw, fh) = (1440, 720);
            let fine = lobe_env::EnvMap::from_fn(fw, fh, |s| {
                let (x, y) = map.texel_at(s);
                map.texel(x, y)
            });
            let (found, expected) = (project_map(&map, order), project_env(&fine, order));
            let error = relative_difference(&found, &expected);
            assert!(error < 1e-3, "{mapping} {w} x {h}: {error:e}");
            let mean = found.mean();
            assert!((mean.r - 1.0).abs() < 1e-12, "{mapping} {w} x {h}: a constant channel has mean {}", mean.r);
            let largest = found.coefficients()[1..].iter().map(|c| c.r.abs()).fold(0.0, f64::max);
            assert!(largest < 4.0 * PI * 1e-7, "{mapping} {w} x {h}: a constant channel has a coefficient {largest:e}");
        }
    }
}

#[test]
fn band_limited_maps_keep_their_coefficients_through_every_pair() {
    let order = 5;
    let f = band_limited(order);
    let planted = ShVec::from_vec(f.coefficients().iter().map(|c| Rgb::new(0.0, *c, 0.0)).collect()).unwrap();
    let texels = 30_000;
    let mut worst = (0.0_f64, String::new());
    for from in Mapping::ALL {
        let (w, h) = size(from, texels);
        let source = MappedMap::from_fn(from, w, h, |s| light(&f, s));
        for there in Mapping::ALL {
            let other = resample(&source, &to(there, texels)).unwrap();
            let back = resample(&other, &Resample::to(from, w, h)).unwrap();
            for (name, map) in [("there", &other), ("back", &back)] {
                let error = relative_difference(&project_map(map, order), &planted);
                if error > worst.0 {
                    worst = (error, format!("{from} {there} {name}"));
                }
                assert!(error < 1e-3, "{from} to {there}, {name}: {error:e}");
            }
        }
    }
    println!("worst relative error of a coefficient: {:e} ({})", worst.0, worst.1);
}

#[test]
fn the_mean_is_kept_through_chains_of_mappings() {
    let f = band_limited(5);
    let smooth = MappedMap::from_fn(Mapping::LatLong, 256, 128, |s| light(&f, s));
    for (name, source) in
        [("smooth", smooth), ("sunset", bundled::sunset().map().into()), ("studio", bundled::studio().map().into())]
    {
        let mean = source.mean().g;
        let mut map = source;
        for (k, mapping) in Mapping::ALL.into_iter().cycle().skip(3).take(10).enumerate() {
            map = resample(&map, &to(mapping, 40_000 + 7_000 * (k % 3))).unwrap();
            let error = (map.mean().g / mean - 1.0).abs();
            println!("{name}, step {k} {mapping}: {error:e}");
            assert!(error < 1e-4, "{name} after step {k}, {mapping}: {error:e}");
        }
    }
}

#[test]
fn constant_maps_stay_constant_at_every_size() {
    for from in Mapping::ALL {
        let (w, h) = size(from, 500);
        let source = MappedMap::from_fn(from, w, h, |_| Rgb::new(1.0, 2.0, 3.0));
        for there in Mapping::ALL {
            for texels in [6, 40, 700, 6000] {
                let map = resample(&source, &to(there, texels)).unwrap();
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

/// Places where maps go wrong: poles, seams, edges, corners, rims.
fn hard_places() -> Vec<Dir> {
    let mut places = vec![Dir::X, -Dir::X, Dir::Y, -Dir::Y, Dir::Z, -Dir::Z];
    for v in
        [[1.0, 1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, 0.0], [-1.0, 0.01, 0.5], [0.0, 0.7, -0.7], [0.3, 0.2, -0.9]]
    {
        places.extend(Dir::new(v));
    }
    places
}

/// The energy of the green channel and the direction of its centre.
fn energy_and_centre(map: &MappedMap) -> (f64, Dir) {
    let f = project_map(map, 2);
    let centre = Dir::new([-f[3].g, -f[1].g, f[2].g]).expect("a sun has a direction");
    ((4.0 * PI).sqrt() * f[0].g, centre)
}

/// How far a rim texel of a ball of 1500 texels, 39 across, reaches from behind the ball: `2 acos(1 - 2/39)`.
const RIM_REACH: f64 = 0.643;

/// The largest angle from the middle of the texel in direction `s` to one of its corners or, at a rim, to the one
/// direction behind the ball, where the rim is.
fn half_texel(map: &MappedMap, s: Dir) -> f64 {
    let (x, y) = map.texel_at(s);
    let centre = map.dir(x, y).expect("a texel with light shows something");
    let behind = match map.mapping() {
        Mapping::Sphere => Dir::Y,
        Mapping::MirrorBall => Dir::X,
        _ => -Dir::X,
    };
    let corner = |(i, j): (usize, usize)| {
        let (u, v) = ((x + i) as f64 / map.width() as f64, (y + j) as f64 / map.height() as f64);
        map.mapping().dir_from_uv(u, v).map_or_else(
            || if map.mapping() == Mapping::DualParaboloid { 0.0 } else { centre.angle_to(behind) },
            |c| c.angle_to(centre),
        )
    };
    // A corner on a fold may be another point of the sphere's far side: half the sphere is no texel.
    [(0, 0), (1, 0), (0, 1), (1, 1)].map(corner).into_iter().filter(|angle| *angle < 1.0).fold(0.0, f64::max)
}

#[test]
fn a_sun_of_one_texel_keeps_energy_and_place_through_every_pair_of_mappings() {
    let texels = 1_500;
    let pitch = (4.0 * PI / texels as f64).sqrt();
    let (mut worst, mut farthest) = ((0.0_f64, String::new()), (0.0_f64, String::new()));
    for from in Mapping::ALL {
        let (w, h) = size(from, texels);
        for place in hard_places() {
            let mut source = MappedMap::from_fn(from, w, h, |_| Rgb::new(0.0, 0.0, 0.0));
            let (x, y) = source.texel_at(place);
            source.texels_mut()[y * w + x] = Rgb::new(0.0, 1e4, 0.0);
            let (energy, centre) = energy_and_centre(&source);
            for there in Mapping::ALL {
                let map = resample(&source, &to(there, texels)).unwrap();
                let (found, moved) = energy_and_centre(&map);
                let error = (found / energy - 1.0).abs();
                let distance = centre.angle_to(moved) / pitch;
                let name = format!("{from} to {there}, sun at {:?}", place.to_array());
                assert!(error < 0.01, "{name}: energy off by {error:e}");
                // Behind a ball light falls on slivers of many rim texels: there the rim's own reach is the texel.
                let behind = |mapping| match mapping {
                    Mapping::Sphere => place.angle_to(Dir::Y) < 0.5,
                    Mapping::MirrorBall => place.angle_to(Dir::X) < 0.5,
                    _ => false,
                };
                let rim = if behind(from) || behind(there) { 0.5 * RIM_REACH } else { 0.0 };
                let limit = half_texel(&source, centre).max(half_texel(&map, centre)).max(0.5 * pitch).max(rim) / pitch;
                assert!(distance < limit, "{name}: moved by {distance} texels");
                if error > worst.0 {
                    worst = (error, name.clone());
                }
                if distance > farthest.0 {
                    farthest = (distance, name);
                }
            }
        }
    }
    println!("worst energy {:e}: {}; farthest {}: {}", worst.0, worst.1, farthest.0, farthest.1);
}

#[test]
fn shrinking_keeps_a_small_sun() {
    let mut source = MappedMap::from_fn(Mapping::LatLong, 512, 256, |_| Rgb::new(0.1, 0.1, 0.1));
    source.texels_mut()[40 * 512 + 3] = Rgb::new(0.0, 1e5, 0.0);
    let mean = source.mean().g;
    for mapping in Mapping::ALL {
        for texels in [6, 60, 600] {
            let small = resample(&source, &to(mapping, texels)).unwrap();
            let error = (small.mean().g / mean - 1.0).abs();
            assert!(error < 0.01, "{mapping} of {texels} texels: {error:e}");
        }
    }
}

#[test]
fn turned_maps_have_turned_expansions() {
    let order = 5;
    let f = band_limited(order);
    let rotation = Rotation::from_axis_angle(Dir::from_angles(1.0, 2.0), 0.9);
    for mapping in Mapping::ALL {
        let (w, h) = size(mapping, 30_000);
        let map = MappedMap::from_fn(mapping, w, h, |s| light(&f, s));
        let expected = rotation.rotated(&project_map(&map, order));
        let error = relative_difference(&project_map(&rotate_map(&map, &rotation), order), &expected);
        assert!(error < 1e-3, "{mapping}: {error:e}");
    }
}

#[test]
fn enlarged_maps_are_smooth_across_seams() {
    let f = band_limited(4);
    for from in Mapping::ALL {
        let (w, h) = size(from, 2_000);
        let small = MappedMap::from_fn(from, w, h, |s| light(&f, s));
        let (ew, eh) = (360, 180);
        let large = resample(&small, &Resample::to(Mapping::LatLong, ew, eh)).unwrap();
        // The whole rim of a disc is one direction: around it the picture has nearly no texels.
        let behind = match from {
            Mapping::Sphere => Some(Dir::Y),
            Mapping::MirrorBall => Some(Dir::X),
            Mapping::Angular => Some(-Dir::X),
            _ => None,
        };
        let mut worst = 0.0_f64;
        for y in 0..eh {
            for x in 0..ew {
                let s = large.dir(x, y).unwrap();
                if behind.is_none_or(|behind| behind.angle_to(s) > 0.6) {
                    worst = worst.max((f64::from(large.texel(x, y).g) - f.eval(s)).abs());
                }
            }
        }
        println!("{from}: off by {worst}");
        assert!(worst < 0.15, "{from}: off by {worst}, values up to 4");
    }
}

#[test]
fn the_same_grid_is_copied_bit_for_bit() {
    let mut random = Random::new(2);
    for mapping in Mapping::ALL {
        let (w, h) = size(mapping, 400);
        let texels = (0..w * h).map(|_| Rgb::new(random.unit() as f32, 1.0, 0.0)).collect();
        let map = MappedMap::new(mapping, w, h, texels).unwrap();
        assert!(resample(&map, &Resample::to(mapping, w, h)).unwrap() == map, "{mapping}");
    }
}

#[test]
fn a_quarter_turn_about_z_shifts_the_columns_of_a_lat_long_map() {
    let mut random = Random::new(2);
    let texels = (0..32 * 16).map(|_| Rgb::new(random.unit() as f32, 1.0, 0.0)).collect();
    let map = MappedMap::new(Mapping::LatLong, 32, 16, texels).unwrap();
    let turned = rotate_map(&map, &Rotation::from_axis_angle(Dir::Z, 0.5 * PI));
    // What was at +x, in the middle, is at +y, a quarter to the left.
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
            let map = resample(&source, &Resample::to(Mapping::Octahedral, 91, 91)).unwrap();
            (project_map(&map, 4), map)
        })
    };
    let (one, three) = (run(1), run(3));
    assert!(one.1 == three.1 && one.0 == three.0, "one thread and three threads differ");
}
