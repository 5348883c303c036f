//! `lobe sh convolve`: convolution of an expansion with a zonal kernel.

use std::ffi::OsString;
use std::str::FromStr;

use anyhow::bail;
use clap::Args;
use lobe::sh::basis::{band_and_m, coefficient_index};
use lobe::sh::expansion::Quantity;
use lobe::sh::sh_json::{FileCoefficients, ShFile};
use lobe::sh::{Coefficient as _, Expansion as _, Rgb, ShVec, Zonal};

use crate::args::input::ShInput;
use crate::args::output::{QuantityOption, ShOutput};
use crate::args::values;
use crate::run::talk::Talk;

/// The largest coefficient with m ≠ 0 that a kernel may have, relative to the largest coefficient of all: above the
/// rounding of a kernel that was projected from a picture in `f32`, below what a picture could show.
const ZONAL_TOLERANCE: f64 = 1e-6;

#[derive(Args)]
pub(crate) struct ShConvolve {
    /// The expansion, a .sh.json file; - reads stdin
    #[arg(value_name = "P")]
    input: ShInput,
    /// cosine: radiance becomes irradiance, not divided by π; phong:E: lobe cos^E, E >= 0; ggx:ALPHA: lobe of a mirror
    /// of roughness ALPHA, 0 to 1 (both integrate to 1); or a .sh.json file of a function of the angle from +z
    #[arg(long, value_name = "cosine|phong:E|ggx:ALPHA|Z.sh.json")]
    kernel: Kernel,
    #[command(flatten)]
    quantity: QuantityOption,
    /// The convolution, a .sh.json file; - writes to stdout
    #[arg(short, long, value_name = "Q")]
    output: ShOutput,
}

/// A kernel as it is named on the command line.
#[derive(Clone, Debug, PartialEq)]
enum Kernel {
    Cosine,
    Phong(f64),
    Ggx(f64),
    File(ShInput),
}

impl FromStr for Kernel {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if let Some(exponent) = text.strip_prefix("phong:") {
            return match values::finite(exponent)? {
                e if e >= 0.0 => Ok(Self::Phong(e)),
                e => Err(format!("a Phong exponent is 0 or more, not {e}")),
            };
        }
        if let Some(alpha) = text.strip_prefix("ggx:") {
            return match values::finite(alpha)? {
                a if (0.0..=1.0).contains(&a) => Ok(Self::Ggx(a)),
                a => Err(format!("a GGX roughness lies between 0 and 1, it is not {a}")),
            };
        }
        match text {
            "cosine" => Ok(Self::Cosine),
            file if file == "-" || file.ends_with(".json") => Ok(Self::File(OsString::from(file).into())),
            _ => Err("expected cosine, phong:E, ggx:ALPHA or a file that ends in .json".to_owned()),
        }
    }
}

impl ShConvolve {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        self.output.check()?;
        let (p, kernel) = match &self.kernel {
            Kernel::File(kernel) => {
                let (p, kernel_file) = ShInput::read_two(&self.input, kernel)?;
                let zonal = match zonal_channels(&kernel_file.coefficients) {
                    Ok(zonal) => zonal,
                    Err(why) => bail!("{kernel}: {why}"),
                };
                self.note_missing_bands(&p, &zonal[0], talk);
                (p, zonal)
            }
            formula => {
                let p = self.input.read()?;
                let zonal = zonal_of_formula(formula, p.coefficients.order());
                (p, vec![zonal])
            }
        };
        let quantity = match self.quantity.or(self.kernel.quantity_of_result(p.quantity)) {
            Ok(quantity) => quantity,
            Err(why) => bail!("{}: {why}", self.input),
        };
        self.output.write(&ShFile::new(quantity, convolve(p.coefficients, &kernel)))
    }

    fn note_missing_bands(&self, p: &ShFile, kernel: &Zonal, talk: Talk) {
        let (n, k) = (p.coefficients.order(), kernel.order());
        if k < n {
            let text = format!("{} has order {n}, the kernel order {k}; the bands from {k} on become zero", self.input);
            talk.note("--kernel", &text);
        }
    }
}

impl Kernel {
    /// The quantity of a convolution, or the reason that it has none.
    fn quantity_of_result(&self, p: Quantity) -> Result<Quantity, String> {
        let is_light = matches!(p, Quantity::Radiance | Quantity::Visibility);
        match (self, p) {
            (Self::File(_), p) => Ok(p),
            (_, Quantity::Function) => Ok(p),
            (Self::Cosine, _) if is_light => Ok(Quantity::Irradiance),
            (_, _) if is_light => Ok(p),
            (_, Quantity::Irradiance) => {
                Err("this is irradiance, the cosine is in it already; expected radiance or visibility".to_owned())
            }
            (_, Quantity::Transfer) => {
                Err("this is transfer, the cosine is in it already; expected radiance or visibility".to_owned())
            }
            _ => Err(format!("{p} is a logarithm, its convolution has no meaning; expected radiance or visibility")),
        }
    }
}

/// The kernel of a formula, to the order of what it is convolved with.
fn zonal_of_formula(kernel: &Kernel, order: usize) -> Zonal {
    match *kernel {
        Kernel::Phong(exponent) => Zonal::phong(order, exponent),
        Kernel::Ggx(alpha) => Zonal::ggx(order, alpha),
        Kernel::Cosine | Kernel::File(_) => Zonal::clamped_cosine(order),
    }
}

/// The kernel in a file, one for each channel; or why it is no kernel.
fn zonal_channels(file: &FileCoefficients) -> Result<Vec<Zonal>, String> {
    match file {
        FileCoefficients::Scalar(f) => Ok(vec![zonal(f)?]),
        FileCoefficients::Rgb(f) => (0..3).map(|c| zonal(&f.map(|rgb| rgb.channel(c)))).collect(),
    }
}

fn zonal(f: &ShVec<f64>) -> Result<Zonal, String> {
    let largest = f.coefficients().iter().fold(0.0_f64, |largest, c| largest.max(c.abs()));
    for (i, c) in f.coefficients().iter().enumerate() {
        let (l, m) = band_and_m(i);
        if m != 0 && c.abs() > ZONAL_TOLERANCE * largest {
            return Err(format!(
                "expected a kernel that is symmetric about +z, but coefficient {i} (l = {l}, m = {m}) is {c}, not 0"
            ));
        }
    }
    Ok(Zonal::new((0..f.order()).map(|l| f[coefficient_index(l, 0)]).collect()))
}

/// Convolves with one kernel for all channels, or with one for each of three.
fn convolve(p: FileCoefficients, kernels: &[Zonal]) -> FileCoefficients {
    match (p, kernels) {
        (FileCoefficients::Scalar(f), [kernel]) => f.convolved(kernel).into(),
        (FileCoefficients::Rgb(f), [kernel]) => f.convolved(kernel).into(),
        (p, kernels) => {
            let rgb = p.to_rgb();
            let channels: Vec<ShVec<f64>> =
                kernels.iter().enumerate().map(|(c, k)| rgb.map(|v| v.channel(c)).convolved(k)).collect();
            let mut out = rgb;
            for (i, out) in out.coefficients_mut().iter_mut().enumerate() {
                *out = Rgb::from_channels(|c| channels[c][i]);
            }
            out.into()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kernels_are_read_as_they_are_written_in_the_help() {
        for (text, kernel) in [
            ("cosine", Kernel::Cosine),
            ("phong:20", Kernel::Phong(20.0)),
            ("ggx:0.25", Kernel::Ggx(0.25)),
            ("-", Kernel::File(ShInput::Stdin)),
            ("z.sh.json", Kernel::File(ShInput::File("z.sh.json".into()))),
        ] {
            assert_eq!(text.parse(), Ok(kernel), "{text}");
        }
    }

    #[test]
    fn kernels_out_of_range_are_refused() {
        for (text, part) in [
            ("cosin", "expected cosine, phong:E, ggx:ALPHA or a file"),
            ("phong:-1", "0 or more, not -1"),
            ("phong:", "expected a finite number"),
            ("ggx:1.5", "between 0 and 1, it is not 1.5"),
            ("ggx:nan", "expected a finite number"),
        ] {
            let message = text.parse::<Kernel>().unwrap_err();
            assert!(message.contains(part), "{text}: {message}");
        }
    }

    #[test]
    fn only_light_is_convolved_with_lobes() {
        for (p, cosine, phong) in [
            (Quantity::Radiance, Some(Quantity::Irradiance), Some(Quantity::Radiance)),
            (Quantity::Visibility, Some(Quantity::Irradiance), Some(Quantity::Visibility)),
            (Quantity::Irradiance, None, None),
            (Quantity::Transfer, None, None),
            (Quantity::LogVisibility, None, None),
            (Quantity::Function, Some(Quantity::Function), Some(Quantity::Function)),
        ] {
            assert_eq!(Kernel::Cosine.quantity_of_result(p).ok(), cosine, "cosine of {p}");
            assert_eq!(Kernel::Phong(3.0).quantity_of_result(p).ok(), phong, "phong of {p}");
            assert_eq!(Kernel::File(ShInput::Stdin).quantity_of_result(p), Ok(p), "a file's kernel with {p}");
        }
    }

    #[test]
    fn each_channel_may_have_its_own_kernel() {
        let p = FileCoefficients::from(ShVec::from_vec(vec![1.0, 2.0, 3.0, 4.0]).unwrap());
        let kernels = [1.0, 2.0, 3.0].map(|f| Zonal::from_convolution_factors([f, 10.0 * f]));
        let expected =
            [(1.0, 1.0), (2.0, 10.0), (3.0, 10.0), (4.0, 10.0)].map(|(c, f)| Rgb::new(c * f, 2.0 * c * f, 3.0 * c * f));
        let FileCoefficients::Rgb(found) = convolve(p, &kernels) else { panic!("colors become colors") };
        for (a, b) in found.coefficients().iter().zip(expected) {
            for c in 0..3 {
                assert!((a.channel(c) - b.channel(c)).abs() < 1e-12, "{a:?} against {b:?}");
            }
        }
    }
}
