//! Evaluation of the basis; see the README beside this file.

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput};
use lobe_sh::basis::{Basis, band_and_m, coefficient_count, eval_basis_into};
use lobe_sh::batch::{DirBatch, ShBatch};
use lobe_testkit::Random;
use sphrs::{Coordinates, HarmonicsSet, RealSH};

const ORDERS: [usize; 7] = [2, 3, 4, 5, 6, 10, 20];

/// Directions whose components and values of order 6 stay in the first-level cache.
const CACHED: usize = 256;

/// Directions whose values leave every cache.
const STREAMED: usize = 1_000_000;

/// Components of `count` directions, one vector each.
fn directions(count: usize) -> [Vec<f32>; 3] {
    let mut random = Random::new(1);
    let all: Vec<[f64; 3]> = (0..count).map(|_| random.direction()).collect();
    [0, 1, 2].map(|k| all.iter().map(|v| v[k] as f32).collect())
}

fn many(c: &mut Criterion, name: &str, count: usize) {
    let mut group = c.benchmark_group(name);
    group.throughput(Throughput::Elements(count as u64));
    let [x, y, z] = directions(count);
    for order in ORDERS {
        let basis = Basis::<f32>::new(order);
        let mut out = vec![0.0; coefficient_count(order) * count];
        group.bench_function(BenchmarkId::from_parameter(order), |b| {
            b.iter(|| basis.eval_many_into(black_box([&x, &y, &z]), &mut out));
        });
    }
}

fn sums(c: &mut Criterion, name: &str, count: usize) {
    let mut group = c.benchmark_group(name);
    group.throughput(Throughput::Elements(count as u64));
    let [x, y, z] = directions(count);
    for order in ORDERS {
        let basis = Basis::<f32>::new(order);
        let f: Vec<f32> = Random::new(3).signed_vec(coefficient_count(order)).iter().map(|c| *c as f32).collect();
        let mut out = vec![0.0; count];
        group.bench_function(BenchmarkId::from_parameter(order), |b| {
            b.iter(|| basis.eval_expansion_into(black_box(&f), [&x, &y, &z], &mut out));
        });
    }
}

fn batch(c: &mut Criterion, name: &str, count: usize) {
    let mut group = c.benchmark_group(name);
    group.throughput(Throughput::Elements(count as u64));
    let [x, y, z] = directions(count);
    let directions = DirBatch::from_components([&x, &y, &z]);
    for order in &ORDERS[..6] {
        let mut out = ShBatch::zero(*order, count);
        group.bench_function(BenchmarkId::from_parameter(order), |b| {
            b.iter(|| out.set_basis(black_box(&directions)));
        });
    }
}

fn one(c: &mut Criterion) {
    let mut group = c.benchmark_group("basis-one-f64");
    let mut random = Random::new(2);
    let directions: Vec<[f64; 3]> = (0..CACHED).map(|_| random.direction()).collect();
    group.throughput(Throughput::Elements(CACHED as u64));
    for order in ORDERS {
        let mut out = vec![0.0; coefficient_count(order)];
        group.bench_function(BenchmarkId::new("lobe", order), |b| {
            b.iter(|| {
                for s in &directions {
                    eval_basis_into(black_box(*s), &mut out);
                }
                out[0]
            });
        });
        let peer = HarmonicsSet::new(order - 1, RealSH::Spherical);
        if !agrees(&peer, order, directions[0]) {
            println!("basis-one-f64/sphrs/{order} is left out: the peer's numbers are wrong at this order");
            continue;
        }
        group.bench_function(BenchmarkId::new("sphrs", order), |b| {
            b.iter(|| {
                for [x, y, z] in &directions {
                    black_box(peer.eval(&Coordinates::cartesian(black_box(*x), *y, *z)));
                }
            });
        });
    }
}

/// Whether the peer gives our numbers, up to the sign of its odd `m`.
fn agrees(peer: &HarmonicsSet<f64, RealSH>, order: usize, [x, y, z]: [f64; 3]) -> bool {
    let mut ours = vec![0.0; coefficient_count(order)];
    eval_basis_into([x, y, z], &mut ours);
    let theirs = peer.eval(&Coordinates::cartesian(x, y, z));
    (0..coefficient_count(order)).all(|i| {
        let sign = if band_and_m(i).1 % 2 == 0 { 1.0 } else { -1.0 };
        (theirs[i] - sign * ours[i]).abs() < 1e-9 || (theirs[i] - ours[i]).abs() < 1e-9
    })
}

fn main() {
    let mut c = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_millis(1000))
        .configure_from_args();
    many(&mut c, "basis-cached-f32", CACHED);
    many(&mut c, "basis-streamed-f32", STREAMED);
    batch(&mut c, "basis-batch-cached-f32", CACHED);
    batch(&mut c, "basis-batch-streamed-f32", STREAMED);
    sums(&mut c, "values-cached-f32", CACHED);
    one(&mut c);
    c.final_summary();
}
