//! `lobe sh exp`: the exponential of a log-visibility, what several occluders leave visible.

use anyhow::bail;
use clap::Args;
use lobe::sh::expansion::Quantity;
use lobe::sh::exponential::{ExpMethod, Exponential};
use lobe::sh::sh_json::{FileCoefficients, ShFile};
use lobe::sh::{Coefficient as _, Expansion as _, Rgb, ShVec};
use serde::Serialize;

use crate::args::input::ShInput;
use crate::args::output::{self, ShOutput};
use crate::run::talk::Talk;

/// The highest order of logarithms and exponentials: the eigenvectors of one function of order 10 take a second.
const MOST_BANDS: usize = 10;

/// With two digits and this factor no bound is printed as less than it is.
const ROUNDED_UP: f64 = 1.05;

const JSON_HELP: &str = r#"Print {"error_bound"}: for each channel a bound on the norm of the error, of grid against the projection of the true exponential, of series against eigen; null by the other methods, which have none"#;

#[derive(Args)]
pub(crate) struct ShExp {
    /// The log-visibility, a .sh.json file, such as a sum of logarithms; - reads stdin
    #[arg(value_name = "Q")]
    input: ShInput,
    /// How: on a grid of directions; by the best linear function; that after halving to a NORM (1), then squared; by P truncated products;
    /// by eigenvectors of the product matrix
    #[arg(long, value_name = "grid|optimal-linear|hybrid[:NORM]|series:P|eigen", default_value = "grid")]
    method: ExpMethod,
    /// The visibility, a .sh.json file; - writes to stdout
    #[arg(short, long, value_name = "P")]
    output: ShOutput,
    #[arg(long, help = JSON_HELP)]
    json: bool,
}

/// The JSON of `--json`.
#[derive(Serialize)]
struct Report {
    error_bound: Vec<Option<f64>>,
}

impl ShExp {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        if self.json && self.output == ShOutput::Stdout {
            bail!("stdout: both the expansion and the JSON would go there; name a file for -o, or leave --json out");
        }
        self.output.check()?;
        let file = self.input.read()?;
        expect(&self.input, file.quantity, Quantity::LogVisibility)?;
        check_order(&self.input, &file.coefficients)?;
        let exponential = Exponential::new(file.coefficients.order(), self.method);
        let visibility = by_channel(&file.coefficients, |f| exponential.of(f));
        if !is_finite(&visibility) {
            bail!(
                "{}: its exponential is not finite; expected the logarithm of a visibility, which is at most 0",
                self.input
            );
        }
        self.output.write(&ShFile::new(Quantity::Visibility, visibility))?;
        let error_bound = channels(&file.coefficients).iter().map(|f| exponential.error_bound(f)).collect();
        if self.json {
            return output::print_json(&Report { error_bound });
        }
        if let Some(text) = in_words(&error_bound) {
            talk.note(&self.input.to_string(), &text);
        }
        Ok(())
    }
}

/// The largest bound of the channels, if the method has one.
fn in_words(bounds: &[Option<f64>]) -> Option<String> {
    let worst = bounds.iter().flatten().copied().reduce(f64::max)?;
    Some(format!("the norm of the error of its exponential is at most {:.1e}", ROUNDED_UP * worst))
}

/// Whether every coefficient is a finite number.
fn is_finite(coefficients: &FileCoefficients) -> bool {
    coefficients.to_rgb().coefficients().iter().all(|c| c.to_array().into_iter().all(f64::is_finite))
}

/// Refuses another quantity than the one that a command is for.
pub(crate) fn expect(input: &ShInput, found: Quantity, expected: Quantity) -> anyhow::Result<()> {
    if found != expected {
        let hint = match expected {
            Quantity::LogVisibility => "lobe sh log makes it of visibility",
            _ => "lobe sh exp makes it of log-visibility",
        };
        bail!("{input}: expected {expected}, found {found}; {hint}");
    }
    Ok(())
}

/// Refuses orders that would take minutes.
pub(crate) fn check_order(input: &ShInput, coefficients: &FileCoefficients) -> anyhow::Result<()> {
    let order = coefficients.order();
    if order > MOST_BANDS {
        bail!("{input}: expected order {MOST_BANDS} at most, found {order}; shadows this soft need no more than 8");
    }
    Ok(())
}

/// The same function of every channel.
pub(crate) fn by_channel(
    coefficients: &FileCoefficients,
    function: impl Fn(&ShVec<f64>) -> ShVec<f64>,
) -> FileCoefficients {
    match coefficients {
        FileCoefficients::Scalar(f) => function(f).into(),
        FileCoefficients::Rgb(f) => {
            let [r, g, b] = colors(f).map(|f| function(&f));
            let mut out = f.clone();
            for (i, c) in out.coefficients_mut().iter_mut().enumerate() {
                *c = Rgb::new(r[i], g[i], b[i]);
            }
            out.into()
        }
    }
}

/// Every channel by itself.
fn channels(coefficients: &FileCoefficients) -> Vec<ShVec<f64>> {
    match coefficients {
        FileCoefficients::Scalar(f) => vec![f.clone()],
        FileCoefficients::Rgb(f) => colors(f).into(),
    }
}

fn colors(f: &ShVec<Rgb<f64>>) -> [ShVec<f64>; 3] {
    [0, 1, 2].map(|k| f.map(|c| c.channel(k)))
}
