//! `lobe bake --texels`: any model, in any kind of file.

use lobe::prt::read_transfer;
use lobe_testkit::glb_faults;

use crate::harness::{Dir, mean};

/// A folder with a roof over a floor: `bare.obj` without texture coordinates, `tiled.obj` with such that overlap, and
/// `own.obj` with such that hold a lightmap; `sky.exr` is brighter above.
fn folder() -> Dir {
    let dir = Dir::new();
    let floor = "v -2 -2 0\nv 2 -2 0\nv 2 2 0\nv -2 2 0\n";
    let roof = "v -1 -1 1\nv 1 -1 1\nv 0 1 1.5\n";
    let tiled = "vt 0 0\nvt 3 0\nvt 3 3\nvt 0 3\n";
    let own = "vt 0.1 0.1\nvt 0.5 0.1\nvt 0.5 0.5\nvt 0.1 0.5\nvt 0.6 0.6\nvt 0.9 0.6\nvt 0.6 0.9\n";
    let faces = "f 1 2 3 4\nf 5 6 7\n";
    let with = |roof: [u8; 3]| format!("f 1/1 2/2 3/3 4/4\nf 5/{} 6/{} 7/{}\n", roof[0], roof[1], roof[2]);
    dir.file("bare.obj", format!("{floor}{roof}{faces}"));
    dir.file("tiled.obj", format!("{floor}{roof}{tiled}{}", with([1, 2, 3])));
    dir.file("own.obj", format!("{floor}{roof}{own}{}", with([5, 6, 7])));
    dir.map("sky.exr", 16, 8, |_, y| [1.0 / (1.0 + y as f32), 0.5, 0.25]);
    dir
}

const BAKE: &str = "--up z --mode shadowed --samples 64 --order 2";
const VIEW: &str = "--env sky.exr --mode shadowed --size 48x32 --eye 5,-5,4 --target 0,0,0";

#[test]
fn any_scene_is_baked_at_texels_and_looks_the_same_from_every_kind_of_file() {
    let dir = folder();
    let (_, notes) = dir.lobe(&format!("bake bare.obj {BAKE} --texels 48 -o t.safetensors")).succeeds();
    assert!(
        notes.contains("note: bare.obj: unwrapped into 2 charts, its own coordinates hold no lightmap ("),
        "{notes}"
    );
    let (transfer, recipe) = read_transfer(dir.path("t.safetensors")).unwrap();
    assert_eq!((transfer.receivers(), recipe.texels), (48 * 48, Some(48)), "{recipe:?}");
    let unwrap = recipe.unwrap.unwrap();
    assert_eq!((unwrap.texels, unwrap.padding, recipe.denoised, recipe.stitched), (48, 2, Some(true), Some(true)));
    for name in ["t.exr", "t.glb"] {
        dir.lobe(&format!("bake bare.obj {BAKE} --texels 48 -o {name} --quiet")).stdout();
    }
    assert_eq!(glb_faults(&dir.bytes("t.glb")), [] as [String; 0], "t.glb");
    let pictures =
        ["bare.obj --up z --transfer t.safetensors", "bare.obj --up z --transfer t.exr", "t.glb"].map(|scene| {
            dir.lobe(&format!("render {scene} {VIEW} -o p.exr --quiet")).stdout();
            dir.numbers("p.exr")
        });
    assert!(pictures[0] == pictures[1], "the same numbers as .safetensors and as .exr");
    // 16 bits have 11 digits.
    let off = pictures[0].iter().zip(&pictures[2]).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(off < 2e-3 && mean(&pictures[2]) > 0.05, "as .glb off by {off} of {}", mean(&pictures[2]));
    let baked = dir.baked("t.glb");
    assert_eq!(baked.lightmap.unwrap().width(), 48, "width");
    assert!(baked.scene.meshes().iter().all(|mesh| mesh.uvs(1).is_empty()), "the first set was free");
}

#[test]
fn a_scene_is_unwrapped_where_its_own_coordinates_overlap_and_when_it_is_asked_for() {
    let dir = folder();
    let notes = |args: &str| {
        let command = format!("bake {args} {BAKE} -o t.safetensors");
        dir.lobe(&command).succeeds().1
    };
    let note = notes("tiled.obj --texels 32");
    assert!(note.contains("unwrapped into 2 charts, its own coordinates hold no lightmap (mesh "), "{note}");
    assert!(!notes("own.obj --texels 32").contains("unwrapped"), "coordinates that hold a lightmap");
    for option in ["--unwrap always", "--padding 4", "--texel-size 0.2", "--chart-angle 30"] {
        let note = notes(&format!("own.obj --texels 48 {option}"));
        assert!(note.contains("unwrapped into 2 charts, as asked for; a texel is "), "{option}: {note}");
    }
    let line = dir.lobe(&format!("bake tiled.obj {BAKE} --texels 32 --unwrap never --quiet -o n.glb")).error();
    assert!(line.contains("expected texture coordinates in the unit square"), "{line}");
    assert!(line.ends_with("; --unwrap auto makes others"), "{line}");
    let line = dir.lobe(&format!("bake bare.obj {BAKE} --texels 32 --texel-size 0.01 --quiet -o n.glb")).error();
    assert!(
        line.contains("with a padding of 2 texels would not fit into 32 x 32: more texels, larger texels"),
        "{line}"
    );
    let line = dir.lobe("bake bare.obj --padding 4 -o n.glb").error();
    assert!(line.contains("--texels"), "{line}");
    assert!(!dir.names().contains(&"n.glb".to_owned()), "nothing is left");
}

#[test]
fn transfer_of_a_scene_that_was_unwrapped_is_of_no_other_scene() {
    let dir = folder();
    dir.lobe(&format!("bake bare.obj {BAKE} --texels 32 -o t.safetensors --quiet")).stdout();
    let line = dir.lobe(&format!("render tiled.obj --up z --transfer t.safetensors {VIEW} --quiet -o p.png")).error();
    assert!(line.starts_with("t.safetensors: expected the scene that was unwrapped for it, found another"), "{line}");
}

#[test]
fn noise_that_is_left_in_is_left_in_and_threads_change_no_byte() {
    let dir = folder();
    for (name, options) in [("a", "--threads 1"), ("b", "--threads 3"), ("c", "--denoise off")] {
        dir.lobe(&format!("bake bare.obj {BAKE} --texels 32 {options} -o {name}.glb --quiet")).stdout();
    }
    assert!(dir.bytes("a.glb") == dir.bytes("b.glb"), "one thread and three");
    assert!(dir.bytes("a.glb") != dir.bytes("c.glb"), "with its noise");
    assert_eq!(dir.baked("c.glb").recipe.denoised, None, "what the recipe says");
}
