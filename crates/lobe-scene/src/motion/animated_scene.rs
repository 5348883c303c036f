//! Animated scenes.

use std::ops::Range;

use glam::DMat4;
use lobe_io::one_line;

use crate::error::SceneError;
use crate::files::read_options::ScenePose;
use crate::motion::animation::Animation;
use crate::motion::animation::State;
use crate::motion::entity::{Entity, EntityKind};
use crate::motion::posed_scene::PosedScene;
use crate::motion::rig::{Moves, Rig};
use crate::motion::shape::{Carrier, Part};
use crate::motion::similar_nodes::similar_nodes;
use crate::motion::skin::Skin;
use crate::scene::material::Material;
use crate::scene::mesh::Mesh;
use crate::scene::scene::Scene;
use crate::scene::transform::Trs;

/// The most names of entities in a message.
const LISTED: usize = 16;

/// A scene whose nodes, skins and morph targets animations move.
///
/// A [pose](Self::pose) has the same meshes, vertices and triangles, in the same order, as the scene at rest, which is
/// what [`read_scene`](crate::read_scene) gives of the same file [without poses](ScenePose::Unposed): what is baked for
/// the one can be looked up for the other, vertex by vertex. Triangles that lose their area in a pose stay in it. Of
/// those without area at rest the ones are there that may have one in a pose: a mesh all of which is scaled to nothing,
/// which `read_scene` leaves out, is a mesh here.
///
/// # Examples
///
/// ```
/// use lobe_scene::{Bvh, EntityKind, Ray, built_in};
///
/// let objects = built_in::three_objects(24);
/// let moving: Vec<_> = objects.entities().iter().filter(|entity| entity.kind() == EntityKind::Rigid).collect();
/// assert_eq!(moving.len(), 3, "they move over a ground that does not");
///
/// let posed = objects.pose(0, 0.25)?;
/// let center = posed.place(moving[0]).translation().map(|c| c as f32);
/// assert!(posed.bvh().is_occluded(&Ray::new([center[0], center[1], 9.0], [0.0, 0.0, -1.0])));
/// # Ok::<(), lobe_scene::SceneError>(())
/// ```
#[derive(Clone, Debug)]
pub struct AnimatedScene {
    pub(crate) rest: Scene,
    pub(crate) rig: Rig,
    /// One for each mesh of the scene.
    pub(crate) parts: Vec<Part>,
    pub(crate) skins: Vec<Skin>,
    pub(crate) animations: Vec<Animation>,
    entities: Vec<Entity>,
    rest_worlds: Vec<DMat4>,
}

impl AnimatedScene {
    /// A scene of parts, one for each mesh at rest; those of one node stand side by side.
    pub(crate) fn new(rest: Scene, rig: Rig, parts: Vec<Part>, skins: Vec<Skin>, animations: Vec<Animation>) -> Self {
        let rest_worlds = rig.worlds(&rig.rest);
        let mut scene = Self { rest, rig, parts, skins, animations, entities: Vec::new(), rest_worlds };
        scene.entities = scene.found_entities();
        scene
    }

    /// A scene of meshes in their own frames, one for each part, as its nodes stand.
    pub(crate) fn standing(
        own: &[Mesh],
        materials: Vec<Material>,
        rig: Rig,
        parts: Vec<Part>,
        skins: Vec<Skin>,
        animations: Vec<Animation>,
    ) -> Self {
        let worlds = rig.worlds(&rig.rest);
        let placed = |(mesh, part): (&Mesh, &Part)| part.posed(mesh, &rig, Carrier::Node(worlds[part.node]), &[]);
        let meshes = own.iter().zip(&parts).map(placed).collect::<Result<Vec<_>, _>>();
        match meshes.and_then(|meshes| Scene::new(meshes, materials, Vec::new())) {
            Ok(rest) => Self::new(rest, rig, parts, skins, animations),
            Err(error) => unreachable!("built-in scenes are near their origin and have triangles: {error}"),
        }
    }

    /// A scene in which nothing moves; each of its meshes is an entity. It has no normal maps, as no scene of poses.
    #[must_use]
    pub fn still(scene: Scene) -> Self {
        let scene = scene.without_normal_maps();
        let nodes = scene.meshes().iter().map(|mesh| (mesh.name().to_owned(), Trs::IDENTITY, None)).collect();
        let parts = scene.meshes().iter().enumerate().map(|(node, mesh)| Part::rigid(mesh, node)).collect();
        Self::new(scene, Rig::upright(nodes), parts, Vec::new(), Vec::new())
    }

    /// The scene as [`read_scene`](crate::read_scene) gives it [without poses](ScenePose::Unposed): nodes stand as the
    /// file says, and neither skins nor morph targets are applied. Triangles without area that may have one in a pose
    /// are there, normal maps are not.
    #[must_use]
    pub fn rest(&self) -> &Scene {
        &self.rest
    }

    /// The animations.
    #[must_use]
    pub fn animations(&self) -> &[Animation] {
        &self.animations
    }

    /// The index of the animation of a name, or of a number, where none has it as its name.
    ///
    /// # Errors
    /// [`SceneError::Options`] if there is no such animation, with the names of those that are there.
    pub fn animation(&self, name: &str) -> Result<usize, SceneError> {
        let by_name = self.animations.iter().position(|animation| animation.name() == Some(name));
        let by_number = || name.parse().ok().filter(|&index: &usize| index < self.animations.len());
        by_name.or_else(by_number).ok_or_else(|| self.no_animation(name))
    }

    /// The index of the animation of a number, if there are as many, whatever their names.
    ///
    /// # Errors
    /// As [`AnimatedScene::animation`].
    pub fn animation_of_number(&self, number: usize) -> Result<usize, SceneError> {
        if number < self.animations.len() { Ok(number) } else { Err(self.no_animation(&number.to_string())) }
    }

    fn no_animation(&self, asked: &str) -> SceneError {
        let named = |(index, animation): (usize, &Animation)| match animation.name() {
            Some(name) => format!("`{name}`"),
            None => format!("{index} (without a name)"),
        };
        let all: Vec<String> = self.animations.iter().enumerate().map(named).collect();
        let there = if all.is_empty() { "it has none".into() } else { format!("expected one of {}", all.join(", ")) };
        SceneError::Options(one_line(&format!("found no animation `{asked}` in the scene: {there}")))
    }

    /// What the scene consists of: the meshes of each node that shows any, in the order of the scene's meshes.
    #[must_use]
    pub fn entities(&self) -> &[Entity] {
        &self.entities
    }

    /// The entity whose node has a name; or else one of whose meshes has it, as messages name meshes; or else that of the node of this
    /// number. Of several of one name, the first.
    ///
    /// # Errors
    /// [`SceneError::Options`] if there is no such entity, with the names of those that are there.
    pub fn entity(&self, name: &str) -> Result<&Entity, SceneError> {
        let by_name = self.entities.iter().find(|entity| entity.name() == Some(name));
        let names = |entity: &Entity| self.rest.meshes()[entity.meshes()].iter().map(Mesh::name);
        let by_mesh = || self.entities.iter().find(|entity| names(entity).any(|mesh| mesh == name));
        let by_number = || name.parse().ok().and_then(|node: usize| self.entities.iter().find(|e| e.node() == node));
        by_name.or_else(by_mesh).or_else(by_number).ok_or_else(|| {
            let named = |entity: &Entity| match (entity.name(), names(entity).find(|mesh| !mesh.is_empty())) {
                (Some(name), _) => format!("`{name}`"),
                (None, Some(mesh)) => format!("`{mesh}`"),
                (None, None) => entity.node().to_string(),
            };
            let mut all: Vec<String> = self.entities.iter().take(LISTED).map(named).collect();
            if self.entities.len() > LISTED {
                all.push(format!("{} more", self.entities.len() - LISTED));
            }
            let all = all.join(", ");
            SceneError::Options(one_line(&format!("found no entity `{name}` in the scene: expected one of {all}")))
        })
    }

    /// Whether one animation moves or deforms an entity. [`Self::kinds_in`] answers for all at once.
    ///
    /// # Panics
    /// If there is no such animation.
    #[must_use]
    pub fn kind_in(&self, animation: usize, entity: &Entity) -> EntityKind {
        self.kind_of_meshes(entity.meshes(), &self.rig.moves(&self.animations[animation..][..1]))
    }

    /// Whether one animation moves or deforms each of the entities, in their order.
    ///
    /// # Panics
    /// If there is no such animation.
    #[must_use]
    pub fn kinds_in(&self, animation: usize) -> Vec<EntityKind> {
        let moves = self.rig.moves(&self.animations[animation..][..1]);
        self.entities.iter().map(|entity| self.kind_of_meshes(entity.meshes(), &moves)).collect()
    }

    /// Whether the place of each entity is a [similarity](crate::Place::nearest_similarity) at all times of one animation, or
    /// scaled to nothing for a while: no node from its own up to the root ever scales axes by different numbers. Cubic splines
    /// are bounded by their control points, so that one between even keys counts as uneven only if it might become so.
    ///
    /// # Panics
    /// If there is no such animation.
    #[must_use]
    pub fn similar_in(&self, animation: usize) -> Vec<bool> {
        let nodes = similar_nodes(&self.rig, &self.animations[animation]);
        self.entities.iter().map(|entity| nodes[entity.node]).collect()
    }

    /// The number of skins.
    #[must_use]
    pub fn skins(&self) -> usize {
        self.skins.len()
    }

    /// The name of a skin, and those of the nodes of its joints.
    ///
    /// # Panics
    /// If there is no such skin.
    #[must_use]
    pub fn skin_names(&self, skin: usize) -> (Option<&str>, Vec<Option<&str>>) {
        let Skin { name, joints, .. } = &self.skins[skin];
        (name.as_deref(), joints.iter().map(|&joint| self.rig.names[joint].as_deref()).collect())
    }

    /// The joints that carry a vertex of a mesh, as indices within its skin, with weights that sum to one; nothing if its
    /// entity has no skin.
    ///
    /// Where a node has a skin and one of its meshes no joints, that mesh moves with the node. The node then counts as one
    /// joint more, behind those of the skin: its place is [`PosedScene::place`], as those of the joints are
    /// [`PosedScene::joint_maps`].
    ///
    /// # Panics
    /// If there is no such mesh or vertex.
    pub fn influences(&self, mesh: usize, vertex: usize) -> impl Iterator<Item = (usize, f64)> {
        let part = &self.parts[mesh];
        let influences = part.skin.and(part.shape.influences.as_ref());
        let entity = &self.entities[self.entities.partition_point(|entity| entity.meshes.end <= mesh)];
        let node = entity.skin.filter(|_| influences.is_none()).map(|skin| (self.skins[skin].joints.len(), 1.0));
        influences.into_iter().flat_map(move |influences| influences.of(vertex)).chain(node)
    }

    /// An entity by itself, in its own frame: the meshes as no animation has moved or deformed them, with the morph targets
    /// that have a weight without animation, and with the same vertices and triangles. That of a skin is its shape where it
    /// was bound. Positions of a mesh that is far from its frame count from the [origin](Scene::origin) of the scene returned.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] if a coordinate is out of range.
    ///
    /// # Panics
    /// If the entity is of another scene, which has more meshes.
    pub fn own_scene(&self, entity: &Entity) -> Result<Scene, SceneError> {
        self.morphed_scene(entity, self.morph_weights(entity))
    }

    /// The scene at a time of an animation, in seconds. Before its first key and after its last one nothing moves, as glTF
    /// says; [`Animation::looped`] repeats it.
    ///
    /// Deterministic, and the same bit by bit for any number of threads. Positions count from the
    /// [origin](Scene::origin) of the scene at rest, so what moves far away from it loses digits of `f32`.
    ///
    /// # Errors
    /// [`SceneError::Options`] if there is no such animation or the time is not finite, [`SceneError::Invalid`] if
    /// coordinates become infinite or larger than 10¹⁵.
    pub fn pose(&self, animation: usize, time: f64) -> Result<PosedScene, SceneError> {
        self.pose_together(&[(animation, time)])
    }

    /// The scene without animation: nodes stand as the file says, skins follow their joints and morph targets have their
    /// weights.
    ///
    /// # Errors
    /// As [`Self::pose`].
    pub fn rest_pose(&self) -> Result<PosedScene, SceneError> {
        self.pose_together(&[])
    }

    /// The scene at times of several animations at once. Of two that animate the same, the later one in the list counts.
    ///
    /// # Errors
    /// As [`Self::pose`].
    pub fn pose_together(&self, playing: &[(usize, f64)]) -> Result<PosedScene, SceneError> {
        let mut state = self.rig.rest.clone();
        for &(index, time) in playing {
            let Some(animation) = self.animations.get(index) else {
                let count = self.animations.len();
                return Err(SceneError::Options(format!("found no animation {index}: the scene has {count}")));
            };
            if !time.is_finite() {
                return Err(SceneError::Options(format!("expected a finite time, found {time}")));
            }
            animation.apply(time, &mut state);
        }
        self.posed(&state)
    }

    /// The scene as [`SceneReadOptions::pose`](crate::SceneReadOptions::pose) asks for it.
    ///
    /// # Errors
    /// As [`Self::animation`] and [`Self::pose`].
    pub fn posed_as(&self, pose: &ScenePose) -> Result<Scene, SceneError> {
        let posed = match pose {
            ScenePose::Unposed => return Ok(self.rest.clone()),
            ScenePose::At { animation: Some(name), time } => self.pose(self.animation(name)?, *time),
            ScenePose::At { time, .. } if !self.animations.is_empty() => self.pose(0, *time),
            ScenePose::Start if !self.animations.is_empty() => self.pose(0, 0.0),
            ScenePose::At { .. } | ScenePose::Start => self.rest_pose(),
        };
        posed.map(PosedScene::into_scene)
    }

    fn posed(&self, state: &State) -> Result<PosedScene, SceneError> {
        let worlds = self.rig.worlds(state);
        let of_skins: Vec<Vec<DMat4>> = self.skins.iter().map(|skin| skin.matrices(&worlds)).collect();
        let posed = |(mesh, part): (&Mesh, &Part)| {
            let (world, weights) = (worlds[part.node], &state.weights[part.node]);
            let carrier = match part.skin {
                Some(skin) => Carrier::Joints(&of_skins[skin]),
                // What stands still is the mesh at rest, bit by bit.
                None if world == self.rest_worlds[part.node] && weights.iter().all(|&w| w == 0.0) => {
                    return Ok(mesh.clone());
                }
                None => Carrier::Node(world),
            };
            part.posed(mesh, &self.rig, carrier, weights)
        };
        let meshes = self.rest.meshes().iter().zip(&self.parts).map(posed).collect::<Result<_, _>>()?;
        let joints = self.skins.iter().map(|skin| skin.joints.clone());
        Ok(PosedScene {
            scene: self.rest.with_meshes(meshes),
            up: self.rig.up,
            skins: joints.zip(of_skins).collect(),
            worlds,
            weights: state.weights.clone(),
        })
    }

    fn found_entities(&self) -> Vec<Entity> {
        let moves = self.rig.moves(&self.animations);
        let mut entities: Vec<Entity> = Vec::new();
        let mut vertices = 0;
        for (mesh, part) in self.parts.iter().enumerate() {
            let end = vertices + self.rest.meshes()[mesh].positions().len();
            match entities.last_mut().filter(|last| last.node == part.node) {
                Some(last) => {
                    (last.meshes.end, last.vertices.end) = (mesh + 1, end);
                    last.skin = last.skin.or(part.skin);
                }
                None => entities.push(Entity {
                    name: self.rig.names[part.node].clone(),
                    node: part.node,
                    kind: EntityKind::Static,
                    meshes: mesh..mesh + 1,
                    vertices: vertices..end,
                    skin: part.skin,
                }),
            }
            vertices = end;
        }
        entities.iter_mut().for_each(|entity| entity.kind = self.kind_of_meshes(entity.meshes(), &moves));
        entities
    }

    /// What becomes of meshes of one entity: where joints carry some and the node others, they part unless all stand still.
    fn kind_of_meshes(&self, meshes: Range<usize>, moves: &Moves) -> EntityKind {
        let kinds = self.parts[meshes].iter().map(|part| self.kind_of(part, moves));
        kinds.reduce(|a, b| if a == b { a } else { EntityKind::Deformed }).unwrap_or(EntityKind::Static)
    }

    fn kind_of(&self, part: &Part, Moves { moved, morphed }: &Moves) -> EntityKind {
        match part.skin {
            _ if morphed[part.node] => EntityKind::Deformed,
            Some(skin) if self.skins[skin].joints.iter().any(|&joint| moved[joint]) => EntityKind::Deformed,
            None if moved[part.node] => EntityKind::Rigid,
            _ => EntityKind::Static,
        }
    }
}
