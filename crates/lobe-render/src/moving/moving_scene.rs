//! Moving scenes: parts, read from their files, and the scene that they make at a time.

use std::path::Path;

use lobe_prt::{AlbedoMode, BakedOrScene, read_baked_or_scene};
use lobe_scene::{AnimatedScene, Bvh, Entity, EntityKind, PosedScene, Scene, SceneReadOptions, built_in, read_scene};
use lobe_sh::Rotation;
use lobe_shadow::{Placement, SceneDescription, read_field, read_spheres};

use crate::moving::moment::{Moment, PlacedPart};
use crate::{Motion, MovingPart, RenderError};

/// A scene whose parts move: entities that are files of their own, or those of an animated glTF file.
///
/// ```
/// use lobe_render::MovingScene;
/// use lobe_scene::built_in;
///
/// let moving = MovingScene::animated(built_in::three_objects(8), Some(0))?;
/// assert_eq!(moving.parts().len(), 4, "a ground and three objects");
/// let [begin, end] = moving.span();
/// let vertices = moving.at(0.5 * (begin + end))?.scene().vertex_count();
/// assert_eq!(vertices, moving.at(begin)?.scene().vertex_count());
/// # Ok::<(), lobe_render::RenderError>(())
/// ```
#[derive(Clone, Debug)]
pub struct MovingScene {
    parts: Vec<MovingPart>,
    /// What moves the parts that are entities of a file, and which of its animations.
    animated: Option<(AnimatedScene, Option<usize>)>,
}

impl MovingScene {
    /// A scene of parts that move along tracks or stand still.
    ///
    /// # Errors
    /// [`RenderError::Options`] without any part, or if one is moved by an animation.
    pub fn new(parts: Vec<MovingPart>) -> Result<Self, RenderError> {
        if parts.is_empty() {
            return Err(RenderError::Options("expected a part of a moving scene, found none".to_owned()));
        }
        if parts.iter().any(|part| part.entity().is_some()) {
            return Err(RenderError::Options(
                "expected parts that move along tracks, found one of an animation".into(),
            ));
        }
        Ok(Self { parts, animated: None })
    }

    /// The entities of an animated scene, moved by one of its animations or as they stand: all that stands still is one
    /// part, the first.
    ///
    /// # Errors
    /// [`RenderError::Scene`] with those of [`AnimatedScene::own_scene`].
    ///
    /// # Panics
    /// If there is no such animation.
    pub fn animated(scene: AnimatedScene, animation: Option<usize>) -> Result<Self, RenderError> {
        let count = scene.entities().len();
        let kinds = animation.map_or_else(|| vec![EntityKind::Static; count], |k| scene.kinds_in(k));
        let similar = animation.map_or_else(|| vec![true; count], |k| scene.similar_in(k));
        let (mut still, mut parts) = (Vec::new(), Vec::new());
        for ((entity, kind), is_similar) in scene.entities().iter().zip(kinds).zip(similar) {
            let motion = match kind {
                EntityKind::Static => {
                    still.extend(entity.meshes());
                    continue;
                }
                EntityKind::Rigid if is_similar => Motion::Node(entity.clone()),
                _ => Motion::Deformed(entity.clone()),
            };
            let name = entity.name().map_or_else(|| format!("node {}", entity.node()), str::to_owned);
            parts.push(MovingPart::new(name, scene.own_scene(entity)?, motion));
        }
        if !still.is_empty() {
            let still = scene.rest_pose()?.scene().part(still)?;
            parts.insert(0, MovingPart::new("still", still, Motion::Still));
        }
        Ok(Self { parts, animated: Some((scene, animation)) })
    }

    /// Reads a [description](SceneDescription) and the files that it names. Of baked .glb files the transfer is read too.
    /// With the scene come notes on what is not read of its files.
    ///
    /// # Errors
    /// [`RenderError::Shadow`], [`RenderError::Prt`] and [`RenderError::Scene`] with those of the readers.
    pub fn read(path: impl AsRef<Path>, options: &SceneReadOptions) -> Result<(Self, Vec<String>), RenderError> {
        let description = SceneDescription::read(path, options.allow_outside)?;
        let (mut notes, mut parts) = (Vec::new(), Vec::new());
        if let Some(file) = &description.still {
            parts.push(read_part(file, "still", Motion::Still, options, &mut notes)?);
        }
        for entity in description.entities {
            let mut part = read_part(&entity.mesh, &entity.name, Motion::Track(entity.track), options, &mut notes)?;
            part.field = entity.field.as_ref().map(read_field).transpose()?;
            part.spheres = entity.spheres.as_ref().map(read_spheres).transpose()?;
            parts.push(part);
        }
        Ok((Self::new(parts)?, notes))
    }

    /// The parts. Their vertices, one part after the other, are those of the scene at any time.
    #[must_use]
    pub fn parts(&self) -> &[MovingPart] {
        &self.parts
    }

    pub(crate) fn parts_mut(&mut self) -> &mut [MovingPart] {
        &mut self.parts
    }

    /// The animated scene that moves parts.
    pub(crate) fn rig(&self) -> Option<&AnimatedScene> {
        self.animated.as_ref().map(|(scene, _)| scene)
    }

    /// The seconds from the first to the last key: of all tracks, or of the animation. `[0, 0]` if nothing moves.
    #[must_use]
    pub fn span(&self) -> [f64; 2] {
        let of_animation =
            self.animated.iter().filter_map(|(scene, k)| Some([0.0, scene.animations()[(*k)?].duration()]));
        let of_tracks = self.parts.iter().filter_map(|part| match &part.motion {
            Motion::Track(track) => Some(track.span()),
            _ => None,
        });
        let spans = of_animation.chain(of_tracks);
        spans.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]).unwrap_or_default()
    }

    /// The scene at a time, in seconds; outside of [`MovingScene::span`] it rests.
    ///
    /// All parts are there at all times, with the same triangles in the same order: one that an animation scales to nothing is
    /// a point, which no ray hits and which hides nothing. For one time after the other, [`MovingScene::moments`] takes less
    /// time.
    ///
    /// # Errors
    /// [`RenderError::Scene`] with the errors of [`AnimatedScene::pose`] and [`Scene::joined`]; [`RenderError::Options`] if
    /// the time is not finite.
    pub fn at(&self, time: f64) -> Result<Moment<'_>, RenderError> {
        let (scene, placed) = self.placed_at(time)?;
        let bvh = Bvh::new(&scene);
        Ok(Moment::new(&self.parts, (scene, bvh), placed))
    }

    /// The smallest box around the scene at a time, in the world: the corners of the smallest and of the largest coordinates.
    /// It makes no tree and places no part.
    ///
    /// # Errors
    /// As [`MovingScene::at`].
    pub fn bounds(&self, time: f64) -> Result<[[f64; 3]; 2], RenderError> {
        Ok(self.scene_at(time, self.posed(time)?.as_ref())?.world_bounds())
    }

    /// All triangles in the world at a time, and where the parts are.
    pub(crate) fn placed_at(&self, time: f64) -> Result<(Scene, Vec<PlacedPart>), RenderError> {
        let posed = self.posed(time)?;
        let scene = self.scene_at(time, posed.as_ref())?;
        let placed = self.parts.iter().map(|part| placed(part, time, posed.as_ref()));
        Ok((scene, placed.collect::<Result<_, _>>()?))
    }

    /// The animated scene at a time.
    pub(crate) fn posed(&self, time: f64) -> Result<Option<PosedScene>, RenderError> {
        if !time.is_finite() {
            return Err(RenderError::Options(format!("expected a finite time, found {time}")));
        }
        Ok(match &self.animated {
            Some((scene, Some(animation))) => Some(scene.pose(*animation, time)?),
            Some((scene, None)) => Some(scene.rest_pose()?),
            None => None,
        })
    }

    /// All triangles in the world at a time: those of the pose as they are, in the order of the parts.
    fn scene_at(&self, time: f64, posed: Option<&PosedScene>) -> Result<Scene, RenderError> {
        if let Some(posed) = posed {
            let moving: Vec<usize> =
                self.parts.iter().filter_map(MovingPart::entity).flat_map(Entity::meshes).collect();
            let mut is_still = vec![true; posed.scene().meshes().len()];
            moving.iter().for_each(|&mesh| is_still[mesh] = false);
            let still = (0..is_still.len()).filter(|&mesh| is_still[mesh]);
            return Ok(posed.scene().part(still.chain(moving))?);
        }
        let scene = |part: &MovingPart| match &part.motion {
            Motion::Track(track) => part.scene.clone().mapped(track.at(time).rows()),
            // What stands still is bit by bit as it is.
            _ => Ok(part.scene.clone()),
        };
        let scenes = self.parts.iter().map(scene).collect::<Result<Vec<_>, _>>()?;
        Ok(Scene::joined(scenes)?)
    }
}

/// The scale of a part that an animation scales to nothing, or to less: its solid angle is then below a rounding from
/// wherever it is seen, and its surface still has a place.
const NOTHING: f64 = 1e-12;

/// Where a part is at a time, with its spheres.
fn placed(part: &MovingPart, time: f64, posed: Option<&PosedScene>) -> Result<PlacedPart, RenderError> {
    match (&part.motion, posed) {
        (Motion::Track(track), _) => Ok(PlacedPart::rigid(part, track.at(time))),
        (Motion::Node(entity), Some(posed)) => Ok(PlacedPart::rigid(part, placement_of(posed, entity))),
        (Motion::Deformed(entity), Some(posed)) => {
            PlacedPart::deformed(part, posed, entity, &posed.scene().part(entity.meshes())?)
        }
        _ => Ok(PlacedPart::rigid(part, Placement::IDENTITY)),
    }
}

/// The place of an entity that is a similarity at all times, or nothing.
fn placement_of(posed: &PosedScene, entity: &Entity) -> Placement {
    let place = posed.place(entity);
    let (rotation, scale) = match place.nearest_similarity() {
        Some(found) => (Rotation::from_quaternion(found.rotation).ok(), found.scale.max(NOTHING)),
        None => (None, NOTHING),
    };
    let (origin, own) = (posed.scene().origin(), place.translation());
    Placement::new([0, 1, 2].map(|k| own[k] + origin[k]), rotation.unwrap_or(Rotation::IDENTITY), scale)
}

/// Reads the triangles of a part, and their transfer if the file is baked.
fn read_part(
    file: &Path,
    name: &str,
    motion: Motion,
    options: &SceneReadOptions,
    notes: &mut Vec<String>,
) -> Result<MovingPart, RenderError> {
    let path = file.display().to_string();
    if let Some(known) = path.strip_prefix("built-in:") {
        let scene = built_in::named(known).ok_or_else(|| {
            RenderError::invalid(file, format!("there is no such scene; there are {}", built_in::NAMES.join(", ")))
        })?;
        return Ok(MovingPart::new(name, scene, motion));
    }
    let is_gltf = file.extension().is_some_and(|e| e.eq_ignore_ascii_case("glb") || e.eq_ignore_ascii_case("gltf"));
    let read = match is_gltf {
        true => read_baked_or_scene(file, options)?,
        false => read_scene(file, options).map(|(scene, report)| BakedOrScene::Scene(scene, report))?,
    };
    let (part, report) = match read {
        BakedOrScene::Baked(baked) => {
            let is_demodulated = baked.recipe.bake_options().albedo == AlbedoMode::None;
            let part = MovingPart::new(name, baked.scene, motion);
            (MovingPart { transfer: Some(baked.transfer), is_demodulated, ..part }, baked.report)
        }
        BakedOrScene::Scene(scene, report) => (MovingPart::new(name, scene, motion), report),
    };
    notes.extend(report.notes.iter().map(|note| format!("{path}: {note}")));
    Ok(part)
}
