//! Copies to memory that is not read soon.
//!
//! Rationale
//! - An ordinary store reads its line of the cache from memory first, which is a third of the bytes that a table larger than the caches moves, and
//!   throws out what lies in them. Non-temporal stores of whole lines do neither.
//! - They are no part of pulp, and none of the language but as intrinsics on pointers: hence the `unsafe` of this file, the
//!   only one of the crate besides that of the feature `bytemuck`.
//! - Registers of 16 bytes, which every machine with x86-64 has: four of them make a line, and memory is the bound.

#![allow(unsafe_code, reason = "non-temporal stores take pointers; see above")]

use core::mem::size_of_val;

use crate::simd::Lane;

/// Results of at least as many bytes go past the caches: nothing of so many would be found in the caches of most
/// machines. Of 36 MB, a million directions of order 3, non-temporal stores took 1.4 times as long into planes and as long into a batch; of 144 MB,
/// order 6, 0.5 and 0.42 of the time (Xeon, AVX-512).
const MANY_BYTES: usize = 40 << 20;

/// Whether results are so large that they go past the caches.
pub(crate) fn are_many<T>(results: &[T]) -> bool {
    cfg!(target_arch = "x86_64") && size_of_val(results) >= MANY_BYTES
}

/// Copies numbers, whole lines past the caches. [`finish`] is to be called before another thread may read them.
///
/// # Panics
/// If the lengths differ.
#[cfg(target_arch = "x86_64")]
pub(crate) fn copy<T: Lane>(from: &[T], to: &mut [T]) {
    use core::arch::x86_64::{_mm_loadu_ps, _mm_stream_ps};

    /// Numbers of a register.
    const REGISTER: usize = 4;

    #[repr(align(64))]
    struct Line;

    assert_eq!(from.len(), to.len(), "numbers to be copied");
    let before = to.as_ptr().align_offset(align_of::<Line>()).min(to.len());
    let (from_start, from) = from.split_at(before);
    let (to_start, to) = to.split_at_mut(before);
    to_start.copy_from_slice(from_start);
    let lines = size_of_val(from) / align_of::<Line>();
    let singles = lines * align_of::<Line>() / size_of::<f32>();
    let (source, target) = (from.as_ptr().cast::<f32>(), to.as_mut_ptr().cast::<f32>());
    for at in (0..singles).step_by(REGISTER) {
        // SAFETY: `Lane` is f32 or f64. Both slices have `singles` times four bytes, which are numbers of the first or halves of some of the second, loaded and
        // stored as bits; `to` begins at a line, so that every sixteenth byte is aligned.
        unsafe { _mm_stream_ps(target.add(at), _mm_loadu_ps(source.add(at))) };
    }
    let done = lines * align_of::<Line>() / size_of::<T>();
    to[done..].copy_from_slice(&from[done..]);
}

/// The same by ordinary stores.
#[cfg(not(target_arch = "x86_64"))]
pub(crate) fn copy<T: Lane>(from: &[T], to: &mut [T]) {
    to.copy_from_slice(from);
}

/// Lets no later store pass those of [`copy`].
pub(crate) fn finish() {
    // SAFETY: every machine with x86-64 has the instruction.
    #[cfg(target_arch = "x86_64")]
    unsafe {
        core::arch::x86_64::_mm_sfence();
    };
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use super::*;

    fn assert_copies<T: Lane>() {
        let from: Vec<T> = (0..200).map(|k| T::from_f64(f64::from(k) - 50.5)).collect();
        for start in 0..20 {
            for count in [0, 1, 7, 16, 33, 180] {
                let mut to = [T::ZERO; 200];
                copy(&from[..count], &mut to[start..start + count]);
                finish();
                assert_eq!(to[start..start + count], from[..count], "{count} from {start} on");
                let others = to[..start].iter().chain(&to[start + count..]);
                assert!(others.into_iter().all(|x| *x == T::ZERO), "beside {count} from {start} on");
            }
        }
    }

    #[test]
    fn copies_have_any_length_and_place() {
        assert_copies::<f32>();
        assert_copies::<f64>();
    }
}
