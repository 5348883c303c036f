//! Normals of OBJ files that have none: smoothing groups, and borders of texture coordinates, groups and materials.

use std::fs;

use lobe_scene::{MissingNormals, Scene, SceneReadOptions, SceneReadReport, Up, read_scene, read_scene_bytes};

fn read(text: &str, normals: MissingNormals) -> (Scene, SceneReadReport) {
    let options = SceneReadOptions::default().up(Up::Z).missing_normals(normals);
    read_scene_bytes(text.as_bytes(), "a.obj", &options).unwrap()
}

/// Two squares that share the edge between the first two positions, the one lying and the other standing.
const POINTS: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\n";

fn close(a: [f32; 3], b: [f32; 3]) -> bool {
    (0..3).all(|k| (a[k] - b[k]).abs() < 1e-6)
}

/// The normals at the edge that both squares share.
fn edge_normals(scene: &Scene) -> Vec<[f32; 3]> {
    let vertices = scene.meshes().iter().flat_map(|mesh| mesh.positions().iter().zip(mesh.normals()));
    vertices.filter(|(p, _)| p[1] == 0.0 && p[2] == 0.0).map(|(_, &n)| n).collect()
}

#[test]
fn an_edge_between_faces_is_round_within_a_smoothing_group_and_hard_elsewhere() {
    for (first, second, is_round) in [
        ("", "", true),
        ("s 1\n", "", true),
        ("s on\n", "s 1\n", true),
        ("s off\n", "", false),
        ("s 0\n", "", false),
        ("s 1\n", "s 2\n", false),
        ("s 1\n", "s off\n", false),
        ("", "s 1\n", false),
    ] {
        let text = format!("{POINTS}{first}f 1 2 3 4\n{second}f 2 1 5 6\n");
        for (normals, is_round) in
            [(MissingNormals::AsFormat, is_round), (MissingNormals::Smooth, true), (MissingNormals::Flat, false)]
        {
            let (scene, report) = read(&text, normals);
            let (mesh, what) = (&scene.meshes()[0], format!("{first:?}, {second:?}, {normals:?}"));
            let count = mesh.positions().len();
            assert_eq!((count, report.made_normals), (if is_round { 6 } else { 8 }, count), "{what}: vertices");
            assert_eq!(report.notes, Vec::<String>::new(), "{what}: notes");
            let half = 0.5_f32.sqrt();
            let expected = if is_round { [[0.0, half, half]; 2] } else { [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]] };
            for found in edge_normals(&scene) {
                assert!(expected.iter().any(|&n| close(found, n)), "{what}: {found:?}, expected one of {expected:?}");
            }
            for t in mesh.triangles().iter().filter(|_| !is_round) {
                let [a, b, c] = t.map(|i| mesh.normals()[i as usize]);
                assert!(a == b && b == c, "{what}: one normal for each triangle: {a:?} {b:?} {c:?}");
            }
        }
    }
}

#[test]
fn normals_are_those_of_positions_across_texture_coordinates_groups_and_materials() {
    let half = 0.5_f32.sqrt();
    let corners = "vt 0 0\nvt 1 1\n";
    for faces in [
        "f 1/1 2/1 3/1 4/1\nf 2/2 1/2 5/2 6/2\n",
        "f 1 2 3 4\ng other\nf 2 1 5 6\n",
        "f 1 2 3 4\nusemtl other\nf 2 1 5 6\n",
        "s 3\nf 1 2 3 4\ns 4\ng between\nf 4 3 6 5\ns 3\ng other\nf 2 1 5 6\n",
    ] {
        let (scene, report) = read(&format!("{POINTS}{corners}{faces}"), MissingNormals::AsFormat);
        let found = edge_normals(&scene);
        assert_eq!((found.len(), report.made_normals), (4, report.vertices), "{faces:?}: two vertices for each corner");
        assert!(found.iter().all(|&n| close(n, [0.0, half, half])), "{faces:?}: {found:?}");
    }
}

#[test]
fn normals_that_a_file_gives_stay() {
    let faces = "vn 0 0 2\ns off\nf 1//1 2//1 3//1 4//1\ng other\nf 2 1 5 6\n";
    let (scene, report) = read(&format!("{POINTS}{faces}"), MissingNormals::AsFormat);
    let [given, made] = scene.meshes() else { panic!("{report:?}") };
    assert_eq!(given.normals(), [[0.0, 0.0, 1.0]; 4], "given");
    assert_eq!((made.normals(), report.made_normals), (&[[0.0, 1.0, 0.0]; 4][..], 4), "made, flat");
}

#[test]
fn a_smoothing_group_that_is_not_understood_is_noted() {
    let (scene, report) = read(&format!("{POINTS}s round\nf 1 2 3 4\nf 2 1 5 6\n"), MissingNormals::AsFormat);
    let note = "line 7: expected the number of a smoothing group or off after s, found `round`, which is not used";
    assert_eq!(report.notes, [note], "notes");
    assert_eq!(scene.vertex_count(), 6, "round, as without it");
}

#[test]
fn of_materials_of_one_name_the_last_is_used() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.obj");
    fs::write(folder.path().join("a.mtl"), "newmtl a\nKd 0.25\nnewmtl b\nKd 0.5\nnewmtl a\nKd 0.75\n").unwrap();
    fs::write(&path, format!("mtllib a.mtl\n{POINTS}usemtl a\nf 1 2 3 4\nusemtl b\nf 2 1 5 6\n")).unwrap();
    let (scene, _) = read_scene(&path, &SceneReadOptions::default()).unwrap();
    let found = [0, 1].map(|mesh| scene.vertex_base_color(mesh, 0)[0]);
    assert_eq!(found, [0.75, 0.5], "of both meshes");
}
