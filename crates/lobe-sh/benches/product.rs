//! Products of two functions; see the README beside this file.

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput};
use lobe_sh::basis::coefficient_count;
use lobe_sh::batch::ShBatch;
use lobe_sh::exponential::{LOG_CLAMP, logarithm, logarithm_batch_in_place};
use lobe_sh::product::{product_into, square_into};
use lobe_sh::{Dir, ShVec, Zonal};
use lobe_testkit::Random;

const ORDERS: [usize; 8] = [2, 3, 4, 5, 6, 7, 8, 10];

/// Pairs that are multiplied; at order 6 they and their products stay in the second-level cache.
const PAIRS: usize = 512;

fn functions(seed: u64, order: usize) -> Vec<f32> {
    Random::new(seed).signed_vec(PAIRS * coefficient_count(order)).iter().map(|x| *x as f32).collect()
}

fn product(c: &mut Criterion) {
    let mut group = c.benchmark_group("product-f32");
    group.throughput(Throughput::Elements(PAIRS as u64));
    for order in ORDERS {
        let n = coefficient_count(order);
        let (a, b, mut out) = (functions(1, order), functions(2, order), vec![0.0; PAIRS * n]);
        group.bench_function(BenchmarkId::from_parameter(order), |bencher| {
            bencher.iter(|| {
                let pairs = black_box(&a).chunks_exact(n).zip(black_box(&b).chunks_exact(n));
                for ((a, b), out) in pairs.zip(out.chunks_exact_mut(n)) {
                    product_into(a, b, out);
                }
            });
        });
    }
}

fn square(c: &mut Criterion) {
    let mut group = c.benchmark_group("square-f32");
    group.throughput(Throughput::Elements(PAIRS as u64));
    for order in ORDERS {
        let n = coefficient_count(order);
        let (a, mut out) = (functions(1, order), vec![0.0; PAIRS * n]);
        group.bench_function(BenchmarkId::from_parameter(order), |bencher| {
            bencher.iter(|| {
                for (a, out) in black_box(&a).chunks_exact(n).zip(out.chunks_exact_mut(n)) {
                    square_into(a, out);
                }
            });
        });
    }
}

/// The same pairs and squares, sixteen side by side.
fn batch(c: &mut Criterion) {
    for (name, squared) in [("product-batch-f32", false), ("square-batch-f32", true)] {
        let mut group = c.benchmark_group(name);
        group.throughput(Throughput::Elements(PAIRS as u64));
        for order in ORDERS {
            let batch = |seed| ShBatch::from_planes(order, PAIRS, &functions(seed, order));
            let (a, b, mut out) = (batch(1), batch(2), ShBatch::zero(order, PAIRS));
            group.bench_function(BenchmarkId::from_parameter(order), |bencher| {
                bencher.iter(|| {
                    if squared { black_box(&a).square_into(&mut out) } else { black_box(&a).product_into(&b, &mut out) }
                });
            });
        }
    }
}

/// Visibilities whose logarithms are taken, by which products become sums.
const VISIBILITIES: usize = 64;

/// Logarithms of what two spheres leave visible, one after the other in `f64`, and side by side.
fn logarithms(c: &mut Criterion) {
    for order in [3, 4, 6] {
        let mut random = Random::new(3);
        let mut visible = || {
            let mut f = ShVec::constant(order, 1.0_f32);
            for angle in [0.2, 0.5] {
                f += &Zonal::cone(order, angle).towards(Dir::from_unit(random.direction()), -1.0);
            }
            f
        };
        let functions: Vec<ShVec<f32>> = (0..VISIBILITIES).map(|_| visible()).collect();
        let mut group = c.benchmark_group("logarithm");
        group.throughput(Throughput::Elements(VISIBILITIES as u64));
        let wide: Vec<ShVec<f64>> = functions.iter().map(|f| f.map(f64::from)).collect();
        group.bench_function(BenchmarkId::new("one", order), |bencher| {
            bencher.iter(|| {
                for f in black_box(&wide) {
                    black_box(logarithm(f, LOG_CLAMP));
                }
            });
        });
        let batch = ShBatch::from_functions(&functions);
        let mut work = batch.clone();
        group.bench_function(BenchmarkId::new("batch", order), |bencher| {
            bencher.iter(|| {
                work.blocks_mut().copy_from_slice(black_box(&batch).blocks());
                logarithm_batch_in_place(&mut work, LOG_CLAMP);
            });
        });
    }
}

fn main() {
    let mut c = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_millis(1000))
        .configure_from_args();
    product(&mut c);
    square(&mut c);
    batch(&mut c);
    logarithms(&mut c);
    c.final_summary();
}
