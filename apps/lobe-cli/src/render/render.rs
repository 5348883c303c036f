//! `lobe render`: a scene under distant light, by transfer or by path tracing.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::bail;
use clap::{Args, ValueEnum};
use lobe::env::{EnvMap, write_env};
use lobe::image::{AnimatedPng, Curve, Exposure, ImageError, Picture, PictureWriteOptions, Tone};
use lobe::io::{Job, Progress, StagedFile, StagedWriter, Watch};
use lobe::render::{
    BakedScene, Camera, DistantLight, GlossyLobe, LitPicture, PathOptions, RenderError, SampleCount, Surfaces, Truth,
    TruthOptions, ViewOptions, light_baked_scene, light_by_irradiance, render_truth,
};
use lobe::scene::{Bvh, Scene};
use lobe::sh::{Dir, Rgb, Rotation, ShVec};

use crate::args::memory::MemoryLimit;
use crate::args::output;
use crate::args::picture::note_clamped;
use crate::args::scene_input::SceneInput;
use crate::args::values;
use crate::render::light::{LightInput, ReadLight};
use crate::render::transfer::{Asked, parse_lobe};
use crate::render::view::ViewInput;
use crate::run::bake_watch::Checkpoint;
use crate::run::ctrl_c;
use crate::run::talk::Talk;

/// Limits of the options. Larger numbers are taken for typing errors.
const MAX_SAMPLES: usize = 1 << 20;
const MAX_BOUNCES: usize = 255;
const MAX_FRAMES: usize = 1000;

/// Samples of a pixel without --samples: paths of the truth, rays of all else.
const PATHS: usize = 64;
const RAYS: usize = 4;

/// Bounces without --bounces, as in the bake.
const BOUNCES: usize = 3;

/// The order of irradiance without --order: higher bands hardly show.
const IRRADIANCE_ORDER: usize = 3;

/// The lobe without --lobe: about the sharpest that order 4 can show.
const LOBE: GlossyLobe = GlossyLobe::Ggx(0.3);

/// A turn of 36 frames takes three seconds.
const SECONDS_PER_FRAME: f64 = 1.0 / 12.0;

/// Bytes that a pixel takes in memory at most (test `work_takes_no_more_memory_than_is_said`). Of the truth 14 numbers
/// four times: traced and on the way to the checkpoint, or in layers, as channels and compressed. Else three numbers
/// five times: twice as they are, compressed in blocks and as a file, and some room.
const TRACED_PIXEL: u64 = 4 * 14 * 4;
const SHADED_PIXEL: u64 = 4 * 3 * 5;

/// Steps of one picture in the line of progress.
const STEPS: usize = 1000;

const NOTES: &str = "\
Surfaces seen from behind: single-sided ones are black, in every mode, and stop light all the same. Double-sided ones show the light \
that falls on their back. Baked files hold fronts; backs are baked on the way, with as many paths, as far as the view shows them: of a \
closed body seen from outside there are none.

Memory: 224 bytes for each pixel of the truth, 60 else, for one picture at a time; transfer that is baked on the way, twice 4 n² bytes \
for each vertex and channel, of glossy 4 n⁴. Scene, light and transfer from a file come on top and are as large as their files.";

#[derive(Args)]
#[command(after_help = NOTES)]
pub(crate) struct Render {
    #[command(flatten)]
    scene: SceneInput,
    #[command(flatten)]
    light: LightInput,
    /// The method that makes the picture
    #[arg(long, value_enum)]
    mode: Mode,
    /// The picture: .png tone-mapped for looking at, .exr with the values; of the truth with variance, albedo, normal, depth and
    /// coverage
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    #[command(flatten)]
    view: ViewInput,
    /// Paths (truth) or rays (else) for each pixel [default: 64, 4]
    #[arg(long, value_name = "N", value_parser = samples)]
    samples: Option<usize>,
    /// truth, interreflected, glossy: the number of reflections before that of the surface that is seen [default: 3]
    #[arg(long, value_name = "B", value_parser = bounces)]
    bounces: Option<usize>,
    /// truth: the model of reflection [default: matte, as in a bake]
    #[arg(long, value_enum)]
    surfaces: Option<SurfaceModel>,
    /// truth: another seed gives other paths [default: 0]
    #[arg(long, value_name = "S")]
    seed: Option<u64>,
    /// Paths from each vertex where the scene is not baked yet, 1 to 1048576 [default: 1024]
    #[arg(long, value_name = "N", value_parser = samples)]
    bake_samples: Option<usize>,
    /// All but truth and irradiance: the transfer of this scene that lobe bake, compress or fit-lobes wrote without the scene, a
    /// .safetensors file, or an .exr file of lobe bake --texels
    #[arg(long, value_name = "FILE")]
    transfer: Option<PathBuf>,
    /// glossy: the lobe of reflection about the mirrored view, tinted by the base color [default: ggx:0.3]. For metals of α 0.3
    /// the picture differs by 18 % from --mode truth --surfaces gltf, for rougher ones by more
    #[arg(long, value_name = "phong:E|ggx:ALPHA", value_parser = parse_lobe)]
    lobe: Option<GlossyLobe>,
    /// All but truth, which shows the light that it uses: the background behind the scene; light, to compare with a truth of
    /// the same --order [default: env]
    #[arg(long, value_enum)]
    background: Option<Background>,
    /// Multiply the light of a .png by this before it is tone-mapped [default: as suits the picture, with --frames the first one]
    #[arg(long, value_name = "X", value_parser = values::positive)]
    exposure: Option<f64>,
    /// Turn the light once around in this many pictures: OUT-000.png (or .exr) and on, and all of them as an animation in
    /// OUT.png
    #[arg(long, value_name = "N", value_parser = frames)]
    frames: Option<usize>,
    #[command(flatten)]
    memory: MemoryLimit,
    /// truth: start anew, even if there is a checkpoint of a picture that was stopped
    #[arg(long)]
    fresh: bool,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Mode {
    /// Path tracing: shadows and reflections between surfaces
    Truth,
    /// The irradiance of the expansion by shading normal, times albedo/π
    Irradiance,
    /// Transfer without shadows
    Unshadowed,
    /// Transfer with shadows
    Shadowed,
    /// Transfer with shadows and reflections between surfaces
    Interreflected,
    /// Transfer matrices with shadows and reflections between surfaces, and rough mirrors
    Glossy,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum SurfaceModel {
    /// Lambert with the base color as albedo
    Matte,
    /// The metallic-roughness model of glTF
    Gltf,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Background {
    /// The environment as it was given
    Env,
    /// The expansion that lights the scene
    Light,
}

fn samples(text: &str) -> Result<usize, String> {
    values::whole(text, 1, MAX_SAMPLES, "a number of samples")
}

fn bounces(text: &str) -> Result<usize, String> {
    values::whole(text, 0, MAX_BOUNCES, "a number of reflections")
}

fn frames(text: &str) -> Result<usize, String> {
    values::whole(text, 2, MAX_FRAMES, "a number of pictures")
}

/// A picture, with all its channels if it was traced.
enum Rendered {
    Traced(Box<Truth>),
    Shaded(LitPicture),
}

impl Rendered {
    fn picture(&self) -> &Picture {
        match self {
            Self::Traced(truth) => &truth.mean,
            Self::Shaded(shaded) => &shaded.picture,
        }
    }
}

/// The scene, with transfer where the mode needs it.
enum Stage {
    Plain(Scene, Bvh),
    Baked(Box<BakedScene>),
}

/// The inputs that all frames share.
struct Work<'a> {
    stage: Stage,
    camera: Camera,
    light: &'a ReadLight,
    /// None where the light is used as it was given.
    expansion: Option<ShVec<Rgb<f64>>>,
}

impl Render {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        self.check_options()?;
        let frames = self.frames.unwrap_or(1);
        self.check_memory()?;
        for path in (0..frames).map(|k| self.frame_path(k)).chain(self.animation_path()) {
            for input in
                [Some(self.scene.path()), Some(self.light.path()), self.transfer.as_deref()].into_iter().flatten()
            {
                output::check_not_input(&path, input)?;
            }
            output::prepare_file(&path)?;
        }
        let light = self.light.read(talk)?;
        let (stage, camera) = match self.asked() {
            None => {
                let scene = self.scene.read(talk)?;
                let (bvh, camera) = (Bvh::new(&scene), self.view.camera(&scene)?);
                (Stage::Plain(scene, bvh), camera)
            }
            Some(asked) => {
                let view = |scene: &Scene| Ok((self.view.camera(scene)?, self.view_options()));
                let (baked, camera) = asked.prepare(&self.scene, view, &self.memory, talk)?;
                (Stage::Baked(Box::new(baked)), camera)
            }
        };
        let order = if let Stage::Baked(baked) = &stage { baked.order() } else { IRRADIANCE_ORDER };
        let is_expansion = self.mode != Mode::Truth || self.light.asks_for_expansion(&light);
        let expansion = is_expansion.then(|| self.light.expansion(&light, order));
        let work = Work { stage, camera, light: &light, expansion };
        self.render_all(&work, frames, talk)
    }

    fn render_all(&self, work: &Work<'_>, frames: usize, talk: Talk) -> anyhow::Result<()> {
        let checkpoints: Vec<_> = (0..frames).map(|k| Checkpoint::beside(&self.frame_path(k))).collect();
        if self.fresh {
            checkpoints.iter().try_for_each(Checkpoint::discard)?;
        }
        ctrl_c::watch();
        match self.animation_path() {
            None => self.render_frames(work, &checkpoints, talk, &mut |_, _| Ok(()))?,
            Some(path) => {
                let io = |source| RenderError::Io { place: path.display().to_string(), source };
                let in_file = |error| match error {
                    ImageError::Output(source) => io(source),
                    other => other.into(),
                };
                let mut file = StagedWriter::new(&path).map_err(io)?;
                let (width, height) = self.view.size();
                let mut animation =
                    AnimatedPng::new(&mut file, width, height, frames, SECONDS_PER_FRAME).map_err(in_file)?;
                self.render_frames(work, &checkpoints, talk, &mut |picture, tone| {
                    animation.add(picture, tone).map_err(in_file)
                })?;
                animation.finish().map_err(in_file)?;
                file.finish().and_then(StagedFile::publish).map_err(io)?;
            }
        }
        checkpoints.iter().for_each(Checkpoint::finish);
        Ok(())
    }

    /// Renders and writes all pictures, one after the other; each is handed to `animate` and dropped.
    fn render_frames(
        &self,
        work: &Work<'_>,
        checkpoints: &[Checkpoint],
        talk: Talk,
        animate: &mut dyn FnMut(&Picture, &Tone) -> Result<(), RenderError>,
    ) -> anyhow::Result<()> {
        let frames = checkpoints.len();
        let (line, total, begin) = (talk.progress("render"), frames * STEPS, Instant::now());
        let mut resumed = 0;
        let mut tone = None;
        for (k, checkpoint) in checkpoints.iter().enumerate() {
            let turn = self.light.turn(k, frames);
            let mut is_told = false;
            let rendered = self.render(work, &turn, checkpoint, &mut |progress| {
                let part = progress.done as f64 / progress.total as f64;
                let steps = (part * STEPS as f64) as usize;
                if !is_told && progress.resumed > 0 {
                    let text = format!("found; going on from {:.0} %", 100.0 * part);
                    talk.note(&checkpoint.path().display().to_string(), &text);
                    resumed += steps;
                }
                is_told = true;
                let elapsed = begin.elapsed();
                let all = Progress { done: k * STEPS + steps, total, resumed, elapsed, ..Progress::default() };
                line.show(all.done, total, None, all.seconds_left());
                ctrl_c::go_on()
            });
            let rendered = match rendered {
                Err(RenderError::Cancelled) => bail!(self.stopped(k, frames)),
                other => other?,
            };
            let tone = *tone.get_or_insert_with(|| self.tone(rendered.picture()));
            self.write(&rendered, &tone, k, talk)?;
            if let (0, Rendered::Shaded(shaded)) = (k, &rendered) {
                self.note_ringing(shaded.below_zero, talk);
            }
            animate(rendered.picture(), &tone)?;
        }
        Ok(())
    }

    /// Notes where the picture is below zero because the expansion of the light rings.
    fn note_ringing(&self, below: f64, talk: Talk) {
        if below > 0.0 {
            let text = format!(
                "{:.2} % of what is seen of the scene is below zero, because the light rings; --window, or a light from \
                 lobe sh dering, stops that",
                100.0 * below
            );
            talk.note(&self.output.display().to_string(), &text);
        }
    }

    /// The message when picture `k` was not finished: the files that are left.
    fn stopped(&self, k: usize, frames: usize) -> String {
        let complete =
            if self.frames.is_some() { format!("after {k} of {frames} pictures") } else { "before the end".into() };
        match self.mode {
            Mode::Truth => {
                format!("stopped {complete}; the same command goes on from there, --fresh starts anew")
            }
            _ if k > 0 => format!("stopped {complete}, which are kept; the same command starts anew"),
            _ => format!("stopped {complete}; nothing is kept, and the same command starts anew"),
        }
    }

    fn render(
        &self,
        work: &Work<'_>,
        turn: &Rotation,
        checkpoint: &Checkpoint,
        watch: Watch<'_>,
    ) -> Result<Rendered, RenderError> {
        let job = Job::default().watched_by(watch);
        match (&work.stage, &work.expansion) {
            (Stage::Plain(scene, bvh), expansion) if self.mode == Mode::Truth => {
                let light = match expansion {
                    Some(f) => DistantLight::from_expansion(f.clone()),
                    None => work.light.as_it_is(),
                };
                let (light, options) = (light.turned(turn), self.truth_options());
                let job = job.kept_in(checkpoint.path());
                let truth = render_truth(scene, bvh, &work.camera, &light, &options, job)?;
                Ok(Rendered::Traced(Box::new(truth)))
            }
            (stage, Some(f)) => {
                let behind = match self.background.unwrap_or(Background::Env) {
                    Background::Env => work.light.as_it_is(),
                    Background::Light => DistantLight::from_expansion(f.clone()),
                };
                let (behind, f) = (behind.turned(turn), turn.rotated(f));
                let background = |s: Dir| behind.radiance(s);
                let (camera, options) = (&work.camera, self.view_options());
                let lit = match stage {
                    Stage::Baked(baked) => light_baked_scene(baked, &f, camera, &options, background, job),
                    Stage::Plain(scene, bvh) => {
                        light_by_irradiance((scene, bvh), &f, camera, &options, background, job)
                    }
                };
                lit.map(Rendered::Shaded)
            }
            (_, None) => unreachable!("all modes but truth light with an expansion"),
        }
    }

    fn truth_options(&self) -> TruthOptions {
        let (width, height) = self.view.size();
        let count = SampleCount::of(self.samples.unwrap_or(PATHS));
        TruthOptions::default().width(width).height(height).count(count).paths(self.path_options())
    }

    /// The options of the view of all modes but truth.
    fn view_options(&self) -> ViewOptions {
        let (width, height) = self.view.size();
        let rays = (self.samples.unwrap_or(RAYS) as f64).sqrt().ceil() as usize;
        ViewOptions::default().width(width).height(height).rays(rays)
    }

    fn path_options(&self) -> PathOptions {
        let surfaces = match self.surfaces {
            None | Some(SurfaceModel::Matte) => Surfaces::Matte,
            Some(SurfaceModel::Gltf) => Surfaces::MetallicRoughness,
        };
        let bounces = self.bounces.unwrap_or(BOUNCES);
        PathOptions::default().bounces(bounces).surfaces(surfaces).seed(self.seed.unwrap_or(0))
    }

    /// The transfer that the mode needs.
    fn asked(&self) -> Option<Asked> {
        let mode = match self.mode {
            Mode::Truth | Mode::Irradiance => return None,
            Mode::Unshadowed => lobe::prt::Mode::Unshadowed,
            Mode::Shadowed => lobe::prt::Mode::Shadowed,
            Mode::Interreflected | Mode::Glossy => lobe::prt::Mode::Interreflected,
        };
        let lobe = (self.mode == Mode::Glossy).then(|| self.lobe.unwrap_or(LOBE));
        let (order, samples, file) = (self.light.order(), self.bake_samples, self.transfer.clone());
        Some(Asked { mode, order, samples, bounces: self.bounces, lobe, file })
    }

    fn tone(&self, first: &Picture) -> Tone {
        match self.exposure {
            Some(exposure) => Tone { exposure: Exposure::Fixed(exposure), ..Tone::PHOTOGRAPH },
            None => Tone::PHOTOGRAPH.fixed_for(first),
        }
    }

    fn write(&self, rendered: &Rendered, tone: &Tone, k: usize, talk: Talk) -> anyhow::Result<()> {
        let path = self.frame_path(k);
        let name = path.display().to_string();
        if self.is_png() {
            rendered.picture().write_png(&path, tone)?;
            if let (0, Exposure::Fixed(exposure), Curve::Reinhard { .. }) = (k, tone.exposure, tone.curve) {
                talk.note(&name, &format!("tone-mapped for looking at, exposure {exposure:.3}; .exr holds the values"));
            }
            return Ok(());
        }
        match rendered {
            Rendered::Traced(truth) => truth.write_exr(&path)?,
            Rendered::Shaded(LitPicture { picture, .. }) => {
                let pixels = EnvMap::new(picture.width(), picture.height(), picture.clone().into_pixels())?;
                note_clamped(&name, write_env(&path, &pixels, &PictureWriteOptions::default())?, talk);
            }
        }
        Ok(())
    }

    /// Refuses a picture that takes too much memory.
    fn check_memory(&self) -> anyhow::Result<()> {
        let (width, height) = self.view.size();
        let each = if self.mode == Mode::Truth { TRACED_PIXEL } else { SHADED_PIXEL };
        let bytes = each.saturating_mul((width * height) as u64);
        self.memory.check(&format!("--size {width}x{height}"), bytes, "a smaller picture")
    }

    /// Refuses options that would be ignored.
    fn check_options(&self) -> anyhow::Result<()> {
        let is_truth = self.mode == Mode::Truth;
        let bakes = !matches!(self.mode, Mode::Truth | Mode::Irradiance);
        let bounces = matches!(self.mode, Mode::Truth | Mode::Interreflected | Mode::Glossy);
        let ignored = [
            (self.bounces.is_some() && !bounces, "--bounces: only of --mode truth, interreflected and glossy"),
            (self.surfaces.is_some() && !is_truth, "--surfaces: only of --mode truth; all others are matte"),
            (self.seed.is_some() && !is_truth, "--seed: only --mode truth is random"),
            (self.bake_samples.is_some() && !bakes, "--bake-samples: only of modes with transfer"),
            (self.transfer.is_some() && !bakes, "--transfer: only of modes with transfer"),
            (self.lobe.is_some() && self.mode != Mode::Glossy, "--lobe: only of --mode glossy"),
            (self.background.is_some() && is_truth, "--background: --mode truth shows the light it uses"),
            (self.fresh && !is_truth, "--fresh: only --mode truth keeps a checkpoint"),
            (self.exposure.is_some() && !self.is_png() && self.frames.is_none(), "--exposure: only of .png pictures"),
        ];
        if let Some((_, message)) = ignored.into_iter().find(|(is_ignored, _)| *is_ignored) {
            bail!("{message}; leave the option out");
        }
        if !self.is_png() && !self.has_extension("exr") {
            bail!("-o: expected a name that ends in .png or .exr, found {}", self.output.display());
        }
        Ok(())
    }

    fn is_png(&self) -> bool {
        self.has_extension("png")
    }

    fn has_extension(&self, extension: &str) -> bool {
        self.output.extension().is_some_and(|found| found.eq_ignore_ascii_case(extension))
    }

    /// The path of picture `k`.
    fn frame_path(&self, k: usize) -> PathBuf {
        if self.frames.is_none() {
            return self.output.clone();
        }
        let stem = self.output.file_stem().unwrap_or_default().to_string_lossy();
        let extension = if self.is_png() { "png" } else { "exr" };
        self.output.with_file_name(format!("{stem}-{k:03}.{extension}"))
    }

    fn animation_path(&self) -> Option<PathBuf> {
        self.frames.map(|_| self.output.with_extension("png"))
    }
}
