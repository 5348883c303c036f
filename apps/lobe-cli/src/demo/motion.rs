//! Motion section of the demo: objects that pass through each other's light, by shadow fields and by spheres, beside a bake of
//! each moment and the truth.

use lobe::image::{Tone, compare, error_map};
use lobe::io::Job;
use lobe::render::{MovingBakeOptions, MovingMethod, MovingScene};
use lobe::scene::built_in;
use lobe::shadow::FieldOptions;

use super::stage::{ORDER, Stage, psnr, shading};
use super::{Sky, Writer};

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

/// The scene with what each way needs baked.
struct Objects<'a> {
    stage: Stage<'a>,
    fields: MovingScene,
    spheres: MovingScene,
}

impl Writer<'_> {
    /// Three objects over a ground.
    pub(super) fn motion(&mut self, sky: &Sky) -> anyhow::Result<()> {
        let name = sky.bundled.name;
        self.page.section(&format!("{name}: things that move"));
        (self.progress)("moving parts");
        let objects = Objects::new(sky, self.picture)?;
        self.page.text(&format!(
            "Each object was baked alone: what it does to its own light, and what it hides of the sky around it, once as a field \
             of samples on spheres around it (order {ORDER}), once as {} spheres that stand for it. Wherever the objects move, their \
             shadows are products of the fields, or exponentials of the sum of the spheres' logarithms; nothing is traced.",
            objects.spheres.parts().iter().filter_map(|part| part.spheres.as_ref()).map(|set| set.len()).max().unwrap_or(0),
        ));
        for (method, name, caption) in METHODS {
            let what = format!("moving-{name}.png");
            self.moving_picture(&objects.stage, (objects.scene(method), method), FRAMES, (&what, caption))?;
        }
        self.moments(&objects)?;
        self.page.command(&format!(
            "lobe render moving built-in:three-objects --env bundled:{name} --frames 0..95 -o moving.png\n\
             lobe render moving built-in:three-objects --env bundled:{name} --method exponentials --time 1 -o spheres.exr\n\
             lobe render trace built-in:three-objects --env bundled:{name} --time 1 -o truth.exr"
        ));
        Ok(())
    }

    /// Pictures and figures of merit at some times.
    fn moments(&mut self, objects: &Objects<'_>) -> anyhow::Result<()> {
        let mut rows = Vec::new();
        let Objects { stage, fields, spheres } = objects;
        let (alone, measured) = (fields.without_occluders(), stage.measured);
        for time in TIMES {
            (self.progress)("a moment, traced");
            let moment = fields.at(time)?;
            let truth = stage.truth(&moment, measured)?;
            let lit = |scene: &MovingScene, method| {
                stage.lit(&scene.at(time)?, &shading(method)?, &stage.distant(), measured)
            };
            let pictures = [
                lit(&alone, MovingMethod::Fields)?,
                lit(spheres, MovingMethod::Exponentials)?,
                lit(fields, MovingMethod::Fields)?,
                stage.lit_by(&stage.baked_at(&moment)?, &moment, measured)?,
            ];
            rows.push([format!("{time} s")].into_iter().chain(pictures.map(|lit| psnr(&truth, &lit))).collect());
        }
        self.moment_figures(objects)?;
        self.page.text(&format!(
            "The peak signal-to-noise ratio over what is seen of the scene, against {} paths for each of fewer pixels, under the same {} \
             coefficients of light: without any shadow of one object on another, by spheres, by fields, and by transfer that was baked \
             for that very moment, the best that order {ORDER} can do for a scene that stands still.",
            measured.paths,
            ORDER * ORDER
        ));
        self.page.table(&["time", "no shadows", "spheres", "fields", "baked for the moment"], &rows);
        Ok(())
    }

    /// The first moment in truth, and how far each way is from it.
    fn moment_figures(&mut self, objects: &Objects<'_>) -> anyhow::Result<()> {
        let stage = &objects.stage;
        let (width, time) = (stage.shown.size[0], TIMES[0]);
        let moment = objects.fields.at(time)?;
        let truth = stage.truth(&moment, stage.shown)?;
        let full_scale = 0.5 * compare(truth.mean.pixels(), truth.mean.pixels()).mean;
        let file = stage.sky.file("moment-truth.png");
        self.write(&file, &truth.mean, &Tone::PHOTOGRAPH.fixed_for(&truth.mean))?;
        self.page.figure(&file, width, &format!("the truth at {time} s"));
        let lit =
            |method| stage.lit(&objects.scene(method).at(time)?, &shading(method)?, &stage.distant(), stage.shown);
        for (name, picture) in [
            ("fields", lit(MovingMethod::Fields)?),
            ("spheres", lit(MovingMethod::Exponentials)?),
            ("bake", stage.lit_by(&stage.baked_at(&moment)?, &moment, stage.shown)?),
        ] {
            let file = stage.sky.file(&format!("moment-{name}-difference.png"));
            self.write(&file, &error_map(&picture, &truth.mean, full_scale)?, &Tone::PLAIN)?;
            self.page.figure(&file, width, &format!("the difference of {name}, white at half of the mean"));
        }
        Ok(())
    }
}

impl<'a> Objects<'a> {
    /// Bakes the parts. `picture` is the width of pictures on the page.
    fn new(sky: &'a Sky, picture: usize) -> anyhow::Result<Self> {
        let stage = Stage::new(sky, picture, [7.5, -9.0, 6.0], [0.0, 0.0, 0.9], 20.0);
        let bare = MovingScene::animated(built_in::three_objects(CELLS), Some(0))?;
        let field = FieldOptions::default().order(ORDER).rays(FIELD_RAYS);
        let options = MovingBakeOptions::default().transfer(stage.transfer.clone()).field(field);
        let baked = |method| -> anyhow::Result<MovingScene> {
            let mut scene = bare.clone();
            scene.bake(method, &options, Job::default())?;
            Ok(scene)
        };
        let (fields, spheres) = (baked(MovingMethod::Fields)?, baked(MovingMethod::Exponentials)?);
        Ok(Self { stage, fields, spheres })
    }

    /// The scene that is baked for a way.
    fn scene(&self, method: MovingMethod) -> &MovingScene {
        if method == MovingMethod::Fields { &self.fields } else { &self.spheres }
    }
}
