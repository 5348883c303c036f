//! Stage of the sections of things that move: a camera and a light, and pictures of moments by what was baked and by paths.

use lobe::image::{Picture, compare};
use lobe::io::Job;
use lobe::motion::{Moment, MovingMethod, MovingOptions, MovingScene, MovingShading, light_moving_scene};
use lobe::prt::{BakeMode, BakeOptions, Receivers, Transfer, bake};
use lobe::render::{Camera, DistantLight, RenderError, Truth};
use lobe::sh::{Rgb, ShVec};

use super::look::{Look, Raster, camera, covered, decibels};
use crate::error::{Drawn, GalleryError};
use crate::page::{Canvas, Sky};

/// Number of bands of light, transfer, fields and spheres.
pub(crate) const ORDER: usize = 4;

/// A camera and its light.
pub(crate) struct Stage<'a> {
    camera: Camera,
    light: ShVec<Rgb<f64>>,
    pub(crate) transfer: BakeOptions,
    sky: &'a Sky,
    pub(crate) shown: Raster,
    /// Few pixels with little noise, from which figures of merit are computed: as many paths in all.
    pub(crate) measured: Raster,
}

/// How many times as many pixels are shown as measured along each side.
const COARSER: usize = 4;

/// As many rays as are as good as the paths.
fn raster(size: [usize; 2], paths: usize) -> Raster {
    Raster { size, paths, rays: (paths as f64).sqrt() as usize / 4 }
}

impl<'a> Stage<'a> {
    /// `picture` is the width of pictures on the page; the camera sees an angle of `fov` degrees.
    pub(crate) fn new(sky: &'a Sky, picture: usize, eye: [f64; 3], target: [f64; 3], fov: f64) -> Self {
        let transfer = BakeOptions::default().mode(BakeMode::Shadowed).order(ORDER).samples(picture as u32);
        let shown = raster([picture * 3 / 5, picture * 2 / 5], picture / 4);
        let measured = raster(shown.size.map(|n| n / COARSER), shown.paths * COARSER * COARSER);
        let (camera, light) = (camera(eye, target, fov), sky.radiance.resized(ORDER));
        Self { camera, light, transfer, sky, shown, measured }
    }

    /// The light that the ways and the truth have, which is behind the scene too where they are compared.
    fn distant(&self) -> DistantLight {
        DistantLight::from_expansion(self.light.clone())
    }

    fn look<'b>(&'b self, moment: &'b Moment<'_>, raster: Raster) -> Look<'b> {
        Look { scene: moment.scene(), bvh: moment.bvh(), camera: &self.camera, raster }
    }

    /// A moment by what was baked for a method.
    pub(crate) fn lit(
        &self,
        moment: &Moment<'_>,
        method: MovingMethod,
        raster: Raster,
    ) -> Result<Picture, RenderError> {
        self.lit_before(moment, method, &self.distant(), raster)
    }

    fn lit_before(
        &self,
        moment: &Moment<'_>,
        method: MovingMethod,
        behind: &DistantLight,
        raster: Raster,
    ) -> Result<Picture, RenderError> {
        let shading = MovingShading::new(MovingOptions::default().order(ORDER).method(method))?;
        let (camera, view) = (&self.camera, raster.view());
        let background = |s| behind.seen(s);
        let lit = light_moving_scene(
            moment,
            &shading,
            &self.light.clone().into(),
            camera,
            &view,
            background,
            Job::default(),
        )?;
        Ok(lit.picture)
    }

    /// Transfer of the whole scene as it is at a moment.
    pub(crate) fn baked_at(&self, moment: &Moment<'_>) -> Result<Transfer, GalleryError> {
        let receivers = Receivers::at_vertices(moment.scene())?;
        Ok(bake(moment.scene(), moment.bvh(), &receivers, &self.transfer, Job::default())?.0)
    }

    /// A moment by transfer of all its vertices, of whatever moment that is.
    pub(crate) fn lit_by(
        &self,
        transfer: &Transfer,
        moment: &Moment<'_>,
        raster: Raster,
    ) -> Result<Picture, RenderError> {
        let behind = self.distant();
        self.look(moment, raster).lit(transfer, &self.light, |s| behind.seen(s))
    }

    /// Paths without reflections from surface to surface, which none of the ways has.
    pub(crate) fn truth(&self, moment: &Moment<'_>, raster: Raster) -> Result<Truth, RenderError> {
        self.look(moment, raster).truth(&self.distant(), 0)
    }

    /// So many pictures of the whole motion, as an animated one, before the photograph.
    pub(crate) fn animate(
        &self,
        canvas: &mut Canvas<'_>,
        (moving, method): (&MovingScene, MovingMethod),
        frames: usize,
        (what, caption): (&str, &str),
    ) -> Drawn {
        let [begin, end] = moving.span();
        let step = (end - begin) / frames as f64;
        let photograph = DistantLight::from_map(self.sky.map.clone());
        let frame = |k: usize| self.lit_before(&moving.at(begin + step * k as f64)?, method, &photograph, self.shown);
        let frames = (0..frames).map(frame).collect::<Result<Vec<Picture>, RenderError>>()?;
        canvas.animation(&self.sky.file(what), &frames, step, &format!("{caption}, moving"))
    }
}

/// A row of a table: the time, and of each picture the peak signal-to-noise ratio over what is seen of the scene.
pub(crate) fn merits(time: f64, truth: &Truth, pictures: &[Picture]) -> Vec<String> {
    let psnr = |picture: &Picture| {
        let (found, expected): (Vec<_>, Vec<_>) = covered(truth, picture).zip(covered(truth, &truth.mean)).unzip();
        decibels(compare(&found, &expected).psnr)
    };
    [format!("{time} s")].into_iter().chain(pictures.iter().map(psnr)).collect()
}

/// The most spheres that stand for a part.
pub(crate) fn most_spheres(scene: &MovingScene) -> usize {
    let sets = scene.parts().iter().filter_map(|part| part.spheres.as_ref());
    sets.map(|set| set.len()).max().unwrap_or(0)
}
