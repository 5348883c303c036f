//! `lobe sh window`: window functions over the bands of an expansion, which trade ringing for blur.

use std::f64::consts::PI;

use anyhow::bail;
use clap::{Args, ValueEnum};
use lobe::env::damp_zonal_in_place;
use lobe::sh::filter::width_of_peak;
use lobe::sh::ringing::ContentWindow;
use lobe::sh::sh_json::{FileCoefficients, ShFile};
use lobe::sh::{Coefficient, Expansion as _, ShVec, Window};

use crate::args::input::ShInput;
use crate::args::output::ShOutput;
use crate::args::values;
use crate::run::talk::Talk;

/// The power of the sigma factors that is named by its own.
const SINC4: f64 = 4.0;

/// Bands that the window for punctual lights leaves.
const PUNCTUAL_BANDS: usize = 3;

#[derive(Args)]
pub(crate) struct ShWindow {
    /// The expansion, a .sh.json file; - reads stdin
    #[arg(value_name = "P")]
    input: ShInput,
    /// The factors of the bands
    #[arg(long, value_enum)]
    kind: Kind,
    /// hanning, lanczos, sinc4: the band at which the factors reach zero [default: the order, the first band that is
    /// missing]; gauss: the standard deviation in degrees
    #[arg(long, value_name = "W", allow_hyphen_values = true, value_parser = values::positive)]
    width: Option<f64>,
    /// hanning, lanczos, sinc4: in place of a width, the value that a unit impulse of the order of P keeps at its peak,
    /// between 1/4π, its mean, and n²/4π, which it has without a window; finds the width
    #[arg(long, value_name = "V", allow_hyphen_values = true, value_parser = values::positive, conflicts_with = "width")]
    peak: Option<f64>,
    /// lanczos: the power of the sigma factors, above 0 [default: 1]
    #[arg(long, value_name = "P", allow_hyphen_values = true, value_parser = values::positive)]
    power: Option<f64>,
    /// laplacian: the weight of the squared Laplacian, 0 or more
    #[arg(long, value_name = "L", allow_hyphen_values = true, value_parser = weight, conflicts_with = "keep")]
    lambda: Option<f64>,
    /// laplacian: the part of the squared Laplacian that is left, above 0 and up to 1, channels summed; finds the weight
    #[arg(long, value_name = "F", allow_hyphen_values = true, value_parser = fraction)]
    keep: Option<f64>,
    /// Leave the function as it is towards its light, the direction of band 1, and let the window come in away from it
    #[arg(long)]
    content: bool,
    /// With --content: the order that is written; the blend needs more bands than the input [default: that of the input]
    #[arg(long, value_name = "N", value_parser = values::order, requires = "content")]
    order: Option<usize>,
    /// The expansion under the window, a .sh.json file; - writes to stdout
    #[arg(short, long, value_name = "Q")]
    output: ShOutput,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Kind {
    /// A raised cosine
    Hanning,
    /// The sigma factors, sin(πl/W)/(πl/W), to the power P
    Lanczos,
    /// The heat kernel of the sphere, which never makes light negative
    Gauss,
    /// Least squares with the squared Laplacian as a penalty, 1/(1 + L l²(l+1)²)
    Laplacian,
    /// The sigma factors to the fourth power
    Sinc4,
    /// 1, 0.92, 0.73: for a point light before it is added to a probe of order 3
    Punctual,
    /// The sigma factors on m = 0 alone, which holds the step of a sky at its horizon; a sun loses a few percent of its peak, near the zenith up
    /// to half. Not rotation invariant: before anything is turned
    Horizon,
}

fn weight(text: &str) -> Result<f64, String> {
    match values::finite(text)? {
        x if x >= 0.0 => Ok(x),
        x => Err(format!("expected a weight of 0 or more, found {x}")),
    }
}

fn fraction(text: &str) -> Result<f64, String> {
    match values::finite(text)? {
        x if x > 0.0 && x <= 1.0 => Ok(x),
        x => Err(format!("expected a fraction above 0 and up to 1, found {x}")),
    }
}

impl ShWindow {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        self.check_options()?;
        self.output.check()?;
        let file = if self.content { self.input.read_to_search()? } else { self.input.read()? };
        let coefficients: FileCoefficients = match file.coefficients {
            FileCoefficients::Scalar(f) => self.windowed(&f, talk)?.into(),
            FileCoefficients::Rgb(f) => self.windowed(&f, talk)?.into(),
        };
        self.output.write(&ShFile::new(file.quantity, coefficients))
    }

    /// An option that would be ignored is a misunderstanding.
    fn check_options(&self) -> anyhow::Result<()> {
        let has_width = !matches!(self.kind, Kind::Laplacian | Kind::Punctual | Kind::Horizon);
        if self.width.is_some() && !has_width {
            bail!(
                "--width: only hanning, lanczos, sinc4 and gauss have one; choose one of them, or leave the width out"
            );
        }
        if self.peak.is_some() && !matches!(self.kind, Kind::Hanning | Kind::Lanczos | Kind::Sinc4) {
            bail!(
                "--peak: only the width of hanning, lanczos and sinc4 follows from it; choose one of them, or leave it out"
            );
        }
        if self.power.is_some() && self.kind != Kind::Lanczos {
            bail!("--power: only --kind lanczos has one; choose it, or leave the power out");
        }
        if self.content && self.kind == Kind::Horizon {
            bail!(
                "--content: horizon knows no light, it damps the same everywhere; choose another --kind, or leave --content out"
            );
        }
        let is_laplacian = self.kind == Kind::Laplacian;
        for (option, is_given) in [("--lambda", self.lambda.is_some()), ("--keep", self.keep.is_some())] {
            if is_given && !is_laplacian {
                bail!("{option}: only --kind laplacian has a weight; choose it, or leave {option} out");
            }
        }
        if is_laplacian && self.lambda.is_none() && self.keep.is_none() {
            bail!("--kind laplacian: expected a weight, --lambda L, or the fraction that is left, --keep F");
        }
        if self.kind == Kind::Gauss && self.width.is_none() {
            bail!("--kind gauss: expected its standard deviation in degrees, --width W");
        }
        Ok(())
    }

    fn windowed<T: Coefficient<Scalar = f64>>(&self, f: &ShVec<T>, talk: Talk) -> anyhow::Result<ShVec<T>> {
        let order = f.order();
        if self.kind == Kind::Horizon {
            let mut damped = f.clone();
            damp_zonal_in_place(damped.coefficients_mut());
            return Ok(damped);
        }
        let window = self.window(f)?;
        let subject = self.input.to_string();
        if let (Some(peak), Window::Hanning { width } | Window::Lanczos { width, .. }) = (self.peak, window) {
            talk.note(&subject, &format!("--width {width} lowers the peak of a unit impulse to {peak}"));
        }
        if let (Some(keep), Window::SquaredLaplacian { lambda }) = (self.keep, window) {
            talk.note(&subject, &format!("--lambda {lambda} leaves {keep} of the squared Laplacian"));
        }
        if self.kind == Kind::Punctual && order > PUNCTUAL_BANDS {
            let text = format!("order {order}; punctual is made for order {PUNCTUAL_BANDS}, later bands become zero");
            talk.note(&subject, &text);
        }
        Ok(if self.content { self.blended(f, window, talk) } else { f.windowed(&window) })
    }

    /// The function towards its light, the window away from it, and what the order that is written loses of that.
    fn blended<T: Coefficient<Scalar = f64>>(&self, f: &ShVec<T>, window: Window, talk: Talk) -> ShVec<T> {
        let subject = self.input.to_string();
        let content = ContentWindow::of(f, window);
        let order = self.order.unwrap_or(f.order());
        let blend = content.project(f, order);
        let Some(dir) = content.dir else {
            talk.note(&subject, "--content: band 1 has no direction; the window is applied everywhere");
            return blend;
        };
        let energy = content.energy(f);
        let kept: f64 = (0..T::CHANNELS).map(|c| blend.dot(&blend).channel(c)).sum();
        // Rounding can make it negative.
        let lost = (1.0 - kept / energy).max(0.0).sqrt();
        let [x, y, z] = dir.to_array();
        let text = format!(
            "as it is towards {x:.4},{y:.4},{z:.4}; order {order} leaves out {:.2} % of the root mean square",
            100.0 * lost
        );
        talk.note(&subject, &text);
        blend
    }

    fn window<T: Coefficient>(&self, f: &ShVec<T>) -> anyhow::Result<Window> {
        Ok(match (self.kind, self.lambda, self.keep) {
            (Kind::Laplacian, None, Some(keep)) => Window::squared_laplacian_of(f.coefficients(), keep),
            (Kind::Laplacian, lambda, _) => Window::SquaredLaplacian { lambda: lambda.unwrap_or(0.0) },
            (Kind::Punctual, ..) => Window::PunctualLight,
            _ => self.of_width(self.used_width(f.order())?),
        })
    }

    /// The window of the kinds that have a width.
    fn of_width(&self, width: f64) -> Window {
        match self.kind {
            Kind::Hanning => Window::Hanning { width },
            Kind::Gauss => Window::Gauss { sigma: width.to_radians() },
            Kind::Sinc4 => Window::Lanczos { width, power: SINC4 },
            _ => Window::Lanczos { width, power: self.power.unwrap_or(1.0) },
        }
    }

    /// The width as given, of the peak that is wanted, or the order.
    fn used_width(&self, order: usize) -> anyhow::Result<f64> {
        let Some(peak) = self.peak else { return Ok(self.width.unwrap_or(order as f64)) };
        let Some(width) = width_of_peak(order, peak, |width| self.of_width(width)) else {
            let [mean, whole] = [1, order * order].map(|n| n as f64 / (4.0 * PI));
            if mean < peak && peak < whole {
                bail!("{}: --peak: no width of this window has the peak {peak}; take a larger --power", self.input);
            }
            bail!(
                "{}: --peak: expected a value between {mean:.6} and {whole:.6}, the mean and the peak of an impulse of \
                 order {order}, found {peak}",
                self.input
            );
        };
        Ok(width)
    }
}
