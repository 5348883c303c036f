//! Rays and trees of lobe-scene beside those of Embree 4, one thread; see the README beside this file.

use std::alloc::System;
use std::time::Instant;

use lobe_io::HugePages;
use lobe_scene::{Bvh, Ray};

mod embree;
#[path = "../../../crates/lobe-scene/benches/rays/workload.rs"]
mod workload;

use embree::Embree;
use workload::{RAYS_PER_POINT, Workload};

/// As in Lobe's programs; Embree asks for huge pages by itself.
#[global_allocator]
static ALLOCATOR: HugePages<System> = HugePages::new(System).growing_by_remapping();

/// The sizes of `benches/rays.rs`: cells along the height field and around each ball.
const SIZES: [(&str, usize, usize); 2] = [("100k", 100, 36), ("1M", 320, 112)];

/// Rounds; in each, every tracer answers all rays once, so that a busy machine slows all of them alike.
const ROUNDS: usize = 21;

/// Rounds of builds, which take longer.
const BUILDS: usize = 7;

/// The part of what is counted by which two tracers may differ: rays that graze an edge.
const SAME: f64 = 1e-4;

/// What the rays from a point find: how many are occluded, or the sum of the distances.
type Trace<'a> = Box<dyn FnMut([f32; 3], &[[f32; 3]]) -> f64 + 'a>;

/// A tracer and its name.
type Tracer<'a> = (&'static str, Trace<'a>);

fn main() -> Result<(), rayon::ThreadPoolBuildError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    pool.install(|| {
        for (size, cells, around) in SIZES {
            compare(size, &Workload::new(cells, around));
        }
    });
    Ok(())
}

fn compare(size: &str, work: &Workload) {
    println!(
        "{size}: {} triangles, {RAYS_PER_POINT} rays from each of {} points",
        work.corners.len(),
        work.points.len()
    );
    builds(&work.corners);
    let bvh = Bvh::from_corners(&work.corners);
    let (fast, robust) = (Embree::new(&work.corners, false), Embree::new(&work.corners, true));
    let ordered = work.ordered();
    for (order, work) in [("any order", work), ("ordered", &ordered)] {
        rays(
            &format!("occlusion, the rays of a point in one call, {order}"),
            work,
            occlusion(together(&bvh), &fast, &robust),
        );
        rays(
            &format!("occlusion, 256 rays in one call as if of many points, {order}"),
            work,
            occlusion(independent(&bvh), &fast, &robust),
        );
        rays(&format!("occlusion, one ray in a call, {order}"), work, occlusion(single(&bvh), &fast, &robust));
        rays(
            &format!("closest hit, the rays of a point in one call, {order}"),
            work,
            closest(closest_together(&bvh), &fast, &robust),
        );
        rays(
            &format!("closest hit, 256 rays in one call as if of many points, {order}"),
            work,
            closest(closest_independent(&bvh), &fast, &robust),
        );
        rays(&format!("closest hit, one ray in a call, {order}"), work, closest(closest_single(&bvh), &fast, &robust));
    }
}

/// The time for the tree, the triangles at hand in the layout that each reads.
fn builds(corners: &[[[f32; 3]; 3]]) {
    let mut seconds = [const { Vec::new() }; 3];
    for _ in 0..BUILDS {
        let start = Instant::now();
        let bvh = Bvh::from_corners(corners);
        seconds[0].push(start.elapsed().as_secs_f64());
        drop(bvh);
        seconds[1].push(Embree::new(corners, false).build_seconds);
        seconds[2].push(Embree::new(corners, true).build_seconds);
    }
    println!("  build");
    for (name, of_it) in ["lobe", "embree", "embree robust"].iter().zip(&seconds) {
        println!(
            "    {name:14} {:7.1} ms        lobe's time / its {:5.3}",
            1e3 * median(of_it),
            ratio(&seconds[0], of_it)
        );
    }
}

fn together(bvh: &Bvh) -> Trace<'_> {
    let mut occluded = vec![false; RAYS_PER_POINT];
    Box::new(move |origin, directions| {
        bvh.occluded_from_into(origin, directions, &mut occluded);
        occluded.iter().filter(|&&o| o).count() as f64
    })
}

fn independent(bvh: &Bvh) -> Trace<'_> {
    let (mut rays, mut occluded) = (Vec::new(), vec![false; RAYS_PER_POINT]);
    Box::new(move |origin, directions| {
        rays.clear();
        rays.extend(directions.iter().map(|&direction| Ray::new(origin, direction)));
        bvh.occluded_into(&rays, &mut occluded);
        occluded.iter().filter(|&&o| o).count() as f64
    })
}

fn single(bvh: &Bvh) -> Trace<'_> {
    Box::new(|origin, directions| {
        directions.iter().filter(|&&direction| bvh.is_occluded(&Ray::new(origin, direction))).count() as f64
    })
}

fn occlusion<'a>(lobe: Trace<'a>, fast: &'a Embree, robust: &'a Embree) -> [Tracer<'a>; 3] {
    [
        ("lobe", lobe),
        ("embree", Box::new(|origin, directions| fast.occluded(origin, directions))),
        ("embree robust", Box::new(|origin, directions| robust.occluded(origin, directions))),
    ]
}

fn closest_together(bvh: &Bvh) -> Trace<'_> {
    let mut hits = vec![None; RAYS_PER_POINT];
    Box::new(move |origin, directions| {
        bvh.closest_from_into(origin, directions, &mut hits);
        hits.iter().flatten().map(|hit| f64::from(hit.t)).sum()
    })
}

fn closest_independent(bvh: &Bvh) -> Trace<'_> {
    let (mut rays, mut hits) = (Vec::new(), vec![None; RAYS_PER_POINT]);
    Box::new(move |origin, directions| {
        rays.clear();
        rays.extend(directions.iter().map(|&direction| Ray::new(origin, direction)));
        bvh.closest_into(&rays, &mut hits);
        hits.iter().flatten().map(|hit| f64::from(hit.t)).sum()
    })
}

fn closest_single(bvh: &Bvh) -> Trace<'_> {
    Box::new(|origin, directions| {
        let hits = directions.iter().filter_map(|&direction| bvh.closest(&Ray::new(origin, direction)));
        hits.map(|hit| f64::from(hit.t)).sum()
    })
}

fn closest<'a>(lobe: Trace<'a>, fast: &'a Embree, robust: &'a Embree) -> [Tracer<'a>; 3] {
    [
        ("lobe", lobe),
        ("embree", Box::new(|origin, directions| fast.closest(origin, directions))),
        ("embree robust", Box::new(|origin, directions| robust.closest(origin, directions))),
    ]
}

/// Times all tracers in turns, and fails where they find something else.
fn rays(job: &str, work: &Workload, mut tracers: [Tracer<'_>; 3]) {
    let mut seconds = [const { Vec::new() }; 3];
    let mut found = [0.0; 3];
    for _ in 0..ROUNDS {
        for (k, (_, trace)) in tracers.iter_mut().enumerate() {
            let start = Instant::now();
            found[k] = work.points.iter().map(|(origin, directions)| trace(*origin, directions)).sum();
            seconds[k].push(start.elapsed().as_secs_f64());
        }
    }
    let count = (work.points.len() * RAYS_PER_POINT) as f64;
    println!("  {job}");
    for ((name, _), (of_it, sum)) in tracers.iter().zip(seconds.iter().zip(found)) {
        let off = (sum - found[0]).abs() / found[0];
        assert!(off < SAME, "{job}: {name} finds {sum}, lobe {}: {off} apart", found[0]);
        println!(
            "    {name:14} {:7.2} Mrays/s   lobe's rate / its {:5.3}",
            count / median(of_it) / 1e6,
            ratio(of_it, &seconds[0])
        );
    }
}

/// The median of the ratios of all rounds: what slows a round slows both.
fn ratio(seconds: &[f64], others: &[f64]) -> f64 {
    median(&seconds.iter().zip(others).map(|(a, b)| a / b).collect::<Vec<_>>())
}

fn median(seconds: &[f64]) -> f64 {
    let mut sorted = seconds.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[sorted.len() / 2]
}
