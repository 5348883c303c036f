//! Maps in fewer texels, each the mean of those that it stands for.

use std::f64::consts::PI;

use lobe::env::{MappedMap, Mapping};
use lobe::sh::{Coefficient as _, Rgb};

/// A map with at most so many texels along each side; none if it has no more.
///
/// ```text
///   L'_t = Σ_s w_ts L_s / Σ_s w_ts        w_ts = Ω_s · the part of texel s that lies in t
/// ```
///
/// Each texel of the map is divided among those of the smaller one, so that a sun of one texel keeps its energy: exactly where the sides
/// are multiples, and in a lat-long map, whose rows are cut by solid angle, always; else up to the change of solid angles from one
/// texel to the next. A constant stays constant. [`lobe::env::resample()`] keeps more, in many passes, for which a window has no time.
pub(crate) fn shrunk(map: &MappedMap, most: usize) -> Option<MappedMap> {
    let factor = map.width().max(map.height()).div_ceil(most.max(1));
    if factor <= 1 {
        return None;
    }
    let width = (map.width() / factor).max(1);
    let faces = map.mapping().faces();
    let height = faces * (map.height() / faces / factor).max(1);
    let at = |c: f64, count: usize| ((c * count as f64) as usize).min(count - 1);
    Some(MappedMap::from_fn(map.mapping(), width, height, |s| {
        // The texel that this direction is the middle of.
        let (u, v) = map.mapping().uv_from_dir(s);
        mean_under(map, [width, height], [at(u, width), at(v, height)])
    }))
}

/// The mean of the texels of a map that lie under a texel of one of this size; black where all of it is outside the discs.
fn mean_under(map: &MappedMap, [width, height]: [usize; 2], [x, y]: [usize; 2]) -> Rgb<f32> {
    let is_lat_long = map.mapping() == Mapping::LatLong;
    let z = |row: f64| (PI * row / map.height() as f64).cos();
    let (mut sum, mut whole) = (Rgb::<f64>::ZERO, 0.0);
    for (row, [top, bottom]) in parts(y, height, map.height()) {
        let of_row = is_lat_long.then(|| z(top) - z(bottom));
        for (column, [left, right]) in parts(x, width, map.width()) {
            let of_row = of_row.unwrap_or_else(|| (bottom - top) * map.solid_angle(column, row));
            let weight = (right - left) * of_row;
            // Texels outside the discs may hold any value.
            if weight > 0.0 {
                sum += map.texel(column, row).widen().scale(weight);
                whole += weight;
            }
        }
    }
    if whole > 0.0 { Rgb::narrow(sum.scale(1.0 / whole)) } else { Rgb::ZERO }
}

/// The parts of texel `k` of a side of `count` in the texels of one of `of`: their numbers, and where each part begins and ends.
fn parts(k: usize, count: usize, of: usize) -> impl Iterator<Item = (usize, [f64; 2])> {
    let edge = |k: usize| k as f64 * of as f64 / count as f64;
    let (begin, end) = (edge(k), edge(k + 1));
    let last = (end.ceil() as usize).min(of);
    (begin as usize..last).map(move |s| (s, [begin.max(s as f64), end.min(s as f64 + 1.0)]))
}

#[cfg(test)]
mod tests {
    use lobe::sh::Dir;

    use super::*;

    #[test]
    fn skies_are_shrunk_to_the_sides_that_a_device_has_and_look_the_same() {
        let radiance = |s: Dir| Rgb::new(1.5 + s.x() as f32, 1.5 + s.y() as f32, 1.5 + s.z() as f32);
        for (mapping, width) in [(Mapping::LatLong, 130), (Mapping::Cube, 40), (Mapping::Octahedral, 130)] {
            let map = MappedMap::from_fn(mapping, width, mapping.height_for(width), radiance);
            let most = map.width().max(map.height());
            assert!(shrunk(&map, most).is_none(), "{mapping}: it fits");
            let smaller = shrunk(&map, most - 1).unwrap();
            assert!(smaller.width().max(smaller.height()) < most, "{mapping}: {}", smaller.height());
            for s in lobe_testkit::directions() {
                let s = Dir::new(s).unwrap();
                let [found, expected] = [&smaller, &map].map(|map| map.radiance(s).r);
                assert!((found - expected).abs() < 0.05, "{mapping} towards {s:?}: {found}, expected {expected}");
            }
        }
    }

    #[test]
    fn a_sun_of_one_texel_keeps_its_energy_wherever_it_is() {
        for (mapping, [width, height], most) in [
            (Mapping::LatLong, [128, 64], 64),
            // Neither side is a multiple.
            (Mapping::LatLong, [131, 67], 50),
            (Mapping::LatLong, [2, 300], 100),
            (Mapping::Cube, [16, 96], 50),
            (Mapping::Octahedral, [64, 64], 16),
            (Mapping::Angular, [64, 64], 32),
        ] {
            for place in [[0, 0], [width - 1, height - 1], [width / 2, 0], [0, height / 2], [width / 2, height / 2 - 1]]
            {
                let [x, y] = place;
                let mut map = MappedMap::from_fn(mapping, width, height, |_| Rgb::ZERO);
                if map.solid_angle(x, y) <= 0.0 {
                    continue;
                }
                map.texels_mut()[y * width + x] = Rgb::new(3e5, 2e5, 1e5);
                let smaller = shrunk(&map, most).unwrap();
                assert!(smaller.width().max(smaller.height()) <= most, "{mapping}: {}", smaller.height());
                let [found, expected] = [&smaller, &map].map(|map| map.mean().r);
                let is_kept = (found / expected - 1.0).abs() < 1e-6;
                assert!(is_kept, "{mapping} {width} x {height} at {place:?}: a mean of {found}, not {expected}");
            }
        }
    }

    #[test]
    fn constants_stay_constant_whatever_lies_outside_the_discs() {
        for (mapping, width) in [(Mapping::LatLong, 131), (Mapping::Angular, 61), (Mapping::MirrorBall, 61)] {
            let mut map = MappedMap::from_fn(mapping, width, mapping.height_for(width), |_| Rgb::splat(0.7));
            let outside: Vec<usize> =
                (0..width * map.height()).filter(|k| map.solid_angle(k % width, k / width) <= 0.0).collect();
            outside.iter().for_each(|k| map.texels_mut()[*k] = Rgb::splat(f32::NAN));
            let smaller = shrunk(&map, 20).unwrap();
            for (k, texel) in smaller.texels().iter().enumerate() {
                let [x, y] = [k % smaller.width(), k / smaller.width()];
                let is_outside = smaller.solid_angle(x, y) <= 0.0;
                let is_same = (texel.r - 0.7).abs() < 1e-6;
                assert!(is_same || is_outside, "{mapping}, texel {x}, {y}: {texel:?}");
            }
        }
    }
}
