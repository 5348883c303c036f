//! A ball over a ground, baked once, under three skies.
//!
//! `cargo run --release -p lobe --example 08_bake_a_scene`

use std::error::Error;
use std::ops::ControlFlow;

use lobe::env::{bundled, project_env};
use lobe::io::Job;
use lobe::prt::{BakeMode, BakeOptions, Receivers, bake};
use lobe::scene::{Bvh, built_in};
use lobe::sh::{Coefficient as _, Expansion as _, Rgb, ShVec};

pub(crate) fn main() -> Result<(), Box<dyn Error>> {
    let scene = built_in::ball_over_ground(16);
    let receivers = Receivers::at_vertices(&scene)?;
    let options = BakeOptions::default().mode(BakeMode::Interreflected).order(4).samples(64);

    // A job may be watched, and stopped by `ControlFlow::Break`.
    let mut reports = 0;
    let mut watch = |_: &lobe::io::Progress| {
        reports += 1;
        ControlFlow::Continue(())
    };
    let job = Job::default().watched_by(&mut watch);
    let (transfer, report) = bake(&scene, &Bvh::new(&scene), &receivers, &options, job)?;
    println!("{} vertices, {} rays, {reports} reports of progress", report.receivers, report.rays);

    let even = ShVec::constant(4, Rgb::new(1.0, 1.0, 1.0));
    let skies = [bundled::sunset(), bundled::studio()].map(|sky| project_env(&sky.map(), 4));
    for (name, light) in [("even", &even), ("sunset", &skies[0]), ("studio", &skies[1])] {
        let colors = transfer.exit_radiance(light.coefficients());
        let mean = colors.iter().fold(Rgb::ZERO, |sum, color| sum + *color).scale(1.0 / colors.len() as f32);
        println!("{name:7} mean exit radiance {:.3?}", mean.to_array());
        assert_eq!(colors.len(), scene.vertex_count(), "a color for each vertex");
        assert!(mean.g > 0.0 && mean.g < light.mean().g as f32, "{name}: {mean:?}");
    }
    Ok(())
}
