//! Grids of visibility: what a scene that stands still leaves of the sky where others move.

use derive_setters::Setters;
use lobe_io::{Job, parallel};
use lobe_scene::{Bvh, Ray, Scene};
use lobe_sh::sphere::even_directions;
use lobe_shadow::{VisibilityOptions, bake_visibility};

use lobe_render::RenderError;

/// Directions in which a point looks for backs of surfaces.
const SIDE_RAYS: usize = 64;

/// Hits of those at least, before a point can be told to lie behind a surface: fewer say nothing.
const LEAST_HITS: usize = 8;

/// The part of the diagonal of the box by which the grid reaches beyond it: points of the box are between points of the
/// grid, and none of these lies in a floor on which the box stands.
const MARGIN: f64 = 1e-3;

/// Options of [`VisibilityGrid::bake`].
#[derive(Clone, Debug, PartialEq, Setters)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[non_exhaustive]
pub struct VisibilityGridOptions {
    /// Number of bands, 1 to 8.
    pub order: usize,
    /// Points at most, at least 8.
    pub points: usize,
    /// Rays from each point, 1 to 2²⁰.
    pub rays: u32,
}

impl Default for VisibilityGridOptions {
    /// Order 4, 4096 points of 512 rays: about the work of an occlusion field.
    fn default() -> Self {
        Self { order: 4, points: 4096, rays: 512 }
    }
}

/// What a scene leaves visible of the sky at the points of a grid in a box, linear in between along each axis.
///
/// ```text
///   V_i(p) = Σ_k w_k(p) V_i(p_k)        V_i(p_k) = ∫ V(p_k, s) y_i(s) ds, by rays
/// ```
///
/// An occlusion field is known on spheres around its entity, and coarse within; this is known where the receivers are,
/// so that it holds inside a room or a cave as well. Points behind surfaces, in solids and below floors of one layer,
/// are seen by no receiver: more than half of the surfaces around them show their backs. They take the mean of their
/// neighbors in front of surfaces, so that what stands on a floor is not darkened by what is below it. What is thinner
/// than the distance of two points is not resolved.
///
/// ```
/// use lobe_io::Job;
/// use lobe_motion::{VisibilityGrid, VisibilityGridOptions};
/// use lobe_scene::built_in;
///
/// let options = VisibilityGridOptions::default().order(2).points(27).rays(64);
/// let hall = built_in::named("columns").expect("a scene of the program");
/// let grid = VisibilityGrid::bake(&hall, [[-1.0, -1.0, 0.1], [1.0, 1.0, 1.5]], &options, Job::default())?;
/// let mut visible = [0.0; 4];
/// grid.visibility_into([0.0, 0.0, 0.5], &mut visible);
/// let all = (4.0 * std::f32::consts::PI).sqrt();
/// assert!(visible[0] < 0.9 * all, "floor and roof hide a part of the sky: {visible:?}");
/// # Ok::<(), lobe_render::RenderError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct VisibilityGrid {
    order: usize,
    min: [f64; 3],
    step: [f64; 3],
    counts: [usize; 3],
    /// `order²` numbers of each point, x rising first.
    rows: Vec<f32>,
}

impl VisibilityGrid {
    /// The grid of a scene in a box of its world. Steps of `job` are points; it can be kept in a file.
    ///
    /// # Errors
    /// [`RenderError::Options`] if the box is empty or not finite, or there are fewer than 8 points;
    /// [`RenderError::Shadow`] with those of [`bake_visibility`], [`RenderError::Cancelled`] if the watch of the job
    /// said to stop.
    pub fn bake(
        scene: &Scene,
        [min, max]: [[f64; 3]; 2],
        options: &VisibilityGridOptions,
        job: Job<'_>,
    ) -> Result<Self, RenderError> {
        if !(0..3).all(|k| min[k].is_finite() && max[k].is_finite() && min[k] <= max[k]) {
            return Err(RenderError::Options(format!("expected a box with finite corners, found {min:?} to {max:?}")));
        }
        if options.points < 8 {
            return Err(RenderError::Options(format!(
                "expected 8 points of a grid at least, found {}",
                options.points
            )));
        }
        let extent: [f64; 3] = std::array::from_fn(|k| max[k] - min[k]);
        let diagonal = extent.iter().map(|e| e * e).sum::<f64>().sqrt();
        // A box that is a point has a grid of the size of a unit's thousandth.
        let margin = MARGIN * if diagonal > 0.0 { diagonal } else { 1.0 };
        let extent = extent.map(|e| e + 2.0 * margin);
        let counts = counts(extent, options.points);
        let mut grid = Self {
            order: options.order,
            min: min.map(|c| c - margin),
            step: std::array::from_fn(|k| extent[k] / (counts[k] - 1) as f64),
            counts,
            rows: Vec::new(),
        };
        let origin = scene.origin();
        let points: Vec<[f32; 3]> = (0..grid.points())
            .map(|point| {
                let p = grid.point(point);
                std::array::from_fn(|k| (p[k] - origin[k]) as f32)
            })
            .collect();
        // Without a normal rays start at the point itself.
        let normals = vec![[0.0; 3]; points.len()];
        let rays = VisibilityOptions::default().order(options.order).rays(options.rays);
        grid.rows = bake_visibility(scene, &points, &normals, &rays, job)?;
        let bvh = Bvh::new(scene);
        grid.fill(parallel::map(points.len(), &|i| !is_behind(scene, &bvh, points[i])));
        Ok(grid)
    }

    /// Number of bands.
    #[must_use]
    pub fn order(&self) -> usize {
        self.order
    }

    /// Number of points.
    #[must_use]
    pub fn points(&self) -> usize {
        self.counts.iter().product()
    }

    /// The first point and the distance of neighbors along each axis, in the world.
    #[must_use]
    pub fn lattice(&self) -> [[f64; 3]; 2] {
        [self.min, self.step]
    }

    /// Points along each axis.
    #[must_use]
    pub fn counts(&self) -> [usize; 3] {
        self.counts
    }

    /// `order²` numbers of each point, x rising first.
    #[must_use]
    pub fn rows(&self) -> &[f32] {
        &self.rows
    }

    /// The visibility of the sky at a point of the world, in its directions: the first numbers of as many bands as
    /// `out` has places for. Beyond the box that of the nearest point of the box.
    ///
    /// # Panics
    /// If `out` has more places than `order²`.
    pub fn visibility_into(&self, point: [f64; 3], out: &mut [f32]) {
        let (width, places) = (self.order * self.order, out.len());
        assert!(places <= width, "{places} places for visibility, of which order {} has {width} numbers", self.order);
        let (mut low, mut part) = ([0; 3], [0.0; 3]);
        for k in 0..3 {
            let at = ((point[k] - self.min[k]) / self.step[k]).clamp(0.0, (self.counts[k] - 1) as f64);
            low[k] = (at as usize).min(self.counts[k] - 2);
            part[k] = at - low[k] as f64;
        }
        out.fill(0.0);
        for corner in 0..8 {
            let up: [usize; 3] = std::array::from_fn(|k| corner >> k & 1);
            let weight: f64 = (0..3).map(|k| if up[k] == 1 { part[k] } else { 1.0 - part[k] }).product();
            let row = self.index(std::array::from_fn(|k| low[k] + up[k])) * width;
            let row = &self.rows[row..row + places];
            out.iter_mut().zip(row).for_each(|(out, v)| *out += weight as f32 * v);
        }
    }

    fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.counts[1] + y) * self.counts[0] + x
    }

    fn place(&self, point: usize) -> [usize; 3] {
        let [nx, ny, _] = self.counts;
        [point % nx, point / nx % ny, point / nx / ny]
    }

    fn point(&self, point: usize) -> [f64; 3] {
        let place = self.place(point);
        std::array::from_fn(|k| self.min[k] + self.step[k] * place[k] as f64)
    }

    /// The points next to one along the axes.
    fn neighbors(&self, point: usize) -> impl Iterator<Item = usize> {
        let place = self.place(point);
        (0..6).filter_map(move |side| {
            let (k, is_up) = (side / 2, side % 2 == 1);
            let mut place = place;
            place[k] = if is_up { place[k] + 1 } else { place[k].checked_sub(1)? };
            (place[k] < self.counts[k]).then(|| self.index(place))
        })
    }

    /// Gives points that are not known the mean of their neighbors, layer by layer from those that are.
    fn fill(&mut self, mut known: Vec<bool>) {
        let width = self.order * self.order;
        loop {
            let layer: Vec<(usize, Vec<f32>)> = (0..known.len())
                .filter(|point| !known[*point])
                .filter_map(|point| {
                    let from: Vec<usize> = self.neighbors(point).filter(|p| known[*p]).collect();
                    let mean =
                        |i: usize| from.iter().map(|p| self.rows[p * width + i]).sum::<f32>() / from.len() as f32;
                    (!from.is_empty()).then(|| (point, (0..width).map(mean).collect()))
                })
                .collect();
            if layer.is_empty() {
                return;
            }
            for (point, row) in layer {
                self.rows[point * width..][..width].copy_from_slice(&row);
                known[point] = true;
            }
        }
    }
}

/// Points along each axis, 2 at least: about as far from each other in all directions, no more than `most` in all.
fn counts(extent: [f64; 3], most: usize) -> [usize; 3] {
    let at = |step: f64| extent.map(|e| ((e / step) as usize).saturating_add(2).min(most));
    let count = |counts: [usize; 3]| counts.iter().fold(1_usize, |all, n| all.saturating_mul(*n));
    let longest = extent.iter().fold(0.0_f64, |a, b| a.max(*b));
    // The step is between that of one long row and the longest side.
    let (mut fine, mut coarse) = (longest / most as f64, 2.0 * longest);
    for _ in 0..64 {
        let middle = 0.5 * (fine + coarse);
        if count(at(middle)) > most { fine = middle } else { coarse = middle }
    }
    at(coarse)
}

/// Whether most surfaces around a point show it their backs.
fn is_behind(scene: &Scene, bvh: &Bvh, point: [f32; 3]) -> bool {
    let (mut hits, mut backs) = (0, 0);
    for direction in even_directions(SIDE_RAYS) {
        let direction = direction.to_array().map(|c| c as f32);
        if let Some(hit) = bvh.closest(&Ray::new(point, direction)) {
            let normal = scene.surface(&hit).geometric_normal;
            hits += 1;
            backs += usize::from((0..3).map(|k| normal[k] * direction[k]).sum::<f32>() > 0.0);
        }
    }
    hits >= LEAST_HITS && 2 * backs > hits
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_scene::built_in;

    #[test]
    fn a_grid_has_about_as_many_points_as_it_may() {
        for (extent, most) in
            [([1.0, 1.0, 1.0], 4096), ([10.0, 1.0, 0.1], 4096), ([1.0, 1e-9, 1e-9], 8), ([5.0, 4.0, 3.0], 100)]
        {
            let counts = counts(extent, most);
            let all: usize = counts.iter().product();
            assert!(all <= most && 3 * all >= most && counts.iter().all(|n| *n >= 2), "{extent:?}: {counts:?}");
        }
    }

    #[test]
    fn what_is_under_a_floor_does_not_darken_what_stands_on_it() {
        // The floor of this scene is at z = 0; its ball is 1.5 above, of radius 1.
        let floor = built_in::ball_over_ground(8).part([0]).unwrap();
        let options = VisibilityGridOptions::default().order(1).points(64).rays(256);
        let grid =
            VisibilityGrid::bake(&floor, [[-0.2, -0.2, -0.3], [0.2, 0.2, 0.3]], &options, Job::default()).unwrap();
        let all = (4.0 * std::f32::consts::PI).sqrt();
        for z in [-0.2, 0.0, 0.1, 0.25] {
            let mut visible = [0.0];
            grid.visibility_into([0.0, 0.0, z], &mut visible);
            let part = visible[0] / all;
            assert!((0.4..0.62).contains(&part), "{part} of the sky at {z}: half of it, and what is beyond the floor");
        }
    }

    #[test]
    #[should_panic(expected = "4 places for visibility, of which order 1 has 1 numbers")]
    fn a_grid_has_no_more_bands_than_it_was_baked_with() {
        let floor = built_in::ball_over_ground(4).part([0]).unwrap();
        let options = VisibilityGridOptions::default().order(1).points(27).rays(16);
        let grid = VisibilityGrid::bake(&floor, [[-1.0; 3], [1.0; 3]], &options, Job::default()).unwrap();
        grid.visibility_into([-1.0; 3], &mut [0.0; 4]);
    }
}
