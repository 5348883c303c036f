//! The product of coefficients and of the basis towards directions, by the widest instructions of the machine:
//!
//! ```text
//!   f_j(s_k) = Σ_i c_ji y_i(s_k)
//! ```
//!
//! Four functions and a tile of directions at a time, whose sums stay in registers. Each sum is over i in this order, product and sum
//! rounded together where the machine can, so that a value does not depend on what else is computed.

use lobe::sh::simd::{Kernel, Machine};
use lobe::sh::{Basis, coefficient_count};
use pulp::{Scalar, Simd};

use crate::directions::Directions;
use crate::rows::Number;

/// Directions of a tile.
const TILE: usize = 32;

/// Functions whose sums are in registers at a time.
const QUAD: usize = 4;

/// Functions of numbers, four side by side: the coefficients `i` of four follow each other. Colors are three of them.
pub(crate) struct Coefficients<T> {
    quads: Vec<Vec<[T; QUAD]>>,
    /// Functions of numbers, of which the last quad may have fewer than four.
    count: usize,
    channels: usize,
}

impl<T: Number> Coefficients<T> {
    /// Of functions one after the other, of `channels` numbers a coefficient.
    pub(crate) fn new(functions: &[T], order: usize, channels: usize) -> Self {
        let size = coefficient_count(order);
        let count = functions.len() / size;
        let quad = |first: usize| {
            let mut quad = vec![[T::ZERO; QUAD]; size];
            for j in first..count.min(first + QUAD) {
                let c = functions[j / channels * size * channels + j % channels..].iter().step_by(channels);
                quad.iter_mut().zip(c).for_each(|(quad, c)| quad[j - first] = *c);
            }
            quad
        };
        Self { quads: (0..count).step_by(QUAD).map(quad).collect(), count, channels }
    }
}

/// The basis towards directions, in tiles one after the other: `y[i * width + k]` of a tile is `y_i` towards its direction `k`. The last may
/// be narrower than [`TILE`].
pub(crate) struct Tiles<T> {
    y: Vec<T>,
    directions: usize,
    size: usize,
}

impl<T: Number> Tiles<T> {
    /// Of no directions.
    pub(crate) fn new(order: usize) -> Self {
        Self { y: Vec::new(), directions: 0, size: coefficient_count(order) }
    }

    /// Of other directions, in the same memory. Whether all of them are directions.
    pub(crate) fn fill(&mut self, basis: &Basis<T>, directions: Directions<'_>) -> bool {
        self.directions = directions.len();
        self.y.resize(self.size * directions.len(), T::ZERO);
        let mut all = true;
        for (t, y) in self.y.chunks_mut(self.size * TILE).enumerate() {
            let width = TILE.min(self.directions - t * TILE);
            let mut components = [[T::ZERO; TILE]; 3];
            for k in 0..width {
                let s = directions.unit(t * TILE + k);
                all &= s.iter().all(|s| s.is_finite());
                for (component, s) in components.iter_mut().zip(s) {
                    component[k] = T::from_f64(s);
                }
            }
            basis.eval_many_into(components.each_ref().map(|component| &component[..width]), y);
        }
        all
    }
}

/// Writes the values of all functions towards the directions of all tiles, a row for each function, of colors one after the other.
pub(crate) fn multiply<T: Sums>(functions: &Coefficients<T>, tiles: &Tiles<T>, rows: &mut [&mut [T]]) {
    Machine::detect().run(Product { functions, tiles, rows });
}

struct Product<'a, 'b, T> {
    functions: &'a Coefficients<T>,
    tiles: &'a Tiles<T>,
    rows: &'a mut [&'b mut [T]],
}

impl<T: Sums> Kernel for Product<'_, '_, T> {
    type Output = ();

    #[inline(always)]
    fn wide<S: Simd>(self, simd: S) {
        self.run::<S, true>(simd);
    }

    fn plain(self) {
        self.run::<Scalar, false>(Scalar::new());
    }
}

impl<T: Sums> Product<'_, '_, T> {
    /// By fused multiply-adds or without.
    #[inline(always)]
    fn run<S: Simd, const FUSED: bool>(self, simd: S) {
        // Rows are written from start to end.
        for (q, quad) in self.functions.quads.iter().enumerate() {
            for (t, y) in self.tiles.y.chunks(self.tiles.size * TILE).enumerate() {
                let width = TILE.min(self.tiles.directions - t * TILE);
                let mut sums = [[T::ZERO; TILE]; QUAD];
                if width < TILE {
                    for k in 0..width {
                        let values = one_direction::<T, FUSED>(quad, y, width, k);
                        for j in 0..QUAD {
                            sums[j][k] = values[j];
                        }
                    }
                } else if self.functions.count == 1 {
                    T::sums::<S, 1>(simd, quad, y, &mut sums);
                } else {
                    T::sums::<S, QUAD>(simd, quad, y, &mut sums);
                }
                store(self.functions, q, &sums, t * TILE..t * TILE + width, self.rows);
            }
        }
    }
}

/// Numbers of which registers are multiplied.
pub(crate) trait Sums: Number {
    /// The values of the first functions of a quad towards a whole tile.
    fn sums<S: Simd, const FUNCTIONS: usize>(
        simd: S,
        quad: &[[Self; QUAD]],
        y: &[Self],
        out: &mut [[Self; TILE]; QUAD],
    );
}

/// Registers of directions at a time: with four functions eight sums, of the sixteen or 32 registers that there are.
const REGISTERS: usize = 2;

macro_rules! sums {
    ($number:ty, $splat:ident, $mul_add:ident, $registers:ident, $registers_mut:ident) => {
        impl Sums for $number {
            #[inline(always)]
            fn sums<S: Simd, const FUNCTIONS: usize>(
                simd: S,
                quad: &[[Self; QUAD]],
                y: &[Self],
                out: &mut [[Self; TILE]; QUAD],
            ) {
                let y = S::$registers(y).0;
                let row = y.len() / quad.len();
                for first in (0..row).step_by(REGISTERS) {
                    let mut sums = [[simd.$splat(0.0); REGISTERS]; FUNCTIONS];
                    for (c, y) in quad.iter().zip(y.chunks_exact(row)) {
                        if let Some(y) = y[first..].first_chunk::<REGISTERS>() {
                            for j in 0..FUNCTIONS {
                                let c = simd.$splat(c[j]);
                                for r in 0..REGISTERS {
                                    sums[j][r] = simd.$mul_add(c, y[r], sums[j][r]);
                                }
                            }
                        }
                    }
                    for j in 0..FUNCTIONS {
                        S::$registers_mut(&mut out[j]).0[first..first + REGISTERS].copy_from_slice(&sums[j]);
                    }
                }
            }
        }
    };
}

sums!(f32, splat_f32s, mul_add_e_f32s, as_simd_f32s, as_mut_simd_f32s);
sums!(f64, splat_f64s, mul_add_e_f64s, as_simd_f64s, as_mut_simd_f64s);

/// Towards direction `k` of a tile that is not whole.
#[inline(always)]
fn one_direction<T: Number, const FUSED: bool>(quad: &[[T; QUAD]], y: &[T], width: usize, k: usize) -> [T; QUAD] {
    let mut sums = [T::ZERO; QUAD];
    for (c, y) in quad.iter().zip(y.chunks_exact(width)) {
        for j in 0..QUAD {
            sums[j] = if FUSED { c[j].fused(y[k], sums[j]) } else { sums[j] + c[j] * y[k] };
        }
    }
    sums
}

/// Writes the values of quad `q` towards some directions to their rows.
#[inline(always)]
fn store<T: Number>(
    functions: &Coefficients<T>,
    q: usize,
    sums: &[[T; TILE]; QUAD],
    directions: std::ops::Range<usize>,
    rows: &mut [&mut [T]],
) {
    let channels = functions.channels;
    for (j, sums) in (q * QUAD..functions.count).zip(sums) {
        let row = &mut rows[j / channels][directions.start * channels..directions.end * channels];
        if channels == 1 {
            row.copy_from_slice(&sums[..row.len()]);
        } else {
            for (color, value) in row.chunks_exact_mut(channels).zip(sums) {
                color[j % channels] = *value;
            }
        }
    }
}
