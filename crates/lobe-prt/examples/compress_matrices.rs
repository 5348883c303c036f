//! Compresses transfer matrices, rows of up to 768 numbers, and says how long that takes and how much it loses.
//!
//! `cargo run --release -p lobe-prt --example compress_matrices -- 2000` takes that many vertices of a ball over a
//! ground.

use std::error::Error;
use std::time::Instant;

use lobe_io::Job;
use lobe_prt::{BakeMode, BakeOptions, CompressOptions, Receivers, bake_matrices, compress_table};
use lobe_scene::{Bvh, built_in};

fn main() -> Result<(), Box<dyn Error>> {
    let count: usize = std::env::args().nth(1).map_or(Ok(2000), |n| n.parse())?;
    let scene = built_in::ball_over_ground(64);
    let all = Receivers::at_vertices(&scene)?;
    let pick = |v: &[[f32; 3]]| (0..count).map(|k| v[k * all.len() / count]).collect();
    let receivers = Receivers::new(pick(all.positions()), pick(all.normals()), pick(all.albedos()))?;
    let bvh = Bvh::new(&scene);
    for order in 2..=4 {
        let options = BakeOptions::default().mode(BakeMode::Interreflected).order(order).samples(256).bounces(1);
        let (matrices, _) = bake_matrices(&scene, &bvh, &receivers, &options, Job::default())?;
        let rows = matrices.coefficients();
        let width = rows.len() / count;
        let start = Instant::now();
        let options = CompressOptions::default().clusters(8).components(8);
        let (_, report) = compress_table(rows, width, &options, Job::default())?;
        let (seconds, error) = (start.elapsed().as_secs_f64(), report.relative_error);
        let per_number = 1e6 * seconds / rows.len() as f64;
        println!(
            "{count} rows of {width}: {seconds:.2} s, {per_number:.2} µs for each number, relative error {error:.3e}"
        );
    }
    Ok(())
}
