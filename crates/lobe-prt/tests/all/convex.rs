//! Convex bodies whose normals tilt off their faces: no light comes through the faces, and none is reflected onto them.

use crate::common::{baked, options};
use lobe_io::Job;
use lobe_prt::{AdaptiveOptions, BakeMode, BakeOptions, Receivers, TexelReceivers, bake_matrices, split_adaptively};
use lobe_scene::{Bvh, Material, Mesh, MeshParts, Scene};
use lobe_sh::sphere::vector::{dot, normalized};

/// A white unit ball of 32 triangles with the normals of the sphere, each triangle in a lightmap by itself. If
/// `is_cut`, no two triangles share a vertex.
fn ball(is_cut: bool) -> Scene {
    let corners: [[f64; 3]; 6] =
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]];
    let middle = |a: [f64; 3], b: [f64; 3]| normalized([0, 1, 2].map(|k| a[k] + b[k]));
    let mut parts = MeshParts { material: Some(0), ..MeshParts::default() };
    for k in 0..4 {
        for (a, b, c) in [(k, (k + 1) % 4, 4), ((k + 1) % 4, k, 5)] {
            let [a, b, c] = [a, b, c].map(|i| corners[i]);
            let [x, y, z] = [middle(a, b), middle(b, c), middle(c, a)];
            for triangle in [[a, x, z], [x, b, y], [z, y, c], [x, y, z]] {
                let cell = parts.triangles.len();
                let indices = [0, 1, 2].map(|i| {
                    let p = triangle[i].map(|c| c as f32);
                    let known = parts.positions.iter().position(|&q| q == p).filter(|_| !is_cut);
                    known.unwrap_or_else(|| {
                        let [u, v] = [[0.1, 0.1], [0.9, 0.1], [0.1, 0.9]][i];
                        parts.positions.push(p);
                        parts.uvs[0].push([(cell % 6) as f32 + u, (cell / 6) as f32 + v].map(|c| c / 6.0));
                        parts.positions.len() - 1
                    }) as u32
                });
                parts.triangles.push(indices);
            }
        }
    }
    parts.normals = parts.positions.clone();
    let material = Material { double_sided: false, ..Material::matte("white", [1.0; 3]) };
    Scene::new(vec![Mesh::new(parts).unwrap()], vec![material], vec![]).unwrap()
}

/// The ball with its faces cut into 64 each: most vertices lie within faces.
fn finely_cut_ball() -> Scene {
    (0..3).fold(ball(false), |scene, _| scene.halve_edges(|_, _| true).unwrap().0)
}

/// The part of a constant sky that each receiver sends back, in both modes that trace rays.
fn sent(scene: &Scene, receivers: &Receivers) -> [Vec<f64>; 2] {
    [BakeMode::Shadowed, BakeMode::Interreflected].map(|mode| {
        let (transfer, _) = baked(scene, receivers, &options(mode, 1, 1024));
        transfer.coefficients().iter().map(|&t| f64::from(t) * (4.0 * std::f64::consts::PI).sqrt()).collect()
    })
}

#[test]
fn a_convex_body_has_the_same_transfer_with_and_without_reflections() {
    let cut = ball(true);
    let texels = TexelReceivers::new(&cut, 64).unwrap();
    let fine = finely_cut_ball();
    for (name, scene, receivers) in [
        ("vertices", ball(false), Receivers::at_vertices(&ball(false)).unwrap()),
        ("vertices at seams", ball(true), Receivers::at_vertices(&cut).unwrap()),
        ("vertices within faces", fine.clone(), Receivers::at_vertices(&fine).unwrap()),
        ("texels", cut.clone(), texels.receivers().clone()),
    ] {
        let [shadowed, interreflected] = sent(&scene, &receivers);
        for (i, (a, b)) in shadowed.iter().zip(&interreflected).enumerate() {
            let (p, n) = (receivers.positions()[i], receivers.normals()[i]);
            assert!((a - b).abs() < 1e-6, "{name}: shadowed {a}, interreflected {b} at {p:?}, normal {n:?}");
            assert!(!name.starts_with("vertices") || name.ends_with("faces") || *a > 0.999_999, "{name}: {a} at {p:?}");
        }
        let matrices = [BakeMode::Shadowed, BakeMode::Interreflected].map(|mode| {
            let options = options(mode, 2, 64);
            bake_matrices(&scene, &Bvh::new(&scene), &receivers, &options, Job::default()).unwrap().0
        });
        assert!(matrices[0] == matrices[1], "{name}: matrices with and without reflections");
    }
}

#[test]
fn within_a_face_the_part_of_the_sky_below_the_face_is_lost() {
    let scene = ball(true);
    let texels = TexelReceivers::new(&scene, 64).unwrap();
    let receivers = texels.receivers();
    let [shadowed, _] = sent(&scene, receivers);
    let (mut most, mut off, mesh) = (0.0_f64, 0.0, &scene.meshes()[0]);
    for (i, found) in shadowed.iter().enumerate() {
        let [a, b, c] = mesh.corners(texels.triangles()[i] as usize).map(|p| p.map(f64::from));
        // A face of a ball about the origin: its normal is that of the plane through its corners.
        let edge = |p: [f64; 3]| [0, 1, 2].map(|k| p[k] - a[k]);
        let [u, v] = [edge(b), edge(c)];
        let face = normalized([0, 1, 2].map(|k| u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3]));
        // The projection of the half disc below the plane is half an ellipse of semi-axes 1 and cos.
        let expected = 0.5 * (1.0 + dot(face, receivers.normals()[i].map(f64::from)));
        // Of 1024 points of a net few are on the wrong side of an arc.
        assert!((found - expected).abs() < 8e-3, "texel {i}: {found}, expected {expected}");
        most = most.max(1.0 - expected);
        off += (found - expected) / shadowed.len() as f64;
    }
    assert!(off.abs() < 2e-4, "off by {off} in the mean of {} texels", shadowed.len());
    assert!(most > 0.02, "at most {most} is lost: too little to tell");
}

#[test]
fn adaptive_splitting_finds_nothing_to_split_by_light_that_a_face_sends_itself() {
    let split = |mode| {
        let bake = BakeOptions::default().mode(mode).order(2).samples(256).energy_stop(0.0);
        let options = AdaptiveOptions::default().max_vertices(Some(300)).bake(bake);
        split_adaptively(&ball(false), &Bvh::new(&ball(false)), &options, Job::default()).unwrap().0
    };
    let [shadowed, interreflected] = [BakeMode::Shadowed, BakeMode::Interreflected].map(split);
    assert_eq!(shadowed.meshes(), interreflected.meshes(), "the same triangles in both modes");
    assert!(shadowed.triangle_count() > 100, "{} triangles: some were split", shadowed.triangle_count());
}
