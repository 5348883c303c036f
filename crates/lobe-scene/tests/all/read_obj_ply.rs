//! OBJ and PLY files that are read, and those refused in one line.

use std::fs;
use std::path::Path;

use lobe_scene::{
    MissingNormals, Scene, SceneError, SceneReadOptions, SceneReadReport, Texture, Up, Wrap, read_scene,
    read_scene_bytes,
};

fn read(name: &str, text: &str) -> Result<(Scene, SceneReadReport), SceneError> {
    read_scene_bytes(text.as_bytes(), name, &SceneReadOptions::default())
}

fn refusal(name: &str, bytes: &[u8]) -> String {
    match read_scene_bytes(bytes, name, &SceneReadOptions::default()) {
        Err(error) => error.to_string(),
        Ok((_, report)) => panic!("{name} was read as {report:?}"),
    }
}

const SQUARE_OBJ: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";

#[test]
fn an_obj_is_turned_unless_z_is_up_and_convex_polygons_become_fans() {
    let (scene, report) = read("a.obj", SQUARE_OBJ).unwrap();
    let mesh = &scene.meshes()[0];
    assert_eq!(mesh.positions()[2], [1.0, 0.0, 1.0], "y up");
    assert_eq!(mesh.triangles(), [[0, 1, 2], [0, 2, 3]], "a fan");
    assert_eq!((mesh.normals()[0], report.made_normals), ([0.0, -1.0, 0.0], 4), "made normals");
    let options = SceneReadOptions::default().up(Up::Z);
    let (scene, _) = read_scene_bytes(SQUARE_OBJ.as_bytes(), "a.obj", &options).unwrap();
    assert_eq!(scene.meshes()[0].positions()[2], [1.0, 1.0, 0.0], "z up");
}

#[test]
fn obj_materials_textures_and_colors_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.obj");
    let obj = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0.5 0.75\nvt 0.5 0.25\n\
               usemtl red\nf 1/1 2/1 3/2\nusemtl wood\nf 1/1 3/1 2/1\n";
    fs::write(&path, obj).unwrap();
    let (scene, report) = read_scene(&path, &SceneReadOptions::default()).unwrap();
    assert_eq!(scene.vertex_base_color(0, 0), [1.0; 4], "white without its materials");
    assert!(report.notes.len() == 1 && report.notes[0].contains("a.mtl"), "{:?}", report.notes);
    let two = folder.path().join("two.obj");
    fs::write(&two, obj.replace("a.mtl", "b.mtl red.mtl")).unwrap();
    fs::write(folder.path().join("red.mtl"), "newmtl red\nKd 0.8 0.1 0.05\n").unwrap();
    let (scene, report) = read_scene(&two, &SceneReadOptions::default()).unwrap();
    assert_eq!(scene.vertex_base_color(0, 0), [0.8, 0.1, 0.05, 1.0], "of two files in a line the one that is there");
    let [missing, unknown] = &*report.notes else { panic!("{:?}", report.notes) };
    assert!(missing.contains("b.mtl"), "{missing}");
    assert_eq!(unknown, "material \"wood\" is in none of the libraries; its faces are white", "what none of them has");

    fs::write(folder.path().join("a.mtl"), "newmtl red\nKd 0.8 0.1 0.05\nnewmtl wood\nKd 1 1 1\nmap_Kd w.png\n")
        .unwrap();
    for content in [None, Some("no picture")] {
        if let Some(text) = content {
            fs::write(folder.path().join("w.png"), text).unwrap();
        }
        let (scene, report) = read_scene(&path, &SceneReadOptions::default()).unwrap();
        assert_eq!((scene.textures().len(), scene.vertex_base_color(1, 0)), (0, [1.0; 4]), "the color alone");
        assert!(report.notes.len() == 1 && report.notes[0].contains("w.png"), "{content:?}: {:?}", report.notes);
    }
    fs::write(folder.path().join("w.png"), Texture::new(2, 1, vec![[0; 4]; 2], [Wrap::Repeat; 2]).to_png()).unwrap();
    let small = SceneReadOptions::default().max_texels(1);
    assert!(matches!(read_scene(&path, &small), Err(SceneError::Refused { .. })), "a limit is no missing file");

    let picture = Texture::new(1, 2, vec![[255, 0, 255, 255], [0, 0, 0, 255]], [Wrap::Repeat; 2]);
    fs::write(folder.path().join("w.png"), picture.to_png()).unwrap();
    let (scene, report) = read_scene(&path, &SceneReadOptions::default()).unwrap();
    assert_eq!(report.notes, Vec::<String>::new(), "nothing to note");
    assert_eq!(scene.vertex_base_color(0, 0), [0.8, 0.1, 0.05, 1.0], "red");
    // v = 0.75 upwards is the upper texel.
    assert_eq!(scene.vertex_base_color(1, 0), [1.0, 0.0, 1.0, 1.0], "wood");
}

#[test]
fn obj_vertices_with_and_without_normals_do_not_mix() {
    let (scene, report) = read("a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nvn 0 0 1\nf 1//1 2//1 3\nf 1//1 3 2\n").unwrap();
    assert_eq!(scene.meshes()[0].normals().len(), scene.meshes()[0].positions().len(), "one for each");
    assert!(report.notes[0].contains("normals at some vertices only"), "{:?}", report.notes);
}

#[test]
fn broken_obj_files_are_refused_in_one_line() {
    for (text, expected) in [
        ("", "a.obj: expected triangles, found none"),
        ("v 0 0 0\n", "a.obj: expected triangles, found none"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "a.obj: line 4: the face uses vertex 9, but there are 3"),
        (
            "v 0 0 0\nv 1 0 0\nv nan 1 0\nf 1 2 3\n",
            "a.obj: line 3: expected three coordinates, and a weight or a color after v, found `nan 1 0`",
        ),
        ("v 0 0 0\nv 1 0 0\nf 1 2 2\n", "a.obj: expected triangles with an area, found 1 without"),
        ("v 0 0\nf 1 1 1\n", "a.obj: line 1: expected three coordinates, and a weight or a color after v, found `0 0`"),
        (
            "v 0 0 0\n\n# x\nvt 0 \\\n0\nf 1/2 1 1\n",
            "a.obj: line 6: the face uses texture coordinate 2, but there are 1",
        ),
        ("v 0 0 0\nf 1 2/x 3\n", "a.obj: line 2: expected corners such as 1, 1/2 or 1//3, found `2/x`"),
        ("v 0 0 0\nf 0 1 1\n", "a.obj: line 2: expected corners such as 1, 1/2 or 1//3, found `0`"),
        ("v 0 0 0\nf 1 -2 1\n", "a.obj: line 2: expected corners such as 1, 1/2 or 1//3, found `-2`"),
    ] {
        assert_eq!(refusal("a.obj", text.as_bytes()), expected, "{text:?}");
    }
}

const SQUARE_PLY: &str = "ply\nformat ascii 1.0\ncomment made by hand\nelement vertex 4\nproperty float x\nproperty float y\n\
     property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\n\
     property list uchar int vertex_indices\nend_header\n\
     0 0 0 255 0 0\n1 0 0 255 0 0\n1 1 0 255 255 0\n0 1 0 0 0 188\n4 0 1 2 3\n";

#[test]
fn an_ascii_ply_is_read_with_colors_and_polygons() {
    let (scene, report) = read("a.ply", SQUARE_PLY).unwrap();
    let mesh = &scene.meshes()[0];
    assert_eq!(mesh.positions()[2], [1.0, 0.0, 1.0], "y up");
    assert_eq!(mesh.triangles(), [[0, 1, 2], [0, 2, 3]], "a fan");
    assert_eq!(mesh.colors()[0], [1.0, 0.0, 0.0, 1.0], "red");
    assert!((mesh.colors()[3][2] - 0.503).abs() < 1e-3, "sRGB 188 is half: {}", mesh.colors()[3][2]);
    assert_eq!((report.vertices, report.triangles), (4, 2), "{report:?}");
}

/// A square with normals in doubles, `vertex_index` and an unknown element, in either byte order.
fn binary_ply(big_endian: bool) -> Vec<u8> {
    let order = if big_endian { "big" } else { "little" };
    let mut bytes = format!(
        "ply\nformat binary_{order}_endian 1.0\nelement knot 1\nproperty list uchar short weights\nelement vertex 4\n\
         property double x\nproperty double y\nproperty double z\nproperty float nx\nproperty float ny\n\
         property float nz\nproperty float quality\nelement face 2\nproperty uchar flags\n\
         property list uchar uint vertex_index\nend_header\n"
    )
    .into_bytes();
    let mut put = |little: &[u8]| {
        let mut word = little.to_vec();
        if big_endian {
            word.reverse();
        }
        bytes.extend(word);
    };
    put(&[2]);
    put(&7_i16.to_le_bytes());
    put(&8_i16.to_le_bytes());
    for p in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0_f64]] {
        [p[0], p[1], 0.5].iter().for_each(|c| put(&c.to_le_bytes()));
        [0.0, 0.0, 2.0, 9.0_f32].iter().for_each(|c| put(&c.to_le_bytes()));
    }
    for t in [[0, 1, 2], [0, 2, 3_u32]] {
        put(&[1]);
        put(&[3]);
        t.iter().for_each(|i| put(&i.to_le_bytes()));
    }
    bytes
}

#[test]
fn binary_ply_files_of_either_order_are_read() {
    for big_endian in [false, true] {
        let (scene, report) = read_scene_bytes(&binary_ply(big_endian), "a.ply", &SceneReadOptions::default()).unwrap();
        let mesh = &scene.meshes()[0];
        assert_eq!(mesh.positions()[2], [1.0, -0.5, 1.0], "y up, big endian {big_endian}");
        assert_eq!(mesh.normals(), [[0.0, -1.0, 0.0]; 4], "normals, big endian {big_endian}");
        assert_eq!(mesh.triangles(), [[0, 1, 2], [0, 2, 3]], "triangles, big endian {big_endian}");
        assert_eq!(report.notes, ["the element `knot` is not used"], "notes");
    }
}

#[test]
fn broken_ply_files_are_refused_in_one_line() {
    let huge = SQUARE_PLY.replace("element face 1", "element face 3000000000");
    let outside = SQUARE_PLY.replace("4 0 1 2 3", "4 0 1 2 7");
    let negative = SQUARE_PLY.replace("4 0 1 2 3", "4 0 1 2 -3");
    let nan = SQUARE_PLY.replace("1 1 0 255", "1 nan 0 255");
    for (text, expected) in [
        ("", "a.ply: expected a PLY file, which begins with `ply`, found something else".to_string()),
        (&huge, format!("a.ply: 3000000000 rows of `face` do not fit into {} bytes", huge.len())),
        (&outside, "a.ply: mesh `ply`: triangle 1 uses vertex 7, but there are 4 vertices".into()),
        (&negative, "a.ply: face 0 uses a vertex index below zero or above 2^32".into()),
        (&SQUARE_PLY.replace("1 1 0 255", "1 x 0 255"), "a.ply: expected rows of `vertex`, found an error: ".into()),
        (&nan, "a.ply: mesh `ply`: expected finite positions, found [1.0, -0.0, NaN] at vertex 2".into()),
    ] {
        let error = refusal("a.ply", text.as_bytes());
        // What follows a colon at the end are the words of the library.
        assert!(error == expected || (expected.ends_with(": ") && error.starts_with(&expected)), "{text:?}: {error}");
    }
    let whole = binary_ply(false);
    for length in (0..whole.len()).step_by(3) {
        let error = refusal("a.ply", &whole[..length]);
        assert!(error.starts_with("a.ply: ") && !error.contains('\n'), "{length} bytes: {error}");
    }
    assert_eq!(refusal("a.stl", b""), "a.stl: expected a file named .glb, .gltf, .vrm, .obj or .ply", "another format");
}

#[test]
fn the_real_bunny_is_read_vertex_for_vertex() {
    let bunny = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/bunny.obj");
    let (scene, report) = read_scene(&bunny, &SceneReadOptions::default()).unwrap();
    let found = (report.vertices, report.triangles, report.dropped_triangles, report.made_normals);
    assert_eq!(found, (1839, 3674, 0, 1839), "vertices, triangles, dropped, made normals");
    assert_eq!(scene.meshes().len(), 1, "one mesh");
}

fn area(scene: &Scene) -> f64 {
    scene
        .meshes()
        .iter()
        .flat_map(|mesh| (0..mesh.triangles().len()).map(|t| mesh.corners(t)))
        .map(|[a, b, c]| {
            let [u, v] = [b, c].map(|p| [0, 1, 2].map(|k| f64::from(p[k]) - f64::from(a[k])));
            let cross = [0, 1, 2].map(|k| u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3]);
            0.5 * cross.iter().map(|c| c * c).sum::<f64>().sqrt()
        })
        .sum()
}

#[test]
fn a_face_of_too_many_corners_is_a_fan_with_a_note() {
    // A star: every second corner is nearer to the middle.
    let star = |corners: usize| {
        let mut obj = String::new();
        for k in 0..corners {
            let (angle, radius) = (std::f64::consts::TAU * k as f64 / corners as f64, 1.0 - 0.5 * (k % 2) as f64);
            obj += &format!("v {} {} 0\n", radius * angle.cos(), radius * angle.sin());
        }
        let face: Vec<String> = (1..=corners).map(|k| k.to_string()).collect();
        obj + "f " + &face.join(" ") + "\n"
    };
    let (_, report) = read("a.obj", &star(10_000)).unwrap();
    assert!(report.notes.is_empty(), "{:?}", report.notes);
    let (_, report) = read("a.obj", &star(10_002)).unwrap();
    let expected = "faces of more than 10000 corners: 1, whose dents are filled; divide them into smaller ones";
    assert!(report.notes.iter().any(|note| note == expected), "{:?}", report.notes);
}

#[test]
fn dented_polygons_keep_their_dent() {
    let obj = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0.5 0.2 0\nv 0 1 0\nf 1 2 3 4 5\n";
    let ply = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n\
               element face 1\nproperty list uchar int vertex_indices\nend_header\n\
               0 0 0\n1 0 0\n1 1 0\n0.5 0.2 0\n0 1 0\n5 0 1 2 3 4\n";
    for (name, text) in [("a.obj", obj), ("a.ply", ply)] {
        let found = area(&read(name, text).unwrap().0);
        assert!((found - 0.6).abs() < 1e-6, "{name}: an area of {found}, expected 0.6");
    }
}

#[test]
fn faces_of_a_ply_may_come_before_its_vertices() {
    let (head, body) = SQUARE_PLY.split_once("end_header\n").unwrap();
    let (vertices, faces) = head.split_once("element face").unwrap();
    let (start, vertices) = vertices.split_once("element vertex").unwrap();
    let (rows, face) = body.split_at(body.find("4 0 1 2 3").unwrap());
    let turned = format!("{start}element face{faces}element vertex{vertices}end_header\n{face}{rows}");
    let [a, b] = [SQUARE_PLY, &turned].map(|text| read("a.ply", text).unwrap().0.meshes().to_vec());
    assert_eq!(a, b, "either order");
}

#[test]
fn an_obj_in_latin_1_with_continued_lines_and_a_nameless_material_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.obj");
    fs::write(folder.path().join("a.mtl"), b"# caf\xE9\nnewmtl\nKd 0.25 \\\n0.5 1\nnewmtl stra\xDFe\nKd 0.75\n")
        .unwrap();
    let obj = b"# \xE4 c:\\\nmtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 \\\r\n 0\nusemtl\nf 1 \\\n2 3 # a comment\n\
                usemtl stra\xDFe\nf 3 2 1\n";
    fs::write(&path, obj).unwrap();
    let (scene, report) = read_scene(&path, &SceneReadOptions::default()).unwrap();
    assert_eq!(report.notes, Vec::<String>::new(), "nothing to note");
    assert_eq!(scene.vertex_base_color(0, 0), [0.25, 0.5, 1.0, 1.0], "the material without a name");
    assert_eq!(scene.vertex_base_color(1, 0), [0.75, 0.75, 0.75, 1.0], "one number for three");
}

/// A roof: two squares that share an edge.
const ROOF_OBJ: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nf 1 2 3 4\nf 2 1 5 6\n";

#[test]
fn missing_normals_of_an_obj_are_smooth_unless_asked_to_be_flat() {
    let read = |normals| {
        let options = SceneReadOptions::default().up(Up::Z).missing_normals(normals);
        read_scene_bytes(ROOF_OBJ.as_bytes(), "a.obj", &options).unwrap().0
    };
    let smooth = read(MissingNormals::AsFormat);
    assert_eq!(smooth.meshes(), read(MissingNormals::Smooth).meshes(), "OBJ does not say");
    let half = 0.5_f32.sqrt();
    assert_eq!(smooth.meshes()[0].normals()[0], [0.0, half, half], "the mean of both sides");
    let flat = read(MissingNormals::Flat);
    let mesh = &flat.meshes()[0];
    assert_eq!(mesh.positions().len(), 8, "the edge has two vertices at each end");
    for t in mesh.triangles() {
        let [a, b, c] = t.map(|i| mesh.normals()[i as usize]);
        assert!(a == b && b == c, "one normal for each triangle: {a:?} {b:?} {c:?}");
    }
}

#[test]
fn a_texture_is_shown_although_its_color_is_black_as_maya_writes_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.obj");
    fs::write(&path, "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nusemtl a\nf 1/1 2/1 3/1\n").unwrap();
    let picture = Texture::new(1, 1, vec![[255, 0, 0, 255]], [Wrap::Repeat; 2]);
    fs::write(folder.path().join("w.png"), picture.to_png()).unwrap();
    let hole = Texture::new(1, 1, vec![[255, 0, 0, 40]], [Wrap::Repeat; 2]);
    fs::write(folder.path().join("hole.png"), hole.to_png()).unwrap();
    for (mtl, expected, note) in [
        (
            "Kd 0 0 0\nmap_Kd w.png",
            [1.0, 0.0, 0.0, 1.0],
            Some("material `a`: Kd is 0, which would hide map_Kd, and taken as 1"),
        ),
        ("map_Kd w.png\nKd 0.5 0.5 0.5", [0.5, 0.0, 0.0, 1.0], None),
        ("Kd 0 0 0", [0.0, 0.0, 0.0, 1.0], None),
        (
            "map_Kd hole.png",
            [1.0, 0.0, 0.0, 40.0 / 255.0],
            Some("material `a`: the alpha of map_Kd is not used, surfaces are opaque"),
        ),
    ] {
        fs::write(folder.path().join("a.mtl"), format!("newmtl a\n{mtl}\n")).unwrap();
        let (scene, report) = read_scene(&path, &SceneReadOptions::default()).unwrap();
        assert_eq!(scene.vertex_base_color(0, 0), expected, "{mtl}");
        assert_eq!(report.notes.iter().map(String::as_str).collect::<Vec<_>>(), Vec::from_iter(note), "{mtl}");
    }
}

#[test]
fn what_a_library_says_of_light_and_is_not_used_is_named_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.obj");
    fs::write(&path, "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl a\nf 1 2 3\nl 1 2\n").unwrap();
    // What is zero, or is that of a matte surface, says nothing.
    let plain = "newmtl a\nKa 1 1 1\nKs 0 0 0\nNs 10\nNi 1.45\nillum 2\nPm 0.0\nPr 1.0\nTf 1 1 1\n";
    let shiny =
        "newmtl b\nKs 0.5 0.5 0.5\nillum 5\nPm 1\nPr 0.2\nmap_Bump -bm 1 b.png\nnewmtl c\nKs 1 1 1\nmap_Ke e.png\n";
    fs::write(folder.path().join("a.mtl"), format!("{plain}{shiny}")).unwrap();
    let (_, report) = read_scene(&path, &SceneReadOptions::default()).unwrap();
    let expected = [
        "a.mtl: not used: Ks, Pm, Pr, illum, map_Bump, map_Ke; surfaces are matte, of the color Kd and map_Kd",
        "points and lines are left out",
    ];
    assert_eq!(report.notes, expected, "notes");
}

#[test]
fn materials_without_any_library_are_noted() {
    let (_, report) = read("a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl a\nf 1 2 3\n").unwrap();
    let expected = ["materials are named, and no library that has them (mtllib): surfaces are white"];
    assert_eq!(report.notes, expected, "notes");
}

#[test]
fn colors_of_obj_vertices_keep_their_digits_and_those_of_bytes_are_divided() {
    let of = |color: &str| {
        let text = format!("v 0 0 0 {color}\nv 1 0 0 {color}\nv 1 1 0 {color}\nf 1 2 3\n");
        let (scene, report) = read("a.obj", &text).unwrap();
        (scene.meshes()[0].colors()[0], report.notes)
    };
    let decode = |c: f64| if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) };
    let close = |found: f32, expected: f64| (f64::from(found) - expected).abs() < 1e-6 * expected;
    let (fine, notes) = of("0.0123 0.5012 1.0");
    assert!(close(fine[0], decode(0.0123)) && close(fine[1], decode(0.5012)) && fine[2] == 1.0, "{fine:?}");
    assert!(notes.is_empty(), "{notes:?}");
    let (bytes, notes) = of("51 102 255");
    assert!(close(bytes[0], decode(0.2)) && close(bytes[1], decode(0.4)) && bytes[2] == 1.0, "{bytes:?}");
    assert_eq!(notes, ["colors of vertices go up to 255: they are taken as bytes, divided by 255"], "notes");
    let (above, notes) = of("0.5 1.25 -0.5");
    assert!(close(above[0], decode(0.5)) && above[1] == 1.0 && above[2] == 0.0, "{above:?}");
    assert_eq!(notes, ["colors of vertices are outside of 0 to 1, and moved there"], "notes");
}

#[test]
fn every_statement_of_an_obj_that_is_not_used_is_named_once() {
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let notes = |lines: &str| {
        let text = format!("{lines}\n{triangle}");
        read_scene_bytes(text.as_bytes(), "a.obj", &SceneReadOptions::default()).unwrap().1.notes
    };
    for (lines, expected) in [
        ("call b.obj\ncall c.obj", "call is not used: what it brings is missing"),
        ("csh -ls", "csh is not used: what it brings is missing"),
        ("maplib a.map", "maplib is not used"),
        ("shadow_obj a.obj", "shadow_obj is not used"),
        ("trace_obj a.obj", "trace_obj is not used"),
        ("V 1 2 3", "V is not used"),
        ("#MRGB ff00ff00ff", "colors of vertices in comments (#MRGB) are not used"),
    ] {
        assert_eq!(notes(lines), [expected], "{lines}");
    }
    assert_eq!(notes("lod 1\nvp 0 1\ng\n# comment"), Vec::<String>::new(), "what changes no triangle");
}
