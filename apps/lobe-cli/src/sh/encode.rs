//! `lobe sh encode`: irradiance in a compact encoding, or as the constants of a shader.

use std::f64::consts::FRAC_1_PI;
use std::fmt::Write as _;

use anyhow::bail;
use clap::{Args, ValueEnum};
use lobe::sh::encoding::{
    EngineForm, EngineFrame, IrradianceEncoding, IrradianceMatrix, IrradiancePolynomial, PackedIrradiance,
    PackedIrradiance5,
};
use lobe::sh::expansion::Quantity;
use lobe::sh::rotation::{AxisPermutation, tangent_frame};
use lobe::sh::sh_json::FileCoefficients;
use lobe::sh::{Coefficient, Dir, Expansion as _, Rgb, ShError, ShVec, Zonal};
use serde::Serialize;

use crate::args::input::ShInput;
use crate::args::output;
use crate::args::values;
use crate::run::talk::Talk;

/// Bands of encodings of order 5.
const BANDS_OF_5: usize = 5;

const JSON_HELP: &str = r#"Print {"encoding", "floats", "of": "E", "E/pi", "L" or "L/pi", "up", "numbers": [{"name", "values"}]} instead of lines"#;

#[derive(Args)]
pub(crate) struct ShEncode {
    /// The expansion of irradiance, or of radiance, whose irradiance is taken; a .sh.json file; - reads stdin
    #[arg(value_name = "P")]
    input: ShInput,
    /// An encoding of lobe sh encodings; packed: the seven vectors cAr .. cC of Sloan's shader; matrix: the 4x4
    /// matrices of Ramamoorthi and Hanrahan, row after row; r-h: their nine coefficients L00 .. L22 of radiance, without
    /// the Condon-Shortley phase (these three colors, three bands); packed-5: fourteen vectors cAr .. cG of order 5, for
    /// light of high contrast (colors; P of five bands). three, babylon, playcanvas, filament, godot, unity, unreal,
    /// cesium: nine colors as that engine keeps them, in its order and its frame, which lobe import reads back.
    /// Coefficients for pyshtools, healpy, e3nn or Ambisonics are written by lobe sh convert --to
    #[arg(long = "as", value_name = "NAME|packed|packed-5|matrix|r-h|ENGINE", value_parser = form)]
    form: Form,
    /// For encodings of one side of a surface: its geometric normal [default: 0,0,1]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = values::dir)]
    normal: Option<Dir>,
    /// Divide by π: not the irradiance E, but what a white matte surface leaves of it, as the shaders of Sloan's paper,
    /// Direct3D and Unity expect
    #[arg(long)]
    over_pi: bool,
    /// The axis that points up where the numbers are used: y for glTF, OpenGL, Unity; directions, that of --normal
    /// too, are then (x, z, -y) of Lobe's [default: z; of an engine its own]
    #[arg(long, value_enum)]
    up: Option<Up>,
    #[arg(long, help = JSON_HELP)]
    json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum Up {
    Y,
    Z,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Form {
    Encoding(IrradianceEncoding),
    Packed,
    Packed5,
    Matrix,
    Polynomial,
    Engine(EngineForm),
}

impl Form {
    /// Whether it holds only the normals on one side of a surface.
    fn is_one_sided(self) -> bool {
        matches!(self, Self::Encoding(encoding) if encoding.is_hemispherical())
    }
}

fn form(text: &str) -> Result<Form, String> {
    match text {
        "packed" => Ok(Form::Packed),
        "packed-5" => Ok(Form::Packed5),
        "matrix" => Ok(Form::Matrix),
        "r-h" => Ok(Form::Polynomial),
        _ => text.parse().map(Form::Engine).or_else(|_| text.parse().map(Form::Encoding)).map_err(|e: ShError| {
            let engines = EngineForm::ALL.map(EngineForm::name).join(", ");
            e.to_string().replacen("one of", &format!("packed, packed-5, matrix, r-h, {engines} or one of"), 1)
        }),
    }
}

/// The JSON of `--json`.
#[derive(Serialize)]
struct Encoded {
    encoding: &'static str,
    floats: usize,
    of: &'static str,
    up: &'static str,
    numbers: Vec<Row>,
}

/// Numbers that belong together: the channels of a coefficient, or a vector.
#[derive(Serialize)]
struct Row {
    name: String,
    values: Vec<f64>,
}

fn row(name: impl Into<String>, values: impl Into<Vec<f64>>) -> Row {
    Row { name: name.into(), values: values.into() }
}

/// The vectors of three channels, named by a letter: `cAr`, `cAg`, `cAb`.
fn vectors(letter: char, values: [[f64; 4]; 3]) -> impl Iterator<Item = Row> {
    ['r', 'g', 'b'].into_iter().zip(values).map(move |(channel, v)| row(format!("c{letter}{channel}"), v))
}

impl ShEncode {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        if self.normal.is_some() && !self.form.is_one_sided() {
            bail!("--normal: only of encodings of one side of a surface, such as h-4; leave the option out");
        }
        if let Form::Engine(engine) = self.form {
            return self.print(&self.of_engine(engine)?);
        }
        let file = self.input.read()?;
        let order = match &file.coefficients {
            FileCoefficients::Scalar(f) => f.order(),
            FileCoefficients::Rgb(f) => f.order(),
        };
        if order < BANDS_OF_5 && matches!(self.form, Form::Packed5 | Form::Encoding(IrradianceEncoding::Sh5)) {
            let text =
                format!("order {order}; the numbers of its fifth band are zero (lobe project --order 5 finds them)");
            talk.note(&self.input.to_string(), &text);
        }
        let encoded = match (file.quantity, file.coefficients) {
            (Quantity::Irradiance, FileCoefficients::Scalar(f)) => self.encoded(&f),
            (Quantity::Irradiance, FileCoefficients::Rgb(f)) => self.encoded(&f),
            (Quantity::Radiance, FileCoefficients::Scalar(f)) => self.encoded(&irradiance_of(&f)),
            (Quantity::Radiance, FileCoefficients::Rgb(f)) => self.encoded(&irradiance_of(&f)),
            (found, _) => bail!("{}: expected radiance or irradiance, found {found}", self.input),
        };
        self.print(&encoded)
    }

    fn print(&self, encoded: &Encoded) -> anyhow::Result<()> {
        if self.json { output::print_json(encoded) } else { output::print(&encoded.text()) }
    }

    /// The numbers of an engine, which says itself what they are of.
    fn of_engine(&self, engine: EngineForm) -> anyhow::Result<Encoded> {
        let ignored = [(self.over_pi, "--over-pi"), (self.up.is_some(), "--up")];
        if let Some((_, option)) = ignored.into_iter().find(|(is_given, _)| *is_given) {
            bail!("{option}: the form of {engine} says it by itself; leave the option out");
        }
        let file = self.input.read()?;
        let quantity = file.quantity;
        let colors = match file.coefficients {
            FileCoefficients::Scalar(f) => f.map(|c| Rgb::new(c, c, c)),
            FileCoefficients::Rgb(f) => f,
        };
        let colors = match quantity {
            Quantity::Radiance => engine.encode(&colors),
            Quantity::Irradiance => engine.encode_irradiance(&colors),
            found => bail!("{}: expected radiance or irradiance, found {found}", self.input),
        };
        let places = engine.places();
        let numbers = if engine.is_planar() {
            let flat = engine.flat(&colors);
            ["r", "g", "b"].into_iter().zip(flat.chunks(9)).map(|(channel, values)| row(channel, values)).collect()
        } else {
            places.into_iter().zip(colors).map(|(place, color)| row(place, color.to_array())).collect()
        };
        let up = match engine.frame() {
            EngineFrame::YUp => "y",
            EngineFrame::YUpLeftHanded => "left-handed, y",
            EngineFrame::ZUp => "z",
            EngineFrame::ZUpLeftHanded => "left-handed, z",
        };
        Ok(Encoded { encoding: engine.name(), floats: 27, of: engine.quantity(), up, numbers })
    }

    fn encoded<T: Coefficient<Scalar = f64>>(&self, irradiance: &ShVec<T>) -> Encoded {
        let (of, factor) = match (self.form, self.over_pi) {
            (Form::Polynomial, false) => ("L", 1.0),
            (Form::Polynomial, true) => ("L/pi", FRAC_1_PI),
            (_, false) => ("E", 1.0),
            (_, true) => ("E/pi", FRAC_1_PI),
        };
        let scaled = irradiance.map(|e| e.scale(factor));
        let (up, turned) = match self.up.unwrap_or(Up::Z) {
            Up::Z => ("z", scaled),
            Up::Y => ("y", scaled.permuted(&AxisPermutation::Y_UP_FROM_Z_UP)),
        };
        let (encoding, floats, numbers) = self.numbers(&turned);
        Encoded { encoding, floats, of, up, numbers }
    }

    /// The name of the encoding, the number of its floats, and the floats.
    fn numbers<T: Coefficient<Scalar = f64>>(&self, irradiance: &ShVec<T>) -> (&'static str, usize, Vec<Row>) {
        let colors = || irradiance.map(|e| Rgb::from_channels(|c| e.channel(c % T::CHANNELS)));
        match self.form {
            Form::Packed => {
                let PackedIrradiance { a, b, c } = PackedIrradiance::from_irradiance_sh(&colors());
                ("packed", 27, vectors('A', a).chain(vectors('B', b)).chain([row("cC", c)]).collect())
            }
            Form::Packed5 => {
                let PackedIrradiance5 { a, b, c, d, f, g } = PackedIrradiance5::from_irradiance_sh(&colors());
                let order_3 = vectors('A', a).chain(vectors('B', b)).chain([row("cC", c)]);
                let band_4 = vectors('D', d).chain(vectors('F', f)).chain([row("cG", g)]);
                ("packed-5", 54, order_3.chain(band_4).collect())
            }
            Form::Matrix => {
                let IrradianceMatrix { m } = IrradianceMatrix::from_irradiance_sh(&colors());
                let numbers = ["Mr", "Mg", "Mb"].into_iter().zip(m).map(|(name, m)| row(name, m.concat())).collect();
                ("matrix", 48, numbers)
            }
            Form::Polynomial => {
                let IrradiancePolynomial { l } = IrradiancePolynomial::from_irradiance_sh(&colors());
                let numbers =
                    IrradiancePolynomial::NAMES.into_iter().zip(l).map(|(name, l)| row(name, l.to_array())).collect();
                ("r-h", 27, numbers)
            }
            Form::Encoding(encoding) => {
                let encoded = encoding.encode(irradiance, tangent_frame(self.normal.unwrap_or(Dir::Z)));
                let numbers = encoded.numbers().into_iter().map(|(name, values)| row(name, values)).collect();
                (encoding.name(), encoding.floats(T::CHANNELS), numbers)
            }
            Form::Engine(engine) => unreachable!("the numbers of {engine} are made of radiance"),
        }
    }
}

fn irradiance_of<T: Coefficient>(radiance: &ShVec<T>) -> ShVec<T> {
    radiance.convolved(&Zonal::clamped_cosine(radiance.order()))
}

impl Encoded {
    fn text(&self) -> String {
        let Self { encoding, floats, of, up, .. } = self;
        let mut text = format!("{encoding}, {floats} floats, of {of}, {up} up\n");
        for Row { name, values } in &self.numbers {
            let values = values.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(" ");
            let _ = writeln!(text, "{name} {values}");
        }
        text
    }
}
