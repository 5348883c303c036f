//! Bakes of diffuse transfer; see the README beside this file.

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput};
use lobe_io::Job;
use lobe_prt::{BakeMode, BakeOptions, Receivers, bake};
use lobe_scene::{Bvh, Scene, built_in};

/// Paths from each receiver.
const SAMPLES: u32 = 256;

fn bakes(c: &mut Criterion) {
    for (name, scene) in [("ball", built_in::ball_over_ground(48)), ("columns", built_in::columns_hall(1))] {
        let bvh = Bvh::new(&scene);
        let receivers = thinned(&scene, 512);
        let mut group = c.benchmark_group(format!("bake-{name}"));
        group.sample_size(10).measurement_time(Duration::from_secs(3));
        for (mode, bounces, order) in [
            (BakeMode::Shadowed, 0, 4),
            (BakeMode::Shadowed, 0, 8),
            (BakeMode::Interreflected, 1, 4),
            (BakeMode::Interreflected, 2, 4),
            (BakeMode::Interreflected, 2, 8),
        ] {
            let options =
                BakeOptions::default().mode(mode).bounces(bounces).order(order).samples(SAMPLES).energy_stop(0.0);
            let bake = || bake(&scene, &bvh, &receivers, &options, Job::default());
            let Ok((_, report)) = bake() else { unreachable!("the options are in range") };
            // The pilot is timed with the rest and counted here: of 512 receivers it bakes 64 once and 8 of them 8
            // times.
            let pilot = f64::from(64 + 8 * 8) / receivers.len() as f64;
            group.throughput(Throughput::Elements((report.rays as f64 * (1.0 + pilot)) as u64));
            let name = format!("{mode:?}-{bounces}-bounces-order-{order}");
            group.bench_function(BenchmarkId::from_parameter(name), |b| b.iter(|| black_box(bake())));
        }
    }
}

/// `count` receivers evenly out of all vertices.
fn thinned(scene: &Scene, count: usize) -> Receivers {
    let thinned = Receivers::at_vertices(scene).and_then(|all| {
        let pick = |v: &[[f32; 3]]| (0..count).map(|k| v[k * all.len() / count]).collect();
        Receivers::new(pick(all.positions()), pick(all.normals()), pick(all.albedos()))
    });
    match thinned {
        Ok(receivers) => receivers,
        Err(error) => unreachable!("the vertices of built-in scenes receive: {error}"),
    }
}

fn main() {
    let mut criterion = Criterion::default().configure_from_args();
    bakes(&mut criterion);
    criterion.final_summary();
}
