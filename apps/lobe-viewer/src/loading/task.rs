//! Work beside the window.

use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

use lobe::io::Progress;

use crate::loading::place::IN_PAGE;

/// Work on a thread of its own, in a page before anything else, that sends results, can be watched, and stops when it is told to or forgotten.
///
/// ```
/// use lobe_viewer::{Task, TaskEvent};
///
/// let task = Task::start("count", || (), |control| {
///     (0..3).for_each(|i| control.send(i));
///     Err("no more fingers".into())
/// });
/// let mut events = Vec::new();
/// while !matches!(events.last(), Some(TaskEvent::Failed(_))) {
///     events.extend(task.events());
/// }
/// assert_eq!(events[..3], [TaskEvent::Result(0), TaskEvent::Result(1), TaskEvent::Result(2)]);
/// assert_eq!(events[3], TaskEvent::Failed("no more fingers".into()));
/// ```
#[derive(Debug)]
pub struct Task<T> {
    title: String,
    shared: Arc<Shared>,
    events: Receiver<TaskEvent<T>>,
}

/// What a task has to say.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum TaskEvent<T> {
    /// A result; there may be more.
    Result(T),
    /// It ended, with all results.
    Done,
    /// It ended because it was [cancelled](Task::cancel).
    Cancelled,
    /// It ended with an error, in one line.
    Failed(String),
}

#[derive(Debug, Default)]
struct Shared {
    is_cancelled: AtomicBool,
    state: Mutex<State>,
    is_released: Mutex<bool>,
    /// When it was released or cancelled.
    released: Condvar,
}

#[derive(Clone, Debug, Default, PartialEq)]
enum State {
    /// Not begun, or waiting for something to do.
    #[default]
    Resting,
    /// The stage of the work, and the part of it that is done, where that is known.
    Working(String, Option<f32>),
}

/// What work has in its hands: whom to tell, and whether to go on.
pub struct Control<T> {
    shared: Arc<Shared>,
    events: Sender<TaskEvent<T>>,
    wake: Box<dyn Fn() + Send>,
}

impl<T: Send + 'static> Task<T> {
    /// Starts work under a title, such as `bake`. `wake` is called when there is something new to show.
    pub fn start(
        title: impl Into<String>,
        wake: impl Fn() + Send + 'static,
        work: impl FnOnce(&Control<T>) -> Result<(), String> + Send + 'static,
    ) -> Self {
        let (sender, events) = channel();
        let shared = Arc::<Shared>::default();
        let unstarted = sender.clone();
        let control = Control { shared: shared.clone(), events: sender, wake: Box::new(wake) };
        let run = move || {
            // What decoders do to damaged files is no reason to lose the window.
            let ended = catch_unwind(AssertUnwindSafe(|| work(&control)));
            let is_cancelled = control.is_cancelled();
            if is_cancelled {
                // A stage that failed is told; one that was cancelled is none.
                control.rest();
            }
            control.tell(match ended {
                Ok(_) if is_cancelled => TaskEvent::Cancelled,
                Ok(Ok(())) => TaskEvent::Done,
                Ok(Err(message)) => TaskEvent::Failed(message),
                Err(_) => TaskEvent::Failed("a fault of this program, please report it with what you opened".into()),
            });
        };
        let title = title.into();
        if IN_PAGE {
            run();
        } else if let Err(error) = thread::Builder::new().name(title.clone()).spawn(run) {
            // The receiver is here.
            drop(unstarted.send(TaskEvent::Failed(format!("the system starts no thread: {error}"))));
        }
        Self { title, shared, events }
    }

    /// What came since this was asked last.
    #[must_use]
    pub fn events(&self) -> Vec<TaskEvent<T>> {
        self.events.try_iter().collect()
    }
}

impl<T> Task<T> {
    /// Waits until the work has ended, and hands out what came since it was asked last.
    #[must_use]
    pub fn finish(&self) -> Vec<TaskEvent<T>> {
        self.events.iter().collect()
    }

    /// The title and the stage of the work, for people.
    #[must_use]
    pub fn describe(&self) -> String {
        match &*locked(&self.shared.state) {
            State::Resting => self.title.clone(),
            State::Working(stage, _) => format!("{}: {stage}", self.title),
        }
    }

    /// Whether a stage of the work is under way.
    #[must_use]
    pub fn is_at_work(&self) -> bool {
        *locked(&self.shared.state) != State::Resting
    }

    /// The part that is done, 0 to 1, where the work says it.
    #[must_use]
    pub fn progress(&self) -> Option<f32> {
        match *locked(&self.shared.state) {
            State::Resting => None,
            State::Working(_, part) => part,
        }
    }

    /// Tells the work to stop, which it does at its next report.
    pub fn cancel(&self) {
        self.shared.is_cancelled.store(true, Ordering::Relaxed);
        self.release();
    }

    /// Lets work go on that [waits](Control::wait) for it, now or later.
    pub fn release(&self) {
        *locked(&self.shared.is_released) = true;
        self.shared.released.notify_all();
    }
}

impl<T> Drop for Task<T> {
    fn drop(&mut self) {
        self.cancel();
    }
}

impl<T> Control<T> {
    /// Hands out a result.
    pub fn send(&self, result: T) {
        self.tell(TaskEvent::Result(result));
    }

    /// Names what is being done, and forgets how far it was.
    pub fn stage(&self, stage: impl Into<String>) {
        self.enter(State::Working(stage.into(), None));
    }

    /// Waits until the task is [released](Task::release), or nobody waits for its results any more, or `most` has passed, as where a
    /// window is hidden and draws nothing. In a page it does not wait: nothing else is done there meanwhile.
    pub fn wait(&self, most: Duration) {
        if !IN_PAGE {
            let is_held = |is_released: &mut bool| !*is_released;
            drop(self.shared.released.wait_timeout_while(locked(&self.shared.is_released), most, is_held));
        }
    }

    /// Says that it waits for something to do.
    pub fn rest(&self) {
        self.enter(State::Resting);
    }

    fn enter(&self, state: State) {
        let is_new = {
            let mut current = locked(&self.shared.state);
            let is_new = *current != state;
            *current = state;
            is_new
        };
        if is_new {
            (self.wake)();
        }
    }

    /// Whether nobody waits for the results any more.
    #[must_use]
    pub fn is_cancelled(&self) -> bool {
        self.shared.is_cancelled.load(Ordering::Relaxed)
    }

    /// A watch for a [`Job`](lobe::io::Job).
    pub fn watch(&self) -> impl FnMut(&Progress) -> ControlFlow<()> + '_ {
        |progress| {
            let part = progress.done as f32 / progress.total.max(1) as f32;
            if let State::Working(_, done) = &mut *locked(&self.shared.state) {
                *done = Some(part);
            }
            (self.wake)();
            if self.is_cancelled() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        }
    }

    fn tell(&self, event: TaskEvent<T>) {
        // Of a task that was dropped nobody reads.
        drop(self.events.send(event));
        (self.wake)();
    }
}

impl<T> std::fmt::Debug for Control<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Control").field("shared", &self.shared).finish_non_exhaustive()
    }
}

/// What a mutex holds, also after a thread panicked with it.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
