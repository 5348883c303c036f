//! Errors of the exponential of a sum of logarithms, against what random spheres really leave of the sky.
//!
//! For clusters of 8 to 512 spheres, and orders 3 to 6, prints the mean of `‖found - truth‖/‖truth‖`, the truth being the
//! projection of the sky's visibility by quadrature: for chained truncated products, for every method of
//! [`lobe_sh::exponential::Exponential`], and for the single-precision path of the crate with its table.
//!
//! ```sh
//! cargo run --release --package lobe-shadow --example exponential_errors [CLUSTERS [SCALE]]
//! ```
//!
//! Beside them stand the figures that were measured before for 16 spheres. `SCALE` multiplies the sizes of the spheres: with 1.4 half of the sky is hidden.

#![allow(clippy::unwrap_used, reason = "an example fails by panicking")]

use std::env;

use lobe_sh::basis::Basis;
use lobe_sh::batch::ShBatch;
use lobe_sh::exponential::{ExpMethod, Exponential, LOG_CLAMP, ZonalLogarithm};
use lobe_sh::ringing::DeringOptions;
use lobe_sh::{Dir, Expansion as _, ShVec, Zonal, project};
use lobe_shadow::{BatchExponential, LogTable, LogTableOptions};
use lobe_testkit::Random;

const METHODS: [(&str, ExpMethod); 6] = [
    ("eigen", ExpMethod::Eigen),
    ("linear", ExpMethod::OptimalLinear),
    ("hybrid 4.8", ExpMethod::Hybrid { limit: 4.8 }),
    ("hybrid 1", ExpMethod::Hybrid { limit: 1.0 }),
    ("series 4", ExpMethod::ProductSeries(4)),
    ("grid", ExpMethod::Grid),
];

/// Degree of the quadrature of the truth: its error is below a percent of the errors that are printed.
const TRUTH_DEGREE: usize = 220;

/// Errors that were measured before with clusters of 16 spheres of another kind: of products and of the methods, in their order.
const BEFORE: [[f64; 7]; 4] = [
    [0.116, 0.119, 0.153, 0.153, 0.130, 0.119, 0.124],
    [0.115, 0.131, 0.262, 0.261, 0.162, 0.139, 0.137],
    [0.095, 0.120, 0.369, 0.365, 0.206, 0.212, 0.129],
    [0.078, 0.115, 0.374, 0.422, 0.246, 1.11, 0.166],
];

fn main() {
    let clusters = env::args().nth(1).map_or(6, |text| text.parse::<usize>().expect("a number of clusters"));
    let scale = env::args().nth(2).map_or(1.0, |text| text.parse::<f64>().expect("a factor for sizes"));
    let methods = METHODS.map(|(name, _)| name).join(" | ");
    println!("| order, spheres | hidden | products | {methods} | f32 grid | windowed | capped | below zero |");
    println!("|---|---|---{}|---|---|---|---|", "|---".repeat(METHODS.len()));
    let row = |errors: &[f64]| errors.iter().map(|error| format!("{error:.3}")).collect::<Vec<_>>().join(" | ");
    for (order, before) in (3..=6).zip(BEFORE) {
        for count in [8, 16, 32, 128, 512] {
            let (hidden, errors) = mean_errors(order, count, clusters, scale);
            println!("| {order}, {count} | {hidden:.3} | {} |", row(&errors));
            if count == 16 {
                println!("| {order}, 16 before | | {} | | | | |", row(&before));
            }
        }
    }
}

/// The part of the sky that is hidden, and the mean errors of products, methods, the fast path, that with a window, and two ways on the grid that one
/// more sphere brightens less or never: sums cut off at zero, and logarithms of single spheres that are nowhere above it.
fn mean_errors(order: usize, count: usize, clusters: usize, scale: f64) -> (f64, Vec<f64>) {
    let exponentials = METHODS.map(|(_, method)| Exponential::new(order, method));
    let fast = BatchExponential::new(order, ExpMethod::default()).unwrap();
    let options = LogTableOptions::default().order(order);
    let tables = [LogTable::new(&options).unwrap(), LogTable::new(&options.window(2.0 * order as f64)).unwrap()];
    let exact = ZonalLogarithm::new(order, LOG_CLAMP);
    let mut random = Random::new(5);
    let (mut hidden, mut errors) = (0.0, vec![0.0; METHODS.len() + 5]);
    for _ in 0..clusters {
        let spheres = cluster(count, scale, &mut random);
        let truth = truth(order, &spheres);
        hidden += (1.0 - truth.mean()) / clusters as f64;
        let mut f = ShVec::zero(order);
        spheres.iter().for_each(|&(s, angle)| f += &exact.of_sphere(angle).towards(s, 1.0));
        let mut found = vec![chain(order, &spheres)];
        found.extend(exponentials.iter().map(|exponential| exponential.of(&f)));
        for table in &tables {
            let mut f = ShVec::zero(order);
            spheres.iter().for_each(|&(s, angle)| f += &table.at(angle).towards(s, 1.0));
            let mut batch = ShBatch::zero(order, 1);
            batch.set(0, &f.coefficients().iter().map(|c| *c as f32).collect::<Vec<f32>>());
            fast.of_batch_in_place(&mut batch);
            found.push(ShVec::from_vec(batch.blocks().iter().map(|block| f64::from(block[0])).collect()).unwrap());
        }
        found.push(capped(&f));
        let mut f = ShVec::zero(order);
        spheres.iter().for_each(|&(s, angle)| f += &below_zero(&exact.of_sphere(angle)).towards(s, 1.0));
        found.push(Exponential::new(order, ExpMethod::Grid).of(&f));
        for (sum, found) in errors.iter_mut().zip(&found) {
            let mut rest = found.clone();
            rest -= &truth;
            *sum += (rest.dot(&rest) / truth.dot(&truth)).sqrt() / clusters as f64;
        }
    }
    (hidden, errors)
}

/// The exponential on the grid of what of a function is not above zero.
fn capped(f: &ShVec<f64>) -> ShVec<f64> {
    let mut sum = ShVec::zero(f.order());
    let mut y = ShVec::zero(f.order());
    for (s, weight) in ExpMethod::grid(f.order()).points() {
        Basis::<f64>::with_shared(f.order(), |basis| basis.eval_into(s.to_array(), y.coefficients_mut()));
        let value = weight * f.eval(s).min(0.0).exp();
        sum += &y.map(|y: f64| value * y);
    }
    sum
}

/// The zonal function nearest to one that is nowhere above zero, among those with its bands by factors.
fn below_zero(f: &Zonal) -> Zonal {
    let (minus, _) = f.towards(Dir::Z, -1.0).deringed_with(&DeringOptions::default());
    Zonal::about(Dir::Z, &minus.map(|c: f64| -c))
}

/// Spheres of 5 to 25 degrees in random directions where there are 16, smaller where there are more, so that about as much
/// of the sky is hidden.
fn cluster(count: usize, scale: f64, random: &mut Random) -> Vec<(Dir, f64)> {
    let scale = scale * (16.0 / count as f64).sqrt().min(1.0);
    let direction = |random: &mut Random| Dir::try_from(random.direction()).unwrap();
    (0..count).map(|_| (direction(random), scale * (5.0 + 20.0 * random.unit()).to_radians())).collect()
}

fn chain(order: usize, spheres: &[(Dir, f64)]) -> ShVec<f64> {
    spheres.iter().fold(ShVec::constant(order, 1.0), |all, &(s, angle)| {
        let visible = &ShVec::constant(order, 1.0) + &Zonal::cone(order, angle).towards(s, -1.0);
        all.product(&visible, order)
    })
}

fn truth(order: usize, spheres: &[(Dir, f64)]) -> ShVec<f64> {
    let cones: Vec<(Dir, f64)> = spheres.iter().map(|&(s, angle)| (s, angle.cos())).collect();
    let hides = |s: Dir| cones.iter().any(|(axis, cosine)| axis.dot(s) > *cosine);
    project(order, TRUTH_DEGREE, |s: Dir| if hides(s) { 0.0 } else { 1.0 })
}
