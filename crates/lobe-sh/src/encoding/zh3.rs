//! ZH3: bands 0 and 1 and one zonal coefficient of band 2.

use core::f64::consts::PI;

use crate::encoding::{LINEAR_SHARE, QUADRATIC_SHARE, channel_of, coefficient, linear_vector};
use crate::expansion::gradient::eval_with_gradient;
use crate::expansion::{Expansion, Sh, Zonal};
use crate::prelude::*;
use crate::scalar::{Coefficient, Real};
use crate::scalar::{luminance, luminance_weight};
use crate::solver::newton_on_sphere::ascend;
use crate::sphere::Dir;
use crate::sphere::vector::dot;

/// The shortest luminance vector, as a share of the given one, that still defines an axis: half of the digits of `f32`.
const SHORTEST_VECTOR: f64 = 3e-4;

/// The origin of the axis of [`Zh3`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum Zh3Axis {
    /// All channels share the optimal linear direction of their luminance.
    Luminance,
    /// Each channel has its own linear direction.
    PerChannel,
}

/// Irradiance as bands 0 and 1 and, for each channel, one zonal coefficient of band 2 about the linear direction.
///
/// ```text
///   E(n) = Σ_{i<4} E_i y_i(n) + z √(5/16π) (3 (n·d)² - 1)        d = (-E_3, -E_1, E_2) / |..|
/// ```
///
/// Five numbers for each channel; `d` needs none, because it follows from the linear band of the luminance or of each
/// channel ([`Zh3Axis`]). One light and a constant, which are zonal about one axis, are kept exactly. The encoding
/// rotates with the light. Without a linear direction the last term is zero. After Roughton et al. 2024.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Zh3<T = f32> {
    /// Bands 0 and 1 of the irradiance.
    pub linear: Sh<4, T>,
    /// `z`, the zonal coefficient of band 2 about the axis.
    pub zonal: T,
    /// The origin of the axis.
    pub axis: Zh3Axis,
}

impl<T: Coefficient> Zh3<T> {
    /// Keeps the linear band as it is and projects band 2 on its axis.
    ///
    /// ```text
    ///   z = √(4π/5) Σ_m E_2m y_2m(d)
    /// ```
    #[must_use]
    pub fn projected(irradiance: &impl Expansion<T>, axis: Zh3Axis) -> Self {
        let linear = Sh::from_slice(irradiance.coefficients());
        let axes = axes(&linear, axis);
        let zonal = |c: usize| axes(c).map_or(0.0, |d| Zonal::about(d, &three_bands::<T>(irradiance, c))[2]);
        Self { linear, zonal: T::from_channels(|c| T::Scalar::from_f64(zonal(c))), axis }
    }

    /// The encoding of this form with the least squared error against bands 0 to 2: the linear band changes so that the
    /// axis suits band 2.
    ///
    /// If the channels share an axis, each has its weight in the luminance. With equal weights green, which determines
    /// the axis most, would change alone, and gray light would become colored (test
    /// `a_shared_axis_leaves_gray_light_gray`).
    ///
    /// For a given axis the best coefficients have a closed form; there remains the maximum of a form of degree 4 on
    /// the sphere, found by Newton's method from the linear direction and 13 further starts. Never worse than
    /// [`Zh3::projected`] (test
    /// `the_solved_axis_is_the_best_of_a_dense_grid`). If the best axis would leave no linear vector that gives it, the
    /// result is the projection.
    #[must_use]
    pub fn solved(irradiance: &impl Expansion<T>, axis: Zh3Axis) -> Self {
        let weighted = |c: usize, w: f64| (w, three_bands::<T>(irradiance, c));
        let numbers: Vec<[f64; 5]> = match axis {
            Zh3Axis::Luminance => {
                let all: Vec<_> = (0..T::CHANNELS).map(|c| weighted(c, luminance_weight::<T>(c))).collect();
                solve_together(&all)
            }
            Zh3Axis::PerChannel => (0..T::CHANNELS).flat_map(|c| solve_together(&[weighted(c, 1.0)])).collect(),
        };
        let coefficient = |i: usize| T::from_channels(|c| T::Scalar::from_f64(numbers[c][i]));
        Self { linear: Sh::<4, T>::from([0, 1, 2, 3].map(coefficient)), zonal: coefficient(4), axis }
    }

    /// Estimates `z` from bands 0 and 1 alone, from the usual shape of light; no number is stored for it.
    ///
    /// ```text
    ///   z = π/4 · L_0 r (0.08 + 0.6 r)        r = |L_1 vector · d| / L_0
    /// ```
    ///
    /// `L` are the coefficients of the radiance, `L_l = E_l/A_l`. `r` is limited to `√3`, that of a single directional
    /// light, and `z` is 0 where `L_0` is not above 0.
    #[must_use]
    pub fn hallucinated(irradiance: &impl Expansion<T>, axis: Zh3Axis) -> Self {
        let linear = Sh::from_slice(irradiance.coefficients());
        let axes = axes(&linear, axis);
        let vector = linear_vector(&linear);
        let zonal = |c: usize| {
            let l_0 = coefficient(&linear, 0).channel(c) / PI;
            let along = axes(c).map_or(0.0, |d| dot(d.to_array(), channel_of(vector, c)));
            hallucinated_zonal(l_0, along.abs() / (PI * LINEAR_SHARE))
        };
        Self { linear, zonal: T::from_channels(|c| T::Scalar::from_f64(zonal(c))), axis }
    }

    /// The irradiance of a surface with normal `n`.
    #[must_use]
    pub fn eval(&self, n: Dir) -> T {
        let linear = self.linear.map(T::widen).eval(n);
        let axes = axes(&self.linear, self.axis);
        T::from_channels(|c| {
            let p_2 = axes(c).map_or(0.0, |d| 3.0 * n.dot(d).powi(2) - 1.0);
            let zonal = self.zonal.widen().channel(c);
            T::Scalar::from_f64(linear.channel(c) + zonal * (5.0 / (16.0 * PI)).sqrt() * p_2)
        })
    }
}

/// The zonal coefficient of the irradiance, from the radiance's mean coefficient and the length of its linear one.
fn hallucinated_zonal(l_0: f64, l_1: f64) -> f64 {
    if l_0 <= 0.0 {
        return 0.0;
    }
    let r = l_1 / l_0;
    let r = if r > 3.0_f64.sqrt() { 3.0_f64.sqrt() } else { r };
    PI * QUADRATIC_SHARE * l_0 * r * (0.08 + 0.6 * r)
}

/// The axis of each channel.
fn axes<T: Coefficient>(linear: &Sh<4, T>, axis: Zh3Axis) -> impl Fn(usize) -> Option<Dir> {
    let vector = linear_vector(linear);
    let shared = Dir::new(vector.map(luminance));
    move |c| match axis {
        Zh3Axis::Luminance => shared,
        Zh3Axis::PerChannel => Dir::new(channel_of(vector, c)),
    }
}

/// Bands 0 to 2 of a channel.
fn three_bands<T: Coefficient>(f: &impl Expansion<T>, c: usize) -> Sh<9, f64> {
    Sh::from(core::array::from_fn(|i| coefficient(f, i).channel(c)))
}

/// Bands 0 and 1 and the zonal coefficient of each channel, for channels with weights that share an axis.
fn solve_together(channels: &[(f64, Sh<9, f64>)]) -> Vec<[f64; 5]> {
    let shared = Shared::new(channels);
    let linear = shared.linear_direction();
    // An axis perpendicular to the linear direction leaves no vector that gives it.
    let best = shared.best_axis().filter(|n| linear.is_some_and(|d| d.dot(*n) > SHORTEST_VECTOR));
    let one = |(_, f): &(f64, Sh<9, f64>)| {
        let [x, y, z] = best.map_or([0.0; 3], |n| shared.change(n));
        let zonal = best.or(linear).map_or(0.0, |n| Zonal::about(n, f)[2]);
        [f[0], f[1] - y, f[2] + z, f[3] - x, zonal]
    };
    channels.iter().map(one).collect()
}

/// Starts of the search for a maximum, besides the linear direction: one of each pair of opposite face, edge and corner
/// directions of the cube.
const STARTS: [[f64; 3]; 13] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 1.0, 0.0],
    [1.0, -1.0, 0.0],
    [1.0, 0.0, 1.0],
    [1.0, 0.0, -1.0],
    [0.0, 1.0, 1.0],
    [0.0, 1.0, -1.0],
    [1.0, 1.0, 1.0],
    [1.0, 1.0, -1.0],
    [1.0, -1.0, 1.0],
    [-1.0, 1.0, 1.0],
];

/// Channels that share an axis: the quadratic band of each, and the linear vector of their luminance.
pub(crate) struct Shared {
    /// Weight and band 2 of each channel, bands 0 and 1 zero, times `√(4π/5)`: its value towards `n` is the zonal
    /// coefficient.
    quadratic: Vec<(f64, Sh<9, f64>)>,
    /// The linear vector of the weighted sum of the channels.
    linear: [f64; 3],
    /// The sum of the weights.
    weight: f64,
}

impl Shared {
    /// Of channels given as bands 0 to 2, with their weights in the luminance.
    pub(crate) fn new(channels: &[(f64, Sh<9, f64>)]) -> Self {
        let mut linear = [0.0; 3];
        let mut quadratic = Vec::new();
        for (w, f) in channels {
            for (sum, part) in linear.iter_mut().zip([-f[3], -f[1], f[2]]) {
                *sum += w * part;
            }
            let scale = (4.0 * PI / 5.0).sqrt();
            quadratic.push((*w, Sh::<9, f64>::from(core::array::from_fn(|i| if i < 4 { 0.0 } else { scale * f[i] }))));
        }
        Self { quadratic, linear, weight: channels.iter().map(|(w, _)| w).sum() }
    }

    /// The direction of the linear vector.
    pub(crate) fn linear_direction(&self) -> Option<Dir> {
        Dir::new(self.linear)
    }

    /// The weighted energy of bands 1 and 2 that the axis `n` keeps, up to a constant, and its gradient.
    //
    // The error is Σ_c w_c |error of channel c|². Given the axis, each channel keeps z_c(n)² of its quadratic band. The
    // linear vectors v_c must sum to a multiple of n: Σ w_c v_c ∥ n. The nearest to the given ones, L_c, differ from
    // them all by the same, so that gray stays gray:
    //
    //   v_c - L_c = -(1 - n nᵀ) L/W,      L = Σ w_c L_c,      W = Σ w_c
    //
    // at the price of |(1 - n nᵀ) L|²/W. So the best axis has the greatest
    //
    //   Σ_c w_c z_c(n)² + (n·L)²/W.
    pub(crate) fn kept(&self, n: Dir) -> (f64, [f64; 3]) {
        let along = dot(n.to_array(), self.linear);
        let mut value = along * along / self.weight;
        let mut gradient = self.linear.map(|l| 2.0 * along * l / self.weight);
        for (w, f) in &self.quadratic {
            let (z, slope) = eval_with_gradient(f, n);
            value += w * z * z;
            for (sum, d) in gradient.iter_mut().zip(slope) {
                *sum += 2.0 * w * z * d;
            }
        }
        (value, gradient)
    }

    /// The change of the linear vector of every channel that makes `n` the axis.
    pub(crate) fn change(&self, n: Dir) -> [f64; 3] {
        let along = dot(n.to_array(), self.linear);
        [0, 1, 2].map(|k| (along * n.to_array()[k] - self.linear[k]) / self.weight)
    }

    /// The axis that keeps the most energy, on the side of the linear direction; `None` if that is not defined.
    pub(crate) fn best_axis(&self) -> Option<Dir> {
        let first = ascend(self.linear_direction()?, |n| self.kept(n));
        let others = STARTS.iter().filter_map(|v| Dir::new(*v)).map(|start| ascend(start, |n| self.kept(n)));
        let better = |best: Dir, next: Dir| if self.kept(next).0 > self.kept(best).0 { next } else { best };
        let best = others.fold(first, better);
        Some(if dot(best.to_array(), self.linear) < 0.0 { -best } else { best })
    }
}
