//! Stage of the sections of things that move: a camera and a light, and pictures of moments by what was baked and by paths.

use lobe::image::{Picture, Tone, compare, write_animated_png};
use lobe::io::Job;
use lobe::prt::{BakeMode, BakeOptions, Receivers, Transfer, bake};
use lobe::render::{
    Camera, DistantLight, Moment, MovingMethod, MovingOptions, MovingScene, MovingShading, PathOptions, SampleCount,
    SceneHit, Truth, TruthOptions, ViewOptions, light_moving_scene, render_truth, scene_picture,
};
use lobe::sh::{Dir, Expansion as _, Rgb, ShVec};

use super::transfer::covered;
use super::{Sky, Writer, digits};

/// Number of bands of light, transfer, fields and spheres.
pub(super) const ORDER: usize = 4;

/// A camera and its light.
pub(super) struct Stage<'a> {
    pub(super) camera: Camera,
    pub(super) light: ShVec<Rgb<f64>>,
    pub(super) transfer: BakeOptions,
    pub(super) sky: &'a Sky,
    pub(super) shown: Raster,
    /// Few pixels with little noise, from which figures of merit are computed: as many paths in all.
    pub(super) measured: Raster,
}

/// Pixels, and paths for each of a truth.
#[derive(Clone, Copy)]
pub(super) struct Raster {
    pub(super) size: [usize; 2],
    pub(super) paths: usize,
}

/// How many times as many pixels are shown as measured along each side.
const COARSER: usize = 4;

impl<'a> Stage<'a> {
    /// `picture` is the width of pictures on the page; the camera sees an angle of `fov` degrees.
    pub(super) fn new(sky: &'a Sky, picture: usize, eye: [f64; 3], target: [f64; 3], fov: f64) -> Self {
        let Some(camera) = Camera::look_at(eye, target, fov.to_radians()) else {
            unreachable!("the eye is not where it looks")
        };
        let transfer = BakeOptions::default().mode(BakeMode::Shadowed).order(ORDER).samples(picture as u32);
        let shown = Raster { size: [picture * 3 / 5, picture * 2 / 5], paths: picture / 4 };
        let measured = Raster { size: shown.size.map(|n| n / COARSER), paths: shown.paths * COARSER * COARSER };
        Self { camera, light: sky.radiance.resized(ORDER), transfer, sky, shown, measured }
    }

    /// The light that the ways and the truth have, which is behind the scene too where they are compared.
    pub(super) fn distant(&self) -> DistantLight {
        DistantLight::from_expansion(self.light.clone())
    }

    pub(super) fn lit(
        &self,
        moment: &Moment<'_>,
        shading: &MovingShading,
        behind: &DistantLight,
        raster: Raster,
    ) -> anyhow::Result<Picture> {
        let background = |s: Dir| behind.seen(s);
        let (camera, view) = (&self.camera, raster.view());
        let lit = light_moving_scene(moment, shading, &self.light, camera, &view, background, Job::default())?;
        Ok(lit.picture)
    }

    /// Transfer of the whole scene as it is at a moment.
    pub(super) fn baked_at(&self, moment: &Moment<'_>) -> anyhow::Result<Transfer> {
        let receivers = Receivers::at_vertices(moment.scene())?;
        Ok(bake(moment.scene(), moment.bvh(), &receivers, &self.transfer, Job::default())?.0)
    }

    /// A moment by transfer of all its vertices, of whatever moment that is.
    pub(super) fn lit_by(&self, transfer: &Transfer, moment: &Moment<'_>, raster: Raster) -> anyhow::Result<Picture> {
        let lit = transfer.exit_radiance(self.light.coefficients());
        let radiance = |hit: &SceneHit<'_>| hit.at_corners(&lit);
        let (behind, view) = (self.distant(), raster.view());
        let background = |s: Dir| behind.seen(s);
        Ok(scene_picture(moment.scene(), moment.bvh(), &self.camera, &view, background, radiance, Job::default())?)
    }

    /// Paths without reflections from surface to surface, which none of the ways has.
    pub(super) fn truth(&self, moment: &Moment<'_>, raster: Raster) -> anyhow::Result<Truth> {
        let light = self.distant();
        let [width, height] = raster.size;
        let paths = PathOptions::default().bounces(0);
        let options =
            TruthOptions::default().width(width).height(height).count(SampleCount::of(raster.paths)).paths(paths);
        Ok(render_truth(moment.scene(), moment.bvh(), &self.camera, &light, &options, Job::default())?)
    }
}

impl Raster {
    /// Rays along each side of a pixel: as good as the paths are.
    fn view(self) -> ViewOptions {
        let [width, height] = self.size;
        ViewOptions::default().width(width).height(height).rays((self.paths as f64).sqrt() as usize / 4)
    }
}

pub(super) fn shading(method: MovingMethod) -> anyhow::Result<MovingShading> {
    Ok(MovingShading::new(MovingOptions::default().order(ORDER).method(method))?)
}

/// The peak signal-to-noise ratio over what is seen of the scene.
pub(super) fn psnr(truth: &Truth, picture: &Picture) -> String {
    let (found, expected): (Vec<_>, Vec<_>) = covered(truth, picture).zip(covered(truth, &truth.mean)).unzip();
    format!("{} dB", digits(compare(&found, &expected).psnr))
}

impl Writer<'_> {
    /// So many pictures of the whole motion, as an animated one.
    pub(super) fn moving_picture(
        &mut self,
        stage: &Stage<'_>,
        (moving, method): (&MovingScene, MovingMethod),
        frames: usize,
        (what, caption): (&str, &str),
    ) -> anyhow::Result<()> {
        let shading = shading(method)?;
        let [begin, end] = moving.span();
        let step = (end - begin) / frames as f64;
        let photograph = DistantLight::from_map(stage.sky.map.clone());
        let frame = |k: usize| stage.lit(&moving.at(begin + step * k as f64)?, &shading, &photograph, stage.shown);
        let frames = (0..frames).map(frame).collect::<anyhow::Result<Vec<Picture>>>()?;
        let file = stage.sky.file(what);
        (self.progress)(&file);
        let tone = Tone::PHOTOGRAPH.fixed_for(&frames[0]);
        write_animated_png(self.folder.join(&file), &frames, &tone, step)?;
        self.page.figure(&file, stage.shown.size[0], &format!("{caption}, moving"));
        Ok(())
    }
}
