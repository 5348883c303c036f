//! Work in processes that were forked.
//!
//! A child of `fork` has one thread. Work that was handed to the threads of its parent, which Lobe's library shares work among, would be waited
//! for for ever: in a child there are threads of its own.

use std::cell::Cell;
use std::mem;
use std::process;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

static IS_FORKED: AtomicBool = AtomicBool::new(false);

/// The process in which the thread that was forked joined threads of its own; 0 in none.
static JOINED_IN: AtomicU32 = AtomicU32::new(0);

thread_local! {
    /// Whether this thread is the one that was forked.
    static IS_FIRST: Cell<bool> = const { Cell::new(false) };
}

/// To be called in every child, which `os.register_at_fork` does.
#[pyfunction]
pub(crate) fn after_fork() {
    IS_FORKED.store(true, Ordering::Relaxed);
    IS_FIRST.set(true);
}

/// Does work where it finds threads.
pub(crate) fn with_threads<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    if !IS_FORKED.load(Ordering::Relaxed) || has_threads() || IS_FIRST.get() && join_threads() {
        return work();
    }
    match threads_of_child() {
        Some(threads) => threads.install(work),
        None => work(),
    }
}

/// Whether this thread belongs to some of this process.
fn has_threads() -> bool {
    let is_of_parent = IS_FIRST.get() && JOINED_IN.load(Ordering::Relaxed) != process::id();
    rayon::current_thread_index().is_some() && !is_of_parent
}

/// Makes this thread one of new ones, for as long as it lives: so work on it stays on it, with what answers Ctrl-C. Where it was one of its
/// parent's already it cannot be.
fn join_threads() -> bool {
    let joined = ThreadPoolBuilder::new().use_current_thread().build().map(mem::forget).is_ok();
    if joined {
        JOINED_IN.store(process::id(), Ordering::Relaxed);
    }
    joined
}

/// The threads of this process, made once; none if the system gives none.
fn threads_of_child() -> Option<Arc<ThreadPool>> {
    static THREADS: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);
    let mut kept = THREADS.lock().unwrap_or_else(PoisonError::into_inner);
    match &*kept {
        Some((of, threads)) if *of == process::id() => return Some(Arc::clone(threads)),
        // A parent's threads are not here, so that it would never end to end them.
        _ => mem::forget(kept.take()),
    }
    let threads = Arc::new(ThreadPoolBuilder::new().build().ok()?);
    *kept = Some((process::id(), Arc::clone(&threads)));
    Some(threads)
}
