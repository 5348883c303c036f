//! Bakes that are stopped, killed and continued.

use std::fs;
use std::ops::ControlFlow;
use std::path::Path;

use crate::common::options;
use lobe_io::Job;
use lobe_prt::{BakeMode, BakeOptions, BakeReport, PrtError, Receivers, Transfer, bake, bake_on_disk};
use lobe_scene::{Bvh, Scene, built_in};

struct World {
    scene: Scene,
    bvh: Bvh,
    receivers: Receivers,
    options: BakeOptions,
}

/// Some hundred vertices in seven chunks.
fn world() -> World {
    let scene = built_in::ball_over_ground(16);
    let receivers = Receivers::at_vertices(&scene).unwrap();
    let options = options(BakeMode::Interreflected, 2, 16).bounces(1);
    World { bvh: Bvh::new(&scene), scene, receivers, options }
}

impl World {
    fn resume(&self, path: &Path) -> Result<(Transfer, BakeReport), PrtError> {
        let (stored, report) =
            bake_on_disk(&self.scene, &self.bvh, &self.receivers, &self.options, Job::default().kept_in(path))?;
        Ok((stored.load()?, report))
    }

    /// Asserts that a bake resumed from a checkpoint has the results of an uninterrupted one.
    fn assert_same(&self, path: &Path, what: &str) {
        let (transfer, report) = bake(&self.scene, &self.bvh, &self.receivers, &self.options, Job::default()).unwrap();
        let (resumed, its_report) = self.resume(path).unwrap();
        assert!(transfer == resumed, "{what}: transfer differs");
        let timeless = |mut report: BakeReport| {
            report.seconds = 0.0;
            report
        };
        assert_eq!(timeless(its_report), timeless(report), "{what}: report");
    }
}

/// Bytes of header and record, which the documentation of both gives.
const HEADER: u64 = 80;

fn record(world: &World) -> u64 {
    let bands = world.options.order * world.options.order;
    (16 + 8 * (world.options.bounces + 1) + 4 * bands * 3 * 64 + 8) as u64
}

#[test]
fn a_bake_killed_at_any_record_or_inside_one_ends_with_the_same_bytes() {
    let (folder, world) = (tempfile::tempdir().unwrap(), world());
    let path = folder.path().join("bunny.glb.lobe-partial");
    world.assert_same(&path, "not interrupted");
    let complete = fs::read(&path).unwrap();
    let records = world.receivers.len().div_ceil(64) as u64;
    assert!(records > 5, "{records} records");
    let (from, to) = (HEADER + (records - 1) * record(&world), HEADER + records * record(&world));
    assert!((from..=to).contains(&(complete.len() as u64)), "{} bytes, {records} records", complete.len());
    for kept in 0..records {
        for into in [0, 1, record(&world) / 2] {
            // A file that was cut off, and one whose last record was not finished.
            let end = ((HEADER + kept * record(&world) + into) as usize).min(complete.len() - 9);
            fs::write(&path, &complete[..end]).unwrap();
            resumes_from(&world, &path, kept, &complete);
            let mut torn = complete.clone();
            torn[end..].fill(0);
            fs::write(&path, &torn).unwrap();
            resumes_from(&world, &path, kept, &complete);
        }
    }
    // Killed while the file was made: no header yet.
    for size in [0, 7, HEADER as usize, complete.len()] {
        fs::write(&path, vec![0; size]).unwrap();
        resumes_from(&world, &path, 0, &complete);
    }
}

fn resumes_from(world: &World, path: &Path, records: u64, complete: &[u8]) {
    let mut resumed = None;
    let mut watch = |p: &lobe_io::Progress| {
        resumed.get_or_insert(p.resumed);
        ControlFlow::Continue(())
    };
    bake_on_disk(
        &world.scene,
        &world.bvh,
        &world.receivers,
        &world.options,
        Job::default().watched_by(&mut watch).kept_in(path),
    )
    .unwrap();
    assert_eq!(
        resumed,
        Some((records as usize * 64).min(world.receivers.len())),
        "receivers done before, with {records} records"
    );
    assert!(fs::read(path).unwrap() == complete, "the file, resumed from {records} records");
}

#[test]
fn a_bake_stopped_by_its_user_goes_on_where_it_was() {
    let (folder, world) = (tempfile::tempdir().unwrap(), world());
    let world = World { options: world.options.mode(BakeMode::Shadowed).samples(1 << 12), ..world };
    let path = folder.path().join("a");
    let mut stops = 0;
    for _ in 0..1000 {
        let mut reports = 0;
        let mut stop = |_: &lobe_io::Progress| {
            reports += 1;
            if reports == 4 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let bake = || {
            bake_on_disk(
                &world.scene,
                &world.bvh,
                &world.receivers,
                &world.options,
                Job::default().watched_by(&mut stop).kept_in(&path),
            )
        };
        match one.install(bake) {
            Err(PrtError::Cancelled) => stops += 1,
            other => {
                other.unwrap();
                break;
            }
        }
    }
    assert!(stops > 1, "stopped {stops} times");
    world.assert_same(&path, "stopped many times");
}

#[test]
fn the_checkpoint_of_another_bake_is_refused_in_one_line() {
    let (folder, world) = (tempfile::tempdir().unwrap(), world());
    let path = folder.path().join("a.lobe-partial");
    world.resume(&path).unwrap();
    let before = fs::read(&path).unwrap();
    let refusal = |world: &World| {
        let message = world.resume(&path).unwrap_err().to_string();
        message.strip_prefix(&format!("{}: ", path.display())).unwrap().to_string()
    };
    let expected = "this checkpoint is of another bake: the scene, the receivers or the options differ; repeat that \
                    command to continue it, or remove it to start anew";
    let o = &world.options;
    for options in [o.clone().seed(7), o.clone().order(3), o.clone().samples(17), o.clone().energy_stop(1e-9)] {
        let other = World { options, ..self::world() };
        assert_eq!(refusal(&other), expected, "{:?}", other.options);
    }
    let back = World { receivers: Receivers::back_of_vertices(&world.scene).unwrap(), ..self::world() };
    assert_eq!(refusal(&back), expected, "other receivers");
    let (meshes, mut materials, textures) = world.scene.clone().into_parts();
    materials[0].base_color[1] = 0.5;
    let scene = Scene::new(meshes, materials, textures).unwrap();
    assert_eq!(refusal(&World { scene, ..self::world() }), expected, "another scene");
    assert!(fs::read(&path).unwrap() == before, "what is refused is not touched");

    let mut newer = before.clone();
    newer[8] = 9;
    fs::write(&path, newer).unwrap();
    let found = refusal(&world);
    assert_eq!(found, "this checkpoint was made by another version of Lobe; remove it to start anew", "version 9");
    fs::write(&path, "a letter").unwrap();
    assert_eq!(refusal(&world), "this is no checkpoint of a bake; move it away", "no checkpoint");
    assert_eq!(fs::read(&path).unwrap(), b"a letter", "it is left as it was");
}

#[test]
fn a_checkpoint_that_cannot_be_written_is_an_error_before_the_bake() {
    let (folder, world) = (tempfile::tempdir().unwrap(), world());
    for path in [folder.path().join("no such folder/a"), folder.path().to_path_buf()] {
        let mut calls = 0;
        let mut watch = |_: &lobe_io::Progress| {
            calls += 1;
            ControlFlow::Continue(())
        };
        let found = bake_on_disk(
            &world.scene,
            &world.bvh,
            &world.receivers,
            &world.options,
            Job::default().watched_by(&mut watch).kept_in(&path),
        )
        .unwrap_err();
        assert!(matches!(found, PrtError::Io(_)), "{}: {found}", path.display());
        assert_eq!((calls, found.to_string().lines().count()), (0, 1), "{found}");
    }
    #[cfg(target_os = "linux")]
    {
        let found = world.resume(Path::new("/dev/null")).unwrap_err().to_string();
        assert_eq!(found, "/dev/null: expected a file for the checkpoint, found a device or a pipe", "a device");
    }
}
