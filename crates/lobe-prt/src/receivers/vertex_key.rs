//! Keys of vertices: equal for equal numbers, so that vertices of one place are found however they are stored.

/// The bits of the numbers of a vertex. Adding zero makes -0 and 0 the same bits.
pub(crate) fn vertex_key<const N: usize>(numbers: [f32; N]) -> [u32; N] {
    numbers.map(|c| (c + 0.0).to_bits())
}
