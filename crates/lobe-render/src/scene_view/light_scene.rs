//! Pictures of a scene under an expansion: by its baked transfer, or by irradiance alone.

use std::f64::consts::FRAC_1_PI;
use std::sync::atomic::{AtomicUsize, Ordering};

use lobe_env::SceneLight;
use lobe_image::Picture;
use lobe_io::Job;
use lobe_scene::{Bvh, Scene};
use lobe_sh::{Coefficient as _, Dir, Expansion as _, Rgb, ShVec, Zonal};

use crate::camera::camera::Camera;
use crate::error::RenderError;
use crate::scene_view::baked_scene::BakedScene;
use crate::scene_view::scene_picture::ray_cast;
use crate::scene_view::scene_picture::{SceneHit, ViewOptions};
use crate::scene_view::sun_rays::SunRays;
use crate::scene_view::surface_model::{LitSurfaces, MatteSurfaces, SurfaceLight, SurfaceModel, Surroundings};

/// A channel that is below zero by more than this part of the mean radiance of the light is a dark spot in the picture,
/// not rounding.
const VISIBLY_BELOW: f64 = 1e-3;

/// A scene that is lit.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct LitPicture {
    /// Radiance.
    pub picture: Picture,
    /// The part of each pixel that shows a surface, 0 to 1, row by row; glass by the part of the light that it stops.
    /// Before a background that is black it is the alpha of the picture.
    pub coverage: Vec<f32>,
    /// The part of the rays that hit a lit surface whose radiance is below zero in some channel, by more than 0.1 % of
    /// the light's mean. This happens where the expansion of the light rings; see [`lobe_sh::ringing`]. 0 without an
    /// expansion.
    pub below_zero: f64,
}

/// Lights a baked scene, and shows it as `camera` sees it: `background` where a ray escapes.
///
/// ```text
///   matte    B = Σᵢ Lᵢ Tᵢ - Σᵢ Sᵢ Dᵢ + ρ/π Σ_suns E_sun max(n·s, 0) V(x, s)
///   glossy   B = ρ Σᵢ (k ∗ M L)ᵢ yᵢ(r)
///
///   T: transfer vector   D: its part without reflections   M: transfer matrix   k: lobe   r: mirrored direction
///   L: expansion of all light   S: that of the suns   V: what is seen of a sun   ρ: albedo, or directional albedo
/// ```
///
/// Suns cast shadows by rays, and what surfaces reflect of them is in `T - D`, which [`BakedScene::bake_direct`] has to
/// find first: without it, and on glossy surfaces, the expansion holds the suns. Bands above [`BakedScene::order`] are
/// ignored. The steps of `job` are pixels; it cannot be kept in a file. The same bits for any number of threads.
///
/// # Examples
///
/// ```
/// use lobe_io::Job;
/// use lobe_prt::BakeOptions;
/// use lobe_render::{BakedScene, Camera, View, ViewOptions, light_baked_scene};
/// use lobe_sh::Coefficient as _;
///
/// let options = BakeOptions::default().order(3).samples(16);
/// let scene = lobe_scene::built_in::ball_over_ground(8);
/// let baked = BakedScene::bake(scene, &options, None, Job::default())?;
///
/// let sky = lobe_env::bundled::sunset().map();
/// let light = lobe_env::project_env(&sky, 3).into();
/// let camera = Camera::framing([-1.5, -1.5, 0.0], [1.5, 1.5, 2.0], View::three_quarter(), 0.35);
/// let view = ViewOptions::default().width(32).height(24);
/// let lit = light_baked_scene(&baked, &light, &camera, &view, |s| sky.radiance(s).widen(), Job::default())?;
/// assert!(lit.picture.pixels().iter().any(|pixel| pixel[1] > 0.0), "{}", lit.below_zero);
/// # Ok::<(), lobe_render::RenderError>(())
/// ```
///
/// # Errors
/// As [`scene_picture`](fn@crate::scene_picture).
pub fn light_baked_scene(
    baked: &BakedScene,
    light: &SceneLight,
    camera: &Camera,
    options: &ViewOptions,
    background: impl Fn(Dir) -> Rgb<f64> + Sync,
    job: Job<'_>,
) -> Result<LitPicture, RenderError> {
    light_baked_surfaces(baked, (light, &MatteSurfaces), camera, options, background, job)
}

/// [`light_baked_scene`] by any model of reflection, such as [`GltfSurfaces`](crate::GltfSurfaces): what hides
/// reflections is known where the transfer without reflections is ([`BakedScene::bake_direct`]) and not compressed.
///
/// # Errors
/// As [`scene_picture`](fn@crate::scene_picture).
pub fn light_baked_surfaces(
    baked: &BakedScene,
    (light, model): (&SceneLight, &dyn SurfaceModel),
    camera: &Camera,
    options: &ViewOptions,
    background: impl Fn(Dir) -> Rgb<f64> + Sync,
    job: Job<'_>,
) -> Result<LitPicture, RenderError> {
    let lit = baked.lit(light);
    let lit = if model.looks_around() { lit.with_surroundings() } else { lit };
    let scene = (baked.scene(), baked.bvh());
    light_surfaces_by(scene, (&lit.by_rays(), model), camera, options, &background, &lit, job)
}

/// Lights a scene by the irradiance of its shading normals, without shadows, of suns neither: `B = albedo/π · E(n)`.
/// Normal maps tilt them in every pixel.
///
/// The other arguments are those of [`light_baked_scene`].
///
/// # Errors
/// As [`scene_picture`](fn@crate::scene_picture).
pub fn light_by_irradiance(
    scene: &Scene,
    bvh: &Bvh,
    light: &SceneLight,
    camera: &Camera,
    options: &ViewOptions,
    background: impl Fn(Dir) -> Rgb<f64> + Sync,
    job: Job<'_>,
) -> Result<LitPicture, RenderError> {
    let lit = LitByIrradiance { rest: light.rest().convolved(&Zonal::clamped_cosine(light.rest().order())) };
    light_surfaces_by((scene, bvh), (light, &MatteSurfaces), camera, options, &background, &lit, job)
}

/// Surfaces that see all of a light, whatever is before them.
struct LitByIrradiance {
    /// The irradiance of all but the suns.
    rest: ShVec<Rgb<f64>>,
}

impl LitSurfaces for LitByIrradiance {
    fn matte(&self, hit: &SceneHit<'_>) -> Rgb<f64> {
        (hit.albedo * self.rest.eval(hit.normal)).scale(FRAC_1_PI)
    }

    fn surroundings(&self, _hit: &SceneHit<'_>, _axis: Dir, _roughness: f64) -> Surroundings {
        Surroundings::OPEN
    }

    fn hide_suns(&self) -> bool {
        false
    }
}

/// Shows a scene as `camera` sees it, where `shade` gives the radiance of each hit without the direct light of suns,
/// which is added by [`SunRays`].
///
/// ```text
///   B = shade + ρ/π Σ_suns E_sun max(n·s, 0) V(x, s)
/// ```
///
/// The mean of `light` is the measure of [`LitPicture::below_zero`]. The other arguments are those of
/// [`light_baked_scene`].
///
/// # Errors
/// As [`scene_picture`](fn@crate::scene_picture).
pub fn light_scene_by(
    (scene, bvh): (&Scene, &Bvh),
    light: &SceneLight,
    camera: &Camera,
    options: &ViewOptions,
    background: &(dyn Fn(Dir) -> Rgb<f64> + Sync),
    shade: &(dyn Fn(&SceneHit<'_>) -> Rgb<f64> + Sync),
    job: Job<'_>,
) -> Result<LitPicture, RenderError> {
    light_surfaces_by((scene, bvh), (light, &MatteSurfaces), camera, options, background, &shade, job)
}

/// [`light_scene_by`] where surfaces reflect by a model what is said of their light.
///
/// # Errors
/// As [`scene_picture`](fn@crate::scene_picture).
pub fn light_surfaces_by(
    (scene, bvh): (&Scene, &Bvh),
    (light, model): (&SceneLight, &dyn SurfaceModel),
    camera: &Camera,
    options: &ViewOptions,
    background: &(dyn Fn(Dir) -> Rgb<f64> + Sync),
    lit: &dyn LitSurfaces,
    job: Job<'_>,
) -> Result<LitPicture, RenderError> {
    let rays = SunRays::new(scene, bvh, light).hidden(lit.hide_suns());
    let shade = |hit: &SceneHit<'_>| {
        let suns: Vec<_> = rays.shining_on(&hit.lit_at).collect();
        model.radiance(hit, &SurfaceLight { lit, suns: &suns })
    };
    let counted = Counted::new(light, &shade);
    let radiance = |hit: &SceneHit<'_>| counted.radiance(hit);
    let (picture, coverage) = ray_cast(scene, bvh, camera, options, background, &radiance, job)?;
    Ok(LitPicture { picture, coverage, below_zero: counted.below_zero() })
}

impl LitPicture {
    /// The picture with its coverage as [alpha](Picture::alpha), for what was rendered before black.
    #[must_use]
    pub fn before_nothing(self) -> Self {
        let Self { picture, coverage, below_zero } = self;
        let alpha = coverage.clone();
        let picture = picture.with_alpha(alpha).unwrap_or_else(|_| unreachable!("a pixel has a coverage"));
        Self { picture, coverage, below_zero }
    }
}

/// A shading that counts how often it is below zero.
struct Counted<'a> {
    shade: &'a (dyn Fn(&SceneHit<'_>) -> Rgb<f64> + Sync),
    /// Values below this are visibly below zero.
    limit: f64,
    shaded: AtomicUsize,
    below: AtomicUsize,
}

impl<'a> Counted<'a> {
    fn new(light: &SceneLight, shade: &'a (dyn Fn(&SceneHit<'_>) -> Rgb<f64> + Sync)) -> Self {
        let limit = -VISIBLY_BELOW * light.mean().luminance().abs();
        Self { shade, limit, shaded: AtomicUsize::new(0), below: AtomicUsize::new(0) }
    }

    fn radiance(&self, hit: &SceneHit<'_>) -> Rgb<f64> {
        let radiance = (self.shade)(hit);
        let is_below = radiance.r.min(radiance.g).min(radiance.b) < self.limit;
        self.shaded.fetch_add(1, Ordering::Relaxed);
        self.below.fetch_add(usize::from(is_below), Ordering::Relaxed);
        radiance
    }

    fn below_zero(self) -> f64 {
        self.below.into_inner() as f64 / self.shaded.into_inner().max(1) as f64
    }
}
