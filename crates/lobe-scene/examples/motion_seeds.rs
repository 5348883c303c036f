//! Writes small animated glTF files, from which the fuzz target `read_motion` starts.
//!
//! ```sh
//! cargo run -p lobe-scene --example motion_seeds -- FOLDER
//! ```

#![allow(clippy::unwrap_used, reason = "the builder of the tests")]

#[path = "../tests/all/common/mod.rs"]
mod common;

use std::fs;
use std::path::Path;

use serde_json::json;

use crate::common::Gltf;

const TURN: [f32; 8] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.6, 0.8];
const MOVE: [f32; 6] = [0.0, 0.0, 0.0, 1.0, -2.0, 0.5];
const POP: [f32; 9] = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 2.0, 1.0, 1.0];

/// A square that two targets move and turn.
fn morphing() -> Gltf {
    let mut file = Gltf::square().with_attribute("NORMAL", "VEC3", &[0.0, 0.0, 1.0].repeat(4));
    let (up, turned) =
        (file.floats("VEC3", &[0.0, 1.0, 0.0].repeat(4)), file.floats("VEC3", &[1.0, 0.0, -1.0].repeat(4)));
    file.with("/meshes/0/primitives/0/targets", json!([{"POSITION": up}, {"NORMAL": turned}]))
        .with("/meshes/0/weights", json!([0.5, 0.0]))
}

fn seeds() -> Vec<(&'static str, Gltf)> {
    let mut instances = morphing();
    let places = instances.floats("VEC3", &MOVE);
    let spline: Vec<f32> =
        MOVE.chunks(3).flat_map(|value| [&[0.5, 0.0, 0.0], value, &[0.5, 0.0, 0.0]].concat()).collect();
    vec![
        (
            "moved",
            Gltf::square()
                .with_channel(0, (0, "translation"), "LINEAR", (&[0.0, 1.0], "VEC3", &MOVE))
                .with_channel(0, (0, "rotation"), "STEP", (&[0.5, 2.0], "VEC4", &TURN))
                .with_channel(1, (0, "scale"), "LINEAR", (&[0.0, 1.0, 2.0], "VEC3", &POP)),
        ),
        ("spline", Gltf::square().with_channel(0, (0, "translation"), "CUBICSPLINE", (&[0.0, 2.0], "VEC3", &spline))),
        ("skin", Gltf::skinned().with_channel(0, (2, "rotation"), "LINEAR", (&[0.0, 1.0], "VEC4", &TURN))),
        ("morph", morphing().with_channel(0, (0, "weights"), "LINEAR", (&[0.0, 1.0], "SCALAR", &[0.0, 1.0, 1.0, 0.0]))),
        (
            "instances",
            instances.with(
                "/nodes/0/extensions",
                json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": places}}}),
            ),
        ),
        (
            "chain",
            Gltf::square()
                .with("/scenes/0/nodes", json!([1]))
                .with("/nodes/1", json!({"children": [0], "scale": [1.0, -1.0, 2.0], "translation": [1e6, 0.0, 0.0]}))
                .with_channel(0, (0, "translation"), "LINEAR", (&[0.0, 1.0], "VEC3", &MOVE)),
        ),
    ]
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1).ok_or("usage: motion_seeds FOLDER")?;
    fs::create_dir_all(&folder)?;
    for (name, file) in seeds() {
        fs::write(Path::new(&folder).join(format!("{name}.glb")), file.glb())?;
        fs::write(Path::new(&folder).join(format!("{name}.gltf")), file.gltf())?;
    }
    Ok(())
}
