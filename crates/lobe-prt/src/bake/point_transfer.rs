//! Transfer of a point of a surface: the start of its paths, and the estimator of its row of numbers.

use glam::Vec3;
use lobe_scene::{Hit, Ray};

use crate::bake::tracer::Tracer;
use crate::job::chunks::Tally;
use crate::sampling::sobol::Sobol;
use crate::sampling::warp::Frame;

/// A point that paths start from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PathStart<'a> {
    pub(crate) position: [f32; 3],
    pub(crate) normal: [f32; 3],
    /// The unit vector along which rays are lifted off the surface.
    pub(crate) lift: [f32; 3],
    /// The normals of the planes of the triangles that the point lies on, as of [`crate::Receivers::planes`].
    pub(crate) planes: &'a [[f32; 3]],
    pub(crate) albedo: [f64; 3],
    /// The sequences of its directions, and the number of its first path among them.
    pub(crate) sobol: &'a Sobol,
    pub(crate) first: u32,
}

/// An estimator of a row of numbers for any point of a surface: its transfer vectors or matrices.
pub(crate) trait PointTransfer: Sync {
    /// The buffers of a thread.
    type Scratch;

    /// Numbers of a row.
    fn row(&self) -> usize;

    /// Paths from each point.
    fn count(&self) -> usize;

    /// Bounces of a path, at most.
    fn bounces(&self) -> usize;

    fn limit_bounces(&mut self, bounces: usize);

    /// Sets the paths from each point.
    fn set_count(&mut self, count: u32);

    fn scratch(&self) -> Self::Scratch;

    /// The tracer of its paths; none if nothing is in the way.
    fn tracer(&self) -> Option<&Tracer<'_>>;

    /// Finds the row of a point.
    fn transfer(&self, start: &PathStart<'_>, scratch: &mut Self::Scratch, row: &mut [f32]) -> Tally;

    /// Finds how far the row of a white point would be off its closed form if nothing were in the way, by the
    /// directions of its paths alone. Returns whether there is a closed form.
    fn sampling_error(&self, _start: &PathStart<'_>, _scratch: &mut Self::Scratch, _row: &mut [f32]) -> bool {
        false
    }

    /// Whether a point that no light reaches is inside of a solid, or of a gap narrower than `gap`: whether at least
    /// half of 16 rays, uniform over the hemisphere, meet a back side, or anything nearer than that.
    ///
    /// Half of them, as solids overlap: where a floor goes on below a box, rays in the box meet the floor's front. From
    /// a point of a dark room they meet fronts.
    fn is_buried(&self, start: &PathStart<'_>, gap: f32) -> bool {
        const RAYS: u32 = 16;
        self.tracer().is_some_and(|tracer| {
            let (frame, origin) = (Frame::about(start.normal), tracer.origin_above(start.position, start.lift));
            let is_hidden = |index: &u32| {
                let direction = frame.hemisphere(start.sobol.point(*index, 0));
                let (hit, _) = tracer.0.closest_through(&Ray::new(origin, direction));
                hit.is_some_and(|hit| hit.t < gap || is_met_from_behind(tracer, &hit, direction))
            };
            2 * (0..RAYS).filter(is_hidden).count() >= RAYS as usize
        })
    }
}

fn is_met_from_behind(tracer: &Tracer<'_>, hit: &Hit, direction: [f32; 3]) -> bool {
    let normal = tracer.0.scene().surface(hit).geometric_normal;
    Vec3::from(normal).dot(Vec3::from(direction)) > 0.0
}
