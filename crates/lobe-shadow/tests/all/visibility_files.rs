//! Files of the visibility of surfaces: what is written is read, and damage is told in one line.

use lobe_prt::CompressOptions;
use lobe_shadow::{FieldStorage, SurfaceVisibility, read_visibility, read_visibility_bytes, write_visibility};
use lobe_testkit::Random;

fn visibility() -> SurfaceVisibility {
    let mut random = Random::new(8);
    SurfaceVisibility::new(3, (0..9 * 200).map(|_| random.signed() as f32).collect()).unwrap()
}

#[test]
fn visibility_that_is_written_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("v.visibility.safetensors");
    let clustered = FieldStorage::Clustered(CompressOptions::default().clusters(4).components(9).iterations(2));
    for (storage, most) in
        [(FieldStorage::F32, 0.0), (FieldStorage::F16, 5e-4), (FieldStorage::U8, 8e-3), (clustered, 1e-2)]
    {
        let report = write_visibility(&path, &visibility(), &storage).unwrap();
        let back = read_visibility(&path).unwrap();
        assert_eq!((back.order(), back.points()), (3, 200), "{storage:?}");
        let off = back.rows().iter().zip(visibility().rows()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(f64::from(off) <= most && report.largest_error <= most, "{storage:?}: off by {off}, {report:?}");
    }
}

#[test]
fn each_row_has_its_position_where_positions_are_given() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("v.visibility.safetensors");
    let positions: Vec<[f32; 3]> = (0..200).map(|k| [k as f32, -0.5, 2.0]).collect();
    let placed = visibility().with_positions(positions.clone()).unwrap();
    for storage in [FieldStorage::F32, FieldStorage::U8] {
        write_visibility(&path, &placed, &storage).unwrap();
        assert_eq!(read_visibility(&path).unwrap().positions(), Some(&*positions), "{storage:?}");
        write_visibility(&path, &visibility(), &storage).unwrap();
        assert_eq!(read_visibility(&path).unwrap().positions(), None, "a file without, {storage:?}");
    }
    for (bad, message) in
        [(vec![[0.0; 3]; 199], "expected 200 positions, found 199"), (vec![[f32::NAN; 3]; 200], "expected finite")]
    {
        let error = visibility().with_positions(bad).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    }
}

#[test]
fn damaged_visibility_is_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("v.visibility.safetensors");
    write_visibility(&path, &visibility(), &FieldStorage::F32).unwrap();
    let whole = std::fs::read(&path).unwrap();
    let refusal = |bytes: &[u8]| {
        let message = read_visibility_bytes(bytes, "v").unwrap_err().to_string();
        assert!(message.starts_with("v: ") && !message.contains('\n'), "{message}");
        message
    };
    for end in (0..whole.len()).step_by(97) {
        assert!(refusal(&whole[..end]).contains("expected safetensors"), "cut off after {end}");
    }
    let with = |from: &str, to: &str| {
        let at = whole.windows(from.len()).position(|w| w == from.as_bytes()).unwrap_or_else(|| panic!("no {from}"));
        [&whole[..at], to.as_bytes(), &whole[at + from.len()..]].concat()
    };
    for (from, to, expected) in [
        ("lobe-visibility", "lobe-visibilitx", "expected lobe-visibility, found lobe-visibilitx"),
        (r#"\"order\":3"#, r#"\"order\":9"#, "an order of 1 to 8, found 9"),
        (r#"\"order\":3"#, r#"\"order\":2"#, "expected a tensor rows of shape [200, 4]"),
        (r#"\"storage\":\"f32\""#, r#"\"storage\":\"f33\""#, "expected storage f32, f16, u8 or clustered"),
    ] {
        let message = refusal(&with(from, to));
        assert!(message.contains(expected), "{from}: {message}");
    }
    let mut nan = whole.clone();
    let end = nan.len();
    nan[end - 4..].copy_from_slice(&f32::NAN.to_le_bytes());
    assert!(refusal(&nan).contains("expected finite"), "{}", refusal(&nan));
    assert!(SurfaceVisibility::new(3, vec![0.0; 10]).is_err(), "a part of a point");
    assert!(SurfaceVisibility::new(0, Vec::new()).is_err(), "no bands");
}
