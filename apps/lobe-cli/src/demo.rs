//! `lobe demo`: everything that Lobe does, on built-in data, as one folder with a page.

use std::path::PathBuf;

use clap::Args;
use lobe_gallery::{Size, page_in, write_gallery};

use crate::args::output;
use crate::run::talk::Talk;

#[derive(Args)]
pub(crate) struct Demo {
    /// The folder to write into; it is made if need be
    #[arg(short, long, value_name = "DIR", default_value = "demo")]
    output: PathBuf,
    /// Draw small pictures: half the width
    #[arg(long)]
    quick: bool,
    /// Draw large pictures and trace more paths for the truth: three times the time
    #[arg(long, conflicts_with = "quick")]
    full: bool,
}

impl Demo {
    pub(crate) fn run(&self, talk: Talk) -> anyhow::Result<()> {
        let page = page_in(&self.output);
        talk.note("demo", &format!("{} shows each section as soon as it is there", page.display()));
        let size = match (self.quick, self.full) {
            (true, _) => Size::QUICK,
            (_, true) => Size::FULL,
            _ => Size::USUAL,
        };
        let index = talk.watch("demo", |job| write_gallery(&self.output, size, job))?;
        output::print(&format!("{}\n", index.display()))
    }
}
