//! `lobe man` and `lobe completions`: the command line described for `man` and for shells, by the parser itself.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::anyhow;
use clap::{Args, Command};
use clap_complete::Shell;
use clap_mangen::Man;
use lobe::io::write_atomically;

use crate::args::output;

#[derive(Args)]
pub(crate) struct ManPages {
    /// Write a page for every command into this folder, which is made if need be; without it, the page lobe(1) goes to stdout
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
}

#[derive(Args)]
pub(crate) struct Completions {
    /// The shell that completes the command line
    #[arg(value_name = "SHELL", value_enum)]
    shell: Shell,
}

/// A page of the manual.
struct Page {
    /// Such as `lobe-sh-eval.1`.
    file: String,
    roff: String,
}

impl ManPages {
    pub(crate) fn run(&self, lobe: Command) -> anyhow::Result<()> {
        let pages = pages(lobe)?;
        let Some(folder) = &self.output else { return output::print(&pages[0].roff) };
        fs::create_dir_all(folder).map_err(|error| anyhow!("{}: cannot be made: {error}", folder.display()))?;
        pages.iter().try_for_each(|page| page.write(folder))
    }
}

impl Page {
    fn write(&self, folder: &Path) -> anyhow::Result<()> {
        let path = folder.join(&self.file);
        write_atomically(&path, |file| file.write_all(self.roff.as_bytes()))
            .map_err(|error| anyhow!("{}: cannot be written: {error}", path.display()))
    }
}

impl Completions {
    pub(crate) fn run(&self, mut lobe: Command) -> anyhow::Result<()> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut lobe, "lobe", &mut script);
        output::print(&String::from_utf8(script)?)
    }
}

/// The pages of `lobe` and all its commands, that of `lobe` first.
fn pages(lobe: Command) -> anyhow::Result<Vec<Page>> {
    let mut lobe = lobe.disable_help_subcommand(true);
    // Gives every command its full name, and the options of all commands.
    lobe.build();
    let mut pages = Vec::new();
    add_pages(&lobe, &mut pages)?;
    Ok(pages)
}

fn add_pages(command: &Command, pages: &mut Vec<Page>) -> anyhow::Result<()> {
    let mut roff = Vec::new();
    // A page has all options, those that short help leaves out too.
    let whole = command.clone().mut_args(|arg| arg.hide_short_help(false));
    Man::new(whole).render(&mut roff)?;
    let name = command.get_display_name().unwrap_or(command.get_name());
    pages.push(Page { file: format!("{name}.1"), roff: String::from_utf8(roff)? });
    command.get_subcommands().try_for_each(|sub| add_pages(sub, pages))
}
