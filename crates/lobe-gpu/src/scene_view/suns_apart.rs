//! Suns of a light beside its expansion: the ways to show them.

use std::borrow::Cow;

use lobe_env::SceneLight;
use lobe_prt::Transfer;

use crate::renderer::kernel::Slot;
use crate::renderer::pass::Use;
use crate::renderer::shader::Shader;
use crate::scene_view::surface_pass::whole;

/// The texture with the maps of what suns see.
pub(crate) const MAPS: &str = "sun maps";

/// How the suns of a light are shown, by a view that is made for them.
///
/// ```text
///   No           B = T·L                                                  L: expansion of all light
///   Unshadowed   B = T·R + ρ/π Σ_suns E_sun max(n·s, 0)                   R: that of what is no sun
///   Shadowed     B = T·R + ρ/π Σ_suns E_sun max(n·s, 0) V(x, s)           V: what is seen of a sun
///   Reflected    B = T·L - D·S + ρ/π Σ_suns E_sun max(n·s, 0) V(x, s)     S: expansion of the suns
/// ```
///
/// `T` is the transfer that is shown, or irradiance, `D` its part without reflections, `ρ` the base color. Meshes
/// that shine have all light in their expansion, whatever this is.
#[derive(Clone, Copy, Debug, Default)]
#[non_exhaustive]
pub enum SunsApart<'a> {
    /// They are in the expansion.
    #[default]
    No,
    /// By themselves, without shadows as all light.
    Unshadowed,
    /// By themselves, at most so many; transfer has no other light of theirs.
    Shadowed(usize),
    /// By themselves, at most so many, and what surfaces reflect of them by transfer, of which this is the part without
    /// reflections: of the same receivers and order.
    Reflected(usize, &'a Transfer),
}

impl<'a> SunsApart<'a> {
    /// The most suns that a view shows apart. What a light has beyond these is in the expansion.
    pub const MOST: usize = 4;

    /// The suns that are apart, at most.
    pub(crate) fn count(&self) -> usize {
        match self {
            Self::No => 0,
            Self::Unshadowed => Self::MOST,
            Self::Shadowed(count) | Self::Reflected(count, _) => (*count).min(Self::MOST),
        }
    }

    /// A light with as many suns as may be apart, from the first on, and the others in its expansion.
    #[must_use]
    pub fn split<'b>(&self, light: &'b SceneLight) -> Cow<'b, SceneLight> {
        limited(light, self.count())
    }

    /// The suns that have a map of what they see.
    pub(crate) fn maps(&self) -> usize {
        if matches!(self, Self::Unshadowed) { 0 } else { self.count() }
    }

    /// A shader with the module `sun_light` and what that reads of these suns, bound after `reads` and the camera; as
    /// it is without suns.
    pub(crate) fn added_to(&self, shader: Shader, reads: &mut Vec<(Use, Slot)>) -> Shader {
        if self.count() == 0 {
            return shader;
        }
        reads.push((whole("suns"), Slot::Uniform));
        let shader = shader.with(&format!("\n@group(0) @binding({}) var<uniform> suns: Suns;\n", reads.len()));
        let head = "fn sun_part(sun: Sun, p: vec3f, plane: vec3f) -> f32 {";
        if self.maps() == 0 {
            return shader.with(&format!("\n{head}\n    return 1.0;\n}}\n"));
        }
        reads.push((whole(MAPS), Slot::Texture));
        shader.with(&format!(
            "@group(0) @binding({}) var sun_maps: texture_2d<f32>;\n\n\
            {head}\n    return sun_visible(sun_maps, sun, p, plane);\n}}\n",
            reads.len()
        ))
    }

    /// The transfer without reflections.
    pub(crate) fn direct(&self) -> Option<&'a Transfer> {
        match self {
            Self::Reflected(_, direct) => Some(direct),
            _ => None,
        }
    }
}

/// A light with the first `most` of its suns apart, and the others in its expansion.
pub(crate) fn limited(light: &SceneLight, most: usize) -> Cow<'_, SceneLight> {
    let suns = light.suns();
    if suns.len() <= most {
        return Cow::Borrowed(light);
    }
    let (kept, others) = suns.split_at(most);
    let whole = SceneLight::new(light.rest().clone(), others.to_vec()).whole();
    Cow::Owned(SceneLight::new(whole, kept.to_vec()))
}
