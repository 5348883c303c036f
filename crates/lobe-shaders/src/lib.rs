//! Functions of spherical-harmonic lighting for the shaders of other programs.
//!
//! [`ShaderFunction::ALL`] lists them, [`shader_text`] writes some of them with what they need in one of the
//! [languages](ShaderLanguage), and [`ShaderFunction::spirv`] is a compute program around one. They are WGSL modules of
//! `lobe-gpu`; naga has written the other languages. Nothing is translated at run time.
//!
//! ```
//! use lobe_shaders::{ShaderFunction, ShaderLanguage, shader_text};
//!
//! let function = ShaderFunction::find("octahedral_dir_from_uv")?;
//! let text = shader_text(ShaderLanguage::Hlsl, &[function])?;
//! assert!(text.contains("float3 octahedral_dir_from_uv(float2 uv)"), "{text}");
//! # Ok::<(), lobe_shaders::ShaderError>(())
//! ```
//!
//! Vectors are unit vectors in a right-handed frame with +z up, expansions are arrays of colors in Lobe's order and
//! signs. Numbers are those of `lobe-sh` to 1e-5 where coefficients are at most 1 (test
//! `every_shader_function_has_the_numbers_of_the_library` of `lobe-gpu`).

mod compute_program;
mod error;
mod functions;
#[cfg(test)]
mod generate;
mod items;
mod shader_function;
mod shader_language;
mod shader_text;
mod shader_types;

pub use error::ShaderError;
pub use shader_function::ShaderFunction;
pub use shader_language::ShaderLanguage;
pub use shader_text::shader_text;
