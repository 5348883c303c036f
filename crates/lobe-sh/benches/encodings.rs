//! Small encodings of irradiance; see the README beside this file.

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput};
use lobe_sh::encoding::{IrradianceEncoding, IrradianceMatrix, PackedIrradiance};
use lobe_sh::{Dir, Expansion as _, Rgb, Rotation, ShL2, ShVec, Zonal};
use lobe_testkit::{Random, directions};

const PROBES: usize = 64;

/// Irradiance of a few lights, to order 5, which encodings that sample need.
fn probes() -> Vec<ShVec<Rgb>> {
    let mut random = Random::new(1);
    let cosine = Zonal::clamped_cosine(5);
    let mut probe = || {
        let mut f = ShVec::<Rgb<f64>>::constant(5, Rgb::new(0.2, 0.25, 0.3));
        for _ in 0..3 {
            let color = Rgb::new(random.unit(), random.unit(), random.unit());
            f += &ShVec::impulse(5, Dir::from_unit(random.direction()), color);
        }
        f.convolved(&cosine).map(|c| Rgb::new(c.r as f32, c.g as f32, c.b as f32))
    };
    (0..PROBES).map(|_| probe()).collect()
}

fn encodings(c: &mut Criterion) {
    let probes = probes();
    let mut group = c.benchmark_group("encode-rgb-f32");
    group.throughput(Throughput::Elements(PROBES as u64));
    for encoding in IrradianceEncoding::ALL {
        group.bench_function(BenchmarkId::from_parameter(encoding.name()), |b| {
            b.iter(|| {
                for f in &probes {
                    black_box(encoding.encode(black_box(f), Rotation::IDENTITY));
                }
            });
        });
    }
    group.finish();
    let normals: Vec<Dir> = directions().into_iter().map(Dir::from_unit).collect();
    let mut group = c.benchmark_group("decode-rgb-f32");
    group.throughput(Throughput::Elements(normals.len() as u64));
    for encoding in IrradianceEncoding::ALL {
        let encoded = encoding.encode(&probes[0], Rotation::IDENTITY);
        group.bench_function(BenchmarkId::from_parameter(encoding.name()), |b| {
            b.iter(|| normals.iter().map(|n| black_box(&encoded).eval(*n).g).sum::<f32>());
        });
    }
    let order_3 = ShL2::from_slice(&probes[0].coefficients()[..9]);
    let (packed, matrix) =
        (PackedIrradiance::from_irradiance_sh(&order_3), IrradianceMatrix::from_irradiance_sh(&order_3));
    group.bench_function("packed", |b| b.iter(|| normals.iter().map(|n| black_box(&packed).eval(*n).g).sum::<f64>()));
    group.bench_function("matrix", |b| b.iter(|| normals.iter().map(|n| black_box(&matrix).eval(*n).g).sum::<f64>()));
}

fn main() {
    let mut c = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(100))
        .measurement_time(Duration::from_millis(300))
        .configure_from_args();
    encodings(&mut c);
    c.final_summary();
}
