//! Materials: the metallic-roughness model of glTF 2.0.

/// The reflectance of a surface: the metallic-roughness model of glTF 2.0.
///
/// What is asked of a point is [`Surface::base_color`](crate::Surface::base_color) and
/// [`Scene::finish`](crate::Scene::finish).
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Material {
    /// The name in its file.
    pub name: String,
    /// Linear base color and alpha: the albedo of a surface that is no metal.
    pub base_color: [f32; 4],
    /// A texture that multiplies the base color.
    pub base_color_texture: Option<TextureUse>,
    /// A texture that tilts the normals to shade with, where the mesh has [tangents](crate::Mesh::tangents).
    pub normal_map: Option<NormalMap>,
    /// The use of alpha.
    pub alpha: Alpha,
    /// Whether both sides reflect. A surface that is not double-sided still blocks light from both sides.
    pub double_sided: bool,
    /// 0 for plastics and stone, 1 for metals.
    pub metallic: f32,
    /// A texture whose blue multiplies [`metallic`](Self::metallic).
    pub metallic_texture: Option<TextureUse>,
    /// Perceptual roughness; its square is the α of GGX.
    pub roughness: f32,
    /// A texture whose green multiplies [`roughness`](Self::roughness).
    pub roughness_texture: Option<TextureUse>,
    /// A texture of how much light from all around reaches a point.
    pub occlusion_map: Option<OcclusionMap>,
    /// Emitted radiance, the same towards all sides, in the unit of the light.
    pub emissive: [f32; 3],
    /// A texture that multiplies the emitted radiance.
    pub emissive_texture: Option<TextureUse>,
    /// The part of the light entering the surface that comes out behind it, for thin glass: `KHR_materials_transmission`.
    pub transmission: f32,
    /// Whether light goes straight through blended and transmissive surfaces, see [`Scene::opacity`](crate::Scene::opacity);
    /// without it they are opaque.
    pub straight_through: bool,
}

/// The use of the base color's alpha.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum Alpha {
    /// Alpha is ignored.
    #[default]
    Opaque,
    /// The surface exists where alpha is at least the cutoff.
    Mask(f32),
    /// Alpha is coverage, if [`Material::straight_through`] is set; else the surface is opaque.
    Blend,
}

/// A texture and its mapping.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct TextureUse {
    /// Index into the textures of the scene.
    pub texture: usize,
    /// The mesh's set of texture coordinates, 0 or 1.
    pub uv_set: usize,
    /// Rows of the affine map from the mesh's coordinates to the picture's: `u' = r₀₀ u + r₀₁ v + r₀₂`, `v'` likewise.
    pub uv_map: [[f32; 3]; 2],
}

/// A texture of normals, relative to those of the vertices.
///
/// ```text
///   n = normalize( s (2 t_x - 1) T + s (2 t_y - 1) w (N × T) + (2 t_z - 1) N )
/// ```
///
/// `t` are the texture's numbers from 0 to 1 as they are stored, not decoded as colors, interpolated bilinearly before `n` is
/// normalized; `N` and `T` are the interpolated normal and tangent of the vertices, `T` made perpendicular to `N`, and `w = ±1`
/// says to which side the texture's y, against v, runs. That is the normal texture of glTF 2.0.
///
/// Tangents are along the u of the mesh. Where [`TextureUse::uv_map`], whose rows begin with `a, b` and `c, d`, turns or mirrors
/// the picture, its own u is the first column of the inverse of that map:
///
/// ```text
///   T' ∝ σ (d T + c w (N × T)),      w' = σ w,      σ = -1 if a d < b c, else 1
/// ```
///
/// take the places of `T` and `w`, and where `T'` would be zero `T` stays.
///
/// A sum of zero, or a tangent of zero, leaves `N`. Texels of 128, 128, 255 stand for (0.004, 0.004, 1): eight bits hold no half.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct NormalMap {
    /// The texture and its mapping.
    pub used: TextureUse,
    /// `s`, the factor of the tilt, finite. Zero leaves `N`.
    pub scale: f32,
}

/// A texture of occlusion: of the light from all around, a point has the part
///
/// ```text
///   o = 1 + s (t_r - 1)
/// ```
///
/// where `t_r` is the texture's red as it is stored. It says nothing of lamps and suns. That is the occlusion texture
/// of glTF 2.0.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct OcclusionMap {
    /// The texture and its mapping.
    pub used: TextureUse,
    /// `s`, from 0, no occlusion, to 1.
    pub strength: f32,
}

impl TextureUse {
    /// The point of the picture at a mesh's texture coordinates. It is finite if all of these numbers are, however large: products
    /// of two of `f32` are far from the largest of `f64`.
    #[must_use]
    pub fn map(uv_map: [[f32; 3]; 2], uv: [f32; 2]) -> [f64; 2] {
        let [u, v] = uv.map(f64::from);
        uv_map.map(|row| {
            let [a, b, c] = row.map(f64::from);
            a * u + b * v + c
        })
    }

    /// The identity map.
    pub const UV_UNCHANGED: [[f32; 3]; 2] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
}

impl Material {
    /// White, Lambertian and double-sided: the material of a mesh without one.
    pub const WHITE: Self = Self {
        name: String::new(),
        base_color: [1.0; 4],
        base_color_texture: None,
        normal_map: None,
        alpha: Alpha::Opaque,
        double_sided: true,
        metallic: 0.0,
        metallic_texture: None,
        roughness: 1.0,
        roughness_texture: None,
        occlusion_map: None,
        emissive: [0.0; 3],
        emissive_texture: None,
        transmission: 0.0,
        straight_through: false,
    };

    /// Refuses numbers that are out of their range, in words.
    pub(crate) fn check(&self) -> Result<(), String> {
        let Self { name, base_color, metallic, roughness, transmission, emissive, .. } = self;
        if base_color.iter().chain([metallic, roughness, transmission]).any(|value| !(0.0..=1.0).contains(value)) {
            return Err(format!(
                "material `{name}`: expected base color, metallic, roughness and transmission from 0 to 1, found \
                 {base_color:?}, {metallic}, {roughness} and {transmission}"
            ));
        }
        if !emissive.iter().all(|value| value.is_finite() && *value >= 0.0) {
            return Err(format!("material `{name}`: expected a finite emission from 0 on, found {emissive:?}"));
        }
        if let Some(strength) = self.occlusion_map.map(|map| map.strength).filter(|s| !(0.0..=1.0).contains(s)) {
            return Err(format!("material `{name}`: expected a strength of occlusion from 0 to 1, found {strength}"));
        }
        for TextureUse { uv_set, uv_map, .. } in self.textures() {
            if uv_set > 1 {
                return Err(format!("material `{name}`: expected texture coordinates of set 0 or 1, found {uv_set}"));
            }
            if !uv_map.as_flattened().iter().all(|value| value.is_finite()) {
                return Err(format!("material `{name}`: expected a finite map of its texture, found {uv_map:?}"));
            }
        }
        match self.normal_map.map(|map| map.scale).filter(|scale| !scale.is_finite()) {
            Some(scale) => Err(format!("material `{name}`: expected a finite scale of its normal map, found {scale}")),
            None => Ok(()),
        }
    }

    /// The textures of the material.
    pub(crate) fn textures(&self) -> impl Iterator<Item = TextureUse> {
        let color = self.base_color_texture.into_iter().chain(self.normal_map.map(|map| map.used));
        let finish = [self.metallic_texture, self.roughness_texture, self.emissive_texture].into_iter().flatten();
        color.chain(finish).chain(self.occlusion_map.map(|map| map.used))
    }

    /// The same, to be changed.
    pub(crate) fn textures_mut(&mut self) -> impl Iterator<Item = &mut TextureUse> {
        let color = self.base_color_texture.iter_mut().chain(self.normal_map.iter_mut().map(|map| &mut map.used));
        let finish = [&mut self.metallic_texture, &mut self.roughness_texture, &mut self.emissive_texture];
        let occlusion = self.occlusion_map.iter_mut().map(|map| &mut map.used);
        color.chain(finish.into_iter().flatten()).chain(occlusion)
    }

    /// Whether surfaces of this material emit light.
    #[must_use]
    pub fn is_emissive(&self) -> bool {
        self.emissive != [0.0; 3]
    }

    /// Whether rays may pass surfaces of this material.
    #[must_use]
    pub fn has_holes(&self) -> bool {
        let lets_through = self.alpha == Alpha::Blend || self.transmission > 0.0;
        matches!(self.alpha, Alpha::Mask(_)) || self.straight_through && lets_through
    }

    /// Whether light goes straight through it as through glass.
    pub(crate) fn is_clear(&self) -> bool {
        self.straight_through && self.transmission > 0.0
    }

    /// The part of the light at a point of this base color and alpha that goes straight through, without [masks](Alpha::Mask):
    /// uncovered, or transmitted. It is the mean over the channels; [`Self::tint`] is what each of them has of it.
    ///
    /// ```text
    ///   through = 1 - α (1 - t m),    m = (r + g + b) / 3
    /// ```
    pub(crate) fn through(&self, [r, g, b, alpha]: [f32; 4]) -> f32 {
        if !self.straight_through {
            return 0.0;
        }
        let covered = if self.alpha == Alpha::Blend { alpha } else { 1.0 };
        1.0 - covered * (1.0 - self.transmission * (r + g + b) / 3.0)
    }

    /// The color of the light that goes straight through a point, relative to its mean [`Self::through`]: glass is
    /// tinted by its base color, the uncovered part is not.
    ///
    /// ```text
    ///   (1 - α (1 - t ρ)) / (1 - α (1 - t m))
    /// ```
    pub(crate) fn tint(&self, color: [f32; 4]) -> [f32; 3] {
        let [r, g, b, alpha] = color;
        let through = self.through(color);
        if (r == g && g == b) || through <= 0.0 {
            return [1.0; 3];
        }
        let covered = if self.alpha == Alpha::Blend { alpha } else { 1.0 };
        [r, g, b].map(|c| (1.0 - covered * (1.0 - self.transmission * c)) / through)
    }

    /// The color that a point reflects, given what is stopped there: of glass the part that is not transmitted,
    ///
    /// ```text
    ///   ρ (1 - t) / (1 - t m)
    /// ```
    pub(crate) fn reflected(&self, [r, g, b, alpha]: [f32; 4]) -> [f32; 4] {
        if !self.straight_through || self.transmission == 0.0 {
            return [r, g, b, alpha];
        }
        let stopped = 1.0 - self.transmission * (r + g + b) / 3.0;
        // Where nothing is stopped, nothing is reflected.
        let part = if stopped > 0.0 { (1.0 - self.transmission) / stopped } else { 0.0 };
        [r * part, g * part, b * part, alpha]
    }

    /// A Lambertian double-sided surface of one color.
    #[must_use]
    pub fn matte(name: &str, [r, g, b]: [f32; 3]) -> Self {
        Self { name: name.to_string(), base_color: [r, g, b, 1.0], ..Self::WHITE }
    }
}

impl Default for Material {
    fn default() -> Self {
        Self::WHITE
    }
}
