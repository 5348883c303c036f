//! The engines, and in one table what each wants of a light.

use std::fmt;
use std::str::FromStr;

use lobe_sh::encoding::{EngineForm, EngineFrame};

use crate::error::EnvError;
use crate::map::cube_handedness::CubeHandedness;
use crate::prefilter::roughness_levels::{LAST_SIZE, RoughnessLevels};

/// An engine or a viewer that takes the light of an environment map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Engine {
    /// three.js.
    Three,
    /// Babylon.js.
    Babylon,
    /// `PlayCanvas`.
    PlayCanvas,
    /// Filament.
    Filament,
    /// bevy.
    Bevy,
    /// Blender.
    Blender,
    /// Godot.
    Godot,
    /// Unity.
    Unity,
    /// Unreal Engine.
    Unreal,
    /// Mitsuba.
    Mitsuba,
    /// `OpenUSD`: the lights of a stage.
    Usd,
    /// The viewer of glTF by Khronos, and what reads the files of its IBL sampler.
    Khronos,
}

/// How far an engine's row of the table has been tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Tried {
    /// This version read the files by the snippet, and what it showed was compared with the light.
    Run(&'static str),
    /// Nothing was run: by the formulas of its source, or of programs that quote it.
    Formulas,
}

/// What an engine wants of a light.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct EngineFacts {
    /// Its name as it is written.
    pub title: &'static str,
    /// The version that was tried.
    pub tried: Tried,
    /// The frame of its world.
    pub frame: EngineFrame,
    /// Quarter turns about the vertical, counterclockwise from above, by which a lat-long map is turned for it.
    pub panorama_turn: i32,
    /// For which directions the faces of its cubes are made.
    pub faces: CubeHandedness,
    /// The roughness of the levels of its prefiltered chains, and the size of the last one; none if it prefilters by
    /// itself, or traces paths.
    pub chain: Option<(RoughnessLevels, usize)>,
    /// The form of its coefficients.
    pub form: Option<EngineForm>,
    /// Whether it traces paths, so that suns can stay in the map.
    pub traces_paths: bool,
    /// Directional lights that the program may make; none if there is no limit. Other suns stay in the pictures.
    pub most_suns: Option<usize>,
    /// What a light of it is in.
    pub units: &'static str,
}

/// Units of engines that multiply textures and lights as they are.
const PLAIN: &str = "a texel is radiance, the intensity of a sun its irradiance, both in the units of the map";

/// What rows have that say nothing else.
const USUAL: EngineFacts = EngineFacts {
    title: "",
    tried: Tried::Formulas,
    frame: EngineFrame::YUp,
    panorama_turn: 0,
    faces: CubeHandedness::Left,
    chain: None,
    form: None,
    traces_paths: false,
    most_suns: None,
    units: PLAIN,
};

impl Engine {
    /// All engines.
    pub const ALL: [Self; 12] = [
        Self::Three,
        Self::Babylon,
        Self::PlayCanvas,
        Self::Filament,
        Self::Bevy,
        Self::Blender,
        Self::Godot,
        Self::Unity,
        Self::Unreal,
        Self::Mitsuba,
        Self::Usd,
        Self::Khronos,
    ];

    /// The name in options, and of the folder of its files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Three => "three",
            Self::Babylon => "babylon",
            Self::PlayCanvas => "playcanvas",
            Self::Filament => "filament",
            Self::Bevy => "bevy",
            Self::Blender => "blender",
            Self::Godot => "godot",
            Self::Unity => "unity",
            Self::Unreal => "unreal",
            Self::Mitsuba => "mitsuba",
            Self::Usd => "usd",
            Self::Khronos => "khronos",
        }
    }

    /// The table. `peers/engines` runs the engines that can be run and compares what they show.
    #[must_use]
    pub fn facts(self) -> EngineFacts {
        self.of_the_web().or_else(|| self.of_paths()).unwrap_or_else(|| self.by_formulas())
    }

    /// Rows of engines whose lookups were seen to read the chains.
    fn of_the_web(self) -> Option<EngineFacts> {
        Some(match self {
            Self::Three => EngineFacts {
                title: "three.js",
                tried: Tried::Run("0.187.0"),
                chain: Some((RoughnessLevels::Quadratic, 8)),
                form: Some(EngineForm::Three),
                ..USUAL
            },
            Self::Babylon => EngineFacts {
                title: "Babylon.js",
                tried: Tried::Run("9.35.0"),
                frame: EngineFrame::YUpLeftHanded,
                panorama_turn: 1,
                chain: Some((RoughnessLevels::Babylon, 1)),
                form: Some(EngineForm::Babylon),
                ..USUAL
            },
            Self::PlayCanvas => EngineFacts {
                title: "PlayCanvas",
                tried: Tried::Run("2.23.3"),
                panorama_turn: 1,
                form: Some(EngineForm::PlayCanvas),
                ..USUAL
            },
            Self::Filament => EngineFacts {
                most_suns: Some(1),
                title: "Filament",
                tried: Tried::Run("1.53.4"),
                faces: CubeHandedness::Right,
                chain: Some((RoughnessLevels::Quadratic, LAST_SIZE)),
                form: Some(EngineForm::Filament),
                units: "a texel is luminance in cd/m², the intensity of a sun its illuminance in lux, both before exposure",
                ..USUAL
            },
            Self::Bevy => EngineFacts {
                title: "bevy",
                tried: Tried::Run("0.19.1"),
                chain: Some((RoughnessLevels::Linear, LAST_SIZE)),
                units: "a texel times `intensity` is luminance in cd/m², a sun is in lux; at ev100 = 0 the picture is \
                        1/1.2 of it",
                ..USUAL
            },
            _ => return None,
        })
    }

    /// Rows of programs that trace paths.
    fn of_paths(self) -> Option<EngineFacts> {
        let usual = EngineFacts { traces_paths: true, ..USUAL };
        Some(match self {
            Self::Blender => {
                EngineFacts { title: "Blender", tried: Tried::Run("5.0.1"), frame: EngineFrame::ZUp, ..usual }
            }
            Self::Mitsuba => EngineFacts { title: "Mitsuba", tried: Tried::Run("3.9.1"), panorama_turn: 1, ..usual },
            // Its panoramas are those of OpenEXR, whose middle is +z.
            Self::Usd => EngineFacts {
                title: "OpenUSD",
                tried: Tried::Run("Blender 5.0.1's importer"),
                panorama_turn: 1,
                units: "a texel is radiance, the intensity of a sun its irradiance, normalized by its angle; Blender \
                        5.0 doubles that angle, and so makes a sun four times as strong: divide its strength by four \
                        there",
                ..usual
            },
            _ => return None,
        })
    }

    /// Rows of what was not run.
    fn by_formulas(self) -> EngineFacts {
        match self {
            Self::Godot => EngineFacts {
                title: "Godot",
                panorama_turn: 1,
                form: Some(EngineForm::Godot),
                units: "a texel is radiance; the energy of a sun is its irradiance over π",
                ..USUAL
            },
            Self::Unity => EngineFacts {
                title: "Unity",
                frame: EngineFrame::YUpLeftHanded,
                panorama_turn: 1,
                form: Some(EngineForm::Unity),
                units: "a texel is radiance; the intensity of a sun is its irradiance over π",
                ..USUAL
            },
            Self::Unreal => EngineFacts {
                title: "Unreal Engine",
                frame: EngineFrame::ZUpLeftHanded,
                panorama_turn: -1,
                form: Some(EngineForm::Unreal),
                units: "a texel is luminance in cd/m², the intensity of a sun its illuminance in lux",
                ..USUAL
            },
            _ => EngineFacts {
                title: "glTF sample viewer",
                faces: CubeHandedness::Right,
                chain: Some((RoughnessLevels::Linear, LAST_SIZE)),
                most_suns: Some(0),
                ..USUAL
            },
        }
    }

    /// The version that was tried, in words.
    #[must_use]
    pub fn tried(self) -> String {
        match self.facts().tried {
            Tried::Run(version) => format!("tried with {version}, which ran the program in this folder"),
            Tried::Formulas => "by the formulas of its source, not run".to_owned(),
        }
    }
}

impl fmt::Display for Engine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Engine {
    type Err = EnvError;

    fn from_str(text: &str) -> Result<Self, EnvError> {
        Self::ALL.into_iter().find(|engine| engine.name() == text).ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            EnvError::Options(format!("expected one of {names}, found {text:?}"))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn engines_are_read_by_the_names_that_they_print() {
        for engine in Engine::ALL {
            assert_eq!(engine.to_string().parse::<Engine>().unwrap(), engine, "{engine}");
            assert!(!engine.facts().title.is_empty(), "{engine}: a title");
        }
        let error = "quake".parse::<Engine>().unwrap_err().to_string();
        assert!(error.contains("three, babylon") && error.ends_with("\"quake\""), "{error}");
    }

    #[test]
    fn coefficients_are_in_the_frame_of_the_engine() {
        for engine in Engine::ALL {
            let EngineFacts { frame, form, .. } = engine.facts();
            if let Some(form) = form {
                assert_eq!(form.frame(), frame, "{engine}");
            }
        }
    }
}
