//! Products of two functions; see the README beside this file.

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput};
use lobe_sh::{ShBatch, coefficient_count, product_into, square_into};
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

fn main() {
    let mut c = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_millis(1000))
        .configure_from_args();
    product(&mut c);
    square(&mut c);
    batch(&mut c);
    c.final_summary();
}
