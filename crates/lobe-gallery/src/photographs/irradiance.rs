//! Section about a ball lit by spherical harmonics and by brute force.

use lobe::env::{irradiance_at, irradiance_map_brute_force};
use lobe::image::{Picture, Tone, color_bar, compare, error_map};
use lobe::io::Job;
use lobe::sh::{Dir, Rgb, Zonal};

use super::overview::overview;
use crate::error::{Drawn, GalleryError};
use crate::page::{BACKDROP, Canvas, SWEEP, Size, Sky, ball_from, digits, percent, values_like};

/// The order that irradiance is usually stored at: nine coefficients.
const USUAL: usize = 3;

/// Rows of the grid of normals over which errors are measured.
const GRID: usize = 48;

/// A white ball under a photograph.
pub(crate) struct Balls {
    /// Lit by nine coefficients.
    claim: Picture,
    /// Lit by every texel.
    truth: Picture,
    /// As colors.
    difference: Picture,
    /// The difference that has the last color.
    full_scale: f64,
    tone: Tone,
}

impl Balls {
    pub(crate) fn new(sky: &Sky, size: Size) -> Result<Self, GalleryError> {
        let irradiance = sky.radiance.resized(USUAL).convolved(&Zonal::clamped_cosine(USUAL));
        // The lit and the dark side, a little from above.
        let ball = ball_from(size.ball, sky.beside_the_light(75.0, 60.0));
        let normals: Vec<Dir> = ball.normals().into_iter().map(|(_, n)| n).collect();
        let truth = ball.lit_by_values(BACKDROP, &irradiance_at(&sky.map, &normals));
        let claim = ball.lit_by_sh(BACKDROP, &irradiance);
        let full_scale = compare(claim.pixels(), truth.pixels()).max_abs;
        let difference = error_map(&claim, &truth, full_scale)?;
        Ok(Self { tone: Tone::OBJECT.fixed_for(&truth), claim, truth, difference, full_scale })
    }

    /// In the colors that are shown: claim, truth and difference.
    pub(crate) fn shown(&self) -> [Picture; 3] {
        [self.tone.apply(&self.claim), self.tone.apply(&self.truth), self.difference.clone()]
    }
}

/// The section, and the [`overview`] with the same balls.
pub(crate) fn irradiance(canvas: &mut Canvas<'_>, sky: &Sky) -> Drawn {
    let name = sky.bundled.name;
    canvas.text(
        "A white Lambertian ball leaves E(n)/π. On the left E comes from nine coefficients a channel, in the middle \
         from a sum over every texel of the photograph for every pixel of the ball; on the right their difference.",
    );
    let balls = Balls::new(sky, canvas.size)?;
    let Balls { claim, truth, difference, full_scale, tone } = &balls;
    let width = canvas.size.ball * 4 / 3;
    canvas.figure(&sky.file("ball-sh.png"), (claim, tone), width, "order 3, 9 coefficients")?;
    let caption = format!("brute force, {} texels", sky.map.texels().len());
    canvas.figure(&sky.file("ball-truth.png"), (truth, tone), width, &caption)?;
    let caption = "difference of the radiance they leave, and its scale";
    canvas.figure(&sky.file("ball-error.png"), (&with_bar(difference, *full_scale), &Tone::PLAIN), width, caption)?;
    table(canvas, sky)?;
    canvas.command(&format!(
        "lobe env irradiance bundled:{name} --order 3 -o {name}-irradiance.exr\n\
         lobe env irradiance bundled:{name} --method brute-force -o {name}-truth.exr"
    ));
    canvas.hidden_figure(&sky.file("overview.png"), (&overview(sky, canvas.size, &balls.shown()), &Tone::PLAIN))
}

fn table(canvas: &mut Canvas<'_>, sky: &Sky) -> Drawn {
    canvas.step()?;
    let truth = irradiance_map_brute_force(&sky.map, 2 * GRID, GRID, Job::default())?;
    let peak = truth.texels().iter().flat_map(|c| c.to_array()).fold(0.0, f32::max);
    let rows: Vec<Vec<String>> = (1..=SWEEP)
        .map(|order| {
            let e = sky.radiance.resized(order).convolved(&Zonal::clamped_cosine(order));
            let values = values_like(&e, &truth);
            let report = compare(&values, truth.texels());
            let lowest = values.iter().flat_map(|c| c.to_array()).fold(f32::INFINITY, f32::min);
            vec![
                order.to_string(),
                (order * order).to_string(),
                percent(report.relative_rmse),
                percent(report.max_abs / f64::from(peak)),
                digits(f64::from(lowest)),
            ]
        })
        .collect();
    let head = ["order", "coefficients", "RMS error / mean", "largest error / peak", "lowest irradiance"];
    canvas.table(&head, &rows);
    canvas.text(
        "Measured towards all normals, not only those that the picture shows. Order 4 equals order 3 because the clamped \
         cosine has no band 3. A lowest irradiance below zero is ringing.",
    );
    Ok(())
}

/// An error map with the scale of its colors below.
fn with_bar(map: &Picture, full_scale: f64) -> Picture {
    let height = map.height() / 7;
    let white = Rgb::new(1.0, 1.0, 1.0);
    let mut picture = Picture::filled(map.width(), map.height() + height, BACKDROP);
    picture.paste(map, 0, 0);
    picture.paste(&color_bar(map.width(), height, full_scale, white, BACKDROP), 0, map.height() as isize);
    picture
}
