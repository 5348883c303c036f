//! Poses, and trees over them: refit or built anew; see the README beside this file.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion};
use lobe_scene::{AnimatedScene, Bvh, built_in};

#[path = "rays/workload.rs"]
mod workload;

use workload::{RAYS_PER_POINT, Workload};

/// Vertices around the limbs of the figure: about 5 and 50 thousand vertices.
const SIZES: [(&str, usize); 2] = [("5k", 24), ("50k", 75)];

/// The poses that a tree is refit to after it was built for the first, as parts of the walk.
const POSES: usize = 8;

fn poses(c: &mut Criterion) {
    for (size, around) in SIZES {
        let figure = built_in::walking_figure(around);
        let scenes: Vec<_> = (0..=POSES).map(|k| pose(&figure, k)).collect();
        let first = Bvh::new(&scenes[0]);
        println!("{size}: {} vertices, {} triangles", figure.rest().vertex_count(), figure.rest().triangle_count());
        let mut group = c.benchmark_group(format!("poses-{size}"));
        group.sample_size(10);
        let id = BenchmarkId::from_parameter;
        group.bench_function(id("pose"), |b| b.iter(|| black_box(pose(&figure, 3))));
        group.bench_function(id("build"), |b| b.iter(|| Bvh::new(black_box(&scenes[3]))));
        let mut refit = first.clone();
        group.bench_function(id("refit"), |b| b.iter(|| refit.refit(black_box(&scenes[3]))));
        for (k, scene) in scenes.iter().enumerate() {
            refit.refit(scene);
            let built = Bvh::new(scene);
            println!(
                "{size}, pose {k}: expected cost {:.3} of that built anew",
                refit.expected_cost() / built.expected_cost()
            );
        }
        // Half of the walk away from the pose it was built for, legs and arms have changed places.
        let far = &scenes[POSES / 2];
        refit.refit(far);
        let (built, work) = (Bvh::new(far), Workload::among(far.corners().collect()));
        for (name, bvh) in [("rays-built", &built), ("rays-refit", &refit)] {
            let mut occluded = vec![false; RAYS_PER_POINT];
            group.bench_function(id(name), |b| {
                b.iter(|| {
                    work.count(|origin, directions| {
                        bvh.occluded_from_into(origin, directions, &mut occluded);
                        usize::from(occluded[0])
                    })
                });
            });
        }
    }
}

fn pose(figure: &AnimatedScene, k: usize) -> lobe_scene::Scene {
    let time = figure.animations()[0].duration() * k as f64 / POSES as f64;
    match figure.pose(0, time) {
        Ok(posed) => posed.into_scene(),
        Err(error) => panic!("the figure walks: {error}"),
    }
}

fn main() {
    let mut criterion = Criterion::default().configure_from_args();
    poses(&mut criterion);
    criterion.final_summary();
}
