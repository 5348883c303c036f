//! Prefiltering for glossy reflection; see the README beside this file.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion};
use lobe_env::{CubeMap, PrefilterOptions, SpecularLobe, bundled, filter_lobe, prefilter_ggx};
use lobe_io::Job;
use rayon::ThreadPoolBuilder;

fn chain(c: &mut Criterion) {
    let map = bundled::sunset().map();
    let source = CubeMap::from_fn(256, |s| map.radiance(s));
    let options = PrefilterOptions::default();
    for threads in [1, 2] {
        let pool = match ThreadPoolBuilder::new().num_threads(threads).build() {
            Ok(pool) => pool,
            Err(error) => panic!("no pool of {threads} threads: {error}"),
        };
        let mut group = c.benchmark_group("ggx-chain-256-to-16");
        group.sample_size(10);
        group.bench_function(BenchmarkId::from_parameter(threads), |b| {
            b.iter(|| pool.install(|| prefilter_ggx(black_box(&source), &options, Job::default())));
        });
        drop(group);
        let mut group = c.benchmark_group(format!("phong-64-{threads}-threads"));
        group.sample_size(10);
        for exponent in [10.0, 100.0] {
            let lobe = SpecularLobe::Phong { exponent };
            group.bench_function(BenchmarkId::from_parameter(exponent), |b| {
                b.iter(|| {
                    pool.install(|| filter_lobe(black_box(&source), lobe, 64, options.tolerance, Job::default()))
                });
            });
        }
    }
}

fn main() {
    let mut criterion = Criterion::default().configure_from_args();
    chain(&mut criterion);
    criterion.final_summary();
}
