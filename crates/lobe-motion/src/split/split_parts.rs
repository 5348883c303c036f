//! Splitting triangles of a scene that moves, so that it has vertices where shadows fall.

use derive_setters::Setters;
use lobe_io::Job;
use lobe_prt::{AdaptiveOptions, split_adaptively};
use lobe_scene::{Bvh, Mesh, Scene};

use crate::scene::moving_part::{Motion, MovingPart};
use crate::scene::moving_scene::MovingScene;
use lobe_render::RenderError;

/// Times of the span at which it is seen where parts are.
pub(crate) const TIMES: usize = 33;

/// Edges of what stands still are split to a sixteenth of the size of what moves where it comes, and of the distance
/// from it elsewhere: shadows are the softer the farther what throws them is.
const FINEST: f64 = 1.0 / 16.0;

/// The part of the vertices that are allowed which go to what moves.
const FOR_WHAT_MOVES: f64 = 0.5;

/// The part of the vertices of what stands still which go to shadows of what moves; the others go where the own
/// transfer of a part asks for them.
const FOR_SHADOWS: f64 = 0.5;

/// Options of [`MovingScene::split`].
#[derive(Clone, Debug, Default, PartialEq, Setters)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[non_exhaustive]
pub struct MovingSplitOptions {
    /// Of splits by transfer; the vertices that they allow are those of the whole scene.
    pub adaptive: AdaptiveOptions,
}

/// What became of a split: of what moves, and of what stands still. None of what was not to be split.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct MovingSplitReport {
    /// Parts that move.
    pub moving: Option<SplitCounts>,
    /// Parts that stand still.
    pub still: Option<SplitCounts>,
}

/// Vertices before and after a split.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct SplitCounts {
    /// Vertices before.
    pub before: usize,
    /// And after.
    pub after: usize,
    /// How long edges are at most, as a part of the size of what moves, there where it is.
    pub edge: f64,
}

/// A place of what moves: a box, and half of its diagonal.
struct Moved {
    bounds: [[f64; 3]; 2],
    size: f64,
}

/// The smallest box around meshes, and half of its diagonal; none without vertices.
fn bounds_of<'a>(meshes: impl Iterator<Item = &'a Mesh>, origin: [f64; 3]) -> Option<Moved> {
    let [mut min, mut max] = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    for p in meshes.flat_map(Mesh::positions) {
        for axis in 0..3 {
            let x = f64::from(p[axis]) + origin[axis];
            (min[axis], max[axis]) = (min[axis].min(x), max[axis].max(x));
        }
    }
    let size = 0.5 * (0..3).map(|k| (max[k] - min[k]).powi(2)).sum::<f64>().sqrt();
    (min[0] <= max[0]).then_some(Moved { bounds: [min, max], size })
}

/// Half of the diagonal of the box around meshes.
pub(crate) fn size_of<'a>(meshes: impl Iterator<Item = &'a Mesh>) -> f64 {
    bounds_of(meshes, [0.0; 3]).map_or(0.0, |moved| moved.size)
}

impl Moved {
    /// The scale of its shadow at a point: its size, and its distance.
    fn scale_at(&self, p: [f64; 3]) -> f64 {
        let [min, max] = &self.bounds;
        let off = |k: usize| (min[k] - p[k]).max(p[k] - max[k]).max(0.0);
        self.size + (0..3).map(|k| off(k).powi(2)).sum::<f64>().sqrt()
    }
}

/// Whether a part came without transfer, which its vertices would have to keep.
pub(crate) fn is_bare(part: &MovingPart) -> bool {
    part.transfer.is_none() && part.kept.is_none()
}

impl MovingScene {
    /// Splits the triangles of parts that have no transfer yet. The vertices that this makes are of
    /// [moments](Self::at), too; the surface of no part changes.
    ///
    /// Edges of what moves end at a quarter of its `size`, half of the diagonal of its box. Triangles that stand still
    /// are split first where shadows of what moves fall, then where their own transfer asks for it, see
    /// [`split_adaptively`]; under shadows edges end at a sixteenth of `size + distance`, of what moves and to it. What
    /// moves takes half of the vertices that are allowed at most, shadows half of the rest. Where these do not suffice,
    /// edges stay longer, everywhere by the same factor.
    ///
    /// # Errors
    /// [`RenderError::Prt`] with those of [`split_adaptively`], [`RenderError::Cancelled`] if the watch of the job said
    /// to stop, and those of [`Self::at`].
    pub fn split(&mut self, options: &MovingSplitOptions, mut job: Job<'_>) -> Result<MovingSplitReport, RenderError> {
        job.expect_no_checkpoint().map_err(RenderError::Options)?;
        let all: usize = self.vertex_count();
        let allowed = options.adaptive.budget(all).saturating_sub(all);
        let moving = self.split_moving((FOR_WHAT_MOVES * allowed as f64) as usize)?;
        let left = allowed.saturating_sub(self.vertex_count() - all);
        let still = self.split_still(&options.adaptive, left, &mut job)?;
        Ok(MovingSplitReport { moving, still })
    }

    /// The vertices of all parts.
    pub(crate) fn vertex_count(&self) -> usize {
        self.parts().iter().map(|part| part.scene.vertex_count()).sum()
    }

    /// Splits what stands still and has no transfer, if there is such a part, to so many vertices more.
    fn split_still(
        &mut self,
        adaptive: &AdaptiveOptions,
        mut left: usize,
        job: &mut Job<'_>,
    ) -> Result<Option<SplitCounts>, RenderError> {
        let is_split = |part: &MovingPart| matches!(part.motion, Motion::Still) && is_bare(part);
        let still: Vec<usize> = (0..self.parts().len()).filter(|k| is_split(&self.parts()[*k])).collect();
        if still.is_empty() {
            return Ok(None);
        }
        let moved = self.moved()?;
        let mut counts = SplitCounts { edge: FINEST, ..SplitCounts::default() };
        for (done, &index) in still.iter().enumerate() {
            // Each part has its share of what those before it left.
            let own = &self.parts()[index].scene;
            let (before, allowed) = (own.vertex_count(), left / (still.len() - done));
            let (scene, edge) = graded(own, &moved, before + (FOR_SHADOWS * allowed as f64) as usize)?;
            let adaptive = adaptive.clone().max_vertices(Some(before + allowed));
            let (scene, _) = split_adaptively(&scene, &Bvh::new(&scene), &adaptive, job.reborrow())?;
            let after = scene.vertex_count();
            left = left.saturating_sub(after - before);
            counts = SplitCounts {
                before: counts.before + before,
                after: counts.after + after,
                edge: counts.edge.max(edge),
            };
            self.parts_mut()[index].scene = scene;
        }
        self.set_split();
        Ok(Some(counts))
    }

    /// Where the parts that move are, at some times.
    fn moved(&self) -> Result<Vec<Moved>, RenderError> {
        let [begin, end] = self.span();
        let mut moved = Vec::new();
        for k in 0..TIMES {
            let part = k as f64 / (TIMES - 1) as f64;
            let (scene, _) = self.placed_at((1.0 - part) * begin + part * end)?;
            let mut meshes = scene.meshes().iter();
            for part in self.parts() {
                let own = meshes.by_ref().take(part.scene.meshes().len());
                let found = bounds_of(own, scene.origin());
                moved.extend(found.filter(|_| !matches!(part.motion, Motion::Still)));
            }
        }
        Ok(moved)
    }
}

/// A scene whose edges are short where shadows of what moves fall, and how short; as far as so many vertices allow.
fn graded(scene: &Scene, moved: &[Moved], most: usize) -> Result<(Scene, f64), RenderError> {
    let (mut found, mut edge) = (scene.clone(), 1.0);
    if moved.is_empty() {
        return Ok((found, FINEST));
    }
    while edge > FINEST {
        let finer = 0.5 * edge;
        let Some(next) = with_edges(&found, moved, finer, most)? else { break };
        (found, edge) = (next, finer);
    }
    Ok((found, edge))
}

/// A scene without edges that are longer than a part of the scale of shadows there; none if that takes too many
/// vertices.
fn with_edges(scene: &Scene, moved: &[Moved], part: f64, most: usize) -> Result<Option<Scene>, RenderError> {
    let mut found = scene.clone();
    loop {
        let origin = found.origin();
        let is_long = |mesh: usize, ends: [u32; 2]| {
            let positions = found.meshes()[mesh].positions();
            let [a, b] = ends.map(|v| positions[v as usize].map(f64::from));
            let length = (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt();
            let middle = std::array::from_fn(|k| 0.5 * (a[k] + b[k]) + origin[k]);
            // The nearest end of a long edge may be much nearer than its middle.
            let scale = |moved: &Moved| (moved.scale_at(middle) - 0.5 * length).max(moved.size);
            moved.iter().any(|moved| length > part * scale(moved))
        };
        let (finer, _) = found.halve_edges(is_long)?;
        if finer.vertex_count() > most {
            return Ok(None);
        }
        if finer.vertex_count() == found.vertex_count() {
            return Ok(Some(found));
        }
        found = finer;
    }
}
