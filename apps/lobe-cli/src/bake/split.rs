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
    /// Split triangles where transfer between vertices is farthest off, until that is less than this part of it,
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
        let options = self.options(work.scene())?.bake(work.options().clone());
        checkpoint.watched_rounds(talk, |job| work.split(&options, job))
    }

    /// The options of splitting, except for those of the bake.
    pub(crate) fn options(&self, scene: &Scene) -> anyhow::Result<AdaptiveOptions> {
        let options = self.budget.options(scene)?.error(self.error());
        Ok(options.min_edge(self.min_edge.map(|edge| edge as f32)))
    }

    /// The error to reach.
    fn error(&self) -> f64 {
        self.adaptive.unwrap_or(AdaptiveOptions::default().error)
    }

    /// The report of adaptive splitting, as a note: its outcome, and what is left to do.
    pub(crate) fn note_of(&self, scene: &Scene, report: &AdaptiveReport) -> String {
        let AdaptiveReport { vertices_before, vertices, error, error_bound, too_short, worst, .. } = report;
        let text =
            format!("{vertices} vertices after splitting, {vertices_before} before; interpolated transfer is off by");
        if *error_bound <= self.error() {
            return format!("{text} less than {:.1} %", 100.0 * self.error());
        }
        // An estimate near zero says little: half of its bound is nearer to what is known.
        let error = error.max(0.5 * error_bound);
        let place = worst.map_or_else(String::new, |(mesh, _)| format!(", most on `{}`", scene.meshes()[mesh].name()));
        let advice = if *too_short > 0.5 {
            "a smaller --min-edge splits what is too short now".to_owned()
        } else {
            // Along the edge of a shadow the error falls as the root of the number of vertices.
            format!("--max-vertices {} about halves it", 4 * vertices)
        };
        format!("{text} about {:.1} %{place}; {advice}", 100.0 * error)
    }
}

#[cfg(test)]
mod tests {
    use lobe::prt::AdaptiveReport;
    use lobe::scene::built_in;

    use super::*;

    #[test]
    fn the_note_after_splitting_says_what_is_off_and_what_to_do() {
        let budget = VertexBudget { max_vertices: None, no_split: false };
        let splitting = Splitting { max_edge: None, adaptive: Some(0.02), min_edge: None, budget };
        let scene = built_in::ball_over_ground(4);
        let mut report = AdaptiveReport::default();
        (report.vertices_before, report.vertices, report.error, report.error_bound) = (8, 20, 0.01, 0.015);
        let begin = "20 vertices after splitting, 8 before; interpolated transfer is off by";
        assert_eq!(splitting.note_of(&scene, &report), format!("{begin} less than 2.0 %"));
        (report.error, report.error_bound, report.worst) = (0.041, 0.05, Some((1, 0.9)));
        let name = scene.meshes()[1].name();
        let expected = format!("{begin} about 4.1 %, most on `{name}`; --max-vertices 80 about halves it");
        assert_eq!(splitting.note_of(&scene, &report), expected);
        report.too_short = 0.8;
        assert!(splitting.note_of(&scene, &report).ends_with("a smaller --min-edge splits what is too short now"));
    }
}
