//! Animated scenes of files.

use std::borrow::Cow;
use std::path::Path;
use std::sync::Arc;

use glam::DVec3;
use serde::Deserialize;

use crate::error::SceneError;
use crate::files::gltf::files::GltfFile;
use crate::files::gltf::nodes::{Tree, local};
use crate::files::gltf::placement::origin_of;
use crate::files::gltf::plain;
use crate::files::gltf::primitive::name_of;
use crate::files::read_gltf::{Flattened, standing_scene_of};
use crate::files::read_options::{SceneReadOptions, SceneReadReport};
use crate::files::scene_format::{is_gltf, read_still};
use crate::files::source::{Source, read_file};
use crate::motion::animated_scene::AnimatedScene;
use crate::motion::animation::State;
use crate::motion::numbers::{Numbers, members};
use crate::motion::read_animations::{self, Wanted};
use crate::motion::read_shapes::Shapes;
use crate::motion::read_skins::Skins;
use crate::motion::rig::Rig;
use crate::motion::shape::Part;
use crate::scene::mesh::MeshSource;
use crate::scene::scene::Scene;
use crate::scene::transform::Affine;
use crate::scene::up::{Up, y_up_from_z_up};

/// What moves of a node; its transform is read with the scene.
#[derive(Deserialize)]
struct GltfNode {
    name: Option<String>,
    skin: Option<usize>,
    weights: Option<Vec<f64>>,
}

impl AnimatedScene {
    /// Reads a scene with its animations from a .gltf or .glb file. Of an .obj or .ply file nothing moves.
    ///
    /// Weights of joints that do not sum to one are divided by their sum, with a note where they are off by more than a
    /// rounding; a vertex all of whose weights are zero follows the first joint that it names. A skin that carries nothing in
    /// the scene is not checked, and has no joints. Triangles that have no area as the nodes stand, but may get one from an
    /// animation that scales them or weights a morph target, are there, which [`read_scene`](crate::read_scene) drops. Normal textures are left out with a note. Animations of other things than nodes and morph weights are left out with a note.
    ///
    /// # Errors
    /// As [`read_scene`](crate::read_scene). [`SceneError::Invalid`] also where keys are not in the order of time or not as
    /// many as their values, a number is not finite, a node or a joint does not exist or is not in the scene, a skin that
    /// carries a mesh of the scene has no joints or too few matrices, a vertex has a negative weight, or a morph target has
    /// another number of vertices than its mesh. [`SceneError::Refused`] also for more than sixteen numbers of animations, skins and morph
    /// targets for each vertex that [`SceneReadOptions::max_triangles`] allows.
    pub fn read(path: impl AsRef<Path>, options: &SceneReadOptions) -> Result<(Self, SceneReadReport), SceneError> {
        let path = path.as_ref();
        let (name, bytes) = read_file(path, options)?;
        let source = Source::of_file(&name, path, &bytes, options)?;
        read(bytes.into(), source, options.up)
    }

    /// Reads a scene with its animations from the bytes of a file that references no other; `name` decides the format and
    /// stands in messages.
    ///
    /// # Errors
    /// As [`Self::read`], and [`SceneError::Unsupported`] if the bytes reference other files.
    pub fn read_bytes(
        bytes: &[u8],
        name: &str,
        options: &SceneReadOptions,
    ) -> Result<(Self, SceneReadReport), SceneError> {
        read(bytes.into(), Source::new(name, None, options), options.up)
    }
}

fn read(bytes: Cow<'_, [u8]>, mut source: Source<'_>, up: Up) -> Result<(AnimatedScene, SceneReadReport), SceneError> {
    let scene = if is_gltf(source.name) {
        animated_scene_of(&plain::read(bytes, &mut source)?, &Wanted::All, false, &mut source)?
    } else {
        AnimatedScene::still(read_still(&bytes, up, &mut source)?)
    };
    let report = source.into_report(scene.rest());
    Ok((scene, report))
}

/// The scene of a file with those of its animations that are wanted; of one pose of it normal maps may be read, too.
pub(crate) fn animated_scene_of(
    file: &GltfFile,
    wanted: &Wanted<'_>,
    reads_normal_maps: bool,
    source: &mut Source<'_>,
) -> Result<AnimatedScene, SceneError> {
    let rest = standing_scene_of(file, Flattened::Kept, reads_normal_maps, source)?;
    let nodes = members::<GltfNode>(file, "nodes", source)?;
    let mut numbers = Numbers::default();
    let rig = rig_of(file, &nodes, &rest, &mut numbers, source)?;
    let animations = read_animations::read((file, wanted), &rig, &mut numbers, source)?;
    let mut skins = Skins::of(file, &rig, source)?;
    let parts = parts_of((file, &nodes), (&rest, &rig, &mut skins), &mut numbers, source)?;
    Ok(AnimatedScene::new(rest, rig, parts, skins.into_all(), animations))
}

/// The nodes as they stand; those of the scene with the weights of their meshes' morph targets: their own, else those of the
/// mesh, else zero.
fn rig_of(
    file: &GltfFile,
    nodes: &[GltfNode],
    rest: &Scene,
    numbers: &mut Numbers,
    source: &mut Source<'_>,
) -> Result<Rig, SceneError> {
    let root = &file.root;
    let origin = origin_of(file, source)?;
    let tree = Tree::of(root, source)?;
    let mut weights = vec![Vec::new(); nodes.len()];
    for node in tree.nodes() {
        if let Some(mesh) = root.nodes[node].mesh {
            weights[node] = weights_of(file, (node, &nodes[node]), mesh, numbers, source)?;
        }
    }
    Ok(Rig {
        tree,
        rest: State { locals: root.nodes.iter().map(local).collect(), weights },
        names: nodes.iter().map(|node| node.name.clone()).collect(),
        shift: DVec3::from(y_up_from_z_up(rest.origin())) - origin.point,
        origin,
        up: Up::Y,
    })
}

fn weights_of(
    file: &GltfFile,
    (index, node): (usize, &GltfNode),
    mesh: usize,
    numbers: &mut Numbers,
    source: &mut Source<'_>,
) -> Result<Vec<f64>, SceneError> {
    let Some(json) = file.root.meshes.get(mesh) else { return Ok(Vec::new()) };
    let mut counts = json.primitives.iter().map(|primitive| primitive.targets.as_ref().map_or(0, Vec::len));
    let count = counts.next().unwrap_or(0);
    if let Some(other) = counts.find(|&other| other != count) {
        let name = name_of(json, mesh);
        let message = format!("mesh `{name}`: expected {count} morph targets in each primitive, found {other}");
        return Err(source.invalid(message));
    }
    // Two of four bytes for each at rest, and in a pose.
    numbers.add(count.saturating_mul(4), source)?;
    let of_mesh = || json.weights.iter().flatten().map(|&weight| f64::from(weight)).collect();
    let weights: Vec<f64> = node.weights.clone().unwrap_or_else(of_mesh);
    match weights.len() {
        0 => Ok(vec![0.0; count]),
        found if found == count => Ok(weights),
        found => Err(source.invalid(format!(
            "node {index}: expected {count} weights, one for each morph target of its mesh, found {found}"
        ))),
    }
}

/// The shapes of the scene's meshes with what carries them.
fn parts_of(
    (file, nodes): (&GltfFile, &[GltfNode]),
    (rest, rig, skins): (&Scene, &Rig, &mut Skins<'_>),
    numbers: &mut Numbers,
    source: &mut Source<'_>,
) -> Result<Vec<Part>, SceneError> {
    let worlds = rig.worlds(&rig.rest);
    let mut shapes = Shapes::default();
    let mut parts = Vec::with_capacity(rest.meshes().len());
    for mesh in rest.meshes() {
        let Some(place @ MeshSource { node, .. }) = mesh.source() else { continue };
        let shape = shapes.of(file, place, !mesh.tangents().is_empty(), numbers, source)?;
        let skin = nodes[node].skin;
        if let Some(index) = skin {
            let last_joint = shape.influences.as_ref().map(|influences| usize::from(influences.last_joint));
            check_skin((index, node), last_joint, skins, numbers, source)?;
        }
        parts.push(Part {
            skin: skin.filter(|_| shape.influences.is_some()),
            shape: Arc::clone(&shape),
            node,
            is_mirrored: Affine::new(worlds[node]).is_mirror(),
        });
    }
    Ok(parts)
}

/// Checks that the skin of a node exists and has the joints that a mesh names, if it names any.
fn check_skin(
    (index, node): (usize, usize),
    last_joint: Option<usize>,
    skins: &mut Skins<'_>,
    numbers: &mut Numbers,
    source: &mut Source<'_>,
) -> Result<(), SceneError> {
    let Some(last) = last_joint else {
        let message = format!("node {node} has a skin, but a mesh without joints, which moves with the node");
        source.note(message);
        return Ok(());
    };
    let count = skins.joints((index, node), numbers, source)?;
    if last >= count {
        return Err(source.invalid(format!(
            "node {node}: a vertex of its mesh is bound to joint {last}, but skin {index} has {count}"
        )));
    }
    Ok(())
}
