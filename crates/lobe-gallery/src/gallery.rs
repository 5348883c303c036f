//! The page: the table of its sections, and how they are written one after the other.

use std::fs;
use std::path::{Path, PathBuf};

use lobe::env::bundled;
use lobe::io::Job;

use crate::error::{Drawn, GalleryError};
use crate::functions::{basis, lights, ringing, skies, windows};
use crate::page::{Canvas, Size, Sky, State};
use crate::photographs::{
    encodings, environment, environment_mapping, extraction, irradiance, mappings, projection, reconstruction,
    rotation, sun,
};
use crate::scenes::hall::Hall;
use crate::scenes::{motion, transfer, transfer_ringing, walking};

const PAGE: &str = "index.html";

const TITLE: &str = "Lobe: light as functions on the sphere";

const INTRODUCTION: &str = "\
A photograph of everything around a point, turned into a handful of numbers that light a scene. Every \
picture here was made by this program from the photographs it carries; the numbers beside them are measured, \
not quoted. Each section ends with the command that does the same to a photograph of yours.";

/// The pieces of work that the page is made of: files, tables, and what is baked.
const STEPS: usize = 156;

/// The photographs that a section is about.
#[derive(Clone, Copy)]
enum Of {
    /// Each.
    Every,
    /// That of this number alone.
    Only(usize),
}

impl Of {
    fn has(self, number: usize) -> bool {
        match self {
            Self::Every => true,
            Self::Only(wanted) => wanted == number,
        }
    }
}

/// The function that draws a section.
#[derive(Clone, Copy)]
enum Draw {
    /// Of a photograph.
    Photograph(fn(&mut Canvas<'_>, &Sky) -> Drawn),
    /// Of the hall, which is baked once, under a photograph.
    Hall(fn(&mut Canvas<'_>, &Sky, &Hall) -> Drawn),
    /// Of neither.
    Alone(DrawAlone),
}

type DrawAlone = fn(&mut Canvas<'_>) -> Drawn;

/// The sections about photographs in their order, which all have before the next photograph comes: for which, the
/// heading and the function that draws. `NAME` and `TITLE` in a heading are the photograph's.
const OF_PHOTOGRAPHS: [(Of, &str, Draw); 17] = {
    use Draw::{Alone, Hall, Photograph};
    use Of::{Every, Only};
    [
        (Every, "A photograph: TITLE", Photograph(environment::environment)),
        (Every, "NAME: what n² numbers remember", Photograph(reconstruction::reconstruction)),
        (Every, "NAME: nine numbers light a ball", Photograph(irradiance::irradiance)),
        (Every, "NAME: fewer numbers than nine a channel", Photograph(encodings::encodings)),
        (Every, "NAME: three lights, two, one", Photograph(extraction::extraction)),
        (Only(1), "A sun that lights its dark side with less than nothing", Alone(ringing::sun_alone)),
        (Only(1), "NAME: irradiance below zero, and how it is removed", Photograph(ringing::irradiance_of_sky)),
        (Only(1), "NAME: the price for radiance", Photograph(ringing::radiance_of_sky)),
        (Only(1), "NAME: light that rings in the hall", Hall(transfer_ringing::transfer_ringing)),
        (Only(0), "NAME: the sky turns, the numbers turn with it", Photograph(rotation::rotation)),
        (Only(0), "NAME: summing beats sampling", Photograph(projection::projection)),
        (Only(0), "Eight ways to lay the sphere out", Photograph(mappings::mappings)),
        (Only(0), "NAME: the sun as a light of its own", Photograph(sun::sun)),
        (Only(0), "NAME: a scene that knows what it does to light", Hall(transfer::transfer)),
        (Only(0), "NAME: things that move", Photograph(motion::motion)),
        (Only(0), "NAME: a figure that walks", Photograph(walking::walking)),
        (
            Every,
            "NAME: environment mapping, every technique beside the truth",
            Photograph(environment_mapping::environment_mapping),
        ),
    ]
};

/// The sections about no photograph: the heading and the function that draws.
const OTHERS: [(&str, DrawAlone); 12] = [
    ("Skies without a photograph", skies::skies),
    ("When is a light a point?", skies::area_lights),
    ("The functions themselves", basis::basis),
    ("What a surface sees, in three and in five bands", lights::kernels),
    ("Discs of light, hard and soft", lights::cones),
    ("A sky and a ground", lights::skies_of_formulas),
    ("A window from the integrals along its edges", lights::window_of_a_room),
    ("Windows: less ringing for more blur", windows::windows),
    ("Windows: half the curvature", windows::laplacians),
    ("Windows: none towards the light", windows::content_window),
    ("Windows: the table for irradiance", windows::table_windows),
    ("Windows: point lights before they are added", windows::punctual_light),
];

/// The path of the page that [`write_gallery`] writes into a folder.
#[must_use]
pub fn page_in(folder: &Path) -> PathBuf {
    folder.join(PAGE)
}

/// Writes all sections into `folder`, which is made if need be; returns the path of the page.
///
/// The page is written after every section, and says of itself whether it is complete. Progress counts pictures and tables, between
/// which the job is stopped. It cannot be resumed.
///
/// # Errors
/// [`GalleryError::Io`] or [`GalleryError::Image`] for a file that cannot be written; [`GalleryError::Cancelled`] if the
/// callback cancelled it, [`GalleryError::Options`] for a job with a checkpoint.
pub fn write_gallery(folder: &Path, size: Size, job: Job<'_>) -> Result<PathBuf, GalleryError> {
    job.expect_no_checkpoint().map_err(GalleryError::Options)?;
    fs::create_dir_all(folder).map_err(GalleryError::io(folder))?;
    let index = page_in(folder);
    lobe::io::check_writable(&index).map_err(GalleryError::io(&index))?;
    lobe::io::remove_abandoned(&index);
    let mut canvas = Canvas::new(index.clone(), size, job, STEPS);
    canvas.title(TITLE);
    canvas.text(INTRODUCTION);
    let mut hall = None;
    for (number, bundled) in bundled::all().into_iter().enumerate() {
        let sky = Sky::new(bundled);
        for (_, heading, draw) in OF_PHOTOGRAPHS.iter().filter(|(of, ..)| of.has(number)) {
            canvas.section(&heading.replace("NAME", sky.bundled.name).replace("TITLE", sky.bundled.title));
            match draw {
                Draw::Photograph(draw) => draw(&mut canvas, &sky)?,
                Draw::Hall(draw) => {
                    let hall = match &mut hall {
                        Some(hall) => hall,
                        none => {
                            canvas.step()?;
                            none.insert(Hall::new(size.picture)?)
                        }
                    };
                    draw(&mut canvas, &sky, hall)?;
                }
                Draw::Alone(draw) => draw(&mut canvas)?,
            }
            canvas.publish(State::Growing)?;
        }
    }
    for (heading, draw) in OTHERS {
        canvas.section(heading);
        draw(&mut canvas)?;
        canvas.publish(State::Growing)?;
    }
    canvas.publish(State::Complete)?;
    canvas.finish();
    Ok(index)
}
