//! Bands 1 to 7 by straight-line code, with fused multiply-adds where the machine has them; in `f32` by registers of
//! AVX2.

use crate::basis::index::{band_range, coefficient_count};
use crate::rotation::closed_bands::{rotate_band_1, rotate_band_2};
use crate::rotation::cos_sin::{CosSin, zyz_of};
use crate::rotation::generated::{band_3, band_4, band_5, band_6, band_7};
#[cfg(all(feature = "simd", target_arch = "x86_64"))]
use crate::rotation::register_bands::rotate_in_registers;
#[cfg(feature = "simd")]
use crate::rotation::term::Fused;
use crate::rotation::term::Term;
use crate::scalar::{Coefficient, Real, Rgb};
use crate::scalar::{TypedSlice, TypedSliceMut};
use crate::simd::{Kernel, Machine};

/// The bands that are turned by angles and have code of their own.
pub(crate) const MIDDLE_BANDS: core::ops::RangeInclusive<usize> = 3..=7;

/// The first band that has no code of its own.
pub(crate) const FIRST_BAND_BY_TABLES: usize = *MIDDLE_BANDS.end() + 1;

/// Cosine and sine of `m` times an angle in places `2(m - 1)` and `2(m - 1) + 1`.
type Turns<S> = [S; 2 * *MIDDLE_BANDS.end()];

/// The matrix of a rotation, row by row.
type Matrix = [[f64; 3]; 3];

/// The number of coefficients of the bands that have code.
pub(crate) const LOW_COUNT: usize = coefficient_count(FIRST_BAND_BY_TABLES);

/// Rotates bands 0 to 7 of `src` into `dst`, as far as they have them: bands 1 and 2 by the matrix, and bands 3 to 7 by
/// its angles and the formula of `rotate_bands_zyz`. Colors channel by channel, so that there is one code for all.
pub(crate) fn rotate_low_bands<T: Coefficient>(matrix: &Matrix, src: &[T], dst: &mut [T]) {
    let count = src.len().min(LOW_COUNT);
    let (src, dst) = (&src[..count], &mut dst[..count]);
    match (T::typed(src), T::typed_mut(dst)) {
        (TypedSlice::Single(src), TypedSliceMut::Single(dst)) => rotate_singles(matrix, src, dst),
        (TypedSlice::Double(src), TypedSliceMut::Double(dst)) => rotate_doubles(matrix, src, dst),
        (TypedSlice::SingleColors(src), TypedSliceMut::SingleColors(dst)) => {
            rotate_channels(rotate_singles, matrix, src, dst);
        }
        (TypedSlice::DoubleColors(src), TypedSliceMut::DoubleColors(dst)) => {
            rotate_channels(rotate_doubles, matrix, src, dst);
        }
        _ => unreachable!("slices of one type"),
    }
}

fn rotate_channels<S: Real>(rotate: fn(&Matrix, &[S], &mut [S]), matrix: &Matrix, src: &[Rgb<S>], dst: &mut [Rgb<S>]) {
    let (mut from, mut to) = ([S::ZERO; LOW_COUNT], [S::ZERO; LOW_COUNT]);
    let (from, to) = (&mut from[..src.len()], &mut to[..src.len()]);
    for c in 0..Rgb::<S>::CHANNELS {
        from.iter_mut().zip(src).for_each(|(from, color)| *from = color.channel(c));
        rotate(matrix, from, to);
        to.iter().zip(&mut *dst).for_each(|(to, color)| *color.channel_mut(c) = *to);
    }
}

fn rotate_singles(matrix: &Matrix, src: &[f32], dst: &mut [f32]) {
    #[cfg(all(feature = "simd", target_arch = "x86_64"))]
    if let Some(v3) = Machine::detect().avx2()
        && rotate_in_registers(v3, matrix, src, dst)
    {
        return;
    }
    dst.copy_from_slice(src);
    Machine::detect().run_scalar(LowBands { matrix, coefficients: dst });
}

fn rotate_doubles(matrix: &Matrix, src: &[f64], dst: &mut [f64]) {
    dst.copy_from_slice(src);
    Machine::detect().run_scalar(LowBands { matrix, coefficients: dst });
}

/// Rotates bands 3 to 7 by `R_z(α) R_y(β) R_z(γ)`.
pub(crate) fn rotate_middle_bands<T: Coefficient>(angles: [CosSin; 3], coefficients: &mut [T]) {
    Machine::detect().run_scalar(MiddleBands { angles, coefficients });
}

struct LowBands<'a, T> {
    matrix: &'a Matrix,
    coefficients: &'a mut [T],
}

struct MiddleBands<'a, T> {
    angles: [CosSin; 3],
    coefficients: &'a mut [T],
}

impl<T: Coefficient> Kernel for LowBands<'_, T> {
    type Output = ();

    #[cfg(feature = "simd")]
    #[inline(always)]
    fn wide<S: pulp::Simd>(self, _: S) {
        low_bands::<Fused<T>>(self.matrix, self.coefficients);
    }

    fn plain(self) {
        low_bands::<T>(self.matrix, self.coefficients);
    }
}

impl<T: Coefficient> Kernel for MiddleBands<'_, T> {
    type Output = ();

    #[cfg(feature = "simd")]
    #[inline(always)]
    fn wide<S: pulp::Simd>(self, _: S) {
        middle_bands::<Fused<T>>(self.angles, self.coefficients);
    }

    fn plain(self) {
        middle_bands::<T>(self.angles, self.coefficients);
    }
}

/// Replaces a band, if the coefficients have it, by what the function makes of its terms.
macro_rules! band {
    ($coefficients:ident, $l:literal, $function:expr, $($turn:expr),*) => {
        if let Some(f) = $coefficients.get_mut(band_range($l)).and_then(<[_]>::first_chunk_mut::<{ 2 * $l + 1 }>) {
            let mut before = [A::of(f[0]); 2 * $l + 1];
            for (term, f) in before.iter_mut().zip(&*f) {
                *term = A::of(*f);
            }
            let mut after = before;
            $function($($turn,)* &before, &mut after);
            for (f, term) in f.iter_mut().zip(after) {
                *f = term.value();
            }
        }
    };
}

#[inline(always)]
fn low_bands<A: Term>(matrix: &Matrix, coefficients: &mut [A::Value]) {
    let mut numbers = [[A::Scalar::ZERO; 3]; 3];
    for (numbers, row) in numbers.iter_mut().zip(matrix) {
        for (number, entry) in numbers.iter_mut().zip(row) {
            *number = A::Scalar::from_f64(*entry);
        }
    }
    band!(coefficients, 1, rotate_band_1, &numbers);
    band!(coefficients, 2, rotate_band_2, &numbers);
    if coefficients.len() > band_range(2).end {
        middle_bands::<A>(zyz_of(matrix), coefficients);
    }
}

#[inline(always)]
fn middle_bands<A: Term>([alpha, beta, gamma]: [CosSin; 3], coefficients: &mut [A::Value]) {
    let [p, q, r] = [Multiples::of(gamma), Multiples::of(CosSin { sin: -beta.sin, ..beta }), Multiples::of(alpha)];
    let [a, b, c]: [Turns<A::Scalar>; 3] = [p.turns(), q.turns(), r.turns()];
    band!(coefficients, 3, band_3::rotate, &a, &b, &c);
    band!(coefficients, 4, band_4::rotate, &a, &b, &c);
    if coefficients.len() > band_range(4).end {
        let [a, b, c]: [Turns<A::Scalar>; 3] = [p.all_turns(), q.all_turns(), r.all_turns()];
        band!(coefficients, 5, band_5::rotate, &a, &b, &c);
        band!(coefficients, 6, band_6::rotate, &a, &b, &c);
        band!(coefficients, 7, band_7::rotate, &a, &b, &c);
    }
}

/// An angle times 1 to 4, in `f64`, by `e^{i(j+k)a} = e^{ija} e^{ika}`: three products lead to the seventh multiple.
struct Multiples([CosSin; 4]);

impl Multiples {
    #[inline(always)]
    fn of(one: CosSin) -> Self {
        let two = one.and(one);
        Self([one, two, one.and(two), two.and(two)])
    }

    /// The first four, zero above.
    #[inline(always)]
    fn turns<S: Real>(&self) -> Turns<S> {
        let (n, [a, b, c, d]) = (S::from_f64, &self.0);
        let [e, f] = [S::ZERO; 2];
        [n(a.cos), n(a.sin), n(b.cos), n(b.sin), n(c.cos), n(c.sin), n(d.cos), n(d.sin), e, f, e, f, e, f]
    }

    /// All seven.
    #[inline(always)]
    fn all_turns<S: Real>(&self) -> Turns<S> {
        let (n, [_, two, three, four]) = (S::from_f64, &self.0);
        let [e, f, g] = [two.and(*three), three.and(*three), three.and(*four)];
        let [a, b, c, d, h, i, j, k, ..] = self.turns();
        [a, b, c, d, h, i, j, k, n(e.cos), n(e.sin), n(f.cos), n(f.sin), n(g.cos), n(g.sin)]
    }
}
