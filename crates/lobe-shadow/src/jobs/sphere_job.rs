//! The job of spheres that stand for a mesh.

use std::path::PathBuf;

use lobe_io::{
    Given, GivenPaths, Job, JobFiles, JobOptions, OptionError, OptionField, OptionKind, WorkOptions, options,
};
use lobe_scene::SceneSource;

use crate::error::ShadowError;
use crate::jobs::field_job::expect_safetensors;
use crate::spheres::fit_spheres::{SphereFitMethod, SphereFitOptions, fit_spheres};
use crate::spheres::sphere_file::write_spheres;
use crate::spheres::sphere_json::SphereSetJson;
use crate::spheres::sphere_set::SphereSet;

/// A fit that holds less than this part of the space for certain is noted.
const CERTAIN: f64 = 0.9;

/// Bytes that a point takes while the fit runs.
const POINT: u64 = 100;

options! {
    /// Spheres that stand for a mesh: of what, how they are found, and where they are written.
    ///
    /// ```
    /// use lobe_io::{Job, JobOptions};
    /// use lobe_shadow::SphereJob;
    ///
    /// let asked = serde_json::json!({"scene": "built-in:furnace", "count": 2, "points": 64, "rounds": 1});
    /// let job = SphereJob::from_values(asked.as_object().cloned().unwrap_or_default())?;
    /// let (spheres, report) = job.run(Job::default())?;
    /// assert_eq!(spheres.len(), 2);
    /// assert!(report.union_volume > 0.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub struct SphereJob with source: SceneSource, work: WorkOptions {
        /// The spheres, a .safetensors file
        #[serde(serialize_with = "lobe_io::as_text_if_any")]
        output: Option<PathBuf> = None, OptionKind::File, "OUT", "";
        /// Only this entity of a scene: a mesh, or a node of a glTF file, by name or number; in the shape that its skin
        /// was bound to. The file then has the joints of each sphere, which follow them where an animation moves the
        /// entity
        entity: Option<String> = None, OptionKind::Text, "NAME", "";
        /// Number of spheres
        count: usize = SphereFitOptions::default().count,
            OptionKind::Whole { least: 1, most: SphereFitOptions::MAX_COUNT as u64, what: "a number of spheres" },
            "K", "";
        /// How they are found
        method: SphereFitMethod = SphereFitOptions::default().method, OptionKind::Name(&[
            ("variational", "Least volume outside the solid, by Lloyd's algorithm with teleportation"),
            ("medial-axis", "Balls of the medial axis, selected greedily: faster, and worse"),
        ]), "METHOD", "";
        /// About how many points of the solid the spheres must cover
        points: usize = SphereFitOptions::default().samples,
            OptionKind::Whole { least: 1, most: SphereFitOptions::MAX_SAMPLES as u64, what: "a number of points" },
            "N", "";
        /// With `method` medial-axis: balls keep the size that they were selected with, as published; without this each
        /// shrinks at last to the points that are its own
        no_shrink: bool = false, OptionKind::Flag, "", "";
        /// With `method` variational: rounds at most
        rounds: usize = SphereFitOptions::default().rounds,
            OptionKind::Whole { least: 0, most: SphereFitOptions::MAX_ROUNDS as u64, what: "a number of rounds" },
            "N", "";
        /// Another seed gives other points
        seed: u64 = SphereFitOptions::default().seed,
            OptionKind::Whole { least: 0, most: u64::MAX, what: "a number" }, "S", "";
    }
}

impl JobOptions for SphereJob {
    fn fields() -> Vec<&'static OptionField> {
        SceneSource::fields().into_iter().chain(Self::FIELDS).chain(WorkOptions::FIELDS).collect()
    }

    fn heading_of(name: &str) -> Option<&'static str> {
        if SceneSource::has(name) { SceneSource::heading_of(name) } else { None }
    }

    fn set_paths(&mut self, given: GivenPaths<'_>) {
        self.source.set_paths(given);
        self.output = given("output").and_then(|paths| paths.into_iter().next()).or(self.output.take());
    }

    fn check_together(&self, given: &Given<'_>) -> Result<(), OptionError> {
        self.source.check_together(given)?;
        let refused =
            |option, method| Err(OptionError::new(option, format!("only of @method {method}; leave the option out")));
        match self.method {
            SphereFitMethod::MedialAxis if given.has("rounds") => refused("rounds", "variational"),
            SphereFitMethod::Variational if self.no_shrink => refused("no_shrink", "medial-axis"),
            _ => expect_safetensors(self.output.as_ref()),
        }
    }
}

impl SphereJob {
    /// Fits spheres, and writes them if there is an output. A variational fit is then kept beside it while it runs; the
    /// same job goes on from there. The job that is watched has the step `fit`, and hears what a user should know.
    ///
    /// # Errors
    /// [`ShadowError::OfJob`] for options that cannot be; [`ShadowError::Cancelled`] if the watch said to stop; else
    /// those of reading, of [`fit_spheres`] and of writing.
    pub fn run(&self, mut work: Job<'_>) -> Result<(SphereSet, SphereSetJson), ShadowError> {
        self.check()?;
        let files = self.files();
        if let Some(files) = &files {
            files.expect_writable([&*self.source.scene])?;
        }
        let name = self.source.name();
        let read = self.source.read_entity(self.entity.as_deref(), self.work.memory().bytes())?;
        read.remarks.iter().for_each(|text| work.note(&name, text));
        if read.is_posed {
            let text = "is posed by animations, skins or morph targets, whose motion these spheres do not follow; @entity \
                        NAME fits some that do";
            work.note(&name, text);
        }
        // Spheres shrink with what morph targets stretch.
        let scene = match &read.entity {
            Some((animated, entity)) => animated.morphed_scene(entity, &animated.widest_weights(entity)?)?,
            None => read.scene,
        };
        let options = self.options();
        let what = format!("a fit to {} points", options.samples);
        self.work.memory().check(&what, POINT * options.samples as u64, "fewer @points")?;
        if let Some(files) = files.as_ref().filter(|_| self.work.fresh) {
            files.discard()?;
        }
        let is_kept = self.method == SphereFitMethod::Variational;
        let part = work.step("fit");
        let part = match files.as_ref().filter(|_| is_kept) {
            Some(files) => part.kept_in(files.checkpoint()),
            None => part,
        };
        // What cannot be fitted is the mesh.
        let named = |error: ShadowError| match error {
            ShadowError::Options(message) => ShadowError::Invalid { place: name.clone(), message },
            other => other,
        };
        let (spheres, report) = fit_spheres(&scene, &options, part).map_err(named)?;
        let spheres = match &read.entity {
            Some((animated, entity)) => spheres.bind_to(animated, entity, &mut work)?,
            None => spheres,
        };
        if report.certainty < CERTAIN {
            let certain = 100.0 * report.certainty;
            let text = format!(
                "is not closed: of {certain:.0} % of its box it is certain whether it is solid; spheres cover what is more \
                 likely so than not"
            );
            work.note(&name, &text);
        }
        if let Some(files) = &files {
            write_spheres(files.output(), &spheres)?;
            files.finish();
        }
        let told = SphereSetJson::new(&spheres, &report);
        Ok((spheres, told))
    }

    /// The output, and what is kept beside it, if there is one.
    #[must_use]
    pub fn files(&self) -> Option<JobFiles> {
        self.output.clone().map(JobFiles::beside)
    }

    /// The options of the fit.
    #[must_use]
    pub fn options(&self) -> SphereFitOptions {
        let options = SphereFitOptions::default().count(self.count).method(self.method).samples(self.points);
        options.shrink(!self.no_shrink).rounds(self.rounds).seed(self.seed)
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn options_of_another_method_are_refused_by_name() {
        for (asked, expected) in [
            (json!({"method": "medial-axis", "rounds": 3}), "rounds: only of method variational"),
            (json!({"no_shrink": true}), "no_shrink: only of method medial-axis"),
            (json!({"count": 0}), "count: expected a number of spheres from 1 to 4096, found 0"),
            (json!({"output": "a.json"}), "output: expected a name that ends in .safetensors"),
        ] {
            let error = SphereJob::from_values(asked.as_object().unwrap().clone()).unwrap_err().to_string();
            assert!(error.starts_with(expected), "{asked}: {error}");
        }
        assert_eq!(SphereJob::default().options(), SphereFitOptions::default(), "the same defaults");
    }
}
