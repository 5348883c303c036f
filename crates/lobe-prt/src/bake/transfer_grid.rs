//! Neighborhood transfer: transfer matrices at the points of a grid around or within a scene.

use lobe_io::Job;
use lobe_scene::{Bounds, Bvh, Scene};
use lobe_sh::{Rgb, ShVec};

use crate::bake::glossy::{Points, bake_points};
use crate::bake::options::{BakeOptions, BakeReport};
use crate::error::PrtError;
use crate::transfer::transfer_matrices::TransferMatrices;

/// Points of a grid along the axes of the world: at least two along each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NeighborhoodGrid {
    min: [f64; 3],
    max: [f64; 3],
    counts: [usize; 3],
}

impl NeighborhoodGrid {
    /// `counts` points along the axes over a box, its corners among them.
    ///
    /// # Errors
    /// [`PrtError::Options`] if there are fewer than 2 along an axis, more than 2²⁴ in all, or the box has no volume.
    pub fn new(bounds: Bounds, counts: [usize; 3]) -> Result<Self, PrtError> {
        Self::between(bounds.min.map(f64::from), bounds.max.map(f64::from), counts)
    }

    /// [`NeighborhoodGrid::new`] over the box of these corners, which may be far from the origin.
    ///
    /// # Errors
    /// As [`NeighborhoodGrid::new`].
    pub fn between(min: [f64; 3], max: [f64; 3], counts: [usize; 3]) -> Result<Self, PrtError> {
        let refuse = |message: String| Err(PrtError::Options(message));
        let all = counts.iter().try_fold(1_usize, |all, &count| all.checked_mul(count));
        if counts.iter().any(|&count| count < 2) || all.is_none_or(|all| all > 1 << 24) {
            return refuse(format!("expected at least 2 points along each axis and at most 2^24, found {counts:?}"));
        }
        if !(0..3).all(|k| min[k].is_finite() && max[k].is_finite() && min[k] < max[k]) {
            return refuse(format!("expected a box with a volume, found {min:?} to {max:?}"));
        }
        Ok(Self { min, max, counts })
    }

    /// The smallest and the largest coordinates.
    #[must_use]
    pub fn corners(&self) -> [[f64; 3]; 2] {
        [self.min, self.max]
    }

    /// Points along x, y and z.
    #[must_use]
    pub fn counts(&self) -> [usize; 3] {
        self.counts
    }

    /// All points, x fastest, then y, relative to the [origin of a scene](Scene::origin).
    #[must_use]
    pub fn points(&self, origin: [f64; 3]) -> Vec<[f32; 3]> {
        let [nx, ny, nz] = self.counts;
        let at = |k: usize, i: usize| {
            let min = self.min[k] - origin[k];
            (min + (self.max[k] - self.min[k]) * i as f64 / (self.counts[k] - 1) as f64) as f32
        };
        let row = |y: usize, z: usize| (0..nx).map(move |x| [at(0, x), at(1, y), at(2, z)]);
        (0..nz).flat_map(|z| (0..ny).map(move |y| (y, z))).flat_map(|(y, z)| row(y, z)).collect()
    }

    /// Refuses matrices of another number of points.
    pub(crate) fn check_points(&self, found: usize) -> Result<(), PrtError> {
        let expected: usize = self.counts.iter().product();
        if expected == found {
            return Ok(());
        }
        Err(PrtError::invalid("neighborhood", format!("expected matrices of {expected} points, found {found}")))
    }

    /// The eight points around a place in the world and their weights, which add up to 1. Outside of the box the nearest
    /// place in it counts.
    #[must_use]
    pub fn around(&self, place: [f64; 3]) -> [(usize, f64); 8] {
        let axes: [(usize, f64); 3] = std::array::from_fn(|k| {
            let last = self.counts[k] - 1;
            let x = ((place[k] - self.min[k]) / (self.max[k] - self.min[k])).clamp(0.0, 1.0) * last as f64;
            let cell = (x as usize).min(last - 1);
            (cell, x - cell as f64)
        });
        std::array::from_fn(|corner| {
            let (mut index, mut weight) = (0, 1.0);
            for k in (0..3).rev() {
                let (cell, part) = axes[k];
                let far = corner >> k & 1;
                index = index * self.counts[k] + cell + far;
                weight *= if far == 1 { part } else { 1.0 - part };
            }
            (index, weight)
        })
    }
}

/// Neighborhood transfer [Sloan, Kautz and Snyder 2002]: the transfer matrices of a scene at the points of a grid.
///
/// An object that moves through the grid, or a medium that fills it, is lit by `M L` instead of L: with the shadows of
/// the scene and the light it sends back. Its own transfer vector T gives `B = Σᵢ Tᵢ (M L)ᵢ`. Between points matrices
/// are mixed by their distances; points inside of closed objects are dark and darken places beside those objects, so
/// that the grid should be finer than the gap between what moves and what stands.
#[derive(Clone, Debug, PartialEq)]
pub struct Neighborhood {
    grid: NeighborhoodGrid,
    matrices: TransferMatrices,
}

impl Neighborhood {
    /// The matrices of all points of a grid.
    ///
    /// # Errors
    /// [`PrtError::Invalid`] if their numbers differ.
    pub fn new(grid: NeighborhoodGrid, matrices: TransferMatrices) -> Result<Self, PrtError> {
        grid.check_points(matrices.points())?;
        Ok(Self { grid, matrices })
    }

    /// The grid of the points.
    #[must_use]
    pub fn grid(&self) -> &NeighborhoodGrid {
        &self.grid
    }

    /// The matrices of the points, x fastest.
    #[must_use]
    pub fn matrices(&self) -> &TransferMatrices {
        &self.matrices
    }

    /// The light that arrives at a place in the world when the surroundings send `light`: `M L`, mixed from the eight
    /// points around.
    #[must_use]
    pub fn incident(&self, place: [f64; 3], light: &[Rgb<f64>]) -> ShVec<Rgb<f64>> {
        let mut sum = ShVec::zero(self.matrices.order());
        for (point, weight) in self.grid.around(place) {
            sum += &(&self.matrices.incident(point, light) * weight);
        }
        sum
    }
}

/// Bakes neighborhood transfer at the points of a grid. See [`crate::bake_matrices`]; directions are uniform over
/// the sphere.
///
/// # Errors
/// Those of [`fn@crate::bake`].
pub fn bake_neighborhood(
    scene: &Scene,
    bvh: &Bvh,
    grid: &NeighborhoodGrid,
    options: &BakeOptions,
    job: Job<'_>,
) -> Result<(Neighborhood, BakeReport), PrtError> {
    let positions = grid.points(scene.origin());
    let points = Points { positions: &positions, receivers: None };
    let (matrices, report) = bake_points(scene, bvh, points, options, job)?;
    Ok((Neighborhood::new(*grid, matrices)?, report))
}
