//! Projection, reconstruction and brute-force irradiance; see the README beside this file.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput};
use lobe_env::{
    EnvMap, MappedMap, Mapping, Resample, bundled, irradiance_at, project_env, project_map, reconstruct, resample,
};
use lobe_io::Job;
use lobe_sh::{Dir, Rgb};
use rayon::{ThreadPool, ThreadPoolBuilder};

const SIZE: (usize, usize) = (2048, 1024);
const ORDERS: [usize; 6] = [3, 6, 16, 64, 128, 256];
const NORMALS: usize = 256;

fn pool(threads: usize) -> ThreadPool {
    match ThreadPoolBuilder::new().num_threads(threads).build() {
        Ok(pool) => pool,
        Err(error) => panic!("no pool of {threads} threads: {error}"),
    }
}

fn project(c: &mut Criterion) {
    let map = EnvMap::from_fn(SIZE.0, SIZE.1, |s| Rgb::new(1.0 + s.x() as f32, 2.0 + s.y() as f32, 0.5));
    for threads in [1, 2] {
        let pool = pool(threads);
        let mut group = c.benchmark_group(format!("project-{threads}-threads"));
        group.throughput(Throughput::Elements((SIZE.0 * SIZE.1) as u64)).sample_size(20);
        for order in ORDERS {
            group.bench_function(BenchmarkId::from_parameter(order), |b| {
                b.iter(|| pool.install(|| project_env(black_box(&map), order)));
            });
        }
        drop(group);
        let mut group = c.benchmark_group(format!("reconstruct-{threads}-threads"));
        group.throughput(Throughput::Elements((SIZE.0 * SIZE.1) as u64)).sample_size(10);
        for order in ORDERS {
            let f = project_env(&map, order);
            group.bench_function(BenchmarkId::from_parameter(order), |b| {
                b.iter(|| pool.install(|| reconstruct(black_box(&f), SIZE.0, SIZE.1)));
            });
        }
    }
}

/// Each with a lat-long map of as many texels, to compare with.
fn project_planes(c: &mut Criterion) {
    let mut group = c.benchmark_group("project-order-8");
    group.sample_size(10);
    for (mapping, width) in
        [(Mapping::LatLong, 3548), (Mapping::Cube, 1024), (Mapping::LatLong, 1448), (Mapping::Octahedral, 1024)]
    {
        let height = mapping.height_for(width);
        let map = MappedMap::from_fn(mapping, width, height, |s| Rgb::new(1.0 + s.x() as f32, 2.0 + s.y() as f32, 0.5));
        group.throughput(Throughput::Elements((width * height) as u64));
        group.bench_function(BenchmarkId::new(mapping.name(), width), |b| b.iter(|| project_map(black_box(&map), 8)));
    }
}

fn irradiance(c: &mut Criterion) {
    let map = bundled::studio().map();
    let normals: Vec<Dir> = (0..NORMALS).map(|k| Dir::from_angles(0.012 * k as f64, k as f64)).collect();
    let mut group = c.benchmark_group("irradiance-brute-force");
    group.throughput(Throughput::Elements((NORMALS * map.texels().len()) as u64)).sample_size(10);
    for threads in [1, 2] {
        let pool = pool(threads);
        group.bench_function(BenchmarkId::from_parameter(threads), |b| {
            b.iter(|| pool.install(|| irradiance_at(black_box(&map), black_box(&normals))));
        });
    }
}

fn convert(c: &mut Criterion) {
    let map = EnvMap::from_fn(4096, 2048, |s| Rgb::new(1.0 + s.x() as f32, 2.0 + s.y() as f32, 0.5));
    let to = Resample::to(Mapping::Cube, 1024, 6 * 1024);
    let mut group = c.benchmark_group("convert-4096-to-cube-1024");
    group.throughput(Throughput::Elements(map.texels().len() as u64)).sample_size(10);
    for threads in [1, 2] {
        let pool = pool(threads);
        group.bench_function(BenchmarkId::from_parameter(threads), |b| {
            b.iter(|| pool.install(|| resample(black_box(&map), &to, Job::default())));
        });
    }
}

fn main() {
    let mut criterion = Criterion::default().configure_from_args();
    project(&mut criterion);
    project_planes(&mut criterion);
    irradiance(&mut criterion);
    convert(&mut criterion);
    criterion.final_summary();
}
