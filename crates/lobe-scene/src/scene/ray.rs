//! Rays and hits.

/// A ray: a half line from `origin` along `direction`, or a segment of it.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Ray {
    /// The start of the ray, from [`Scene::origin`](crate::Scene::origin). Nothing at the start itself is hit.
    pub origin: [f32; 3],
    /// Its direction, of any length above zero.
    pub direction: [f32; 3],
    /// Its end, in lengths of `direction`; infinity for a half line.
    pub t_max: f32,
}

/// A hit: a point on a triangle.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Hit {
    /// The distance along the ray, in lengths of its direction.
    pub t: f32,
    /// The index of the triangle.
    pub triangle: u32,
    /// Weight of the triangle's second corner.
    pub u: f32,
    /// Weight of the triangle's third corner; the first one's is `1 - u - v`.
    pub v: f32,
}

impl Ray {
    /// The half line from `origin` along `direction`.
    #[must_use]
    pub fn new(origin: [f32; 3], direction: [f32; 3]) -> Self {
        Self { origin, direction, t_max: f32::INFINITY }
    }

    /// The segment between two points, both excluded.
    #[must_use]
    pub fn between(from: [f32; 3], to: [f32; 3]) -> Self {
        Self { origin: from, direction: std::array::from_fn(|k| to[k] - from[k]), t_max: 1.0f32.next_down() }
    }

    /// The point at `t`.
    #[must_use]
    pub fn at(&self, t: f32) -> [f32; 3] {
        std::array::from_fn(|k| self.origin[k] + t * self.direction[k])
    }
}
