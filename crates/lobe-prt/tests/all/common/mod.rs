//! Scenes with a closed form, for the tests of baking.

#![allow(dead_code, reason = "tests, each of which uses a part")]

use std::f64::consts::{PI, TAU};

use lobe_io::Job;
use lobe_prt::{BakeMode, BakeOptions, BakeReport, Channels, Receivers, Transfer, bake};
use lobe_scene::{Bvh, Material, Mesh, MeshParts, Scene};
use lobe_sh::Zonal;

pub(crate) fn baked(scene: &Scene, receivers: &Receivers, options: &BakeOptions) -> (Transfer, BakeReport) {
    bake(scene, &Bvh::new(scene), receivers, options, Job::default()).unwrap()
}

pub(crate) fn options(mode: BakeMode, order: usize, samples: u32) -> BakeOptions {
    BakeOptions::default().mode(mode).order(order).samples(samples).bounces(3).energy_stop(0.0).seed(1)
}

/// One white receiver.
pub(crate) fn receiver(position: [f32; 3], normal: [f32; 3]) -> Receivers {
    Receivers::new(vec![position], vec![normal], vec![[1.0; 3]]).unwrap()
}

/// One mesh of a matte material of this albedo.
pub(crate) fn scene_of(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>, albedo: f32, double_sided: bool) -> Scene {
    let parts = MeshParts { positions, triangles, material: Some(0), ..MeshParts::default() };
    let material = Material { double_sided, ..Material::matte("matte", [albedo; 3]) };
    Scene::new(vec![Mesh::new(parts).unwrap()], vec![material], vec![]).unwrap()
}

/// A surface of revolution about z through circles of these radii and heights, of `sides` sides, facing the axis if
/// heights ascend.
pub(crate) fn revolved(profile: &[(f64, f64)], sides: u32, albedo: f32) -> Scene {
    let mut positions = Vec::new();
    for &(r, z) in profile {
        for k in 0..sides {
            let (sin, cos) = (TAU * f64::from(k) / f64::from(sides)).sin_cos();
            positions.push([(r * cos) as f32, (r * sin) as f32, z as f32]);
        }
    }
    let mut triangles = Vec::new();
    for ring in 0..profile.len() as u32 - 1 {
        for k in 0..sides {
            let [a, b] = [k, (k + 1) % sides].map(|k| ring * sides + k);
            triangles.extend([[a, a + sides, b], [b, a + sides, b + sides]]);
        }
    }
    scene_of(positions, triangles, albedo, true)
}

/// Transfer of a white receiver that sees exactly the cone of this cosine about its normal: `1/π ∫ t P_l(t)`, as
/// a zonal function. By a quadrature that is exact for it.
pub(crate) fn cone_transfer(order: usize, cosine: f64) -> Zonal {
    Zonal::project(order, &[cosine], 16, |t| if t > cosine { t / PI } else { 0.0 })
}

/// The largest difference of two vectors.
pub(crate) fn largest_difference(found: &[f32], expected: &[f64]) -> f64 {
    assert_eq!(found.len(), expected.len(), "coefficients");
    found.iter().zip(expected).map(|(a, b)| (f64::from(*a) - b).abs()).fold(0.0, f64::max)
}

pub(crate) fn is_gray(transfer: &Transfer) -> bool {
    transfer.channels() == Channels::Gray
}
