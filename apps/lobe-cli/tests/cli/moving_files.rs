//! `lobe render` of moving scenes in files: poses, what parts bring along, and bad input, each a clear line or a defined result.

use lobe::shadow::{SphereSet, write_spheres};

use crate::harness::{Dir, mean};
#[cfg(unix)]
use crate::stopped::{line, started, stopped};

const TETRAHEDRON: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 4 3\nf 1 2 4\nf 2 3 4\n";
const GROUND: &str = "v -3 0 3\nv 3 0 3\nv 3 0 -3\nv -3 0 -3\nf 1 2 3 4\n";
const VIEW: &str = "--env bundled:sunset --size 16x12 --bake-samples 16 --no-split";
/// The same where shadows on the ground are to be seen, which needs more vertices than its corners.
const SPLIT: &str = "--env bundled:sunset --size 16x12 --bake-samples 16 --still-points 64";
const TRUTH: &str = "--env bundled:sunset --size 16x12 --samples 2 --bounces 0";

/// A folder with a ground and a tetrahedron, and a description of both whose entity has these further members.
fn scene(members: &str) -> Dir {
    let dir = Dir::new();
    dir.file("t.obj", TETRAHEDRON);
    dir.file("ground.obj", GROUND);
    describe(&dir, members);
    dir
}

fn describe(dir: &Dir, members: &str) {
    dir.file(
        "s.json",
        format!(
            r#"{{"format":"lobe-scene","version":1,"still":"ground.obj","entities":[{{"name":"t","mesh":"t.obj"{members}}}]}}"#
        ),
    );
}

const KEYS: &str = r#","keys":[{"translation":[0,0,1]},{"time":1,"translation":[2,0,1]}]"#;

const TRIANGLE: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

/// A glTF file of triangles, three corners each, that an animation moves from x = 0 to x = 4 within 2 seconds.
fn animated_gltf(dir: &Dir, corners: &[[f32; 3]]) {
    let keys = [0.0, 2.0, 1.0, 0.0, 0.0, 4.0, 0.0, 0.0];
    dir.file("a.bin", corners.iter().flatten().chain(&keys).flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>());
    let (count, bytes) = (corners.len(), 12 * corners.len());
    dir.file(
        "a.gltf",
        format!(
            r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
            "buffers":[{{"uri":"a.bin","byteLength":{}}}],
            "bufferViews":[{{"buffer":0,"byteLength":{bytes}}},{{"buffer":0,"byteOffset":{bytes},"byteLength":8}},
                {{"buffer":0,"byteOffset":{},"byteLength":24}}],
            "accessors":[{{"bufferView":0,"componentType":5126,"count":{count},"type":"VEC3","min":[0,0,0],"max":[1,1,1]}},
                {{"bufferView":1,"componentType":5126,"count":2,"type":"SCALAR","min":[0],"max":[2]}},
                {{"bufferView":2,"componentType":5126,"count":2,"type":"VEC3"}}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
            "animations":[{{"name":"Slide","channels":[{{"sampler":0,"target":{{"node":0,"path":"translation"}}}}],
                "samplers":[{{"input":1,"output":2}}]}}]}}"#,
            bytes + 32,
            bytes + 8
        ),
    );
}

#[test]
fn spheres_of_a_whole_file_that_moves_say_that_they_do_not_follow() {
    let dir = Dir::new();
    let [o, x, y, z] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    animated_gltf(&dir, &[o, y, x, o, z, y, o, x, z, x, y, z]);
    let fit = "spheres a.gltf -n 2 --points 100 --rounds 1 -o f.safetensors";
    let (_, notes) = dir.lobe(fit).succeeds();
    assert!(notes.contains("note: a.gltf: is posed by animations") && notes.contains("--entity NAME"), "{notes}");
    let (_, notes) = dir.lobe(&format!("{fit} --entity 0")).succeeds();
    assert!(!notes.contains("--entity"), "{notes}");
}

#[test]
fn a_field_of_a_whole_file_that_moves_says_that_it_does_not_follow() {
    let dir = Dir::new();
    animated_gltf(&dir, &TRIANGLE);
    let bake = "field a.gltf --order 2 --spheres 3 --cells 4 --rays 4 -o f.safetensors";
    let (_, notes) = dir.lobe(bake).succeeds();
    assert!(notes.contains("note: a.gltf: is posed by animations") && notes.contains("--entity NAME"), "{notes}");
    let (_, notes) = dir.lobe(&format!("{bake} --entity 0")).succeeds();
    assert!(!notes.contains("--entity") && !notes.contains("posed"), "{notes}");
}

#[test]
fn the_truth_of_an_animated_file_is_posed_as_fields_are() {
    let dir = Dir::new();
    animated_gltf(&dir, &TRIANGLE);
    let view = "--eye 0.5,-8,1 --target 0.5,0,1 --fov 60";
    let truth = |more: &str, out: &str| {
        dir.lobe(&format!("render trace a.gltf {TRUTH} {view} {more} -o {out}.exr")).succeeds().1
    };
    let notes = truth("", "plain");
    assert!(!notes.contains("animations are not used"), "{notes}");
    truth("--time 0 --animation Slide", "zero");
    assert!(dir.bytes("plain.exr") == dir.bytes("zero.exr"), "without --time it is at 0");
    let notes = truth("--time 99", "late");
    assert!(notes.contains("has come to its end at 2.000 s and rests there"), "{notes}");
    truth("--time 2 --animation 0", "end");
    assert!(dir.bytes("late.exr") == dir.bytes("end.exr"), "after its end it rests");
    truth("--time 5 --loop", "looped");
    truth("--time 1", "middle");
    assert!(dir.bytes("looped.exr") == dir.bytes("middle.exr"), "5 s is 1 s of a loop of 2 s");
    assert!(dir.bytes("middle.exr") != dir.bytes("zero.exr"), "it moves");
    let notes = dir.lobe("render irradiance a.gltf --env bundled:sunset --size 16x12 -o still.png").succeeds().1;
    assert!(
        notes.contains("it is taken at 0 s of its animation `Slide`; --time and --animation choose another"),
        "{notes}"
    );
}

#[test]
fn bakes_and_all_modes_see_a_file_that_moves_as_the_truth_does() {
    let dir = Dir::new();
    let [o, x, y, z] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    animated_gltf(&dir, &[o, y, x, o, z, y, o, x, z, x, y, z]);
    let bake = "bake a.gltf --mode shadowed --order 2 --samples 16";
    let position = |file: &str| {
        let scene = dir.baked(file).scene;
        f64::from(scene.meshes()[0].positions()[0][0]) + scene.origin()[0]
    };
    for (options, file, expected) in [
        ("", "first.glb", 1.0),
        ("--time 1", "middle.glb", 2.5),
        ("--time 1.5 --animation Slide", "later.glb", 3.25),
        ("--time 9 --animation 0", "end.glb", 4.0),
    ] {
        dir.lobe(&format!("{bake} {options} -o {file}")).succeeds();
        // The recipe says where it stood, so that it is looked up there.
        assert_eq!(position(file), expected, "{options}");
    }
    let view = "--env bundled:sunset --size 16x12 --eye 2.5,-8,1 --target 2.5,0,1 --fov 60 --order 2";
    let shown = |scene: &str, more: &str| {
        dir.lobe(&format!("render {more} {scene} {view} -o {scene}.exr")).succeeds();
        dir.bytes(&format!("{scene}.exr"))
    };
    let baked = shown("middle.glb", "baked --mode shadowed");
    assert!(
        baked == shown("a.gltf", "baked --mode shadowed --bake-samples 16 --time 1"),
        "baked before and on the way"
    );
    assert!(baked != shown("first.glb", "baked --mode shadowed"), "it moves");
    let at_rest = shown("a.gltf", "irradiance");
    assert!(at_rest != shown("a.gltf", "irradiance --time 1"), "modes without transfer pose it, too");
    for (command, part) in [
        (
            "render middle.glb --env bundled:sunset --mode shadowed --time 2 --quiet -o a.png",
            "middle.glb is baked in one pose",
        ),
        ("bake a.gltf --animation Run -o b.glb", "found no animation `Run` in the scene: expected one of `Slide`"),
        ("bake built-in:ball --time 1 -o b.glb", "--time: only what a glTF file moves"),
        ("field a.gltf --entity 0 --time 1 -o f.safetensors", "--time: --entity takes a part in its own frame"),
    ] {
        let line = dir.lobe(command).error();
        assert!(line.contains(part), "{command}: {line}");
    }
}

#[test]
fn pictures_past_the_end_are_told() {
    let dir = scene(KEYS);
    let notes = dir.lobe(&format!("render trace s.json {TRUTH} --frames 0..4 --fps 2 -o f.png")).succeeds().1;
    assert!(
        notes.contains("comes to its end at 1.000 s: the last 3 pictures are alike; --loop begins anew"),
        "{notes}"
    );
    assert!(dir.bytes("f-002.png") == dir.bytes("f-003.png"), "at the end and after it");
    assert!(dir.bytes("f-003.png") == dir.bytes("f-004.png"), "alike");
    assert!(dir.bytes("f-001.png") != dir.bytes("f-002.png"), "before the end");
    assert!(dir.bytes("f-000.png") != dir.bytes("f-002.png"), "it moves");
    let notes = dir.lobe(&format!("render trace s.json {TRUTH} --frames 0..4 --fps 2 --loop -o g.png")).succeeds().1;
    assert!(!notes.contains("alike"), "{notes}");
    assert!(dir.bytes("g-001.png") == dir.bytes("g-003.png"), "it begins anew after 1 s");
    let notes = dir.lobe(&format!("render trace s.json {TRUTH} --frames 2 -o h.png")).succeeds().1;
    assert!(notes.contains("stands still while the light turns; --frames A..B lets it move"), "{notes}");
}

#[test]
fn an_entity_that_begins_anew_by_itself_has_no_end() {
    let dir = Dir::new();
    animated_gltf(&dir, &TRIANGLE);
    let notes = |looped: &str, times: &str| {
        let entity = format!(r#"{{"name":"t","mesh":"a.gltf","animation":0{looped}}}"#);
        dir.file("s.json", format!(r#"{{"format":"lobe-scene","version":1,"entities":[{entity}]}}"#));
        dir.lobe(&format!("render trace s.json {TRUTH} {times} -o x.png")).succeeds().1
    };
    for (times, end) in
        [("--time 5", "has come to its end at 2.000 s"), ("--frames 96..97", "comes to its end at 2.000 s")]
    {
        let (rests, loops) = (notes("", times), notes(r#","loop":true"#, times));
        assert!(rests.contains(end), "{times}: {rests}");
        assert!(!loops.contains("end at"), "{times}: {loops}");
    }
}

#[test]
fn pictures_that_no_animation_can_show_are_written_without_it() {
    let dir = scene(KEYS);
    for fps in ["5000", "0.01"] {
        let render = format!("render trace s.json {TRUTH} --frames 0..1 --fps {fps}");
        let error = dir.lobe(&format!("{render} --quiet -o f.png")).error();
        let expected = "--fps: an animated .png shows each picture for 0.001 to 65 seconds, found ";
        assert!(error.starts_with(expected), "{fps}: {error}");
        assert_eq!(dir.names(), ["ground.obj", "s.json", "t.obj"], "refused before any work");
        let notes = dir.lobe(&format!("{render} -o f.exr")).succeeds().1;
        assert!(notes.contains("note: f.exr: no animation of the pictures is written"), "{fps}: {notes}");
        assert_eq!(dir.names(), ["f-000.exr", "f-001.exr", "ground.obj", "s.json", "t.obj"], "the pictures alone");
        for name in ["f-000.exr", "f-001.exr"] {
            std::fs::remove_file(dir.path(name)).unwrap();
        }
    }
}

#[test]
fn a_description_with_a_byte_order_mark_is_read_and_one_that_is_cut_off_is_said_to_be() {
    let dir = scene("");
    let text = String::from_utf8(dir.bytes("s.json")).unwrap();
    dir.file("s.json", format!("\u{feff}{text}"));
    dir.lobe(&format!("render trace s.json {TRUTH} -o x.png")).succeeds();
    dir.file("s.json", "{");
    let error = dir.lobe(&format!("render trace s.json {TRUTH} --quiet -o x.png")).error();
    let expected = "s.json: expected a description of a scene, found: EOF while parsing an object at line 1 column 1";
    assert_eq!(error, expected, "cut off");
}

#[test]
fn commands_that_read_no_descriptions_say_which_does() {
    let dir = scene("");
    for command in ["bake s.json -o b.glb", "field s.json -o f.safetensors", "spheres s.json -n 2 -o p.safetensors"] {
        let error = dir.lobe(&format!("{command} --quiet")).error();
        let expected = "s.json: only lobe render reads descriptions of scenes; expected a file named .glb, ";
        assert!(error.starts_with(expected), "{command}: {error}");
    }
}

#[test]
fn scenes_of_the_program_that_move_are_named_with_what_they_need() {
    let dir = Dir::new();
    let error = |text: &str| {
        dir.file("s.json", format!(r#"{{"format":"lobe-scene","version":1,{text}}}"#));
        dir.lobe(&format!("render trace s.json {TRUTH} --quiet -o x.png")).error()
    };
    let moves =
        "built-in:three-objects: moves by an animation: expected an entity of it with an `animation`, such as 0";
    assert_eq!(error(r#""still":"built-in:three-objects""#), moves, "what stands still");
    assert_eq!(error(r#""entities":[{"name":"a","mesh":"built-in:three-objects"}]"#), moves, "an entity");
    let named = error(r#""still":"built-in:nope""#);
    assert!(named.ends_with("furnace, and with an `animation` three-objects and walking-figure"), "{named}");
    let still = error(r#""entities":[{"name":"a","mesh":"built-in:ball","animation":0}]"#);
    assert!(still.starts_with("built-in:ball: has no animation: "), "{still}");
    let named = dir.lobe(&format!("render moving built-in:nope {VIEW} --quiet -o x.png")).error();
    assert!(
        named.ends_with("of lobe render also built-in:three-objects and built-in:walking-figure, which move"),
        "{named}"
    );
}

#[test]
fn the_order_is_that_of_the_files_and_a_higher_one_names_the_part() {
    let dir = scene("");
    dir.lobe("field t.obj -o t.field.safetensors --order 2 --spheres 4 --cells 4 --rays 16").succeeds();
    describe(&dir, r#","field":"t.field.safetensors","keys":[{"translation":[0,0,1]}]"#);
    dir.lobe(&format!("render moving s.json {VIEW} -o a.exr")).succeeds();
    dir.lobe(&format!("render moving s.json {VIEW} --order 2 -o b.exr")).succeeds();
    assert!(dir.bytes("a.exr") == dir.bytes("b.exr"), "order 2 without asking");
    let error = dir.lobe(&format!("render moving s.json {VIEW} --order 3 --quiet -o c.exr")).error();
    assert!(error.starts_with("`t`: expected its field to have 3 bands at least, found 2"), "{error}");
    // A field of another mesh.
    dir.file("s2.json", r#"{"format":"lobe-scene","version":1,"entities":[{"name":"o","mesh":"ground.obj","field":"t.field.safetensors"}]}"#);
    let error = dir.lobe(&format!("render moving s2.json {VIEW} --quiet -o c.exr")).error();
    assert!(error.contains("t.field.safetensors: expected the field of `o`"), "{error}");
}

#[test]
#[ignore = "long: of the nightly group"]
fn a_table_of_spheres_is_kept_and_one_of_another_window_refused() {
    let dir = scene(KEYS);
    let render = |more: &str| {
        dir.lobe(&format!("render moving s.json {SPLIT} --method exponentials --order 2 --spheres 2 {more} --quiet"))
    };
    render("--sphere-table t.safetensors -o a.exr").succeeds();
    let kept = dir.bytes("t.safetensors");
    render("--sphere-table t.safetensors -o b.exr").succeeds();
    assert!(dir.bytes("t.safetensors") == kept && dir.bytes("a.exr") == dir.bytes("b.exr"), "taken as it is");
    render("-o c.exr").succeeds();
    assert!(dir.bytes("a.exr") == dir.bytes("c.exr"), "the table that is made without a file");
    dir.lobe("spheres table -o w.safetensors --order 2 --window 3").succeeds();
    let error = render("--sphere-table w.safetensors -o d.exr").error();
    assert!(error.starts_with("w.safetensors: ") && error.contains("a window of 3"), "{error}");
    render("--sphere-table w.safetensors --sphere-window 3 -o d.exr").succeeds();
    assert!(dir.bytes("d.exr") != dir.bytes("a.exr"), "a window changes shadows");
}

#[test]
fn a_table_of_spheres_says_its_own_clamp_and_tolerance() {
    let dir = scene(KEYS);
    let render = |more: &str| {
        dir.lobe(&format!("render moving s.json {SPLIT} --method exponentials --order 2 --spheres 2 {more} --quiet"))
    };
    render("-o default.exr").succeeds();
    for (name, option) in [("clamp", "--clamp 0.4"), ("coarse", "--tolerance 0.3")] {
        dir.lobe(&format!("spheres table -o {name}.safetensors --order 2 {option}")).succeeds();
        let kept = dir.bytes(&format!("{name}.safetensors"));
        render(&format!("--sphere-table {name}.safetensors -o {name}.exr")).succeeds();
        assert!(dir.bytes(&format!("{name}.safetensors")) == kept, "{option}: taken as it is");
    }
    // The more of a logarithm the clamp takes, the less is hidden.
    let [clamped, default] = ["clamp.exr", "default.exr"].map(|name| mean(&dir.numbers(name)));
    assert!(clamped > default, "a clamp of 0.4 leaves {clamped}, of 0.02 {default}");
    let error = dir
        .lobe(&format!(
            "render moving s.json {SPLIT} --method exponentials --sphere-table clamp.safetensors --quiet -o x.exr"
        ))
        .error();
    assert!(
        error.starts_with("clamp.safetensors: a table of another order: expected order 4, found order 2"),
        "{error}"
    );
}

#[test]
fn spheres_without_size_hide_nothing_and_none_are_no_fault() {
    let with = |dir: &Dir, centers: Vec<[f32; 3]>, radii: Vec<f32>, name: &str| {
        write_spheres(dir.path("t.spheres.safetensors"), &SphereSet::new(centers, radii).unwrap()).unwrap();
        let out = format!("{name}.exr");
        dir.lobe(&format!("render moving s.json {VIEW} --method exponentials --order 2 --sphere-bounce -o {out}"))
            .succeeds();
        dir.bytes(&out)
    };
    let dir = scene(&format!(r#","spheres":"t.spheres.safetensors"{KEYS}"#).replace(",0,1]", ",0,0]"));
    let none = with(&dir, Vec::new(), Vec::new(), "none");
    let points = with(&dir, vec![[0.2, 0.2, 0.2], [0.0, 0.0, 0.0]], vec![0.0, 0.0], "points");
    assert!(none == points, "points hide what no spheres hide");
    // The first translation puts the center on a corner of the tetrahedron and on the ground.
    let some = with(&dir, vec![[0.0, 0.0, 0.0]], vec![0.5], "some");
    assert!(some != none, "a sphere around a receiver has a defined shadow");
    // Spheres of another mesh.
    write_spheres(dir.path("t.spheres.safetensors"), &SphereSet::new(vec![[50.0, 0.0, 0.0]], vec![1.0]).unwrap())
        .unwrap();
    let error = dir.lobe(&format!("render moving s.json {VIEW} --method exponentials --quiet -o x.exr")).error();
    assert!(error.contains("t.spheres.safetensors: expected spheres of `t`"), "{error}");
}

#[test]
fn objects_that_overlap_have_a_defined_picture() {
    let dir = scene("");
    let entity = r#"{"name":"t","mesh":"t.obj","keys":[{"translation":[0,0,0.5]}]}"#;
    dir.file(
        "s.json",
        format!(r#"{{"format":"lobe-scene","version":1,"still":"ground.obj","entities":[{entity},{entity}]}}"#),
    );
    for mode in ["fields", "exponentials --spheres 2"] {
        let command = format!("render moving s.json {VIEW} --order 2 --method {mode}");
        dir.lobe(&format!("{command} -o a.exr")).succeeds();
        dir.lobe(&format!("{command} -o b.exr --threads 1")).succeeds();
        assert!(dir.bytes("a.exr") == dir.bytes("b.exr"), "{mode}: the same for any number of threads");
        let (picture, _) = lobe::image::read_picture(dir.path("a.exr"), &Default::default()).unwrap();
        assert!(picture.pixels().iter().flatten().all(|c| c.is_finite()), "{mode}");
    }
}

#[test]
fn descriptions_at_fault_end_in_one_line() {
    let dir = scene(KEYS);
    let damaged: &[(&str, &str)] = &[
        (
            r#","keys":[{"translation":[1e308,0,0]},{"time":1,"translation":[-1e308,0,0]}]"#,
            "a translation of at most 1e15",
        ),
        (r#","keys":[{"time":-1e308},{"time":1e308}]"#, "a time of at most 1e15 seconds"),
        (r#","keys":[{"scale":1e-300}]"#, "a scale from 1e-15 to 1e15"),
        (r#","keys":[{"scale":0}]"#, "a positive scale"),
        (r#","keys":[{"time":1},{"time":0}]"#, "times that rise, found 0 after 1"),
        (r#","keys":[{"rotation":[0,0,0,2]}]"#, "unit quaternion"),
        (r#","keys":[{"translation":[0,0]}]"#, "entities[0].keys[0].translation"),
        (r#","field":"none.safetensors""#, "none.safetensors"),
        (r#","field":"t.obj""#, "t.obj"),
        (r#","spheres":"../t.obj""#, "outside of its folder"),
        (r#","hue":1"#, "unknown field `hue`"),
        (r#","mesh":"ground.obj""#, "duplicate field `mesh`"),
    ];
    for (members, expected) in damaged {
        describe(&dir, members);
        for time in ["0", "1.7e308"] {
            let error = dir.lobe(&format!("render moving s.json {VIEW} --time {time} --quiet -o x.png")).error();
            assert!(error.contains(expected) && !error.contains("a fault of this program"), "{members}: {error}");
        }
    }
    for text in [
        "",
        "{",
        "[]",
        "{\"format\":\"lobe-scene\",\"version\":1}",
        "{\"format\":\"lobe-scene\",\"version\":9,\"still\":\"ground.obj\"}",
    ] {
        dir.file("s.json", text);
        let error = dir.lobe(&format!("render trace s.json {TRUTH} --quiet -o x.png")).error();
        assert!(error.starts_with("s.json: expected "), "{text}: {error}");
    }
}

#[cfg(unix)]
#[test]
fn a_pipe_that_a_description_names_is_refused_and_not_waited_for() {
    let dir = scene(KEYS);
    assert!(std::process::Command::new("mkfifo").arg(dir.path("pipe")).status().unwrap().success(), "a pipe");
    let expected = "pipe: expected a file, found a device or a pipe";
    for members in [r#","field":"pipe""#, r#","spheres":"pipe""#] {
        describe(&dir, members);
        let error = dir.lobe(&format!("render moving s.json {VIEW} --quiet -o x.png")).error();
        assert!(error.contains(expected), "{members}: {error}");
    }
    let lamp = r#"{"format":"lobe-scene","version":1,"still":"ground.obj","lamps":[{"name":"l","file":"pipe"}]}"#;
    let still = r#"{"format":"lobe-scene","version":1,"still":{"mesh":"ground.obj","field":"pipe"}}"#;
    let mesh = r#"{"format":"lobe-scene","version":1,"still":"pipe"}"#;
    for text in [lamp, still, mesh] {
        dir.file("s.json", text);
        let error = dir.lobe(&format!("render moving s.json {VIEW} --quiet -o x.png")).error();
        assert!(error.contains(expected), "{text}: {error}");
    }
}

#[test]
fn what_is_baked_of_parts_is_held_against_the_limit_of_memory() {
    let dir = scene(KEYS);
    // An expansion takes less than a map.
    dir.lobe("project bundled:sunset --order 4 --quiet -o sky.sh.json").stdout();
    let view = VIEW.replace("bundled:sunset", "sky.sh.json");
    let error = dir.lobe(&format!("render moving s.json {view} --max-memory 0.00002 --quiet -o x.png")).error();
    assert!(error.starts_with("what is baked of the parts takes up to "), "{error}");
    assert!(error.ends_with("ask for a lower --order, or raise the limit with --max-memory"), "{error}");
}

#[cfg(unix)]
#[test]
fn bakes_of_parts_that_were_stopped_go_on_with_the_same_command() {
    let dir = scene(KEYS);
    // More work each time it was done before it could be stopped.
    for samples in [1 << 10, 1 << 13, 1 << 16, 1 << 19] {
        let args = format!(
            "render moving s.json --env bundled:sunset --size 16x12 --bake-samples {samples} --quiet -o out.exr"
        );
        let Some(output) = stopped(&dir, started(&dir, &args), "out.exr.checkpoint.field-1") else {
            std::fs::remove_file(dir.path("out.exr")).unwrap();
            continue;
        };
        let line = line(output);
        assert!(line.contains("the same command "), "{line}");
        assert!(dir.names().contains(&"out.exr.checkpoint.transfer-0".to_owned()), "{:?}", dir.names());
        dir.lobe(&args).stdout();
        assert_eq!(dir.names(), ["ground.obj", "out.exr", "s.json", "t.obj"], "files at the end");
        dir.lobe(&args.replace("out.exr", "whole.exr")).stdout();
        assert!(dir.bytes("out.exr") == dir.bytes("whole.exr"), "the same bytes as without a stop");
        return;
    }
    panic!("the bakes were done before they could be stopped");
}

#[test]
fn edges_of_what_moves_are_split_where_that_is_asked_for() {
    let dir = Dir::new();
    let view = "--env bundled:sunset --method exponentials --order 2 --size 16x12 --spheres 2 --bake-samples 4 --still-points 0 --quiet";
    for (name, option) in [("coarse", " --no-split"), ("fine", " --max-edge 0.3")] {
        dir.lobe(&format!("render moving built-in:three-objects {view}{option} -o {name}.exr")).succeeds();
    }
    assert!(dir.bytes("coarse.exr") != dir.bytes("fine.exr"), "light at more vertices is other light");
    dir.file("s.json", "{}");
    let error = dir.lobe(&format!("render moving s.json {view} --max-edge 0.2 -o x.exr")).error();
    assert_eq!(error, "--max-edge: not of a scene description; leave the option out");
}
