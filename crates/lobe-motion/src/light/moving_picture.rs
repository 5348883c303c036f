//! Pictures of moving scenes.

use lobe_env::SceneLight;
use lobe_io::{Job, Progress};
use lobe_sh::{Dir, Rgb};

use crate::light::moving_shading::MovingShading;
use crate::light::moving_shading::Shaded;
use crate::light::moving_surroundings::MovingSurroundings;
use crate::scene::moment::Moment;
use crate::scene::moving_scene::MovingScene;
use lobe_render::{
    Camera, LitPicture, LitSurfaces, MatteSurfaces, RenderError, SceneHit, SurfaceModel, Surroundings, ViewOptions,
    light_surfaces_by, vertex_backs_in_view,
};

/// Lights a moment of a moving scene, and shows it as `camera` sees it: `background` where a ray escapes. Where the
/// transfer of a part leaves out the albedo, and on parts that are deformed, that of the pixel counts, so that textures
/// keep their detail.
///
/// The other arguments are those of [`light_baked_scene`](lobe_render::light_baked_scene). To see the reference, hand
/// [`Moment::scene`] to [`render_truth`](lobe_render::render_truth).
///
/// # Errors
/// As [`scene_picture`](fn@lobe_render::scene_picture) and [`MovingShading::exit_radiance`].
pub fn light_moving_scene(
    moment: &Moment<'_>,
    shading: &MovingShading,
    light: &SceneLight,
    camera: &Camera,
    options: &ViewOptions,
    background: impl Fn(Dir) -> Rgb<f64> + Sync,
    job: Job<'_>,
) -> Result<LitPicture, RenderError> {
    light_moving_surfaces(moment, shading, (light, &MatteSurfaces), camera, options, background, job)
}

/// [`light_moving_scene`] by any model of reflection, such as [`GltfSurfaces`](lobe_render::GltfSurfaces). What hides
/// reflections of fronts is known in three bands, and shines by what a part sends to itself; backs, and black surfaces
/// whose transfer holds the albedo, reflect as if nothing hid the sky.
///
/// # Errors
/// As [`light_moving_scene`].
pub fn light_moving_surfaces(
    moment: &Moment<'_>,
    shading: &MovingShading,
    (light, model): (&SceneLight, &dyn SurfaceModel),
    camera: &Camera,
    options: &ViewOptions,
    background: impl Fn(Dir) -> Rgb<f64> + Sync,
    mut job: Job<'_>,
) -> Result<LitPicture, RenderError> {
    let (scene, bvh) = (moment.scene(), moment.bvh());
    let total = options.width.saturating_mul(options.height);
    let fronts = Lit::new(moment, shading.fronts(moment, light, &mut || go_on(&mut job, total))?);
    let seen = vertex_backs_in_view(scene, bvh, camera, options, job.reborrow())?;
    let backs = match seen.is_empty() {
        true => None,
        false => Some(Lit::new(moment, shading.backs(moment, light, &seen, &mut || go_on(&mut job, total))?)),
    };
    let around = match model.looks_around() {
        true => Some(MovingSurroundings::new(shading, moment, &light.whole(), &mut || go_on(&mut job, total))?),
        false => None,
    };
    let lit = LitMoment { moment, fronts, backs, around };
    let light = shading.by_rays(moment, light);
    light_surfaces_by((scene, bvh), (&light, model), camera, options, &background, &lit, job)
}

/// A moment under a light.
struct LitMoment<'a> {
    moment: &'a Moment<'a>,
    fronts: Lit,
    backs: Option<Lit>,
    around: Option<MovingSurroundings>,
}

impl LitSurfaces for LitMoment<'_> {
    fn matte(&self, hit: &SceneHit<'_>) -> Rgb<f64> {
        match &self.backs {
            Some(backs) if !hit.is_front => backs.radiance(self.moment, hit),
            _ => self.fronts.radiance(self.moment, hit),
        }
    }

    fn surroundings(&self, hit: &SceneHit<'_>, axis: Dir, roughness: f64) -> Surroundings {
        match &self.around {
            Some(around) if hit.is_front => around.at(hit, axis, roughness),
            _ => Surroundings::UNKNOWN,
        }
    }
}

/// Tells that no pixel is done yet, and ends where the job says so.
fn go_on(job: &mut Job<'_>, total: usize) -> Result<(), RenderError> {
    match job.report(&Progress { done: 0, total, ..Progress::default() }).is_break() {
        true => Err(RenderError::Cancelled),
        false => Ok(()),
    }
}

impl MovingScene {
    /// The vertices of a moment that a view shows from behind, in rising order: those that [`MovingScene::bake_backs`]
    /// needs.
    ///
    /// The steps of `job` are the pixels that were looked at.
    ///
    /// # Errors
    /// As [`scene_picture`](fn@lobe_render::scene_picture).
    pub fn backs_in_view(
        moment: &Moment<'_>,
        camera: &Camera,
        view: &ViewOptions,
        job: Job<'_>,
    ) -> Result<Vec<usize>, RenderError> {
        vertex_backs_in_view(moment.scene(), moment.bvh(), camera, view, job)
    }
}

/// All vertices under a light.
struct Lit {
    radiance: Vec<Rgb<f32>>,
    /// For each mesh, whether the albedo is left out.
    is_white: Vec<bool>,
}

impl Lit {
    fn new(moment: &Moment<'_>, parts: Vec<Shaded>) -> Self {
        let mut is_white = Vec::with_capacity(moment.scene().meshes().len());
        for (shaded, part) in parts.iter().zip(moment.parts()) {
            is_white.extend(part.scene.meshes().iter().map(|_| shaded.is_white));
        }
        Self { radiance: parts.into_iter().flat_map(|part| part.radiance).collect(), is_white }
    }

    fn radiance(&self, moment: &Moment<'_>, hit: &SceneHit<'_>) -> Rgb<f64> {
        let radiance = hit.at_corners(&self.radiance);
        let (mesh, _) = moment.scene().locate(hit.hit().triangle as usize);
        if self.is_white[mesh] { hit.albedo * radiance } else { radiance }
    }
}
