//! Conventions of coefficients, and the numbers that expansions have in them.

use crate::basis::{MAX_ORDER, coefficient_index};
use crate::convention::array::{ArrayNumbers, CoefficientArray};
use crate::convention::layout::CoefficientLayout;
use crate::convention::normalization::BasisNormalization;
use crate::error::ShError;
use crate::expansion::Expansion;
use crate::prelude::*;
use crate::rotation::AxisPermutation;
use crate::scalar::Coefficient;

/// The convention by which a library keeps the coefficients of real functions.
///
/// With `S_lm` as Lobe has it in the library's axes, `q` of [`BasisNormalization`], and the sign `p = (-1)^m` where the
/// library leaves the Condon-Shortley phase out, else `p = 1`:
///
/// ```text
///   Real        c_lm = p S_lm / q
///   Complex     c_lm = p (S_lm - i S_l-m) / (√2 q), m > 0        c_l0 = S_l0 / q        c_l-m = (-1)^m conj(c_lm)
///   Projection  q stands above instead: c = ∫ f conj(Y) ds, where c of an expansion has f = Σ c Y
/// ```
///
/// The step from real to complex is that of [`complex_from_real`](crate::basis::complex_from_real). There and back
/// change no coefficient by more than 4 units of its last place (test `there_and_back_changes_the_last_digits_alone`).
/// Axes of e3nn take a matrix for each band, and leave 1e-14 of the largest coefficient of a band at order 20.
///
/// ```
/// use lobe_sh::convention::NamedConvention;
/// use lobe_sh::{Dir, ShVec};
///
/// let sun = ShVec::impulse(4, Dir::X, 1.0);
/// let ambix = NamedConvention::find("ambix")?.convention();
/// let signals = ambix.encode(&sun)?;
/// // A source ahead is in W and in X, the channels 0 and 3 of ACN.
/// let [w, x] = [0, 3].map(|channel| signals.numbers.complex(channel)[0]);
/// assert!((w - 1.0).abs() < 1e-15 && (x - 1.0).abs() < 1e-15);
/// let back: ShVec<f64> = ambix.decode(&signals, "signals")?;
/// # assert!((back[3] - sun[3]).abs() < 1e-15);
/// # Ok::<(), lobe_sh::ShError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Convention {
    /// The kind of basis.
    pub harmonics: Harmonics,
    /// The length of its functions.
    pub normalization: BasisNormalization,
    /// Whether the functions have the Condon-Shortley phase `(-1)^m`.
    pub phase: bool,
    /// Whether numbers multiply the functions, or are integrals of products with them.
    pub meaning: Meaning,
    /// The places of the numbers.
    pub layout: CoefficientLayout,
    /// The axis of θ = 0.
    pub polar_axis: PolarAxis,
}

/// Real or complex functions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum Harmonics {
    /// `cos mφ` and `sin |m|φ`.
    Real,
    /// `e^{imφ}`.
    Complex,
}

/// What a number is of a function `f`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum Meaning {
    /// `f = Σ c Y`: what the library's functions are multiplied by.
    Expansion,
    /// `c = ∫ f conj(Y) ds`: signals of Ambisonics, where a source of strength 1 towards `s` has the numbers `Y(s)`.
    Projection,
}

/// The axis of θ = 0 of the library's formulas. The vectors of the world are the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum PolarAxis {
    /// z, and φ from x to y.
    Z,
    /// y, and φ from z to x: the formulas get (z, x, y) for (x, y, z).
    Y,
}

/// `(z, x, y)` of `(x, y, z)`.
const FROM_Z_TO_Y: [[i8; 3]; 3] = [[0, 0, 1], [1, 0, 0], [0, 1, 0]];

impl Convention {
    /// Lobe's own: real, orthonormal, with the phase.
    pub const LOBE: Self = Self {
        harmonics: Harmonics::Real,
        normalization: BasisNormalization::Orthonormal,
        phase: true,
        meaning: Meaning::Expansion,
        layout: CoefficientLayout::Bands,
        polar_axis: PolarAxis::Z,
    };

    /// The highest order that it holds: 4 of `FuMa`, 86 of unnormalized functions, whose factors would leave `f64`.
    #[must_use]
    pub const fn max_order(&self) -> usize {
        let by_layout = match self.layout {
            CoefficientLayout::FuMa => 4,
            _ => MAX_ORDER,
        };
        match self.normalization.most_bands() {
            Some(most) if most < by_layout => most,
            _ => by_layout,
        }
    }

    /// The coefficients of a real function as the library keeps them, in the shape of [`CoefficientLayout`]; colors
    /// have a leading axis of three.
    ///
    /// # Errors
    /// If the order is 0 or above [`max_order`](Self::max_order), or a coefficient is not finite. If real functions
    /// shall have a layout of `m >= 0` alone.
    pub fn encode<T: Coefficient>(&self, f: &impl Expansion<T>) -> Result<CoefficientArray, ShError> {
        let order = f.order();
        self.check(order).map_err(ShError::Options)?;
        let mut shape = self.layout.shape(order);
        let count: usize = shape.iter().product();
        let mut own: Vec<T::Wide> = f.coefficients().iter().map(|c| c.widen()).collect();
        if let Some(i) = own.iter().position(|c| (0..T::CHANNELS).any(|k| !c.channel(k).is_finite())) {
            return Err(ShError::Options(format!("coefficient {i} is not finite; only finite numbers are converted")));
        }
        if let Some(turn) = self.turn() {
            turn.apply_in_place(&mut own);
        }
        let mut numbers = vec![[0.0; 2]; count * T::CHANNELS];
        for (c, out) in numbers.chunks_exact_mut(count).enumerate() {
            self.fill(order, |i| own[i].channel(c), out);
        }
        if T::CHANNELS > 1 {
            shape.insert(0, T::CHANNELS);
        }
        let numbers = match self.harmonics {
            Harmonics::Real => ArrayNumbers::Real(numbers.into_iter().map(|[re, _]| re).collect()),
            Harmonics::Complex => ArrayNumbers::Complex(numbers),
        };
        Ok(CoefficientArray { shape, numbers })
    }

    /// The number of channels, 1 or 3, and the order of an array of this shape.
    ///
    /// # Errors
    /// If it is no shape of the layout, nor three of them along a leading axis; `name` is the array's.
    pub fn channels_and_order(&self, shape: &[usize], name: &str) -> Result<(usize, usize), ShError> {
        self.of_shape(shape).map_err(|message| ShError::Invalid { place: name.into(), message })
    }

    pub(super) fn of_shape(&self, shape: &[usize]) -> Result<(usize, usize), String> {
        let (channels, own) = match shape {
            [3, own @ ..] if own.len() == self.layout.axes() => (3, own),
            own => (1, own),
        };
        let order = self.layout.order_of_shape(own).ok_or_else(|| {
            let words = self.layout.shape_in_words();
            let has_last = own.len() > 1 && own.last() == Some(&3);
            let moved = if has_last { "; move colors from the last axis to the first" } else { "" };
            format!("expected an array of shape {words}, or three of them along a first axis; found {shape:?}{moved}")
        })?;
        self.check(order)?;
        Ok((channels, order))
    }

    fn check(&self, order: usize) -> Result<(), String> {
        if self.harmonics == Harmonics::Real && self.layout == CoefficientLayout::OrderMajor {
            return Err("a layout of m >= 0 alone holds complex numbers; choose complex harmonics".into());
        }
        let most = self.max_order();
        if (1..=most).contains(&order) {
            return Ok(());
        }
        if order == 0 {
            return Err(format!("expected order 1 to {most}, found order 0"));
        }
        let why = match (self.layout, self.normalization) {
            (CoefficientLayout::FuMa, _) | (_, BasisNormalization::MaxN) => "FuMa has letters for no more",
            (_, BasisNormalization::Unnormalized) => "factorials of higher degrees leave f64: choose a normalization",
            _ => "Lobe holds no more",
        };
        let degree = most - 1;
        Err(format!("expected order 1 to {most} (degree 0 to {degree}), found order {order}; {why}"))
    }

    /// What moves a function from Lobe's axes to those of the formulas.
    pub(super) fn turn(&self) -> Option<AxisPermutation> {
        match self.polar_axis {
            PolarAxis::Z => None,
            PolarAxis::Y => AxisPermutation::from_matrix(FROM_Z_TO_Y),
        }
    }

    /// What a coefficient of Lobe's is multiplied by.
    pub(super) fn factor(&self, l: usize, m: usize) -> f64 {
        let length = self.normalization.length(l, m, self.harmonics == Harmonics::Complex);
        let sign = if self.phase || m.is_multiple_of(2) { 1.0 } else { -1.0 };
        match self.meaning {
            Meaning::Expansion => sign / length,
            Meaning::Projection => sign * length,
        }
    }

    /// Writes one channel, whose coefficients are `of(i)`.
    fn fill(&self, order: usize, of: impl Fn(usize) -> f64, out: &mut [[f64; 2]]) {
        let mut put = |l: usize, m: isize, number: [f64; 2]| {
            if let Some(place) = self.layout.place(order, l, m) {
                out[place] = number;
            }
        };
        for l in 0..order {
            let factor = self.factor(l, 0);
            put(l, 0, [of(coefficient_index(l, 0)) * factor, 0.0]);
            for k in 1..=l {
                let (m, factor) = (k as isize, self.factor(l, k));
                let (plus, minus) = (of(coefficient_index(l, m)), of(coefficient_index(l, -m)));
                if self.harmonics == Harmonics::Real {
                    put(l, m, [plus * factor, 0.0]);
                    put(l, -m, [minus * factor, 0.0]);
                } else {
                    let [re, im] = [plus, -minus].map(|part| part * 0.5_f64.sqrt() * factor);
                    put(l, m, [re, im]);
                    put(l, -m, [re, -im].map(|part| part * sign(k)));
                }
            }
        }
    }
}

/// `(-1)^m`.
pub(super) fn sign(m: usize) -> f64 {
    if m.is_multiple_of(2) { 1.0 } else { -1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::basis::{band_and_m, eval_complex};
    use crate::convention::NamedConvention;
    use crate::expansion::ShVec;
    use crate::scalar::Rgb;
    use crate::sphere::Dir;
    use lobe_testkit::{Random, directions};

    fn random(order: usize, seed: u64) -> ShVec<f64> {
        ShVec::from_vec(Random::new(seed).signed_vec(order * order)).unwrap()
    }

    /// Every combination of the fields that is one.
    fn all() -> impl Iterator<Item = Convention> {
        use BasisNormalization as N;
        use CoefficientLayout as L;
        let layouts = [L::Bands, L::NegativeEnd, L::Cilm, L::OrderMajor, L::FuMa];
        let normalizations = [N::Orthonormal, N::FourPi, N::Schmidt, N::Unnormalized, N::MaxN];
        let kinds = [Harmonics::Real, Harmonics::Complex].into_iter().flat_map(move |harmonics| {
            layouts.into_iter().flat_map(move |layout| {
                normalizations.map(|normalization| Convention { harmonics, layout, normalization, ..Convention::LOBE })
            })
        });
        let signs = kinds.flat_map(|c| [true, false].map(|phase| Convention { phase, ..c }));
        let meanings =
            signs.flat_map(|c| [Meaning::Expansion, Meaning::Projection].map(|meaning| Convention { meaning, ..c }));
        meanings
            .flat_map(|c| [PolarAxis::Z, PolarAxis::Y].map(|polar_axis| Convention { polar_axis, ..c }))
            .filter(|c| c.harmonics == Harmonics::Complex || c.layout != L::OrderMajor)
    }

    #[test]
    fn there_and_back_changes_the_last_digits_alone() {
        let mut worst = [0.0_f64; 2];
        for convention in all() {
            let order = convention.max_order().min(20);
            let f = random(order, 5);
            let back: ShVec<f64> = convention.decode(&convention.encode(&f).unwrap(), "test").unwrap();
            for (i, (a, b)) in f.coefficients().iter().zip(back.coefficients()).enumerate() {
                if convention.polar_axis == PolarAxis::Y {
                    worst[1] = worst[1].max((a - b).abs());
                    assert!((a - b).abs() < 1e-14, "{convention:?}, {i}: {a} became {b}");
                } else {
                    worst[0] = worst[0].max((a - b).abs() / a.abs());
                    assert!((a - b).abs() <= 4.0 * f64::EPSILON * a.abs(), "{convention:?}, {i}: {a} became {b}");
                }
            }
        }
        assert!(worst[0] > 0.0 && worst[1] > 0.0, "{worst:?}");
    }

    #[test]
    fn colors_are_three_arrays_one_after_the_other() {
        for named in NamedConvention::ALL {
            let convention = named.convention();
            let channels = [1, 2, 3].map(|seed| random(4, seed));
            let colors =
                ShVec::from_vec((0..16).map(|i| Rgb::from_channels(|c| channels[c][i])).collect::<Vec<Rgb<f64>>>())
                    .unwrap();
            let array = convention.encode(&colors).unwrap();
            let count = array.numbers.len() / 3;
            for (c, channel) in channels.iter().enumerate() {
                let one = convention.encode(channel).unwrap();
                assert_eq!(array.shape[1..], one.shape, "{named}");
                for i in 0..count {
                    assert_eq!(array.numbers.complex(c * count + i), one.numbers.complex(i), "{named}, {c}, {i}");
                }
            }
            assert_eq!(convention.channels_and_order(&array.shape, "").unwrap(), (3, 4), "{named}");
            let back: ShVec<Rgb<f64>> = convention.decode(&array, "test").unwrap();
            let error = (0..16).map(|i| (back[i].g - colors[i].g).abs()).fold(0.0, f64::max);
            assert!(error < 1e-14, "{named}: {error}");
        }
    }

    /// The complex function of a convention, by the definition.
    fn complex_value(convention: &Convention, l: usize, m: isize, s: Dir) -> [f64; 2] {
        let k = m.unsigned_abs();
        let sign = if convention.phase { 1.0 } else { sign(k) };
        eval_complex(l, m, s).map(|part| part * sign * convention.normalization.length(l, k, true))
    }

    #[test]
    fn complex_projections_of_an_impulse_are_the_conjugated_functions_towards_it() {
        let convention = Convention {
            harmonics: Harmonics::Complex,
            normalization: BasisNormalization::Schmidt,
            meaning: Meaning::Projection,
            ..Convention::LOBE
        };
        for s in directions().into_iter().map(Dir::from_unit) {
            let array = convention.encode(&ShVec::impulse(4, s, 1.0)).unwrap();
            for (i, (l, m)) in (0..16).map(band_and_m).enumerate() {
                let [re, im] = complex_value(&convention, l, m, s);
                let [found_re, found_im] = array.numbers.complex(i);
                let off = (found_re - re).hypot(found_im + im);
                assert!(off < 1e-14, "l = {l}, m = {m}: {found_re} {found_im:+}i for the conjugate of {re} {im:+}i");
            }
        }
    }

    #[test]
    fn complex_numbers_times_their_functions_sum_to_the_function() {
        let f = random(6, 9);
        for phase in [true, false] {
            for normalization in [BasisNormalization::FourPi, BasisNormalization::Unnormalized] {
                let layout = CoefficientLayout::Bands;
                let convention =
                    Convention { harmonics: Harmonics::Complex, phase, normalization, layout, ..Convention::LOBE };
                let array = convention.encode(&f).unwrap();
                for v in directions() {
                    let s = Dir::from_unit(v);
                    let sum = (0..36).fold([0.0; 2], |[re, im], i| {
                        let (l, m) = band_and_m(i);
                        let (c, y) = (array.numbers.complex(i), complex_value(&convention, l, m, s));
                        [re + c[0] * y[0] - c[1] * y[1], im + c[0] * y[1] + c[1] * y[0]]
                    });
                    let expected = f.eval(s);
                    assert!((sum[0] - expected).abs() < 1e-12, "{convention:?}: {sum:?}, expected {expected}");
                    assert!(sum[1].abs() < 1e-12, "{convention:?}: {sum:?} is not real");
                }
            }
        }
    }

    #[test]
    fn a_source_of_ambisonics_has_the_values_of_the_functions() {
        let s = Dir::new([0.48, -0.6, 0.64]).unwrap();
        let [x, y, z] = s.to_array();
        let numbers = |name: &str| {
            let convention = NamedConvention::find(name).unwrap().convention();
            let array = convention.encode(&ShVec::impulse(3, s, 1.0)).unwrap();
            (0..9).map(|i| array.numbers.complex(i)[0]).collect::<Vec<f64>>()
        };
        let root = 3.0_f64.sqrt();
        let zonal = 1.5 * z * z - 0.5;
        let sn3d = [1.0, y, z, x, root * x * y, root * y * z, zonal, root * x * z, 0.5 * root * (x * x - y * y)];
        let fuma = [0.5_f64.sqrt(), x, y, z, zonal, 2.0 * x * z, 2.0 * y * z, x * x - y * y, 2.0 * x * y];
        for i in 0..9 {
            let n3d = sn3d[i] * ((2 * i.isqrt() + 1) as f64).sqrt();
            for (name, expected) in [("ambix", sn3d[i]), ("ambisonics-n3d", n3d), ("fuma", fuma[i])] {
                let found = numbers(name)[i];
                assert!((found - expected).abs() < 1e-14, "{name}, {i}: {found}, expected {expected}");
            }
        }
    }

    #[test]
    fn functions_of_e3nn_have_y_x_z_for_the_first_band() {
        let convention = NamedConvention::find("e3nn").unwrap().convention();
        for (i, axis) in [(1, Dir::X), (2, Dir::Y), (3, Dir::Z)] {
            let mut numbers = vec![0.0; 4];
            numbers[i] = 1.0;
            let array = CoefficientArray { shape: vec![4], numbers: ArrayNumbers::Real(numbers) };
            let f: ShVec<f64> = convention.decode(&array, "test").unwrap();
            let (found, expected) = (f.eval(axis), (3.0 / (4.0 * core::f64::consts::PI)).sqrt());
            assert!((found - expected).abs() < 1e-15, "{i}: {found}, expected {expected}");
        }
    }

    #[test]
    fn the_highest_band_without_normalization_keeps_its_digits() {
        let convention = NamedConvention::find("pyshtools-unnormalized").unwrap().convention();
        let order = convention.max_order();
        let f = random(order, 3);
        let array = convention.encode(&f).unwrap();
        let back: ShVec<f64> = convention.decode(&array, "test").unwrap();
        for (a, b) in f.coefficients().iter().zip(back.coefficients()) {
            assert!((a - b).abs() <= 4.0 * f64::EPSILON * a.abs(), "{a} became {b}");
        }
        let error = convention.encode(&random(order + 1, 3)).unwrap_err().to_string();
        assert!(error.contains("found order 87; factorials"), "{error}");
        let mut broken = random(2, 1);
        broken.coefficients_mut()[2] = f64::INFINITY;
        assert!(Convention::LOBE.encode(&broken).unwrap_err().to_string().contains("coefficient 2"), "infinite");
    }
}
