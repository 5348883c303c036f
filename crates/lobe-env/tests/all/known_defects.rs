//! Regressions against defects of other tools: mirrored cubes, wrong axes, half-texel shifts, seams and lost suns.
use std::f64::consts::PI;

use lobe_env::{CubeMap, MappedMap, Mapping, Resample, project_map, resample};
use lobe_io::Job;
use lobe_sh::{Dir, Rgb};

fn size(mapping: Mapping, texels: f64) -> Resample {
    let aspect = mapping.height_for(12) as f64 / 12.0;
    let width = (texels / aspect).sqrt().round() as usize;
    Resample::to(mapping, width, mapping.height_for(width))
}

/// A patch of light of the radius 0.15 towards `d`.
fn patch(d: Dir) -> impl Fn(Dir) -> Rgb<f32> + Sync {
    move |s| if s.angle_to(d) < 0.15 { Rgb::new(1.0, 1.0, 1.0) } else { Rgb::new(0.0, 0.0, 0.0) }
}

#[test]
fn no_map_is_mirrored_or_has_other_axes() {
    // Far from the rims of the balls, and at least 0.3 from all its images.
    let v = [0.42, -0.2, 0.85];
    for from in Mapping::ALL {
        let Resample { width, height, .. } = size(from, 3_000.0);
        let source = MappedMap::from_fn(from, width, height, patch(Dir::new(v).unwrap()));
        for there in Mapping::ALL {
            let map = resample(&source, &size(there, 3_000.0), Job::default()).unwrap();
            // All 48 mirror images and permutations of the axes.
            for image in 0..48 {
                let order = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [1, 0, 2], [0, 2, 1], [2, 1, 0]][image / 8];
                let sign = |k: usize| if image >> k & 1 == 0 { 1.0 } else { -1.0 };
                let s = Dir::new([0, 1, 2].map(|k| sign(k) * v[order[k]])).unwrap();
                let (found, expected) = (map.radiance(s).g, patch(Dir::new(v).unwrap())(s).g);
                assert!((found - expected).abs() < 0.2, "{from} to {there}, image {image}: {found}, not {expected}");
            }
        }
    }
}

#[test]
fn cubes_have_each_axis_on_its_face() {
    for (k, axis) in [Dir::X, -Dir::X, Dir::Z, -Dir::Z, -Dir::Y, Dir::Y].into_iter().enumerate() {
        let source = MappedMap::from_fn(Mapping::LatLong, 128, 64, patch(axis));
        let cube: CubeMap =
            resample(&source, &Resample::to(Mapping::Cube, 15, 90), Job::default()).unwrap().into_cube_map().unwrap();
        for face in 0..6 {
            let expected = if face == k { 1.0 } else { 0.0 };
            let found = cube.texel(face, 7, 7).g;
            assert!((found - expected).abs() < 1e-3, "light towards {axis:?}, face {face}: {found}");
        }
    }
}

#[test]
fn nothing_shifts_by_half_a_texel() {
    let d = Dir::new([0.3, -0.8, 0.4]).unwrap();
    let texels = 1_500.0;
    let half = 0.5 * (4.0 * PI / texels).sqrt();
    let towards = |map: &MappedMap| {
        let f = project_map(map, 2);
        Dir::new([-f[3].g, -f[1].g, f[2].g]).unwrap()
    };
    for from in Mapping::ALL {
        let Resample { width, height, .. } = size(from, texels);
        let lobe = |s: Dir| Rgb::new(1.0, (4.0 * (s.dot(d) - 1.0)).exp() as f32, 1.0);
        let source = MappedMap::from_fn(from, width, height, lobe);
        let before = towards(&source);
        for there in Mapping::ALL {
            for texels in [0.7 * texels, 1.6 * texels] {
                let map = resample(&source, &size(there, texels), Job::default()).unwrap();
                let moved = towards(&map).angle_to(before) / half;
                assert!(moved < 0.15, "{from} to {there} of {texels}: moved by {moved} of half a texel");
            }
        }
    }
}
