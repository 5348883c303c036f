//! Reflectance models (BRDFs) and their directional albedo.

use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::OnceLock;

use lobe_sh::Dir;
use lobe_sh::sphere::gauss_legendre;

use crate::reflection::dfg::{dfg, towards_both_ends};

/// Nodes for the one integral of [`Phong::directional_albedo`] on each piece: test
/// `phong_reflects_what_brute_force_says`.
const PHONG_NODES: usize = 48;

/// An isotropic reflectance function `f(v, l)` in sr⁻¹ over a surface that faces +z.
///
/// The **ambient reflectance** `R_A(v)` of a surface, its reflected radiance towards `v` in uniform light, is its
/// directional albedo:
///
/// ```text
///   B(v) = ∫ L f(v, l) l_z dl = L R_A(v)        R_A(v) = ∫_{l_z > 0} f(v, l) l_z dl
/// ```
///
/// In a constant environment of radiance `L`, whose irradiance is `E = πL`, nothing else of the reflectance function is
/// visible; in the white furnace, `L = 1`, a surface without absorption is invisible: `R_A = 1`.
pub trait Brdf {
    /// `f(v, l)`; zero if either direction is below the surface.
    fn eval(&self, v: Dir, l: Dir) -> f64;

    /// `R_A` towards a direction at the angle of this cosine from the normal, which is clamped to `[0, 1]`.
    fn directional_albedo(&self, cos_v: f64) -> f64;
}

/// A Lambertian surface: `f = ρ/π`, `R_A = ρ`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lambert {
    /// The albedo ρ in `[0, 1]`.
    pub albedo: f64,
}

impl Brdf for Lambert {
    fn eval(&self, v: Dir, l: Dir) -> f64 {
        if v.z() > 0.0 && l.z() > 0.0 { self.albedo / PI } else { 0.0 }
    }

    fn directional_albedo(&self, _cos_v: f64) -> f64 {
        self.albedo
    }
}

/// The Phong lobe about the reflected view `r`, normalized to reflect all light for a view along the normal.
///
/// ```text
///   f = (s+2)/(2π) max(r·l, 0)^s                                        (Lafortune and Willems 1994)
///   R_A = (s+2)/(2π) ∫_0^{π/2} cos^s α sin α 2 (φ₀ cos α cos θ + sin φ₀ sin α sin θ) dα
///   cos φ₀ = max(-1, -cot α cot θ);  max(.., 0)^s is 0 for r·l <= 0, for s = 0 too
/// ```
///
/// The bracket is the ring at angle `α` from `r`, weighted with the cosine to the normal; `θ` is the angle of `v` and
/// `r`, `φ₀` half the part of the ring above the surface. Seen along the normal `R_A = 1`; towards grazing
/// angles the lobe dips below the surface and `R_A` falls. For `s = 0` the lobe is the hemisphere about `r`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phong {
    /// The exponent `s >= 0`.
    pub exponent: f64,
}

impl Brdf for Phong {
    fn eval(&self, v: Dir, l: Dir) -> f64 {
        if v.z() <= 0.0 || l.z() <= 0.0 {
            return 0.0;
        }
        let cos_alpha = v.z() * l.z() - v.x() * l.x() - v.y() * l.y();
        if cos_alpha <= 0.0 {
            return 0.0;
        }
        (self.exponent + 2.0) / (2.0 * PI) * cos_alpha.powf(self.exponent)
    }

    fn directional_albedo(&self, cos_v: f64) -> f64 {
        static RULE: OnceLock<Vec<(f64, f64)>> = OnceLock::new();
        let rule = RULE.get_or_init(|| gauss_legendre(PHONG_NODES));
        let s = self.exponent;
        let cos_v = cos_v.clamp(0.0, 1.0);
        let sin_v = ((1.0 - cos_v) * (1.0 + cos_v)).sqrt();
        let ring = |cos: f64, sin: f64| {
            let (up, aside) = (cos * cos_v, sin * sin_v);
            let phi = if up >= aside { PI } else { (-up / aside).clamp(-1.0, 1.0).acos() };
            2.0 * (phi * up + phi.sin() * aside)
        };
        // The lobe is about 1/√(s+1) wide; at 90° - θ the ring begins to dip below the surface.
        let width = (s + 1.0).sqrt().recip();
        let mut ends =
            [0.0, 3.0 * width, 8.0 * width, FRAC_PI_2 - cos_v.acos(), FRAC_PI_2].map(|e| f64::min(e, FRAC_PI_2));
        ends.sort_by(f64::total_cmp);
        let mut sum = 0.0;
        for panel in ends.windows(2).filter(|panel| panel[1] > panel[0]) {
            for &(x, weight) in rule {
                let (alpha, weight) = towards_both_ends(panel[0], panel[1], x, weight);
                let (sin, cos) = alpha.sin_cos();
                sum += weight * cos.max(0.0).powf(s) * sin * ring(cos, sin);
            }
        }
        (s + 2.0) / (2.0 * PI) * sum
    }
}

/// Rough specular reflection: GGX microfacets, Smith's height-correlated masking, Schlick's Fresnel factor.
///
/// ```text
///   f = D(h) F(v·h) / (2 (l_z √(α² + (1-α²) v_z²) + v_z √(α² + (1-α²) l_z²)))        h = (v + l)/|v + l|
///   D(h) = α² / (π ((α² - 1) h_z² + 1)²)        F(c) = F₀ + (1 - F₀)(1 - c)⁵
///   R_A = F₀ A + B                              of `dfg`
/// ```
///
/// `D` is [Walter et al. 2007] eq. 33, the masking [Heitz 2014] eq. 99. Single scattering: light that bounces between
/// the facets is lost, 69 % for `α = 1` seen along the normal; [`Dfg::energy_compensation`] restores it.
///
/// [Walter et al. 2007]: https://www.cs.cornell.edu/~srm/publications/EGSR07-btdf.pdf
/// [Heitz 2014]: https://jcgt.org/published/0003/02/03/
/// [`Dfg::energy_compensation`]: crate::Dfg::energy_compensation
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ggx {
    /// The GGX width α in `(0, 1]`: the square of the perceptual roughness.
    pub alpha: f64,
    /// The reflectance `F₀` along the normal in `[0, 1]`.
    pub f0: f64,
}

impl Brdf for Ggx {
    fn eval(&self, v: Dir, l: Dir) -> f64 {
        let (cos_v, cos_l) = (v.z(), l.z());
        if cos_v <= 0.0 || cos_l <= 0.0 {
            return 0.0;
        }
        let sum: [f64; 3] = std::array::from_fn(|k| v.to_array()[k] + l.to_array()[k]);
        let Some(h) = Dir::new(sum) else { return 0.0 };
        let width = self.alpha * self.alpha;
        let root = |cos: f64| (width + (1.0 - width) * cos * cos).sqrt();
        let fresnel = self.f0 + (1.0 - self.f0) * (1.0 - v.dot(h)).max(0.0).powi(5);
        ggx_distribution(width, h) * fresnel / (2.0 * (cos_l * root(cos_v) + cos_v * root(cos_l)))
    }

    fn directional_albedo(&self, cos_v: f64) -> f64 {
        let table = dfg(cos_v, self.alpha);
        self.f0 * table.scale + table.bias
    }
}

/// `D(h)` for `α² = width`; `h_x² + h_y² + h_z²/width` keeps the digits that `1 - h_z²` loses.
fn ggx_distribution(width: f64, h: Dir) -> f64 {
    let aside = h.x() * h.x() + h.y() * h.y();
    let denominator = aside + width * h.z() * h.z();
    width / (PI * denominator * denominator)
}

#[cfg(test)]
mod tests {
    use lobe_testkit::Random;

    use super::*;

    /// `∫ f(v, l) l_z dl` over the hemisphere, in coordinates about the reflected view.
    fn by_brute_force(brdf: &impl Brdf, cos_v: f64, nodes: usize) -> f64 {
        let v = Dir::from_angles(cos_v.acos(), 0.0);
        let r = Dir::from_angles(cos_v.acos(), PI);
        let [u, w] = lobe_sh::sphere::vector::tangents_along_axis(r.to_array());
        let rule = gauss_legendre(nodes);
        let mut sum = 0.0;
        for &(x, weight_x) in &rule {
            let alpha = 0.5 * PI * (1.0 + x);
            for k in 0..2 * nodes {
                let (sin, cos) = (PI * (k as f64 + 0.5) / nodes as f64).sin_cos();
                let l: [f64; 3] =
                    std::array::from_fn(|i| alpha.cos() * r.to_array()[i] + alpha.sin() * (cos * u[i] + sin * w[i]));
                let weight = 0.5 * PI * weight_x * alpha.sin() * PI / nodes as f64;
                sum += weight * l[2].max(0.0) * brdf.eval(v, Dir::from_unit(l));
            }
        }
        sum
    }

    #[test]
    fn lambert_reflects_its_albedo() {
        let found = by_brute_force(&Lambert { albedo: 0.6 }, 0.5, 400);
        assert!((found - 0.6).abs() < 1e-5, "{found}");
    }

    #[test]
    fn phong_reflects_what_brute_force_says() {
        for s in [0.0, 1.0, 3.5, 20.0, 200.0] {
            for cos_v in [1.0, 0.9, 0.5, 0.1, 0.0] {
                let brdf = Phong { exponent: s };
                // The direction at the horizon itself is not above the surface.
                let expected = by_brute_force(&brdf, f64::max(cos_v, 1e-9), 600);
                let found = brdf.directional_albedo(cos_v);
                assert!((found - expected).abs() < 2e-5 * (1.0 + s.sqrt()), "s {s}, cos {cos_v}: {found}, {expected}");
            }
        }
    }

    #[test]
    fn phong_reflects_everything_seen_along_the_normal_and_less_elsewhere() {
        for s in [0.0, 1.0, 7.0, 100.0, 1e4] {
            let albedo = |cos_v| Phong { exponent: s }.directional_albedo(cos_v);
            assert!((albedo(1.0) - 1.0).abs() < 1e-12, "s = {s}: {}", albedo(1.0));
            let mut before = 1.0 + 1e-12;
            for k in (0..=20).rev() {
                let found = albedo(0.05 * f64::from(k));
                assert!(found <= before + 1e-12 && found >= 0.0, "s = {s}, cos {}: {found}", 0.05 * f64::from(k));
                before = found;
            }
        }
    }

    #[test]
    fn ggx_reflects_what_brute_force_says() {
        for alpha in [0.25, 0.5, 1.0] {
            for cos_v in [1.0, 0.7, 0.3, 0.1] {
                for f0 in [0.04, 1.0] {
                    let brdf = Ggx { alpha, f0 };
                    let (found, expected) = (brdf.directional_albedo(cos_v), by_brute_force(&brdf, cos_v, 600));
                    assert!((found - expected).abs() < 1e-5, "α {alpha}, cos {cos_v}, F₀ {f0}: {found}, {expected}");
                }
            }
        }
    }

    #[test]
    fn reflection_is_reciprocal_and_never_negative() {
        let mut random = Random::new(3);
        for _ in 0..500 {
            let mut upper = || Dir::new(random.direction()).unwrap();
            let (v, l) = (upper(), upper());
            let check = |name: &str, brdf: &dyn Brdf| {
                let (there, back) = (brdf.eval(v, l), brdf.eval(l, v));
                assert!((there - back).abs() <= 1e-13 * there.abs(), "{name}: {there} and {back}");
                let lit = v.z() > 0.0 && l.z() > 0.0;
                assert!(there >= 0.0 && (lit || there == 0.0), "{name} from {v:?} to {l:?}: {there}");
            };
            check("Lambert", &Lambert { albedo: 0.5 });
            check("Phong", &Phong { exponent: 12.0 });
            check("GGX", &Ggx { alpha: 0.3, f0: 0.04 });
        }
    }

    #[test]
    fn the_facets_of_ggx_project_onto_the_surface_once() {
        // ∫ D(h) h_z dh = 1: in the tangent of the angle the integrand is 2 α² t/(α² + t²)².
        for alpha in [0.01, 0.2, 1.0] {
            let mut sum = 0.0;
            for (x, weight) in gauss_legendre(200) {
                let t = alpha * (0.25 * PI * (1.0 + x)).tan();
                let h = Dir::new([t, 0.0, 1.0]).unwrap();
                let dt = alpha * (1.0 + (t / alpha).powi(2)) * 0.25 * PI * weight;
                // dh = sin θ dθ 2π = 2π t (1 + t²)^{-3/2} dt
                sum += ggx_distribution(alpha * alpha, h) * h.z() * 2.0 * PI * t * (1.0 + t * t).powf(-1.5) * dt;
            }
            assert!((sum - 1.0).abs() < 1e-12, "α = {alpha}: {sum}");
        }
    }
}
