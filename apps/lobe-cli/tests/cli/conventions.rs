//! `lobe sh convert`.

use lobe::sh::convention::NamedConvention;
use lobe::sh::expansion::Quantity;
use lobe::sh::sh_json::FileCoefficients;
use lobe::sh::{Expansion as _, Rgb, ShVec};

use crate::harness::Dir;

fn gray() -> ShVec<f64> {
    ShVec::from_vec((0..16).map(|k| f64::from((7 * k + 3) % 17) / 17.0 - 0.4).collect()).unwrap()
}

fn worst(a: &FileCoefficients, b: &FileCoefficients) -> f64 {
    let (a, b) = (a.to_rgb(), b.to_rgb());
    let pairs = a.coefficients().iter().zip(b.coefficients());
    pairs.flat_map(|(a, b)| (*a - *b).to_array()).fold(0.0, |worst, e| worst.max(e.abs()))
}

#[test]
fn every_library_gets_its_numbers_and_gives_them_back() {
    let dir = Dir::new();
    dir.sh("gray.sh.json", Quantity::Radiance, gray());
    dir.sh("color.sh.json", Quantity::Radiance, gray().map(|c| Rgb::new(c, -c, 0.5 * c)));
    for named in NamedConvention::ALL {
        for (input, ending) in [("gray", "npy"), ("gray", "txt"), ("color", "npy"), ("color", "json"), ("color", "txt")]
        {
            let (stdout, stderr) =
                dir.lobe(&format!("sh convert {input}.sh.json --to {named} -o numbers.{ending}")).succeeds();
            assert_eq!((stdout.as_str(), stderr.as_str()), ("", ""), "{named}, {ending}");
            dir.lobe(&format!("sh convert numbers.{ending} --from {named} -o back.sh.json")).succeeds();
            let (back, given) = (dir.read_sh("back.sh.json"), dir.read_sh(&format!("{input}.sh.json")));
            let error = worst(&back.coefficients, &given.coefficients);
            assert!(error < 1e-14 && back.quantity == Quantity::Radiance, "{named}, {input}, {ending}: {error}");
            let is_gray = matches!(back.coefficients, FileCoefficients::Scalar(_));
            assert_eq!(is_gray, input == "gray", "{named}: channels of {input}.{ending}");
        }
    }
}

#[test]
fn numbers_are_text_on_stdout_and_are_read_from_stdin() {
    let dir = Dir::new();
    dir.sh("f.sh.json", Quantity::Function, ShVec::from_vec(vec![1.0, 0.5, 0.25, -0.5]).unwrap());
    let (text, _) = dir.lobe("sh convert f.sh.json --to sphericart").succeeds();
    // Without the phase the functions of odd m turn around.
    assert_eq!(text, "1.0\n-0.5\n0.25\n0.5\n", "text");
    let (back, _) = dir.lobe("sh convert - --from sphericart --quantity function -o -").stdin(text).succeeds();
    assert_eq!(back.as_bytes(), dir.bytes("f.sh.json"), "the same file");
    let (piped, _) = dir.lobe("sh convert - --to ambix -o -").stdin(back).succeeds();
    assert_eq!(piped.lines().count(), 4, "{piped}");
}

#[test]
fn what_cannot_be_converted_is_said_in_one_line() {
    let dir = Dir::new();
    dir.sh("five.sh.json", Quantity::Radiance, ShVec::<f64>::zero(5));
    dir.sh("high.sh.json", Quantity::Radiance, ShVec::<f64>::zero(90));
    dir.file("not-real.txt", "1 0\n2 0.5\n3 0\n");
    dir.file("nan.txt", "1\nnan\n3\n4\n");
    dir.file("cut.npy", b"\x93NUMPY\x01\x00v\x00{'descr'");
    dir.file("count.txt", "1\n2\n3\n");
    for (arguments, said) in [
        (
            "five.sh.json --to fuma",
            "five.sh.json: fuma: expected order 1 to 4 (degree 0 to 3), found order 5; FuMa has",
        ),
        ("high.sh.json --to pyshtools-unnormalized", "expected order 1 to 86 (degree 0 to 85), found order 90"),
        (
            "five.sh.json --to ambix -o five.sh.json",
            "--to writes the numbers of a library; name it .npy, .json or .txt",
        ),
        ("five.sh.json --to ambix -o a.exr", "-o: expected a name that ends in .npy, .json or .txt, found a.exr"),
        (
            "not-real.txt --from healpy -o a.sh.json",
            "not-real.txt: healpy: l = 1, m = 0: expected a real number, found",
        ),
        ("nan.txt --from ambix -o a.sh.json", "nan.txt: line 2: expected a finite number, found \"nan\""),
        ("cut.npy --from ambix -o a.sh.json", "cut.npy: the file is cut off in its header"),
        ("count.txt --from ambix -o a.sh.json", "count.txt: 3 numbers are of no order: ambix has [1, 4, 9, 16], .."),
        ("count.txt --from ambix", "-o: expected a .sh.json file, or - for stdout"),
        ("count.txt --from ambix -o a.npy", "a.npy: an expansion is written as .sh.json"),
        ("none.npy --from ambix -o a.sh.json", "none.npy: no such file"),
        ("five.sh.json --to mathematica", "pyshtools, pyshtools-phase"),
        ("five.sh.json --to ambix --from ambix", "cannot be used with"),
        ("five.sh.json", "required arguments were not provided"),
    ] {
        let found = dir.lobe(&format!("sh convert {arguments}")).error();
        assert!(found.contains(said), "{arguments}: {found}");
    }
    assert!(!dir.path("a.sh.json").exists(), "nothing is written");
}
