//! Colors and expansions as plain bytes (feature `bytemuck`), to copy them to vertex and uniform buffers.

#![allow(unsafe_code, reason = "bytemuck derives `Pod` for no type with parameters whose layout it cannot compute")]

use bytemuck::{Pod, Zeroable};

use crate::expansion::Sh;
use crate::scalar::Rgb;

// SAFETY: `Rgb` is `repr(C)` with three fields of one type, so that there is no padding, and every bit pattern of them
// is a color.
unsafe impl<S: Zeroable> Zeroable for Rgb<S> {}

// SAFETY: as above, and `S` is `Pod`.
unsafe impl<S: Pod> Pod for Rgb<S> {}

// SAFETY: `Sh` is `repr(transparent)` over an array.
unsafe impl<const N: usize, T: Zeroable> Zeroable for Sh<N, T> {}

// SAFETY: `Sh` is `repr(transparent)` over an array, and `T` is `Pod`.
unsafe impl<const N: usize, T: Pod> Pod for Sh<N, T> {}

#[cfg(test)]
mod tests {
    use crate::expansion::{Expansion as _, ShL1, ShL2};
    use crate::scalar::Rgb;

    #[test]
    fn an_expansion_is_its_numbers_in_order() {
        let f = ShL1::from([[1.0_f32, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0], [10.0, 11.0, 12.0]]);
        let numbers: &[f32] = bytemuck::cast_slice(std::slice::from_ref(&f));
        assert_eq!(numbers, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0], "three for each row");
        assert_eq!(bytemuck::bytes_of(&f).len(), 48, "no padding");
    }

    #[test]
    fn numbers_are_read_in_place_as_expansions() {
        let numbers: Vec<f32> = (0..54).map(|k| k as f32).collect();
        let probes: &[ShL2<Rgb<f32>>] = bytemuck::cast_slice(&numbers);
        assert_eq!(probes.len(), 2, "27 numbers each");
        assert_eq!(probes[1].coefficients()[8], Rgb::new(51.0, 52.0, 53.0), "the last row");
    }
}
