//! Files of fields: what is written is read, and damage is told in one line.

use lobe_io::Job;
use lobe_prt::{CompressOptions, WeightBits};
use lobe_shadow::{FieldOptions, FieldStorage, OcclusionField, bake_field, read_field, read_field_bytes, write_field};

use crate::shapes::rabbit;

fn field() -> OcclusionField {
    let options = FieldOptions::default().order(3).spheres(6).cells(4).rays(128);
    bake_field(&rabbit(), &options, Job::default()).unwrap().0
}

fn storages() -> [(&'static str, FieldStorage, f64); 5] {
    let clusters = CompressOptions::default().clusters(4).components(6).iterations(4);
    [
        ("f32", FieldStorage::F32, 0.0),
        ("f16", FieldStorage::F16, 3e-4),
        ("u8", FieldStorage::U8, 8e-3),
        ("clustered", FieldStorage::Clustered(clusters), 5e-2),
        ("clustered, u8", FieldStorage::Clustered(clusters.weights(WeightBits::U8)), 5e-2),
    ]
}

#[test]
fn every_storage_is_read_back_within_the_error_it_reports() {
    let (folder, field) = (tempfile::tempdir().unwrap(), field());
    let path = folder.path().join("f.field.safetensors");
    let mut sizes = Vec::new();
    for (name, storage, bound) in storages() {
        let report = write_field(&path, &field, &storage).unwrap();
        let back = read_field(&path).unwrap();
        assert_eq!((back.grid(), back.order()), (field.grid(), field.order()), "{name}");
        let (mut errors, mut squares) = (0.0, 0.0);
        for (a, b) in back.rows().iter().zip(field.rows()) {
            errors += (f64::from(*a) - f64::from(*b)).powi(2);
            squares += f64::from(*b).powi(2);
        }
        let error = (errors / squares).sqrt();
        assert!((error - report.relative_error).abs() < 1e-9, "{name}: {error}, reported {report:?}");
        assert!(error <= bound, "{name}: {error}, expected at most {bound}");
        assert_eq!(report.bytes_before, field.bytes(), "{name}");
        let file = std::fs::metadata(&path).unwrap().len() as usize;
        assert!((report.bytes..report.bytes + 1500).contains(&file), "{name}: {file} bytes of the file, {report:?}");
        sizes.push(report.bytes);
        let first = std::fs::read(&path).unwrap();
        write_field(&path, &field, &storage).unwrap();
        assert!(std::fs::read(&path).unwrap() == first, "{name}: the same bytes again");
    }
    assert!(sizes[0] == 2 * sizes[1] && sizes[2] < sizes[1] && sizes[4] < sizes[3], "bytes: {sizes:?}");
}

/// The file with another text in its header, of the same length.
fn with(bytes: &[u8], from: &str, to: &str) -> Vec<u8> {
    assert_eq!(from.len(), to.len(), "the header keeps its length");
    let at = bytes.windows(from.len()).position(|w| w == from.as_bytes()).unwrap_or_else(|| panic!("no {from}"));
    [&bytes[..at], to.as_bytes(), &bytes[at + from.len()..]].concat()
}

#[test]
fn damaged_files_are_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("f.field.safetensors");
    let bytes_of = |storage: &FieldStorage| {
        write_field(&path, &field(), storage).unwrap();
        std::fs::read(&path).unwrap()
    };
    let refusal = |bytes: &[u8]| {
        let message = read_field_bytes(bytes, "f.field").map(drop).unwrap_err().to_string();
        assert!(message.starts_with("f.field: ") && !message.contains('\n'), "{message}");
        message
    };
    for (name, storage, _) in storages() {
        let whole = bytes_of(&storage);
        for end in (0..whole.len()).step_by(97) {
            assert!(refusal(&whole[..end]).contains("expected safetensors"), "{name}, cut off after {end}");
        }
    }
    let whole = bytes_of(&FieldStorage::F32);
    for (from, to, expected) in [
        ("lobe-occlusion-field", "lobe-occlusion-farms", "expected lobe-occlusion-field, found lobe-occlusion-farms"),
        (r#"\"version\":2"#, r#"\"version\":3"#, "found 3; take a Lobe as new as the file"),
        (
            r#"\"version\":2"#,
            r#"\"version\":1"#,
            "expected version 2 of lobe-occlusion-field, found 1; bake the field anew",
        ),
        (r#"\"order\":3"#, r#"\"order\":4"#, "expected a tensor rows of shape [151, 20]"),
        (r#"\"order\":3"#, r#"\"order\":0"#, "expected an order of 1 to 8, found 0"),
        (r#"\"spheres\":6"#, r#"\"spheres\":1"#, "expected 2 spheres or more"),
        (r#"\"spheres\":6"#, r#"\"spheres\":7"#, "expected a tensor rows of shape [176, 12]"),
        (r#"\"cells\":4"#, r#"\"cells\":3"#, "an even number of cells"),
        (r#"\"outer\":8.0"#, r#"\"outer\":0.1"#, "expected spheres that rise"),
        (r#"\"storage\":\"f32\""#, r#"\"storage\":\"f64\""#, "expected storage f32, f16, u8 or clustered"),
        (r#"\"storage\":\"f32\""#, r#"\"storage\":\"f16\""#, "expected a tensor rows of F16"),
        (r#"\"inner\":0.25"#, r#"\"inner\":null"#, "the entry lobe of its metadata is wrong"),
    ] {
        let message = refusal(&with(&whole, from, to));
        assert!(message.contains(expected), "{from}: {message}");
    }
    let mut nan = whole.clone();
    let end = nan.len();
    nan[end - 4..].copy_from_slice(&f32::NAN.to_le_bytes());
    assert!(refusal(&nan).contains("expected finite coefficients, found NaN at point 150"), "{}", refusal(&nan));
    let mut broken = bytes_of(&FieldStorage::U8);
    let at = broken.windows(8).rposition(|w| w == b"\"ranges\"".as_slice());
    assert!(at.is_some(), "the ranges have a name");
    let ranges = {
        let header = u64::from_le_bytes(broken[..8].try_into().unwrap()) as usize;
        // Tensors of larger numbers come first.
        8 + header
    };
    broken[ranges..ranges + 4].copy_from_slice(&f32::INFINITY.to_le_bytes());
    assert!(refusal(&broken).contains("expected finite coefficients"), "{}", refusal(&broken));
    let other = lobe_scene_of_nothing();
    assert!(refusal(&other).contains("found none of Lobe's"), "{}", refusal(&other));
    let missing = read_field(folder.path().join("none")).unwrap_err().to_string();
    assert!(missing.contains("none: "), "{missing}");
}

/// Safetensors without metadata.
fn lobe_scene_of_nothing() -> Vec<u8> {
    let json = b"{}      ";
    [&(json.len() as u64).to_le_bytes()[..], json].concat()
}

#[test]
fn fields_of_wrong_parts_are_refused() {
    let field = field();
    let grid = *field.grid();
    for (found, expected) in [
        (OcclusionField::new(grid, 0, vec![]), "an order of 1 to 8, found 0"),
        (
            OcclusionField::new(grid, 3, field.rows()[1..].to_vec()),
            "expected 12 numbers for each of 151 points, found 1811",
        ),
        (OcclusionField::new(grid, 3, vec![f32::INFINITY; 1812]), "found inf at point 0"),
        (field.truncated(4), "expected an order of 1 to 3, which the field has, found 4"),
        (field.truncated(0), "found 0"),
    ] {
        let message = found.map(drop).unwrap_err().to_string();
        assert!(message.contains(expected) && !message.contains('\n'), "{message}");
    }
}

#[test]
fn clusters_keep_the_spheres_far_away_as_well_as_those_near_by() {
    let options = FieldOptions::default().spheres(8).cells(8).rays(512);
    let field = bake_field(&rabbit(), &options, Job::default()).unwrap().0;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("f.field.safetensors");
    let clusters = CompressOptions::default().clusters(64).components(4);
    write_field(&path, &field, &FieldStorage::Clustered(clusters)).unwrap();
    let back = read_field(&path).unwrap();
    let of_sphere = 9 * 9 * (4 + 16);
    let errors: Vec<f64> = (0..8)
        .map(|sphere| {
            let rows = sphere * of_sphere..(sphere + 1) * of_sphere;
            let pairs = back.rows()[rows.clone()].iter().zip(&field.rows()[rows]);
            let (errors, squares) = pairs.fold((0.0, 0.0), |(errors, squares), (a, b)| {
                (errors + f64::from(a - b).powi(2), squares + f64::from(*b).powi(2))
            });
            (errors / squares).sqrt()
        })
        .collect();
    let [near, far] = [&errors[..4], &errors[4..]].map(|part| part.iter().copied().fold(0.0, f64::max));
    assert!(far < 0.04 && far < near, "of each sphere: {errors:?}");
}
