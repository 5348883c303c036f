//! Built-in scenes by formula: the same on every machine, each at any number of cells.
//!
//! Lengths are meters. All vertices are used and every triangle has an area.

// Read `scenes` first, then `shapes`, from which they are made, and `still_life`; `three_objects` and `walking_figure` move. Uses `motion` and
// `scene`.

pub(crate) mod scenes;
pub(crate) mod shapes;
pub(crate) mod still_life;
pub(crate) mod three_objects;
pub(crate) mod walking_figure;

pub use scenes::{
    MOVING_NAMES, NAMES, ball_over_ground, cave, closed_white_box, columns_hall, cornell_box, moving, named, terrain,
};
pub use still_life::still_life;
pub use three_objects::three_objects;
pub use walking_figure::walking_figure;
