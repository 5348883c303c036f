//! `lobe demo`: everything that Lobe does, on built-in data, as one folder with a page.
//!
//! Read `overview` and `page` first, then any chapter: each draws its pictures and writes its part of the page. Uses `args`, `run` and `sh`.

mod basis;
mod encodings;
mod environment;
mod environment_mapping;
mod extraction;
mod irradiance;
mod lights;
mod mappings;
mod motion;
mod overview;
mod page;
mod projection;
mod reconstruction;
mod ringing;
mod rotation;
mod skies;
mod stage;
mod transfer;
mod transfer_ringing;
mod walking;
mod windows;

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use clap::Args;
use lobe::env::bundled::{self, Bundled};
use lobe::env::{EnvMap, project_env};
use lobe::image::{Exposure, ImageError, Picture, Tone};
use lobe::io::write_atomically;
use lobe::sh::{Dir, Expansion as _, Quantity, Rgb, ShFile, ShVec, optimal_linear_direction, write_sh_json};

use crate::args::output;
use crate::run::talk::Talk;
use page::{Page, State};

const PAGE: &str = "index.html";

const TITLE: &str = "Lobe: light as functions on the sphere";

/// The highest order of the sweep over orders, that of the figures in the papers.
const SWEEP: usize = 6;

/// The color around the balls: black stays black at any exposure.
const BACKDROP: Rgb<f32> = Rgb::new(0.0, 0.0, 0.0);

/// The display value of the mean radiance of a photograph beside its reconstructions, which are smooth: brighter
/// than middle gray, so that what is darker than the mean can be told apart.
const MEAN_KEY: f64 = 0.3;

/// The steps of the progress bar: files, tables and the page.
const STEPS: u64 = 157;

#[derive(Args)]
pub(crate) struct Demo {
    /// The folder to write into; it is made if need be
    #[arg(short, long, value_name = "DIR", default_value = "demo")]
    output: PathBuf,
    /// Draw small pictures: half the width
    #[arg(long)]
    quick: bool,
    /// Draw large pictures and trace more paths for the truth: three times the time
    #[arg(long, conflicts_with = "quick")]
    full: bool,
}

/// The size of pictures, which the number of paths and of rays follows.
#[derive(Clone, Copy)]
struct Detail {
    /// Pixels across a ball.
    ball: usize,
    /// Pixels across a lat-long picture.
    picture: usize,
}

impl Detail {
    const QUICK: Self = Self { ball: 80, picture: 256 };
    const USUAL: Self = Self { ball: 120, picture: 384 };
    const FULL: Self = Self { ball: 160, picture: 512 };
}

/// The data that the figures of one photograph share.
struct Sky {
    bundled: Bundled,
    map: EnvMap,
    /// The radiance at order [`SWEEP`].
    radiance: ShVec<Rgb<f64>>,
    /// Exposure for the photograph and its reconstructions: by the mean, which they share.
    tone: Tone,
}

/// The demo as it is being written.
struct Writer<'a> {
    folder: &'a Path,
    /// Pixels across a ball.
    ball: usize,
    /// Pixels across a lat-long picture.
    picture: usize,
    /// The path of the page.
    index: PathBuf,
    /// Called with the name of every piece of work that begins.
    progress: &'a mut dyn FnMut(&str),
    page: Page,
}

impl Demo {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        let page = self.output.join(PAGE);
        talk.note("demo", &format!("{} shows each section as soon as it is there", page.display()));
        let bar = talk.bar("demo", STEPS);
        let mut progress = |_: &str| bar.inc(1);
        let detail = match (self.quick, self.full) {
            (true, _) => Detail::QUICK,
            (_, true) => Detail::FULL,
            _ => Detail::USUAL,
        };
        let index = write_demo(&self.output, detail, &mut progress)?;
        bar.finish_and_clear();
        output::print(&format!("{}\n", index.display()))
    }
}

/// Writes the demo into `folder`, which is made if need be.
///
/// Returns the path of the page. It is written after every section, and says of itself whether it is complete.
fn write_demo(folder: &Path, detail: Detail, progress: &mut dyn FnMut(&str)) -> anyhow::Result<PathBuf> {
    fs::create_dir_all(folder).map_err(|source| io_error(folder, source))?;
    let index = folder.join(PAGE);
    output::prepare_file(&index, output::NO_INPUTS)?;
    let Detail { ball, picture } = detail;
    let mut demo = Writer { folder, ball, picture, index, progress, page: Page::new(TITLE) };
    demo.page.text(
        "A photograph of everything around a point, turned into a handful of numbers that light a scene. Every \
         picture here was made by this program from the photographs it carries; the numbers beside them are measured, \
         not quoted. Each section ends with the command that does the same to a photograph of yours.",
    );
    let mut hall = None;
    for (number, bundled) in bundled::all().into_iter().enumerate() {
        let sky = Sky::new(bundled);
        demo.environment(&sky)?;
        demo.write_expansion(&sky)?;
        demo.reconstruction(&sky)?;
        demo.publish(State::Growing)?;
        let balls = demo.irradiance(&sky)?;
        demo.overview(&sky, &balls)?;
        demo.publish(State::Growing)?;
        demo.encodings(&sky)?;
        demo.extraction(&sky)?;
        demo.publish(State::Growing)?;
        if number == 1 {
            demo.ringing(&sky)?;
        }
        if let Some(hall) = &hall {
            demo.transfer_that_rings(&sky, hall)?;
        }
        if number == 0 {
            demo.rotation(&sky)?;
            demo.projection(&sky);
            demo.mappings(&sky)?;
            demo.sun(&sky)?;
            demo.publish(State::Growing)?;
            hall = Some(demo.transfer(&sky)?);
            demo.publish(State::Growing)?;
            demo.motion(&sky)?;
            demo.publish(State::Growing)?;
            demo.walking(&sky)?;
        }
        demo.publish(State::Growing)?;
        demo.environment_mapping(&sky)?;
        demo.publish(State::Growing)?;
    }
    demo.skies()?;
    demo.area_lights()?;
    demo.basis()?;
    demo.lights()?;
    demo.windows()?;
    demo.publish(State::Complete)?;
    (demo.progress)(PAGE);
    Ok(demo.index)
}

impl Sky {
    fn new(bundled: Bundled) -> Self {
        let map = bundled.map();
        let radiance = project_env(&map, SWEEP);
        let exposure = Exposure::Fixed(MEAN_KEY / radiance.mean().luminance());
        let tone = Tone { exposure, ..Tone::PHOTOGRAPH };
        Self { bundled, map, radiance, tone }
    }

    /// The name of a file about this photograph.
    fn file(&self, what: &str) -> String {
        format!("{}-{what}", self.bundled.name)
    }

    /// The direction that the light comes from on the whole; +z if there is none.
    fn main_direction(&self) -> Dir {
        optimal_linear_direction(&self.radiance).unwrap_or(Dir::Z)
    }
}

fn io_error(path: &Path, source: io::Error) -> ImageError {
    ImageError::Io { place: path.display().to_string(), source }
}

impl Writer<'_> {
    /// Writes the page as far as it is.
    fn publish(&self, state: State) -> anyhow::Result<()> {
        let html = self.page.html(TITLE, state);
        write_atomically(&self.index, |file| file.write_all(html.as_bytes()))
            .map_err(|source| io_error(&self.index, source))?;
        Ok(())
    }

    fn write(&mut self, file: &str, picture: &Picture, tone: &Tone) -> anyhow::Result<()> {
        (self.progress)(file);
        picture.write_png(self.folder.join(file), tone)?;
        Ok(())
    }

    /// Writes a figure of lines.
    fn write_svg(&mut self, file: &str, svg: &str) -> anyhow::Result<()> {
        (self.progress)(file);
        let path = self.folder.join(file);
        write_atomically(&path, |out| out.write_all(svg.as_bytes())).map_err(|source| io_error(&path, source))?;
        Ok(())
    }

    /// Writes the expansion that the figures show, for the reader's own use.
    fn write_expansion(&mut self, sky: &Sky) -> anyhow::Result<()> {
        let file = format!("{}.sh.json", sky.bundled.name);
        (self.progress)(&file);
        write_sh_json(self.folder.join(file), &ShFile::new(Quantity::Radiance, sky.radiance.clone()))?;
        Ok(())
    }
}

/// All values of an expansion at the texel centers of the map.
fn values_like(f: &ShVec<Rgb<f64>>, map: &EnvMap) -> Vec<Rgb<f32>> {
    lobe::env::reconstruct(f, map.width(), map.height()).texels().to_vec()
}

/// A number in three significant digits.
fn digits(x: f64) -> String {
    match x.abs() {
        0.0 => "0".into(),
        size if !(1e-3..1e5).contains(&size) => format!("{x:.2e}"),
        size => format!("{x:.*}", (2 - size.log10().floor() as i32).max(0) as usize),
    }
}

/// The energy of an expansion over all bands and channels, `∫ f² ds`.
fn energy(f: &ShVec<Rgb<f64>>) -> f64 {
    let e = f.dot(f);
    e.r + e.g + e.b
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits() {
        let cases = [
            (0.0, "0"),
            (1.0, "1.00"),
            (-12.345, "-12.3"),
            (9876.5, "9876"),
            (0.00012345, "1.23e-4"),
            (0.0456, "0.0456"),
        ];
        for (x, expected) in cases {
            assert_eq!(digits(x), expected, "{x}");
        }
    }

    #[test]
    fn the_demo_writes_every_file_that_its_page_shows() {
        let folder = tempfile::tempdir().unwrap();
        let small = Detail { ball: 16, picture: 64 };
        let mut steps = 0;
        let index = write_demo(folder.path(), small, &mut |_| steps += 1).unwrap();
        assert_eq!(steps, STEPS, "the steps of the progress bar");
        let html = fs::read_to_string(index).unwrap();
        assert!(!html.contains("http-equiv"), "a complete page does not ask to be loaded again");
        let shown: Vec<&str> = html.split("<img src=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
        assert!(shown.len() > 20, "{} figures: {shown:?}", shown.len());
        for file in shown {
            let bytes = fs::read(folder.path().join(file)).unwrap();
            if file.ends_with(".svg") {
                assert!(bytes.starts_with(b"<svg ") && bytes.ends_with(b"</svg>\n"), "{file}");
                assert!(!String::from_utf8(bytes).unwrap().contains("NaN"), "{file}");
            } else {
                assert_eq!(&bytes[1..4], b"PNG", "{file}");
            }
        }
    }
}
