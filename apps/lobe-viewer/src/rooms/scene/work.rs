//! Opening and baking beside the window: the scene, the sky, transfer from files, and what went wrong with them.

use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::Arc;

use eframe::egui::Context;
use lobe::env::{MappedMap, SunChoice};
use lobe::prt::Recipe;
use lobe_gpu::SplitSum;

use crate::loading::adopt;
use crate::loading::bake::{self, MOST_UNASKED, SceneData, SceneNews};
use crate::loading::cache::UserFolder;
use crate::loading::limits::ReadLimits;
use crate::loading::materials::prefilter;
use crate::loading::place::IN_PAGE;
use crate::loading::places::Places;
use crate::loading::scene_source::{self, is_built_in};
use crate::loading::sky_source::{self, OpenedSky};
use crate::loading::suns::open_direct;
use crate::loading::task::{Task, TaskEvent};
use crate::rooms::scene::controls::BakePlan;
use crate::rooms::scene::edits::SceneEdits;
use crate::rooms::scene::opened::{Opened, failure, take_back};
use lobe::render::Surfaces;

/// What a page says in place of a bake.
const NO_BAKES: &str = "A page with one thread does not bake: drop a .glb that lobe bake wrote, for its shadows.";

/// Frames of the window with a scene before it is baked, for which all processors are taken: for the first, a device compiles what draws it.
const FRAMES_BEFORE_BAKE: usize = 2;

/// Files that are open or being opened, and the tasks that do it.
pub(crate) struct Work {
    pub(crate) limits: ReadLimits,
    /// The suns that are looked for in skies.
    pub(crate) suns: SunChoice,
    /// The most texels along each side of a sky on the device.
    pub(crate) most_side: usize,
    /// What went wrong last, in one line.
    pub(crate) message: Option<String>,
    folder: UserFolder,
    scene: Opened<SceneData>,
    sky: Opened<OpenedSky>,
    scene_task: Option<Task<SceneNews>>,
    /// Frames that are still to be drawn before the task of the scene may bake.
    frames_to_draw: usize,
    sky_task: Option<Task<OpenedSky>>,
    reflections: Reflections,
    /// Whether the scene was opened with the textures that materials need.
    surfaces: Surfaces,
    /// Files of transfer, for the scene when that is open, one after the other.
    adopting: VecDeque<PathBuf>,
    is_fallback: bool,
}

/// What shiny surfaces reflect of a sky, with or without its suns.
#[derive(Default)]
struct Reflections {
    of: Option<(Arc<MappedMap>, bool)>,
    task: Option<Task<Arc<SplitSum>>>,
    found: Option<Arc<SplitSum>>,
}

/// What came from a task.
pub(crate) enum News {
    Scene(SceneNews),
    Sky,
}

impl Work {
    /// Nothing is open. `folder` keeps the bakes of built-in scenes.
    pub(crate) fn new(folder: UserFolder) -> Self {
        Self {
            limits: ReadLimits::default(),
            suns: SunChoice::Auto,
            most_side: usize::MAX,
            message: None,
            folder,
            scene: Opened::default(),
            sky: Opened::default(),
            scene_task: None,
            frames_to_draw: 0,
            sky_task: None,
            reflections: Reflections::default(),
            surfaces: Surfaces::Matte,
            adopting: VecDeque::new(),
            is_fallback: false,
        }
    }

    /// The scene that is open.
    pub(crate) fn scene(&self) -> Option<&SceneData> {
        self.scene.found.as_ref()
    }

    /// The environment that is open.
    pub(crate) fn sky(&self) -> Option<&OpenedSky> {
        self.sky.found.as_ref()
    }

    /// Whether nothing is being opened or baked.
    pub(crate) fn is_idle(&self) -> bool {
        let is_open = self.scene_task.is_none() && self.sky_task.is_none();
        is_open && self.reflections.task.is_none() && self.adopting.is_empty()
    }

    /// The task of the scene.
    pub(crate) fn scene_task(&self) -> Option<&Task<SceneNews>> {
        self.scene_task.as_ref()
    }

    /// The task of the sky.
    pub(crate) fn sky_task(&self) -> Option<&Task<OpenedSky>> {
        self.sky_task.as_ref()
    }

    /// Takes transfer from a file for the scene when that is open.
    pub(crate) fn adopt(&mut self, path: PathBuf) {
        if self.adopting.is_empty() {
            self.forget_message();
        }
        self.adopting.push_back(path);
    }

    /// Opens the scene of the edits at the next start, also if it is open.
    pub(crate) fn read_scene_anew(&mut self) {
        self.scene.source.clear();
    }

    /// The same for the sky.
    pub(crate) fn read_sky_anew(&mut self) {
        self.sky.source.clear();
    }

    /// Starts what the edits ask for.
    pub(crate) fn start(&mut self, ctx: &Context, edits: &SceneEdits, plan: BakePlan) {
        // With its textures, a scene of a file serves both models.
        let lacks_textures = edits.surfaces == Surfaces::MetallicRoughness && self.surfaces == Surfaces::Matte;
        if self.scene.source != edits.scene || lacks_textures && !is_built_in(&edits.scene) {
            self.scene.source.clone_from(&edits.scene);
            self.surfaces = edits.surfaces;
            let (source, amount) = (edits.scene.clone(), (plan.order, plan.samples));
            let (folder, limits, surfaces) = (self.folder.clone(), self.limits, edits.surfaces);
            let work = move |control: &_| bake::open(control, (&source, surfaces), amount, (&folder, &limits));
            self.scene_task = Some(Task::start("Scene", wake(ctx), work));
            self.frames_to_draw = 0;
            self.forget_message();
        }
        if self.sky.source != edits.sky {
            self.sky.source.clone_from(&edits.sky);
            let (source, limits, most) = (edits.sky.clone(), self.limits, self.most_side);
            let suns = self.suns.clone();
            let work = move |control: &_| sky_source::open(control, &source, (&limits, &suns), most);
            self.sky_task = Some(Task::start("Sky", wake(ctx), work));
            self.forget_message();
        }
        if self.scene_task.is_none()
            && let Some(data) = self.scene.found.clone()
            && let Some(path) = self.adopting.pop_front()
        {
            let limits = self.limits;
            let work = move |control: &_| adopt::adopt(control, &data, &path, &limits);
            self.scene_task = Some(Task::start("Transfer", wake(ctx), work));
        }
    }

    /// What shiny surfaces reflect of the sky, which is prefiltered if it was not.
    pub(crate) fn reflections(&mut self, ctx: &Context, has_suns: bool) -> Option<Arc<SplitSum>> {
        let sky = self.sky.found.as_ref()?;
        let key = (sky.map.clone(), has_suns);
        let Reflections { of, task, found } = &mut self.reflections;
        if of.as_ref().is_none_or(|(map, suns)| !Arc::ptr_eq(map, &key.0) || *suns != has_suns) {
            (*of, *found) = (Some(key), None);
            let sky = sky.clone();
            *task = Some(Task::start("Materials", wake(ctx), move |control| prefilter(control, &sky, has_suns)));
        }
        for event in task.as_ref().map(Task::events).unwrap_or_default() {
            match event {
                TaskEvent::Result(made) => *found = Some(made),
                ended => {
                    *task = None;
                    self.message = self.message.take().or(failure(ended));
                }
            }
        }
        found.clone()
    }

    /// Lets the scene be baked after some frames of the window. Called for each frame, after its [news](Self::news).
    pub(crate) fn let_bake(&mut self, ctx: &Context) {
        if self.frames_to_draw == 0 {
            return;
        }
        self.frames_to_draw -= 1;
        if self.frames_to_draw > 0 {
            ctx.request_repaint();
        } else if let Some(task) = &self.scene_task {
            task.release();
        }
    }

    /// Bakes the scene that is open anew.
    pub(crate) fn bake(&mut self, ctx: &Context, plan: BakePlan) {
        if IN_PAGE {
            self.message = Some(NO_BAKES.into());
            return;
        }
        let Some(data) = self.scene.found.clone() else { return };
        self.scene_task = Some(Task::start("Bake", wake(ctx), move |control| {
            bake::rounds(control, &data, (plan.order, plan.samples), &UserFolder::none(), |_| ())
        }));
        self.message = None;
    }

    /// Bakes the part without reflections of transfer of a file, unless that takes long.
    pub(crate) fn bake_direct(&mut self, ctx: &Context, (recipe, order, places): (Arc<Recipe>, usize, Places)) {
        let Some(data) = self.scene.found.clone() else { return };
        let paths = u64::from(recipe.samples.unwrap_or(1));
        if IN_PAGE || self.scene_task.is_some() || data.scene.vertex_count() as u64 * paths > MOST_UNASKED {
            return;
        }
        self.scene_task = Some(Task::start("Suns", wake(ctx), move |control: &_| {
            open_direct(control, &data, (&recipe, order), &places)
        }));
    }

    /// Forgets what went wrong, unless what is opened now stands in for it.
    fn forget_message(&mut self) {
        if !std::mem::take(&mut self.is_fallback) {
            self.message = None;
        }
    }

    /// What has come since this was asked last. After a failure the edits have the file again that is open.
    pub(crate) fn news(&mut self, edits: &mut SceneEdits) -> Vec<News> {
        let mut came = Vec::new();
        for event in self.scene_task.as_ref().map(Task::events).unwrap_or_default() {
            match event {
                TaskEvent::Result(news) => {
                    self.note(&news);
                    came.push(News::Scene(news));
                }
                ended => {
                    self.scene_task = None;
                    self.is_fallback |= take_back(&ended, &mut edits.scene, &mut self.scene, scene_source::FIRST);
                    self.message = self.message.take().or(failure(ended));
                }
            }
        }
        for event in self.sky_task.as_ref().map(Task::events).unwrap_or_default() {
            match event {
                TaskEvent::Result(sky) => {
                    self.sky.found = Some(sky);
                    self.sky.good.clone_from(&self.sky.source);
                    came.push(News::Sky);
                }
                ended => {
                    self.sky_task = None;
                    self.is_fallback |= take_back(&ended, &mut edits.sky, &mut self.sky, sky_source::FIRST);
                    self.message = self.message.take().or(failure(ended));
                }
            }
        }
        came
    }

    fn note(&mut self, news: &SceneNews) {
        match news {
            SceneNews::Opened(data) => {
                self.scene.found = Some(data.clone());
                self.scene.good.clone_from(&self.scene.source);
                // And the one in which this came.
                self.frames_to_draw = FRAMES_BEFORE_BAKE + 1;
            }
            SceneNews::AskBeforeBake => {
                self.message =
                    Some(if IN_PAGE { NO_BAKES } else { "This scene is large: press Bake for its shadows." }.into());
            }
            _ => {}
        }
    }

    /// Stops what is under way. What cannot be interrupted goes on where nobody waits for it, and is forgotten: it is not shown.
    pub(crate) fn cancel(&mut self, edits: &mut SceneEdits) {
        let was_at_work = self.scene_task.is_some() || self.sky_task.is_some();
        if self.scene_task.take().is_some() {
            let ended = TaskEvent::<SceneNews>::Cancelled;
            self.is_fallback |= take_back(&ended, &mut edits.scene, &mut self.scene, scene_source::FIRST);
        }
        if self.sky_task.take().is_some() {
            let ended = TaskEvent::<OpenedSky>::Cancelled;
            self.is_fallback |= take_back(&ended, &mut edits.sky, &mut self.sky, sky_source::FIRST);
        }
        self.adopting.clear();
        if was_at_work {
            self.message = failure(TaskEvent::<()>::Cancelled);
        }
    }
}

/// What a task calls when it has something to say.
fn wake(ctx: &Context) -> impl Fn() + Send + Sync + 'static {
    let ctx = ctx.clone();
    move || ctx.request_repaint()
}
