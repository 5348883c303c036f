//! Rotation of coefficients by Euler angles, with rotations about z and fixed exchanges of y and z.

use crate::basis::index::{band_range, coefficient_count, order_of_slice};
use crate::prelude::*;
use crate::rotation::cos_sin::CosSin;
use crate::rotation::high_bands::{FIRST_HIGH_BAND, rotate_high_bands};
use crate::rotation::low_bands::{MIDDLE_BANDS, rotate_middle_bands};
use crate::rotation::yz_exchange::{SplitBand, YzExchange, YzExchangeBand};
use crate::scalar::TypedSliceMut;
use crate::scalar::{Coefficient, Real, Rgb};

/// Orders up to this one work on the stack alone.
const STACK_ORDER: usize = 11;

/// Places for two [`SplitBand`]s of order [`STACK_ORDER`].
const STACK_PLACES: usize = 2 * SplitBand::<f64>::places(STACK_ORDER);

/// Places for three [`ZRotation`]s of order [`STACK_ORDER`].
const STACK_ROTATION_PLACES: usize = 3 * z_rotation_places(STACK_ORDER);

/// Rotates bands `first_band..` of the coefficients by `R_z(α) R_y(β) R_z(γ)`.
///
/// ```text
///   R = Z(α) J Z(-β) J Z(γ)
///
///   Z(a):  f_-m' =  cos ma f_-m + sin ma f_m        J: the exchange of y and z
///          f_m'  = -sin ma f_-m + cos ma f_m
/// ```
///
/// `J Z(-β) J = R_y(β)`: exchanging y and z turns a rotation about z into the opposite one about y. Only the three
/// rotations about z depend on the rotation, and no matrix is built. Not counting the entries ±1 of `J`, bands 0 to l
/// take 0, 12, 44, 104, 194, 316 multiplications for l = 0 to 5 (test
/// `three_z_rotations_and_two_exchanges_take_few_multiplications`), where Green 2003 needs 340 to l = 4.
///
/// Bands 3 to 7 have straight-line code ([`rotate_middle_bands`]), those to 63 tables, those above three terms
/// ([`rotate_high_bands`]).
///
/// Source: [Pinchon and Hoggan 2007].
///
/// [Pinchon and Hoggan 2007]: https://doi.org/10.1088/1751-8113/40/7/011
pub(crate) fn rotate_bands_zyz<T: Coefficient>(angles: [CosSin; 3], coefficients: &mut [T]) {
    rotate_middle_bands(angles, coefficients);
    rotate_bands_by_tables(angles, 0, coefficients);
}

/// Rotates the bands from `first_band` on that have no code of their own: colors channel by channel, which is the same
/// and compiled once less for each kind of number.
pub(crate) fn rotate_bands_by_tables<T: Coefficient>(angles: [CosSin; 3], first_band: usize, coefficients: &mut [T]) {
    let all = coefficients;
    rotate_high_bands(angles, all);
    let order = order_of_slice(all).min(FIRST_HIGH_BAND);
    let start = band_range(first_band).start;
    if coefficient_count(order) <= start {
        return;
    }
    let coefficients = &mut all[..coefficient_count(order)];
    match T::typed_mut(coefficients) {
        TypedSliceMut::Single(numbers) => rotate_numbers(angles, first_band, numbers),
        TypedSliceMut::Double(numbers) => rotate_numbers(angles, first_band, numbers),
        TypedSliceMut::SingleColors(colors) => rotate_channels(angles, first_band, colors),
        TypedSliceMut::DoubleColors(colors) => rotate_channels(angles, first_band, colors),
    }
}

fn rotate_channels<S: Real>(angles: [CosSin; 3], first_band: usize, colors: &mut [Rgb<S>]) {
    let (mut few, mut many) = ([S::ZERO; STACK_ORDER * STACK_ORDER], Vec::new());
    let numbers = match few.get_mut(..colors.len()) {
        Some(few) => few,
        None => {
            many.resize(colors.len(), S::ZERO);
            &mut many
        }
    };
    for c in 0..Rgb::<S>::CHANNELS {
        numbers.iter_mut().zip(&*colors).for_each(|(number, color)| *number = color.channel(c));
        rotate_numbers(angles, first_band, numbers);
        numbers.iter().zip(&mut *colors).for_each(|(number, color)| *color.channel_mut(c) = *number);
    }
}

fn rotate_numbers<T: Real>(angles: [CosSin; 3], first_band: usize, coefficients: &mut [T]) {
    let order = order_of_slice(coefficients);
    if order <= STACK_ORDER {
        let (mut work, mut turns) = ([T::ZERO; STACK_PLACES], [T::Scalar::ZERO; STACK_ROTATION_PLACES]);
        rotate_with(angles, first_band, coefficients, &mut work, &mut turns);
    } else {
        let mut work = vec![T::ZERO; 2 * SplitBand::<T>::places(order)];
        let mut turns = vec![T::Scalar::ZERO; 3 * z_rotation_places(order)];
        rotate_with(angles, first_band, coefficients, &mut work, &mut turns);
    }
}

fn rotate_with<T: Coefficient>(
    [alpha, beta, gamma]: [CosSin; 3],
    first_band: usize,
    coefficients: &mut [T],
    work: &mut [T],
    turns: &mut [T::Scalar],
) {
    let order = order_of_slice(coefficients);
    let (a, b) = work.split_at_mut(SplitBand::<T>::places(order));
    let (mut a, mut b) = (SplitBand::new(order, a), SplitBand::new(order, b));
    let (alpha_turn, rest) = turns.split_at_mut(z_rotation_places(order));
    let (beta_turn, gamma_turn) = rest.split_at_mut(z_rotation_places(order));
    let turns = [
        ZRotation::new(alpha, order, alpha_turn),
        ZRotation::new(CosSin { sin: -beta.sin, ..beta }, order, beta_turn),
        ZRotation::new(gamma, order, gamma_turn),
    ];
    YzExchange::with_shared(|table| {
        for l in (first_band..order).filter(|l| !MIDDLE_BANDS.contains(l)) {
            let (band, exchange) = (&mut coefficients[band_range(l)], table.band(l));
            // With a constant band the loops unroll, which saves much of the time at these sizes.
            #[cfg(feature = "batch")]
            match l {
                8 => rotate_band(8, &turns, exchange, band, &mut a, &mut b),
                9 => rotate_band(9, &turns, exchange, band, &mut a, &mut b),
                _ => rotate_band(l, &turns, exchange, band, &mut a, &mut b),
            }
            #[cfg(not(feature = "batch"))]
            rotate_band(l, &turns, exchange, band, &mut a, &mut b);
        }
    });
}

/// Rotates one band, with work space `a` and `b`.
#[inline(always)]
fn rotate_band<T: Coefficient>(
    l: usize,
    [z_alpha, z_minus_beta, z_gamma]: &[ZRotation<'_, T::Scalar>; 3],
    exchange: &YzExchangeBand,
    band: &mut [T],
    a: &mut SplitBand<'_, T>,
    b: &mut SplitBand<'_, T>,
) {
    // R_z(γ), then R_y(β) between exchanges of y and z, then R_z(α).
    a.load(l, band);
    z_gamma.apply(l, a);
    exchange.apply(l, a, b);
    z_minus_beta.apply(l, b);
    exchange.apply(l, b, a);
    z_alpha.apply(l, a);
    a.store(l, band);
}

/// Places that a [`ZRotation`] needs.
const fn z_rotation_places(order: usize) -> usize {
    4 * (order / 2 + 1)
}

/// A rotation about z: cosine and sine of `m a` for even `m` from 2 and for odd `m` from 1.
struct ZRotation<'a, S> {
    cos_even: &'a [S],
    sin_even: &'a [S],
    cos_odd: &'a [S],
    sin_odd: &'a [S],
}

impl<'a, S: Real> ZRotation<'a, S> {
    /// By repeated multiplication, `e^{i(m+1)a} = e^{ia} e^{ima}`, in `f64`: the error grows as `m` roundings.
    fn new(angle: CosSin, order: usize, places: &'a mut [S]) -> Self {
        let each = order / 2 + 1;
        let (cos_even, places) = places.split_at_mut(each);
        let (sin_even, places) = places.split_at_mut(each);
        let (cos_odd, sin_odd) = places.split_at_mut(each);
        let (mut cos, mut sin) = (angle.cos, angle.sin);
        for m in 1..order {
            let (to_cos, to_sin) =
                if m % 2 == 1 { (&mut *cos_odd, &mut *sin_odd) } else { (&mut *cos_even, &mut *sin_even) };
            to_cos[(m - 1) / 2] = S::from_f64(cos);
            to_sin[(m - 1) / 2] = S::from_f64(sin);
            (cos, sin) = (angle.cos * cos - angle.sin * sin, angle.sin * cos + angle.cos * sin);
        }
        Self { cos_even, sin_even, cos_odd, sin_odd }
    }

    #[inline(always)]
    fn apply<T: Coefficient<Scalar = S>>(&self, l: usize, band: &mut SplitBand<'_, T>) {
        let (evens, odds) = (l / 2, l.div_ceil(2));
        rotate_pairs(self.cos_even, self.sin_even, &mut band.sin_even[..evens], &mut band.cos_even[1..=evens]);
        rotate_pairs(self.cos_odd, self.sin_odd, &mut band.sin_odd[..odds], &mut band.cos_odd[..odds]);
    }
}

#[inline(always)]
fn rotate_pairs<T: Coefficient>(cos: &[T::Scalar], sin: &[T::Scalar], minus: &mut [T], plus: &mut [T]) {
    let count = minus.len();
    let (cos, sin, plus) = (&cos[..count], &sin[..count], &mut plus[..count]);
    for k in 0..count {
        let (f, g) = (minus[k], plus[k]);
        minus[k] = f.scale(cos[k]) + g.scale(sin[k]);
        plus[k] = g.scale(cos[k]) - f.scale(sin[k]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expansion::{Expansion as _, ShVec};
    use crate::rotation::Rotation;

    #[test]
    fn exchanges_agree_with_the_closed_forms_of_bands_1_and_2() {
        let mut random = lobe_testkit::Random::new(41);
        for _ in 0..100 {
            let rotation = Rotation::from_quaternion(random.quaternion()).unwrap();
            let f = ShVec::from_vec(random.signed_vec(9)).unwrap();
            let closed = f.rotated(&rotation);
            let mut exchanged = f.clone();
            rotate_bands_zyz(rotation.zyz_cos_sin(), exchanged.coefficients_mut());
            for i in 0..9 {
                assert!((closed[i] - exchanged[i]).abs() < 3e-15, "{i}: {} against {}", closed[i], exchanged[i]);
            }
        }
    }

    #[test]
    fn the_work_on_the_stack_is_that_on_the_heap() {
        let f = lobe_testkit::Random::new(42).signed_vec((STACK_ORDER + 1).pow(2));
        let angles = Rotation::from_euler_zyz(0.3, 1.2, -2.0).zyz_cos_sin();
        let (mut short, mut long) = (f[..STACK_ORDER * STACK_ORDER].to_vec(), f);
        rotate_bands_zyz(angles, &mut short);
        rotate_bands_zyz(angles, &mut long);
        assert_eq!(short, long[..short.len()], "the bands that both have");
    }
}
