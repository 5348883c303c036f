//! Section about a figure with a skin: its shadows by spheres that follow its joints, beside bakes and the truth.

use lobe::io::Job;
use lobe::motion::{MovingBakeOptions, MovingMethod, MovingScene};
use lobe::prt::Transfer;
use lobe::scene::built_in;

use super::stage::{ORDER, Stage, merits, most_spheres};
use crate::error::Drawn;
use crate::page::{Canvas, Sky};

/// Vertices around the figure.
const AROUND: usize = 24;

/// Seconds of a walk of 1.1 s at which pictures are compared with the truth.
const TIMES: [f64; 3] = [0.1, 0.4, 0.8];

/// Pictures of the walk.
const FRAMES: usize = 24;

const METHOD: MovingMethod = MovingMethod::Exponentials;

/// A figure that walks over a ground.
pub(crate) fn walking(canvas: &mut Canvas<'_>, sky: &Sky) -> Drawn {
    let name = sky.bundled.name;
    canvas.step()?;
    let stage = Stage::new(sky, canvas.size.picture, [2.6, -3.2, 1.9], [0.0, 0.0, 0.8], 38.0);
    let mut figure = MovingScene::animated(built_in::walking_figure(AROUND), Some(0))?;
    let options = MovingBakeOptions::default().transfer(stage.transfer.clone());
    figure.bake(METHOD, &options, Job::default())?;
    canvas.text(&format!(
        "A skin changes the shape of what it moves, so that nothing can be baked for it but the {} spheres that stand for it. They \
         follow its joints, and shade the ground and the figure itself by the exponential of the sum of their logarithms.",
        most_spheres(&figure),
    ));
    stage.animate(canvas, (&figure, METHOD), FRAMES, ("walking.png", "spheres that follow a skin"))?;
    steps(canvas, &stage, &figure)?;
    canvas.command(&format!(
        "lobe spheres built-in:walking-figure -n 64 --entity figure -o figure.spheres.safetensors\n\
         lobe render moving built-in:walking-figure --env bundled:{name} --method exponentials --frames 0..47 --loop -o walking.png"
    ));
    Ok(())
}

/// Figures of merit at some times.
fn steps(canvas: &mut Canvas<'_>, stage: &Stage<'_>, figure: &MovingScene) -> Drawn {
    let (alone, measured) = (figure.without_occluders(), stage.measured);
    let at_first = stage.baked_at(&figure.at(0.0)?)?;
    let mut rows = Vec::new();
    for time in TIMES {
        canvas.step()?;
        let moment = figure.at(time)?;
        let lit = |scene: &MovingScene| stage.lit(&scene.at(time)?, METHOD, measured);
        let by = |transfer: &Transfer| stage.lit_by(transfer, &moment, measured);
        let pictures = [lit(&alone)?, by(&at_first)?, lit(figure)?, by(&stage.baked_at(&moment)?)?];
        rows.push(merits(time, &stage.truth(&moment, measured)?, &pictures));
    }
    canvas.text(&format!(
        "The same ratio, against {} paths for each of fewer pixels: without shadows, by transfer that was baked once, at the first \
         moment, and stays with the vertices, by spheres, and by transfer that was baked for that very moment, the best that order \
         {ORDER} can do.",
        measured.paths
    ));
    canvas.table(&["time", "no shadows", "baked once", "spheres", "baked for the moment"], &rows);
    Ok(())
}
