//! The members of a glTF file that a scene consists of. Cameras are not even looked at; animations and skins are read where
//! they are used.

use std::collections::BTreeMap;

use gltf_json::{Accessor, Buffer, Image, Material, Mesh, buffer, texture::Sampler};
use serde::Deserialize;
use serde_json::Value;

use crate::error::SceneError;
use crate::files::source::Source;

/// The members of a glTF file that Lobe uses. Only their shape has been checked.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
#[derive(Default)]
pub(crate) struct Root {
    pub(crate) accessors: Vec<Accessor>,
    pub(crate) buffers: Vec<Buffer>,
    pub(crate) buffer_views: Vec<buffer::View>,
    pub(crate) extensions_used: Vec<String>,
    pub(crate) images: Vec<Image>,
    pub(crate) materials: Vec<Material>,
    pub(crate) meshes: Vec<Mesh>,
    pub(crate) nodes: Vec<GltfNode>,
    pub(crate) samplers: Vec<Sampler>,
    pub(crate) scene: Option<usize>,
    pub(crate) scenes: Vec<GltfScene>,
    pub(crate) textures: Vec<GltfTexture>,
}

/// A node. The numbers of its transform are those of the file: far from the origin of the world, `f32` is too coarse for
/// them.
#[derive(Deserialize)]
pub(crate) struct GltfNode {
    extensions: Option<NodeExtensions>,
    pub(crate) children: Option<Vec<usize>>,
    pub(crate) mesh: Option<usize>,
    /// By columns.
    pub(crate) matrix: Option<[f64; 16]>,
    /// The quaternion x, y, z, w.
    pub(crate) rotation: Option<[f64; 4]>,
    pub(crate) scale: Option<[f64; 3]>,
    pub(crate) translation: Option<[f64; 3]>,
}

/// The extensions of a node that are read here.
#[derive(Deserialize)]
struct NodeExtensions {
    #[serde(rename = "KHR_node_visibility")]
    visibility: Option<Visibility>,
}

/// `KHR_node_visibility`: a node that is not visible hides itself and all below it.
#[derive(Deserialize)]
struct Visibility {
    visible: Option<bool>,
}

impl GltfNode {
    /// Whether the file shows the node, if it shows its parent.
    pub(crate) fn is_visible(&self) -> bool {
        let visibility = self.extensions.as_ref().and_then(|extensions| extensions.visibility.as_ref());
        visibility.and_then(|visibility| visibility.visible).unwrap_or(true)
    }
}

/// A scene; one without nodes is empty.
#[derive(Deserialize)]
pub(crate) struct GltfScene {
    #[serde(default)]
    pub(crate) nodes: Vec<usize>,
}

/// A texture, whose image may stand in an extension instead.
#[derive(Deserialize)]
pub(crate) struct GltfTexture {
    pub(crate) sampler: Option<usize>,
    pub(crate) source: Option<usize>,
    #[serde(default)]
    extensions: BTreeMap<String, Value>,
}

/// Extensions that store an image of another kind, in the order in which they are preferred.
const IMAGE_EXTENSIONS: [&str; 3] = ["EXT_texture_webp", "KHR_texture_basisu", "EXT_texture_avif"];

impl GltfTexture {
    /// The index of the image: the PNG or JPEG where there is one.
    pub(crate) fn image(&self) -> Option<usize> {
        let of_extension =
            |name: &&str| self.extensions.get(*name)?.get("source")?.as_u64().map(|image| image as usize);
        self.source.or_else(|| IMAGE_EXTENSIONS.iter().find_map(of_extension))
    }
}

impl Root {
    pub(crate) fn of(json: &Value, source: &Source<'_>) -> Result<Self, SceneError> {
        serde_path_to_error::deserialize(json).map_err(|error| {
            let (place, error) = (error.path().to_string(), error.into_inner());
            source.invalid(format!("expected glTF, found an error at {place}: {error}"))
        })
    }
}
