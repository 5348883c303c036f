//! Section about a baked hall under a turning sky, beside path-traced references.

use lobe::image::{Picture, Tone};
use lobe::render::Truth;

use super::hall::{BOUNCES, Hall, TURNS, about_z, calmed};
use super::look::{decibels, difference};
use crate::error::{Drawn, GalleryError};
use crate::page::{Canvas, SWEEP, Sky};

/// The order of the pictures.
const SHOWN: usize = 4;

/// Pictures of a full turn of the sky, shown in two seconds.
const FRAMES: usize = 24;
const SECONDS_PER_FRAME: f64 = 1.0 / 12.0;

/// A hall under a sky that turns.
pub(crate) fn transfer(canvas: &mut Canvas<'_>, sky: &Sky, hall: &Hall) -> Drawn {
    let name = sky.bundled.name;
    canvas.text(&format!(
        "Transfer was baked at the {} vertices of a built-in hall by {} rays: shadows and {BOUNCES} reflections of light from surface \
         to surface are in it. Turning the sky costs no more than {} products for each vertex and color. Beside it the \
         truth, traced by {} paths for each pixel under the photograph itself.",
        hall.report.receivers,
        hall.report.rays,
        SHOWN * SHOWN,
        hall.raster.paths
    ));
    let truths = stills(canvas, sky, hall)?;
    turning(canvas, sky, hall)?;
    table(canvas, sky, hall, &truths)?;
    canvas.command(&format!(
        "lobe bake built-in:columns -o hall.glb\n\
         lobe render hall.glb --env bundled:{name} --frames 24 -o hall.png\n\
         lobe render trace hall.glb --env bundled:{name} --samples 256 -o truth.exr"
    ));
    Ok(())
}

/// Transfer, truth and difference for each turn; the truths.
fn stills(canvas: &mut Canvas<'_>, sky: &Sky, hall: &Hall) -> Result<Vec<Truth>, GalleryError> {
    let mut truths = Vec::new();
    let mut tone = None;
    for degrees in TURNS {
        let turn = about_z(degrees);
        let truth = hall.truth(sky, &turn)?;
        let tone: &Tone = tone.get_or_insert_with(|| Tone::PHOTOGRAPH.fixed_for(&truth.mean));
        let claim = hall.picture(sky, &turn, &sky.radiance.resized(SHOWN))?;
        let file = |what: &str| sky.file(&format!("hall-{degrees}-{what}.png"));
        let caption = format!("turned by {degrees}°: transfer of order {SHOWN}");
        canvas.figure(&file("transfer"), (&claim, tone), claim.width(), &caption)?;
        canvas.figure(&file("truth"), (&truth.mean, tone), claim.width(), "the truth: paths of light")?;
        let caption = "the difference, white at half of the mean";
        difference(canvas, &file("difference"), (&claim, &truth.mean), caption)?;
        truths.push(truth);
    }
    Ok(truths)
}

/// The sky turns once around.
fn turning(canvas: &mut Canvas<'_>, sky: &Sky, hall: &Hall) -> Drawn {
    let light = sky.radiance.resized(SHOWN);
    let frame = |k: usize| hall.picture(sky, &about_z(360.0 * k as f64 / FRAMES as f64), &light);
    let frames = (0..FRAMES).map(frame).collect::<Result<Vec<Picture>, _>>()?;
    let caption = "the sky turns, by transfer alone";
    canvas.animation(&sky.file("hall-turning.png"), &frames, SECONDS_PER_FRAME, caption)
}

/// The PSNR of each order, with and without a window.
fn table(canvas: &mut Canvas<'_>, sky: &Sky, hall: &Hall, truths: &[Truth]) -> Drawn {
    canvas.step()?;
    let mut rows = Vec::new();
    let (mut last, mut rings) = (f64::NEG_INFINITY, false);
    for order in 1..=SWEEP {
        let radiance = sky.radiance.resized(order);
        let [plain, calm] = [&radiance, &calmed(&radiance)].map(|light| hall.psnr(light, truths));
        let note = if plain < last { "rings: less than the order before" } else { "" };
        rings |= plain < last;
        last = plain;
        rows.push(vec![order.to_string(), decibels(plain), decibels(calm), note.to_owned()]);
    }
    let why = if rings {
        "Where a higher order comes out lower, it rings: what is cut off a sun swings below zero, and between two orders the \
         trough changes places with the crest. The window calms it and blurs the light."
    } else {
        "Each order comes nearer; a window, which this light does not need, costs sharpness."
    };
    canvas.text(&format!(
        "The peak signal-to-noise ratio over what is seen of the hall, under the three skies together, by the order of light and \
         transfer, plain and with a window (Hanning, zero one band above the order). {why}"
    ));
    canvas.table(&["order", "PSNR", "windowed", ""], &rows);
    Ok(())
}
