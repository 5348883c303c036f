//! Windows over the bands, and what they do to the most pointed light there is.

use lobe::render::{CrossSection, Curve2d, PolarPlot};
use lobe::sh::{Dir, Expansion as _, ShVec, Window, Zonal, squared_laplacian};

use super::lights::{BLACK, BLUE, GREEN, GREY, ORANGE, POLAR, RED, profile};
use super::{SWEEP, Writer, digits};

/// The widths at which a Hanning and a Lanczos window lower the peak of an impulse of order 6 to the same 2.25.
const SAME_PEAK: [f64; 2] = [12.010_498_388, 9.872_527_032];

/// Points of a line between two bands.
const FINE: usize = 32;

/// A window with what the legend calls it; `None` is no window.
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

/// The window that leaves a fraction of the squared Laplacian of the impulse.
fn laplacian(fraction: f64) -> Option<Window> {
    let sun = ShVec::<f64>::impulse(SWEEP, Dir::Z, 1.0);
    Some(Window::squared_laplacian_of(sun.coefficients(), fraction))
}

impl Writer<'_> {
    pub(super) fn windows(&mut self) -> anyhow::Result<()> {
        self.page.section("Windows: less ringing for more blur");
        self.page.text(
            "A window lets the bands fade out where a truncation cuts them off. A sun is the light that rings most: here at \
             order 6, its peak 36/4π = 2.86, under windows of several kinds, widths and powers.",
        );
        self.window_functions()?;
        self.sigma_factors()?;
        self.page.command(
            "lobe light directional --dir 0,0,1 --order 6 --normalize none -o sun.sh.json\n\
             lobe sh window sun.sh.json --kind lanczos --width 9.8725 -o calm.sh.json\n\
             lobe sh plot calm.sh.json --beside sun.sh.json --style polar -o calm.svg",
        );
        self.laplacians()
    }

    fn window_functions(&mut self) -> anyhow::Result<()> {
        // Both depend on l/w alone, so a window FINE times as wide has the values between the bands.
        let fine = |label, colour, window: Window| Curve2d {
            label,
            colour,
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
        self.line_plot("windows.svg", bands, &curves, "windows of width 6 over the band; only whole bands are used")?;
        let [hanning_width, lanczos_width] = SAME_PEAK;
        let named: [Named<'_>; 6] = [
            ("Lanczos, 9.87", RED, lanczos(lanczos_width, 1.0)),
            ("Hanning, 12.01", BLUE, hanning(hanning_width)),
            ("Laplacian, 50 %", GREEN, laplacian(0.5)),
            ("Laplacian, 10 %", BLACK, laplacian(0.1)),
            ("Gauss, 15°", ORANGE, Some(Window::Gauss { sigma: 15.0_f64.to_radians() })),
            ("point lights", GREY, Some(Window::PunctualLight)),
        ];
        let curve = |(label, colour, window): Named<'static>| {
            let factor = |l: usize| window.map_or(1.0, |window| window.factor(l));
            // It lies on the Lanczos window.
            let dashed = matches!(window, Some(Window::Hanning { .. }));
            Curve2d { label, colour, dashed, points: (0..SWEEP).map(|l| [l as f64, factor(l)]).collect() }
        };
        // Room for the legend on the right.
        let bands = ([0.0, 1.5 * SWEEP as f64], 1.0, "");
        let caption = "factors by band: the first two give a sun of order 6 the same peak, 2.25";
        self.line_plot("window-bands.svg", bands, &named.map(curve), caption)
    }

    /// The impulse under each window, over the angle from it.
    fn suns(&mut self, file: &str, windows: &[Named<'_>], caption: &str) -> anyhow::Result<()> {
        let curves: Vec<Curve2d<'_>> = windows
            .iter()
            .map(|(label, colour, window)| {
                let sun = impulse(*window);
                profile(label, *colour, window.is_none(), move |t| sun.eval(t.cos()))
            })
            .collect();
        self.profiles(file, &curves, caption)
    }

    /// A cross-section of the impulse under a window, the bare impulse dashed.
    fn polar_sun(&mut self, file: &str, window: Option<Window>, caption: &str) -> anyhow::Result<()> {
        let (bare, sun) = (impulse(None), impulse(window));
        let plot = PolarPlot { extent: Some(3.0), ..PolarPlot::new(POLAR, CrossSection::XZ) };
        self.write_svg(file, &plot.svg(&|s: Dir| sun.eval(s.z()), &[&|s: Dir| bare.eval(s.z())]))?;
        self.page.figure(file, POLAR as usize, caption);
        Ok(())
    }

    fn sigma_factors(&mut self) -> anyhow::Result<()> {
        let [hanning_width, lanczos_width] = SAME_PEAK;
        let bare: Named<'_> = ("no window", GREY, None);
        let widths = [
            bare,
            ("width 16", ORANGE, lanczos(16.0, 1.0)),
            ("width 9.87", GREEN, lanczos(lanczos_width, 1.0)),
            ("width 7.5", BLUE, lanczos(7.5, 1.0)),
            ("width 6", RED, lanczos(6.0, 1.0)),
        ];
        self.suns(
            "sigma-lanczos-widths.svg",
            &widths,
            "Lanczos windows of several widths, over the angle from the sun",
        )?;
        let powers = [
            bare,
            ("power 1", ORANGE, lanczos(6.0, 1.0)),
            ("power 2", GREEN, lanczos(6.0, 2.0)),
            ("power 4", BLUE, lanczos(6.0, 4.0)),
            ("power 8", RED, lanczos(6.0, 8.0)),
        ];
        self.suns("sigma-lanczos-powers.svg", &powers, "powers of the Lanczos window of width 6")?;
        let widths = [
            bare,
            ("width 20", ORANGE, hanning(20.0)),
            ("width 12.01", GREEN, hanning(hanning_width)),
            ("width 8", BLUE, hanning(8.0)),
            ("width 6", RED, hanning(6.0)),
        ];
        self.suns("sigma-hanning-widths.svg", &widths, "Hanning windows of several widths")?;
        let caption = "in polar form: Lanczos of width 6, the bare sun dashed; signs of its lobes alternate";
        self.polar_sun("sigma-polar-lanczos.svg", lanczos(6.0, 1.0), caption)?;
        self.polar_sun("sigma-polar-hanning.svg", hanning(6.0), "Hanning of width 6, the bare sun dashed")
    }

    fn laplacians(&mut self) -> anyhow::Result<()> {
        self.page.section("Windows: half the curvature");
        self.page.text(
            "The other way round: the fit that is smoothest for its error, with the weight λ that leaves a wanted part of the squared \
             Laplacian. λ is found by Newton's method for the very function at hand.",
        );
        let windows = [("100 %", GREY, None), ("50 %", BLUE, laplacian(0.5)), ("10 %", GREEN, laplacian(0.1))];
        self.suns("laplacian.svg", &windows, "a sun of order 6 with 50 % and 10 % of its squared Laplacian")?;
        self.polar_sun("laplacian-50.svg", laplacian(0.5), "50 % in polar form, the bare sun dashed")?;
        self.polar_sun("laplacian-10.svg", laplacian(0.1), "10 %")?;
        let [hanning_width, lanczos_width] = SAME_PEAK;
        let rows = [
            ("none", None),
            ("Lanczos, width 9.87", lanczos(lanczos_width, 1.0)),
            ("Hanning, width 12.01", hanning(hanning_width)),
            ("Lanczos, width 6", lanczos(6.0, 1.0)),
            ("Lanczos, width 6, power 4", lanczos(6.0, 4.0)),
            ("Hanning, width 6", hanning(6.0)),
            ("squared Laplacian, 50 %", laplacian(0.5)),
            ("squared Laplacian, 10 %", laplacian(0.1)),
        ]
        .map(|(name, window)| row(name, window));
        let head = ["window", "peak", "lowest value", "squared Laplacian left"];
        self.page.table(&head, &rows);
        self.page.command("lobe sh window sun.sh.json --kind laplacian --keep 0.5 -o half.sh.json");
        Ok(())
    }
}

fn row(name: &str, window: Option<Window>) -> Vec<String> {
    let [sun, bare] = [window, None].map(|w| impulse(w).towards(Dir::Z, 1.0_f64));
    let zonal = impulse(window);
    let lowest = (0..=1800).map(|k| zonal.eval((f64::from(k) * 0.1).to_radians().cos())).fold(f64::INFINITY, f64::min);
    let left = squared_laplacian(sun.coefficients()) / squared_laplacian(bare.coefficients());
    vec![name.to_owned(), digits(zonal.eval(1.0)), digits(lowest), format!("{} %", digits(100.0 * left))]
}
