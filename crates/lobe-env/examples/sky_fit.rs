//! Cost of the polynomial fit of the clear sky: errors by degree, and the time of one evaluation.
//!
//! `cargo run --release -p lobe-env --example sky_fit`

use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

use lobe_env::{Ground, PreethamFit, PreethamSky, SkyFitOptions, sky_sh};
use lobe_sh::{Dir, Expansion, Rgb, ShVec};

fn norm(f: &ShVec<Rgb<f64>>) -> f64 {
    f.coefficients().iter().flat_map(|c| c.to_array()).map(|c| c * c).sum::<f64>().sqrt()
}

fn main() -> Result<(), Box<dyn Error>> {
    let exact = |turbidity: f64, sun: Dir| -> Result<_, Box<dyn Error>> {
        Ok(sky_sh(&PreethamSky::new(turbidity, sun)?, &Ground::default(), 7))
    };
    println!("order 7; root mean square over the sphere relative to the sky's, in percent");
    println!("degree sun, turbidity   terms    mean    max   at sun (deg), turbidity     time of one evaluation");
    let suns: Vec<f64> = (0..=60).map(|k| 1.5 * f64::from(k)).collect();
    let turbidities: Vec<f64> = (0..=16).map(|k| 2.0 + 0.5 * f64::from(k)).collect();
    let mut truth = Vec::new();
    for &sun in &suns {
        for &turbidity in &turbidities {
            let direction = Dir::from_angles(sun.to_radians(), 0.7);
            truth.push((sun, turbidity, exact(turbidity, direction)?));
        }
    }
    for (sun_degree, turbidity_degree) in [(13, 7), (10, 5), (8, 4), (6, 3)] {
        let fit = PreethamFit::new(
            SkyFitOptions::default().order(7).sun_degree(sun_degree).turbidity_degree(turbidity_degree),
        )?;
        let errors = truth.iter().map(|(sun, turbidity, f)| {
            let found = fit.eval(*turbidity, Dir::from_angles(sun.to_radians(), 0.7));
            (100.0 * norm(&(&found - f)) / norm(f), *sun, *turbidity)
        });
        let errors: Vec<_> = errors.collect();
        let mean = errors.iter().map(|e| e.0).sum::<f64>() / errors.len() as f64;
        let worst = errors.iter().copied().fold((0.0, 0.0, 0.0), |a, b| if b.0 > a.0 { b } else { a });
        let repeats = 20_000;
        let start = Instant::now();
        for k in 0..repeats {
            black_box(fit.eval(black_box(3.0), Dir::from_angles(1e-4 * f64::from(k % 15_000), 1.0)));
        }
        let micros = start.elapsed().as_secs_f64() * 1e6 / f64::from(repeats);
        println!(
            "{sun_degree:>10} {turbidity_degree:>10} {:>8} {mean:>8.3} {:>7.2}   {:>8.1} {:>10.1} {micros:>20.2} us",
            (sun_degree + 1) * (turbidity_degree + 1),
            worst.0,
            worst.1,
            worst.2
        );
    }
    let start = Instant::now();
    for k in 0..20 {
        black_box(exact(3.0, Dir::from_angles(0.07 * f64::from(k), 1.0))?);
    }
    println!("straight from the formula: {:.0} us", start.elapsed().as_secs_f64() * 1e6 / 20.0);
    Ok(())
}
