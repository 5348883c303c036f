//! The time that pictures of the processor take in a frame, so that a window of many remains alive.

use eframe::egui::{Context, Id};

/// Milliseconds after which the other pictures of a frame wait for the next one: of a thirtieth of a second something is left for
/// the window itself.
const MOST: f64 = 25.0;

/// What was drawn in a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Drawn {
    frame: u64,
    pub(crate) pictures: usize,
    pub(crate) milliseconds: f64,
}

/// What was drawn in this frame so far.
pub(crate) fn drawn(ctx: &Context) -> Drawn {
    let frame = ctx.cumulative_frame_nr();
    let kept: Drawn = ctx.data(|data| data.get_temp(id())).unwrap_or_default();
    if kept.frame == frame { kept } else { Drawn { frame, ..Drawn::default() } }
}

/// Whether there is time for another picture in this frame.
pub(crate) fn has_time(ctx: &Context) -> bool {
    drawn(ctx).milliseconds < MOST
}

/// Notes a picture.
pub(crate) fn note(ctx: &Context, milliseconds: f64) {
    let before = drawn(ctx);
    let after = Drawn { pictures: before.pictures + 1, milliseconds: before.milliseconds + milliseconds, ..before };
    ctx.data_mut(|data| data.insert_temp(id(), after));
}

fn id() -> Id {
    Id::unique("pictures of the processor")
}
