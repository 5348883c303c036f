//! The places that the generated code writes to.

use crate::simd::{Lane, Wide};

/// Where the values of directions go.
pub(crate) trait Places<S: pulp::Simd, T: Lane = f32> {
    /// Takes the values of `y_i`.
    fn put(&mut self, i: usize, value: Wide<S, T>);
}
