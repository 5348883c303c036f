//! Limits of what is read: those of the command `lobe`, from its options or as they are without.

use std::sync::OnceLock;

use lobe::env::MapReadOptions;
use lobe::image::PictureReadOptions;
use lobe::prt::PrtError;
use lobe::render::RenderError;
use lobe::scene::{SceneError, SceneReadOption, SceneReadOptions};

/// Bytes of a gibibyte.
const GIB: f64 = (1_u64 << 30) as f64;

/// What a scene may take in memory while it is read unless an option says otherwise, as for the command, in GiB.
pub(crate) const MEMORY: f64 = 4.0;

/// Set by [`set`] once, before anything is read.
static GIVEN: OnceLock<Limits> = OnceLock::new();

/// Limits of files.
#[derive(Clone, Debug)]
pub(crate) struct Limits {
    /// In GiB.
    pub(crate) max_memory: f64,
    pub(crate) max_triangles: Option<usize>,
    /// Of the textures of a scene together, and of the picture of a sky.
    pub(crate) max_texels: Option<usize>,
    /// Whether files may name others outside of their folder.
    pub(crate) allow_outside: bool,
}

impl Default for Limits {
    fn default() -> Self {
        Self { max_memory: MEMORY, max_triangles: None, max_texels: None, allow_outside: false }
    }
}

impl Limits {
    fn scenes(&self) -> SceneReadOptions {
        let options =
            SceneReadOptions::default().max_bytes((self.max_memory * GIB) as u64).allow_outside(self.allow_outside);
        let (triangles, texels) = (options.max_triangles, options.max_texels);
        options.max_triangles(self.max_triangles.unwrap_or(triangles)).max_texels(self.max_texels.unwrap_or(texels))
    }

    fn skies(&self) -> MapReadOptions {
        MapReadOptions::default().max_texels(self.max_texels.unwrap_or(PictureReadOptions::default().max_texels))
    }
}

/// Sets the limits of this program; later calls change nothing.
pub(crate) fn set(limits: Limits) {
    let _ = GIVEN.set(limits);
}

/// The options of reading scenes.
pub(crate) fn of_scenes() -> SceneReadOptions {
    GIVEN.get().cloned().unwrap_or_default().scenes()
}

/// The options of reading pictures of skies.
pub(crate) fn of_skies() -> MapReadOptions {
    GIVEN.get().cloned().unwrap_or_default().skies()
}

/// An error of reading, what an option keeps out by the name that it has on the command line.
pub(crate) fn in_flags(error: impl Into<anyhow::Error>) -> anyhow::Error {
    let error = error.into();
    let of_scene = match (error.downcast_ref(), error.downcast_ref(), error.downcast_ref()) {
        (Some(error), ..) | (_, Some(PrtError::Scene(error)), _) | (.., Some(RenderError::Scene(error))) => Some(error),
        _ => None,
    };
    let Some(SceneError::Refused { place, message, option }) = of_scene else { return error };
    let flag = match option {
        SceneReadOption::MaxTriangles => "--max-triangles",
        SceneReadOption::MaxTexels => "--max-texels",
        _ => "--max-memory",
    };
    anyhow::anyhow!("{place}: {message}; lobe-viewer {flag} lets it in")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_limit_keeps_out_is_told_with_its_option() {
        let text = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 3 4\n";
        let options = SceneReadOptions::default().max_triangles(1);
        let error = lobe::scene::read_scene_bytes(text, "a.obj", &options).map(|_| ()).unwrap_err();
        let line = in_flags(error).to_string();
        assert!(line.starts_with("a.obj: ") && line.ends_with("; lobe-viewer --max-triangles lets it in"), "{line}");
        let other = in_flags(anyhow::anyhow!("a fault")).to_string();
        assert_eq!(other, "a fault", "other errors stay as they are");
    }

    #[test]
    fn without_options_the_limits_are_those_of_the_command() {
        let (scenes, skies) = (Limits::default().scenes(), Limits::default().skies());
        assert_eq!((scenes.max_bytes, scenes.allow_outside), (4 << 30, false), "4 GiB, and no files outside");
        assert_eq!(scenes.max_triangles, SceneReadOptions::default().max_triangles, "triangles");
        assert_eq!(skies, MapReadOptions::default(), "skies");
        let limits = Limits { max_memory: 0.5, max_triangles: Some(7), max_texels: Some(9), allow_outside: true };
        let scenes = limits.scenes();
        assert_eq!(
            (scenes.max_bytes, scenes.max_triangles, scenes.max_texels, scenes.allow_outside),
            (1 << 29, 7, 9, true),
            "as given"
        );
        assert_eq!(limits.skies().picture.max_texels, 9, "skies as given");
    }
}
