//! Splitting what stands still, so that it has vertices where shadows of what moves fall.

use derive_setters::Setters;
use lobe_io::Job;
use lobe_prt::{AdaptiveOptions, split_adaptively};
use lobe_scene::{Bvh, Mesh, Scene};

use crate::{Motion, MovingPart, MovingScene, RenderError};

/// Times of the span at which it is seen where parts are.
const TIMES: usize = 33;

/// Edges are split to a sixteenth of the size of what moves where it is, and of the distance from it elsewhere: shadows
/// are the softer the farther what throws them is.
const FINEST: f64 = 1.0 / 16.0;

/// The part of the vertices that are allowed which go to shadows of what moves; the others go where the own transfer of
/// a part asks for them.
const FOR_SHADOWS: f64 = 0.5;

/// Options of [`MovingScene::split_still`].
#[derive(Clone, Debug, Default, PartialEq, Setters)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[non_exhaustive]
pub struct StillSplitOptions {
    /// Of splits by transfer; the vertices that they allow are those of the whole scene.
    pub adaptive: AdaptiveOptions,
}

/// What became of a split.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct StillSplitReport {
    /// Vertices of what was split, before.
    pub before: usize,
    /// And after.
    pub after: usize,
    /// How long edges are, as a part of the size of what moves where it is.
    pub edge: f64,
}

/// A place of what moves: a box, and half of its diagonal.
struct Moved {
    bounds: [[f64; 3]; 2],
    size: f64,
}

impl Moved {
    fn of(bounds: [[f64; 3]; 2]) -> Self {
        let [min, max] = bounds;
        Self { bounds, size: 0.5 * (0..3).map(|k| (max[k] - min[k]).powi(2)).sum::<f64>().sqrt() }
    }

    /// The scale of its shadow at a point: its size, and its distance.
    fn scale_at(&self, p: [f64; 3]) -> f64 {
        let [min, max] = &self.bounds;
        let off = |k: usize| (min[k] - p[k]).max(p[k] - max[k]).max(0.0);
        self.size + (0..3).map(|k| off(k).powi(2)).sum::<f64>().sqrt()
    }
}

impl MovingScene {
    /// Splits the triangles of parts that stand still and have no transfer yet: first where shadows of what moves fall,
    /// the finer the nearer it comes, then where their own transfer asks for it, see [`split_adaptively`]. The vertices
    /// that this makes are of [moments](Self::at), too.
    ///
    /// Edges end at a sixteenth of `size + distance`, of what moves and to it. Where that takes more than half of the
    /// vertices that are allowed, they stay longer, everywhere by the same factor. `None` if there is nothing to split:
    /// nothing stands still, or all of it came with its transfer.
    ///
    /// # Errors
    /// [`RenderError::Prt`] with those of [`split_adaptively`], [`RenderError::Cancelled`] if the watch of the job said
    /// to stop, and those of [`Self::at`].
    pub fn split_still(
        &mut self,
        options: &StillSplitOptions,
        mut job: Job<'_>,
    ) -> Result<Option<StillSplitReport>, RenderError> {
        job.expect_no_checkpoint().map_err(RenderError::Options)?;
        let is_bare = |part: &MovingPart| part.transfer.is_none() && part.kept.is_none();
        let is_split = |part: &MovingPart| matches!(part.motion, Motion::Still) && is_bare(part);
        let still: Vec<usize> = (0..self.parts().len()).filter(|k| is_split(&self.parts()[*k])).collect();
        if still.is_empty() {
            return Ok(None);
        }
        let moved = self.moved()?;
        let all: usize = self.parts().iter().map(|part| part.scene.vertex_count()).sum();
        let mut left = options.adaptive.budget(all).saturating_sub(all);
        let mut report = StillSplitReport { edge: FINEST, ..StillSplitReport::default() };
        for (done, &index) in still.iter().enumerate() {
            // Each part has its share of what those before it left.
            let own = &self.parts()[index].scene;
            let (before, allowed) = (own.vertex_count(), left / (still.len() - done));
            let (scene, edge) = graded(own, &moved, before + (FOR_SHADOWS * allowed as f64) as usize)?;
            let adaptive = options.adaptive.clone().max_vertices(Some(before + allowed));
            let (scene, _) = split_adaptively(&scene, &Bvh::new(&scene), &adaptive, job.reborrow())?;
            let after = scene.vertex_count();
            left = left.saturating_sub(after - before);
            report = StillSplitReport {
                before: report.before + before,
                after: report.after + after,
                edge: report.edge.max(edge),
            };
            self.parts_mut()[index].scene = scene;
        }
        self.set_split();
        Ok(Some(report))
    }

    /// Where the parts that move are, at some times.
    fn moved(&self) -> Result<Vec<Moved>, RenderError> {
        let [begin, end] = self.span();
        let mut moved = Vec::new();
        for k in 0..TIMES {
            let part = k as f64 / (TIMES - 1) as f64;
            let (scene, _) = self.placed_at((1.0 - part) * begin + part * end)?;
            let origin = scene.origin();
            let mut meshes = scene.meshes().iter();
            for part in self.parts() {
                let own = meshes.by_ref().take(part.scene.meshes().len());
                let [mut min, mut max] = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
                for p in own.flat_map(Mesh::positions) {
                    for axis in 0..3 {
                        let x = f64::from(p[axis]) + origin[axis];
                        (min[axis], max[axis]) = (min[axis].min(x), max[axis].max(x));
                    }
                }
                if !matches!(part.motion, Motion::Still) && min[0] <= max[0] {
                    moved.push(Moved::of([min, max]));
                }
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
