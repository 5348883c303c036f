//! Products and rotations of single functions, for `f32`.

use crate::product::product::product_into;
use crate::rotation::rotation::Rotation;

/// [`Rotation::apply_into`] of one function.
///
/// # Panics
/// As it.
#[inline(never)]
pub fn rotate_one(turn: &Rotation, f: &[f32], out: &mut [f32]) {
    turn.apply_into(f, out);
}

/// [`product_into`] of pairs of functions with `n` coefficients each, one pair after the other.
///
/// # Panics
/// As it, or if `n` is 0.
#[inline(never)]
pub fn multiply_pairs(n: usize, a: &[f32], b: &[f32], out: &mut [f32]) {
    for ((a, b), out) in a.chunks_exact(n).zip(b.chunks_exact(n)).zip(out.chunks_exact_mut(n)) {
        product_into(a, b, out);
    }
}
