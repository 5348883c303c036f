//! Baked files after other programs have written them anew.

use std::path::{Path, PathBuf};

use half::f16;
use lobe_io::Job;
use lobe_prt::{
    Baked, BakedGlb, Channels, CompressOptions, CompressedTransfer, Recipe, Transfer, WeightBits, read_baked,
    read_baked_or_scene,
};
use lobe_scene::{Mesh, Scene, SceneReadOptions, built_in};
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::baked_glb::{parts_of, write_gltf};

const ORDER: usize = 2;

/// A scene of one mesh with transfer, in a folder.
struct Example {
    folder: TempDir,
    scene: Scene,
    transfer: Transfer,
}

impl Example {
    fn new() -> Self {
        let scene = built_in::closed_white_box(2);
        // Numbers within -1 and 1 that differ at every place: fractions of multiples of the golden ratio.
        let fraction = |i: usize| 2.0 * (i as f32 * 0.618_034).fract() - 1.0;
        let numbers = (0..scene.vertex_count() * ORDER * ORDER).map(fraction).collect();
        let transfer = Transfer::new(ORDER, Channels::Gray, numbers).unwrap();
        Self { folder: tempfile::tempdir().unwrap(), scene, transfer }
    }

    fn path(&self) -> PathBuf {
        self.folder.path().join("baked.glb")
    }

    fn plain(&self) -> (Value, Vec<u8>) {
        let recipe = Recipe::default().samples(7);
        BakedGlb::of_scene(&self.scene).write(self.path(), &self.transfer, &recipe, Job::default()).unwrap();
        parts_of(&self.path())
    }

    fn compressed(&self, weights: WeightBits) -> (CompressedTransfer, Value, Vec<u8>) {
        let options = CompressOptions::default().clusters(3).components(2).weights(weights);
        let (compressed, _) = CompressedTransfer::new(&self.transfer, &options, Job::default()).unwrap();
        let recipe = Recipe::default().samples(7);
        BakedGlb::of_scene(&self.scene).write_compressed(self.path(), &compressed, &recipe).unwrap();
        let (json, bytes) = parts_of(&self.path());
        (compressed, json, bytes)
    }

    fn written(&self, json: &Value, bytes: &[u8]) -> PathBuf {
        write_gltf(&self.folder, "changed", json, bytes)
    }

    fn read(&self, json: &Value, bytes: &[u8]) -> Baked {
        read_baked(self.written(json, bytes), &SceneReadOptions::default()).unwrap()
    }
}

fn refusal(path: &Path) -> String {
    read_baked_or_scene(path, &SceneReadOptions::default()).unwrap_err().to_string()
}

/// Takes the extras out of some objects.
fn drop_extras(json: &mut Value, places: &[&str]) {
    for place in places {
        json.pointer_mut(place).unwrap().as_object_mut().unwrap().remove("extras");
    }
}

/// Puts numbers of another type in the place of an attribute.
fn replace_attribute(json: &mut Value, bytes: &mut Vec<u8>, name: &str, accessor: Value, values: &[u8]) {
    let view = json!({"buffer": 0, "byteOffset": bytes.len(), "byteLength": values.len()});
    bytes.extend_from_slice(values);
    let views = json["bufferViews"].as_array_mut().unwrap();
    views.push(view);
    let view = views.len() - 1;
    let at = json["meshes"][0]["primitives"][0]["attributes"][name].as_u64().unwrap() as usize;
    let count = json["accessors"][at]["count"].clone();
    json["accessors"][at] = accessor;
    json["accessors"][at]["bufferView"] = json!(view);
    json["accessors"][at]["count"] = count;
}

#[test]
fn numbers_of_other_types_are_the_transfer_to_their_own_precision() {
    let example = Example::new();
    let (json, bytes) = example.plain();
    let numbers = example.transfer.coefficients();
    let encode = |of: &dyn Fn(f32) -> Vec<u8>| numbers.iter().flat_map(|x| of(*x)).collect::<Vec<u8>>();
    let signed = |x: f32, most: f32| (x.clamp(-1.0, 1.0) * most).round();
    // The largest error of a rounded fraction is half a step; of a half float of up to 1, 2⁻¹².
    for (kind, normalized, error, values) in [
        (5122, true, 0.5 / 32767.0, encode(&|x| (signed(x, 32767.0) as i16).to_le_bytes().to_vec())),
        (5120, true, 0.5 / 127.0, encode(&|x| (signed(x, 127.0) as i8).to_le_bytes().to_vec())),
        (5131, false, 2.0_f32.powi(-12), encode(&|x| f16::from_f32(x).to_le_bytes().to_vec())),
    ] {
        let (mut json, mut bytes) = (json.clone(), bytes.clone());
        let accessor = json!({"componentType": kind, "normalized": normalized, "type": "VEC4"});
        replace_attribute(&mut json, &mut bytes, "_TRANSFER_0", accessor, &values);
        let found = example.read(&json, &bytes).transfer;
        for (found, expected) in found.coefficients().iter().zip(numbers) {
            let off = (found - expected.clamp(-1.0, 1.0)).abs();
            assert!(off <= error * 1.001, "type {kind}: {found} for {expected}");
        }
    }
}

#[test]
fn a_file_without_extras_of_its_asset_is_described_by_its_scene() {
    let example = Example::new();
    let (mut json, bytes) = example.plain();
    drop_extras(&mut json, &["/asset"]);
    let found = example.read(&json, &bytes);
    assert_eq!((found.transfer, found.recipe.samples), (example.transfer.clone(), Some(7)), "plain");
    let (compressed, mut json, bytes) = example.compressed(WeightBits::F32);
    drop_extras(&mut json, &["/asset"]);
    let found = example.read(&json, &bytes);
    assert_eq!((found.compressed.as_ref(), found.recipe.samples), (Some(&compressed), Some(7)), "compressed");
}

#[test]
fn a_file_with_extras_of_its_meshes_alone_has_its_transfer_and_no_recipe() {
    let example = Example::new();
    let (mut json, bytes) = example.plain();
    drop_extras(&mut json, &["/asset", "/scenes/0"]);
    let found = example.read(&json, &bytes);
    assert_eq!((found.transfer, found.recipe.samples), (example.transfer.clone(), None), "plain");
    let (_, mut json, bytes) = example.compressed(WeightBits::U16);
    drop_extras(&mut json, &["/asset", "/scenes/0"]);
    let message = refusal(&example.written(&json, &bytes));
    assert!(message.contains("no bases of it: another program dropped extras.lobe of its scene"), "{message}");
}

#[test]
fn transfer_that_nothing_describes_is_refused_with_what_is_lost() {
    let example = Example::new();
    let (mut json, bytes) = example.plain();
    drop_extras(&mut json, &["/asset", "/scenes/0", "/meshes/0"]);
    let message = refusal(&example.written(&json, &bytes));
    assert!(message.contains("has _TRANSFER_0 of a bake, and no extras.lobe that describes it"), "{message}");
}

#[test]
fn bases_in_a_buffer_view_and_clusters_that_stand_alone_are_read() {
    let example = Example::new();
    let (compressed, mut json, mut bytes) = example.compressed(WeightBits::U8);
    let table = compressed.table();
    let clusters: Vec<u8> = table.clusters().iter().flat_map(|k| [k.to_le_bytes(), [0; 2]].concat()).collect();
    replace_attribute(&mut json, &mut bytes, "_CLUSTER", json!({"componentType": 5123, "type": "SCALAR"}), &clusters);
    let views = json["bufferViews"].as_array_mut().unwrap();
    views.last_mut().unwrap()["byteStride"] = json!(4);
    let bases: Vec<u8> = table.bases().iter().flat_map(|c| c.to_le_bytes()).collect();
    views.push(json!({"buffer": 0, "byteOffset": bytes.len(), "byteLength": bases.len()}));
    json["asset"]["extras"]["lobe"]["bases"] = json!(views.len() - 1);
    bytes.extend(bases);
    drop_extras(&mut json, &["/scenes/0"]);
    assert_eq!(example.read(&json, &bytes).compressed, Some(compressed));
}

#[test]
fn clusters_that_became_colors_are_refused() {
    let example = Example::new();
    let (_, mut json, mut bytes) = example.compressed(WeightBits::U16);
    let whole = vec![255; 8 * example.scene.vertex_count()];
    let color = json!({"componentType": 5123, "normalized": true, "type": "VEC4"});
    replace_attribute(&mut json, &mut bytes, "_CLUSTER", color, &whole);
    let message = refusal(&example.written(&json, &bytes));
    assert!(message.contains("has clusters as colors") && message.contains("--weights 32"), "{message}");
}

#[test]
fn an_object_that_was_moved_or_turned_after_the_bake_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let scene = built_in::ball_over_ground(16);
    let cosines = |normal: &[f32; 3]| [0.9, -0.5 * normal[1], 0.5 * normal[2], -0.5 * normal[0]];
    let numbers = scene.meshes().iter().flat_map(Mesh::normals).flat_map(cosines).collect();
    let transfer = Transfer::new(2, Channels::Gray, numbers).unwrap();
    let path = folder.path().join("baked.glb");
    BakedGlb::of_scene(&scene).write(&path, &transfer, &Recipe::default(), Job::default()).unwrap();
    let (json, bytes) = parts_of(&path);
    let notes = |change: &dyn Fn(&mut Value)| {
        let mut changed = json.clone();
        change(&mut changed);
        let path = write_gltf(&folder, "changed", &changed, &bytes);
        read_baked(path, &SceneReadOptions::default()).unwrap().report.notes
    };
    assert_eq!(notes(&|_| ()), Vec::<String>::new(), "as it was");
    let ball = scene.meshes().iter().position(|mesh| mesh.name() == "ball").unwrap();
    let node = json["nodes"].as_array().unwrap().iter().position(|node| node["mesh"] == ball).unwrap();
    let center = center_of(&scene, ball);
    for (what, turned, expected) in [
        ("moved", json!({"translation": [0.0, 3.0, 0.0]}), "its bounds are others"),
        // Half a turn about an axis through the center: x and z of glTF change their signs.
        (
            "turned",
            json!({"rotation": [1.0, 0.0, 0.0, 0.0], "translation": [0.0, 2.0 * center[2], -2.0 * center[1]]}),
            "its transfer does not go with its normals",
        ),
    ] {
        let found = notes(&|json| {
            for (name, value) in turned.as_object().unwrap() {
                json["nodes"][node][name] = value.clone();
            }
        });
        assert!(found.iter().any(|note| note.contains(expected)), "{what}: {found:?}");
    }
}

/// The middle of the bounds of a mesh.
fn center_of(scene: &Scene, mesh: usize) -> [f32; 3] {
    let of = |k: usize| scene.meshes()[mesh].positions().iter().map(move |at| at[k]);
    std::array::from_fn(|k| 0.5 * (of(k).fold(f32::MIN, f32::max) + of(k).fold(f32::MAX, f32::min)))
}
