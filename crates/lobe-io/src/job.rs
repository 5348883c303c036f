//! Watching, stopping and continuing long work.

use std::fmt;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// How far a piece of long work is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Progress {
    /// What is done, one of several pieces of work that follow each other, such as `bake`; empty where there is but one.
    pub step: &'static str,
    /// Steps that are done: receivers, points or pixels, as the function that works says.
    pub done: usize,
    /// Steps in all. Work that ends before it has taken all of them reports `done` equal to `total` when it ends.
    pub total: usize,
    /// Steps that an earlier run had done, see [`Job::kept_in`].
    pub resumed: usize,
    /// Rays traced since the start of this run; 0 for work that traces none.
    pub rays: u64,
    /// Time since the start of this run.
    pub elapsed: Duration,
    /// The round that the other numbers are about, from 0. Only [work in rounds](Job::kept_in) has more than one.
    pub round: usize,
    /// How far what there is may be off when the round begins, in the unit of the goal. Only of work in rounds that go on until it is reached; else 0.
    pub error: f64,
    /// Whether `total` is only a bound, as the work ends where going on gains little: then nobody knows the time that is left.
    pub is_bound: bool,
}

impl Progress {
    /// The mean pace of this run.
    #[must_use]
    pub fn rays_per_second(&self) -> f64 {
        self.rays as f64 / self.elapsed.as_secs_f64().max(1e-9)
    }

    /// The time the rest will take at the mean pace of this run. None before anything is done, and where the total is a bound.
    #[must_use]
    pub fn seconds_left(&self) -> Option<f64> {
        let done = self.done - self.resumed;
        (done > 0 && !self.is_bound).then(|| self.elapsed.as_secs_f64() / done as f64 * (self.total - self.done) as f64)
    }
}

/// A function that watches work: it is called a few times a second, and always at the start and at the end, and says
/// whether to go on.
pub type Watch<'a> = &'a mut dyn FnMut(&Progress) -> ControlFlow<()>;

/// A function that is told what a user should know, in one line, and what that is about: a file, or a scene's name.
/// Options are named in backquotes.
pub type Listener<'a> = &'a mut dyn FnMut(&str, &str);

/// How a piece of long work is run: who watches it, and where it keeps its results so that it can be continued.
///
/// By default nobody watches it, and it keeps nothing. Work that is told to stop returns the error `Cancelled` of its crate.
///
/// ```
/// use std::ops::ControlFlow;
/// use lobe_io::{Job, Progress};
///
/// fn long_work(mut job: Job<'_>) -> Option<usize> {
///     for done in 0..=10 {
///         if job.report(&Progress { done, total: 10, ..Progress::default() }).is_break() {
///             return None;
///         }
///     }
///     Some(10)
/// }
///
/// assert_eq!(long_work(Job::default()), Some(10));
/// let mut last = 0;
/// let mut watch = |progress: &Progress| {
///     last = progress.done;
///     if last < 5 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
/// };
/// assert_eq!(long_work(Job::default().watched_by(&mut watch)), None);
/// assert_eq!(last, 5);
/// ```
#[derive(Default)]
pub struct Job<'a> {
    watch: Option<Watch<'a>>,
    checkpoint: Option<PathBuf>,
    listener: Option<Listener<'a>>,
    step: &'static str,
}

impl<'a> Job<'a> {
    /// Calls `watch` with the progress of the work, which is stopped where it returns [`ControlFlow::Break`].
    #[must_use]
    pub fn watched_by(mut self, watch: Watch<'a>) -> Self {
        self.watch = Some(watch);
        self
    }

    /// Keeps results in the file `path` while they are found, and takes up those that are there already: work that was
    /// stopped, or killed at any moment, continues where it was and ends with the same bytes.
    ///
    /// Results reach the disk within 10 seconds. The file is locked while the work runs and refused by work with other
    /// arguments. It remains when the work is done; remove it when the results are safe. Work in rounds that build on
    /// each other keeps each of them in a file of its own, whose name is `path` and a suffix.
    ///
    /// Functions that cannot resume refuse a path as an option that cannot be.
    #[must_use]
    pub fn kept_in(mut self, path: impl Into<PathBuf>) -> Self {
        self.checkpoint = Some(path.into());
        self
    }

    /// Tells `listener` what a user should know of the work.
    #[must_use]
    pub fn heard_by(mut self, listener: Listener<'a>) -> Self {
        self.listener = Some(listener);
        self
    }

    /// The same job for a part of the work, by which it is watched, heard and kept as before.
    pub fn reborrow(&mut self) -> Job<'_> {
        let Self { watch, checkpoint, listener, step } = self;
        let watch = watch.as_mut().map(|watch| &mut **watch as Watch<'_>);
        let listener = listener.as_mut().map(|listener| &mut **listener as Listener<'_>);
        Job { watch, checkpoint: checkpoint.clone(), listener, step }
    }

    /// The same job for a piece of the work with a [name](Progress::step), of which nothing is kept.
    pub fn step(&mut self, step: &'static str) -> Job<'_> {
        Job { step, checkpoint: None, ..self.reborrow() }
    }

    /// Says what a user should know of a file or a scene. To be called by the work.
    pub fn note(&mut self, about: &str, text: &str) {
        if let Some(listener) = &mut self.listener {
            listener(about, text);
        }
    }

    /// The file that results are kept in, if any.
    #[must_use]
    pub fn checkpoint(&self) -> Option<&Path> {
        self.checkpoint.as_deref()
    }

    /// Tells whoever watches how far the work is, and returns whether to go on. To be called by the work.
    pub fn report(&mut self, progress: &Progress) -> ControlFlow<()> {
        match &mut self.watch {
            Some(watch) if self.step.is_empty() => watch(progress),
            Some(watch) => watch(&Progress { step: self.step, ..*progress }),
            None => ControlFlow::Continue(()),
        }
    }

    /// Refuses a checkpoint, for work that cannot resume. To be called by the work before it begins.
    ///
    /// # Errors
    /// The message of the refusal, if a file was given.
    pub fn expect_no_checkpoint(&self) -> Result<(), String> {
        match &self.checkpoint {
            None => Ok(()),
            Some(path) => {
                Err(format!("expected no checkpoint for work that cannot be resumed, found {}", path.display()))
            }
        }
    }
}

impl fmt::Debug for Job<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { watch, checkpoint, listener, step } = self;
        f.debug_struct("Job")
            .field("is_watched", &watch.is_some())
            .field("is_heard", &listener.is_some())
            .field("checkpoint", checkpoint)
            .field("step", step)
            .finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_that_nobody_watches_goes_on() {
        let mut job = Job::default();
        assert!(job.report(&Progress::default()).is_continue(), "{job:?}");
    }

    #[test]
    fn a_step_of_work_says_its_name_and_is_heard() {
        let (mut steps, mut heard) = (Vec::new(), Vec::new());
        let mut watch = |progress: &Progress| {
            steps.push(progress.step);
            ControlFlow::Continue(())
        };
        let mut listener = |about: &str, text: &str| heard.push(format!("{about}: {text}"));
        let mut job = Job::default().watched_by(&mut watch).heard_by(&mut listener).kept_in("file");
        assert!(job.report(&Progress::default()).is_continue());
        let mut part = job.step("bake");
        assert_eq!(part.checkpoint(), None, "nothing is kept of a step");
        assert!(part.reborrow().report(&Progress::default()).is_continue());
        part.note("a.glb", "is empty");
        assert_eq!(steps, ["", "bake"]);
        assert_eq!(heard, ["a.glb: is empty"]);
    }

    #[test]
    fn work_that_cannot_resume_refuses_a_checkpoint() {
        assert_eq!(Job::default().expect_no_checkpoint(), Ok(()), "no file");
        let refused = Job::default().kept_in("a.checkpoint").expect_no_checkpoint().unwrap_err();
        assert!(refused.ends_with("cannot be resumed, found a.checkpoint"), "{refused}");
    }

    #[test]
    fn pace_and_rest_count_this_run_only() {
        let elapsed = Duration::from_secs(4);
        let progress = Progress { done: 30, total: 50, resumed: 10, rays: 800, elapsed, ..Progress::default() };
        assert_eq!(progress.seconds_left(), Some(4.0), "20 done in 4 s, 20 left");
        assert_eq!(progress.rays_per_second(), 200.0, "800 rays in 4 s");
        assert_eq!(Progress { done: 10, ..progress }.seconds_left(), None, "nothing is done yet");
        assert_eq!(Progress { is_bound: true, ..progress }.seconds_left(), None, "it may end before the total");
    }
}
