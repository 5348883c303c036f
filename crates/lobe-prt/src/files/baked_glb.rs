//! Baked .glb files: writing a scene whose vertices carry transfer.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, Write};
use std::ops::Range;
use std::path::Path;

use lobe_io::{IoError, Job};
use lobe_scene::{GltfDocument, Mesh, MeshSource, Scene};
use serde_json::{Map, Value, json};

use crate::compression::compressed_transfer::CompressedTransfer;
use crate::error::PrtError;
use crate::files::baked_compressed::Compressed;
use crate::files::baked_extras::{
    LOBE_EXTRAS_VERSION, check_version, put_description, put_extras, remove_descriptions,
};
use crate::files::baked_layout::{
    Attribute, AttributeGroup, BACK, DIRECT, FRONT, PlainTransfer, VertexData, attribute_groups, attributes_per_channel,
};
use crate::files::baked_shape::BakedShape;
use crate::files::glb_writer::{check_length, padding, write_glb};
use crate::job::meter::Meter;
use crate::recipe::Recipe;
use crate::transfer::transfer::Channels;
use crate::transfer::transfer_rows::TransferRows;

/// The number of vertices in memory at a time while their transfer is written.
const VERTICES_AT_ONCE: usize = 4096;

/// What is written, in messages.
const VERTICES: &str = "vertices";
const BACKS: &str = "backs";

/// Attributes of vertices that a bake writes; those of an earlier bake give way.
const OUR_ATTRIBUTES: [&str; 3] = ["_TRANSFER_", "_WEIGHTS_", "_CLUSTER"];

/// A .glb that waits for its transfer: everything is checked and laid out before the bake.
///
/// ```text
///   attribute _TRANSFER_k, k = c ⌈n²/4⌉ + j, VEC4 of floats:  T_c,4j .. T_c,4j+3,  zeros from n² on
/// ```
///
/// Every primitive with triangles has these attributes for its vertices, in index order; c is 0, or 0 to 2 for red,
/// green and blue. Both its mesh and `asset` say `version`, `quantity` ("transfer"), `order` and `channels` under
/// `extras.lobe`, and `asset` and the scene the whole recipe. The transfer is in Lobe's z-up world frame, whatever node
/// the vertex belongs to.
///
/// [With backs](BakedGlb::with_backs), primitives of double-sided materials have `_TRANSFER_BACK_k` in the same layout,
/// for the side from which corners run clockwise, and `extras.lobe` of their mesh and of `asset` says `"backs": true`.
///
/// [With the direct part](BakedGlb::with_direct), primitives have `_TRANSFER_DIRECT_k`, too: transfer without
/// reflections, of as many channels as `extras.lobe` says under `direct`. Their difference is the reflected part.
#[derive(Clone, Debug)]
pub struct BakedGlb {
    document: GltfDocument,
    /// For each mesh of the scene: the primitive that carries its transfer, and its number of vertices.
    places: Vec<Place>,
    /// The channels of the direct part, if there is one.
    direct: Option<Channels>,
    shape: BakedShape,
}

/// What a file holds beside the transfer of fronts.
#[derive(Clone, Copy, Default)]
pub struct MoreTransfer<'a> {
    /// The transfer of the [double-sided vertices](crate::double_sided_vertices) from behind, of as many bands and
    /// channels as that of fronts.
    pub backs: Option<&'a dyn TransferRows>,
    /// The part of the transfer of fronts without reflections, of as many bands.
    pub direct: Option<&'a dyn TransferRows>,
}

#[derive(Clone, Copy, Debug)]
struct Place {
    mesh: usize,
    primitive: usize,
    vertices: usize,
    /// Whether its backs have transfer too.
    has_backs: bool,
}

/// What is written of the vertices of places: of all, or of the backs of those that have some.
struct Written<'a> {
    /// What it is in messages.
    what: &'static str,
    data: &'a dyn VertexData,
    groups: Vec<AttributeGroup>,
    is_back: bool,
}

impl<'a> Written<'a> {
    fn new(what: &'static str, data: &'a dyn VertexData) -> Self {
        Self { what, data, groups: attribute_groups(&data.attributes()), is_back: what == BACKS }
    }

    fn is_of(&self, place: Place) -> bool {
        !self.is_back || place.has_backs
    }
}

impl BakedGlb {
    /// The file a scene was read from, with all that it holds beside the scene: both come from
    /// [`GltfReader::into_scene_and_document`](lobe_scene::GltfReader::into_scene_and_document).
    ///
    /// A mesh that several nodes show has different transfer at each: further nodes get a copy of the mesh that shares
    /// its data. Meshes that only nodes outside of the scene show stay without transfer, and transfer of an earlier
    /// bake is taken out. The scene may have been split since it was read, alike at all nodes or not: the attributes of
    /// meshes with [`halved`](Mesh::halved) edges are interpolated, as [`GltfDocument::subdivided`] says.
    ///
    /// # Errors
    /// [`PrtError::Options`] if the scene is not this file's; [`PrtError::Unsupported`] or [`PrtError::Invalid`] if the file was
    /// baked by another version, whose transfer cannot be taken out; [`PrtError::Scene`] if attributes of a mesh that
    /// was split are not in the document.
    pub fn of_document(document: GltfDocument, scene: &Scene) -> Result<Self, PrtError> {
        let mut document = document;
        let earlier = &document.json["asset"]["extras"]["lobe"];
        if !earlier.is_null() {
            check_version(earlier, "the document")?;
        }
        let foreign = || {
            let message = "expected the glTF document that the scene was read with; write the scene itself";
            PrtError::Options(message.to_owned())
        };
        let sources: Option<Vec<MeshSource>> = scene.meshes().iter().map(Mesh::source).collect();
        let sources = sources.ok_or_else(foreign)?;
        remove_earlier_transfer(&mut document);
        let own = give_nodes_own_meshes(&mut document.json, &sources);
        let (mut places, mut split) = (Vec::new(), Vec::new());
        for (mesh, source) in scene.meshes().iter().zip(&sources) {
            let place = Place {
                mesh: own.get(&source.node).copied().unwrap_or(source.mesh),
                primitive: source.primitive,
                vertices: mesh.positions().len(),
                has_backs: false,
            };
            let own = place.vertices - mesh.halved().len();
            if vertices_in_file(&document.json, place) != Some(own as u64) {
                return Err(foreign());
            }
            if own < place.vertices {
                split.push(([place.mesh, place.primitive], mesh));
            }
            places.push(place);
        }
        let document = document.subdivided(&split)?.pruned();
        Ok(Self { document, places, direct: None, shape: BakedShape::of(scene) })
    }

    /// A scene that is in no glTF file: one that was made by a formula or read from another kind of file.
    #[must_use]
    pub fn of_scene(scene: &Scene) -> Self {
        let place = |(i, mesh): (usize, &Mesh)| Place {
            mesh: i,
            primitive: 0,
            vertices: mesh.positions().len(),
            has_backs: false,
        };
        let places = scene.meshes().iter().enumerate().map(place).collect();
        Self { document: GltfDocument::of_scene(scene), places, direct: None, shape: BakedShape::of(scene) }
    }

    /// The same file with transfer of the backs of the [double-sided vertices](crate::double_sided_vertices) of its
    /// scene, too.
    #[must_use]
    pub fn with_backs(mut self, scene: &Scene) -> Self {
        for (mesh, place) in self.places.iter_mut().enumerate() {
            place.has_backs = scene.material(mesh).double_sided;
        }
        self
    }

    /// The same file with the direct part of the transfer, too, of so many channels.
    #[must_use]
    pub fn with_direct(self, channels: Channels) -> Self {
        Self { direct: Some(channels), ..self }
    }

    /// The size of the file in bytes, but for its JSON: a few hundred for each mesh and attribute.
    #[must_use]
    pub fn size(&self, order: usize, channels: Channels) -> u64 {
        let floats = |channels: Channels| 4 * channels.count() * attributes_per_channel(order);
        let rows = (self.vertices() + self.backs()) * floats(channels);
        (self.document.bytes.len() + 4 * (rows + self.vertices() * self.direct.map_or(0, floats))) as u64
    }

    /// Refuses transfer that a .glb cannot hold, before it is baked.
    ///
    /// # Errors
    /// [`PrtError::Options`] if the file would have 4 GiB or more, which its header cannot say.
    pub fn check_size(&self, order: usize, channels: Channels) -> Result<(), PrtError> {
        check_length(self.size(order, channels))
    }

    /// Writes the file, a few vertices at a time; until all is written, nothing has its name.
    ///
    /// `recipe` is kept as it is under `asset.extras.lobe.recipe`: the options and versions that made the transfer.
    ///
    /// # Errors
    /// [`PrtError::Options`] if the transfer is not that of the scene's vertices or too large for a .glb,
    /// [`PrtError::Io`] if the system refuses, [`PrtError::Cancelled`] if the job was told to stop.
    pub fn write(
        &self,
        path: impl AsRef<Path>,
        transfer: &dyn TransferRows,
        recipe: &Recipe,
        job: Job<'_>,
    ) -> Result<(), PrtError> {
        self.write_with(path, transfer, MoreTransfer::default(), recipe, job)
    }

    /// [`BakedGlb::write`] of a file [with backs](BakedGlb::with_backs), the [direct part](BakedGlb::with_direct), or
    /// both.
    ///
    /// # Errors
    /// As [`BakedGlb::write`].
    pub fn write_with(
        &self,
        path: impl AsRef<Path>,
        transfer: &dyn TransferRows,
        more: MoreTransfer<'_>,
        recipe: &Recipe,
        job: Job<'_>,
    ) -> Result<(), PrtError> {
        let is_other =
            |backs: &&dyn TransferRows| (backs.order(), backs.channels()) != (transfer.order(), transfer.channels());
        if more.backs.as_ref().is_some_and(is_other)
            || more.direct.is_some_and(|direct| direct.order() != transfer.order())
        {
            let message =
                "expected all transfer of as many bands, and backs of as many channels as fronts, found others";
            return Err(PrtError::Options(message.to_owned()));
        }
        let fronts = PlainTransfer(transfer, FRONT);
        let backs = more.backs.map(|backs| PlainTransfer(backs, BACK));
        let direct = more.direct.map(|direct| PlainTransfer(direct, DIRECT));
        let mut written = vec![Written::new(VERTICES, &fronts)];
        written.extend(backs.as_ref().map(|backs| Written::new(BACKS, backs)));
        written.extend(direct.as_ref().map(|direct| Written::new("direct parts of vertices", direct)));
        self.write_data(path.as_ref(), &written, (transfer, recipe), job)
    }

    /// [`BakedGlb::write`] for compressed transfer.
    ///
    /// ```text
    ///   _CLUSTER: k, 0, 0, 0,  VEC4, u16 or f32
    ///   _WEIGHTS_j: w_4j .. w_4j+3,  VEC4, f32 or normalized u16 or u8, zeros at the end
    /// ```
    ///
    /// Means and directions, floats in base64, are the member `bases` of `extras.lobe` of the scene. Those of cluster k
    /// begin at `k (1 + components) · channels · n²`, the mean first. Blender keeps weights that are floats.
    ///
    /// # Errors
    /// As [`BakedGlb::write`].
    pub fn write_compressed(
        &self,
        path: impl AsRef<Path>,
        transfer: &CompressedTransfer,
        recipe: &Recipe,
    ) -> Result<(), PrtError> {
        let compressed = Compressed(transfer);
        let written = [Written::new(VERTICES, &compressed)];
        self.write_data(path.as_ref(), &written, (&transfer.to_transfer(), recipe), Job::default())
    }

    fn vertices(&self) -> usize {
        self.places.iter().map(|place| place.vertices).sum()
    }

    /// The vertices whose backs have transfer.
    fn backs(&self) -> usize {
        self.places.iter().filter(|place| place.has_backs).map(|place| place.vertices).sum()
    }

    fn write_data(
        &self,
        path: &Path,
        written: &[Written<'_>],
        (transfer, recipe): (&dyn TransferRows, &Recipe),
        job: Job<'_>,
    ) -> Result<(), PrtError> {
        for Written { what, data, is_back, .. } in written {
            let (expected, found) = (if *is_back { self.backs() } else { self.vertices() }, data.vertices());
            if expected != found {
                let message = format!("expected the transfer of {expected} {what}, found that of {found} receivers");
                return Err(PrtError::Options(message));
            }
        }
        let place = || path.display().to_string();
        let shape = self.shape.described(transfer).map_err(|source| IoError::Io { place: place(), source })?;
        let (json, length) = self.laid_out(written, shape, recipe);
        let steps = written.iter().map(|sides| sides.groups.len() * sides.data.vertices()).sum();
        write_glb(path, (&json, &self.document.bytes, length), (steps, job), |out, meter| {
            self.write_vertices(out, written, meter)
        })
    }

    /// The JSON with views, accessors, attributes and extras of the data, and the length of the buffer.
    fn laid_out(&self, written: &[Written<'_>], shape: Value, recipe: &Recipe) -> (Value, usize) {
        let mut json = self.document.json.clone();
        let mut length = self.document.bytes.len() + padding(self.document.bytes.len());
        let mut about = written[0].data.about();
        about["version"] = json!(LOBE_EXTRAS_VERSION);
        if let Some(direct) = written.iter().find(|written| written.data.attributes()[0].name.starts_with(DIRECT)) {
            about["direct"] = json!({"channels": direct.data.about()["channels"]});
        }
        // Add views, accessors and attributes to each primitive, and the extras of its mesh.
        let mut with_backs = BTreeSet::new();
        for place in &self.places {
            for sides in written.iter().filter(|sides| sides.is_of(*place)) {
                let attributes = sides.data.attributes();
                for group in &sides.groups {
                    add_group(&mut json, *place, &attributes[group.attributes.clone()], length);
                    length += place.vertices * group.stride;
                }
                with_backs.extend(sides.is_back.then_some(place.mesh));
            }
            let mut about = about.clone();
            if with_backs.contains(&place.mesh) {
                about["backs"] = json!(true);
            }
            put_extras(&mut json["meshes"][place.mesh], about);
        }
        if !with_backs.is_empty() {
            about["backs"] = json!(true);
        }
        // Say what made the transfer, and how it is read.
        about["generator"] = json!(concat!("Lobe ", env!("CARGO_PKG_VERSION")));
        about["recipe"] = recipe.clone().into();
        about["shape"] = shape;
        put_description(&mut json, &about, written[0].data.bases());
        // Give the one buffer its length.
        let first = json["buffers"].get(0).cloned();
        let mut buffer = first.unwrap_or_else(|| Value::Object(Map::new()));
        buffer["byteLength"] = json!(length);
        json["buffers"] = json!([buffer]);
        (json, length)
    }

    fn write_vertices(&self, out: &mut dyn Write, written: &[Written<'_>], meter: &mut Meter<'_>) -> io::Result<()> {
        let mut firsts = vec![0; written.len()];
        for place in &self.places {
            for (sides, first) in written.iter().zip(&mut firsts).filter(|(sides, _)| sides.is_of(*place)) {
                for group in &sides.groups {
                    write_group(out, sides.data, group, *first..*first + place.vertices, meter)?;
                }
                *first += place.vertices;
            }
        }
        Ok(())
    }
}

/// Writes the attributes of a group for some vertices, a few at a time.
fn write_group(
    out: &mut dyn Write,
    data: &dyn VertexData,
    group: &AttributeGroup,
    vertices: Range<usize>,
    meter: &mut Meter<'_>,
) -> io::Result<()> {
    let mut bytes = Vec::new();
    for start in vertices.clone().step_by(VERTICES_AT_ONCE) {
        meter.go_on_writing()?;
        let end = (start + VERTICES_AT_ONCE).min(vertices.end);
        bytes.clear();
        data.push_bytes(start..end, group.attributes.clone(), &mut bytes)?;
        out.write_all(&bytes)?;
        meter.step(end - start);
    }
    Ok(())
}

/// Adds a buffer view at `offset` for attributes of a primitive that lie side by side.
fn add_group(json: &mut Value, place: Place, attributes: &[Attribute], offset: usize) {
    let stride: usize = attributes.iter().map(|attribute| attribute.bytes).sum();
    let view = json!({
        "buffer": 0, "byteOffset": offset, "byteLength": place.vertices * stride, "byteStride": stride, "target": 34962,
    });
    let view = push(json, "bufferViews", view);
    let mut offset = 0;
    for attribute in attributes {
        let mut accessor = json!({
            "bufferView": view, "byteOffset": offset,
            "componentType": attribute.component, "count": place.vertices, "type": attribute.kind,
        });
        if attribute.normalized {
            accessor["normalized"] = json!(true);
        }
        let accessor = push(json, "accessors", accessor);
        json["meshes"][place.mesh]["primitives"][place.primitive]["attributes"][&attribute.name] = json!(accessor);
        offset += attribute.bytes;
    }
}

pub(crate) fn push(json: &mut Value, array: &str, item: Value) -> usize {
    match &mut json[array] {
        Value::Array(items) => items.push(item),
        missing => *missing = json!([item]),
    }
    json[array].as_array().map_or(0, |items| items.len() - 1)
}

fn vertices_in_file(json: &Value, place: Place) -> Option<u64> {
    let position = json["meshes"][place.mesh]["primitives"][place.primitive]["attributes"]["POSITION"].as_u64()?;
    json["accessors"][usize::try_from(position).ok()?]["count"].as_u64()
}

/// Sees to it that no two nodes of the scene, and no node of the scene and one outside, show the same mesh; the new
/// mesh of each node that got one.
pub(crate) fn give_nodes_own_meshes(json: &mut Value, sources: &[MeshSource]) -> BTreeMap<usize, usize> {
    let shown: BTreeSet<usize> = sources.iter().map(|source| source.node).collect();
    let mesh_of = |node: &Value| node.get("mesh").and_then(Value::as_u64).map(|mesh| mesh as usize);
    let nodes = json["nodes"].as_array().map_or(&[][..], Vec::as_slice);
    let outside = nodes.iter().enumerate().filter(|(node, _)| !shown.contains(node));
    let mut taken: BTreeSet<usize> = outside.filter_map(|(_, node)| mesh_of(node)).collect();
    let mut own = BTreeMap::new();
    for node in shown {
        let Some(mesh) = mesh_of(&json["nodes"][node]) else { continue };
        if !taken.insert(mesh) {
            let copy = json["meshes"][mesh].clone();
            let copy = push(json, "meshes", copy);
            json["nodes"][node]["mesh"] = json!(copy);
            own.insert(node, copy);
        }
    }
    own
}

/// Takes out the attributes and extras of an earlier bake. Their data stay, which nothing names any more.
pub(crate) fn remove_earlier_transfer(document: &mut GltfDocument) {
    let json = &mut document.json;
    for mesh in json["meshes"].as_array_mut().into_iter().flatten() {
        for primitive in mesh.get_mut("primitives").and_then(Value::as_array_mut).into_iter().flatten() {
            if let Some(Value::Object(attributes)) = primitive.get_mut("attributes") {
                attributes.retain(|name, _| !OUR_ATTRIBUTES.iter().any(|ours| name.starts_with(ours)));
            }
        }
    }
    remove_descriptions(json);
}
