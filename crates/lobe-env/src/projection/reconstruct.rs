//! Reconstruction of a lat-long map from its coefficients.

use lobe_io::parallel;
use lobe_sh::basis::{coefficient_count, coefficient_index};
use lobe_sh::{Coefficient, Expansion, Rgb, ShVec};

use crate::map::env_map::EnvMap;
use crate::projection::lat_long_rows::LatLongRows;
use crate::projection::row_dft::RowDft;
use crate::projection::row_legendre::{RowLegendre, for_each_column};

/// Rows whose texels are computed in one piece.
const ROWS_TOGETHER: usize = 8;

/// The map whose texels have the value of the expansion towards their centers.
///
/// ```text
///   L(θ, φ) = Σ_m (Σ_l f_lm P̃_l^m(cos θ)) cos mφ + (Σ_l f_l,-m P̃_l^m(cos θ)) sin mφ
/// ```
///
/// Separable like [`project_env`](crate::project_env): `O(n²)` for each row, `O(n)` for each texel. An
/// expansion of radiance may be negative in places. Order 0 gives a black map.
///
/// Texels are values, not means, so projecting the map again gives band `l` back only up to about `l (l+1) Δ²/24` of
/// it, with `Δ` the larger side of a texel in radians (test
/// `a_band_limited_map_has_its_coefficients_up_to_the_squared_texel_size`).
///
/// # Panics
/// If a side is 0.
#[must_use]
pub fn reconstruct(f: &ShVec<Rgb<f64>>, width: usize, height: usize) -> EnvMap {
    assert!(width > 0 && height > 0, "an environment map needs texels, but {width} x {height} has none");
    let mut texels = vec![Rgb::ZERO; width * height];
    reconstruct_into(f, width, &mut texels);
    EnvMap::from_rows(width, height, texels)
}

/// [`reconstruct`] into texels row after row, numbers or colors of `f32` or `f64`.
///
/// ```
/// use lobe_env::reconstruct_into;
/// use lobe_sh::ShVec;
///
/// // z, from 1 on top to -1 at the bottom.
/// let z = ShVec::from_vec(vec![0.0, 0.0, (4.0 * std::f64::consts::PI / 3.0).sqrt(), 0.0]).expect("four numbers");
/// let mut texels = [0.0_f64; 8 * 4];
/// reconstruct_into(&z, 8, &mut texels);
/// assert!((texels[0] - (std::f64::consts::PI / 8.0).cos()).abs() < 1e-15 && (texels[31] + texels[0]).abs() < 1e-15);
/// ```
///
/// # Panics
/// If `width` is 0, or the texels are not whole rows of it, or there are none.
pub fn reconstruct_into<C: Coefficient>(f: &ShVec<C::Wide>, width: usize, texels: &mut [C]) {
    let (order, height) = (f.order(), LatLongRows::new(texels, width).height());
    let azimuth = RowDft::new(width, order);
    let polar = RowLegendre::values(order, height);
    parallel::rows(texels, ROWS_TOGETHER * width, &|chunk, texels| {
        let mut values = vec![0.0; coefficient_count(order)];
        let mut rows: Vec<&mut [C]> = texels.chunks_exact_mut(width).collect();
        let mut waves = vec![[C::Wide::ZERO; 2]; rows.len() * order];
        for (y, waves) in (chunk * ROWS_TOGETHER..).zip(waves.chunks_exact_mut(order.max(1))) {
            // Evaluate in the upper half, which has all digits, and mirror by parity.
            let upper = y.min(height - 1 - y);
            polar.eval_into(upper, &mut values);
            for_each_column(order, |m, l, i| {
                let value = if y != upper && (l + m) % 2 == 1 { -values[i] } else { values[i] };
                waves[m][0] += f[i].scale(value);
                if m > 0 {
                    waves[m][1] += f[coefficient_index(l, -(m as isize))].scale(value);
                }
            });
        }
        let waves: Vec<_> = (0..rows.len()).map(|k| &waves[k * order..][..order]).collect();
        azimuth.synthesise_into(&waves, &mut rows);
    });
}

#[cfg(test)]
mod tests {
    use lobe_testkit::Random;

    use super::*;

    #[test]
    fn the_texels_are_the_values_of_the_expansion() {
        for (order, w, h) in
            [(1, 2, 1), (3, 8, 4), (6, 7, 5), (12, 36, 17), (64, 20, 10), (70, 12, 6), (100, 64, 33), (256, 22, 41)]
        {
            let mut random = Random::new(order as u64);
            let f = (0..coefficient_count(order)).map(|_| Rgb::from([(); 3].map(|()| random.signed()))).collect();
            let f = ShVec::from_vec(f).unwrap();
            let map = reconstruct(&f, w, h);
            for y in 0..h {
                for x in 0..w {
                    let (found, expected) = (map.texel(x, y), f.eval(map.dir(x, y)));
                    let error = (found.widen() - expected).to_array().map(f64::abs);
                    let limit = 1e-6 * order as f64;
                    assert!(error.iter().all(|e| *e < limit), "order {order} at ({x}, {y}): {found:?} {expected:?}");
                }
            }
        }
    }

    #[test]
    fn numbers_are_the_values_of_the_expansion_in_their_precision() {
        for (order, w, h) in [(1, 2, 1), (6, 7, 5), (12, 36, 17), (20, 32, 10), (64, 20, 10), (70, 12, 7)] {
            let f = ShVec::from_vec(Random::new(order as u64).signed_vec(coefficient_count(order))).unwrap();
            let (mut single, mut double) = (vec![0.0_f32; w * h], vec![0.0_f64; w * h]);
            reconstruct_into(&f, w, &mut single);
            reconstruct_into(&f, w, &mut double);
            let map = EnvMap::from_rows(w, h, vec![Rgb::ZERO; w * h]);
            for (k, (single, double)) in single.iter().zip(&double).enumerate() {
                let expected = f.eval(map.dir(k % w, k / w));
                assert!((double - expected).abs() < 1e-12 * order as f64, "order {order}, {k}: {double}, {expected}");
                assert!((f64::from(*single) - expected).abs() < 1e-6 * order as f64, "order {order}, {k}: {single}");
            }
        }
    }
}
