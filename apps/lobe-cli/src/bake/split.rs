//! Subdivision before a bake: options that split long edges, or those along which transfer changes.

use clap::Args;
use lobe::prt::{AdaptiveOptions, AdaptiveReport, BakeWork};
use lobe::scene::Scene;

use crate::args::values;
use crate::args::vertex_budget::VertexBudget;
use crate::run::bake_watch::Checkpoint;
use crate::run::talk::Talk;

#[derive(Args)]
pub(crate) struct Splitting {
    /// Split triangles first until no edge is longer than this, in the scene's unit of length
    #[arg(long, value_name = "L", value_parser = values::positive)]
    pub(crate) max_edge: Option<f64>,
    /// Split triangles where transfer between vertices is farthest off, until that is less than this part of the mean,
    /// or there are --max-vertices [default: 0.01; none are split for a .safetensors file, nor after --max-edge]
    #[arg(long, value_name = "X", value_parser = values::positive, conflicts_with = "no_split")]
    pub(crate) adaptive: Option<f64>,
    /// Leave edges that are shorter than this [default: 1/1024 of the scene's diagonal]
    #[arg(long, value_name = "L", value_parser = values::positive, conflicts_with = "no_split")]
    pub(crate) min_edge: Option<f64>,
    #[command(flatten)]
    pub(crate) budget: VertexBudget,
}

impl Splitting {
    /// Whether the user asked for anything to be split.
    pub(crate) fn is_asked(&self) -> bool {
        self.max_edge.is_some() || self.is_adaptive_asked()
    }

    /// Whether the user asked for splitting that takes rays.
    pub(crate) fn is_adaptive_asked(&self) -> bool {
        self.adaptive.is_some() || self.min_edge.is_some() || self.budget.max_vertices.is_some()
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
    ) -> anyhow::Result<(Scene, AdaptiveReport)> {
        let options = self.budget.options(work.scene())?.error(self.error()).bake(work.options().clone());
        let options = options.min_edge(self.min_edge.map(|edge| edge as f32));
        checkpoint.watched_rounds(talk, |job| work.split(&options, job))
    }

    /// The error to reach.
    fn error(&self) -> f64 {
        self.adaptive.unwrap_or(AdaptiveOptions::default().error)
    }

    /// The report of adaptive splitting, as a note: its outcome.
    pub(crate) fn note_of(&self, scene: &Scene, report: &AdaptiveReport) -> String {
        let AdaptiveReport { vertices_before, vertices, error, error_bound, too_short, worst, .. } = report;
        let goal = self.error();
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
