//! Rotation of coefficients; see the README beside this file.

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput};
use lobe_sh::Rotation;
use lobe_sh::basis::coefficient_count;
use lobe_sh::batch::ShBatch;
use lobe_sh::rotation::RotationMatrices;
use lobe_testkit::Random;

const ORDERS: [usize; 6] = [3, 4, 5, 6, 10, 64];

/// Vectors rotated by one rotation; at order 6 they and their results stay in the second-level cache.
const VECTORS: usize = 1024;

fn rotation() -> Rotation {
    Rotation::from_euler_zyz(0.3, 1.1, -2.0)
}

fn build(c: &mut Criterion) {
    let mut group = c.benchmark_group("rotation-build-f64");
    for order in ORDERS {
        group.bench_function(BenchmarkId::from_parameter(order), |b| {
            b.iter(|| RotationMatrices::<f64>::new(black_box(&rotation()), order));
        });
    }
}

/// One vector by a rotation that is new to it: no matrix is built.
fn one(c: &mut Criterion) {
    let mut group = c.benchmark_group("rotation-one-f32");
    for order in ORDERS.into_iter().chain([128, 256]) {
        let f: Vec<f32> = Random::new(1).signed_vec(coefficient_count(order)).iter().map(|x| *x as f32).collect();
        let mut g = vec![0.0; coefficient_count(order)];
        let rotation = rotation();
        group.bench_function(BenchmarkId::from_parameter(order), |b| {
            b.iter(|| black_box(&rotation).apply_into(black_box(&f), &mut g));
        });
    }
}

/// Many vectors by one prepared rotation.
fn many(c: &mut Criterion) {
    let mut group = c.benchmark_group("rotation-many-f32");
    group.throughput(Throughput::Elements(VECTORS as u64));
    for order in ORDERS {
        let matrices = RotationMatrices::<f32>::new(&rotation(), order);
        let f: Vec<f32> =
            Random::new(1).signed_vec(coefficient_count(order) * VECTORS).iter().map(|x| *x as f32).collect();
        let mut g = vec![0.0; f.len()];
        group.bench_function(BenchmarkId::from_parameter(order), |b| {
            b.iter(|| matrices.apply_many_into(VECTORS, black_box(&f), &mut g));
        });
    }
}

/// The same vectors, sixteen side by side.
fn batch(c: &mut Criterion) {
    let mut group = c.benchmark_group("rotation-batch-f32");
    group.throughput(Throughput::Elements(VECTORS as u64));
    for order in &ORDERS[..5] {
        let matrices = RotationMatrices::<f32>::new(&rotation(), *order);
        let f: Vec<f32> =
            Random::new(1).signed_vec(coefficient_count(*order) * VECTORS).iter().map(|x| *x as f32).collect();
        let f = ShBatch::from_planes(*order, VECTORS, &f);
        let mut g = ShBatch::zero(*order, VECTORS);
        group.bench_function(BenchmarkId::from_parameter(order), |b| {
            b.iter(|| black_box(&f).rotated_into(&matrices, &mut g));
        });
    }
}

fn main() {
    let mut c = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_millis(1000))
        .configure_from_args();
    build(&mut c);
    one(&mut c);
    many(&mut c);
    batch(&mut c);
    c.final_summary();
}
