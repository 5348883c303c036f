//! Scenes that move in `lobe render`: their files, the times of the pictures, and the bakes that their parts lack.

use anyhow::bail;
use clap::{Args, ValueEnum};
use lobe::prt::BakeOptions;
use lobe::render::{MovingBakeOptions, MovingMethod, MovingOptions, MovingScene, MovingShading};
use lobe::scene::{AnimatedScene, built_in};
use lobe::sh::ExpMethod;
use lobe::shadow::{FieldOptions, ShadowOptions};

use crate::args::memory::MemoryLimit;
use crate::args::scene_input::SceneInput;
use crate::args::values;
use crate::run::bake_watch::watched;
use crate::run::talk::Talk;

/// Pictures for each second of `--frames A..B`, as films have.
const FRAMES_PER_SECOND: f64 = 24.0;

/// The norm above which `--exponential hybrid` halves: at 1 it is nearest to the truth among those of the example
/// `exponential_errors`.
const HYBRID_LIMIT: f64 = 1.0;

/// Options of scenes that move.
#[derive(Args)]
#[command(next_help_heading = "Scenes that move")]
pub(crate) struct MovingInput {
    /// Show an animated glTF file, a scene description (.json) or built-in:three-objects or built-in:walking-figure at this time
    /// [default: 0]
    #[arg(long, value_name = "SECONDS", allow_hyphen_values = true, value_parser = values::finite)]
    time: Option<f64>,
    /// With --frames A..B: pictures for each second [default: 24]
    #[arg(long, value_name = "N", value_parser = values::positive)]
    fps: Option<f64>,
    /// The animation of a glTF file, by name or number [default: the first]
    #[arg(long, value_name = "NAME")]
    animation: Option<String>,
    /// shexp: the exponential [default: grid]
    #[arg(long, value_enum)]
    exponential: Option<Exponential>,
    /// fields, shexp: spheres fitted to each part that is deformed, and in shexp to each that moves [default: 16;
    /// more overlap more, and count twice what they hide together]
    #[arg(long, value_name = "K", value_parser = spheres)]
    spheres: Option<usize>,
    /// fields, shexp: light that spheres send on, one bounce
    #[arg(long)]
    sphere_bounce: bool,
    /// fields, shexp: what stands still hides the sky from what moves, by a field; without this it only receives shadows
    #[arg(long)]
    still_hides: bool,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Exponential {
    /// Values on a grid of directions
    Grid,
    /// The best linear function of single spheres
    OptimalLinear,
    /// That after halving, then squared
    Hybrid,
}

fn spheres(text: &str) -> Result<usize, String> {
    values::whole(text, 1, 4096, "a number of spheres")
}

impl MovingInput {
    /// Whether an option asks for a scene that moves; its name for messages.
    pub(crate) fn asked(&self) -> Option<&'static str> {
        [
            (self.time.is_some(), "--time"),
            (self.fps.is_some(), "--fps"),
            (self.animation.is_some(), "--animation"),
            (self.exponential.is_some(), "--exponential"),
            (self.spheres.is_some(), "--spheres"),
            (self.sphere_bounce, "--sphere-bounce"),
            (self.still_hides, "--still-hides"),
        ]
        .into_iter()
        .find_map(|(is_asked, name)| is_asked.then_some(name))
    }

    /// Whether options of shading are given, which the truth ignores; the name of one.
    pub(crate) fn asked_of_shading(&self) -> Option<&'static str> {
        [
            (self.exponential.is_some(), "--exponential"),
            (self.spheres.is_some(), "--spheres"),
            (self.sphere_bounce, "--sphere-bounce"),
            (self.still_hides, "--still-hides"),
        ]
        .into_iter()
        .find_map(|(is_asked, name)| is_asked.then_some(name))
    }

    /// Refuses options that contradict each other.
    pub(crate) fn check(&self, has_range: bool, method: Option<MovingMethod>) -> anyhow::Result<()> {
        if has_range && self.time.is_some() {
            bail!("--time: --frames A..B says the times; leave one of them out");
        }
        if self.fps.is_some() && !has_range {
            bail!("--fps: only of --frames A..B; leave the option out");
        }
        if self.exponential.is_some() && method != Some(MovingMethod::Exponentials) {
            bail!("--exponential: only of --mode shexp; leave the option out");
        }
        Ok(())
    }

    /// The time of a picture, in seconds: of frame `frame` of a range, else the one that was asked for.
    pub(crate) fn time_of(&self, frame: Option<usize>) -> f64 {
        match frame {
            Some(frame) => frame as f64 * self.seconds_per_frame(),
            None => self.time.unwrap_or(0.0),
        }
    }

    /// The time from one picture of a range to the next.
    pub(crate) fn seconds_per_frame(&self) -> f64 {
        self.fps.unwrap_or(FRAMES_PER_SECOND).recip()
    }

    /// Reads or makes the scene.
    pub(crate) fn read(&self, input: &SceneInput, memory: &MemoryLimit, talk: Talk) -> anyhow::Result<MovingScene> {
        let name = input.name();
        if input.has_extension(&["json"]) {
            if self.animation.is_some() {
                bail!("--animation: only of glTF files; the tracks of a scene description are all it has");
            }
            let (moving, notes) = MovingScene::read(input.path(), &input.checked_options(memory)?)?;
            notes.iter().for_each(|note| talk.note(&name, note));
            return Ok(moving);
        }
        let animated = match built_in::moving(name.strip_prefix("built-in:").unwrap_or_default()) {
            Some(animated) => animated,
            None if input.is_gltf() => {
                let (animated, report) = AnimatedScene::read(input.path(), &input.checked_options(memory)?)?;
                report.notes.iter().for_each(|note| talk.note(&name, note));
                animated
            }
            None => AnimatedScene::still(input.read(memory, talk)?),
        };
        let animation = match &self.animation {
            Some(asked) => Some(animated.animation(asked)?),
            None => (!animated.animations().is_empty()).then_some(0),
        };
        if animation.is_none() {
            talk.note(&name, "has no animation; it is shown as it stands");
        }
        Ok(MovingScene::animated(animated, animation)?)
    }

    /// Bakes what the parts lack, and prepares the shading.
    pub(crate) fn prepare(
        &self,
        moving: &mut MovingScene,
        method: MovingMethod,
        transfer: &BakeOptions,
        talk: Talk,
    ) -> anyhow::Result<MovingShading> {
        let bake = MovingBakeOptions::default();
        let spheres = bake.spheres.clone();
        let count = self.spheres.unwrap_or(spheres.count);
        let bake = bake
            .transfer(transfer.clone())
            .field(FieldOptions::default().order(transfer.order))
            .spheres(spheres.count(count))
            .still_hides(self.still_hides);
        let baked = watched(talk, "bake", |job| moving.bake(method, &bake, job))?;
        if baked.is_err() {
            bail!(
                "stopped while parts were baked, of which nothing is kept; lobe field, spheres and bake keep theirs in files"
            );
        }
        let exponential = match self.exponential {
            None | Some(Exponential::Grid) => ExpMethod::Grid,
            Some(Exponential::OptimalLinear) => ExpMethod::OptimalLinear,
            Some(Exponential::Hybrid) => ExpMethod::Hybrid { limit: HYBRID_LIMIT },
        };
        let options = MovingOptions::default()
            .method(method)
            .order(transfer.order)
            .spheres(ShadowOptions::default().method(exponential))
            .bounce(self.sphere_bounce);
        Ok(MovingShading::new(options)?)
    }
}
