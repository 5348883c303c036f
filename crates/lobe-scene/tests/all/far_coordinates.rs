//! OBJ and PLY files with coordinates far from their origin, such as those of maps: digits that `f32` does not hold
//! count.

use lobe_scene::{Scene, SceneReadOptions, Up, read_scene_bytes};

/// A place of a map, in meters.
const PLACE: [f64; 3] = [500_000.25, 4_649_776.75, 120.5];

/// A pyramid with steps that `f32` does not hold there.
const POINTS: [[f64; 3]; 5] =
    [[-1.03125, -1.0, 0.0], [1.0, -1.015625, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0], [0.0, 0.0078125, 1.5]];

const FACES: [[usize; 3]; 4] = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]];

fn moved(by: [f64; 3]) -> Vec<[f64; 3]> {
    POINTS.iter().map(|p| [0, 1, 2].map(|k| p[k] + by[k])).collect()
}

fn obj(points: &[[f64; 3]]) -> Vec<u8> {
    let vertices = points.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n"));
    let faces = FACES.iter().map(|f| format!("f {} {} {}\n", f[0] + 1, f[1] + 1, f[2] + 1));
    vertices.chain(faces).collect::<String>().into_bytes()
}

fn ply(points: &[[f64; 3]], is_binary: bool) -> Vec<u8> {
    let format = if is_binary { "binary_little_endian" } else { "ascii" };
    let head = format!(
        "ply\nformat {format} 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n\
         element face 4\nproperty list uchar int vertex_indices\nend_header\n",
        points.len()
    );
    let mut bytes = head.into_bytes();
    if is_binary {
        bytes.extend(points.as_flattened().iter().flat_map(|c| c.to_le_bytes()));
        for face in FACES {
            bytes.push(3);
            bytes.extend(face.iter().flat_map(|&i| (i as i32).to_le_bytes()));
        }
    } else {
        points.iter().for_each(|[x, y, z]| bytes.extend(format!("{x} {y} {z}\n").bytes()));
        FACES.iter().for_each(|[a, b, c]| bytes.extend(format!("3 {a} {b} {c}\n").bytes()));
    }
    bytes
}

fn read(name: &str, bytes: &[u8], up: Up) -> (Scene, Vec<String>) {
    let (scene, report) = read_scene_bytes(bytes, name, &SceneReadOptions::default().up(up)).unwrap();
    (scene, report.notes)
}

/// The points of a scene in its world, in the order of those of its file that faces use.
fn in_world(scene: &Scene) -> Vec<[f64; 3]> {
    let origin = scene.origin();
    scene.meshes()[0].positions().iter().map(|p| [0, 1, 2].map(|k| f64::from(p[k]) + origin[k])).collect()
}

/// Points as a file has them whose vertices are numbered by first use.
fn by_first_use(points: &[[f64; 3]]) -> Vec<[f64; 3]> {
    [0, 1, 4, 2, 3].map(|i| points[i]).to_vec()
}

#[test]
fn digits_that_f32_does_not_hold_are_kept_far_from_the_origin() {
    let far = moved(PLACE);
    let cases = [
        ("a.obj", obj(&far), by_first_use(&far)),
        ("a.ply", ply(&far, false), far.clone()),
        ("a.ply", ply(&far, true), far.clone()),
    ];
    for (name, bytes, expected) in cases {
        let (scene, notes) = read(name, &bytes, Up::Z);
        for (found, expected) in in_world(&scene).iter().zip(expected) {
            let off = (0..3).map(|k| (found[k] - expected[k]).abs()).fold(0.0, f64::max);
            // The rounding of f32 near the origin of the scene: what is there is smaller than 4.
            assert!(off < 4e-7, "{name}: {found:?}, expected {expected:?}");
        }
        let [note, ..] = &notes[..] else { panic!("{name}: no note") };
        assert!(note.contains("moved by [-500000.25, -4649776.5, -121.25]"), "{name}: {note}");
    }
    let (scene, _) = read("a.obj", &obj(&far), Up::Y);
    let turned = in_world(&scene)[0];
    let off = (0..3).map(|k| (turned[k] - [far[0][0], -far[0][2], far[0][1]][k]).abs()).fold(0.0, f64::max);
    assert!(off < 4e-7, "y up: {turned:?} of {:?}", far[0]);
}

#[test]
fn what_no_face_uses_does_not_keep_a_scene_from_its_origin() {
    let mut far = moved(PLACE);
    far.push([0.0; 3]);
    for (name, bytes) in [("a.obj", obj(&far)), ("a.ply", ply(&far, false))] {
        let (scene, _) = read(name, &bytes, Up::Z);
        let found = in_world(&scene)[0];
        let off = (0..3).map(|k| (found[k] - far[0][k]).abs()).fold(0.0, f64::max);
        assert!(off < 4e-7, "{name}: {found:?}, expected {:?}", far[0]);
    }
}

#[test]
fn a_scene_near_its_origin_is_not_moved() {
    for (name, bytes) in [("a.obj", obj(&POINTS)), ("a.ply", ply(&POINTS, true))] {
        let (scene, notes) = read(name, &bytes, Up::Z);
        assert_eq!((scene.origin(), notes.len()), ([0.0; 3], 0), "{name}: {notes:?}");
    }
}

#[test]
fn digits_that_are_lost_to_something_far_from_the_rest_are_noted() {
    // The pyramid far away, and another one at the origin: one box has both.
    let both = |second: [f64; 3]| {
        let points = moved(PLACE).into_iter().chain(moved(second));
        let vertices = points.map(|[x, y, z]| format!("v {x} {y} {z}\n"));
        let faces = [0, 5].into_iter().flat_map(|first| FACES.map(|f| f.map(|i| i + 1 + first)));
        vertices.chain(faces.map(|[a, b, c]| format!("f {a} {b} {c}\n"))).collect::<String>().into_bytes()
    };
    let notes = |bytes: &[u8]| read("a.obj", bytes, Up::Z).1;
    let text = "coordinates are rounded by up to 2.5e-1: they are too far apart for their digits; leave out what stands far from the rest";
    assert_eq!(notes(&both([0.0; 3])), [text], "far from each other");
    let near = notes(&both([PLACE[0], PLACE[1] + 5.0, PLACE[2]]));
    assert!(near.iter().all(|note| !note.contains("rounded")), "beside each other: {near:?}");
    // A .ply file has the same.
    let mut points = moved(PLACE);
    points[0] = [0.0; 3];
    let (_, found) = read("a.ply", &ply(&points, true), Up::Z);
    assert!(found.iter().any(|note| note.contains("rounded by up to")), "{found:?}");
}
