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

/// Whether results are so large that they go past the caches: as large as the third cache, where the processor tells its size. Where that is
/// 8 MB, copies past it take 0.65, 0.52 and 0.54 of the time of ordinary ones to 8, 12 and 36 MB, and 0.65 to 0.73 with a reading of all
/// afterwards; to 4 MB 1.5 and 1.9 times as long (AMD, AVX2).
pub(crate) fn are_many<T>(results: &[T]) -> bool {
    cfg!(target_arch = "x86_64") && size_of_val(results) >= third_cache().unwrap_or(MANY_BYTES).min(MANY_BYTES)
}

/// The bytes of the cache of the third level, which cores share.
fn third_cache() -> Option<usize> {
    cache_bytes(3)
}

/// The bytes of the cache for data of a level, 1 to 3, where the processor tells.
pub fn cache_bytes(level: u32) -> Option<usize> {
    static BYTES: std::sync::OnceLock<[Option<usize>; 3]> = std::sync::OnceLock::new();
    #[cfg(target_arch = "x86_64")]
    let ask = told_by_processor;
    #[cfg(not(target_arch = "x86_64"))]
    let ask = |_| None;
    let place = (level as usize).checked_sub(1)?;
    BYTES.get_or_init(|| [1, 2, 3].map(ask)).get(place).copied().flatten()
}

/// What `cpuid` says of caches, one after the other: leaf `0x8000_001d` of AMD (APM volume 3, appendix E), leaf 4 of Intel (SDM volume 2A).
#[cfg(target_arch = "x86_64")]
fn told_by_processor(level: u32) -> Option<usize> {
    use core::arch::x86_64::{__cpuid, __cpuid_count};

    /// The leaf that says which leaves there are besides the first ones.
    const EXTENDED: u32 = 0x8000_0000;
    /// More caches than processors have.
    const MOST_CACHES: u32 = 8;

    let of_leaf = |leaf: u32| {
        let mut caches = (0..MOST_CACHES).map(|k| __cpuid_count(leaf, k)).map(|told| [told.eax, told.ebx, told.ecx]);
        caches.find_map(|told| cache_of(told).filter(|(of, _)| *of == level)).map(|(_, bytes)| bytes)
    };
    let has = |leaf: u32| __cpuid(leaf & EXTENDED).eax >= leaf;
    [0x8000_001d, 4].into_iter().filter(|leaf| has(*leaf)).find_map(of_leaf)
}

/// The level and the bytes of a cache by the registers eax, ebx and ecx of these leaves, which have one layout; `None` if they tell of
/// none for data. All but the type and the level are less by one than what they count.
///
/// ```text
///   eax: type 0..5, level 5..8      ebx: bytes of a line 0..12, lines of a partition 12..22, ways 22..32      ecx: sets
///   bytes = line · partition · ways · sets
/// ```
#[cfg(target_arch = "x86_64")]
fn cache_of([eax, ebx, ecx]: [u32; 3]) -> Option<(u32, usize)> {
    /// Types: 2 is one of instructions alone.
    const DATA: u32 = 1;
    const UNIFIED: u32 = 3;
    let [line, partition, ways, sets] =
        [ebx & 0xfff, ebx >> 12 & 0x3ff, ebx >> 22, ecx].map(|less_by_one| less_by_one as usize + 1);
    (matches!(eax & 0x1f, DATA | UNIFIED)).then_some((eax >> 5 & 7, line * partition * ways * sets))
}

/// Copies numbers past the caches, for results that are larger than the caches and not read soon: their lines are neither
/// read from memory before they are overwritten, nor do they take the place of others. On machines that are not x86-64 an ordinary copy.
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

    /// Unified caches with lines of 64 bytes: 32 MB and 8 MB of 16 ways on the third level, 1.25 MB of 10 ways on the second.
    #[cfg(target_arch = "x86_64")]
    #[test]
    fn caches_have_the_sizes_that_their_registers_tell() {
        assert_eq!(cache_of([0x1c163, 0x03c0_003f, 0x7fff]), Some((3, 32 << 20)), "2^15 sets");
        assert_eq!(cache_of([0x1c03_c163, 0x03c0_003f, 0x1fff]), Some((3, 8 << 20)), "2^13 sets");
        assert_eq!(cache_of([0x0000_4143, 0x0240_003f, 0x07ff]), Some((2, 1280 << 10)), "2^11 sets");
        assert_eq!(cache_of([0x0000_4121, 0x01c0_003f, 0x003f]), Some((1, 32 << 10)), "8 ways of data");
        assert_eq!(cache_of([0x0000_4122, 0x01c0_003f, 0x003f]), None, "instructions");
        assert_eq!(cache_of([0, 0x0240_003f, 0x07ff]), None, "type 0");
    }

    #[test]
    fn few_results_stay_in_the_caches_and_many_do_not() {
        let [few, many] = [1 << 10, MANY_BYTES].map(|bytes| vec![0_u8; bytes]);
        let found = [are_many(&few), are_many(&many)];
        assert_eq!(found, [false, cfg!(target_arch = "x86_64")], "a third cache of {:?} bytes", third_cache());
    }

    #[test]
    fn copies_have_any_length_and_place() {
        assert_copies::<f32>();
        assert_copies::<f64>();
    }
}
