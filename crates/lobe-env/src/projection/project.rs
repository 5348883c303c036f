//! Projection of a lat-long environment map onto spherical harmonics.

use std::f64::consts::PI;
use std::ops::Range;

use lobe_io::parallel;
use lobe_sh::basis::{coefficient_count, coefficient_index};
use lobe_sh::{Coefficient, Expansion, FixedOrder, Rgb, ShVec};

use crate::map::env_map::EnvMap;
use crate::mapping::lat_long::sin_cos_pi;
use crate::projection::lat_long_rows::LatLongRows;
use crate::projection::row_dft::{RowDft, RowSums};
use crate::projection::row_legendre::{RowLegendre, for_each_column};

/// Pairs of mirrored rows that share one pass over the tables of cosines.
const PAIRS_TOGETHER: usize = 8;

/// The most partial results held at once. The chunks depend on the height of the picture alone, never on the number
/// of threads, so that the sum is the same on every machine.
const MAX_CHUNKS: usize = 64;

/// The coefficients of the environment in the basis of the given order.
///
/// ```text
///   f_lm = ∫ L(s) y_lm(s) ds = Σ_y R_lm(y) Σ_x L(x, y) c_m(x)
///
///   R_lm(y) = ∫_{θ_y}^{θ_{y+1}} P̃_l^|m|(cos θ) sin θ dθ                       θ_y = π y/h
///   c_m(x)  = ∫_column cos mφ dφ = (2/m) sin(mπ/w) cos mφ_x    (m > 0; sin mφ_x for -m; 2π/w for m = 0)
/// ```
///
/// The map is piecewise constant over texels, and that function is projected **exactly**: the basis is integrated over
/// every texel, not sampled at its center. So the weights of the texels are their solid angles, a constant map of any
/// size has only a mean, and a sun of one texel keeps its energy and direction wherever it is
/// (tests `a_constant_map_of_any_size_has_only_a_mean`, `a_sun_of_one_texel_keeps_its_energy_and_its_direction`).
///
/// Order 0 has no coefficients. A texel that is not finite makes the coefficients NaN or infinite.
///
/// Both integrals separate: the cost is `O(w h n)` for the sums along the rows and `O(h n²)` for the rest. Sums are in `f64`
/// and the result has the same bits for any number of threads (`the_projection_has_the_same_bits_for_any_number_of_threads`).
///
/// ```
/// use lobe_env::{EnvMap, project_env};
/// use lobe_sh::{Expansion, Rgb};
///
/// let sky = EnvMap::from_fn(64, 32, |s| Rgb::new(0.5, 0.5, 1.0 + s.z() as f32));
/// let light = project_env(&sky, 3);
/// assert!((light.mean().b - 1.0).abs() < 1e-6);
/// assert!(light[2].b > 0.0 && light[2].r.abs() < 1e-12);
/// ```
#[must_use]
pub fn project_env(map: &EnvMap, order: usize) -> ShVec<Rgb<f64>> {
    project_rows(LatLongRows::from(&**map), order)
}

/// [`project_env`] with the order and coefficients of the type `E`.
///
/// ```
/// use lobe_env::{bundled, project_env_as};
/// use lobe_sh::{Rgb, ShL2};
///
/// let light = project_env_as::<ShL2<Rgb<f32>>>(&bundled::sunset().map());
/// assert!(light[0].g > 0.0);
/// ```
#[must_use]
pub fn project_env_as<E>(map: &EnvMap) -> E
where
    E: FixedOrder,
    E::Value: Coefficient<Wide = Rgb<f64>>,
{
    fixed(&project_env(map, E::ORDER))
}

/// The expansion as a type of fixed order, rounded to its coefficients.
pub(crate) fn fixed<E>(f: &ShVec<Rgb<f64>>) -> E
where
    E: FixedOrder,
    E::Value: Coefficient<Wide = Rgb<f64>>,
{
    let coefficients: Vec<E::Value> = f.coefficients().iter().map(|c| E::Value::narrow(*c)).collect();
    E::from_coefficients(&coefficients)
}

/// [`project_env`] of texels row after row, numbers or colors of `f32` or `f64`, which are read where they are.
///
/// ```
/// use lobe_env::project_lat_long;
///
/// // A sky of 1 over a ground of 0, of numbers: a mean and a part along z.
/// let texels: Vec<f64> = (0..64 * 32).map(|k| if k < 64 * 16 { 1.0 } else { 0.0 }).collect();
/// let f = project_lat_long(&texels, 64, 2);
/// let pi = std::f64::consts::PI;
/// assert!((f[0] - pi.sqrt()).abs() < 1e-12 && (f[2] - (0.75 * pi).sqrt()).abs() < 1e-12 && f[1].abs() < 1e-12);
/// ```
///
/// # Panics
/// If `width` is 0, or the texels are not whole rows of it, or there are none.
#[must_use]
pub fn project_lat_long<C: Coefficient>(texels: &[C], width: usize, order: usize) -> ShVec<C::Wide> {
    project_rows(LatLongRows::new(texels, width), order)
}

/// Pair of mirrored rows by pair, with the functions integrated over each.
pub(crate) fn project_rows<C: Coefficient>(map: LatLongRows<'_, C>, order: usize) -> ShVec<C::Wide> {
    if order == 0 {
        return ShVec::zero(0);
    }
    let columns = column_factors(map.width(), order);
    let azimuth = RowDft::new(map.width(), order);
    let polar = RowLegendre::integrals(order, map.height());
    sum_of_pairs(map.height(), order, |pairs, part| {
        for first in pairs.clone().step_by(PAIRS_TOGETHER) {
            add_pairs(map, first..pairs.end.min(first + PAIRS_TOGETHER), &azimuth, &polar, &columns, part);
        }
    })
}

/// The sum of what `add` adds for ranges of pairs of mirrored rows, always the same ranges.
pub(crate) fn sum_of_pairs<W: Coefficient<Scalar = f64, Wide = W>>(
    height: usize,
    order: usize,
    add: impl Fn(Range<usize>, &mut ShVec<W>) + Sync,
) -> ShVec<W> {
    let pairs = height.div_ceil(2);
    let chunk = pairs.div_ceil(MAX_CHUNKS).max(PAIRS_TOGETHER);
    let parts: Vec<ShVec<W>> = parallel::map(pairs.div_ceil(chunk), &|c| {
        let mut part = ShVec::zero(order);
        add(c * chunk..pairs.min((c + 1) * chunk), &mut part);
        part
    });
    parts.iter().fold(ShVec::zero(order), |mut sum, part| {
        sum += part;
        sum
    })
}

/// `∫_column cos mφ dφ / cos mφ_x` for every `m`.
pub(crate) fn column_factors(width: usize, order: usize) -> Vec<f64> {
    let w = width as f64;
    (0..order)
        .map(|m| match m {
            0 => 2.0 * PI / w,
            _ => 2.0 / m as f64 * sin_cos_pi((m % (2 * width)) as f64 / w).0,
        })
        .collect()
}

/// Adds the contributions of the rows `y` and `h - 1 - y`, for all `y` in `pairs`.
fn add_pairs<C: Coefficient>(
    map: LatLongRows<'_, C>,
    pairs: Range<usize>,
    azimuth: &RowDft,
    polar: &RowLegendre,
    columns: &[f64],
    part: &mut ShVec<C::Wide>,
) {
    let (order, height) = (columns.len(), map.height());
    let mut sums = vec![[C::Wide::ZERO; 2]; 2 * pairs.len() * order];
    let rows: Vec<_> = pairs.clone().flat_map(|y| [map.row(y), map.row(height - 1 - y)]).collect();
    azimuth.add_sums(&rows, &mut sums);
    for (y, sums) in pairs.zip(sums.chunks_exact(2 * order)) {
        let (upper, lower) = sums.split_at(order);
        add_pair(y, height, [upper, lower], polar, columns, part);
    }
}

/// Adds the contribution of the rows `y` and `height - 1 - y`, whose sums along them are given.
pub(crate) fn add_pair<W: Coefficient<Scalar = f64, Wide = W>>(
    y: usize,
    height: usize,
    [upper, lower]: [&RowSums<W>; 2],
    polar: &RowLegendre,
    columns: &[f64],
    part: &mut ShVec<W>,
) {
    let order = columns.len();
    let mut integrals = vec![0.0; coefficient_count(order)];
    polar.integrate_into(y, &mut integrals);
    // The middle row of an odd number is its own mirror image: count it once.
    let lower_weight = if y == height - 1 - y { 0.0 } else { 1.0 };
    let f = part.coefficients_mut();
    for_each_column(order, |m, l, i| {
        let parity = if (l + m) % 2 == 0 { lower_weight } else { -lower_weight };
        let weight = integrals[i] * columns[m];
        f[i] += (upper[m][0] + lower[m][0].scale(parity)).scale(weight);
        if m > 0 {
            f[coefficient_index(l, -(m as isize))] += (upper[m][1] + lower[m][1].scale(parity)).scale(weight);
        }
    });
}

#[cfg(test)]
mod tests {
    use lobe_testkit::Random;

    use super::*;

    #[test]
    fn numbers_have_the_projection_of_a_channel_in_their_precision() {
        for (order, w, h) in [(1, 1, 1), (4, 64, 33), (16, 30, 17), (17, 8, 4), (40, 64, 31), (70, 33, 20)] {
            let mut random = Random::new(order as u64);
            let singles: Vec<f32> = (0..w * h).map(|_| random.unit() as f32).collect();
            let doubles: Vec<f64> = singles.iter().map(|v| f64::from(*v)).collect();
            let colors: Vec<Rgb<f32>> = singles.iter().map(|v| Rgb::new(0.0, *v, 1.0)).collect();
            let wide: Vec<Rgb<f64>> = colors.iter().map(|c| c.widen()).collect();
            let expected = project_lat_long(&colors, w, order);
            let (single, double) = (project_lat_long(&singles, w, order), project_lat_long(&doubles, w, order));
            let wide = project_lat_long(&wide, w, order);
            let limit = 1e-13 * expected[0].g;
            for i in 0..coefficient_count(order) {
                let expected = expected[i].g;
                for found in [single[i], double[i], wide[i].g] {
                    assert!((found - expected).abs() < limit, "order {order}, {w} x {h}, c_{i}: {found}, {expected}");
                }
            }
        }
    }
}
