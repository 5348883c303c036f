//! Windows: factors per band that exchange ringing for blur.

use core::f64::consts::PI;
use core::fmt;
use core::str::FromStr;

use crate::basis::index::{band_range, order_of_slice};
use crate::error::ShError;
use crate::filter::squared_laplacian::{band_energies, squared_eigenvalue, squared_laplacian_lambda};
use crate::prelude::*;
use crate::scalar::Coefficient;

/// One factor for each band, 1 for band 0, so that the mean over the sphere does not change.
///
/// ```text
///   Hanning            (1 + cos(π l/w)) / 2                     0 from l = w on
///   Lanczos            (sin(π l/w) / (π l/w))^p                 0 from l = w on
///   Gauss              exp(-σ² l(l+1) / 2)
///   SquaredLaplacian   1 / (1 + λ l² (l+1)²)
///   PunctualLight      1, 0.92, 0.73                            0 from l = 3 on
/// ```
///
/// `w` is the band at which the window reaches zero; the sigma factors of a truncation to order `n` have `w = n`,
/// larger widths blur less. Source: [Sloan 2008] for Hanning, Lanczos and the squared Laplacian; [Sloan 2017] for the
/// factors of punctual lights, made for order 3 and applied before such a light is added to a probe.
///
/// In text a window is its name and its numbers, `hanning:12`, `lanczos:9:4`, `gauss:0.2`, `squared-laplacian:0.0042`,
/// `punctual-light`; a Lanczos window without a power has power 1.
///
/// ```
/// use lobe_sh::Window;
///
/// let window: Window = "lanczos:9.872527032259".parse()?;
/// // A band-limited impulse of order 6 has the peak 36/4π = 2.86; the window lowers it to 2.25.
/// assert!((window.impulse_peak(6) - 2.25).abs() < 1e-12);
/// # Ok::<(), lobe_sh::ShError>(())
/// ```
///
/// [Sloan 2008]: https://www.ppsloan.org/publications/StupidSH36.pdf
/// [Sloan 2017]: https://www.ppsloan.org/publications/shdering.pdf
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Window {
    /// A raised cosine.
    Hanning {
        /// The band `w > 0` at which it reaches zero.
        width: f64,
    },
    /// A power of the sigma factors of Lanczos. In one dimension `sinc` is the transform of a box, and the window
    /// averages `p` times over an interval; on the sphere that is only an analogy.
    Lanczos {
        /// The band `w > 0` at which it reaches zero.
        width: f64,
        /// The power `p > 0`; 4 in [Sloan 2017](Self).
        power: f64,
    },
    /// The heat kernel of the sphere. It is positive: it never lowers a minimum.
    Gauss {
        /// The width σ in radians: for small σ the standard deviation along each of two perpendicular arcs.
        sigma: f64,
    },
    /// The least squares fit with `λ` times the integral of the squared Laplacian as a penalty.
    SquaredLaplacian {
        /// The weight `λ >= 0`; [`Window::squared_laplacian_of`] finds it.
        lambda: f64,
    },
    /// The blur of a directional or point light before it is added to a probe of order 3.
    PunctualLight,
}

impl Window {
    /// The names in text.
    pub const NAMES: [&'static str; 5] = ["hanning", "lanczos", "gauss", "squared-laplacian", "punctual-light"];

    /// The factor of band `l`.
    #[must_use]
    pub fn factor(&self, l: usize) -> f64 {
        let lf = l as f64;
        match *self {
            _ if l == 0 => 1.0,
            Self::Hanning { width } | Self::Lanczos { width, .. } if lf >= width => 0.0,
            Self::Hanning { width } => 0.5 * (1.0 + (PI * lf / width).cos()),
            Self::Lanczos { width, power } => {
                let x = PI * lf / width;
                // An endless width is no window.
                if x == 0.0 { 1.0 } else { (x.sin() / x).powf(power) }
            }
            Self::Gauss { sigma } => (-0.5 * sigma * sigma * lf * (lf + 1.0)).exp(),
            Self::SquaredLaplacian { lambda } => 1.0 / (1.0 + lambda * squared_eigenvalue(l)),
            Self::PunctualLight => [1.0, 0.92, 0.73].get(l).copied().unwrap_or(0.0),
        }
    }

    /// The factors of bands `0..order`.
    #[must_use]
    pub fn factors(&self, order: usize) -> Vec<f64> {
        (0..order).map(|l| self.factor(l)).collect()
    }

    /// The value at its peak of a windowed unit impulse of order `n`: `Σ_l (2l+1)/4π w_l`.
    #[must_use]
    pub fn impulse_peak(&self, order: usize) -> f64 {
        (0..order).map(|l| (2 * l + 1) as f64 / (4.0 * PI) * self.factor(l)).sum()
    }

    /// The squared Laplacian window that leaves `fraction` of the squared Laplacian of this function, summed over its
    /// channels; see [`squared_laplacian_lambda`].
    ///
    /// # Panics
    /// If `coefficients` are not `n²`.
    #[must_use]
    pub fn squared_laplacian_of<T: Coefficient>(coefficients: &[T], fraction: f64) -> Self {
        let energies = band_energies(coefficients);
        Self::SquaredLaplacian { lambda: squared_laplacian_lambda(&energies, fraction) }
    }
}

/// The width at which a window lowers the peak of a unit impulse of order `n` to `peak`, by bisection.
///
/// `window` makes the window of a width and must blur less with a larger one, as [`Window::Hanning`] and
/// [`Window::Lanczos`] do. `None` for a peak that is not between that of the mean alone, `1/4π`, and that without a
/// window, `n²/4π`, or that windows of powers near 0 jump over.
///
/// ```
/// use lobe_sh::Window;
/// use lobe_sh::filter::width_of_peak;
///
/// // Sloan 2008 compares windows of order 6 at the same peak.
/// let width = width_of_peak(6, 2.25, |width| Window::Hanning { width });
/// assert!(width.is_some_and(|width| (width - 12.010498388).abs() < 1e-9));
/// ```
#[must_use]
pub fn width_of_peak(order: usize, peak: f64, window: impl Fn(f64) -> Window) -> Option<f64> {
    /// How near the peak has to be: the rounding of sums over bands, and some more.
    const PEAK_TOLERANCE: f64 = 1e-9;
    /// The bits of a number and some more, for each end of the interval.
    const STEPS: usize = 120;

    let whole = (order * order) as f64 / (4.0 * PI);
    if !(peak > 1.0 / (4.0 * PI) && peak < whole) {
        return None;
    }
    let is_low = |width: f64| window(width).impulse_peak(order) < peak;
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..STEPS {
        if !is_low(high) {
            break;
        }
        (low, high) = (high, 2.0 * high);
    }
    for _ in 0..STEPS {
        let middle = 0.5 * (low + high);
        if is_low(middle) { low = middle } else { high = middle }
    }
    // Powers of Lanczos' window near 0 make a band jump from 0 to nearly 1: peaks between have no width.
    let is_met = (window(high).impulse_peak(order) - peak).abs() <= PEAK_TOLERANCE * peak;
    is_met.then_some(high)
}

/// Multiplies every band of a function by its factor; bands beyond the last factor become zero.
///
/// A factor of 1 changes no bit of its band.
///
/// # Panics
/// If `coefficients` are not `n²`.
pub fn scale_bands_in_place<T: Coefficient>(coefficients: &mut [T], factors: &[f64]) {
    for l in 0..order_of_slice(coefficients) {
        let factor = factors.get(l).copied().unwrap_or(0.0);
        for c in &mut coefficients[band_range(l)] {
            *c = T::narrow(c.widen().scale(factor));
        }
    }
}

/// Applies a window to a function.
///
/// # Panics
/// If `coefficients` are not `n²`.
pub fn window_in_place<T: Coefficient>(coefficients: &mut [T], window: &Window) {
    let factors = window.factors(order_of_slice(coefficients));
    scale_bands_in_place(coefficients, &factors);
}

impl fmt::Display for Window {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Hanning { width } => write!(f, "hanning:{width}"),
            Self::Lanczos { width, power } => write!(f, "lanczos:{width}:{power}"),
            Self::Gauss { sigma } => write!(f, "gauss:{sigma}"),
            Self::SquaredLaplacian { lambda } => write!(f, "squared-laplacian:{lambda}"),
            Self::PunctualLight => write!(f, "punctual-light"),
        }
    }
}

impl FromStr for Window {
    type Err = ShError;

    fn from_str(text: &str) -> Result<Self, ShError> {
        Self::parse(text).map_err(ShError::Options)
    }
}

impl Window {
    fn parse(text: &str) -> Result<Self, String> {
        let mut parts = text.split(':');
        let name = parts.next().unwrap_or_default();
        let numbers = parts
            .map(|part| match part.parse::<f64>() {
                Ok(number) if number >= 0.0 && number.is_finite() => Ok(number),
                _ => Err(format!("window {text}: expected a number of 0 or more, found '{part}'")),
            })
            .collect::<Result<Vec<f64>, String>>()?;
        let positive = |number: f64, what: &str| {
            if number > 0.0 { Ok(number) } else { Err(format!("window {text}: expected a {what} above 0")) }
        };
        match (name, numbers[..].as_ref()) {
            ("hanning", &[width]) => Ok(Self::Hanning { width: positive(width, "width")? }),
            ("lanczos", &[width]) => Ok(Self::Lanczos { width: positive(width, "width")?, power: 1.0 }),
            ("lanczos", &[width, power]) => {
                Ok(Self::Lanczos { width: positive(width, "width")?, power: positive(power, "power")? })
            }
            ("gauss", &[sigma]) => Ok(Self::Gauss { sigma }),
            ("squared-laplacian", &[lambda]) => Ok(Self::SquaredLaplacian { lambda }),
            ("punctual-light", []) => Ok(Self::PunctualLight),
            _ => Err(format!(
                "window {text}: expected hanning:WIDTH, lanczos:WIDTH[:POWER], gauss:SIGMA, squared-laplacian:LAMBDA or \
                 punctual-light"
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expansion::Expansion as _;
    use crate::expansion::ShVec;
    use crate::scalar::Rgb;
    use crate::sphere::Dir;
    use crate::sphere::quadrature::SphereQuadrature;
    use lobe_testkit::Random;

    #[test]
    fn the_published_widths_give_an_impulse_the_peak_9_4() {
        for (name, found, expected) in [
            ("Hanning", width_of_peak(6, 2.25, |width| Window::Hanning { width }), 12.010498388175),
            ("Lanczos", width_of_peak(6, 2.25, |width| Window::Lanczos { width, power: 1.0 }), 9.872527032259),
            ("Lanczos squared", width_of_peak(6, 2.25, |width| Window::Lanczos { width, power: 2.0 }), 13.712128048),
        ] {
            let found = found.unwrap();
            assert!((found - expected).abs() < 1e-9, "{name}: {found} against {expected}");
        }
    }

    #[test]
    fn peaks_that_no_width_gives_have_no_width() {
        let hanning = |width| Window::Hanning { width };
        let [mean, whole] = [1.0, 36.0].map(|n| n / (4.0 * PI));
        for peak in [0.0, mean, whole, 3.0, f64::NAN, f64::INFINITY] {
            assert_eq!(width_of_peak(6, peak, hanning), None, "a peak of {peak}");
        }
        assert_eq!(width_of_peak(0, 1.0, hanning), None, "no bands");
        for peak in [mean * 1.001, 1.0, whole * 0.999] {
            let found = hanning(width_of_peak(6, peak, hanning).unwrap()).impulse_peak(6);
            assert!((found - peak).abs() < 1e-12, "{found} against {peak}");
        }
    }

    #[test]
    fn windowed_impulses_have_their_published_extremes() {
        let extremes = |window: Window| {
            let f = ShVec::impulse(6, Dir::Z, 1.0).windowed(&window);
            let values = (0..=20_000).map(|k| f.eval(Dir::from_angles(PI * f64::from(k) / 20_000.0, 0.3)));
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)))
        };
        for (window, min, max) in [
            (Window::Hanning { width: 6.0 }, -0.037661, 1.116941),
            (Window::Lanczos { width: 6.0, power: 1.0 }, -0.073346, 1.454550),
            (Window::Hanning { width: 12.0105 }, -0.273423, 2.25),
            (Window::Lanczos { width: 9.8725, power: 1.0 }, -0.271956, 2.25),
            (Window::SquaredLaplacian { lambda: 0.004209 }, -0.072440, 1.456416),
            (Window::SquaredLaplacian { lambda: 0.000632 }, -0.266391, 2.346973),
            (Window::Gauss { sigma: 0.0 }, -0.477465, 2.864789),
        ] {
            let found = extremes(window);
            let close = (found.0 - min).abs() < 2e-6 && (found.1 - max).abs() < 1e-5;
            assert!(close, "{window}: {found:?} against {:?}", (min, max));
        }
    }

    #[test]
    fn the_heat_kernel_is_positive_where_enough_bands_hold_it() {
        let kernel = ShVec::impulse(40, Dir::Z, 1.0).windowed(&Window::Gauss { sigma: 0.25 });
        for k in 0..=1000 {
            let value = kernel.eval(Dir::from_angles(PI * f64::from(k) / 1000.0, 1.0));
            assert!(value > -1e-12, "{value} at {k} thousandths of π");
        }
        let spread: f64 = SphereQuadrature::of_degree(41).integrate(|s| kernel.eval(s) * 2.0 * (1.0 - s.z()));
        assert!((spread / (2.0 * 0.25 * 0.25) - 1.0).abs() < 0.07, "mean squared chord {spread}, two axes of 0.25²");
    }

    #[test]
    fn windows_never_touch_the_mean_and_unit_factors_touch_nothing() {
        let f: Vec<Rgb> =
            Random::new(1).signed_vec(75).chunks(3).map(|c| Rgb::new(c[0] as f32, c[1] as f32, c[2] as f32)).collect();
        for name in ["hanning:3.5", "lanczos:5:4", "gauss:1.2", "squared-laplacian:0.1", "punctual-light"] {
            let mut g = f.clone();
            window_in_place(&mut g, &name.parse().unwrap());
            assert_eq!(g[0], f[0], "the mean under {name}");
            assert_ne!(g[1..], f[1..], "the rest under {name}");
        }
        let mut g = f.clone();
        scale_bands_in_place(&mut g, &[1.0; 5]);
        assert_eq!(g, f, "factors of 1");
    }

    #[test]
    fn windows_are_read_as_they_are_written() {
        for text in ["hanning:12.5", "lanczos:9:4", "gauss:0.25", "squared-laplacian:0.0042", "punctual-light"] {
            let window: Window = text.parse().unwrap();
            assert_eq!(window.to_string(), text, "there and back");
            assert!(Window::NAMES.iter().any(|name| text.starts_with(name)), "{text} begins with a name");
        }
        assert_eq!("lanczos:6".parse().ok(), Some(Window::Lanczos { width: 6.0, power: 1.0 }), "the default power");
    }

    #[test]
    fn what_is_no_window_is_refused_in_one_line() {
        for (text, part) in [
            ("", "expected hanning:WIDTH"),
            ("hanning", "expected hanning:WIDTH"),
            ("hanning:0", "a width above 0"),
            ("lanczos:4:0", "a power above 0"),
            ("gauss:-1", "found '-1'"),
            ("gauss:nan", "found 'nan'"),
            ("squared-laplacian:inf", "found 'inf'"),
            ("punctual-light:3", "expected hanning:WIDTH"),
        ] {
            let message = text.parse::<Window>().unwrap_err().to_string();
            assert!(message.contains(part) && !message.contains('\n'), "'{text}': {message}");
        }
    }
}
