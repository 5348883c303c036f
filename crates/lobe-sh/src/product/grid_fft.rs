//! Products of functions on a grid whose rows are transformed by FFT.

use alloc::vec::Vec;
use core::f64::consts::PI;

use lobe_fft::{Complex, Registers, Transform};

use crate::basis::basis::Basis;
use crate::basis::index::{coefficient_count, order_of_slice};
use crate::product::row_columns::{BLOCK, Coefficients, NO_WAVE, Rows, Series, Wave};
use crate::simd::Machine;
use crate::sphere::quadrature::SphereQuadrature;

// The rows u at z and v at -z are one complex row z = u + iv. With U_m = (A_m + iB_m)/2, U_{K-m} its conjugate and U_0 = A_0
//
//     u(φ_k) = Σ_m A_m cos mφ_k + B_m sin mφ_k = Σ_m U_m e^{-imφ_k}        φ_k = 2πk/K
//
// is a transform, that of U + iV gives both rows, and the transform Z of a row of products has the sums over both:
//
//     Σ_k u cos mφ_k - i Σ_k u sin mφ_k = (Z_m + Z*_{K-m})/2        (Z_m - Z*_{K-m})/(2i) for v

/// The coefficients of the product of functions of order 1 at least, `order²` of them.
///
/// Exact up to rounding: the grid has as many points as the degree of the integrand needs, or a few more along rows, whose number has the
/// factors 2, 3 and 5 alone.
pub(crate) fn product_by_fft(factors: &[Vec<f64>], order: usize, [degree, highest]: [usize; 2]) -> Vec<f64> {
    let rule = SphereQuadrature::of_degree(degree);
    let all = rule.rows();
    let upper = &all[all.len() / 2..];
    let rows = Rows::new(&upper.iter().map(|(z, _)| *z).collect::<Vec<_>>());
    let grid = Grid::new(fft_length(degree + 1), rows);
    let machine = Machine::detect();
    let mut out = vec![0.0; coefficient_count(order)];
    Basis::<f64>::with_shared(highest, |basis| {
        let constants = basis.constants();
        let series: Vec<Vec<Wave>> = factors
            .iter()
            .map(|f| {
                let mut waves = vec![NO_WAVE; grid.rows.blocks() * order_of_slice(f)];
                machine.run(Series { constants, rows: &grid.rows, f, waves: &mut waves });
                waves
            })
            .collect();
        let mut waves = vec![NO_WAVE; grid.rows.blocks() * order];
        let mut work = grid.work();
        for (j, (_, weight)) in upper.iter().enumerate() {
            let weight = weight * 2.0 * PI / grid.azimuths as f64;
            // The row in the middle is its own mirror image, and counts once.
            let mirrored = if j == 0 && !all.len().is_multiple_of(2) { 0.0 } else { weight };
            work.product.fill(Complex::new(weight, mirrored));
            for series in &series {
                grid.multiply_by(series, j, &mut work);
            }
            grid.analyze(j, &mut work, &mut waves);
        }
        machine.run(Coefficients { constants, rows: &grid.rows, waves: &mut waves, sums: &mut out });
    });
    out
}

/// The smallest number from `least` on whose prime factors are 2, 3 and 5.
fn fft_length(least: usize) -> usize {
    let has_them_alone = |n: &usize| {
        let rest = [2, 3, 5].into_iter().fold(*n, |mut n, factor| {
            while n.is_multiple_of(factor) {
                n /= factor;
            }
            n
        });
        rest == 1
    };
    (least.max(1)..).find(has_them_alone).unwrap_or(least)
}

/// Rows at `z >= 0` and their mirror images, and the transform along them.
struct Grid {
    azimuths: usize,
    rows: Rows,
    transform: Transform,
}

/// The scratch space of a product.
struct Work {
    row: Vec<Complex<f64>>,
    product: Vec<Complex<f64>>,
    scratch: Vec<Complex<f64>>,
}

impl Grid {
    /// By the widest registers, unless `LOBE_SIMD` forbids them.
    fn new(azimuths: usize, rows: Rows) -> Self {
        let registers = if Machine::detect().is_plain() { Registers::Plain } else { Registers::Widest };
        Self { azimuths, rows, transform: Transform::new(azimuths, registers) }
    }

    fn work(&self) -> Work {
        let zeros = |count| vec![Complex::new(0.0, 0.0); count];
        Work { row: zeros(self.azimuths), product: zeros(self.azimuths), scratch: self.transform.scratch() }
    }

    /// Multiplies the products on row `j` and its mirror image by the values of a function.
    fn multiply_by(&self, series: &[Wave], j: usize, work: &mut Work) {
        let (blocks, block, k) = (self.rows.blocks(), j / BLOCK, j % BLOCK);
        work.row.fill(Complex::new(0.0, 0.0));
        for (m, [even, odd]) in series.chunks_exact(blocks).map(|waves| &waves[block]).enumerate() {
            let of = |sign: f64| [0, 1].map(|part: usize| even[part][k] + sign * odd[part][k]);
            let ([a, b], [c, d]) = (of(1.0), of(-1.0));
            if m == 0 {
                // Of m = 0 there are no sines.
                work.row[0] = Complex::new(a, c);
            } else {
                // U + iV of m, and of K - m with the conjugates of U and V.
                work.row[m] = 0.5 * Complex::new(a - d, b + c);
                work.row[self.azimuths - m] = 0.5 * Complex::new(a + d, c - b);
            }
        }
        self.transform.apply(&mut work.row, &mut work.scratch);
        for (product, value) in work.product.iter_mut().zip(&work.row) {
            *product = Complex::new(product.re * value.re, product.im * value.im);
        }
    }

    /// The Fourier sums of the products on row `j` and its mirror image: sums for even `l - m`, differences for odd.
    fn analyze(&self, j: usize, work: &mut Work, waves: &mut [Wave]) {
        let (blocks, block, k) = (self.rows.blocks(), j / BLOCK, j % BLOCK);
        let Work { product, scratch, .. } = work;
        self.transform.apply(product, scratch);
        for (m, waves) in waves.chunks_exact_mut(blocks).enumerate() {
            let (z, mirrored) = (product[m], product[(self.azimuths - m) % self.azimuths].conj());
            let (u, v) = (z + mirrored, mirrored - z);
            // (Z_m - Z*_{K-m})/i = i (Z*_{K-m} - Z_m).
            let (u, v) = (0.5 * u, 0.5 * Complex::new(-v.im, v.re));
            for (half, value) in [u + v, u - v].into_iter().enumerate() {
                waves[block][half][0][k] = value.re;
                waves[block][half][1][k] = -value.im;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_have_small_factors_and_are_the_next() {
        let found = [1, 7, 13, 61, 253, 257].map(fft_length);
        assert_eq!(found, [1, 8, 15, 64, 256, 270], "lengths");
    }
}
