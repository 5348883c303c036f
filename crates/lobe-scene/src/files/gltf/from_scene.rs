//! glTF from a scene.

use serde_json::{Map, Value, json};

use crate::files::gltf::document::GltfDocument;
use crate::files::gltf::files::push;
use crate::scene::material::{Alpha, Material, TextureUse};
use crate::scene::mesh::Mesh;
use crate::scene::scene::Scene;
use crate::scene::texture::Wrap;
use crate::scene::up::y_up_from_z_up;

const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

impl GltfDocument {
    /// The scene as glTF: a node and a mesh of one primitive for each of its meshes, in their order, y up.
    ///
    /// Read again, it has the same triangles, vertices, colors, materials and textures at the same place: an origin of
    /// the scene that `f32` cannot hold is split between two nodes, for programs that read `f32`. The tangents of a
    /// mesh are left out, so that readers compute them, if they differ between triangles at a vertex or a corner has none. Base colors and emission
    /// outside the range of glTF, 0 to 1, are clamped. Anything else in the file of the scene is lost.
    #[must_use]
    pub fn of_scene(scene: &Scene) -> Self {
        let count = scene.meshes().len();
        let json = json!({
            "asset": {"version": "2.0", "generator": concat!("Lobe ", env!("CARGO_PKG_VERSION"))},
            "scene": 0,
            "scenes": [{"nodes": (0..count).collect::<Vec<_>>()}],
        });
        // Positions, normals, tangents, two pairs of texture coordinates, a color and the triangles; pictures are few.
        let bytes_of = |mesh: &Mesh| {
            let (vertices, has_tangents) = (mesh.positions().len(), !mesh.tangents().is_empty());
            let pairs = [mesh.uvs(0), mesh.uvs(1), mesh.third_uvs()].map(<[_]>::len).iter().sum::<usize>();
            let in_fours = mesh.colors().len() + if has_tangents { vertices } else { 0 };
            24 * vertices + 8 * pairs + 16 * in_fours + 12 * mesh.triangles().len()
        };
        let mut document = Self { json, bytes: Vec::with_capacity(scene.meshes().iter().map(bytes_of).sum()) };
        // Both are exact: what the numbers of f32 leave of an f64 has no more digits than it. The node above holds what
        // is left, so that the nodes of meshes are at the origin: readers take the first node near the scene for it.
        let origin = y_up_from_z_up(scene.origin());
        let place = origin.map(|c| f64::from(c as f32));
        let rest = [0, 1, 2].map(|k| origin[k] - place[k]);
        for mesh in scene.meshes() {
            document.push_mesh(mesh, scene.materials().len(), place);
        }
        if rest != [0.0; 3] {
            let children: Vec<usize> = (0..count).collect();
            push(&mut document.json, "nodes", json!({"children": children, "translation": rest}));
            document.json["scenes"][0]["nodes"] = json!([count]);
        }
        for material in scene.materials() {
            document.push_material(material);
        }
        if scene.meshes().iter().any(|mesh| mesh.material().is_none()) {
            // Lobe's material of a mesh without one; glTF's default is a single-sided metal.
            document.push_material(&Material { name: "white".to_string(), ..Material::WHITE });
        }
        for texture in scene.textures() {
            let view = document.push_view(&texture.to_png());
            let source = push(&mut document.json, "images", json!({"bufferView": view, "mimeType": "image/png"}));
            let [s, t] = texture.wrap().map(wrap_mode);
            let sampler = push(&mut document.json, "samplers", json!({"wrapS": s, "wrapT": t}));
            push(&mut document.json, "textures", json!({"source": source, "sampler": sampler}));
        }
        document.declare_buffer();
        document
    }

    fn push_mesh(&mut self, mesh: &Mesh, white: usize, place: [f64; 3]) {
        let mut attributes = Map::new();
        let y_up = |v: &[[f32; 3]]| v.iter().map(|&v| y_up_from_z_up(v)).collect::<Vec<_>>();
        let positions = y_up(mesh.positions());
        let accessor = self.push_vectors("VEC3", &positions);
        let extreme = |pick: fn(f32, f32) -> f32| {
            positions.iter().copied().reduce(|a, b| std::array::from_fn(|k| pick(a[k], b[k])))
        };
        self.json["accessors"][accessor]["min"] = json!(extreme(f32::min));
        self.json["accessors"][accessor]["max"] = json!(extreme(f32::max));
        attributes.insert("POSITION".to_string(), json!(accessor));
        attributes.insert("NORMAL".to_string(), json!(self.push_vectors("VEC3", &y_up(mesh.normals()))));
        if let Some(tangents) = vertex_tangents(mesh) {
            attributes.insert("TANGENT".to_string(), json!(self.push_vectors("VEC4", &tangents)));
        }
        for (set, uvs) in [mesh.uvs(0), mesh.uvs(1), mesh.third_uvs()].into_iter().enumerate() {
            if !uvs.is_empty() {
                attributes.insert(format!("TEXCOORD_{set}"), json!(self.push_vectors("VEC2", uvs)));
            }
        }
        if !mesh.colors().is_empty() {
            attributes.insert("COLOR_0".to_string(), json!(self.push_vectors("VEC4", mesh.colors())));
        }
        let indices = mesh.triangles().as_flattened();
        let bytes: Vec<u8> = indices.iter().flat_map(|i| i.to_le_bytes()).collect();
        let indices = self.push_accessor(&bytes, ELEMENT_ARRAY_BUFFER, UNSIGNED_INT, "SCALAR", indices.len());
        let material = mesh.material().unwrap_or(white);
        let primitive = json!({"attributes": attributes, "indices": indices, "material": material});
        let name = mesh.name();
        let index = push(&mut self.json, "meshes", json!({"name": name, "primitives": [primitive]}));
        let mut node = json!({"name": name, "mesh": index});
        if place != [0.0; 3] {
            node["translation"] = json!(place);
        }
        push(&mut self.json, "nodes", node);
    }

    fn push_vectors<const N: usize>(&mut self, kind: &str, values: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = values.as_flattened().iter().flat_map(|c| c.to_le_bytes()).collect();
        self.push_accessor(&bytes, ARRAY_BUFFER, FLOAT, kind, values.len())
    }

    fn push_accessor(&mut self, bytes: &[u8], target: u32, component: u32, kind: &str, count: usize) -> usize {
        let view = self.push_view(bytes);
        self.json["bufferViews"][view]["target"] = json!(target);
        let accessor = json!({"bufferView": view, "componentType": component, "count": count, "type": kind});
        push(&mut self.json, "accessors", accessor)
    }

    fn push_material(&mut self, material: &Material) {
        let clamped = |c: f32| c.clamp(0.0, 1.0);
        let mut pbr = json!({
            "baseColorFactor": material.base_color.map(clamped),
            "metallicFactor": clamped(material.metallic),
            "roughnessFactor": clamped(material.roughness),
        });
        if let Some(used) = material.base_color_texture {
            pbr["baseColorTexture"] = self.texture_info(used);
        }
        // One texture holds both.
        if let Some(used) =
            material.metallic_texture.filter(|_| material.metallic_texture == material.roughness_texture)
        {
            pbr["metallicRoughnessTexture"] = self.texture_info(used);
        }
        let mut json = json!({
            "name": material.name,
            "pbrMetallicRoughness": pbr,
            "doubleSided": material.double_sided,
            "emissiveFactor": material.emissive.map(clamped),
        });
        if let Some(map) = material.normal_map {
            json["normalTexture"] = self.texture_info(map.used);
            json["normalTexture"]["scale"] = json!(map.scale);
        }
        if let Some(map) = material.occlusion_map {
            json["occlusionTexture"] = self.texture_info(map.used);
            json["occlusionTexture"]["strength"] = json!(map.strength);
        }
        if let Some(used) = material.emissive_texture {
            json["emissiveTexture"] = self.texture_info(used);
        }
        // Factors end at 1; the strength carries what is above.
        let strength = material.emissive.into_iter().fold(1.0_f32, f32::max);
        if strength > 1.0 {
            json["emissiveFactor"] = json!(material.emissive.map(|c| clamped(c / strength)));
            json["extensions"]["KHR_materials_emissive_strength"] = json!({"emissiveStrength": strength});
            self.use_extension("KHR_materials_emissive_strength");
        }
        match material.alpha {
            Alpha::Opaque => {}
            Alpha::Mask(cutoff) => {
                json["alphaMode"] = json!("MASK");
                json["alphaCutoff"] = json!(cutoff.max(0.0));
            }
            Alpha::Blend => json["alphaMode"] = json!("BLEND"),
        }
        if material.transmission > 0.0 {
            let transmission = json!({"transmissionFactor": clamped(material.transmission)});
            json["extensions"]["KHR_materials_transmission"] = transmission;
            self.use_extension("KHR_materials_transmission");
        }
        push(&mut self.json, "materials", json);
    }

    /// `KHR_texture_transform` is translation · rotation · scale: the first column of the map is the rotated scale
    /// along u.
    fn texture_info(&mut self, used: TextureUse) -> Value {
        let mut info = json!({"index": used.texture, "texCoord": used.uv_set});
        if used.uv_map == TextureUse::UV_UNCHANGED {
            return info;
        }
        let [[a, b, du], [c, d, dv]] = used.uv_map;
        let is_turned = b != 0.0 || c != 0.0;
        let (rotation, su) = if is_turned { ((-c).atan2(a), a.hypot(c)) } else { (0.0, a) };
        let (sin, cos) = rotation.sin_cos();
        let sv = if is_turned { b * sin + d * cos } else { d };
        let transform = json!({"offset": [du, dv], "rotation": rotation, "scale": [su, sv]});
        info["extensions"] = json!({"KHR_texture_transform": transform});
        self.use_extension("KHR_texture_transform");
        info
    }

    /// Names an extension among those that the file uses.
    fn use_extension(&mut self, name: &str) {
        let is_named = self.json["extensionsUsed"].as_array().is_some_and(|names| names.iter().any(|n| n == name));
        if !is_named {
            push(&mut self.json, "extensionsUsed", json!(name));
        }
    }
}

/// The tangent of each vertex, y up; none if triangles at a vertex have several, or one has none.
fn vertex_tangents(mesh: &Mesh) -> Option<Vec<[f32; 4]>> {
    let mut found = vec![None; mesh.positions().len()];
    for (&i, tangent) in mesh.triangles().as_flattened().iter().zip(mesh.tangents().as_flattened()) {
        let is_other = *found[i as usize].get_or_insert(*tangent) != *tangent;
        if is_other || tangent[..3] == [0.0; 3] {
            return None;
        }
    }
    let y_up = |tangent: Option<[f32; 4]>| {
        // A vertex that no triangle has may have any.
        let [x, y, z, w] = tangent.unwrap_or([1.0, 0.0, 0.0, 1.0]);
        let [x, y, z] = y_up_from_z_up([x, y, z]);
        [x, y, z, w]
    };
    (!mesh.tangents().is_empty()).then(|| found.into_iter().map(y_up).collect())
}

fn wrap_mode(wrap: Wrap) -> u32 {
    match wrap {
        Wrap::Repeat => 10497,
        Wrap::Mirror => 33648,
        Wrap::Clamp => 33071,
    }
}
