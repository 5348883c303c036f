//! Holes of alpha masks: the light through them, in closed form.

use std::f64::consts::PI;

use crate::common::{baked, cone_transfer, largest_difference, options, receiver, revolved};
use lobe_prt::BakeMode;
use lobe_scene::{Alpha, Material, Mesh, MeshParts, Scene, Texture, TextureUse, Wrap};
use lobe_sh::{Dir, Expansion as _};

/// Texels along a side of the mask.
const TEXELS: usize = 256;

/// Radius of the hole, and the height at which it is.
const RADIUS: f64 = 0.6;
const HEIGHT: f32 = 1.0;

/// Alpha around a circle of [`RADIUS`] in the square from -1 to 1: it passes one half there, and rises so slowly that
/// the circle is found between texels.
fn circle() -> Texture {
    let ramp = 8.0 * 2.0 / TEXELS as f64;
    let place = |k: usize| 2.0 * (k as f64 + 0.5) / TEXELS as f64 - 1.0;
    let alpha = |x: f64, y: f64| (0.5 + (x.hypot(y) - RADIUS) / ramp).clamp(0.0, 1.0);
    let texel = |k: usize| [255, 255, 255, (255.0 * alpha(place(k % TEXELS), place(k / TEXELS))).round() as u8];
    Texture::new(TEXELS, TEXELS, (0..TEXELS * TEXELS).map(texel).collect(), [Wrap::Clamp; 2])
}

/// A black room, two wide, below a white lid with that hole.
fn room(alpha: Alpha) -> Scene {
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0_f32]];
    let at = |z: f32| corners.map(|[x, y]| [x, y, z]);
    let walls = MeshParts {
        positions: [at(0.0), at(HEIGHT)].concat(),
        triangles: [[0, 1, 2], [0, 2, 3]]
            .into_iter()
            .chain((0..4).flat_map(|k| [[k, (k + 1) % 4, k + 4], [(k + 1) % 4, (k + 1) % 4 + 4, k + 4]]))
            .collect(),
        material: Some(0),
        ..MeshParts::default()
    };
    let lid = MeshParts {
        positions: at(HEIGHT).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        uvs: [corners.map(|c| c.map(|x| 0.5 * (x + 1.0))).to_vec(), vec![]],
        material: Some(1),
        ..MeshParts::default()
    };
    let used = TextureUse { texture: 0, uv_set: 0, uv_map: TextureUse::UV_UNCHANGED };
    let materials =
        vec![Material::matte("black", [0.0; 3]), Material { alpha, base_color_texture: Some(used), ..Material::WHITE }];
    let meshes = [walls, lid].map(|parts| Mesh::new(parts).unwrap());
    Scene::new(meshes.to_vec(), materials, vec![circle()]).unwrap()
}

#[test]
fn a_round_hole_in_a_mask_lets_in_the_light_of_its_cone() {
    let below = receiver([0.0; 3], [0.0, 0.0, 1.0]);
    let expected = cone_transfer(6, f64::from(HEIGHT) / RADIUS.hypot(f64::from(HEIGHT))).towards(Dir::Z, 1.0);
    for mode in [BakeMode::Shadowed, BakeMode::Interreflected] {
        // Black walls reflect nothing, and the lid sees nothing else.
        let options = options(mode, 6, 1 << 14).bounces(2);
        let (transfer, report) = baked(&room(Alpha::Mask(0.5)), &below, &options);
        let difference = largest_difference(transfer.vector(0, 0), expected.coefficients());
        assert!(difference < 1e-3, "{mode:?}: largest difference of a coefficient {difference}, {report:?}");
        let (closed, _) = baked(&room(Alpha::Opaque), &below, &options.samples(256));
        assert!(closed.coefficients().iter().all(|&t| t == 0.0), "{mode:?}: without the mask no light comes in");
    }
}

#[test]
fn a_sphere_with_a_masked_cap_has_the_closed_form_of_every_bounce() {
    // From each point of a sphere the part f of a cosine-weighted hemisphere is seen of a cap that has this part of the
    // area: T_0 = y_0 ρ f Σ_b (ρ (1-f))^b. Alpha is linear in z between vertices, so the cap ends at a plane.
    const RINGS: u32 = 96;
    let (f, rho) = (0.25_f64, 0.8_f64);
    let end_of_cap = 1.0 - 2.0 * f;
    let circle = |k: u32| {
        let theta = PI * (1.0 - f64::from(k) / f64::from(RINGS));
        (theta.sin().max(1e-6), theta.cos())
    };
    let profile: Vec<_> = (0..=RINGS).map(circle).collect();
    let (meshes, mut materials, _) = revolved(&profile, 2 * RINGS, rho as f32).into_parts();
    let mut parts = meshes.into_iter().next().unwrap().into_parts();
    parts.colors = parts.positions.iter().map(|p| [1.0, 1.0, 1.0, 0.5 + 0.25 * (end_of_cap as f32 - p[2])]).collect();
    materials[0].alpha = Alpha::Mask(0.5);
    let scene = Scene::new(vec![Mesh::new(parts).unwrap()], materials, vec![]).unwrap();
    for (name, receivers) in
        [("bottom", receiver([0.0, 0.0, -1.0], [0.0, 0.0, 1.0])), ("side", receiver([1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]))]
    {
        let options = options(BakeMode::Interreflected, 2, 1 << 15).bounces(4);
        let (_, report) = baked(&scene, &receivers, &options);
        for (b, energy) in report.energy_per_bounce.iter().enumerate() {
            let expected = f * (rho * (1.0 - f)).powi(b as i32);
            assert!((energy - expected).abs() < 5e-3, "{name}, bounce {b}: {energy}, expected {expected}");
        }
    }
}
