//! The status line: frame times and sizes.

use std::collections::VecDeque;
use std::fmt;

use eframe::egui::{Context, Label, Ui};
use web_time::{Duration, Instant};

use crate::widgets::drawing_time::drawn;

/// The time over which frames are counted.
const SPAN: Duration = Duration::from_secs(1);

/// What the line below the picture says.
#[derive(Clone, Debug, Default)]
pub(crate) struct Status {
    drawn: VecDeque<Instant>,
    /// Milliseconds on the processor of the last frame.
    pub(crate) cpu: f64,
    /// Milliseconds on the device, where it measures times.
    pub(crate) gpu: Option<f64>,
    pub(crate) vertices: usize,
    pub(crate) triangles: usize,
    pub(crate) draw_calls: usize,
    /// Bytes on the device.
    pub(crate) bytes: u64,
    /// Columns and rows of the picture.
    pub(crate) size: [u32; 2],
    /// What the device leaves out of the picture.
    pub(crate) left_out: Option<&'static str>,
    /// Pictures that the processor drew last, where it draws all of them.
    pub(crate) by_processor: Option<usize>,
}

impl Status {
    /// Counts a frame.
    pub(crate) fn drew(&mut self, now: Instant) {
        self.drawn.push_back(now);
        while self.drawn.front().is_some_and(|first| now.duration_since(*first) > SPAN) {
            self.drawn.pop_front();
        }
    }

    /// Frames a second between the first and the last of the last second; none of fewer than two, or after a rest.
    pub(crate) fn rate(&self, now: Instant) -> Option<f64> {
        let (first, last) = (self.drawn.front()?, self.drawn.back()?);
        let span = last.duration_since(*first).as_secs_f64();
        let is_moving = now.duration_since(*last) < SPAN;
        (is_moving && self.drawn.len() > 1 && span > 0.0).then(|| (self.drawn.len() - 1) as f64 / span)
    }
}

impl Status {
    /// Notes what the processor drew in this frame, in a room whose pictures are all its own.
    pub(crate) fn note_drawn(&mut self, ctx: &Context) {
        let drawn = drawn(ctx);
        let known = self.by_processor.get_or_insert_default();
        if drawn.pictures > 0 {
            *known = drawn.pictures;
            self.cpu = drawn.milliseconds;
            self.drew(Instant::now());
        }
        let textures = ctx.tex_manager();
        self.bytes = textures.read().allocated().map(|(_, texture)| texture.bytes_used() as u64).sum();
    }

    /// Shows it, in as many lines as it took at most: one more or less would make the picture above another, and begin its truth
    /// anew.
    pub(crate) fn show(&self, ui: &mut Ui) {
        let (id, width) = (ui.scope_id().with("status"), ui.available_width());
        let known: Option<[f32; 2]> = ui.data(|data| data.get_temp(id));
        let least = known.filter(|known| known[0] == width).map_or(0.0, |[_, height]| height);
        let height = ui.add(Label::new(self.to_string()).wrap()).rect.height();
        ui.add_space((least - height).max(0.0));
        ui.data_mut(|data| data.insert_temp(id, [width, height.max(least)]));
    }
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.rate(Instant::now()) {
            Some(rate) => write!(f, "{rate:.0} frames/s")?,
            None => write!(f, "at rest")?,
        }
        write!(f, ", CPU {:.1} ms", self.cpu)?;
        match self.gpu {
            Some(gpu) => write!(f, ", GPU {gpu:.1} ms")?,
            None if self.by_processor.is_none() => write!(f, ", GPU not timed")?,
            None => {}
        }
        let [width, height] = self.size;
        let megabytes = self.bytes as f64 * 1e-6;
        if let Some(pictures) = self.by_processor {
            let pictures = if pictures == 1 { "1 picture".into() } else { format!("{pictures} pictures") };
            return write!(
                f,
                ", GPU 0 ms | {pictures} by the processor | 0 vertices, 0 draw calls, {megabytes:.0} MB of textures"
            );
        }
        write!(
            f,
            " | {} vertices, {} triangles, {} draw calls, {megabytes:.0} MB on the device | {width} x {height}",
            self.vertices, self.triangles, self.draw_calls
        )?;
        self.left_out.map_or(Ok(()), |what| write!(f, " | {what}"))
    }
}
