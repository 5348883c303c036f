//! Lobes of microfacets: where they point, by the angle of view.

use lobe_io::parallel;
use lobe_sh::Dir;
use lobe_sh::sphere::vector::dot;

use crate::path_tracer::ggx::Facets;
use crate::path_tracer::surfaces::Surfaces;

/// Nodes along a side.
const NODES: usize = 33;

/// Directions along each of two axes that find the mean of a lobe.
const GRID: usize = 48;

/// The sine of the angle of view in place of zero, at which a lobe has no side to lean to.
const LEAST_SINE: f64 = 1e-3;

/// The mean directions of the lobes of GGX, between nodes at `√cos` of the angle of view and roughness `k/32`.
///
/// ```text
///   m(v, α) = ∫ f(v, l) (n·l) l dl / ∫ f(v, l) (n·l) dl          f = D V, white and without Fresnel's factor
/// ```
///
/// A prefiltered map holds, for each roughness, the lobe of a view along the normal. A lobe that is seen at a slant
/// leans from the mirrored direction to the normal: looked up about `m/|m|` it agrees better than about that direction
/// (test `a_ball_is_as_the_truth_but_for_the_split_sum`).
#[derive(Clone, Debug)]
pub(crate) struct LobeTable {
    /// The sine of the angle between the mean and the normal, as a part of that of the mirrored direction; row after row
    /// of rising roughness.
    leans: Vec<f64>,
}

impl LobeTable {
    /// Computes the table, in parallel.
    pub(crate) fn new(surfaces: Surfaces) -> Self {
        let is_separable = surfaces == Surfaces::MetallicRoughnessSeparable;
        let at = |k: usize| k as f64 / (NODES - 1) as f64;
        let lean = |k: usize| {
            let cos = at(k % NODES).powi(2).clamp(LEAST_SINE, (1.0 - LEAST_SINE * LEAST_SINE).sqrt());
            let [across, up] = mean(cos, Facets::of_roughness(at(k / NODES), is_separable));
            across / (across.hypot(up) * (1.0 - cos * cos).sqrt())
        };
        Self { leans: parallel::map(NODES * NODES, &lean) }
    }

    /// The mean direction of the lobe of a surface of this roughness in `[0, 1]`, whose mirrored direction is above it.
    pub(crate) fn axis(&self, mirrored: Dir, normal: Dir, roughness: f64) -> Dir {
        let (r, n, cos) = (mirrored.to_array(), normal.to_array(), normal.dot(mirrored));
        let lean = self.lean(cos, roughness);
        let along = [0, 1, 2].map(|k| lean * (r[k] - cos * n[k]));
        let up = (1.0 - dot(along, along)).max(0.0).sqrt();
        Dir::new([0, 1, 2].map(|k| along[k] + up * n[k])).unwrap_or(mirrored)
    }

    fn lean(&self, cos_view: f64, roughness: f64) -> f64 {
        let split = |t: f64| {
            let place = t.clamp(0.0, 1.0) * (NODES - 1) as f64;
            let low = (place as usize).min(NODES - 2);
            (low, place - low as f64)
        };
        let ((x, tx), (y, ty)) = (split(cos_view.max(0.0).sqrt()), split(roughness));
        let mix = |a: f64, b: f64, t: f64| (1.0 - t) * a + t * b;
        let row = |y: usize| mix(self.leans[y * NODES + x], self.leans[y * NODES + x + 1], tx);
        mix(row(y), row(y + 1), ty)
    }
}

/// The mean of a lobe that is seen at the angle of this cosine: across the surface, away from the eye, and up.
fn mean(cos_view: f64, facets: Facets) -> [f64; 2] {
    let v = [-(1.0 - cos_view * cos_view).sqrt(), 0.0, cos_view];
    let (mut across, mut up, mut all) = (0.0, 0.0, 0.0);
    for k in 0..GRID * GRID {
        let number = |k: usize| (k as f64 + 0.5) / GRID as f64;
        let l = facets.sample(v, [number(k % GRID), number(k / GRID)]);
        let density = facets.density(v, l);
        if l[2] > 0.0 && density > 0.0 {
            let weight = facets.reflectance(v, l) * l[2] / density;
            across += weight * l[0];
            up += weight * l[2];
            all += weight;
        }
    }
    [across / all, up / all]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mirror_points_where_it_mirrors_and_a_rough_surface_leans_to_its_normal() {
        let table = LobeTable::new(Surfaces::MetallicRoughness);
        let normal = Dir::Z;
        for cos in [0.15, 0.5, 0.9_f64] {
            let mirrored = Dir::new([(1.0 - cos * cos).sqrt(), 0.0, cos]).unwrap();
            let axis = |roughness: f64| table.axis(mirrored, normal, roughness);
            assert!(axis(0.0).dot(mirrored) > 1.0 - 1e-4, "cosine {cos}: {:?}", axis(0.0));
            let leans: Vec<f64> = [0.2, 0.5, 1.0].map(|roughness| axis(roughness).dot(normal)).to_vec();
            assert!(leans.is_sorted() && leans[2] > cos + 0.05, "cosine {cos}: {leans:?}");
        }
    }
}
