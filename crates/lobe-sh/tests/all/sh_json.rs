//! `.sh.json` files: what is written, what is read back, and every file that is refused.

use lobe_sh::basis::MAX_ORDER;
use lobe_sh::expansion::Quantity;
use lobe_sh::sh_json::{ShFile, read_sh_json, read_sh_json_bytes, read_sh_json_from, write_sh_json, write_sh_json_to};
use lobe_sh::{Expansion as _, Rgb, ShError, ShVec};
use lobe_testkit::Random;

fn written(file: &ShFile) -> String {
    let mut bytes = Vec::new();
    write_sh_json_to(&mut bytes, file, "out").unwrap();
    String::from_utf8(bytes).unwrap()
}

fn read(text: &str) -> Result<ShFile, ShError> {
    read_sh_json_bytes(text.as_bytes(), "in")
}

/// The refusal of `text`, which must be one line and name the file.
fn refusal(text: &[u8]) -> String {
    let error = read_sh_json_bytes(text, "in").expect_err("a bad file was read");
    let message = error.to_string();
    assert!(message.starts_with("in: ") && !message.contains('\n'), "not one line with the name: {message:?}");
    message["in: ".len()..].to_owned()
}

/// A file of order 1 with one field replaced.
fn with(field: &str, value: &str) -> String {
    let mut fields = [
        ("format", "\"lobe-sh\""),
        ("version", "1"),
        ("order", "1"),
        ("quantity", "\"radiance\""),
        ("convention", "\"real, orthonormal, Condon-Shortley phase, z up\""),
        ("coefficients", "[[1,2,3]]"),
    ];
    fields.iter_mut().find(|(name, _)| *name == field).unwrap().1 = value;
    format!("{{{}}}", fields.map(|(name, value)| format!("\"{name}\":{value}")).join(","))
}

#[test]
fn a_file_has_its_head_and_then_one_row_a_line() {
    let (first, last) = (Rgb::new(0.1, 1.0, 1e-7), Rgb::new(-0.5, 2e20, 3.0));
    let f = ShVec::from_vec(vec![first, Rgb::default(), Rgb::default(), last]).unwrap();
    let expected = "{\"format\":\"lobe-sh\",\"version\":1,\"order\":2,\"quantity\":\"irradiance\",\
                    \"convention\":\"real, orthonormal, Condon-Shortley phase, z up\",\"coefficients\":[\n\
                    [0.1,1.0,1e-7],\n[0.0,0.0,0.0],\n[0.0,0.0,0.0],\n[-0.5,2e+20,3.0]\n]}\n";
    assert_eq!(written(&ShFile::new(Quantity::Irradiance, f)), expected, "text");
}

#[test]
fn every_f64_up_to_the_largest_survives_a_round_trip_bit_by_bit() {
    let mut random = Random::new(7);
    let mut any = || loop {
        let x = f64::from_bits(random.next_u64());
        if x.abs() <= 1e30 {
            return x;
        }
    };
    for order in [1, 2, 6, MAX_ORDER] {
        let scalar = ShVec::from_vec((0..order * order).map(|_| any()).collect()).unwrap();
        let rgb = ShVec::from_vec((0..order * order).map(|_| Rgb::new(any(), any(), any())).collect()).unwrap();
        for file in [ShFile::new(Quantity::Visibility, scalar), ShFile::new(Quantity::Transfer, rgb)] {
            let text = written(&file);
            let back = read(&text).unwrap();
            assert_eq!(back, file, "order {order}");
            assert_eq!(written(&back), text, "bytes of order {order}");
        }
    }
}

#[test]
fn notes_of_other_tools_white_space_and_a_byte_order_mark_are_accepted() {
    let text = "\u{feff} {\"author\": {\"name\": \"me\"}, \"coefficients\": [ [ 1 , 2.5 , -3e0 ] ], \"order\": 1,\r\n\
                \"version\": 1, \"quantity\": \"log-visibility\", \"format\": \"lobe-sh\"}";
    let f = ShVec::from_vec(vec![Rgb::new(1.0, 2.5, -3.0)]).unwrap();
    assert_eq!(read(text).unwrap(), ShFile::new(Quantity::LogVisibility, f), "content");
}

#[test]
fn a_scalar_file_is_gray_as_color() {
    let file = read(&with("coefficients", "[[2.5]]")).unwrap();
    assert_eq!(file.coefficients.order(), 1, "order");
    assert_eq!(file.coefficients.to_rgb().coefficients(), [Rgb::new(2.5, 2.5, 2.5)], "color");
}

#[test]
fn heads_that_are_wrong_are_refused_with_what_was_expected_and_found() {
    let quantity =
        "\"quantity\": expected one of radiance, irradiance, transfer, visibility, log-visibility, function, found ";
    for (field, value, message) in [
        ("format", "\"gltf\"", "\"format\": expected \"lobe-sh\", found \"gltf\"; is this an expansion?"),
        ("format", "null", "\"format\": expected \"lobe-sh\", found nothing; is this an expansion?"),
        ("version", "2", "\"version\": this Lobe reads version 1, found 2; a newer Lobe may read it"),
        ("version", "\"1\"", "\"version\": expected 1, found \"1\""),
        ("order", "0", "\"order\": expected a whole number from 1 to 256, found 0"),
        ("order", "257", "\"order\": expected a whole number from 1 to 256, found 257"),
        ("order", "-3", "\"order\": expected a whole number from 1 to 256, found -3"),
        ("order", "1.5", "\"order\": expected a whole number from 1 to 256, found 1.5"),
        ("order", "1e300", "\"order\": expected a whole number from 1 to 256, found 1e+300"),
        ("quantity", "\"color\"", &format!("{quantity}\"color\"")),
        ("quantity", "7", &format!("{quantity}7")),
        ("coefficients", "{}", "\"coefficients\": expected an array of rows, found an object"),
        ("coefficients", "null", "\"coefficients\": expected an array of rows, found nothing"),
    ] {
        assert_eq!(refusal(with(field, value).as_bytes()), message, "{field}: {value}");
    }
}

#[test]
fn another_convention_is_refused_with_the_way_to_read_it() {
    let message = refusal(with("convention", "\"ambix\"").as_bytes());
    assert!(message.contains("found \"ambix\"; lobe sh convert --from NAME reads others"), "{message}");
    let without = with("coefficients", "[[1,2,3]]").replace("\"convention\"", "\"note\"");
    assert!(read_sh_json_bytes(without.as_bytes(), "in").is_ok(), "it may be left out");
}

#[test]
fn rows_that_are_wrong_are_refused_with_their_place() {
    let order_2 = |rows: &str| with("coefficients", rows).replace("\"order\":1", "\"order\":2");
    for (text, message) in [
        (with("coefficients", "[]"), "order 1 has 1 rows, found 0"),
        (order_2("[[1],[2],[3]]"), "order 2 has 4 rows, found 3"),
        (order_2("[[1],[2],[3],[4],[5]]"), "order 2 has 4 rows, found 5"),
        (with("coefficients", "[[1,2]]"), "expected an array of 1 or 3 numbers in row 0, found 2"),
        (with("coefficients", "[[]]"), "expected an array of 1 or 3 numbers in row 0, found 0"),
        (with("coefficients", "[5]"), "expected an array of 1 or 3 numbers in row 0, found 5"),
        (with("coefficients", "[[null]]"), "expected an array of 1 or 3 numbers in row 0, found null"),
        (order_2("[[1],[2],[3,3,3],[4]]"), "expected an array of 1 number as in row 0 in row 2, found 3"),
        (order_2("[[1,1,1],[2],[3],[4]]"), "expected an array of 3 numbers as in row 0 in row 1, found 1"),
        (order_2("[[1],[\"x\"],[3],[4]]"), "expected an array of 1 number as in row 0 in row 1, found \"x\""),
    ] {
        assert_eq!(refusal(text.as_bytes()), format!("\"coefficients\": {message}"), "{text}");
    }
}

#[test]
fn text_that_is_no_json_is_refused_with_line_and_column() {
    let good = with("coefficients", "[[1,2,3]]");
    let no_nan = "; JSON has no NaN and no infinity";
    for (text, message) in [
        (String::new(), "expected a .sh.json file, found an empty one".to_owned()),
        (" \n".to_owned(), "the file is cut off: EOF while parsing a value at line 2 column 0".to_owned()),
        ("hello".to_owned(), "expected a .sh.json file, which begins with {; this is something else".to_owned()),
        (format!("[{good}]"), "expected a .sh.json file, which begins with {; this is something else".to_owned()),
        (format!("{good}]"), "not valid JSON: trailing characters at line 1 column 152".to_owned()),
        (with("order", "1,\"order\":1"), "not an expansion: duplicate field `order` at line 1 column 49".to_owned()),
        (with("coefficients", "[[1,NaN,3]]"), format!("not valid JSON: expected value at line 1 column 146{no_nan}")),
        (with("coefficients", "[[1,1e999,3]]"), "not valid JSON: number out of range at line 1 column 150".to_owned()),
    ] {
        assert_eq!(refusal(text.as_bytes()), message, "{text}");
    }
}

#[test]
fn a_file_cut_off_anywhere_is_refused() {
    let text = written(&ShFile::new(Quantity::Radiance, ShVec::constant(2, Rgb::new(1.0, 2.0, 3.0))));
    for end in 1..text.len() - 2 {
        let message = refusal(&text.as_bytes()[..end]);
        assert!(message.starts_with("the file is cut off: EOF while parsing"), "cut at {end}: {message}");
    }
}

#[test]
fn files_of_other_kinds_are_named() {
    for (bytes, part) in [
        (&b"\x76\x2F\x31\x01\x02\0\0\0"[..], "an OpenEXR picture; project it first"),
        (b"#?RADIANCE\n", "a Radiance picture; project it first"),
        (b"\x89PNG\r\n", "a PNG picture"),
        (b"\xFF\xFE{\0", "text in UTF-16; save it as UTF-8"),
    ] {
        let message = refusal(bytes);
        assert!(message.starts_with("expected a .sh.json file, found ") && message.contains(part), "{message}");
    }
}

#[test]
fn a_list_longer_than_any_is_refused_before_it_takes_memory() {
    let rows = "[0],".repeat(4 * 256 * 256);
    let text =
        format!(r#"{{"format":"lobe-sh","version":1,"order":2,"quantity":"radiance","coefficients":[{rows}[0]]}}"#);
    assert_eq!(refusal(text.as_bytes()), "expected at most 256² rows of up to three numbers, found more", "rows");
}

#[test]
fn an_endless_file_is_not_read_to_its_end() {
    let error = read_sh_json_from(std::io::repeat(b' '), "in").unwrap_err().to_string();
    assert_eq!(error, "in: expected a .sh.json file of at most 33554432 bytes, found a longer one", "endless blanks");
}

#[test]
fn messages_stay_short_whatever_the_file_says() {
    for field in ["format", "version", "order", "quantity", "convention", "coefficients"] {
        let message = refusal(with(field, &format!("\"{}\"", "long\\n".repeat(10_000))).as_bytes());
        assert!(message.len() < 200 && message.contains("found \"long"), "{field}: {message}");
    }
}

#[test]
fn damaged_files_are_read_or_refused_in_one_line() {
    let good = with("coefficients", "[[1,2,3]]").into_bytes();
    let mut random = Random::new(11);
    let mut refused = 0;
    for _ in 0..20_000 {
        let mut bytes = good.clone();
        for _ in 0..1 + random.next_u64() % 3 {
            let place = (random.next_u64() % bytes.len() as u64) as usize;
            bytes[place] = (random.next_u64() % 256) as u8;
        }
        if let Err(error) = read_sh_json_bytes(&bytes, "in") {
            let message = error.to_string();
            assert!(!message.contains('\n'), "{message:?} for {:?}", String::from_utf8_lossy(&bytes));
            refused += 1;
        }
    }
    assert!(refused > 10_000, "only {refused} of 20000 damaged files were refused");
}

#[test]
fn deep_nesting_is_refused() {
    let message = refusal(with("coefficients", &"[".repeat(100_000)).as_bytes());
    assert!(message.contains("recursion limit exceeded at line 1"), "{message}");
}

#[test]
fn what_a_file_cannot_hold_is_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.sh.json");
    for (f, part) in [
        (ShVec::from_vec(vec![1.0, f64::NAN, 0.0, 0.0]).unwrap(), "coefficient 1 is NaN"),
        (ShVec::zero(0), "this one has order 0"),
        (ShVec::zero(MAX_ORDER + 1), "this one has order 257"),
    ] {
        let error = write_sh_json(&path, &ShFile::new(Quantity::Radiance, f)).unwrap_err();
        assert!(matches!(&error, ShError::Options(m) if m.contains(part)), "{error}");
        assert!(!path.exists(), "{part}: a file was made");
    }
}

#[test]
fn a_missing_file_is_an_io_error_with_its_name() {
    let error = read_sh_json(std::path::Path::new("none/here.sh.json")).unwrap_err();
    assert!(matches!(error, ShError::Io { .. }), "{error:?}");
    assert!(error.to_string().starts_with("none/here.sh.json: "), "{error}");
}
