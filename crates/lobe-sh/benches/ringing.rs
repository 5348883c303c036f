//! Windows, minima and dering; see the README beside this file.

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput};
use lobe_sh::batch::ShBatch;
use lobe_sh::extrema::certified_minimum;
use lobe_sh::filter::window_in_place;
use lobe_sh::ringing::{DeringMethod, DeringOptions, conservative_minimum, dering_in_place};
use lobe_sh::{Coefficient as _, Dir, Expansion as _, Rgb, ShL2, ShVec, Window, Zonal};
use lobe_testkit::Random;

const PROBES: usize = 256;

/// The irradiance of a sun of random place and color on a dim blue sky over brown ground: it rings below zero.
fn probe(random: &mut Random, order: usize) -> ShVec<Rgb> {
    let sun = Rgb::new(20.0 + random.unit(), 18.0 + random.unit(), 14.0 + random.unit());
    let mut f = ShVec::impulse(order, Dir::from_unit(random.direction()), sun);
    let sky = Zonal::project(order, &[0.0], 20, |t| if t > 0.0 { 0.06 } else { 0.02 });
    f += &sky.towards(Dir::Z, Rgb::new(0.6, 0.8, 1.0));
    f.convolved(&Zonal::clamped_cosine(order)).map(|c| Rgb::new(c.r as f32, c.g as f32, c.b as f32))
}

fn dering(c: &mut Criterion) {
    let mut random = Random::new(1);
    let probes: Vec<ShL2<Rgb>> = (0..PROBES).map(|_| ShL2::from_slice(probe(&mut random, 3).coefficients())).collect();
    let quick = DeringOptions::default().evidence(false);
    let mut group = c.benchmark_group("dering-one-rgb-f32");
    group.bench_function(BenchmarkId::from_parameter(3), |bencher| {
        bencher.iter(|| {
            let mut f = black_box(probes[0]);
            dering_in_place(f.coefficients_mut(), &quick);
            f
        });
    });
    group.finish();
    let mut group = c.benchmark_group("dering-batch-rgb-f32");
    group.throughput(Throughput::Elements(PROBES as u64));
    group.bench_function(BenchmarkId::from_parameter(3), |bencher| {
        let mut work = probes.clone();
        bencher.iter(|| {
            work.copy_from_slice(black_box(&probes));
            for f in &mut work {
                dering_in_place(f.coefficients_mut(), &quick);
            }
        });
    });
    group.finish();
    let mut group = c.benchmark_group("dering-lanes-rgb-f32");
    group.throughput(Throughput::Elements(PROBES as u64));
    group.bench_function(BenchmarkId::from_parameter(3), |bencher| {
        let channel = |c| probes.iter().map(|f| f.map(|v| v.channel(c))).collect::<Vec<ShL2>>();
        let batches = [0, 1, 2].map(|c| ShBatch::from_functions(&channel(c)));
        let mut work = batches.clone();
        bencher.iter(|| {
            for (work, batch) in work.iter_mut().zip(black_box(&batches)) {
                work.blocks_mut().copy_from_slice(batch.blocks());
            }
            ShBatch::dering_in_place(&mut work)
        });
    });
    group.finish();
    let mut group = c.benchmark_group("dering-reported-rgb-f32");
    for (method, orders) in [
        ("least-change", &[3, 4, 5, 6, 8][..]),
        ("table", &[3]),
        ("lanczos:4", &[3, 5]),
        ("squared-laplacian", &[3, 5]),
    ] {
        let parsed: DeringMethod = method.parse().unwrap_or_default();
        for &order in orders {
            let f = probe(&mut random, order);
            let dering = DeringOptions::default().method(parsed);
            group.bench_function(BenchmarkId::new(method, order), |bencher| {
                bencher.iter(|| {
                    let mut g = f.clone();
                    dering_in_place(g.coefficients_mut(), &dering)
                });
            });
        }
    }
}

fn minimum(c: &mut Criterion) {
    const FUNCTIONS: usize = 16;
    let mut group = c.benchmark_group("minimum-f64");
    group.throughput(Throughput::Elements(FUNCTIONS as u64));
    let mut random = Random::new(2);
    for order in 2..=10 {
        let functions: Vec<Vec<f64>> = (0..FUNCTIONS).map(|_| random.signed_vec(order * order)).collect();
        group.bench_function(BenchmarkId::from_parameter(order), |bencher| {
            bencher.iter(|| functions.iter().map(|f| certified_minimum(black_box(f), 1e-6).hi).sum::<f64>());
        });
    }
    group.finish();
    let mut group = c.benchmark_group("minimum-ring-f64");
    for order in [3, 5, 10] {
        let f = ShVec::<f64>::impulse(order, Dir::from_angles(1.0, 2.0), 1.0);
        group.bench_function(BenchmarkId::from_parameter(order), |bencher| {
            bencher.iter(|| certified_minimum(black_box(f.coefficients()), 1e-6));
        });
    }
    group.finish();
    let f = random.signed_vec(9);
    c.benchmark_group("minimum-bound-f64").bench_function(BenchmarkId::from_parameter(3), |bencher| {
        bencher.iter(|| conservative_minimum(black_box(&f)));
    });
}

fn window(c: &mut Criterion) {
    let mut group = c.benchmark_group("window-rgb-f32");
    group.throughput(Throughput::Elements(PROBES as u64));
    for order in [3, 6] {
        let mut probes = vec![Rgb::new(1.0_f32, 2.0, 3.0); PROBES * order * order];
        // So weak that the numbers stay in range however often it is applied.
        let window = Window::SquaredLaplacian { lambda: 1e-12 };
        group.bench_function(BenchmarkId::from_parameter(order), |bencher| {
            bencher.iter(|| {
                for f in black_box(&mut probes).chunks_exact_mut(order * order) {
                    window_in_place(f, &window);
                }
            });
        });
    }
}

fn main() {
    let mut c = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_millis(600))
        .configure_from_args();
    dering(&mut c);
    minimum(&mut c);
    window(&mut c);
    c.final_summary();
}
