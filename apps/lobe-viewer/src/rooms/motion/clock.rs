//! The time of an animation, which plays around and around or stands still.

use eframe::egui::{Context, Slider, SliderClamping, Ui};

/// The longest step of time between two frames, in seconds: after a rest the animation goes on where it was.
const MOST_STEP: f64 = 0.1;

/// The shortest time that an animation takes to come around, in seconds: one of a single moment stands still.
const LEAST_SPAN: f64 = 1e-3;

/// A clock that plays at first.
pub(crate) struct Clock {
    pub(crate) is_playing: bool,
    /// Seconds.
    pub(crate) time: f64,
}

impl Default for Clock {
    fn default() -> Self {
        Self { is_playing: true, time: 0.0 }
    }
}

impl Clock {
    /// Stops at a time.
    pub(crate) fn pause_at(&mut self, time: f64) {
        (self.is_playing, self.time) = (false, time);
    }

    /// Plays, or stops.
    pub(crate) fn toggle(&mut self) {
        self.is_playing = !self.is_playing;
    }

    /// Brings the time into that of another animation.
    pub(crate) fn keep_within(&mut self, [begin, end]: [f64; 2]) {
        self.time = self.time.clamp(begin, end);
    }

    /// Lets the time of a frame pass, from the end to the begin again.
    pub(crate) fn advance(&mut self, ctx: &Context, [begin, end]: [f64; 2]) {
        if self.is_playing {
            self.time = begin + (self.time + passed(ctx) - begin).rem_euclid((end - begin).max(LEAST_SPAN));
            ctx.request_repaint();
        }
    }

    /// Whether it plays, and the time, to be changed.
    pub(crate) fn controls(&mut self, ui: &mut Ui, [begin, end]: [f64; 2]) {
        ui.checkbox(&mut self.is_playing, "Play");
        let slider = Slider::new(&mut self.time, begin..=end).text("Time").suffix(" s").fixed_decimals(2);
        // A frame takes less than the slider rounds to.
        ui.add(slider.clamping(SliderClamping::Edits));
    }
}

/// Seconds since the last frame.
pub(crate) fn passed(ctx: &Context) -> f64 {
    ctx.input(|input| f64::from(input.stable_dt)).min(MOST_STEP)
}
