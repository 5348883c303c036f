//! Control variate of the moments of a triangle: noise of the directions of paths alone, subtracted.

/// The error that directions of paths alone leave in the moments of a triangle, times the part that leaves at once.
///
/// ```text
///   m_a = Σ_k w_k φ_a(p_k) (T_k - β_h E_k)      β_h: the mean of o_j over the points j of the other half
/// ```
///
/// `E_k` is what the directions of point k are off their closed form, and `o_k` the part of its paths that leaves at
/// once: a control variate. The mean of `E_k` is 0. Every second point has a sequence of its own, so that `β_h` knows
/// nothing of the directions of its half, and the mean of the moments is the same (test
/// `moments_by_few_paths_are_those_by_many_in_the_mean`). In the open β is 1, and the closed form is left without
/// noise. One point alone is left as it is.
#[derive(Debug)]
pub(crate) struct SamplingErrors {
    halves: [Half; 2],
}

/// The points of a sequence.
#[derive(Debug)]
struct Half {
    /// `Σ_k w_k φ_a(p_k) E_k`.
    sums: Vec<f64>,
    open: f64,
    points: u32,
}

impl SamplingErrors {
    pub(crate) fn new(numbers: usize) -> Self {
        Self { halves: [(); 2].map(|()| Half { sums: vec![0.0; numbers], open: 0.0, points: 0 }) }
    }

    pub(crate) fn clear(&mut self) {
        for half in &mut self.halves {
            half.sums.fill(0.0);
            (half.open, half.points) = (0.0, 0);
        }
    }

    /// Adds a point of a half, of whose paths the part `open` leaves at once.
    pub(crate) fn add(&mut self, half: usize, weight: f64, phi: [f64; 3], error: &[f32], open: f64) {
        let half = &mut self.halves[half];
        add_vectors(&mut half.sums, weight, phi, error);
        half.open += open;
        half.points += 1;
    }

    /// Subtracts `Σ_k w_k φ_a(p_k) β_h E_k`.
    pub(crate) fn subtract_from(&self, moments: &mut [f64]) {
        let [first, second] = &self.halves;
        for (half, other) in [(first, second), (second, first)] {
            let beta = other.open / f64::from(other.points.max(1));
            moments.iter_mut().zip(&half.sums).for_each(|(moment, sum)| *moment -= beta * sum);
        }
    }
}

/// Adds a row times the hat function of each corner.
pub(crate) fn add_vectors(sums: &mut [f64], weight: f64, phi: [f64; 3], row: &[f32]) {
    for (sums, phi) in sums.chunks_exact_mut(row.len()).zip(phi) {
        sums.iter_mut().zip(row).for_each(|(sum, t)| *sum += weight * phi * f64::from(*t));
    }
}

#[cfg(test)]
mod tests {
    use crate::bake::diffuse::DiffusePaths;
    use crate::bake::options::{BakeMode, BakeOptions};
    use crate::fit::fitted_vertices::FittedVertices;
    use crate::fit::surface_points::{SurfacePoints, gap};
    use crate::fit::triangle_moments::{ELEMENT, TriangleMoments};
    use crate::fit::vertex_fit::white_channels;
    use crate::job::chunks::Estimator;
    use lobe_scene::{Bvh, SurfaceRays, built_in};

    /// The mean of each moment of vectors of a triangle over some seeds, and the standard error of that mean.
    fn means(moments: &TriangleMoments<'_, DiffusePaths<'_>>, triangle: usize, seeds: u64) -> Vec<(f64, f64)> {
        let (mut scratch, mut row) = (moments.scratch(), vec![0.0; moments.row()]);
        let mut sums = vec![(0.0, 0.0); row.len() - ELEMENT];
        for seed in 0..seeds {
            moments.estimate(seed, triangle, &mut scratch, &mut row);
            for ((sum, square), m) in sums.iter_mut().zip(&row[ELEMENT..]) {
                *sum += f64::from(*m);
                *square += f64::from(*m).powi(2);
            }
        }
        let count = seeds as f64;
        let of = |(sum, square): (f64, f64)| {
            let mean = sum / count;
            (mean, ((square / count - mean * mean).max(0.0) / (count - 1.0)).sqrt())
        };
        sums.into_iter().map(of).collect()
    }

    #[test]
    fn moments_by_few_paths_are_those_by_many_in_the_mean() {
        let scene = built_in::ball_over_ground(12);
        let (bvh, fitted) = (Bvh::new(&scene), FittedVertices::all(&scene).unwrap());
        let options = BakeOptions::default().mode(BakeMode::Shadowed).order(3);
        let moments = |samples| {
            let points = SurfacePoints::new(&fitted, samples);
            let (rays, order) = (SurfaceRays::new(&scene, &bvh), options.path_order(points.paths));
            let paths = DiffusePaths::new(rays, &options, order, white_channels(&scene, &options));
            let albedos = vec![1.0; scene.triangle_count()];
            TriangleMoments { paths, points, albedos, gap: gap(&scene), seed: 0 }
        };
        let (few, many) = (moments(16), moments(4096));
        let mut tried = 0;
        for triangle in (0..scene.triangle_count()).step_by(7) {
            let known = means(&many, triangle, 16);
            // The first moments of the three corners are those of constant transfer: 1/√4π of the area where all is
            // open.
            let open = (0..3).map(|a| known[9 * a].0).sum::<f64>() / few.points.area(triangle) * 12.566_f64.sqrt();
            if !(0.2..0.97).contains(&open) {
                continue;
            }
            tried += 1;
            for (k, ((found, error), (expected, other))) in
                means(&few, triangle, 1024).into_iter().zip(known).enumerate()
            {
                // Of some thousand numbers none is farther off by chance; moments are rounded to f32.
                let most = 6.0 * (error.hypot(other) + 1e-9);
                assert!((found - expected).abs() < most, "triangle {triangle}, {k}: {found}, {expected} ± {most}");
            }
        }
        assert!(tried > 5, "{tried} triangles are partly hidden");
    }
}
