//! Times of the frames of a moving scene, with a tree of their own and with that of the frame before, refit.
//!
//! For `built-in:three-objects` and `built-in:walking-figure`, prints the mean milliseconds of a picture of 160 × 120 pixels both
//! ways, in turns, and their ratio.
//!
//! ```sh
//! cargo run --release --package lobe-motion --example moving_frames [CELLS]
//! ```

use std::env;
use std::error::Error;
use std::time::{Duration, Instant};

use lobe_env::{bundled, project_env};
use lobe_io::Job;
use lobe_motion::{
    Moment, MovingBakeOptions, MovingMethod, MovingOptions, MovingScene, MovingShading, light_moving_scene,
};
use lobe_prt::{BakeMode, BakeOptions};
use lobe_render::{Camera, RenderError, View, ViewOptions};
use lobe_scene::{AnimatedScene, Bvh, built_in};
use lobe_sh::Rgb;

const ORDER: usize = 4;
const FRAMES: usize = 12;

fn main() -> Result<(), Box<dyn Error>> {
    let cells = env::args().nth(1).map_or(Ok(96), |text| text.parse::<usize>())?;
    println!("scene            triangles    two trees   refit    ratio of frames   of trees alone");
    for (name, scene) in
        [("three-objects", built_in::three_objects(cells)), ("walking-figure", built_in::walking_figure(cells))]
    {
        row(name, scene)?;
    }
    Ok(())
}

fn row(name: &str, scene: AnimatedScene) -> Result<(), Box<dyn Error>> {
    let light = project_env(&bundled::sunset().map(), ORDER);
    let mut moving = MovingScene::animated(scene, Some(0))?;
    let transfer = BakeOptions::default().mode(BakeMode::Shadowed).order(ORDER).samples(16);
    let bake = MovingBakeOptions::default().transfer(transfer).still_hides(false);
    moving.bake(MovingMethod::Exponentials, &bake, Job::default())?;
    let shading = MovingShading::new(MovingOptions::default().order(ORDER).method(MovingMethod::Exponentials))?;
    let [min, max] = moving.world_bounds(0.0)?;
    let camera = Camera::framing(min, max, View::three_quarter(), 0.6);
    let view = ViewOptions::default().width(160).height(120);
    let shade = |moment: &Moment<'_>| -> Result<(), RenderError> {
        MovingScene::backs_in_view(moment, &camera, &view, Job::default())?;
        light_moving_scene(
            moment,
            &shading,
            &light.clone().into(),
            &camera,
            &view,
            |_| Rgb::new(0.0, 0.0, 0.0),
            Job::default(),
        )?;
        Ok(())
    };
    let [begin, end] = moving.span();
    let (mut anew, mut refit) = ([Duration::ZERO; 2], [Duration::ZERO; 2]);
    let mut tree: Option<Bvh> = None;
    for k in 0..=FRAMES {
        let time = begin + (end - begin) * k as f64 / FRAMES as f64;
        let start = Instant::now();
        let moments = [moving.at(time)?, moving.at(time)?];
        let trees = start.elapsed();
        shade(&moments[1])?;
        let whole = start.elapsed();
        let start = Instant::now();
        let moment = moving.at_with(time, tree.take())?;
        let refits = start.elapsed();
        shade(&moment)?;
        // The first frame has no tree before it.
        if k > 0 {
            (anew[0], anew[1]) = (anew[0] + whole, anew[1] + trees);
            (refit[0], refit[1]) = (refit[0] + start.elapsed(), refit[1] + refits);
        }
        tree = Some(moment.into_bvh());
    }
    let ms = |time: Duration| 1e3 * time.as_secs_f64() / FRAMES as f64;
    println!(
        "{name:16} {:9} {:8.1} ms {:8.1} ms {:10.2} {:16.2}",
        moving.at(begin)?.scene().triangle_count(),
        ms(anew[0]),
        ms(refit[0]),
        ms(anew[0]) / ms(refit[0]),
        ms(anew[1]) / ms(refit[1])
    );
    Ok(())
}
