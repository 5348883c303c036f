//! Jobs of receivers of light: shading by transfer, rays to the sky.

use std::hint::black_box;

use lobe::prt::{Channels, Transfer};
use lobe::scene::{Bvh, built_in};
use lobe::sh::{Rgb, even_directions};

use crate::bench::cost::{Cost, Level};
use crate::bench::measure::{Bench, BenchJob};

/// Receivers, enough that their transfer leaves every cache.
const RECEIVERS: usize = 1 << 20;

const ORDER: usize = 4;

/// Rays from each point.
const RAYS: usize = 256;

/// Points from which rays start.
const POINTS: usize = 512;

/// Cells of the still life, of which it has some hundred thousand triangles.
const CELLS: usize = 96;

/// Runs the jobs of this file.
pub(crate) fn run(bench: &mut Bench<'_>) -> anyhow::Result<()> {
    transfer(bench)?;
    occlusion(bench);
    Ok(())
}

fn transfer(bench: &mut Bench<'_>) -> anyhow::Result<()> {
    for (name, channels) in [("transfer", Channels::Gray), ("transfer-rgb", Channels::Rgb)] {
        if !bench.wants(name) {
            continue;
        }
        let width = ORDER * ORDER * channels.count();
        // Any numbers: shading does not depend on them.
        let numbers = (0..RECEIVERS * width).map(|k| ((k % 1021) as f32).sin()).collect();
        let transfer = Transfer::new(ORDER, channels, numbers)?;
        let light: Vec<Rgb<f64>> = (0..ORDER * ORDER).map(|k| Rgb::new(1.0, 0.5, 1.0 / (1 + k) as f64)).collect();
        let mut out = vec![Rgb::new(0.0, 0.0, 0.0); RECEIVERS];
        let read = (size_of::<f32>() * width) as f64;
        let job = BenchJob {
            name,
            order: Some(ORDER),
            item: "receiver",
            items: RECEIVERS,
            // Three colors of the light; each number is read once, each color written once.
            cost: Some(Cost {
                operations: (2 * 3 * ORDER * ORDER) as f64,
                bytes: read + size_of::<Rgb<f32>>() as f64,
                level: Level::Read,
            }),
            above: "not known",
        };
        bench.measure(&job, || transfer.exit_radiance_into(black_box(&light), black_box(&mut out)));
    }
    Ok(())
}

fn occlusion(bench: &mut Bench<'_>) {
    let name = "occlusion";
    if !bench.wants(name) {
        return;
    }
    let scene = built_in::still_life(CELLS);
    let bvh = Bvh::new(&scene);
    let directions: Vec<[f32; 3]> = even_directions(RAYS).map(|s| s.to_array().map(|c| c as f32)).collect();
    let mesh = &scene.meshes()[0];
    let step = (mesh.positions().len() / POINTS).max(1);
    let points: Vec<[f32; 3]> =
        mesh.positions().iter().zip(mesh.normals()).step_by(step).map(|(p, n)| bvh.origin_above(*p, *n)).collect();
    let mut hidden = vec![false; RAYS];
    let job = BenchJob { name, order: None, item: "ray", items: points.len() * RAYS, cost: None, above: "" };
    bench.measure(&job, || {
        for point in &points {
            bvh.occluded_from_into(*point, black_box(&directions), black_box(&mut hidden));
        }
    });
}
