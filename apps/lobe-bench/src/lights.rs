//! Light from all around a point: irradiance at normals, probes without ringing, maps filtered for rough surfaces.

use std::hint::black_box;

use lobe::env::{CubeMap, PrefilterOptions, prefilter_ggx};
use lobe::io::Job;
use lobe::sh::batch::{DirBatch, ShBatch};
use lobe::sh::encoding::PackedIrradiance;
use lobe::sh::sphere::even_directions;
use lobe::sh::{Coefficient as _, Dir, Rgb, ShL2, eval_basis};

use crate::cost::{Cost, Level};
use crate::measure::{Bench, BenchJob};

/// Normals, and probes.
const COUNT: usize = 1024;

/// The order of irradiance and of the probes.
const ORDER: usize = 3;

/// Texels along a face of the map that is filtered.
const FACE: usize = 128;

/// Runs the jobs of this file.
pub(crate) fn run(bench: &mut Bench<'_>) -> anyhow::Result<()> {
    irradiance(bench);
    dering(bench);
    prefilter(bench)
}

/// A sky with a sun, whose expansion rings.
fn light(seed: usize) -> ShL2<Rgb<f32>> {
    let sun = Dir::from_angles(0.3, 0.618 * seed as f64);
    let mut colors: Vec<Rgb<f32>> =
        eval_basis(sun, ORDER).iter().map(|y| Rgb::narrow(Rgb::new(5.0, 4.0, 2.5).scale(*y))).collect();
    colors[0] += Rgb::splat(1.0);
    ShL2::from_slice(&colors)
}

fn irradiance(bench: &mut Bench<'_>) {
    let name = "irradiance";
    if !bench.wants(name) {
        return;
    }
    let packed = PackedIrradiance::from_irradiance_sh(&light(0));
    let normals: DirBatch = even_directions(COUNT).collect();
    let mut out = vec![Rgb::new(0.0, 0.0, 0.0); COUNT];
    for order in bench.orders(&[ORDER]) {
        let job = BenchJob {
            name,
            order: Some(order),
            item: "normal",
            items: COUNT,
            // Five products of coordinates, one of them in a multiply-add; eight multiply-adds for each color.
            cost: Some(Cost { operations: 7.0 + 3.0 * 16.0, bytes: 12.0 + 12.0, level: Level::Cache }),
            above: "sixteen colors are put together from their channels",
        };
        bench.measure(&job, || packed.eval_into(black_box(&normals), black_box(&mut out)));
    }
}

fn dering(bench: &mut Bench<'_>) {
    let name = "dering";
    if !bench.wants(name) {
        return;
    }
    let probes: Vec<ShL2<Rgb<f32>>> = (0..COUNT).map(light).collect();
    let batches = [0, 1, 2].map(|c| {
        let channel: Vec<ShL2<f32>> = probes.iter().map(|f| f.map(|v| v.channel(c))).collect();
        ShBatch::from_functions(&channel)
    });
    let mut work = batches.clone();
    for order in bench.orders(&[ORDER]) {
        let job = BenchJob { name, order: Some(order), item: "probe", items: COUNT, cost: None, above: "" };
        bench.measure(&job, || {
            for (work, batch) in work.iter_mut().zip(black_box(&batches)) {
                work.blocks_mut().copy_from_slice(batch.blocks());
            }
            black_box(ShBatch::dering_in_place(black_box(&mut work)));
        });
    }
}

/// All levels of a map for rough surfaces; counted by the texels of the first.
fn prefilter(bench: &mut Bench<'_>) -> anyhow::Result<()> {
    let name = "prefilter";
    if !bench.wants_without_order(name) {
        return Ok(());
    }
    let map = CubeMap::from_fn(FACE, |s| Rgb::splat(if s.z() > 0.99 { 100.0 } else { 1.5 + s.x() as f32 }));
    let options = PrefilterOptions::default().size(FACE);
    let items = 6 * FACE * FACE;
    // Once where a fault can be told.
    prefilter_ggx(&map, &options, Job::default())?;
    let job = BenchJob { name, order: None, item: "texel", items, cost: None, above: "" };
    bench.measure(&job, || {
        let _ = black_box(prefilter_ggx(black_box(&map), &options, Job::default()));
    });
    Ok(())
}
