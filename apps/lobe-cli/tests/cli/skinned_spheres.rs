//! `lobe spheres --entity`, and descriptions that name spheres for entities that an animation moves.

use lobe::scene::built_in;
use lobe::shadow::{Skeleton, Skin, SphereSet, read_spheres, write_spheres};

use crate::harness::Dir;

const VIEW: &str = "--env bundled:sunset --size 32x24 --bake-samples 16 --order 3 --method exponentials --time 0.4";
const FIT: &str = "spheres built-in:walking-figure -n 6";

/// A description of the walking figure with these further members.
fn walk(members: &str) -> Dir {
    let dir = Dir::new();
    let figure = format!(r#"{{"name":"walker","mesh":"built-in:walking-figure"{members}}}"#);
    dir.file("s.json", format!(r#"{{"format":"lobe-scene","version":1,"entities":[{figure}]}}"#));
    dir
}

const ANIMATED: &str = r#","animation":"walk","spheres":"f.safetensors","keys":[{"translation":[1,0,0]}]"#;

fn refused(dir: &Dir) -> String {
    let error = dir.lobe(&format!("render moving s.json {VIEW} --quiet -o x.exr")).error();
    assert!(!error.contains("a fault of this program"), "{error}");
    assert!(!dir.path("x.exr").exists(), "nothing is written");
    error
}

#[test]
#[ignore = "long: of the nightly group"]
fn a_file_of_spheres_gives_the_picture_of_spheres_that_are_fitted_on_the_way() {
    let dir = walk(ANIMATED);
    let (printed, _) = dir.lobe(&format!("{FIT} --entity figure -o f.safetensors")).succeeds();
    assert!(printed.contains("spheres         6"), "{printed}");
    dir.lobe(&format!("render moving s.json {VIEW} -o file.exr")).succeeds();
    let fitted = walk(&ANIMATED.replace(r#","spheres":"f.safetensors""#, ""));
    fitted.lobe(&format!("render moving s.json {VIEW} --spheres 6 -o fitted.exr")).succeeds();
    fitted.lobe(&format!("render moving s.json {VIEW} --spheres 5 -o fewer.exr")).succeeds();
    assert!(dir.bytes("file.exr") == fitted.bytes("fitted.exr"), "the same picture");
    assert!(dir.bytes("file.exr") != fitted.bytes("fewer.exr"), "spheres are seen in it");
}

#[test]
fn spheres_of_an_entity_have_its_joints() {
    let dir = Dir::new();
    let figure = built_in::moving("walking-figure").unwrap();
    let node = figure.entity("figure").unwrap().node();
    dir.lobe(&format!("{FIT} --entity {node} --points 300 --rounds 2 -o f.safetensors")).succeeds();
    let set = read_spheres(dir.path("f.safetensors")).unwrap();
    assert_eq!(set.skin().map(|skin| skin.joints().len()), Some(6), "joints of six spheres");
    let skeleton = set.skeleton().unwrap();
    assert_eq!(
        (skeleton.entity(), skeleton.node(), skeleton.joints().len()),
        (Some("figure"), node, 16),
        "{skeleton:?}"
    );
    dir.lobe(&format!("{FIT} --entity figure --method medial-axis --points 300 -o m.safetensors")).succeeds();
    assert_eq!(read_spheres(dir.path("m.safetensors")).unwrap().skeleton(), Some(skeleton), "by either method");
    let error = dir.lobe(&format!("{FIT} --entity nobody -o f.safetensors")).error();
    assert_eq!(error, "found no entity `nobody` in the scene: expected one of `ground`, `figure`", "");
    let error = dir.lobe(&format!("{FIT} -o f.safetensors")).error();
    assert!(error.contains("--entity NAME"), "{error}");
}

#[test]
fn spheres_that_cannot_follow_the_joints_are_refused_in_one_line() {
    let dir = walk(ANIMATED);
    let figure = built_in::moving("walking-figure").unwrap();
    let skeleton = Skeleton::of(&figure, figure.entity("figure").unwrap());
    let plain = || SphereSet::new(vec![[0.0, 0.0, 1.0]], vec![0.1]).unwrap();
    let with = |entity: &str, joints: Vec<Option<String>>| {
        let skin = Skin::new(vec![[0; 4]], vec![[1.0, 0.0, 0.0, 0.0]]).unwrap();
        let set = plain().with_skin(skin).unwrap();
        set.with_skeleton(Skeleton::new(Some(entity.to_owned()), 7, joints)).unwrap()
    };
    let names = skeleton.joints().to_vec();
    let mut renamed = names.clone();
    renamed[3] = Some("antenna".to_owned());
    for (set, expected) in [
        (plain(), "f.safetensors: expected spheres bound to the joints of `figure`, found spheres without joints"),
        (
            with("figure", names[1..].to_vec()),
            "f.safetensors: expected spheres bound to the 16 joints of `figure`, found some bound to 15",
        ),
        (with("figure", renamed), "f.safetensors: found no joint `antenna` in `figure`"),
        (
            with("ghost", names.clone()),
            "f.safetensors: found spheres of `ghost`, which does not move here: expected one of `figure`",
        ),
        (with("ground", names.clone()), "f.safetensors: found spheres of `ground`, which does not move here"),
    ] {
        write_spheres(dir.path("f.safetensors"), &set).unwrap();
        let error = refused(&dir);
        assert!(error.contains(expected), "expected {expected:?} in: {error}");
    }
    let far = SphereSet::new(vec![[0.0, 0.0, 50.0]], vec![0.1]).unwrap();
    let far = far.with_skin(with("figure", names.clone()).skin().unwrap().clone()).unwrap();
    write_spheres(dir.path("f.safetensors"), &far.with_skeleton(skeleton).unwrap()).unwrap();
    assert!(refused(&dir).contains("f.safetensors: expected spheres of `walker: figure`, within "), "of another mesh");

    write_spheres(dir.path("f.safetensors"), &with("figure", names.clone())).unwrap();
    let mut bytes = dir.bytes("f.safetensors");
    let at = bytes.windows(4).rposition(|four| four == 1.0_f32.to_le_bytes()).unwrap();
    bytes[at..at + 4].copy_from_slice(&0.7_f32.to_le_bytes());
    dir.file("f.safetensors", &bytes);
    assert!(refused(&dir).contains("f.safetensors: expected weights that sum to 1, found [0.7, "), "weights");

    write_spheres(dir.path("f.safetensors"), &with("figure", names)).unwrap();
    dir.lobe(&format!("render moving s.json {VIEW} -o good.exr")).succeeds();
    let twice = walk(&ANIMATED.replace(r#""f.safetensors""#, r#"["f.safetensors","f.safetensors"]"#));
    twice.file("f.safetensors", dir.bytes("f.safetensors"));
    assert!(refused(&twice).contains("`walker: figure` has spheres of another file already"), "twice");
    let field = walk(&ANIMATED.replace("spheres", "field"));
    field.file("f.safetensors", dir.bytes("f.safetensors"));
    assert!(refused(&field).contains("none can be named for it"), "fields stay as they are");
}

#[test]
fn spheres_with_joints_are_refused_where_no_animation_moves_them() {
    let dir = Dir::new();
    dir.lobe(&format!("{FIT} --entity figure --points 300 --rounds 2 -o f.safetensors")).succeeds();
    let entity = r#"{"name":"t","mesh":"built-in:ball","spheres":"f.safetensors"}"#;
    dir.file("s.json", format!(r#"{{"format":"lobe-scene","version":1,"entities":[{entity}]}}"#));
    let error = refused(&dir);
    assert!(error.contains("f.safetensors: expected spheres of `t`, which no animation moves"), "{error}");
}
