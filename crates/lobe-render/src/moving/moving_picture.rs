//! Pictures of moving scenes.

use lobe_io::Job;
use lobe_sh::{Dir, Rgb, ShVec};

use crate::scene_view::back_faces::backs_in_view;
use crate::scene_view::light_scene::picture_of;
use crate::scene_view::prt_shading::Places;
use crate::{Camera, LitPicture, Moment, MovingShading, RenderError, SceneHit, ViewOptions};

/// Lights a moment of a moving scene, and shows it as `camera` sees it: `background` where a ray escapes.
///
/// The other arguments are those of [`light_baked_scene`](crate::light_baked_scene). To see the reference, hand
/// [`Moment::scene`] to [`render_truth`](crate::render_truth).
///
/// # Errors
/// As [`scene_picture`](fn@crate::scene_picture) and [`MovingShading::exit_radiance`].
pub fn light_moving_scene(
    moment: &Moment<'_>,
    shading: &MovingShading,
    light: &ShVec<Rgb<f64>>,
    camera: &Camera,
    options: &ViewOptions,
    background: impl Fn(Dir) -> Rgb<f64> + Sync,
    mut job: Job<'_>,
) -> Result<LitPicture, RenderError> {
    let (scene, bvh) = (moment.scene(), moment.bvh());
    let fronts = shading.exit_radiance(moment, light)?;
    let seen = backs_in_view(scene, bvh, camera, options, &Places::Vertices, job.reborrow())?;
    let backs = if seen.is_empty() { Vec::new() } else { shading.exit_radiance_of_backs(moment, light)? };
    let radiance = |hit: &SceneHit<'_>| hit.at_corners(if hit.is_front { &fronts } else { &backs });
    picture_of((scene, bvh), light, camera, options, background, radiance, job)
}
