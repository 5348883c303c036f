//! Wavefront OBJ reader, with the materials of MTL files.

use std::cell::RefCell;
use std::collections::HashMap;
use std::io::Cursor;

use tobj::LoadOptions;

use crate::files::gltf::materials;
use crate::files::source::Source;
use crate::scene::texture::linear_from_srgb8;
use crate::{Material, MeshParts, Scene, SceneError, Texture, TextureUse, Up, Wrap};

/// Reads one mesh for each object, group and material.
///
/// OBJ indexes positions, texture coordinates and normals separately. Each combination that a face uses becomes a
/// vertex, in the order of first use.
pub(crate) fn read(bytes: &[u8], source: &mut Source<'_>, up: Up) -> Result<Scene, SceneError> {
    let notes = RefCell::new(Vec::new());
    let options = LoadOptions { single_index: true, triangulate: true, ignore_points: true, ignore_lines: true };
    let load_mtl = |path: &std::path::Path| {
        let found = source.neighbor(&path.to_string_lossy()).map_err(|error| error.to_string());
        let read =
            found.and_then(|bytes| tobj::load_mtl_buf(&mut Cursor::new(bytes)).map_err(|error| error.to_string()));
        read.map_err(|error| {
            notes.borrow_mut().push(format!("materials are missing, their surfaces are white: {error}"));
            tobj::LoadError::OpenFileFailed
        })
    };
    let (models, materials) = tobj::load_obj_buf(&mut Cursor::new(bytes), &options, load_mtl)
        .map_err(|error| source.invalid(format!("expected an OBJ file, found an error: {error}")))?;
    notes.into_inner().into_iter().for_each(|note| source.note(note));
    let materials = materials.unwrap_or_default();
    let mut meshes = Vec::new();
    for model in models {
        source.count(model.mesh.positions.len() / 3, model.mesh.indices.len() / 3)?;
        let mut parts = mesh_parts(model, up, source)?;
        parts.material = parts.material.filter(|&index| index < materials.len());
        meshes.extend(source.mesh(parts)?);
    }
    if meshes.is_empty() {
        return Err(source.no_triangles());
    }
    let (materials, textures) = read_materials(&materials, source)?;
    Scene::new(meshes, materials, textures).map_err(|error| error.within(source.name))
}

fn mesh_parts(model: tobj::Model, up: Up, source: &mut Source<'_>) -> Result<MeshParts, SceneError> {
    let tobj::Model { mesh, name } = model;
    let count = mesh.positions.len() / 3;
    let triples = |values: &[f32]| values.chunks_exact(3).map(|v| [v[0], v[1], v[2]]).collect::<Vec<_>>();
    // If only some vertices have a texture coordinate or normal, the lists are too short.
    let mut complete = |what: &str, length: usize| {
        if length != 0 && length != count {
            source.note(format!("mesh `{name}` has {what} at some vertices only, which are not used"));
        }
        length == count
    };
    let has_uvs = complete("texture coordinates", mesh.texcoords.len() / 2);
    let has_normals = complete("normals", mesh.normals.len() / 3);
    let has_colors = complete("colors", mesh.vertex_color.len() / 3);
    // Programs write sRGB-encoded vertex colors.
    let linear = |c: f32| linear_from_srgb8((c.clamp(0.0, 1.0) * 255.0).round() as u8);
    Ok(MeshParts {
        positions: triples(&mesh.positions).into_iter().map(|p| up.to_world(p)).collect(),
        triangles: mesh.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
        normals: if has_normals { triples(&mesh.normals) } else { Vec::new() }
            .into_iter()
            .map(|n| up.to_world(n))
            .collect(),
        // In OBJ v points upwards.
        uvs: [
            if has_uvs { mesh.texcoords.chunks_exact(2).map(|t| [t[0], 1.0 - t[1]]).collect() } else { Vec::new() },
            Vec::new(),
        ],
        colors: if has_colors { triples(&mesh.vertex_color) } else { Vec::new() }
            .into_iter()
            .map(|c| [linear(c[0]), linear(c[1]), linear(c[2]), 1.0])
            .collect(),
        material: mesh.material_id,
        source: None,
        name,
    })
}

fn read_materials(
    materials: &[tobj::Material],
    source: &mut Source<'_>,
) -> Result<(Vec<Material>, Vec<Texture>), SceneError> {
    let (mut read, mut textures, mut places) = (Vec::new(), Vec::new(), HashMap::new());
    for material in materials {
        let name = &material.name;
        let diffuse = material.diffuse.unwrap_or([1.0; 3]);
        let mut result = Material::matte(name, diffuse.map(|c| source.unit(c, &format!("material `{name}`: Kd"))));
        if let Some(file) = &material.diffuse_texture {
            let texture = match places.get(file) {
                Some(&texture) => texture,
                None => {
                    let bytes = source.neighbor(&file.replace('\\', "/"))?;
                    textures.push(materials::decode(&bytes, file, [Wrap::Repeat; 2], source)?);
                    places.insert(file.clone(), textures.len() - 1);
                    textures.len() - 1
                }
            };
            result.base_color_texture = Some(TextureUse { texture, uv_set: 0, uv_map: TextureUse::UV_UNCHANGED });
        }
        if material.dissolve.is_some_and(|dissolve| dissolve < 1.0) || material.dissolve_texture.is_some() {
            source.note(format!("material `{name}` is transparent, and taken as opaque"));
        }
        if let Some(emissive) = material.emissive.filter(|emissive| *emissive != [0.0; 3]) {
            source.note(format!("material `{name}` is emissive, which is not used: light comes from the environment"));
            result.emissive = emissive;
        }
        read.push(result);
    }
    Ok((read, textures))
}
