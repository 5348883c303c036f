//! Sections about ringing: light below zero, and deringing.

use std::f64::consts::{PI, TAU};

use lobe::env::irradiance_at;
use lobe::figures::{Balloon, CrossSection, CubeCross};
use lobe::render::View;
use lobe::sh::expansion::Quantity;
use lobe::sh::extrema::{Extremum, certified_maximum};
use lobe::sh::ringing::{DeringMethod, DeringOptions, DeringReport, WindowFamily};
use lobe::sh::{Coefficient as _, Dir, Expansion as _, Rgb, ShVec, Zonal};

use crate::error::Drawn;
use crate::page::{Canvas, SWEEP, Sky, digits, percent};

/// The order that irradiance is usually stored at.
const USUAL: usize = 3;

/// Places around the cross-section at which the truth is summed.
const PLACES: usize = 360;

const METHODS: [(&str, DeringMethod); 7] = [
    ("least-change", DeringMethod::LeastChange),
    ("table", DeringMethod::Table),
    ("sinc4", DeringMethod::Family(WindowFamily::Lanczos { power: 4.0 })),
    ("lanczos", DeringMethod::Family(WindowFamily::Lanczos { power: 1.0 })),
    ("hanning", DeringMethod::Family(WindowFamily::Hanning)),
    ("gauss", DeringMethod::Family(WindowFamily::Gauss)),
    ("laplacian", DeringMethod::Family(WindowFamily::SquaredLaplacian)),
];

/// A function before and after, under the names of its files.
struct Pair<'a> {
    /// The prefix of the names of the files.
    stem: &'a str,
    before: &'a ShVec<f64>,
    after: &'a ShVec<f64>,
    /// The value that fills the figures.
    largest: f64,
}

impl<'a> Pair<'a> {
    fn new(stem: &'a str, before: &'a ShVec<f64>, after: &'a ShVec<f64>) -> Self {
        let largest = certified_maximum(before.coefficients(), 1e-3).hi;
        Self { stem, before, after, largest }
    }

    fn both(&self) -> [(&'static str, &'a ShVec<f64>); 2] {
        [("before", self.before), ("after", self.after)]
    }
}

/// The irradiance of a sun, which rings most.
pub(crate) fn sun_alone(canvas: &mut Canvas<'_>) -> Drawn {
    let before = ShVec::<f64>::impulse(USUAL, Dir::Z, 1.0).convolved(&Zonal::clamped_cosine(USUAL));
    let (after, report) = before.deringed_with(&DeringOptions::default());
    canvas.text(&format!(
            "The irradiance of a sun in order {USUAL} is negative below the horizon, down to {} % of the mean, and positive again at \
             the far pole. The least change makes its lowest value 0 with the factors {}; {} % of the norm stay.",
            digits(100.0 * report.before[0].lo / before.mean()),
            bands(&report),
            norm_kept(&report),
        ));
    let pair = Pair::new("sun-ringing", &before, &after);
    // A little from below, where it rings.
    balloons(canvas, &pair, Dir::from_angles(110.0_f64.to_radians(), 0.6), "red is positive, blue negative")?;
    let truth = |s: Dir| s.z().max(0.0);
    polars(canvas, &pair, CrossSection::XZ, 1.0, &truth, "in polar form, the cosine dashed")?;
    polars(canvas, &pair, CrossSection::XZ, 5.0, &truth, "its middle, five times as large")?;
    canvas.command(
        "lobe light directional --dir 0,0,1 --order 3 --normalize none -o sun.sh.json\n\
             lobe sh convolve sun.sh.json --kernel cosine -o e.sh.json\n\
             lobe sh dering e.sh.json -o calm.sh.json",
    );
    Ok(())
}

pub(crate) fn irradiance_of_sky(canvas: &mut Canvas<'_>, sky: &Sky) -> Drawn {
    let name = sky.bundled.name;
    let irradiance = sky.radiance.resized(USUAL).convolved(&Zonal::clamped_cosine(USUAL));
    let (after, report) = irradiance.deringed_with(&DeringOptions::default());
    let (channel, color) = worst_channel(&irradiance, &report);
    canvas.text(&format!(
            "The irradiance of order {USUAL} of this photograph falls to {} % of its mean, which no light does. The least change by a \
             factor for each band, {}, lifts its least value to 0 and keeps {} % of the norm; the {color} channel is shown, the \
             lowest for its mean.",
            digits(100.0 * report.before[channel].lo / irradiance.mean().channel(channel)),
            bands(&report),
            norm_kept(&report),
        ));
    let [before, after] = [&irradiance, &after].map(|f| f.map(|c| c.channel(channel)));
    let stem = sky.file("ringing");
    let pair = Pair::new(&stem, &before, &after);
    crosses(canvas, &pair)?;
    let lowest = report.before[channel].dir;
    let right = Dir::new([lowest.x(), lowest.y(), 0.0]).unwrap_or(Dir::X);
    let section = CrossSection { right, up: Dir::Z };
    let truth = truth_around(sky, section, channel);
    let what = "in the vertical plane through the least value, down and to the right; the truth dashed";
    polars(canvas, &pair, section, 1.0, &truth, what)?;
    polars(canvas, &pair, section, 12.0, &truth, "its middle, twelve times as large")?;
    methods_table(canvas, &irradiance)?;
    orders_table(canvas, sky)?;
    canvas.command(&format!(
        "lobe project bundled:{name} --order 3 -o - | lobe sh convolve - --kernel cosine -o e.sh.json\n\
             lobe sh min e.sh.json\n\
             lobe sh dering e.sh.json -o calm.sh.json\n\
             lobe sh plot calm.sh.json --style cross -o calm.png"
    ));
    Ok(())
}

pub(crate) fn radiance_of_sky(canvas: &mut Canvas<'_>, sky: &Sky) -> Drawn {
    let name = sky.bundled.name;
    let (after, report) = sky.radiance.deringed_with(&DeringOptions::default());
    canvas.text(&format!(
            "Radiance of lamps rings far more: to {} % of the mean in order {SWEEP}. To make it non-negative costs contrast, {} % of the \
             norm stay; if only its irradiance is needed, --quantity irradiance leaves nearly all.",
            digits(100.0 * lowest_of_means(&sky.radiance, &report.before)),
            norm_kept(&report),
        ));
    let [before, after] = [&sky.radiance, &after].map(|f| f.map(Rgb::luminance));
    let stem = sky.file("radiance-ringing");
    let pair = Pair::new(&stem, &before, &after);
    balloons(
        canvas,
        &pair,
        sky.beside_the_light(75.0, 90.0),
        "red is positive, blue negative, the main lamp to one side",
    )?;
    crosses(canvas, &pair)?;
    canvas.command(&format!("lobe sh dering {name}.sh.json --quantity radiance -o calm.sh.json"));
    Ok(())
}

fn balloons(canvas: &mut Canvas<'_>, pair: &Pair<'_>, eye: Dir, caption: &str) -> Drawn {
    for (when, f) in pair.both() {
        let size = 2 * canvas.size.ball;
        let balloon = Balloon { extent: Some(pair.largest), view: View::from_eye(eye), ..Balloon::new(size) };
        let file = format!("{}-balloon-{when}.png", pair.stem);
        let picture = balloon.picture(|s| f.eval(s));
        canvas.plain_figure(&file, &picture, &format!("{when}: {caption}"))?;
    }
    Ok(())
}

fn crosses(canvas: &mut Canvas<'_>, pair: &Pair<'_>) -> Drawn {
    for (when, f) in pair.both() {
        let cross = CubeCross { full_scale: Some(pair.largest), ..CubeCross::new(canvas.size.ball * 3 / 4) };
        let picture = cross.picture(|s| f.eval(s));
        let file = format!("{}-cross-{when}.png", pair.stem);
        canvas.plain_figure(&file, &picture, &format!("{when}, on the unfolded cube: the green line is zero"))?;
    }
    Ok(())
}

/// Cross-sections beside the truth, their radius multiplied by `enlarged`.
fn polars(
    canvas: &mut Canvas<'_>,
    pair: &Pair<'_>,
    section: CrossSection,
    enlarged: f64,
    truth: &dyn Fn(Dir) -> f64,
    caption: &str,
) -> Drawn {
    let name = if enlarged > 1.0 { "middle" } else { "polar" };
    for (when, f) in pair.both() {
        let file = format!("{}-{name}-{when}.svg", pair.stem);
        let plane = (section, pair.largest / enlarged);
        canvas.polar(&file, plane, &|s| f.eval(s), truth, &format!("{when}, {caption}"))?;
    }
    Ok(())
}

fn methods_table(canvas: &mut Canvas<'_>, irradiance: &ShVec<Rgb<f64>>) -> Drawn {
    canvas.step()?;
    let rows = METHODS.map(|(name, method)| {
        let (_, report) = irradiance.deringed_with(&DeringOptions::default().method(method));
        vec![
            name.to_owned(),
            bands(&report),
            // The proven bound is a little below zero: the width of the interval.
            format!("{} %", digits((1e4 * lowest_of_means(irradiance, &report.after)).round() / 1e2)),
            format!("{} %", norm_kept(&report)),
        ]
    });
    canvas.table(&["method", "factors of the bands", "lowest value after / mean", "norm kept"], &rows);
    Ok(())
}

fn orders_table(canvas: &mut Canvas<'_>, sky: &Sky) -> Drawn {
    canvas.step()?;
    let mut rows = Vec::new();
    for quantity in [Quantity::Irradiance, Quantity::Radiance] {
        for order in 2..=SWEEP {
            let radiance = sky.radiance.resized(order);
            let f = match quantity {
                Quantity::Irradiance => radiance.convolved(&Zonal::clamped_cosine(order)),
                _ => radiance,
            };
            let (_, report) = f.deringed_with(&DeringOptions::default());
            let before = lowest_of_means(&f, &report.before);
            rows.push(vec![
                quantity.to_string(),
                order.to_string(),
                percent(before),
                bands(&report),
                format!("{} %", norm_kept(&report)),
            ]);
        }
    }
    let head = ["least change of", "order", "lowest value before / mean", "factors of the bands", "norm kept"];
    canvas.table(&head, &rows);
    Ok(())
}

/// The channel that is lowest in units of its mean, and its name.
fn worst_channel(before: &ShVec<Rgb<f64>>, report: &DeringReport) -> (usize, &'static str) {
    let depth = |c: &usize| report.before[*c].lo / before.mean().channel(*c);
    let channel = (0..3).min_by(|a, b| depth(a).total_cmp(&depth(b))).unwrap_or(0);
    (channel, ["red", "green", "blue"][channel])
}

/// The exact irradiance around a cross-section, between the places where it was summed in proportion.
fn truth_around(sky: &Sky, section: CrossSection, channel: usize) -> impl Fn(Dir) -> f64 + use<> {
    let places: Vec<Dir> = (0..PLACES).map(|i| section.dir(TAU * i as f64 / PLACES as f64)).collect();
    let values: Vec<f64> = irradiance_at(&sky.map, &places).iter().map(|e| e.channel(channel)).collect();
    move |s| {
        let turn = s.dot(section.up).atan2(s.dot(section.right)).rem_euclid(2.0 * PI) / TAU * PLACES as f64;
        let (i, part) = (turn.floor() as usize, turn.fract());
        (1.0 - part) * values[i % PLACES] + part * values[(i + 1) % PLACES]
    }
}

fn bands(report: &DeringReport) -> String {
    report.factors.iter().map(|w| format!("{w:.3}")).collect::<Vec<_>>().join(" ")
}

/// The part of the norm that is left, in percent.
fn norm_kept(report: &DeringReport) -> String {
    digits(100.0 * (1.0 - report.energy_removed).sqrt())
}

/// The lowest value of any channel in units of its mean.
fn lowest_of_means(f: &ShVec<Rgb<f64>>, minima: &[Extremum]) -> f64 {
    minima.iter().enumerate().map(|(c, min)| min.lo / f.mean().channel(c)).fold(f64::INFINITY, f64::min)
}
