//! Lightmaps of unwrapped scenes: seams, noise, closed rooms.

use std::collections::HashMap;

use crate::common::{baked, options, revolved};
use lobe_io::Job;
use lobe_prt::{BakeMode, Channels, FinishOptions, Lightmap, TexelReceivers, Transfer};
use lobe_scene::{Hit, Mesh, Scene, UnwrapOptions, built_in};
use lobe_testkit::Random;

/// A triangle, two of its corners, and their places in the lightmap.
type Side = (usize, [usize; 2], [[f32; 2]; 2]);

const NOTHING: [bool; 2] = [false, false];

fn unwrapped(scene: &Scene, texels: usize) -> Scene {
    scene.unwrapped(&UnwrapOptions::default().texels(texels), Job::default()).unwrap().0
}

fn finish([denoise, stitch]: [bool; 2]) -> FinishOptions {
    FinishOptions::default().denoise(denoise).stitch(stitch)
}

/// The meshes of a scene alone, in white.
fn white(scene: &Scene, keeps: impl Fn(&Mesh) -> bool) -> Scene {
    let parts = scene.meshes().iter().filter(|mesh| keeps(mesh)).map(|mesh| mesh.clone().into_parts());
    let meshes = parts.map(|mut parts| {
        parts.material = None;
        Mesh::new(parts).unwrap()
    });
    Scene::new(meshes.collect(), vec![], vec![]).unwrap()
}

/// The largest and the mean value of |a - b| / mean at random places of the edges that have two places in the lightmap,
/// by a look at the picture from both.
fn steps_at_seams(scene: &Scene, texels: &TexelReceivers, transfer: &Transfer) -> (f64, f64, usize) {
    const PLACES: usize = 9;
    let mut random = Random::new(5);
    let (picture, lightmap) = (texels.picture(transfer).unwrap(), Lightmap::new(scene, texels.width()).unwrap());
    let shown = |triangle: usize, weights: [f64; 3]| {
        let hit = Hit { t: 0.0, triangle: triangle as u32, u: weights[1] as f32, v: weights[2] as f32 };
        let texels = lightmap.texels_at(scene, &hit).into_iter();
        texels.map(|(texel, part)| f64::from(picture.vector(texel, 0)[0]) * part).sum::<f64>()
    };
    let mean = (0..transfer.receivers()).map(|i| f64::from(transfer.vector(i, 0)[0])).sum::<f64>()
        / transfer.receivers() as f64;
    let mut sides: HashMap<[[u32; 6]; 2], Vec<Side>> = HashMap::new();
    for triangle in 0..scene.triangle_count() {
        let (mesh, number) = scene.locate(triangle);
        let mesh = &scene.meshes()[mesh];
        let corners = mesh.triangles()[number];
        for [i, j] in [[0, 1], [1, 2], [2, 0]] {
            let end = |k: usize| {
                let (p, n) = (mesh.positions()[corners[k] as usize], mesh.normals()[corners[k] as usize]);
                std::array::from_fn(|c| (if c < 3 { p[c] } else { n[c - 3] } + 0.0).to_bits())
            };
            let (a, b): ([u32; 6], [u32; 6]) = (end(i), end(j));
            let order = if a < b { [i, j] } else { [j, i] };
            let uvs = order.map(|k| mesh.lightmap_uvs()[corners[k] as usize]);
            sides.entry([a.min(b), a.max(b)]).or_default().push((triangle, order, uvs));
        }
    }
    let (mut largest, mut sum, mut count) = (0.0_f64, 0.0, 0);
    for pair in sides.values().filter(|sides| sides.len() == 2 && sides[0].2 != sides[1].2) {
        for _ in 0..PLACES {
            let part = random.unit();
            let [a, b] = [pair[0], pair[1]].map(|(triangle, order, _)| {
                let mut weights = [0.0; 3];
                (weights[order[0]], weights[order[1]]) = (1.0 - part, part);
                shown(triangle, weights)
            });
            let step = (a - b).abs() / mean;
            (largest, sum, count) = (largest.max(step), sum + step, count + 1);
        }
    }
    (largest, sum / count.max(1) as f64, count / PLACES)
}

#[test]
fn light_has_no_step_where_charts_cut_a_smooth_surface() {
    for (name, scene, width) in [
        ("ball", white(&built_in::ball_over_ground(16), |_| true), 96),
        ("tube", revolved(&[(1.0, 0.0), (1.2, 1.0), (0.8, 2.0)], 24, 0.5), 96),
    ] {
        let scene = unwrapped(&scene, width);
        let texels = TexelReceivers::new(&scene, width).unwrap();
        let (transfer, _) = baked(&scene, texels.receivers(), &options(BakeMode::Shadowed, 2, 64));
        let (before, ..) = steps_at_seams(&scene, &texels, &transfer);
        for stitched in [[false, true], [true, true]] {
            let (after, report) = texels.finished(&scene, transfer.clone(), &finish(stitched)).unwrap();
            let (largest, mean, seams) = steps_at_seams(&scene, &texels, &after);
            assert_eq!(seams, report.seams, "{name}: seams");
            assert!(seams > 2 && mean < 2e-3, "{name} {stitched:?}: {seams} seams, steps of {mean} on average");
            assert!(largest < 0.01, "{name} {stitched:?}: a step of {largest}, {before} before");
        }
    }
}

#[test]
fn planted_noise_is_found_and_most_of_it_goes() {
    const WIDTH: usize = 48;
    // A square in the middle of which light falls to a half, sharply.
    let ground = unwrapped(&white(&built_in::ball_over_ground(4), |mesh| mesh.positions().len() == 25), WIDTH);
    let texels = TexelReceivers::new(&ground, WIDTH).unwrap();
    let truth = |i: usize| {
        let [x, y, _] = texels.receivers().positions()[i];
        let light = if x.hypot(y) < 1.5 { 0.5 } else { 1.0 };
        [light, 0.01 * x, 0.3 * light, 0.005 * y]
    };
    let count = texels.receivers().len();
    let transfer_of = |noise: f64| {
        let mut random = Random::new(9);
        let mut gauss = || (0..12).map(|_| random.unit()).sum::<f64>() - 6.0;
        let values = (0..count).flat_map(truth).map(|t| (f64::from(t) + noise * gauss()) as f32).collect();
        Transfer::new(2, Channels::Gray, values).unwrap()
    };
    let error = |transfer: &Transfer| {
        let of =
            |i: usize| truth(i).iter().zip(transfer.vector(i, 0)).map(|(t, v)| f64::from(t - v).powi(2)).sum::<f64>();
        ((0..count).map(of).sum::<f64>() / (4 * count) as f64).sqrt()
    };
    // Where the border of the shadow turns, the least of four differences takes a part of it for noise.
    let (clean, _) = texels.finished(&ground, transfer_of(0.0), &finish([true, false])).unwrap();
    assert!(error(&clean) < 5e-3, "without noise: {}", error(&clean));
    for noise in [0.005, 0.02, 0.05] {
        let noisy = transfer_of(noise);
        let (found, _) = texels.finished(&ground, noisy.clone(), &finish([true, false])).unwrap();
        let (before, after) = (error(&noisy), error(&found));
        assert!(after < 0.5 * before, "noise of {noise}: {before} before, {after} after");
        let same = texels.finished(&ground, noisy.clone(), &finish(NOTHING)).unwrap().0;
        assert!(same == noisy, "nothing to do");
    }
}

#[test]
fn denoising_brings_baked_texels_nearer_to_the_truth_at_any_number_of_paths() {
    const WIDTH: usize = 40;
    let scene = unwrapped(&white(&built_in::ball_over_ground(12), |_| true), WIDTH);
    let texels = TexelReceivers::new(&scene, WIDTH).unwrap();
    let of = |samples| baked(&scene, texels.receivers(), &options(BakeMode::Shadowed, 3, samples)).0;
    let truth = of(1 << 14);
    let error = |transfer: &Transfer| {
        let pairs = truth.coefficients().iter().zip(transfer.coefficients());
        let of = |a: &f32| f64::from(*a).powi(2);
        let sum: f64 = pairs.map(|(t, v)| of(&(t - v))).sum();
        (sum / truth.coefficients().iter().map(of).sum::<f64>()).sqrt()
    };
    for samples in [64, 256, 1024] {
        let before = of(samples);
        let (after, _) = texels.finished(&scene, before.clone(), &finish([true, false])).unwrap();
        let [before, after] = [&before, &after].map(error);
        assert!(after < before, "{samples} paths: {before} before, {after} after");
    }
}

#[test]
fn a_closed_room_that_was_unwrapped_stays_black_at_any_density() {
    for scene in [built_in::closed_white_box(1), built_in::closed_white_box(3)] {
        for width in [16, 40, 100, 256] {
            let scene = unwrapped(&scene, width);
            let texels = TexelReceivers::new(&scene, width).unwrap();
            let (transfer, _) = baked(&scene, texels.receivers(), &options(BakeMode::Shadowed, 1, 64));
            let (finished, _) = texels.finished(&scene, transfer, &finish([true, true])).unwrap();
            let picture = texels.picture(&finished).unwrap();
            let brightest = picture.coefficients().iter().fold(0.0_f32, |most, c| most.max(c.abs()));
            assert!(brightest < 1e-3, "{width} texels: {brightest}");
        }
    }
}
