//! Occlusion rays: throughput; see the README beside this file.

use std::alloc::System;
use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput};
use lobe_io::{HugePages, choose_huge_pages};
use lobe_scene::{Bvh, Ray, Simd};

#[path = "rays/obvhs_peer.rs"]
mod obvhs_peer;
#[path = "rays/workload.rs"]
mod workload;

use obvhs_peer::Obvhs;
use workload::{RAYS_PER_POINT, Workload};

#[global_allocator]
static ALLOCATOR: HugePages<System> = HugePages::new(System).growing_by_remapping();

/// Traces rays from a point, and returns a number that depends on the hits.
type Trace<'a> = dyn FnMut([f32; 3], &[[f32; 3]]) -> usize + 'a;

/// Cells along a side of the height field and around each of the 64 balls: about 100 thousand and 1 million triangles.
const SIZES: [(&str, usize, usize); 2] = [("100k", 100, 36), ("1M", 320, 112)];

fn rays(c: &mut Criterion) {
    for (size, cells, around) in SIZES {
        let work = Workload::new(cells, around);
        let bvh = Bvh::from_corners(&work.corners);
        let narrower: Vec<_> =
            Simd::ALL.into_iter().filter_map(|simd| Some((simd, bvh.clone().with_simd(simd)?))).collect();
        let obvhs = Obvhs::new(&work.corners);
        let rays = (work.points.len() * RAYS_PER_POINT) as f64;
        let mut occluded = vec![false; RAYS_PER_POINT];
        let ours: usize = work.count(|origin, directions| {
            bvh.occluded_from_into(origin, directions, &mut occluded);
            occluded.iter().filter(|&&o| o).count()
        });
        let peers: usize = work.count(|origin, directions| obvhs.occluded(origin, directions));
        println!(
            "{size}: {} triangles, {:.1} bytes each; occluded {:.4}, by obvhs {:.4}",
            work.corners.len(),
            bvh.bytes() as f64 / work.corners.len() as f64,
            ours as f64 / rays,
            peers as f64 / rays
        );
        let mut group = c.benchmark_group(format!("occlusion-{size}"));
        group.throughput(Throughput::Elements(rays as u64)).sample_size(10).measurement_time(Duration::from_secs(3));
        let ordered = work.ordered();
        let mut measure = |name: &str, work: &Workload, trace: &mut Trace<'_>| {
            group.bench_function(BenchmarkId::from_parameter(name), |b| {
                b.iter(|| black_box(work.count(&mut *trace)));
            });
        };
        for (name, work) in [("together", &work), ("ordered", &ordered)] {
            measure(name, work, &mut |origin, directions| {
                bvh.occluded_from_into(origin, directions, &mut occluded);
                usize::from(occluded[0])
            });
        }
        measure("single", &work, &mut |origin, directions| {
            directions.iter().filter(|&&d| bvh.is_occluded(&Ray::new(origin, d))).count()
        });
        for (simd, bvh) in &narrower {
            measure(&format!("together-{simd:?}").to_lowercase(), &work, &mut |origin, directions| {
                bvh.occluded_from_into(origin, directions, &mut occluded);
                usize::from(occluded[0])
            });
        }
        measure("closest", &work, &mut |origin, directions| {
            directions.iter().filter(|&&d| bvh.closest(&Ray::new(origin, d)).is_some()).count()
        });
        let mut hits = vec![None; RAYS_PER_POINT];
        measure("closest-together", &work, &mut |origin, directions| {
            bvh.closest_from_into(origin, directions, &mut hits);
            usize::from(hits[0].is_some())
        });
        measure("obvhs", &work, &mut |origin, directions| obvhs.occluded(origin, directions));
        measure("obvhs-ordered", &ordered, &mut |origin, directions| obvhs.occluded(origin, directions));
        drop(group);
        let mut group = c.benchmark_group(format!("build-{size}"));
        group.throughput(Throughput::Elements(work.corners.len() as u64)).sample_size(10);
        group.bench_function("lobe", |b| b.iter(|| Bvh::from_corners(black_box(&work.corners))));
        group.bench_function("obvhs", |b| b.iter(|| Obvhs::new(black_box(&work.corners))));
    }
}

fn main() {
    choose_huge_pages().expect("on or off");
    let mut criterion = Criterion::default().configure_from_args();
    rays(&mut criterion);
    criterion.final_summary();
}
