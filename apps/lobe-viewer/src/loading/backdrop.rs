//! Background of a scene on a device, by the words of the command, and the alpha of pictures before nothing.

use std::path::Path;

use lobe::env::{EnvMap, MappedMap, reconstruct};
use lobe::image::{FrameSequence, Picture, Tone};
use lobe::io::Job;
use lobe::render::{Backdrop, Background};
use lobe::scene::Scene;
use lobe::sh::{Coefficient as _, Rgb, ShVec};
use lobe_gpu::{
    Context, Environment, GpuCamera, GpuError, SceneView, SceneViewOptions, SurfaceShading, TurningLight,
    TurntableOptions, render_turntable, write_turntable,
};

use crate::loading::sky_source::on_device;

/// Rows of the picture of an expansion: of band 7 a wave has 36.
const ROWS: usize = 128;

/// A background, and the expansion that it shows if it is the light.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Behind {
    background: Background,
    light: Option<ShVec<Rgb<f64>>>,
}

impl Behind {
    /// A background under a light that is not turned.
    pub(crate) fn new(background: Background, light: impl FnOnce() -> ShVec<Rgb<f64>>) -> Self {
        Self { background, light: (background == Background::Light).then(light) }
    }

    /// Whether pictures have an alpha.
    pub(crate) fn is_nothing(&self) -> bool {
        self.background == Background::None
    }

    /// What a device shows, of a sky if it is that.
    pub(crate) fn on_device(&self, context: &Context, sky: Option<&MappedMap>) -> Option<Environment> {
        let shown = |map: EnvMap| Environment::from(&MappedMap::from(map));
        match (self.background, &self.light) {
            (Background::Env, _) => sky.map(|sky| on_device(context, sky)),
            (Background::Color(color), _) => Some(shown(EnvMap::from_fn(2, 1, |_| Rgb::narrow(color)))),
            (_, Some(light)) => Some(shown(reconstruct(light, 2 * ROWS, ROWS))),
            _ => None,
        }
    }

    /// What paths show.
    pub(crate) fn backdrop(&self) -> Backdrop {
        match &self.light {
            Some(light) => Backdrop::Expansion(light.clone()),
            None => self.background.backdrop(None, None),
        }
    }

    /// The alpha of pictures before nothing; none before anything else.
    pub(crate) fn alpha(
        &self,
        context: &Context,
        scene: &Scene,
        options: &SceneViewOptions,
        camera: &GpuCamera,
    ) -> Result<Option<Alpha>, GpuError> {
        if !self.is_nothing() {
            return Ok(None);
        }
        let white = Environment::from(&MappedMap::from(EnvMap::from_fn(2, 1, |_| Rgb::new(1.0, 1.0, 1.0))));
        let view = SceneView::new(context, scene, &SurfaceShading::Irradiance(1), Some(&white), options)?;
        view.set_camera(camera)?;
        Ok(Some(Alpha(view)))
    }
}

/// What hides how much of what is behind: a view of surfaces without light before an even white.
pub(crate) struct Alpha(SceneView);

impl Alpha {
    /// Moves the vertices to those of another moment.
    pub(crate) fn set_vertices(&self, scene: &Scene) -> Result<(), GpuError> {
        self.0.set_vertices(scene)
    }

    /// A picture of the same view before black, with its alpha.
    pub(crate) fn put_into(&self, picture: Picture) -> Result<Picture, GpuError> {
        self.0.render()?;
        let seen = self.0.picture()?;
        let alpha = seen.pixels().iter().map(|[white, ..]| (1.0 - white).clamp(0.0, 1.0));
        Ok(picture.with_alpha(alpha.collect())?)
    }
}

/// [`write_turntable`], with an alpha if there is one.
pub(crate) fn write_frames(
    (view, alpha): (&SceneView, Option<&Alpha>),
    light: impl Into<TurningLight>,
    options: &TurntableOptions,
    path: &Path,
    job: Job<'_>,
) -> Result<(), GpuError> {
    let Some(alpha) = alpha else { return write_turntable(view, light, options, path, job) };
    let [width, height] = [view.options().width, view.options().height].map(|side| side as usize);
    let sequence = FrameSequence { width, height, frames: options.frames, seconds_per_frame: options.seconds };
    sequence.write(path, |add| {
        let frame = |_, picture: Picture, tone: &Tone| Ok(add(&alpha.put_into(picture)?, tone)?);
        render_turntable(view, light, options, frame, job)
    })
}
