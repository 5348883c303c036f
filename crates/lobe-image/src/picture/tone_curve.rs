//! Tone curves: from exposed light to `[0, 1]`.

use std::fmt;
use std::sync::LazyLock;

use crate::picture::primaries::{Matrix, inverse, transformed};
use crate::pixel::{luminance, scaled};

/// The curve from exposed light to `[0, 1]`.
///
/// [`Curve::Aces`], [`Curve::AgX`] and [`Curve::Neutral`] show what three.js r187 shows at its exposure 1, within 1e-4
/// (test `curves_have_the_values_of_three_js`).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "lowercase"))]
pub enum Curve {
    /// Clamp to 0 and 1.
    Clip,
    /// Compress highlights: colors keep their chromaticity until a channel is clamped to 1 [Reinhard et al. 2002].
    ///
    /// ```text
    ///   Y' = Y (1 + Y/w²) / (1 + Y)          Y: luminance, of which w becomes 1
    /// ```
    Reinhard {
        /// The least luminance, after exposure, that is shown white.
        white: f64,
    },
    /// The reference rendering and output transforms of ACES, as Hill fitted them for sRGB [Hill 2017]: more contrast,
    /// and bright colors turn to white.
    ///
    /// ```text
    ///   v  = M_in L / 0.6
    ///   L' = M_out (v (v + 0.0245786) - 0.000090537) / (v (0.983729 v + 0.432951) + 0.238081)
    /// ```
    ///
    /// The factor 1/0.6 is that of three.js.
    Aces,
    /// `AgX` without a look [Sobotka 2022]: bright colors lose their saturation, as on film.
    ///
    /// ```text
    ///   x = (log₂(M_in L₂₀₂₀) - e₀) / (e₁ - e₀)          L'₂₀₂₀ = (M_out p(x))^2.2
    /// ```
    ///
    /// `L₂₀₂₀` is light in the primaries of Rec. 2020, its channels below zero black. `x` is clamped to 0 and 1, and `p` is the
    /// polynomial of degree 6 that [Wrensch 2023] fitted to the curve.
    AgX,
    /// Khronos PBR Neutral [Khronos 2024]: base colors up to 0.8 stay as they are, and highlights are compressed.
    ///
    /// ```text
    ///   C = L - m + m²/(4 F₀)                   m: the least channel, or 2 F₀ if that is less; F₀ = 0.04
    ///   P = max C;   P' = 1 - d²/(P + d - s) for P ≥ s          s = 0.8 - F₀, d = 1 - s
    ///   L' = mix(C P'/P, P', 1 - 1/(0.15 (P - P') + 1))
    /// ```
    Neutral,
}

/// Rows of the matrix to ACES's working space, and back from what it shows [Hill 2017].
const TO_ACES: Matrix = [[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]];
const FROM_ACES: Matrix = [[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]];

/// The factor of three.js before ACES, for surroundings that are brighter than a cinema.
const ACES_BRIGHTNESS: f64 = 1.0 / 0.6;

/// Rec. 2020 to linear sRGB, with the digits of [ITU 2017].
const FROM_REC_2020: Matrix = [[1.6605, -0.5876, -0.0728], [-0.1246, 1.1329, -0.0083], [-0.0182, -0.1006, 1.1187]];

/// Rows of the inset of `AgX`, and of the inverse of its outset [Sobotka 2022].
const INSET: Matrix = [
    [0.856627153315983, 0.0951212405381588, 0.0482516061458583],
    [0.137318972929847, 0.761241990602591, 0.101439036467562],
    [0.11189821299995, 0.0767994186031903, 0.811302368396859],
];
const OUTSET_INVERSE: Matrix = [
    [0.899796955911611, 0.0871996192028351, 0.013003424885555],
    [0.11142098895748, 0.875575586156966, 0.0130034248855548],
    [0.11142098895748, 0.0871996192028349, 0.801379391839686],
];

static TO_REC_2020: LazyLock<Matrix> = LazyLock::new(|| inverse(&FROM_REC_2020));
static OUTSET: LazyLock<Matrix> = LazyLock::new(|| inverse(&OUTSET_INVERSE));

/// The range of `AgX` in stops: log₂ of light [Sobotka 2022].
const STOPS: [f64; 2] = [-12.47393, 4.026069];

/// The polynomial of the contrast of `AgX`, its constant first [Wrensch 2023].
const CONTRAST: [f64; 7] = [-0.00232, 0.1191, 0.4298, -6.868, 31.96, -40.14, 15.5];

/// Figures of [Khronos 2024]: where compression starts, the reflectance at normal incidence, the strength of
/// desaturation.
const START: f64 = 0.8 - F0;
const F0: f64 = 0.04;
const DESATURATION: f64 = 0.15;

/// Light above this is at the end of every curve. An infinite channel would make the others no numbers.
const WHITE: f64 = 1e30;

impl Curve {
    /// Reinhard's curve, by which light of 4 is white.
    pub const REINHARD: Self = Self::Reinhard { white: 4.0 };

    /// All curves, the default first.
    pub const ALL: [Self; 5] = [Self::REINHARD, Self::Aces, Self::AgX, Self::Neutral, Self::Clip];

    /// Names and descriptions of all curves, in their order.
    pub const NAMES: [(&'static str, &'static str); 5] = [
        ("reinhard", "luminance is compressed up to 4 times white"),
        ("aces", "ACES by Hill's fit: more contrast, bright colors turn to white"),
        ("agx", "AgX: less contrast, bright colors lose saturation"),
        ("neutral", "Khronos PBR Neutral: colors up to 0.8 stay as they are"),
        ("clip", "light above 1 is cut off"),
    ];

    /// The curve of a name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::NAMES.iter().position(|(known, _)| *known == name).map(|k| Self::ALL[k])
    }

    /// The name of the curve, whatever its white.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Reinhard { .. } => "reinhard",
            Self::Aces => "aces",
            Self::AgX => "agx",
            Self::Neutral => "neutral",
            Self::Clip => "clip",
        }
    }

    /// The light in `[0, 1]`; negative light is black, infinite light what the curve tends to, and what is no number
    /// black.
    #[must_use]
    pub fn apply(&self, light: [f64; 3]) -> [f64; 3] {
        if light.iter().any(|c| c.is_nan()) {
            return [0.0; 3];
        }
        let bounded = light.map(|c| c.min(WHITE));
        let shown = match *self {
            Self::Clip => light,
            Self::Reinhard { white } => reinhard(light, white),
            Self::Aces => aces(bounded.map(|c| c.max(0.0))),
            Self::AgX => agx(bounded),
            Self::Neutral => neutral(bounded.map(|c| c.max(0.0))),
        };
        shown.map(|c| c.clamp(0.0, 1.0))
    }
}

impl Default for Curve {
    /// Reinhard's, by which light of 4 is white.
    fn default() -> Self {
        Self::REINHARD
    }
}

impl fmt::Display for Curve {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

fn reinhard(light: [f64; 3], white: f64) -> [f64; 3] {
    let y = luminance(light).max(0.0);
    // The limit of the factor, where ∞ / ∞ would make the brightest pixel NaN and so black.
    let limit = 1.0 / (white * white);
    scaled(light, if y.is_finite() { (1.0 + y * limit) / (1.0 + y) } else { limit })
}

fn aces(light: [f64; 3]) -> [f64; 3] {
    let film = transformed(&TO_ACES, scaled(light, ACES_BRIGHTNESS));
    let shown = film.map(|v| (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.4329510) + 0.238081));
    transformed(&FROM_ACES, shown)
}

fn agx(light: [f64; 3]) -> [f64; 3] {
    let wide = transformed(&TO_REC_2020, light).map(|c| c.max(0.0));
    let inset = transformed(&INSET, wide);
    let [least, most] = STOPS;
    let encoded = inset.map(|c| ((c.max(1e-10).log2() - least) / (most - least)).clamp(0.0, 1.0));
    let contrast = encoded.map(|x| CONTRAST.iter().rev().fold(0.0, |sum, c| sum * x + c));
    let shown = transformed(&OUTSET, contrast).map(|c| c.max(0.0).powf(2.2));
    transformed(&FROM_REC_2020, shown)
}

fn neutral(light: [f64; 3]) -> [f64; 3] {
    // Take off what Fresnel reflection adds to a base color.
    let least = light.into_iter().fold(2.0 * F0, f64::min);
    let offset = least - least * least / (4.0 * F0);
    let base = light.map(|c| c - offset);
    let peak = base.into_iter().fold(0.0, f64::max);
    if peak < START {
        return base;
    }
    // Compress the largest channel, the others with it, and mix with white.
    let range = 1.0 - START;
    let compressed = 1.0 - range * range / (peak + range - START);
    let part = 1.0 - 1.0 / (DESATURATION * (peak - compressed) + 1.0);
    scaled(base, compressed / peak).map(|c| c + part * (compressed - c))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the shader of three.js r187 shows of gray light and of bright orange (`peers/python/tone.py`).
    const OF_THREE_JS: [(Curve, [f64; 3], [f64; 3]); 6] = [
        (Curve::Aces, [0.18; 3], [0.213105; 3]),
        (Curve::Aces, [2.0, 0.5, 0.1], [0.982304, 0.604406, 0.224429]),
        (Curve::AgX, [0.18; 3], [0.214502; 3]),
        (Curve::AgX, [2.0, 0.5, 0.1], [0.816277, 0.453794, 0.263061]),
        (Curve::Neutral, [0.18; 3], [0.14; 3]),
        (Curve::Neutral, [2.0, 0.5, 0.1], [0.96, 0.321136, 0.150772]),
    ];

    /// Digits of the published matrices, whose rows do not sum to one exactly.
    const ROUNDING: f64 = 2e-3;
    /// Digits of the matrices whose inverses three.js has rounded, and of the table.
    const OF_THE_TABLE: f64 = 1e-4;

    #[test]
    fn curves_have_the_values_of_three_js() {
        for (curve, light, expected) in OF_THREE_JS {
            let found = curve.apply(light);
            let off = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(off < OF_THE_TABLE, "{curve} of {light:?}: {found:?}, not {expected:?}");
        }
    }

    #[test]
    fn what_is_no_number_is_black_under_every_curve() {
        for (curve, k) in Curve::ALL.into_iter().flat_map(|curve| [0, 1, 2].map(|k| (curve, k))) {
            let mut light = [0.5; 3];
            light[k] = f64::NAN;
            assert_eq!(curve.apply(light), [0.0; 3], "{curve}, channel {k}");
        }
    }

    #[test]
    fn names_and_curves_are_in_one_order() {
        for (curve, (name, _)) in Curve::ALL.into_iter().zip(Curve::NAMES) {
            assert_eq!((curve.name(), Curve::from_name(name)), (name, Some(curve)), "{curve:?}");
        }
        assert_eq!(Curve::from_name("film"), None, "another name");
    }

    #[test]
    fn gray_light_stays_gray_and_rises_from_black_to_white() {
        for curve in Curve::ALL {
            let mut before = curve.apply([0.0; 3]);
            assert!(before.iter().all(|c| *c < ROUNDING), "{curve} of black: {before:?}");
            for stop in -40..=60 {
                let shown = curve.apply([(0.25 * f64::from(stop)).exp2(); 3]);
                let [r, g, b] = shown;
                assert!((r - g).abs() < ROUNDING && (g - b).abs() < ROUNDING, "{curve} at {stop}: {shown:?}");
                assert!(g >= before[1] - 1e-12, "{curve} falls at {stop}: {before:?} to {shown:?}");
                before = shown;
            }
            assert!(before.iter().all(|c| *c > 1.0 - 4.0 * ROUNDING), "{curve} of bright light: {before:?}");
            let infinite = curve.apply([f64::INFINITY; 3]);
            assert!(infinite.iter().all(|c| *c > 1.0 - 4.0 * ROUNDING), "{curve} of infinite light: {infinite:?}");
        }
    }

    #[test]
    fn neutral_shows_base_colors_as_they_are_less_what_fresnel_adds() {
        for base in [[0.05, 0.3, 0.7], [0.5, 0.5, 0.5], [0.1, 0.1, 0.75]] {
            let light = base.map(|c| c + F0);
            let shown = Curve::Neutral.apply(light);
            for (shown, base) in shown.iter().zip(base) {
                assert!((shown - base).abs() < 1e-12, "{light:?}: {shown} for {base}");
            }
        }
    }
}
