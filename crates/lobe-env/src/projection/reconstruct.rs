//! Reconstruction of a lat-long map from its coefficients.

use lobe_sh::{Coefficient, Expansion, Rgb, ShVec, coefficient_count, coefficient_index};
use rayon::prelude::*;

use crate::EnvMap;
use crate::projection::high_orders::{FIRST_HIGH_ORDER, reconstruct_high};
use crate::projection::row_dft::RowDft;
use crate::projection::row_legendre::{RowLegendre, for_each_column};

/// The map whose texels have the value of the expansion towards their centers.
///
/// ```text
///   L(θ, φ) = Σ_m (Σ_l f_lm P̃_l^m(cos θ)) cos mφ + (Σ_l f_l,-m P̃_l^m(cos θ)) sin mφ
/// ```
///
/// Separable like [`project_env`](crate::project_env): `O(n²)` for each row, `O(n)` for each texel, from order 25 on `O(log w)`
/// by FFT; above order 16 in `48 h n` bytes. An expansion of
/// radiance may be negative in places. Order 0 gives a black map.
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
    let order = f.order();
    if order >= FIRST_HIGH_ORDER {
        return EnvMap::from_rows(width, height, reconstruct_high(f, order, width, height));
    }
    let azimuth = RowDft::new(width, order);
    let polar = RowLegendre::values(order, height);
    let mut texels = vec![Rgb::ZERO; width * height];
    texels.par_chunks_exact_mut(width).enumerate().for_each(|(y, row)| {
        let mut values = vec![0.0; coefficient_count(order)];
        // Evaluate in the upper half, which has all digits, and mirror by parity.
        let upper = y.min(height - 1 - y);
        polar.eval_into(upper, &mut values);
        let mut waves = vec![[Rgb::ZERO; 2]; order];
        for_each_column(order, |m, l, i| {
            let value = if y != upper && (l + m) % 2 == 1 { -values[i] } else { values[i] };
            waves[m][0] += f[i].scale(value);
            if m > 0 {
                waves[m][1] += f[coefficient_index(l, -(m as isize))].scale(value);
            }
        });
        azimuth.synthesise_into(&waves, row);
    });
    EnvMap::from_rows(width, height, texels)
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
}
