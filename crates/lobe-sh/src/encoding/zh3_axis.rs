//! The axis that lets four numbers and a zonal one keep the most of three bands.

use std::f64::consts::PI;

use crate::solver::newton_on_sphere::ascend;
use crate::sphere::vector::dot;
use crate::{Dir, Sh, eval_with_gradient};

/// Directions from which a maximum is sought beside the linear one: one of each pair of opposite face, edge and corner
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
pub(super) struct Shared {
    /// Weight and band 2 of each channel, bands 0 and 1 zero, times `√(4π/5)`: its value towards `n` is the zonal coefficient.
    quadratic: Vec<(f64, Sh<9, f64>)>,
    /// The linear vector of the weighted sum of the channels.
    linear: [f64; 3],
    /// The sum of the weights.
    weight: f64,
}

impl Shared {
    /// Of channels given as bands 0 to 2, with their weights in the luminance.
    pub(super) fn new(channels: &[(f64, Sh<9, f64>)]) -> Self {
        let mut linear = [0.0; 3];
        let mut quadratic = Vec::new();
        for (w, f) in channels {
            for (sum, part) in linear.iter_mut().zip([-f[3], -f[1], f[2]]) {
                *sum += w * part;
            }
            let scale = (4.0 * PI / 5.0).sqrt();
            quadratic.push((*w, Sh::from(std::array::from_fn(|i| if i < 4 { 0.0 } else { scale * f[i] }))));
        }
        Self { quadratic, linear, weight: channels.iter().map(|(w, _)| w).sum() }
    }

    /// The direction of the linear vector.
    pub(super) fn linear_direction(&self) -> Option<Dir> {
        Dir::new(self.linear)
    }

    /// What the axis `n` keeps of the weighted energy of bands 1 and 2, apart from a constant, and its gradient.
    //
    // The error is Σ_c w_c |error of channel c|². Given the axis, each channel keeps z_c(n)² of its quadratic band. The linear
    // vectors v_c must sum to a multiple of n: Σ w_c v_c ∥ n. The nearest to the given ones, L_c, differ from them all by
    // the same, so that gray stays gray:
    //
    //   v_c - L_c = -(1 - n nᵀ) L/W,      L = Σ w_c L_c,      W = Σ w_c
    //
    // at the price of |(1 - n nᵀ) L|²/W. So the best axis has the greatest
    //
    //   Σ_c w_c z_c(n)² + (n·L)²/W.
    pub(super) fn kept(&self, n: Dir) -> (f64, [f64; 3]) {
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

    /// What has to be added to the linear vector of every channel so that the axis becomes `n`.
    pub(super) fn change(&self, n: Dir) -> [f64; 3] {
        let along = dot(n.to_array(), self.linear);
        [0, 1, 2].map(|k| (along * n.to_array()[k] - self.linear[k]) / self.weight)
    }

    /// The axis that keeps the most, on the side of the linear direction; `None` if that is not defined.
    pub(super) fn best_axis(&self) -> Option<Dir> {
        let first = ascend(self.linear_direction()?, |n| self.kept(n));
        let others = STARTS.iter().filter_map(|v| Dir::new(*v)).map(|start| ascend(start, |n| self.kept(n)));
        let better = |best: Dir, next: Dir| if self.kept(next).0 > self.kept(best).0 { next } else { best };
        let best = others.fold(first, better);
        Some(if dot(best.to_array(), self.linear) < 0.0 { -best } else { best })
    }
}
