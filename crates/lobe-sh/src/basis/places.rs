//! The places that the generated code writes to.

use crate::simd::Wide;

/// Where the values of sixteen directions go.
pub(crate) trait Places<S: pulp::Simd> {
    /// Takes the values of `y_i`.
    fn put(&mut self, i: usize, value: Wide<S>);
}
