//! Work that several machines share: whatever the number of shards, the output has the bytes of one machine.

use lobe::sh::simd::Machine;

use crate::harness::Dir;

/// A triangle over a floor of two units, with texture coordinates and normals.
const SCENE: &str = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nv -0.5 -0.5 0.5\nv 0.5 -0.5 0.5\nv 0.5 0.5 0.5\n\
    vt 0 0\nvt 0.5 0\nvt 0.5 1\nvt 0 1\nvt 0.6 0\nvt 1 0\nvt 1 1\nvn 0 0 1\nf 1/1/1 2/2/1 3/3/1 4/4/1\nf 5/5/1 6/6/1 7/7/1\n";

/// Shards that work is cut into: all of it in one, halves, and numbers that divide few others.
const COUNTS: [usize; 4] = [1, 2, 3, 7];

/// A command without its output, and the extension of that.
type Kind = (&'static str, &'static str);

/// Bakes at vertices: in each mode, as each kind of file, in colors, split, compressed, and of fewer vertices than there are shards.
const AT_VERTICES: [Kind; 10] = [
    ("bake s.obj --order 2 --samples 64 --max-edge 0.1", "glb"),
    ("bake s.obj --order 3 --samples 64 --mode unshadowed --max-vertices 400", "glb"),
    ("bake s.obj --order 3 --samples 64 --mode shadowed --seed 5 --no-split", "safetensors"),
    ("bake s.obj --order 2 --samples 64 --energy-stop 0 --albedo none --no-split", "safetensors"),
    ("bake s.obj --order 2 --samples 64 --max-edge 0.4 --clusters 3 --components 2 --weights 16", "glb"),
    ("bake s.obj --order 2 --samples 64 --mode glossy", "safetensors"),
    ("bake built-in:cornell --order 2 --samples 4 --bounces 1 --no-split", "glb"),
    ("bake built-in:cornell --order 2 --samples 4 --bounces 1 --mode glossy", "safetensors"),
    ("bake three.obj --order 2 --samples 64 --max-vertices 30", "glb"),
    ("bake three.obj --order 2 --samples 64 --mode glossy", "safetensors"),
];

/// Bakes at texels and at points in space.
const ELSEWHERE: [Kind; 8] = [
    ("bake s.obj --order 2 --samples 64 --texels 16", "exr"),
    ("bake s.obj --order 2 --samples 64 --texels 16 --mode shadowed", "safetensors"),
    ("bake built-in:cornell --order 2 --samples 4 --bounces 1 --texels 8 --albedo none", "safetensors"),
    ("bake s.obj --order 2 --samples 64 --grid 3,3,3", "safetensors"),
    ("bake built-in:cornell --order 2 --samples 16 --bounces 1 --grid 2,2,2 --grid-box -1,-1,0,1,1,1", "safetensors"),
    ("field s.obj --order 2 --rays 64 --spheres 4 --cells 4", "safetensors"),
    ("field s.obj --order 2 --rays 64 --spheres 4 --cells 4 --range 0.5,3 --seed 2 --storage u8", "safetensors"),
    ("field s.obj --order 2 --rays 64 --spheres 4 --cells 4 --storage clustered", "safetensors"),
];

/// Path-traced pictures: under a map, under its expansion, with the materials of glTF, of a scene that moves, and of fewer pixels than shards.
const PICTURES: [Kind; 5] = [
    ("render trace s.obj --env bundled:sunset --size 16x12 --samples 4", "exr"),
    ("render trace s.obj --env bundled:sunset --order 3 --size 7x5 --samples 4 --seed 3", "exr"),
    ("render trace built-in:cornell --env bundled:studio --surfaces gltf --size 8x6 --samples 4 --exposure 0", "png"),
    ("render trace built-in:three-objects --time 1 --env bundled:sunset --size 8x6 --samples 4", "exr"),
    ("render trace s.obj --env bundled:sunset --size 2x1 --samples 4", "exr"),
];

/// A folder with the scenes of the commands above.
fn scenes() -> Dir {
    let dir = Dir::new();
    dir.file("s.obj", SCENE);
    dir.file("three.obj", "v 0 0 0\nv 1 0 0\nv 0 0 -1\nf 1 2 3\n");
    dir
}

/// Makes the shards of a command, and returns their names.
fn shards(dir: &Dir, command: &str, count: usize) -> Vec<String> {
    let part = |number: usize| {
        let name = format!("part-{number}-of-{count}.safetensors");
        dir.lobe(&format!("{command} --shard {number}/{count} -o {name}")).succeeds();
        name
    };
    (1..=count).map(part).collect()
}

/// Whether the merge of shards in this order has the bytes of one machine, which `one` holds.
fn merges_to(dir: &Dir, (command, extension): Kind, parts: &[String], one: &[u8]) -> bool {
    dir.lobe(&format!("{command} --merge {} -o merged.{extension}", parts.join(" "))).succeeds();
    dir.bytes(&format!("merged.{extension}")) == one
}

/// What one machine writes alone.
fn alone(dir: &Dir, (command, extension): Kind) -> Vec<u8> {
    dir.lobe(&format!("{command} -o one.{extension}")).succeeds();
    dir.bytes(&format!("one.{extension}"))
}

/// Cuts each kind of work into each number of shards, which come in an order that is neither theirs nor the reverse.
fn all_numbers_of_shards_make_the_bytes_of_one_machine(kinds: &[Kind]) {
    for &kind in kinds {
        let dir = scenes();
        let one = alone(&dir, kind);
        for count in COUNTS {
            let mut parts = shards(&dir, kind.0, count);
            assert!(!dir.names().iter().any(|name| name.contains(".split-")), "what splitting kept: {:?}", dir.names());
            parts.reverse();
            parts.rotate_left(count / 2);
            assert!(merges_to(&dir, kind, &parts, &one), "{}: {count} shards", kind.0);
        }
        let left: Vec<String> = dir.names().into_iter().filter(|name| name.contains("checkpoint")).collect();
        assert_eq!(left, Vec::<String>::new(), "{}", kind.0);
    }
}

#[test]
#[ignore = "long: of the nightly group"]
fn shards_of_bakes_at_vertices_make_the_bytes_of_one_machine() {
    all_numbers_of_shards_make_the_bytes_of_one_machine(&AT_VERTICES);
}

#[test]
#[ignore = "long: of the nightly group"]
fn shards_of_bakes_at_texels_and_points_in_space_make_the_bytes_of_one_machine() {
    all_numbers_of_shards_make_the_bytes_of_one_machine(&ELSEWHERE);
}

#[test]
#[ignore = "long: of the nightly group"]
fn shards_of_path_traced_pictures_make_the_bytes_of_one_machine() {
    all_numbers_of_shards_make_the_bytes_of_one_machine(&PICTURES);
}

/// Each command once; every kind of bake and every number of shards are the library's, and at night those above.
#[test]
fn shards_of_each_command_are_merged_in_any_order() {
    for kind in [AT_VERTICES[4], ELSEWHERE[5], PICTURES[0]] {
        let dir = scenes();
        let one = alone(&dir, kind);
        let parts = shards(&dir, kind.0, 3);
        for order in [[0, 1, 2], [1, 2, 0], [2, 1, 0]] {
            let parts = order.map(|part| parts[part].clone());
            assert!(merges_to(&dir, kind, &parts, &one), "{}: {order:?}", kind.0);
        }
    }
}

#[test]
fn shards_of_machines_that_round_otherwise_are_not_mixed() {
    if Machine::detect().is_plain() {
        lobe_testkit::skipped("this machine fuses no products and sums");
        return;
    }
    let dir = scenes();
    for command in [
        "bake s.obj --no-split --order 3 --samples 64 --mode shadowed",
        "field s.obj --order 2 --rays 64 --spheres 4 --cells 4",
    ] {
        shards(&dir, command, 2);
        dir.lobe(&format!("{command} --shard 2/2 -o plain.safetensors")).env("LOBE_SIMD", "plain").succeeds();
        let merge = format!("{command} --quiet --merge part-1-of-2.safetensors plain.safetensors -o m.safetensors");
        let error = dir.lobe(&merge).error();
        assert!(error.contains("is a shard of other work: ") && error.contains("the kind of machine"), "{error}");
        // Those of one kind go together on a machine of that kind.
        dir.lobe(&format!("{command} --shard 1/2 -o first.safetensors")).env("LOBE_SIMD", "plain").succeeds();
        let merge = format!("{command} --merge first.safetensors plain.safetensors -o m.safetensors");
        let (_, notes) = dir.lobe(&merge).env("LOBE_SIMD", "plain").succeeds();
        assert!(!notes.contains("found; going on"), "what the command itself has put together is no news: {notes}");
        dir.lobe(&format!("{command} -o whole.safetensors")).env("LOBE_SIMD", "plain").succeeds();
        assert!(dir.bytes("m.safetensors") == dir.bytes("whole.safetensors"), "{command}: the same bytes");
        for name in ["plain", "first", "m", "whole", "part-1-of-2", "part-2-of-2"] {
            std::fs::remove_file(dir.path(&format!("{name}.safetensors"))).unwrap();
        }
    }
}

/// The first shard of each command by AVX2, the second by the widest instructions, merged by these: the bytes of one machine.
fn machines_of_both_widths_are_mixed(kinds: &[Kind]) {
    if Machine::available().all(|machine| machine.name() != "avx512") {
        lobe_testkit::skipped("this machine has no AVX-512");
        return;
    }
    for &(command, extension) in kinds {
        let dir = scenes();
        let narrow = |rest: &str| dir.lobe(&format!("{command} {rest}")).env("LOBE_SIMD", "avx2").succeeds();
        narrow("--shard 1/2 -o narrow.safetensors");
        dir.lobe(&format!("{command} --shard 2/2 -o wide.safetensors")).succeeds();
        dir.lobe(&format!("{command} --merge narrow.safetensors wide.safetensors -o merged.{extension}")).succeeds();
        narrow(&format!("-o narrow.{extension}"));
        let one = alone(&dir, (command, extension));
        assert!(dir.bytes(&format!("merged.{extension}")) == one, "{command}: merged");
        assert!(dir.bytes(&format!("narrow.{extension}")) == one, "{command}: all by AVX2");
    }
}

#[test]
fn shards_of_machines_with_wide_and_narrow_registers_make_the_bytes_of_one() {
    machines_of_both_widths_are_mixed(&AT_VERTICES);
    machines_of_both_widths_are_mixed(&ELSEWHERE);
    machines_of_both_widths_are_mixed(&PICTURES);
}

#[test]
fn machines_with_wide_and_narrow_registers_write_the_same_bytes() {
    if Machine::available().all(|machine| machine.name() != "avx512") {
        lobe_testkit::skipped("this machine has no AVX-512");
        return;
    }
    let dir = scenes();
    // Widths that are and are not a multiple of four, low orders and high ones.
    for (width, height) in [(64, 32), (30, 15), (134, 67)] {
        dir.map(&format!("{width}.pfm"), width, height, |x, y| [(x * 7 % 13) as f32, (y * x % 11) as f32, y as f32]);
    }
    dir.lobe("env convert 134.pfm --to cube --size 21 -o cube.pfm").succeeds();
    dir.lobe("env convert 134.pfm --to octahedral --size 37 -o oct.pfm").succeeds();
    let commands = [
        "project 64.pfm --order 5 -o OUT.sh.json",
        "project 30.pfm --order 4 -o OUT.sh.json",
        "project 134.pfm --order 16 -o OUT.sh.json",
        "project 64.pfm --order 30 -o OUT.sh.json",
        "project 134.pfm --order 90 -o OUT.sh.json",
        "project cube.pfm --from cube --order 6 -o OUT.sh.json",
        "project oct.pfm --from octahedral --order 20 -o OUT.sh.json",
        "env irradiance 30.pfm --size 16 -o OUT.pfm",
        "env prefilter 64.pfm --size 16 -o OUT.ktx2",
        "env rotate 134.pfm --axis 1,2,3 --angle 30 -o OUT.pfm",
        "env reconstruct low.sh.json --size 17 -o OUT.pfm",
        "env reconstruct high.sh.json --size 33 -o OUT.pfm",
        "sh product high.sh.json high.sh.json --order 90 --quantity function -o OUT.sh.json",
        "sh product low.sh.json low.sh.json --quantity function -o OUT.sh.json",
        "sh rotate high.sh.json --axis 1,2,3 --angle 40 -o OUT.sh.json",
        "sh dering low.sh.json -o OUT.sh.json",
        "sh log seen.sh.json -o OUT.sh.json",
        "sh convolve high.sh.json --kernel cosine -o OUT.sh.json",
    ];
    dir.lobe("project 134.pfm --order 5 -o low.sh.json").succeeds();
    dir.lobe("project 134.pfm --order 90 -o high.sh.json").succeeds();
    dir.lobe("project 30.pfm --order 6 --quantity visibility -o seen.sh.json").succeeds();
    for command in commands {
        let run = |name: &str, instructions: &str| {
            let command = command.replace("OUT", name);
            dir.lobe(&command).env("LOBE_SIMD", instructions).succeeds();
            dir.bytes(command.rsplit(' ').next().unwrap())
        };
        assert!(run("narrow", "avx2") == run("wide", "avx512"), "{command}");
    }
}

#[test]
fn shards_that_are_not_all_of_one_command_are_refused_by_name() {
    let dir = scenes();
    let command = AT_VERTICES[0].0;
    shards(&dir, command, 3);
    dir.lobe(&format!("{command} --seed 7 --shard 2/3 -o other.safetensors")).succeeds();
    dir.file("none.safetensors", "no shard");
    let bytes = dir.bytes("part-2-of-3.safetensors");
    dir.file("short.safetensors", &bytes[..bytes.len() - 9]);
    // What a bake that was stopped has kept is not in the way, and stays.
    dir.file("m.glb.checkpoint", "hours of rays");
    let before = dir.names();
    let [a, b, c] = [1, 2, 3].map(|number| format!("part-{number}-of-3.safetensors"));
    let refusal = |options: &str, parts: &[&str]| {
        dir.lobe(&format!("{command} {options} --quiet --merge {} -o m.glb", parts.join(" "))).error()
    };
    for (parts, expected) in [
        (vec![a.as_str(), &c], "--merge: expected 3 shards, found 2; missing: 2/3"),
        (
            vec![&a, &b, &b, &c],
            "part-2-of-3.safetensors: is shard 2/3, and so is part-2-of-3.safetensors; leave one of them out",
        ),
        (vec![&a, "other.safetensors", &c], "other.safetensors: is a shard of other work"),
        (vec![&a, "none.safetensors", &c], "none.safetensors: expected a shard, as this version of Lobe leaves it"),
        (vec![&a, "short.safetensors", &c], "short.safetensors: shard 2/3 is not complete"),
        (vec![&a, "nowhere.safetensors", &c], "nowhere.safetensors: "),
    ] {
        let error = refusal("", &parts);
        assert!(error.contains(expected), "{parts:?}: {error}");
        assert_eq!(dir.names(), before, "{parts:?}");
    }
    // All of them, but of another command.
    let error = refusal("--seed 1", &[&a, &b, &c]);
    assert!(error.contains("part-1-of-3.safetensors: this shard and the others are not of this work"), "{error}");
    assert_eq!(dir.names(), before, "nothing is left of another command");
    for (options, expected) in [
        ("--shard 4/3 -o x.safetensors", "expected a part I/N, such as 1/4"),
        ("--shard 1/3 -o x.glb", "expected a name that ends in .safetensors"),
        ("--shard 1/3 -o s.obj.safetensors --merge part-1-of-3.safetensors", "--merge: not with --shard"),
    ] {
        let error = dir.lobe(&format!("{command} {options}")).error();
        assert!(error.contains(expected), "{options}: {error}");
    }
    let render = "render trace s.obj --env bundled:sunset --size 4x4 --shard 1/2 --frames 2 -o x.safetensors";
    let error = dir.lobe(render).error();
    assert!(error.contains("--shard and --merge: only of a single picture"), "{error}");
    assert_eq!(dir.names(), before, "nothing is written");
}

#[test]
fn a_shard_goes_on_where_it_was_cut_off_and_tells_what_it_has() {
    let dir = scenes();
    let command = format!("{} --shard 2/2 -o part.safetensors", AT_VERTICES[0].0);
    let (_, notes) = dir.lobe(&command).succeeds();
    assert!(notes.contains("part.safetensors: shard 2/2: "), "{notes}");
    let whole = dir.bytes("part.safetensors");
    dir.file("part.safetensors", &whole[..whole.len() / 2]);
    let json = dir.lobe(&format!("{command} --json --quiet")).stdout();
    assert!(json.contains(r#""shard":"2/2""#) && json.contains(r#""points_in_all":"#), "{json}");
    assert!(dir.bytes("part.safetensors") == whole, "the same bytes");
    // It is a file of safetensors that says what it is.
    let length = u64::from_le_bytes(*whole.first_chunk().unwrap()) as usize;
    let header: serde_json::Value = serde_json::from_slice(&whole[8..8 + length]).unwrap();
    assert_eq!(header["__metadata__"]["shard"], "2/2", "{header}");
    assert_eq!(header["records"]["data_offsets"][1], whole.len() - 8 - length, "{header}");
}
