//! Colors, texture coordinates and strips of PLY files.

use lobe_scene::{Scene, SceneReadOptions, SceneReadReport, read_scene_bytes};

fn read(text: &str) -> (Scene, SceneReadReport) {
    read_scene_bytes(text.as_bytes(), "a.ply", &SceneReadOptions::default()).unwrap()
}

/// A triangle whose vertices have these properties, by lines of the header, all with these values; likewise its face.
fn triangle([vertex, values]: [&str; 2], [face, face_values]: [&str; 2]) -> String {
    let xyz = "property float x\nproperty float y\nproperty float z\n";
    let corners: String = ["0 0 0", "1 0 0", "0 1 0"].map(|p| format!("{p} {values}\n")).concat();
    format!(
        "ply\nformat ascii 1.0\nelement vertex 3\n{xyz}{vertex}element face 1\n\
         property list uchar int vertex_indices\n{face}end_header\n{corners}3 0 1 2 {face_values}\n"
    )
}

fn properties(kind: &str, names: &[&str]) -> String {
    names.iter().map(|name| format!("property {kind} {name}\n")).collect()
}

const NOTHING: [&str; 2] = ["", ""];

#[test]
fn colors_of_whole_numbers_are_parts_of_the_largest_of_their_type() {
    for (kind, half, most) in [
        ("char", "64", "127"),
        ("uchar", "128", "255"),
        ("short", "16384", "32767"),
        ("ushort", "32768", "65535"),
        ("int", "1073741824", "2147483647"),
        ("uint", "2147483648", "4294967295"),
        ("int", "128", "255"),
    ] {
        let header = properties(kind, &["red", "green", "blue", "alpha"]);
        let (scene, report) = read(&triangle([&header, &format!("{most} {half} 0 {half}")], NOTHING));
        let [r, g, b, a] = scene.meshes()[0].colors()[0];
        assert_eq!((r, b), (1.0, 0.0), "{kind}: all and none");
        // Half of the most is 0.214 in linear light, and half a step of eight bits is 0.0035.
        assert!((g - 0.214).abs() < 0.004 && (a - 0.5).abs() < 0.005, "{kind}: {g} and alpha {a}");
        assert_eq!(report.notes, Vec::<String>::new(), "{kind}: notes");
    }
    let header = properties("float", &["red", "green", "blue"]);
    let (scene, _) = read(&triangle([&header, "0.25 0.5 1"], NOTHING));
    assert_eq!(scene.meshes()[0].colors()[0], [0.25, 0.5, 1.0, 1.0], "floats are linear");
}

#[test]
fn of_several_texture_coordinates_the_first_are_used() {
    for (names, values, expected, unused) in [
        (&["s", "t", "texture_u", "texture_v"][..], "0.25 0.25 0.5 0.5", [0.25, 0.75], "`texture_u`, `texture_v`"),
        (&["texture_u", "texture_v", "u", "v"][..], "0.25 0.25 0.5 0.5", [0.5, 0.5], "`texture_u`, `texture_v`"),
        (&["u", "s", "t"][..], "1 0.25 0.25", [0.25, 0.75], "`u`"),
        (&["texture_u", "texture_v"][..], "0.25 0.25", [0.25, 0.75], ""),
    ] {
        let (scene, report) = read(&triangle([&properties("float", names), values], NOTHING));
        assert_eq!(scene.meshes()[0].uvs(0), [expected; 3], "{names:?}");
        let note = format!("colors or texture coordinates of `vertex` in a form that is not used: {unused}");
        let expected = if unused.is_empty() { vec![] } else { vec![note] };
        assert_eq!(report.notes, expected, "{names:?}: notes");
    }
}

#[test]
fn colors_in_a_form_that_is_not_read_are_noted() {
    let diffuse = properties("uchar", &["diffuse_red", "diffuse_green", "diffuse_blue", "quality"]);
    let face = properties("uchar", &["red", "green", "blue"]) + "property list uchar float texcoord\n";
    let (scene, report) = read(&triangle([&diffuse, "255 0 0 7"], [&face, "255 0 0 6 0 0 1 0 0 1"]));
    assert!(scene.meshes()[0].colors().is_empty(), "no colors");
    let in_a_form =
        |element: &str| format!("colors or texture coordinates of `{element}` in a form that is not used: ");
    let expected = [
        in_a_form("vertex") + "`diffuse_red`, `diffuse_green`, `diffuse_blue`",
        in_a_form("face") + "`red`, `green`, `blue`, `texcoord`",
    ];
    assert_eq!(report.notes, expected, "notes");
    let (_, report) = read(&triangle([&properties("uchar", &["red"]), "255"], NOTHING));
    assert_eq!(report.notes, [in_a_form("vertex") + "`red`"], "red alone");
}

#[test]
fn textures_splats_and_intensities_that_are_not_used_are_noted() {
    let uvs = triangle([&properties("float", &["s", "t"]), "0.25 0.25"], NOTHING);
    let textured = uvs.replace("format ascii 1.0\n", "format ascii 1.0\ncomment TextureFile wall.png\n");
    let expected = ["the texture wall.png is not used; surfaces have the colors of vertices alone"];
    assert_eq!(read(&textured).1.notes, expected, "a texture in a comment");
    let splats = triangle([&properties("float", &["f_dc_0", "f_dc_1", "f_dc_2", "opacity"]), "1 1 1 1"], NOTHING);
    let notes = read(&splats).1.notes;
    assert!(notes.len() == 1 && notes[0].starts_with("Gaussian splats"), "splats: {notes:?}");
    let scanned = triangle([&properties("float", &["scalar_Intensity", "Red"]), "1 1"], NOTHING);
    let expected = "colors or texture coordinates of `vertex` in a form that is not used: `scalar_Intensity`, `Red`";
    assert_eq!(read(&scanned).1.notes, [expected], "scanners");
}

#[test]
fn strips_are_triangles_that_face_one_way() {
    let header = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n\
                  element tristrips 1\nproperty list int int vertex_indices\nend_header\n\
                  0 0 0\n1 0 0\n0 1 0\n1 1 0\n2 1 0\n";
    let (scene, report) = read(&format!("{header}8 0 1 2 3 -1 1 4 3\n"));
    assert_eq!(scene.meshes()[0].triangles(), [[0, 1, 2], [2, 1, 3], [1, 4, 3]], "two strips");
    assert_eq!(report.notes, Vec::<String>::new(), "notes");
    // A vertex that stands there twice, to go on elsewhere.
    let (scene, report) = read(&format!("{header}7 0 1 2 2 1 3 -1\n"));
    assert_eq!((scene.triangle_count(), report.dropped_triangles), (2, 0), "the triangles between are none");
    let below = read_scene_bytes(format!("{header}3 0 1 -2\n").as_bytes(), "a.ply", &SceneReadOptions::default());
    let error = below.map(|_| ()).unwrap_err().to_string();
    assert_eq!(error, "a.ply: row 0 of `tristrips` uses a vertex index below -1 or above 2^32", "message");
}
