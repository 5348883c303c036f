//! Baked scenes: a scene with its transfer, read from a file or baked on the spot.

use std::path::Path;

use lobe_image::FileFormat;
use lobe_io::Job;
use lobe_prt::{
    AnyTransfer, BakeMode, BakeOptions, Baked, FittedVertices, GlossyLobe, Lightmap, Recipe, read_any_transfer_bytes,
    read_baked, read_baked_bytes, read_matrices_bytes,
};
use lobe_scene::{Bvh, Scene, SceneReadOptions};

use crate::camera::camera::Camera;
use crate::error::RenderError;
use crate::scene_view::placed_transfer::{self, PlacedTransfer};
use crate::scene_view::prt_shading::{Gloss, Places, SurfaceTransfer};
use crate::scene_view::scene_picture::ViewOptions;

/// A scene with precomputed radiance transfer at its vertices or at the texels of a lightmap.
///
/// It is lit by [`BakedScene::lit`], or in one step by [`light_baked_scene`](crate::light_baked_scene). Transfer covers
/// the fronts of surfaces. Double-sided surfaces show their backs too; [`BakedScene::bake_backs`] bakes those that a
/// view shows, and until then they are black.
pub struct BakedScene {
    pub(crate) scene: Scene,
    bvh: Bvh,
    pub(crate) places: Places,
    pub(crate) front: SurfaceTransfer,
    pub(crate) back: Option<PlacedTransfer>,
    /// Transfer without reflections, where that is known.
    pub(crate) direct: Option<DirectPart>,
    /// None if surfaces are matte.
    pub(crate) gloss: Option<Gloss>,
    /// Options of the bake of backs; the albedo is where it is in the fronts.
    pub(crate) options: BakeOptions,
    recipe: Recipe,
}

impl From<Baked> for BakedScene {
    /// The scene of a baked glTF file, with the backs that it holds, and the options of its recipe for others.
    fn from(baked: Baked) -> Self {
        let Baked { scene, transfer, lightmap, recipe, backs, direct, .. } = baked;
        let places = lightmap.map_or(Places::Vertices, |lightmap| Places::Texels(Box::new(lightmap)));
        let read = Self::new(scene, places, SurfaceTransfer::Matte(transfer.into()), None, recipe);
        let back = backs.map(|backs| PlacedTransfer::of_file(&read.scene, backs));
        let direct = direct.map(|direct| DirectPart { front: PlacedTransfer::at_vertices(direct), back: None });
        Self { back, direct, ..read }
    }
}

impl BakedScene {
    /// Reads a baked .glb or .gltf file.
    ///
    /// # Errors
    /// [`RenderError::Prt`] with the errors of [`lobe_prt::read_baked`].
    pub fn read(path: impl AsRef<Path>, options: &SceneReadOptions) -> Result<Self, RenderError> {
        Ok(read_baked(path, options)?.into())
    }

    /// [`BakedScene::read`] from the bytes of a file that references no other; `name` stands in messages.
    ///
    /// # Errors
    /// [`RenderError::Prt`] with the errors of [`lobe_prt::read_baked_bytes`].
    pub fn read_bytes(bytes: &[u8], name: &str, options: &SceneReadOptions) -> Result<Self, RenderError> {
        Ok(read_baked_bytes(bytes, name, options)?.into())
    }

    /// Reads the transfer of `scene` from a file that holds transfer alone: with a `lobe` a .safetensors file of
    /// matrices at vertices, else one of transfer in any form, or an OpenEXR lightmap.
    ///
    /// # Errors
    /// [`RenderError::Io`] if the file cannot be read; [`RenderError::Prt`] if it holds no such transfer, or is a lightmap and
    /// the scene is not unfolded; [`RenderError::Invalid`] if it is of another number of vertices.
    pub fn read_transfer(scene: Scene, path: impl AsRef<Path>, lobe: Option<GlossyLobe>) -> Result<Self, RenderError> {
        let path = path.as_ref();
        let bytes = std::fs::read(path).map_err(RenderError::io(path))?;
        Self::read_transfer_bytes(scene, &bytes, &path.display().to_string(), lobe)
    }

    /// [`BakedScene::read_transfer`] from the bytes of a file, whose name stands in messages.
    ///
    /// # Errors
    /// As [`BakedScene::read_transfer`].
    pub fn read_transfer_bytes(
        scene: Scene,
        bytes: &[u8],
        name: &str,
        lobe: Option<GlossyLobe>,
    ) -> Result<Self, RenderError> {
        if lobe.is_some() {
            let (matrices, recipe) = read_matrices_bytes(bytes, name)?;
            expect_vertices(&scene, matrices.points(), name, &recipe)?;
            return Ok(Self::new(scene, Places::Vertices, SurfaceTransfer::Glossy(matrices), lobe, recipe));
        }
        let (transfer, recipe) = read_any_transfer_bytes(bytes, name)?;
        let is_picture = matches!(FileFormat::of_bytes(bytes, name), Ok(FileFormat::OpenExr));
        let width = transfer.receivers().isqrt();
        let is_of_texels = is_picture || recipe.texels == Some(width);
        let scene = if is_of_texels { recipe.scene_of_texels(scene, name)? } else { scene };
        let places = if is_of_texels {
            Places::Texels(Box::new(Lightmap::new(&scene, width)?))
        } else {
            expect_vertices(&scene, transfer.receivers(), name, &recipe)?;
            Places::Vertices
        };
        Ok(Self::new(scene, places, SurfaceTransfer::Matte(transfer), None, recipe))
    }

    /// Bakes the vertices of `scene`, [fitted](lobe_prt::bake_vertices), with matrices and `lobe` if there is one. The
    /// steps of `job` are triangles; it can be kept in a file.
    ///
    /// # Errors
    /// [`RenderError::Prt`] with the errors of [`bake`](fn@lobe_prt::bake), [`RenderError::Cancelled`] if the
    /// watch of the job said to stop.
    pub fn bake(
        scene: Scene,
        options: &BakeOptions,
        lobe: Option<GlossyLobe>,
        job: Job<'_>,
    ) -> Result<Self, RenderError> {
        let bvh = Bvh::new(&scene);
        let (front, report) = SurfaceTransfer::fit(&FittedVertices::all(&scene)?, &bvh, options, lobe.is_some(), job)?;
        let recipe = Recipe::of_bake(&scene, options, &report);
        let recipe = if lobe.is_some() { recipe.mode(BakeMode::Glossy) } else { recipe };
        let (gloss, options) = (lobe.map(Gloss::new), options.clone());
        Ok(Self { scene, bvh, places: Places::Vertices, front, back: None, direct: None, gloss, options, recipe })
    }

    fn new(scene: Scene, places: Places, front: SurfaceTransfer, lobe: Option<GlossyLobe>, recipe: Recipe) -> Self {
        // Light goes where it went in the bake, whatever the options of reading were.
        let scene = scene.with_straight_through(recipe.straight_through == Some(true));
        let (bvh, gloss) = (Bvh::new(&scene), lobe.map(Gloss::new));
        let options = recipe.bake_options().order(front.order());
        Self { scene, bvh, places, front, back: None, direct: None, gloss, options, recipe }
    }

    /// The same with other options for the bake of backs. Their [`BakeOptions::albedo`] remains that of the fronts, which
    /// are shaded alike.
    #[must_use]
    pub fn with_options(self, options: BakeOptions) -> Self {
        let options = options.albedo(self.options.albedo);
        Self { options, ..self }
    }

    /// The same with [one finish](Scene::with_finish) of all surfaces, which transfer does not depend on.
    ///
    /// # Errors
    /// [`RenderError::Scene`] for numbers that are not from 0 to 1.
    pub fn with_finish(self, roughness: Option<f32>, metallic: Option<f32>) -> Result<Self, RenderError> {
        let scene = self.scene.with_finish(roughness, metallic)?;
        Ok(Self { scene, ..self })
    }

    /// The options of the bake of backs: as the recipe in the file says the fronts were, with defaults for what it
    /// leaves out.
    #[must_use]
    pub fn options(&self) -> &BakeOptions {
        &self.options
    }

    /// The recipe in the file, or that of the bake on the spot; an empty one if the file has none.
    #[must_use]
    pub fn recipe(&self) -> &Recipe {
        &self.recipe
    }

    /// The scene.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The tree over the triangles of the scene.
    #[must_use]
    pub fn bvh(&self) -> &Bvh {
        &self.bvh
    }

    /// The order of the transfer: light of more bands is cut off there.
    #[must_use]
    pub fn order(&self) -> usize {
        self.front.order()
    }

    /// The vertices or texels whose fronts are baked.
    #[must_use]
    pub fn receivers(&self) -> usize {
        self.places.count(&self.scene)
    }

    /// Whether surfaces are glossy rather than matte.
    #[must_use]
    pub fn is_glossy(&self) -> bool {
        self.gloss.is_some()
    }

    /// Whether transfer is at the texels of a lightmap rather than at vertices.
    #[must_use]
    pub fn is_lightmap(&self) -> bool {
        matches!(self.places, Places::Texels(_))
    }

    /// The vertices or texels that a view shows from behind, in rising order: those that [`BakedScene::bake_backs`]
    /// needs. None if the backs of all of them are known, such as from the file.
    ///
    /// The steps of `job` are the pixels that were looked at.
    ///
    /// # Errors
    /// As [`scene_picture`](fn@crate::scene_picture).
    pub fn backs_in_view(&self, camera: &Camera, view: &ViewOptions, job: Job<'_>) -> Result<Vec<usize>, RenderError> {
        let seen = placed_transfer::backs_in_view(&self.scene, &self.bvh, camera, view, &self.places, job)?;
        let is_known = |place: &usize| self.back.as_ref().is_some_and(|back| back.receiver(*place).is_some());
        Ok(if seen.iter().all(is_known) { Vec::new() } else { seen })
    }

    /// Bakes the backs of these vertices or texels, in rising order, in place of those that were baked before.
    ///
    /// # Errors
    /// As [`BakedScene::bake`].
    pub fn bake_backs(&mut self, seen: &[usize], job: Job<'_>) -> Result<(), RenderError> {
        let Self { scene, bvh, places, options, .. } = &*self;
        let is_glossy = self.is_glossy();
        self.back = Some(PlacedTransfer::backs((scene, bvh), places, seen, options, is_glossy, job)?);
        if let Some(direct) = &mut self.direct {
            direct.back = None;
        }
        Ok(())
    }

    /// Whether suns of a light, and reflections that surfaces hide, need transfer without reflections that is not known
    /// yet: of matte surfaces that reflect.
    #[must_use]
    pub fn needs_direct(&self) -> bool {
        self.options.most_bounces() > 0 && !self.is_glossy() && !self.knows_direct()
    }

    /// Whether its transfer, with the direct part that can be baked, says what hides reflections.
    pub(crate) fn tells_openness(&self) -> bool {
        let is_plain = matches!(&self.front, SurfaceTransfer::Matte(AnyTransfer::Plain(_)));
        is_plain || self.options.most_bounces() > 0 || self.options.mode == BakeMode::Unshadowed
    }

    /// Whether the direct part is known of fronts and of all backs that are.
    pub(crate) fn knows_direct(&self) -> bool {
        self.direct.as_ref().is_some_and(|direct| direct.back.is_some() == self.back.is_some())
    }

    /// Bakes the transfer without reflections, of the fronts and of the backs that are known, so that suns cast
    /// shadows by rays. Its paths are the first parts of those of the whole transfer: what both share has no noise of
    /// its own.
    ///
    /// # Errors
    /// As [`BakedScene::bake`].
    pub fn bake_direct(&mut self, mut job: Job<'_>) -> Result<(), RenderError> {
        let Self { scene, bvh, places, options, recipe, .. } = &*self;
        let options = options.clone().of_direct_part(recipe.samples);
        let front = match &self.direct {
            Some(_) => None,
            None => {
                // Texels as those of the whole transfer are.
                let finish = recipe.finish_options();
                Some(PlacedTransfer::fronts((scene, bvh), places, (&options, &finish), job.reborrow())?)
            }
        };
        let back = match &self.back {
            Some(back) => Some(PlacedTransfer::backs((scene, bvh), places, &back.places(), &options, false, job)?),
            None => None,
        };
        let front = front.or_else(|| self.direct.take().map(|known| known.front));
        self.direct = front.map(|front| DirectPart { front, back });
        Ok(())
    }

    /// The fronts and the backs whose direct part [`BakedScene::bake_direct`] bakes: no fronts if a file holds theirs.
    #[must_use]
    pub fn lacking_direct(&self) -> [usize; 2] {
        let fronts = if self.direct.is_some() { 0 } else { self.receivers() };
        [fronts, self.back.as_ref().map_or(0, |back| back.places().len())]
    }
}

/// Transfer of light that no surface reflects but the last.
pub(crate) struct DirectPart {
    pub(crate) front: PlacedTransfer,
    /// Of the backs that are known, in their order.
    pub(crate) back: Option<PlacedTransfer>,
}

/// The most bytes that baking and lighting `receivers` receivers of a scene take: their rows, twice while they grow,
/// and their values under one light.
#[must_use]
pub fn transfer_bytes(scene: &Scene, receivers: usize, options: &BakeOptions, is_glossy: bool) -> u64 {
    let (bands, channels) = (options.order.pow(2), options.channels_for(scene, scene.is_gray()).count());
    let (numbers, lit) = if is_glossy { (bands * bands, 3 * 8 * bands) } else { (bands, 3 * 4) };
    ((2 * 4 * numbers * channels + lit) as u64).saturating_mul(receivers as u64)
}

fn expect_vertices(scene: &Scene, found: usize, name: &str, recipe: &Recipe) -> Result<(), RenderError> {
    let count = scene.vertex_count();
    if count == found {
        return Ok(());
    }
    let mut message = format!("expected transfer of {count} vertices as the scene has, found {found}");
    if recipe.max_edge.is_some() || recipe.adaptive.is_some() {
        message += "; baked with --max-edge or --adaptive it belongs to the split mesh, which a bake to .glb holds";
    }
    Err(RenderError::Invalid { place: name.to_owned(), message })
}
