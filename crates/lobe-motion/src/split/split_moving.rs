//! Splitting what moves, so that it has vertices where its parts shadow each other.

use lobe_scene::AnimatedScene;

use crate::scene::moving_part::{Motion, MovingPart};
use crate::scene::moving_scene::MovingScene;
use crate::split::split_parts::{SplitCounts, TIMES, is_bare, size_of};
use lobe_render::RenderError;

/// Edges of what moves are split to a quarter of its size, so that a limb has vertices between its ends. Shorter ones
/// show more of what spheres get wrong: they reach out of faces and not of corners, and those at a sixteenth make the
/// fox of `peers/motion` 2.6 dB worse.
const FINEST: f64 = 1.0 / 4.0;

/// The sizes of what is to be split: of parts along tracks, and by mesh of the animated scenes; infinite where edges
/// may be as long as they are.
struct Sizes {
    tracks: Vec<f64>,
    animated: Vec<f64>,
    carried: Vec<Vec<f64>>,
}

impl Sizes {
    fn of(moving: &MovingScene) -> Result<Self, RenderError> {
        let on_track = |part: &MovingPart| match part.motion {
            Motion::Track(_) if is_bare(part) => bounded(size_of(part.scene.meshes().iter())),
            _ => f64::INFINITY,
        };
        let of = |(scene, animation): (&AnimatedScene, usize)| sizes_in(scene, animation, moving.parts());
        let carried = moving
            .all_carried()
            .iter()
            .map(|carried| sizes_in(&carried.scene, carried.animation, &moving.parts()[carried.parts.clone()]));
        Ok(Self {
            tracks: moving.parts().iter().map(on_track).collect(),
            animated: moving.animation().map(of).transpose()?.unwrap_or_default(),
            carried: carried.collect::<Result<_, _>>()?,
        })
    }
}

/// A size; infinite where there is none, as a point has no edges.
fn bounded(size: f64) -> f64 {
    if size > 0.0 { size } else { f64::INFINITY }
}

/// For each mesh of an animated scene the size of the entity that it belongs to, if that is one of these parts and has
/// no transfer: at some times of the animation the largest.
fn sizes_in(scene: &AnimatedScene, animation: usize, parts: &[MovingPart]) -> Result<Vec<f64>, RenderError> {
    let mut sizes = vec![0.0_f64; scene.rest().meshes().len()];
    for k in 0..TIMES {
        let time = scene.animations()[animation].duration() * k as f64 / (TIMES - 1) as f64;
        let posed = scene.pose(animation, time)?;
        for entity in parts.iter().filter(|part| is_bare(part)).filter_map(MovingPart::entity) {
            let size = size_of(posed.scene().meshes()[entity.meshes()].iter());
            sizes[entity.meshes()].iter_mut().for_each(|largest| *largest = largest.max(size));
        }
    }
    Ok(sizes.into_iter().map(bounded).collect())
}

impl MovingScene {
    /// Splits edges of parts that move and have no transfer, to so many vertices more at most. None if there is no such
    /// part.
    pub(crate) fn split_moving(&mut self, allowed: usize) -> Result<Option<SplitCounts>, RenderError> {
        let is_split = |part: &&MovingPart| !matches!(part.motion, Motion::Still) && is_bare(part);
        let before: usize = self.parts().iter().filter(is_split).map(|part| part.scene.vertex_count()).sum();
        if before == 0 {
            return Ok(None);
        }
        let (all, sizes, mut edge) = (self.vertex_count(), Sizes::of(self)?, 1.0);
        while edge > FINEST {
            let finer = self.with_moving_edges(&sizes, 0.5 * edge)?;
            if finer.vertex_count() > all + allowed {
                break;
            }
            (*self, edge) = (finer, 0.5 * edge);
        }
        Ok(Some(SplitCounts { before, after: before + self.vertex_count() - all, edge }))
    }

    /// The same scene with edges that are no longer than a part of these sizes.
    fn with_moving_edges(&self, sizes: &Sizes, part: f64) -> Result<Self, RenderError> {
        let mut finer = self.clone();
        let split = |scene: &AnimatedScene, animation: usize, sizes: &[f64]| {
            let longest: Vec<f32> = sizes.iter().map(|size| (part * size) as f32).collect();
            scene.split_edges_of(Some(animation), &longest, "edges of what moves")
        };
        if let Some((scene, animation)) = self.animation() {
            finer.set_animated(split(scene, animation, &sizes.animated)?, None)?;
        }
        for (k, carried) in self.all_carried().iter().enumerate() {
            finer.set_animated(split(&carried.scene, carried.animation, &sizes.carried[k])?, Some(k))?;
        }
        for (own, size) in finer.parts_mut().iter_mut().zip(&sizes.tracks).filter(|(_, size)| size.is_finite()) {
            own.scene = own.scene.split_edges((part * size) as f32)?;
        }
        Ok(finer)
    }
}
