//! Canvas of the sections: the page and the folder beside it. Each picture is a file and a figure of the page.

use std::path::PathBuf;
use std::time::Instant;

use lobe::image::{Picture, Pixel, Sheet, Tone, write_animated_png};
use lobe::io::{Job, Progress, write_atomically};

use super::html::{Page, State};
use super::size::Size;
use crate::error::{Drawn, GalleryError};

/// The page as it is being written.
pub(crate) struct Canvas<'a> {
    folder: PathBuf,
    pub(crate) size: Size,
    /// The path of the page.
    index: PathBuf,
    page: Page,
    job: Job<'a>,
    begun: Instant,
    /// Pieces of work that have begun, of so many.
    done: usize,
    total: usize,
}

impl<'a> Canvas<'a> {
    /// A page of so many pieces of work, with its files beside it.
    pub(crate) fn new(index: PathBuf, size: Size, job: Job<'a>, total: usize) -> Self {
        let folder = index.with_file_name("");
        Self { folder, size, index, page: Page::default(), job, begun: Instant::now(), done: 0, total }
    }

    /// A piece of work begins.
    pub(crate) fn step(&mut self) -> Drawn {
        let Self { done, total, begun, .. } = *self;
        self.done += 1;
        let progress = Progress { done, total, elapsed: begun.elapsed(), ..Progress::default() };
        if self.job.report(&progress).is_break() { Err(GalleryError::Cancelled) } else { Ok(()) }
    }

    /// All work is done.
    pub(crate) fn finish(&mut self) {
        let Self { done, begun, .. } = *self;
        // There is nothing left to stop.
        let _ = self.job.report(&Progress { done, total: done, elapsed: begun.elapsed(), ..Progress::default() });
    }

    pub(crate) fn title(&mut self, title: &str) {
        self.page.title(title);
    }

    pub(crate) fn section(&mut self, title: &str) {
        self.page.section(title);
    }

    pub(crate) fn text(&mut self, text: &str) {
        self.page.text(text);
    }

    /// A command that the reader can type.
    pub(crate) fn command(&mut self, command: &str) {
        self.page.command(command);
    }

    pub(crate) fn table(&mut self, head: &[&str], rows: &[Vec<String>]) {
        self.page.table(head, rows);
    }

    /// A picture, `width` wide on the page whatever its own pixels.
    pub(crate) fn figure(&mut self, file: &str, drawn: (&Picture, &Tone), width: usize, caption: &str) -> Drawn {
        self.hidden_figure(file, drawn)?;
        self.page.figure(file, width, caption);
        Ok(())
    }

    /// A picture that has all its colors, as wide on the page as it is.
    pub(crate) fn plain_figure(&mut self, file: &str, picture: &Picture, caption: &str) -> Drawn {
        self.figure(file, (picture, &Tone::PLAIN), picture.width(), caption)
    }

    /// A picture in the folder that the page does not show.
    pub(crate) fn hidden_figure(&mut self, file: &str, (picture, tone): (&Picture, &Tone)) -> Drawn {
        let path = self.begin_file(file)?;
        Ok(picture.write_png(path, tone)?)
    }

    /// Pictures that follow each other after so many seconds, in the tone of the first.
    pub(crate) fn animation(&mut self, file: &str, frames: &[Picture], seconds: f64, caption: &str) -> Drawn {
        let path = self.begin_file(file)?;
        let tone = Tone::PHOTOGRAPH.fixed_for(&frames[0]);
        write_animated_png(path, frames, &tone, seconds)?;
        self.page.figure(file, frames[0].width(), caption);
        Ok(())
    }

    /// A figure of lines.
    pub(crate) fn svg(&mut self, file: &str, svg: &str, width: usize, caption: &str) -> Drawn {
        let path = self.begin_file(file)?;
        write_atomically(&path, |out| out.write_all(svg.as_bytes())).map_err(GalleryError::io(&path))?;
        self.page.figure(file, width, caption);
        Ok(())
    }

    /// Begins a file beside the page: its path.
    pub(crate) fn begin_file(&mut self, file: &str) -> Result<PathBuf, GalleryError> {
        self.step()?;
        Ok(self.folder.join(file))
    }

    /// Writes the page as far as it is.
    pub(crate) fn publish(&self, state: State) -> Drawn {
        let html = self.page.html(state);
        write_atomically(&self.index, |file| file.write_all(html.as_bytes())).map_err(GalleryError::io(&self.index))
    }
}

/// Pictures in rows of so many, with space between and around them.
pub(crate) fn sheet(columns: usize, margin: usize, background: impl Into<Pixel>, pictures: &[Picture]) -> Picture {
    Sheet { columns, margin, background: background.into() }.compose(pictures)
}
