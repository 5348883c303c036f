//! The sun leaves a map, and nothing is lost.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]

mod common;

use std::f64::consts::PI;

use lobe_env::{EnvMap, MappedMap, Mapping, SunOptions, SunReport, bundled, extract_sun, lat_long};
use lobe_sh::{Coefficient, Dir, Rgb};

const WIDTH: usize = 256;
const HEIGHT: usize = 128;
const PITCH: f64 = PI / HEIGHT as f64;

fn sky(s: Dir) -> Rgb<f32> {
    Rgb::new(0.4 + 0.1 * s.x() as f32, 0.5 + 0.2 * s.z() as f32, 1.0 + 0.3 * s.y() as f32)
}

/// Poles, the seam, axes, a diagonal and one place without any.
fn places() -> Vec<Dir> {
    let mut places = vec![Dir::Z, -Dir::Z, Dir::X, -Dir::X, Dir::Y];
    for v in [[1.0, 1.0, 1.0], [-1.0, 0.0, 0.4], [-1.0, 1e-3, 0.2], [0.01, 0.013, 1.0], [0.31, 0.52, 0.77]] {
        places.extend(Dir::new(v));
    }
    places
}

/// Columns and rows of about as many texels as the lat-long picture has.
fn size(mapping: Mapping) -> (usize, usize) {
    let width = match mapping {
        Mapping::LatLong => WIDTH,
        Mapping::Cube => 64,
        Mapping::DualParaboloid => 272,
        _ => 192,
    };
    (width, mapping.height_for(width))
}

/// The sky with a disc, every texel holding the part of it that the disc covers.
fn with_disc(mapping: Mapping, place: Dir, radius: f64, radiance: Rgb<f32>) -> MappedMap {
    // Solid angles of texels of discs are integrals of their own, and take time.
    let parts = if mapping == Mapping::LatLong { 32 } else { 16 };
    let longest = if matches!(mapping, Mapping::Sphere | Mapping::MirrorBall) { 0.4 } else { 0.1 };
    let (width, height) = size(mapping);
    let mut map = MappedMap::from_fn(mapping, width, height, sky);
    for y in 0..height {
        for x in 0..width {
            // No texel is longer than a tenth but at the rim of a ball, where it may be 20°.
            let is_far = map.dir(x, y).is_none_or(|s| s.angle_to(place) > radius + longest);
            if is_far || !(0..16).any(|i| is_in(&map, [x, y], [i % 4, i / 4], 4, place, radius + 0.06)) {
                continue;
            }
            let (mut covered, mut all) = (0.0, 0.0);
            for i in 0..parts * parts {
                let part = [i % parts, i / parts];
                // The cube's rows are those of its faces, however many parts there are.
                let weight =
                    mapping.solid_angle(width * parts, height * parts, x * parts + part[0], y * parts + part[1]);
                all += weight;
                covered += if is_in(&map, [x, y], part, parts, place, radius) { weight } else { 0.0 };
            }
            map.texels_mut()[y * width + x] += radiance.scale((covered / all) as f32);
        }
    }
    map
}

/// Whether the middle of one of `parts²` parts of a texel lies in a disc.
fn is_in(map: &MappedMap, [x, y]: [usize; 2], part: [usize; 2], parts: usize, place: Dir, radius: f64) -> bool {
    let at = |i: usize, part: usize, n: usize| (i as f64 + (part as f64 + 0.5) / parts as f64) / n as f64;
    let s = map.mapping().dir_from_uv(at(x, part[0], map.width()), at(y, part[1], map.height()));
    s.is_some_and(|s| s.angle_to(place) < radius)
}

fn assert_kept(name: &str, map: &MappedMap, found: &SunReport) {
    let (before, after) = (map.mean(), found.rest.mean() + found.sun.irradiance.scale(0.25 / PI));
    for c in 0..3 {
        let error = (after.channel(c) / before.channel(c) - 1.0).abs();
        assert!(error < 1e-12, "{name}, channel {c}: {before:?} became {after:?}");
    }
    let darker = |a: Rgb<f32>, b: Rgb<f32>| {
        (0..3).all(|c| a.channel(c) <= b.channel(c) && a.channel(c) >= b.channel(c).min(0.0))
    };
    let mut pairs = found.rest.texels().iter().zip(map.texels());
    assert!(pairs.all(|(a, b)| darker(*a, *b)), "{name}: a rest below black, or brighter than it was");
    let bits = |t: &Rgb<f32>| t.to_array().map(f32::to_bits);
    let changed = found.rest.texels().iter().zip(map.texels()).filter(|(a, b)| bits(a) != bits(b)).count();
    assert_eq!(changed, found.sun.texels, "{name}: texels that are not as they were, and the sun's");
    assert_eq!((found.rest.mapping(), found.rest.width()), (map.mapping(), map.width()), "{name}: the picture's form");
}

#[test]
fn nothing_is_lost_when_a_sun_is_taken_out() {
    for (name, map) in common::real_maps() {
        let Some(found) = extract_sun(&map, &SunOptions::default()) else {
            println!("{name}: no sun");
            continue;
        };
        let sun = found.sun;
        let degrees = sun.angular_diameter.to_degrees();
        println!("{name}: {:?}, {:?}, {degrees:.2}°, {} texels", sun.direction, sun.irradiance, sun.texels);
        assert_kept(&name, map.as_ref(), &found);
    }
}

/// Whether a place is at a rim of a round picture, or near it. Texels at the rim of a ball's are up to 20° long, and the
/// light of a small disc is spread until it is no sun any more; those at the rims of paraboloids are cut.
fn is_at_rim(mapping: Mapping, place: Dir) -> bool {
    let (u, v) = mapping.uv_from_dir(place);
    let across = match mapping {
        Mapping::Sphere | Mapping::MirrorBall | Mapping::Angular => u,
        Mapping::DualParaboloid => (2.0 * u).fract(),
        _ => return false,
    };
    (2.0 * across - 1.0).hypot(2.0 * v - 1.0) > 0.9
}

#[test]
fn planted_discs_are_found_wherever_they_are() {
    let radiance = Rgb::new(2000.0, 1500.0, 900.0);
    for mapping in Mapping::ALL {
        let mut worst = [0.0_f64; 4];
        for radius in [1.0 * PITCH, 1.7 * PITCH] {
            let disc = 2.0 * PI * (1.0 - radius.cos());
            for place in places().into_iter().filter(|place| !is_at_rim(mapping, *place)) {
                let map = with_disc(mapping, place, radius, radiance);
                let at = format!("{mapping}: disc of {} texels at {:?}", radius / PITCH, place.to_array());
                // Texels are of another size in every mapping, so that texels alone do not say how large a sun may be.
                let mut options = SunOptions::default();
                options.max_radius = radius + 1.5 * PITCH;
                let Some(found) = extract_sun(&map, &options) else { panic!("no sun: {at}") };
                assert_kept(&at, &map, &found);
                let distance = found.sun.direction.angle_to(place) / PITCH;
                let energy = (found.sun.irradiance.g / (1500.0 * disc) - 1.0).abs();
                let size = (0.5 * found.sun.angular_diameter - radius).abs() / PITCH;
                let (filled, expected) = (found.rest.radiance(place), sky(place));
                let fill = (0..3).map(|c| (filled.channel(c) - expected.channel(c)).abs()).fold(0.0, f32::max);
                let colour = found.sun.irradiance.b / found.sun.irradiance.r;
                assert!((colour - 0.45).abs() < 1e-3, "{at}: blue over red {colour}");
                assert!(distance < 0.15, "{at}: found {distance} texels away");
                // The points of a texel tell the part of it that is covered; a few may be wrong along the whole edge.
                assert!(energy < 0.025, "{at}: energy off by {energy}");
                // A texel is up to 1.3 PITCH long, and a sun no smaller than it.
                assert!(size < 0.8, "{at}: radius off by {size} texels");
                assert!(fill < 0.02, "{at}: filled with {filled:?} instead of {expected:?}");
                for (worst, value) in worst.iter_mut().zip([distance, energy, size, f64::from(fill)]) {
                    *worst = worst.max(value);
                }
            }
        }
        println!("{mapping}: place {} texels, energy {}, size {}, fill {}", worst[0], worst[1], worst[2], worst[3]);
    }
}

#[test]
fn a_sun_of_one_texel_keeps_its_energy_and_its_place() {
    for place in places() {
        let mut map = EnvMap::from_fn(WIDTH, HEIGHT, sky);
        let (u, v) = lat_long::uv_from_dir(place);
        let (x, y) = (((u * 256.0) as usize).min(WIDTH - 1), ((v * 128.0) as usize).min(HEIGHT - 1));
        let texel = map.dir(x, y);
        // A texel at a pole is a hundredth of one at the equator: its sun is brighter.
        map.texels_mut()[y * WIDTH + x] = Rgb::new(1e5, 1e5, 1e5);
        let found = extract_sun(&map, &SunOptions::default()).unwrap_or_else(|| panic!("no sun at {place:?}"));
        let expected = (1e5 - f64::from(sky(texel).g)) * lat_long::solid_angle(WIDTH, HEIGHT, y);
        let error = (found.sun.irradiance.g / expected - 1.0).abs();
        let distance = found.sun.direction.angle_to(texel) / PITCH;
        assert!(error < 1e-4, "{place:?}: {} against {expected}", found.sun.irradiance.g);
        // A texel at a pole is a triangle: its centre of light lies a sixth of its height from the middle.
        assert!(distance < 0.17, "{place:?}: {distance} texels away");
    }
}

#[test]
fn the_sun_of_the_sunset_is_a_small_warm_light_over_the_horizon() {
    let map = bundled::sunset().map();
    let SunReport { sun, rest } = extract_sun(&map, &SunOptions::default()).unwrap();
    assert!(sun.direction.z() > 0.0 && sun.direction.z() < 0.15, "{:?}", sun.direction);
    assert!(sun.irradiance.r > sun.irradiance.b && sun.irradiance.b > 0.0, "{:?}", sun.irradiance);
    assert!(sun.angular_diameter.to_degrees() < 3.0, "{}", sun.angular_diameter.to_degrees());
    let brightest = |map: &MappedMap| map.texels().iter().map(|t| t.luminance()).fold(0.0, f32::max);
    assert!(brightest(&rest) < 0.2 * brightest(map.as_ref()), "{} of {}", brightest(&rest), brightest(map.as_ref()));
    assert!((sun.irradiance_at(sun.direction).g - sun.irradiance.g).abs() < 1e-12, "a surface that faces it");
    assert!(sun.irradiance_at(-sun.direction).g == 0.0, "a surface that faces away");
}

#[test]
fn maps_without_a_sun_have_none() {
    let none = |name: &str, map: &EnvMap| {
        let found = extract_sun(map, &SunOptions::default());
        assert!(found.is_none(), "{name}: {:?}", found.map(|found| found.sun));
    };
    none("a smooth sky", &EnvMap::from_fn(WIDTH, HEIGHT, sky));
    none("the night", &EnvMap::from_fn(WIDTH, HEIGHT, |_| Rgb::ZERO));
    none("a hemisphere", &EnvMap::from_fn(WIDTH, HEIGHT, |s| Rgb::splat(if s.z() > 0.0 { 9.0 } else { 0.0 })));
    let large = |s: Dir| Rgb::splat(if s.angle_to(Dir::Y) < 0.2 { 1000.0 } else { 0.1 });
    none("a soft box", &EnvMap::from_fn(WIDTH, HEIGHT, large));
    let cloud = |s: Dir| Rgb::splat(1.0 + 8.0 * (-(s.angle_to(Dir::X) / 0.05).powi(2)).exp() as f32);
    none("a bright place in the clouds", &EnvMap::from_fn(WIDTH, HEIGHT, cloud));
}
