//! The basis, and functions by it, towards many directions.

use crate::basis::basis::Basis;
use crate::basis::basis::TypedBasis;
use crate::basis::index::{coefficient_count, order_of, order_of_slice};
#[cfg(feature = "simd")]
use crate::basis::lane_kernels::{eval_planes, eval_sums};
use crate::basis::recurrence::lanes;
use crate::by_type::of_each_type;
use crate::scalar::{Coefficient, Real, Rgb};
use crate::scalar::{TypedSlice as Slice, TypedSliceMut as SliceMut};
#[cfg(feature = "simd")]
use crate::simd::Machine;

/// Directions in one block of the batched kernels: one AVX-512 register of `f32`, two of AVX2.
const BLOCK: usize = 16;

impl<S: Real> Basis<S> {
    /// The values towards many unit vectors: `out[i * count + k]` is `y_i` towards vector `k`.
    ///
    /// By the instructions of the [`Machine`], orders to 6 as straight-line code.
    ///
    /// # Panics
    /// If the components differ in length, or `out` is not `n²` times as long for an order of this basis.
    /// Without directions `out` is empty.
    pub fn eval_many_into(&self, [x, y, z]: [&[S]; 3], out: &mut [S]) {
        let count = x.len();
        assert!(y.len() == count && z.len() == count, "components differ in length");
        if count == 0 {
            assert!(out.is_empty(), "no directions have no values, not {}", out.len());
            return;
        }
        let order = match order_of(out.len() / count) {
            Some(order) if coefficient_count(order) * count == out.len() => order,
            _ => panic!("out has {} places, not n² for each of {count} directions", out.len()),
        };
        match (self.typed(), [x, y, z].map(S::typed), S::typed_mut(out)) {
            (
                TypedBasis::Single(basis),
                [Slice::Single(x), Slice::Single(y), Slice::Single(z)],
                SliceMut::Single(out),
            ) => {
                single::eval_many_into(basis, order, [x, y, z], out);
            }
            (
                TypedBasis::Double(basis),
                [Slice::Double(x), Slice::Double(y), Slice::Double(z)],
                SliceMut::Double(out),
            ) => {
                double::eval_many_into(basis, order, [x, y, z], out);
            }
            _ => unreachable!("numbers of one type"),
        }
    }

    /// The values of one expansion towards many unit vectors.
    ///
    /// # Panics
    /// If the slices differ in length or the order of `coefficients` is above that of the basis.
    pub fn eval_expansion_into<T: Coefficient<Scalar = S>>(
        &self,
        coefficients: &[T],
        [x, y, z]: [&[S]; 3],
        out: &mut [T],
    ) {
        assert!(
            x.len() == out.len() && y.len() == out.len() && z.len() == out.len(),
            "components and out differ in length"
        );
        match (self.typed(), [x, y, z].map(S::typed), T::typed(coefficients), T::typed_mut(out)) {
            (
                TypedBasis::Single(basis),
                [Slice::Single(x), Slice::Single(y), Slice::Single(z)],
                Slice::Single(coefficients),
                SliceMut::Single(out),
            ) => single::eval_expansion_into(basis, coefficients, [x, y, z], out),
            (
                TypedBasis::Single(basis),
                [Slice::Single(x), Slice::Single(y), Slice::Single(z)],
                Slice::SingleColors(coefficients),
                SliceMut::SingleColors(out),
            ) => single::eval_colors_into(basis, coefficients, [x, y, z], out),
            (
                TypedBasis::Double(basis),
                [Slice::Double(x), Slice::Double(y), Slice::Double(z)],
                Slice::Double(coefficients),
                SliceMut::Double(out),
            ) => double::eval_expansion_into(basis, coefficients, [x, y, z], out),
            (
                TypedBasis::Double(basis),
                [Slice::Double(x), Slice::Double(y), Slice::Double(z)],
                Slice::DoubleColors(coefficients),
                SliceMut::DoubleColors(out),
            ) => double::eval_colors_into(basis, coefficients, [x, y, z], out),
            _ => unreachable!("slices of one type"),
        }
    }

    /// [`Basis::eval_many_into`] of the directions from `done` on, in plain code.
    fn eval_many_from(&self, done: usize, order: usize, components: [&[S]; 3], out: &mut [S]) {
        let [x, y, z] = components;
        let count = x.len();
        let blocks = count / BLOCK;
        for block in done / BLOCK..blocks {
            let start = block * BLOCK;
            self.for_each_in_block(components.map(|c| block_of(c, start)), order, |i, y| {
                // An array, not a slice: its length is known at compile time and needs no call.
                if let Some(out) = out[i * count + start..].first_chunk_mut() {
                    *out = *y;
                }
            });
        }
        for k in blocks * BLOCK..count {
            self.for_each([x[k], y[k], z[k]], order, |i, y| out[i * count + k] = y);
        }
    }

    /// [`Basis::eval_expansion_into`] of the directions from `done` on, in plain code.
    fn eval_expansion_from<T: Coefficient<Scalar = S>>(
        &self,
        done: usize,
        coefficients: &[T],
        [x, y, z]: [&[S]; 3],
        out: &mut [T],
    ) {
        let order = order_of_slice(coefficients);
        let blocks = out.len() / BLOCK;
        for block in done / BLOCK..blocks {
            let start = block * BLOCK;
            let mut sum = [T::ZERO; BLOCK];
            self.for_each_in_block([x, y, z].map(|c| block_of(c, start)), order, |i, y| {
                for (sum, y) in sum.iter_mut().zip(y) {
                    *sum += coefficients[i].scale(*y);
                }
            });
            out[start..][..BLOCK].copy_from_slice(&sum);
        }
        for k in blocks * BLOCK..out.len() {
            out[k] = T::ZERO;
            self.for_each([x[k], y[k], z[k]], order, |i, y| out[k] += coefficients[i].scale(y));
        }
    }
}

of_each_type! { numbers:
    pub(super) fn eval_many_into(basis: &Basis<T>, order: usize, components: [&[T]; 3], out: &mut [T]) {
        #[cfg(feature = "simd")]
        let done = eval_planes::<T>(Machine::detect(), basis.constants(), order, components, out);
        #[cfg(not(feature = "simd"))]
        let done = 0;
        basis.eval_many_from(done, order, components, out);
    }

    pub(super) fn eval_expansion_into(basis: &Basis<T>, coefficients: &[T], components: [&[T]; 3], out: &mut [T]) {
        #[cfg(feature = "simd")]
        let done = {
            let order = order_of_slice(coefficients);
            eval_sums::<T>(Machine::detect(), basis.constants(), coefficients, order, components, out)
        };
        #[cfg(not(feature = "simd"))]
        let done = 0;
        basis.eval_expansion_from(done, coefficients, components, out);
    }

    pub(super) fn eval_colors_into(
        basis: &Basis<T>,
        coefficients: &[Rgb<T>],
        components: [&[T]; 3],
        out: &mut [Rgb<T>],
    ) {
        basis.eval_expansion_from(0, coefficients, components, out);
    }
}

/// `BLOCK` components from `start`.
#[inline(always)]
fn block_of<S: Real>(component: &[S], start: usize) -> [S; BLOCK] {
    lanes(|k| component[start + k])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::basis::eval_basis;
    use crate::sphere::Dir;
    use lobe_testkit::directions;

    #[test]
    fn no_directions_and_order_zero_have_no_values() {
        let basis = Basis::<f32>::new(0);
        basis.eval_many_into([&[], &[], &[]], &mut []);
        basis.eval_many_into([&[0.0; 17], &[0.0; 17], &[1.0; 17]], &mut []);
        let mut sums = [7.0_f32; 17];
        basis.eval_expansion_into::<f32>(&[], [&[0.0; 17], &[0.0; 17], &[1.0; 17]], &mut sums);
        assert_eq!(sums, [0.0; 17], "an expansion of order 0 is zero");
        assert!(eval_basis(Dir::X, 0).is_empty(), "order 0");
    }

    #[test]
    #[should_panic(expected = "no directions have no values, not 4")]
    fn values_of_no_directions_are_refused() {
        Basis::<f64>::new(2).eval_many_into([&[], &[], &[]], &mut [0.0; 4]);
    }

    #[test]
    fn blocks_of_directions_equal_single_ones() {
        let all = directions();
        let component = |k: usize| all.iter().map(|v| v[k] as f32).collect::<Vec<f32>>();
        let (x, y, z) = (component(0), component(1), component(2));
        for order in [1, 2, 6, 17] {
            for count in [1, BLOCK - 1, BLOCK, BLOCK + 1, all.len()] {
                let mut many = vec![0.0_f32; coefficient_count(order) * count];
                let basis = Basis::new(order);
                basis.eval_many_into([&x[..count], &y[..count], &z[..count]], &mut many);
                let mut one = vec![0.0_f32; coefficient_count(order)];
                for k in 0..count {
                    basis.eval_into([x[k], y[k], z[k]], &mut one);
                    for i in 0..coefficient_count(order) {
                        let (a, b) = (many[i * count + k], one[i]);
                        assert!(
                            (a - b).abs() < 1e-6,
                            "order {order}, y_{i}, direction {k} of {count}: {a} against {b}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn an_expansion_has_one_value_by_every_route() {
        use crate::expansion::Expansion as _;
        let f = crate::ShVec::from_vec(lobe_testkit::Random::new(9).signed_vec(100)).unwrap();
        let all = directions();
        let component = |k: usize| all.iter().map(|v| v[k]).collect::<Vec<f64>>();
        let mut many = vec![0.0; all.len()];
        f.eval_many_into([&component(0), &component(1), &component(2)], &mut many);
        for (v, value) in all.iter().zip(many) {
            let s = Dir::from_unit(*v);
            let by_basis: f64 = eval_basis(s, 10).iter().zip(f.coefficients()).map(|(y, c)| y * c).sum();
            assert!((value - by_basis).abs() < 1e-12, "towards {v:?}: {value} against {by_basis}");
            assert!((f.eval(s) - by_basis).abs() < 1e-12, "towards {v:?}: {} against {by_basis}", f.eval(s));
        }
    }

    #[test]
    fn many_directions_give_f32_and_colors_their_values() {
        use crate::expansion::Expansion as _;
        use crate::scalar::Rgb;
        let f = crate::ShVec::from_vec(lobe_testkit::Random::new(10).signed_vec(36)).unwrap();
        let color = f.map(|c| Rgb::new(c as f32, -2.0 * c as f32, 0.0));
        let all = directions();
        let component = |k: usize| all.iter().map(|v| v[k] as f32).collect::<Vec<f32>>();
        let mut many = vec![Rgb::default(); all.len()];
        color.eval_many_into([&component(0), &component(1), &component(2)], &mut many);
        for (v, value) in all.iter().zip(many) {
            let expected = f.eval(Dir::from_unit(*v));
            // 36 terms of size 1, each with the rounding of its basis function and of the direction.
            assert!((f64::from(value.r) - expected).abs() < 1e-5, "towards {v:?}: {} against {expected}", value.r);
            assert!((value.g + 2.0 * value.r).abs() < 1e-5 && value.b == 0.0, "channels towards {v:?}: {value:?}");
        }
    }
}
