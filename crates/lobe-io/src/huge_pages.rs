//! Large arrays on huge pages.
//!
//! The one file of this crate with `unsafe`: an allocator cannot be had without, and advice to the system takes a
//! pointer.
#![allow(unsafe_code, reason = "an allocator, and the system call by which it asks for huge pages; see above")]

use std::alloc::{GlobalAlloc, Layout};
use std::env::var_os;
use std::ffi::OsStr;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::error::IoError;

/// The variable that keeps a process from huge pages.
const VARIABLE: &str = "LOBE_HUGE_PAGES";

/// Allocations of fewer bytes are left as they are. A page more than they need would be half of them or more.
const LEAST: usize = 4 << 20;

/// The bytes of a huge page, of x86-64 and of most others. Where it is larger, advice on parts of a page does nothing.
const PAGE: usize = 2 << 20;

/// Whether large allocations ask for huge pages.
static IS_ON: AtomicBool = AtomicBool::new(true);

/// An allocator whose allocations of 4 MiB and more lie on huge pages, if the system has some.
///
/// Rays through a large tree, and whatever else reads here and there in much memory, wait for the table of pages. A
/// page of 2 MiB takes one place in it where 512 usual ones do, and the system clears it in one go. Linux gives such
/// pages to memory for which `madvise(MADV_HUGEPAGE)` asks (`/sys/kernel/mm/transparent_hugepage/enabled` is `madvise`
/// or `always`). Elsewhere the allocator is the one that it stands on.
///
/// mimalloc, which the command stands on, asks for huge pages by itself. This is for programs with the system's
/// allocator: a million triangles so take rays of a bundle 0.80 to 0.86 of the time, single ones 0.87 to 0.95 (AMD
/// EPYC, `cargo bench -p lobe-scene --bench rays -- 1M`).
///
/// Only whole huge pages within an allocation are asked for, so a process takes no memory beyond its allocations. What
/// an array has allocated and not written yet takes up to 2 MiB.
///
/// ```no_run
/// use std::alloc::System;
///
/// use lobe_io::HugePages;
///
/// #[global_allocator]
/// static ALLOCATOR: HugePages<System> = HugePages::new(System).growing_by_remapping();
/// ```
#[derive(Clone, Copy, Debug)]
pub struct HugePages<A> {
    allocator: A,
    remaps: bool,
}

impl<A> HugePages<A> {
    /// Huge pages for the large allocations of this allocator. A large one that grows is copied to a new one.
    #[must_use]
    pub const fn new(allocator: A) -> Self {
        Self { allocator, remaps: false }
    }
}

impl<A: Copy> HugePages<A> {
    /// The same for an allocator that lets the system move the pages of a large allocation that grows, as those of C
    /// libraries on Linux do. Nothing is copied then.
    #[must_use]
    pub const fn growing_by_remapping(self) -> Self {
        Self { remaps: true, ..self }
    }
}

// SAFETY: what is returned comes from the allocator below, which is asked by its own contract. Advice moves and changes
// nothing.
unsafe impl<A: GlobalAlloc> GlobalAlloc for HugePages<A> {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller keeps the contract of this function, which is that of the allocator's.
        advised(unsafe { self.allocator.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as above.
        advised(unsafe { self.allocator.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        if size < LEAST || size <= layout.size() || self.remaps {
            // SAFETY: as above.
            return advised(unsafe { self.allocator.realloc(memory, layout, size) }, size);
        }
        // The advice comes before the copy, which would otherwise be the first to touch the pages.
        // SAFETY: the caller has seen to it that a layout of this size is none that overflows.
        let grown = unsafe { self.alloc(Layout::from_size_align_unchecked(size, layout.align())) };
        if !grown.is_null() {
            // SAFETY: both are there, apart from each other, and have as many bytes; the first was allocated by this
            // layout.
            unsafe {
                std::ptr::copy_nonoverlapping(memory, grown, layout.size());
                self.allocator.dealloc(memory, layout);
            }
        }
        grown
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: as above.
        unsafe { self.allocator.dealloc(memory, layout) }
    }
}

/// Takes the choice of `LOBE_HUGE_PAGES`, `on` or `off`, for the memory that follows; without it huge pages are on.
///
/// On Linux `off` holds for the whole process, whatever allocators it has.
///
/// # Errors
/// [`IoError::Invalid`] for another value, such as a typing error.
pub fn choose_huge_pages() -> Result<(), IoError> {
    let is_on = var_os(VARIABLE).map_or(Ok(true), |value| is_on(&value))?;
    IS_ON.store(is_on, Ordering::Relaxed);
    if !is_on {
        keep_from_huge_pages();
    }
    Ok(())
}

/// Has the system give this process no huge page any more. A system that cannot may go on giving them.
#[cfg(target_os = "linux")]
fn keep_from_huge_pages() {
    let [yes, none]: [libc::c_ulong; 2] = [1, 0];
    // SAFETY: the call takes numbers only, and changes nothing of the memory that is there.
    unsafe { libc::prctl(libc::PR_SET_THP_DISABLE, yes, none, none, none) };
}

#[cfg(not(target_os = "linux"))]
fn keep_from_huge_pages() {}

fn is_on(value: &OsStr) -> Result<bool, IoError> {
    match value.to_str() {
        Some("" | "on") => Ok(true),
        Some("off") => Ok(false),
        _ => {
            let found = value.to_string_lossy();
            let message = format!("expected on or off, found `{found}`; correct or unset it");
            Err(IoError::Invalid { place: VARIABLE.to_owned(), message })
        }
    }
}

/// The same memory, after the system was asked for huge pages for it, if it is large.
fn advised(memory: *mut u8, bytes: usize) -> *mut u8 {
    if bytes >= LEAST && !memory.is_null() && IS_ON.load(Ordering::Relaxed) {
        advise(memory, bytes);
    }
    memory
}

/// Asks for the whole huge pages within this memory. Without, all stays as it is: a refusal is no error.
#[cfg(target_os = "linux")]
fn advise(memory: *mut u8, bytes: usize) {
    let before = memory.addr().next_multiple_of(PAGE) - memory.addr();
    let inside = bytes.saturating_sub(before) / PAGE * PAGE;
    if inside > 0 {
        // SAFETY: the range lies within an allocation, and this advice changes nothing that is in it.
        unsafe { libc::madvise(memory.wrapping_add(before).cast(), inside, libc::MADV_HUGEPAGE) };
    }
}

#[cfg(not(target_os = "linux"))]
fn advise(_: *mut u8, _: usize) {
    let _ = PAGE;
}

#[cfg(test)]
mod tests {
    use std::alloc::System;

    use super::*;

    /// Allocates, fills, and grows twice, beyond the size from which pages are huge; returns what the last part is
    /// like.
    fn grown<T>(allocator: &HugePages<System>, look: impl Fn(*mut u8, usize) -> T) -> T {
        let layout = |bytes: usize| Layout::from_size_align(bytes, 64).unwrap();
        let sizes = [LEAST / 2, 2 * LEAST + 12_345, 8 * LEAST];
        // SAFETY: each allocation is used within its bounds, freed by its own layout, and checked to be there.
        unsafe {
            let mut memory = allocator.alloc(layout(sizes[0]));
            for pair in sizes.windows(2) {
                assert!(!memory.is_null(), "no memory");
                for place in (0..pair[0]).step_by(4096) {
                    memory.add(place).write((place / 4096) as u8);
                }
                memory = allocator.realloc(memory, layout(pair[0]), pair[1]);
                for place in (0..pair[0]).step_by(4096) {
                    assert_eq!(memory.add(place).read(), (place / 4096) as u8, "byte {place} of {}", pair[0]);
                }
            }
            let result = look(memory, sizes[2]);
            allocator.dealloc(memory, layout(sizes[2]));
            result
        }
    }

    /// What `/proc/self/smaps` has about the mapping at an address: whether it has asked for huge pages.
    #[cfg(target_os = "linux")]
    fn has_asked(memory: *mut u8) -> bool {
        let maps = std::fs::read_to_string("/proc/self/smaps").unwrap();
        let mut is_here = false;
        for line in maps.lines() {
            let range = line.split_whitespace().next().and_then(|word| word.split_once('-'));
            let ends = range.map(|(a, b)| [a, b].map(|end| usize::from_str_radix(end, 16)));
            if let Some([Ok(start), Ok(end)]) = ends {
                is_here = (start..end).contains(&memory.addr());
            } else if is_here && line.starts_with("VmFlags:") {
                return line.split_whitespace().any(|flag| flag == "hg");
            }
        }
        false
    }

    #[test]
    fn what_grows_keeps_its_bytes_and_lies_on_huge_pages_unless_they_are_off() {
        for allocator in [HugePages::new(System), HugePages::new(System).growing_by_remapping()] {
            #[cfg(target_os = "linux")]
            if std::path::Path::new("/sys/kernel/mm/transparent_hugepage/enabled").exists() {
                let middle = |memory: *mut u8, bytes: usize| has_asked(memory.wrapping_add(bytes / 2));
                assert!(grown(&allocator, middle), "no huge pages asked for: {allocator:?}");
                IS_ON.store(false, Ordering::Relaxed);
                let asked = grown(&allocator, middle);
                IS_ON.store(true, Ordering::Relaxed);
                assert!(!asked, "huge pages asked for though they are off: {allocator:?}");
                continue;
            }
            grown(&allocator, |_, _| ());
        }
    }

    #[test]
    fn a_choice_is_on_or_off_and_nothing_else() {
        for (value, expected) in [("", true), ("on", true), ("off", false)] {
            assert_eq!(is_on(value.as_ref()).unwrap(), expected, "`{value}`");
        }
        for value in ["0", "Off", "never"] {
            let message = is_on(value.as_ref()).unwrap_err().to_string();
            let expected = format!("LOBE_HUGE_PAGES: expected on or off, found `{value}`; correct or unset it");
            assert_eq!(message, expected, "what is said");
        }
    }
}
