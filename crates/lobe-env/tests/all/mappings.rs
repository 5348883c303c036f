//! Mappings: the properties that every mapping must have.

use std::f64::consts::PI;

use lobe_env::{EnvMap, MappedMap, Mapping};
use lobe_sh::{Dir, Rgb};
use lobe_testkit::{Random, directions};

/// The angle to the direction behind a mirrored ball within which the inverse is inaccurate: `r` has lost half its
/// digits.
const BEHIND_BALL: f64 = 1e-3;

/// Sizes of all kinds: tiny, odd, tall, wide. Cubes take the width.
const SIZES: [(usize, usize); 8] = [(1, 1), (2, 1), (2, 2), (3, 3), (5, 2), (31, 17), (64, 64), (129, 200)];

fn sizes(mapping: Mapping) -> impl Iterator<Item = (usize, usize)> {
    SIZES.into_iter().map(move |(w, h)| if mapping == Mapping::Cube { (w, 6 * w) } else { (w, h) })
}

fn dir(v: [f64; 3]) -> Dir {
    Dir::new(v).unwrap_or_else(|| panic!("{v:?} is no direction"))
}

/// The direction in which a mapping's whole rim or side is one point.
fn singular(mapping: Mapping) -> Option<Dir> {
    match mapping {
        Mapping::Sphere => Some(Dir::Y),
        Mapping::MirrorBall => Some(Dir::X),
        _ => None,
    }
}

#[test]
fn solid_angles_of_every_mapping_and_size_sum_to_the_whole_sphere() {
    let mut worst = 0.0_f64;
    for mapping in Mapping::ALL {
        for (w, h) in sizes(mapping) {
            let sum: f64 = (0..w * h).map(|i| mapping.solid_angle(w, h, i % w, i / w)).sum();
            let error = (sum - 4.0 * PI).abs();
            worst = worst.max(error);
            assert!(error < 1e-11, "{mapping} {w} x {h}: {sum}, off by {error:e}");
        }
    }
    println!("worst sum of solid angles: off by {worst:e}");
}

#[test]
fn every_mapping_is_found_by_its_name_and_tells_its_shape() {
    for (k, mapping) in Mapping::ALL.into_iter().enumerate() {
        let name = mapping.name();
        assert_eq!(Mapping::from_name(name), Some(mapping), "{name}: two mappings of this name?");
        assert_eq!(mapping as usize, k, "{name}: the shaders of lobe-gpu count in this order");
        assert!(!mapping.description().is_empty() && mapping.to_string() == name, "{name}: {}", mapping.description());
        let [width, height] = mapping.picture_size(12);
        assert_eq!(mapping.height_for(width), height, "{name}: a picture of {width} columns");
        assert!(height.is_multiple_of(mapping.faces()), "{name}: {} faces in {height} rows", mapping.faces());
        for (axis, [u, v]) in mapping.axes_again() {
            let at = ["+x", "-x", "+y", "-y", "+z", "-z"].iter().position(|known| known == axis);
            let at = at.unwrap_or_else(|| panic!("{name}: {axis} is no axis"));
            let axis = [Dir::X, -Dir::X, Dir::Y, -Dir::Y, Dir::Z, -Dir::Z][at];
            let shown = mapping.dir_from_uv(*u, *v).unwrap_or_else(|| panic!("{name}: nothing at ({u}, {v})"));
            assert!(shown.angle_to(axis) < 1e-7, "{name}: {shown:?} at ({u}, {v}), not {axis:?}");
        }
    }
}

#[test]
fn directions_come_back_from_every_mapping() {
    let mut worst = 0.0_f64;
    for mapping in Mapping::ALL {
        for v in directions() {
            let s = dir(v);
            let (u, v) = mapping.uv_from_dir(s);
            assert!((0.0..=1.0).contains(&u) && (0.0..=1.0).contains(&v), "{mapping}: {s:?} is at ({u}, {v})");
            let back = mapping.dir_from_uv(u, v).unwrap_or_else(|| panic!("{mapping}: nothing at ({u}, {v})"));
            let near_rim = singular(mapping).is_some_and(|behind| behind.angle_to(s) < BEHIND_BALL);
            let limit = if near_rim { 1e-7 } else { 1e-12 };
            let error = s.angle_to(back);
            worst = if near_rim { worst } else { worst.max(error) };
            assert!(error < limit, "{mapping}: {s:?} came back as {back:?} from ({u}, {v}), off by {error:e}");
        }
    }
    println!("worst round trip of a direction: {worst:e} rad");
}

#[test]
fn points_of_the_picture_come_back_away_from_seams() {
    let mut random = Random::new(3);
    let mut worst = 0.0_f64;
    for mapping in Mapping::ALL {
        for _ in 0..2000 {
            let (u, v) = (random.unit(), random.unit());
            // Within 1e-3 of a side several points may be one direction.
            if u.min(v).min(1.0 - u).min(1.0 - v) < 1e-3 {
                continue;
            }
            let Some(s) = mapping.dir_from_uv(u, v) else { continue };
            if singular(mapping).is_some_and(|behind| behind.angle_to(s) < 0.05) {
                continue;
            }
            let back = mapping.uv_from_dir(s);
            let error = (back.0 - u).abs().max((back.1 - v).abs());
            worst = worst.max(error);
            assert!(error < 1e-12, "{mapping}: ({u}, {v}) came back as {back:?}");
        }
    }
    println!("worst round trip of a point: {worst:e}");
}

#[test]
fn both_sides_of_every_seam_are_on_their_own_side() {
    type Side = fn((f64, f64)) -> bool;
    /// Mapping, direction on the seam, direction across it, and the points on either side.
    type Case = (Mapping, [f64; 3], [f64; 3], Side, Side);
    let cases: [Case; 7] = [
        (Mapping::LatLong, [-1.0, 0.0, 0.3], [0.0, 1.0, 0.0], |p| p.0 < 0.01, |p| p.0 > 0.99),
        (Mapping::DualParaboloid, [0.0, 0.4, 0.8], [1.0, 0.0, 0.0], |p| p.0 < 0.5, |p| p.0 >= 0.5),
        (Mapping::Octahedral, [0.5, 0.0, -0.5], [0.0, 1.0, 0.0], |p| p.1 > 0.6, |p| p.1 < 0.4),
        (Mapping::EqualArea, [0.0, -0.5, -0.5], [1.0, 0.0, 0.0], |p| p.0 > 0.6, |p| p.0 < 0.4),
        (Mapping::Cube, [1.0, -1.0, 0.2], [1.0, 1.0, 0.0], |p| p.1 < 1.0 / 6.0, |p| p.1 > 4.0 / 6.0),
        (Mapping::Angular, [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], |p| p.0 < 0.01, |p| p.0 > 0.99),
        (Mapping::Sphere, [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], |p| p.0 > 0.99, |p| p.0 < 0.01),
    ];
    for (mapping, seam, across, plus, minus) in cases {
        for step in [1e-9, 1e-6] {
            let beside = |sign: f64| dir([0, 1, 2].map(|k| seam[k] + sign * step * across[k]));
            let (p, m) = (mapping.uv_from_dir(beside(1.0)), mapping.uv_from_dir(beside(-1.0)));
            assert!(plus(p) && minus(m), "{mapping} {step:e} beside {seam:?}: {p:?} and {m:?}");
            for s in [beside(1.0), beside(-1.0)] {
                let (u, v) = mapping.uv_from_dir(s);
                let back = mapping.dir_from_uv(u, v).unwrap();
                assert!(s.angle_to(back) < 0.1 * step.max(1e-7), "{mapping}: {s:?} came back as {back:?}");
            }
        }
    }
}

/// Whether a direction has more than two points in the picture: a pole, folded corners, the rim around one direction.
fn spread_out(mapping: Mapping, s: Dir) -> bool {
    match mapping {
        Mapping::LatLong => s.x() == 0.0 && s.y() == 0.0,
        Mapping::Octahedral | Mapping::EqualArea => s.x() == 0.0 && s.y() == 0.0 && s.z() < 0.0,
        Mapping::Angular => s.angle_to(-Dir::X) < 1e-6,
        _ => singular(mapping).is_some_and(|behind| behind.angle_to(s) < 1e-2),
    }
}

#[test]
fn every_edge_fold_rim_and_pole_is_on_one_of_its_sides() {
    // Planes of the axes with both signs of zero, poles, diagonals: all edges and corners of the cube, folds of the
    // octahedron, rims of the paraboloids, the seam of the lat-long picture, and places without any of these.
    const COMPONENTS: [f64; 6] = [-1.0, -0.3, -0.0, 0.0, 0.3, 1.0];
    const STEP: f64 = 1e-7;
    let all = COMPONENTS.iter().flat_map(|x| COMPONENTS.iter().map(move |y| [*x, *y]));
    let all: Vec<[f64; 3]> = all.flat_map(|[x, y]| COMPONENTS.map(|z| [x, y, z])).collect();
    let distance = |a: (f64, f64), b: (f64, f64)| (a.0 - b.0).abs().max((a.1 - b.1).abs());
    for mapping in Mapping::ALL {
        for v in all.iter().filter(|v| **v != [0.0; 3]) {
            let s = dir(*v);
            let at = mapping.uv_from_dir(s);
            assert!((0.0..=1.0).contains(&at.0) && (0.0..=1.0).contains(&at.1), "{mapping}: {v:?} is at {at:?}");
            let back = mapping.dir_from_uv(at.0, at.1).unwrap_or_else(|| panic!("{mapping}: nothing at {at:?}"));
            let limit = if singular(mapping).is_some_and(|b| b.angle_to(s) < BEHIND_BALL) { 1e-7 } else { 1e-12 };
            assert!(s.angle_to(back) < limit, "{mapping}: {v:?} came back as {back:?} from {at:?}");
            for k in 0..3 {
                let beside = |steps: f64| {
                    let mut beside = *v;
                    beside[k] += steps * STEP;
                    mapping.uv_from_dir(dir(beside))
                };
                if spread_out(mapping, s) {
                    continue;
                }
                let [minus, plus] = [-1.0, 1.0].map(|sign| [beside(sign), beside(2.0 * sign)]);
                for side in [minus, plus] {
                    assert!(
                        distance(side[0], side[1]) < 1e-4,
                        "{mapping} beside {v:?}, axis {k}: {side:?} on one side"
                    );
                }
                let nearest = distance(at, minus[0]).min(distance(at, plus[0]));
                assert!(nearest < 1e-4, "{mapping}, axis {k}: {v:?} is at {at:?}, its sides at {minus:?} and {plus:?}");
            }
        }
    }
}

#[test]
fn texels_contain_the_directions_of_their_centers() {
    for mapping in Mapping::ALL {
        for (w, h) in sizes(mapping) {
            let map = MappedMap::from_fn(mapping, w, h, |_| Rgb::new(1.0, 1.0, 1.0));
            for i in 0..w * h {
                let (x, y) = (i % w, i / w);
                let shows = map.solid_angle(x, y) > 1e-12;
                let Some(s) = map.dir(x, y) else {
                    assert!(!shows, "{mapping} {w} x {h}: texel ({x}, {y}) shows something but has no direction");
                    continue;
                };
                let whole = w == 1 || h == 1 || (mapping == Mapping::DualParaboloid && w % 2 == 1 && x == w / 2);
                assert!(
                    map.texel_at(s) == (x, y) || whole || !shows,
                    "{mapping} {w} x {h}: {:?} not ({x}, {y})",
                    map.texel_at(s)
                );
            }
        }
    }
}

#[test]
fn the_mean_of_a_constant_map_is_the_constant() {
    for mapping in Mapping::ALL {
        for (w, h) in sizes(mapping) {
            let mean = MappedMap::from_fn(mapping, w, h, |_| Rgb::new(0.25, 1.0, 4.0)).mean();
            assert!((mean.b - 4.0).abs() < 1e-11 && (mean.r - 0.25).abs() < 1e-12, "{mapping} {w} x {h}: {mean:?}");
        }
    }
}

#[test]
fn a_constant_map_is_constant_in_every_direction() {
    for mapping in Mapping::ALL {
        for (w, h) in sizes(mapping) {
            let map = MappedMap::from_fn(mapping, w, h, |_| Rgb::new(1.0, 2.0, 3.0));
            for v in directions() {
                let found = map.radiance(dir(v));
                assert!((found.b - 3.0).abs() < 2e-6, "{mapping} {w} x {h} towards {v:?}: {found:?}");
            }
        }
    }
}

#[test]
fn at_texel_centers_the_radiance_is_the_texel() {
    let mut random = Random::new(11);
    for mapping in Mapping::ALL {
        let (w, h) = (16, mapping.height_for(16));
        let texels = (0..w * h).map(|_| Rgb::new(random.unit() as f32, 1.0, 0.0)).collect();
        let map = MappedMap::new(mapping, w, h, texels).unwrap();
        for i in 0..w * h {
            let ((x, y), (u, v)) = ((i % w, i / w), ((i % w) as f64 + 0.5, (i / w) as f64 + 0.5));
            let Some(s) = mapping.dir_from_uv(u / w as f64, v / h as f64) else { continue };
            // Over the last half texel before a rim the other side is blended in.
            let on_rim = map.solid_angle(x, y) > 0.0 && (mapping.uv_from_dir(s).0 - u / w as f64).abs() < 1.0 && {
                let (px, py) = match mapping {
                    Mapping::DualParaboloid => (4.0 * (u / w as f64).rem_euclid(0.5) - 1.0, 2.0 * v / h as f64 - 1.0),
                    Mapping::Sphere | Mapping::MirrorBall | Mapping::Angular => {
                        (2.0 * u / w as f64 - 1.0, 2.0 * v / h as f64 - 1.0)
                    }
                    _ => (0.0, 0.0),
                };
                px.hypot(py) > 1.0 - 1.0 / 8.0
            };
            let (found, texel) = (map.radiance(s), map.texel(x, y));
            assert!(on_rim || (found.r - texel.r).abs() < 1e-5, "{mapping} at ({x}, {y}): {found:?} against {texel:?}");
        }
    }
}

#[test]
fn the_radiance_of_every_mapping_is_continuous_across_its_seams() {
    let step = 1e-7;
    for mapping in Mapping::ALL {
        for width in [1, 2, 5, 8, 16] {
            let (w, h) = (width, mapping.height_for(width));
            let mut random = Random::new(width as u64);
            let texels = (0..w * h).map(|_| Rgb::new(random.unit() as f32, 1.0, 0.0)).collect();
            let map = MappedMap::new(mapping, w, h, texels).unwrap();
            for _ in 0..400 {
                // Great circles x = 0, y = 0, x = ±y, .. contain every edge, fold, rim and seam.
                let normal = dir([0, 1, 2].map(|_| (random.unit() * 3.0).floor() - 1.0).map(|c| c + 1e-300));
                let on = dir(random.direction());
                let along = on.dot(normal);
                let at =
                    |offset: f64| dir([0, 1, 2].map(|k| on.to_array()[k] - (along - offset) * normal.to_array()[k]));
                // Not at a point where the whole rim, or a whole row, meets.
                let pole = match mapping {
                    Mapping::LatLong => at(0.0).z().abs() > 0.999,
                    Mapping::Angular => at(0.0).x() < -0.999,
                    _ => singular(mapping).is_some_and(|behind| behind.dot(at(0.0)) > 0.95),
                };
                let (a, b) = (map.radiance(at(step)), map.radiance(at(-step)));
                assert!(pole || (a.r - b.r).abs() < 2e-4, "{mapping} {w} x {h} at {:?}: {a:?} and {b:?}", at(0.0));
            }
            // Through the pole, along great circles.
            let through = match mapping {
                Mapping::LatLong => Some((Dir::Z, Dir::X, Dir::Y)),
                Mapping::Angular => Some((-Dir::X, Dir::Y, Dir::Z)),
                Mapping::MirrorBall => Some((Dir::X, Dir::Y, Dir::Z)),
                Mapping::Sphere => Some((Dir::Y, Dir::X, Dir::Z)),
                _ => None,
            };
            if let Some((pole, p, q)) = through {
                for k in 0..20 {
                    let (sin, cos) = (0.1 + 0.31 * f64::from(k)).sin_cos();
                    let beside = |step: f64| {
                        let [c, p, q] = [pole, p, q].map(Dir::to_array);
                        map.radiance(dir([0, 1, 2].map(|i| c[i] + step * (cos * p[i] + sin * q[i]))))
                    };
                    let (a, b) = (beside(1e-9), beside(-1e-9));
                    assert!((a.r - b.r).abs() < 1e-3, "{mapping} {w} x {h}, circle {k}: {a:?} and {b:?}");
                }
            }
        }
    }
}

#[test]
fn maps_change_their_type_without_changing_a_texel() {
    let sky = EnvMap::from_fn(8, 4, |s| Rgb::new(s.x() as f32, s.y() as f32, s.z() as f32));
    let mapped = MappedMap::from(sky.clone());
    assert_eq!(mapped.clone().into_env_map().unwrap(), sky, "lat-long and back");
    let error = mapped.into_cube_map().unwrap_err().to_string();
    assert_eq!(error, "a cube map expected, found a map that is lat-long: convert it");
    let wrong = MappedMap::new(Mapping::Cube, 2, 8, vec![Rgb::new(0.0, 0.0, 0.0); 16]).unwrap_err().to_string();
    assert_eq!(wrong, "a cube's picture is six times as high as wide, but 2 x 8 is not");
}
