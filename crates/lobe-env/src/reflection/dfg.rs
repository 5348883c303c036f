//! DFG table: scale and bias of the split-sum approximation (the "BRDF lookup table").

use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::OnceLock;

use lobe_io::parallel;
use lobe_sh::sphere::gauss_legendre;
use lobe_sh::{Coefficient, Rgb};

/// Nodes of each of the two integrals: three times as many change less than 2e-6 anywhere, 6e-7 for `α >= 0.01`, and
/// 1e-12 for `α >= 0.3`, `cos_v >= 0.02` (test `the_integrals_have_converged`).
const NODES: usize = 48;

/// The least cosine of the view. At 0 the surface is seen edge-on and the masking has no limit that is reached.
const LEAST_COSINE: f64 = 1e-6;

/// Below this width the lobe is treated as a perfect mirror: the integrals would lose their digits.
const LEAST_ALPHA: f64 = 1e-4;

/// The reflectance of rough GGX specular reflection in uniform light, split by `F₀`.
///
/// ```text
///   R_A = F₀ scale + bias        scale = ∫ f₁ (1 - (1 - v·h)⁵) l_z dl        bias = ∫ f₁ (1 - v·h)⁵ l_z dl
/// ```
///
/// `f₁` is [`Ggx`](crate::Ggx) with `F = 1`. In the split-sum approximation ([Karis 2013]) the reflected light is the
/// prefiltered environment times `F₀ scale + bias`.
///
/// [Karis 2013]: https://blog.selfshadow.com/publications/s2013-shading-course/karis/s2013_pbs_epic_notes_v2.pdf
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Dfg {
    /// The factor of `F₀`, A in Karis' notes.
    pub scale: f64,
    /// The summand, B in Karis' notes.
    pub bias: f64,
}

impl Dfg {
    /// The ambient reflectance of a surface of color `f0`.
    #[must_use]
    pub fn reflectance(&self, f0: Rgb<f64>) -> Rgb<f64> {
        f0.scale(self.scale) + Rgb::splat(self.bias)
    }

    /// The factor that compensates the energy lost to single scattering.
    ///
    /// ```text
    ///   1 + F₀ (1/(scale + bias) - 1)
    /// ```
    ///
    /// With `F₀ = 1` the reflectance becomes 1: a white metal vanishes in the white furnace. (The form of Filament's
    /// documentation, section 4.7.2.)
    #[must_use]
    pub fn energy_compensation(&self, f0: Rgb<f64>) -> Rgb<f64> {
        Rgb::splat(1.0) + f0.scale((self.scale + self.bias).recip() - 1.0)
    }
}

// With v = (S, 0, C) and the normals that v sees distributed as Heitz 2018 shows,
//
//     ∫ f₁ g(h) l_z dl = ∫ D_v(h) G₂/G₁ g(h) dh        G₂/G₁ = (1 + Λ_v)/(1 + Λ_v + Λ_l)
//     Λ(s) = ½ (√(1 + α² tan²θ_s) - 1)
//
// (separable masking has G₂/G₁ = 1/(1 + Λ_l) in its place),
//
// where stretching by α turns D_v into the cosine about (sin η, 0, cos η), tan η = α tan θ_v, over that half of the
// sphere it sees and that faces up. With N = (cos ψ sin ζ, sin ψ, cos ψ cos ζ), h ∝ m = (α N_x, α N_y, N_z):
//
//     = 2/(π (1 + cos η)) ∫∫ cos²ψ cos(ζ - η) G₂/G₁ g dζ dψ
//
// The light l = 2 (v·h) h - v is above the surface where 2 (v·m) m_z > C |m|². With x = α tan ζ and T = tan²ψ that is
//
//     C (1 + T) x² - 2 S x - C (1 - α² T) < 0
//
// an interval between two roots, inside the range of visible normals (at its end x = -C/S the left side is positive).
// The roots meet where S² + C² (1 + T)(1 - α² T) = 0, which ends the range of ψ. So both integrals run to where the
// integrand vanishes and are smooth inside: Gauss-Legendre nodes clustered towards the ends converge fast.

/// Scale and bias for a view at the angle of cosine `cos_v` from the normal and the GGX width `alpha`.
///
/// `cos_v` is clamped to `[1e-6, 1]`, `alpha` to at most 1; below `α = 1e-4` it is the perfect mirror,
/// `bias = (1 - cos_v)⁵`, `scale = 1 - bias`. Deterministic quadrature, accurate to 2e-6, from `α = 0.01` on to 6e-7, and
/// to 1e-12 away from smooth and from grazing (test `the_integrals_have_converged`); the derivation is above the code.
///
/// ```
/// use lobe_env::dfg;
///
/// // A white metal of roughness 1 seen along its normal reflects 1 - ln 2 of even light; the rest stays between its
/// // facets.
/// let rough = dfg(1.0, 1.0);
/// assert!((rough.scale + rough.bias - (1.0 - 2.0_f64.ln())).abs() < 1e-14);
/// ```
#[must_use]
pub fn dfg(cos_v: f64, alpha: f64) -> Dfg {
    integrate(cos_v, alpha, Masking::Correlated, NODES)
}

/// [`dfg()`] with separable masking, `G₂ = G₁(v) G₁(l)`, in which being seen and being lit are independent: rough surfaces
/// are darker.
///
/// The arguments and the error are those of [`dfg()`] (test `the_integrals_have_converged`).
///
/// ```
/// use lobe_env::dfg_separable;
///
/// // A white metal of roughness 1 seen along its normal has the closed form of the other masking, too, but not in between.
/// let rough = dfg_separable(1.0, 1.0);
/// assert!((rough.scale + rough.bias - (1.0 - 2.0_f64.ln())).abs() < 1e-12);
/// ```
#[must_use]
pub fn dfg_separable(cos_v: f64, alpha: f64) -> Dfg {
    integrate(cos_v, alpha, Masking::Separable, NODES)
}

/// How the masking of the view and that of the light go together.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Masking {
    /// Facets that lie deep hide from both.
    Correlated,
    /// Each by itself.
    Separable,
}

fn integrate(cos_v: f64, alpha: f64, masking: Masking, nodes: usize) -> Dfg {
    let c = cos_v.clamp(LEAST_COSINE, 1.0);
    if alpha < LEAST_ALPHA {
        let bias = (1.0 - c).powi(5);
        return Dfg { scale: 1.0 - bias, bias };
    }
    let (mut all, mut bias) = (0.0, 0.0);
    View::new(c, alpha.min(1.0), masking).for_each(nodes, |value, v_dot_h, _| {
        all += value;
        bias += value * (1.0 - v_dot_h).max(0.0).powi(5);
    });
    Dfg { scale: all - bias, bias }
}

/// The mean direction of the light that reaches the eye in even light: across the surface, away from the eye, and up;
/// the mirrored one for a mirror. Its length is the reflectance, times how narrow the lobe is. As [`dfg()`], for a
/// cosine in `(0, 1)`.
pub(crate) fn mean_of_lobe(cos_v: f64, alpha: f64, masking: Masking) -> [f64; 2] {
    let mut sum = [0.0; 2];
    let view = View::new(cos_v, alpha.min(1.0), masking);
    if alpha < LEAST_ALPHA {
        return [view.s, view.c];
    }
    view.for_each(NODES, |value, _, [across, up]| {
        sum[0] += value * across;
        sum[1] += value * up;
    });
    sum
}

/// The view and the terms that depend on it alone.
struct View {
    c: f64,
    s: f64,
    alpha: f64,
    eta: f64,
    lambda: f64,
    last_psi: f64,
    norm: f64,
    masking: Masking,
}

impl View {
    fn new(c: f64, alpha: f64, masking: Masking) -> Self {
        let s = ((1.0 - c) * (1.0 + c)).sqrt();
        let eta = (alpha * s).atan2(c);
        // α² T² - (1 - α²) T - 1/C² = 0, from S² + C² (1 + T)(1 - α² T) = 0
        let width = alpha * alpha;
        let half = 0.5 * (1.0 - width);
        let t = (half + (half * half + width / (c * c)).sqrt()) / width;
        // Both halves of ψ, and the density of the visible normals.
        let norm = 4.0 / (PI * (1.0 + eta.cos()));
        Self { c, s, alpha, eta, lambda: lambda(alpha, c), last_psi: t.sqrt().atan(), norm, masking }
    }

    /// Hands out the integrand for `g = 1` at each node with its weight, `v·h`, and the light: away from the eye, and
    /// up.
    fn for_each(&self, nodes: usize, mut add: impl FnMut(f64, f64, [f64; 2])) {
        static RULE: OnceLock<Vec<(f64, f64)>> = OnceLock::new();
        let own;
        let rule = if nodes == NODES {
            RULE.get_or_init(|| gauss_legendre(NODES))
        } else {
            own = gauss_legendre(nodes);
            &own
        };
        for &(x, weight) in rule {
            let (psi, weight) = towards_both_ends(0.0, self.last_psi, x, weight);
            let [start, end] = self.interval(psi);
            for &(x, inner) in rule {
                let (zeta, inner) = towards_both_ends(start, end, x, inner);
                let (value, v_dot_h, light) = self.integrand(psi, zeta);
                add(weight * inner * value, v_dot_h, light);
            }
        }
    }

    /// The range of ζ in which the light is above the surface.
    fn interval(&self, psi: f64) -> [f64; 2] {
        let t = psi.tan().powi(2);
        let (c, s) = (self.c, self.s);
        let product = c * c * (1.0 + t) * (1.0 - self.alpha * self.alpha * t);
        let root = (s * s + product).max(0.0).sqrt();
        let denominator = c * (1.0 + t);
        // S - root without cancellation: the product of both numerators is -product.
        let low = -product / (s + root).max(f64::MIN_POSITIVE);
        [low, s + root].map(|numerator| numerator.atan2(denominator * self.alpha))
    }

    /// The integrand for `g = 1`, `v·h`, and the light.
    fn integrand(&self, psi: f64, zeta: f64) -> (f64, f64, [f64; 2]) {
        let (sin_psi, cos_psi) = psi.sin_cos();
        let (sin_zeta, cos_zeta) = zeta.sin_cos();
        let m = [self.alpha * cos_psi * sin_zeta, self.alpha * sin_psi, cos_psi * cos_zeta];
        let square = m[0] * m[0] + m[1] * m[1] + m[2] * m[2];
        let v_dot_m = self.s * m[0] + self.c * m[2];
        let cos_l = (2.0 * v_dot_m * m[2] / square - self.c).clamp(0.0, 1.0);
        let v_dot_h = v_dot_m / square.sqrt();
        let light = [self.s - 2.0 * v_dot_m * m[0] / square, cos_l];
        if cos_l == 0.0 {
            return (0.0, v_dot_h, light);
        }
        let lambda_l = lambda(self.alpha, cos_l);
        let lit = match self.masking {
            Masking::Correlated => (1.0 + self.lambda) / (1.0 + self.lambda + lambda_l),
            Masking::Separable => (1.0 + lambda_l).recip(),
        };
        (self.norm * cos_psi * cos_psi * (zeta - self.eta).cos() * lit, v_dot_h, light)
    }
}

/// Smith's `Λ` of GGX.
fn lambda(alpha: f64, cos: f64) -> f64 {
    let tan_square = (1.0 - cos) * (1.0 + cos) / (cos * cos);
    let x = alpha * alpha * tan_square;
    // √(1 + x) - 1 without cancellation
    0.5 * x / ((1.0 + x).sqrt() + 1.0)
}

/// [`dfg()`] tabulated over the view's cosine and the roughness `r = √α`.
///
/// Texel `(x, y)` of `size²` holds the values at `cos_v = (x + ½)/size`, `r = (y + ½)/size`; row 0 is the smoothest.
#[derive(Clone, Debug, PartialEq)]
pub struct DfgTable {
    size: usize,
    texels: Vec<Dfg>,
}

impl Default for DfgTable {
    /// The table of 64 × 64 texels, within a hundredth except at grazing angles.
    fn default() -> Self {
        Self::new(64)
    }
}

impl DfgTable {
    /// Computes a table, in parallel; the same bits for any number of threads.
    ///
    /// # Panics
    /// If `size` is 0.
    #[must_use]
    pub fn new(size: usize) -> Self {
        assert!(size > 0, "a table needs texels");
        let at = |i: usize| (i as f64 + 0.5) / size as f64;
        let texels = parallel::map(size * size, &|k| dfg(at(k % size), at(k / size).powi(2)));
        Self { size, texels }
    }

    /// The number of rows, and of columns.
    #[must_use]
    pub fn size(&self) -> usize {
        self.size
    }

    /// All texels, row after row from the smoothest.
    #[must_use]
    pub fn texels(&self) -> &[Dfg] {
        &self.texels
    }

    /// The value between texel centers, bilinear; beyond the outermost centers, theirs.
    ///
    /// `roughness` is `√α`. For the error see test `the_table_interpolates_within_its_stated_error`: 64² texels are
    /// within 0.01 of [`dfg()`] where both coordinates are at least 0.1.
    #[must_use]
    pub fn lookup(&self, cos_v: f64, roughness: f64) -> Dfg {
        let last = self.size - 1;
        let split = |t: f64| {
            let place = (t * self.size as f64 - 0.5).clamp(0.0, last as f64);
            let low = (place as usize).min(last);
            (low, (low + 1).min(last), place - low as f64)
        };
        let ((x0, x1, tx), (y0, y1, ty)) = (split(cos_v), split(roughness));
        let row = |y: usize| {
            let (a, b) = (self.texels[y * self.size + x0], self.texels[y * self.size + x1]);
            mix(a, b, tx)
        };
        mix(row(y0), row(y1), ty)
    }
}

fn mix(a: Dfg, b: Dfg, t: f64) -> Dfg {
    Dfg { scale: a.scale + t * (b.scale - a.scale), bias: a.bias + t * (b.bias - a.bias) }
}

/// Maps the node `x` in `(-1, 1)` and its weight to an interval, clustered towards both ends as a square root needs.
pub(crate) fn towards_both_ends(start: f64, end: f64, x: f64, weight: f64) -> (f64, f64) {
    let (sin, cos) = (FRAC_PI_2 * x).sin_cos();
    let half = 0.5 * (end - start);
    (start + half * (1.0 + sin), weight * half * FRAC_PI_2 * cos)
}

#[cfg(test)]
mod tests {
    use super::*;

    const COSINES: [f64; 8] = [1e-6, 0.001, 0.02, 0.1, 0.3, 0.7, 0.99, 1.0];

    #[test]
    fn the_integrals_have_converged() {
        // The worst for α >= 0.01 is near α = 0.014, cos = 1.5e-4; below, it is the smoothest surface at grazing.
        let cosines = COSINES.into_iter().chain([1e-5, 1.5e-4]);
        for alpha in [LEAST_ALPHA, 1.01e-4, 3e-4, 1e-3, 5e-3, 0.01, 0.014, 0.03, 0.1, 0.3, 0.6, 1.0] {
            for cos_v in cosines.clone() {
                let limit = if alpha < 0.01 {
                    2e-6
                } else if alpha < 0.3 || cos_v < 0.02 {
                    6e-7
                } else {
                    1e-12
                };
                for masking in [Masking::Correlated, Masking::Separable] {
                    let [coarse, fine] = [NODES, 3 * NODES].map(|nodes| integrate(cos_v, alpha, masking, nodes));
                    let error = (coarse.scale - fine.scale).abs().max((coarse.bias - fine.bias).abs());
                    println!(
                        "α {alpha}, cos {cos_v}, {masking:?}: {:.8} {:.8} error {error:.1e}",
                        fine.scale, fine.bias
                    );
                    assert!(error < limit, "α {alpha}, cos {cos_v}, {masking:?}: {error:.1e}");
                }
            }
        }
    }

    #[test]
    fn the_white_furnace_never_gains_and_smooth_mirrors_lose_nothing() {
        for cos_v in COSINES {
            let mut before = 1.0 + 1e-9;
            for alpha in [1e-5, 1e-3, 0.01, 0.1, 0.3, 0.6, 1.0] {
                let found = dfg(cos_v, alpha);
                let all = found.scale + found.bias;
                assert!(found.scale >= 0.0 && found.bias >= 0.0, "α {alpha}, cos {cos_v}: {found:?}");
                assert!(all <= 1.0 + 1e-9, "α {alpha}, cos {cos_v}: {all}");
                if cos_v > 0.25 {
                    assert!(all <= before, "rougher loses more: α {alpha}, cos {cos_v}: {all} after {before}");
                }
                before = all;
            }
            let smooth = dfg(cos_v, 1e-3);
            let bias = (1.0 - cos_v).powi(5);
            if cos_v >= 0.1 {
                assert!((smooth.scale + smooth.bias - 1.0).abs() < 1e-4, "cos {cos_v}: {smooth:?}");
                assert!((smooth.bias - bias).abs() < 1e-3, "cos {cos_v}: {smooth:?} against {bias}");
            }
        }
    }

    #[test]
    fn along_the_normal_the_reflectance_has_its_closed_form() {
        // θ_h = θ_l/2 and everything depends on t = tan²θ_h alone: one integral, by another rule in another variable.
        for alpha in [0.05_f64, 0.3, 1.0] {
            let width = alpha * alpha;
            let mut all = 0.0;
            for (x, weight) in gauss_legendre(400) {
                let cos_l = 0.5 * (1.0 + x);
                let cos_h = (0.5 * (1.0 + cos_l)).sqrt();
                let d = width / (PI * ((width - 1.0) * cos_h * cos_h + 1.0).powi(2));
                let g = 1.0 / (1.0 + lambda(alpha, cos_l));
                all += 0.5 * weight * 2.0 * PI * d * g / 4.0;
            }
            let found = dfg(1.0, alpha);
            assert!((found.scale + found.bias - all).abs() < 1e-8, "α {alpha}: {found:?} against {all}");
        }
    }

    #[test]
    fn separable_masking_loses_more_and_has_its_closed_form() {
        for cos_v in [1.0_f64, 0.7, 0.3, 0.1, 0.02] {
            // For α = 1 the integral is one of a rational function.
            let found = dfg_separable(cos_v, 1.0);
            let expected = 2.0 * (1.0 - 2.0_f64.ln()) / (1.0 + cos_v);
            assert!((found.scale + found.bias - expected).abs() < 1e-12, "cos {cos_v}: {found:?} against {expected}");
            for alpha in [0.01, 0.1, 0.3, 1.0] {
                let (separable, correlated) = (dfg_separable(cos_v, alpha), dfg(cos_v, alpha));
                let [all, more] = [separable, correlated].map(|found| found.scale + found.bias);
                assert!(all <= more + 1e-6, "α {alpha}, cos {cos_v}: {all} above {more}");
            }
        }
        let smooth = [dfg_separable(0.4, 0.0), dfg(0.4, 0.0)];
        assert_eq!(smooth[0], smooth[1], "a mirror has no masking");
    }

    #[test]
    fn compensated_white_metal_vanishes_in_the_furnace() {
        for alpha in [0.1, 0.5, 1.0] {
            for cos_v in COSINES {
                let table = dfg(cos_v, alpha);
                let white = Rgb::splat(1.0);
                let found = table.reflectance(white) * table.energy_compensation(white);
                assert!((found.g - 1.0).abs() < 1e-12, "α {alpha}, cos {cos_v}: {found:?}");
            }
        }
    }

    #[test]
    fn the_table_interpolates_within_its_stated_error() {
        let table = DfgTable::new(64);
        let mut worst = 0.0_f64;
        for i in 0..40 {
            for j in 0..40 {
                let (cos_v, r) = (0.1 + 0.9 * f64::from(i) / 39.0, 0.1 + 0.9 * f64::from(j) / 39.0);
                let (found, exact) = (table.lookup(cos_v, r), dfg(cos_v, r * r));
                worst = worst.max((found.scale - exact.scale).abs()).max((found.bias - exact.bias).abs());
            }
        }
        println!("64 x 64: {worst:.1e}");
        assert!(worst < 1e-2, "{worst}");
        let texel = table.texels()[10 * 64 + 20];
        assert_eq!(table.lookup(20.5 / 64.0, 10.5 / 64.0), texel, "at a texel's center");
        assert_eq!(DfgTable::new(1).lookup(0.0, 1.0), dfg(0.5, 0.25), "a single texel");
    }
}
