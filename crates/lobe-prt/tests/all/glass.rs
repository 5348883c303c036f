//! Transfer through colored glass.

use crate::common::{baked, options};
use lobe_prt::{BakeMode, Channels, Receivers};
use lobe_scene::{Material, Mesh, MeshParts, Scene};

const COLOR: [f32; 3] = [0.5, 0.25, 0.75];

/// A white floor under panes, so wide that nothing passes them by, of a transmission.
fn under_glass(panes: usize, transmission: f32) -> Scene {
    let square = |half: f32, z: f32, material: usize| {
        let positions = vec![[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]];
        let parts = MeshParts { positions, triangles: vec![[0, 1, 2], [0, 2, 3]], ..MeshParts::default() };
        Mesh::new(MeshParts { material: Some(material), ..parts }).unwrap()
    };
    let meshes = std::iter::once(square(0.5, 0.0, 0)).chain((1..=panes).map(|k| square(1e4, k as f32, 1)));
    let [r, g, b] = COLOR;
    let glass = Material { base_color: [r, g, b, 1.0], transmission, straight_through: true, ..Material::WHITE };
    Scene::new(meshes.collect(), vec![Material::WHITE, glass], vec![]).unwrap()
}

#[test]
fn light_that_colored_glass_lets_through_has_the_color_of_the_glass() {
    for (panes, transmission) in [(1, 1.0_f32), (2, 1.0), (1, 0.5)] {
        let scene = under_glass(panes, transmission);
        let receivers = Receivers::at_vertices(&scene).unwrap().subset(&[0, 1, 2, 3]).unwrap();
        for mode in [BakeMode::Shadowed, BakeMode::Interreflected] {
            let options = options(mode, 1, 1 << 14).bounces(0);
            let (transfer, _) = baked(&scene, &receivers, &options);
            assert_eq!(transfer.channels(), Channels::Rgb, "{mode:?}: light has a hue");
            for c in 0..3 {
                // Of a white sky, what each pane lets through.
                let found = transfer.vector(0, c)[0] * (4.0 * std::f32::consts::PI).sqrt();
                let expected = (transmission * COLOR[c]).powi(panes as i32);
                let text = format!("{mode:?}, {panes} panes of {transmission}, channel {c}: {found}, not {expected}");
                // Four standard deviations of 2^14 paths that pass by chance.
                assert!((found - expected).abs() < 0.03 * expected.max(0.3), "{text}");
            }
        }
    }
}
