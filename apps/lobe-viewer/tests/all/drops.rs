//! Files that are dropped on the window: good, corrupt and too large ones.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use eframe::egui::{DroppedFile, Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use lobe::env::{EnvMap, write_env};
use lobe::io::Job;
use lobe::prt::{
    AlbedoMode, BakeMode, Channels, CompressOptions, CompressedTransfer, Recipe, Transfer, TransferMatrices,
    ZonalFitOptions, fit_zonal, write_compressed_transfer, write_lightmap, write_matrices, write_transfer,
    write_zonal_transfer,
};
use lobe::sh::expansion::Quantity;
use lobe::sh::sh_json::{ShFile, write_sh_json};
use lobe::sh::{Expansion as _, Rgb, ShVec};
use lobe::shadow::{SphereFitOptions, SphereSet, fit_spheres, write_spheres};
use lobe_viewer::{
    Kept, MotionEdits, MotionRoom, MotionView, Places, ReadLimits, RoomName, SceneData, UserFolder, ViewerApp,
    bake_options, bake_scene, open_moving, open_sky,
};

use crate::wait::step_until;

/// A file as the system hands it to the window.
#[derive(Debug)]
struct Dropped(PathBuf);

impl DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|error| error.to_string())
    }
}

fn drop_file(harness: &mut Harness<'_, ViewerApp>, path: &Path) {
    harness.input_mut().dropped_files.push(Arc::new(Dropped(path.into())));
    harness.run_steps(2);
    step_until(harness, |app| app.scene().is_idle());
}

#[test]
fn files_that_are_dropped_are_opened_or_told_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let user = UserFolder::at(folder.path().join("user"));
    let mut kept = Kept::default();
    (kept.rooms.scene.scene, kept.rooms.scene.order, kept.room) = ("built-in:furnace".into(), 1, RoomName::Functions);
    kept.rooms.scene.samples = 16;
    kept.write(&user);
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("one.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    std::fs::write(at("torn.glb"), b"glTF\x02\0\0\0\xff\xff\xff\x7f").unwrap();
    std::fs::write(at("torn.exr"), [0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0, 0xff, 0xff]).unwrap();
    // A cube of which each face has its number for a color.
    std::fs::create_dir(at("cube")).unwrap();
    for (k, face) in ["px", "nx", "py", "ny", "pz", "nz"].into_iter().enumerate() {
        let color = [1.0 + k as f32; 3].map(f32::to_le_bytes).concat();
        std::fs::write(at("cube").join(format!("{face}.pfm")), [b"PF\n1 1\n-1.0\n", &*color].concat()).unwrap();
    }
    // A hole of 300 MB, which takes no room.
    File::create(at("huge.hdr")).unwrap().set_len(300_000_000).unwrap();
    File::create(at("huge.glb")).unwrap().set_len(300_000_000).unwrap();
    let app = ViewerApp::new(None, user, &[]);
    let mut harness =
        Harness::builder().with_size([1000.0, 700.0]).build_ui_state(|ui, app: &mut ViewerApp| app.show(ui), app);
    drop_file(&mut harness, &at("one.obj"));
    assert_eq!(harness.state().room(), RoomName::Scene, "what is dropped is shown");
    assert_eq!(harness.state().scene().edits().scene, at("one.obj"), "the scene");
    assert_eq!(harness.state().scene().message(), None, "and nothing is wrong");
    drop_file(&mut harness, &at("cube"));
    assert_eq!(harness.state().scene().edits().sky, at("cube"), "a folder of six faces is a sky");
    assert_eq!(harness.state().scene().message(), None, "and nothing is wrong");
    let light = ShVec::constant(2, Rgb::new(2.0, 1.0, 0.5));
    write_sh_json(at("light.sh.json"), &ShFile::new(Quantity::Radiance, light)).unwrap();
    drop_file(&mut harness, &at("light.sh.json"));
    assert_eq!(harness.state().scene().edits().sky, at("light.sh.json"), "an expansion is a sky");
    assert_eq!(harness.state().room(), RoomName::Scene, "and no scene that moves");
    for name in ["torn.glb", "torn.exr", "huge.hdr", "huge.glb", "none.obj"] {
        drop_file(&mut harness, &at(name));
        let message = harness.state().scene().message().unwrap_or_default().to_owned();
        assert!(message.contains(name) && message.lines().count() == 1, "{name}: {message:?}");
        assert_eq!(harness.state().scene().edits().scene, at("one.obj"), "{name}: the scene is still there");
        assert!(harness.state().scene().sky().is_some(), "{name}: and the sky");
    }
}

/// The window on the least scene.
fn small_window(folder: &Path) -> Harness<'static, ViewerApp> {
    let user = UserFolder::at(folder.join("user"));
    let mut kept = Kept::default();
    (kept.rooms.scene.scene, kept.rooms.scene.order, kept.rooms.scene.samples) = ("built-in:furnace".into(), 1, 16);
    kept.write(&user);
    let app = ViewerApp::new(None, user, &[]);
    let mut harness =
        Harness::builder().with_size([1000.0, 900.0]).build_ui_state(|ui, app: &mut ViewerApp| app.show(ui), app);
    harness.run_steps(2);
    step_until(&mut harness, |app| app.scene().is_idle());
    harness
}

#[test]
fn expansions_of_any_quantity_are_functions_with_the_numbers_of_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = small_window(folder.path());
    for quantity in Quantity::ALL.into_iter().filter(|quantity| *quantity != Quantity::Radiance) {
        let f = ShVec::from_vec((0..9).map(|i| 0.125 * f64::from(i) - 0.5).collect()).unwrap();
        let path = folder.path().join(format!("{quantity}.sh.json"));
        write_sh_json(&path, &ShFile::new(quantity, f.clone())).unwrap();
        drop_file(&mut harness, &path);
        assert_eq!(harness.state().room(), RoomName::Functions, "{quantity}");
        assert_eq!(harness.state().functions().edits().function(), f, "{quantity}: the function of the file");
        harness.run_steps(3);
        let row: Vec<String> = f.band(2).iter().map(|c| format!("{c:8.4}")).collect();
        let text = format!("band 2: {}   energy {:.4}", row.join(" "), f.band_energies()[2]);
        assert!(harness.query_by_label(&text).is_some(), "{quantity}: {text}");
    }
}

#[test]
fn transfer_is_shown_on_the_scene_that_it_is_of_and_refused_on_others() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = small_window(folder.path());
    let scene = lobe::scene::built_in::named("furnace").unwrap();
    let data = SceneData::new("furnace", scene);
    let (transfer, recipe) =
        bake_scene(&data, &bake_options(BakeMode::Interreflected, 2, 16), |_| std::ops::ControlFlow::Continue(()))
            .unwrap();
    let path = folder.path().join("furnace.safetensors");
    write_transfer(&path, &transfer, &recipe, Job::default()).unwrap();
    drop_file(&mut harness, &path);
    harness.run_steps(2);
    assert_eq!(**harness.state().scene().transfer().unwrap(), transfer, "the transfer of the file");
    assert!(harness.query_by_label("Baked: order 2, 16 paths").is_some(), "and the panel says so");
    let other =
        Transfer::new(3, transfer.channels(), transfer.coefficients()[..3 * 9 * transfer.channels().count()].to_vec())
            .unwrap();
    let path = folder.path().join("other.safetensors");
    write_transfer(&path, &other, &recipe, Job::default()).unwrap();
    drop_file(&mut harness, &path);
    let line = harness.state().scene().message().unwrap().to_owned();
    assert!(line.contains("transfer of 3 receivers") && line.contains("open the scene"), "{line}");
    assert_eq!(**harness.state().scene().transfer().unwrap(), transfer, "and what was there remains");
    std::fs::write(folder.path().join("noise.safetensors"), [7_u8; 64]).unwrap();
    drop_file(&mut harness, &folder.path().join("noise.safetensors"));
    let line = harness.state().notice().unwrap();
    assert!(line.contains("noise.safetensors: expected transfer, transfer matrices"), "{line}");
}

#[test]
fn every_form_of_transfer_is_shown_as_what_it_stands_for() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = small_window(folder.path());
    let data = SceneData::new("furnace", lobe::scene::built_in::named("furnace").unwrap());
    let (transfer, recipe) =
        bake_scene(&data, &bake_options(BakeMode::Interreflected, 3, 16), |_| std::ops::ControlFlow::Continue(()))
            .unwrap();
    let compressed = CompressedTransfer::new(&transfer, &CompressOptions::default(), Job::default()).unwrap().0;
    let zonal = fit_zonal(&transfer, &ZonalFitOptions::default(), Job::default()).unwrap().0;
    let at = |name: &str| folder.path().join(name);
    write_compressed_transfer(at("clusters.safetensors"), &compressed, &recipe).unwrap();
    write_zonal_transfer(at("lobes.safetensors"), &zonal, &recipe).unwrap();
    for (name, expected) in [("clusters", compressed.to_transfer()), ("lobes", zonal.to_transfer())] {
        drop_file(&mut harness, &at(&format!("{name}.safetensors")));
        harness.run_steps(2);
        assert_eq!(harness.state().scene().message(), None, "{name}");
        assert_eq!(**harness.state().scene().transfer().unwrap(), expected, "{name}");
        assert!(matches!(harness.state().scene().places(), Places::Vertices), "{name}");
    }
}

#[test]
fn a_lightmap_is_transfer_of_texels_and_no_sky() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = small_window(folder.path());
    let sky = harness.state().scene().edits().sky.clone();
    let scene = folder.path().join("wall.gltf");
    std::fs::write(&scene, WALL).unwrap();
    drop_file(&mut harness, &scene);
    let transfer = Transfer::new(2, Channels::Gray, (0..4 * 64).map(|k| 1.0 / (1.0 + k as f32)).collect()).unwrap();
    let recipe = Recipe::from(serde_json::json!({"mode": "interreflected", "samples": 5}));
    let path = folder.path().join("wall.exr");
    write_lightmap(&path, &transfer, &recipe, Job::default()).unwrap();
    drop_file(&mut harness, &path);
    harness.run_steps(2);
    let room = harness.state().scene();
    assert_eq!((room.message(), &room.edits().sky), (None, &sky), "nothing went wrong, and the sky is still there");
    assert_eq!(**room.transfer().unwrap(), transfer, "the numbers of the file");
    let Places::Texels(lightmap) = room.places() else { panic!("{:?}", room.places()) };
    assert_eq!(lightmap.width(), 8, "texels");
}

#[test]
fn transfer_that_takes_more_memory_than_the_limit_is_refused_before_it_is_decoded() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = small_window(folder.path());
    // Sixteen million numbers that are alike.
    let transfer = Transfer::new(2, Channels::Gray, vec![0.5; 4 << 22]).unwrap();
    let path = folder.path().join("flat.exr");
    write_lightmap(&path, &transfer, &Recipe::from(serde_json::json!({})), Job::default()).unwrap();
    let mut limits = ReadLimits::default();
    limits.max_memory = 0.05;
    let app = std::mem::replace(harness.state_mut(), ViewerApp::new(None, UserFolder::none(), &[]));
    *harness.state_mut() = app.reading_within(limits);
    drop_file(&mut harness, &path);
    let line = harness.state().scene().message().unwrap().to_owned();
    assert!(
        line.starts_with("flat.exr: takes up to 201326592 bytes of memory") && line.contains("--max-memory"),
        "{line}"
    );
}

#[test]
fn matrices_are_those_of_metals_and_what_is_part_of_something_else_says_of_what() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = small_window(folder.path());
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("wall.gltf"), WALL).unwrap();
    let recipe = Recipe::from(serde_json::json!({}));
    let matrices = |points: usize| TransferMatrices::new(1, Channels::Gray, vec![0.5; points]).unwrap();
    write_matrices(at("three.safetensors"), &matrices(3), &recipe, Job::default()).unwrap();
    write_matrices(at("four.safetensors"), &matrices(4), &recipe, Job::default()).unwrap();
    drop_file(&mut harness, &at("four.safetensors"));
    let line = harness.state().scene().message().unwrap().to_owned();
    assert!(line.contains("transfer matrices of 4 receivers, but furnace has"), "{line}");
    drop_file(&mut harness, &at("wall.gltf"));
    drop_file(&mut harness, &at("four.safetensors"));
    let room = harness.state().scene();
    assert_eq!((room.message(), room.glossy().len()), (None, 1), "one metal");
    assert_eq!(*room.glossy()[0].matrices, matrices(4), "with the numbers of the file");
    drop_file(&mut harness, &at("three.safetensors"));
    assert_eq!(harness.state().scene().glossy().len(), 1, "what was there remains");
    // Words of a recipe are no format, and of files that are dropped together each is taken.
    let transfer = Transfer::new(1, Channels::Gray, vec![0.25; 4]).unwrap();
    let about =
        Recipe::from(serde_json::json!({"mode": "interreflected", "scene": "lobe-lamp in lobe-transfer-matrices"}));
    write_transfer(at("rows.safetensors"), &transfer, &about, Job::default()).unwrap();
    let other = TransferMatrices::new(1, Channels::Gray, vec![0.75; 4]).unwrap();
    write_matrices(at("four.safetensors"), &other, &recipe, Job::default()).unwrap();
    for name in ["rows.safetensors", "four.safetensors"] {
        harness.input_mut().dropped_files.push(Arc::new(Dropped(at(name))));
    }
    harness.run_steps(2);
    step_until(&mut harness, |app| app.scene().is_idle());
    harness.run_steps(2);
    let room = harness.state().scene();
    assert_eq!((room.message(), harness.state().notice()), (None, None), "nothing went wrong");
    assert_eq!(**room.transfer().unwrap(), transfer, "the vectors");
    assert_eq!(*room.glossy()[0].matrices, other, "and the matrices");
    for (format, advice) in [
        ("lobe-lamp", "open that"),
        ("lobe-neighbourhood-transfer", "lobe sh incident"),
        ("lobe-visibility", "bakes its own"),
    ] {
        let about = format!(r#"{{"__metadata__":{{"lobe":"{{\"format\":\"{format}\",\"version\":1}}"}}}}"#);
        let bytes = [&(about.len() as u64).to_le_bytes()[..], about.as_bytes()].concat();
        std::fs::write(at("part.safetensors"), bytes).unwrap();
        drop_file(&mut harness, &at("part.safetensors"));
        let line = harness.state().notice().unwrap();
        assert!(line.starts_with("part.safetensors: ") && line.contains(advice), "{format}: {line}");
    }
}

/// A square of metal whose texture coordinates are the whole lightmap.
const WALL: &str = r#"{"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}]}],
"materials": [{"pbrMetallicRoughness": {"metallicFactor": 1, "roughnessFactor": 0.5}}],
"accessors": [
{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
{"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
{"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"}],
"bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 32},
{"buffer": 0, "byteOffset": 80, "byteLength": 12}],
"buffers": [{"byteLength": 92, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAACAPwAAgD8AAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAAAAAAAgD8AAIA/AAAAAAAAgD8AAAEAAgAAAAIAAwA="}]}"#;

#[test]
fn no_difference_is_shown_of_bakes_with_and_without_albedo() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = small_window(folder.path());
    harness.run_steps(2);
    step_until(&mut harness, |app| app.scene().is_idle());
    let data = SceneData::new("furnace", lobe::scene::built_in::named("furnace").unwrap());
    let order = harness.state().scene().edits().order;
    let options = bake_options(BakeMode::Shadowed, order, 16).albedo(AlbedoMode::None);
    let (transfer, recipe) = bake_scene(&data, &options, |_| std::ops::ControlFlow::Continue(())).unwrap();
    let path = folder.path().join("direct.safetensors");
    write_transfer(&path, &transfer, &recipe, Job::default()).unwrap();
    harness.key_press(Key::Num4);
    harness.run_steps(2);
    step_until(&mut harness, |app| app.scene().is_idle());
    assert!(harness.state().scene().transfer().is_some(), "of two that are alike");
    drop_file(&mut harness, &path);
    harness.run_steps(2);
    let line = harness.state().scene().message().unwrap().to_owned();
    assert!(line.contains("leaves out the albedo"), "{line}");
    assert!(harness.state().scene().transfer().is_none(), "no difference of unlike things");
}

#[test]
fn a_sky_that_was_cancelled_is_not_shown_afterwards() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = small_window(folder.path());
    let before = harness.state().scene().sky().unwrap().clone();
    // Large enough that it is being read for some frames.
    let map = EnvMap::from_fn(2048, 1024, |_| Rgb::new(9.0, 9.0, 9.0));
    let path = folder.path().join("large.hdr");
    write_env(&path, &map, &Default::default()).unwrap();
    harness.input_mut().dropped_files.push(Arc::new(Dropped(path.clone())));
    harness.run_steps(2);
    assert!(!harness.state().scene().is_idle(), "it is being read");
    harness.key_press(Key::Escape);
    harness.run_steps(2);
    assert!(harness.state().scene().is_idle(), "cancelled at once");
    // As long as the same sky takes to be read: then it would be there.
    assert!(open_sky(&path, &ReadLimits::default()).is_ok());
    harness.run_steps(5);
    let after = harness.state().scene();
    assert!(Arc::ptr_eq(&after.sky().unwrap().map, &before.map), "the sky before is still there");
    assert_ne!(after.edits().sky, path, "and the next start does not open the other");
    assert!(after.message().is_some_and(|line| line.starts_with("Cancelled")), "{:?}", after.message());
}

#[test]
fn a_key_closes_the_list_of_files_and_stops_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = small_window(folder.path());
    let map = EnvMap::from_fn(2048, 1024, |_| Rgb::new(9.0, 9.0, 9.0));
    let path = folder.path().join("large.hdr");
    write_env(&path, &map, &Default::default()).unwrap();
    harness.key_press_modifiers(Modifiers::COMMAND, Key::O);
    harness.run_steps(2);
    assert!(harness.query_by_label("Open this folder").is_some(), "the list");
    harness.input_mut().dropped_files.push(Arc::new(Dropped(path.clone())));
    harness.run_steps(1);
    harness.key_press(Key::Escape);
    harness.run_steps(2);
    assert!(harness.query_by_label("Open this folder").is_none(), "it is closed");
    step_until(&mut harness, |app| app.scene().is_idle());
    let room = harness.state().scene();
    assert_eq!((room.message(), &room.edits().sky), (None, &path), "the sky is read to its end");
}

#[test]
fn fields_and_spheres_are_those_of_the_part_that_they_were_made_of() {
    let folder = tempfile::tempdir().unwrap();
    let source = "built-in:three-objects";
    let scene = open_moving(source.as_ref(), &ReadLimits::default()).unwrap();
    let ring = scene.parts().iter().find(|part| part.name == "ring").unwrap();
    let options = SphereFitOptions::default().count(5).samples(200);
    let (spheres, _) = fit_spheres(&ring.scene, &options, Job::default()).unwrap();
    let path = folder.path().join("ring.safetensors");
    write_spheres(&path, &spheres).unwrap();
    let mut room = MotionRoom::new(MotionEdits::default());
    room.open(source.as_ref());
    room.open_part_file(&path);
    room.edits_mut().view = MotionView::Exponentials;
    room.edits_mut().order = 1;
    let sky = open_sky("made:even".as_ref(), &ReadLimits::default()).unwrap();
    let show = |ui: &mut eframe::egui::Ui, room: &mut MotionRoom| room.ui(ui, None, Some(&sky));
    let mut harness = Harness::builder().with_size([900.0, 700.0]).build_ui_state(show, room);
    // Sixteen of each of the two others.
    step_until(&mut harness, |room| room.spheres() > 0 || room.message().is_some());
    let room = harness.state();
    assert_eq!((room.message(), room.spheres()), (None, 16 + 16 + 5), "nothing went wrong");
    // Those of a part that is not there.
    let far = SphereSet::new(vec![[90.0, 0.0, 0.0]], vec![1.0]).unwrap();
    let path = folder.path().join("far.safetensors");
    write_spheres(&path, &far).unwrap();
    harness.state_mut().open_part_file(&path);
    step_until(&mut harness, |room| room.message().is_some());
    let line = harness.state().message().unwrap().to_owned();
    assert!(line.contains("far.safetensors") && line.contains("open the scene"), "{line}");
}
