//! Light of a moment: of all parts (`moving_shading`), of one (`part_light`), by lamps (`lamp_light`), past what hides
//! the sky (`part_obstacles`), what is around its surfaces (`moving_surroundings`), and its picture (`moving_picture`).
//! Uses `bake`, `baked` and `scene`.

pub(crate) mod lamp_light;
pub(crate) mod moving_picture;
pub(crate) mod moving_shading;
pub(crate) mod moving_surroundings;
pub(crate) mod part_light;
pub(crate) mod part_obstacles;
