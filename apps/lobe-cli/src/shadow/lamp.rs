//! `lobe lamp`: the light of a lamp at every point around it, for shadows of what moves before it.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::{Args, ValueEnum};
use lobe::image::{PictureReadOptions, read_picture};
use lobe::io::{JobArgs, JobFiles, MemoryLimit, WorkOptions, flag};
use lobe::sh::Rgb;
use lobe::shadow::{
    FieldSampling, Lamp, LampSequence, PatchField, RadianceField, Rectangle, StorageOptions, StorageReport, write_lamp,
};
use serde::Serialize;

use crate::args::input::{NonfiniteOption, tell};
use crate::args::map_input::max_texels;
use crate::args::output;
use crate::args::values;
use crate::run::bake_watch::{tell_if_too_late, watched_bake};
use crate::run::option_names::in_flags;
use crate::run::talk::Talk;

/// The most patches along each side of a rectangle.
const MAX_PATCHES: usize = 64;

#[expect(clippy::doc_markdown, reason = "the keys of the JSON are shown on a terminal")]
#[derive(Args)]
pub(crate) struct LampCommand {
    /// Its shape: a sphere around the origin, or a rectangle in the plane z = 0 around it that shines towards +z
    #[arg(value_enum)]
    shape: Shape,
    /// The lamp, a .safetensors file
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// The radius of a sphere
    #[arg(long, value_name = "R", value_parser = values::positive)]
    radius: Option<f64>,
    /// Width (along x) and height (along y) of a rectangle
    #[arg(long, value_name = "W,H", value_parser = size)]
    size: Option<[f64; 2]>,
    /// The radiance; pictures are multiplied by it [default: 1,1,1]
    #[arg(long, value_name = "R,G,B", value_parser = values::color)]
    radiance: Option<Rgb<f64>>,
    /// What a rectangle shows to one who looks at it with x to the right and y up; several follow each other
    #[arg(long, value_name = "FILE", num_args = 1..)]
    pictures: Vec<PathBuf>,
    /// Patches of one radiance along the width and the height of a picture [default: 8,8]
    #[arg(long, value_name = "N,M", value_parser = patches)]
    patches: Option<[usize; 2]>,
    /// Pictures in a second [default: 24]
    #[arg(long, value_name = "F", value_parser = values::positive)]
    fps: Option<f64>,
    /// The back of a rectangle shines alike
    #[arg(long)]
    two_sided: bool,
    #[command(flatten)]
    sampling: JobArgs<FieldSampling>,
    #[command(flatten)]
    storage: JobArgs<StorageOptions>,
    #[command(flatten)]
    work: JobArgs<WorkOptions>,
    #[command(flatten)]
    nonfinite: NonfiniteOption,
    /// The most pixels of a picture; a larger one is refused
    #[arg(long, value_name = "N", default_value_t = PictureReadOptions::default().max_texels, value_parser = max_texels)]
    max_texels: usize,
    /// Print {"order", "patches", "pictures", "bytes", "relative_error"} on stdout
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Shape {
    Sphere,
    Rectangle,
}

fn size(text: &str) -> Result<[f64; 2], String> {
    match values::numbers::<2>(text)? {
        [width, height] if width > 0.0 && height > 0.0 => Ok([width, height]),
        [width, height] => Err(format!("expected a width and a height above 0, found {width},{height}")),
    }
}

fn patches(text: &str) -> Result<[usize; 2], String> {
    let Some((columns, rows)) = text.split_once(',') else {
        return Err(format!("expected two numbers with a comma between them, such as 8,8; found {text:?}"));
    };
    let one = |text: &str| values::whole(text.trim(), 1, MAX_PATCHES, "a number of patches");
    Ok([one(columns)?, one(rows)?])
}

/// The JSON of `--json`.
#[derive(Serialize)]
struct Printed {
    order: usize,
    patches: [usize; 2],
    pictures: usize,
    bytes: usize,
    relative_error: f64,
}

impl LampCommand {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        output::check_safetensors(&self.output)?;
        let inputs: Vec<_> = self.pictures.iter().map(PathBuf::as_path).collect();
        output::prepare_file(&self.output, &inputs)?;
        self.check()?;
        let (sampling, storage, work) = (self.sampling.job()?, self.storage.job()?, self.work.job()?);
        let checkpoint = JobFiles::beside(self.output.clone());
        if work.fresh {
            checkpoint.discard()?;
        }
        let lamp = match self.shape {
            Shape::Sphere => self.sphere(&sampling)?,
            Shape::Rectangle => self.rectangle(&sampling, (&checkpoint, work.memory()), talk)?,
        };
        let report = write_lamp(&self.output, &lamp, &storage.form())?;
        if let Some(text) = storage.remark(&report) {
            talk.note(&self.output.display().to_string(), &in_flags(&text));
        }
        let StorageReport { bytes, relative_error, .. } = report;
        checkpoint.finish();
        tell_if_too_late(&self.output, talk);
        let (patches, pictures) = (self.patches_of_pictures(), self.pictures.len());
        let printed = Printed { order: sampling.order, patches, pictures, bytes, relative_error };
        if self.json {
            return output::print_json(&printed);
        }
        output::print(&format!("bytes           {bytes}\nrelative error  {relative_error:.3e} of storage\n"))
    }

    /// Refuses options of the other shape, and those that say nothing.
    fn check(&self) -> anyhow::Result<()> {
        let of_rectangles = [
            ("--size", self.size.is_some()),
            ("--pictures", !self.pictures.is_empty()),
            ("--patches", self.patches.is_some()),
            ("--fps", self.fps.is_some()),
            ("--two-sided", self.two_sided),
        ];
        let given = of_rectangles.iter().find(|(_, is_given)| *is_given).map(|(option, _)| (*option).to_owned());
        let of_points = FieldSampling::OF_POINTS.into_iter().find(|name| self.sampling.values.contains_key(*name));
        let of_tables = of_points.or(self.storage.values.keys().map(String::as_str).next()).map(flag);
        if self.shape == Shape::Sphere
            && let Some(option) = given.or(of_tables)
        {
            bail!("{option}: only of a rectangle");
        }
        if self.shape == Shape::Rectangle && self.radius.is_some() {
            bail!("--radius: only of a sphere");
        }
        if self.pictures.is_empty() && self.patches.is_some() {
            bail!("--patches: only with --pictures");
        }
        if self.pictures.len() < 2 && self.fps.is_some() {
            bail!("--fps: only with several --pictures");
        }
        Ok(())
    }

    fn radiance(&self) -> Rgb<f64> {
        self.radiance.unwrap_or(Rgb::new(1.0, 1.0, 1.0))
    }

    /// Patches of one radiance along the width and the height: one in all where there is no picture.
    fn patches_of_pictures(&self) -> [usize; 2] {
        if self.pictures.is_empty() { [1, 1] } else { self.patches.unwrap_or([8, 8]) }
    }

    fn sphere(&self, sampling: &FieldSampling) -> anyhow::Result<Lamp> {
        let radius = self.radius.context("a sphere has a --radius")?;
        Ok(Lamp::Still(RadianceField::ball(sampling.order, [0.0; 3], radius, self.radiance())?))
    }

    fn rectangle(
        &self,
        sampling: &FieldSampling,
        (checkpoint, memory): (&JobFiles, MemoryLimit),
        talk: Talk,
    ) -> anyhow::Result<Lamp> {
        let [width, height] = self.size.context("a rectangle has a --size: give it as --size W,H")?;
        // The first row is on top; pixels are mirrored, as `u × v` of rows to the right would point away from who looks.
        let rectangle = Rectangle::upright([width, height], self.two_sided);
        let (patches, options) = (self.patches_of_pictures(), sampling.of_lamp());
        // Rows are held as those of a field.
        let [columns, rows] = patches;
        let what = format!("a lamp of {columns} x {rows} patches at order {}", options.order);
        let bytes = sampling.bytes().saturating_mul((columns * rows) as u64);
        memory.check(&what, bytes, "fewer --patches, --spheres or --cells")?;
        // A picture that is refused is so before the bake.
        let pictures = self.pictures.iter().map(|path| self.colors(path, patches, memory, talk));
        let pictures = pictures.collect::<anyhow::Result<Vec<_>>>()?;
        let field = watched_bake(checkpoint, talk, |job| PatchField::bake(&rectangle, patches, &options, job))?;
        Ok(match &*pictures {
            [] => Lamp::Still(field.with_colors(&[self.radiance()])?),
            [one] => Lamp::Still(field.with_colors(one)?),
            _ => {
                let narrow = |c: &Rgb<f64>| Rgb::from(c.to_array().map(|c| c as f32));
                let pictures = pictures.iter().map(|colors| colors.iter().map(narrow).collect()).collect();
                Lamp::Sequence(LampSequence::new(field, pictures, self.fps.unwrap_or(24.0))?)
            }
        })
    }

    /// The radiance of the patches under a picture.
    fn colors(
        &self,
        path: &Path,
        patches: [usize; 2],
        memory: MemoryLimit,
        talk: Talk,
    ) -> anyhow::Result<Vec<Rgb<f64>>> {
        let options = PictureReadOptions::default().nonfinite((&self.nonfinite).into()).max_texels(self.max_texels);
        let options = options.max_bytes(memory.bytes());
        let (picture, report) = read_picture(path, &options)?;
        tell(&report, &path.display().to_string(), talk);
        let rows = picture.pixels().chunks_exact(picture.width().max(1));
        let mirrored: Vec<Rgb<f32>> = rows.flat_map(|row| row.iter().rev().map(|pixel| Rgb::from(*pixel))).collect();
        let [r, g, b] = self.radiance().to_array();
        let colors = PatchField::colors_of_patches(patches, picture.width(), &mirrored)?;
        Ok(colors.into_iter().map(|c| Rgb::new(c.r * r, c.g * g, c.b * b)).collect())
    }
}
