//! Files of sphere sets, whole and damaged.

use std::fs;

use lobe_shadow::{Skin, SphereSet, read_spheres, read_spheres_bytes, write_spheres};

fn set() -> SphereSet {
    let set = SphereSet::new(vec![[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]], vec![0.5, 0.0]).unwrap();
    let skin = Skin::new(vec![[1, 2, 0, 0], [7, 0, 0, 0]], vec![[0.1, 0.7, 0.0, 0.3], [1.0, 0.0, 0.0, 0.0]]).unwrap();
    set.with_skin(skin).unwrap()
}

fn bytes_of(set: &SphereSet) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.spheres.safetensors");
    write_spheres(&path, set).unwrap();
    assert_eq!(&read_spheres(&path).unwrap(), set, "read back");
    fs::read(path).unwrap()
}

/// The message for a file with a text of its header replaced, the header's length put right.
fn changed(file: &[u8], from: &str, to: &str) -> String {
    let length = u64::from_le_bytes(file[..8].try_into().unwrap()) as usize;
    let header = String::from_utf8(file[8..8 + length].to_vec()).unwrap();
    assert!(header.contains(from), "{header} has {from}");
    let header = header.replace(from, to);
    let mut bad = (header.len() as u64).to_le_bytes().to_vec();
    bad.extend(header.as_bytes());
    bad.extend(&file[8 + length..]);
    read_spheres_bytes(&bad, "s").unwrap_err().to_string()
}

#[test]
fn what_is_written_is_read_and_has_the_same_bytes_each_time() {
    assert_eq!(bytes_of(&set()), bytes_of(&set()), "written twice");
    bytes_of(&SphereSet::default());
    let plain = SphereSet::new(vec![[1.0; 3]], vec![0.0]).unwrap();
    assert!(read_spheres_bytes(&bytes_of(&plain), "s").unwrap().skin().is_none(), "no joints");
}

#[test]
fn files_keep_the_point_from_which_centers_count() {
    let far = set().with_origin([1e7 + 0.1, 0.0, -3.5]).unwrap();
    let file = bytes_of(&far);
    let read = read_spheres_bytes(&file, "s").unwrap();
    assert_eq!((read.origin(), read.center(1)), ([1e7 + 0.1, 0.0, -3.5], [1e7 + 3.1, 4.0, 1.5]), "in the mesh's frame");
    let message = changed(&file, "10000000.1,", "\\\"a\\\",");
    assert!(message.starts_with("s: ") && !message.contains('\n'), "{message}");
    assert!(set().with_origin([f64::NAN; 3]).is_err(), "no point");
}

#[test]
fn files_written_before_they_had_one_count_from_zero() {
    let file = bytes_of(&set());
    let length = u64::from_le_bytes(file[..8].try_into().unwrap()) as usize;
    let header = String::from_utf8(file[8..8 + length].to_vec()).unwrap();
    let without = header.replace(r#",\"origin\":[0.0,0.0,0.0]"#, "");
    assert!(without.len() < header.len(), "{header} has an origin");
    let old = [&(without.len() as u64).to_le_bytes()[..], without.as_bytes(), &file[8 + length..]].concat();
    assert_eq!(read_spheres_bytes(&old, "s").unwrap(), set(), "the same set");
}

#[test]
fn damaged_files_are_refused_in_one_line() {
    let file = bytes_of(&set());
    for (from, to, expected) in [
        (
            r#"\"version\":1"#,
            r#"\"version\":2"#,
            "s: expected version 1 of lobe-spheres, found 2; take a Lobe as new as the file",
        ),
        ("lobe-spheres", "lobe-transfer", "s: expected lobe-spheres, found lobe-transfer"),
        ("\"lobe\":", "\"else\":", "s: expected tensors of lobe-spheres, found none of Lobe's"),
        ("\"radii\":{", "\"other\":{", "s: expected a tensor radii, found none"),
        ("\"weights\":{", "\"other\":{", "s: expected a tensor weights, found none"),
        ("[2,3]", "[3,2]", "s: expected a tensor centers of shape [any, 3], found [3, 2]"),
    ] {
        assert_eq!(changed(&file, from, to), expected, "{from} as {to}");
    }
    for (from, to) in [("[2,3]", "[18446744073709551615,3]"), ("{", "["), (r#"\"version\":1"#, r#"\"version\":\"\n\""#)]
    {
        let message = changed(&file, from, to);
        assert!(message.starts_with("s: ") && !message.contains('\n'), "{from} as {to}: {message}");
    }
    let mut endless = file.clone();
    endless[..8].copy_from_slice(&u64::MAX.to_le_bytes());
    let message = read_spheres_bytes(&endless, "s").unwrap_err().to_string();
    assert!(message.starts_with("s: expected safetensors, found "), "{message}");
    for length in 0..file.len() {
        assert!(read_spheres_bytes(&file[..length], "s").is_err(), "cut off after {length} bytes");
    }
}

#[test]
fn numbers_that_are_no_sphere_are_refused() {
    let file = bytes_of(&SphereSet::new(vec![[7.0; 3]], vec![0.25]).unwrap());
    let with = |from: f32, to: f32| {
        let from = from.to_le_bytes();
        let at = file.windows(4).position(|bytes| bytes == from).unwrap();
        let mut bad = file.clone();
        bad[at..at + 4].copy_from_slice(&to.to_le_bytes());
        read_spheres_bytes(&bad, "s").unwrap_err().to_string()
    };
    assert_eq!(with(0.25, -1.0), "s: expected finite radii of at least 0, found -1 at sphere 0", "negative");
    assert_eq!(with(0.25, f32::NAN), "s: expected finite radii of at least 0, found NaN at sphere 0", "no number");
    assert_eq!(with(7.0, f32::INFINITY), "s: expected finite centers, found [inf, 7.0, 7.0] at sphere 0", "infinite");
}
