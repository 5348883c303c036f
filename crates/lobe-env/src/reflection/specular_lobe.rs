//! Specular lobes: the radially symmetric kernels of prefiltered environment maps.

use std::f64::consts::PI;

use lobe_sh::sphere::gauss_legendre;

use crate::error::EnvError;

/// A lobe about the reflected view: the kernel with which a prefiltered map averages the light around `r`.
///
/// With normal, view and reflected view assumed to be the same direction `r` (split-sum approximation), every lobe is a
/// function of the angle `θ` between the light `l` and `r` alone. Up to the factor that makes the integral 1:
///
/// ```text
///   Ggx         D(h) (n·l)   =  max(cos θ, 0) / (1 + (1/α² - 1)(1 - cos θ)/2)²      h half-way between r and l
///   Phong                       max(cos θ, 0)^s
///   BlinnPhong  (n·h)^s (n·l)  =  max(cos θ, 0) ((1 + cos θ)/2)^(s/2)
/// ```
///
/// `D` is that of [Walter et al. 2007] eq. 33. The density of half vectors drawn by `D` is `D(h) (n·h)/(4 (v·h)) =
/// D(h)/4` over directions `l`, so importance sampling weighted with `n·l` ([Karis 2013]) has the same average. Phong's
/// lobe is the one of highlight maps ([Miller and Hoffman 1984]), without a cosine.
///
/// Every lobe integrates to 1: a constant map stays as it is. A highlight map in Phong's own normalization, in which
/// the lobe's peak is 1 (`∫ L (r·l)^s dl`), is this one times [`SpecularLobe::integral`].
///
/// [Walter et al. 2007]: https://www.cs.cornell.edu/~srm/publications/EGSR07-btdf.pdf
/// [Karis 2013]: https://blog.selfshadow.com/publications/s2013-shading-course/karis/s2013_pbs_epic_notes_v2.pdf
/// [Miller and Hoffman 1984]: https://www.pauldebevec.com/ReflectionMapping/IlluMAP84.html
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum SpecularLobe {
    /// GGX seen along the normal.
    Ggx {
        /// The GGX width `α` in `[0, 1]`: the square of the perceptual roughness.
        alpha: f64,
    },
    /// A power of the cosine to the reflected view.
    Phong {
        /// The exponent `s >= 0`.
        exponent: f64,
    },
    /// A power of the cosine between the normal and the half vector, seen along the normal.
    BlinnPhong {
        /// The exponent `s >= 0`. Near its peak the lobe is as wide as Phong's of a quarter of the exponent.
        exponent: f64,
    },
}

impl SpecularLobe {
    /// The lobe at the angle of this cosine from its axis; 1 on the axis. A perfect mirror (`α = 0`) is 0 elsewhere.
    #[must_use]
    pub fn value(&self, cos: f64) -> f64 {
        let d = 1.0 - cos.clamp(-1.0, 1.0);
        match *self {
            Self::Ggx { alpha } => GgxKernel::new(alpha).exact(d),
            Self::Phong { exponent } => PowerKernel::phong(exponent).exact(d),
            Self::BlinnPhong { exponent } => PowerKernel::blinn(exponent).exact(d),
        }
    }

    /// `∫ value ds` over the sphere: for Phong `2π/(s + 1)`.
    #[must_use]
    pub fn integral(&self) -> f64 {
        match *self {
            Self::Ggx { alpha } => integral(&GgxKernel::new(alpha)),
            Self::Phong { exponent } => integral(&PowerKernel::phong(exponent)),
            Self::BlinnPhong { exponent } => integral(&PowerKernel::blinn(exponent)),
        }
    }

    /// Whether the parameter is in its range.
    pub(crate) fn check(&self) -> Result<(), EnvError> {
        let (name, value, fits) = match *self {
            Self::Ggx { alpha } => ("α of a GGX lobe lies in [0, 1]", alpha, (0.0..=1.0).contains(&alpha)),
            Self::Phong { exponent } | Self::BlinnPhong { exponent } => (
                "the exponent of a lobe is finite and not negative",
                exponent,
                (0.0..f64::INFINITY).contains(&exponent),
            ),
        };
        if fits { Ok(()) } else { Err(EnvError::Options(format!("{name}, not {value}"))) }
    }
}

/// A function of the angle `θ` from its axis, given by `d = 1 - cos θ` in `[0, 2]`: small angles keep their digits.
pub(crate) trait Kernel: Sync {
    /// The value to 1e-6 of itself or of the peak, in code that a compiler can do for several `d` at once.
    fn fast(&self, d: f32) -> f32;

    /// The value.
    fn exact(&self, d: f64) -> f64;
}

/// `max(1 - d, 0)/(1 + g d)²`.
pub(crate) struct GgxKernel {
    g: f64,
    single: f32,
}

impl GgxKernel {
    pub(crate) fn new(alpha: f64) -> Self {
        let g = 0.5 * ((1.0 - alpha) * (1.0 + alpha) / alpha / alpha).min(1e30);
        Self { g, single: g as f32 }
    }
}

impl Kernel for GgxKernel {
    #[inline(always)]
    fn fast(&self, d: f32) -> f32 {
        let t = 1.0 / (1.0 + self.single * d);
        let cos = 1.0 - d;
        let cos = if cos > 0.0 { cos } else { 0.0 };
        cos * t * t
    }

    fn exact(&self, d: f64) -> f64 {
        let t = 1.0 / (1.0 + self.g * d);
        (1.0 - d).max(0.0) * t * t
    }
}

/// `max(1 - half d, 0)^exponent`, times `max(1 - d, 0)` for Blinn.
pub(crate) struct PowerKernel {
    exponent: f64,
    /// 1 for Phong; ½ for Blinn, where `(n·h)² = 1 - d/2`.
    part: f64,
    cosine: bool,
}

impl PowerKernel {
    pub(crate) fn phong(exponent: f64) -> Self {
        Self { exponent, part: 1.0, cosine: false }
    }

    pub(crate) fn blinn(exponent: f64) -> Self {
        Self { exponent: 0.5 * exponent, part: 0.5, cosine: true }
    }
}

impl Kernel for PowerKernel {
    #[inline(always)]
    fn fast(&self, d: f32) -> f32 {
        let power = power_below_one(self.part as f32 * d, self.exponent as f32);
        let cos = 1.0 - d;
        let above = if cos > 0.0 { cos } else { 0.0 };
        let lit = if cos > 0.0 { power } else { 0.0 };
        if self.cosine { above * power } else { lit }
    }

    fn exact(&self, d: f64) -> f64 {
        let cos = 1.0 - d;
        if cos <= 0.0 {
            return 0.0;
        }
        let power = (self.exponent * (-self.part * d).ln_1p()).exp();
        if self.cosine { cos * power } else { power }
    }
}

/// A kernel given by the caller.
pub(crate) struct CustomKernel<F>(pub(crate) F);

impl<F: Fn(f64) -> f64 + Sync> Kernel for CustomKernel<F> {
    #[inline(always)]
    fn fast(&self, d: f32) -> f32 {
        (self.0)(1.0 - f64::from(d)) as f32
    }

    fn exact(&self, d: f64) -> f64 {
        (self.0)(1.0 - d)
    }
}

/// `∫ K ds = 2π ∫_0^2 K(d) dd`, in pieces that grow outwards from the axis by a factor of four.
pub(crate) fn integral(kernel: &impl Kernel) -> f64 {
    pieces(|start, end, rule| {
        let half = 0.5 * (end - start);
        rule.iter().map(|(x, weight)| 2.0 * PI * half * weight * kernel.exact(start + half * (1.0 + x))).sum()
    })
    .iter()
    .map(|piece| piece.1)
    .sum()
}

/// Evaluates each piece of `[0, 2]`; returns the end of each and its value. The horizon `d = 1` lies between pieces.
pub(crate) fn pieces(mut value: impl FnMut(f64, f64, &[(f64, f64)]) -> f64) -> Vec<(f64, f64)> {
    const FIRST: f64 = 1.0 / (1_u64 << 40) as f64;
    let rule = gauss_legendre(24);
    let mut ends: Vec<f64> = std::iter::successors(Some(FIRST), |end| (end * 4.0 < 1.0).then_some(end * 4.0)).collect();
    ends.extend([1.0, 1.5, 2.0]);
    let mut start = 0.0;
    ends.iter().map(|&end| (end, value(std::mem::replace(&mut start, end), end, &rule))).collect()
}

/// `(1 - x)^s` for `0 <= x <= 1`, `s >= 0`, in straight-line code; 0 for `x = 1`.
///
/// `1 - x = m 2^e` with `m` in `[√½, √2)`; `ln m = 2 artanh z`, `z = (m - 1)/(m + 1)`, by its series to `z⁹`
/// (`|z| <= 0.172`: the rest is below 1e-9); then `2^y` by the series of `e^r` to `r⁶`, `|r| <= 0.35`.
#[inline(always)]
fn power_below_one(x: f32, s: f32) -> f32 {
    const SQRT_HALF_BITS: u32 = 0x3f35_04f3;
    let base = 1.0 - x;
    let base = if base > f32::MIN_POSITIVE { base } else { f32::MIN_POSITIVE };
    let bits = base.to_bits().wrapping_sub(SQRT_HALF_BITS);
    let e = (bits as i32) >> 23;
    let m = f32::from_bits((bits & 0x007f_ffff).wrapping_add(SQRT_HALF_BITS));
    // Near the axis `m - 1` has lost digits that `x` has.
    let f = if e == 0 { -x } else { m - 1.0 };
    let z = f / (2.0 + f);
    let q = z * z;
    let ln = 2.0 * z * (1.0 + q * (1.0 / 3.0 + q * (0.2 + q * (1.0 / 7.0 + q * (1.0 / 9.0)))));
    let y = s * (ln * std::f32::consts::LOG2_E + e as f32);
    let y = if y > -126.0 { y } else { -126.0 };
    // Adding 1.5 2²³ rounds to an integer, which then stands in the lowest bits.
    const ROUND: f32 = 12_582_912.0;
    let shifted = y + ROUND;
    let whole = shifted.to_bits().wrapping_sub(ROUND.to_bits());
    let r = (y - (shifted - ROUND)) * std::f32::consts::LN_2;
    let exp = 1.0 + r * (1.0 + r * (0.5 + r * (1.0 / 6.0 + r * (1.0 / 24.0 + r * (1.0 / 120.0 + r * (1.0 / 720.0))))));
    exp * f32::from_bits(whole.wrapping_add(127) << 23)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_lobe_has_its_closed_form_integral() {
        for s in [0.0, 1.0, 7.5, 200.0, 1e5] {
            let (found, expected) = (SpecularLobe::Phong { exponent: s }.integral(), 2.0 * PI / (s + 1.0));
            assert!((found / expected - 1.0).abs() < 1e-10, "Phong {s}: {found} against {expected}");
            // ∫_0^1 (1 - d)(1 - d/2)^p dd with u = 1 - d/2
            let p = 0.5 * s;
            let upper = 2.0 * (2.0 / (p + 2.0) - 1.0 / (p + 1.0));
            let lower = 2.0 * (2.0 * 0.5_f64.powf(p + 2.0) / (p + 2.0) - 0.5_f64.powf(p + 1.0) / (p + 1.0));
            let (found, expected) = (SpecularLobe::BlinnPhong { exponent: s }.integral(), 2.0 * PI * (upper - lower));
            assert!((found / expected - 1.0).abs() < 1e-9, "Blinn {s}: {found} against {expected}");
        }
        for alpha in [1e-3_f64, 0.1, 0.5, 0.9] {
            // ∫_0^1 (1 - d)/(1 + g d)² dd = (1 + 1/g)/g (1 - 1/(1+g)) - ln(1+g)/g²
            let g = 0.5 * (1.0 / (alpha * alpha) - 1.0);
            let expected = 2.0 * PI * ((1.0 + 1.0 / g) / g * (1.0 - 1.0 / (1.0 + g)) - (1.0 + g).ln() / (g * g));
            let found = SpecularLobe::Ggx { alpha }.integral();
            assert!((found / expected - 1.0).abs() < 1e-9, "GGX {alpha}: {found} against {expected}");
        }
        assert!((SpecularLobe::Ggx { alpha: 1.0 }.integral() / PI - 1.0).abs() < 1e-14, "the clamped cosine");
    }

    #[test]
    fn the_fast_kernels_equal_the_exact_ones() {
        let check = |name: &str, kernel: &dyn Kernel| {
            for k in 0..=4000 {
                let d = (f64::from(k) / 4000.0).powi(4) * 2.0;
                let (fast, exact) = (f64::from(kernel.fast(d as f32)), kernel.exact(f64::from(d as f32)));
                assert!((fast - exact).abs() < 3e-6 * exact.abs() + 2e-7, "{name} at {d}: {fast} against {exact}");
            }
        };
        for alpha in [1e-3, 0.0625, 0.5, 1.0] {
            check(&format!("GGX {alpha}"), &GgxKernel::new(alpha));
        }
        for s in [0.0, 0.5, 1.0, 10.0, 300.0, 1e5] {
            check(&format!("Phong {s}"), &PowerKernel::phong(s));
            check(&format!("Blinn {s}"), &PowerKernel::blinn(s));
        }
    }

    #[test]
    fn the_ggx_lobe_is_the_distribution_of_its_half_vector_times_the_cosine() {
        for alpha in [0.05_f64, 0.3, 1.0] {
            for theta in [0.0_f64, 0.1, 0.7, 1.5, 2.0] {
                let cos_h = (0.5 * theta).cos();
                let width = alpha * alpha;
                let distribution = (width / ((width - 1.0) * cos_h * cos_h + 1.0)).powi(2);
                let expected = distribution * theta.cos().max(0.0);
                let found = SpecularLobe::Ggx { alpha }.value(theta.cos());
                assert!((found - expected).abs() < 1e-12, "α {alpha}, θ {theta}: {found} against {expected}");
            }
        }
    }
}
