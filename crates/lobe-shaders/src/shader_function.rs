//! A function for shaders: its name, what it computes, what it takes.

use crate::error::ShaderError;
use crate::shader_types::numbers_of;

/// A function for shaders.
///
/// ```
/// use lobe_shaders::ShaderFunction;
///
/// for function in ShaderFunction::ALL {
///     println!("{:36} {}", function.name, function.summary);
/// }
/// ```
#[derive(Debug)]
#[non_exhaustive]
pub struct ShaderFunction {
    /// The name, the same in every language.
    pub name: &'static str,
    /// What it computes, in one line.
    pub summary: &'static str,
    /// Name and type of each argument, in WGSL.
    pub arguments: &'static [(&'static str, &'static str)],
    /// The type of the result, in WGSL.
    pub result: &'static str,
    pub(crate) spirv: &'static [u8],
}

impl ShaderFunction {
    /// The function of a name.
    ///
    /// # Errors
    /// [`ShaderError::Options`] for another name; the message lists those that exist.
    pub fn find(name: &str) -> Result<&'static Self, ShaderError> {
        Self::ALL.iter().find(|function| function.name == name).ok_or_else(|| {
            let names: Vec<&str> = Self::ALL.iter().map(|function| function.name).collect();
            ShaderError::Options(format!("expected one of {}; found '{name}'", names.join(", ")))
        })
    }

    /// A SPIR-V module, [`compute_program`](Self::compute_program) compiled: version 1.3, entry point `main`.
    #[must_use]
    pub fn spirv(&self) -> &'static [u8] {
        self.spirv
    }

    /// Numbers in a row of arguments.
    #[must_use]
    pub fn argument_numbers(&self) -> usize {
        self.arguments.iter().map(|(_, ty)| numbers_of(ty)).sum()
    }

    /// Numbers in a row of results.
    #[must_use]
    pub fn result_numbers(&self) -> usize {
        numbers_of(self.result)
    }
}
