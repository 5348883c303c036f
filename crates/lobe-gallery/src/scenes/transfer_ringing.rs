//! Section about transfer that rings: a higher order that is farther from the truth, the cause, and the remedy, a window.

use lobe::figures::Curve2d;
use lobe::image::{Picture, Pixel, Tone};
use lobe::render::Truth;
use lobe::sh::{Coefficient as _, Rgb, ShVec};

use super::hall::{Hall, about_z, calmed};
use super::look::{covered, decibels};
use crate::error::Drawn;
use crate::page::{BLACK, BLUE, Canvas, SWEEP, Sky, digits};

/// The results of light of one order.
struct Row {
    order: usize,
    plain: Found,
    calm: Found,
}

/// The results of a light.
struct Found {
    psnr: f64,
    /// The brightness of the darker half of the hall, and of the brighter half, each over that of the truth.
    halves: [f64; 2],
    /// The part of the hall whose radiance is below zero, in percent.
    below_zero: f64,
}

/// The hall of another sky under one that rings in it.
pub(crate) fn transfer_ringing(canvas: &mut Canvas<'_>, sky: &Sky, hall: &Hall) -> Drawn {
    let name = sky.bundled.name;
    canvas.step()?;
    let truth = hall.truth(sky, &about_z(0.0))?;
    let row = |order: usize| {
        let light = sky.radiance.resized(order);
        let [plain, calm] = [&light, &calmed(&light)].map(|light| Found::of(light, hall, &truth));
        Row { order, plain, calm }
    };
    let rows: Vec<Row> = (1..=SWEEP).map(row).collect();
    let gain = |k: &usize| rows[*k].plain.psnr - rows[*k - 1].plain.psnr;
    let Some(worst) = (1..SWEEP).min_by(|a, b| gain(a).total_cmp(&gain(b))) else { unreachable!("orders") };
    let Row { order, plain, calm } = &rows[worst];
    let before = &rows[worst - 1].plain;
    canvas.text(&format!(
            "The same hall under another sky, in which order {order} comes out {} dB {} than the order before. Nearly all light \
             comes from two lamps. Their bands add up at the lamps and cancel each other elsewhere, but only all of them do: of \
             those up to order {order}, {} times the light that is there reaches the darker half of the hall, {} times with one order \
             less, and the brighter half has {} of its light, {} with one order less. A window (Hanning, zero one band above the \
             order) makes that {} and {}: {} dB instead of {}. It also keeps the hall from sending less than nothing. At the orders \
             that come nearer the truth it takes more than it gives.",
            digits(gain(&worst).abs()),
            if gain(&worst) < 0.0 { "lower" } else { "higher" },
            digits(plain.halves[0]),
            digits(before.halves[0]),
            digits(plain.halves[1]),
            digits(before.halves[1]),
            digits(calm.halves[0]),
            digits(calm.halves[1]),
            digits(calm.psnr),
            digits(plain.psnr),
        ));
    figures(canvas, sky, hall, &truth, *order)?;
    plot(canvas, sky, &rows)?;
    table(canvas, &rows);
    canvas.command(&format!(
        "lobe render hall.glb --env bundled:{name} --order {order} -o rings.exr\n\
             lobe render hall.glb --env bundled:{name} --order {order} --window hanning:{} -o calm.exr\n\
             lobe compare calm.exr truth.exr",
        order + 1
    ));
    Ok(())
}

/// The order before, the order that rings, plain and windowed, and the truth.
fn figures(canvas: &mut Canvas<'_>, sky: &Sky, hall: &Hall, truth: &Truth, order: usize) -> Drawn {
    let light = |order| sky.radiance.resized(order);
    let tone = Tone::PHOTOGRAPH.fixed_for(&truth.mean);
    let mut figure = |what: &str, picture: &Picture, caption: &str| {
        canvas.figure(&sky.file(&format!("hall-{what}.png")), (picture, &tone), picture.width(), caption)
    };
    for (name, light, caption) in [
        (format!("plain-{}", order - 1), light(order - 1), format!("order {}", order - 1)),
        (format!("plain-{order}"), light(order), format!("order {order}: lighter where it should be dark")),
        (format!("windowed-{order}"), calmed(&light(order)), format!("order {order}, windowed")),
    ] {
        let picture = hall.picture(sky, &about_z(0.0), &light)?;
        figure(&name, &picture, &caption)?;
    }
    figure("truth", &truth.mean, "the truth: paths of light")
}

fn plot(canvas: &mut Canvas<'_>, sky: &Sky, rows: &[Row]) -> Drawn {
    let curve = |label, color, of: fn(&Row) -> &Found| {
        let points = rows.iter().map(|row| [row.order as f64, of(row).psnr]).collect();
        Curve2d { label, color, dashed: false, points }
    };
    let curves = [curve("plain", BLACK, |row| &row.plain), curve("windowed", BLUE, |row| &row.calm)];
    let ends = ([1.0, SWEEP as f64], 1.0, "");
    canvas.line_plot(&sky.file("hall-psnr.svg"), ends, &curves, "peak signal-to-noise ratio in dB over the order")
}

fn table(canvas: &mut Canvas<'_>, rows: &[Row]) {
    let cells = |row: &Row| {
        let of = |found: &Found| {
            let [darker, brighter] = found.halves.map(digits);
            [decibels(found.psnr), darker, brighter, format!("{} %", digits(found.below_zero))]
        };
        let order = [row.order.to_string()];
        order.into_iter().chain(of(&row.plain)).chain(of(&row.calm)).collect()
    };
    let rows: Vec<Vec<String>> = rows.iter().map(cells).collect();
    let head = [
        "order",
        "PSNR",
        "darker half / truth",
        "brighter half",
        "below zero",
        "windowed",
        "darker half",
        "brighter half",
        "below zero",
    ];
    canvas.table(&head, &rows);
}

impl Found {
    fn of(light: &ShVec<Rgb<f64>>, hall: &Hall, truth: &Truth) -> Self {
        let luminance = |c: &Pixel| Rgb::from(*c).widen().luminance();
        let luminances = |pixels: Vec<Pixel>| pixels.iter().map(luminance).collect::<Vec<_>>();
        let found = luminances(hall.seen(light, 0.0, truth));
        let expected = luminances(covered(truth, &truth.mean).collect());
        let mut sorted = expected.clone();
        sorted.sort_by(f64::total_cmp);
        let median = sorted[sorted.len() / 2];
        let half = |is_bright: bool| {
            let pairs = found.iter().zip(&expected).filter(|(_, expected)| (**expected >= median) == is_bright);
            let [found, expected] = pairs.fold([0.0, 0.0], |[a, b], (found, expected)| [a + found, b + expected]);
            found / expected
        };
        let below = found.iter().filter(|luminance| **luminance < 0.0).count();
        Self {
            psnr: hall.psnr(light, std::slice::from_ref(truth)),
            halves: [half(false), half(true)],
            below_zero: 100.0 * below as f64 / found.len() as f64,
        }
    }
}
