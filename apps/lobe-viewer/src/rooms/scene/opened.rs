//! The file that a room has open, which stays when opening another one fails.

use std::path::PathBuf;

use crate::loading::task::TaskEvent;

/// What was opened, and from where.
pub(crate) struct Opened<T> {
    /// What is open, or being opened.
    pub(crate) source: PathBuf,
    /// The last source that was no failure.
    pub(crate) good: PathBuf,
    pub(crate) found: Option<T>,
}

impl<T> Default for Opened<T> {
    fn default() -> Self {
        Self { source: PathBuf::new(), good: PathBuf::new(), found: None }
    }
}

/// After a failure the source is again the one that is shown; where nothing is, the first one is opened, and it says so.
pub(crate) fn take_back<A, B>(ended: &TaskEvent<A>, edited: &mut PathBuf, opened: &mut Opened<B>, first: &str) -> bool {
    if !matches!(ended, TaskEvent::Failed(_) | TaskEvent::Cancelled) || *edited != opened.source {
        return false;
    }
    let is_shown = !opened.good.as_os_str().is_empty();
    if is_shown {
        edited.clone_from(&opened.good);
        opened.source.clone_from(&opened.good);
    } else {
        *edited = first.into();
    }
    !is_shown
}

/// What an end has to say.
pub(crate) fn failure<T>(ended: TaskEvent<T>) -> Option<String> {
    match ended {
        TaskEvent::Failed(message) => Some(message),
        TaskEvent::Cancelled => Some("Cancelled; what is there already remains.".into()),
        TaskEvent::Result(_) | TaskEvent::Done => None,
    }
}
