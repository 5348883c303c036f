//! Changes of the scene: one is started, fails or is stopped, and the one before comes back.

use eframe::egui::Context;

use crate::rooms::motion::before::Before;
use crate::rooms::motion::cast::Cast;
use crate::rooms::motion::edits::MotionEdits;
use crate::rooms::motion::motion_room::MotionRoom;
use crate::rooms::motion::player::{Player, Source};
use crate::widgets::orbit::Orbit;

impl MotionRoom {
    /// Takes the parts of the scene, of which the first that moves is chosen.
    pub(super) fn take_cast(&mut self, cast: Cast) {
        self.clock.keep_within(cast.span);
        self.chosen = cast.is_still.iter().position(|still| !still).unwrap_or(0);
        self.cast = Some(cast);
    }

    /// Says what went wrong. Where nothing was lit of the scene, the one before is there again.
    pub(super) fn fail(&mut self, message: String) {
        (self.is_waiting, self.is_stopped) = (false, true);
        if self.lit.is_none() && !self.go_back() && self.cast.is_none() {
            // A file that was kept may have gone: before any other was open, that is the first one of the program.
            self.change_to(&MotionEdits::default().source);
        }
        self.message = Some(message);
    }

    /// Says that the work was cancelled.
    pub(super) fn stop(&mut self) {
        (self.is_waiting, self.is_stopped) = (false, true);
        let message = if self.go_back() && !self.is_stopped {
            "Stopped before the scene was baked; the one before is shown again."
        } else {
            "Stopped before the scene was baked. Bake begins again."
        };
        self.message = Some(message.into());
    }

    /// Shows the scene again that was left, as it was. Whether there is one.
    fn go_back(&mut self) -> bool {
        let Some(before) = self.before.take() else { return false };
        let Source { path, files, .. } = &before.source;
        (self.edits.source, self.edits.files) = (path.clone(), files.clone());
        (self.edits.hands, self.edits.is_by_hand) = (before.in_hand.hands.clone(), before.in_hand.is_by_hand);
        self.put_back(before);
        true
    }

    /// Puts back all of a scene that was left but what the edits say of it. Without its player it is opened again.
    pub(super) fn put_back(&mut self, before: Before) {
        (self.wants_frame, self.orbit) = (before.lit.is_none(), before.orbit);
        (self.is_stopped, self.forgets_history) = (before.is_stopped, false);
        self.panes.clear();
        let Some(player) = before.player else {
            (self.player, self.cast, self.asked, self.lit, self.is_waiting) = (None, None, None, None, false);
            return;
        };
        (self.player, self.is_waiting) = (Some((before.source, player)), before.is_waiting);
        (self.asked, self.lit) = (before.asked, before.lit);
        self.take_cast(before.cast);
        self.chosen = before.in_hand.chosen;
    }

    /// Starts on the scene of the edits, which nothing of the one before belongs to. That is kept as it is, at rest, should this one fail.
    pub(super) fn start(&mut self, ctx: &Context, source: Source) {
        let ctx = ctx.clone();
        // Also where a change of the scene was taken back.
        self.wants_frame |= self.player.as_ref().is_some_and(|(before, _)| before.path != source.path);
        let player = Player::start(&source, self.edits.order, self.device.clone(), move || ctx.request_repaint());
        let left = self.player.replace((source, player));
        let (cast, asked, lit) = (self.cast.take(), self.asked.take(), self.lit.take());
        // A scene of which nothing is lit takes no place of one that is.
        if let (Some((source, player)), Some(cast)) = (left, cast)
            && (lit.is_some() || self.before.as_ref().is_none_or(|before| before.lit.is_none()))
        {
            let (player, in_hand) = (Some(player), std::mem::take(&mut self.in_hand));
            let (orbit, is_waiting, is_stopped) = (self.orbit, self.is_waiting, self.is_stopped);
            let before = Before { source, player, cast, in_hand, asked, lit, orbit, is_waiting, is_stopped };
            self.before = Some(before.at_rest());
        }
        (self.is_waiting, self.is_stopped, self.wants_start) = (false, false, false);
        if self.wants_frame {
            self.orbit = Orbit::default();
        }
        self.panes.clear();
    }
}
