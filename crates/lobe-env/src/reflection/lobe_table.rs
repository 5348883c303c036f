//! Tables of the lobes of GGX, by the angle of view and the roughness: what they reflect of even light, and where they
//! point.

use lobe_io::parallel;
use lobe_sh::Dir;
use lobe_sh::sphere::vector::dot;

use crate::reflection::dfg::{Dfg, Masking, dfg, dfg_separable, mean_of_lobe};

/// Nodes along a side.
const NODES: usize = 33;

/// The sine of the angle of view in place of zero, at which a lobe has no side to lean to.
const LEAST_SINE: f64 = 1e-3;

/// Up to this roughness, α = 10⁻⁴, [`dfg()`] is that of a mirror, whose formula needs no table.
const MIRROR: f64 = 0.01;

/// A lobe of GGX.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LobeNode {
    /// What it reflects of even light.
    pub dfg: Dfg,
    /// The sine of the angle between its mean and the normal, as a part of that of the mirrored direction.
    pub lean: f64,
}

/// The lobes of GGX between nodes at `√cos` of the angle of view and roughness `k/32`, bilinear.
///
/// ```text
///   m(v, α) = ∫ f(v, l) (n·l) l dl / ∫ f(v, l) (n·l) dl          f = D V, white and without Fresnel's factor
/// ```
///
/// A prefiltered map holds, for each roughness, the lobe of a view along the normal. A lobe that is seen at a slant
/// leans from the mirrored direction to the normal: looked up about `m/|m|` it agrees better than about that direction.
///
/// A [`DfgTable`](crate::DfgTable) ends half a texel before roughness 1, which most materials have, and white metals of
/// it are 2.6 % too bright by 64 texels. This one is exact there and for mirrors along its nodes. Its reflectance is
/// within 0.0025 where the cosine is at least 0.1, within 0.02 where it is at least 0.01, and within 0.09 below, where
/// that of smooth surfaces rises (test `the_table_interpolates_within_its_stated_error`).
///
/// ```
/// use lobe_env::LobeTable;
/// use lobe_sh::Dir;
///
/// let (table, mirrored) = (LobeTable::correlated(), Dir::from_angles(1.2, 0.0));
/// let rough = table.axis(mirrored, Dir::Z, 1.0);
/// assert!(rough.z() > mirrored.z(), "a rough surface looks up about a direction nearer to its normal");
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct LobeTable {
    /// Row after row of rising roughness.
    nodes: Vec<LobeNode>,
}

impl LobeTable {
    /// Computes the table for height-correlated masking, in parallel.
    #[must_use]
    pub fn correlated() -> Self {
        Self::new(Masking::Correlated, dfg)
    }

    /// The same for separable masking, [`dfg_separable`].
    #[must_use]
    pub fn separable() -> Self {
        Self::new(Masking::Separable, dfg_separable)
    }

    fn new(masking: Masking, integral: fn(f64, f64) -> Dfg) -> Self {
        let at = |k: usize| k as f64 / (NODES - 1) as f64;
        let node = |k: usize| {
            let (cos, alpha) = (at(k % NODES).powi(2), at(k / NODES).powi(2));
            let slanted = cos.clamp(LEAST_SINE, (1.0 - LEAST_SINE * LEAST_SINE).sqrt());
            let [across, up] = mean_of_lobe(slanted, alpha, masking);
            let lean = across / (across.hypot(up) * (1.0 - slanted * slanted).sqrt());
            // A mirror does not lean, to the last digit.
            LobeNode { dfg: integral(cos, alpha), lean: if alpha == 0.0 { 1.0 } else { lean } }
        };
        Self { nodes: parallel::map(NODES * NODES, &node) }
    }

    /// The number of rows, and of columns.
    #[must_use]
    pub fn size(&self) -> usize {
        NODES
    }

    /// All nodes, row after row from the smoothest.
    #[must_use]
    pub fn nodes(&self) -> &[LobeNode] {
        &self.nodes
    }

    /// The lobe between nodes, seen at the angle of this cosine, of a surface of this roughness; both in `[0, 1]`.
    #[must_use]
    pub fn lookup(&self, cos_view: f64, roughness: f64) -> LobeNode {
        let split = |t: f64| {
            let place = t.clamp(0.0, 1.0) * (NODES - 1) as f64;
            let low = (place as usize).min(NODES - 2);
            (low, place - low as f64)
        };
        let ((x, tx), (y, ty)) = (split(cos_view.max(0.0).sqrt()), split(roughness));
        let row = |y: usize| mix(self.nodes[y * NODES + x], self.nodes[y * NODES + x + 1], tx);
        mix(row(y), row(y + 1), ty)
    }

    /// The reflectance in even light, exact for mirrors.
    #[must_use]
    pub fn dfg(&self, cos_view: f64, roughness: f64) -> Dfg {
        if roughness <= MIRROR { dfg(cos_view, 0.0) } else { self.lookup(cos_view, roughness).dfg }
    }

    /// The mean direction of the lobe of a surface of this roughness in `[0, 1]`, whose mirrored direction is above it.
    #[must_use]
    pub fn axis(&self, mirrored: Dir, normal: Dir, roughness: f64) -> Dir {
        let (r, n, cos) = (mirrored.to_array(), normal.to_array(), normal.dot(mirrored));
        let lean = self.lookup(cos, roughness).lean;
        let along = [0, 1, 2].map(|k| lean * (r[k] - cos * n[k]));
        let up = (1.0 - dot(along, along)).max(0.0).sqrt();
        Dir::new([0, 1, 2].map(|k| along[k] + up * n[k])).unwrap_or(mirrored)
    }
}

fn mix(a: LobeNode, b: LobeNode, t: f64) -> LobeNode {
    let between = |a: f64, b: f64| (1.0 - t) * a + t * b;
    let dfg = Dfg { scale: between(a.dfg.scale, b.dfg.scale), bias: between(a.dfg.bias, b.dfg.bias) };
    LobeNode { dfg, lean: between(a.lean, b.lean) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mirror_points_where_it_mirrors_and_a_rough_surface_leans_to_its_normal() {
        let (table, normal) = (LobeTable::correlated(), Dir::Z);
        for cos in [0.15, 0.5, 0.9_f64] {
            let mirrored = Dir::new([(1.0 - cos * cos).sqrt(), 0.0, cos]).unwrap();
            let axis = |roughness: f64| table.axis(mirrored, normal, roughness);
            assert!(axis(0.0).dot(mirrored) > 1.0 - 1e-4, "cosine {cos}: {:?}", axis(0.0));
            let leans: Vec<f64> = [0.2, 0.5, 1.0].map(|roughness| axis(roughness).dot(normal)).to_vec();
            assert!(leans.is_sorted() && leans[2] > cos + 0.05, "cosine {cos}: {leans:?}");
        }
    }

    #[test]
    fn the_mean_of_a_lobe_is_that_by_even_directions() {
        // Of the reflectance by its formula, on a grid of the hemisphere.
        use crate::reflection::brdf::{Brdf as _, Ggx};
        let grid = 400;
        for (cos, roughness) in [(0.25_f64, 0.75_f64), (0.5625, 1.0), (0.25, 0.5)] {
            let view = Dir::new([-(1.0 - cos * cos).sqrt(), 0.0, cos]).unwrap();
            let ggx = Ggx { alpha: roughness * roughness, f0: 1.0 };
            let mut sum = [0.0; 2];
            for k in 0..grid * grid {
                let at = |k: usize| (k as f64 + 0.5) / grid as f64;
                let (z, phi) = (at(k % grid), std::f64::consts::TAU * at(k / grid));
                let light = Dir::from_angles(z.acos(), phi);
                let weight = ggx.eval(view, light) * z;
                sum = [sum[0] + weight * light.x(), sum[1] + weight * z];
            }
            let expected = sum[0] / (sum[0].hypot(sum[1]) * (1.0 - cos * cos).sqrt());
            let found = LobeTable::correlated().lookup(cos, roughness).lean;
            assert!((found - expected).abs() < 2e-3, "cosine {cos}, roughness {roughness}: {found}, not {expected}");
        }
    }

    #[test]
    fn the_table_interpolates_within_its_stated_error() {
        type Integral = fn(f64, f64) -> Dfg;
        let of = [
            ("correlated", LobeTable::correlated(), dfg as Integral),
            ("separable", LobeTable::separable(), dfg_separable as Integral),
        ];
        for (what, table, integral) in of {
            // The middles of a third of the cells, where interpolation is farthest off, from steep to grazing.
            let mut worst = [0.0_f64; 3];
            let cells = NODES - 1;
            for (x, y) in (0..cells * cells).map(|k| (k % cells, k / cells)).filter(|(x, y)| x % 3 == y % 3) {
                let middle = |k: usize| (k as f64 + 0.5) / cells as f64;
                let (cos, roughness) = (middle(x).powi(2), middle(y));
                let (found, exact) = (table.dfg(cos, roughness), integral(cos, roughness * roughness));
                let error = (found.scale - exact.scale).abs().max((found.bias - exact.bias).abs());
                let part = &mut worst[usize::from(cos < 0.1) + usize::from(cos < 0.01)];
                *part = part.max(error);
            }
            println!("{what}: {worst:?}");
            let stated = [2.5e-3, 2e-2, 9e-2];
            assert!((0..3).all(|k| worst[k] < stated[k]), "{what}: {worst:?}, stated {stated:?}");
            for (cos, roughness) in [(1.0, 0.0), (1.0, 1.0), (0.25, 0.5_f64)] {
                let (found, exact) = (table.dfg(cos, roughness), integral(cos, roughness.powi(2)));
                assert_eq!(found, exact, "{what}: at the node of {cos} and {roughness}");
            }
        }
    }
}
