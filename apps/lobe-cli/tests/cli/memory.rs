//! Memory limits: work that takes more memory than allowed or available is refused before it begins.

#[cfg(target_os = "linux")]
use std::process::{Command, Output, Stdio};
#[cfg(target_os = "linux")]
use std::time::Duration;

use serde_json::json;

use crate::harness::Dir;

/// What the program takes by itself, and freed memory that stays with it for a while: 12 to 32 MiB were seen.
#[cfg(target_os = "linux")]
const PROGRAM: u64 = 48 << 20;

/// Runs `lobe` with `kib` KiB of address space, in one thread, since each has a stack and a heap of its own.
#[cfg(target_os = "linux")]
pub(crate) fn limited(dir: &Dir, kib: u64, args: &str) -> Output {
    let lobe = env!("CARGO_BIN_EXE_lobe");
    let line = format!("ulimit -v {kib} && exec {lobe} {args} --threads 1 --quiet");
    Command::new("sh").args(["-c", &line]).current_dir(dir.path("")).output().unwrap()
}

fn scene(dir: &Dir) {
    dir.file(
        "s.obj",
        "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvn 0 0 1\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1/1 2/2/1 3/3/1 4/4/1\n",
    );
    dir.map("even.exr", 16, 8, |_, _| [1.0; 3]);
}

#[test]
fn a_small_file_of_many_equal_numbers_is_held_against_the_limit() {
    let dir = Dir::new();
    scene(&dir);
    let mut layers = lobe::image::ExrLayers::new(2048, 2048);
    for name in ["R", "G", "B", "variance.R", "variance.G", "variance.B"] {
        layers.channel(name, vec![0.0; 2048 * 2048]);
    }
    let bytes = layers.into_bytes().unwrap();
    assert!(bytes.len() < 2 << 20, "{} bytes hold 96 MiB", bytes.len());
    std::fs::write(dir.path("flat.exr"), bytes).unwrap();
    for args in [
        "render s.obj --env even.exr --transfer flat.exr --mode shadowed --size 4x4 --max-memory 0.1 -o a.png",
        "compare flat.exr flat.exr --z-test --max-memory 0.1",
    ] {
        let line = dir.lobe(args).arg("--quiet").error();
        assert!(line.contains("flat.exr takes up to 301989888 bytes of memory"), "{args}: {line}");
        assert!(line.contains("more than the limit of 0.1 GiB"), "{args}: {line}");
        let advice = if args.starts_with("compare") { "ask for smaller pictures" } else { "a lower order" };
        assert!(line.contains(advice), "{args}: {line}");
    }
    for args in [
        "compare flat.exr flat.exr --max-memory 0.01",
        "render irradiance s.obj --env flat.exr --size 4x4 --max-memory 0.01 -o a.png",
    ] {
        let line = dir.lobe(args).arg("--quiet").error();
        assert!(line.contains("flat.exr: the picture is 2048 x 2048, more than the limit"), "{args}: {line}");
        assert!(line.ends_with("or raise the limit with --max-memory"), "{args}: {line}");
    }
    let line = dir.lobe("compare none.exr none.exr --z-test").error();
    assert!(line.contains("none.exr: no such file"), "{line}");
}

#[test]
fn what_takes_more_than_the_limit_is_refused_in_one_line() {
    let dir = Dir::new();
    scene(&dir);
    let before = dir.names();
    for (args, part) in [
        (
            "render trace s.obj --env even.exr --size 16384x16384 -o a.exr",
            "--size 16384x16384 takes up to 60129542144 bytes of memory (56.0 GiB), more than the limit of 4 GiB; ask for a \
             smaller picture, or raise the limit with --max-memory",
        ),
        ("render irradiance s.obj --env even.exr --size 16384x16384 -o a.png", "--size 16384x16384 takes up to "),
        (
            "render s.obj --env even.exr --mode shadowed --order 8 --size 4x4 --max-memory 0.0000015 -o a.png",
            "transfer of 4 vertices at order 8 takes up to 2096 bytes of memory",
        ),
        (
            "render s.obj --env even.exr --mode glossy --size 4x4 --order 8 --max-memory 0.0001 -o a.png",
            "more than the limit of 0.0001 GiB; ask for a lower --order, or raise the limit with --max-memory",
        ),
        ("bake s.obj --texels 16384 -o a.safetensors", "--texels 16384 takes up to "),
        ("bake s.obj --texels 4096 --order 5 -o a.exr", "ask for fewer --texels, or a lower --order"),
    ] {
        let line = dir.lobe(args).arg("--quiet").error();
        assert!(line.contains(part) && line.contains(" bytes of memory"), "{args}: {line}");
    }
    assert_eq!(dir.names(), before, "nothing was written");
}

/// A file of 1.3 MB: a mesh of 2048 triangles, shown by 30 000 nodes.
#[test]
fn sixty_million_instanced_triangles_of_a_small_file_are_refused_in_one_line() {
    const SIDE: usize = 33;
    const NODES: usize = 30_000;
    let dir = Dir::new();
    let positions = (0..SIDE * SIDE).flat_map(|i| [(i % SIDE) as f32, (i / SIDE) as f32, (i % 7) as f32]);
    let cells = (0..SIDE * SIDE).filter(|i| i % SIDE + 1 < SIDE && i / SIDE + 1 < SIDE);
    let triangles = cells.flat_map(|i| [i, i + 1, i + SIDE + 1, i, i + SIDE + 1, i + SIDE]);
    let mut bytes: Vec<u8> = positions.flat_map(f32::to_le_bytes).collect();
    let indices_at = bytes.len();
    bytes.extend(triangles.flat_map(|i| (i as u32).to_le_bytes()));
    let nodes: Vec<_> = (0..NODES).map(|k| json!({"mesh": 0, "translation": [40 * k, 0, 0]})).collect();
    let gltf = json!({
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": (0..NODES).collect::<Vec<_>>()}],
        "nodes": nodes,
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": SIDE * SIDE, "type": "VEC3", "min": [0, 0, 0], "max": [32, 32, 6]},
            {"bufferView": 1, "componentType": 5125, "count": 6 * (SIDE - 1) * (SIDE - 1), "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": indices_at},
            {"buffer": 0, "byteOffset": indices_at, "byteLength": bytes.len() - indices_at},
        ],
        "buffers": [{"uri": "many.bin", "byteLength": bytes.len()}],
    });
    dir.file("many.bin", &bytes);
    dir.file("many.gltf", gltf.to_string());
    for (options, part, advice) in [
        ("", "expected a scene of at most 4294967296 bytes, found 12", "raise the limit with --max-memory"),
        (
            "--max-triangles 99999999",
            "expected a scene of at most 4294967296 bytes",
            "raise the limit with --max-memory",
        ),
        ("--max-memory 64", "expected at most 67108864 triangles and vertices", "raise it with --max-triangles"),
    ] {
        let line = dir.lobe(&format!("bake many.gltf -o a.glb --quiet {options}")).error();
        assert!(line.starts_with("many.gltf: ") && line.contains(part) && line.contains(advice), "{options}: {line}");
    }
    assert_eq!(dir.names(), ["many.bin", "many.gltf"], "nothing was written");
}

#[test]
fn a_glb_of_many_meshes_is_refused_before_the_bake() {
    const NODES: usize = 20_000;
    let dir = Dir::new();
    let bytes: Vec<u8> =
        [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].into_iter().flat_map(f32::to_le_bytes).collect();
    let mut gltf = json!({
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": (0..NODES).collect::<Vec<_>>()}],
        "nodes": (0..NODES).map(|k| json!({"mesh": 0, "translation": [k, 0, 0]})).collect::<Vec<_>>(),
        "meshes": [{"primitives": [{}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}],
        "bufferViews": [{"buffer": 0, "byteLength": bytes.len()}],
        "buffers": [{"uri": "one.bin", "byteLength": bytes.len()}],
    });
    dir.file("one.bin", &bytes);
    // Positions, normals, triangles and transfer; colors are one attribute more.
    for (attributes, bytes) in
        [(json!({"POSITION": 0}), 187_200_000), (json!({"POSITION": 0, "COLOR_0": 0}), 234_000_000)]
    {
        gltf["meshes"][0]["primitives"][0]["attributes"] = attributes;
        dir.file("one.gltf", gltf.to_string());
        let line = dir.lobe("bake one.gltf -o a.glb --samples 1 --order 1 --max-memory 0.1 --quiet").error();
        let expected = format!("a .glb of 20000 meshes takes up to {bytes} bytes of memory");
        assert!(line.contains(&expected) && line.contains("or a .safetensors file"), "{line}");
    }
    assert_eq!(dir.names(), ["one.bin", "one.gltf"], "nothing was written");
}

#[cfg(target_os = "linux")]
#[test]
fn what_the_system_does_not_give_is_told_and_nothing_aborts() {
    let dir = Dir::new();
    scene(&dir);
    let before = dir.names();
    for args in [
        "render irradiance s.obj --env even.exr --size 7000x6000 -o a.png",
        "render trace s.obj --env even.exr --samples 2 --size 4000x3000 -o a.exr",
        "bake s.obj --texels 6000 --order 1 -o a.safetensors",
    ] {
        let output = limited(&dir, 3 << 19, args);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{args}: {stderr}");
        assert!(stderr.contains(" bytes of memory, which the system does not give; ask for "), "{args}: {stderr}");
        assert_eq!(stderr.lines().count(), 1, "{args}: {stderr}");
    }
    assert_eq!(dir.names(), before, "nothing was written");
}

#[cfg(target_os = "linux")]
#[test]
fn memory_that_is_refused_in_the_middle_of_work_is_a_line_and_no_fault() {
    let dir = Dir::new();
    // Triangles by the million, in 384 MiB.
    let output = limited(&dir, 3 << 17, "bake built-in:ball --max-edge 0.004 -o a.glb");
    let stderr = String::from_utf8_lossy(&output.stderr);
    let last = stderr.lines().last().unwrap_or_default();
    assert_eq!(output.status.code(), Some(2), "{stderr}");
    assert!(last.starts_with("lobe: out of memory: ") && last.contains(" more bytes were asked for"), "{stderr}");
    assert!(!dir.path("a.glb").exists(), "no output");
}

#[cfg(not(target_os = "linux"))]
#[test]
fn memory_that_is_refused_in_the_middle_of_work_is_a_line_and_no_fault() {
    lobe_testkit::skipped("this system does not limit the memory of a program");
}

/// Runs `lobe` to its end, which must be good, and returns the most bytes that it was seen to have in memory. Between two looks it
/// may have had more, so this is a lower bound: what is above a limit is so for certain.
#[cfg(target_os = "linux")]
fn peak(dir: &Dir, args: &str) -> u64 {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lobe"));
    command.args(args.split(' ')).args(["--quiet", "--threads", "1"]).current_dir(dir.path(""));
    let mut child = command.stderr(Stdio::piped()).spawn().unwrap();
    let status = format!("/proc/{}/status", child.id());
    let mut peak = 0;
    while child.try_wait().unwrap().is_none() {
        let found = std::fs::read_to_string(&status).unwrap_or_default();
        let kib = found.lines().find_map(|line| line.strip_prefix("VmHWM:")?.trim().strip_suffix(" kB")?.parse().ok());
        peak = peak.max(1024 * kib.unwrap_or(0_u64));
        std::thread::sleep(Duration::from_millis(1));
    }
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), &*String::from_utf8_lossy(&output.stderr)), (Some(0), ""), "{args}");
    assert!(peak > 0, "{args}: it was never seen at work");
    peak
}

#[cfg(target_os = "linux")]
#[test]
#[ignore = "long: of the nightly group"]
fn work_takes_no_more_memory_than_is_said() {
    let dir = Dir::new();
    scene(&dir);
    for args in [
        "render trace s.obj --env even.exr --samples 2 --size 800x600 -o a.exr",
        "render trace s.obj --env even.exr --samples 2 --size 800x600 -o a.png",
        "render irradiance s.obj --env even.exr --samples 1 --size 1600x1200 -o a.exr",
        "render irradiance s.obj --env even.exr --samples 1 --size 1600x1200 -o a.png",
        "bake s.obj --mode unshadowed --order 1 --texels 1200 -o a.safetensors",
        "bake s.obj --mode unshadowed --order 6 --texels 500 -o a.exr",
        // Of the work before, which is the input of these.
        "compress a.safetensors --clusters 2 --components 1 -o c.safetensors",
        "fit-lobes a.safetensors --closed-form -o l.safetensors",
    ] {
        // It is said if no more may be taken than is to read a small input.
        let limit = if args.contains("a.safetensors -") { "0.017" } else { "0.000001" };
        let line = dir.lobe(&format!("{args} --max-memory {limit}")).arg("--quiet").error();
        let (_, rest) = line.split_once(" takes up to ").unwrap();
        let said: u64 = rest.split_once(" bytes").unwrap().0.parse().unwrap();
        let found = peak(&dir, args);
        // Up to a quarter was seen to stay with the allocator.
        assert!(found < said + said / 4 + PROGRAM, "{args}: {found} bytes, {said} were said");
    }
}

#[cfg(target_os = "linux")]
#[test]
#[ignore = "long: of the nightly group"]
fn pictures_of_an_animation_are_not_kept() {
    let dir = Dir::new();
    scene(&dir);
    let args = "render irradiance s.obj --env even.exr --samples 1 --size 512x384 --frames";
    let found = peak(&dir, &format!("{args} 32 -o a.png"));
    assert_eq!(dir.names().len(), 2 + 33, "pictures and their animation");
    // All of them are 75 MB as numbers.
    assert!(found < PROGRAM + (16 << 20), "{found} bytes with 32 pictures");
}

#[test]
#[cfg(target_os = "linux")]
fn a_map_is_projected_in_less_memory_than_its_picture_takes() {
    let dir = Dir::new();
    let texels = 4096 * 2048;
    let picture = 12 * texels;
    for name in ["m.hdr", "m.exr"] {
        dir.map(name, 4096, 2048, |_, _| [1.0, 2.0, 4.0]);
        let by_rows = peak(&dir, &format!("project {name} --order 3 -o a.sh.json"));
        assert!(by_rows < picture, "{name}: {by_rows} bytes by rows, the picture has {picture}");
        // An order that is not taken from rows needs all of it: the measure tells the two apart.
        let whole = peak(&dir, &format!("project {name} --order 17 -o b.sh.json"));
        assert!(whole > picture, "{name}: {whole} bytes, the picture has {picture}");
    }
}

#[test]
fn conversions_of_maps_that_take_more_than_the_limit_are_refused_with_their_bytes() {
    let dir = Dir::new();
    dir.map("sky.pfm", 64, 32, |_, _| [1.0; 3]);
    for (args, what, bytes) in [
        ("env convert sky.pfm --size 2048 -o x.exr", "a map of 4096 x 2048 texels from one of 64 x 32", 335_568_896),
        ("env convert sky.pfm --to cube --size 1024 -o x.exr", "a map of 1024 x 6144 texels", 503_316_480),
        ("env convert sky.pfm --to cube --size 1024 -o x.ktx2", "a map of 1024 x 6144 texels", 251_682_816),
        (
            "env prefilter sky.pfm --size 1024 -o x.ktx2",
            "faces of 1024 x 1024 texels from a map of 64 x 32",
            239_157_248,
        ),
        ("env prefilter sky.pfm --size 1024 --texels rgba16f -o x.ktx2", "faces of 1024 x 1024 texels", 169_951_232),
        ("env prefilter sky.pfm --size 1024 --left-handed -o x.ktx2", "faces of 1024 x 1024 texels", 339_820_544),
        ("env prefilter sky.pfm --size 1024 --zstd -o x.ktx2", "faces of 1024 x 1024 texels", 371_277_824),
    ] {
        let line = dir.lobe(&format!("{args} --max-memory 0.1 --quiet")).error();
        assert!(line.starts_with(what), "{args}: {line}");
        assert!(line.contains(&format!("takes up to {bytes} bytes of memory")), "{args}: {line}");
        assert!(line.contains("raise the limit with --max-memory"), "{args}: {line}");
    }
    assert_eq!(dir.names(), ["sky.pfm"], "files");
    dir.lobe("env convert sky.pfm --size 64 -o x.exr --max-memory 0.1").succeeds();
}

#[cfg(unix)]
#[test]
fn a_picture_longer_than_the_limit_is_refused_before_it_is_read() {
    let dir = Dir::new();
    for (name, begin) in [("sky.png", &b"\x89PNG\r\n\x1a\n"[..]), ("sky.jpg", b"\xff\xd8\xff"), ("sky.dds", b"DDS ")] {
        dir.file(name, begin);
        let file = std::fs::OpenOptions::new().write(true).open(dir.path(name)).unwrap();
        file.set_len(30 << 30).unwrap();
        for command in ["env info", "env convert -o x.exr", "project -o p.sh.json"] {
            let line = dir.lobe(&format!("{command} {name} --max-memory 2")).error();
            let expected = format!(
                "{name}: the file has 32212254720 bytes, more than the limit of 2147483648; make it smaller, or raise the limit with \
                 --max-memory"
            );
            assert_eq!(line, expected, "{command}");
        }
        let line = dir.lobe(&format!("render built-in:ball --mode shadowed --env {name} -o x.png")).error();
        assert!(line.contains("the file has 32212254720 bytes, more than the limit of 4294967296"), "{line}");
    }
}

#[test]
fn all_work_on_a_map_is_held_against_the_limit() {
    let dir = Dir::new();
    // 64 MiB cannot hold any of it, and hold the map.
    dir.map("sky.pfm", 2048, 1024, |_, _| [1.0; 3]);
    dir.lobe("env convert sky.pfm --to cube --size 512 -o cube.ktx2 --quiet").succeeds();
    let before = dir.names();
    for (args, what) in [
        (
            "env rotate sky.pfm --axis 0,0,1 --angle 30 -o x.exr",
            "rotating a map of 2048 x 1024 texels takes up to 109051904 bytes",
        ),
        ("env sun sky.pfm -o x.exr", "looking for suns in a map of 2048 x 1024 texels takes up to 109051904 bytes"),
        ("env adjust sky.pfm --scale 2,2,2 -o x.exr", "writing a map of 2048 x 1024 texels takes up to 83886080 bytes"),
        ("env show sky.pfm -o x.png", "prefiltering a map of 2048 x 1024 texels takes up to 83886080 bytes"),
        (
            "env irradiance cube.ktx2 --method brute-force -o x.exr",
            "converting a map of 512 x 3072 texels takes up to 81788928 bytes",
        ),
        ("env convert cube.ktx2 --left-handed --zstd -o x.ktx2", "writing a map of 512 x 3072 texels takes up to "),
    ] {
        let line = dir.lobe(&format!("{args} --max-memory 0.0625 --quiet")).error();
        assert!(line.contains(what) && line.contains("--max-memory"), "{args}: {line}");
    }
    assert_eq!(dir.names(), before, "nothing was written");
}

/// The peak of what a command takes is below what it says that it needs.
#[cfg(target_os = "linux")]
#[test]
fn conversions_of_maps_take_no_more_than_they_say() {
    let dir = Dir::new();
    dir.map("sky.pfm", 2048, 1024, |x, y| [(x * y % 17) as f32, 1.0, y as f32]);
    for (args, need) in [
        ("env convert sky.pfm --to octahedral --size 1448 -o x.exr", 52),
        ("env convert sky.pfm --size 64 -o x.exr", 40),
        ("env convert sky.pfm --to octahedral --size 1448 -o x.png", 52),
        ("env prefilter sky.pfm --size 32 -o x.ktx2", 41),
    ] {
        let peak = peak_of(&dir, args);
        // Each thread keeps freed memory for a while, which shows where maps are small.
        let said = 4 * PROGRAM + need * (2 << 20);
        assert!(peak <= said, "{args}: {peak} bytes, which are to be {said} at most");
        // The map that is read takes 12 bytes a texel: less was seen only where the look came too early.
        assert!(peak > 12 * (2 << 20), "{args}: {peak} bytes are less than its input takes");
    }
}

/// The most bytes in memory that were seen of a command, which has to succeed.
#[cfg(target_os = "linux")]
fn peak_of(dir: &Dir, args: &str) -> u64 {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lobe"));
    let mut child =
        command.args(args.split(' ')).args(["--quiet", "--threads", "2"]).current_dir(dir.path("")).spawn().unwrap();
    let status = format!("/proc/{}/status", child.id());
    let mut peak = 0;
    loop {
        let text = std::fs::read_to_string(&status).unwrap_or_default();
        let kib =
            text.lines().find_map(|line| line.strip_prefix("VmHWM:")?.trim().strip_suffix(" kB")?.parse::<u64>().ok());
        peak = peak.max(kib.unwrap_or(0) << 10);
        if let Some(status) = child.try_wait().unwrap() {
            assert!(status.success(), "{args}: {status}");
            return peak;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
}
