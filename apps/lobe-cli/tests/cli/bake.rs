//! `lobe bake`: its outputs, and refusals in one line before any work.

use lobe::prt::{BakeMode, read_compressed_transfer, read_matrices, read_neighborhood, read_transfer};
use lobe::scene::{Mesh, SceneReadOptions, built_in, read_scene};
use serde_json::{Value, json};

use crate::harness::Dir;

/// A square of two triangles in `scene.gltf`, its numbers in `scene.bin`.
fn square() -> Value {
    json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"name": "square", "primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 12},
        ],
        "buffers": [{"byteLength": 60, "uri": "scene.bin"}],
    })
}

fn square_bin(first: f32) -> Vec<u8> {
    let positions = [first, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0];
    let indices: [u16; 6] = [0, 1, 2, 0, 2, 3];
    let positions = positions.iter().flat_map(|c: &f32| c.to_le_bytes());
    positions.chain(indices.iter().flat_map(|i| i.to_le_bytes())).collect()
}

/// A folder with the square.
fn with_square(change: impl FnOnce(&mut Value)) -> Dir {
    let dir = Dir::new();
    let mut json = square();
    change(&mut json);
    dir.file("scene.gltf", json.to_string());
    dir.file("scene.bin", square_bin(0.0));
    dir
}

/// The refusal of a file, which names the file and leaves nothing behind.
fn refusal(dir: &Dir, name: &str) -> String {
    let before = dir.names();
    let line = dir.lobe(&format!("bake {name} -o out.glb --quiet")).error();
    assert_eq!(dir.names(), before, "files after {line}");
    line.strip_prefix(&format!("{name}: ")).unwrap_or_else(|| panic!("the file is not named: {line}")).to_owned()
}

fn refusal_of_square(change: impl FnOnce(&mut Value)) -> String {
    refusal(&with_square(change), "scene.gltf")
}

#[test]
fn a_file_comes_back_vertex_for_vertex_with_transfer() {
    let dir = with_square(|json| json["nodes"][0]["extras"] = json!({"kept": true}));
    let printed = dir.lobe("bake scene.gltf -o out.glb --order 3 --samples 64 --mode shadowed --json --quiet").stdout();
    let printed: Value = serde_json::from_str(&printed).unwrap();
    assert_eq!((&printed["vertices"], &printed["triangles"]), (&json!(4), &json!(2)), "{printed}");
    assert_eq!(printed["rays"], 4 * 64, "{printed}");
    assert!(printed["seconds"].is_f64() && printed["stderr_dc"].is_f64(), "{printed}");
    assert_eq!(dir.names(), ["out.glb", "scene.bin", "scene.gltf"], "no checkpoint is left");
    let baked = dir.baked("out.glb");
    let (scene, _) = read_scene(dir.path("scene.gltf"), &SceneReadOptions::default()).unwrap();
    assert_eq!(baked.scene.meshes(), scene.meshes(), "meshes");
    assert_eq!((baked.transfer.order(), baked.transfer.receivers()), (3, 4), "transfer");
    assert_eq!((&baked.recipe.mode, baked.recipe.samples), (&Some(BakeMode::Shadowed), Some(64)), "{:?}", baked.recipe);
    // Nothing in the way: all of the light, T_0 = y_0 for a white surface.
    let t = baked.transfer.vector(0, 0)[0];
    assert!((t - 0.28209479).abs() < 1e-5, "{t}");
}

#[test]
fn the_same_command_gives_the_same_bytes() {
    let dir = with_square(|_| ());
    for (name, threads) in [("a", 1), ("b", 3)] {
        dir.lobe(&format!("bake scene.gltf -o {name}.glb --samples 32 --seed 5 --quiet --threads {threads}")).stdout();
    }
    assert!(dir.bytes("a.glb") == dir.bytes("b.glb"), "one thread and three");
    dir.lobe("bake scene.gltf -o c.glb --samples 32 --seed 6 --quiet").stdout();
    assert!(dir.bytes("a.glb") != dir.bytes("c.glb"), "another seed");
}

#[test]
fn built_in_scenes_and_split_ones_are_written_as_they_were_baked() {
    let dir = Dir::new();
    dir.lobe("bake built-in:furnace -o out.glb --samples 16 --order 2 --mode shadowed --quiet").stdout();
    let baked = dir.baked("out.glb");
    let scene = built_in::named("furnace").unwrap();
    assert_eq!(baked.transfer.receivers(), scene.vertex_count(), "vertices");
    let all = baked.transfer.coefficients().iter().fold(0.0, |sum: f32, c| sum.max(c.abs()));
    assert_eq!(all, 0.0, "no light comes into a closed box");

    let (_, notes) =
        dir.lobe("bake built-in:furnace -o out.safetensors --samples 4 --order 2 --max-edge 0.1").succeeds();
    let (transfer, recipe) = read_transfer(dir.path("out.safetensors")).unwrap();
    let split = scene.split_edges(0.1).unwrap();
    assert_eq!(transfer.receivers(), split.vertex_count(), "vertices of the split scene");
    assert_eq!(recipe.max_edge, Some(0.1), "{recipe:?}");
    let note = format!(
        "note: out.safetensors: transfer of {} vertices after splitting; only a .glb holds the split mesh\n",
        split.vertex_count()
    );
    assert!(notes.contains(&note), "{notes}");
    let render = "render built-in:furnace --transfer out.safetensors --env bundled:studio --mode interreflected";
    let line = dir.lobe(&format!("{render} --quiet -o x.png")).error();
    assert!(line.contains("baked with --max-edge or --adaptive it belongs to the split mesh"), "{line}");
}

#[test]
fn which_axis_is_up_is_asked_for_obj_and_ply_only() {
    let dir = Dir::new();
    dir.file("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    for (up, band) in [("y", 1), ("z", 2)] {
        dir.lobe(&format!("bake t.obj -o out.glb --mode unshadowed --order 2 --quiet --up {up}")).stdout();
        let baked = dir.baked("out.glb");
        let t = baked.transfer.vector(0, 0).to_vec();
        // The triangle faces +z of the file: -y of the world, or its +z. Y_1 = c (-y, z, -x).
        assert!(t[band] > 0.1, "{up} up: {t:?}");
    }
    let line = with_square(|_| ()).lobe("bake scene.gltf -o out.glb --up z").error();
    assert_eq!(line, "--up: only .obj or .ply files leave open which axis points up; leave the option out", "glTF");
}

#[test]
fn edges_are_split_where_transfer_changes() {
    let dir = Dir::new();
    // A wall on a wide ground: its foot is dark.
    let ground = "v -8 0 -8\nv 8 0 -8\nv 8 0 8\nv -8 0 8\nf 1 4 3 2\n";
    let wall = "v 0 0 -1\nv 0 0 1\nv 0 2 1\nv 0 2 -1\nf 5 6 7 8\n";
    dir.file("wall.obj", format!("{ground}{wall}"));
    let bake = "bake wall.obj -o out.glb --order 2 --samples 16 --mode shadowed --quiet --max-edge 2";
    dir.lobe(bake).stdout();
    let even = dir.baked("out.glb").scene;
    dir.lobe(&format!("{bake} --adaptive 0.02 --min-edge 0.3")).stdout();
    let fine = dir.baked("out.glb").scene;
    let near = |scene: &lobe::scene::Scene, inside: bool| {
        let positions = scene.meshes().iter().flat_map(Mesh::positions);
        positions.filter(|p| (p[0].abs().max(p[1].abs()) < 3.0) == inside).count()
    };
    let (gained, elsewhere) = (near(&fine, true) - near(&even, true), near(&fine, false) - near(&even, false));
    assert!(gained > 20 && elsewhere * 4 < gained, "{gained} new vertices near the wall, {elsewhere} elsewhere");
}

#[test]
fn matrices_lightmaps_grids_and_compressed_transfer_are_written() {
    let dir = with_square(|_| ());
    let bake = |args: &str| dir.lobe(&format!("bake {args} --samples 8 --order 2 --quiet")).stdout();
    bake("scene.gltf -o m.safetensors --mode glossy --bounces 0");
    assert_eq!(read_matrices(dir.path("m.safetensors")).unwrap().0.points(), 4, "matrices");
    let line = dir.lobe("bake scene.gltf -o g.safetensors --grid 2,3,4 --quiet").error();
    assert!(line.starts_with("--grid: expected a box with a volume, "), "{line}");
    bake("built-in:ball -o g.safetensors --grid 2,3,4 --mode shadowed");
    assert_eq!(read_neighborhood(dir.path("g.safetensors")).unwrap().0.grid().counts(), [2, 3, 4], "grid");
    bake("built-in:furnace -o c.glb --max-edge 0.2 --mode unshadowed --clusters 3 --components 2 --weights 8");
    let compressed = dir.baked("c.glb").compressed.unwrap();
    assert_eq!((compressed.table().components(), compressed.order()), (2, 2), "compressed");
    bake("scene.gltf -o c.safetensors --clusters 2");
    let recipe = read_compressed_transfer(dir.path("c.safetensors")).unwrap().1;
    assert_eq!((recipe.samples, recipe.clusters), (Some(8), Some(2)), "{recipe:?}");
    assert!(recipe.scene_hash.is_some() && recipe.relative_error.is_some(), "{recipe:?}");
    dir.file("t.obj", "v 0 0 0\nv 1 0 0\nv 0 0 -1\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n");
    bake("t.obj -o t.safetensors --texels 8");
    assert_eq!(read_transfer(dir.path("t.safetensors")).unwrap().0.receivers(), 64, "a lightmap, dilated");
    let line = dir.lobe("bake scene.gltf -o t.safetensors --texels 8 --unwrap never --quiet").error();
    assert!(line.contains("it has no texture coordinates for a lightmap"), "{line}");
}

#[test]
fn the_light_at_a_point_of_a_grid_is_that_of_the_library_and_can_be_drawn() {
    use lobe::sh::Expansion as _;
    use lobe::sh::expansion::Quantity;
    use lobe::sh::sh_json::FileCoefficients;
    let dir = Dir::new();
    dir.lobe("bake built-in:ball --grid 2,3,4 --mode shadowed --order 2 --samples 256 --quiet -o g.safetensors")
        .stdout();
    dir.lobe("light gradient --zenith 1,2,4 --horizon 1,1,1 --ground 0.2,0.1,0 --order 3 -o sky.sh.json").succeeds();
    let command = "sh incident g.safetensors --light sky.sh.json --at 0.1,-0.2,0.3 -o there.sh.json";
    let (_, note) = dir.lobe(command).succeeds();
    assert!(note.starts_with("note: sky.sh.json: the bands of the light from 2 on are left out"), "{note}");
    let sky = dir.read_sh("sky.sh.json").coefficients.to_rgb();
    let (grid, _) = read_neighborhood(dir.path("g.safetensors")).unwrap();
    let expected = grid.incident([0.1, -0.2, 0.3], &sky.coefficients()[..4]);
    let found = dir.read_sh("there.sh.json");
    assert_eq!(found.quantity, Quantity::Radiance, "quantity");
    assert_eq!(found.coefficients, FileCoefficients::Rgb(expected), "coefficients");
    dir.lobe("sh plot there.sh.json -o there.png").succeeds();
    let error = dir.lobe("sh incident sky.sh.json --light sky.sh.json --at 0,0,0 -o x.sh.json").error();
    assert!(error.starts_with("sky.sh.json: expected safetensors"), "{error}");
    let error = dir.lobe(&format!("{command} --max-memory 1e-6")).error();
    assert!(error.contains("g.safetensors takes up to ") && error.contains("a grid of fewer points"), "{error}");
}

#[test]
fn points_of_a_grid_are_off_the_floor_or_where_they_are_asked_for() {
    let dir = Dir::new();
    let bake = "bake built-in:ball --grid 3,3,4 --mode shadowed --order 1 --samples 256 --quiet -o";
    dir.lobe(&format!("{bake} a.safetensors")).stdout();
    let (found, recipe) = read_neighborhood(dir.path("a.safetensors")).unwrap();
    for (point, place) in found.grid().points([0.0; 3]).into_iter().enumerate() {
        // The ground takes the lower half of what arrives, but for what passes its ends.
        let open = found.matrices().matrix(point, 0)[0];
        assert!(open < 0.85, "{open} of the sky arrives at {place:?}");
    }
    assert_eq!(recipe.grid, Some([3, 3, 4]), "{recipe:?}");
    dir.lobe(&format!("{bake} b.safetensors --grid-box 1,1,9,-1,-1,5")).stdout();
    let corners = read_neighborhood(dir.path("b.safetensors")).unwrap().0.grid().corners();
    assert_eq!(corners, [[-1.0, -1.0, 5.0], [1.0, 1.0, 9.0]], "the box asked for");
}

#[test]
fn a_scene_far_from_its_origin_has_the_transfer_of_one_that_is_near() {
    let dir = Dir::new();
    // A wall on a square about the place.
    let wall = |[x, y, z]: [f32; 3]| {
        let corners =
            [[-1, -1, -1], [-1, -1, 1], [1, -1, 1], [1, -1, -1], [0, -1, -1], [0, -1, 1], [0, 1, 1], [0, 1, -1]];
        let vertices = corners.map(|c: [i8; 3]| {
            let [a, b, c] = c.map(f32::from);
            format!("v {} {} {}\n", x + a, y + b, z + c)
        });
        vertices.concat() + "f 1 2 3 4\nf 5 6 7 8\n"
    };
    dir.file("near.obj", wall([0.0; 3]));
    dir.file("far.obj", wall([1e5, -7e5, 65536.0]));
    for options in ["", "--adaptive 0.05 --min-edge 0.25", "--mode glossy", "--grid 2,2,2"] {
        let [near, far] = ["near", "far"].map(|name| {
            let bake = format!("bake {name}.obj -o {name}.safetensors --order 3 --samples 256 {options}");
            let (_, said) = dir.lobe(&bake).succeeds();
            assert!(!said.contains("far from its origin"), "{said}");
            let bytes = dir.bytes(&format!("{name}.safetensors"));
            // Compare the data behind the header: the header has the name of the scene.
            let length = u64::from_le_bytes(bytes[..8].try_into().unwrap()) as usize;
            bytes[8 + length..].to_vec()
        });
        assert!(near == far && near.iter().any(|&b| b != 0), "{options}: {} and {} bytes", near.len(), far.len());
    }
}

#[test]
fn options_that_would_be_ignored_or_cannot_be_are_refused() {
    let dir = with_square(|_| ());
    for (args, expected) in [
        ("--mode shadowed --bounces 2", "--bounces: only of --mode interreflected and glossy"),
        ("--mode shadowed --energy-stop 0", "--energy-stop: only of --mode interreflected and glossy"),
        ("--mode glossy", "-o: --mode glossy and --grid are written as .safetensors"),
        ("--texels 4 --max-edge 1", "--max-edge: light is not at vertices with --texels and --grid"),
        ("--min-edge 1 --no-split", "--min-edge: not with --no-split, by which nothing is split"),
        ("--mode glossy --clusters 2", "--clusters: of transfer vectors only, not of matrices"),
    ] {
        assert_eq!(dir.lobe(&format!("bake scene.gltf -o out.glb {args}")).error(), expected, "{args}");
    }
    for (args, part) in [
        ("--order 9", "expected an order (number of bands) from 1 to 8"),
        ("--samples 0", "expected a number of paths from 1 to 16777216"),
        ("--max-edge 0", "expected a number above 0, found 0"),
        ("--max-edge nan", "expected a number above 0, found nan"),
        ("--mode glow", "possible values"),
    ] {
        let line = dir.lobe(&format!("bake scene.gltf -o out.glb {args}")).error();
        assert!(line.contains(part) && line.ends_with("; see lobe bake --help"), "{args}: {line}");
    }
    let line = dir.lobe("bake scene.gltf -o out.glb --max-edge 1e-6 --quiet").error();
    assert!(line.contains("would take more than 67108864 triangles"), "{line}");
    assert_eq!(dir.names(), ["scene.bin", "scene.gltf"], "nothing is written");
}

#[test]
fn outputs_that_cannot_be_are_refused_before_the_bake() {
    let dir = with_square(|_| ());
    let line = dir.lobe("bake scene.gltf -o out.gltf").error();
    assert_eq!(line, "-o: out.gltf: expected a name that ends in .glb or .safetensors", "another kind");
    // The scene does not exist: what is wrong with the output is found first.
    let line = dir.lobe("bake none.glb -o none/out.glb").error();
    assert!(line.starts_with("none/out.glb: the folder none does not exist"), "{line}");
    assert_eq!(dir.names(), ["scene.bin", "scene.gltf"], "nothing is written");
}

#[test]
fn the_most_triangles_are_what_the_option_says() {
    let dir = with_square(|_| ());
    for command in ["bake scene.gltf -o out.glb", "render trace scene.gltf --env bundled:studio --quiet -o out.png"] {
        let line = dir.lobe(&format!("{command} --max-triangles 3")).error();
        let expected = "scene.gltf: expected at most 3 triangles and vertices, found 2 and 4 or more: raise it with --max-triangles";
        assert_eq!(line, expected, "{command}");
    }
    dir.lobe("bake scene.gltf -o out.glb --max-triangles 4 --samples 4 --quiet").stdout();
    let advice = "make the scene smaller, or raise the limit with --max-memory";
    let line = dir.lobe("bake scene.gltf -o out.glb --max-memory 0.0000001").error();
    let expected = format!("scene.gltf: expected a file of at most 107 bytes, found 490: {advice}");
    assert_eq!(line, expected, "memory of the file");
    let line = dir.lobe("bake scene.gltf -o out.glb --max-memory 0.0000006").error();
    let expected = "scene.gltf: expected a scene of at most 644 bytes, found 2 triangles, 4 vertices and 0 texels or more, each \
                    instance counted, and 550 bytes read beside them, which take 1446";
    assert_eq!(line, format!("{expected}: {advice}"), "memory of the scene");
    let line = dir.lobe("bake built-in:ball -o out.glb --max-triangles 4").error();
    assert_eq!(line, "--max-triangles: only of scenes in files; leave the option out", "built-in");
    let line = dir.lobe("bake scene.gltf -o out.glb --max-triangles 0").error();
    assert!(line.contains("expected a number of triangles from 1 to 2147483647"), "{line}");
}

#[test]
fn the_help_names_every_key_of_the_json() {
    let dir = with_square(|_| ());
    let help = dir.lobe("bake --help").stdout();
    for options in ["--clusters 2 -o c.glb", "--shard 1/2 -o c.safetensors"] {
        let printed = dir.lobe(&format!("bake scene.gltf --samples 4 --order 1 {options} --json --quiet")).stdout();
        let printed: Value = serde_json::from_str(&printed).unwrap();
        let inner = printed.get("compression").and_then(Value::as_object).into_iter().flat_map(serde_json::Map::keys);
        for key in printed.as_object().unwrap().keys().chain(inner) {
            assert!(help.contains(&format!("\"{key}\"")), "{options}: {key} is not in the help");
        }
    }
}

#[test]
fn the_help_of_compression_is_that_of_what_is_compressed() {
    let dir = Dir::new();
    let help = |command: &str| {
        let help = dir.lobe(&format!("{command} --help")).stdout();
        help.split_whitespace().collect::<Vec<_>>().join(" ")
    };
    for command in ["bake", "compress"] {
        let help = help(command);
        assert!(help.contains("--clusters <K> Compress to this many clusters at most"), "{command}: {help}");
        assert!(!help.contains("of a field"), "{command} reads no fields: {help}");
    }
    for command in ["field", "lamp"] {
        let help = help(command);
        assert!(help.contains("--clusters <K> Compress to this many clusters at most"), "{command}: {help}");
        assert!(help.contains("0 gives vector quantization [0 to 192; default: 6]"), "{command}: {help}");
    }
}

#[test]
fn scenes_that_are_missing_are_named() {
    let dir = Dir::new();
    assert_eq!(refusal(&dir, "none.glb"), "no such file; check the name and the folder", "file");
    assert!(
        refusal(&dir, "built-in:moon").starts_with("there is no such scene in the program; there are built-in:ball, ")
    );
    assert!(refusal(&dir, "built-in:moon").contains("; of lobe render also built-in:three-objects and "), "that move");
    dir.file("scene.fbx", "Kaydara");
    assert_eq!(refusal(&dir, "scene.fbx"), "expected a file named .glb, .gltf, .vrm, .obj or .ply", "another kind");
    let dir = with_square(|json| json["buffers"][0]["uri"] = json!("none.bin"));
    let line = dir.lobe("bake scene.gltf -o out.glb").error();
    assert!(line.contains("none.bin, named by scene.gltf: no such file"), "{line}");
}

#[test]
fn scenes_without_triangles_are_refused() {
    let none = "expected triangles, found none";
    for (name, text) in [("a.obj", ""), ("a.obj", "v 0 0 0\n"), ("a.ply", "ply\nformat ascii 1.0\nend_header\n")] {
        let dir = Dir::new();
        dir.file(name, text);
        assert_eq!(refusal(&dir, name), none, "{text:?}");
    }
    assert_eq!(refusal_of_square(|json| json["scenes"][0]["nodes"] = json!([])), none, "empty scene");
    assert_eq!(refusal_of_square(|json| json["meshes"][0]["primitives"][0]["mode"] = json!(1)), none, "lines");
    assert_eq!(refusal_of_square(|json| json["accessors"][1]["count"] = json!(0)), none, "no indices");
    let dir = Dir::new();
    let mut text = "v 0 0 0\nv 1 0 0\nv 2 0 0\n".to_owned();
    text += &"f 1 2 3\n".repeat(1_000_000);
    dir.file("flat.obj", text);
    assert_eq!(refusal(&dir, "flat.obj"), "expected triangles with an area, found 1000000 without", "a million");
}

#[test]
fn scenes_that_contradict_themselves_are_refused() {
    let dir = with_square(|_| ());
    dir.file("scene.bin", square_bin(f32::NAN));
    let line = refusal(&dir, "scene.gltf");
    assert!(line.contains("expected finite positions, found [NaN, "), "{line}");
    dir.file("scene.bin", &square_bin(0.0)[..59]);
    assert_eq!(refusal(&dir, "scene.gltf"), "expected 60 bytes in buffer 0, found 59", "cut off");
    for (pointer, value, part) in [
        ("/buffers/0", json!({"byteLength": 60}), "buffer 0 has neither a URI nor a chunk of a .glb"),
        ("/accessors/0/type", json!("VEC2"), "expected vectors of 3 floats as POSITION, found 2 x F32"),
        ("/accessors/1/componentType", json!(5122), "expected unsigned whole numbers as indices, found 1 x I16"),
        ("/accessors/1/count", json!(750_000_000), "750000000 elements do not fit into a buffer view of 12 bytes"),
        ("/meshes/0/primitives/0/indices", json!(7), "uses accessor 7, but there are 2"),
        ("/accessors/0/count", json!(3), "triangle 1 uses vertex 3, but there are 3 vertices"),
        ("/nodes/0", json!({"mesh": 0, "children": [0]}), "node 0 is its own ancestor or has two parents"),
        ("/nodes/0/mesh", json!(5), "node 0 shows mesh 5, but there are 1"),
        (
            "/asset/extras",
            json!({"lobe": {"version": 99}}),
            "baked by a newer Lobe: expected version 1 of its attributes",
        ),
    ] {
        let line = refusal_of_square(|json| {
            let (parent, key) = pointer.rsplit_once('/').unwrap();
            match json.pointer_mut(parent).unwrap() {
                Value::Array(items) => items[key.parse::<usize>().unwrap()] = value,
                object => object[key] = value,
            }
        });
        assert!(line.contains(part), "{pointer}: {line}");
    }
}

#[test]
fn extensions_that_are_required_and_not_read_are_named_with_what_to_do() {
    for (name, part) in [
        ("EXT_texture_avif", "convert its textures with `gltf-transform png IN OUT`"),
        ("X_unknown", "export it without"),
    ] {
        let line = refusal_of_square(|json| json["extensionsRequired"] = json!([name]));
        assert!(line.starts_with(&format!("the file requires {name}, which Lobe does not read: ")), "{line}");
        assert!(line.contains(part), "{line}");
    }
    // One that is read: the primitive points to the compressed bytes, which are none, its accessors to nothing.
    let line = refusal_of_square(|json| {
        json["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
        json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
        let compressed = json!({"bufferView": 0, "attributes": {"POSITION": 0}});
        json["meshes"][0]["primitives"][0]["extensions"] = json!({"KHR_draco_mesh_compression": compressed});
        for accessor in json["accessors"].as_array_mut().unwrap() {
            accessor.as_object_mut().unwrap().remove("bufferView");
        }
    });
    assert!(line.contains("Draco compression: expected Draco's bytes, found "), "{line}");
}

#[test]
fn glb_files_that_are_cut_off_are_refused() {
    let dir = with_square(|_| ());
    dir.lobe("bake scene.gltf -o whole.glb --samples 4 --quiet").stdout();
    let bytes = dir.bytes("whole.glb");
    for end in [0, 3, 11, 19, 100, bytes.len() / 2, bytes.len() - 5] {
        dir.file("cut.glb", &bytes[..end]);
        let line = refusal(&dir, "cut.glb");
        assert!(!line.is_empty(), "cut off after {end} bytes");
    }
}

#[test]
fn a_scene_that_is_split_keeps_what_its_file_holds_besides() {
    let camera = json!([{"name": "eye", "type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}}]);
    let material = json!([{"name": "glow", "emissiveFactor": [1, 0, 0], "extras": {"a": 1}}]);
    let dir = with_square(|json| {
        json["cameras"] = camera.clone();
        json["nodes"].as_array_mut().unwrap().push(json!({"camera": 0, "name": "tripod"}));
        json["materials"] = material.clone();
        json["meshes"][0]["primitives"][0]["material"] = json!(0);
    });
    for split in ["--max-edge 0.3", "--adaptive 0.01 --min-edge 0.2"] {
        // Without a note on what was left out.
        dir.lobe(&format!("bake scene.gltf -o split.glb --samples 4 --mode shadowed {split} --fresh -q")).stdout();
        let bytes = dir.bytes("split.glb");
        let end = 20 + u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        let found: Value = serde_json::from_slice(&bytes[20..end]).unwrap();
        assert_eq!((&found["cameras"], &found["materials"]), (&camera, &material), "{split}");
        assert_eq!(found["nodes"][1]["name"], "tripod", "{split}");
        let position = found["meshes"][0]["primitives"][0]["attributes"]["POSITION"].as_u64().unwrap() as usize;
        let vertices = found["accessors"][position]["count"].as_u64().unwrap();
        assert!(vertices > 4 || split.starts_with("--adaptive"), "{split}: {vertices} vertices");
    }
}

#[test]
fn a_job_in_a_file_and_the_recipe_of_a_bake_give_the_same_bytes() {
    let dir = with_square(|_| ());
    let options = "--mode shadowed --order 2 --samples 16 --no-split --seed 7";
    dir.lobe(&format!("bake scene.gltf -o out.glb {options} --quiet")).stdout();
    let job = dir.lobe(&format!("bake scene.gltf -o job.glb {options} --print-job")).stdout();
    assert!(job.contains("no_split = true\n") && job.contains("scene = \"scene.gltf\"\n"), "{job}");
    assert!(!dir.names().contains(&"job.glb".to_owned()), "a job that is printed is not done");
    dir.file("night.toml", &job);
    dir.lobe("bake --job night.toml --quiet").stdout();
    assert!(dir.bytes("job.glb") == dir.bytes("out.glb"), "by the job");
    dir.lobe("bake --like out.glb -o like.glb --quiet").stdout();
    assert!(dir.bytes("like.glb") == dir.bytes("out.glb"), "by the recipe");
    dir.lobe("bake --job night.toml --order 1 -o low.glb --quiet").stdout();
    assert_eq!(dir.baked("low.glb").transfer.order(), 1, "options count more");
    for (text, expected) in [
        ("order = 9\n", "bad.toml: order: expected an order (number of bands) from 1 to 8, found 9"),
        ("orders = 3\n", "bad.toml: orders: there is no such option; order is the nearest"),
        ("order = \n", "bad.toml: line 1: "),
    ] {
        dir.file("bad.toml", text);
        let line = dir.lobe("bake scene.gltf -o bad.glb --job bad.toml").error();
        assert!(line.starts_with(expected), "{text:?}: {line}");
    }
    let line = dir.lobe("bake -o out.glb").error();
    assert!(line.starts_with("SCENE: expected the scene"), "{line}");
}

#[test]
fn a_bake_like_that_of_another_scene_says_so() {
    let dir = Dir::new();
    dir.file("a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n");
    dir.lobe("bake a.obj -o a.glb --order 1 --samples 4 --quiet").stdout();
    let notes = |output: &str| dir.lobe(&format!("bake --like a.glb -o {output}")).succeeds().1;
    assert!(!notes("same.glb").contains("another scene"), "the same scene");
    dir.file("a.obj", "v 0 0 0\nv 1 0 0\nv 1 2 0\nf 1 2 3\n");
    assert!(
        notes("other.glb").contains("note: other.glb: is of another scene than a.glb, or of other vertices"),
        "changed"
    );
}
