//! Files with bytes changed at random: they are read, and can be used, or they are refused in one line.

use lobe_io::Job;
use lobe_prt::CompressOptions;
use lobe_scene::built_in;
use lobe_sh::{Expansion as _, Rgb};
use lobe_shadow::{
    FieldOptions, FieldStorage, Lamp, LampSequence, PatchField, RadialInterpolation, RadianceOptions, Rectangle,
    ShadowError, SphereSet, bake_field, read_field_bytes, read_lamp_bytes, read_spheres_bytes, write_field, write_lamp,
    write_spheres,
};
use lobe_testkit::Random;

use crate::shapes::ball;

/// Changed files of each kind.
const COUNT: usize = 3000;

const STILL: [[f64; 4]; 3] = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

/// Some bytes changed: most of the time in the header, digits for digits among them.
fn mutated(whole: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = whole.to_vec();
    let header = 8 + u64::from_le_bytes(whole[..8].try_into().unwrap()) as usize;
    for _ in 0..1 + (3.0 * random.unit()) as usize {
        let end = if random.unit() < 0.8 { header } else { whole.len() };
        let at = (random.unit() * end as f64) as usize;
        bytes[at] = match bytes[at] {
            digit @ b'0'..=b'9' if random.unit() < 0.8 => {
                let other = b'0' + (10.0 * random.unit()) as u8;
                if other == digit { b'e' } else { other }
            }
            _ => (256.0 * random.unit()) as u8,
        };
    }
    bytes
}

fn check<T>(kind: &str, whole: &[u8], read: impl Fn(&[u8]) -> Result<T, ShadowError>, check: impl Fn(T)) {
    let mut random = Random::new(3);
    let mut were_read = 0;
    for _ in 0..COUNT {
        match read(&mutated(whole, &mut random)) {
            Ok(found) => {
                were_read += 1;
                check(found);
            }
            Err(error) => {
                let line = error.to_string();
                assert!(line.starts_with("mutated: ") && !line.contains('\n'), "{kind}: {line}");
            }
        }
    }
    assert!(were_read > 0 && were_read < COUNT, "{kind}: {were_read} of {COUNT} were read");
}

#[test]
fn changed_files_are_read_or_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("seed.safetensors");
    let options = FieldOptions::default().order(2).spheres(3).cells(2).rays(16);
    let (field, _) = bake_field(&ball(), &options, Job::default()).unwrap();
    let clustered = FieldStorage::Clustered(CompressOptions::default().clusters(2).components(2).iterations(2));
    for storage in [FieldStorage::F32, FieldStorage::F16, FieldStorage::U8, clustered] {
        write_field(&path, &field, &storage).unwrap();
        let whole = std::fs::read(&path).unwrap();
        check(
            &format!("{storage:?}"),
            &whole,
            |bytes| read_field_bytes(bytes, "mutated"),
            |field| {
                // Sums of larger numbers may be infinite.
                if field.rows().iter().any(|x| x.abs() > 1e30) {
                    return;
                }
                let center = field.grid().center();
                for offset in [[0.0; 3], [0.3, -0.2, 0.1], [1e-9, 0.0, 0.0], [1e9, -3.0, 2.0]] {
                    let point = std::array::from_fn(|c| center[c] + offset[c] * field.grid().radius());
                    let seen = field.visibility_at(point, RadialInterpolation::Cubic);
                    assert!(
                        seen.coefficients().iter().all(|c| !c.is_nan()),
                        "{:?} at {offset:?}: {seen:?}",
                        field.grid()
                    );
                }
            },
        );
    }
    let rectangle = Rectangle { corner: [-0.5, -0.5, 0.0], u: [1.0, 0.0, 0.0], v: [0.0, 1.0, 0.0], two_sided: false };
    let options = RadianceOptions::default().order(2).spheres(2).cells(2);
    let patches = PatchField::bake(&rectangle, [2, 1], &options, Job::default()).unwrap();
    let gray = |c: f32| Rgb::new(c, c, c);
    let sequence = LampSequence::new(patches.clone(), vec![vec![gray(1.0), gray(2.0)]; 2], 24.0).unwrap();
    for lamp in [Lamp::Sequence(sequence), Lamp::Still(patches.with_colors(&[Rgb::new(1.0, 2.0, 3.0); 2]).unwrap())] {
        write_lamp(&path, &lamp, &FieldStorage::F32).unwrap();
        let whole = std::fs::read(&path).unwrap();
        check(
            "lamp",
            &whole,
            |bytes| read_lamp_bytes(bytes, "mutated"),
            |lamp| {
                if let Err(error) = lamp.at(0.7) {
                    assert!(!error.to_string().contains('\n'), "{error}");
                }
            },
        );
    }
    let plain = SphereSet::new(vec![[0.0; 3], [1.0, 2.0, 3.0]], vec![0.5, 0.7]).unwrap();
    let walking = built_in::walking_figure(8);
    let bound = plain.clone().bind_to(&walking, &walking.entities()[1], &mut Job::default()).unwrap();
    for set in [plain, bound] {
        write_spheres(&path, &set).unwrap();
        let whole = std::fs::read(&path).unwrap();
        check(
            "spheres",
            &whole,
            |bytes| read_spheres_bytes(bytes, "mutated"),
            |set| {
                assert!(set.radii().iter().all(|r| *r >= 0.0), "{set:?}");
                match set.for_entity(&walking, &walking.entities()[1]) {
                    Ok(set) => assert!(set.posed(&[STILL; 17]).is_ok(), "joints of the entity"),
                    Err(error) => assert!(!error.to_string().contains('\n'), "{error}"),
                }
            },
        );
    }
}
