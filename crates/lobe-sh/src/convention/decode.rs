//! Functions from the numbers of a library.

use crate::basis::{band_and_m, coefficient_index};
use crate::convention::array::CoefficientArray;
use crate::convention::convention::{Convention, Harmonics, sign};
use crate::error::ShError;
use crate::expansion::ShVec;
use crate::prelude::*;
use crate::scalar::Coefficient;

/// How far numbers may be from those of a real function, as a part of the largest: what sums in `f32` leave.
/// Numbers that are smaller than this part of the largest may have a wrong sign.
const MOST_IMAGINARY: f64 = 1e-5;

impl Convention {
    /// The function of an array of the library: the inverse of [`encode`](Self::encode). `name` is the array's in
    /// messages.
    ///
    /// # Errors
    /// If the shape is none of the layout's with the channels of `T`
    /// ([`channels_and_order`](Self::channels_and_order)), a number is not finite or stands where no coefficient is,
    /// the order is above [`max_order`](Self::max_order), or the numbers are not those of a real function: the
    /// message says which `l` and `m`, and by how much.
    pub fn decode<T: Coefficient<Scalar = f64>>(
        &self,
        array: &CoefficientArray,
        name: &str,
    ) -> Result<ShVec<T>, ShError> {
        self.decoded(array).map_err(|message| ShError::Invalid { place: name.into(), message })
    }

    fn decoded<T: Coefficient<Scalar = f64>>(&self, array: &CoefficientArray) -> Result<ShVec<T>, String> {
        let (channels, order) = self.of_shape(&array.shape)?;
        if channels != T::CHANNELS {
            let expected = if T::CHANNELS == 1 { "one channel" } else { "three channels" };
            return Err(format!("expected {expected}, found {channels}"));
        }
        let count: usize = self.layout.shape(order).iter().product();
        if array.numbers.len() != count * channels {
            return Err(format!(
                "shape {:?} has {} numbers, found {}",
                array.shape,
                count * channels,
                array.numbers.len()
            ));
        }
        let numbers: Vec<[f64; 2]> = (0..count * channels).map(|i| array.numbers.complex(i)).collect();
        if let Some(i) = numbers.iter().position(|c| !c.iter().all(|part| part.is_finite())) {
            return Err(format!("number {i} of {} is not finite: {:?}", numbers.len(), numbers[i]));
        }
        let mut rows = Vec::with_capacity(channels);
        for channel in numbers.chunks_exact(count) {
            rows.push(self.read(order, channel)?);
        }
        let mut own: Vec<T> = (0..order * order).map(|i| T::from_channels(|c| rows[c][i])).collect();
        if let Some(turn) = self.turn() {
            turn.inverse().apply_in_place(&mut own);
        }
        Ok(ShVec::of(own))
    }

    /// One channel in Lobe's basis and the axes of the formulas.
    fn read(&self, order: usize, numbers: &[[f64; 2]]) -> Result<Vec<f64>, String> {
        self.check_unused(order, numbers)?;
        let at = |l: usize, m: isize| {
            let factor = self.factor(l, m.unsigned_abs());
            self.layout.place(order, l, m).map(|place| numbers[place].map(|part| part / factor))
        };
        let all = (0..order * order).map(band_and_m).filter_map(|(l, m)| at(l, m));
        let largest = all.flatten().fold(0.0, |most: f64, part| most.max(part.abs()));
        let most = MOST_IMAGINARY * largest;
        let mut own = vec![0.0; order * order];
        for l in 0..order {
            for k in 0..=l {
                let m = k as isize;
                let (Some(plus), minus) = (at(l, m), at(l, -m)) else { continue };
                let [cosine, sine] = match self.harmonics {
                    Harmonics::Real => {
                        let minus = minus.unwrap_or_default();
                        expect_real(l, m, plus, most)?;
                        expect_real(l, -m, minus, most)?;
                        [plus[0], minus[0]]
                    }
                    Harmonics::Complex => of_complex(l, k, plus, minus, most)?,
                };
                own[coefficient_index(l, -m)] = sine;
                own[coefficient_index(l, m)] = cosine;
            }
        }
        Ok(own)
    }

    /// Refuses numbers where no coefficient is: those of another layout have some.
    fn check_unused(&self, order: usize, numbers: &[[f64; 2]]) -> Result<(), String> {
        let mut is_used = vec![false; numbers.len()];
        for (l, m) in (0..order * order).map(band_and_m) {
            if let Some(place) = self.layout.place(order, l, m) {
                is_used[place] = true;
            }
        }
        let stray = numbers.iter().zip(is_used).position(|(number, is_used)| !is_used && *number != [0.0; 2]);
        match stray {
            None => Ok(()),
            Some(i) => {
                let words = self.layout.shape_in_words();
                Err(format!("number {i} of shape {words} belongs to no l and m, expected 0, found {:?}", numbers[i]))
            }
        }
    }
}

fn expect_real(l: usize, m: isize, [_, im]: [f64; 2], most: f64) -> Result<(), String> {
    if im.abs() <= most {
        return Ok(());
    }
    Err(format!("l = {l}, m = {m}: expected a real number, found the imaginary part {im}; {ONLY_REAL}"))
}

/// What to do with a function that is not real.
const ONLY_REAL: &str = "Lobe holds real functions: take the real and the imaginary part one after the other";

/// The coefficients of `cos mφ` and `sin mφ` of complex ones, which are those of a real function to rounding: the
/// last step of [`real_from_complex`](crate::basis::real_from_complex), with its signs.
fn of_complex(l: usize, k: usize, plus: [f64; 2], minus: Option<[f64; 2]>, most: f64) -> Result<[f64; 2], String> {
    if k == 0 {
        expect_real(l, 0, plus, most)?;
        return Ok([plus[0]; 2]);
    }
    let mirrored = [plus[0], -plus[1]].map(|part| part * sign(k));
    let minus = minus.unwrap_or(mirrored);
    let distance = (minus[0] - mirrored[0]).hypot(minus[1] - mirrored[1]);
    if distance > most {
        return Err(format!(
            "l = {l}, m = {k}: of a real function m = -{k} is (-1)^m times the conjugate, here it is off by \
             {distance:e} in orthonormal units; {ONLY_REAL}"
        ));
    }
    let conjugated = [minus[0], -minus[1]].map(|part| part * sign(k));
    Ok([(plus[0] + conjugated[0]) * 0.5_f64.sqrt(), -(plus[1] + conjugated[1]) * 0.5_f64.sqrt()])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::convention::{ArrayNumbers, NamedConvention};

    fn refusal(name: &str, shape: &[usize], numbers: ArrayNumbers) -> String {
        let array = CoefficientArray { shape: shape.to_vec(), numbers };
        let decoded = NamedConvention::find(name).unwrap().convention().decode::<f64>(&array, "a.npy");
        decoded.unwrap_err().to_string()
    }

    #[test]
    fn numbers_that_are_no_real_function_are_refused_with_their_place() {
        let complex = |mut numbers: Vec<[f64; 2]>, i: usize, value: [f64; 2]| {
            numbers[i] = value;
            ArrayNumbers::Complex(numbers)
        };
        let found = refusal("healpy", &[6], complex(vec![[1.0, 0.0]; 6], 1, [1.0, 0.5]));
        assert!(
            found.starts_with("a.npy: l = 1, m = 0: expected a real number, found the imaginary part 0.5"),
            "{found}"
        );
        let found = refusal("scipy", &[2, 3], complex(vec![[0.0; 2]; 6], 4, [1.0, 0.0]));
        assert!(found.starts_with("a.npy: l = 1, m = 1: of a real function m = -1 is"), "{found}");
        let found = refusal("ambix", &[4], complex(vec![[1.0, 0.0]; 4], 3, [1.0, -2.0]));
        assert!(found.starts_with("a.npy: l = 1, m = 1: expected a real number"), "{found}");
    }

    #[test]
    fn arrays_that_cannot_be_are_refused_in_one_line() {
        let real = |count: usize| ArrayNumbers::Real(vec![1.0; count]);
        for (name, shape, numbers, said) in [
            ("ambix", &[5][..], real(5), "expected an array of shape (n²)"),
            ("pyshtools", &[2, 3, 4], real(24), "expected an array of shape (2, n, n)"),
            ("pyshtools", &[2, 2, 2], real(8), "number 1 of shape (2, n, n) belongs to no l and m, expected 0"),
            ("pyshtools", &[4, 2, 2, 2], real(32), "three of them along a first axis; found [4, 2, 2, 2]"),
            ("pyshtools", &[3, 2, 1, 1], real(6), "expected one channel, found 3"),
            ("fuma", &[25], real(25), "expected order 1 to 4 (degree 0 to 3), found order 5; FuMa has letters"),
            ("pyshtools-unnormalized", &[2, 87, 87], real(2 * 87 * 87), "expected order 1 to 86 (degree 0 to 85)"),
            ("ambix", &[4], ArrayNumbers::Real(vec![0.0, 1.0, f64::NAN, 0.0]), "number 2 of 4 is not finite"),
            ("ambix", &[4], real(3), "shape [4] has 4 numbers, found 3"),
            ("ambix", &[0], real(0), "found order 0"),
            ("ambix", &[], real(1), "found []"),
        ] {
            let found = refusal(name, shape, numbers);
            assert!(found.contains(said) && found.lines().count() == 1, "{name}, {shape:?}: {found}");
        }
    }
}
