//! Changes that can be taken back and made again.

use std::time::Duration;

use eframe::egui::Context;
use eframe::egui::util::undoer::Undoer;

/// A change counts as made after it has rested for so long, as [`Undoer`] has it.
const REST: Duration = Duration::from_millis(1100);

/// What a user changed in a room, moment by moment.
#[derive(Debug)]
pub(crate) struct History<T>(Undoer<T>);

/// A step through changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Back, before the last one.
    Undo,
    /// Forward, to one that was taken back.
    Redo,
}

/// What can be done with changes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Can {
    pub(crate) undo: bool,
    pub(crate) redo: bool,
}

impl<T: Clone + PartialEq> Default for History<T> {
    fn default() -> Self {
        Self(Undoer::default())
    }
}

impl<T: Clone + PartialEq> History<T> {
    /// Looks at what there is now. Called for each frame.
    pub(crate) fn watch(&mut self, ctx: &Context, now: &T) {
        self.0.feed_state(ctx.input(|input| input.time), now);
        if self.0.is_in_flux() {
            ctx.request_repaint_after(REST);
        }
    }

    /// Takes the last change back, or makes it again; without one nothing happens.
    pub(crate) fn step(&mut self, step: Step, now: &mut T) {
        let other = match step {
            Step::Undo => self.0.undo(now),
            Step::Redo => self.0.redo(now),
        };
        if let Some(other) = other.cloned() {
            *now = other;
        }
    }

    pub(crate) fn can(&self, now: &T) -> Can {
        Can { undo: self.0.has_undo(now), redo: self.0.has_redo(now) }
    }
}
