//! Folder of a scene: the files that lie in it are all that the scene may name.

use std::path::{Component, Path, PathBuf};
use std::{fs, io};

/// The place of a file that a scene names, links resolved; `None` if it is not within the folder.
///
/// A name from the root of the file system or one that climbs out of the folder is not looked up at all.
pub(crate) fn find_within(folder: &Path, name: &Path) -> io::Result<Option<PathBuf>> {
    let mut depth = 0_usize;
    for component in name.components() {
        match component {
            Component::CurDir => {}
            Component::Normal(_) => depth += 1,
            Component::ParentDir if depth > 0 => depth -= 1,
            Component::ParentDir | Component::RootDir | Component::Prefix(_) => return Ok(None),
        }
    }
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let (file, folder) = (fs::canonicalize(folder.join(name))?, fs::canonicalize(folder)?);
    Ok(file.starts_with(folder).then_some(file))
}
