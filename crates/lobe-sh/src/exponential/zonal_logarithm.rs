//! The logarithm of a function that is symmetric about an axis, many times faster than that of any function.

use core::f64::consts::PI;

use crate::basis::legendre::legendre_normalized;
use crate::expansion::Zonal;
use crate::exponential::logarithm::{check_clamp, slope_of_ln};
use crate::exponential::matrix_function::apply;
use crate::prelude::*;
use crate::solver::matrix::Matrix;
use crate::solver::symmetric_eigen::SymmetricEigen;
use crate::sphere::quadrature::gauss_legendre;

/// Logarithms of visibilities that are symmetric about an axis, of one order, with what they share prepared: for tables.
///
/// The product matrix of a zonal function joins coefficients of equal `m` alone. With `P̄` the normalized associated
/// Legendre functions, its blocks are
///
/// ```text
///   M^m_ij = 2π ∫ g(z) P̄_i^m(z) P̄_j^m(z) dz        i, j = m .. n-1
/// ```
///
/// `g - 1` has coefficients of `m = 0` alone, so that [`logarithm`](crate::exponential::logarithm) needs the eigenvectors of `M^0`,
/// `n × n`, and of the other blocks only the largest eigenvalue, to which its clamp is relative.
#[derive(Clone, Debug)]
pub struct ZonalLogarithm {
    order: usize,
    clamp: f64,
    /// Nodes of the quadrature with `2π` times their weights.
    nodes: Vec<(f64, f64)>,
    /// For every `m`, at every node, `P̄_l^m` for `l` from `m` on.
    legendre: Vec<Vec<f64>>,
}

impl ZonalLogarithm {
    /// For functions of an order, with eigenvalues of at least `clamp` times the largest, or times 1, the open sky.
    ///
    /// # Panics
    /// If `clamp` is not in `(0, 1]`.
    #[must_use]
    pub fn new(order: usize, clamp: f64) -> Self {
        check_clamp(clamp);
        // Products of three functions have degree 3 (n - 1); k nodes are exact to 2k - 1.
        let rule = gauss_legendre((3 * order).div_ceil(2).max(1));
        let nodes: Vec<(f64, f64)> = rule.iter().map(|(z, weight)| (*z, 2.0 * PI * weight)).collect();
        let row =
            |m: usize| nodes.iter().flat_map(move |&(z, _)| (m..order).map(move |l| legendre_normalized(l, m, z)));
        let legendre = (0..order).map(|m| row(m).collect()).collect();
        Self { order, clamp, nodes, legendre }
    }

    /// The logarithm of a visibility, or of anything else that is 1 where the sky is open.
    ///
    /// Its value at 1 is 0 exactly, whatever the clamp.
    ///
    /// # Panics
    /// If `visible` has another order.
    #[must_use]
    pub fn of(&self, visible: &Zonal) -> Zonal {
        assert_eq!(visible.order(), self.order, "the order of the function against that of the logarithm");
        if self.order == 0 {
            return Zonal::new(Vec::new());
        }
        if !visible.coefficients().iter().all(|c| c.is_finite()) {
            return Zonal::new(vec![f64::NAN; self.order]);
        }
        let values: Vec<f64> = self.nodes.iter().map(|(z, _)| visible.eval(*z)).collect();
        let spectrum = SymmetricEigen::new(self.block(0, &values));
        let others = (1..self.order).map(|m| SymmetricEigen::new(self.block(m, &values)).largest());
        let largest = others.fold(spectrum.largest().max(1.0), f64::max);
        let mut rest = visible.coefficients().to_vec();
        rest[0] -= (4.0 * PI).sqrt();
        Zonal::new(apply(&spectrum, &|d| slope_of_ln(d.max(self.clamp * largest)), &rest))
    }

    /// The logarithm of what a sphere of angular radius `half_angle` leaves visible.
    ///
    /// # Panics
    /// If `half_angle` is outside `[0, π]`.
    #[must_use]
    pub fn of_sphere(&self, half_angle: f64) -> Zonal {
        if self.order == 0 {
            return Zonal::new(Vec::new());
        }
        let hidden = Zonal::cone(self.order, half_angle);
        let mut visible: Vec<f64> = hidden.coefficients().iter().map(|c| -c).collect();
        visible[0] += (4.0 * PI).sqrt();
        self.of(&Zonal::new(visible))
    }

    /// `M^m` of the function with these values at the nodes.
    fn block(&self, m: usize, values: &[f64]) -> Matrix {
        let size = self.order - m;
        let mut block = Matrix::zeros(size, size);
        for ((p, (_, weight)), value) in self.legendre[m].chunks_exact(size).zip(&self.nodes).zip(values) {
            for i in 0..size {
                for j in 0..=i {
                    block[(i, j)] += weight * value * p[i] * p[j];
                }
            }
        }
        Matrix::from_fn(size, size, |i, j| block[(i.max(j), i.min(j))])
    }
}

impl Zonal {
    /// The logarithm of the visibility that a sphere of angular radius `half_angle` (radians, in `[0, π]`) leaves: 0
    /// within that angle of the axis, 1 outside; see [`logarithm`](crate::exponential::logarithm) for `clamp`. For many angles, keep a
    /// [`ZonalLogarithm`].
    ///
    /// What is relative in the clamp is so to 1, the open sky, or to the overshoot of the basis above it. A sphere around the
    /// point leaves the constant `ln clamp / (1 - clamp)`.
    ///
    /// Spheres that stand together add up: the exponential of the sum is what all of them leave.
    ///
    /// # Panics
    /// If `half_angle` is outside `[0, π]`, or `clamp` not in `(0, 1]`.
    #[must_use]
    pub fn sphere_logarithm(order: usize, half_angle: f64, clamp: f64) -> Self {
        ZonalLogarithm::new(order, clamp).of_sphere(half_angle)
    }
}
