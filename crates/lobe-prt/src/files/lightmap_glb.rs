//! Lightmaps of transfer as .glb files: the scene with its texture coordinates, and the texels as textures.

use std::io::{self, Write};
use std::path::Path;

use half::f16;
use lobe_io::Job;
use lobe_scene::{GltfDocument, GltfReader, Mesh, MeshSource, Scene};
use serde_json::{Value, json};

use crate::error::PrtError;
use crate::files::baked_extras::{LOBE_EXTRAS_VERSION, lobe_of, put_description, put_extras};
use crate::files::baked_glb::{give_nodes_own_meshes, push, remove_earlier_transfer};
use crate::files::baked_layout::attributes_per_channel;
use crate::files::glb_writer::{check_length, write_glb};
use crate::files::new_vertices::NewVertices;
use crate::job::checkpoint::rows_at_once;
use crate::job::meter::Meter;
use crate::receivers::lightmap::Lightmap;
use crate::recipe::Recipe;
use crate::transfer::transfer::{Channels, Transfer};
use crate::transfer::transfer_rows::TransferRows;

/// The bytes of a texel of one texture: four numbers of 16 bits.
const TEXEL: usize = 8;

/// What a texture holds.
const FORMAT: &str = "RGBA16F";

/// A .glb of a scene with a lightmap of transfer, that waits for its texels.
///
/// ```text
///   texture k = c ⌈n²/4⌉ + j,  W × W texels of RGBA16F, row 0 first:  T_c,4j .. T_c,4j+3,  zeros from n² on
/// ```
///
/// `asset.extras.lobe.lightmap` has the width W, the format, and the buffer view of each texture, which has nothing but
/// its texels; c is 0, or 0 to 2 for red, green and blue. Each mesh says in `extras.lobe.lightmap` which set of texture
/// coordinates is that of the lightmap. The rest of `asset.extras.lobe` is as in a [`BakedGlb`](crate::BakedGlb).
#[derive(Clone, Debug)]
pub struct LightmapGlb {
    document: GltfDocument,
    width: usize,
}

impl LightmapGlb {
    /// That of a scene whose meshes have texture coordinates for a lightmap of this width.
    #[must_use]
    pub fn of_scene(scene: &Scene, width: usize) -> Self {
        let mut document = GltfDocument::of_scene(scene);
        for (mesh, json) in scene.meshes().iter().zip(document.json["meshes"].as_array_mut().into_iter().flatten()) {
            put_extras(json, json!({"lightmap": {"texCoord": set_of(mesh)}}));
        }
        Self { document, width }
    }

    /// The file that a scene was read from, with all that it holds beside the scene, whose meshes get the vertices and
    /// the texture coordinates of a scene that was [unwrapped](Scene::unwrapped); that may be the scene itself.
    ///
    /// A mesh that several nodes show is copied for each, and transfer of an earlier bake is taken out. `None` if the
    /// scene is not the document's, or the document stores attributes of vertices in a way that is not followed, such
    /// as sparse ones: [`LightmapGlb::of_scene`] takes any scene.
    #[must_use]
    pub fn of_document(document: GltfDocument, scene: &Scene, unwrapped: &Scene, width: usize) -> Option<Self> {
        let mut document = document;
        let sources: Vec<MeshSource> = scene.meshes().iter().map(Mesh::source).collect::<Option<_>>()?;
        remove_earlier_transfer(&mut document);
        let own = give_nodes_own_meshes(&mut document.json, &sources);
        let mesh_of = |source: &MeshSource| own.get(&source.node).copied().unwrap_or(source.mesh);
        for ((source, before), after) in sources.iter().zip(scene.meshes()).zip(unwrapped.meshes()) {
            if before != after {
                let from = sources_of(before, after);
                let uvs = (after.lightmap_uvs(), set_of(after));
                let new = NewVertices { from: &from, triangles: after.triangles(), uvs };
                new.put(&mut document, [mesh_of(source), source.primitive], source.node)?;
            }
        }
        let mut document = document.pruned();
        for (source, after) in sources.iter().zip(unwrapped.meshes()) {
            let mesh = document.json["meshes"].get_mut(mesh_of(source))?;
            put_extras(mesh, json!({"lightmap": {"texCoord": set_of(after)}}));
        }
        Some(Self { document, width })
    }

    /// The size of the file in bytes, except for its JSON.
    #[must_use]
    pub fn size(&self, order: usize, channels: Channels) -> u64 {
        let textures = channels.count() * attributes_per_channel(order);
        (self.document.bytes.len() + textures * self.bytes_of_texture()) as u64
    }

    /// Refuses transfer that a .glb cannot hold, before it is baked.
    ///
    /// # Errors
    /// [`PrtError::Options`] if the file would have 4 GiB or more, which its header cannot say.
    pub fn check_size(&self, order: usize, channels: Channels) -> Result<(), PrtError> {
        check_length(self.size(order, channels))
    }

    fn bytes_of_texture(&self) -> usize {
        TEXEL * self.width * self.width
    }

    /// Writes the file, some texels at a time; until all is written, nothing has its name. The rows are those of all
    /// texels, from the top.
    ///
    /// # Errors
    /// [`PrtError::Options`] if the transfer is not that of all texels, too large for a .glb or beyond 16 bits;
    /// [`PrtError::Io`] if the system refuses, [`PrtError::Cancelled`] if the job was told to stop.
    pub fn write(
        &self,
        path: impl AsRef<Path>,
        texels: &dyn TransferRows,
        recipe: &Recipe,
        job: Job<'_>,
    ) -> Result<(), PrtError> {
        let (path, expected, found) = (path.as_ref(), self.width * self.width, texels.receivers());
        if expected != found {
            let message = format!("expected the transfer of {expected} texels, found that of {found} receivers");
            return Err(PrtError::Options(message));
        }
        let textures = texels.channels().count() * attributes_per_channel(texels.order());
        let (json, length) = self.laid_out(texels, textures, recipe);
        let steps = textures * expected;
        write_glb(path, (&json, &self.document.bytes, length), (steps, job), |out, meter| {
            (0..textures).try_for_each(|texture| write_texture(out, texels, texture, meter))
        })
    }

    /// The JSON with the views of all textures, and the length of the buffer.
    fn laid_out(&self, texels: &dyn TransferRows, textures: usize, recipe: &Recipe) -> (Value, usize) {
        let (mut json, bytes) = (self.document.json.clone(), self.bytes_of_texture());
        let first = self.document.bytes.len().next_multiple_of(4);
        let views: Vec<usize> = (0..textures)
            .map(|k| {
                let view = json!({"buffer": 0, "byteOffset": first + k * bytes, "byteLength": bytes});
                push(&mut json, "bufferViews", view)
            })
            .collect();
        let about = json!({
            "version": LOBE_EXTRAS_VERSION,
            "generator": concat!("Lobe ", env!("CARGO_PKG_VERSION")),
            "quantity": "transfer",
            "order": texels.order(),
            "channels": texels.channels().count(),
            "lightmap": {"width": self.width, "format": FORMAT, "bufferViews": views},
            "recipe": recipe,
        });
        put_description(&mut json, &about, None);
        let length = first + textures * bytes;
        json["buffers"] = json!([{"byteLength": length}]);
        (json, length)
    }
}

/// The set of texture coordinates that is that of the lightmap.
fn set_of(mesh: &Mesh) -> usize {
    let sets = [mesh.uvs(0), mesh.uvs(1), mesh.third_uvs()];
    sets.iter().rposition(|set| !set.is_empty()).unwrap_or(0)
}

/// For each vertex of a mesh that was unwrapped the one that it was made from: triangles keep their order.
fn sources_of(before: &Mesh, after: &Mesh) -> Vec<u32> {
    let mut from = vec![0; after.positions().len()];
    for (old, new) in before.triangles().iter().zip(after.triangles()) {
        old.iter().zip(new).for_each(|(&old, &new)| from[new as usize] = old);
    }
    from
}

/// Writes all texels of one texture.
fn write_texture(
    out: &mut dyn Write,
    texels: &dyn TransferRows,
    texture: usize,
    meter: &mut Meter<'_>,
) -> io::Result<()> {
    let (bands, per_channel, row) = (texels.order().pow(2), attributes_per_channel(texels.order()), texels.row_len());
    let (channel, begin) = (texture / per_channel, texture % per_channel * 4);
    let mut rows = vec![0.0; row * rows_at_once(row).min(texels.receivers())];
    let mut bytes = Vec::with_capacity(TEXEL * rows.len() / row);
    for first in (0..texels.receivers()).step_by(rows_at_once(row)) {
        meter.go_on_writing()?;
        let count = rows_at_once(row).min(texels.receivers() - first);
        texels.read_rows(first, &mut rows[..row * count])?;
        bytes.clear();
        for values in rows[..row * count].chunks_exact(row) {
            for i in begin..begin + 4 {
                let value = f16::from_f32(if i < bands { values[channel * bands + i] } else { 0.0 });
                if !value.is_finite() {
                    let found = values[channel * bands + i];
                    let message = format!("expected transfer that 16 bits hold, below 65520, found {found}");
                    return Err(io::Error::new(io::ErrorKind::InvalidData, message));
                }
                bytes.extend(value.to_le_bytes());
            }
        }
        out.write_all(&bytes)?;
        meter.step(count);
    }
    Ok(())
}

/// The texels of a file that [`LightmapGlb`] wrote, and how they lie in its scene; none of a file without a lightmap.
pub(crate) fn read_lightmap_of_glb(
    gltf: &GltfReader,
    (order, channels): (usize, Channels),
) -> Result<Option<(Transfer, usize)>, PrtError> {
    let (about, name) = (&lobe_of(gltf)["lightmap"], gltf.name());
    if about.is_null() {
        return Ok(None);
    }
    let invalid = |what: &str, member: &str| {
        let message = format!("expected {what} in asset.extras.lobe.lightmap, found {}", about[member]);
        Err(PrtError::invalid(name, message))
    };
    let width = match about["width"].as_u64() {
        Some(width @ 1..=16384) => width as usize,
        _ => return invalid("a width of 1 to 16384", "width"),
    };
    if about["format"] != FORMAT {
        return invalid("the format RGBA16F", "format");
    }
    let (per_channel, bands, row) = (attributes_per_channel(order), order.pow(2), order.pow(2) * channels.count());
    let views: Vec<u32> = about["bufferViews"].as_array().into_iter().flatten().filter_map(view_of).collect();
    if views.len() != per_channel * channels.count() {
        return invalid(&format!("{} buffer views", per_channel * channels.count()), "bufferViews");
    }
    // As long as the file says before there is room for what it says.
    let bytes: Vec<&[u8]> = views.iter().map(|&view| gltf.buffer_view(view)).collect::<Result<_, _>>()?;
    if let Some(found) = bytes.iter().find(|bytes| bytes.len() != TEXEL * width * width) {
        let message =
            format!("expected {} bytes of each texture of a lightmap, found {}", TEXEL * width * width, found.len());
        return Err(PrtError::invalid(name, message));
    }
    let mut coefficients = vec![0.0; width * width * row];
    for (texture, bytes) in bytes.iter().enumerate() {
        let (channel, begin) = (texture / per_channel, texture % per_channel * 4);
        for (values, texel) in coefficients.chunks_exact_mut(row).zip(bytes.chunks_exact(TEXEL)) {
            for (i, half) in (begin..bands.min(begin + 4)).zip(texel.chunks_exact(2)) {
                values[channel * bands + i] = f16::from_le_bytes([half[0], half[1]]).to_f32();
            }
        }
    }
    let transfer = Transfer::new(order, channels, coefficients).map_err(|error| error.within(name))?;
    Ok(Some((transfer, width)))
}

fn view_of(value: &Value) -> Option<u32> {
    u32::try_from(value.as_u64()?).ok()
}

/// The lightmap of this width in a scene that was read from the file called `name`.
pub(crate) fn lightmap_in(scene: &Scene, width: usize, name: &str) -> Result<Lightmap, PrtError> {
    Lightmap::new(scene, width).map_err(|error| error.within(name))
}
