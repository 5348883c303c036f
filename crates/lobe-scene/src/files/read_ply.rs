//! PLY reader, ASCII and binary.

use std::io::Cursor;

use gltf_json::mesh::Mode;
use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_ply::{ElementDef, PlyFormat, PlyReader, PropertyType, ScalarType};

use crate::error::SceneError;
use crate::files::gltf::primitive::triangles;
use crate::files::polygon::Triangulator;
use crate::files::source::Source;
use crate::scene::mesh::MeshParts;
use crate::scene::near_origin::{from_origin, note_of_rounding, noticeable_rounding, origin_of};
use crate::scene::scene::Scene;
use crate::scene::texture::{linear_from_srgb, linear_from_srgb8};
use crate::scene::up::Up;

/// A row of the element `vertex`; missing properties are `None`.
#[derive(Deserialize)]
struct Vertex {
    x: f64,
    y: f64,
    z: f64,
    #[serde(default)]
    nx: Option<f32>,
    #[serde(default)]
    ny: Option<f32>,
    #[serde(default)]
    nz: Option<f32>,
    #[serde(default)]
    u: Option<f32>,
    #[serde(default)]
    v: Option<f32>,
    #[serde(default)]
    s: Option<f32>,
    #[serde(default)]
    t: Option<f32>,
    #[serde(default)]
    texture_u: Option<f32>,
    #[serde(default)]
    texture_v: Option<f32>,
    #[serde(default)]
    red: Option<f32>,
    #[serde(default)]
    green: Option<f32>,
    #[serde(default)]
    blue: Option<f32>,
    #[serde(default)]
    alpha: Option<f32>,
}

impl Vertex {
    /// The texture coordinates of these [names](UV_NAMES).
    fn uv(&self, names: usize) -> Option<[f32; 2]> {
        let [u, v] = match names {
            0 => [self.u, self.v],
            1 => [self.s, self.t],
            _ => [self.texture_u, self.texture_v],
        };
        Some([u?, v?])
    }
}

/// What programs call texture coordinates. The first ones that a file has are used.
const UV_NAMES: [[&str; 2]; 3] = [["u", "v"], ["s", "t"], ["texture_u", "texture_v"]];

const COLOR_NAMES: [&str; 3] = ["red", "green", "blue"];

/// A row of the element `face`, a polygon, or of `tristrips`, strips with -1 between them.
#[derive(Deserialize)]
struct Face {
    #[serde(alias = "vertex_index")]
    vertex_indices: Vec<i64>,
}

/// Reads one mesh: the element `vertex` in the order of the file, and the polygons of the element `face` and the strips of
/// `tristrips` as triangles.
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
    note_texture(bytes, source);
    let mut places = Vec::new();
    let (mut faces, mut strips) = (Vec::<Face>::new(), Vec::<Face>::new());
    while let Some(element) = reader.current_element().cloned() {
        check_length(&element, format, bytes.len(), source)?;
        let rows = format!("rows of `{}`", element.name);
        match element.name.as_str() {
            "vertex" => {
                source.count(element.count, 0)?;
                // Rows and places, which are dropped when the mesh is made of them.
                let row = size_of::<Vertex>() + size_of::<[f64; 3]>();
                source.count_bytes((element.count as u64).saturating_mul(row as u64))?;
                let vertices: Vec<Vertex> =
                    reader.next_element().map_err(|error| source.invalid(broken(&rows, error)))?;
                places = vertices.iter().map(|row| up.to_world([row.x, row.y, row.z])).collect();
                read_vertices(&element, &vertices, up, &mut parts, source);
            }
            name @ ("face" | "tristrips") if name == "face" || has_indices(&element) => {
                source.count(0, element.count)?;
                let more: Vec<Face> = reader.next_element().map_err(|error| source.invalid(broken(&rows, error)))?;
                if name == "face" {
                    faces.extend(more);
                } else {
                    strips.extend(more);
                }
                note_unused(&element, &[], source);
            }
            other => {
                source.note(format!("the element `{other}` is not used"));
                let _: Vec<IgnoredRow> = reader.next_element().map_err(|error| source.invalid(broken(&rows, error)))?;
            }
        }
    }
    let used = faces.iter().chain(&strips).flat_map(|row| &row.vertex_indices);
    let used = used.filter_map(|&index| places.get(usize::try_from(index).ok()?).copied());
    let origin = origin_of(used);
    let edges = faces.iter().chain(&strips).flat_map(|row| row.vertex_indices.windows(2));
    let number = |index: i64| usize::try_from(index).unwrap_or(usize::MAX);
    let rounding = noticeable_rounding(&places, edges.map(|pair| [number(pair[0]), number(pair[1])]), origin);
    rounding.into_iter().for_each(|rounding| source.note(note_of_rounding(rounding)));
    parts.positions = places.into_iter().map(|place| from_origin(place, origin)).collect();
    read_faces(&faces, &mut parts, source)?;
    read_strips(&strips, &mut parts, source)?;
    match source.mesh(parts)? {
        Some(mesh) => {
            let scene = Scene::new(vec![mesh], Vec::new(), Vec::new()).map_err(|error| error.within(source.name))?;
            Ok(scene.moved(origin))
        }
        None => Err(source.no_triangles()),
    }
}

/// Whether an element lists vertices.
fn has_indices(element: &ElementDef) -> bool {
    ["vertex_indices", "vertex_index"].iter().any(|name| element.has_property(name))
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
            (PropertyType::Scalar(scalar) | PropertyType::List { count_type: scalar, .. }, _) => {
                size_of_scalar(*scalar)
            }
        })
        .sum();
    if element.properties.is_empty() || element.count.checked_mul(smallest).is_none_or(|size| size > available + 2) {
        let (name, count) = (&element.name, element.count);
        return Err(source.invalid(format!("{count} rows of `{name}` do not fit into {available} bytes")));
    }
    Ok(())
}

fn size_of_scalar(scalar: ScalarType) -> usize {
    match scalar {
        ScalarType::I8 | ScalarType::U8 => 1,
        ScalarType::I16 | ScalarType::U16 => 2,
        ScalarType::I32 | ScalarType::U32 | ScalarType::F32 => 4,
        ScalarType::F64 => 8,
    }
}

/// The largest number of a property, of which its values are parts; `None` for floats. Of 32 bits it is that of eight, where `largest`, that there
/// is, is no larger: such files hold ordinary colors.
fn most_of(element: &ElementDef, name: &str, largest: f32) -> Option<f64> {
    let has_eight_bits = largest <= 255.0;
    match element.get_property(name)?.property_type {
        PropertyType::Scalar(ScalarType::I8) => Some(i8::MAX.into()),
        PropertyType::Scalar(ScalarType::U8) => Some(u8::MAX.into()),
        PropertyType::Scalar(ScalarType::I16) => Some(i16::MAX.into()),
        PropertyType::Scalar(ScalarType::U16) => Some(u16::MAX.into()),
        PropertyType::Scalar(ScalarType::I32 | ScalarType::U32) if has_eight_bits => Some(u8::MAX.into()),
        PropertyType::Scalar(ScalarType::I32) => Some(i32::MAX.into()),
        PropertyType::Scalar(ScalarType::U32) => Some(u32::MAX.into()),
        PropertyType::Scalar(ScalarType::F32 | ScalarType::F64) | PropertyType::List { .. } => None,
    }
}

/// Notes that the comments of the header name a picture, as photogrammetry writes it.
fn note_texture(bytes: &[u8], source: &mut Source<'_>) {
    // The header is text, whatever follows.
    let header = bytes.split(|&byte| byte == b'\n').map(<[u8]>::trim_ascii).take_while(|line| *line != b"end_header");
    let names = header.filter_map(|line| line.strip_prefix(b"comment TextureFile "));
    for name in names.take(1) {
        let name = String::from_utf8_lossy(name);
        source.note(format!("the texture {} is not used; surfaces have the colors of vertices alone", name.trim()));
    }
}

fn read_vertices(element: &ElementDef, rows: &[Vertex], up: Up, parts: &mut MeshParts, source: &mut Source<'_>) {
    let normals = rows.iter().map(|row| Some(up.to_world([row.nx?, row.ny?, row.nz?])));
    parts.normals = normals.collect::<Option<_>>().unwrap_or_default();
    let mut used = Vec::new();
    let has_all = |names: &[&str]| names.iter().all(|name| element.has_property(name));
    if let Some(names) = UV_NAMES.iter().position(|names| has_all(names)) {
        used.extend(UV_NAMES[names]);
        // In PLY v points upwards.
        let uvs = rows.iter().map(|row| row.uv(names).map(|[u, v]| [u, 1.0 - v]));
        parts.uvs[0] = uvs.collect::<Option<_>>().unwrap_or_default();
    }
    if has_all(&COLOR_NAMES) {
        used.extend(COLOR_NAMES);
        used.push("alpha");
        // Whole numbers are sRGB-encoded colors, floats are linear.
        let color = |c: f32, most: Option<f64>| {
            let Some(most) = most else { return c };
            if most == 255.0 { linear_from_srgb8(c as u8) } else { linear_from_srgb(f64::from(c) / most) }
        };
        let numbers = rows.iter().flat_map(|row| [row.red, row.green, row.blue, row.alpha]).flatten();
        let largest = numbers.fold(0.0, f32::max);
        let most = COLOR_NAMES.map(|name| most_of(element, name, largest));
        let whole = most_of(element, "alpha", largest).map_or(1.0, |most| most as f32);
        let colors = rows.iter().map(|row| {
            let [r, g, b] = [row.red?, row.green?, row.blue?];
            Some([color(r, most[0]), color(g, most[1]), color(b, most[2]), row.alpha.map_or(1.0, |a| a / whole)])
        });
        parts.colors = colors.collect::<Option<_>>().unwrap_or_default();
    }
    note_unused(element, &used, source);
}

/// Notes properties that, by their names, are colors or texture coordinates, but are not among those used: of splats and scanners too.
fn note_unused(element: &ElementDef, used: &[&str], source: &mut Source<'_>) {
    if element.has_property("f_dc_0") {
        source.note("Gaussian splats (f_dc_0, opacity and others) are not used; the file is read as a mesh");
    }
    const WORDS: [&str; 11] = ["red", "green", "blue", "alpha", "r", "g", "b", "u", "v", "s", "t"];
    const PARTS: [&str; 7] = ["color", "colour", "texcoord", "texture", "texnumber", "intensity", "reflectance"];
    let is_look = |name: &str| {
        let name = name.to_ascii_lowercase();
        name.split('_').any(|word| WORDS.contains(&word)) || PARTS.iter().any(|part| name.contains(part))
    };
    let names = element.properties.iter().map(|property| property.name.as_str());
    let names: Vec<String> =
        names.filter(|name| !used.contains(name) && is_look(name)).map(|name| format!("`{name}`")).collect();
    if !names.is_empty() {
        let (element, names) = (&element.name, names.join(", "));
        source.note(format!("colors or texture coordinates of `{element}` in a form that is not used: {names}"));
    }
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

/// The triangles of strips, every other one of which runs around the other way in the file.
fn read_strips(rows: &[Face], parts: &mut MeshParts, source: &mut Source<'_>) -> Result<(), SceneError> {
    for (row, Face { vertex_indices }) in rows.iter().enumerate() {
        // Each row was counted as one.
        source.count(0, vertex_indices.len().saturating_sub(3))?;
        for strip in vertex_indices.split(|&index| index == -1) {
            let corners: Option<Vec<u32>> = strip.iter().map(|&i| u32::try_from(i).ok()).collect();
            let Some(corners) = corners else {
                return Err(
                    source.invalid(format!("row {row} of `tristrips` uses a vertex index below -1 or above 2^32"))
                );
            };
            // A vertex that stands there twice leads to where the strip goes on.
            let triangles = triangles(Mode::TriangleStrip, &corners).into_iter();
            parts.triangles.extend(triangles.filter(|[a, b, c]| a != b && b != c && c != a));
        }
    }
    Ok(())
}
