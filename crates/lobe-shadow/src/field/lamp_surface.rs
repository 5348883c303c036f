//! The emitting surface of a lamp, to which rays are traced, and around which its light is sampled.

use lobe_sh::Rgb;
use lobe_sh::sphere::vector::{add, cross, length, sub};

use crate::error::ShadowError;
use crate::field::field_grid::FieldGrid;

/// Patches at most, along each side of a rectangle.
const MOST_PATCHES: usize = 64;

/// The surface of a lamp in its own frame.
#[derive(Clone, Debug, PartialEq)]
pub enum LampSurface {
    /// A ball of one radiance.
    Ball {
        /// Its middle.
        center: [f64; 3],
        /// Above 0.
        radius: f64,
        /// In every direction.
        radiance: Rgb<f64>,
    },
    /// A rectangle.
    Rectangle(PatchedRectangle),
}

impl LampSurface {
    /// A ball around the origin.
    #[must_use]
    pub fn ball(radius: f64, radiance: Rgb<f64>) -> Self {
        Self::Ball { center: [0.0; 3], radius, radiance }
    }

    /// A rectangle of one radiance.
    #[must_use]
    pub fn rectangle(rectangle: Rectangle, radiance: Rgb<f64>) -> Self {
        Self::Rectangle(PatchedRectangle { rectangle, patches: [1, 1], radiance: vec![radiance] })
    }
}

/// A rectangle cut into patches of equal size along its rows and columns, each of one radiance.
#[derive(Clone, Debug, PartialEq)]
pub struct PatchedRectangle {
    /// Where it is.
    pub rectangle: Rectangle,
    /// Patches along the rows and along the columns.
    pub patches: [usize; 2],
    /// Of each patch, row by row.
    pub radiance: Vec<Rgb<f64>>,
}

/// A lamp in the shape of a parallelogram.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Rectangle {
    /// The corner of the first pixel of a picture on it.
    pub corner: [f64; 3],
    /// The edge along its rows.
    pub u: [f64; 3],
    /// The edge along its columns. It shines towards `u × v`.
    pub v: [f64; 3],
    /// Whether the back shines alike.
    pub two_sided: bool,
}

impl Rectangle {
    /// In the plane z = 0 around the origin, of this width along x and height along y, shining towards +z. Its rows go from +x to -x
    /// and its columns from +y to -y.
    #[must_use]
    pub fn upright([width, height]: [f64; 2], two_sided: bool) -> Self {
        let corner = [0.5 * width, 0.5 * height, 0.0];
        Self { corner, u: [-width, 0.0, 0.0], v: [0.0, -height, 0.0], two_sided }
    }

    /// The points around it at which its light is sampled, on spheres around its middle; radii count half its longer diagonal.
    ///
    /// # Errors
    /// [`ShadowError::Options`] if it has no area or is not finite, and as [`FieldGrid::new`].
    pub(crate) fn grid(&self, range: [f64; 2], spheres: usize, cells: usize) -> Result<FieldGrid, ShadowError> {
        let Self { corner, u, v, .. } = *self;
        let normal = length(cross(u, v));
        if !(normal.is_finite() && normal > 0.0) {
            return Err(ShadowError::Options(format!(
                "expected a rectangle with an area, found edges {u:?} and {v:?}"
            )));
        }
        let center = std::array::from_fn(|k| corner[k] + 0.5 * (u[k] + v[k]));
        let radius = 0.5 * length(add(u, v)).max(length(sub(u, v)));
        FieldGrid::new(center, radius, range, spheres, cells)
    }

    /// Patch `k`, row by row, of `columns` along its rows and `rows` along its columns.
    pub(crate) fn patch(&self, [columns, rows]: [usize; 2], k: usize) -> Self {
        let (i, j) = ((k % columns) as f64, (k / columns) as f64);
        let (u, v) = (self.u.map(|c| c / columns as f64), self.v.map(|c| c / rows as f64));
        Self { corner: std::array::from_fn(|c| self.corner[c] + i * u[c] + j * v[c]), u, v, ..*self }
    }
}

/// Refuses numbers of patches that no field has.
pub(crate) fn check_patches(patches: [usize; 2]) -> Result<(), ShadowError> {
    if patches.iter().all(|n| (1..=MOST_PATCHES).contains(n)) {
        return Ok(());
    }
    Err(ShadowError::Options(format!("expected 1 to {MOST_PATCHES} patches along each side, found {patches:?}")))
}
