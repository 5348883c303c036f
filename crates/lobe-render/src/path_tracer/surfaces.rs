//! The models of reflection of surfaces, by name.

use std::fmt;
use std::str::FromStr;

/// Models of reflection.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Surfaces {
    /// All are matte and their albedo is the base color; metallic and roughness are ignored. This is what a diffuse
    /// bake computes.
    #[default]
    Matte,
    /// The metallic-roughness model of glTF 2.0 with height-correlated masking, as renderers have it; surfaces whose
    /// materials emit light do.
    MetallicRoughness,
    /// The same with separable masking, as appendix B.3 of the specification prints it: rough metals are darker.
    MetallicRoughnessSeparable,
}

impl Surfaces {
    /// All models with their names.
    pub const NAMES: [(Self, &'static str); 3] = [
        (Self::Matte, "matte"),
        (Self::MetallicRoughness, "gltf"),
        (Self::MetallicRoughnessSeparable, "gltf-separable"),
    ];
}

impl fmt::Display for Surfaces {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = Self::NAMES.iter().find(|(model, _)| model == self).map_or("", |(_, name)| name);
        f.write_str(name)
    }
}

impl FromStr for Surfaces {
    type Err = String;

    /// `matte`, `gltf` or `gltf-separable`.
    fn from_str(text: &str) -> Result<Self, String> {
        let found = Self::NAMES.iter().find(|(_, name)| *name == text).map(|(model, _)| *model);
        found.ok_or_else(|| format!("expected matte, gltf or gltf-separable, found {text:?}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_model_is_read_from_the_name_that_it_prints() {
        for (model, name) in Surfaces::NAMES {
            assert_eq!((name.parse(), &*model.to_string()), (Ok(model), name), "{name}");
        }
        let error = "shiny".parse::<Surfaces>().unwrap_err();
        assert_eq!(error, "expected matte, gltf or gltf-separable, found \"shiny\"");
    }
}
