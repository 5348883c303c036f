//! Sections about windows: window functions over the bands, and the impulse under each of them.

use lobe::figures::Curve2d;
use lobe::sh::filter::{squared_laplacian, width_of_peak};
use lobe::sh::ringing::{ContentWindow, dering_table_factors};
use lobe::sh::{Dir, Expansion as _, ShVec, Window, Zonal};

use crate::error::Drawn;
use crate::page::{BLACK, BLUE, Canvas, GRAY, GREEN, ORANGE, RED, SWEEP, digits, percent};

/// The peak to which a Hanning and a Lanczos window lower an impulse of order 6, so that they can be compared.
const SAME_PEAK: f64 = 2.25;

/// Points of a line between two bands.
const FINE: usize = 32;

/// A window with its name in the legend; `None` is no window.
type Named<'a> = (&'a str, [u8; 3], Option<Window>);

/// The impulse of order [`SWEEP`] towards +z under a window.
fn impulse(window: Option<Window>) -> Zonal {
    let sun = Zonal::impulse(SWEEP);
    let factor = |l: usize| window.map_or(1.0, |window| window.factor(l));
    Zonal::new(sun.coefficients().iter().enumerate().map(|(l, c)| c * factor(l)).collect())
}

fn lanczos(width: f64, power: f64) -> Option<Window> {
    Some(Window::Lanczos { width, power })
}

fn hanning(width: f64) -> Option<Window> {
    Some(Window::Hanning { width })
}

/// The widths of the Hanning and the Lanczos window at which an impulse of order [`SWEEP`] has the peak [`SAME_PEAK`].
fn same_peak() -> [f64; 2] {
    let hanning = width_of_peak(SWEEP, SAME_PEAK, |width| Window::Hanning { width });
    let lanczos = width_of_peak(SWEEP, SAME_PEAK, |width| Window::Lanczos { width, power: 1.0 });
    let (Some(hanning), Some(lanczos)) = (hanning, lanczos) else { unreachable!("a window has the peak") };
    [hanning, lanczos]
}

/// The window that leaves a fraction of the squared Laplacian of the impulse.
fn laplacian(fraction: f64) -> Option<Window> {
    let sun = ShVec::<f64>::impulse(SWEEP, Dir::Z, 1.0);
    Some(Window::squared_laplacian_of(sun.coefficients(), fraction))
}

pub(crate) fn windows(canvas: &mut Canvas<'_>) -> Drawn {
    let widths = same_peak();
    canvas.text(&format!(
            "A window lets the bands fade out where a truncation cuts them off. A sun is the light that rings most: here at \
             order {SWEEP}, its peak {}/4π = {}, under windows of several kinds, widths and powers.",
            SWEEP * SWEEP,
            digits(impulse(None).eval(1.0)),
        ));
    window_functions(canvas, widths)?;
    sigma_factors(canvas, widths)?;
    canvas.command(&format!(
        "lobe light directional --dir 0,0,1 --order {SWEEP} --normalize none -o sun.sh.json\n\
             lobe sh window sun.sh.json --kind lanczos --width {:.4} -o calm.sh.json\n\
             lobe sh plot calm.sh.json --beside sun.sh.json --style polar -o calm.svg",
        widths[1],
    ));
    Ok(())
}

fn window_functions(canvas: &mut Canvas<'_>, [hanning_width, lanczos_width]: [f64; 2]) -> Drawn {
    // Both depend on l/w alone, so a window FINE times as wide has the values between the bands.
    let fine = |label, color, window: Window| Curve2d {
        label,
        color,
        dashed: false,
        points: (0..=SWEEP * FINE).map(|k| [k as f64 / FINE as f64, window.factor(k)]).collect(),
    };
    let width = (SWEEP * FINE) as f64;
    let curves = [
        fine("Lanczos", RED, Window::Lanczos { width, power: 1.0 }),
        fine("Lanczos, power 4", ORANGE, Window::Lanczos { width, power: 4.0 }),
        fine("Hanning", BLUE, Window::Hanning { width }),
    ];
    let bands = ([0.0, SWEEP as f64], 1.0, "");
    canvas.line_plot("windows.svg", bands, &curves, "windows of width 6 over the band; only whole bands are used")?;
    let labels = [format!("Lanczos, {lanczos_width:.2}"), format!("Hanning, {hanning_width:.2}")];
    let named: [Named<'_>; 6] = [
        (labels[0].as_str(), RED, lanczos(lanczos_width, 1.0)),
        (labels[1].as_str(), BLUE, hanning(hanning_width)),
        ("Laplacian, 50 %", GREEN, laplacian(0.5)),
        ("Laplacian, 10 %", BLACK, laplacian(0.1)),
        ("Gauss, 15°", ORANGE, Some(Window::Gauss { sigma: 15.0_f64.to_radians() })),
        ("point lights", GRAY, Some(Window::PunctualLight)),
    ];
    let curves = named.map(|(label, color, window)| {
        let factor = |l: usize| window.map_or(1.0, |window| window.factor(l));
        // It lies on the Lanczos window.
        let dashed = matches!(window, Some(Window::Hanning { .. }));
        Curve2d { label, color, dashed, points: (0..SWEEP).map(|l| [l as f64, factor(l)]).collect() }
    });
    // Room for the legend on the right.
    let bands = ([0.0, 1.5 * SWEEP as f64], 1.0, "");
    let caption = format!("factors by band: the first two give a sun of order {SWEEP} the same peak, {SAME_PEAK}");
    canvas.line_plot("window-bands.svg", bands, &curves, &caption)
}

/// The impulse under each window, over the angle from it.
fn suns(canvas: &mut Canvas<'_>, file: &str, windows: &[Named<'_>], caption: &str) -> Drawn {
    let curves: Vec<Curve2d<'_>> = windows
        .iter()
        .map(|(label, color, window)| {
            let sun = impulse(*window);
            Curve2d::of_angle(label, *color, window.is_none(), move |t| sun.eval(t.cos()))
        })
        .collect();
    canvas.profiles(file, &curves, caption)
}

/// A cross-section of the impulse under a window, the bare impulse dashed.
fn polar_sun(canvas: &mut Canvas<'_>, file: &str, window: Option<Window>, caption: &str) -> Drawn {
    let (bare, sun) = (impulse(None), impulse(window));
    canvas.polar_xz(file, 3.0, &|s| sun.eval(s.z()), &|s| bare.eval(s.z()), caption)
}

fn sigma_factors(canvas: &mut Canvas<'_>, [hanning_width, lanczos_width]: [f64; 2]) -> Drawn {
    let labels = [lanczos_width, hanning_width].map(|width| format!("width {width:.2}"));
    let bare: Named<'_> = ("no window", GRAY, None);
    let widths = [
        bare,
        ("width 16", ORANGE, lanczos(16.0, 1.0)),
        (labels[0].as_str(), GREEN, lanczos(lanczos_width, 1.0)),
        ("width 7.5", BLUE, lanczos(7.5, 1.0)),
        ("width 6", RED, lanczos(6.0, 1.0)),
    ];
    let caption = "Lanczos windows of several widths, over the angle from the sun";
    suns(canvas, "sigma-lanczos-widths.svg", &widths, caption)?;
    let powers = [
        bare,
        ("power 1", ORANGE, lanczos(6.0, 1.0)),
        ("power 2", GREEN, lanczos(6.0, 2.0)),
        ("power 4", BLUE, lanczos(6.0, 4.0)),
        ("power 8", RED, lanczos(6.0, 8.0)),
    ];
    suns(canvas, "sigma-lanczos-powers.svg", &powers, "powers of the Lanczos window of width 6")?;
    let widths = [
        bare,
        ("width 20", ORANGE, hanning(20.0)),
        (labels[1].as_str(), GREEN, hanning(hanning_width)),
        ("width 8", BLUE, hanning(8.0)),
        ("width 6", RED, hanning(6.0)),
    ];
    suns(canvas, "sigma-hanning-widths.svg", &widths, "Hanning windows of several widths")?;
    let caption = "in polar form: Lanczos of width 6, the bare sun dashed; signs of its lobes alternate";
    polar_sun(canvas, "sigma-polar-lanczos.svg", lanczos(6.0, 1.0), caption)?;
    polar_sun(canvas, "sigma-polar-hanning.svg", hanning(6.0), "Hanning of width 6, the bare sun dashed")?;
    let together = [
        bare,
        ("Lanczos", RED, lanczos(6.0, 1.0)),
        ("Lanczos, power 2", ORANGE, lanczos(6.0, 2.0)),
        ("Lanczos, power 4", GREEN, lanczos(6.0, 4.0)),
        ("Hanning", BLUE, hanning(6.0)),
    ];
    suns(canvas, "sigma-together.svg", &together, "all windows of width 6 together")
}

/// Windows by the curvature that they leave.
pub(crate) fn laplacians(canvas: &mut Canvas<'_>) -> Drawn {
    let [hanning_width, lanczos_width] = same_peak();
    canvas.text(
            "The other way round: the fit that is smoothest for its error, with the weight λ that leaves a wanted part of the squared \
             Laplacian. λ is found by Newton's method for the very function at hand.",
        );
    let windows = [("100 %", GRAY, None), ("50 %", BLUE, laplacian(0.5)), ("10 %", GREEN, laplacian(0.1))];
    suns(canvas, "laplacian.svg", &windows, "a sun of order 6 with 50 % and 10 % of its squared Laplacian")?;
    polar_sun(canvas, "laplacian-50.svg", laplacian(0.5), "50 % in polar form, the bare sun dashed")?;
    polar_sun(canvas, "laplacian-10.svg", laplacian(0.1), "10 %")?;
    let labels = [format!("Lanczos, width {lanczos_width:.2}"), format!("Hanning, width {hanning_width:.2}")];
    let rows = [
        ("none", None),
        (labels[0].as_str(), lanczos(lanczos_width, 1.0)),
        (labels[1].as_str(), hanning(hanning_width)),
        ("Lanczos, width 6", lanczos(6.0, 1.0)),
        ("Lanczos, width 6, power 4", lanczos(6.0, 4.0)),
        ("Hanning, width 6", hanning(6.0)),
        ("squared Laplacian, 50 %", laplacian(0.5)),
        ("squared Laplacian, 10 %", laplacian(0.1)),
    ]
    .map(|(name, window)| row(name, window));
    let head = ["window", "peak", "lowest value", "squared Laplacian left"];
    canvas.table(&head, &rows);
    canvas.command("lobe sh window sun.sh.json --kind laplacian --keep 0.5 -o half.sh.json");
    Ok(())
}

/// The window that adapts to the content of the light.
pub(crate) fn content_window(canvas: &mut Canvas<'_>) -> Drawn {
    let window = Window::Hanning { width: SWEEP as f64 };
    let (bare, calm) = (impulse(None), impulse(Some(window)));
    let sun = bare.towards(Dir::Z, 1.0);
    let content = ContentWindow::of(&sun, window);
    let blend = |s: Dir| content.eval(&sun, s);
    let at = |t: f64| Dir::from_angles(t, 0.0);
    let whole = ContentWindow::THRESHOLD.acos().to_degrees();
    canvas.text(&format!(
            "A window takes most from where the light is, and rings are only seen where it is not. So the content decides: \
             towards the light, the direction of band 1, the function stays as it is, from {whole:.0}° on the window is whole, and \
             in between it comes in by a weight from Sloan's paper. The peak stays; the first lobe beside it only \
             shrinks. The blend has no last band: what an order keeps of it is below."
        ));
    let curves = [
        Curve2d::of_angle("no window", GRAY, true, |t| bare.eval(t.cos())),
        Curve2d::of_angle("Hanning", BLUE, false, |t| calm.eval(t.cos())),
        Curve2d::of_angle("by content", RED, false, |t| blend(at(t))),
        Curve2d::of_angle("weight", ORANGE, true, |t| content.weight(at(t))),
    ];
    canvas.profiles("content.svg", &curves, "a sun of order 6, bare, under a Hanning window, and by content")?;
    polar_sun(canvas, "content-polar-bare.svg", None, "in polar form: bare")?;
    polar_sun(canvas, "content-polar-window.svg", Some(window), "the Hanning window, the bare sun dashed")?;
    let caption = "by content, the bare sun dashed";
    canvas.polar_xz("content-polar.svg", 3.0, &blend, &|s| bare.eval(s.z()), caption)?;
    let row = |name: &str, f: &dyn Fn(Dir) -> f64, lost: f64| {
        let least = lowest(|t| f(at(t)));
        vec![name.to_owned(), digits(f(Dir::Z)), digits(least), percent(lost)]
    };
    let mut rows = vec![
        row("none", &|s: Dir| bare.eval(s.z()), 0.0),
        row("Hanning, width 6", &|s: Dir| calm.eval(s.z()), 0.0),
        row("by content", &blend, 0.0),
    ];
    for order in [6, 8, 12] {
        let kept = content.project(&sun, order);
        let lost = (1.0 - kept.dot(&kept) / content.energy(&sun)).max(0.0).sqrt();
        rows.push(row(&format!("by content, kept at order {order}"), &|s: Dir| kept.eval(s), lost));
    }
    canvas.table(&["window", "peak", "lowest value", "left out, of the root mean square"], &rows);
    canvas.command("lobe sh window sun.sh.json --kind hanning --content --order 12 -o content.sh.json");
    Ok(())
}

/// The figure of Sloan 2017 that his table is made by.
pub(crate) fn table_windows(canvas: &mut Canvas<'_>) -> Drawn {
    const ROWS: [(f64, [u8; 3]); 7] =
        [(0.0, GRAY), (1.0, [170, 60, 160]), (2.0, ORANGE), (3.0, RED), (4.0, GREEN), (5.0, BLUE), (6.0, BLACK)];
    let suns = ROWS.map(|(row, _)| irradiance_of_sun(&dering_table_factors(row / 6.0)));
    let [first, .., before, last] = suns.each_ref().map(lowest_of);
    canvas.text(&format!(
            "The irradiance of a sun at order 3 in units of its mean, under the seven windows of Sloan's table. Bare it falls to \
             {}, under the last but one to {}, under the last no lower than {}: light rings no more than a sun, so the last \
             suffices for any.",
            digits(first),
            digits(before),
            digits(last),
        ));
    let labels = ROWS.map(|(row, _)| format!("row {}", row + 1.0));
    let curves: Vec<Curve2d<'_>> = ROWS
        .iter()
        .zip(&suns)
        .zip(&labels)
        .map(|((&(row, color), sun), label)| Curve2d::of_angle(label, color, row == 0.0, |t| sun.eval(t.cos())))
        .collect();
    canvas.profiles("table-windows.svg", &curves, "over the angle from the sun")?;
    let truth = |s: Dir| 4.0 * s.z().max(0.0);
    for (file, sun, caption) in [
        ("table-first.svg", &suns[0], "the middle of the first in polar form, the cosine dashed"),
        ("table-last.svg", &suns[6], "the middle of the last"),
    ] {
        canvas.polar_xz(file, 1.0, &|s| sun.eval(s.z()), &truth, caption)?;
    }
    canvas.command("lobe sh dering e.sh.json --method table -o calm.sh.json");
    Ok(())
}

/// The blur of a punctual light before it is added to a probe.
pub(crate) fn punctual_light(canvas: &mut Canvas<'_>) -> Drawn {
    let factors = Window::PunctualLight.factors(3);
    let (bare, sun) = (irradiance_of_sun(&[1.0; 3]), irradiance_of_sun(&factors));
    canvas.text(&format!(
            "A light that is added to a probe at run time is not deringed with it. With the bands scaled by {} its irradiance \
             rings half as deep, to {} instead of {} of its mean, for a peak of {} instead of {}.",
            factors.iter().map(f64::to_string).collect::<Vec<_>>().join(", "),
            digits(lowest_of(&sun)),
            digits(lowest_of(&bare)),
            digits(sun.eval(1.0)),
            digits(bare.eval(1.0)),
        ));
    let curves = [
        Curve2d::of_angle("bare", GRAY, true, |t| bare.eval(t.cos())),
        Curve2d::of_angle("under the window", RED, false, |t| sun.eval(t.cos())),
    ];
    canvas.profiles("punctual-light.svg", &curves, "the irradiance of a point light over the angle from it")?;
    canvas.command("lobe sh window sun.sh.json --kind punctual -o added.sh.json");
    Ok(())
}

/// The irradiance of a sun of order 3 under factors for its bands, in units of its mean.
fn irradiance_of_sun(factors: &[f64]) -> Zonal {
    let cosine = Zonal::clamped_cosine(3);
    let sun = Zonal::impulse(3);
    let bands = sun.coefficients().iter().zip(cosine.convolution_factors()).zip(factors);
    // The mean of an irradiance of 1 facing the sun is 1/4.
    Zonal::new(bands.map(|((z, a), w)| 4.0 * z * a * w).collect())
}

/// The lowest value of a zonal function.
fn lowest_of(zonal: &Zonal) -> f64 {
    lowest(|t| zonal.eval(t.cos()))
}

/// The lowest value over an angle up to a half turn, from a tenth of a degree to the next.
fn lowest(f: impl Fn(f64) -> f64) -> f64 {
    (0..=1800).map(|k| f((f64::from(k) * 0.1).to_radians())).fold(f64::INFINITY, f64::min)
}

fn row(name: &str, window: Option<Window>) -> Vec<String> {
    let [sun, bare] = [window, None].map(|w| impulse(w).towards(Dir::Z, 1.0_f64));
    let zonal = impulse(window);
    let left = squared_laplacian(sun.coefficients()) / squared_laplacian(bare.coefficients());
    vec![name.to_owned(), digits(zonal.eval(1.0)), digits(lowest_of(&zonal)), percent(left)]
}
