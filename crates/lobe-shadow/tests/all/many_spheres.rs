//! Exponentials of many random spheres against what they really leave of the sky.

use lobe_sh::batch::ShBatch;
use lobe_sh::exponential::ExpMethod;
use lobe_sh::{Dir, Expansion as _, ShVec, project};
use lobe_shadow::{BatchExponential, LogTable, LogTableOptions};
use lobe_testkit::Random;

/// Degree of the quadrature of the truth.
const TRUTH_DEGREE: usize = 120;

/// The most bands.
const MOST: usize = 6;

/// Mean errors at orders 3 to 6 that were measured before with 16 spheres: by the grid, by the optimal linear method, and by the hybrid
/// method of limit 1.
const BEFORE: [[f64; 3]; 4] =
    [[0.124, 0.153, 0.130], [0.137, 0.262, 0.162], [0.129, 0.369, 0.206], [0.166, 0.374, 0.246]];

const METHODS: [ExpMethod; 3] = [ExpMethod::Grid, ExpMethod::OptimalLinear, ExpMethod::Hybrid { limit: 1.0 }];

/// Spheres in random directions, of sizes that hide about as much of the sky for any number: 5 to 25 degrees where there are 16.
fn cluster(count: usize, random: &mut Random) -> Vec<(Dir, f64)> {
    let scale = (16.0 / count as f64).sqrt().min(1.0);
    let direction = |random: &mut Random| Dir::try_from(random.direction()).unwrap();
    (0..count).map(|_| (direction(random), scale * (5.0 + 20.0 * random.unit()).to_radians())).collect()
}

fn truth(spheres: &[(Dir, f64)]) -> ShVec<f64> {
    let cones: Vec<(Dir, f64)> = spheres.iter().map(|&(s, angle)| (s, angle.cos())).collect();
    project(
        MOST,
        TRUTH_DEGREE,
        |s: Dir| if cones.iter().any(|(axis, cosine)| axis.dot(s) > *cosine) { 0.0 } else { 1.0 },
    )
}

#[test]
fn exponentials_of_8_to_512_spheres_are_no_worse_than_what_was_measured_for_16() {
    const CLUSTERS: usize = 2;
    for count in [8, 32, 128, 512] {
        let mut random = Random::new(5);
        let clusters: Vec<_> = (0..CLUSTERS).map(|_| cluster(count, &mut random)).collect();
        let truths: Vec<_> = clusters.iter().map(|spheres| truth(spheres)).collect();
        for (order, before) in (3..=MOST).zip(BEFORE) {
            let table = LogTable::new(&LogTableOptions::default().order(order)).unwrap();
            for (method, before) in METHODS.into_iter().zip(before) {
                let fast = BatchExponential::new(order, method).unwrap();
                let mut error = 0.0;
                for (spheres, truth) in clusters.iter().zip(&truths) {
                    let mut f = ShVec::zero(order);
                    spheres.iter().for_each(|&(s, angle)| f += &table.at(angle).towards(s, 1.0));
                    let mut found = ShBatch::zero(order, 1);
                    found.set(0, &f.coefficients().iter().map(|c| *c as f32).collect::<Vec<f32>>());
                    fast.of_batch_in_place(&mut found);
                    let truth = truth.resized(order);
                    let mut rest = ShVec::from_vec(found.blocks().iter().map(|b| f64::from(b[0])).collect()).unwrap();
                    rest -= &truth;
                    error += (rest.dot(&rest) / truth.dot(&truth)).sqrt() / CLUSTERS as f64;
                }
                println!("order {order}, {count} spheres, {method:?}: {error:.3} of {before}");
                assert!(error <= before, "order {order}, {count} spheres, {method:?}: {error}, before {before}");
            }
        }
    }
}
