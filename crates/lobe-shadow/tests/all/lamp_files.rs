//! Files of lamps: what is written is read, sequences turn with time, and damage is told in one line.

use std::ops::ControlFlow;

use lobe_io::{Job, Progress};
use lobe_prt::CompressOptions;
use lobe_sh::Rgb;
use lobe_shadow::{
    FieldStorage, Lamp, LampSequence, PatchField, RadialInterpolation, RadianceField, RadianceOptions, Rectangle,
    read_lamp, read_lamp_bytes, write_lamp,
};

fn patches() -> PatchField {
    let rectangle = Rectangle { corner: [-0.5, -0.5, 0.0], u: [1.0, 0.0, 0.0], v: [0.0, 1.0, 0.0], two_sided: false };
    let options = RadianceOptions::default().order(3).spheres(4).cells(4);
    PatchField::bake(&rectangle, [2, 1], &options, Job::default()).unwrap()
}

fn lamps() -> [(&'static str, Lamp); 3] {
    let (red, blue) = (Rgb::new(2.0, 0.0, 0.0), Rgb::new(0.0, 0.0, 1.0));
    let narrow = |c: Rgb<f64>| Rgb::from(c.to_array().map(|c| c as f32));
    let pictures = vec![vec![narrow(red), narrow(blue)], vec![narrow(blue), narrow(red)]];
    [
        ("ball", Lamp::Still(RadianceField::ball(3, [1.0, 2.0, 3.0], 0.5, red).unwrap())),
        ("rectangle", Lamp::Still(patches().with_colors(&[red, blue]).unwrap())),
        ("sequence", Lamp::Sequence(LampSequence::new(patches(), pictures, 2.0).unwrap())),
    ]
}

fn light(lamp: &Lamp, time: f64) -> Vec<Rgb<f32>> {
    lamp.at(time).unwrap().radiance_at([0.4, 0.2, 1.5], RadialInterpolation::Linear).into_vec()
}

#[test]
fn a_lamp_that_is_written_is_read_with_the_same_light() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("l.lamp.safetensors");
    for (name, lamp) in lamps() {
        write_lamp(&path, &lamp, &FieldStorage::F32).unwrap();
        let back = read_lamp(&path).unwrap();
        assert_eq!(back.order(), 3, "{name}");
        for time in [0.0, 0.6] {
            assert_eq!(light(&back, time), light(&lamp, time), "{name} at {time} s");
            let surface = |lamp: &Lamp| lamp.at(time).unwrap().surface();
            assert_eq!(surface(&back), surface(&lamp), "{name} at {time} s: what shines");
        }
        let first = std::fs::read(&path).unwrap();
        write_lamp(&path, &lamp, &FieldStorage::F32).unwrap();
        assert!(std::fs::read(&path).unwrap() == first, "{name}: the same bytes again");
    }
}

#[test]
fn a_sequence_shows_one_picture_after_the_other_and_begins_anew() {
    let [_, (_, still), (_, sequence)] = lamps();
    let [first, second] = [light(&sequence, 0.0), light(&sequence, 0.5)];
    assert!(first != second, "the pictures differ");
    assert_eq!(first, light(&still, 0.0), "the first picture is that of the lamp that stands");
    for (time, expected) in [(0.49, &first), (0.99, &second), (1.0, &first), (-0.1, &second), (1e15, &first)] {
        assert_eq!(&light(&sequence, time), expected, "at {time} s");
    }
    assert!(sequence.at(f64::INFINITY).unwrap_err().to_string().contains("a finite time"), "no time");
}

/// The file with another text in its header, of the same length.
fn with(bytes: &[u8], from: &str, to: &str) -> Vec<u8> {
    assert_eq!(from.len(), to.len(), "the header keeps its length");
    let at = bytes.windows(from.len()).position(|w| w == from.as_bytes()).unwrap_or_else(|| panic!("no {from}"));
    [&bytes[..at], to.as_bytes(), &bytes[at + from.len()..]].concat()
}

#[test]
fn damaged_lamps_are_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("l.lamp.safetensors");
    let files = lamps().map(|(_, lamp)| {
        write_lamp(&path, &lamp, &FieldStorage::F32).unwrap();
        std::fs::read(&path).unwrap()
    });
    let refusal = |bytes: &[u8]| {
        let message = read_lamp_bytes(bytes, "l.lamp").map(drop).unwrap_err().to_string();
        assert!(message.starts_with("l.lamp: ") && !message.contains('\n'), "{message}");
        message
    };
    for whole in &files {
        for end in (0..whole.len()).step_by(97) {
            assert!(refusal(&whole[..end]).contains("expected safetensors"), "cut off after {end}");
        }
    }
    for (k, from, to, expected) in [
        (0, "lobe-lamp", "lobe-lump", "expected lobe-lamp, found lobe-lump"),
        (0, r#"\"version\":2"#, r#"\"version\":1"#, "found 1; make the lamp anew"),
        (0, r#"\"version\":2"#, r#"\"version\":3"#, "found 3; take a Lobe as new as the file"),
        (0, r#"\"order\":3"#, r#"\"order\":9"#, "an order of 1 to 8, found 9"),
        (0, r#"\"radius\":0.5"#, r#"\"radius\":0.0"#, "radius above 0"),
        (0, r#"\"shape\":\"ball\""#, r#"\"shape\":\"bulb\""#, "the entry lobe of its metadata is wrong"),
        (1, r#"\"spheres\":4"#, r#"\"spheres\":5"#, "expected a tensor rows of shape [126, 3, 12]"),
        (2, r#"\"patches\":[2,1]"#, r#"\"patches\":[1,1]"#, "expected a tensor patches of shape [1, 101, 12]"),
        (2, r#"\"patches\":[2,1]"#, r#"\"patches\":[2,0]"#, "expected 1 to 64 patches along each side"),
        (2, r#"\"pictures\":2"#, r#"\"pictures\":3"#, "expected a tensor radiance of shape [3, 2, 3]"),
        (2, r#"\"per_second\":2.0"#, r#"\"per_second\":0.0"#, "pictures in a second above 0"),
    ] {
        let message = refusal(&with(&files[k], from, to));
        assert!(message.contains(expected), "{from}: {message}");
    }
    for whole in &files[1..] {
        let mut nan = whole.clone();
        let end = nan.len();
        nan[end - 4..].copy_from_slice(&f32::NAN.to_le_bytes());
        assert!(refusal(&nan).contains("expected finite"), "{}", refusal(&nan));
    }
}

#[test]
fn light_that_has_no_single_precision_is_refused() {
    let patches = patches();
    for found in [
        RadianceField::ball(3, [0.0; 3], 1.0, Rgb::new(1e300, 0.0, 0.0)).map(drop),
        patches.with_colors(&[Rgb::new(1e300, 0.0, 0.0); 2]).map(drop),
        patches.with_colors(&[Rgb::new(3e38, 0.0, 0.0); 2]).map(drop),
    ] {
        let message = found.unwrap_err().to_string();
        assert!(message.contains("finite") && !message.contains('\n'), "{message}");
    }
}

#[test]
fn lamps_in_fewer_bytes_shine_nearly_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("l.lamp.safetensors");
    let clustered = FieldStorage::Clustered(CompressOptions::default().clusters(4).components(5).iterations(4));
    // The part of the bytes of single precision, and the largest relative error, of all numbers and of the light at a point.
    for (storage, part, most) in [
        (FieldStorage::F32, 1.0, 0.0),
        (FieldStorage::F16, 0.5, 5e-4),
        (FieldStorage::U8, 0.3, 1e-2),
        (clustered, 0.6, 0.1),
    ] {
        for (name, lamp) in lamps() {
            let report = write_lamp(&path, &lamp, &storage).unwrap();
            let back = read_lamp(&path).unwrap();
            if name == "ball" {
                assert_eq!((report.bytes, light(&back, 0.0)), (0, light(&lamp, 0.0)), "a ball has no numbers");
                continue;
            }
            assert!(report.bytes as f64 <= part * report.bytes_before as f64, "{name} in {storage:?}: {report:?}");
            assert!(report.relative_error <= most, "{name} in {storage:?}: {report:?}");
            assert_eq!(report.relative_error == 0.0, storage == FieldStorage::F32, "{name} in {storage:?}: {report:?}");
            let expected = light(&lamp, 0.6);
            let brightest = expected.iter().flat_map(|c| c.to_array()).fold(0.0_f32, |most, c| most.max(c.abs()));
            for (a, b) in light(&back, 0.6).iter().zip(&expected) {
                let off = a.to_array().iter().zip(b.to_array()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                assert!(off <= most as f32 * brightest, "{name} in {storage:?}: off by {off} of {brightest}");
            }
        }
    }
}

#[test]
fn an_unknown_storage_of_a_lamp_is_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("l.lamp.safetensors");
    let [_, (_, lamp), _] = lamps();
    write_lamp(&path, &lamp, &FieldStorage::F16).unwrap();
    let bytes = with(&std::fs::read(&path).unwrap(), r#"storage\":\"f16\""#, r#"storage\":\"f61\""#);
    let message = read_lamp_bytes(&bytes, "l.lamp").map(drop).unwrap_err().to_string();
    assert_eq!(message, "l.lamp: expected storage f32, f16, u8 or clustered, found \"f61\"", "said");
}

#[test]
fn a_lamp_whose_bake_was_stopped_goes_on_to_the_same_numbers() {
    let rectangle = Rectangle { corner: [-0.5, -0.5, 0.0], u: [1.0, 0.0, 0.0], v: [0.0, 1.0, 0.0], two_sided: true };
    let options = RadianceOptions::default().order(4).spheres(8).cells(8);
    let bake = |job: Job<'_>| PatchField::bake(&rectangle, [4, 4], &options, job);
    let whole = bake(Job::default()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("l.checkpoint");
    let mut stop =
        |progress: &Progress| if progress.done > 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    let stopped = bake(Job::default().watched_by(&mut stop).kept_in(&path)).unwrap_err();
    assert!(matches!(stopped, lobe_shadow::ShadowError::Cancelled), "{stopped}");
    let mut resumed = 0;
    let mut watch = |progress: &Progress| {
        resumed = progress.resumed;
        ControlFlow::Continue(())
    };
    let found = bake(Job::default().watched_by(&mut watch).kept_in(&path)).unwrap();
    assert!(resumed > 0, "what was done is taken up");
    assert_eq!(found, whole, "as without a stop");
    let other = PatchField::bake(&rectangle, [4, 2], &options, Job::default().kept_in(&path)).unwrap_err().to_string();
    assert!(other.contains("l.checkpoint") && !other.contains('\n'), "the checkpoint of another lamp: {other}");
}
