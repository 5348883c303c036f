//! Section of the demo about a figure with a skin: its shadows by spheres that follow its joints, beside bakes and the truth.

use lobe::io::Job;
use lobe::prt::Transfer;
use lobe::render::{MovingBakeOptions, MovingMethod, MovingScene};
use lobe::scene::built_in;

use super::stage::{ORDER, Stage, psnr, shading};
use super::{Sky, Writer};

/// Vertices around the figure.
const AROUND: usize = 24;

/// Seconds of a walk of 1.1 s at which pictures are compared with the truth.
const TIMES: [f64; 3] = [0.1, 0.4, 0.8];

/// Pictures of the walk.
const FRAMES: usize = 24;

impl Writer<'_> {
    /// A figure that walks over a ground.
    pub(super) fn walking(&mut self, sky: &Sky) -> anyhow::Result<()> {
        let name = sky.bundled.name;
        self.page.section(&format!("{name}: a figure that walks"));
        (self.progress)("a figure");
        let stage = Stage::new(sky, self.picture, [2.6, -3.2, 1.9], [0.0, 0.0, 0.8], 38.0);
        let mut figure = MovingScene::animated(built_in::walking_figure(AROUND), Some(0))?;
        let options = MovingBakeOptions::default().transfer(stage.transfer.clone());
        figure.bake(MovingMethod::Exponentials, &options, Job::default())?;
        self.page.text(&format!(
            "A skin changes the shape of what it moves, so that nothing can be baked for it but the {} spheres that stand for it. They \
             follow its joints, and shade the ground and the figure itself by the exponential of the sum of their logarithms.",
            figure.parts().iter().filter_map(|part| part.spheres.as_ref()).map(|set| set.len()).max().unwrap_or(0),
        ));
        let method = MovingMethod::Exponentials;
        self.moving_picture(&stage, (&figure, method), FRAMES, ("walking.png", "spheres that follow a skin"))?;
        self.steps(&stage, &figure)?;
        self.page.command(&format!(
            "lobe spheres built-in:walking-figure -n 64 --entity figure -o figure.spheres.safetensors\n\
             lobe render moving built-in:walking-figure --env bundled:{name} --method exponentials --frames 0..47 --loop -o walking.png"
        ));
        Ok(())
    }

    /// Figures of merit at some times.
    fn steps(&mut self, stage: &Stage<'_>, figure: &MovingScene) -> anyhow::Result<()> {
        let (alone, measured) = (figure.without_occluders(), stage.measured);
        let at_first = stage.baked_at(&figure.at(0.0)?)?;
        let mut rows = Vec::new();
        for time in TIMES {
            (self.progress)("a step, traced");
            let moment = figure.at(time)?;
            let truth = stage.truth(&moment, measured)?;
            let lit = |scene: &MovingScene| {
                stage.lit(&scene.at(time)?, &shading(MovingMethod::Exponentials)?, &stage.distant(), measured)
            };
            let by = |transfer: &Transfer| stage.lit_by(transfer, &moment, measured);
            let pictures = [lit(&alone)?, by(&at_first)?, lit(figure)?, by(&stage.baked_at(&moment)?)?];
            rows.push([format!("{time} s")].into_iter().chain(pictures.map(|lit| psnr(&truth, &lit))).collect());
        }
        self.page.text(&format!(
            "The same ratio, against {} paths for each of fewer pixels: without shadows, by transfer that was baked once, at the first \
             moment, and stays with the vertices, by spheres, and by transfer that was baked for that very moment, the best that order \
             {ORDER} can do.",
            measured.paths
        ));
        self.page.table(&["time", "no shadows", "baked once", "spheres", "baked for the moment"], &rows);
        Ok(())
    }
}
