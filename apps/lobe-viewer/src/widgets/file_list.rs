//! A window that lists folders and files, to open one of either.

use std::fs;
use std::path::{Path, PathBuf};

use eframe::egui::{Context, Key, Modifiers, ScrollArea, TextEdit, Ui, Window};

/// Entries of a folder that are shown at most.
const MOST: usize = 2000;

/// Folders and the files that can be opened.
#[derive(Debug, Default)]
pub(crate) struct FileList {
    is_open: bool,
    folder: PathBuf,
    typed: String,
    entries: Vec<Entry>,
    message: Option<String>,
}

#[derive(Debug)]
struct Entry {
    name: String,
    path: PathBuf,
    is_folder: bool,
}

impl FileList {
    /// Opens the window, in the folder where it was or in that of the program.
    pub(crate) fn open(&mut self, endings: &[&str]) {
        self.is_open = true;
        if self.folder.as_os_str().is_empty() {
            self.folder = std::env::current_dir().unwrap_or_else(|_| PathBuf::from("/"));
        }
        self.read(endings);
    }

    fn read(&mut self, endings: &[&str]) {
        self.entries.clear();
        self.message = None;
        self.typed = self.folder.display().to_string();
        let listed = match fs::read_dir(&self.folder) {
            Ok(listed) => listed,
            Err(error) => {
                self.message = Some(format!("{}: {error}", self.folder.display()));
                return;
            }
        };
        for entry in listed.flatten() {
            let (path, name) = (entry.path(), entry.file_name().to_string_lossy().into_owned());
            // What a link leads to is asked of the disk, what else an entry is the folder says.
            let is_folder = match entry.file_type() {
                Ok(kind) if !kind.is_symlink() => kind.is_dir(),
                _ => path.is_dir(),
            };
            let ending = path.extension().unwrap_or_default();
            let is_known = endings.iter().any(|known| ending.eq_ignore_ascii_case(known));
            if !name.starts_with('.') && (is_folder || is_known) {
                self.entries.push(Entry { name, path, is_folder });
            }
        }
        self.entries.sort_by(|a, b| (!a.is_folder, &a.name).cmp(&(!b.is_folder, &b.name)));
        let count = self.entries.len();
        if count > MOST {
            self.entries.truncate(MOST);
            self.message = Some(format!("The first {MOST} of {count}; type the path of another one."));
        }
    }

    /// Closes the window by a key, which then stops nothing else.
    pub(crate) fn keys(&mut self, ctx: &Context) {
        if self.is_open && ctx.input_mut(|input| input.consume_key(Modifiers::NONE, Key::Escape)) {
            self.is_open = false;
        }
    }

    /// Shows the window; returns the file or the folder that was chosen.
    pub(crate) fn show(&mut self, ctx: &Context, endings: &[&str]) -> Option<PathBuf> {
        if !self.is_open {
            return None;
        }
        let (mut is_open, mut chosen) = (true, None);
        Window::new("Open a file").open(&mut is_open).default_size([460.0, 420.0]).show(ctx, |ui| {
            chosen = self.content(ui, endings);
        });
        self.is_open = is_open && chosen.is_none();
        chosen
    }

    fn content(&mut self, ui: &mut Ui, endings: &[&str]) -> Option<PathBuf> {
        let (mut go, mut is_whole) = (None, false);
        ui.horizontal(|ui| {
            if ui.button("Up").on_hover_text("The folder above").clicked() {
                go = self.folder.parent().map(Path::to_path_buf);
            }
            let hint = "Six pictures that are the faces of a cube, by their names";
            is_whole = ui.button("Open this folder").on_hover_text(hint).clicked();
            let label = ui.label("Path");
            let typed = ui.add(TextEdit::singleline(&mut self.typed).desired_width(f32::INFINITY));
            if typed.labelled_by(label.id).lost_focus() && ui.input(|input| input.key_pressed(Key::Enter)) {
                go = Some(PathBuf::from(self.typed.trim()));
            }
        });
        ui.label(self.message.clone().unwrap_or_else(|| format!("Files: {}", endings.join(", "))));
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            for entry in &self.entries {
                let name = if entry.is_folder { format!("{}/", entry.name) } else { entry.name.clone() };
                if ui.selectable_label(false, name).clicked() {
                    go = Some(entry.path.clone());
                }
            }
        });
        if is_whole {
            return Some(self.folder.clone());
        }
        let path = go?;
        if path.is_dir() {
            self.folder = path;
            self.read(endings);
            return None;
        }
        Some(path)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_that_can_be_opened_are_listed_in_order_among_however_many_others() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: String| fs::write(folder.path().join(name), "").unwrap();
        (0..MOST + 5).for_each(|k| write(format!("note-{k:04}.txt")));
        ["z.glb", "a.HDR", ".hidden.glb"].into_iter().for_each(|name| write(name.into()));
        fs::create_dir(folder.path().join("zoo")).unwrap();
        let mut list = FileList { folder: folder.path().into(), ..FileList::default() };
        list.open(&["glb", "hdr"]);
        let names: Vec<&str> = list.entries.iter().map(|entry| entry.name.as_str()).collect();
        assert_eq!((names, &list.message), (vec!["zoo", "a.HDR", "z.glb"], &None), "all of them");
        (0..MOST + 5).for_each(|k| write(format!("scene-{k:04}.glb")));
        list.open(&["glb", "hdr"]);
        assert_eq!(list.entries.len(), MOST, "no more than that");
        assert_eq!(list.entries[1].name, "a.HDR", "the first by name");
        let told = list.message.unwrap_or_default();
        assert!(told.contains(&format!("{MOST} of {}", MOST + 8)), "{told}");
    }
}
