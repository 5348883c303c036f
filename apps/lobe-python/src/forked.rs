//! Work in processes that were forked.
//!
//! A child of `fork` has one thread. Work that was handed to the threads of its parent, which Lobe's library shares work among, would be waited
//! for for ever: in a child there are threads of its own.

use std::mem;
use std::process;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

static IS_FORKED: AtomicBool = AtomicBool::new(false);

/// To be called in every child, which `os.register_at_fork` does.
#[pyfunction]
pub(crate) fn after_fork() {
    IS_FORKED.store(true, Ordering::Relaxed);
}

/// Does work where it finds threads.
pub(crate) fn with_threads<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    if !IS_FORKED.load(Ordering::Relaxed) {
        return work();
    }
    match threads_of_child() {
        Some(threads) => threads.install(work),
        None => work(),
    }
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
