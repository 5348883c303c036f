//! Attributes of the vertices of a baked scene, and their layout in buffer views.

use std::io;
use std::ops::Range;

use lobe_scene::{GltfReader, Mesh};
use serde_json::{Value, json};

use crate::error::PrtError;
use crate::transfer::transfer_rows::TransferRows;

/// glTF allows vertices that share a buffer view to be at most this far apart.
const MOST_STRIDE: usize = 252;

const FLOAT: u32 = 5126;

/// One attribute of a vertex.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Attribute {
    pub(crate) name: String,
    /// VEC4 or SCALAR.
    pub(crate) kind: &'static str,
    /// The number that glTF gives the type of a component.
    pub(crate) component: u32,
    /// Whether whole numbers stand for fractions of their largest.
    pub(crate) normalized: bool,
    /// Its size in bytes, a multiple of four.
    pub(crate) bytes: usize,
}

/// The attributes of many vertices.
pub(crate) trait VertexData {
    fn vertices(&self) -> usize;

    fn attributes(&self) -> Vec<Attribute>;

    /// Adds the bytes of some attributes of some vertices, vertex by vertex.
    fn push_bytes(&self, vertices: Range<usize>, attributes: Range<usize>, bytes: &mut Vec<u8>) -> io::Result<()>;

    /// The members of `extras.lobe` that describe the data.
    fn about(&self) -> Value;

    /// The numbers that all vertices share.
    fn bases(&self) -> Option<&[f32]> {
        None
    }
}

/// Attributes that lie side by side in one buffer view.
pub(crate) struct AttributeGroup {
    pub(crate) attributes: Range<usize>,
    /// Bytes from one vertex to the next.
    pub(crate) stride: usize,
}

/// All attributes, as many of them in a buffer view as it takes.
pub(crate) fn attribute_groups(attributes: &[Attribute]) -> Vec<AttributeGroup> {
    let mut groups: Vec<AttributeGroup> = Vec::new();
    for (k, attribute) in attributes.iter().enumerate() {
        match groups.last_mut() {
            Some(group) if group.stride + attribute.bytes <= MOST_STRIDE => {
                group.attributes.end = k + 1;
                group.stride += attribute.bytes;
            }
            _ => groups.push(AttributeGroup { attributes: k..k + 1, stride: attribute.bytes }),
        }
    }
    groups
}

/// The number of VEC4 attributes that hold the n² coefficients of a channel.
pub(crate) fn attributes_per_channel(order: usize) -> usize {
    (order * order).div_ceil(4)
}

/// The prefix of the attributes of transfer, of the side from which corners run counter-clockwise.
pub(crate) const FRONT: &str = "_TRANSFER_";

/// The prefix of those of the other side.
pub(crate) const BACK: &str = "_TRANSFER_BACK_";

/// The prefix of those of the part without reflections.
pub(crate) const DIRECT: &str = "_TRANSFER_DIRECT_";

/// Transfer as it is, and the prefix of its attributes.
///
/// ```text
///   attribute k = c ⌈n²/4⌉ + j  holds  T_c,4j .. T_c,4j+3,  zeros from n² on
/// ```
pub(crate) struct PlainTransfer<'a>(pub(crate) &'a dyn TransferRows, pub(crate) &'static str);

impl VertexData for PlainTransfer<'_> {
    fn vertices(&self) -> usize {
        self.0.receivers()
    }

    fn attributes(&self) -> Vec<Attribute> {
        let attribute = |k| Attribute {
            name: format!("{}{k}", self.1),
            kind: "VEC4",
            component: FLOAT,
            normalized: false,
            bytes: 16,
        };
        (0..self.0.channels().count() * attributes_per_channel(self.0.order())).map(attribute).collect()
    }

    fn push_bytes(&self, vertices: Range<usize>, attributes: Range<usize>, bytes: &mut Vec<u8>) -> io::Result<()> {
        let (bands, per_channel) = (self.0.order() * self.0.order(), attributes_per_channel(self.0.order()));
        let mut rows = vec![0.0; vertices.len() * self.0.row_len()];
        self.0.read_rows(vertices.start, &mut rows)?;
        for row in rows.chunks_exact(self.0.row_len()) {
            for k in attributes.clone() {
                let (channel, first) = (k / per_channel, k % per_channel * 4);
                for i in first..first + 4 {
                    let value = if i < bands { row[channel * bands + i] } else { 0.0 };
                    bytes.extend(value.to_le_bytes());
                }
            }
        }
        Ok(())
    }

    fn about(&self) -> Value {
        json!({"quantity": "transfer", "order": self.0.order(), "channels": self.0.channels().count()})
    }
}

/// The values of an attribute at all vertices of a mesh, in the file called `name`.
pub(crate) fn read_column<const N: usize>(
    gltf: &GltfReader,
    mesh: &Mesh,
    attribute: &str,
    name: &str,
) -> Result<Vec<[f32; N]>, PrtError> {
    let Some(at) = mesh.source() else {
        unreachable!("every mesh of a glTF file comes from one of its primitives");
    };
    let vertices = mesh.positions().len();
    let place = format!("mesh {}, primitive {}", at.mesh, at.primitive);
    match gltf.vectors(at, attribute)? {
        Some(column) if column.len() == vertices => Ok(column),
        Some(column) => {
            let found = column.len();
            Err(PrtError::invalid(name, format!("{place}: expected {vertices} values of {attribute}, found {found}")))
        }
        None => Err(PrtError::invalid(
            name,
            format!("{place}: expected the attribute {attribute}, found none: another program left it out; bake again"),
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transfer::transfer::{Channels, Transfer};

    #[test]
    fn coefficients_stand_in_index_order_padded_with_zeros_channel_by_channel() {
        let transfer = Transfer::new(3, Channels::Rgb, (0..54).map(|i| i as f32).collect()).unwrap();
        let data = PlainTransfer(&transfer, FRONT);
        assert_eq!(data.attributes().len(), 9, "three attributes of four hold nine coefficients");
        let mut bytes = Vec::new();
        data.push_bytes(1..2, 2..9, &mut bytes).unwrap();
        let floats: Vec<f32> = bytes.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
        assert_eq!(floats[..8], [35.0, 0.0, 0.0, 0.0, 36.0, 37.0, 38.0, 39.0], "end of red, begin of green");
        assert_eq!(floats[24..], [53.0, 0.0, 0.0, 0.0], "end of blue");
    }

    #[test]
    fn no_view_has_vertices_more_than_252_bytes_apart() {
        for order in 1..=8 {
            let transfer = Transfer::new(order, Channels::Rgb, vec![]).unwrap();
            let attributes = PlainTransfer(&transfer, FRONT).attributes();
            let groups = attribute_groups(&attributes);
            let all: Vec<usize> = groups.iter().flat_map(|group| group.attributes.clone()).collect();
            assert_eq!(all, (0..attributes.len()).collect::<Vec<_>>(), "order {order}: each attribute once");
            for group in groups {
                assert_eq!(group.stride, 16 * group.attributes.len(), "order {order}");
                assert!(group.stride <= 252, "order {order}: {} bytes apart", group.stride);
            }
        }
    }
}
