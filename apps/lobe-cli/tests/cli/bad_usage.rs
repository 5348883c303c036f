//! Invalid command lines: one line that names the fault and points to the help.

use lobe::sh::ShVec;
use lobe::sh::expansion::Quantity;

use crate::harness::Dir;

#[test]
fn slips_on_the_command_line_are_one_line() {
    let dir = Dir::new();
    for (args, line) in [
        (
            "sh eval p.sh.json",
            "the following required arguments were not provided: --dir <X,Y,Z>; see lobe sh eval --help",
        ),
        ("roast x", "unrecognized subcommand 'roast'; see lobe --help"),
        (
            "sh convolve p.sh.json --kernal cosine -o -",
            "unexpected argument '--kernal' found (a similar argument exists: '--kernel'); see lobe sh convolve --help",
        ),
        (
            "sh eval p.sh.json --dir 0,0,0",
            "invalid value '0,0,0' for '--dir <X,Y,Z>': 0,0,0 points nowhere; give a vector that is not zero; see lobe sh eval --help",
        ),
        (
            "sh eval p.sh.json --dir 1,2",
            "invalid value '1,2' for '--dir <X,Y,Z>': expected 3 numbers with commas between them, such as 0,0,1; found 2; \
             see lobe sh eval --help",
        ),
        (
            "project x.exr -o - --order 0",
            "invalid value '0' for '--order <N>': expected an order (number of bands) from 1 to 256; see lobe project --help",
        ),
        (
            "project x.exr -o - --order -1",
            "invalid value '-1' for '--order <N>': expected an order (number of bands) from 1 to 256; see lobe project --help",
        ),
        (
            "project x.exr -o - --order 257",
            "invalid value '257' for '--order <N>': expected an order (number of bands) from 1 to 256; see lobe project --help",
        ),
        (
            "project x.exr -o - --method magic",
            "invalid value 'magic' for '--method <METHOD>' [possible values: exact, monte-carlo, fibonacci]; see lobe project --help",
        ),
        (
            "project x.exr -o - --threads 0",
            "invalid value '0' for '--threads <N>': expected a number of threads from 1 to 1024; see lobe project --help",
        ),
        (
            "sh convolve p.sh.json -o - --kernel ggx:2",
            "invalid value 'ggx:2' for '--kernel <cosine|phong:E|ggx:ALPHA|Z.sh.json>': a GGX roughness lies between 0 and 1, \
             it is not 2; see lobe sh convolve --help",
        ),
    ] {
        assert_eq!(dir.lobe(args).error(), line, "lobe {args}");
    }
}

#[test]
fn variables_that_name_no_instructions_and_no_number_of_threads_are_refused() {
    let dir = Dir::new();
    for (name, value, range) in [
        ("LOBE_SIMD", "plains", "plain, neon, avx2 or avx512"),
        ("LOBE_SIMD", "AVX2", "plain, neon, avx2 or avx512"),
        ("LOBE_HUGE_PAGES", "none", "on or off"),
        ("RAYON_NUM_THREADS", "0", "a number of threads from 1 to 1024"),
        ("RAYON_NUM_THREADS", "100000", "a number of threads from 1 to 1024"),
        ("RAYON_NUM_THREADS", "-3", "a number of threads from 1 to 1024"),
        ("RAYON_RS_NUM_CPUS", "two", "a number of threads from 1 to 1024"),
    ] {
        let error = dir.lobe("project bundled:sunset -o p.sh.json").env(name, value).error();
        assert_eq!(error, format!("{name}: expected {range}, found `{value}`; correct or unset it"));
    }
    let known = dir.lobe("light ambient --order 2 -o p.sh.json").env("LOBE_SIMD", "plain");
    known.env("RAYON_NUM_THREADS", "2").succeeds();
    let given = dir.lobe("--threads 2 light ambient --order 2 -o p.sh.json").env("RAYON_NUM_THREADS", "0");
    given.succeeds();
}

#[test]
fn a_rotation_is_given_in_exactly_one_way() {
    let dir = Dir::new();
    for args in [
        "",
        "--axis 0,0,1",
        "--angle 90",
        "--axis 0,0,1 --angle 90 --quat 0,0,0,1",
        "--quat 0,0,0,1 --angle 90",
        "--quat 0,0,0,1 --matrix 1,0,0,0,1,0,0,0,1",
        "--quat 0,0,1",
        "--euler-zyz 1,2",
        "--euler-zyz 1,2,inf",
        "--euler-zyz 1,2,3 --angle 90",
        "--euler-zyz 1,2,3 --quat 0,0,0,1",
        "--axis 0,0,1 --angle nan",
        "--axis 0,0,0 --angle 1",
    ] {
        dir.lobe(&format!("sh rotate p.sh.json -o q.sh.json {args}")).error();
    }
    assert_eq!(dir.names(), [""; 0], "files");
}

#[test]
fn stdin_is_read_only_once() {
    let dir = Dir::new();
    let line = "stdin: two inputs are -, but stdin can be read only once; name a file for one of them";
    assert_eq!(dir.lobe("sh product - - -o c.sh.json").error(), line, "product");
    assert_eq!(dir.lobe("sh convolve - --kernel - -o c.sh.json").error(), line, "convolve");
    let line = dir.lobe("project - -o p.sh.json").error();
    assert!(line.starts_with("-: pictures are read from files, not from stdin; name a file (.exr, .hdr, "), "{line}");
}

#[test]
fn an_output_that_cannot_be_written_is_refused_before_the_input_is_read() {
    let dir = Dir::new();
    dir.file("file", "");
    for (args, line) in [
        ("project none.exr -o none/p.sh.json", "none/p.sh.json: the folder none does not exist; make it first"),
        ("env irradiance none.exr -o none/e.exr", "none/e.exr: the folder none does not exist; make it first"),
        ("env reconstruct none.sh.json -o file/r.png", "file/r.png: the folder file does not exist; make it first"),
        ("sh product none none -o .", ".: this is a folder; give the name of a file"),
        ("sh rotate none --quat 0,0,0,1 -o .", ".: this is a folder; give the name of a file"),
        ("sh convolve none --kernel cosine -o none/", "none/: this is the name of a folder; give the name of a file"),
    ] {
        assert_eq!(dir.lobe(args).error(), line, "lobe {args}");
    }
    assert_eq!(dir.names(), ["file"], "files");
}

#[test]
fn an_error_leaves_the_old_output() {
    let dir = Dir::new();
    dir.file("q.sh.json", "old");
    dir.sh("p.sh.json", Quantity::Irradiance, ShVec::constant(2, 1.0));
    dir.lobe("sh convolve p.sh.json --kernel cosine -o q.sh.json").error();
    dir.lobe("project none.exr -o q.sh.json").error();
    assert_eq!(dir.bytes("q.sh.json"), b"old", "the old output");
    assert_eq!(dir.names(), ["p.sh.json", "q.sh.json"], "files");
}
