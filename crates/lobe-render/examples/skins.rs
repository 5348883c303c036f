//! The shadows of a figure with a skin against traced paths: `built-in:walking-figure` at three times of its walk.
//!
//! Its spheres are fitted to the shape that was bound and follow its joints. Prints the PSNR of pictures of direct light by 8, 16
//! and 64 spheres, and by none, against 64 paths a pixel, of all pixels and of those of the ground and of the figure by themselves;
//! the table of the guide (Things that move).
//!
//! ```sh
//! cargo run --release --package lobe-render --example skins
//! ```

use std::error::Error;

use lobe_env::{bundled, project_env};
use lobe_image::compare;
use lobe_io::Job;
use lobe_prt::{BakeMode, BakeOptions};
use lobe_render::{
    Camera, DistantLight, MovingBakeOptions, MovingMethod, MovingOptions, MovingScene, MovingShading, PathOptions,
    SampleCount, TruthOptions, ViewOptions, light_moving_scene, render_truth,
};
use lobe_scene::built_in;
use lobe_sh::Dir;
use lobe_shadow::SphereFitOptions;

const ORDER: usize = 4;

/// Of a walk of 1.1 s.
const TIMES: [f64; 3] = [0.1, 0.4, 0.8];

const SIZE: [usize; 2] = [240, 180];

fn main() -> Result<(), Box<dyn Error>> {
    let light = project_env(&bundled::sunset().map(), ORDER);
    let distant = DistantLight::from_expansion(light.clone());
    let background = |s: Dir| distant.radiance(s);
    let Some(camera) = Camera::look_at([2.6, -3.2, 1.9], [0.0, 0.0, 0.8], 38_f64.to_radians()) else {
        return Err("the eye is not where it looks".into());
    };
    let bare = MovingScene::animated(built_in::walking_figure(24), Some(0))?;
    let [width, height] = SIZE;
    let paths = PathOptions::default().bounces(0);
    let options = TruthOptions::default().width(width).height(height).count(SampleCount::of(64)).paths(paths);
    let mut truths = Vec::new();
    for time in TIMES {
        let moment = bare.at(time)?;
        truths.push(render_truth(moment.scene(), moment.bvh(), &camera, &distant, &options, Job::default())?);
    }
    println!("| spheres | {} |", TIMES.map(|time| format!("{time} s")).join(" | "));
    println!("|---|{}", "---|".repeat(TIMES.len()));
    let view = ViewOptions::default().width(width).height(height);
    for count in [0, 8, 16, 64] {
        let transfer = BakeOptions::default().mode(BakeMode::Shadowed).order(ORDER);
        let spheres = SphereFitOptions::default().count(count.max(1));
        let mut moving = bare.clone();
        let bake = MovingBakeOptions::default().transfer(transfer).spheres(spheres).deformed_spheres(None);
        moving.bake(MovingMethod::Exponentials, &bake, Job::default())?;
        if count == 0 {
            moving = moving.without_occluders();
        }
        let shading = MovingShading::new(MovingOptions::default().order(ORDER).method(MovingMethod::Exponentials))?;
        let mut row = Vec::new();
        for (time, truth) in TIMES.iter().zip(&truths) {
            let moment = moving.at(*time)?;
            let lit = light_moving_scene(&moment, &shading, &light, &camera, &view, background, Job::default())?;
            let psnr = |shows: &dyn Fn([f32; 3]) -> bool| {
                let all = lit.picture.pixels().iter().zip(truth.mean.pixels()).zip(truth.albedo.pixels());
                let (found, expected): (Vec<_>, Vec<_>) =
                    all.filter(|(_, albedo)| shows(**albedo)).map(|((lit, truth), _)| (*lit, *truth)).unzip();
                compare(&found, &expected).psnr
            };
            // The ground is gray, the figure is not.
            let is_gray = |[r, _, b]: [f32; 3]| r > 0.0 && (r - b).abs() < 1e-3;
            let is_figure = |[r, _, b]: [f32; 3]| r - b > 0.2;
            row.push(format!("{:.1}, {:.1}, {:.1}", psnr(&|_| true), psnr(&is_gray), psnr(&is_figure)));
        }
        println!("| {count} | {} |", row.join(" | "));
    }
    Ok(())
}
