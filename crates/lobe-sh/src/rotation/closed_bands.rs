//! Rotation of bands 1 and 2 in closed form.

use crate::rotation::term::{Term, number};

/// √3; `f64::sqrt` is not const.
pub(crate) const SQRT_3: f64 = 1.732_050_807_568_877_2;

/// Rotates the three coefficients of band 1, which are a vector.
///
/// ```text
///   f = √(3/4π) v · s        v = (-f_1, -f_-1, f_0)        v' = R v
///
///                                     [ R_11 -R_12  R_10 ]
///   so that (f_-1, f_0, f_1)' is the  [-R_21  R_22 -R_20 ]  multiple of (f_-1, f_0, f_1),
///                                     [ R_01 -R_02  R_00 ]
/// ```
///
/// rows and columns of `R` counted from 0.
#[inline(always)]
pub(crate) fn rotate_band_1<T: Term>(r: &[[T::Scalar; 3]; 3], f: &[T; 3], out: &mut [T; 3]) {
    let v = [-f[2], -f[0], f[1]];
    *out = [-dot(&r[1], &v), dot(&r[2], &v), -dot(&r[0], &v)];
}

/// Rotates the five coefficients of band 2, which are a symmetric matrix without trace.
///
/// ```text
///   f = √(15/16π) sᵀ B s        B' = R B Rᵀ
///
///       [ f_2 - f_0/√3     f_-2             -f_1      ]          f_0 = √3/2 B_zz
///   B = [ f_-2            -f_2 - f_0/√3     -f_-1     ]          f_2 = (B_xx - B_yy)/2
///       [-f_1             -f_-1              2 f_0/√3 ]
/// ```
///
/// 48 multiplications.
#[inline(always)]
pub(crate) fn rotate_band_2<T: Term>(r: &[[T::Scalar; 3]; 3], f: &[T; 5], out: &mut [T; 5]) {
    let third = f[2].times(number(SQRT_3.recip()));
    let b = [[f[4] - third, f[0], -f[3]], [f[0], -f[4] - third, -f[1]], [-f[3], -f[1], third + third]];
    // B is symmetric: its rows are its columns.
    let mut rb = b;
    for (rb, row) in rb.iter_mut().zip(r) {
        *rb = [dot(row, &b[0]), dot(row, &b[1]), dot(row, &b[2])];
    }
    *out = [
        dot(&r[1], &rb[0]),
        -dot(&r[2], &rb[1]),
        dot(&r[2], &rb[2]).times(number(0.5 * SQRT_3)),
        -dot(&r[2], &rb[0]),
        (dot(&r[0], &rb[0]) - dot(&r[1], &rb[1])).times(number(0.5)),
    ];
}

#[inline(always)]
fn dot<T: Term>(row: &[T::Scalar; 3], v: &[T; 3]) -> T {
    v[2].times_plus(row[2], v[1].times_plus(row[1], v[0].times(row[0])))
}
