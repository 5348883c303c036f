//! `KHR_draco_mesh_compression`: meshes stored by Draco, made plain.

use std::panic::{AssertUnwindSafe, catch_unwind};

use draco_core::decode_limits::DecodeLimits;
use draco_core::decoder_buffer::DecoderBuffer;
use draco_core::draco_types::DataType;
use draco_core::geometry_attribute::PointAttribute;
use draco_core::geometry_indices::PointIndex;
use draco_core::mesh::Mesh;
use draco_core::mesh_decoder::MeshDecoder;
use gltf_json::Index;
use serde_json::{Value, json};

use crate::error::SceneError;
use crate::files::gltf::accessor::view_bytes;
use crate::files::gltf::files::{GltfFile, forget_extension, take_extension};
use crate::files::source::Source;

const NAME: &str = "KHR_draco_mesh_compression";

/// Gives the accessors of compressed primitives the bytes that Draco holds. A primitive that is stored plain as well stays
/// so: its vertices may be in another order than Draco's.
pub(crate) fn decode(file: &mut GltfFile, source: &mut Source<'_>) -> Result<(), SceneError> {
    let mut was_there = false;
    for mesh in 0..file.root.meshes.len() {
        for primitive in 0..file.root.meshes[mesh].primitives.len() {
            let json = &mut file.json["meshes"][mesh]["primitives"][primitive];
            let Some(compressed) = take_extension(json, NAME) else { continue };
            was_there = true;
            let json = json.clone();
            let (before, limits) = (file.buffers.len(), limits_of(source));
            let is_decoded = decode_primitive(file, &json, &compressed, limits).map_err(|message| {
                source.invalid(format!("mesh {mesh}, primitive {primitive}: Draco compression: {message}"))
            })?;
            // What Draco holds is a list of triangles, whatever the primitive says.
            if is_decoded && let Some(mode) = file.json["meshes"][mesh]["primitives"][primitive].get_mut("mode") {
                *mode = json!(4);
            }
            source.count_bytes(file.buffers[before..].iter().map(|bytes| bytes.len() as u64).sum())?;
        }
    }
    if was_there {
        forget_extension(&mut file.json, NAME);
        file.update(source)?;
    }
    Ok(())
}

/// Whether the primitive was decoded: one that is stored plain as well is not.
fn decode_primitive(
    file: &mut GltfFile,
    primitive: &Value,
    compressed: &Value,
    limits: DecodeLimits,
) -> Result<bool, String> {
    let accessor_of = |index: &Value| index.as_u64().map(|index| index as usize);
    let indices = accessor_of(&primitive["indices"]).ok_or("expected indices, found none")?;
    let accessors = &file.root.accessors;
    if accessors.get(indices).is_some_and(|accessor| accessor.buffer_view.is_some()) {
        return Ok(false);
    }
    let view = compressed["bufferView"].as_u64().and_then(|view| u32::try_from(view).ok());
    let view = Index::new(view.ok_or("expected a buffer view, found none")?);
    let mesh = mesh_of(view_bytes(file, view)?, limits)?;
    let corners: Vec<u8> = mesh.faces().iter().flatten().flat_map(|corner| corner.0.to_le_bytes()).collect();
    set_accessor(file, indices, (3 * mesh.num_faces(), 4), 5125, &corners)?;
    for (name, id) in compressed["attributes"].as_object().into_iter().flatten() {
        let Some(accessor) = accessor_of(&primitive["attributes"][name]) else { continue };
        let attribute = id.as_u64().and_then(|id| mesh.attribute_by_unique_id(u32::try_from(id).ok()?));
        let attribute = attribute.ok_or_else(|| format!("it has no {name}"))?;
        let component = accessor_of(&file.json["accessors"][accessor]["componentType"]).unwrap_or(0);
        let (size, bytes) = values_of(attribute, mesh.num_points(), component)
            .ok_or_else(|| format!("{name} is not of the type that its accessor says"))?;
        set_accessor(file, accessor, (mesh.num_points(), size), component, &bytes)?;
    }
    Ok(true)
}

/// The limits of decoding a mesh.
fn limits_of(source: &Source<'_>) -> DecodeLimits {
    let limit = source.limit() as u64;
    // Every point has up to sixteen attributes of sixteen bytes.
    let bytes = limit.saturating_mul(256).min(source.bytes_left());
    DecodeLimits::permissive().with_max_faces(limit).with_max_points(limit).with_max_decoded_bytes(bytes)
}

fn mesh_of(bytes: &[u8], limits: DecodeLimits) -> Result<Mesh, String> {
    let decoded = catch_unwind(AssertUnwindSafe(|| {
        let mut mesh = Mesh::new();
        MeshDecoder::new().decode(&mut DecoderBuffer::new(bytes).with_limits(limits), &mut mesh).map(|_| mesh)
    }));
    match decoded {
        Ok(Ok(mesh)) => Ok(mesh),
        Ok(Err(error)) => Err(format!("expected Draco's bytes, found an error: {error}").replace('\n', " ")),
        Err(_) => Err("expected Draco's bytes, found none".to_owned()),
    }
}

/// Gives an accessor `count` elements of `size` bytes, of this type of component. Its bounds become theirs: those of the file are
/// often of what was compressed, with loss.
fn set_accessor(
    file: &mut GltfFile,
    accessor: usize,
    (count, size): (usize, usize),
    component: usize,
    bytes: &[u8],
) -> Result<(), String> {
    let view = file.push_elements(bytes, size);
    let Some(Value::Object(accessor)) = file.json["accessors"].get_mut(accessor) else {
        return Err(format!("uses accessor {accessor}, which is not there"));
    };
    let said = accessor.get("count").and_then(Value::as_u64).unwrap_or(0);
    if said != count as u64 {
        return Err(format!("holds {count} elements where an accessor says {said}"));
    }
    accessor.remove("byteOffset");
    accessor.insert("bufferView".to_owned(), json!(view));
    accessor.insert("componentType".to_owned(), json!(component));
    for (name, bound) in [("min", f64::min as fn(f64, f64) -> f64), ("max", f64::max)] {
        if accessor.contains_key(name) {
            accessor.insert(name.to_owned(), json!(bounds(bytes, size, component, bound)));
        }
    }
    Ok(())
}

/// The least or the largest number of each component; none of no elements.
fn bounds(bytes: &[u8], size: usize, component: usize, bound: fn(f64, f64) -> f64) -> Vec<f64> {
    let numbers = |element: &[u8]| -> Vec<f64> {
        match component {
            5120 => element.iter().map(|b| f64::from(b.cast_signed())).collect(),
            5121 => element.iter().map(|b| f64::from(*b)).collect(),
            5122 => element.as_chunks().0.iter().map(|b| f64::from(i16::from_le_bytes(*b))).collect(),
            5123 => element.as_chunks().0.iter().map(|b| f64::from(u16::from_le_bytes(*b))).collect(),
            5125 => element.as_chunks().0.iter().map(|b| f64::from(u32::from_le_bytes(*b))).collect(),
            _ => element.as_chunks().0.iter().map(|b| f64::from(f32::from_le_bytes(*b))).collect(),
        }
    };
    let elements = bytes.chunks_exact(size.max(1)).map(numbers);
    elements.reduce(|all, next| all.iter().zip(&next).map(|(a, b)| bound(*a, *b)).collect()).unwrap_or_default()
}

/// The values of an attribute for all points, as a component type of glTF; with them the bytes of each.
fn values_of(attribute: &PointAttribute, points: usize, component: usize) -> Option<(usize, Vec<u8>)> {
    let (components, stride) =
        (usize::from(attribute.num_components()), usize::try_from(attribute.byte_stride()).ok()?);
    let width = attribute.data_type().byte_length();
    let data = attribute.buffer().data();
    let mut bytes = Vec::new();
    for point in 0..points as u32 {
        let value = (attribute.mapped_index(PointIndex(point)).0 as usize).checked_mul(stride)?;
        for k in 0..components {
            push_value(data.get(value + k * width..)?.get(..width)?, attribute.data_type(), component, &mut bytes)?;
        }
    }
    Some((bytes.len() / points.max(1), bytes))
}

/// Adds a number as a component of an accessor: whole ones in as many bytes as that has, if they fit.
fn push_value(value: &[u8], kind: DataType, component: usize, out: &mut Vec<u8>) -> Option<()> {
    if matches!(kind, DataType::Float64 | DataType::Bool | DataType::Invalid) {
        return None;
    }
    if kind == DataType::Float32 {
        out.extend_from_slice(value);
        return (component == 5126).then_some(());
    }
    let sign = if matches!(kind, DataType::Int8 | DataType::Int16 | DataType::Int32) && value.last()? & 0x80 != 0 {
        255
    } else {
        0
    };
    let mut wide = [sign; 8];
    wide.get_mut(..value.len())?.copy_from_slice(value);
    let value = i64::from_le_bytes(wide);
    match component {
        5120 => out.extend(i8::try_from(value).ok()?.to_le_bytes()),
        5121 => out.extend(u8::try_from(value).ok()?.to_le_bytes()),
        5122 => out.extend(i16::try_from(value).ok()?.to_le_bytes()),
        5123 => out.extend(u16::try_from(value).ok()?.to_le_bytes()),
        5125 => out.extend(u32::try_from(value).ok()?.to_le_bytes()),
        _ => return None,
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_are_those_of_each_component() {
        let floats: Vec<u8> = [1.0_f32, -2.0, 3.0, -1.0, 5.0, 3.5].into_iter().flat_map(f32::to_le_bytes).collect();
        assert_eq!(bounds(&floats, 12, 5126, f64::min), [-1.0, -2.0, 3.0], "least");
        assert_eq!(bounds(&floats, 12, 5126, f64::max), [1.0, 5.0, 3.5], "largest");
        assert_eq!(bounds(&[255, 1, 2, 127], 2, 5120, f64::min), [-1.0, 1.0], "signed bytes");
        assert_eq!(bounds(&[255, 1, 2, 0], 2, 5123, f64::max), [511.0], "of 16 bits");
        assert!(bounds(&[], 12, 5126, f64::max).is_empty(), "of nothing");
    }

    #[test]
    fn numbers_of_kinds_that_gltf_does_not_have_are_refused() {
        for kind in [DataType::Float64, DataType::Bool, DataType::Invalid] {
            let mut bytes = Vec::new();
            let found = push_value(&[0; 8][..kind.byte_length()], kind, 5125, &mut bytes);
            assert_eq!((found, bytes), (None, vec![]), "zero as {kind:?}");
        }
    }
}
