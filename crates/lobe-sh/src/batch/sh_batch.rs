//! Many expansions of one order, sixteen side by side.

use alloc::vec::Vec;

use crate::basis::index::{coefficient_count, order_of_slice};
use crate::batch::basis_blocks::eval_blocks;
use crate::batch::dir_batch::DirBatch;
use crate::batch::lane_eval;
use crate::expansion::{Expansion, FixedOrder, ShVec};
use crate::product::lane_product::{self, Factors};
use crate::rotation::ivanic::RotationMatrices;
use crate::rotation::lane_rotation;
use crate::scalar::Coefficient;
use crate::simd::{LANES, Lanes, Machine};

/// Many expansions of one order in `f32`, in the layout of the kernels that take sixteen at once.
///
/// ```text
///   blocks()[n² b + i].0[k]        coefficient i of function 16 b + k
/// ```
///
/// So the n² blocks of sixteen functions follow each other, each block a line of the cache, and a kernel reads and writes
/// one run of memory. Places of the last block that no function takes hold numbers of no meaning, zero at first. Colors
/// take a batch for each channel.
///
/// Every operation runs by the widest instructions of the machine ([`Machine`]); its plain
/// code is what the machine has for single expansions, so that results agree with those to rounding.
///
/// ```
/// use lobe_sh::batch::{DirBatch, ShBatch};
/// use lobe_sh::{Dir, Expansion as _, ShL2};
///
/// // Light and visibility at two points, and what arrives.
/// let light = ShBatch::from_functions(&[ShL2::constant(1.0), ShL2::impulse(Dir::X, 2.0)]);
/// let visible = ShBatch::from_functions(&[ShL2::impulse(Dir::Z, 1.0), ShL2::constant(0.5)]);
/// let mut arriving = ShBatch::zero(3, 2);
/// light.product_into(&visible, &mut arriving);
/// let of_first: ShL2<f32> = arriving.function(0);
/// assert!((of_first.eval(Dir::Z) - ShL2::<f32>::impulse(Dir::Z, 1.0).eval(Dir::Z)).abs() < 1e-6);
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShBatch {
    order: usize,
    count: usize,
    blocks: Vec<Lanes>,
}

impl ShBatch {
    /// `count` functions of `order` that are zero everywhere.
    #[must_use]
    pub fn zero(order: usize, count: usize) -> Self {
        Self { order, count, blocks: vec![Lanes::ZERO; coefficient_count(order) * count.div_ceil(LANES)] }
    }

    /// Of functions of one order.
    ///
    /// # Panics
    /// If the orders differ.
    #[must_use]
    pub fn from_functions<E: Expansion<f32>>(functions: &[E]) -> Self {
        let mut batch = Self::zero(functions.first().map_or(0, Expansion::order), functions.len());
        for (k, f) in functions.iter().enumerate() {
            batch.set(k, f.coefficients());
        }
        batch
    }

    /// Of coefficients in planes, as [`Basis::eval_many_into`](crate::basis::Basis::eval_many_into) and
    /// [`RotationMatrices::apply_many_into`] have them: `planes[i * count + k]` is coefficient `i` of function `k`.
    ///
    /// # Panics
    /// If there are not `n² count` of them.
    #[must_use]
    pub fn from_planes(order: usize, count: usize, planes: &[f32]) -> Self {
        assert_eq!(planes.len(), coefficient_count(order) * count, "numbers of coefficients");
        let mut batch = Self::zero(order, count);
        for b in 0..count.div_ceil(LANES) {
            let part = b * LANES..count.min((b + 1) * LANES);
            for (i, block) in batch.group_mut(b).iter_mut().enumerate() {
                block.0[..part.len()].copy_from_slice(&planes[i * count..][part.clone()]);
            }
        }
        batch
    }

    /// The coefficients in planes: `planes[i * count + k]` becomes coefficient `i` of function `k`.
    ///
    /// # Panics
    /// If there is not room for exactly all of them.
    pub fn planes_into(&self, planes: &mut [f32]) {
        assert_eq!(planes.len(), coefficient_count(self.order) * self.count, "numbers of coefficients");
        for b in 0..self.count.div_ceil(LANES) {
            let part = b * LANES..self.count.min((b + 1) * LANES);
            for (i, block) in self.group(b).iter().enumerate() {
                planes[i * self.count..][part.clone()].copy_from_slice(&block.0[..part.len()]);
            }
        }
    }

    /// Of functions that lie one after the other, `n²` coefficients each. The channels of colors are functions of their own: channel `c`
    /// of row `k` is function `C::CHANNELS k + c`.
    ///
    /// # Panics
    /// If there are not `n²` coefficients for each function.
    #[must_use]
    pub fn from_rows<C: Coefficient<Scalar = f32>>(order: usize, rows: &[C]) -> Self {
        let width = coefficient_count(order);
        assert!(rows.is_empty() || rows.len().is_multiple_of(width), "{} coefficients of order {order}", rows.len());
        let mut batch = Self::zero(order, rows.len() / width.max(1) * C::CHANNELS);
        for (k, row) in rows.chunks_exact(width.max(1)).enumerate() {
            for channel in 0..C::CHANNELS {
                let function = k * C::CHANNELS + channel;
                let group = batch.group_mut(function / LANES);
                group.iter_mut().zip(row).for_each(|(block, c)| block.0[function % LANES] = c.channel(channel));
            }
        }
        batch
    }

    /// The functions one after the other, as [`from_rows`](Self::from_rows) has them.
    ///
    /// # Panics
    /// If there is not room for exactly all of them, in whole rows.
    pub fn rows_into<C: Coefficient<Scalar = f32>>(&self, rows: &mut [C]) {
        let width = coefficient_count(self.order);
        let found = (self.count.is_multiple_of(C::CHANNELS), rows.len() * C::CHANNELS);
        assert_eq!(found, (true, width * self.count), "functions in whole rows, and numbers of their coefficients");
        for (k, row) in rows.chunks_exact_mut(width.max(1)).enumerate() {
            let first = k * C::CHANNELS;
            for (i, out) in row.iter_mut().enumerate() {
                let of = |function: usize| self.group(function / LANES)[i].0[function % LANES];
                *out = C::from_channels(|channel| of(first + channel));
            }
        }
    }

    /// The order of the functions.
    #[must_use]
    pub fn order(&self) -> usize {
        self.order
    }

    /// The number of functions.
    #[must_use]
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// All blocks; see the layout above.
    #[must_use]
    pub fn blocks(&self) -> &[Lanes] {
        &self.blocks
    }

    /// All blocks, to be written.
    #[must_use]
    pub fn blocks_mut(&mut self) -> &mut [Lanes] {
        &mut self.blocks
    }

    /// Sets function `k`.
    ///
    /// # Panics
    /// If `k >= len()` or the order is another one.
    pub fn set(&mut self, k: usize, coefficients: &[f32]) {
        assert!(k < self.count, "no function {k} of {}", self.count);
        assert_eq!(order_of_slice(coefficients), self.order, "the order of a function against that of the batch");
        for (block, c) in self.group_mut(k / LANES).iter_mut().zip(coefficients) {
            block.0[k % LANES] = *c;
        }
    }

    /// The coefficients of function `k`, for the order that `out` has room for: cut off, or filled up with zeros.
    ///
    /// # Panics
    /// If `k >= len()`.
    pub fn get_into(&self, k: usize, out: &mut [f32]) {
        assert!(k < self.count, "no function {k} of {}", self.count);
        out.fill(0.0);
        for (out, block) in out.iter_mut().zip(self.group(k / LANES)) {
            *out = block.0[k % LANES];
        }
    }

    /// Function `k` with the order of the type that is asked for: cut off, or filled up with zeros.
    ///
    /// # Panics
    /// If `k >= len()`.
    #[must_use]
    pub fn function<E: FixedOrder<Value = f32>>(&self, k: usize) -> E {
        let mut f = E::zero();
        self.get_into(k, f.coefficients_mut());
        f
    }

    /// All functions.
    #[must_use]
    pub fn to_functions(&self) -> Vec<ShVec<f32>> {
        let mut functions = vec![ShVec::zero(self.order); self.count];
        for (k, f) in functions.iter_mut().enumerate() {
            self.get_into(k, f.coefficients_mut());
        }
        functions
    }

    /// The basis towards many directions: coefficient `i` of function `k` is `y_i` towards direction `k`. Orders 1 to 10
    /// have straight-line code.
    ///
    /// # Panics
    /// If the numbers of directions and of functions differ.
    pub fn set_basis(&mut self, directions: &DirBatch) {
        assert_eq!(self.count, directions.len(), "functions against directions");
        eval_blocks(Machine::detect(), self.order, directions.blocks(), &mut self.blocks);
    }

    /// The functions turned by one rotation.
    ///
    /// # Panics
    /// If the orders or the numbers of functions differ, or the order is above that of the matrices.
    pub fn rotated_into(&self, rotation: &RotationMatrices<f32>, out: &mut Self) {
        self.assert_alike(out);
        let reached = rotation.order();
        assert!(self.order <= reached, "these matrices reach order {reached}, not {}", self.order);
        lane_rotation::rotate_blocks(Machine::detect(), rotation.columns(), self.order, &self.blocks, &mut out.blocks);
    }

    /// The product of each function with that of the same number in `other`, cut off at their order; see
    /// [`product_into`](crate::product::product_into). Orders 1 to 6 have straight-line code.
    ///
    /// # Panics
    /// If the orders or the numbers of functions differ, or the order is above
    /// [`MAX_GAUNT_ORDER`](crate::product::MAX_GAUNT_ORDER).
    pub fn product_into(&self, other: &Self, out: &mut Self) {
        self.assert_alike(other);
        self.assert_alike(out);
        let factors = Factors::Two(&self.blocks, &other.blocks);
        lane_product::multiply_blocks(Machine::detect(), self.order, factors, &mut out.blocks);
    }

    /// The square of each function, cut off at its order; see [`square_into`](crate::product::square_into).
    ///
    /// # Panics
    /// If the orders or the numbers of functions differ, or the order is above
    /// [`MAX_GAUNT_ORDER`](crate::product::MAX_GAUNT_ORDER).
    pub fn square_into(&self, out: &mut Self) {
        self.assert_alike(out);
        let factors = Factors::One(&self.blocks);
        lane_product::multiply_blocks(Machine::detect(), self.order, factors, &mut out.blocks);
    }

    /// The product of each function with a zonal one about +z, cut off at their order; see
    /// [`zonal_product_into`](crate::product::zonal_product_into). Orders 2 to 6 have straight-line code. `zonal` has a block for each band of
    /// sixteen functions:
    ///
    /// ```text
    ///   zonal[order b + l].0[k]        coefficient of band l of the factor of function 16 b + k
    /// ```
    ///
    /// # Panics
    /// If the orders or the numbers of functions differ, there are other than `order` blocks of `zonal` for sixteen functions, or the
    /// order is above [`MAX_GAUNT_ORDER`](crate::product::MAX_GAUNT_ORDER).
    pub fn zonal_product_into(&self, zonal: &[Lanes], out: &mut Self) {
        self.assert_alike(out);
        assert_eq!(zonal.len(), self.count.div_ceil(LANES) * self.order, "blocks of bands of zonal functions");
        let factors = Factors::Zonal(zonal, &self.blocks);
        lane_product::multiply_blocks(Machine::detect(), self.order, factors, &mut out.blocks);
    }

    /// The value of each function towards the direction of the same number.
    ///
    /// ```text
    ///   out[k] = Σ_i f_ki y_i(s_k)
    /// ```
    ///
    /// # Panics
    /// If the numbers of functions, directions and values differ.
    pub fn eval_into(&self, directions: &DirBatch, out: &mut [f32]) {
        assert_eq!(self.count, directions.len(), "functions against directions");
        assert_eq!(self.count, out.len(), "functions against values");
        lane_eval::eval_functions(Machine::detect(), self.order, &self.blocks, directions.blocks(), out);
    }

    fn assert_alike(&self, other: &Self) {
        let of = |batch: &Self| (batch.order, batch.count);
        assert_eq!(of(self), of(other), "orders and numbers of functions of two batches");
    }

    /// The blocks of sixteen functions.
    fn group(&self, b: usize) -> &[Lanes] {
        let count = coefficient_count(self.order);
        &self.blocks[b * count..][..count]
    }

    fn group_mut(&mut self, b: usize) -> &mut [Lanes] {
        let count = coefficient_count(self.order);
        &mut self.blocks[b * count..][..count]
    }
}

#[cfg(test)]
mod tests {
    use lobe_testkit::Random;

    use super::*;
    use crate::scalar::Rgb;

    #[test]
    fn rows_of_numbers_and_of_colors_come_back_from_blocks() {
        let mut random = Random::new(7);
        for (order, count) in [(1, 1), (2, 5), (3, 16), (4, 17), (6, 40), (3, 0), (0, 0)] {
            let width = coefficient_count(order);
            let rows: Vec<Rgb<f32>> =
                (0..count * width).map(|_| Rgb::from_channels(|_| random.signed() as f32)).collect();
            let (numbers, colors) = (rows.iter().map(|c| c.g).collect::<Vec<_>>(), ShBatch::from_rows(order, &rows));
            assert_eq!((colors.order(), colors.len()), (order, 3 * count), "of order {order}");
            let mut back = vec![Rgb::ZERO; rows.len()];
            colors.rows_into(&mut back);
            assert_eq!(back, rows, "{count} colors of order {order}");
            let mut green = vec![f32::NAN; width];
            for (k, row) in numbers.chunks_exact(width.max(1)).enumerate() {
                colors.get_into(3 * k + 1, &mut green);
                assert_eq!(green, row, "green of function {k} of order {order}");
            }
            let mut back = vec![f32::NAN; numbers.len()];
            ShBatch::from_rows(order, &numbers).rows_into(&mut back);
            assert_eq!(back, numbers, "{count} functions of order {order}");
        }
    }
    #[test]
    #[should_panic(expected = "whole rows")]
    fn one_function_is_no_row_of_colors() {
        ShBatch::zero(3, 1).rows_into(&mut [Rgb::<f32>::ZERO; 3]);
    }
}
