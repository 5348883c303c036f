//! Shapes of glTF files: the primitives that a scene shows, in their own frames, with morph targets and joints.

use std::collections::HashMap;
use std::sync::Arc;

use gltf_json::mesh::{MorphTarget, Primitive, Semantic};
use gltf_json::validation::Checked;
use gltf_json::{Accessor, Index};

use crate::error::SceneError;
use crate::files::gltf::files::GltfFile;
use crate::files::gltf::primitive::place_of;
use crate::files::source::Source;
use crate::motion::numbers::Numbers;
use crate::motion::read_skins;
use crate::motion::shape::{Shape, Target};
use crate::scene::mesh::MeshSource;

/// The shapes read so far, by mesh and primitive: instances share them.
#[derive(Default)]
pub(crate) struct Shapes {
    read: HashMap<(usize, usize), Arc<Shape>>,
}

impl Shapes {
    /// The shape of a primitive that the scene shows, with tangents if it is to have them and the file gives some; it
    /// was read once, so its parts are there.
    pub(crate) fn of(
        &mut self,
        file: &GltfFile,
        MeshSource { mesh, primitive, .. }: MeshSource,
        has_tangents: bool,
        numbers: &mut Numbers,
        source: &mut Source<'_>,
    ) -> Result<Arc<Shape>, SceneError> {
        if let Some(there) = self.read.get(&(mesh, primitive)) {
            return Ok(Arc::clone(there));
        }
        let place = place_of(&file.root.meshes[mesh], mesh, primitive);
        let json = &file.root.meshes[mesh].primitives[primitive];
        let shape = Arc::new(shape((file, &place), (json, has_tangents), numbers, source)?);
        self.read.insert((mesh, primitive), Arc::clone(&shape));
        Ok(shape)
    }
}

fn shape(
    (file, place): (&GltfFile, &str),
    (primitive, has_tangents): (&Primitive, bool),
    numbers: &mut Numbers,
    source: &mut Source<'_>,
) -> Result<Shape, SceneError> {
    let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
    let mut vectors = |what: &'static str, index: Option<Index<Accessor>>, source: &mut Source<'_>| match index {
        Some(index) if what == "TANGENT" => numbers.of::<4>((what, place), (file, index), source),
        Some(index) => numbers.of::<3>((what, place), (file, index), source),
        None => Ok([].into()),
    };
    let positions = vectors("POSITION", attribute(Semantic::Positions), source)?;
    let normals = vectors("NORMAL", attribute(Semantic::Normals), source)?;
    // Without normals glTF says that tangents are ignored.
    let given = attribute(Semantic::Tangents).filter(|_| has_tangents && !normals.is_empty());
    let tangents = vectors("TANGENT", given, source)?;
    let mut targets = Vec::new();
    for (number, target) in primitive.targets.iter().flatten().enumerate() {
        let MorphTarget { positions: moved, normals: turned, .. } = target;
        let target =
            Target { positions: vectors("POSITION", *moved, source)?, normals: vectors("NORMAL", *turned, source)? };
        for (what, found) in [("positions", target.positions.len() / 3), ("normals", target.normals.len() / 3)] {
            let expected = positions.len() / 3;
            if found != 0 && found != expected {
                let message = format!("{place}: expected {expected} {what} in morph target {number}, found {found}");
                return Err(source.invalid(message));
            }
        }
        if let Some(number) = target.positions.iter().chain(&*target.normals).find(|c| !c.is_finite()) {
            return Err(source.invalid(format!("{place}: expected finite morph targets, found {number}")));
        }
        targets.push(target);
    }
    let influences = read_skins::influences((file, place), primitive, positions.len() / 3, numbers, source)?;
    Ok(Shape { positions, normals, tangents, targets, influences })
}
