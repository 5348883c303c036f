//! Changes of the vertices of a moving scene from one frame to the next: by shadow fields, by spheres, and in truth.
//!
//! What pops is a change that the truth does not have. The truth is transfer that is baked anew for every frame, of the same
//! order and by the same rays at every vertex. Prints the largest change of a vertex between two frames, and that which one of a
//! thousand exceeds, over the mean radiance. With a folder as its argument, writes the frames of each way as an animated PNG.
//!
//! ```sh
//! cargo run --release --package lobe-motion --example popping [FOLDER]
//! ```

use std::env;
use std::error::Error;
use std::path::{Path, PathBuf};

use lobe_env::{bundled, project_env};
use lobe_image::{Picture, Tone, write_animated_png};
use lobe_io::Job;
use lobe_motion::{Moment, MovingBakeOptions, MovingMethod, MovingOptions, MovingScene, MovingShading};
use lobe_prt::{BakeMode, BakeOptions, Receivers, bake};
use lobe_render::{Camera, RenderError, SceneHit, ViewOptions, scene_picture};
use lobe_scene::built_in;
use lobe_sh::{Coefficient as _, Expansion as _, Rgb, ShVec};

const ORDER: usize = 4;

/// Frames of the motion, of four seconds.
const FRAMES: usize = 60;

/// Cells along a side of the ground.
const CELLS: usize = 32;

/// Rays of the bakes at each vertex.
const RAYS: u32 = 1024;

type Frame = Vec<Rgb<f32>>;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = env::args_os().nth(1).map(PathBuf::from);
    let light = project_env(&bundled::sunset().map(), ORDER);
    let transfer = BakeOptions::default().mode(BakeMode::Shadowed).order(ORDER).samples(RAYS);
    println!("radiance changes by                at most    one of 1000");
    for (what, scene) in
        [("three objects", built_in::three_objects(CELLS)), ("walking figure", built_in::walking_figure(CELLS))]
    {
        let bare = MovingScene::animated(scene, Some(0))?;
        compare(what, &bare, &transfer, &light, folder.as_deref())?;
    }
    Ok(())
}

/// The changes of one scene by each method. Fields are of rigid parts: the figure has spheres in their place.
fn compare(
    what: &str,
    bare: &MovingScene,
    transfer: &BakeOptions,
    light: &ShVec<Rgb<f64>>,
    folder: Option<&Path>,
) -> Result<(), Box<dyn Error>> {
    for (name, method) in
        [("truth", None), ("fields", Some(MovingMethod::Fields)), ("spheres", Some(MovingMethod::Exponentials))]
    {
        let name = format!("{what}, {name}");
        let mut moving = bare.clone();
        if let Some(method) = method {
            moving.bake(method, &MovingBakeOptions::default().transfer(transfer.clone()), Job::default())?;
        }
        let shading = MovingShading::new(MovingOptions::default().order(ORDER).method(method.unwrap_or_default()))?;
        let [begin, end] = moving.span();
        let (mut frames, mut pictures) = (Vec::new(), Vec::new());
        for k in 0..FRAMES {
            let moment = moving.at(begin + (end - begin) * k as f64 / FRAMES as f64)?;
            let frame = match method {
                Some(_) => shading.exit_radiance(&moment, light)?,
                None => truth(&moment, transfer, light)?,
            };
            if folder.is_some() {
                pictures.push(picture(&moment, &frame)?);
            }
            frames.push(frame);
        }
        let changes = changes(&frames);
        println!("{name:32} {:9.4} {:13.4}", changes[changes.len() - 1], changes[changes.len() * 999 / 1000]);
        if let Some(folder) = folder {
            write(folder, &name, &pictures)?;
        }
    }
    Ok(())
}

/// The radiance of all vertices by transfer that is baked for the moment.
fn truth(moment: &Moment<'_>, options: &BakeOptions, light: &ShVec<Rgb<f64>>) -> Result<Frame, Box<dyn Error>> {
    let receivers = Receivers::at_vertices(moment.scene())?;
    let (transfer, _) = bake(moment.scene(), moment.bvh(), &receivers, options, Job::default())?;
    Ok(transfer.exit_radiance(light.coefficients()))
}

/// How much each vertex changes between any two frames, ascending, over the mean of all; the last frame comes before the first.
fn changes(frames: &[Frame]) -> Vec<f64> {
    let count = frames.iter().map(Vec::len).sum::<usize>() as f64;
    let mean = frames.iter().flatten().map(|c| f64::from(c.g)).sum::<f64>() / count;
    let pairs = frames.iter().zip(frames.iter().cycle().skip(1));
    let change = |(a, b): (&Rgb<f32>, &Rgb<f32>)| f64::from((a.g - b.g).abs()) / mean;
    let mut all: Vec<f64> = pairs.flat_map(|(a, b)| a.iter().zip(b).map(change)).collect();
    all.sort_by(f64::total_cmp);
    all
}

fn picture(moment: &Moment<'_>, frame: &Frame) -> Result<Picture, RenderError> {
    let Some(camera) = Camera::look_at([7.5, -9.0, 6.0], [0.0, 0.0, 0.9], 17_f64.to_radians()) else {
        unreachable!("the eye is not where it looks")
    };
    let options = ViewOptions::default().width(320).height(240);
    let radiance = |hit: &SceneHit<'_>| hit.at_corners(frame);
    scene_picture(moment.scene(), moment.bvh(), &camera, &options, |_| Rgb::ZERO, radiance, Job::default())
}

fn write(folder: &Path, name: &str, pictures: &[Picture]) -> Result<(), Box<dyn Error>> {
    let tone = Tone::PHOTOGRAPH.fixed_for(&pictures[0]);
    write_animated_png(folder.join(format!("{name}.png")), pictures, &tone, 1.0 / 15.0)?;
    Ok(())
}
