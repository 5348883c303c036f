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

/// Results of at least as many bytes go past the caches however large these are. Of 36 MB, a million directions of order 3, non-temporal
/// stores took 1.4 times as long into planes and as long into a batch on a Xeon whose last cache holds them; of 144 MB, order 6, 0.5 and
/// 0.42 of the time.
const MANY_BYTES: usize = 40 << 20;

/// Whether results are so large that they go past the caches: as large as the last cache, where the processor tells how large that is.
pub(crate) fn are_many<T>(results: &[T]) -> bool {
    cfg!(target_arch = "x86_64") && size_of_val(results) >= last_cache().unwrap_or(MANY_BYTES).min(MANY_BYTES)
}

/// The bytes of the last cache.
fn last_cache() -> Option<usize> {
    static BYTES: std::sync::OnceLock<Option<usize>> = std::sync::OnceLock::new();
    #[cfg(target_arch = "x86_64")]
    let ask = told_by_processor;
    #[cfg(not(target_arch = "x86_64"))]
    let ask = || None;
    *BYTES.get_or_init(ask)
}

/// What `cpuid` says of caches, level by level: leaf 4 of Intel, 0x8000001D of AMD, of one layout.
#[cfg(target_arch = "x86_64")]
fn told_by_processor() -> Option<usize> {
    use core::arch::x86_64::{__cpuid, __cpuid_count};

    const EXTENDED: u32 = 0x8000_0000;
    /// More than processors have of them.
    const MOST_CACHES: u32 = 8;

    let bytes_of = |leaf: u32| {
        let caches = (0..MOST_CACHES).map(|k| __cpuid_count(leaf, k)).take_while(|cache| cache.eax & 31 != 0);
        let last = caches.max_by_key(|cache| cache.eax >> 5 & 7)?;
        let [line, partitions, ways] =
            [last.ebx & 0xfff, last.ebx >> 12 & 0x3ff, last.ebx >> 22].map(|n| n as usize + 1);
        Some(line * partitions * ways * (last.ecx as usize + 1))
    };
    let has = |leaf: u32| __cpuid(leaf & EXTENDED).eax >= leaf;
    [0x8000_001d, 4].into_iter().filter(|leaf| has(*leaf)).find_map(bytes_of)
}

/// Copies numbers past the caches, for results that are larger than these and not read soon: their lines are neither read from
/// memory before they are overwritten, nor do they take the place of others. On machines that are not x86-64 an ordinary copy.
///
/// # Panics
/// If the lengths differ.
pub fn copy_past_caches(from: &[f32], to: &mut [f32]) {
    copy(from, to);
    finish();
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
    use alloc::vec;
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
    fn a_cache_that_is_told_has_the_size_of_one() {
        if let Some(bytes) = last_cache() {
            assert!((1 << 16..1 << 32).contains(&bytes), "{bytes}");
        }
        let [few, many] = [1 << 10, MANY_BYTES].map(|bytes| vec![0_u8; bytes]);
        assert!(!are_many(&few) && (are_many(&many) || !cfg!(target_arch = "x86_64")), "at most 40 MiB");
    }

    #[test]
    fn copies_have_any_length_and_place() {
        assert_copies::<f32>();
        assert_copies::<f64>();
    }
}
