//! Errors of the shadows of overlapping spheres, against those of their union: each sphere by itself, as published, and shared.
//!
//! Sets of 4, 16 and 64 spheres are fitted to a cube, a ring and a ball. For receivers that look at them from near by and from
//! afar, prints the root mean square difference of visibility from that of the union, which is projected by quadrature, relative to
//! the union's occlusion.
//!
//! ```sh
//! cargo run --release --package lobe-shadow --example sphere_unions [ORDER]
//! ```

#![allow(clippy::unwrap_used, reason = "an example fails by panicking")]

use std::env;

use lobe_io::Job;
use lobe_scene::built_in;
use lobe_sh::{Dir, Expansion as _, ShVec, project};
use lobe_shadow::{
    LogTable, LogTableOptions, Occluder, ShadowOptions, ShadowReceivers, SphereFitOptions, SphereShadows, fit_spheres,
};
use lobe_testkit::Random;

/// Entities of the three objects.
const SHAPES: [(&str, usize); 3] = [("cube", 2), ("ring", 3), ("ball", 1)];

/// Distances from the middle, in reaches of the set.
const DISTANCES: [[f64; 2]; 3] = [[1.0, 1.3], [1.3, 2.0], [2.0, 4.0]];

const RECEIVERS: usize = 12;

/// Degree of the quadrature of the truth: its error is a few percent of those that are printed.
const TRUTH_DEGREE: usize = 80;

fn main() {
    let order = env::args().nth(1).map_or(4, |text| text.parse::<usize>().expect("an order"));
    let table = LogTable::new(&LogTableOptions::default().order(order)).unwrap();
    let animated = built_in::three_objects(24);
    println!("shape  spheres   distance   each by itself   shared");
    for (name, entity) in SHAPES {
        let scene = animated.own_scene(&animated.entities()[entity]).unwrap();
        for count in [4, 16, 64] {
            let options = SphereFitOptions::default().count(count).samples(2000).rounds(6);
            let (set, _) = fit_spheres(&scene, &options, Job::default()).unwrap();
            let spheres: Vec<Occluder> =
                set.centers().iter().zip(set.radii()).map(|(center, radius)| Occluder::new(*center, *radius)).collect();
            for [low, high] in DISTANCES {
                let [alone, shared] = [false, true].map(|share| error(&table, &spheres, [low, high], share));
                println!("{name:5} {count:8}   {low} to {high}   {alone:14.3} {shared:8.3}");
            }
        }
    }
}

fn error(table: &LogTable, spheres: &[Occluder], [low, high]: [f64; 2], share: bool) -> f64 {
    let length = |v: [f32; 3]| v.iter().map(|c| f64::from(*c).powi(2)).sum::<f64>().sqrt();
    let reach = spheres.iter().map(|s| length(s.center) + f64::from(s.radius)).fold(0.0, f64::max);
    let mut random = Random::new(3);
    let (mut positions, mut normals) = (Vec::new(), Vec::new());
    for _ in 0..RECEIVERS {
        let s = random.direction();
        let distance = reach * (low + (high - low) * random.unit());
        positions.push(s.map(|c| (distance * c) as f32));
        // They look at the middle, so that no plane hides a sphere.
        normals.push(s.map(|c| -c as f32));
    }
    let options = ShadowOptions::default().cut(0.0).share_overlaps(share);
    let shadows = SphereShadows::new(table, spheres, &options).unwrap();
    let found = shadows.visibility(&ShadowReceivers::new(&positions, &normals).unwrap());
    let (mut off, mut hidden) = (0.0, 0.0);
    for (p, found) in positions.iter().zip(found.chunks_exact(table.order() * table.order())) {
        let truth = truth(table.order(), spheres, *p);
        off += truth.coefficients().iter().zip(found).map(|(t, v)| (f64::from(*v) - t).powi(2)).sum::<f64>();
        let mut occlusion = ShVec::constant(table.order(), 1.0);
        occlusion -= &truth;
        hidden += occlusion.dot(&occlusion);
    }
    (off / hidden).sqrt()
}

/// What the union of the spheres leaves visible.
fn truth(order: usize, spheres: &[Occluder], p: [f32; 3]) -> ShVec<f64> {
    let cone = |sphere: &Occluder| {
        let to = [0, 1, 2].map(|k| f64::from(sphere.center[k]) - f64::from(p[k]));
        let d = to.iter().map(|c| c * c).sum::<f64>().sqrt();
        (Dir::new(to).unwrap(), (1.0 - (f64::from(sphere.radius) / d).powi(2)).max(0.0).sqrt())
    };
    let cones: Vec<(Dir, f64)> = spheres.iter().map(cone).collect();
    let hides = |s: Dir| cones.iter().any(|(axis, cosine)| axis.dot(s) > *cosine);
    project(order, TRUTH_DEGREE, |s: Dir| if hides(s) { 0.0 } else { 1.0 })
}
