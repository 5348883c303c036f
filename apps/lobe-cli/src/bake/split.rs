//! Subdivision before a bake: options that split long edges, or those along which transfer changes.

use anyhow::bail;
use clap::Args;
use lobe::prt::{AdaptiveOptions, AdaptiveReport, BakeOptions, split_adaptively};
use lobe::scene::Scene;

use crate::args::values;
use crate::run::bake_watch::Checkpoint;
use crate::run::talk::Talk;

#[derive(Args)]
pub(crate) struct Splitting {
    /// Split triangles first until no edge is longer than this, in the scene's unit of length
    #[arg(long, value_name = "L", value_parser = values::positive)]
    pub(crate) max_edge: Option<f64>,
    /// Split edges in whose middle interpolated transfer is off by more than this part of the mean, such as 0.05
    #[arg(long, value_name = "X", value_parser = values::positive)]
    pub(crate) adaptive: Option<f64>,
    /// With --adaptive: leave edges that are shorter than this [default: 1/512 of the scene's diagonal]
    #[arg(long, value_name = "L", value_parser = values::positive)]
    pub(crate) min_edge: Option<f64>,
    /// With --adaptive: the most vertices, spent where interpolation is worst [default: as many as it takes]
    #[arg(long, value_name = "N", value_parser = vertices)]
    pub(crate) max_vertices: Option<usize>,
}

fn vertices(text: &str) -> Result<usize, String> {
    values::whole(text, 1, u32::MAX as usize, "a number of vertices")
}

impl Splitting {
    /// Whether anything is to be split.
    pub(crate) fn is_asked(&self) -> bool {
        self.max_edge.is_some() || self.is_adaptive()
    }

    /// Whether splitting takes rays.
    pub(crate) fn is_adaptive(&self) -> bool {
        self.adaptive.is_some()
    }

    /// The scene without edges that are too long.
    pub(crate) fn split_long(&self, scene: Scene) -> anyhow::Result<Scene> {
        Ok(match self.max_edge {
            Some(max_edge) => scene.split_edges(max_edge as f32)?,
            None => scene,
        })
    }

    /// The scene with further vertices where its transfer changes, and the report; `bake` has the options of the bake.
    pub(crate) fn split_adaptively(
        &self,
        scene: Scene,
        bake: &BakeOptions,
        checkpoint: &Checkpoint,
        talk: Talk,
    ) -> anyhow::Result<(Scene, Option<AdaptiveReport>)> {
        let Some(threshold) = self.adaptive else { return Ok((scene, None)) };
        let found = scene.vertex_count();
        if self.max_vertices.is_some_and(|most| most < found) {
            bail!("--max-vertices: expected at least the {found} vertices that the scene begins with");
        }
        let min_edge = self.min_edge.map(|edge| edge as f32);
        let options =
            AdaptiveOptions::before(bake).threshold(threshold).min_edge(min_edge).max_vertices(self.max_vertices);
        let (finer, report) = checkpoint.watched_rounds(talk, |job| split_adaptively(&scene, &options, job))?;
        Ok((finer, Some(report)))
    }
}

/// The report of adaptive splitting, as a note: its outcome.
pub(crate) fn note_of(report: &AdaptiveReport, threshold: f64) -> String {
    let AdaptiveReport { vertices_before, vertices, rounds, too_short, left_out, largest_error, .. } = report;
    let plural = if *rounds == 1 { "" } else { "s" };
    let text = format!("{vertices} vertices after {rounds} round{plural} of splitting, {vertices_before} before");
    if too_short + left_out == 0 {
        return format!(
            "{text}; transfer is off by {largest_error:.3} along any edge at most, --adaptive {threshold} is reached"
        );
    }
    let reasons = [
        (too_short, "too short to be split: a smaller --min-edge splits them too"),
        (left_out, "left out: a larger --max-vertices has room for them"),
    ];
    let reasons = reasons.into_iter().filter(|(count, _)| **count > 0).map(|(count, why)| format!("{count} {why}"));
    format!(
        "{text}; --adaptive {threshold} is not reached: transfer may be off by up to {largest_error:.3}; edges that are not split: {}",
        reasons.collect::<Vec<_>>().join(", ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_note_after_splitting_is_its_outcome() {
        let mut report = AdaptiveReport::default();
        (report.vertices_before, report.vertices, report.rounds, report.largest_error) = (8, 20, 1, 0.04);
        let text = "20 vertices after 1 round of splitting, 8 before; transfer is off by 0.040 along any edge at most, --adaptive 0.05 is reached";
        assert_eq!(note_of(&report, 0.05), text);
        (report.rounds, report.too_short, report.left_out, report.largest_error) = (3, 2, 5, 0.3);
        let note = note_of(&report, 0.05);
        assert!(
            note.starts_with("20 vertices after 3 rounds of splitting, 8 before; --adaptive 0.05 is not reached: "),
            "{note}"
        );
        for part in
            ["off by up to 0.300", "2 too short", "a smaller --min-edge", "5 left out", "a larger --max-vertices"]
        {
            assert!(note.contains(part), "{part}: {note}");
        }
    }
}
