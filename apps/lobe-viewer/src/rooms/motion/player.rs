//! Moments of a moving scene, lit beside the window.

use std::cell::RefCell;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};

use lobe::env::Sun;
use lobe::io::{Job, Progress};
use lobe::motion::{MovingBakeOptions, MovingMethod, MovingOptions, MovingScene, MovingShading, PartBakeKind};
use lobe::render::{Emitter, RenderError};
use lobe::sh::{Expansion as _, Rgb, ShVec};
use lobe::shadow::{Placement, SphereFitMethod, WorldSphere};
use lobe_gpu::Context;
use serde::{Deserialize, Serialize};
use web_time::Instant;

use crate::loading::bake::SceneData;
use crate::loading::limits::ReadLimits;
use crate::loading::moving_bakes::leaves_suns;
use crate::loading::moving_bakes::moving_bake_options;
use crate::loading::moving_light::{LitOn, MovingLight};
use crate::loading::moving_source::{is_file, open_moving, split_for_shadows, with_files};
use crate::loading::task::{Control, Task, TaskEvent};
use crate::rooms::motion::cast::{Cast, Hand, cast, placed};

/// The most bands of light, transfer, fields and spheres.
pub(crate) const MOST_ORDER: usize = 8;

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

/// What is to be shown.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Asked {
    pub(crate) time: f64,
    /// How parts hide the sky: one way or several, of the same moment.
    pub(crate) methods: Vec<MovingMethod>,
    /// Of the order to which the parts are to be baked.
    pub(crate) light: ShVec<Rgb<f64>>,
    /// What is not in it: suns that cast shadows by themselves.
    pub(crate) suns: Vec<Sun>,
    /// Of exponentials.
    pub(crate) fit: Fit,
    /// Where its light is computed.
    pub(crate) lit_on: LitOn,
    /// Where each part is; none while the animation plays.
    pub(crate) hands: Option<Vec<Hand>>,
}

impl Asked {
    /// Whether other bakes are needed for it, those of another order or other spheres.
    pub(crate) fn needs_other_bakes(&self, other: &Self) -> bool {
        self.light.order() != other.light.order() || self.fit != other.fit || self.methods != other.methods
    }
}

/// What comes from the player.
pub(crate) enum News {
    /// The parts are baked.
    Ready(Cast),
    /// A moment was lit.
    Lit(Box<Lit>),
}

/// A moment and its light.
pub(crate) struct Lit {
    pub(crate) asked: Asked,
    /// Its triangles in the world.
    pub(crate) data: SceneData,
    /// Its lamps, to be traced.
    pub(crate) emitters: Vec<Emitter>,
    /// One for each way that is baked already.
    pub(crate) ways: Vec<Way>,
}

/// A moment by one way.
pub(crate) struct Way {
    pub(crate) method: MovingMethod,
    pub(crate) radiance: Vec<Rgb<f32>>,
    pub(crate) spheres: Vec<WorldSphere>,
    /// Milliseconds that the light took, and where.
    pub(crate) milliseconds: f64,
    pub(crate) place: String,
}

impl Lit {
    /// How it was lit, in one line.
    pub(crate) fn describe(&self) -> String {
        let by = |way: &Way| match way.method {
            MovingMethod::Exponentials => {
                format!("exponentials of {} spheres in {:.0} ms {}", way.spheres.len(), way.milliseconds, way.place)
            }
            _ => format!("products of shadow fields in {:.0} ms {}", way.milliseconds, way.place),
        };
        let (vertices, order) = (self.data.scene.vertex_count(), self.asked.light.order());
        let whole = format!("{vertices} vertices, order {order}");
        [whole].into_iter().chain(self.ways.iter().map(by)).collect::<Vec<_>>().join(", ")
    }

    /// What was asked for, by the ways that are baked.
    pub(crate) fn asked_as_lit(&self) -> Asked {
        Asked { methods: self.ways.iter().map(|way| way.method).collect(), ..self.asked.clone() }
    }

    /// The moment by a way; none if that is not baked yet.
    pub(crate) fn way(&self, method: MovingMethod) -> Option<&Way> {
        self.ways.iter().find(|way| way.method == method)
    }
}

/// A scene that moves, and where it comes from.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Source {
    pub(crate) path: PathBuf,
    /// Fields and spheres for its parts.
    pub(crate) files: Vec<PathBuf>,
    pub(crate) limits: ReadLimits,
}

/// Bakes parts, then lights the moment that was asked for last.
pub(crate) struct Player {
    task: Task<News>,
    asks: Sender<Asked>,
}

impl Player {
    /// Opens a scene and bakes its parts, to an order as far as they came without. Moments can be lit on a device.
    pub(crate) fn start(
        source: &Source,
        order: usize,
        device: Option<Context>,
        wake: impl Fn() + Send + 'static,
    ) -> Self {
        let (asks, asked) = channel();
        let source = source.clone();
        let work =
            move |control: &_| play(control, &source, order, device.as_ref(), asked).map_err(|error| error.to_string());
        let task = Task::start("Parts", wake, work);
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

fn play(
    control: &Control<News>,
    source: &Source,
    order: usize,
    device: Option<&Context>,
    asked: Receiver<Asked>,
) -> anyhow::Result<()> {
    let Source { path: source, files, limits } = source;
    control.stage(source.file_name().unwrap_or_default().to_string_lossy());
    let mut opened = with_files(open_moving(source, limits)?, files)?;
    control.stage("triangles");
    let mut watch = control.watch();
    match split_for_shadows(&mut opened, source, Job::default().watched_by(&mut watch)) {
        Err(RenderError::Cancelled) => return Ok(()),
        other => other?,
    }
    let most_order = opened.order().unwrap_or(MOST_ORDER).min(MOST_ORDER);
    opened.bake_lamps(most_order)?;
    // The built-in scenes stand on open ground, which hides nothing from what moves over it.
    let inbox = Inbox { asked, next: RefCell::default() };
    let mut desk = Desk { control, inbox, still_hides: is_file(source), rest: Vec::new() };
    let mut bakes = Bakes::begin(&opened, order.min(most_order), Fit::default(), device)?;
    if bakes.prepare(MovingMethod::Fields, &desk)? != Prepared::Ready {
        return Ok(());
    }
    let cast = Cast { parts_suns: leaves_suns(&opened), ..cast(&bakes.scenes[0], most_order)? };
    desk.rest.clone_from(&cast.rest);
    control.send(News::Ready(cast));
    // Those of the order before, for a user who goes back to it.
    let mut before: Option<Bakes> = None;
    while let Some(next) = desk.inbox.take() {
        let order = next.light.order();
        if order != bakes.order {
            let known = before.take().filter(|before| before.order == order);
            let others = known.map_or_else(|| Bakes::begin(&opened, order, next.fit, device), Ok)?;
            before = Some(std::mem::replace(&mut bakes, others));
        }
        if next.fit != bakes.fit && next.methods.contains(&MovingMethod::Exponentials) {
            bakes.refit(next.fit);
        }
        // What is baked already is shown while the rest is being baked.
        let ready: Vec<_> = next.methods.iter().copied().filter(|way| bakes.is_ready(*way, &desk)).collect();
        if !ready.is_empty() && ready.len() < next.methods.len() {
            control.send(News::Lit(Box::new(bakes.lit(&ready, &next, &desk.rest)?)));
        }
        let prepared = next.methods.iter().map(|method| bakes.prepare(*method, &desk)).find(|prepared| {
            // Stops at the first that is none.
            !matches!(prepared, Ok(Prepared::Ready))
        });
        match prepared.transpose()? {
            None => control.send(News::Lit(Box::new(bakes.lit(&next.methods, &next, &desk.rest)?))),
            Some(Prepared::Cancelled) => break,
            Some(_) => {}
        }
    }
    Ok(())
}

/// What work needs to know while it is done.
struct Desk<'a> {
    control: &'a Control<News>,
    inbox: Inbox,
    still_hides: bool,
    /// The places of the parts at first, to which those of hands are added.
    rest: Vec<Placement>,
}

/// What was asked for and not begun, of which only the last counts.
struct Inbox {
    asked: Receiver<Asked>,
    next: RefCell<Option<Asked>>,
}

impl Inbox {
    fn look(&self) {
        if let Some(last) = self.asked.try_iter().last() {
            self.next.replace(Some(last));
        }
    }

    /// The last, once there is one; none when nobody asks any more.
    fn take(&self) -> Option<Asked> {
        self.look();
        let next = self.next.take().or_else(|| self.asked.recv().ok())?;
        self.look();
        Some(self.next.take().unwrap_or(next))
    }

    /// Whether what is asked for needs other bakes than those for a way that are under way.
    fn is_past(&self, method: MovingMethod, order: usize, fit: Fit) -> bool {
        self.look();
        self.next.borrow().as_ref().is_some_and(|next| {
            let is_other_fit = method == MovingMethod::Exponentials && next.fit != fit;
            next.light.order() != order || is_other_fit || !next.methods.contains(&method)
        })
    }
}

/// How a preparation ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Prepared {
    Ready,
    /// Something else was asked for meanwhile.
    Outdated,
    Cancelled,
}

/// All that is baked to an order. What has fields needs no spheres, and the other way round: each way has a scene of its own.
struct Bakes {
    order: usize,
    fit: Fit,
    /// With what both ways share.
    common: MovingScene,
    scenes: [MovingScene; 2],
    lights: [MovingLight; 2],
}

impl Bakes {
    fn begin(opened: &MovingScene, order: usize, fit: Fit, device: Option<&Context>) -> Result<Self, RenderError> {
        let light = |method| -> Result<_, RenderError> {
            let shading = MovingShading::new(MovingOptions::default().order(order).method(method))?;
            Ok(MovingLight::new(shading, device, LitOn::default()))
        };
        let lights = [light(MovingMethod::Fields)?, light(MovingMethod::Exponentials)?];
        let [common, fields, exponentials] = [(); 3].map(|()| opened.clone());
        Ok(Self { order, fit, common, scenes: [fields, exponentials], lights })
    }

    /// Forgets the spheres, for others.
    fn refit(&mut self, fit: Fit) {
        self.fit = fit;
        self.scenes[1] = self.common.clone();
        self.lights[1].forget();
    }

    fn options(&self, still_hides: bool) -> MovingBakeOptions {
        moving_bake_options(self.order, self.fit.method, self.fit.count, still_hides)
    }

    fn is_ready(&self, method: MovingMethod, desk: &Desk<'_>) -> bool {
        self.scenes[number_of(method)].lacking(method, &self.options(desk.still_hides)).is_empty()
    }

    /// Bakes what is lacking for a way.
    fn prepare(&mut self, method: MovingMethod, desk: &Desk<'_>) -> Result<Prepared, RenderError> {
        let is_common = |kind| matches!(kind, PartBakeKind::Transfer | PartBakeKind::Visibility);
        let (options, of) = (self.options(desk.still_hides), (self.order, self.fit));
        let number = number_of(method);
        if !self.is_ready(method, desk) {
            let common = bake_lacking(&mut self.common, (method, &options, of), is_common, desk)?;
            if common != Prepared::Ready {
                return Ok(common);
            }
            self.scenes[number] = self.common.clone();
        }
        bake_lacking(&mut self.scenes[number], (method, &options, of), |_| true, desk)
    }

    /// A moment by ways that are prepared.
    fn lit(&mut self, methods: &[MovingMethod], asked: &Asked, rest: &[Placement]) -> anyhow::Result<Lit> {
        let by_hand = |scene: &MovingScene| asked.hands.as_ref().map(|hands| placed(scene, rest, hands)).transpose();
        let (mut seen, mut ways) = (None, Vec::new());
        for &method in methods {
            let scene = &self.scenes[number_of(method)];
            let by_hand = by_hand(scene)?;
            let moment = by_hand.as_ref().unwrap_or(scene).at(asked.time)?;
            let begin = Instant::now();
            let light = &mut self.lights[number_of(method)];
            light.move_to(asked.lit_on);
            let radiance = light.exit_radiance(&moment, &asked.light)?;
            let milliseconds = 1e3 * begin.elapsed().as_secs_f64();
            let place = light.place();
            let spheres = (0..moment.parts().len()).flat_map(|part| moment.spheres(part).iter().copied()).collect();
            ways.push(Way { method, radiance, spheres, milliseconds, place });
            seen.get_or_insert_with(|| (SceneData::of_moment(moment.scene(), moment.bvh()), moment.emitters()));
        }
        let (data, emitters) = match seen {
            Some(seen) => seen,
            None => {
                let by_hand = by_hand(&self.common)?;
                let moment = by_hand.as_ref().unwrap_or(&self.common).at(asked.time)?;
                (SceneData::of_moment(moment.scene(), moment.bvh()), moment.emitters())
            }
        };
        Ok(Lit { asked: asked.clone(), data, emitters, ways })
    }
}

/// Does the bakes that a scene lacks for a way.
fn bake_lacking(
    scene: &mut MovingScene,
    (method, options, (order, fit)): (MovingMethod, &MovingBakeOptions, (usize, Fit)),
    is_wanted: impl Fn(PartBakeKind) -> bool,
    desk: &Desk<'_>,
) -> Result<Prepared, RenderError> {
    let Desk { control, inbox, .. } = desk;
    for bake in scene.lacking(method, options).into_iter().filter(|bake| is_wanted(bake.kind)) {
        control.stage(format!("{bake}, order {order}"));
        let mut tell = control.watch();
        let mut watch = |progress: &Progress| match inbox.is_past(method, order, fit) {
            true => ControlFlow::Break(()),
            false => tell(progress),
        };
        match scene.bake_part(&bake, options, Job::default().watched_by(&mut watch)) {
            Err(RenderError::Cancelled) if !control.is_cancelled() => return Ok(Prepared::Outdated),
            Err(RenderError::Cancelled) => return Ok(Prepared::Cancelled),
            other => other?,
        }
    }
    control.rest();
    Ok(if control.is_cancelled() { Prepared::Cancelled } else { Prepared::Ready })
}

/// The place of a way among scenes and shadings.
fn number_of(method: MovingMethod) -> usize {
    usize::from(method == MovingMethod::Exponentials)
}

/// What is shown, for a picture that keeps it.
pub(crate) type Shown = Arc<Lit>;
