//! The background of a picture of a scene, by its name.

use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use lobe_env::EnvMap;
use lobe_image::srgb_decode;
use lobe_sh::{Rgb, ShVec};

use crate::path_tracer::distant_light::Backdrop;

/// What a picture shows where no surface is: the choice, by a name or a color, of a [`Backdrop`].
///
/// ```
/// use lobe_render::Background;
///
/// assert_eq!("none".parse(), Ok(Background::None));
/// let gray = Background::Color([0.5, 0.5, 0.5].into());
/// assert_eq!("0.5,0.5,0.5".parse(), Ok(gray));
/// assert_eq!("#ff0000".parse(), Ok(Background::Color([1.0, 0.0, 0.0].into())));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
#[non_exhaustive]
pub enum Background {
    /// The environment as it was given: a map interpolated between its texels, an expansion with all its bands.
    #[default]
    Env,
    /// The light that lights the scene: of most methods its expansion, with the bands and the window that they use.
    Light,
    /// Nothing: the picture has an alpha.
    None,
    /// One color of radiance, linear.
    Color(Rgb<f64>),
}

impl Background {
    /// The backdrop of a light that was given as a map or as an expansion; what lights the scene may be another
    /// expansion.
    #[must_use]
    pub fn backdrop(self, map: Option<&Arc<EnvMap>>, given: Option<&ShVec<Rgb<f64>>>) -> Backdrop {
        match (self, map, given) {
            (Self::Env, Some(map), _) => Backdrop::Map(map.clone()),
            (Self::Env, None, Some(given)) => Backdrop::Expansion(given.clone()),
            (Self::Env | Self::Light, ..) => Backdrop::Light,
            (Self::None, ..) => Backdrop::None,
            (Self::Color(color), ..) => Backdrop::Color(color),
        }
    }
}

impl FromStr for Background {
    type Err = String;

    /// `env`, `light`, `none`, `#rrggbb` of sRGB, or `r,g,b` of linear light, each at least 0.
    fn from_str(text: &str) -> Result<Self, String> {
        let expected =
            || format!("expected env, light, none, a color #rrggbb, or r,g,b of linear light, found {text:?}");
        match text {
            "env" => return Ok(Self::Env),
            "light" => return Ok(Self::Light),
            "none" => return Ok(Self::None),
            _ => {}
        }
        if let Some(digits) = text.strip_prefix('#') {
            let is_hexadecimal = digits.len() == 6 && digits.bytes().all(|b| b.is_ascii_hexdigit());
            let color = u32::from_str_radix(digits, 16).ok().filter(|_| is_hexadecimal).ok_or_else(expected)?;
            let [_, r, g, b] = color.to_be_bytes().map(|byte| srgb_decode(f64::from(byte) / 255.0));
            return Ok(Self::Color(Rgb::new(r, g, b)));
        }
        let numbers: Option<Vec<f64>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
        match numbers.as_deref() {
            Some(&[r, g, b]) if [r, g, b].iter().all(|c| c.is_finite() && *c >= 0.0) => {
                Ok(Self::Color(Rgb::new(r, g, b)))
            }
            _ => Err(expected()),
        }
    }
}

impl fmt::Display for Background {
    /// The text that it is read from; a color in linear light.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Env => f.write_str("env"),
            Self::Light => f.write_str("light"),
            Self::None => f.write_str("none"),
            Self::Color(Rgb { r, g, b }) => write!(f, "{r},{g},{b}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_background_is_read_from_the_text_that_it_prints() {
        let gray = Background::Color(Rgb::new(0.25, 0.5, 12.0));
        for background in [Background::Env, Background::Light, Background::None, gray] {
            assert_eq!(background.to_string().parse(), Ok(background), "{background}");
        }
    }

    #[test]
    fn a_color_of_a_display_is_linear_light() {
        let Ok(Background::Color(color)) = "#00ff80".parse() else { panic!("a color") };
        assert!((color.b - 0.2158605).abs() < 1e-7 && (color.r, color.g) == (0.0, 1.0), "{color:?}");
    }

    #[test]
    fn other_texts_are_refused_with_what_was_expected() {
        for bad in ["", "sky", "#12345", "#1234567", "#+12345", "1,2", "1,2,3,4", "1,-2,3", "nan,0,0", "inf,0,0", "Env"]
        {
            let error = bad.parse::<Background>().unwrap_err();
            assert!(error.starts_with("expected env, light, none,") && error.contains(bad), "{bad:?}: {error}");
        }
    }
}
