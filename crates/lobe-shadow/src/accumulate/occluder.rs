//! Spheres that hide the sky.

/// A sphere that hides what is behind it: center and radius, in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Occluder {
    /// The center.
    pub center: [f32; 3],
    /// The radius, 0 or more; a sphere of radius 0 hides nothing.
    pub radius: f32,
}

impl Occluder {
    /// A sphere.
    #[must_use]
    pub const fn new(center: [f32; 3], radius: f32) -> Self {
        Self { center, radius }
    }
}
