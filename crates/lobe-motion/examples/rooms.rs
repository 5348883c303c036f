//! Light on a ball under a roof: with what stands still hiding the sky from it by the grid, and hiding nothing.
//!
//! Prints the PSNR of pictures of direct light, of which the ball fills most, against 64 paths a pixel, in `built-in:columns` and
//! `built-in:cave`; a table of the guide (Things that move).
//!
//! ```sh
//! cargo run --release --package lobe-motion --example rooms
//! ```

use std::error::Error;

use lobe_env::{bundled, project_env};
use lobe_image::compare;
use lobe_io::Job;
use lobe_motion::{
    Motion, MovingBakeOptions, MovingMethod, MovingOptions, MovingPart, MovingScene, MovingShading, light_moving_scene,
};
use lobe_prt::{BakeMode, BakeOptions};
use lobe_render::{Camera, DistantLight, PathOptions, SampleCount, TruthOptions, ViewOptions, render_truth};
use lobe_scene::{Scene, built_in};
use lobe_sh::{Dir, Rotation};
use lobe_shadow::{Key, Placement, Track};

const ORDER: usize = 4;

const SIZE: [usize; 2] = [160, 120];

const RADIUS: f64 = 0.3;

/// The middle of the way of the ball, and half of the way, along y.
const MIDDLE: [f64; 3] = [0.0, 0.0, 1.0];
const REACH: f64 = 0.6;

/// Of a way of two seconds.
const TIME: f64 = 1.0;

/// The height of the ball of `built-in:ball` over its ground.
const BALL_HEIGHT: f64 = 1.5;

fn main() -> Result<(), Box<dyn Error>> {
    println!("| what stands still | hiding by the grid | hiding nothing |");
    println!("|---|---|---|");
    for (name, room) in [("columns", built_in::columns_hall(4)), ("cave", built_in::cave(96))] {
        let [hiding, bare] = [true, false].map(|hides| psnr(&room, hides));
        println!("| `built-in:{name}` | {:.1} dB | {:.1} dB |", hiding?, bare?);
    }
    Ok(())
}

/// A ball on its way through a room.
fn with_ball(room: &Scene) -> Result<MovingScene, Box<dyn Error>> {
    let ball = built_in::ball_over_ground(48).part([1])?;
    let [x, y, z] = MIDDLE;
    let key = |time: f64, y: f64| Key {
        time,
        placement: Placement::new([x, y, z - BALL_HEIGHT * RADIUS], Rotation::IDENTITY, RADIUS),
    };
    let track = Track::new(vec![key(0.0, y - REACH), key(2.0 * TIME, y + REACH)])?;
    let parts =
        vec![MovingPart::new("room", room.clone(), Motion::Still), MovingPart::new("ball", ball, Motion::Track(track))];
    Ok(MovingScene::new(parts)?)
}

/// How near the picture of the ball is to that of paths.
fn psnr(room: &Scene, still_hides: bool) -> Result<f64, Box<dyn Error>> {
    let mut moving = with_ball(room)?;
    let transfer = BakeOptions::default().mode(BakeMode::Shadowed).order(ORDER);
    let options = MovingBakeOptions::default().transfer(transfer).still_hides(still_hides);
    moving.bake(MovingMethod::Exponentials, &options, Job::default())?;
    let moment = moving.at(TIME)?;

    let eye = [MIDDLE[0] + 1.2, MIDDLE[1] - 0.6, MIDDLE[2] + 0.4];
    let Some(camera) = Camera::look_at(eye, MIDDLE, 30_f64.to_radians()) else {
        return Err("the eye is not where it looks".into());
    };
    let light = project_env(&bundled::sunset().map(), ORDER);
    let distant = DistantLight::from_expansion(light.clone());
    let [width, height] = SIZE;
    let view = ViewOptions::default().width(width).height(height);
    let shading = MovingShading::new(MovingOptions::default().order(ORDER).method(MovingMethod::Exponentials))?;
    let background = |s: Dir| distant.radiance(s);
    let lit = light_moving_scene(&moment, &shading, &light.clone().into(), &camera, &view, background, Job::default())?
        .picture;

    let paths = PathOptions::default().bounces(0);
    let options = TruthOptions::default().width(width).height(height).count(SampleCount::of(64)).paths(paths);
    let truth = render_truth(moment.scene(), moment.bvh(), &camera, &distant, &options, Job::default())?;
    Ok(compare(lit.pixels(), truth.mean.pixels()).psnr)
}
