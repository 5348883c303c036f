//! Files of sphere sets, whole and damaged.

use std::fs;

use lobe_shadow::{Skeleton, Skin, SphereSet, read_spheres, read_spheres_bytes, write_spheres};

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
fn files_keep_the_entity_and_the_names_of_its_joints() {
    let names = (0..8).map(|j| (j != 4).then(|| format!("joint \"{j}\"\n"))).collect();
    let bound = set().with_skeleton(Skeleton::new(Some("figure".to_owned()), 3, names)).unwrap();
    let file = bytes_of(&bound);
    let unnamed = set().with_skeleton(Skeleton::new(None, 0, vec![None; 7])).unwrap();
    bytes_of(&unnamed);
    let without = bytes_of(&set());
    assert!(!String::from_utf8_lossy(&without).contains("skeleton"), "nothing of a set that is bound to no entity");
    for (from, to, expected) in [
        (r#"\"node\":3"#, r#"\"node\":-3"#, "s: "),
        (r#"\"node\":3"#, r#"\"nodes\":3"#, "s: "),
        (r#",null,"#, r#",7,"#, "s: "),
        (
            r#"\"joints\":["#,
            r#"\"other\":["#,
            "s: expected joints of `figure`, which has 0, found number 1 at sphere 0",
        ),
    ] {
        let message = changed(&file, from, to);
        assert!(message.starts_with(expected) && !message.contains('\n'), "{from} as {to}: {message}");
    }
}

#[test]
fn weights_that_do_not_sum_to_one_are_refused() {
    let file = bytes_of(&set());
    let weight = 1.0_f32.to_le_bytes();
    let at = file.windows(4).rposition(|bytes| bytes == weight).unwrap();
    let with = |weight: f32| {
        let mut other = file.clone();
        other[at..at + 4].copy_from_slice(&weight.to_le_bytes());
        read_spheres_bytes(&other, "s")
    };
    assert_eq!(with(1.0).unwrap(), set(), "as it was");
    for off in [0.5, 0.999, 1.001, 4.0] {
        let expected = format!("s: expected weights that sum to 1, found [{off:?}, 0.0, 0.0, 0.0] at sphere 1");
        assert_eq!(with(off).unwrap_err().to_string(), expected, "{off}");
    }
    let rounded = with(0.99995).unwrap();
    assert_eq!(rounded.skin().unwrap().weights()[1], [1.0, 0.0, 0.0, 0.0], "written with few digits: scaled");
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

#[test]
fn more_spheres_than_a_set_has_are_refused_in_one_line() {
    let most = 65_536;
    let whole = SphereSet::new(vec![[0.5; 3]; most], vec![0.5; most]).unwrap();
    let file = bytes_of(&whole);
    let length = u64::from_le_bytes(file[..8].try_into().unwrap()) as usize;
    let mut header = String::from_utf8(file[8..8 + length].to_vec()).unwrap();
    // One more: 12 bytes of a center, and 4 of a radius.
    for bytes in [1, 12, 16] {
        let (from, to) = ((bytes * most).to_string(), (bytes * (most + 1)).to_string());
        assert!(header.contains(&from), "{header} has {from}");
        header = header.replace(&from, &to);
    }
    let numbers = vec![0_u8; 16 * (most + 1)];
    let bytes = [&(header.len() as u64).to_le_bytes()[..], header.as_bytes(), &numbers].concat();
    let message = read_spheres_bytes(&bytes, "s").unwrap_err().to_string();
    assert_eq!(message, "s: expected at most 65536 spheres of a set, found 65537: fit fewer", "said");

    // A file of a terabyte without contents is not read.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.spheres.safetensors");
    fs::File::create(&path).unwrap().set_len(1 << 40).unwrap();
    let message = read_spheres(&path).unwrap_err().to_string();
    assert!(message.contains("expected spheres in a file of at most 67108864 bytes"), "{message}");
}
