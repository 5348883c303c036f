//! The truth by rays, which refines itself beside the window while nothing moves.

use std::sync::Arc;

use eframe::egui::{ColorImage, Context, TextureHandle, TextureId, TextureOptions};
use lobe::env::{EnvError, MappedMap};
use lobe::image::{Curve, Picture, Tone, compare};
use lobe::io::Job;
use lobe::render::{
    Emitter, PathOptions, RenderError, SampleCount, Surfaces, TruthOptions, render_truth_with_emitters,
};
use lobe::sh::{Rgb, Rotation};

use crate::loading::backdrop::Behind;
use crate::loading::bake::SceneData;
use crate::loading::place::IN_PAGE;
use crate::loading::task::{Control, Task, TaskEvent};
use crate::rooms::truth_light::{Disc, SkyGrid};
use crate::widgets::orbit::Orbit;
use crate::widgets::tone::Look;

/// Paths of a pixel in one pass: the fewest that the path tracer takes.
const PATHS: SampleCount = SampleCount { sets: 2, per_set: 1 };

/// Passes after which the picture is good enough: the noise that is left is a 45th of that of one path.
const PASSES: u64 = 1024;

/// All that a truth depends on.
#[derive(Clone)]
pub(crate) struct Still {
    pub(crate) data: SceneData,
    /// Lamps near by, of a scene that is another where they are others.
    pub(crate) emitters: Vec<Emitter>,
    pub(crate) sky: Option<Arc<MappedMap>>,
    pub(crate) behind: Behind,
    pub(crate) orbit: Orbit,
    pub(crate) size: [u32; 2],
    pub(crate) turn: Rotation,
    pub(crate) strength: f64,
    pub(crate) lamps: Vec<Disc>,
    pub(crate) bounces: usize,
    pub(crate) surfaces: Surfaces,
}

impl Still {
    fn is_same(&self, other: &Self) -> bool {
        let is_same_sky = match (&self.sky, &other.sky) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (a, b) => a.is_none() && b.is_none(),
        };
        let of = |still: &Self| (still.orbit, still.size, still.turn, still.strength, still.bounces, still.surfaces);
        is_same_sky
            && Arc::ptr_eq(&self.data.scene, &other.data.scene)
            && of(self) == of(other)
            && self.behind == other.behind
            && self.lamps == other.lamps
    }
}

/// What passes have found so far.
pub(crate) struct Refined {
    /// The mean of all passes.
    pub(crate) mean: Picture,
    /// Paths of each pixel.
    pub(crate) paths: u64,
}

impl Refined {
    /// The root mean square of the difference to a picture over the mean; none of a picture of another size.
    pub(crate) fn error_of(&self, found: &Picture) -> Option<f64> {
        let mean = self.mean.mean().iter().sum::<f64>() / 3.0;
        let is_same_size = (found.width(), found.height()) == (self.mean.width(), self.mean.height());
        is_same_size.then(|| compare(found.pixels(), self.mean.pixels()).rmse / mean.max(f64::MIN_POSITIVE))
    }
}

/// The truth of what stands still, and how it is shown.
#[derive(Default)]
pub(crate) struct Truth {
    task: Option<(Still, Task<Refined>)>,
    refined: Option<Refined>,
    texture: Option<TextureHandle>,
    /// What the texture shows; none before it shows this truth.
    shown: Option<ShownKey>,
    /// The root mean square of the difference over the mean of the truth.
    error: Option<f64>,
    message: Option<String>,
    grid: SkyGrid,
}

/// The paths, how light is shown and the comparison that a texture shows.
type ShownKey = (u64, Look, Shows);

/// What a texture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shows {
    Truth,
    /// Red where the picture is too bright, blue where it is too dark.
    Difference,
}

impl Truth {
    /// Forgets it, for something that moves.
    pub(crate) fn stop(&mut self) {
        (self.task, self.refined, self.shown) = (None, None, None);
        (self.error, self.message) = (None, None);
    }

    /// Starts where another truth is asked for, and takes what passes have found.
    pub(crate) fn follow(&mut self, ctx: &Context, still: &Still) {
        if IN_PAGE {
            self.message = Some("A page traces no paths: it has one thread".into());
            return;
        }
        if self.task.as_ref().is_none_or(|(before, _)| !before.is_same(still)) {
            self.stop();
            let (work, grid, ctx) = (still.clone(), self.grid.clone(), ctx.clone());
            let work = move |control: &_| refine(control, &work, &grid);
            let task = Task::start("Truth", move || ctx.request_repaint(), work);
            self.task = Some((still.clone(), task));
        }
        for event in self.task.as_ref().map(|(_, task)| task.events()).unwrap_or_default() {
            match event {
                TaskEvent::Result(refined) => self.refined = Some(refined),
                TaskEvent::Failed(message) => self.message = Some(message),
                TaskEvent::Done | TaskEvent::Cancelled => {}
            }
        }
    }

    /// What passes have found so far.
    pub(crate) fn refined(&self) -> Option<&Refined> {
        self.refined.as_ref()
    }

    /// The root mean square of the difference to what it was shown beside, over its mean; none before it was.
    pub(crate) fn error(&self) -> Option<f64> {
        self.error
    }

    /// What is known, in one line.
    pub(crate) fn describe(&self) -> String {
        match (&self.message, &self.refined, self.error) {
            (Some(message), ..) => message.clone(),
            (None, None, _) => "Tracing the truth".into(),
            (None, Some(refined), None) => format!("{} paths a pixel", refined.paths),
            (None, Some(refined), Some(error)) => {
                format!("{} paths a pixel, RMS difference {:.1} % of the mean", refined.paths, 100.0 * error)
            }
        }
    }

    /// The texture of the truth, or of the difference to `found`; none before the first pass.
    pub(crate) fn texture(
        &mut self,
        ctx: &Context,
        shows: Shows,
        found: impl FnOnce() -> Option<(Picture, f64)>,
        look: Look,
    ) -> Option<TextureId> {
        let refined = self.refined.as_ref()?;
        let key = (refined.paths, look, shows);
        if let Some(texture) = self.texture.as_ref().filter(|_| self.shown == Some(key)) {
            return Some(texture.id());
        }
        let (found, fitting) = found()?;
        let tone = look.of(fitting);
        let is_same_size = (found.width(), found.height()) == (refined.mean.width(), refined.mean.height());
        self.error = refined.error_of(&found);
        let bytes = match shows {
            Shows::Difference if is_same_size => {
                Tone { curve: Curve::Clip, ..tone }.to_bytes(&difference(&found, &refined.mean))
            }
            _ => tone.to_bytes(&refined.mean),
        };
        let image = ColorImage::from_rgb([refined.mean.width(), refined.mean.height()], &bytes);
        self.shown = Some(key);
        match &mut self.texture {
            Some(texture) => texture.set(image, TextureOptions::LINEAR),
            None => self.texture = Some(ctx.load_texture("truth", image, TextureOptions::LINEAR)),
        }
        self.texture.as_ref().map(TextureHandle::id)
    }
}

/// Red where the first picture has more luminance, blue where it has less.
fn difference(found: &Picture, truth: &Picture) -> Picture {
    Picture::from_fn(truth.width(), truth.height(), |x, y| {
        let more = Rgb::from(found.pixel(x, y)).luminance() - Rgb::from(truth.pixel(x, y)).luminance();
        let (red, blue) = (more.max(0.0), (-more).max(0.0));
        [red + 0.1 * blue, 0.15 * red + 0.3 * blue, 0.1 * red + blue]
    })
}

/// Traces pass after pass, each by random numbers of its own, and hands out the mean of all.
fn refine(control: &Control<Refined>, still: &Still, grid: &SkyGrid) -> Result<(), String> {
    control.stage("tracing");
    let mut watch = control.watch();
    let job = Job::default().watched_by(&mut watch);
    let light = match grid.light(still.sky.as_ref(), (still.strength, &still.turn), &still.lamps, job) {
        Err(EnvError::Cancelled) => return Ok(()),
        other => other.map_err(|error| error.to_string())?.before(still.behind.backdrop()),
    };
    let emitters = &still.emitters;
    let Some(camera) = still.orbit.camera() else { return Err("the camera looks at its own place".into()) };
    let [width, height] = still.size.map(|side| side as usize);
    let mut sums = vec![[0.0_f64; 3]; width * height];
    for pass in 0..PASSES {
        let paths = PathOptions::default().bounces(still.bounces).surfaces(still.surfaces).seed(pass);
        let options = TruthOptions::default().width(width).height(height).count(PATHS).paths(paths);
        let mut watch = control.watch();
        let job = Job::default().watched_by(&mut watch);
        let (scene, bvh) = (&still.data.scene, &still.data.bvh);
        let traced = match render_truth_with_emitters(scene, bvh, &camera, &light, emitters, &options, job) {
            Err(RenderError::Cancelled) => return Ok(()),
            other => other.map_err(|error| error.to_string())?,
        };
        for (sum, pixel) in sums.iter_mut().zip(traced.mean.pixels()) {
            (0..3).for_each(|c| sum[c] += f64::from(pixel[c]));
        }
        let part = 1.0 / (pass + 1) as f64;
        let mean = sums.iter().map(|sum| sum.map(|c| (part * c) as f32)).collect();
        let mean = Picture::new(width, height, mean).map_err(|error| error.to_string())?;
        control.send(Refined { mean, paths: (pass + 1) * PATHS.total() as u64 });
    }
    Ok(())
}
