//! Long work: progress to a callable of Python, and Ctrl-C.

use std::error::Error;
use std::io;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;

use lobe::io::{IoError, Job, OptionError, Progress};
use lobe::prt::PrtError;
use lobe::render::RenderError;
use lobe::scene::SceneError;
use lobe::shadow::ShadowError;
use pyo3::exceptions::{PyKeyboardInterrupt, PyOSError, PyRuntimeError};
use pyo3::prelude::*;

use crate::forked::with_threads;
use crate::options::{refusal, told, warn};
use crate::rows::{UNSTOPPED, value_error};

/// An error of the library, which may be that its work was stopped.
pub(crate) trait WorkError: Error + Send + 'static {
    fn is_cancelled(&self) -> bool;
}

impl WorkError for lobe::env::EnvError {
    fn is_cancelled(&self) -> bool {
        matches!(self, Self::Cancelled)
    }
}

impl WorkError for PrtError {
    fn is_cancelled(&self) -> bool {
        matches!(self, Self::Cancelled)
    }
}

impl WorkError for RenderError {
    fn is_cancelled(&self) -> bool {
        matches!(self, Self::Cancelled)
    }
}

impl WorkError for ShadowError {
    fn is_cancelled(&self) -> bool {
        matches!(self, Self::Cancelled)
    }
}

impl WorkError for IoError {
    fn is_cancelled(&self) -> bool {
        matches!(self, Self::Cancelled)
    }
}

/// An error as Python has it: `OSError` where the system refused, else `ValueError`.
pub(crate) fn error_of(error: &(dyn Error + 'static)) -> PyErr {
    if let Some(error) = option_error(error) {
        return refusal(error);
    }
    let mut cause = error.source();
    while let Some(inner) = cause {
        if inner.is::<io::Error>() {
            return PyOSError::new_err(error.to_string());
        }
        cause = inner.source();
    }
    value_error(error)
}

/// The refusal of an option, if an error is one.
fn option_error<'a>(error: &'a (dyn Error + 'static)) -> Option<&'a OptionError> {
    macro_rules! refused_by {
        ($($type:ident),*) => {$(
            if let Some($type::OfJob(error)) = error.downcast_ref() {
                return Some(error);
            }
        )*};
    }
    refused_by!(IoError, SceneError, PrtError, ShadowError, RenderError);
    None
}

/// Numbers that are worked on before anyone waits: to start a thread takes as long as some thousands of them.
const QUICK: usize = 1 << 15;

/// Does work that cannot be stopped without the interpreter's lock, on `size` numbers; all that it needs is its own. Ctrl-C is answered
/// at once: the work goes on to its end by itself, which takes seconds, and what comes of it is dropped.
pub(crate) fn answered<T: Send + 'static>(
    py: Python<'_>,
    size: usize,
    work: impl FnOnce() -> T + Send + 'static,
) -> PyResult<T> {
    if size < QUICK {
        return Ok(py.detach(|| with_threads(work)));
    }
    let (send, mut receive) = mpsc::sync_channel(1);
    thread::spawn(move || send.send(with_threads(work)));
    loop {
        let waited = py.detach(move || {
            let found = receive.recv_timeout(UNSTOPPED);
            (receive, found)
        });
        match waited {
            (_, Ok(done)) => return Ok(done),
            (left, Err(RecvTimeoutError::Timeout)) => {
                py.check_signals()?;
                receive = left;
            }
            (_, Err(RecvTimeoutError::Disconnected)) => {
                return Err(PyRuntimeError::new_err("a fault of lobe, please report it: work ended by a panic"));
            }
        }
    }
}

/// Reads without the interpreter's lock. Ctrl-C is answered at once; what a user should know is a warning.
pub(crate) fn heard<T: Send + 'static, E: WorkError>(
    py: Python<'_>,
    read: impl FnOnce(&mut Job<'_>) -> Result<T, E> + Send + 'static,
) -> PyResult<T> {
    let (found, remarks) = answered(py, usize::MAX, move || {
        let mut remarks = Vec::new();
        let mut listener = |about: &str, text: &str| remarks.push(told(about, text));
        let found = read(&mut Job::default().heard_by(&mut listener));
        (found, remarks)
    })?;
    let found = found.map_err(|error| error_of(&error))?;
    warn(py, &remarks)?;
    Ok(found)
}

/// Does work without the interpreter's lock. `progress(done, total)`, if there is one, is called after each step of it; what it raises
/// stops the work, as Ctrl-C does.
pub(crate) fn watched<T: Send, E: WorkError>(
    py: Python<'_>,
    progress: Option<&Py<PyAny>>,
    checkpoint: Option<&Path>,
    work: impl FnOnce(Job<'_>) -> Result<T, E> + Send,
) -> PyResult<T> {
    let mut remarks = Vec::new();
    watched_work(py, progress, checkpoint, &mut remarks, work)
}

/// [`watched`] work of which a user should know more: what it tells is a warning.
pub(crate) fn watched_and_heard<T: Send, E: WorkError>(
    py: Python<'_>,
    progress: Option<&Py<PyAny>>,
    work: impl FnOnce(Job<'_>) -> Result<T, E> + Send,
) -> PyResult<T> {
    let mut remarks = Vec::new();
    let done = watched_work(py, progress, None, &mut remarks, work)?;
    warn(py, &remarks)?;
    Ok(done)
}

/// [`watched`], with what the work tells.
fn watched_work<T: Send, E: WorkError>(
    py: Python<'_>,
    progress: Option<&Py<PyAny>>,
    checkpoint: Option<&Path>,
    remarks: &mut Vec<String>,
    work: impl FnOnce(Job<'_>) -> Result<T, E> + Send,
) -> PyResult<T> {
    let mut raised = None;
    let watch = |raised: &mut Option<PyErr>, state: &Progress| {
        let told = Python::attach(|py| {
            py.check_signals()?;
            progress.map_or(Ok(()), |call| call.call1(py, (state.done, state.total)).map(drop))
        });
        match told {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => {
                *raised = Some(error);
                ControlFlow::Break(())
            }
        }
    };
    let done = py.detach(|| {
        with_threads(|| {
            let mut watch = |state: &Progress| watch(&mut raised, state);
            let mut listener = |about: &str, text: &str| remarks.push(told(about, text));
            let job = Job::default().watched_by(&mut watch).heard_by(&mut listener);
            work(match checkpoint {
                Some(path) => job.kept_in(path),
                None => job,
            })
        })
    });
    match (done, raised) {
        // Even where all was done already: what was raised is for the caller.
        (Ok(_), Some(error)) => Err(error),
        (Ok(done), None) => Ok(done),
        (Err(error), raised) if error.is_cancelled() => Err(raised.unwrap_or_else(|| PyKeyboardInterrupt::new_err(()))),
        (Err(error), _) => Err(error_of(&error)),
    }
}
