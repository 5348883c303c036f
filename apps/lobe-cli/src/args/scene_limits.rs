//! Limits of what a scene's file may hold.

use clap::Args;
use lobe::scene::SceneReadOptions;

use crate::args::memory::MemoryLimit;
use crate::args::values;

/// `--max-triangles` and `--max-texels`.
#[derive(Args)]
pub(crate) struct SceneLimits {
    /// The most triangles, and the most vertices, that a file may hold, its instances counted [default: 67108864]
    #[arg(long, value_name = "N", value_parser = max_triangles)]
    max_triangles: Option<usize>,
    /// The most texels that all textures of a file together may have [default: 268435456]
    #[arg(long, value_name = "N", value_parser = max_texels)]
    max_texels: Option<usize>,
}

fn max_triangles(text: &str) -> Result<usize, String> {
    values::whole(text, 1, SceneReadOptions::MOST_TRIANGLES, "a number of triangles")
}

fn max_texels(text: &str) -> Result<usize, String> {
    values::whole(text, 1, SceneReadOptions::MOST_TEXELS, "a number of texels")
}

impl SceneLimits {
    /// The first option that is given: for what is no scene's file.
    pub(crate) fn given(&self) -> Option<&'static str> {
        let triangles = self.max_triangles.map(|_| "--max-triangles");
        triangles.or(self.max_texels.map(|_| "--max-texels"))
    }

    /// The options of reading within these limits.
    pub(crate) fn options(&self, memory: &MemoryLimit) -> SceneReadOptions {
        let options = SceneReadOptions::default().max_bytes(memory.bytes());
        let (triangles, texels) = (options.max_triangles, options.max_texels);
        options.max_triangles(self.max_triangles.unwrap_or(triangles)).max_texels(self.max_texels.unwrap_or(texels))
    }
}
