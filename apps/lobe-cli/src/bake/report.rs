//! The report of a bake that is done, as text or JSON.

use std::path::Path;

use lobe::prt::{BakeDone, BakeJob};
use serde::Serialize;
use serde_json::{Value, json};

use crate::args::{output, sharing};
use crate::run::talk::Talk;

/// Tells what is done, as JSON on stdout or else as a note.
pub(crate) fn tell(job: &BakeJob, done: &BakeDone, as_json: bool, talk: Talk) -> anyhow::Result<()> {
    let output = job.output.as_deref().unwrap_or(Path::new(""));
    let report = &done.report;
    if let Some(shard) = job.sharing.shard {
        let (points, seconds) = (report.receivers, report.seconds);
        let done = sharing::Done { shard: shard.to_string(), points, points_in_all: done.points, seconds };
        return done.tell(output, as_json, talk);
    }
    if as_json {
        return output::print_json(&printed(done));
    }
    talk.note(&output.display().to_string(), &text(job, done));
    Ok(())
}

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

fn printed(done: &BakeDone) -> Printed<'_> {
    let report = &done.report;
    Printed {
        vertices: done.vertices,
        triangles: done.triangles,
        rays: report.rays,
        seconds: report.seconds,
        stderr_dc: report.stderr_dc,
        points: report.receivers,
        samples: report.samples,
        bounces: report.bounces,
        energy_per_bounce: &report.energy_per_bounce,
        energy_left: report.energy_left,
        compression: done.compression.as_ref().map(|saved| {
            json!({
                "clusters": saved.clusters, "components": saved.components, "bytes": saved.bytes,
                "ratio": saved.ratio, "relative_error": saved.relative_error,
            })
        }),
    }
}

fn text(job: &BakeJob, done: &BakeDone) -> String {
    let report = &done.report;
    let mut text = format!(
        "vertices: {}, triangles: {}; rays: {} in {:.1} s; paths from each: {}; standard error of the constant \
         coefficient {:.2} %",
        done.vertices,
        done.triangles,
        report.rays,
        report.seconds,
        report.samples,
        100.0 * report.stderr_dc
    );
    if job.mode.reflects() {
        let all = report.energy_left + report.energy_per_bounce.iter().sum::<f64>();
        let left = if all > 0.0 { 100.0 * report.energy_left / all } else { 0.0 };
        text += &format!("; bounces: {}, at most {left:.2} % of the light goes on", report.bounces);
    }
    if let Some(saved) = &done.compression {
        text += &format!("; compressed {:.1} : 1 at {:.2} % error", saved.ratio, 100.0 * saved.relative_error);
    }
    text
}
