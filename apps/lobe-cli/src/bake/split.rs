//! Subdivision before a bake: options that split long edges, or those along which transfer changes.

use anyhow::bail;
use clap::Args;
use lobe::prt::{AdaptiveOptions, AdaptiveReport, BakeWork, SplitScene};
use lobe::scene::Scene;

use crate::args::values;
use crate::run::bake_watch::Checkpoint;
use crate::run::talk::Talk;

#[derive(Args)]
pub(crate) struct Splitting {
    /// Split triangles first until no edge is longer than this, in the scene's unit of length
    #[arg(long, value_name = "L", value_parser = values::positive)]
    pub(crate) max_edge: Option<f64>,
    /// Split triangles where transfer between vertices is farthest off, until that is less than this part of the mean, or
    /// there are --max-vertices [default: 0.01; of a .safetensors file none are split]
    #[arg(long, value_name = "X", value_parser = values::positive)]
    pub(crate) adaptive: Option<f64>,
    /// Leave edges that are shorter than this [default: 1/1024 of the scene's diagonal]
    #[arg(long, value_name = "L", value_parser = values::positive)]
    pub(crate) min_edge: Option<f64>,
    /// The most vertices, spent where transfer is farthest off [default: four times those of the scene, at least 20000]
    #[arg(long, value_name = "N", value_parser = vertices)]
    pub(crate) max_vertices: Option<usize>,
    /// Bake at the vertices that the scene has, however few
    #[arg(long, conflicts_with_all = ["adaptive", "min_edge", "max_vertices"])]
    pub(crate) no_split: bool,
}

fn vertices(text: &str) -> Result<usize, String> {
    values::whole(text, 1, u32::MAX as usize, "a number of vertices")
}

impl Splitting {
    /// Whether the user asked for anything to be split.
    pub(crate) fn is_asked(&self) -> bool {
        self.max_edge.is_some() || self.is_adaptive_asked()
    }

    /// Whether the user asked for splitting that takes rays.
    pub(crate) fn is_adaptive_asked(&self) -> bool {
        self.adaptive.is_some() || self.min_edge.is_some() || self.max_vertices.is_some()
    }

    /// The scene without edges that are too long.
    pub(crate) fn split_long(&self, scene: Scene) -> anyhow::Result<Scene> {
        Ok(match self.max_edge {
            Some(max_edge) => scene.split_edges(max_edge as f32)?,
            None => scene,
        })
    }

    /// The scene of a work with further vertices where its transfer is off, and the report.
    pub(crate) fn split_adaptively(
        &self,
        work: &BakeWork,
        checkpoint: &Checkpoint,
        talk: Talk,
    ) -> anyhow::Result<(SplitScene, AdaptiveReport)> {
        let found = work.scene().vertex_count();
        if self.max_vertices.is_some_and(|most| most < found) {
            bail!("--max-vertices: expected at least the {found} vertices that the scene begins with");
        }
        let options = self.options().bake(work.options().clone());
        checkpoint.watched_rounds(talk, |job| work.split(&options, job))
    }

    fn options(&self) -> AdaptiveOptions {
        let defaults = AdaptiveOptions::default();
        let error = self.adaptive.unwrap_or(defaults.error);
        defaults.error(error).min_edge(self.min_edge.map(|edge| edge as f32)).max_vertices(self.max_vertices)
    }

    /// The report of adaptive splitting, as a note: its outcome.
    pub(crate) fn note_of(&self, scene: &Scene, report: &AdaptiveReport) -> String {
        let AdaptiveReport { vertices_before, vertices, error, error_bound, too_short, worst, .. } = report;
        let goal = self.options().error;
        let mut text = format!("{vertices} vertices after splitting, {vertices_before} before");
        if *error_bound <= goal {
            text += &format!("; interpolated transfer is off by less than {:.1} % of the mean", 100.0 * goal);
            return text;
        }
        text += &format!(
            "; interpolated transfer is off by about {:.1} % of the mean",
            100.0 * error.max(0.5 * error_bound)
        );
        if let Some((mesh, _)) = worst {
            text += &format!(", most on `{}`", scene.meshes()[*mesh].name());
        }
        // Along the edge of a shadow the error falls as the root of the number of vertices.
        let more = 4 * vertices;
        text += &if *too_short > 0.5 {
            format!("; edges are too short to be split: a smaller --min-edge splits them too")
        } else {
            format!("; --max-vertices {more} about halves it")
        };
        text
    }
}
