//! Compressed transfer at the vertices of a baked scene.

use std::io;
use std::ops::Range;

use lobe_scene::{GltfReader, Mesh};
use serde_json::{Value, json};

use crate::compression::compressed_table::{CompressedTable, TableWeights};
use crate::compression::compressed_transfer::CompressedTransfer;
use crate::error::PrtError;
use crate::files::baked_extras::{bases_of, lobe_of};
use crate::files::baked_layout::{Attribute, VertexData, read_column};
use crate::transfer::transfer::Channels;

/// The number that glTF gives a type of components, by the name that `extras.lobe` gives it.
const WEIGHT_TYPES: [(&str, u32, usize); 3] = [("f32", 5126, 4), ("u16", 5123, 2), ("u8", 5121, 1)];
const UNSIGNED_SHORT: u32 = 5123;

/// Compressed transfer as attributes, see [`crate::BakedGlb::write_compressed`].
pub(crate) struct Compressed<'a>(pub(crate) &'a CompressedTransfer);

impl Compressed<'_> {
    fn weight_type(&self) -> (&'static str, u32, usize) {
        WEIGHT_TYPES[match self.0.table().weights() {
            TableWeights::F32(_) => 0,
            TableWeights::U16(_) => 1,
            TableWeights::U8(_) => 2,
        }]
    }

    /// The cluster, and three zeros.
    fn push_cluster(&self, receiver: usize, bytes: &mut Vec<u8>) {
        let cluster = self.0.table().clusters()[receiver];
        match self.0.table().weights() {
            TableWeights::F32(_) => {
                bytes.extend(f32::from(cluster).to_le_bytes());
                bytes.extend([0; 12]);
            }
            _ => {
                bytes.extend(cluster.to_le_bytes());
                bytes.extend([0; 6]);
            }
        }
    }

    fn push_weight(&self, receiver: usize, j: usize, bytes: &mut Vec<u8>) {
        let table = self.0.table();
        let at = (j < table.components()).then(|| receiver * table.components() + j);
        match table.weights() {
            TableWeights::F32(w) => bytes.extend(at.map_or(0.0, |at| w[at]).to_le_bytes()),
            TableWeights::U16(w) => bytes.extend(at.map_or(0, |at| w[at]).to_le_bytes()),
            TableWeights::U8(w) => bytes.push(at.map_or(0, |at| w[at])),
        }
    }
}

impl VertexData for Compressed<'_> {
    fn vertices(&self) -> usize {
        self.0.receivers()
    }

    fn attributes(&self) -> Vec<Attribute> {
        let (_, component, bytes) = self.weight_type();
        // Importers of Blender take attributes of one kind only, and keep floats only.
        let (component_of_cluster, bytes_of_cluster) = if bytes == 4 { (component, 16) } else { (UNSIGNED_SHORT, 8) };
        let cluster = Attribute {
            name: "_CLUSTER".to_string(),
            kind: "VEC4",
            component: component_of_cluster,
            normalized: false,
            bytes: bytes_of_cluster,
        };
        let weights = (0..self.0.table().components().div_ceil(4)).map(|j| Attribute {
            name: format!("_WEIGHTS_{j}"),
            kind: "VEC4",
            component,
            normalized: bytes < 4,
            bytes: 4 * bytes,
        });
        std::iter::once(cluster).chain(weights).collect()
    }

    fn push_bytes(&self, vertices: Range<usize>, attributes: Range<usize>, bytes: &mut Vec<u8>) -> io::Result<()> {
        for receiver in vertices {
            for attribute in attributes.clone() {
                match attribute.checked_sub(1) {
                    None => self.push_cluster(receiver, bytes),
                    Some(k) => (4 * k..4 * k + 4).for_each(|j| self.push_weight(receiver, j, bytes)),
                }
            }
        }
        Ok(())
    }

    fn about(&self) -> Value {
        let (weights, ..) = self.weight_type();
        let table = self.0.table();
        json!({
            "quantity": "transfer", "order": self.0.order(), "channels": self.0.channels().count(),
            "compression": {
                "clusters": table.cluster_count(), "components": table.components(), "weights": weights,
            },
        })
    }

    fn bases(&self) -> Option<&[f32]> {
        Some(self.0.table().bases())
    }
}

/// How far a fraction of a whole number of 16 bits in `f32` is from it at most when it is multiplied again.
const OFF_WHOLE: f32 = 0.01;

/// The number of a cluster, or a whole number of 16 bits that was a fraction.
fn whole(number: f32, name: &str) -> Result<f32, PrtError> {
    let whole = number.round();
    if (number - whole).abs() <= OFF_WHOLE && (0.0..=65535.0).contains(&whole) {
        return Ok(whole);
    }
    Err(PrtError::invalid(
        name,
        format!("expected whole clusters and weights of the type that it says, found {number}"),
    ))
}

/// Fractions of a whole number, as whole numbers.
fn wholes(fractions: &[f32], most: f32, name: &str) -> Result<impl Iterator<Item = f32>, PrtError> {
    let wholes = fractions.iter().map(|w| whole(w * most, name)).collect::<Result<Vec<f32>, _>>()?;
    match wholes.iter().find(|w| **w > most) {
        Some(w) => Err(PrtError::invalid(name, format!("expected weights up to {most}, found {w}"))),
        None => Ok(wholes.into_iter()),
    }
}

/// Reads what [`Compressed`] wrote of all meshes.
pub(crate) fn read_compressed(
    meshes: &[Mesh],
    gltf: &GltfReader,
    (order, channels): (usize, Channels),
    name: &str,
) -> Result<CompressedTransfer, PrtError> {
    let said = &lobe_of(gltf)["compression"];
    let wrong = || PrtError::invalid(name, format!("expected components and weights of f32, u16 or u8, found {said}"));
    let components = said["components"].as_u64().and_then(|n| usize::try_from(n).ok()).ok_or_else(wrong)?;
    let (mut clusters, mut weights) = (Vec::new(), Vec::new());
    for mesh in meshes {
        if said["weights"] != "f32" && gltf.is_normalized(mesh, "_CLUSTER") {
            let message = "has clusters as colors: another program, such as Blender, keeps floats alone; \
                           compress with --weights 32";
            return Err(PrtError::invalid(name, message));
        }
        let count = mesh.positions().len();
        // Files of earlier bakes have the cluster alone.
        for [k, ..] in read_column::<4>(gltf, mesh, "_CLUSTER", name)? {
            clusters.push(whole(k, name)? as u16);
        }
        let columns: Vec<Vec<[f32; 4]>> = (0..components.div_ceil(4))
            .map(|j| read_column(gltf, mesh, &format!("_WEIGHTS_{j}"), name))
            .collect::<Result<_, _>>()?;
        for vertex in 0..count {
            weights.extend(columns.iter().flat_map(|column| column[vertex]).take(components));
        }
    }
    // A fraction of u16 or u8 in f32 is the whole number again when it is multiplied and rounded.
    let weights = match said["weights"].as_str() {
        Some("f32") => TableWeights::F32(weights),
        Some("u16") => TableWeights::U16(wholes(&weights, 65535.0, name)?.map(|w| w as u16).collect()),
        Some("u8") => TableWeights::U8(wholes(&weights, 255.0, name)?.map(|w| w as u8).collect()),
        _ => return Err(wrong()),
    };
    let width = order * order * channels.count();
    let table = CompressedTable::new(width, components, clusters, weights, bases_of(gltf)?);
    let table = table.map_err(|error| error.within(name))?;
    // The numbers of the bases are those of some clusters for other components too.
    let clusters = table.cluster_count();
    if said["clusters"].as_u64() != Some(clusters as u64) {
        let found = &said["clusters"];
        let message =
            format!("`bases` hold {clusters} clusters of {components} components, `compression` says {found}");
        return Err(PrtError::invalid(name, message));
    }
    CompressedTransfer::from_table(order, channels, table).map_err(|error| error.within(name))
}
