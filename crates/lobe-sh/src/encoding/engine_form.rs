//! The nine colors of order 3 in the forms of engines.

use core::array;
use core::f64::consts::{FRAC_1_PI, PI};
use core::fmt;
use core::str::FromStr;

#[cfg(not(feature = "std"))]
use num_traits::Float as _;

use crate::encoding::engine_frame::EngineFrame;
use crate::encoding::irradiance_polynomial::IrradiancePolynomial;
use crate::encoding::{LINEAR_SHARE, QUADRATIC_SHARE, coefficient};
use crate::error::ShError;
use crate::expansion::{Expansion, ShL2};
use crate::scalar::{Coefficient, Rgb};

/// The form in which an engine keeps nine colors of a light.
///
/// ```text
///   C_i = (-1)^m S_i    radiance without the Condon-Shortley phase, S_i as Lobe has it, in the engine's frame
///   F_i = A_l k_i C_i / π    with A_l = π, 2π/3, π/4 and the constants k_i > 0 of the basis
///
///   Three       C_i                          LightProbe of three.js
///   Babylon     A_l S_i / π                  SphericalHarmonics of Babylon.js
///   PlayCanvas  F_i, i = 0 3 1 2 7 5 4 6 8   ambientSH of its materials
///   Filament    F_i                          IndirectLight.irradianceSh, `cmgen --sh-shader`, the key sh of .ktx
///   Godot       C_i / π                      light probes
///   Unity       F_i                          SphericalHarmonicsL2, channel after channel
///   Unreal      S_i                          FSHVectorRGB3, channel after channel
///   Cesium      F_i                          sphericalHarmonicCoefficients
/// ```
///
/// `F_i` are the factors of the polynomials 1, y, z, x, xy, yz, 3z² - 1, zx, x² - y², whose sum is E/π.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum EngineForm {
    /// three.js.
    Three,
    /// Babylon.js.
    Babylon,
    /// `PlayCanvas`.
    PlayCanvas,
    /// Filament.
    Filament,
    /// Godot.
    Godot,
    /// Unity.
    Unity,
    /// Unreal Engine.
    Unreal,
    /// Cesium.
    Cesium,
}

/// What a coefficient is multiplied by, beside the constants of all.
#[derive(Clone, Copy, PartialEq)]
enum Scale {
    /// Radiance.
    One,
    /// Radiance over π.
    OverPi,
    /// `A_l / π`.
    Cosine,
    /// `A_l k_i / π`.
    Polynomial,
}

/// The numbers of coefficients in the order of `PlayCanvas`: 1, x, y, z, xz, zy, yx, 3z² - 1, x² - y².
const OF_PLAYCANVAS: [usize; 9] = [0, 3, 1, 2, 7, 5, 4, 6, 8];

/// The order of all others.
const IN_ORDER: [usize; 9] = [0, 1, 2, 3, 4, 5, 6, 7, 8];

/// Those with an odd m, which the phase turns around.
const IS_ODD: [bool; 9] = [false, true, false, true, false, true, false, true, false];

/// `A_l / π` of each coefficient.
const SHARES: [f64; 9] = [
    1.0,
    LINEAR_SHARE,
    LINEAR_SHARE,
    LINEAR_SHARE,
    QUADRATIC_SHARE,
    QUADRATIC_SHARE,
    QUADRATIC_SHARE,
    QUADRATIC_SHARE,
    QUADRATIC_SHARE,
];

/// `k_i`, by which the polynomial of each basis function is multiplied.
fn constants() -> [f64; 9] {
    let (constant, linear, mixed) = (0.5 / PI.sqrt(), 0.5 * (3.0 / PI).sqrt(), 0.5 * (15.0 / PI).sqrt());
    [constant, linear, linear, linear, mixed, mixed, 0.25 * (5.0 / PI).sqrt(), mixed, 0.5 * mixed]
}

impl EngineForm {
    /// All forms.
    pub const ALL: [Self; 8] = [
        Self::Three,
        Self::Babylon,
        Self::PlayCanvas,
        Self::Filament,
        Self::Godot,
        Self::Unity,
        Self::Unreal,
        Self::Cesium,
    ];

    /// The name in options.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Three => "three",
            Self::Babylon => "babylon",
            Self::PlayCanvas => "playcanvas",
            Self::Filament => "filament",
            Self::Godot => "godot",
            Self::Unity => "unity",
            Self::Unreal => "unreal",
            Self::Cesium => "cesium",
        }
    }

    /// The frame of the numbers.
    #[must_use]
    pub fn frame(self) -> EngineFrame {
        match self {
            Self::Three | Self::PlayCanvas | Self::Filament | Self::Godot | Self::Cesium => EngineFrame::YUp,
            Self::Babylon | Self::Unity => EngineFrame::YUpLeftHanded,
            Self::Unreal => EngineFrame::ZUpLeftHanded,
        }
    }

    /// What the numbers are of, in the letters of radiance L and irradiance E: what the engine multiplies by the cosine
    /// lobe itself is of L.
    #[must_use]
    pub fn quantity(self) -> &'static str {
        match self.scale() {
            Scale::One => "L",
            Scale::OverPi => "L/pi",
            Scale::Cosine | Scale::Polynomial => "E/pi",
        }
    }

    /// Whether all numbers of a channel stand together; else the three channels of a coefficient do.
    #[must_use]
    pub fn is_planar(self) -> bool {
        matches!(self, Self::Unity | Self::Unreal)
    }

    fn scale(self) -> Scale {
        match self {
            Self::Three | Self::Unreal => Scale::One,
            Self::Godot => Scale::OverPi,
            Self::Babylon => Scale::Cosine,
            Self::PlayCanvas | Self::Filament | Self::Unity | Self::Cesium => Scale::Polynomial,
        }
    }

    /// Which coefficient stands in each place.
    fn order(self) -> [usize; 9] {
        if self == Self::PlayCanvas { OF_PLAYCANVAS } else { IN_ORDER }
    }

    /// The factor of coefficient `i` as Lobe has it.
    fn factor(self, i: usize) -> f64 {
        let keeps_phase = matches!(self, Self::Babylon | Self::Unreal);
        let sign = if IS_ODD[i] && !keeps_phase { -1.0 } else { 1.0 };
        sign * match self.scale() {
            Scale::One => 1.0,
            Scale::OverPi => FRAC_1_PI,
            Scale::Cosine => SHARES[i],
            Scale::Polynomial => SHARES[i] * constants()[i],
        }
    }

    /// The nine colors of the first three bands of a radiance in Lobe's frame.
    #[must_use]
    pub fn encode<T: Coefficient<Wide = Rgb<f64>>>(self, radiance: &impl Expansion<T>) -> [Rgb<f64>; 9] {
        let mut turned: [Rgb<f64>; 9] = array::from_fn(|i| coefficient(radiance, i));
        self.frame().from_lobe().apply_in_place(&mut turned);
        self.order().map(|i| turned[i].scale(self.factor(i)))
    }

    /// The nine colors of the radiance whose irradiance this is: [`encode`](Self::encode) of `S_lm = E_lm / A_l`, for
    /// `l <= 2`.
    #[must_use]
    pub fn encode_irradiance<T: Coefficient<Wide = Rgb<f64>>>(self, irradiance: &impl Expansion<T>) -> [Rgb<f64>; 9] {
        self.encode(&ShL2::of(array::from_fn(|i| coefficient(irradiance, i).scale(FRAC_1_PI / SHARES[i]))))
    }

    /// The radiance, in Lobe's frame, that has these nine colors: the inverse of [`encode`](Self::encode).
    #[must_use]
    pub fn decode(self, colors: &[Rgb<f64>; 9]) -> ShL2<Rgb<f64>> {
        let mut own = [Rgb::ZERO; 9];
        for (i, color) in self.order().into_iter().zip(colors) {
            own[i] = color.scale(1.0 / self.factor(i));
        }
        self.frame().from_lobe().inverse().apply_in_place(&mut own);
        ShL2::of(own)
    }

    /// The 27 numbers of nine colors as the engine lays them out.
    #[must_use]
    pub fn flat(self, colors: &[Rgb<f64>; 9]) -> [f64; 27] {
        array::from_fn(|k| {
            let (i, c) = if self.is_planar() { (k % 9, k / 9) } else { (k / 3, k % 3) };
            colors[i].channel(c)
        })
    }

    /// The nine colors of 27 numbers as the engine lays them out: the inverse of [`flat`](Self::flat).
    #[must_use]
    pub fn colors(self, numbers: &[f64; 27]) -> [Rgb<f64>; 9] {
        let at = |i: usize, c: usize| numbers[if self.is_planar() { 9 * c + i } else { 3 * i + c }];
        array::from_fn(|i| Rgb::from_channels(|c| at(i, c)))
    }

    /// The name of each place: bands and m, as in `L2-1`.
    #[must_use]
    pub fn places(self) -> [&'static str; 9] {
        self.order().map(|i| IrradiancePolynomial::NAMES[i])
    }
}

impl fmt::Display for EngineForm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for EngineForm {
    type Err = ShError;

    fn from_str(text: &str) -> Result<Self, ShError> {
        Self::ALL.into_iter().find(|form| form.name() == text).ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            ShError::Options(alloc::format!("expected one of {names}, found {text:?}"))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expansion::{ShVec, Zonal};
    use crate::sphere::Dir;
    use lobe_testkit::{Random, directions};

    fn radiance() -> ShVec<Rgb<f64>> {
        let values = Random::new(7).signed_vec(27);
        ShVec::from_vec(values.chunks(3).map(|c| Rgb::new(c[0], c[1], c[2])).collect()).unwrap()
    }

    fn worst(a: Rgb<f64>, b: Rgb<f64>) -> f64 {
        (0..3).map(|c| (a.channel(c) - b.channel(c)).abs()).max_by(f64::total_cmp).unwrap()
    }

    /// The polynomials of a direction of the engine's frame, without constants.
    fn polynomials([x, y, z]: [f64; 3]) -> [f64; 9] {
        [1.0, y, z, x, x * y, y * z, 3.0 * z * z - 1.0, z * x, x * x - y * y]
    }

    /// E/π by the formula that each engine evaluates, as its source has it, with six to nine digits.
    fn evaluated(form: EngineForm, colors: &[Rgb<f64>; 9], d: [f64; 3]) -> Rgb<f64> {
        let [x, y, z] = d;
        let sum = |terms: [f64; 9]| colors.iter().zip(terms).fold(Rgb::ZERO, |all, (c, t)| all + c.scale(t));
        let k = [
            0.282094792,
            0.488602512,
            0.488602512,
            0.488602512,
            1.092548431,
            1.092548431,
            0.315391565,
            1.092548431,
            0.546274215,
        ];
        let p = polynomials(d);
        match form {
            EngineForm::Filament | EngineForm::Unity | EngineForm::Cesium => sum(p),
            EngineForm::PlayCanvas => sum([1.0, x, y, z, x * z, z * y, y * x, 3.0 * z * z - 1.0, x * x - y * y]),
            EngineForm::Babylon => {
                let signs = [1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0];
                sum(array::from_fn(|i| signs[i] * k[i] * p[i]))
            }
            EngineForm::Three | EngineForm::Godot => {
                let (c1, c2, c3, c4, c5) = (0.429043, 0.511664, 0.743125, 0.886227, 0.247708);
                let terms = [
                    c4,
                    2.0 * c2 * y,
                    2.0 * c2 * z,
                    2.0 * c2 * x,
                    2.0 * c1 * x * y,
                    2.0 * c1 * y * z,
                    c3 * z * z - c5,
                    2.0 * c1 * x * z,
                    c1 * (x * x - y * y),
                ];
                let e = sum(terms);
                if form == EngineForm::Three { e.scale(FRAC_1_PI) } else { e }
            }
            EngineForm::Unreal => {
                let (c0, c1, c2, c3) = (0.282094792, 0.325735008, 0.273137108, 0.078847891);
                sum([
                    c0,
                    -c1 * y,
                    c1 * z,
                    -c1 * x,
                    c2 * x * y,
                    -c2 * y * z,
                    c3 * (3.0 * z * z - 1.0),
                    -c2 * x * z,
                    0.5 * c2 * (x * x - y * y),
                ])
            }
        }
    }

    #[test]
    fn every_form_yields_what_a_white_surface_sends_back_by_the_formula_of_its_engine() {
        let radiance = radiance();
        let irradiance = radiance.convolved(&Zonal::clamped_cosine(3));
        for form in EngineForm::ALL {
            let colors = form.encode(&radiance);
            for v in directions() {
                let n = Dir::from_unit(v);
                let found = evaluated(form, &colors, form.frame().dir(n).to_array());
                let expected = irradiance.eval(n).scale(FRAC_1_PI);
                assert!(worst(found, expected) < 2e-6, "{form}, {v:?}: {found:?}, expected {expected:?}");
            }
        }
    }

    #[test]
    fn irradiance_has_the_colors_of_its_radiance() {
        let radiance = radiance();
        let irradiance = radiance.convolved(&Zonal::clamped_cosine(3));
        for form in EngineForm::ALL {
            let (found, expected) = (form.encode_irradiance(&irradiance), form.encode(&radiance));
            for (i, (found, expected)) in found.into_iter().zip(expected).enumerate() {
                assert!(worst(found, expected) < 1e-15, "{form}, {i}: {found:?}, expected {expected:?}");
            }
        }
    }

    #[test]
    fn every_form_is_read_back_to_the_last_digits() {
        let radiance = radiance();
        for form in EngineForm::ALL {
            let colors = form.encode(&radiance);
            assert_eq!(form.colors(&form.flat(&colors)), colors, "{form}: 27 numbers");
            let back = form.decode(&colors);
            for (i, (found, expected)) in back.coefficients().iter().zip(radiance.coefficients()).enumerate() {
                assert!(worst(*found, *expected) < 1e-15, "{form}, coefficient {i}: {found:?}, {expected:?}");
            }
        }
    }

    #[test]
    fn names_are_read_as_they_are_printed() {
        for form in EngineForm::ALL {
            assert_eq!(form.name().parse::<EngineForm>().unwrap(), form, "{form}");
        }
        let error = "quake".parse::<EngineForm>().unwrap_err().to_string();
        assert!(error.contains("three, babylon") && error.contains("quake"), "{error}");
    }
}
