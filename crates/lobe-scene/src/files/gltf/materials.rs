//! Materials and textures of a glTF file.

use std::collections::HashMap;

use gltf_json::material::AlphaMode;
use gltf_json::texture::{Info, MagFilter, WrappingMode};
use gltf_json::validation::Checked;
use serde::Deserialize as _;

use crate::error::SceneError;
use crate::files::gltf::accessor::view_bytes;
use crate::files::gltf::files::GltfFile;
use crate::files::gltf::uri::read_uri;
use crate::files::picture::decode;
use crate::files::source::{Source, emission_unused};
use crate::scene::material::{Alpha, Material, NormalMap, OcclusionMap, TextureUse};
use crate::scene::texture::{Texture, Wrap};

/// Reads all materials of the file, and of those that are used the textures of base colors and, if they are wanted, of normals.
pub(crate) fn read(
    file: &GltfFile,
    is_used: &[bool],
    reads_normal_maps: bool,
    source: &mut Source<'_>,
) -> Result<(Vec<Material>, Vec<Texture>), SceneError> {
    let mut materials = Vec::new();
    let mut textures = Textures { file, read: Vec::new(), places: HashMap::new() };
    for (index, material) in file.root.materials.iter().enumerate() {
        let pbr = &material.pbr_metallic_roughness;
        let name = material.name.clone().unwrap_or_else(|| index.to_string());
        let mut unit = |value, what| source.unit(value, &format!("material `{name}`: {what}"));
        let base_color = pbr.base_color_factor.0.map(|c| unit(c, "a base color factor"));
        let metallic = unit(pbr.metallic_factor.0, "a metallic factor");
        let roughness = unit(pbr.roughness_factor.0, "a roughness factor");
        let transmission = material.extensions.as_ref().and_then(|extensions| extensions.transmission.as_ref());
        let transmission = unit(transmission.map_or(0.0, |t| t.transmission_factor.0), "a transmission factor");
        let base_color_texture = match &pbr.base_color_texture {
            Some(info) if is_used[index] => Some(textures.use_of(info, &name, source)?),
            _ => None,
        };
        let normal_map = match &material.normal_texture {
            Some(found) if is_used[index] && reads_normal_maps => {
                Some(textures.normal_map(index, found.scale, &name, source)?)
            }
            _ => None,
        };
        let finish = match is_used[index] && source.options.finish {
            true => textures.finish_of(index, material, &name, source)?,
            false => Finish::default(),
        };
        let alpha = match material.alpha_mode {
            Checked::Valid(AlphaMode::Opaque) => Alpha::Opaque,
            Checked::Valid(AlphaMode::Mask) => Alpha::Mask(material.alpha_cutoff.map_or(0.5, |cutoff| cutoff.0)),
            Checked::Valid(AlphaMode::Blend) => Alpha::Blend,
            Checked::Invalid => {
                return Err(source.invalid(format!("material `{name}` has an alpha mode that glTF does not know")));
            }
        };
        if material.normal_texture.is_some() && !reads_normal_maps {
            source.note(format!("material `{name}` has a normal texture, which is not used"));
        }
        note_unused(material, &name, source);
        let volume = &file.json["materials"][index]["extensions"]["KHR_materials_volume"];
        if source.options.straight_through && !volume["attenuationDistance"].is_null() {
            let text = "has a volume, whose attenuation is not used: glass tints light at its surfaces alone";
            source.note(format!("material `{name}` {text}"));
        }
        materials.push(Material {
            base_color,
            base_color_texture,
            normal_map,
            alpha,
            double_sided: material.double_sided,
            metallic,
            metallic_texture: finish.metallic_roughness,
            roughness,
            roughness_texture: finish.metallic_roughness,
            occlusion_map: finish.occlusion,
            emissive: emission_of(file, index, material, source),
            emissive_texture: finish.emissive,
            transmission,
            straight_through: source.options.straight_through,
            name,
        });
    }
    Ok((materials, textures.read))
}

/// The emitted radiance of a material: its factor times the strength of `KHR_materials_emissive_strength`.
fn emission_of(file: &GltfFile, index: usize, material: &gltf_json::Material, source: &mut Source<'_>) -> [f32; 3] {
    let extension = &file.json["materials"][index]["extensions"]["KHR_materials_emissive_strength"];
    let strength = extension["emissiveStrength"].as_f64().unwrap_or(1.0) as f32;
    let is_usable = strength.is_finite() && strength >= 0.0;
    if !is_usable {
        source.note(format!("material {index} has an emissive strength of {strength}, which is not used"));
    }
    let strength = if is_usable { strength } else { 1.0 };
    material.emissive_factor.0.map(|c| if c.is_finite() { (c * strength).clamp(0.0, f32::MAX) } else { 0.0 })
}

fn note_unused(material: &gltf_json::Material, name: &str, source: &mut Source<'_>) {
    if !source.options.finish && material.emissive_factor.0 != [0.0; 3] {
        source.note(emission_unused(name));
    }
    if material.alpha_mode == Checked::Valid(AlphaMode::Blend) && !source.options.straight_through {
        source.note(format!("material `{name}` is blended, and taken as opaque"));
    }
    let extensions = material.extensions.as_ref();
    if let Some(transmission) = extensions.and_then(|extensions| extensions.transmission.as_ref()) {
        if !source.options.straight_through {
            source.note(format!("material `{name}` is glass, and taken as opaque"));
        } else if transmission.transmission_texture.is_some() {
            source.note(format!("material `{name}` has a transmission texture; only its factor is used"));
        }
    }
    if material.pbr_metallic_roughness.metallic_roughness_texture.is_some() && !source.options.finish {
        source
            .note(format!("material `{name}` has a metallic-roughness texture, which is not used: surfaces are matte"));
    }
}

/// The textures of a finish.
#[derive(Default)]
struct Finish {
    metallic_roughness: Option<TextureUse>,
    occlusion: Option<OcclusionMap>,
    emissive: Option<TextureUse>,
}

/// The textures read so far.
struct Textures<'a> {
    file: &'a GltfFile,
    read: Vec<Texture>,
    /// The index of the texture for an image of the file and a wrap mode.
    places: HashMap<(usize, [Wrap; 2]), usize>,
}

impl Textures<'_> {
    /// The textures of the finish of the material of this index.
    fn finish_of(
        &mut self,
        index: usize,
        material: &gltf_json::Material,
        name: &str,
        source: &mut Source<'_>,
    ) -> Result<Finish, SceneError> {
        let mut read = |info: &Option<Info>| info.as_ref().map(|info| self.use_of(info, name, source)).transpose();
        let metallic_roughness = read(&material.pbr_metallic_roughness.metallic_roughness_texture)?;
        let emissive = read(&material.emissive_texture)?;
        let occlusion = match &material.occlusion_texture {
            Some(found) => {
                let info = self.info_of(index, "occlusionTexture", "an occlusion texture", name, source)?;
                let strength = source.unit(found.strength.0, &format!("material `{name}`: a strength of occlusion"));
                Some(OcclusionMap { used: self.use_of(&info, name, source)?, strength })
            }
            None => None,
        };
        Ok(Finish { metallic_roughness, occlusion, emissive })
    }

    /// What a texture of the material of this index is as any other, with the extensions that its own type leaves out.
    fn info_of(
        &self,
        index: usize,
        key: &str,
        what: &str,
        material: &str,
        source: &Source<'_>,
    ) -> Result<Info, SceneError> {
        Info::deserialize(&self.file.json["materials"][index][key])
            .map_err(|error| source.invalid(format!("material `{material}`: expected {what}, found an error: {error}")))
    }

    /// The normal map of the material of this index.
    fn normal_map(
        &mut self,
        index: usize,
        scale: f32,
        material: &str,
        source: &mut Source<'_>,
    ) -> Result<NormalMap, SceneError> {
        let info = self.info_of(index, "normalTexture", "a normal texture", material, source)?;
        Ok(NormalMap { used: self.use_of(&info, material, source)?, scale })
    }

    fn use_of(&mut self, info: &Info, material: &str, source: &mut Source<'_>) -> Result<TextureUse, SceneError> {
        let transform = info.extensions.as_ref().and_then(|extensions| extensions.texture_transform.as_ref());
        let uv_set = transform.and_then(|transform| transform.tex_coord).unwrap_or(info.tex_coord) as usize;
        if uv_set > 1 {
            let message = format!("material `{material}` uses texture coordinates of set {uv_set}; Lobe reads 0 and 1");
            return Err(source.unsupported(message));
        }
        let uv_map = transform.map_or(TextureUse::UV_UNCHANGED, |transform| {
            // KHR_texture_transform: translation · rotation · scale, the rotation taking +v towards +u.
            let ([du, dv], [su, sv]) = (transform.offset.0, transform.scale.0);
            let (sin, cos) = transform.rotation.0.sin_cos();
            [[cos * su, sin * sv, du], [-sin * su, cos * sv, dv]]
        });
        let key @ (image, wrap) = self.image_and_wrap(info.index.value(), material, source)?;
        let root = &self.file.root;
        let sampler = root.textures[info.index.value()].sampler.and_then(|sampler| root.samplers.get(sampler));
        if sampler.is_some_and(|sampler| sampler.mag_filter == Some(Checked::Valid(MagFilter::Nearest))) {
            source.note("the filter NEAREST of textures is not used: colors are interpolated between texels");
        }
        let texture = match self.places.get(&key) {
            Some(&texture) => texture,
            None => {
                self.read.push(self.texture(image, wrap, source)?);
                self.places.insert(key, self.read.len() - 1);
                self.read.len() - 1
            }
        };
        Ok(TextureUse { texture, uv_set, uv_map })
    }

    /// The image of a texture, by its index, and its wrap modes.
    fn image_and_wrap(
        &self,
        index: usize,
        material: &str,
        source: &Source<'_>,
    ) -> Result<(usize, [Wrap; 2]), SceneError> {
        let root = &self.file.root;
        let missing = |what: &str, index: usize, count: usize| {
            source.invalid(format!("material `{material}` uses {what} {index}, but there are {count}"))
        };
        let texture = root.textures.get(index).ok_or_else(|| missing("texture", index, root.textures.len()))?;
        let Some(image) = texture.image() else {
            let message = format!("texture {index} has no picture: export the textures of the scene as PNG or JPEG");
            return Err(source.unsupported(message));
        };
        if image >= root.images.len() {
            return Err(missing("image", image, root.images.len()));
        }
        let wrap = match texture.sampler {
            None => [Wrap::Repeat; 2],
            Some(at) => {
                let count = root.samplers.len();
                let sampler = root.samplers.get(at).ok_or_else(|| missing("sampler", at, count))?;
                [wrap(sampler.wrap_s), wrap(sampler.wrap_t)]
            }
        };
        Ok((image, wrap))
    }

    fn texture(&self, index: usize, wrap: [Wrap; 2], source: &mut Source<'_>) -> Result<Texture, SceneError> {
        let image = &self.file.root.images[index];
        let bytes = match (&image.uri, image.buffer_view) {
            (Some(uri), _) => read_uri(uri, source)?,
            (None, Some(view)) => {
                view_bytes(self.file, view).map_err(|message| source.invalid(format!("image: {message}")))?.to_vec()
            }
            (None, None) => {
                let advice = "export the scene again with its pictures, or without that texture";
                return Err(source.invalid(format!("image {index} has neither a URI nor a buffer view: {advice}")));
            }
        };
        decode(&bytes, &format!("image {index}"), wrap, source)
    }
}

fn wrap(mode: Checked<WrappingMode>) -> Wrap {
    match mode {
        Checked::Valid(WrappingMode::ClampToEdge) => Wrap::Clamp,
        Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::Mirror,
        Checked::Valid(WrappingMode::Repeat) | Checked::Invalid => Wrap::Repeat,
    }
}
