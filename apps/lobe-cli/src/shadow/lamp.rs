//! `lobe lamp`: the light of a lamp at every point around it, for shadows of what moves before it.

use std::path::PathBuf;

use anyhow::{Context, bail};
use clap::{Args, ValueEnum};
use lobe::image::{Picture, PictureReadOptions, read_picture};
use lobe::io::Job;
use lobe::sh::Rgb;
use lobe::shadow::{Lamp, LampSequence, PatchField, RadianceField, RadianceOptions, Rectangle, write_lamp};
use serde::Serialize;

use crate::args::input::{NonfiniteOption, tell};
use crate::args::map_input::max_texels;
use crate::args::output;
use crate::args::values;
use crate::run::talk::Talk;
use crate::shadow::field;

/// The most patches along each side of a rectangle.
const MAX_PATCHES: usize = 64;

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
    /// Number of bands, 1 to 8
    #[arg(long, value_name = "N", default_value = "4", value_parser = field::order)]
    order: usize,
    /// Concentric spheres of sample points around a rectangle, 2 or more [default: 16]
    #[arg(long, value_name = "N", value_parser = field::spheres)]
    spheres: Option<usize>,
    /// Cells along each side of the octahedral grid of sample points on a sphere, an even number [default: 16]
    #[arg(long, value_name = "N", value_parser = field::cells)]
    cells: Option<usize>,
    /// The innermost and the outermost sphere, in half diagonals of the rectangle [default: 0.25,8]
    #[arg(long, value_name = "INNER,OUTER", value_parser = field::range)]
    range: Option<[f64; 2]>,
    #[command(flatten)]
    nonfinite: NonfiniteOption,
    /// The most pixels of a picture; a larger one is refused
    #[arg(long, value_name = "N", default_value_t = PictureReadOptions::default().max_texels, value_parser = max_texels)]
    max_texels: usize,
    /// Print {"order", "patches", "pictures", "bytes"} on stdout
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
}

impl LampCommand {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        output::check_safetensors(&self.output)?;
        let inputs: Vec<_> = self.pictures.iter().map(PathBuf::as_path).collect();
        output::prepare_file(&self.output, &inputs)?;
        self.check()?;
        let (lamp, bytes) = match self.shape {
            Shape::Sphere => self.sphere()?,
            Shape::Rectangle => self.rectangle(talk)?,
        };
        write_lamp(&self.output, &lamp)?;
        let patches = match &lamp {
            Lamp::Sequence(sequence) => sequence.patches().patches(),
            Lamp::Still(_) => [1, 1],
        };
        let printed = Printed { order: self.order, patches, pictures: self.pictures.len(), bytes };
        if self.json { output::print_json(&printed) } else { output::print(&format!("bytes  {bytes}\n")) }
    }

    /// Refuses options of the other shape, and those that say nothing.
    fn check(&self) -> anyhow::Result<()> {
        let of_rectangles = [
            ("--size", self.size.is_some()),
            ("--pictures", !self.pictures.is_empty()),
            ("--patches", self.patches.is_some()),
            ("--fps", self.fps.is_some()),
            ("--two-sided", self.two_sided),
            ("--spheres", self.spheres.is_some()),
            ("--cells", self.cells.is_some()),
            ("--range", self.range.is_some()),
        ];
        if self.shape == Shape::Sphere
            && let Some((option, _)) = of_rectangles.iter().find(|(_, given)| *given)
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

    fn sphere(&self) -> anyhow::Result<(Lamp, usize)> {
        let radius = self.radius.context("a sphere has a --radius")?;
        Ok((Lamp::Still(RadianceField::ball(self.order, [0.0; 3], radius, self.radiance())?), 0))
    }

    fn rectangle(&self, talk: Talk) -> anyhow::Result<(Lamp, usize)> {
        let [width, height] = self.size.context("a rectangle has a --size: give it as --size W,H")?;
        // The first row is on top; pixels are mirrored, as `u × v` of rows to the right would point away from who looks.
        let rectangle = Rectangle::upright([width, height], self.two_sided);
        let patches = if self.pictures.is_empty() { [1, 1] } else { self.patches.unwrap_or([8, 8]) };
        let field = PatchField::bake(&rectangle, patches, &self.options(), Job::default())?;
        if self.pictures.is_empty() {
            let still = field.with_colors(&[self.radiance()])?;
            let bytes = still.bytes();
            return Ok((Lamp::Still(still), bytes));
        }
        let mut pictures = Vec::new();
        let options = PictureReadOptions::default().nonfinite((&self.nonfinite).into()).max_texels(self.max_texels);
        for path in &self.pictures {
            let (picture, report) = read_picture(path, &options)?;
            tell(&report, &path.display().to_string(), talk);
            pictures.push(self.colors(&field, &picture)?);
        }
        if let [one] = &*pictures {
            let still = field.with_colors(one)?;
            let bytes = still.bytes();
            return Ok((Lamp::Still(still), bytes));
        }
        let narrow = |c: Rgb<f64>| Rgb::from(c.to_array().map(|c| c as f32));
        let pictures = pictures.into_iter().map(|colors| colors.into_iter().map(narrow).collect()).collect();
        let bytes = field.bytes();
        Ok((Lamp::Sequence(LampSequence::new(field, pictures, self.fps.unwrap_or(24.0))?), bytes))
    }

    /// The radiance of the patches under a picture.
    fn colors(&self, field: &PatchField, picture: &Picture) -> anyhow::Result<Vec<Rgb<f64>>> {
        let rows = picture.pixels().chunks_exact(picture.width().max(1));
        let mirrored: Vec<Rgb<f32>> = rows.flat_map(|row| row.iter().rev().map(|pixel| Rgb::from(*pixel))).collect();
        let [r, g, b] = self.radiance().to_array();
        let colors = field.patch_colors(picture.width(), &mirrored)?;
        Ok(colors.into_iter().map(|c| Rgb::new(c.r * r, c.g * g, c.b * b)).collect())
    }

    fn options(&self) -> RadianceOptions {
        let defaults = RadianceOptions::default();
        let [inner, outer] = self.range.unwrap_or([defaults.inner, defaults.outer]);
        defaults
            .clone()
            .order(self.order)
            .spheres(self.spheres.unwrap_or(defaults.spheres))
            .cells(self.cells.unwrap_or(defaults.cells))
            .inner(inner)
            .outer(outer)
    }
}
