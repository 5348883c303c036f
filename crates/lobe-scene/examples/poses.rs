//! Writes an animated scene at several times as numbers, for other programs to compare.
//!
//! ```sh
//! cargo run --release -p lobe-scene --example poses -- FILE ANIMATION OUT TIME...
//! ```
//!
//! OUT.json says which meshes there are; OUT holds `f32`, little-endian: for each time, for each mesh, all positions, then all
//! normals, y up as in the file and from the origin of its world.

use std::fs;

use lobe_scene::{AnimatedScene, SceneReadOptions, y_up_from_z_up};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [file, animation, out, times @ ..] = &arguments[..] else {
        return Err("usage: poses FILE ANIMATION OUT TIME...".into());
    };
    let (scene, report) = AnimatedScene::read(file, &SceneReadOptions::default())?;
    report.notes.iter().for_each(|note| eprintln!("{file}: {note}"));
    let animation = scene.animation(animation)?;
    let meshes = scene.rest().meshes().iter().map(|mesh| {
        let place = mesh.source().ok_or("expected glTF, which says where a mesh comes from")?;
        let (node, index, primitive, vertices) = (place.node, place.mesh, place.primitive, mesh.positions().len());
        Ok(serde_json::json!({"node": node, "mesh": index, "primitive": primitive, "vertices": vertices}))
    });
    let meshes = meshes.collect::<Result<Vec<_>, &str>>()?;
    fs::write(format!("{out}.json"), serde_json::to_vec(&meshes)?)?;
    let mut bytes = Vec::new();
    for time in times {
        let posed = scene.pose(animation, time.parse()?)?;
        let origin = posed.scene().origin();
        for mesh in posed.scene().meshes() {
            let place = |p: &[f32; 3]| [0, 1, 2].map(|k| (f64::from(p[k]) + origin[k]) as f32);
            let all = mesh.positions().iter().map(place).chain(mesh.normals().iter().copied());
            bytes.extend(all.flat_map(y_up_from_z_up).flat_map(f32::to_le_bytes));
        }
    }
    fs::write(out, bytes)?;
    Ok(())
}
