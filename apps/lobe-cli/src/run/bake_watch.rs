//! Progress, Ctrl-C and checkpoints of long work.

use std::borrow::Cow;
use std::error::Error;
use std::path::Path;

use anyhow::bail;
use lobe::io::{IoError, Job, JobFiles, Progress};
use lobe::prt::PrtError;
use lobe::render::RenderError;
use lobe::scene::SceneError;
use lobe::shadow::ShadowError;

use crate::run::ctrl_c;
use crate::run::talk::{ProgressLine, Talk};

/// Advice on work that was stopped and has a checkpoint.
pub(crate) const GO_ON: &str = "the same command goes on from there, --fresh starts anew";

/// An error that may say that work was stopped.
pub(crate) trait Cancellable: Error + Send + Sync + 'static {
    fn is_cancelled(&self) -> bool;
}

macro_rules! cancellable {
    ($($error:ty),*) => {$(
        impl Cancellable for $error {
            fn is_cancelled(&self) -> bool {
                matches!(self, Self::Cancelled)
            }
        }
    )*};
}

cancellable!(IoError, SceneError, PrtError, ShadowError, RenderError);

/// Does work, with a line of progress on a terminal, until it is done or the user presses Ctrl-C: then the inner error
/// says how far it was.
pub(crate) fn watched<T, E: Cancellable>(
    talk: Talk,
    what: impl Into<Cow<'static, str>>,
    work: impl FnOnce(Job<'_>) -> Result<T, E>,
) -> anyhow::Result<Result<T, Progress>> {
    ctrl_c::watch();
    let line = talk.progress(what);
    let mut last = None;
    let result = work(Job::default().watched_by(&mut |progress| {
        last = Some(*progress);
        show(&line, progress);
        ctrl_c::go_on()
    }));
    match (result, last) {
        (Err(error), Some(last)) if error.is_cancelled() => Ok(Err(last)),
        (other, _) => Ok(Ok(other?)),
    }
}

/// Notes that an output is complete although the user has pressed Ctrl-C.
pub(crate) fn tell_if_too_late(output: &Path, talk: Talk) {
    if ctrl_c::go_on().is_break() {
        talk.note(&output.display().to_string(), "complete; Ctrl-C came too late to stop it");
    }
}

/// Shows the progress of a bake, or of other work, which traces no rays.
pub(crate) fn show(line: &ProgressLine, progress: &Progress) {
    let text = text_of(progress);
    line.show(progress.done, progress.total, text.as_deref(), progress.seconds_left());
}

/// The pace of work that traces rays; of splitting also how many triangles are measured, and how far transfer is off.
fn text_of(progress: &Progress) -> Option<String> {
    let Progress { total, rays, round, error, .. } = *progress;
    let pace = (rays > 0).then(|| format!("{:.2} Mrays/s", progress.rays_per_second() / 1e6));
    let edges = (round > 0).then(|| format!("round {round}: {total} triangles, off by {:.1} %", 100.0 * error));
    let parts: Vec<String> = edges.into_iter().chain(pace).collect();
    (!parts.is_empty()).then(|| parts.join(", "))
}

/// Bakes, with results kept in these files, until it is done or the user presses Ctrl-C.
pub(crate) fn watched_bake<T, E: Cancellable>(
    files: &JobFiles,
    talk: Talk,
    work: impl FnOnce(Job<'_>) -> Result<T, E>,
) -> anyhow::Result<T> {
    watched_steps(files, talk, "bake", work)?
        .or_else(|at| bail!("stopped after {} of {} points; {GO_ON}", at.done, at.total))
}

/// Bakes something of a name, one of several, until it is done or the user presses Ctrl-C.
pub(crate) fn watched_one<T, E: Cancellable>(
    files: &JobFiles,
    talk: Talk,
    name: &str,
    work: impl FnOnce(Job<'_>) -> Result<T, E>,
) -> anyhow::Result<T> {
    watched_steps(files, talk, format!("bake {name}"), work)?
        .or_else(|at| bail!("stopped at {name}, after {} of {} steps; {GO_ON}", at.done, at.total))
}

/// Works until it is done or the user presses Ctrl-C; then the inner error says how far it was.
fn watched_steps<T, E: Cancellable>(
    files: &JobFiles,
    talk: Talk,
    what: impl Into<Cow<'static, str>>,
    work: impl FnOnce(Job<'_>) -> Result<T, E>,
) -> anyhow::Result<Result<T, Progress>> {
    let mut is_told = false;
    watched(talk, what, |mut shown| {
        let mut watch = |progress: &Progress| {
            if !is_told && progress.resumed > 0 {
                let percent = 100 * progress.resumed / progress.total.max(1);
                talk.note(&files.checkpoint().display().to_string(), &format!("found; going on from {percent} %"));
            }
            is_told = true;
            shown.report(progress)
        };
        work(Job::default().watched_by(&mut watch).kept_in(files.checkpoint()))
    })
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn progress_of_splitting_says_how_far_it_is_from_its_goal() {
        let work = Progress { done: 30, total: 120, elapsed: Duration::from_secs(2), ..Progress::default() };
        assert_eq!(text_of(&work), None, "work without rays");
        let bake = Progress { rays: 3_000_000, ..work };
        assert_eq!(text_of(&bake).as_deref(), Some("1.50 Mrays/s"));
        let splitting = Progress { round: 2, error: 0.0824, ..bake };
        let text = "round 2: 120 triangles, off by 8.2 %, 1.50 Mrays/s";
        assert_eq!(text_of(&splitting).as_deref(), Some(text));
    }
}
