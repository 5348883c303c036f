//! Motion section of the demo: objects that pass through each other's light, by shadow fields and by spheres, beside a bake of
//! each moment and the truth.

use lobe::image::{Picture, Tone, compare, error_map, write_animated_png};
use lobe::io::Job;
use lobe::prt::{BakeMode, BakeOptions, Receivers, bake};
use lobe::render::{
    Camera, DistantLight, Moment, MovingBakeOptions, MovingMethod, MovingOptions, MovingScene, MovingShading,
    PathOptions, SampleCount, SceneHit, Truth, TruthOptions, ViewOptions, light_moving_scene, render_truth,
    scene_picture,
};
use lobe::scene::built_in;
use lobe::sh::{Dir, Expansion as _, Rgb, ShVec};
use lobe::shadow::FieldOptions;

use super::transfer::covered;
use super::{Sky, Writer, digits};

/// Number of bands of light, transfer, fields and spheres.
const ORDER: usize = 4;

/// Cells along each side of the ground.
const CELLS: usize = 48;

/// Seconds at which pictures are compared with the truth: in a quarter, in the middle and near the end of the motion.
const TIMES: [f64; 3] = [1.0, 2.1, 3.4];

/// Pictures of the whole motion.
const FRAMES: usize = 40;

/// Directions traced from each point around an object for its field: with 16 × 16 cells the error of the field is that of
/// its spacing.
const FIELD_RAYS: u32 = 256;

/// The two ways, with the names of their files and what the page calls them.
const METHODS: [(MovingMethod, &str, &str); 2] =
    [(MovingMethod::Fields, "fields", "shadow fields"), (MovingMethod::Exponentials, "spheres", "spheres")];

/// The scene with what each way needs baked, its camera and its light.
struct Stage<'a> {
    fields: MovingScene,
    spheres: MovingScene,
    camera: Camera,
    light: ShVec<Rgb<f64>>,
    transfer: BakeOptions,
    sky: &'a Sky,
    shown: Raster,
    /// Few pixels with little noise, from which figures of merit are computed: as many paths in all.
    measured: Raster,
}

/// Pixels, and paths for each of a truth.
#[derive(Clone, Copy)]
struct Raster {
    size: [usize; 2],
    paths: usize,
}

/// How many times as many pixels are shown as measured along each side.
const COARSER: usize = 4;

impl Writer<'_> {
    /// Three objects over a ground.
    pub(super) fn motion(&mut self, sky: &Sky) -> anyhow::Result<()> {
        let name = sky.bundled.name;
        self.page.section(&format!("{name}: things that move"));
        (self.progress)("moving parts");
        let stage = Stage::new(sky, self.picture)?;
        self.page.text(&format!(
            "Each object was baked alone: what it does to its own light, and what it hides of the sky around it, once as a field \
             of samples on spheres around it (order {ORDER}), once as {} spheres that stand for it. Wherever the objects move, their \
             shadows are products of the fields, or exponentials of the sum of the spheres' logarithms; nothing is traced.",
            stage.spheres.parts().iter().filter_map(|part| part.spheres.as_ref()).map(|set| set.len()).max().unwrap_or(0),
        ));
        for (method, name, caption) in METHODS {
            self.moving_picture(&stage, method, &format!("moving-{name}.png"), caption)?;
        }
        self.moments(&stage)?;
        self.page.command(&format!(
            "lobe render built-in:three-objects --env bundled:{name} --mode fields --frames 0..95 -o moving.png\n\
             lobe render built-in:three-objects --env bundled:{name} --mode shexp --time 1 -o spheres.exr\n\
             lobe render built-in:three-objects --env bundled:{name} --mode truth --time 1 -o truth.exr"
        ));
        Ok(())
    }

    /// The whole motion, as an animated picture.
    fn moving_picture(
        &mut self,
        stage: &Stage<'_>,
        method: MovingMethod,
        what: &str,
        caption: &str,
    ) -> anyhow::Result<()> {
        let shading = shading(method)?;
        let moving = stage.scene(method);
        let [begin, end] = moving.span();
        let step = (end - begin) / FRAMES as f64;
        let photograph = DistantLight::from_map(stage.sky.map.clone());
        let frame = |k: usize| stage.lit(&moving.at(begin + step * k as f64)?, &shading, &photograph, stage.shown);
        let frames = (0..FRAMES).map(frame).collect::<anyhow::Result<Vec<Picture>>>()?;
        let file = stage.sky.file(what);
        (self.progress)(&file);
        let tone = Tone::PHOTOGRAPH.fixed_for(&frames[0]);
        write_animated_png(self.folder.join(&file), &frames, &tone, step)?;
        self.page.figure(&file, stage.shown.size[0], &format!("{caption}, moving"));
        Ok(())
    }

    /// Pictures and figures of merit at some times.
    fn moments(&mut self, stage: &Stage<'_>) -> anyhow::Result<()> {
        let mut rows = Vec::new();
        let alone = stage.fields.without_occluders();
        for time in TIMES {
            (self.progress)("a moment, traced");
            let truth = stage.truth(&stage.fields.at(time)?, stage.measured)?;
            let psnr = |picture: Picture| {
                let (found, expected): (Vec<_>, Vec<_>) =
                    covered(&truth, &picture).zip(covered(&truth, &truth.mean)).unzip();
                format!("{} dB", digits(compare(&found, &expected).psnr))
            };
            let lit = |scene: &MovingScene, method| {
                stage.lit(&scene.at(time)?, &shading(method)?, &stage.distant(), stage.measured)
            };
            let pictures = [
                lit(&alone, MovingMethod::Fields)?,
                lit(&stage.spheres, MovingMethod::Exponentials)?,
                lit(&stage.fields, MovingMethod::Fields)?,
                stage.baked(&stage.fields.at(time)?, stage.measured)?,
            ];
            rows.push([format!("{time} s")].into_iter().chain(pictures.map(psnr)).collect());
        }
        self.moment_figures(stage)?;
        self.page.text(&format!(
            "The peak signal-to-noise ratio over what is seen of the scene, against {} paths for each of fewer pixels, under the same {} \
             coefficients of light: without any shadow of one object on another, by spheres, by fields, and by transfer that was baked \
             for that very moment, the best that order {ORDER} can do for a scene that stands still.",
            stage.measured.paths,
            ORDER * ORDER
        ));
        self.page.table(&["time", "no shadows", "spheres", "fields", "baked for the moment"], &rows);
        Ok(())
    }

    /// The first moment in truth, and how far each way is from it.
    fn moment_figures(&mut self, stage: &Stage<'_>) -> anyhow::Result<()> {
        let (width, time) = (stage.shown.size[0], TIMES[0]);
        let moment = stage.fields.at(time)?;
        let truth = stage.truth(&moment, stage.shown)?;
        let full_scale = 0.5 * compare(truth.mean.pixels(), truth.mean.pixels()).mean;
        let file = stage.sky.file("moment-truth.png");
        self.write(&file, &truth.mean, &Tone::PHOTOGRAPH.fixed_for(&truth.mean))?;
        self.page.figure(&file, width, &format!("the truth at {time} s"));
        let lit = |method| stage.lit(&stage.scene(method).at(time)?, &shading(method)?, &stage.distant(), stage.shown);
        for (name, picture) in [
            ("fields", lit(MovingMethod::Fields)?),
            ("spheres", lit(MovingMethod::Exponentials)?),
            ("bake", stage.baked(&moment, stage.shown)?),
        ] {
            let file = stage.sky.file(&format!("moment-{name}-difference.png"));
            self.write(&file, &error_map(&picture, &truth.mean, full_scale)?, &Tone::PLAIN)?;
            self.page.figure(&file, width, &format!("the difference of {name}, white at half of the mean"));
        }
        Ok(())
    }
}

fn shading(method: MovingMethod) -> anyhow::Result<MovingShading> {
    Ok(MovingShading::new(MovingOptions::default().order(ORDER).method(method))?)
}

impl<'a> Stage<'a> {
    /// Bakes the parts. `picture` is the width of pictures on the page.
    fn new(sky: &'a Sky, picture: usize) -> anyhow::Result<Self> {
        let bare = MovingScene::animated(built_in::three_objects(CELLS), Some(0))?;
        let transfer = BakeOptions::default().mode(BakeMode::Shadowed).order(ORDER).samples(picture as u32);
        let field = FieldOptions::default().order(ORDER).rays(FIELD_RAYS);
        let options = MovingBakeOptions::default().transfer(transfer.clone()).field(field);
        let baked = |method| -> anyhow::Result<MovingScene> {
            let mut scene = bare.clone();
            scene.bake(method, &options, Job::default())?;
            Ok(scene)
        };
        let Some(camera) = Camera::look_at([7.5, -9.0, 6.0], [0.0, 0.0, 0.9], 20_f64.to_radians()) else {
            unreachable!("the eye is not where it looks")
        };
        let shown = Raster { size: [picture * 3 / 5, picture * 2 / 5], paths: picture / 4 };
        let measured = Raster { size: shown.size.map(|n| n / COARSER), paths: shown.paths * COARSER * COARSER };
        let light = sky.radiance.resized(ORDER);
        let (fields, spheres) = (baked(MovingMethod::Fields)?, baked(MovingMethod::Exponentials)?);
        Ok(Self { fields, spheres, camera, light, transfer, sky, shown, measured })
    }

    /// The scene that is baked for a way.
    fn scene(&self, method: MovingMethod) -> &MovingScene {
        if method == MovingMethod::Fields { &self.fields } else { &self.spheres }
    }

    /// The light that the ways and the truth have, which is behind the scene too where they are compared.
    fn distant(&self) -> DistantLight {
        DistantLight::from_expansion(self.light.clone())
    }

    fn lit(
        &self,
        moment: &Moment<'_>,
        shading: &MovingShading,
        behind: &DistantLight,
        raster: Raster,
    ) -> anyhow::Result<Picture> {
        let background = |s: Dir| behind.radiance(s);
        let (camera, view) = (&self.camera, raster.view());
        let lit = light_moving_scene(moment, shading, &self.light, camera, &view, background, Job::default())?;
        Ok(lit.picture)
    }

    /// By transfer of the whole scene as it is at the moment.
    fn baked(&self, moment: &Moment<'_>, raster: Raster) -> anyhow::Result<Picture> {
        let (scene, bvh) = (moment.scene(), moment.bvh());
        let receivers = Receivers::at_vertices(scene)?;
        let (transfer, _) = bake(scene, bvh, &receivers, &self.transfer, Job::default())?;
        let lit = transfer.exit_radiance(self.light.coefficients());
        let radiance = |hit: &SceneHit<'_>| hit.at_corners(&lit);
        let (behind, view) = (self.distant(), raster.view());
        let background = |s: Dir| behind.radiance(s);
        Ok(scene_picture(scene, bvh, &self.camera, &view, background, radiance, Job::default())?)
    }

    /// Paths without reflections from surface to surface, which none of the ways has.
    fn truth(&self, moment: &Moment<'_>, raster: Raster) -> anyhow::Result<Truth> {
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
