//! Section about irradiance in nine to twenty-seven numbers, each encoding on a ball of its own.

use std::f64::consts::PI;

use lobe::env::{EncodingErrors, encoding_errors, irradiance_at, irradiance_to_encode};
use lobe::image::{Tone, error_map};
use lobe::io::Job;
use lobe::sh::encoding::{EncodingError, IrradianceEncoding, Zh3Axis};
use lobe::sh::rotation::tangent_frame;
use lobe::sh::{Dir, Rgb};

use crate::error::Drawn;
use crate::page::{BACKDROP, Canvas, Sky, ball_from, digits, percent, sheet};

/// Encodings that have a ball; the table has all.
const SHOWN: [IrradianceEncoding; 11] = [
    IrradianceEncoding::Sh2,
    IrradianceEncoding::Sh3,
    IrradianceEncoding::NonLinearL1,
    IrradianceEncoding::Zh3Hallucinated(Zh3Axis::Luminance),
    IrradianceEncoding::Zh3Projected(Zh3Axis::Luminance),
    IrradianceEncoding::Zh3Solved(Zh3Axis::Luminance),
    IrradianceEncoding::AmbientCubeFitted,
    IrradianceEncoding::AhdSolved,
    IrradianceEncoding::HBasis4,
    IrradianceEncoding::HBasis6,
    IrradianceEncoding::Hl2,
];

/// The error that is white on the error maps, as a share of the mean radiance of the ball.
const FULL_SCALE: f64 = 0.5;

pub(crate) fn encodings(canvas: &mut Canvas<'_>, sky: &Sky) -> Drawn {
    canvas.text(&format!(
        "The same ball lit by small encodings of the irradiance, beside each its error: black for none, white for {} % \
         of the mean and more, on one scale for all. The last three serve the normals on one side of a surface only: here the \
         side that the picture shows.",
        digits(100.0 * FULL_SCALE)
    ));
    canvas.step()?;
    let measured = encoding_errors(&sky.map, Job::default())?;
    balls(canvas, sky, &measured)?;
    table(canvas, &measured);
    canvas.command(&format!("lobe sh encodings bundled:{}", sky.bundled.name));
    Ok(())
}

fn balls(canvas: &mut Canvas<'_>, sky: &Sky, measured: &EncodingErrors) -> Drawn {
    let eye = sky.beside_the_light(75.0, 60.0);
    let ball = ball_from(canvas.size.ball * 3 / 4, eye);
    let normals: Vec<Dir> = ball.normals().into_iter().map(|(_, n)| n).collect();
    let truth = ball.lit_by_values(BACKDROP, &irradiance_at(&sky.map, &normals));
    let tone = Tone::OBJECT.fixed_for(&truth);
    let width = ball.size() * 4 / 3;
    canvas.figure(&sky.file("encoding-truth.png"), (&truth, &tone), width, "the truth, a sum over every texel")?;

    let irradiance = irradiance_to_encode(&sky.map);
    let full_scale = FULL_SCALE * measured.mean / PI;
    for encoding in SHOWN {
        let encoded = encoding.encode(&irradiance, tangent_frame(eye));
        let values: Vec<Rgb<f64>> = normals.iter().map(|n| encoded.eval(*n)).collect();
        let claim = ball.lit_by_values(BACKDROP, &values);
        let pair = [tone.apply(&claim), error_map(&claim, &truth, full_scale)?];
        let name = encoding.name();
        let error = measured.encodings.iter().find(|(measured, _)| *measured == encoding);
        let rms = error.map_or(f64::NAN, |(_, error)| error.rms);
        let caption = format!("{name}, {} floats, RMS error {}", encoding.floats(3), percent(rms));
        let drawn = (&sheet(2, 0, BACKDROP, &pair), &Tone::PLAIN);
        canvas.figure(&sky.file(&format!("encoding-{name}.png")), drawn, 2 * width, &caption)?;
    }
    Ok(())
}

fn table(canvas: &mut Canvas<'_>, measured: &EncodingErrors) {
    let row = |(encoding, error): &(IrradianceEncoding, EncodingError)| {
        vec![
            encoding.name().into(),
            encoding.floats(3).to_string(),
            if encoding.is_hemispherical() { "one side" } else { "all" }.into(),
            percent(error.mean),
            percent(error.rms),
            percent(error.max),
            digits(error.lowest),
        ]
    };
    let rows: Vec<Vec<String>> = measured.encodings.iter().map(row).collect();
    let head = ["encoding", "floats", "normals", "mean error", "RMS error", "largest error", "lowest irradiance"];
    canvas.table(&head, &rows);
    canvas.text(
        "Errors in percent of the mean irradiance, over all normals and channels; those of one side averaged over surfaces \
         that face everywhere. zh3 adds one zonal number a channel to order 2: the axis is read from the other four. ahd is a constant and \
         one light. hl2-linear has no constant, which is why it fails under any sky.",
    );
}
