//! The languages of shaders.

use std::fmt;
use std::str::FromStr;

use crate::error::ShaderError;

/// A language in which shaders are written.
///
/// ```
/// use lobe_shaders::ShaderLanguage;
///
/// let language: ShaderLanguage = "msl".parse()?;
/// assert_eq!(language.extension(), "metal");
/// # Ok::<(), lobe_shaders::ShaderError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ShaderLanguage {
    /// WebGPU's.
    Wgsl,
    /// OpenGL's and Vulkan's; the text is for every version from 330 and ES 300 on.
    Glsl,
    /// Direct3D's, shader model 5 and 6.
    Hlsl,
    /// Metal's, version 2.
    Msl,
    /// Vulkan's binary form, version 1.3: one compute program for each function.
    Spirv,
}

impl ShaderLanguage {
    /// All languages.
    pub const ALL: [Self; 5] = [Self::Wgsl, Self::Glsl, Self::Hlsl, Self::Msl, Self::Spirv];

    /// The name in options.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Wgsl => "wgsl",
            Self::Glsl => "glsl",
            Self::Hlsl => "hlsl",
            Self::Msl => "msl",
            Self::Spirv => "spirv",
        }
    }

    /// What it is, for help pages.
    #[must_use]
    pub fn description(self) -> &'static str {
        match self {
            Self::Wgsl => "WebGPU",
            Self::Glsl => {
                "OpenGL from 3.3 on, WebGL 2, OpenGL ES from 3.0 on and Vulkan; the program has the #version line"
            }
            Self::Hlsl => "Direct3D, shader model 5 and 6",
            Self::Msl => "Metal from 2.0 on",
            Self::Spirv => "Vulkan from 1.1 on: a compute program for each function, from a buffer to a buffer",
        }
    }

    /// The ending of files.
    #[must_use]
    pub fn extension(self) -> &'static str {
        match self {
            Self::Wgsl => "wgsl",
            Self::Glsl => "glsl",
            Self::Hlsl => "hlsl",
            Self::Msl => "metal",
            Self::Spirv => "spv",
        }
    }

    /// All functions in this language; `None` for what is no text.
    pub(crate) fn library(self) -> Option<&'static str> {
        match self {
            Self::Wgsl => Some(include_str!("../shaders/lobe.wgsl")),
            Self::Glsl => Some(include_str!("../shaders/lobe.glsl")),
            Self::Hlsl => Some(include_str!("../shaders/lobe.hlsl")),
            Self::Msl => Some(include_str!("../shaders/lobe.metal")),
            Self::Spirv => None,
        }
    }

    /// What stands before functions of this language.
    pub(crate) fn prelude(self) -> &'static str {
        match self {
            Self::Msl => "#include <metal_stdlib>\n",
            Self::Glsl => {
                "// For #version 330, 300 es or later, which the program has above it; in ES with precision highp float.\n"
            }
            Self::Wgsl | Self::Hlsl | Self::Spirv => "",
        }
    }
}

impl fmt::Display for ShaderLanguage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for ShaderLanguage {
    type Err = ShaderError;

    fn from_str(text: &str) -> Result<Self, ShaderError> {
        Self::ALL.into_iter().find(|language| language.name() == text).ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            ShaderError::Options(format!("expected one of {names}; found '{text}'"))
        })
    }
}
