//! The parameters of the room of motion, which a user changes.

use std::path::PathBuf;

use lobe::render::MovingMethod;
use lobe::scene::built_in;
use serde::{Deserialize, Serialize};

use crate::loading::moving_source::built_in_moving;
use crate::rooms::motion::player::{Fit, Hand};
use crate::widgets::within::within;

/// The most spheres of a part.
pub(crate) const MOST_SPHERES: usize = 64;

/// The farthest from the origin that a part is kept, in meters, and how much larger or smaller than it was.
const FARTHEST: f64 = 1e6;
const SCALES: std::ops::RangeInclusive<f64> = 1e-3..=1e3;

/// What moves, how its shadows are computed, and where a user has put its parts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
#[non_exhaustive]
pub struct MotionEdits {
    /// The scene: a file, or a built-in one.
    pub source: PathBuf,
    /// Whether parts hide the sky by exponentials of sums of spheres, and not by shadow fields.
    pub has_exponentials: bool,
    /// Whether parts are where the user has put them, and not where the animation does.
    pub is_by_hand: bool,
    /// Whether the spheres are drawn.
    pub has_spheres: bool,
    /// The spheres of exponentials.
    pub(crate) fit: Fit,
    pub(crate) hands: Vec<Hand>,
}

impl Default for MotionEdits {
    fn default() -> Self {
        Self::of_scene(built_in_moving(built_in::MOVING_NAMES[0]))
    }
}

impl MotionEdits {
    pub(crate) fn of_scene(source: PathBuf) -> Self {
        let (has_exponentials, is_by_hand, has_spheres) = (false, false, false);
        Self { source, has_exponentials, is_by_hand, has_spheres, fit: Fit::default(), hands: Vec::new() }
    }

    /// How moving parts hide the sky.
    pub(crate) fn method(&self) -> MovingMethod {
        if self.has_exponentials { MovingMethod::Exponentials } else { MovingMethod::Fields }
    }

    /// Brings its numbers into their ranges.
    pub(crate) fn check(&mut self) {
        self.fit.count = self.fit.count.clamp(1, MOST_SPHERES);
        for hand in &mut self.hands {
            hand.position = hand.position.map(|c| within(c, -FARTHEST..=FARTHEST, 0.0));
            hand.turn = within(hand.turn, -FARTHEST..=FARTHEST, 0.0);
            hand.scale = within(hand.scale, SCALES, 1.0);
        }
    }
}
