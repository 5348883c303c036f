//! Section about objects that pass through each other's light, by shadow fields and by spheres, beside a bake of each moment
//! and the truth.

use lobe::image::Tone;
use lobe::io::Job;
use lobe::motion::{MovingBakeOptions, MovingMethod, MovingScene};
use lobe::scene::built_in;
use lobe::shadow::FieldOptions;

use super::look::difference;
use super::stage::{ORDER, Stage, merits, most_spheres};
use crate::error::{Drawn, GalleryError};
use crate::page::{Canvas, Sky};

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

/// Three objects over a ground.
pub(crate) fn motion(canvas: &mut Canvas<'_>, sky: &Sky) -> Drawn {
    let name = sky.bundled.name;
    canvas.step()?;
    let objects = Objects::new(sky, canvas.size.picture)?;
    canvas.text(&format!(
        "Each object was baked alone: what it does to its own light, and what it hides of the sky around it, once as a field \
         of samples on spheres around it (order {ORDER}), once as {} spheres that stand for it. Wherever the objects move, their \
         shadows are products of the fields, or exponentials of the sum of the spheres' logarithms; nothing is traced.",
        most_spheres(&objects.spheres),
    ));
    for (method, name, caption) in METHODS {
        let what = format!("moving-{name}.png");
        objects.stage.animate(canvas, (objects.scene(method), method), FRAMES, (&what, caption))?;
    }
    moments(canvas, sky, &objects)?;
    canvas.command(&format!(
        "lobe render moving built-in:three-objects --env bundled:{name} --frames 0..95 -o moving.png\n\
         lobe render moving built-in:three-objects --env bundled:{name} --method exponentials --time 1 -o spheres.exr\n\
         lobe render trace built-in:three-objects --env bundled:{name} --time 1 -o truth.exr"
    ));
    Ok(())
}

/// Pictures and figures of merit at some times.
fn moments(canvas: &mut Canvas<'_>, sky: &Sky, objects: &Objects<'_>) -> Drawn {
    let mut rows = Vec::new();
    let Objects { stage, fields, spheres } = objects;
    let (alone, measured) = (fields.without_occluders(), stage.measured);
    for time in TIMES {
        canvas.step()?;
        let moment = fields.at(time)?;
        let lit = |scene: &MovingScene, method| stage.lit(&scene.at(time)?, method, measured);
        let pictures = [
            lit(&alone, MovingMethod::Fields)?,
            lit(spheres, MovingMethod::Exponentials)?,
            lit(fields, MovingMethod::Fields)?,
            stage.lit_by(&stage.baked_at(&moment)?, &moment, measured)?,
        ];
        rows.push(merits(time, &stage.truth(&moment, measured)?, &pictures));
    }
    figures(canvas, sky, objects)?;
    canvas.text(&format!(
        "The peak signal-to-noise ratio over what is seen of the scene, against {} paths for each of fewer pixels, under the same {} \
         coefficients of light: without any shadow of one object on another, by spheres, by fields, and by transfer that was baked \
         for that very moment, the best that order {ORDER} can do for a scene that stands still.",
        measured.paths,
        ORDER * ORDER
    ));
    canvas.table(&["time", "no shadows", "spheres", "fields", "baked for the moment"], &rows);
    Ok(())
}

/// The first moment in truth, and how far each way is from it.
fn figures(canvas: &mut Canvas<'_>, sky: &Sky, objects: &Objects<'_>) -> Drawn {
    let stage = &objects.stage;
    let time = TIMES[0];
    let moment = objects.fields.at(time)?;
    let truth = stage.truth(&moment, stage.shown)?.mean;
    let drawn = (&truth, &Tone::PHOTOGRAPH.fixed_for(&truth));
    canvas.figure(&sky.file("moment-truth.png"), drawn, truth.width(), &format!("the truth at {time} s"))?;
    let lit = |method| stage.lit(&objects.scene(method).at(time)?, method, stage.shown);
    for (name, picture) in [
        ("fields", lit(MovingMethod::Fields)?),
        ("spheres", lit(MovingMethod::Exponentials)?),
        ("bake", stage.lit_by(&stage.baked_at(&moment)?, &moment, stage.shown)?),
    ] {
        let file = sky.file(&format!("moment-{name}-difference.png"));
        let caption = format!("the difference of {name}, white at half of the mean");
        difference(canvas, &file, (&picture, &truth), &caption)?;
    }
    Ok(())
}

impl<'a> Objects<'a> {
    /// Bakes the parts. `picture` is the width of pictures on the page.
    fn new(sky: &'a Sky, picture: usize) -> Result<Self, GalleryError> {
        let stage = Stage::new(sky, picture, [7.5, -9.0, 6.0], [0.0, 0.0, 0.9], 20.0);
        let bare = MovingScene::animated(built_in::three_objects(CELLS), Some(0))?;
        let field = FieldOptions::default().order(ORDER).rays(FIELD_RAYS);
        let options = MovingBakeOptions::default().transfer(stage.transfer.clone()).field(field);
        let baked = |method| -> Result<MovingScene, GalleryError> {
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
