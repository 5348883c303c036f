//! Moments of a moving scene, lit beside the window.

use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};

use lobe::io::Job;
use lobe::prt::{BakeMode, BakeOptions};
use lobe::render::{
    Moment, Motion, MovingBakeOptions, MovingMethod, MovingOptions, MovingPart, MovingScene, MovingShading,
    PartBakeKind, RenderError,
};
use lobe::scene::{Mesh, Scene};
use lobe::sh::{Dir, Rgb, Rotation, ShVec};
use lobe::shadow::{FieldOptions, Placement, SphereFitMethod, SphereFitOptions, Track, WorldSphere};
use serde::{Deserialize, Serialize};
use web_time::Instant;

use crate::loading::moving_source::{is_file, open_moving};
use crate::loading::task::{Control, Task, TaskEvent};

/// Number of bands of light, transfer, fields and spheres.
pub(crate) const ORDER: usize = 4;

/// Paths from each vertex for the transfer of parts.
const SAMPLES: u32 = 64;

/// Directions traced from each point around a part for its field.
const FIELD_RAYS: u32 = 128;

/// Points that spheres are fitted to: fewer than the library takes, so that a fit ends in seconds.
const FIT_SAMPLES: usize = 1500;

/// Times as many spheres for a part that changes its shape: it has limbs.
const DEFORMED: usize = 4;

/// How spheres are fitted to a part that keeps its shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct Fit {
    pub(crate) count: usize,
    pub(crate) method: SphereFitMethod,
}

impl Default for Fit {
    fn default() -> Self {
        Self { count: 16, method: SphereFitMethod::Variational }
    }
}

/// Where a user has put a part.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Hand {
    pub(crate) position: [f64; 3],
    /// About +z, in radians.
    pub(crate) turn: f64,
    /// Its size over that which it has.
    pub(crate) scale: f64,
}

/// What is to be shown.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Asked {
    pub(crate) time: f64,
    pub(crate) method: MovingMethod,
    pub(crate) light: ShVec<Rgb<f64>>,
    /// Of exponentials.
    pub(crate) fit: Fit,
    /// Where each part is; none while the animation plays.
    pub(crate) hands: Option<Vec<Hand>>,
}

/// What comes from the player.
pub(crate) enum News {
    /// The parts are baked.
    Ready(Cast),
    /// A moment was lit.
    Lit(Box<Lit>),
}

/// The parts of the scene.
#[derive(Clone, Debug)]
pub(crate) struct Cast {
    pub(crate) names: Vec<String>,
    /// Which stand still.
    pub(crate) is_still: Vec<bool>,
    /// Where the parts are at first.
    pub(crate) hands: Vec<Hand>,
    /// About how far each reaches from its middle.
    pub(crate) radii: Vec<f64>,
    /// Whether all can be moved by hand: none changes its shape.
    pub(crate) is_rigid: bool,
    /// The first and the last time, in seconds.
    pub(crate) span: [f64; 2],
}

/// A moment and its light.
pub(crate) struct Lit {
    pub(crate) asked: Asked,
    pub(crate) scene: Scene,
    pub(crate) radiance: Vec<Rgb<f32>>,
    pub(crate) spheres: Vec<WorldSphere>,
    /// What the light of all vertices took.
    pub(crate) milliseconds: f64,
}

/// A thread that lights the moment that was asked for last.
pub(crate) struct Player {
    task: Task<News>,
    asks: Sender<Asked>,
}

impl Player {
    /// Opens a scene and bakes its parts.
    pub(crate) fn start(source: &Path, wake: impl Fn() + Send + 'static) -> Self {
        let (asks, asked) = channel();
        let source = source.to_owned();
        let task = Task::start("Parts", wake, move |control| play(control, &source, &asked).map_err(|e| e.to_string()));
        Self { task, asks }
    }

    /// Asks for a moment; those that were asked for before and not begun are forgotten.
    pub(crate) fn ask(&self, asked: Asked) {
        // Of a player that has ended nothing comes; its end says why.
        drop(self.asks.send(asked));
    }

    pub(crate) fn events(&self) -> Vec<TaskEvent<News>> {
        self.task.events()
    }

    pub(crate) fn task(&self) -> &Task<News> {
        &self.task
    }
}

fn play(control: &Control<News>, source: &Path, asked: &Receiver<Asked>) -> anyhow::Result<()> {
    control.stage(source.file_name().unwrap_or_default().to_string_lossy());
    let mut common = open_moving(source)?;
    common.bake_lamps(ORDER)?;
    let mut fit = Fit::default();
    // The built-in scenes stand on open ground, which hides nothing from what moves over it.
    let still_hides = is_file(source);
    if !prepare(control, &mut common, MovingMethod::Fields, &bake_options(fit, still_hides), IS_COMMON)? {
        return Ok(());
    }
    // What has fields needs no spheres, and the other way round: each way has a scene of its own.
    let mut scenes = [common.clone(), common.clone()];
    if !prepare(control, &mut scenes[0], MovingMethod::Fields, &bake_options(fit, still_hides), IS_ANY)? {
        return Ok(());
    }
    control.send(News::Ready(cast(&scenes[0])?));
    let shading = |method| MovingShading::new(MovingOptions::default().order(ORDER).method(method));
    let shadings = [shading(MovingMethod::Fields)?, shading(MovingMethod::Exponentials)?];
    while let Ok(mut next) = asked.recv() {
        // Only the last counts.
        while let Ok(later) = asked.try_recv() {
            next = later;
        }
        if next.fit != fit && next.method == MovingMethod::Exponentials {
            fit = next.fit;
            scenes[1] = common.clone();
        }
        let scene = &mut scenes[number_of(next.method)];
        if !prepare(control, scene, next.method, &bake_options(fit, still_hides), IS_ANY)? {
            break;
        }
        let by_hand = next.hands.as_ref().map(|hands| placed(&*scene, hands)).transpose()?;
        let moment = by_hand.as_ref().unwrap_or(&*scene).at(next.time)?;
        control.send(News::Lit(Box::new(lit(&moment, &shadings, next)?)));
    }
    Ok(())
}

fn bake_options(fit: Fit, still_hides: bool) -> MovingBakeOptions {
    let transfer = BakeOptions::default().mode(BakeMode::Shadowed).order(ORDER).samples(SAMPLES);
    let field = FieldOptions::default().order(ORDER).rays(FIELD_RAYS);
    let spheres = SphereFitOptions::default().method(fit.method).count(fit.count).samples(FIT_SAMPLES);
    let options = MovingBakeOptions::default().transfer(transfer).field(field).spheres(spheres);
    options.deformed_spheres(Some(DEFORMED * fit.count)).still_hides(still_hides)
}

/// Which bakes are done now.
type Wanted = fn(PartBakeKind) -> bool;

/// Those that fields and spheres share, so that other spheres do not bake them again.
const IS_COMMON: Wanted = |kind| matches!(kind, PartBakeKind::Transfer | PartBakeKind::Visibility);
const IS_ANY: Wanted = |_| true;

/// Bakes what a scene lacks for a way; whether to go on.
fn prepare(
    control: &Control<News>,
    scene: &mut MovingScene,
    method: MovingMethod,
    options: &MovingBakeOptions,
    is_wanted: Wanted,
) -> Result<bool, RenderError> {
    for bake in scene.lacking(method, options).into_iter().filter(|bake| is_wanted(bake.kind)) {
        control.stage(bake.to_string());
        let mut watch = control.watch();
        match scene.bake_part(&bake, options, Job::default().watched_by(&mut watch)) {
            Err(RenderError::Cancelled) => return Ok(false),
            other => other?,
        }
    }
    control.rest();
    Ok(!control.is_cancelled())
}

/// The place of a way among scenes and shadings.
fn number_of(method: MovingMethod) -> usize {
    usize::from(method == MovingMethod::Exponentials)
}

fn lit(moment: &Moment<'_>, shadings: &[MovingShading; 2], asked: Asked) -> Result<Lit, RenderError> {
    let begin = Instant::now();
    let shading = &shadings[number_of(asked.method)];
    let radiance = shading.exit_radiance(moment, &asked.light)?;
    let milliseconds = 1e3 * begin.elapsed().as_secs_f64();
    let spheres = (0..moment.parts().len()).flat_map(|part| moment.spheres(part).iter().copied()).collect();
    Ok(Lit { scene: moment.scene().clone(), radiance, spheres, milliseconds, asked })
}

/// The same parts where a user has put them.
fn placed(scene: &MovingScene, hands: &[Hand]) -> Result<MovingScene, RenderError> {
    let part = |(part, hand): (&MovingPart, &Hand)| {
        let mut part = part.clone();
        if !matches!(part.motion, Motion::Still) {
            let turn = Rotation::from_axis_angle(Dir::Z, hand.turn);
            part.motion = Motion::Track(Track::resting(Placement::new(hand.position, turn, hand.scale)));
        }
        part
    };
    MovingScene::new(scene.parts().iter().zip(hands).map(part).collect())
}

fn cast(scene: &MovingScene) -> Result<Cast, RenderError> {
    let span = scene.span();
    let moment = scene.at(span[0])?;
    let (mut hands, mut radii, mut first) = (Vec::new(), Vec::new(), 0);
    let world: Vec<[f64; 3]> = positions(moment.scene());
    for part in scene.parts() {
        let own = positions(&part.scene);
        let there = &world[first..first + own.len()];
        first += own.len();
        let (middle, own_middle) = (mean(there), mean(&own));
        let radius = there.iter().map(|p| distance(*p, middle)).fold(0.0, f64::max);
        radii.push(radius);
        // At the first time parts are not turned.
        hands.push(Hand { position: std::array::from_fn(|k| middle[k] - own_middle[k]), turn: 0.0, scale: 1.0 });
    }
    Ok(Cast {
        names: scene.parts().iter().map(|part| part.name.clone()).collect(),
        is_still: scene.parts().iter().map(|part| matches!(part.motion, Motion::Still)).collect(),
        is_rigid: scene.parts().iter().all(MovingPart::is_rigid),
        hands,
        radii,
        span,
    })
}

/// All vertices of a scene in the world.
fn positions(scene: &Scene) -> Vec<[f64; 3]> {
    let origin = scene.origin();
    let world = |p: &[f32; 3]| std::array::from_fn(|k| f64::from(p[k]) + origin[k]);
    scene.meshes().iter().flat_map(Mesh::positions).map(world).collect()
}

fn mean(points: &[[f64; 3]]) -> [f64; 3] {
    std::array::from_fn(|k| points.iter().map(|p| p[k]).sum::<f64>() / points.len().max(1) as f64)
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

/// What is shown, for a picture that keeps it.
pub(crate) type Shown = Arc<Lit>;
