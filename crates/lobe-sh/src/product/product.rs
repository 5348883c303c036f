//! The product of two functions.

use crate::basis::index::{coefficient_count, order_of_slice};
use crate::by_type::{by_type, of_each_type};
use crate::expansion::{Expansion as _, Zonal};
use crate::once::Once;
use crate::product::gaunt::{GauntTensor, MAX_GAUNT_ORDER};
use crate::product::grid::product_on_grid;
#[cfg(feature = "simd")]
use crate::product::lane_rows::{LEAST_COUNT, multiply_by_rows};
use crate::product::straight_line;
use crate::scalar::{Coefficient, Real as _};
#[cfg(feature = "simd")]
use crate::simd::Machine;

/// The product of two functions, cut off at the order that `out` has room for.
///
/// ```text
///   c_k = ∫ f g y_k ds = Σ_ij Γ_ijk a_i b_j        Γ_ijk = ∫ y_i y_j y_k ds
/// ```
///
/// The caller chooses the order of the product. The full product of functions of orders `n_a` and `n_b` has order
/// `n_a + n_b - 1`; a lower order drops the highest bands. Truncated products commute, and the constant 1, the
/// expansion `√(4π) y_00`, is their unit element, but they **do not associate**: `(f g) h` and `f (g h)` lose different
/// bands before the last product (test `truncated_products_do_not_associate`). [`product_on_grid`] multiplies many
/// factors and truncates once.
///
/// Common orders, 2 to 6 and some mixtures, have straight-line code, written by the crate `lobe-tables`; other
/// orders up to [`MAX_GAUNT_ORDER`] use the sparse tensor of Gaunt coefficients, and higher ones a grid. Where the
/// [`Machine`] has wide instructions, those of one order from 5 to 10 in `f32` use the rows of a quadrature rule side by
/// side. In `f64` all equal quadrature within 1e-12 of the largest coefficient (test
/// `products_equal_quadrature_at_every_mix_of_orders`), and rows in `f32` the tensor within 2e-5 (test `rows_multiply_as_the_tensor`).
///
/// The method of the generated code is after [Snyder 2006]; where it gathers triples of coefficients this one gathers
/// triples of complex numbers, which needs a quarter fewer operations.
///
/// ```
/// use lobe_sh::product::product_into;
/// use lobe_sh::{Dir, Expansion as _, ShVec};
///
/// let f = ShVec::impulse(2, Dir::X, 1.0);
/// let mut square = ShVec::zero(3);
/// product_into(f.coefficients(), f.coefficients(), square.coefficients_mut());
/// let (value, expected): (f64, f64) = (square.eval(Dir::Z), f.eval(Dir::Z) * f.eval(Dir::Z));
/// assert!((value - expected).abs() < 1e-15);
/// ```
///
/// # Panics
/// If a length is no perfect square.
///
/// [Snyder 2006]: https://www.microsoft.com/en-us/research/publication/code-generation-and-factoring-for-fast-evaluation-of-low-order-spherical-harmonic-products-and-squares/
#[inline]
pub fn product_into<T: Coefficient>(a: &[T], b: &[T], out: &mut [T]) {
    // Products commute, and the generated code has the factor of higher order first.
    let (a, b) = if a.len() < b.len() { (b, a) } else { (a, b) };
    if !product_by_rows(a, b, out) && !straight_line::general(a, b, out) {
        by_type!(T: a, b; mut out => product_by_tensor_or_grid(a, b, out));
    }
}

/// The product in the lanes of the machine, where it has wide instructions for the type and the orders; whether it has.
#[inline]
fn product_by_rows<T: Coefficient>(a: &[T], b: &[T], out: &mut [T]) -> bool {
    #[cfg(feature = "simd")]
    if a.len() >= LEAST_COUNT
        && let (Some(a), Some(b), Some(out)) = (T::single_slice(a), T::single_slice(b), T::single_slice_mut(out))
    {
        return multiply_by_rows(Machine::detect(), a, b, out);
    }
    #[cfg(not(feature = "simd"))]
    let _ = (a, b, out);
    false
}

/// The square of a function, cut off at the order that `out` has room for.
///
/// The same as [`product_into`] with both factors equal, in about 0.6 of the operations for orders 2 to 6.
///
/// # Panics
/// If a length is no perfect square.
#[inline]
pub fn square_into<T: Coefficient>(a: &[T], out: &mut [T]) {
    if !straight_line::square(a, out) {
        product_into(a, a, out);
    }
}

/// The product of a zonal function about +z with any function, cut off at the order that `out` has room for.
///
/// The same as [`product_into`] with the expansion of `zonal`, in an eighth of the operations at order 6: the matrix
/// of such a product joins coefficients of equal `m` alone, and its entries depend on `|m|`. For another axis rotate
/// the function so that the axis becomes +z, multiply, and rotate back.
///
/// # Panics
/// If a length is no perfect square.
pub fn zonal_product_into<T: Coefficient>(zonal: &Zonal, b: &[T], out: &mut [T]) {
    /// The highest order that has generated code.
    const LONGEST: usize = 6;
    let mut z = [<T::Scalar as Coefficient>::ZERO; LONGEST];
    let order = order_of_slice(b);
    // Missing bands of the zonal function are zero.
    if zonal.order() <= order && order <= LONGEST {
        for (z, coefficient) in z.iter_mut().zip(zonal.coefficients()) {
            *z = T::Scalar::from_f64(*coefficient);
        }
        if straight_line::zonal(&z[..order], b, out) {
            return;
        }
    }
    let mut f = vec![T::ZERO; coefficient_count(zonal.order())];
    for (l, coefficient) in zonal.coefficients().iter().enumerate() {
        f[l * (l + 1)] = T::splat(T::Scalar::from_f64(*coefficient));
    }
    product_into(&f, b, out);
}

of_each_type! {
    pub(super) fn product_by_tensor_or_grid(a: &[T], b: &[T], out: &mut [T]) {
        let [n_a, n_b, n_out] = [order_of_slice(a), order_of_slice(b), order_of_slice(out)];
        let highest = n_a.max(n_b).max(n_out);
        if highest <= MAX_GAUNT_ORDER {
            shared_tensor([n_a, n_b, n_out]).product_into(a, b, out);
        } else {
            out.copy_from_slice(product_on_grid(&[a, b], n_out).coefficients());
        }
    }
}

/// The tensor for these orders, made once.
fn shared_tensor(orders: [usize; 3]) -> &'static GauntTensor {
    const SIDE: usize = MAX_GAUNT_ORDER + 1;
    static TENSORS: [Once<GauntTensor>; SIDE * SIDE * SIDE] = [const { Once::new() }; SIDE * SIDE * SIDE];
    let [a, b, out] = orders;
    TENSORS[(a * SIDE + b) * SIDE + out].get_or_init(|| GauntTensor::new(a, b, out))
}
