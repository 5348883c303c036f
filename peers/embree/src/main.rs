//! Occlusion rays of lobe-scene beside those of Embree 3, one thread; see the README beside this file.

use std::time::Instant;

use lobe_scene::Bvh;

mod embree;
#[path = "../../../crates/lobe-scene/benches/rays/workload.rs"]
mod workload;

use embree::Embree;
use workload::{RAYS_PER_POINT, Workload};

/// The sizes of `benches/rays.rs`: cells along the height field and around each ball.
const SIZES: [(&str, usize, usize); 2] = [("100k", 100, 36), ("1M", 320, 112)];

/// Rounds; in each, every tracer answers all rays once, so that a busy machine slows all of them alike.
const ROUNDS: usize = 21;

/// The part of all rays by which two tracers may differ about what is occluded: those that graze an edge.
const SAME: f64 = 1e-4;

type Trace<'a> = Box<dyn FnMut([f32; 3], &[[f32; 3]]) -> usize + 'a>;

fn main() {
    for (size, cells, around) in SIZES {
        let work = Workload::new(cells, around);
        compare(size, "any order", &work);
        compare(size, "ordered", &work.ordered());
    }
}

fn compare(size: &str, order: &str, work: &Workload) {
    let bvh = Bvh::from_corners(&work.corners);
    let (fast, robust) = (Embree::new(&work.corners, false), Embree::new(&work.corners, true));
    let mut occluded = vec![false; RAYS_PER_POINT];
    let mut tracers: [(&str, Trace<'_>); 3] = [
        (
            "lobe",
            Box::new(|origin, directions| {
                bvh.occluded_from_into(origin, directions, &mut occluded);
                occluded.iter().filter(|&&o| o).count()
            }),
        ),
        ("embree", Box::new(|origin, directions| fast.occluded(origin, directions))),
        ("embree robust", Box::new(|origin, directions| robust.occluded(origin, directions))),
    ];
    let rays = (work.points.len() * RAYS_PER_POINT) as f64;
    let mut seconds = [const { Vec::new() }; 3];
    let mut counts = [0; 3];
    for _ in 0..ROUNDS {
        for (k, (_, trace)) in tracers.iter_mut().enumerate() {
            let start = Instant::now();
            counts[k] = work.count(&mut *trace);
            seconds[k].push(start.elapsed().as_secs_f64());
        }
    }
    let median = |k: usize| {
        let mut sorted = seconds[k].clone();
        sorted.sort_by(f64::total_cmp);
        sorted[ROUNDS / 2]
    };
    println!("{size}, {} triangles, {RAYS_PER_POINT} rays from each point, {order}", work.corners.len());
    for (k, (name, _)) in tracers.iter().enumerate() {
        let (rate, part) = (rays / median(k) / 1e6, counts[k] as f64 / rays);
        let difference = (part - counts[0] as f64 / rays).abs();
        assert!(difference < SAME, "{name} finds {part} of the rays occluded, {difference} more or less than lobe");
        println!("  {name:14} {rate:6.2} Mrays/s   lobe / it {:5.3}   occluded {part:.6}", median(k) / median(0));
    }
}
