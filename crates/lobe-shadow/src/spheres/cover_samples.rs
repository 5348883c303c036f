//! The points that a sphere set has to cover, in a solid and on its surface.

use glam::DVec3;
use lobe_io::parallel;

use crate::error::ShadowError;
use crate::spheres::overlaps::Overlaps;
use crate::spheres::solid::Solid;
use crate::split_mix::{self, GOLDEN};

/// The part of the points that lies inside; the rest is on the surface, where a cover that is too small shows.
const INNER: f64 = 1.0 / 3.0;

/// The part of the points on the surface for which vertices are taken first: a corner that sticks out is one.
const AT_VERTICES: f64 = 0.5;

/// Cells of the first lattice over the longest side of a mesh with holes, whose volume no formula gives.
const COARSE: f64 = 24.0;

/// Cells of a lattice at most: a solid that fills little of its box gets fewer points inside.
const MOST_CELLS: f64 = 1e6;

/// A winding number that is by more than this between 0 and 1 says little.
const SURE: f64 = 0.25;

/// Points to cover, and what finding them told about the solid.
pub(crate) struct CoverSamples {
    /// Those inside first.
    pub(crate) points: Vec<DVec3>,
    /// How many of them are inside.
    pub(crate) inner: usize,
    /// Normals of the points on the surface, as [`CoverSamples::points`] after `inner`.
    pub(crate) normals: Vec<DVec3>,
    /// The volume of the solid.
    pub(crate) volume: f64,
    /// The part of the points of a lattice over the box whose winding number says whether they are inside.
    pub(crate) certainty: f64,
    /// Where the winding number counts too much.
    pub(crate) overlaps: Overlaps,
}

impl CoverSamples {
    /// About `count` points.
    ///
    /// # Errors
    /// [`ShadowError::Options`] if none of the lattice is inside a mesh with holes.
    pub(crate) fn new(solid: &Solid, count: usize, seed: u64) -> Result<Self, ShadowError> {
        let [min, max] = solid.tree().bounds();
        let shift = DVec3::from_array([1, 2, 3].map(|k| unit(seed, k)));
        let volume = if solid.is_closed() {
            solid.signed_volume()
        } else {
            Lattice::new([min, max], (max - min).max_element() / COARSE, shift).inside(solid).volume
        };
        if volume <= 0.0 {
            let message = "expected a mesh around a volume, found one so open that nothing is inside; close its holes";
            return Err(ShadowError::Options(message.to_owned()));
        }
        let spacing = (volume / (count as f64 * INNER)).cbrt();
        let Inside { points, volume: counted, certainty, overlaps } =
            Lattice::new([min, max], spacing, shift).inside(solid);
        let volume = if solid.is_closed() { volume - overlaps.volume() } else { counted };
        let mut samples = Self { inner: points.len(), points, normals: Vec::new(), volume, certainty, overlaps };
        samples.add_surface(solid, (count as f64 * (1.0 - INNER)) as usize, seed);
        Ok(samples)
    }

    /// Adds vertices, and points spread evenly over the area of the triangles.
    fn add_surface(&mut self, solid: &Solid, count: usize, seed: u64) {
        let tree = solid.tree();
        let triangles = || (0..tree.triangle_count()).map(|t| tree.corners(t));
        let doubled = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a);
        let vertices = tree.vertices();
        let stride = (vertices.len() as f64 / (count as f64 * AT_VERTICES)).ceil().max(1.0) as usize;
        let normals = tree.vertex_normals();
        for v in (0..vertices.len()).step_by(stride) {
            self.points.push(vertices[v]);
            self.normals.push(normals[v]);
        }
        let left = count.saturating_sub(vertices.len().div_ceil(stride)).max(1);
        let step = triangles().map(|t| doubled(t).length()).sum::<f64>() / left as f64;
        let (mut next, mut before, mut taken) = (unit(seed, 0) * step, 0.0, 0_u64);
        for corners in triangles() {
            let [a, b, c] = corners;
            let normal = doubled(corners);
            before += normal.length();
            while next < before {
                let [mut u, mut v] = plastic(taken);
                if u + v > 1.0 {
                    [u, v] = [1.0 - u, 1.0 - v];
                }
                self.points.push(a + (b - a) * u + (c - a) * v);
                self.normals.push(normal.normalize_or_zero());
                next += step;
                taken += 1;
            }
        }
    }
}

/// A cubic lattice over a box.
struct Lattice {
    first: DVec3,
    spacing: f64,
    cells: [usize; 3],
}

/// The points of a lattice inside a solid.
struct Inside {
    points: Vec<DVec3>,
    volume: f64,
    certainty: f64,
    overlaps: Overlaps,
}

impl Lattice {
    /// The lattice of a spacing, wider if it had too many cells; `shift`, from 0 to 1, is where in its cells points
    /// are.
    fn new([min, max]: [DVec3; 2], spacing: f64, shift: DVec3) -> Self {
        let extent = max - min;
        let least = (extent.element_product() / MOST_CELLS).cbrt().max(extent.max_element() / MOST_CELLS);
        let spacing = spacing.max(least);
        let cells = (extent / spacing).to_array().map(|n| n.ceil().max(1.0) as usize);
        Self { first: min + shift * spacing, spacing, cells }
    }

    fn inside(&self, solid: &Solid) -> Inside {
        let [nx, ny, nz] = self.cells;
        let place = |i: usize, row: usize| {
            self.first + DVec3::new(i as f64, (row % ny) as f64, (row / ny) as f64) * self.spacing
        };
        let row = |row: usize| (0..nx).map(|i| (place(i, row), solid.winding(place(i, row)))).collect::<Vec<_>>();
        let rows: Vec<Vec<(DVec3, f64)>> = parallel::map(ny * nz, &row);
        let all = || rows.iter().flatten().copied();
        let points: Vec<DVec3> = all().filter(|(_, w)| *w >= 0.5).map(|(place, _)| place).collect();
        let sure = all().filter(|(_, w)| *w <= SURE || *w >= 1.0 - SURE).count();
        Inside {
            volume: points.len() as f64 * self.spacing.powi(3),
            points,
            certainty: sure as f64 / (nx * ny * nz) as f64,
            overlaps: Overlaps::new(self.spacing, all()),
        }
    }
}

/// The two-dimensional Kronecker sequence of the plastic number g, g³ = g + 1: places in the unit square, evenly
/// spread.
fn plastic(index: u64) -> [f64; 2] {
    const G: f64 = 1.324_717_957_244_746;
    let i = index as f64 + 1.0;
    [(i / G).fract(), (i / (G * G)).fract()]
}

/// A number from 0 to 1 by seed and place.
fn unit(seed: u64, place: u64) -> f64 {
    split_mix::unit(split_mix::mix(seed.wrapping_add(place.wrapping_mul(GOLDEN))))
}
