//! The report of a bake that is done, as text or JSON.

use std::path::Path;

use lobe::prt::{BakeOptions, BakeReport, CompressReport};
use lobe::scene::Scene;
use serde::Serialize;
use serde_json::{Value, json};

use crate::args::output;
use crate::run::talk::Talk;

/// The JSON of `--json`.
#[derive(Serialize)]
struct Printed<'a> {
    vertices: usize,
    triangles: usize,
    rays: u64,
    seconds: f64,
    stderr_dc: f64,
    points: usize,
    samples: u32,
    bounces: usize,
    energy_per_bounce: &'a [f64],
    energy_left: f64,
    /// Clusters, components, bytes, bytes before for each of them, relative error.
    #[serde(skip_serializing_if = "Option::is_none")]
    compression: Option<Value>,
}

/// A bake that is done, its output written.
pub(crate) struct Done<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) options: &'a BakeOptions,
    pub(crate) report: &'a BakeReport,
    pub(crate) compression: Option<&'a CompressReport>,
}

impl Done<'_> {
    /// As JSON on stdout, or else as a note.
    pub(crate) fn tell(&self, output: &Path, as_json: bool, talk: Talk) -> anyhow::Result<()> {
        if as_json {
            return output::print_json(&self.printed());
        }
        talk.note(&output.display().to_string(), &self.text());
        Ok(())
    }

    fn printed(&self) -> Printed<'_> {
        let report = self.report;
        Printed {
            vertices: self.scene.vertex_count(),
            triangles: self.scene.triangle_count(),
            points: report.receivers,
            rays: report.rays,
            seconds: report.seconds,
            stderr_dc: report.stderr_dc,
            samples: report.samples,
            bounces: report.bounces,
            energy_per_bounce: &report.energy_per_bounce,
            energy_left: report.energy_left,
            compression: self.compression.map(|saved| {
                json!({
                    "clusters": saved.clusters, "components": saved.components, "bytes": saved.bytes,
                    "ratio": saved.ratio, "relative_error": saved.relative_error,
                })
            }),
        }
    }

    fn text(&self) -> String {
        let report = self.report;
        let mut text = format!(
            "vertices: {}, triangles: {}; rays: {} in {:.1} s; paths from each: {}; standard error of the constant \
             coefficient {:.2} %",
            self.scene.vertex_count(),
            self.scene.triangle_count(),
            report.rays,
            report.seconds,
            report.samples,
            100.0 * report.stderr_dc
        );
        if self.options.mode.reflects() {
            let all = report.energy_left + report.energy_per_bounce.iter().sum::<f64>();
            let left = if all > 0.0 { 100.0 * report.energy_left / all } else { 0.0 };
            text += &format!("; bounces: {}, at most {left:.2} % of the light goes on", report.bounces);
        }
        if let Some(saved) = self.compression {
            text += &format!("; compressed {:.1} : 1 at {:.2} % error", saved.ratio, 100.0 * saved.relative_error);
        }
        text
    }
}
