//! Files of what moves and of what shines near by, judged by readers that were written from the page of formats.

use lobe::io::Job;
use lobe::prt::{CompressOptions, WeightBits};
use lobe::scene::{Mesh, MeshParts, Scene, built_in};
use lobe::sh::{Expansion as _, Rgb, ShVec};
use lobe::shadow::{
    FieldGrid, FieldOptions, FieldStorage, Lamp, LampSequence, LogTable, LogTableOptions, OcclusionField, PatchField,
    RadialInterpolation, RadianceField, RadianceOptions, Rectangle, Skin, SphereFitOptions, SphereSet,
    SurfaceVisibility, VisibilityOptions, bake_field, bake_visibility, fit_spheres, read_lamp, write_field, write_lamp,
    write_log_table, write_spheres, write_visibility,
};
use lobe_testkit::Random;

use crate::by_hand::{Record, read_checkpoint, read_safetensors};
use crate::moving_by_hand::{Points, light_of_lamp, logarithm_of_sphere, posed_spheres, stored_rows, vector};
use crate::{ROUNDING, folder};

const LINEAR: RadialInterpolation = RadialInterpolation::Linear;

/// Places and weights among the samples are of single precision, and near the bounding sphere a square root of its rounding.
const PLACES: f64 = 1e-3;

/// Points within all spheres, between them and beyond, some on the axes.
fn points_around(center: [f64; 3], radius: f64) -> Vec<[f64; 3]> {
    let mut random = Random::new(12);
    let anywhere = (0..200).map(|_| (random.direction(), random.unit()));
    let on_axes = [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]];
    let all = anywhere.chain(on_axes.map(|d| (d, 0.4))).collect::<Vec<_>>();
    let place = |(d, t): ([f64; 3], f64)| [0, 1, 2].map(|k| center[k] + radius * (0.02 + 10.0 * t * t * t) * d[k]);
    all.into_iter().map(place).collect()
}

fn expect_near(what: &str, found: &[f64], expected: impl IntoIterator<Item = f32>, tolerance: f64) {
    let expected: Vec<f64> = expected.into_iter().map(f64::from).collect();
    assert_eq!(found.len(), expected.len(), "{what}: numbers");
    let largest = expected.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    for (i, (a, b)) in found.iter().zip(&expected).enumerate() {
        assert!((a - b).abs() <= tolerance * largest, "{what}, number {i}: {a}, expected {b}");
    }
}

fn storages() -> [FieldStorage; 4] {
    let clusters = CompressOptions::default().clusters(3).components(4).weights(WeightBits::U8);
    [FieldStorage::F32, FieldStorage::F16, FieldStorage::U8, FieldStorage::Clustered(clusters)]
}

#[test]
fn occlusion_fields_of_every_storage_are_read_from_the_page() {
    let folder = folder();
    let path = folder.path().join("f.field.safetensors");
    let storages = storages();
    // Spheres on both sides of the bounding sphere, beyond it alone, and two.
    for (range, spheres) in [([0.25, 8.0], 9), ([1.5, 4.0], 3), ([0.5, 2.0], 2)] {
        let grid = FieldGrid::new([1.0, -2.0, 0.5], 0.75, range, spheres, 4).unwrap();
        let numbers = Random::new(3).signed_vec(12 * grid.points()).into_iter().map(|x| x as f32).collect();
        let field = OcclusionField::new(grid, 3, numbers).unwrap();
        for storage in &storages {
            let report = write_field(&path, &field, storage).unwrap();
            let (about, table) = read_safetensors(&path);
            assert_eq!(about["format"], "lobe-occlusion-field", "{about}");
            let rows = stored_rows(&about, &table, "rows", 12);
            let allowed = report.largest_error * 1.01 + 1e-6;
            let far = rows.iter().zip(field.rows()).find(|(a, b)| (**a - f64::from(**b)).abs() > allowed);
            assert_eq!(far, None, "{storage:?}: rows to within {allowed}");
            let stored = OcclusionField::new(grid, 3, rows.iter().map(|x| *x as f32).collect()).unwrap();
            let points = Points::of_field(&about);
            for point in points_around(grid.center(), grid.radius()) {
                let found = points.function_at(point, &rows, |p| 12 * p);
                let expected = stored.occlusion_at(point, LINEAR);
                let what = format!("{storage:?}, {range:?}, at {point:?}");
                expect_near(&what, &found, expected.coefficients().iter().copied(), PLACES);
            }
        }
    }
}

#[test]
fn lamps_of_every_shape_and_storage_are_read_from_the_page() {
    let folder = folder();
    let path = folder.path().join("l.lamp.safetensors");
    let rectangle = Rectangle { corner: [0.5, 1.0, 2.0], u: [1.0, 0.0, 0.5], v: [0.0, -2.0, 0.0], two_sided: false };
    let options = RadianceOptions::default().order(3).spheres(5).cells(4);
    let ball = RadianceField::ball(3, [1.0, 2.0, 3.0], 0.5, Rgb::new(3.0, 2.0, 1.0)).unwrap();
    let still = RadianceField::rectangle(&rectangle, Rgb::new(3.0, 2.0, 1.0), &options).unwrap();
    let patches = PatchField::bake(&rectangle, [2, 3], &options, Job::default()).unwrap();
    let mut random = Random::new(5);
    let mut picture = || (0..6).map(|_| Rgb::from([0; 3].map(|_| random.unit() as f32))).collect();
    let sequence = LampSequence::new(patches, vec![picture(), picture(), picture()], 24.0).unwrap();
    for (lamp, time) in [
        (Lamp::Still(ball), 0.0),
        (Lamp::Still(still), 0.0),
        (Lamp::Sequence(sequence.clone()), 1.5 / 24.0),
        (Lamp::Sequence(sequence), -0.5 / 24.0),
    ] {
        for storage in &storages() {
            write_lamp(&path, &lamp, storage).unwrap();
            let (about, table) = read_safetensors(&path);
            // As Lobe reads it: the loss of the storage is tested with it.
            let read = read_lamp(&path).unwrap();
            let field = read.at(time).unwrap();
            for point in points_around(field.center(), 1.0) {
                let found = light_of_lamp(&about, &table, point, time);
                let expected = field.radiance_at(point, LINEAR);
                let channel = |c: usize| expected.coefficients().iter().map(move |x| x.to_array()[c]);
                for (c, found) in found.iter().enumerate() {
                    expect_near(&format!("{storage:?}, {about}, color {c} at {point:?}"), found, channel(c), PLACES);
                }
            }
        }
    }
}

#[test]
fn visibility_of_every_storage_is_read_from_the_page() {
    let folder = folder();
    let path = folder.path().join("s.visibility.safetensors");
    let rows: Vec<f32> = Random::new(8).signed_vec(9 * 40).into_iter().map(|x| x as f32).collect();
    let visibility = SurfaceVisibility::new(3, rows).unwrap();
    for storage in &storages() {
        let report = write_visibility(&path, &visibility, storage).unwrap();
        let (about, table) = read_safetensors(&path);
        assert_eq!((&about["format"], &about["order"]), (&"lobe-visibility".into(), &3.into()), "{about}");
        let found = stored_rows(&about, &table, "rows", 9);
        let allowed = report.largest_error * 1.01 + 1e-6;
        let far = found.iter().zip(visibility.rows()).find(|(a, b)| (**a - f64::from(**b)).abs() > allowed);
        assert_eq!((found.len(), far), (9 * 40, None), "{storage:?}: numbers to within {allowed}");
    }
}

#[test]
fn sphere_sets_are_read_from_the_page() {
    let folder = folder();
    let path = folder.path().join("s.spheres.safetensors");
    let set = SphereSet::new(vec![[1.0, 2.0, 3.0], [-4.0, 5.0, -6.0]], vec![0.5, 0.25]).unwrap();
    let joints = vec![[7, 0, 0, 0], [1, 2, 3, 4]];
    let skin = Skin::new(joints.clone(), vec![[1.0, 0.0, 0.0, 0.0], [0.1, 0.2, 0.3, 0.4]]).unwrap();
    let set = set.with_origin([1e6, 0.0, -1e6]).unwrap().with_skin(skin).unwrap();
    write_spheres(&path, &set).unwrap();
    let (about, table) = read_safetensors(&path);
    assert_eq!(about["format"], "lobe-spheres", "{about}");
    let (origin, centers) = (vector(&about["origin"]), &table["centers"].1);
    for k in 0..2 {
        assert_eq!([0, 1, 2].map(|axis| origin[axis] + centers[3 * k + axis]), set.center(k), "center {k}");
    }
    expect_near("radii", &table["radii"].1, [0.5, 0.25], 0.0);
    expect_near("joints", &table["joints"].1, joints.concat().into_iter().map(f32::from), 0.0);
    let sums: Vec<f64> = table["weights"].1.chunks(4).map(|w| w.iter().sum()).collect();
    assert!(sums.iter().all(|sum| (sum - 1.0).abs() < ROUNDING), "{sums:?} are 1");
}

#[test]
fn spheres_that_follow_joints_are_posed_from_the_page() {
    let folder = folder();
    let path = folder.path().join("s.spheres.safetensors");
    let scene = built_in::walking_figure(8);
    let figure = scene.entity("figure").unwrap();
    let mut random = Random::new(15);
    let center = |random: &mut Random| [0.3 * random.signed(), 0.2 * random.signed(), 1.7 * random.unit()];
    let centers: Vec<[f32; 3]> = (0..20).map(|_| center(&mut random).map(|c| c as f32)).collect();
    let set = SphereSet::new(centers, vec![0.25; 20]).unwrap().bind_to(&scene, figure, &mut Job::default()).unwrap();
    write_spheres(&path, &set).unwrap();
    let (about, table) = read_safetensors(&path);
    let names: Vec<Option<&str>> =
        about["skeleton"]["joints"].as_array().unwrap().iter().map(serde_json::Value::as_str).collect();
    assert_eq!(names, scene.skin_names(figure.skin().unwrap()).1, "in the order of the skin");
    assert_eq!(
        (&about["skeleton"]["entity"], &about["skeleton"]["node"]),
        (&"figure".into(), &figure.node().into()),
        ""
    );
    for time in [0.0, 0.3, 0.9] {
        let pose = scene.pose(0, time).unwrap();
        let maps = pose.joint_maps(figure.skin().unwrap()).into_iter().chain([pose.place(figure)]);
        let found = posed_spheres(&about, &table, &maps.map(|map| map.rows()).collect::<Vec<_>>());
        for (k, (found, expected)) in found.iter().zip(set.posed_with(&pose, figure).unwrap()).enumerate() {
            let off = [0, 1, 2].map(|axis| (found.0[axis] - expected.center[axis]).abs());
            assert!(off.iter().all(|off| *off < ROUNDING), "{time} s, center {k} is {off:?} off");
            assert!((found.1 - expected.radius).abs() < ROUNDING, "{time} s, radius {k}");
        }
    }
}

#[test]
fn log_tables_are_read_from_the_page() {
    let folder = folder();
    let path = folder.path().join("t.safetensors");
    let log_table = LogTable::new(&LogTableOptions::default().order(4).tolerance(0.05)).unwrap();
    write_log_table(&path, &log_table).unwrap();
    let (about, table) = read_safetensors(&path);
    assert_eq!(about["options"]["order"], 4, "{about}");
    for half_angle in [0.0, 0.01, 0.3, 0.7, 1.0, 1.3, 0.5 * std::f64::consts::PI] {
        let found = logarithm_of_sphere(&about, &table, half_angle);
        let rotated = log_table.at(half_angle);
        let factor = |l: usize| (4.0 * std::f64::consts::PI / (2 * l + 1) as f64).sqrt();
        let expected = rotated.coefficients().iter().enumerate().map(|(l, z)| (z * factor(l)) as f32);
        expect_near(&format!("half angle {half_angle}"), &found, expected, 1e-4);
    }
}

/// A solid.
fn tetrahedron() -> Scene {
    let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let triangles = vec![[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]];
    let mesh = Mesh::new(MeshParts { positions, triangles, ..MeshParts::default() }).unwrap();
    Scene::new(vec![mesh], Vec::new(), Vec::new()).unwrap()
}

fn floats(records: &[Record]) -> Vec<f32> {
    records.concat().as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect()
}

#[test]
fn the_records_of_fields_visibility_and_spheres_hold_what_the_page_says() {
    let (folder, scene) = (folder(), built_in::ball_over_ground(4));
    let kept = |name: &str| folder.path().join(name);
    // Points are not filled, so that they are as they were sampled.
    let options = FieldOptions::default().order(2).spheres(3).cells(4).rays(32).fill_inside(false);
    let (field, report) = bake_field(&scene, &options, Job::default().kept_in(kept("f"))).unwrap();
    let (kind, records) = read_checkpoint(&kept("f"));
    assert_eq!((kind.as_str(), records[0].len()), ("OCCF", 32 * 5 * 4), "32 points of n² + 1 numbers each");
    let numbers = floats(&records);
    assert_eq!(report.rays, 32 * (numbers.len() / 5) as u64, "rays of the points that are there");
    // The first sample lies at the corner of the square, straight below; the last is the center.
    let grid = field.grid();
    for (row, offset) in [(0, grid.offset(0)), (numbers.len() / 5 - 1, [0.0; 3])] {
        let point = [0, 1, 2].map(|k| grid.center()[k] + offset[k]);
        let scale = grid.scale_at(offset[2].abs()) as f32;
        let expected: ShVec<f32> = field.occlusion_at(point, LINEAR);
        let found: Vec<f64> = numbers[5 * row..][..4].iter().map(|x| f64::from(x / scale)).collect();
        expect_near(&format!("sample {row}"), &found, expected.coefficients().iter().copied(), PLACES);
    }

    let (positions, normals) = ([[0.0, 0.0, 3.0], [0.0, 0.5, 3.0]], [[0.0, 0.0, 1.0]; 2]);
    let options = VisibilityOptions::default().order(2).rays(32);
    let visibility =
        bake_visibility(&scene, &positions, &normals, &options, Job::default().kept_in(kept("v"))).unwrap();
    let (kind, records) = read_checkpoint(&kept("v"));
    assert_eq!((kind.as_str(), floats(&records)), ("VISB", visibility), "n² numbers for each receiver");

    let options = SphereFitOptions::default().count(3).samples(200).rounds(4);
    let (_, report) = fit_spheres(&tetrahedron(), &options, Job::default().kept_in(kept("s"))).unwrap();
    let (kind, records) = read_checkpoint(&kept("s"));
    assert_eq!((kind.as_str(), records[0].len()), ("SPHR", 8 * (2 + 5 * 6)), "room for twice the spheres");
    let numbers =
        |record: &Vec<u8>| -> Vec<f64> { record.as_chunks().0.iter().map(|b| f64::from_le_bytes(*b)).collect() };
    let records: Vec<Vec<f64>> = records.iter().map(numbers).collect();
    let (start, rounds): (Vec<_>, Vec<_>) = records.iter().partition(|numbers| numbers[1] > 3.0);
    assert!(start.iter().all(|numbers| numbers[1] <= 6.0), "twice as many at most: {start:?}");
    for (numbers, energy) in rounds.iter().zip(&report.history) {
        let balls = &numbers[2..][..5 * numbers[1] as usize];
        let outside: f64 = balls.as_chunks::<5>().0.iter().map(|ball| ball[4]).sum();
        assert_eq!((numbers[0], numbers[1]), (*energy, 3.0), "the energy of the round and the number of spheres");
        assert!((outside - energy).abs() <= 1e-9 * energy.abs(), "{outside} is the sum {energy}");
    }
    assert!(rounds.len() >= report.history.len(), "a record for each round");
}
