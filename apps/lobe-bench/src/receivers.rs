//! Jobs of receivers of light: shading by transfer, rays to the sky.

use std::hint::black_box;
use std::path::Path;

use anyhow::bail;
use lobe::io::{Numbers, Tensor, TensorFormat, write_tensors};
use lobe::prt::{
    Channels, CompressedTable, CompressedTransfer, HalfTransfer, TableWeights, Transfer, TransferMatrices,
};
use lobe::scene::{Bvh, built_in};
use lobe::sh::Rgb;
use lobe::sh::sphere::even_directions;

use crate::cost::{Cost, Level};
use crate::measure::{Bench, BenchJob};

/// Receivers, enough that their transfer leaves every cache.
const RECEIVERS: usize = 1 << 20;

const ORDER: usize = 4;

/// Rays from each point.
const RAYS: usize = 256;

/// Points from which rays start.
const POINTS: usize = 512;

/// Cells of the still life, of which it has some hundred thousand triangles.
const CELLS: usize = 96;

/// The file of rays.
const FORMAT: TensorFormat = TensorFormat { name: "lobe-bench-rays", version: 1, if_older: "write it anew" };

/// Runs the jobs of this file.
///
/// `rays_file` is what the rays of the job `occlusion` are written to.
pub(crate) fn run(bench: &mut Bench<'_>, rays_file: Option<&Path>) -> anyhow::Result<()> {
    transfer(bench)?;
    half_transfer(bench)?;
    clustered(bench)?;
    incident(bench)?;
    occlusion(bench, rays_file)
}

/// Any numbers: shading does not depend on them.
fn numbers(count: usize) -> Vec<f32> {
    // A prime number of them, so that no column of a power of two has the same in all rows.
    let some: Vec<f32> = (0..1021).map(|k| (k as f32).sin()).collect();
    some.iter().copied().cycle().take(count).collect()
}

/// Any light of an order.
fn light(order: usize) -> Vec<Rgb<f64>> {
    (0..order * order).map(|k| Rgb::new(1.0, 0.5, 1.0 / (1 + k) as f64)).collect()
}

fn transfer(bench: &mut Bench<'_>) -> anyhow::Result<()> {
    for (name, channels) in [("transfer", Channels::Gray), ("transfer-rgb", Channels::Rgb)] {
        if bench.wants(name) {
            let transfer = any_transfer(channels)?;
            let cost = cost_of_transfer(channels, size_of::<f32>());
            shading(bench, name, (cost, "what is written counts as read"), |light, out| {
                transfer.exit_radiance_into(light, out);
            });
        }
    }
    Ok(())
}

/// The same where each number has 16 bits.
fn half_transfer(bench: &mut Bench<'_>) -> anyhow::Result<()> {
    for (name, channels) in [("transfer-f16", Channels::Gray), ("transfer-f16-rgb", Channels::Rgb)] {
        if bench.wants(name) {
            let (transfer, _) = HalfTransfer::new(&any_transfer(channels)?)?;
            let cost = cost_of_transfer(channels, size_of::<u16>());
            let above = "every number is converted and, of one vector for all colors, turned, and what is written counts as read";
            shading(bench, name, (cost, above), |light, out| transfer.exit_radiance_into(light, out));
        }
    }
    Ok(())
}

/// Measures how long all receivers take to be lit.
fn shading(
    bench: &mut Bench<'_>,
    name: &'static str,
    (cost, above): (Cost, &'static str),
    shade: impl Fn(&[Rgb<f64>], &mut [Rgb<f32>]),
) {
    let light = light(ORDER);
    let mut out = vec![Rgb::new(0.0, 0.0, 0.0); RECEIVERS];
    for order in bench.orders(&[ORDER]) {
        let job = BenchJob { name, order: Some(order), item: "receiver", items: RECEIVERS, cost: Some(cost), above };
        bench.measure(&job, || shade(black_box(&light), black_box(&mut out)));
    }
}

fn any_transfer(channels: Channels) -> anyhow::Result<Transfer> {
    Ok(Transfer::new(ORDER, channels, numbers(RECEIVERS * ORDER * ORDER * channels.count()))?)
}

/// Three colors of the light; each number is read once, each color written once.
fn cost_of_transfer(channels: Channels, bytes: usize) -> Cost {
    let width = ORDER * ORDER * channels.count();
    Cost {
        operations: (2 * 3 * ORDER * ORDER) as f64,
        bytes: (bytes * width + size_of::<Rgb<f32>>()) as f64,
        level: Level::Read,
    }
}

/// Of compressed transfer: clusters, runs of receivers in one, and weights of each receiver.
const CLUSTERS: usize = 64;
const RUN: usize = 512;
const COMPONENTS: usize = 8;

fn clustered(bench: &mut Bench<'_>) -> anyhow::Result<()> {
    for (name, bytes) in [("clustered", size_of::<f32>()), ("clustered-u8", size_of::<u8>())] {
        if !bench.wants(name) {
            continue;
        }
        let width = ORDER * ORDER;
        let clusters = (0..RECEIVERS).map(|k| ((k / RUN) % CLUSTERS) as u16).collect();
        let bases = numbers(CLUSTERS * width * (COMPONENTS + 1));
        let weights = match bytes {
            1 => TableWeights::U8((0..RECEIVERS * COMPONENTS).map(|k| (k % 251) as u8).collect()),
            _ => TableWeights::F32(numbers(RECEIVERS * COMPONENTS)),
        };
        let table = CompressedTable::new(width, COMPONENTS, clusters, weights, bases)?;
        let transfer = CompressedTransfer::from_table(ORDER, Channels::Gray, table)?;
        // Bases times light are sums of the clusters; each weight and cluster is read once, each color written once.
        let cost = Cost {
            operations: (2 * 3 * COMPONENTS) as f64,
            bytes: (bytes * COMPONENTS + size_of::<u16>() + size_of::<Rgb<f32>>()) as f64,
            level: Level::Read,
        };
        let above = "each weight takes two loads for four lanes, and what is written counts as read";
        shading(bench, name, (cost, above), |light, out| transfer.exit_radiance_into(light, out));
    }
    Ok(())
}

fn incident(bench: &mut Bench<'_>) -> anyhow::Result<()> {
    for (name, channels) in [("incident", Channels::Gray), ("incident-rgb", Channels::Rgb)] {
        if !bench.wants(name) {
            continue;
        }
        for order in bench.orders(&[4, 6]) {
            let (bands, width) = (order * order, order.pow(4) * channels.count());
            // As many numbers as the transfer of all receivers.
            let points = RECEIVERS * ORDER * ORDER / order.pow(4);
            let matrices = TransferMatrices::new(order, channels, numbers(points * width))?;
            let light = light(order);
            let mut out = vec![Rgb::new(0.0, 0.0, 0.0); points * bands];
            let job = BenchJob {
                name,
                order: Some(order),
                item: "matrix",
                items: points,
                // Three colors of the light; each number is read once, n² colors are written once.
                cost: Some(Cost {
                    operations: (2 * 3 * bands * bands) as f64,
                    bytes: (size_of::<f32>() * width + size_of::<Rgb<f32>>() * bands) as f64,
                    level: Level::Read,
                }),
                above: "each row of a matrix ends in additions across lanes",
            };
            bench.measure(&job, || matrices.incident_into(black_box(&light), black_box(&mut out)));
        }
    }
    Ok(())
}

/// Rays to the whole sky from points on the ground of the still life.
struct SkyRays {
    corners: Vec<[[f32; 3]; 3]>,
    bvh: Bvh,
    points: Vec<[f32; 3]>,
    /// Of each point.
    directions: Vec<[f32; 3]>,
}

impl SkyRays {
    fn new() -> Self {
        let scene = built_in::still_life(CELLS);
        let corners: Vec<_> = scene.corners().collect();
        let bvh = Bvh::from_corners(&corners);
        let directions = even_directions(RAYS).map(|s| s.to_array().map(|c| c as f32)).collect();
        let mesh = &scene.meshes()[0];
        let step = (mesh.positions().len() / POINTS).max(1);
        let ground = mesh.positions().iter().zip(mesh.normals()).step_by(step);
        let points = ground.map(|(p, n)| bvh.origin_above(*p, *n)).collect();
        Self { corners, bvh, points, directions }
    }

    /// Which of all rays hit something, those of a point side by side.
    fn trace_into(&self, hidden: &mut [bool]) {
        for (point, hidden) in self.points.iter().zip(hidden.chunks_exact_mut(RAYS)) {
            self.bvh.occluded_from_into(*point, black_box(&self.directions), hidden);
        }
    }

    /// Writes triangles, rays and what they found.
    fn write(&self, hidden: &[bool], path: &Path) -> anyhow::Result<()> {
        let hidden: Vec<u8> = hidden.iter().map(|&h| u8::from(h)).collect();
        let tensors = [
            Tensor::new(
                "corners",
                [self.corners.len(), 3, 3],
                Numbers::F32(self.corners.as_flattened().as_flattened()),
            ),
            Tensor::new("points", [self.points.len(), 3], Numbers::F32(self.points.as_flattened())),
            Tensor::new("directions", [RAYS, 3], Numbers::F32(self.directions.as_flattened())),
            Tensor::new("hidden", [self.points.len(), RAYS], Numbers::U8(&hidden)),
        ];
        Ok(write_tensors(path, FORMAT, &(), &tensors)?)
    }
}

fn occlusion(bench: &mut Bench<'_>, rays_file: Option<&Path>) -> anyhow::Result<()> {
    let name = "occlusion";
    if !bench.wants_without_order(name) {
        return match rays_file {
            Some(_) => bail!("--rays: expected {name} among the jobs, whose rays they are"),
            None => Ok(()),
        };
    }
    let rays = SkyRays::new();
    let mut hidden = vec![false; rays.points.len() * RAYS];
    let job = BenchJob { name, order: None, item: "ray", items: hidden.len(), cost: None, above: "" };
    bench.measure(&job, || rays.trace_into(black_box(&mut hidden)));
    rays_file.map_or(Ok(()), |path| rays.write(&hidden, path))
}
