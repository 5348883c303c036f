//! The moments of transfer in triangles: what the fit needs to know of the points.

use crate::bake::pilot::Piloted;
use crate::bake::point_transfer::PointTransfer;
use crate::fit::sampling_errors::{SamplingErrors, add_vectors};
use crate::fit::surface_points::SurfacePoints;
use crate::job::chunks::{Estimator, Tally};
use crate::sampling::sobol::hash;

/// The weight of a point that nobody sees, in a solid or a narrow gap, as a part of that of others: it decides only
/// where nothing else does.
const BURIED: f64 = 1e-4;

/// Numbers of a row before the moments of transfer: the upper triangle of the moments of the weights alone, and the
/// variance of the noise.
pub(crate) const ELEMENT: usize = 7;

/// Marks the seed of every second point; any number.
const SECOND_SEQUENCE: u64 = 0x5345_434F_4E44;

/// The place of the variance in a row.
pub(crate) const VARIANCE: usize = 6;

/// The estimator of the moments of each triangle, by the hat functions φ of its corners:
///
/// ```text
///   M_ab = Σ_k w_k φ_a(p_k) φ_b(p_k)      m_a = Σ_k w_k φ_a(p_k) T(p_k)      w_k = area / points in the triangle
///
///   σ² = (1 - p) / (p N)
///
///   a row:  M_00, M_01, M_02, M_11, M_12, M_22, σ², m_0, m_1, m_2
/// ```
///
/// T are the vectors or matrices of a white point. Vectors are less noisy by what their directions alone are off, times
/// the part β of paths that leave at once (see [`SamplingErrors`]).
/// Points that nobody sees have a weight of 1e-4 of this. p is the mean
/// throughput of the N paths of the others: σ² is the variance of that, as a part of its square, if each path brings
/// all or nothing and none knows of the others.
#[derive(Debug)]
pub(crate) struct TriangleMoments<'a, P> {
    pub(crate) paths: P,
    pub(crate) points: SurfacePoints<'a>,
    /// The albedo of each triangle, which the tally needs alone.
    pub(crate) albedos: Vec<f64>,
    /// The width of gaps that hide what is in them.
    pub(crate) gap: f32,
    pub(crate) seed: u64,
}

/// The buffers of a thread.
pub(crate) struct Scratch<S> {
    paths: S,
    row: Vec<f32>,
    error: Vec<f32>,
    sums: Vec<f64>,
    errors: SamplingErrors,
}

impl<P: PointTransfer> Piloted for TriangleMoments<'_, P> {
    fn limit_bounces(&mut self, bounces: usize) {
        self.paths.limit_bounces(bounces);
    }

    fn set_samples(&mut self, samples: u32) {
        self.points = self.points.of_samples(samples);
        self.paths.set_count(self.points.paths);
    }

    fn weight(&self, triangle: usize) -> f64 {
        self.albedos[triangle] * self.points.area(triangle) * self.points.triangles() as f64
    }
}

impl<P: PointTransfer> Estimator for TriangleMoments<'_, P> {
    type Scratch = Scratch<P::Scratch>;

    fn receivers(&self) -> usize {
        self.points.triangles()
    }

    fn row(&self) -> usize {
        ELEMENT + 3 * self.paths.row()
    }

    fn paths(&self) -> usize {
        self.points.len() * self.paths.count() / self.points.triangles().max(1)
    }

    fn scratch(&self) -> Scratch<P::Scratch> {
        let numbers = self.paths.row();
        Scratch {
            paths: self.paths.scratch(),
            row: vec![0.0; numbers],
            error: vec![0.0; numbers],
            sums: vec![0.0; self.row()],
            errors: SamplingErrors::new(3 * numbers),
        }
    }

    fn seed(&self) -> u64 {
        self.seed
    }

    fn estimate(&self, seed: u64, triangle: usize, scratch: &mut Self::Scratch, row: &mut [f32]) -> Tally {
        let Scratch { paths, row: transfer, error, sums, errors } = scratch;
        sums.fill(0.0);
        errors.clear();
        let count = self.points.count(triangle);
        let area = self.points.area(triangle);
        let face = self.points.face(triangle);
        // Every second point has a sequence of its own, which knows nothing of that of the others.
        let [places, first] = face.sequences(seed, self.paths.bounces());
        let [_, second] = face.sequences(hash([seed, SECOND_SEQUENCE]), self.paths.bounces());
        let mut tally = Tally::default();
        let mut seen = 0;
        for index in 0..count {
            // Bake the point as if it were white.
            let point = face.point(index, &places);
            let half = index as usize % 2;
            let start = point.start([&first, &second][half], index / 2 * self.points.paths);
            let of_point = self.paths.transfer(&start, paths, transfer);
            let is_dark = of_point.energy.iter().all(|&energy| energy == 0.0);
            let is_buried = is_dark && self.paths.is_buried(&start, self.gap);
            tally += &of_point;
            seen += u32::from(!is_buried);
            // Add its moments.
            let weight = area / f64::from(count) * if is_buried { BURIED } else { 1.0 };
            add_moments(sums, weight, point.weights, transfer);
            // What directions alone are off is known where nothing is in the way.
            if self.paths.sampling_error(&start, paths, error) {
                errors.add(half, weight, point.weights, error, of_point.energy[0]);
            }
        }
        errors.subtract_from(&mut sums[ELEMENT..]);
        row.iter_mut().zip(&*sums).for_each(|(number, sum)| *number = *sum as f32);
        row[VARIANCE] = variance(&tally, seen, self.paths.count()) as f32;
        // Energy is the mean over the triangle, weighted by its area among all.
        let weight = self.weight(triangle) / f64::from(count.max(1));
        tally.energy.iter_mut().for_each(|energy| *energy *= weight);
        tally.left *= weight;
        tally
    }
}

/// The variance of the mean over so many points and paths from each, as a part of its square.
fn variance(tally: &Tally, points: u32, paths: usize) -> f64 {
    let paths = f64::from(points) * paths as f64;
    if paths == 0.0 {
        return 0.0;
    }
    let mean = tally.energy.iter().sum::<f64>() / f64::from(points);
    // One path that escapes is the least that could have been seen.
    let mean = mean.clamp(1.0 / paths, 1.0);
    (1.0 - mean) / (mean * paths)
}

/// Adds the moments of a point, with its barycentric coordinates and its transfer, to a row.
pub(crate) fn add_moments(sums: &mut [f64], weight: f64, [a, b, c]: [f64; 3], transfer: &[f32]) {
    let (element, vectors) = sums.split_at_mut(ELEMENT);
    let products = [a * a, a * b, a * c, b * b, b * c, c * c];
    element.iter_mut().zip(products).for_each(|(sum, product)| *sum += weight * product);
    add_vectors(vectors, weight, [a, b, c], transfer);
}
