//! Moments one after the other: of a picture after the other, the tree of one serves the next.

use crate::scene::moment::Moment;
use crate::scene::moving_scene::MovingScene;
use lobe_render::RenderError;

/// Moments of a [`MovingScene`], one at a time. The tree over the triangles is [refit](lobe_scene::Bvh::update) from
/// moment to moment, which takes a small part of the time of building it, and built anew where it is worn. Asked for
/// the same time again, it gives the same moment.
///
/// Rays find the same as in [`MovingScene::at`], bit by bit, and may take a little longer: a picture of very many rays
/// is better traced in a tree of its own.
///
/// ```
/// use lobe_motion::MovingScene;
/// use lobe_scene::built_in;
///
/// let moving = MovingScene::animated(built_in::three_objects(8), Some(0))?;
/// let mut moments = moving.moments();
/// for frame in 0..4 {
///     let moment = moments.at(f64::from(frame) / 24.0)?;
///     assert_eq!(moment.bvh().triangle_count(), moment.scene().triangle_count());
/// }
/// # Ok::<(), lobe_render::RenderError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Moments<'a> {
    scene: &'a MovingScene,
    last: Option<(f64, Moment<'a>)>,
}

impl MovingScene {
    /// Moments of the scene one after the other, each with the tree of the one before it.
    #[must_use]
    pub fn moments(&self) -> Moments<'_> {
        Moments { scene: self, last: None }
    }
}

impl<'a> Moments<'a> {
    /// The scene at a time.
    ///
    /// # Errors
    /// As [`MovingScene::at`].
    pub fn at(&mut self, time: f64) -> Result<&Moment<'a>, RenderError> {
        let moment = match self.last.take() {
            Some((last, moment)) if last == time => moment,
            last => self.scene.at_with(time, last.map(|(_, moment)| moment.into_bvh()))?,
        };
        Ok(&self.last.insert((time, moment)).1)
    }
}
