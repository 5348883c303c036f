//! Failures that the standard library leaves to the system: memory that is refused, and a stdout that was closed.
//!
//! The one place of this program with `unsafe`. An allocator cannot be had without; refused memory ends the program by a
//! signal, whose handler has to be asked for, because `std::alloc::set_alloc_error_hook` is not stable; and the standard
//! library opens /dev/null in place of a stdout that was closed before `main` can look.
#![allow(unsafe_code, reason = "an allocator, a handler of a signal and a look before main; see above")]

use std::alloc::{GlobalAlloc, Layout};
use std::io;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use mimalloc::MiMalloc;

/// The bytes that were asked for last in vain.
static REFUSED: AtomicUsize = AtomicUsize::new(0);

/// Whether stdout was closed when the program began.
static STDOUT_IS_CLOSED: AtomicBool = AtomicBool::new(false);

/// mimalloc, remembering what it refuses. Maps are many large arrays, each used once: memory that is kept, in large pages,
/// spares the system's work for every page of them (`cargo run --release -p lobe-env --example convert_large`: a quarter of
/// the time).
///
/// Whoever asks whether memory is there, as `Vec::try_reserve` does, is told that it is not; all else aborts, which
/// [`tell_refused_memory`] turns into a line.
pub(crate) struct Allocator;

fn remembered(memory: *mut u8, bytes: usize) -> *mut u8 {
    if memory.is_null() {
        REFUSED.store(bytes, Ordering::Relaxed);
    }
    memory
}

// SAFETY: all calls are handed on to mimalloc as they are, and so is what it returns.
unsafe impl GlobalAlloc for Allocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller keeps the contract of this function, which is that of mimalloc's.
        remembered(unsafe { MiMalloc.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as above.
        remembered(unsafe { MiMalloc.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: as above.
        remembered(unsafe { MiMalloc.realloc(memory, layout, size) }, size)
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: as above.
        unsafe { MiMalloc.dealloc(memory, layout) }
    }
}

/// From now on a program that aborts because memory was refused says so in one line, after that of the standard library, and
/// exits as with any other error. Elsewhere than on Unix it aborts.
pub(crate) fn tell_refused_memory() {
    #[cfg(unix)]
    // SAFETY: the handler calls nothing but atomics, formatting into an array, `write` and `_exit`, which are safe in handlers
    // of signals. Where it cannot be registered, the program aborts as it would without.
    let _ = unsafe { signal_hook::low_level::register(libc::SIGABRT, on_abort) };
}

#[cfg(unix)]
fn on_abort() {
    use std::io::Write as _;

    use crate::run::ERROR;

    let bytes = REFUSED.load(Ordering::Relaxed);
    if bytes == 0 {
        return;
    }
    let mut line = [0; 256];
    let mut rest = &mut line[..];
    let _ = writeln!(
        rest,
        "lobe: out of memory: {bytes} more bytes were asked for, which the system does not give; make memory free, or ask for \
         less: a smaller picture or scene, a lower order, or a lower --max-memory, which refuses before the work"
    );
    let length = 256 - rest.len();
    // SAFETY: the array is there, and has that many bytes.
    unsafe { libc::write(libc::STDERR_FILENO, line.as_ptr().cast(), length) };
    signal_hook::low_level::exit(i32::from(ERROR))
}

/// From now on a file that grows above the limit of the system (`ulimit -f`) makes a write fail, as a full disk does. Without, SIGXFSZ
/// ends the program.
pub(crate) fn let_writes_fail() {
    #[cfg(unix)]
    {
        // A handler that does nothing is enough: the write that it interrupts fails.
        let came = std::sync::Arc::new(AtomicBool::new(false));
        let _ = signal_hook::flag::register(libc::SIGXFSZ, came);
    }
}

/// Called by the loader before `main`, and so before the standard library opens something in the place of stdout.
#[cfg(any(target_os = "linux", target_os = "macos"))]
#[used]
#[cfg_attr(target_os = "linux", unsafe(link_section = ".init_array"))]
#[cfg_attr(target_os = "macos", unsafe(link_section = "__DATA,__mod_init_func"))]
static BEFORE_MAIN: extern "C" fn() = {
    extern "C" fn look() {
        // SAFETY: this asks for the flags of a file that need not be open, and changes nothing.
        let flags = unsafe { libc::fcntl(libc::STDOUT_FILENO, libc::F_GETFD) };
        STDOUT_IS_CLOSED.store(flags == -1, Ordering::Relaxed);
    }
    look
};

/// Refuses, before the work, a stdout on which its result cannot be printed: one that is closed, or on a disk that is full.
///
/// # Errors
/// As [`stdout`]; and if the system has no room for the result.
pub(crate) fn check_stdout() -> io::Result<()> {
    let out = stdout()?;
    #[cfg(target_os = "linux")]
    room_behind(&out)?;
    drop(out);
    Ok(())
}

/// The bytes for which room is asked, more than most results have.
#[cfg(target_os = "linux")]
const RESULT: libc::off_t = 1 << 12;

/// Asks for room behind the end of a file, whose length stays. `/dev/full` has none; other devices and pipes are not asked.
#[cfg(target_os = "linux")]
fn room_behind(out: &io::StdoutLock<'_>) -> io::Result<()> {
    use std::fs::File;
    use std::os::fd::{AsFd as _, AsRawFd as _};
    use std::os::unix::fs::{FileTypeExt as _, MetadataExt as _};

    let file = File::from(out.as_fd().try_clone_to_owned()?);
    let found = file.metadata()?;
    // /dev/full is the character device 1:7.
    let is_full = found.file_type().is_char_device() && found.rdev() == libc::makedev(1, 7);
    let end = libc::off_t::try_from(found.len()).unwrap_or(libc::off_t::MAX - RESULT);
    if is_full {
        return Err(io::Error::from_raw_os_error(libc::ENOSPC));
    }
    if !found.is_file() {
        return Ok(());
    }
    // SAFETY: the file is open, and no memory is handed over.
    let refused = unsafe { libc::fallocate(file.as_raw_fd(), libc::FALLOC_FL_KEEP_SIZE, end, RESULT) } == -1;
    let error = io::Error::last_os_error();
    // Other refusals are those of systems of files that cannot be asked.
    if refused && error.raw_os_error() == Some(libc::ENOSPC) { Err(error) } else { Ok(()) }
}

/// stdout, to print a result on.
///
/// # Errors
/// If it was closed when the program began: what is printed would be lost.
pub(crate) fn stdout() -> io::Result<io::StdoutLock<'static>> {
    if STDOUT_IS_CLOSED.load(Ordering::Relaxed) {
        let message = "it is closed, so the result would be lost; open it, or send it to /dev/null";
        return Err(io::Error::other(message));
    }
    Ok(io::stdout().lock())
}
