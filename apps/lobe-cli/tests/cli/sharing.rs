//! Work that several machines share: whatever the number of shards, the output has the bytes of one machine.

use crate::harness::Dir;

/// A triangle over a floor of two units, with texture coordinates and normals.
const SCENE: &str = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nv -0.5 -0.5 0.5\nv 0.5 -0.5 0.5\nv 0.5 0.5 0.5\n\
    vt 0 0\nvt 0.5 0\nvt 0.5 1\nvt 0 1\nvt 0.6 0\nvt 1 0\nvt 1 1\nvn 0 0 1\nf 1/1/1 2/2/1 3/3/1 4/4/1\nf 5/5/1 6/6/1 7/7/1\n";

/// Every kind of work that can be shared: the command without its output, and the extension of that.
const KINDS: [(&str, &str); 6] = [
    ("bake s.obj --order 2 --samples 64 --max-edge 0.1", "glb"),
    ("bake s.obj --order 2 --samples 64 --mode glossy", "safetensors"),
    ("bake s.obj --order 2 --samples 64 --texels 16", "exr"),
    ("bake s.obj --order 2 --samples 64 --grid 3,3,3", "safetensors"),
    ("field s.obj --order 2 --rays 64 --spheres 4 --cells 4", "safetensors"),
    ("render s.obj --mode truth --env bundled:sunset --size 16x12 --samples 4", "exr"),
];

/// Makes the shards of a command as `part-1` and so on, and returns their names.
fn shards(dir: &Dir, command: &str, count: usize) -> Vec<String> {
    let part = |number: usize| {
        let name = format!("part-{number}.safetensors");
        dir.lobe(&format!("{command} --shard {number}/{count} -o {name}")).succeeds();
        name
    };
    (1..=count).map(part).collect()
}

/// The bytes of one machine, and those merged of shards in another order.
fn both_ways(dir: &Dir, command: &str, extension: &str, count: usize) -> [Vec<u8>; 2] {
    dir.lobe(&format!("{command} -o one.{extension}")).succeeds();
    let mut parts = shards(dir, command, count);
    parts.reverse();
    parts.rotate_left(count / 2);
    dir.lobe(&format!("{command} --merge {} -o merged.{extension}", parts.join(" "))).succeeds();
    ["one", "merged"].map(|name| dir.bytes(&format!("{name}.{extension}")))
}

#[test]
fn shards_of_every_kind_of_work_make_the_bytes_of_one_machine() {
    for (command, extension) in KINDS {
        let dir = Dir::new();
        dir.file("s.obj", SCENE);
        let [one, merged] = both_ways(&dir, command, extension, 3);
        assert!(one == merged, "{command}");
        let left: Vec<String> = dir.names().into_iter().filter(|name| name.contains("checkpoint")).collect();
        assert_eq!(left, Vec::<String>::new(), "{command}");
    }
}

#[test]
fn any_number_of_shards_makes_the_same_bytes() {
    let (command, extension) = KINDS[0];
    for count in [1, 2, 7] {
        let dir = Dir::new();
        dir.file("s.obj", SCENE);
        let [one, merged] = both_ways(&dir, command, extension, count);
        assert!(one == merged, "{count} shards");
    }
}

#[test]
fn shards_that_are_not_all_of_one_command_are_refused_by_name() {
    let dir = Dir::new();
    dir.file("s.obj", SCENE);
    let command = KINDS[0].0;
    shards(&dir, command, 3);
    dir.lobe(&format!("{command} --seed 7 --shard 2/3 -o other.safetensors")).succeeds();
    dir.file("none.safetensors", "no shard");
    let bytes = dir.bytes("part-2.safetensors");
    dir.file("short.safetensors", &bytes[..bytes.len() - 9]);
    let before = dir.names();
    let [a, b, c] = [1, 2, 3].map(|number| format!("part-{number}.safetensors"));
    let refusal = |options: &str, parts: &[&str]| {
        dir.lobe(&format!("{command} {options} --quiet --merge {} -o m.glb", parts.join(" "))).error()
    };
    for (parts, expected) in [
        (vec![a.as_str(), &c], "expected 3 shards, found 2; missing: 2/3"),
        (vec![&a, &b, &b, &c], "part-2.safetensors: is shard 2/3, and so is part-2.safetensors; leave one of them out"),
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
    assert!(error.contains("part-1.safetensors: this shard and the others are not of this command"), "{error}");
    assert_eq!(dir.names(), before, "nothing is left of another command");
    for (options, expected) in [
        ("--shard 4/3 -o x.safetensors", "expected a shard such as 2/7"),
        ("--shard 1/3 -o x.glb", "expected a name that ends in .safetensors"),
        ("--shard 1/3 --adaptive 0.1 -o x.safetensors", "--shard and --merge: not of --adaptive"),
        ("--shard 1/3 -o s.obj.safetensors --merge part-1.safetensors", "cannot be used with"),
    ] {
        let error = dir.lobe(&format!("{command} {options}")).error();
        assert!(error.contains(expected), "{options}: {error}");
    }
    let render = "render s.obj --env bundled:sunset --size 4x4 --shard 1/2 -o x.safetensors";
    let error = dir.lobe(&format!("{render} --mode irradiance")).error();
    assert!(error.contains("--shard and --merge: only of a single picture of --mode truth"), "{error}");
    assert_eq!(dir.names(), before, "nothing is written");
}

#[test]
fn a_shard_goes_on_where_it_was_cut_off_and_tells_what_it_has() {
    let dir = Dir::new();
    dir.file("s.obj", SCENE);
    let command = format!("{} --shard 2/2 -o part.safetensors", KINDS[0].0);
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
