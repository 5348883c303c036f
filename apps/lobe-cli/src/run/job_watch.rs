//! Work in several steps: a line of progress for each, Ctrl-C, and what it tells.

use std::path::Path;

use anyhow::bail;
use lobe::io::{Job, Progress};

use crate::run::bake_watch::{Cancellable, GO_ON, show};
use crate::run::ctrl_c;
use crate::run::option_names::in_flags;
use crate::run::talk::{ProgressLine, Talk};

/// Where the results of a job are while it runs.
#[derive(Clone, Copy)]
pub(crate) enum Kept<'a> {
    /// In this file. The user hears of what was found in it.
    In(&'a Path),
    /// In files that the same command has made, of which the user knows nothing.
    Untold,
    /// Nowhere.
    Nowhere,
}

/// The steps of a job, as far as they are known.
struct Steps<'a> {
    talk: Talk,
    /// The file that results are kept in, if the user hears of what was found in it.
    kept: Option<&'a Path>,
    line: Option<ProgressLine>,
    last: Progress,
    is_resumed: bool,
    is_told: bool,
}

impl Steps<'_> {
    fn show(&mut self, progress: &Progress) {
        if self.line.is_none() || self.last.step != progress.step {
            (self.is_resumed, self.is_told) = (false, self.kept.is_none());
            self.line = Some(self.talk.progress(progress.step));
        }
        self.last = *progress;
        self.is_resumed |= progress.resumed > 0;
        // Rounds of splitting that are done are taken up in no time.
        if !self.is_told && (progress.step != "split" || progress.resumed < progress.total) {
            self.is_told = true;
            if let Some(kept) = self.kept.filter(|_| self.is_resumed) {
                let (subject, text) = resumption(kept, progress);
                self.talk.note(&subject, &text);
            }
        }
        if let Some(line) = &self.line {
            show(line, progress);
        }
    }
}

/// What is said of work that was taken up from a file, and of what.
fn resumption(kept: &Path, progress: &Progress) -> (String, String) {
    let percent = 100 * progress.resumed / progress.total.max(1);
    let place = match progress.step {
        "split" => format!(" of round {} of splitting", progress.round),
        _ => String::new(),
    };
    let ending = match progress.step {
        "bake backs" => ".backs",
        "bake direct" => ".direct",
        _ => "",
    };
    (format!("{}{ending}", kept.display()), format!("found; going on from {percent} %{place}"))
}

/// Does work with a line of progress for each step, until it is done or the user presses Ctrl-C.
pub(crate) fn watched_job<T, E: Cancellable>(
    talk: Talk,
    kept: Kept<'_>,
    work: impl FnOnce(Job<'_>) -> Result<T, E>,
) -> anyhow::Result<T> {
    ctrl_c::watch();
    let told = if let Kept::In(path) = kept { Some(path) } else { None };
    let mut steps =
        Steps { talk, kept: told, line: None, last: Progress::default(), is_resumed: false, is_told: false };
    let mut watch = |progress: &Progress| {
        steps.show(progress);
        ctrl_c::go_on()
    };
    let mut listener = |about: &str, text: &str| talk.note(about, &in_flags(text));
    match work(Job::default().watched_by(&mut watch).heard_by(&mut listener)) {
        Err(error) if error.is_cancelled() => stopped(&steps.last, kept),
        other => Ok(other?),
    }
}

/// Does work in no time that one could watch, and tells what a user should know of it.
pub(crate) fn heard<T, E>(talk: Talk, work: impl FnOnce(&mut Job<'_>) -> Result<T, E>) -> Result<T, E> {
    let mut listener = |about: &str, text: &str| talk.note(about, &in_flags(text));
    work(&mut Job::default().heard_by(&mut listener))
}

/// Advice where a bake on the way to a picture takes long.
const BAKE_FIRST: &str = "lobe bake can be stopped and continued, and what it writes can be rendered";

/// The error of work that was stopped.
fn stopped<T>(last: &Progress, kept: Kept<'_>) -> anyhow::Result<T> {
    let Progress { step, done, total, round, .. } = *last;
    match step {
        "fit" if matches!(kept, Kept::Nowhere) => {
            bail!("stopped; nothing is written, and the same command starts anew")
        }
        "look" => bail!("stopped before the first picture; nothing is kept"),
        "split" | "bake" if matches!(kept, Kept::Nowhere) => {
            let what = if step == "split" { "triangles were split" } else { "transfer was baked" };
            bail!("stopped while {what}, of which nothing is kept; {BAKE_FIRST}")
        }
        "split" => bail!("stopped in round {round} of splitting after {done} of {total} points; {GO_ON}"),
        "fit" => bail!("stopped after {done} of up to {total} rounds; {GO_ON}"),
        "unwrap" => bail!("stopped while the scene was unwrapped"),
        "merge" => bail!("stopped after {done} of {total} records, of which nothing is kept"),
        "compress" | "write" => bail!("stopped after the bake, before its output was written; {GO_ON}"),
        _ => bail!("stopped after {done} of {total} points; {GO_ON}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(step: &'static str) -> Progress {
        Progress { step, done: 30, total: 120, resumed: 30, round: 2, ..Progress::default() }
    }

    #[test]
    fn work_that_stops_says_what_is_kept() {
        let kept = Kept::In("out.checkpoint".as_ref());
        for (step, kept, said) in [
            ("split", kept, "stopped in round 2 of splitting after 30 of 120 points; the same command goes on"),
            ("unwrap", kept, "stopped while the scene was unwrapped"),
            ("bake", kept, "stopped after 30 of 120 points; the same command goes on"),
            ("fit", kept, "stopped after 30 of up to 120 rounds; the same command goes on"),
            ("merge", kept, "stopped after 30 of 120 records, of which nothing is kept"),
            ("compress", kept, "stopped after the bake, before its output was written; the same command goes on"),
            ("write", kept, "stopped after the bake, before its output was written; the same command goes on"),
            ("split", Kept::Nowhere, "stopped while triangles were split, of which nothing is kept; lobe bake can"),
            ("bake", Kept::Nowhere, "stopped while transfer was baked, of which nothing is kept; lobe bake can"),
            ("fit", Kept::Nowhere, "stopped; nothing is written, and the same command starts anew"),
            ("look", Kept::Nowhere, "stopped before the first picture; nothing is kept"),
        ] {
            let line = stopped::<()>(&at(step), kept).unwrap_err().to_string();
            assert!(line.starts_with(said), "{step}: {line}");
        }
    }

    #[test]
    fn work_that_goes_on_says_from_where() {
        for (step, subject, said) in [
            ("split", "out.checkpoint", "found; going on from 25 % of round 2 of splitting"),
            ("bake", "out.checkpoint", "found; going on from 25 %"),
            ("bake backs", "out.checkpoint.backs", "found; going on from 25 %"),
        ] {
            let found = resumption("out.checkpoint".as_ref(), &at(step));
            assert_eq!(found, (subject.to_owned(), said.to_owned()), "{step}");
        }
    }
}
