//! Transfer of `lobe render`: the scene with the transfer that a mode needs, read from a file or baked on the way.

use std::path::PathBuf;

use anyhow::bail;
use lobe::io::{Job, Progress};
use lobe::prt::{AdaptiveOptions, AlbedoMode, BakeMode, BakeOptions, BakeWork, BakedOrScene, GlossyLobe, Transfer};
use lobe::render::{BakedScene, Camera, RenderError, ViewOptions, transfer_bytes};
use lobe::scene::Scene;

use crate::args::memory::MemoryLimit;
use crate::args::open_scene::OpenScene;
use crate::args::vertex_budget::VertexBudget;
use crate::run::bake_watch::watched;
use crate::run::ctrl_c;
use crate::run::talk::Talk;

/// Advice where a bake takes long.
const BAKE_FIRST: &str = "lobe bake can be stopped and continued, and what it writes can be rendered";

/// The transfer that the options ask for.
pub(crate) struct Asked {
    pub(crate) mode: BakeMode,
    pub(crate) order: Option<usize>,
    pub(crate) samples: Option<usize>,
    pub(crate) bounces: Option<usize>,
    /// The lobe of glossy surfaces; without one they are matte.
    pub(crate) lobe: Option<GlossyLobe>,
    /// The vertices that splitting may make.
    pub(crate) budget: VertexBudget,
    /// The file of transfer that was baked before.
    pub(crate) file: Option<PathBuf>,
}

impl Asked {
    /// Reads a scene that was baked, or a file of transfer beside a scene, or reads and bakes a scene; then bakes the
    /// backs of double-sided surfaces as far as `view` shows them.
    pub(crate) fn prepare(
        &self,
        open: OpenScene<'_>,
        view: impl FnOnce(&Scene) -> anyhow::Result<(Camera, ViewOptions)>,
    ) -> anyhow::Result<(BakedScene, Camera)> {
        if let Some(order) = self.order.filter(|&order| order > Transfer::MAX_ORDER) {
            bail!("--order: transfer has an order of 1 to {}, found {order}", Transfer::MAX_ORDER);
        }
        let (memory, talk, input) = (open.memory, open.talk, open.input.name());
        let (mut baked, file) = self.read_or_bake(open)?;
        if baked.scene().has_normal_maps() && !baked.is_lightmap() && !baked.is_glossy() {
            let text = "has normal maps, which transfer at vertices does not hold; that of lobe bake --texels does, and lobe \
                        render trace, irradiance and maps show them";
            talk.note(&input, text);
        }
        let (camera, view) = view(baked.scene())?;
        bake_backs(&mut baked, file.as_deref(), (&camera, &view), memory, talk)?;
        Ok((baked, camera))
    }

    /// The scene with the transfer of its fronts, and the file that this was read from.
    fn read_or_bake(&self, open: OpenScene<'_>) -> anyhow::Result<(BakedScene, Option<String>)> {
        let (memory, talk, input) = (open.memory, open.talk, open.input.name());
        if let Some(file) = &self.file {
            memory.check_file(file, "a bake of fewer receivers or a lower order")?;
            let baked = BakedScene::read_transfer(open.scene()?, file, self.lobe)?;
            let name = file.display().to_string();
            return Ok((self.checked(baked, &name)?, Some(name)));
        }
        // A baked scene holds no matrices.
        let scene = if self.lobe.is_some() { open.scene()?.into() } else { open.baked_or_scene()? };
        match scene {
            BakedOrScene::Baked(baked) => {
                let baked = self.checked(BakedScene::from(*baked), &input)?;
                Ok((baked, Some(input)))
            }
            BakedOrScene::Scene(scene, _) => Ok((self.bake(scene, memory, talk)?, None)),
        }
    }

    /// Refuses options that cannot be had of transfer that was baked before.
    fn checked(&self, baked: BakedScene, name: &str) -> anyhow::Result<BakedScene> {
        let recipe = baked.recipe();
        for (option, asked, found) in [
            ("--bake-samples", self.samples, recipe.samples.map(|samples| samples as usize)),
            ("--bounces", self.bounces, recipe.bounces),
        ] {
            if let Some(asked) = asked.filter(|asked| found != Some(*asked)) {
                let baked = found.map_or("already".to_owned(), |found| format!("with {found}"));
                bail!(
                    "{option} {asked}: {name} is baked {baked}; leave the option out, or render the scene it was baked from"
                );
            }
        }
        let wanted = self.mode.name();
        // A recipe that does not say is believed.
        let found = baked.recipe().mode_name().unwrap_or(wanted);
        if found != wanted {
            bail!("--mode {wanted}: {name} was baked as {found}; ask for that, or render the scene it was baked from");
        }
        if let Some(asked) = self.order.filter(|&asked| asked > baked.order()) {
            bail!("--order {asked}: {name} was baked to order {}; bake it to a higher one", baked.order());
        }
        let options = baked.options().clone().mode(self.mode);
        Ok(baked.with_options(options))
    }

    fn bake(&self, scene: Scene, memory: &MemoryLimit, talk: Talk) -> anyhow::Result<BakedScene> {
        let defaults = BakeOptions::default();
        let (order, bounces) = (self.order.unwrap_or(defaults.order), self.bounces.unwrap_or(defaults.bounces));
        let mut options = defaults.mode(self.mode).order(order).bounces(bounces);
        options.samples = self.samples.map(|n| n as u32);
        // Matrices never have the albedo.
        let options = if self.lobe.is_none() { options.albedo(AlbedoMode::of_scene(&scene)) } else { options };
        check_memory(memory, &scene, scene.vertex_count(), &options, self.lobe.is_some())?;
        // Matrices take too much memory for vertices that nobody asked for.
        let is_split = !self.budget.no_split && (self.lobe.is_none() || self.budget.max_vertices.is_some());
        let splitting = self.budget.options(&scene)?.bake(options.clone());
        let scene = if is_split { split(scene, &splitting, talk)? } else { scene };
        check_memory(memory, &scene, scene.vertex_count(), &options, self.lobe.is_some())?;
        watched_bake(talk, |job| BakedScene::bake(scene, &options, self.lobe, job))
    }
}

/// The scene with further vertices where its transfer is off.
fn split(scene: Scene, options: &AdaptiveOptions, talk: Talk) -> anyhow::Result<Scene> {
    let work = BakeWork::at_vertices(scene, options.bake.clone())?;
    let split = watched(talk, "split", |job| work.split(options, job))?;
    let split = split.or_else(|_| bail!("stopped while triangles were split, of which nothing is kept; {BAKE_FIRST}"));
    Ok(split?.0)
}

/// Bakes the backs that a view shows: files hold fronts only.
fn bake_backs(
    baked: &mut BakedScene,
    file: Option<&str>,
    (camera, view): (&Camera, &ViewOptions),
    memory: &MemoryLimit,
    talk: Talk,
) -> anyhow::Result<()> {
    ctrl_c::watch();
    let line = talk.progress("look");
    let mut watch = |progress: &Progress| {
        line.show(progress.done, progress.total, None, None);
        ctrl_c::go_on()
    };
    let looked = baked.backs_in_view(camera, view, Job::default().watched_by(&mut watch));
    drop(line);
    let seen = match looked {
        Err(RenderError::Cancelled) => bail!("stopped before the first picture; nothing is kept"),
        other => other?,
    };
    if seen.is_empty() {
        return Ok(());
    }
    check_memory(memory, baked.scene(), seen.len(), baked.options(), baked.is_glossy())?;
    if let Some(file) = file {
        let count = seen.len();
        let paths = baked.options().samples.map_or_else(String::new, |samples| format!(" from {samples} paths each"));
        let places = if baked.is_lightmap() { "texels" } else { "vertices" };
        let text =
            format!("holds fronts of surfaces; the backs of {count} {places}, which are seen, are baked now{paths}");
        talk.note(file, &text);
    }
    watched_bake(talk, |job| baked.bake_backs(&seen, job))
}

fn watched_bake<T>(talk: Talk, bake: impl FnOnce(Job<'_>) -> Result<T, RenderError>) -> anyhow::Result<T> {
    let baked = watched(talk, "bake", bake)?;
    baked.or_else(|_| bail!("stopped while transfer was baked, of which nothing is kept; {BAKE_FIRST}"))
}

/// Refuses a bake that takes too much memory.
fn check_memory(
    memory: &MemoryLimit,
    scene: &Scene,
    count: usize,
    options: &BakeOptions,
    is_glossy: bool,
) -> anyhow::Result<()> {
    let what = format!("transfer of {count} vertices at order {}", options.order);
    memory.check(&what, transfer_bytes(scene, count, options, is_glossy), "a lower --order")
}
