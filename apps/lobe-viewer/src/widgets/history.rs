//! Changes that can be taken back and made again.

use std::time::Duration;

use eframe::egui::Context;
use eframe::egui::util::undoer::Undoer;

/// A change counts as made after it has rested for so long, as [`Undoer`] has it.
const REST: Duration = Duration::from_millis(1100);

/// What a user changed in a room, moment by moment.
#[derive(Debug)]
pub(crate) struct History<T>(Undoer<T>);

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

    /// Takes the last change back.
    pub(crate) fn undo(&mut self, now: &mut T) {
        if let Some(before) = self.0.undo(now) {
            *now = before.clone();
        }
    }

    /// Makes a change again that was taken back.
    pub(crate) fn redo(&mut self, now: &mut T) {
        if let Some(after) = self.0.redo(now) {
            *now = after.clone();
        }
    }

    pub(crate) fn can(&self, now: &T) -> Can {
        Can { undo: self.0.has_undo(now), redo: self.0.has_redo(now) }
    }
}
