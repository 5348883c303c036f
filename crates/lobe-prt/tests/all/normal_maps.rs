//! Normal maps at the texels of a lightmap.

use std::f64::consts::PI;

use crate::common::{baked, options};
use lobe_io::Job;
use lobe_prt::{BakeMode, Receivers, TexelReceivers, bake_on_disk, scene_hash};
use lobe_scene::{Bvh, Material, Mesh, MeshParts, NormalMap, Scene, Texture, TextureUse, Wrap};
use lobe_sh::sphere::vector::normalized;
use lobe_testkit::Random;

/// Texels along a side of the normal map, and of the lightmap.
const SIDE: usize = 8;

/// A texel that tilts nothing, but for the half that eight bits do not hold.
const FLAT: [u8; 4] = [128, 128, 255, 255];

/// A white square of side 2 that faces up, x along u and y against v, with a normal map over all of it.
fn square(texels: Vec<[u8; 4]>, scale: f32) -> Scene {
    let uvs = vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
    let parts = MeshParts {
        positions: vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        uvs: [uvs, vec![]],
        material: Some(0),
        ..MeshParts::default()
    };
    let used = TextureUse { texture: 0, uv_set: 0, uv_map: TextureUse::UV_UNCHANGED };
    let material = Material { normal_map: Some(NormalMap { used, scale }), ..Material::WHITE };
    let texture = Texture::new(SIDE, texels.len() / SIDE, texels, [Wrap::Clamp; 2]);
    Scene::new(vec![Mesh::new(parts).unwrap().with_tangents(0)], vec![material], vec![texture]).unwrap()
}

/// The unit normal of a texel on the square.
fn normal_of([x, y, z, _]: [u8; 4]) -> [f64; 3] {
    normalized([x, y, z].map(|c| 2.0 * f64::from(c) / 255.0 - 1.0))
}

#[test]
fn a_bump_of_the_normal_map_is_in_its_texels_and_in_no_others() {
    let mut random = Random::new(3);
    let mut texels = vec![FLAT; SIDE * SIDE];
    let is_bump = |i: usize| (2..5).contains(&(i % SIDE)) && (3..6).contains(&(i / SIDE));
    for (i, texel) in texels.iter_mut().enumerate().filter(|(i, _)| is_bump(*i)) {
        *texel = [(256.0 * random.unit()) as u8, (20 * i % 256) as u8, 200, 255];
    }
    let scene = square(texels.clone(), 1.0);
    let found = TexelReceivers::new(&scene, SIDE).unwrap();
    assert_eq!(found.texels().len(), SIDE * SIDE, "all texels are of the square");
    let [(bumped, _), (plain, _)] = [&scene, &square(vec![FLAT; SIDE * SIDE], 1.0)].map(|scene| {
        let texels = TexelReceivers::new(scene, SIDE).unwrap();
        baked(scene, texels.receivers(), &options(BakeMode::Unshadowed, 2, 1))
    });
    for (i, &texel) in found.texels().iter().enumerate() {
        let (n, expected) = (found.receivers().normals()[i].map(f64::from), normal_of(texels[texel as usize]));
        let off = (0..3).map(|k| (n[k] - expected[k]).abs()).fold(0.0, f64::max);
        assert!(off < 1e-5, "texel {texel}: {n:?}, expected {expected:?}");
        // The functions of band 1 are those of (-y, z, -x), which the cosine multiplies by 2/3.
        let (c, flat) = (bumped.vector(i, 0), plain.vector(i, 0));
        let factor = 2.0 / 3.0 * (3.0 / (4.0 * PI)).sqrt();
        for (k, along) in [-n[1], n[2], -n[0]].into_iter().enumerate() {
            assert!((f64::from(c[k + 1]) - factor * along).abs() < 1e-6, "texel {texel}: {c:?}");
        }
        let change = c.iter().zip(flat).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert_eq!(is_bump(texel as usize), change > 1e-2, "texel {texel} changes by {change}");
    }
}

/// Normals of the map from straight up to below the face.
fn tilts() -> Vec<[u8; 4]> {
    let mut texels = vec![FLAT; SIDE * SIDE];
    for (i, texel) in texels.iter_mut().enumerate() {
        let angle = 2.4 * i as f64 / (SIDE * SIDE) as f64;
        let [x, z] = [angle.sin(), angle.cos()].map(|c| (127.5 * (c + 1.0)).round() as u8);
        *texel = [x, 128, z, 255];
    }
    texels
}

#[test]
fn what_is_below_the_face_is_lost_however_far_the_map_tilts_with_and_without_reflections() {
    let scene = square(tilts(), 1.0);
    let texels = TexelReceivers::new(&scene, SIDE).unwrap();
    let front = texels.receivers();
    let all: Vec<usize> = (0..front.len()).collect();
    for (side, receivers, face) in [("front", front.clone(), 1.0), ("back", front.backs(&all).unwrap(), -1.0)] {
        let sent = [BakeMode::Shadowed, BakeMode::Interreflected].map(|mode| {
            let (transfer, _) = baked(&scene, &receivers, &options(mode, 1, 4096));
            transfer.coefficients().iter().map(|&t| f64::from(t) * (4.0 * PI).sqrt()).collect::<Vec<_>>()
        });
        for (i, (a, b)) in sent[0].iter().zip(&sent[1]).enumerate() {
            // Half a disc, and half an ellipse of the axes 1 and cos, which is taken off where the normal is below the face.
            let cos = face * f64::from(receivers.normals()[i][2]);
            let expected = 0.5 * (1.0 + cos);
            assert!((a - expected).abs() < 8e-3, "{side}, receiver {i}: {a}, expected {expected} at cosine {cos}");
            assert!((a - b).abs() < 1e-6, "{side}, receiver {i}: shadowed {a}, interreflected {b}");
        }
    }
    let lowest = front.normals().iter().map(|n| n[2]).fold(1.0, f32::min);
    assert!(lowest < -0.7, "the lowest normal points down by {lowest}");
}

#[test]
fn transfer_at_vertices_holds_no_normal_map() {
    let scene = square(tilts(), 1.0);
    let [found, expected] = [scene.clone(), scene.without_normal_maps()].map(|s| Receivers::at_vertices(&s).unwrap());
    assert_eq!(found, expected, "receivers");
}

#[test]
fn fingerprints_and_checkpoints_tell_normal_maps_apart() {
    let scene = square(tilts(), 1.0);
    let mut other = tilts();
    other[5][0] ^= 1;
    let (meshes, materials, textures) = scene.clone().into_parts();
    let mut parts = meshes[0].clone().into_parts();
    parts.tangents[0][1][3] = -1.0;
    let turned = Scene::new(vec![Mesh::new(parts).unwrap()], materials, textures).unwrap();
    let others = [
        ("the scale", square(tilts(), 0.5)),
        ("a texel", square(other, 1.0)),
        ("a tangent", turned),
        ("no map", scene.clone().without_normal_maps()),
    ];
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.lobe-partial");
    let bake = |scene: &Scene| {
        let receivers = Receivers::at_vertices(scene).unwrap();
        let options = options(BakeMode::Shadowed, 1, 4);
        let job = Job::default().kept_in(&path);
        bake_on_disk(scene, &Bvh::new(scene), &receivers, &options, job).map(drop)
    };
    bake(&scene).unwrap();
    bake(&square(tilts(), 1.0)).unwrap();
    for (what, other) in others {
        assert_ne!(scene_hash(&other), scene_hash(&scene), "{what}");
        let refusal = bake(&other).unwrap_err().to_string();
        assert!(refusal.contains("this checkpoint is of another bake"), "{what}: {refusal}");
    }
}
