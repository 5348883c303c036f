//! Moving scenes: parts, read from their files, and the scene that they make at a time.

use std::path::Path;

use lobe_prt::{AlbedoMode, BakedOrScene, read_baked_or_scene};
use lobe_scene::{AnimatedScene, Entity, EntityKind, PosedScene, Scene, SceneReadOptions, built_in, read_scene};
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
        let rest = scene.rest_pose()?;
        let kind = |entity: &Entity| animation.map_or(EntityKind::Static, |k| scene.kind_in(k, entity));
        let mut parts = Vec::new();
        let still = scene.entities().iter().filter(|entity| kind(entity) == EntityKind::Static);
        let still: Vec<usize> = still.flat_map(Entity::meshes).collect();
        if !still.is_empty() {
            parts.push(MovingPart::new("still", rest.scene().part(still)?, Motion::Still));
        }
        for entity in scene.entities().iter().filter(|entity| kind(entity) != EntityKind::Static) {
            let is_rigid = kind(entity) == EntityKind::Rigid && rest.place(entity).similarity().is_some();
            let motion = if is_rigid { Motion::Node(entity.clone()) } else { Motion::Deformed(entity.clone()) };
            let name = entity.name().map_or_else(|| format!("node {}", entity.node()), str::to_owned);
            let own = scene.own_scene(entity)?;
            parts.push(MovingPart::new(name, own.part(0..own.meshes().len())?, motion));
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

    /// The same scene, no part of which hides the sky from another: what bakes of each part alone can show.
    #[must_use]
    pub fn without_occluders(&self) -> Self {
        let mut alone = self.clone();
        alone.parts.iter_mut().for_each(|part| (part.field, part.spheres) = (None, None));
        alone
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
    /// # Errors
    /// [`RenderError::Scene`] with the errors of [`AnimatedScene::pose`] and [`Scene::joined`]; [`RenderError::Options`] if
    /// the time is not finite, or if an animation shears a part then that it moved as a whole at rest.
    pub fn at(&self, time: f64) -> Result<Moment<'_>, RenderError> {
        if !time.is_finite() {
            return Err(RenderError::Options(format!("expected a finite time, found {time}")));
        }
        let posed = match &self.animated {
            Some((scene, Some(animation))) => Some(scene.pose(*animation, time)?),
            Some((scene, None)) => Some(scene.rest_pose()?),
            None => None,
        };
        let placed = self.parts.iter().map(|part| placed(part, time, posed.as_ref()));
        let placed = placed.collect::<Result<Vec<_>, RenderError>>()?;
        Moment::new(&self.parts, placed)
    }
}

/// A part at a time: its triangles in the world, its place and its spheres.
fn placed(part: &MovingPart, time: f64, posed: Option<&PosedScene>) -> Result<(Scene, PlacedPart), RenderError> {
    let rigid = |placement: Placement| -> Result<(Scene, PlacedPart), RenderError> {
        Ok((part.scene.clone().mapped(placement.rows())?, PlacedPart::rigid(part, placement)))
    };
    match (&part.motion, posed) {
        (Motion::Track(track), _) => rigid(track.at(time)),
        (Motion::Node(entity), Some(posed)) => rigid(placement_of(part, posed, entity, time)?),
        (Motion::Deformed(entity), Some(posed)) => {
            let scene = posed.scene().part(entity.meshes())?;
            let placed = PlacedPart::deformed(part, posed, entity, &scene)?;
            Ok((scene, placed))
        }
        // What stands still is bit by bit as it is.
        _ => Ok((part.scene.clone(), PlacedPart::rigid(part, Placement::IDENTITY))),
    }
}

fn placement_of(part: &MovingPart, posed: &PosedScene, entity: &Entity, time: f64) -> Result<Placement, RenderError> {
    let Some(place) = posed.place(entity).similarity() else {
        let message = format!(
            "`{}` is sheared or scaled by different numbers at {time} s, but not at rest; shadows need one or the other",
            part.name
        );
        return Err(RenderError::Options(message));
    };
    let origin = posed.scene().origin();
    let translation = [0, 1, 2].map(|k| place.translation[k] + origin[k]);
    let rotation = Rotation::from_quaternion(place.rotation).unwrap_or(Rotation::IDENTITY);
    Ok(Placement::new(translation, rotation, place.scale))
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
