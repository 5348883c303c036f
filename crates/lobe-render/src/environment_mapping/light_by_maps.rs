//! Pictures of a scene by environment mapping.

use lobe_io::Job;
use lobe_scene::{Bvh, Scene};
use lobe_sh::{Dir, Rgb};

use crate::camera::camera::Camera;
use crate::environment_mapping::environment_maps::TurnedMaps;
use crate::error::RenderError;
use crate::scene_view::light_scene::LitPicture;
use crate::scene_view::scene_picture::ray_cast;
use crate::scene_view::scene_picture::{SceneHit, ViewOptions};

/// Shows a scene as `camera` sees it, lit by [`EnvironmentMaps`](crate::EnvironmentMaps), which has the formula: `background`
/// where a ray escapes.
///
/// The steps of `job` are pixels; it cannot be kept in a file. The same bits for any number of threads.
///
/// # Examples
///
/// ```
/// use lobe_env::EnvMap;
/// use lobe_io::Job;
/// use lobe_render::{Camera, EnvironmentMapOptions, EnvironmentMaps, View, ViewOptions, light_by_environment_maps};
/// use lobe_scene::{Bvh, built_in};
/// use lobe_sh::{Dir, Rgb, Rotation};
///
/// // Under even light of radiance 1 smooth metals show their colors.
/// let scene = built_in::ball_over_ground(24).with_finish(Some(0.0), Some(1.0))?;
/// let even = EnvMap::from_fn(16, 8, |_| Rgb::new(1.0, 1.0, 1.0));
/// let options = EnvironmentMapOptions::default().size(16);
/// let maps = EnvironmentMaps::new(even, &options, Job::default())?;
///
/// let camera = Camera::framing([-1.5, -1.5, 0.0], [1.5, 1.5, 2.0], View::three_quarter(), 0.35);
/// let view = ViewOptions::default().width(16).height(12);
/// let (bvh, behind) = (Bvh::new(&scene), |_: Dir| Rgb::new(1.0_f64, 1.0, 1.0));
/// let turned = maps.turned(&Rotation::IDENTITY);
/// let lit = light_by_environment_maps(&scene, &bvh, turned, &camera, &view, behind, Job::default())?;
/// let mean = lit.picture.mean();
/// assert!(mean[1] > 0.4 && mean[1] < 1.0, "{mean:?}");
/// # Ok::<(), lobe_render::RenderError>(())
/// ```
///
/// # Errors
/// As [`scene_picture`](fn@crate::scene_picture).
pub fn light_by_environment_maps(
    scene: &Scene,
    bvh: &Bvh,
    maps: TurnedMaps<'_>,
    camera: &Camera,
    options: &ViewOptions,
    background: impl Fn(Dir) -> Rgb<f64> + Sync,
    job: Job<'_>,
) -> Result<LitPicture, RenderError> {
    let radiance = |hit: &SceneHit<'_>| maps.radiance(hit);
    let (picture, coverage) = ray_cast(scene, bvh, camera, options, &background, &radiance, job)?;
    Ok(LitPicture { picture, coverage, below_zero: 0.0 })
}
