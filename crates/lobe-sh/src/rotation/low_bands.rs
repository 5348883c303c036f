//! Rotation of bands 1 and 2 in closed form.

#[cfg(not(feature = "std"))]
use num_traits::Float as _;

use crate::{Coefficient, Real};

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
pub(crate) fn rotate_band_1<T: Coefficient>(r: &[[f64; 3]; 3], f: &mut [T]) {
    let v = [-f[2], -f[0], f[1]];
    let [x, y, z] = r.map(|row| dot(row.map(T::Scalar::from_f64), v));
    f.copy_from_slice(&[-y, z, -x]);
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
pub(crate) fn rotate_band_2<T: Coefficient>(r: &[[f64; 3]; 3], f: &mut [T]) {
    let number = T::Scalar::from_f64;
    let r = r.map(|row| row.map(number));
    let third = f[2].scale(number(3.0_f64.sqrt().recip()));
    let b = [[f[4] - third, f[0], -f[3]], [f[0], -f[4] - third, -f[1]], [-f[3], -f[1], third + third]];
    // B is symmetric: its rows are its columns.
    let rb = r.map(|row| b.map(|column| dot(row, column)));
    let entry = |i: usize, j: usize| dot(r[j], rb[i]);
    f.copy_from_slice(&[
        entry(0, 1),
        -entry(1, 2),
        entry(2, 2).scale(number(0.75_f64.sqrt())),
        -entry(0, 2),
        (entry(0, 0) - entry(1, 1)).scale(number(0.5)),
    ]);
}

#[inline(always)]
fn dot<T: Coefficient>(row: [T::Scalar; 3], v: [T; 3]) -> T {
    v[0].scale(row[0]) + v[1].scale(row[1]) + v[2].scale(row[2])
}
