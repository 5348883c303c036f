//! Wigner's d-matrices of the angle π/2, by recurrence over spinors.

use alloc::vec;
use alloc::vec::Vec;
use core::f64::consts::SQRT_2;

#[cfg(not(feature = "std"))]
use num_traits::Float as _;

/// Wigner's matrix of the half turn that exchanges `+x` and `+z`, on spinors of `N` indices: for `N = 2l` that is
/// `d^l(π/2)` but for signs, see [`YzExchange`](crate::rotation::yz_exchange::YzExchange).
///
/// ```text
///   e_k = √(N over k) u^(N-k) v^k        u → (u + v)/√2        v → (u - v)/√2        e_k → Σ_k' B_{k'k}^N e_k'
///
///   B_{k'k}^{N+1} = { √(N+1-k') [ √(N+1-k) B_{k'k}   + √k B_{k',k-1}   ]
///                   + √k'       [ √(N+1-k) B_{k'-1,k} - √k B_{k'-1,k-1} ] } / (√2 (N+1))
/// ```
///
/// with `B^N` on the right. Each step expresses `e_k^{N+1} = √((N+1-k)/(N+1)) u e_k^N + √(k/(N+1)) v e_{k-1}^N`: it
/// adds one spinor index and symmetrizes. The squares of the weights sum to 1 and nothing divides by a small number, so
/// that errors do not grow ([Risbo 1996], for any angle). `B` is symmetric. The test
/// `the_half_turn_has_the_exact_values_of_krawtchouk` finds every entry to order 60 within 1e-14 of exact integers.
///
/// [Risbo 1996]: https://doi.org/10.1007/BF01090814
pub(crate) struct WignerHalfPi {
    /// Entries are stored for `k < size` only: no step needs a higher one.
    size: usize,
    n: usize,
    matrix: Vec<f64>,
}

impl WignerHalfPi {
    /// `B^0`.
    pub(crate) fn new(size: usize) -> Self {
        let mut matrix = vec![0.0; size * size];
        if let Some(first) = matrix.first_mut() {
            *first = 1.0;
        }
        Self { size, n: 0, matrix }
    }

    pub(crate) fn get(&self, row: usize, column: usize) -> f64 {
        self.matrix[row * self.size + column]
    }

    /// From `B^N` to `B^{N+1}`, in place from the last entry backwards.
    pub(crate) fn advance(&mut self) {
        let n = self.n + 1;
        let scale = 1.0 / (SQRT_2 * n as f64);
        let root: Vec<f64> = (0..=n).map(|k| (k as f64).sqrt()).collect();
        let last = n.min(self.size - 1);
        for row in (0..=last).rev() {
            for column in (0..=last).rev() {
                let left = |row: usize| if column > 0 { root[column] * self.get(row, column - 1) } else { 0.0 };
                let upper = root[n - row] * (root[n - column] * self.get(row, column) + left(row));
                let lower = if row > 0 {
                    root[row] * (root[n - column] * self.get(row - 1, column) - left(row - 1))
                } else {
                    0.0
                };
                self.matrix[row * self.size + column] = scale * (upper + lower);
            }
        }
        self.n = n;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // Σ_j (-1)^j (x over j)(N-x over k-j), the coefficient of u^(N-k) v^k in (u + v)^(N-x) (u - v)^x.
    #[test]
    fn the_half_turn_has_the_exact_values_of_krawtchouk() {
        const N: usize = 118;
        let binomial = |n: usize, k: usize| (0..k).fold(1_i128, |b, j| b * (n - j) as i128 / (j + 1) as i128);
        let mut half_turn = WignerHalfPi::new(N / 2 + 1);
        for _ in 0..N {
            half_turn.advance();
        }
        for x in 0..=N / 2 {
            let mut polynomial = vec![0_i128; N + 1];
            polynomial[0] = 1;
            for factor in 0..N {
                let sign = if factor < x { -1 } else { 1 };
                for k in (1..=N).rev() {
                    polynomial[k] += sign * polynomial[k - 1];
                }
            }
            for k in 0..=N / 2 {
                // B_kx = √(N over x) / √(N over k) 2^(-N/2) K
                let root = (binomial(N, x) as f64 / binomial(N, k) as f64).sqrt();
                let exact = polynomial[k] as f64 * root * 2.0_f64.powi(-(N as i32) / 2);
                let found = half_turn.get(k, x);
                assert!((found - exact).abs() < 1e-14, "({k}, {x}): {found} against {exact}");
            }
        }
    }
}
