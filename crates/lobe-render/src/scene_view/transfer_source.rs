//! The transfer of a scene for pictures: where it is, or how it is baked on the way.

use std::path::PathBuf;

use lobe_io::{Given, GivenPaths, Job, JobOptions, MemoryLimit, OptionError, OptionField, OptionKind, options};
use lobe_prt::{
    AlbedoMode, BakeMode, BakeOptions, BakeWork, BakedOrScene, GlossyLobe, OpenScene, Recipe, Transfer,
    check_file_of_numbers,
};
use lobe_scene::{Scene, SceneSource};

use crate::camera::camera::Camera;
use crate::error::RenderError;
use crate::scene_view::baked_scene::{BakedScene, transfer_bytes};
use crate::scene_view::picture_bake::PictureBake;
use crate::scene_view::scene_picture::ViewOptions;

/// The lobe of glossy light without another choice: about the sharpest that order 4 can show.
const LOBE: GlossyLobe = GlossyLobe::Ggx(0.3);

options! {
    /// The transfer of a scene: that of a file, or else baked before the picture.
    pub struct TransferSource with bake: PictureBake {
        /// The light paths
        mode: Option<BakeMode> = None, OptionKind::Name(BakeMode::NAMES), "MODE",
            "those of the baked file, else interreflected";
        /// The transfer of this scene that lobe bake, compress or fit-lobes wrote without the scene, a .safetensors
        /// file, or an .exr file of lobe bake --texels
        #[serde(serialize_with = "lobe_io::as_text_if_any")]
        transfer: Option<PathBuf> = None, OptionKind::File, "FILE", "";
        /// The lobe of reflection of `mode` glossy about the mirrored view, tinted by the base color. For metals of α
        /// 0.3 the picture differs by 18 % from path tracing by glTF's model, for rougher ones by more
        lobe: Option<GlossyLobe> = None, OptionKind::Text, "phong:E|ggx:ALPHA", "ggx:0.3";
    }
}

impl JobOptions for TransferSource {
    fn fields() -> Vec<&'static OptionField> {
        Self::FIELDS.iter().chain(PictureBake::FIELDS).collect()
    }

    fn set_paths(&mut self, given: GivenPaths<'_>) {
        self.transfer = given("transfer").and_then(|paths| paths.into_iter().next()).or(self.transfer.take());
    }

    fn check_together(&self, given: &Given<'_>) -> Result<(), OptionError> {
        let refused = |option: &str, message: &str| Err(OptionError::new(option, format!("{message}; leave it out")));
        self.bake.check_together(given)?;
        if self.bake.bounces.is_some() && self.mode.is_some_and(|mode| !mode.reflects()) {
            return refused("bounces", "only of @mode interreflected and glossy");
        }
        if self.lobe.is_some() && self.mode.is_some_and(|mode| mode != BakeMode::Glossy) {
            return refused("lobe", "only of @mode glossy");
        }
        match given.first_of(&["max_vertices", "no_split"]) {
            Some(option) if self.transfer.is_some() => refused(option, "not with @transfer, whose vertices are there"),
            _ => Ok(()),
        }
    }
}

impl TransferSource {
    /// The light paths: those that are asked for, or that the file of this scene or of its transfer says; glossy with a
    /// lobe, else interreflected. A file is asked within the limit of memory.
    #[must_use]
    pub fn mode_of(&self, source: &SceneSource, memory: MemoryLimit) -> BakeMode {
        let in_file = || {
            let file = self.transfer.as_deref().or(source.is_gltf().then_some(&*source.scene))?;
            let may_be_read = file.is_file() && check_file_of_numbers(memory, file, "").is_ok();
            may_be_read.then(|| Recipe::of_file(file).ok())??.mode
        };
        let by_lobe = self.lobe.map(|_| BakeMode::Glossy);
        self.mode.or(by_lobe).or_else(in_file).unwrap_or(BakeMode::Interreflected)
    }

    /// Reads a scene that was baked, or a file of transfer beside a scene, or reads and bakes a scene, to `order` bands or
    /// else 4. The job that is watched has the steps `split` and `bake`, and hears what a user should know.
    ///
    /// # Errors
    /// [`RenderError::OfJob`] for what cannot be had of transfer that was baked before, and what takes more memory than
    /// allowed; [`RenderError::Cancelled`] if the watch said to stop; else those of reading and baking.
    pub fn prepare(
        &self,
        open: OpenScene,
        order: Option<usize>,
        memory: MemoryLimit,
        mut work: Job<'_>,
    ) -> Result<SceneTransfer, RenderError> {
        if let Some(order) = order.filter(|&order| order > Transfer::MAX_ORDER) {
            let message = format!("transfer has an order of 1 to {}, found {order}", Transfer::MAX_ORDER);
            return Err(OptionError::new("order", message).into());
        }
        let has_finish = open.source().finish;
        let asked = Asked { source: self, mode: self.mode_of(open.source(), memory), order, has_finish, memory };
        let name = open.source().name();
        let found = asked.read_or_bake(open, &mut work)?;
        let SceneTransfer { baked, .. } = &found;
        if baked.scene().has_normal_maps() && !baked.is_lightmap() && !baked.is_glossy() {
            let text = "has normal maps, which transfer at vertices does not hold; a bake to @texels does, and path tracing, \
                        environment mapping and irradiance show them";
            work.note(&name, text);
        }
        Ok(found)
    }
}

/// A scene with its transfer, and where that was found.
pub struct SceneTransfer {
    /// The scene.
    pub baked: BakedScene,
    /// The file of the transfer; none if it was baked on the way.
    pub file: Option<String>,
    /// Whether the file holds the scene, too.
    is_scene: bool,
    memory: MemoryLimit,
}

impl SceneTransfer {
    /// Bakes what a picture needs and files mostly leave out: the backs of double-sided surfaces that a view shows,
    /// and the direct part of the transfer if that is wanted, for suns and for surfaces that are not matte. The job
    /// that is watched has the steps `look`, `bake` and `bake direct`.
    ///
    /// # Errors
    /// Those of [`BakedScene::backs_in_view`], [`BakedScene::bake_backs`] and [`BakedScene::bake_direct`];
    /// [`RenderError::OfJob`] for what takes more memory than allowed.
    pub fn completed(
        mut self,
        (camera, view): (&Camera, &ViewOptions),
        (has_suns, reflects): (bool, bool),
        mut work: Job<'_>,
    ) -> Result<BakedScene, RenderError> {
        self.bake_backs((camera, view), work.reborrow())?;
        if reflects && !self.baked.tells_openness() {
            let text = "holds transfer in a form that does not say what hides reflections, and none is hidden; a bake \
                        that is neither compressed nor in 16 bits says it";
            work.note(self.file.as_deref().unwrap_or_default(), text);
        }
        if (has_suns || reflects) && self.baked.needs_direct() {
            let (baked, [fronts, backs]) = (&self.baked, self.baked.lacking_direct());
            check_memory(self.memory, baked.scene(), fronts + backs, baked.options(), false)?;
            if let Some(file) = &self.file {
                let places = if baked.is_lightmap() { "texels" } else { "vertices" };
                let (what, advice) = match fronts {
                    0 => (format!("the backs of {backs} {places}"), ""),
                    _ if baked.is_lightmap() || !self.is_scene => (format!("{fronts} {places}"), ""),
                    _ => (format!("{fronts} {places}"), "; a bake with @parts direct,reflected keeps it"),
                };
                let text = format!(
                    "holds no direct part of the transfer of {what}, which suns and reflections need; it is \
                     baked now{advice}"
                );
                work.note(file, &text);
            }
            self.baked.bake_direct(work.step("bake direct"))?;
        }
        Ok(self.baked)
    }

    fn bake_backs(&mut self, (camera, view): (&Camera, &ViewOptions), mut work: Job<'_>) -> Result<(), RenderError> {
        let Self { baked, file, memory, .. } = self;
        let seen = baked.backs_in_view(camera, view, work.step("look"))?;
        if seen.is_empty() {
            return Ok(());
        }
        check_memory(*memory, baked.scene(), seen.len(), baked.options(), baked.is_glossy())?;
        if let Some(file) = file {
            let count = seen.len();
            let paths =
                baked.options().samples.map_or_else(String::new, |samples| format!(" from {samples} paths each"));
            let places = if baked.is_lightmap() { "texels" } else { "vertices" };
            let text = format!(
                "holds fronts of surfaces; the backs of {count} {places}, which are seen, are baked now{paths}"
            );
            work.note(file, &text);
        }
        baked.bake_backs(&seen, work.step("bake"))
    }
}

/// The transfer that is asked for.
struct Asked<'a> {
    source: &'a TransferSource,
    mode: BakeMode,
    order: Option<usize>,
    /// Whether surfaces reflect more than a matte part: what hides that is known of black ones, too, where transfer
    /// leaves the albedo out.
    has_finish: bool,
    memory: MemoryLimit,
}

impl Asked<'_> {
    /// The lobe of glossy surfaces; without one they are matte.
    fn lobe(&self) -> Option<GlossyLobe> {
        (self.mode == BakeMode::Glossy).then(|| self.source.lobe.unwrap_or(LOBE))
    }

    /// The scene with the transfer of its fronts, and the file that this was read from.
    fn read_or_bake(&self, open: OpenScene, work: &mut Job<'_>) -> Result<SceneTransfer, RenderError> {
        let (lobe, memory, name) = (self.lobe(), self.memory, open.source().name());
        if let Some(file) = &self.source.transfer {
            check_file_of_numbers(memory, file, "a bake of fewer receivers or a lower order")?;
            let baked = BakedScene::read_transfer(open.scene(work)?, file, lobe)?;
            let name = file.display().to_string();
            return Ok(SceneTransfer { baked: self.checked(baked, &name)?, file: Some(name), is_scene: false, memory });
        }
        // A baked scene holds no matrices.
        let scene = if lobe.is_some() { open.scene(work)?.into() } else { open.baked_or_scene(work)? };
        match scene {
            BakedOrScene::Baked(baked) => {
                let baked = self.checked(BakedScene::from(*baked), &name)?;
                Ok(SceneTransfer { baked, file: Some(name), is_scene: true, memory })
            }
            BakedOrScene::Scene(scene, _) => {
                Ok(SceneTransfer { baked: self.bake(scene, work)?, file: None, is_scene: false, memory })
            }
        }
    }

    /// Refuses options that cannot be had of transfer that was baked before.
    fn checked(&self, baked: BakedScene, name: &str) -> Result<BakedScene, RenderError> {
        let (recipe, bake) = (baked.recipe(), &self.source.bake);
        let asked_for = [
            ("bake_samples", bake.bake_samples.map(|n| n as usize), recipe.samples.map(|n| n as usize)),
            ("bounces", bake.bounces, recipe.bounces),
        ];
        let refused = |option: &str, message: String| Err(OptionError::new(option, message).into());
        for (option, asked, found) in asked_for {
            if let Some(asked) = asked.filter(|asked| found != Some(*asked)) {
                let found = found.map_or("already".to_owned(), |found| format!("with {found}"));
                let advice = "leave the option out, or render the scene it was baked from";
                return refused(option, format!("{name} is baked {found}, not with {asked}; {advice}"));
            }
        }
        let wanted = self.mode.name();
        // A recipe that does not say is believed.
        let found = baked.recipe().mode_name().unwrap_or(wanted);
        if found != wanted {
            let advice = "ask for that, or render the scene it was baked from";
            return refused("mode", format!("{name} was baked as {found}, not as {wanted}; {advice}"));
        }
        if let Some(asked) = self.order.filter(|&asked| asked > baked.order()) {
            let message = format!("{name} was baked to order {}, not {asked}; bake it to a higher one", baked.order());
            return refused("order", message);
        }
        let options = baked.options().clone().mode(self.mode);
        Ok(baked.with_options(options))
    }

    fn bake(&self, scene: Scene, work: &mut Job<'_>) -> Result<BakedScene, RenderError> {
        let (bake, lobe) = (&self.source.bake, self.lobe());
        let options = bake.light(self.order.unwrap_or(BakeOptions::default().order)).mode(self.mode);
        // Matrices never have the albedo.
        let albedo = if self.has_finish { AlbedoMode::None } else { AlbedoMode::of_scene(&scene) };
        let options = if lobe.is_none() { options.albedo(albedo) } else { options };
        check_memory(self.memory, &scene, scene.vertex_count(), &options, lobe.is_some())?;
        let splitting = bake.splitting(scene.vertex_count(), options.clone())?;
        // Matrices take too much memory for vertices that nobody asked for.
        let is_split = !bake.no_split && (lobe.is_none() || bake.max_vertices.is_some());
        let scene = if is_split {
            BakeWork::at_vertices(scene, options.clone())?.split(&splitting, work.step("split"))?.0
        } else {
            scene
        };
        check_memory(self.memory, &scene, scene.vertex_count(), &options, lobe.is_some())?;
        BakedScene::bake(scene, &options, lobe, work.step("bake"))
    }
}

/// Refuses a bake that takes too much memory.
fn check_memory(
    memory: MemoryLimit,
    scene: &Scene,
    count: usize,
    options: &BakeOptions,
    is_glossy: bool,
) -> Result<(), RenderError> {
    let what = format!("transfer of {count} vertices at order {}", options.order);
    Ok(memory.check(&what, transfer_bytes(scene, count, options, is_glossy), "a lower @order")?)
}
