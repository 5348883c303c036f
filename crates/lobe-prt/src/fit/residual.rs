//! The residual of a triangle: what no values at its corners can fit of its transfer.

use glam::{DMat3, DVec3};
use lobe_scene::{Bvh, Scene, SurfaceRays};

use crate::bake::diffuse::{DiffusePaths, Scratch as PathScratch};
use crate::bake::options::{BakeMode, BakeOptions};
use crate::bake::point_transfer::PointTransfer;
use crate::fit::face::{Face, Side};
use crate::fit::surface_points::area;
use crate::fit::vertex_fit::white_channels;
use crate::job::chunks::{Estimator, Tally};
use crate::sampling::sobol::{coherent_order, hash};

/// Paths of a half of a point.
const PATHS: u32 = 8;

/// Points in a triangle: enough for the three numbers of a linear function and as many that test it, and as many as
/// find the shadow of a small body on a large floor.
const POINTS: [u32; 2] = [6, 256];

/// The measure of transfer, and how far the nearest function linear in the triangle is from it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Residual {
    /// `∫ ‖T - linear‖² dA`.
    pub(crate) error: f64,
    /// `∫ ‖T‖² dA`.
    pub(crate) energy: f64,
    /// The variance of the error's estimate.
    pub(crate) variance: f64,
    /// The area that is seen.
    pub(crate) area: f64,
}

impl Residual {
    pub(crate) const NUMBERS: usize = 4;

    /// Error and energy, the standard deviation of the error, and the area.
    pub(crate) fn numbers(self) -> [f32; Self::NUMBERS] {
        [self.error as f32, self.energy as f32, self.variance.sqrt() as f32, self.area as f32]
    }

    /// The same with an error relative to its own energy and a little of the mean of all, `floor`.
    pub(crate) fn relative_to(self, floor: f64) -> Self {
        let own = if self.area > 0.0 { self.energy.max(0.0) / self.area } else { 0.0 };
        let factor = if own + floor > 0.0 { 1.0 / (own + floor) } else { 0.0 };
        Self { error: self.error * factor, variance: self.variance * factor * factor, ..self }
    }

    /// The error less its standard deviation, so that few triangles count by their noise alone.
    pub(crate) fn least_error(&self) -> f64 {
        self.error - self.variance.sqrt()
    }

    pub(crate) fn of_numbers(numbers: [f32; Self::NUMBERS]) -> Self {
        let [error, energy, deviation, area] = numbers.map(f64::from);
        Self { error, energy, variance: deviation * deviation, area }
    }
}

/// The estimator of residuals, without bias.
///
/// ```text
///   ‖T‖² = Σ over bands l and orders m of  T_lm² / (l + 1)²
///   ∫ ‖T - linear‖² dA ≈ |t|/(K - 3) (Σ_k ⟨T'_k, T''_k⟩ - Σ_ab ⟨m'_a, G⁻¹_ab m''_b⟩)
///   G_ab = Σ_k φ_a(p_k) φ_b(p_k)      m_a = Σ_k φ_a(p_k) T_k
/// ```
///
/// t is the triangle and |t| its area, p its K points, `φ_a` the barycentric coordinate of corner a. T' and T'' are
/// estimates of the same point by different paths. The noise of the one is independent of that of the other, and adds
/// nothing to their product on average. Where more than half of the paths leave at once, both are the closed form less
/// what is in the way, so that open surfaces have no noise. A coefficient of band l counts by what it has in a sky: of
/// the bundled sunset the squares are 1, .22, .07 and .05 of that of band 0.
///
/// Points that nobody sees are left out. Three points or fewer, or points in a line, fit exactly.
#[derive(Debug)]
pub(crate) struct Residuals<'a> {
    paths: DiffusePaths<'a>,
    seed: u64,
    is_traced: bool,
    /// The weight of each number of a transfer vector.
    weights: Vec<f64>,
    gap: f32,
    /// Points for a unit of area.
    density: f64,
}

/// The buffers of a thread.
pub(crate) struct Scratch {
    paths: PathScratch,
    row: Vec<f32>,
    points: Vec<[f64; 3]>,
    /// The two estimates of each point, weighted.
    halves: [Vec<f64>; 2],
    /// What their directions alone are off, weighted.
    errors: [Vec<f64>; 2],
}

impl<'a> Residuals<'a> {
    /// Rays go through `scene`; the triangles are those of one that is split of it. `density` is the number of points
    /// for a unit of area.
    pub(crate) fn new(scene: &'a Scene, bvh: &'a Bvh, options: &'a BakeOptions, density: f64, gap: f32) -> Self {
        let is_traced = options.mode != BakeMode::Unshadowed;
        let order = if is_traced { coherent_order(PATHS) } else { Vec::new() };
        let channels = white_channels(scene, options);
        let paths = DiffusePaths::new(SurfaceRays::new(scene, bvh), options, order, channels);
        let of_band = |l: usize| std::iter::repeat_n(1.0 / (l + 1) as f64, 2 * l + 1);
        let weights: Vec<f64> = (0..channels.count()).flat_map(|_| (0..options.order).flat_map(of_band)).collect();
        Self { paths, seed: options.seed, is_traced, weights, gap, density }
    }

    fn scratch(&self) -> Scratch {
        let row = vec![0.0; self.paths.row()];
        Scratch {
            paths: self.paths.scratch(),
            row,
            points: Vec::new(),
            halves: Default::default(),
            errors: Default::default(),
        }
    }

    /// The residual of a triangle of a split scene.
    fn of(&self, split: &Scene, triangle: usize, scratch: &mut Scratch) -> (Residual, u64) {
        let face = Face::new(split, triangle, Side::Front);
        let size = area(face.corners());
        if size <= 0.0 {
            return (Residual::default(), 0);
        }
        let count = ((size * self.density) as u32).clamp(POINTS[0], POINTS[1]);
        // The two estimates have sequences of their own: blocks of one sequence complement each other, and are no
        // independent witnesses.
        let of = |half: u64| face.sequences(hash([self.seed, half]), self.paths.bounces);
        let [[places, first], [_, second]] = [0, 1].map(of);
        scratch.points.clear();
        scratch.halves.iter_mut().chain(&mut scratch.errors).for_each(Vec::clear);
        let mut open = 0.0;
        let mut rays = 0;
        for index in 0..count {
            let point = face.point(index, &places);
            let start = |half: usize| point.start([&first, &second][half], index * PATHS);
            // Bake the two halves of the point, unless nobody sees it.
            let mut is_dark = self.is_traced;
            for half in 0..2 {
                let tally = self.paths.transfer(&start(half), &mut scratch.paths, &mut scratch.row);
                rays += tally.rays;
                is_dark &= tally.energy.iter().all(|&energy| energy == 0.0);
                open += tally.energy[0];
                extend_weighted(&mut scratch.halves[half], &scratch.row, &self.weights);
                if self.is_traced {
                    let _ = self.paths.sampling_error(&start(half), &mut scratch.paths, &mut scratch.row);
                    extend_weighted(&mut scratch.errors[half], &scratch.row, &self.weights);
                }
            }
            if is_dark && self.paths.is_buried(&start(0), self.gap) {
                let row = self.weights.len();
                scratch.halves.iter_mut().chain(&mut scratch.errors).for_each(|half| half.truncate(half.len() - row));
            } else {
                scratch.points.push(point.weights);
            }
        }
        // Where most paths leave at once, estimate what is in the way instead of what is not.
        if self.is_traced && open > f64::from(count) {
            for (half, errors) in scratch.halves.iter_mut().zip(&scratch.errors) {
                half.iter_mut().zip(errors).for_each(|(t, error)| *t -= error);
            }
        }
        // What is buried counts by its visible part alone.
        let visible = scratch.points.len() as f64 / f64::from(count);
        let found = residual(&scratch.points, &scratch.halves, self.weights.len());
        let area = size * visible;
        let Residual { error, energy, variance, .. } = found;
        (Residual { error: error * area, energy: energy * area, variance: variance * area * area, area }, rays)
    }
}

fn extend_weighted(numbers: &mut Vec<f64>, row: &[f32], weights: &[f64]) {
    numbers.extend(row.iter().zip(weights).map(|(t, weight)| f64::from(*t) * weight));
}

/// The residuals of some triangles of a split scene, as rows of [`Residual::numbers`].
#[derive(Debug)]
pub(crate) struct RoundOfResiduals<'a> {
    pub(crate) residuals: &'a Residuals<'a>,
    pub(crate) split: &'a Scene,
    pub(crate) triangles: &'a [usize],
}

impl Estimator for RoundOfResiduals<'_> {
    type Scratch = Scratch;

    fn receivers(&self) -> usize {
        self.triangles.len()
    }

    fn row(&self) -> usize {
        Residual::NUMBERS
    }

    fn paths(&self) -> usize {
        (POINTS[0] * 2 * PATHS) as usize
    }

    fn scratch(&self) -> Scratch {
        self.residuals.scratch()
    }

    fn seed(&self) -> u64 {
        self.residuals.seed
    }

    fn estimate(&self, _: u64, number: usize, scratch: &mut Scratch, row: &mut [f32]) -> Tally {
        let (residual, rays) = self.residuals.of(self.split, self.triangles[number], scratch);
        row.copy_from_slice(&residual.numbers());
        Tally { rays, energy: vec![0.0], left: 0.0 }
    }
}

/// The residual of a triangle of unit area.
///
/// ```text
///   variance = Σ_i s_i⁴ / (K - 3),      s_i² = Σ_k (T'_ki - T''_ki)² / 2K
/// ```
fn residual(points: &[[f64; 3]], [first, second]: &[Vec<f64>; 2], row: usize) -> Residual {
    let count = points.len();
    if count == 0 {
        return Residual::default();
    }
    let energy = first.iter().zip(second).map(|(a, b)| a * b).sum::<f64>();
    let mut gram = DMat3::ZERO;
    for &phi in points {
        let phi = DVec3::from(phi);
        gram += DMat3::from_cols(phi * phi.x, phi * phi.y, phi * phi.z);
    }
    // Few points fit exactly.
    if count <= 3 || gram.determinant() <= f64::EPSILON {
        return Residual { energy: energy / count as f64, ..Residual::default() };
    }
    let inverse = gram.inverse();
    let (mut fitted, mut fourth) = (0.0, 0.0);
    for k in 0..row {
        let numbers = || first[k..].iter().step_by(row).zip(second[k..].iter().step_by(row));
        let mut moments = [DVec3::ZERO; 2];
        let mut square = 0.0;
        for (&phi, (a, b)) in points.iter().zip(numbers()) {
            moments[0] += DVec3::from(phi) * *a;
            moments[1] += DVec3::from(phi) * *b;
            square += 0.5 * (a - b) * (a - b);
        }
        fitted += moments[0].dot(inverse * moments[1]);
        fourth += (square / count as f64).powi(2);
    }
    let freedom = (count - 3) as f64;
    Residual {
        error: (energy - fitted) / freedom,
        energy: energy / count as f64,
        variance: fourth / freedom,
        area: 1.0,
    }
}
