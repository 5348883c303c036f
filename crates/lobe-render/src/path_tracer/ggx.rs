//! GGX microfacets: their reflectance, and sampling by visible normals.

use std::f64::consts::PI;

use lobe_sh::sphere::vector::{Vec3, add, dot, normalized};

/// A surface of microfacets that faces +z, `α` the width of its slopes.
///
/// ```text
///   D(h) = α² / (π (h_x² + h_y² + α² h_z²)²)        r(c) = √(α² + (1-α²) c²)
///   V(v, l) = G₂ / (4 v_z l_z) = 1 / (2 (l_z r(v_z) + v_z r(l_z)))            height-correlated
///                                1 / ((v_z + r(v_z)) (l_z + r(l_z)))          separable
/// ```
///
/// `D` is [Walter et al. 2007] eq. 33; the masking [Heitz 2014] eq. 99, or eq. 98, in which being seen and being lit are
/// independent. The separable one is never larger: the difference of the denominators is `(v_z - r(v_z)) (l_z - r(l_z))`,
/// and `r(c) ≥ c`.
///
/// [Walter et al. 2007]: https://www.cs.cornell.edu/~srm/publications/EGSR07-btdf.pdf
/// [Heitz 2014]: https://jcgt.org/published/0003/02/03/
#[derive(Clone, Copy, Debug)]
pub(crate) struct Facets {
    pub(crate) alpha: f64,
    /// Whether masking and shadowing are taken for independent.
    pub(crate) is_separable: bool,
}

/// The least α: densities stay far from infinity, and the lobe is a tenth of a degree wide.
const SHARPEST: f64 = 1e-3;

impl Facets {
    /// Those of a surface of this perceptual roughness: `α = roughness²`.
    pub(crate) fn of_roughness(roughness: f64, is_separable: bool) -> Self {
        Self { alpha: (roughness * roughness).max(SHARPEST), is_separable }
    }

    /// `D(h) V(v, l)`, zero if either direction is below the surface: times Fresnel's factor it is the reflectance.
    pub(crate) fn reflectance(self, v: Vec3, l: Vec3) -> f64 {
        if v[2] <= 0.0 || l[2] <= 0.0 {
            return 0.0;
        }
        let h = normalized(add(v, l));
        let width = self.alpha * self.alpha;
        let root = |cos: f64| (width + (1.0 - width) * cos * cos).sqrt();
        self.distribution(h)
            / match self.is_separable {
                false => 2.0 * (l[2] * root(v[2]) + v[2] * root(l[2])),
                true => (v[2] + root(v[2])) * (l[2] + root(l[2])),
            }
    }

    /// The direction mirrored by a microfacet that is drawn by its visible area, seen from `v` above the surface.
    ///
    /// In the space where the facets form a hemisphere, `l` is drawn uniformly on the cap `l_z > -v_z` of the sphere:
    /// the half vector `h = l + v` then has the density of visible normals ([Dupuy and Benyoub 2023], section 3).
    ///
    /// [Dupuy and Benyoub 2023]: https://arxiv.org/abs/2306.05044
    pub(crate) fn sample(self, v: Vec3, [u0, u1]: [f64; 2]) -> Vec3 {
        let stretched = normalized([v[0] * self.alpha, v[1] * self.alpha, v[2]]);
        let z = (1.0 - u1) * (1.0 + stretched[2]) - stretched[2];
        let sin = ((1.0 - z) * (1.0 + z)).max(0.0).sqrt();
        let (sin_phi, cos_phi) = (2.0 * PI * u0).sin_cos();
        let h = add([sin * cos_phi, sin * sin_phi, z], stretched);
        let h = normalized([h[0] * self.alpha, h[1] * self.alpha, h[2].max(0.0)]);
        let twice = 2.0 * dot(v, h);
        std::array::from_fn(|k| twice * h[k] - v[k])
    }

    /// The density in sr⁻¹ with which [`Facets::sample`] draws `l`: `G₁(v) D(h) / (4 v_z)`.
    pub(crate) fn density(self, v: Vec3, l: Vec3) -> f64 {
        // Facets face upwards.
        if v[2] <= 0.0 || v[2] + l[2] <= 0.0 {
            return 0.0;
        }
        let width = self.alpha * self.alpha;
        // G₁ = 2 v_z / (v_z + √(α² + (1-α²) v_z²))
        let root = (width + (1.0 - width) * v[2] * v[2]).sqrt();
        self.distribution(normalized(add(v, l))) / (2.0 * (v[2] + root))
    }

    fn distribution(self, h: Vec3) -> f64 {
        let width = self.alpha * self.alpha;
        let denominator = h[0] * h[0] + h[1] * h[1] + width * h[2] * h[2];
        width / (PI * denominator * denominator)
    }
}

#[cfg(test)]
mod tests {
    use lobe_env::{Brdf as _, Ggx};
    use lobe_sh::Dir;
    use lobe_testkit::{ChiSquare, Random};

    use super::*;

    /// Chance passes it once in three million.
    const LARGEST_Z: f64 = 5.0;

    #[test]
    fn the_reflectance_is_that_of_the_environment_crate() {
        let mut random = Random::new(3);
        for alpha in [0.05, 0.3, 1.0] {
            for _ in 0..200 {
                let [v, l] = [random.direction(), random.direction()];
                let expected = Ggx { alpha, f0: 1.0 }.eval(Dir::from_unit(v), Dir::from_unit(l));
                let found = Facets { alpha, is_separable: false }.reflectance(v, l);
                assert!((found - expected).abs() <= 1e-9 * expected, "{found} against {expected} for {alpha}");
            }
        }
    }

    #[test]
    fn separable_masking_is_the_product_of_two_and_loses_more() {
        let mut random = Random::new(4);
        for alpha in [0.05, 0.3, 1.0] {
            for _ in 0..200 {
                let [v, l] = [random.direction(), random.direction()].map(|[x, y, z]| [x, y, z.abs()]);
                let [correlated, separable] =
                    [false, true].map(|is_separable| Facets { alpha, is_separable }.reflectance(v, l));
                // G₁ is 4 v_z times the density of visible normals over D.
                let facets = Facets { alpha, is_separable: true };
                let g1 = |v: Vec3| 4.0 * v[2] * facets.density(v, l) / facets.distribution(normalized(add(v, l)));
                let g1_of_l = 4.0 * l[2] * facets.density(l, v) / facets.distribution(normalized(add(v, l)));
                let expected = facets.distribution(normalized(add(v, l))) * g1(v) * g1_of_l / (4.0 * v[2] * l[2]);
                assert!((separable / expected - 1.0).abs() < 1e-9, "{separable} against {expected} for {alpha}");
                assert!(separable <= correlated * (1.0 + 1e-12), "{separable} above {correlated} for {alpha}");
            }
        }
    }

    #[test]
    fn directions_are_drawn_with_the_density_stated() {
        let mut random = Random::new(9);
        for (alpha, cos_v) in [(0.2_f64, 0.9_f64), (0.3, 0.1), (0.6, 0.3), (1.0, 0.7), (1.0, 1.0)] {
            let v = [(1.0 - cos_v * cos_v).sqrt(), 0.0, cos_v];
            let facets = Facets { alpha, is_separable: false };
            let draw = || Some(facets.sample(v, [random.unit(), random.unit()]));
            let test = ChiSquare::new(200_000, draw, |l| facets.density(v, l));
            assert!(test.missing.abs() < 2e-3, "alpha {alpha}, cos {cos_v}: {test:?}");
            assert!(test.z() < LARGEST_Z, "alpha {alpha}, cos {cos_v}: z = {}, {test:?}", test.z());
        }
    }
}
