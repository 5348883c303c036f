//! Formats of scene files: one table, which readers, messages, help and the fronts go by.

use std::path::Path;

use lobe_io::named_endings;

use crate::error::SceneError;
use crate::files::source::Source;
use crate::files::{read_obj, read_ply};
use crate::scene::scene::Scene;
use crate::scene::up::Up;

/// A format of scene files, which the ending of a name tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SceneFormat {
    /// glTF, whose nodes may move; .vrm is a .glb of a character.
    Gltf,
    /// Wavefront OBJ with its materials.
    Obj,
    /// PLY, of text or of either byte order.
    Ply,
}

/// Reads a scene in which nothing moves, whose file leaves open which axis points up.
type ReadStill = fn(&[u8], &mut Source<'_>, Up) -> Result<Scene, SceneError>;

/// The endings of all formats, for texts that are put together at compile time. A test compares them with the table.
macro_rules! all_scene_endings {
    () => {
        ".glb, .gltf, .vrm, .obj or .ply"
    };
}
pub(crate) use all_scene_endings;

impl SceneFormat {
    /// All formats.
    pub const ALL: [Self; 3] = [Self::Gltf, Self::Obj, Self::Ply];

    fn row(self) -> (&'static [&'static str], Option<ReadStill>) {
        match self {
            Self::Gltf => (&["glb", "gltf", "vrm"], None),
            Self::Obj => (&["obj"], Some(read_obj::read)),
            Self::Ply => (&["ply"], Some(read_ply::read)),
        }
    }

    /// Endings of the names of its files, in lower case, the most common first.
    #[must_use]
    pub fn endings(self) -> &'static [&'static str] {
        self.row().0
    }

    /// The format that the ending of a name stands for.
    #[must_use]
    pub fn of_name(path: impl AsRef<Path>) -> Option<Self> {
        let ending = path.as_ref().extension()?.to_str()?.to_ascii_lowercase();
        Self::ALL.into_iter().find(|format| format.endings().contains(&&*ending))
    }

    /// All endings of some formats, as a sentence has them: `.glb, .gltf or .vrm`.
    #[must_use]
    pub fn names(of: impl Fn(Self) -> bool) -> String {
        named_endings(Self::ALL.into_iter().filter(|format| of(*format)).flat_map(Self::endings).copied())
    }

    /// Whether its files leave open which axis points up; those of glTF do not, and their nodes may move.
    #[must_use]
    pub fn leaves_up_open(self) -> bool {
        self.row().1.is_some()
    }
}

/// Whether a file's name says that it is glTF.
#[must_use]
pub fn is_gltf(path: impl AsRef<Path>) -> bool {
    SceneFormat::of_name(path) == Some(SceneFormat::Gltf)
}

/// Reads a scene of a format in which nothing moves.
pub(crate) fn read_still(bytes: &[u8], up: Up, source: &mut Source<'_>) -> Result<Scene, SceneError> {
    match SceneFormat::of_name(source.name).and_then(|format| format.row().1) {
        Some(read) => read(bytes, source, up),
        None => Err(source.unsupported(concat!("expected a file named ", all_scene_endings!()))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_of_compile_time_name_all_endings() {
        assert_eq!(SceneFormat::names(|_| true), all_scene_endings!());
    }
}
