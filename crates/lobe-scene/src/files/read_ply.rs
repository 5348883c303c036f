//! PLY reader, ASCII and binary.

use std::io::Cursor;

use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_ply::{ElementDef, PlyFormat, PlyReader, PropertyType, ScalarType};

use crate::files::polygon::Triangulator;
use crate::files::source::Source;
use crate::scene::texture::linear_from_srgb8;
use crate::{MeshParts, Scene, SceneError, Up};

/// A row of the element `vertex`; missing properties are `None`.
#[derive(Deserialize)]
struct Vertex {
    x: f32,
    y: f32,
    z: f32,
    #[serde(default)]
    nx: Option<f32>,
    #[serde(default)]
    ny: Option<f32>,
    #[serde(default)]
    nz: Option<f32>,
    #[serde(default, alias = "s", alias = "texture_u")]
    u: Option<f32>,
    #[serde(default, alias = "t", alias = "texture_v")]
    v: Option<f32>,
    #[serde(default)]
    red: Option<f32>,
    #[serde(default)]
    green: Option<f32>,
    #[serde(default)]
    blue: Option<f32>,
    #[serde(default)]
    alpha: Option<f32>,
}

/// A row of the element `face`: a polygon.
#[derive(Deserialize)]
struct Face {
    #[serde(alias = "vertex_index")]
    vertex_indices: Vec<i64>,
}

/// Reads one mesh: the element `vertex` in the order of the file, and the polygons of the element `face` as triangles.
/// The elements may come in any order.
pub(crate) fn read(bytes: &[u8], source: &mut Source<'_>, up: Up) -> Result<Scene, SceneError> {
    if !bytes.starts_with(b"ply") {
        return Err(source.invalid("expected a PLY file, which begins with `ply`, found something else"));
    }
    let mut data = Cursor::new(bytes);
    let broken =
        |what: &str, error: serde_ply::DeserializeError| format!("expected {what}, found an error: {}", error.0);
    let mut reader = PlyReader::from_reader(&mut data).map_err(|error| source.invalid(broken("a PLY file", error)))?;
    let mut parts = MeshParts { name: "ply".into(), ..MeshParts::default() };
    let format = reader.header().format;
    let mut faces: Vec<Face> = Vec::new();
    while let Some(element) = reader.current_element().cloned() {
        check_length(&element, format, bytes.len(), source)?;
        let rows = format!("rows of `{}`", element.name);
        match element.name.as_str() {
            "vertex" => {
                source.count(element.count, 0)?;
                let vertices: Vec<Vertex> =
                    reader.next_element().map_err(|error| source.invalid(broken(&rows, error)))?;
                read_vertices(&element, &vertices, up, &mut parts);
            }
            "face" => {
                source.count(0, element.count)?;
                let more: Vec<Face> = reader.next_element().map_err(|error| source.invalid(broken(&rows, error)))?;
                faces.extend(more);
            }
            other => {
                source.note(format!("the element `{other}` is not used"));
                let _: Vec<IgnoredRow> = reader.next_element().map_err(|error| source.invalid(broken(&rows, error)))?;
            }
        }
    }
    read_faces(&faces, &mut parts, source)?;
    match source.mesh(parts)? {
        Some(mesh) => Scene::new(vec![mesh], Vec::new(), Vec::new()).map_err(|error| error.within(source.name)),
        None => Err(source.no_triangles()),
    }
}

/// A row of an ignored element.
#[derive(Deserialize)]
struct IgnoredRow {
    #[serde(rename = " never a property")]
    _nothing: Option<IgnoredAny>,
}

/// Refuses a count of rows for which the file is too short, before memory is allocated.
fn check_length(
    element: &ElementDef,
    format: PlyFormat,
    available: usize,
    source: &Source<'_>,
) -> Result<(), SceneError> {
    let smallest: usize = element
        .properties
        .iter()
        .map(|property| match (&property.property_type, format) {
            // A digit and a space.
            (_, PlyFormat::Ascii) => 2,
            (PropertyType::Scalar(scalar) | PropertyType::List { count_type: scalar, .. }, _) => size_of(*scalar),
        })
        .sum();
    if element.properties.is_empty() || element.count.checked_mul(smallest).is_none_or(|size| size > available + 2) {
        let (name, count) = (&element.name, element.count);
        return Err(source.invalid(format!("{count} rows of `{name}` do not fit into {available} bytes")));
    }
    Ok(())
}

fn size_of(scalar: ScalarType) -> usize {
    match scalar {
        ScalarType::I8 | ScalarType::U8 => 1,
        ScalarType::I16 | ScalarType::U16 => 2,
        ScalarType::I32 | ScalarType::U32 | ScalarType::F32 => 4,
        ScalarType::F64 => 8,
    }
}

fn read_vertices(element: &ElementDef, rows: &[Vertex], up: Up, parts: &mut MeshParts) {
    parts.positions = rows.iter().map(|row| up.to_world([row.x, row.y, row.z])).collect();
    let normals = rows.iter().map(|row| Some(up.to_world([row.nx?, row.ny?, row.nz?])));
    parts.normals = normals.collect::<Option<_>>().unwrap_or_default();
    // In PLY v points upwards.
    let uvs = rows.iter().map(|row| Some([row.u?, 1.0 - row.v?]));
    parts.uvs[0] = uvs.collect::<Option<_>>().unwrap_or_default();
    // Bytes are sRGB-encoded colors, floats are linear.
    let is_byte = element
        .get_property("red")
        .is_some_and(|red| matches!(red.property_type, PropertyType::Scalar(ScalarType::U8)));
    let color = |c: f32| if is_byte { linear_from_srgb8(c as u8) } else { c };
    let coverage = |a: f32| if is_byte { a / 255.0 } else { a };
    let colors = rows
        .iter()
        .map(|row| Some([color(row.red?), color(row.green?), color(row.blue?), row.alpha.map_or(1.0, coverage)]));
    parts.colors = colors.collect::<Option<_>>().unwrap_or_default();
}

fn read_faces(rows: &[Face], parts: &mut MeshParts, source: &mut Source<'_>) -> Result<(), SceneError> {
    let corners: usize = rows.iter().map(|row| row.vertex_indices.len()).sum();
    source.count(0, corners.saturating_sub(3 * rows.len()))?;
    let mut triangulator = Triangulator::new();
    for (face, row) in rows.iter().enumerate() {
        let corners: Option<Vec<u32>> = row.vertex_indices.iter().map(|&i| u32::try_from(i).ok()).collect();
        let Some(corners) = corners else {
            return Err(source.invalid(format!("face {face} uses a vertex index below zero or above 2^32")));
        };
        triangulator.push(&corners, &parts.positions, &mut parts.triangles);
    }
    triangulator.note_filled(source);
    Ok(())
}
