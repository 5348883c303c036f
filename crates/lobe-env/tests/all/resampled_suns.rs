//! Resampling of suns: small bright lights keep their energy and their place through every pair of mappings.

use std::f64::consts::PI;

use lobe_env::{MappedMap, Mapping, Resample, project_map, resample};
use lobe_io::Job;
use lobe_sh::{Coefficient, Dir, Rgb, Rotation, ShVec};
use lobe_testkit::Random;

use crate::resampling::{half_texel, size, to};

/// Critical directions: poles, seams, edges, corners, rims.
fn hard_places() -> Vec<Dir> {
    let mut places = vec![Dir::X, -Dir::X, Dir::Y, -Dir::Y, Dir::Z, -Dir::Z];
    for v in
        [[1.0, 1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, 0.0], [-1.0, 0.01, 0.5], [0.0, 0.7, -0.7], [0.3, 0.2, -0.9]]
    {
        places.extend(Dir::new(v));
    }
    places
}

/// The energy of a channel and the direction of its centroid.
fn energy_and_center(f: &ShVec<Rgb<f64>>, channel: usize) -> (f64, Dir) {
    let [f0, f1, f2, f3] = [0, 1, 2, 3].map(|i| f[i].channel(channel));
    ((4.0 * PI).sqrt() * f0, Dir::new([-f3, -f1, f2]).expect("a sun has a direction"))
}

/// The change of suns of one texel, one in each channel: the relative error of each energy, and its displacement in
/// units of half a texel of the source or the target, whichever is larger there.
fn fate_of_suns(from: Mapping, (w, h): (usize, usize), places: [Dir; 3], to: &Resample) -> [(f64, f64); 3] {
    let mut source = MappedMap::from_fn(from, w, h, |_| Rgb::new(0.0, 0.0, 0.0));
    for (channel, place) in places.into_iter().enumerate() {
        let (x, y) = source.texel_at(place);
        let sun = Rgb::from_channels(|c| if c == channel { 1e4 } else { 0.0 });
        source.texels_mut()[y * w + x] += sun;
    }
    let map = resample(&source, to, Job::default()).unwrap();
    let (before, after) = (project_map(&source, 2), project_map(&map, 2));
    [0, 1, 2].map(|channel| {
        let ((energy, center), (found, moved)) =
            (energy_and_center(&before, channel), energy_and_center(&after, channel));
        let expected = to.rotation.as_ref().map_or(center, |r| r.rotate_dir(center));
        let half = half_texel(&source, center).max(half_texel(&map, expected));
        ((found / energy - 1.0).abs(), expected.angle_to(moved) / half)
    })
}

/// Follows suns and panics where one is lost.
#[derive(Default)]
struct Suns {
    worst: (f64, String),
    farthest: (f64, String),
    failures: Vec<String>,
}

impl Suns {
    fn follow(&mut self, from: Mapping, size: (usize, usize), places: [Dir; 3], to: &Resample) {
        for (place, (error, distance)) in places.into_iter().zip(fate_of_suns(from, size, places, to)) {
            let name = format!(
                "{from} {size:?} to {} ({}, {}), {:?}, sun at {:?}",
                to.mapping,
                to.width,
                to.height,
                to.rotation.is_some(),
                place.to_array()
            );
            if error > 0.01 || distance > 1.0 {
                self.failures.push(format!("{name}: energy off by {error:.1e}, moved by {distance:.2} half texels"));
            }
            if error > self.worst.0 {
                self.worst = (error, name.clone());
            }
            if distance > self.farthest.0 {
                self.farthest = (distance, name);
            }
        }
    }

    fn report(&self) {
        println!("worst energy {:.1e}: {}", self.worst.0, self.worst.1);
        println!("farthest {:.2} half texels: {}", self.farthest.0, self.farthest.1);
        assert!(self.failures.is_empty(), "{} suns:\n{}", self.failures.len(), self.failures.join("\n"));
    }
}

#[test]
fn a_sun_of_one_texel_keeps_energy_and_place_through_every_pair_of_mappings() {
    let texels = 600;
    let mut suns = Suns::default();
    for from in Mapping::ALL {
        for there in Mapping::ALL {
            for places in hard_places().chunks_exact(3) {
                suns.follow(from, size(from, texels), [places[0], places[1], places[2]], &to(there, texels));
            }
        }
    }
    suns.report();
}

#[test]
#[ignore = "long: of the nightly group"]
fn a_sun_anywhere_keeps_energy_and_place_at_other_sizes_and_turned() {
    let mut random = Random::new(21);
    let mut suns = Suns::default();
    let turns = [
        Rotation::from_axis_angle(Dir::from_angles(1.0, 2.0), 0.9),
        Rotation::from_axis_angle(Dir::Z, 0.3),
        Rotation::from_axis_angle(Dir::from_angles(2.0, 0.4), 2.5),
    ];
    for from in Mapping::ALL {
        for there in Mapping::ALL {
            for (texels, target) in [(900, 130), (150, 1_100)] {
                let places = [(); 3]
                    .map(|()| Dir::new([random.signed(), random.signed(), random.signed()]).expect("not the origin"));
                let to = to(there, target);
                let turn = turns[(texels + there as usize) % turns.len()];
                suns.follow(from, size(from, texels), places, &to);
                suns.follow(from, size(from, texels), places, &to.rotated(turn));
            }
        }
    }
    suns.report();
}

#[test]
fn shrinking_keeps_a_small_sun() {
    let mut source = MappedMap::from_fn(Mapping::LatLong, 256, 128, |_| Rgb::new(0.1, 0.1, 0.1));
    source.texels_mut()[20 * 256 + 3] = Rgb::new(0.0, 1e5, 0.0);
    let mean = source.mean().g;
    for mapping in Mapping::ALL {
        for texels in [6, 60, 600] {
            let small = resample(&source, &to(mapping, texels), Job::default()).unwrap();
            let error = (small.mean().g / mean - 1.0).abs();
            assert!(error < 0.01, "{mapping} of {texels} texels: {error:e}");
        }
    }
}
