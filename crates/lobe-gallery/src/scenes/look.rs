//! A camera's look at a scene: by transfer of its vertices, by paths of light, and the difference.

use lobe::image::{Picture, Pixel, Tone, compare, error_map};
use lobe::io::Job;
use lobe::prt::Transfer;
use lobe::render::{
    Camera, DistantLight, PathOptions, RenderError, SampleCount, SceneHit, Truth, TruthOptions, ViewOptions,
    render_truth, scene_picture,
};
use lobe::scene::{Bvh, Scene};
use lobe::sh::{Dir, Expansion as _, Rgb, ShVec};

use crate::error::Drawn;
use crate::page::{Canvas, digits};

/// Pixels, and what is spent for each.
#[derive(Clone, Copy)]
pub(crate) struct Raster {
    /// Columns and rows.
    pub(crate) size: [usize; 2],
    /// Rays along each side of a pixel.
    pub(crate) rays: usize,
    /// Paths of a truth.
    pub(crate) paths: usize,
}

impl Raster {
    pub(crate) fn view(self) -> ViewOptions {
        let [width, height] = self.size;
        ViewOptions::default().width(width).height(height).rays(self.rays)
    }
}

/// A scene at a moment, and who looks at it.
pub(crate) struct Look<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) bvh: &'a Bvh,
    pub(crate) camera: &'a Camera,
    pub(crate) raster: Raster,
}

impl Look<'_> {
    /// The scene by transfer of its vertices, and something behind.
    pub(crate) fn lit(
        &self,
        transfer: &Transfer,
        light: &ShVec<Rgb<f64>>,
        behind: impl Fn(Dir) -> Rgb<f64> + Sync,
    ) -> Result<Picture, RenderError> {
        let lit = transfer.exit_radiance(light.coefficients());
        let radiance = |hit: &SceneHit<'_>| hit.at_corners(&lit);
        scene_picture(self.scene, self.bvh, self.camera, &self.raster.view(), behind, radiance, Job::default())
    }

    /// The scene by paths of so many reflections before that to the eye.
    pub(crate) fn truth(&self, light: &DistantLight, bounces: usize) -> Result<Truth, RenderError> {
        let Raster { size: [width, height], paths, .. } = self.raster;
        let options = TruthOptions::default().width(width).height(height);
        let options = options.count(SampleCount::of(paths)).paths(PathOptions::default().bounces(bounces));
        render_truth(self.scene, self.bvh, self.camera, light, &options, Job::default())
    }
}

/// The camera at `eye`, from which an angle of `fov` degrees is seen.
pub(crate) fn camera(eye: [f64; 3], target: [f64; 3], fov: f64) -> Camera {
    let camera = Camera::look_at(eye, target, fov.to_radians());
    camera.unwrap_or_else(|| unreachable!("the eye is not where it looks"))
}

/// The pixels of a picture where a truth shows nothing but surfaces.
pub(crate) fn covered<'a>(truth: &'a Truth, picture: &'a Picture) -> impl Iterator<Item = Pixel> + 'a {
    truth.coverage.iter().zip(picture.pixels()).filter(|(coverage, _)| **coverage == 1.0).map(|(_, pixel)| *pixel)
}

/// A peak signal-to-noise ratio in words.
pub(crate) fn decibels(psnr: f64) -> String {
    format!("{} dB", digits(psnr))
}

/// A figure of the difference, white at half of the mean.
pub(crate) fn difference(canvas: &mut Canvas<'_>, file: &str, pair: (&Picture, &Picture), caption: &str) -> Drawn {
    let (claim, truth) = pair;
    let full_scale = 0.5 * compare(claim.pixels(), truth.pixels()).mean;
    let map = error_map(claim, truth, full_scale)?;
    canvas.figure(file, (&map, &Tone::PLAIN), truth.width(), caption)
}
