//! The moments of transfer in triangles: what the fit needs to know of the points.

use lobe_scene::{Bvh, Scene, SurfaceRays};

use crate::bake::diffuse::{DiffusePaths, Scratch as PathScratch};
use crate::fit::surface_points::{SurfacePoint, SurfacePoints, gap};
use crate::job::chunks::{Estimator, Tally};
use crate::sampling::sobol::coherent_order;
use crate::{AlbedoMode, BakeMode, BakeOptions, Channels};

/// The weight of a point that nobody sees, in a solid or a narrow gap, as a part of that of others: it decides only
/// where nothing else does.
const BURIED: f64 = 1e-4;

/// Numbers of a row before the moments of transfer: the upper triangle of the moments of the weights alone.
pub(crate) const ELEMENT: usize = 6;

/// The estimator of the moments of each triangle, by the hat functions φ of its corners:
///
/// ```text
///   M_ab = Σ_k w_k φ_a(p_k) φ_b(p_k)      m_a = Σ_k w_k φ_a(p_k) T(p_k)      w_k = area / points in the triangle
///
///   a row:  M_00, M_01, M_02, M_11, M_12, M_22, m_0, m_1, m_2
/// ```
///
/// T has no albedo. Points that nobody sees have a weight of 1e-4 of this.
#[derive(Debug)]
pub(crate) struct TriangleMoments<'a> {
    paths: DiffusePaths<'a>,
    points: SurfacePoints<'a>,
    albedos: Vec<f64>,
    is_traced: bool,
    gap: f32,
    seed: u64,
}

/// The buffers of a thread.
pub(crate) struct Scratch {
    paths: PathScratch,
    row: Vec<f32>,
    sums: Vec<f64>,
}

impl<'a> TriangleMoments<'a> {
    /// `albedos` are those of the triangles, which the tally needs alone.
    pub(crate) fn new(scene: &'a Scene, bvh: &'a Bvh, albedos: Vec<f64>, options: &'a BakeOptions) -> Self {
        let points = SurfacePoints::new(scene, options.samples);
        let is_traced = options.mode != BakeMode::Unshadowed;
        let order = if is_traced { coherent_order(points.paths) } else { Vec::new() };
        let paths = DiffusePaths::new(SurfaceRays::new(scene, bvh), options, order, Self::channels(scene, options));
        Self { paths, points, albedos, is_traced, gap: gap(scene), seed: options.seed }
    }

    /// The channels of transfer without albedo.
    pub(crate) fn channels(scene: &Scene, options: &BakeOptions) -> Channels {
        BakeOptions { albedo: AlbedoMode::None, channels: None, ..options.clone() }.channels_for(scene, true)
    }

    /// Numbers of a transfer vector.
    pub(crate) fn vector(&self) -> usize {
        self.paths.row()
    }

    pub(crate) fn limit_bounces(&mut self, bounces: usize) {
        self.paths.bounces = bounces;
    }
}

impl Estimator for TriangleMoments<'_> {
    type Scratch = Scratch;

    fn receivers(&self) -> usize {
        self.points.triangles()
    }

    fn row(&self) -> usize {
        ELEMENT + 3 * self.vector()
    }

    fn paths(&self) -> usize {
        self.points.len() * self.paths.count() / self.points.triangles().max(1)
    }

    fn scratch(&self) -> Scratch {
        Scratch { paths: self.paths.scratch(), row: vec![0.0; self.vector()], sums: vec![0.0; self.row()] }
    }

    fn seed(&self) -> u64 {
        self.seed
    }

    fn estimate(&self, seed: u64, triangle: usize, scratch: &mut Scratch, row: &mut [f32]) -> Tally {
        let Scratch { paths, row: transfer, sums } = scratch;
        sums.fill(0.0);
        let count = self.points.count(triangle);
        let area = self.points.area(triangle);
        let scene = self.points.scene();
        let [places, directions] = SurfacePoint::sequences(scene, seed, triangle, self.paths.bounces);
        let mut tally = Tally::default();
        for index in 0..count {
            // Bake the point as if it were white.
            let point = SurfacePoint::new(scene, triangle, index, &places);
            let start = point.start(&directions, index * self.points.paths);
            let of_point = self.paths.transfer(&start, paths, transfer);
            let is_dark = of_point.energy.iter().all(|&energy| energy == 0.0);
            let is_buried = self.is_traced && is_dark && self.paths.is_buried(&start, self.gap);
            tally += &of_point;
            // Add its moments.
            let weight = area / f64::from(count) * if is_buried { BURIED } else { 1.0 };
            add_moments(sums, weight, point.weights, transfer);
        }
        row.iter_mut().zip(&*sums).for_each(|(number, sum)| *number = *sum as f32);
        // Energy is the mean over the triangle, weighted by its area among all.
        let weight = self.albedos[triangle] * area * self.points.triangles() as f64 / f64::from(count.max(1));
        tally.energy.iter_mut().for_each(|energy| *energy *= weight);
        tally.left *= weight;
        tally
    }
}

/// Adds the moments of a point, with its barycentric coordinates and its transfer, to a row.
pub(crate) fn add_moments(sums: &mut [f64], weight: f64, [a, b, c]: [f64; 3], transfer: &[f32]) {
    let (element, vectors) = sums.split_at_mut(ELEMENT);
    let products = [a * a, a * b, a * c, b * b, b * c, c * c];
    element.iter_mut().zip(products).for_each(|(sum, product)| *sum += weight * product);
    for (sums, phi) in vectors.chunks_exact_mut(transfer.len()).zip([a, b, c]) {
        sums.iter_mut().zip(transfer).for_each(|(sum, t)| *sum += weight * phi * f64::from(*t));
    }
}
