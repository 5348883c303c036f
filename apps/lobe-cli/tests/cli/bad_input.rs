//! Invalid files: damaged, missing, of another kind or too large; one clear line and exit code 2 for each.

use lobe::sh::ShVec;
use lobe::sh::expansion::Quantity;

use crate::harness::{Dir, ONE, flat_hdr};
#[cfg(target_os = "linux")]
use crate::memory::limited;

fn project_error(name: &str, bytes: impl AsRef<[u8]>) -> String {
    let dir = Dir::new();
    dir.file(name, bytes);
    let line = dir.lobe(&format!("project {name} -o p.sh.json")).error();
    assert_eq!(dir.names(), [name], "files after {line}");
    assert!(line.starts_with(&format!("{name}: ")), "the file is not named: {line}");
    line[name.len() + 2..].to_owned()
}

/// An expansion of order 1 with one field replaced.
fn sh_error(from: &str, to: &str) -> String {
    let dir = Dir::new();
    let good = r#"{"format":"lobe-sh","version":1,"order":1,"quantity":"radiance","coefficients":[[1,2,3]]}"#;
    dir.file("p.sh.json", good.replace(from, to));
    let line = dir.lobe("sh eval p.sh.json --dir 0,0,1").error();
    assert!(line.starts_with("p.sh.json: "), "the file is not named: {line}");
    line["p.sh.json: ".len()..].to_owned()
}

#[test]
fn missing_files_and_folders_are_named() {
    let dir = Dir::new();
    for args in [
        "project none.exr -o p.sh.json",
        "env info none.exr",
        "env irradiance none.exr -o e.exr",
        "env reconstruct none.exr -o r.exr",
        "sh eval none.exr --dir 0,0,1",
        "sh convolve none.exr --kernel cosine -o q.sh.json",
    ] {
        let line = dir.lobe(args).error();
        assert!(
            line.starts_with("none.exr: ") && line.ends_with(": no such file; check the name and the folder"),
            "{args}: {line}"
        );
    }
    for args in ["project . -o p.sh.json", "sh eval . --dir 0,0,1"] {
        let line = dir.lobe(args).error();
        assert!(line.starts_with(".: ") && line.contains("directory") || line.contains("folder"), "{args}: {line}");
    }
    let line = dir.lobe("project bundled:moon -o p.sh.json").error();
    assert_eq!(
        line, "bundled:moon: there is no such map in the program; there is bundled:sunset or bundled:studio",
        "moon"
    );
}

#[test]
fn truncated_pictures_are_refused() {
    let hdr = flat_hdr(16, 8, &[ONE; 128]);
    for end in [5, 40, hdr.len() / 2, hdr.len() - 1] {
        project_error("cut.hdr", &hdr[..end]);
    }
    let dir = Dir::new();
    dir.map("sky.exr", 64, 32, |x, y| [x as f32, y as f32, 1.0 / (1 + x * y) as f32]);
    let exr = dir.bytes("sky.exr");
    for end in [3, 10, 100, 300, exr.len() / 2, exr.len() - 1] {
        project_error("cut.exr", &exr[..end]);
    }
}

#[test]
fn pictures_of_another_shape_are_refused() {
    let line = project_error("square.hdr", flat_hdr(4, 4, &[ONE; 16]));
    assert!(line.starts_with("a picture of 4 x 4 is neither lat-long (2:1) nor a cube"), "{line}");
    for (width, height) in [(0, 0), (2, 0), (0, 1)] {
        project_error("empty.hdr", flat_hdr(width, height, &[]));
    }
}

#[test]
fn a_photograph_that_is_no_map_is_refused_with_the_options_of_the_command() {
    let dir = Dir::new();
    dir.map("photo.pfm", 6, 4, |_, _| [1.0; 3]);
    let line = dir.lobe("env info photo.pfm").error();
    assert!(line.contains("say what it is with --from or --fisheye"), "{line}");
    let line = dir.lobe("render trace built-in:ball --env photo.pfm -o a.png").error();
    assert!(line.contains("make a map of it first: lobe env convert") && !line.contains("say what it is"), "{line}");
}

#[test]
fn text_with_the_name_of_a_picture_is_refused() {
    let line = project_error("text.hdr", "hello, this is a letter\n");
    assert!(line.contains("found text beginning with \"hello, this"), "{line}");
    let line = project_error("text.exr", "");
    assert!(line.contains("the file is empty"), "{line}");
    let line = project_error("photo.hdr", b"GIF89a");
    assert!(line.contains("found a GIF picture; convert it to .hdr or .exr"), "{line}");
}

#[test]
fn a_header_that_claims_five_billion_pixels_is_refused_for_its_size() {
    let line = project_error("bomb.hdr", flat_hdr(100_000, 50_000, &[]));
    assert!(line.contains("100000 x 50000"), "{line}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_header_that_claims_many_pixels_takes_no_memory_for_them() {
    let dir = Dir::new();
    // 200 million pixels, which are let in, take 2.4 GB; 1.5 GiB can be had.
    dir.file("bomb.hdr", flat_hdr(20_000, 10_000, &[]));
    let output = limited(&dir, 3 << 19, "project bomb.hdr --max-texels 1000000000 -o p.sh.json");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.starts_with("lobe: bomb.hdr: "), "{said}");
    assert_eq!(dir.names(), ["bomb.hdr"], "files");
}

#[test]
fn the_limit_of_pixels_can_be_moved() {
    let dir = Dir::new();
    dir.file("a.hdr", flat_hdr(8, 4, &[ONE; 32]));
    let line = dir.lobe("env info a.hdr --max-texels 31").error();
    assert_eq!(
        line,
        "a.hdr: the picture is 8 x 4, more than the limit of 31 texels; scale it down, or raise it with --max-texels",
        "below"
    );
    for command in ["env info a.hdr", "project a.hdr -o p.sh.json"] {
        dir.lobe(&format!("{command} --max-texels 32")).succeeds();
    }
    // A panorama of 24576 x 12288 is more than is read without the option; then it is only refused for its few bytes.
    dir.file("b.hdr", flat_hdr(24_576, 12_288, &[ONE; 32]));
    let line = dir.lobe("env info b.hdr").error();
    assert!(line.contains("more than the limit of 268435456 texels"), "{line}");
    let line = dir.lobe("env info b.hdr --max-texels 400000000").error();
    assert!(line.contains("the file ends early"), "{line}");
}

#[test]
fn expansions_with_a_wrong_head_or_wrong_rows_are_refused() {
    for (from, to, line) in [
        ("[[1,2,3]]", "[[1,2,3],[1,2,3]]", "\"coefficients\": order 1 has 1 rows, found 2"),
        ("[[1,2,3]]", "[[1,2]]", "\"coefficients\": expected an array of 1 or 3 numbers in row 0, found 2"),
        ("\"version\":1", "\"version\":7", "\"version\": this Lobe reads version 1, found 7; a newer Lobe may read it"),
        ("\"order\":1", "\"order\":0", "\"order\": expected a whole number from 1 to 256, found 0"),
        ("\"order\":1", "\"order\":257", "\"order\": expected a whole number from 1 to 256, found 257"),
        (
            "\"radiance\"",
            "\"light\"",
            "\"quantity\": expected one of radiance, irradiance, transfer, visibility, log-visibility, function, found \"light\"",
        ),
        ("lobe-sh", "other", "\"format\": expected \"lobe-sh\", found \"other\"; is this an expansion?"),
        ("]]}", "", "the file is cut off: EOF while parsing a list at line 1 column 86"),
        ("[1,2,3]", "[1,1e999,3]", "not valid JSON: number out of range at line 1 column 88"),
    ] {
        assert_eq!(sh_error(from, to), line, "{to}");
    }
}

#[test]
fn pictures_and_expansions_are_not_taken_for_each_other() {
    let dir = Dir::new();
    dir.sh("p.sh.json", Quantity::Radiance, ShVec::constant(2, 1.0));
    dir.map("sky.exr", 2, 1, |_, _| [1.0; 3]);
    dir.file("sky.hdr", flat_hdr(2, 1, &[ONE; 2]));
    for command in ["project p.sh.json -o q.sh.json", "env info p.sh.json"] {
        let line = dir.lobe(command).error();
        assert!(line.starts_with("p.sh.json: expected a picture (.exr, .hdr, .pfm, .tif, .png, .jpg, "), "{line}");
        assert!(line.ends_with("), found an expansion; make a picture of it with lobe env reconstruct"), "{line}");
    }
    for (name, kind) in [("sky.exr", "an OpenEXR picture"), ("sky.hdr", "a Radiance picture")] {
        let line = format!("{name}: expected a .sh.json file, found {kind}; project it first");
        assert_eq!(dir.lobe(&format!("sh eval {name} --dir 0,0,1")).error(), line, "eval {name}");
        assert_eq!(dir.lobe(&format!("env reconstruct {name} -o r.exr")).error(), line, "reconstruct {name}");
        assert_eq!(
            dir.lobe("sh eval - --dir 0,0,1").stdin(dir.bytes(name)).error(),
            line.replacen(name, "stdin", 1),
            "stdin"
        );
    }
}

#[test]
fn numbers_that_overflow_are_not_written() {
    let dir = Dir::new();
    dir.sh("p.sh.json", Quantity::Visibility, ShVec::constant(2, 1e25));
    let line = dir.lobe("sh product p.sh.json p.sh.json -o q.sh.json").error();
    assert!(
        line.starts_with("q.sh.json: coefficient 0 is 3.5") && line.ends_with("a file holds numbers up to 1e30"),
        "{line}"
    );
    let line = dir.lobe("light ambient --color 1e300,0,0 -o q.sh.json").error();
    assert!(line.ends_with("a file holds numbers up to 1e30"), "{line}");
    assert_eq!(dir.names(), ["p.sh.json"], "files");
    let text = r#"{"format":"lobe-sh","version":1,"order":1,"quantity":"radiance","coefficients":[[3e275]]}"#;
    dir.file("huge.sh.json", text.as_bytes());
    let line = dir.lobe("sh info huge.sh.json").error();
    assert!(line.contains("row 0 holds 3e275") && line.contains("numbers up to 1e30 are read"), "{line}");
}

#[test]
fn expansions_are_written_under_their_own_extension_only() {
    let dir = Dir::new();
    dir.sh("p.sh.json", Quantity::Radiance, ShVec::constant(2, 1.0));
    for args in ["sh rotate p.sh.json --axis 0,0,1 --angle 4", "light ambient", "project bundled:sunset"] {
        for name in ["x.png", "x", "x.exr"] {
            let line = dir.lobe(&format!("{args} -o {name}")).error();
            assert_eq!(line, format!("-o: {name}: an expansion is written as .sh.json, or to stdout with -"), "{args}");
        }
    }
    assert_eq!(dir.names(), ["p.sh.json"], "files");
}

#[test]
fn a_decoder_that_panics_makes_one_line_too() {
    // Found by fuzzing: a block of B44 whose shift overflows inside of the decoder when arithmetic is checked.
    let line = project_error("b44.exr", include_bytes!("../data/b44-shift.exr"));
    assert!(!line.contains("panicked"), "{line}");
}
