//! Lights into and out of expansions; see the README beside this file.

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput};
use lobe_sh::light::SphericalPolygon;
use lobe_sh::light_extraction::{LightFitOptions, PeakSearch, extract_light, extract_lights, local_maxima};
use lobe_sh::{Dir, Rgb, ShVec, Zonal};
use lobe_testkit::Random;

const ORDERS: [usize; 5] = [2, 3, 4, 5, 6];

/// Expansions that a benchmark goes through, so that no branch is learned by heart.
const EXPANSIONS: usize = 64;

const POLYGON_CORNERS: usize = 4;

fn expansions(order: usize) -> Vec<ShVec<f64>> {
    let expansion = |seed: usize| ShVec::from_vec(Random::new(seed as u64).signed_vec(order * order));
    (0..EXPANSIONS).filter_map(expansion).collect()
}

fn extraction(c: &mut Criterion) {
    let colors = |order| -> Vec<ShVec<Rgb<f64>>> {
        expansions(order).iter().map(|f| f.map(|c| Rgb::new(c, 0.8 * c, 0.5 * c))).collect()
    };
    let mut group = c.benchmark_group("light-extract-one-rgb");
    group.throughput(Throughput::Elements(EXPANSIONS as u64));
    for order in ORDERS {
        let all = colors(order);
        group.bench_function(BenchmarkId::from_parameter(order), |b| {
            b.iter(|| all.iter().filter_map(|f| extract_light(black_box(f)).ok()).count());
        });
    }
    group.finish();
    for (name, refine) in [("light-extract-three-rgb", false), ("light-extract-three-refined-rgb", true)] {
        let options = LightFitOptions::default().count(3).refine(refine);
        let mut group = c.benchmark_group(name);
        group.throughput(Throughput::Elements(EXPANSIONS as u64));
        for order in ORDERS {
            let all = colors(order);
            group.bench_function(BenchmarkId::from_parameter(order), |b| {
                b.iter(|| all.iter().filter_map(|f| extract_lights(black_box(f), &options).ok()).count());
            });
        }
    }
}

fn peaks(c: &mut Criterion) {
    for (name, search) in [("light-peaks-grid", PeakSearch::Grid), ("light-peaks-paper", PeakSearch::Paper)] {
        let mut group = c.benchmark_group(name);
        group.throughput(Throughput::Elements(EXPANSIONS as u64));
        for order in ORDERS {
            let all = expansions(order);
            group.bench_function(BenchmarkId::from_parameter(order), |b| {
                b.iter(|| all.iter().map(|f| local_maxima(black_box(f), search).len()).sum::<usize>());
            });
        }
    }
}

/// An item is an edge.
fn polygon(c: &mut Criterion) {
    let mut group = c.benchmark_group("light-polygon-edge");
    group.throughput(Throughput::Elements(POLYGON_CORNERS as u64));
    let corners = vec![[1.0, -0.4, 0.1], [1.0, 0.5, 0.0], [1.1, 0.6, 0.9], [0.9, -0.5, 1.0]];
    let Ok(polygon) = SphericalPolygon::new(corners) else { return };
    for order in [2, 3, 4, 5, 6, 10] {
        let mut out = vec![0.0; order * order];
        group.bench_function(BenchmarkId::from_parameter(order), |b| {
            b.iter(|| black_box(&polygon).project_into(&mut out));
        });
    }
}

fn cones(c: &mut Criterion) {
    let mut group = c.benchmark_group("light-soft-cone");
    for order in [3, 6, 10] {
        let mut out = vec![0.0; order * order];
        group.bench_function(BenchmarkId::from_parameter(order), |b| {
            b.iter(|| Zonal::soft_cone(order, black_box(0.3)).towards_into(black_box(Dir::X), 1.0, &mut out));
        });
    }
}

fn main() {
    let mut c = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_millis(1000))
        .configure_from_args();
    extraction(&mut c);
    peaks(&mut c);
    polygon(&mut c);
    cones(&mut c);
    c.final_summary();
}
