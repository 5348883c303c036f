//! Moving scenes: parts, and the scene that they make at a time.

use std::ops::Range;
use std::sync::Arc;

use lobe_prt::BakedTransfer;
use lobe_scene::{AnimatedScene, Bvh, Entity, EntityKind, PosedScene, Scene};
use lobe_sh::Rotation;
use lobe_shadow::{OcclusionField, Placement, SphereSet, Track};

use crate::scene::moment::{Moment, PlacedPart};
use crate::scene::moving_lamp::MovingLamp;
use crate::scene::moving_part::{Motion, MovingPart};
use lobe_render::RenderError;

/// A scene whose parts move: entities that are files of their own, or those of an animated glTF file.
///
/// ```
/// use lobe_motion::MovingScene;
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
    carried: Vec<Carried>,
    lamps: Vec<MovingLamp>,
    is_looped: bool,
    /// Whether what stands still has other vertices than in the animated scene.
    is_split: bool,
}

/// An animated file whose parts are carried along a track, which are these of the scene.
#[derive(Clone, Debug)]
pub(crate) struct Carried {
    pub(crate) scene: AnimatedScene,
    pub(crate) animation: usize,
    is_looped: bool,
    pub(crate) track: Track,
    pub(crate) parts: Range<usize>,
}

impl Carried {
    fn posed(&self, time: f64) -> Result<PosedScene, RenderError> {
        let animation = &self.scene.animations()[self.animation];
        Ok(self.scene.pose(self.animation, if self.is_looped { animation.looped(time) } else { time })?)
    }
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
        Ok(Self { parts, ..Self::without_parts() })
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
        Ok(Self { parts, animated: Some((scene, animation)), ..Self::without_parts() })
    }

    /// A scene to which parts are added.
    pub(crate) fn without_parts() -> Self {
        Self {
            parts: Vec::new(),
            animated: None,
            carried: Vec::new(),
            lamps: Vec::new(),
            is_looped: false,
            is_split: false,
        }
    }

    /// Adds a part that no animation moves.
    pub(crate) fn add(&mut self, part: MovingPart) {
        self.parts.push(part);
    }

    /// Adds the parts of an animated scene, which a track carries as a whole. If its file is baked, what its animation
    /// leaves at rest [keeps](Self::keep_transfer) the transfer.
    pub(crate) fn add_animated(
        &mut self,
        name: &str,
        (scene, animation, is_looped): (AnimatedScene, usize, bool),
        baked: Option<&BakedTransfer>,
        track: Track,
    ) -> Result<(), RenderError> {
        let first = self.parts.len();
        let mut animated = Self::animated(scene.clone(), Some(animation))?;
        if let Some(BakedTransfer { transfer, recipe, .. }) = baked {
            animated.keep_transfer(transfer, &recipe.bake_options(), &recipe.pose());
        }
        for mut part in animated.parts {
            // What its animation leaves at rest moves along the track all the same.
            if matches!(part.motion, Motion::Still) {
                part.motion = Motion::Track(track.clone());
            }
            part.name = format!("{name}: {}", part.name);
            self.parts.push(part);
        }
        self.carried.push(Carried { scene, animation, is_looped, track, parts: first..self.parts.len() });
        Ok(())
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
        alone.parts.iter_mut().for_each(|part| (part.field, part.spheres, part.visibility) = (None, None, None));
        alone
    }

    /// The same scene with these lamps instead of its own. They light it beside the distant light, and are not seen
    /// themselves.
    #[must_use]
    pub fn with_lamps(self, lamps: Vec<MovingLamp>) -> Self {
        Self { lamps, ..self }
    }

    /// The lamps.
    #[must_use]
    pub fn lamps(&self) -> &[MovingLamp] {
        &self.lamps
    }

    pub(crate) fn lamps_mut(&mut self) -> &mut [MovingLamp] {
        &mut self.lamps
    }

    /// The animated scene whose entities are the parts.
    pub(crate) fn animated_scene(&self) -> Option<&AnimatedScene> {
        self.animated.as_ref().map(|(scene, _)| scene)
    }

    /// Gives a part its occlusion field, in place of one that would be baked.
    ///
    /// # Panics
    /// If there is no such part.
    pub fn set_field(&mut self, part: usize, field: Arc<OcclusionField>) {
        self.parts[part].field = Some(field);
    }

    /// Gives a part its spheres, in place of some that would be fitted.
    ///
    /// # Panics
    /// If there is no such part.
    pub fn set_spheres(&mut self, part: usize, spheres: Arc<SphereSet>) {
        self.parts[part].spheres = Some(spheres);
    }

    pub(crate) fn parts_mut(&mut self) -> &mut [MovingPart] {
        &mut self.parts
    }

    /// Puts an animated scene with more vertices in the place of the own one, or of one that a track carries, and its
    /// entities in that of the parts.
    pub(crate) fn set_animated(&mut self, finer: AnimatedScene, carried: Option<usize>) -> Result<(), RenderError> {
        let own = carried.map_or(0..self.parts.len(), |k| self.carried[k].parts.clone());
        for part in &mut self.parts[own] {
            let (Motion::Node(old) | Motion::Deformed(old)) = &mut part.motion else { continue };
            if let Some(entity) = finer.entities().iter().find(|entity| entity.node() == old.node()) {
                part.scene = finer.own_scene(entity)?;
                *old = entity.clone();
            }
        }
        match carried {
            Some(k) => self.carried[k].scene = finer,
            None => self.animated.iter_mut().for_each(|(scene, _)| *scene = finer.clone()),
        }
        Ok(())
    }

    /// What stands still has its triangles from the part from now on.
    pub(crate) fn set_split(&mut self) {
        self.is_split = true;
    }

    /// The animated scene that moves a part.
    pub(crate) fn rig_of(&self, part: usize) -> Option<&AnimatedScene> {
        let carried = self.carried.iter().find(|carried| carried.parts.contains(&part)).map(|carried| &carried.scene);
        carried.or(self.animated.as_ref().map(|(scene, _)| scene))
    }

    /// The seconds from the first to the last key: of all tracks, those of lamps too, or of the animation. `[0, 0]` if
    /// nothing moves.
    #[must_use]
    pub fn span(&self) -> [f64; 2] {
        let of_animation =
            self.animated.iter().filter_map(|(scene, k)| Some([0.0, scene.animations()[(*k)?].duration()]));
        let of_tracks = self.parts.iter().filter_map(|part| match &part.motion {
            Motion::Track(track) => Some(track.span()),
            _ => None,
        });
        let of_carried = self.carried.iter().flat_map(|carried| {
            [carried.track.span(), [0.0, carried.scene.animations()[carried.animation].duration()]]
        });
        let of_lamps = self.lamps.iter().map(|lamp| lamp.track.span());
        let spans = of_animation.chain(of_tracks).chain(of_carried).chain(of_lamps);
        spans.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]).unwrap_or_default()
    }

    /// The same scene, which begins anew at the end of its [span](Self::span) instead of resting there, or not.
    #[must_use]
    pub fn looped(self, is_looped: bool) -> Self {
        Self { is_looped, ..self }
    }

    /// The time within the span that counts at a time.
    pub(crate) fn within(&self, time: f64) -> f64 {
        let [begin, end] = self.span();
        if !self.is_looped || begin >= end {
            return time;
        }
        // Halves of finite numbers have a finite difference.
        let length = 2.0 * (0.5 * end - 0.5 * begin);
        let within = begin + (time - begin).rem_euclid(length);
        if within < end { within } else { begin }
    }

    /// The animated scene whose entities are the parts, and which of its animations moves them.
    pub(crate) fn animation(&self) -> Option<(&AnimatedScene, usize)> {
        self.animated.as_ref().and_then(|(scene, animation)| Some((scene, (*animation)?)))
    }

    /// The animated scenes that tracks carry.
    pub(crate) fn all_carried(&self) -> &[Carried] {
        &self.carried
    }

    /// The animated scenes that tracks carry at a time, with their parts and where the track is.
    pub(crate) fn carried(&self, time: f64) -> impl Iterator<Item = Result<CarriedPose, RenderError>> {
        let time = self.within(time);
        self.carried
            .iter()
            .map(move |carried| Ok((carried.parts.clone(), carried.posed(time)?, carried.track.at(time))))
    }

    /// The scene at a time, in seconds; outside of [`MovingScene::span`] it rests, or begins anew if it is
    /// [looped](Self::looped).
    ///
    /// All parts are there at all times, with the same triangles in the same order: one that an animation scales to
    /// nothing is a point, which no ray hits and which hides nothing. For one time after the other,
    /// [`MovingScene::moments`] takes less time.
    ///
    /// # Errors
    /// [`RenderError::Scene`] with the errors of [`AnimatedScene::pose`] and [`Scene::joined`];
    /// [`RenderError::Options`] if the time is not finite.
    pub fn at(&self, time: f64) -> Result<Moment<'_>, RenderError> {
        self.at_with(time, None)
    }

    /// The same with the tree of another moment, which is [refit](Bvh::update): as [`MovingScene::moments`] does, for
    /// one who changes the scene between.
    ///
    /// # Errors
    /// As [`MovingScene::at`].
    pub fn at_with(&self, time: f64, tree: Option<Bvh>) -> Result<Moment<'_>, RenderError> {
        let (scene, placed) = self.placed_at(time)?;
        let bvh = match tree {
            Some(mut bvh) => {
                bvh.update(&scene);
                bvh
            }
            None => Bvh::new(&scene),
        };
        let lamps = self.lamps.iter().map(|lamp| lamp.placed_at(self.within(time))).collect::<Result<_, _>>()?;
        Ok(Moment::new(&self.parts, (scene, bvh), placed, lamps))
    }

    /// The smallest box around the scene at a time, in the world: the corners of the smallest and of the largest
    /// coordinates. It makes no tree and places no part.
    ///
    /// # Errors
    /// As [`MovingScene::at`].
    pub fn world_bounds(&self, time: f64) -> Result<[[f64; 3]; 2], RenderError> {
        let carried = self.carried(time).collect::<Result<Vec<_>, _>>()?;
        Ok(self.scene_at(time, self.posed(time)?.as_ref(), &carried)?.world_bounds())
    }

    /// All triangles in the world at a time, and where the parts are.
    pub(crate) fn placed_at(&self, time: f64) -> Result<(Scene, Vec<PlacedPart>), RenderError> {
        let posed = self.posed(time)?;
        let carried = self.carried(time).collect::<Result<Vec<_>, _>>()?;
        let scene = self.scene_at(time, posed.as_ref(), &carried)?;
        let time = self.within(time);
        let placed = self.parts.iter().enumerate().map(|(index, part)| match carrier(&carried, index, part) {
            Some((_, posed, by)) => Ok(placed(part, time, Some(posed))?.carried(by)),
            None => placed(part, time, posed.as_ref()),
        });
        Ok((scene, placed.collect::<Result<_, RenderError>>()?))
    }

    /// The animated scene at a time.
    pub(crate) fn posed(&self, time: f64) -> Result<Option<PosedScene>, RenderError> {
        if !time.is_finite() {
            return Err(RenderError::Options(format!("expected a finite time, found {time}")));
        }
        let time = self.within(time);
        Ok(match &self.animated {
            Some((scene, Some(animation))) => Some(scene.pose(*animation, time)?),
            Some((scene, None)) => Some(scene.rest_pose()?),
            None => None,
        })
    }

    /// All triangles in the world at a time: those of the pose as they are, in the order of the parts.
    fn scene_at(&self, time: f64, posed: Option<&PosedScene>, carried: &[CarriedPose]) -> Result<Scene, RenderError> {
        if let Some(posed) = posed {
            let moving: Vec<usize> =
                self.parts.iter().filter_map(MovingPart::entity).flat_map(Entity::meshes).collect();
            let mut is_still = vec![true; posed.scene().meshes().len()];
            moving.iter().for_each(|&mesh| is_still[mesh] = false);
            if self.is_split {
                let split = self.parts.iter().filter(|part| part.entity().is_none()).map(|part| part.scene.clone());
                let moving = (!moving.is_empty()).then(|| posed.scene().part(moving)).transpose()?;
                return Ok(Scene::joined(split.chain(moving))?);
            }
            let still = (0..is_still.len()).filter(|&mesh| is_still[mesh]);
            return Ok(posed.scene().part(still.chain(moving))?);
        }
        let time = self.within(time);
        let scene = |(index, part): (usize, &MovingPart)| match (&part.motion, carrier(carried, index, part)) {
            (Motion::Node(entity) | Motion::Deformed(entity), Some((_, posed, by))) => {
                posed.scene().part(entity.meshes())?.mapped(by.rows())
            }
            (Motion::Track(track), _) => part.scene.clone().mapped(track.at(time).rows()),
            // What stands still is bit by bit as it is.
            _ => Ok(part.scene.clone()),
        };
        let scenes = self.parts.iter().enumerate().map(scene).collect::<Result<Vec<_>, _>>()?;
        Ok(Scene::joined(scenes)?)
    }
}

/// The parts of an animated scene that a track carries, its pose, and where the track is.
type CarriedPose = (Range<usize>, PosedScene, Placement);

/// What carries a part that is an entity.
fn carrier<'a>(carried: &'a [CarriedPose], index: usize, part: &MovingPart) -> Option<&'a CarriedPose> {
    carried.iter().find(|(parts, ..)| parts.contains(&index) && part.entity().is_some())
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
