//! Overlaps of a surface with itself, and parts that are inside out, which the winding number counts too much.

use glam::DVec3;

/// A winding number outside the interval from 0 to 1 by no more than this is in it: rounding.
const ROUNDING: f64 = 1e-6;

/// The integral of `w - clamp(w, 0, 1)` over a ball, from the points of a lattice.
///
/// A mesh of several closed parts that reach into each other, an eye in its socket, has a winding number of 2 where
/// they do. The exact volume in a ball counts that twice, and a sphere there would have less than no volume outside.
/// So what is too much is taken off by sampling. A cell of the lattice counts by how far it is inside,
///
/// ```text
///   ∫ (w - clamp(w, 0, 1)) dx ≈ a³ Σ_i (w_i - clamp(w_i, 0, 1)) clamp(½ + (R - |x_i - c|)/a, 0, 1)
/// ```
///
/// for a lattice of spacing a, which is continuous in the ball, and right to a part of about a over the width of the
/// overlap. Closed surfaces without overlaps have none of it.
#[derive(Default)]
pub(crate) struct Overlaps {
    spacing: f64,
    /// Places, and the excess of the winding number.
    cells: Vec<(DVec3, f64)>,
}

impl Overlaps {
    /// What winding numbers at places of a lattice are too much.
    pub(crate) fn new(spacing: f64, windings: impl Iterator<Item = (DVec3, f64)>) -> Self {
        let excess = windings.map(|(place, w)| (place, w - w.clamp(0.0, 1.0)));
        Self { spacing, cells: excess.filter(|cell| cell.1.abs() > ROUNDING).collect() }
    }

    /// The integral over all of space.
    pub(crate) fn volume(&self) -> f64 {
        self.cells.iter().map(|cell| cell.1).sum::<f64>() * self.spacing.powi(3)
    }

    /// The integral over a ball, and its derivatives by the center and by the radius.
    pub(crate) fn in_ball(&self, center: DVec3, radius: f64) -> (f64, DVec3, f64) {
        let (mut volume, mut by_center, mut by_radius) = (0.0, DVec3::ZERO, 0.0);
        for &(place, excess) in &self.cells {
            let distance = place.distance(center);
            let share = 0.5 + (radius - distance) / self.spacing;
            if share > 0.0 {
                volume += excess * share.min(1.0);
                if share < 1.0 {
                    by_center += (place - center) * (excess / (distance.max(f64::MIN_POSITIVE) * self.spacing));
                    by_radius += excess / self.spacing;
                }
            }
        }
        let cell = self.spacing.powi(3);
        (volume * cell, by_center * cell, by_radius * cell)
    }
}
