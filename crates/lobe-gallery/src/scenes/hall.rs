//! A hall of columns, baked, with its camera.

use lobe::image::{Picture, Pixel, compare};
use lobe::io::Job;
use lobe::prt::{BakeMode, BakeOptions, BakeReport, Receivers, Transfer, bake};
use lobe::render::{Camera, DistantLight, RenderError, Truth};
use lobe::scene::{Bvh, Scene, built_in};
use lobe::sh::{Coefficient as _, Dir, Expansion as _, Rgb, Rotation, ShVec, Window};

use super::look::{Look, Raster, camera, covered};
use crate::error::GalleryError;
use crate::page::{SWEEP, Sky};

/// Cells to the meter: shadows of columns need them.
const DETAIL: usize = 3;

/// Bounces before the reflection to the eye.
pub(crate) const BOUNCES: usize = 2;

/// Turns of the sky that are shown beside the truth, in degrees.
pub(crate) const TURNS: [f64; 3] = [0.0, 120.0, 240.0];

/// Rays for a pixel and axis.
const RAYS: usize = 2;

/// The baked hall and its camera.
pub(crate) struct Hall {
    scene: Scene,
    bvh: Bvh,
    camera: Camera,
    transfer: Transfer,
    pub(crate) raster: Raster,
    pub(crate) report: BakeReport,
}

impl Hall {
    /// Bakes it. `picture` is the width of pictures on the page.
    pub(crate) fn new(picture: usize) -> Result<Self, GalleryError> {
        let scene = built_in::columns_hall(DETAIL);
        let bvh = Bvh::new(&scene);
        let receivers = Receivers::at_vertices(&scene)?;
        // Bake as many bounces as the page says, whatever energy they carry.
        let options = BakeOptions::default()
            .mode(BakeMode::Interreflected)
            .order(SWEEP)
            .samples(picture as u32)
            .bounces(BOUNCES)
            .energy_stop(0.0);
        let (transfer, report) = bake(&scene, &bvh, &receivers, &options, Job::default())?;
        let camera = camera([10.0, -11.0, 4.5], [0.0, 0.0, 1.6], 18.0);
        let raster = Raster { size: [picture * 3 / 5, picture * 2 / 5], rays: RAYS, paths: picture / 8 };
        Ok(Self { scene, bvh, camera, transfer, raster, report })
    }

    fn look(&self) -> Look<'_> {
        let Self { scene, bvh, camera, raster, .. } = self;
        Look { scene, bvh, camera, raster: *raster }
    }

    /// The hall under the turned light, the turned photograph behind it.
    pub(crate) fn picture(&self, sky: &Sky, turn: &Rotation, light: &ShVec<Rgb<f64>>) -> Result<Picture, RenderError> {
        let behind = DistantLight::from_map(sky.map.clone()).turned(turn);
        self.look().lit(&self.transfer, &light.rotated(turn), |s| behind.seen(s))
    }

    pub(crate) fn truth(&self, sky: &Sky, turn: &Rotation) -> Result<Truth, RenderError> {
        self.look().truth(&DistantLight::from_map(sky.map.clone()).turned(turn), BOUNCES)
    }

    /// The peak signal-to-noise ratio over what is seen of the hall, under as many turns as there are truths.
    pub(crate) fn psnr(&self, light: &ShVec<Rgb<f64>>, truths: &[Truth]) -> f64 {
        let (mut found, mut expected) = (Vec::new(), Vec::new());
        for (degrees, truth) in TURNS.into_iter().zip(truths) {
            found.extend(self.seen(light, degrees, truth));
            expected.extend(covered(truth, &truth.mean));
        }
        compare(&found, &expected).psnr
    }

    /// All pixels that show nothing but the hall.
    pub(crate) fn seen(&self, light: &ShVec<Rgb<f64>>, degrees: f64, truth: &Truth) -> Vec<Pixel> {
        let Ok(picture) = self.look().lit(&self.transfer, &light.rotated(&about_z(degrees)), |_| Rgb::ZERO) else {
            unreachable!("the picture has pixels and rays, and nobody stops it")
        };
        covered(truth, &picture).collect()
    }
}

/// Light under the window that the sections about the hall have.
pub(crate) fn calmed(light: &ShVec<Rgb<f64>>) -> ShVec<Rgb<f64>> {
    light.windowed(&Window::Hanning { width: (light.order() + 1) as f64 })
}

pub(crate) fn about_z(degrees: f64) -> Rotation {
    Rotation::from_axis_angle(Dir::Z, degrees.to_radians())
}
