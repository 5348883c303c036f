//! A table of reflectance in even light, with nodes at the mirror, at roughness 1 and at grazing.

use lobe_env::{Dfg, dfg, dfg_separable};
use lobe_io::parallel;

use crate::path_tracer::surfaces::Surfaces;

/// Nodes along a side.
const NODES: usize = 33;

/// [`dfg()`], or [`dfg_separable`], between nodes at `√cos` and roughness `k/32`, bilinear.
///
/// A [`DfgTable`](lobe_env::DfgTable), as shaders have it, ends half a texel before roughness 1, which most materials have, and
/// white metals of it are 2.6 % too bright by 64 texels. This one is exact there and for mirrors along its nodes. Within 0.0025 where
/// the cosine is at least 0.1, within 0.02 where it is at least 0.01, and within 0.09 below, where the reflectance of smooth surfaces
/// rises (test `the_table_interpolates_within_its_stated_error`).
#[derive(Clone, Debug)]
pub(crate) struct ReflectanceTable {
    /// Row after row of rising roughness.
    nodes: Vec<Dfg>,
}

impl ReflectanceTable {
    /// Computes the table, in parallel.
    pub(crate) fn new(surfaces: Surfaces) -> Self {
        let integral: fn(f64, f64) -> Dfg = match surfaces {
            Surfaces::MetallicRoughnessSeparable => dfg_separable,
            _ => dfg,
        };
        let at = |k: usize| k as f64 / (NODES - 1) as f64;
        let node = |k: usize| integral(at(k % NODES).powi(2), at(k / NODES).powi(2));
        Self { nodes: parallel::map(NODES * NODES, &node) }
    }

    /// The reflectance of a surface of this roughness in `[0, 1]`, seen at the angle of this cosine in `[0, 1]`.
    pub(crate) fn lookup(&self, cos_view: f64, roughness: f64) -> Dfg {
        let split = |t: f64| {
            let place = t.clamp(0.0, 1.0) * (NODES - 1) as f64;
            let low = (place as usize).min(NODES - 2);
            (low, place - low as f64)
        };
        let ((x, tx), (y, ty)) = (split(cos_view.max(0.0).sqrt()), split(roughness));
        let row = |y: usize| mix(self.nodes[y * NODES + x], self.nodes[y * NODES + x + 1], tx);
        mix(row(y), row(y + 1), ty)
    }
}

fn mix(a: Dfg, b: Dfg, t: f64) -> Dfg {
    let between = |a: f64, b: f64| (1.0 - t) * a + t * b;
    Dfg { scale: between(a.scale, b.scale), bias: between(a.bias, b.bias) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_interpolates_within_its_stated_error() {
        for surfaces in [Surfaces::MetallicRoughness, Surfaces::MetallicRoughnessSeparable] {
            let integral = if surfaces == Surfaces::MetallicRoughness { dfg } else { dfg_separable };
            let table = ReflectanceTable::new(surfaces);
            // The middles of a third of the cells, where interpolation is farthest off, from steep to grazing.
            let mut worst = [0.0_f64; 3];
            let cells = NODES - 1;
            for (x, y) in (0..cells * cells).map(|k| (k % cells, k / cells)).filter(|(x, y)| x % 3 == y % 3) {
                let middle = |k: usize| (k as f64 + 0.5) / cells as f64;
                let (cos, roughness) = (middle(x).powi(2), middle(y));
                let (found, exact) = (table.lookup(cos, roughness), integral(cos, roughness * roughness));
                let error = (found.scale - exact.scale).abs().max((found.bias - exact.bias).abs());
                let part = &mut worst[usize::from(cos < 0.1) + usize::from(cos < 0.01)];
                *part = part.max(error);
            }
            println!("{surfaces:?}: {worst:?}");
            let stated = [2.5e-3, 2e-2, 9e-2];
            assert!((0..3).all(|k| worst[k] < stated[k]), "{surfaces:?}: {worst:?}, stated {stated:?}");
            for (cos, roughness) in [(1.0, 0.0), (1.0, 1.0), (0.25, 0.5_f64)] {
                let (found, exact) = (table.lookup(cos, roughness), integral(cos, roughness.powi(2)));
                assert_eq!(found, exact, "{surfaces:?}: at the node of {cos} and {roughness}");
            }
        }
    }
}
