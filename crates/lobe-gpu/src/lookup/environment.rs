//! Environment maps on the device.

use std::f64::consts::PI;

use bytemuck::{Pod, Zeroable};
use lobe_env::{CubeMipChain, MappedMap, Mapping, RoughnessLevels};
use lobe_sh::{Coefficient as _, Dir, Rgb, Rotation};

use crate::error::GpuError;
use crate::renderer::renderer::Renderer;
use crate::renderer::shader::Shader;

/// The most levels, as in the WGSL module.
const MOST_LEVELS: usize = 16;

/// An environment map for shaders, in any mapping, with one level or one for each roughness.
///
/// A lookup is that of [`MappedMap::radiance`]: bilinear, across every seam, with exact weights where the filters of
/// textures have eight bits. Positions in the picture are single precision: the error grows with the width, 1e-7 times
/// the width times the difference of neighboring texels.
///
/// The sky can be turned without touching a texel ([`SceneView::turn_backdrop`](crate::SceneView::turn_backdrop)).
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    mapping: Mapping,
    levels: Vec<Level>,
    roughness: RoughnessLevels,
    texels: Vec<Rgb<f32>>,
    width: usize,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Level {
    width: usize,
    height: usize,
    row: usize,
}

/// The shape of an environment, as the WGSL module has it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct EnvironmentShape {
    quadratic: u32,
    strength: f32,
    unused: [u32; 2],
    turn: [[f32; 4]; 3],
    level: [LevelShape; MOST_LEVELS],
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct LevelShape {
    width: u32,
    height: u32,
    row: u32,
    bend: f32,
}

impl EnvironmentShape {
    /// The shape of the environment turned once more.
    pub(crate) fn turned(&self, turn: &Rotation) -> Self {
        // The columns of `self.turn R⁻¹`.
        let back = turn.inverse();
        let turn = [Dir::X, Dir::Y, Dir::Z].map(|axis| {
            let v = back.rotate_dir(axis).to_array().map(|c| c as f32);
            std::array::from_fn(|row| (0..3).map(|k| self.turn[k][row] * v[k]).sum())
        });
        Self { turn, ..*self }
    }

    /// The shape of the environment with its radiance times a factor.
    pub(crate) fn with_strength(&self, strength: f64) -> Self {
        Self { strength: strength as f32, ..*self }
    }
}

impl From<&MappedMap> for Environment {
    /// The map as the only level.
    fn from(map: &MappedMap) -> Self {
        let level = Level { width: map.width(), height: map.height(), row: 0 };
        Self {
            mapping: map.mapping(),
            levels: vec![level],
            roughness: RoughnessLevels::Linear,
            texels: map.texels().to_vec(),
            width: map.width(),
        }
    }
}

impl Environment {
    /// The levels of a prefiltered cube, such as those of [`lobe_env::prefilter_ggx`], whose roughnesses are spaced as
    /// `roughness` says.
    ///
    /// # Errors
    /// [`GpuError::Options`] if there are more than 16 levels, or they are spaced otherwise than linear or quadratic.
    pub fn of_levels(levels: &CubeMipChain, roughness: RoughnessLevels) -> Result<Self, GpuError> {
        let maps = levels.levels();
        if !matches!(roughness, RoughnessLevels::Linear | RoughnessLevels::Quadratic) {
            let text = format!("the shader reads levels of linear or quadratic roughness, not of {roughness}");
            return Err(GpuError::Options(text));
        }
        if maps.len() > MOST_LEVELS {
            return Err(GpuError::Options(format!("expected at most {MOST_LEVELS} levels, found {}", maps.len())));
        }
        let width = levels.base().width();
        let (mut rows, mut texels) = (Vec::new(), Vec::new());
        for map in maps {
            rows.push(Level { width: map.width(), height: map.height(), row: texels.len() / width });
            for y in 0..map.height() {
                texels.extend_from_slice(map.row(y));
                texels.resize(texels.len() + width - map.width(), Rgb::ZERO);
            }
        }
        Ok(Self { mapping: Mapping::Cube, levels: rows, roughness, texels, width })
    }

    /// Uploads the texels as texture `name`, the shape as `name shape`.
    pub(crate) fn add_to(&self, renderer: &mut Renderer, name: &str) -> Result<(), GpuError> {
        let size = [self.width as u32, (self.texels.len() / self.width) as u32];
        let texels: Vec<[f32; 4]> = self.texels.iter().map(|c| [c.r, c.g, c.b, 1.0]).collect();
        renderer.upload_texture(name, size, wgpu::TextureFormat::Rgba32Float, &texels)?;
        renderer.uniform(&format!("{name} shape"), &self.shape())
    }

    /// The shader with the constants that looking up this environment needs.
    pub(crate) fn constants(&self, shader: Shader) -> Shader {
        shader.constant("MAPPING", number_of(self.mapping)).constant("LEVELS", self.levels.len())
    }

    /// The shape as shaders read it.
    pub(crate) fn shape(&self) -> EnvironmentShape {
        let mut level = [LevelShape::zeroed(); MOST_LEVELS];
        for (shape, level) in level.iter_mut().zip(&self.levels) {
            *shape = LevelShape {
                width: level.width as u32,
                height: level.height as u32,
                row: level.row as u32,
                bend: row_bend(level.height) as f32,
            };
        }
        let turn = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        let quadratic = u32::from(self.roughness == RoughnessLevels::Quadratic);
        EnvironmentShape { quadratic, strength: 1.0, unused: [0; 2], turn, level }
    }
}

/// The number of a mapping in the WGSL module.
fn number_of(mapping: Mapping) -> usize {
    let known = Mapping::ALL.iter().position(|known| *known == mapping);
    known.unwrap_or_else(|| unreachable!("{mapping} is among all mappings"))
}

/// Up to this height of a row, in radians, the bend is its first term: its closed form loses digits.
const SMALL_ROW: f64 = 1e-3;

/// How far rows of a lat-long picture are bent in the interpolation, over the cotangent at their edge, so that each has
/// its solid angle: `β / cot m` of the interpolation of `lobe_env`, with δ = π/height.
///
/// ```text
///   ((1 - cos δ/2) - I)/(δ K)      I = (2/δ)(sin δ/2 - δ/2 cos δ/2)
///   K = sin(δ/2)/(2δ) - J/δ²       J = (2/δ)(δ²/4 sin δ/2 + δ cos δ/2 - 2 sin δ/2)
/// ```
fn row_bend(height: usize) -> f64 {
    let d = PI / height as f64;
    if d < SMALL_ROW {
        return 0.25 * d;
    }
    let (sin, cos) = (0.5 * d).sin_cos();
    let i = 2.0 / d * (sin - 0.5 * d * cos);
    let j = 2.0 / d * (0.25 * d * d * sin + d * cos - 2.0 * sin);
    let k = 0.5 * sin / d - j / (d * d);
    ((1.0 - cos) - i) / (d * k)
}
