//! Color maps: sequential (cubehelix) and diverging.

use std::f64::consts::PI;

use crate::picture::srgb::srgb_decode;
use crate::pixel::{BLACK, Pixel};

/// The weights of red, green and blue in perceived lightness that [`sequential`] is built on.
const LIGHTNESS: [f64; 3] = [0.30, 0.59, 0.11];
/// The hue at which [`sequential`] starts, in thirds of a turn from blue to red to green.
const START: f64 = 0.5;
/// The turns from black to white; negative turns towards blue first.
const TURNS: f64 = -1.5;

/// The color of `t` in `[0, 1]` on a scale from black to white whose lightness grows in proportion to `t`.
///
/// Linear light, like all pictures; `t` is clamped to `[0, 1]`, NaN is white.
///
/// ```text
///   V(t) = t + (t (1 - t) / 2) (p cos φ + q sin φ)      φ = 2π (START/3 + TURNS t)
/// ```
///
/// `V` is the display value (sRGB-encoded) of the three channels. `p` and `q`, of length 2, span the plane of
/// colors of equal lightness `w·V` with `w = (0.30, 0.59, 0.11)`: `q ∝ (w_g, -w_r, 0)`, and `p ∝ q × w` has blue
/// positive. So the lightness of `V(t)` is exactly `t`: a picture of errors stays readable without colors. The
/// tests `the_scale_is_the_published_cubehelix` and `lightness_grows_in_proportion` check both.
///
/// Source: [Green 2011], with hue 1 and gamma 1.
///
/// [Green 2011]: https://arxiv.org/abs/1108.5083
#[must_use]
pub fn sequential(t: f64) -> Pixel {
    let t = if t.is_nan() { 1.0 } else { t.clamp(0.0, 1.0) };
    let (p, q) = plane_of_equal_lightness();
    let (sin, cos) = (2.0 * PI * (START / 3.0 + TURNS * t)).sin_cos();
    let amplitude = t * (1.0 - t) / 2.0;
    let value = |c: usize| (t + amplitude * (p[c] * cos + q[c] * sin)).clamp(0.0, 1.0);
    from_display([value(0), value(1), value(2)])
}

/// The vectors `p` and `q` of [`sequential`].
fn plane_of_equal_lightness() -> ([f64; 3], [f64; 3]) {
    let [r, g, b] = LIGHTNESS;
    let q = [g, -r, 0.0];
    // q × w, with w = (r, g, b).
    let p = [-r * b, -g * b, g * g + r * r];
    (of_length_2(p), of_length_2(q))
}

fn of_length_2(v: [f64; 3]) -> [f64; 3] {
    let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    v.map(|c| 2.0 * c / length)
}

/// The display value of +1 in [`diverging`].
const RED: [f64; 3] = [0.78, 0.05, 0.08];
/// The display value of -1 in [`diverging`].
const BLUE: [f64; 3] = [0.06, 0.20, 0.82];

/// The color of `t` in `[-1, 1]`: red above zero, blue below, white at zero, NaN black.
///
/// Linear light; the display values are interpolated linearly from white to the end color, `t` is clamped.
#[must_use]
pub fn diverging(t: f64) -> Pixel {
    if t.is_nan() {
        return BLACK;
    }
    let end = if t > 0.0 { RED } else { BLUE };
    let a = t.abs().min(1.0);
    from_display(end.map(|c| 1.0 - a * (1.0 - c)))
}

fn from_display(value: [f64; 3]) -> Pixel {
    value.map(|c| srgb_decode(c) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::srgb::srgb_encode;

    #[test]
    fn the_scale_is_the_published_cubehelix() {
        let (p, q) = plane_of_equal_lightness();
        for (found, printed) in p.iter().chain(&q).zip([-0.14861, -0.29227, 1.97294, 1.78277, -0.90649, 0.0]) {
            assert!((found - printed).abs() < 1e-5, "{found}, printed {printed}");
        }
    }

    #[test]
    fn lightness_grows_in_proportion() {
        for k in 0..=100 {
            let t = f64::from(k) / 100.0;
            let value = sequential(t).map(|c| srgb_encode(f64::from(c)));
            let lightness: f64 = value.iter().zip(LIGHTNESS).map(|(v, w)| v * w).sum();
            assert!((lightness - t).abs() < 1e-5, "t = {t}: lightness {lightness}");
        }
    }

    #[test]
    fn positive_is_red_and_negative_is_blue() {
        for t in [0.2, 0.6, 1.0, 3.0] {
            let (plus, minus) = (diverging(t), diverging(-t));
            assert!(plus[0] > plus[2] && plus[0] > plus[1], "+{t}: {plus:?}");
            assert!(minus[2] > minus[0] && minus[2] > minus[1], "-{t}: {minus:?}");
        }
        assert_eq!(diverging(0.0), [1.0; 3], "zero is white");
    }
}
