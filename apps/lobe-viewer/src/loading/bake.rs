//! Bakes of what the window shows, first with few paths, then with many.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use lobe::io::{Job, Progress};
use lobe::prt::{
    BakeMode, BakeOptions, FittedVertices, GlossyLobe, PrtError, Recipe, Transfer, TransferMatrices, bake_vertices,
};
use lobe::scene::{Bvh, Scene};
use lobe_gpu::GlossyMesh;

use crate::loading::cache::UserFolder;
use crate::loading::limits::ReadLimits;
use crate::loading::place::IN_PAGE;
use crate::loading::places::Places;
use crate::loading::scene_source::open_scene_for;
use crate::loading::task::Control;
use lobe::render::Surfaces;

/// Paths of the first bakes of a scene, which are there after a moment, before that which is asked for.
const FIRST_SAMPLES: [u32; 2] = [8, 64];

/// A scene of more paths is not baked before the user asks for it: it would take minutes.
pub(crate) const MOST_UNASKED: u64 = 250_000 * 256;

/// How long a bake waits for its scene to be drawn: a hidden window draws nothing.
const MOST_WAIT: Duration = Duration::from_secs(2);

/// Reflections of the window's own bakes.
pub(crate) const BOUNCES: usize = 3;

/// Metals of these `α` shine; by what is smoother or rougher than that, lobes of a few bands are far from microfacets, as the table
/// of [`TransferMatrices`] says.
const SHINING: std::ops::RangeInclusive<f64> = 0.05..=0.5;

/// The highest order of transfer matrices, which have the square of the numbers of vectors, and the most bytes of them.
const GLOSSY_ORDER: usize = 4;
const GLOSSY_BYTES: usize = 256 << 20;

/// Paths of the first bake of what shines.
const FIRST_GLOSSY: u32 = 64;

/// A scene and the rays among its triangles.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct SceneData {
    /// The name for people.
    pub name: String,
    /// The scene.
    pub scene: Arc<Scene>,
    /// Its tree.
    pub bvh: Arc<Bvh>,
}

impl SceneData {
    /// A scene with its tree, which is built now.
    #[must_use]
    pub fn new(name: impl Into<String>, scene: Scene) -> Self {
        let bvh = Arc::new(Bvh::new(&scene));
        Self { name: name.into(), scene: Arc::new(scene), bvh }
    }

    /// A moment of what moves, with its tree.
    pub(crate) fn of_moment(scene: &Scene, bvh: &Bvh) -> Self {
        Self { name: String::new(), scene: Arc::new(scene.clone()), bvh: Arc::new(bvh.clone()) }
    }
}

/// A mesh that shines: a metal with the transfer matrices of its vertices.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct GlossyBake {
    /// Its number in the scene.
    pub mesh: usize,
    /// The lobe of its reflection.
    pub lobe: GlossyLobe,
    /// The matrices, of paths with interreflections.
    pub matrices: Arc<TransferMatrices>,
}

impl GlossyBake {
    /// The mesh for a device.
    pub(crate) fn on_device(&self) -> GlossyMesh<'_> {
        GlossyMesh { mesh: self.mesh, matrices: &self.matrices, lobe: self.lobe }
    }
}

/// What comes from a task about a scene.
#[derive(Clone, Debug)]
pub(crate) enum SceneNews {
    /// A scene was opened.
    Opened(SceneData),
    /// Transfer of its vertices was read or baked.
    Baked {
        /// The light paths.
        mode: BakeMode,
        /// Paths from each vertex; none if the file does not say.
        samples: Option<u32>,
        /// Reflections at most, of a mode that has any.
        bounces: usize,
        /// What its rows are of.
        places: Places,
        /// The transfer.
        transfer: Arc<Transfer>,
        /// How a file says that it was baked.
        recipe: Option<Arc<Recipe>>,
    },
    /// The part without reflections of transfer of a file.
    Direct(Arc<Transfer>),
    /// Matrices of the meshes that shine.
    Glossy(Vec<GlossyBake>),
    /// It is large, or in a page, and not baked yet.
    AskBeforeBake,
}

impl SceneNews {
    fn of_bake(mode: BakeMode, samples: u32, transfer: Transfer) -> Self {
        let samples = Some(samples);
        let (places, transfer) = (Places::Vertices, Arc::new(transfer));
        Self::Baked { mode, samples, bounces: BOUNCES, places, transfer, recipe: None }
    }

    pub(crate) fn of_file(transfer: Transfer, recipe: &Recipe, places: Places) -> Self {
        Self::Baked {
            mode: recipe.mode.unwrap_or(BakeMode::Interreflected),
            samples: recipe.samples,
            bounces: recipe.bounces.unwrap_or(BOUNCES),
            places,
            transfer: Arc::new(transfer),
            recipe: Some(Arc::new(recipe.clone())),
        }
    }
}

/// The options of a bake of the window.
#[must_use]
pub fn bake_options(mode: BakeMode, order: usize, samples: u32) -> BakeOptions {
    BakeOptions::default().mode(mode).order(order).samples(samples).bounces(BOUNCES)
}

/// Bakes a scene, watched.
///
/// # Errors
/// As [`bake_vertices`].
pub fn bake_scene(
    data: &SceneData,
    options: &BakeOptions,
    mut watch: impl FnMut(&Progress) -> std::ops::ControlFlow<()>,
) -> Result<(Transfer, Recipe), PrtError> {
    let job = Job::default().watched_by(&mut watch);
    let (transfer, report) = bake_vertices(&data.scene, &data.bvh, options, job)?;
    let recipe = Recipe::of_bake(&data.scene, options, &report);
    Ok((transfer, recipe))
}

/// Opens a scene and says what is known of its light: what its file holds, what was kept of it, or what is baked now.
pub(crate) fn open(
    control: &Control<SceneNews>,
    (source, surfaces): (&Path, Surfaces),
    (order, samples): (usize, u32),
    (folder, limits): (&UserFolder, &ReadLimits),
) -> Result<(), String> {
    let name = source.file_name().unwrap_or_default().to_string_lossy();
    control.stage(name);
    let opened = open_scene_for(source, limits, surfaces).map_err(|error| error.to_string())?;
    if control.is_cancelled() {
        return Ok(());
    }
    let data = SceneData::new(opened.name, opened.scene);
    control.send(SceneNews::Opened(data.clone()));
    if let Some(baked) = opened.baked {
        let vertices = Places::vertices(&baked.recipe);
        if baked.lightmap.is_some() && matches!(vertices, Places::WithoutAlbedo) {
            return Err("a lightmap without albedo; lobe render shows it, or bake it with albedo".to_owned());
        }
        let places = baked.lightmap.map_or(vertices, |lightmap| Places::Texels(Arc::new(lightmap)));
        control.send(SceneNews::of_file(baked.transfer, &baked.recipe, places));
        return Ok(());
    }
    if IN_PAGE || data.scene.vertex_count() as u64 * u64::from(samples) > MOST_UNASKED {
        control.send(SceneNews::AskBeforeBake);
        return Ok(());
    }
    let folder = if opened.is_built_in { folder } else { &UserFolder::none() };
    rounds(control, &data, (order, samples), folder, |control| control.wait(MOST_WAIT))
}

/// Bakes what the modes of the window need, first with few paths; takes what was kept instead, and keeps what it made last. `begin` is
/// called before the first bake, for which all processors are taken.
pub(crate) fn rounds(
    control: &Control<SceneNews>,
    data: &SceneData,
    (order, samples): (usize, u32),
    folder: &UserFolder,
    begin: impl FnOnce(&Control<SceneNews>),
) -> Result<(), String> {
    const MODES: [BakeMode; 2] = [BakeMode::Interreflected, BakeMode::Shadowed];
    let mut missing = Vec::new();
    for mode in MODES {
        match folder.kept_bake(&data.scene, &bake_options(mode, order, samples)) {
            Some(transfer) => {
                control.send(SceneNews::of_bake(mode, samples, transfer));
            }
            None => missing.push(mode),
        }
    }
    begin(control);
    if control.is_cancelled() {
        return Ok(());
    }
    let first = FIRST_SAMPLES.into_iter().filter(|first| *first < samples);
    for round in first.chain([samples]) {
        for &mode in &missing {
            control.stage(format!("{} transfer, {round} paths", mode.name()));
            let options = bake_options(mode, order, round);
            let (transfer, recipe) = match bake_scene(data, &options, control.watch()) {
                Err(PrtError::Cancelled) => return Ok(()),
                other => other.map_err(|error| error.to_string())?,
            };
            if round == samples {
                folder.keep_bake(&data.scene, &options, &transfer, &recipe);
            }
            control.send(SceneNews::of_bake(mode, round, transfer));
        }
    }
    for round in Some(FIRST_GLOSSY).filter(|first| *first < samples).into_iter().chain([samples]) {
        control.stage(format!("metals, {round} paths"));
        match bake_glossy(data, order, round, control.watch()) {
            Err(PrtError::Cancelled) => return Ok(()),
            Err(error) => return Err(error.to_string()),
            Ok(none) if none.is_empty() => return Ok(()),
            Ok(glossy) => control.send(SceneNews::Glossy(glossy)),
        }
    }
    Ok(())
}

/// Bakes the meshes that shine, watched; none of them if they are too many.
///
/// # Errors
/// As [`FittedVertices::bake_matrices`].
pub(crate) fn bake_glossy(
    data: &SceneData,
    order: usize,
    samples: u32,
    mut watch: impl FnMut(&Progress) -> std::ops::ControlFlow<()>,
) -> Result<Vec<GlossyBake>, PrtError> {
    let order = order.min(GLOSSY_ORDER);
    let meshes = shining(&data.scene);
    let vertices: usize = meshes.iter().map(|(mesh, _)| data.scene.meshes()[*mesh].positions().len()).sum();
    // Three channels of single precision.
    if vertices * order.pow(4) * 12 > GLOSSY_BYTES {
        return Ok(Vec::new());
    }
    let options = bake_options(BakeMode::Interreflected, order, samples);
    let mut baked = Vec::new();
    for (mesh, lobe) in meshes {
        let own = FittedVertices::some(&data.scene, &vertices_of(&data.scene, mesh).collect::<Vec<_>>())?;
        let (matrices, _) = own.bake_matrices(&data.bvh, &options, Job::default().watched_by(&mut watch))?;
        baked.push(GlossyBake { mesh, lobe, matrices: Arc::new(matrices) });
    }
    Ok(baked)
}

/// The vertices of a mesh among those of its scene.
pub(crate) fn vertices_of(scene: &Scene, mesh: usize) -> Range<usize> {
    let before = |end: usize| -> usize { scene.meshes()[..end].iter().map(|m| m.positions().len()).sum() };
    before(mesh)..before(mesh + 1)
}

/// The meshes of metals that shine, by their numbers, with their lobes.
pub(crate) fn shining(scene: &Scene) -> Vec<(usize, GlossyLobe)> {
    let lobe = |mesh: usize| {
        let material = scene.material(mesh);
        let alpha = f64::from(material.roughness).powi(2);
        let is_shining = material.metallic > 0.5 && SHINING.contains(&alpha);
        (is_shining && !scene.meshes()[mesh].positions().is_empty()).then_some((mesh, GlossyLobe::Ggx(alpha)))
    };
    (0..scene.meshes().len()).filter_map(lobe).collect()
}
