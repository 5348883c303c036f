//! The vertices that splitting may make: of `lobe bake`, and of `lobe render` where it bakes on the way.

use anyhow::bail;
use clap::Args;
use lobe::prt::AdaptiveOptions;
use lobe::scene::Scene;

use crate::args::values;

#[derive(Args, Clone, Copy, Default)]
pub(crate) struct VertexBudget {
    /// Where a scene is baked: the most vertices that splitting may leave it, spent where transfer is farthest off. Of
    /// a scene that moves, what moves takes half of the new ones at most, and its shadows half of the rest [default:
    /// four times those of the scene, at least 20000]
    #[arg(long, value_name = "N", value_parser = vertices)]
    pub(crate) max_vertices: Option<usize>,
    /// Bake at the vertices that the scene has, however few
    #[arg(long, conflicts_with = "max_vertices")]
    pub(crate) no_split: bool,
}

fn vertices(text: &str) -> Result<usize, String> {
    values::whole(text, 1, u32::MAX as usize, "a number of vertices")
}

impl VertexBudget {
    /// The option that is given, if any.
    pub(crate) fn asked(&self) -> Option<&'static str> {
        self.max_vertices.map(|_| "--max-vertices").or(self.no_split.then_some("--no-split"))
    }

    /// Options of splitting within the budget, which a scene must not exceed to begin with.
    pub(crate) fn options(&self, scene: &Scene) -> anyhow::Result<AdaptiveOptions> {
        self.options_of(scene.vertex_count())
    }

    /// The same of a scene that begins with so many vertices.
    pub(crate) fn options_of(&self, found: usize) -> anyhow::Result<AdaptiveOptions> {
        if self.max_vertices.is_some_and(|most| most < found) {
            bail!("--max-vertices: expected at least the {found} vertices that the scene begins with");
        }
        Ok(AdaptiveOptions::default().max_vertices(self.max_vertices))
    }
}
