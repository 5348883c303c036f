//! Folder of a scene: the files that lie in it are all that the scene may name.

use std::path::{Component, Path, PathBuf};
use std::{fs, io};

use lobe_io::one_line;

use crate::error::SceneError;

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

/// The place of a file that `file` names relative to its folder, which it may not leave unless that is allowed.
///
/// # Errors
/// [`SceneError::Io`] if it is not there, [`SceneError::Unsupported`] if it is outside.
pub fn referenced_file(folder: &Path, name: &str, allow_outside: bool, file: &str) -> Result<PathBuf, SceneError> {
    let path = folder.join(name);
    let found = if allow_outside { Ok(Some(path.clone())) } else { find_within(folder, Path::new(name)) };
    let missing = |source: io::Error| {
        let place = one_line(&format!("{}, named by {file}", path.display()));
        SceneError::Io { place, source }
    };
    found.map_err(missing)?.ok_or_else(|| {
        SceneError::unsupported(
            file,
            format!(
                "names the file `{name}`, which is outside of its folder: move it there, or trust the file with \
                 --allow-outside"
            ),
        )
    })
}
