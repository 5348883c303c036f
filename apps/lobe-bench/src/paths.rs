//! A picture traced for reference: paths through a hall of columns under a map.

use std::hint::black_box;

use lobe::env::bundled;
use lobe::io::Job;
use lobe::render::{Camera, DistantLight, SampleCount, TruthOptions, render_truth};
use lobe::scene::{Bvh, built_in};

use crate::measure::{Bench, BenchJob};

/// Columns and rows of the picture, and paths for each of its pixels.
const SIZE: [usize; 2] = [96, 72];
const PATHS: usize = 16;

/// Half of the angle of view along the height, in radian.
const HALF_ANGLE: f64 = 0.35;

/// Runs the job of this file.
pub(crate) fn run(bench: &mut Bench<'_>) -> anyhow::Result<()> {
    let name = "truth";
    if !bench.wants_without_order(name) {
        return Ok(());
    }
    let scene = built_in::columns_hall(4);
    let (bvh, light) = (Bvh::new(&scene), DistantLight::from_map(bundled::sunset().map()));
    let Some(camera) = Camera::look_at([5.0, -9.0, 5.0], [0.0, 0.0, 1.5], HALF_ANGLE) else { return Ok(()) };
    let options = TruthOptions::default().width(SIZE[0]).height(SIZE[1]).count(SampleCount::of(PATHS));
    // Once where a fault can be told.
    render_truth(&scene, &bvh, &camera, &light, &options, Job::default())?;
    let items = SIZE[0] * SIZE[1] * PATHS;
    let job = BenchJob { name, order: None, item: "path", items, cost: None, above: "" };
    bench.measure(&job, || {
        let _ = black_box(render_truth(&scene, &bvh, &camera, black_box(&light), &options, Job::default()));
    });
    Ok(())
}
