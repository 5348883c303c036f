//! A scene that moves as a job asks for it: how it is read, what is baked of its parts, and how they are shaded.

use std::path::PathBuf;

use lobe_io::{
    Given, GivenPaths, Job, JobFiles, JobOptions, MemoryLimit, NumberRange, OptionError, OptionField, OptionKind,
    options,
};
use lobe_prt::{AlbedoMode, BakeOptions, OpenScene, Transfer};
use lobe_sh::exponential::ExpMethod;
use lobe_shadow::{
    FieldOptions, LogTable, LogTableOptions, RadialInterpolation, SceneDescription, ShadowFieldOptions, ShadowOptions,
    SphereFitOptions, cached_log_table, read_log_table,
};

use crate::bake::moving_bake::MovingBakeOptions;
use crate::baked::visibility_grid::VisibilityGridOptions;
use crate::light::moving_shading::MovingShading;
use crate::moving_options::{MovingMethod, MovingOptions};
use crate::scene::moving_scene::MovingScene;
use crate::split::split_parts::{MovingSplitOptions, SplitCounts};
use lobe_render::{PictureBake, RenderError};

/// Edges of what stands still that are longer than this part of what moves blur its shadow.
const COARSE: f64 = 0.2;

/// What moves wants no shorter edges than this part of its size.
const COARSE_BODY: f64 = 0.25;

/// Vertices that are still near each other in every scene.
const MOST_IN_GROUP: u64 = 4096;

options! {
    /// A scene that moves: how its parts hide the sky from each other, and how that is baked.
    pub struct MovingJob with bake: PictureBake {
        /// How parts that move hide the sky
        method: MovingMethod = MovingMethod::Fields, OptionKind::Name(&[
            ("fields", "By precomputed shadow fields, or by spheres where they change their shape: nearer to the truth"),
            ("exponentials", "By spheres alone, as exponentials of sums (SHEXP): less to bake, and files of a few kilobytes"),
        ]), "METHOD", "";
        /// Spheres fitted to each part that is deformed, and with `method` exponentials to each that moves
        spheres: Option<usize> = None,
            OptionKind::Whole { least: 1, most: SphereFitOptions::MAX_COUNT as u64, what: "a number of spheres" },
            "K", "64 and 16";
        /// With `method` exponentials: the exponential: values on a grid of directions; the best linear function of
        /// single spheres; that after halving, then squared
        exponential: String = "grid".to_owned(), OptionKind::Text, "grid|optimal-linear|hybrid[:NORM]", "";
        /// Light that spheres send on, one bounce
        sphere_bounce: bool = false, OptionKind::Flag, "", "";
        /// The table of spheres, a .safetensors file of lobe spheres table, of any clamp and tolerance; made and
        /// written if it is not there
        #[serde(serialize_with = "lobe_io::as_text_if_any")]
        sphere_table: Option<PathBuf> = None, OptionKind::File, "FILE", "";
        /// The width of a window on what single spheres leave visible, in bands
        sphere_window: Option<f64> = None, OptionKind::Number(NumberRange::Positive), "H", "none";
        /// How fields are interpolated between their spheres: linear has kinks that a moving shadow shows, cubic has
        /// none for twice the reads
        interpolation: RadialInterpolation = ShadowFieldOptions::default().interpolation,
            OptionKind::Name(&[("linear", ""), ("cubic", "")]), "HOW", "";
        /// Vertices, a multiple of 16, for which spheres far away are summed once; 0: for each vertex
        group: usize = ShadowOptions::default().group,
            OptionKind::Whole { least: 0, most: MOST_IN_GROUP, what: "a number of vertices" }, "N", "";
        /// With `group`, spheres are far away where its radius is at most this part of their distance: the less, the
        /// nearer to no groups
        far: f64 = of_single(ShadowOptions::default().far), OptionKind::Number(NumberRange::Fraction), "X", "";
        /// Spheres near each other count as one where what holds them all reaches at most this part of its distance; 0:
        /// each counts by itself
        cut: f64 = of_single(ShadowOptions::default().cut), OptionKind::Number(NumberRange::Fraction), "X", "";
        /// Every sphere hides all that it covers, as published; without this those that overlap share it
        no_share_overlaps: bool = false, OptionKind::Flag, "", "";
        /// For each vertex the fields that look smallest are left out, up to this solid angle in all, in steradians; 0:
        /// none
        negligible: Option<f64> = None, OptionKind::Number(NumberRange::SolidAngle), "SR",
            "0.0063, a thousandth of a hemisphere";
        /// Split edges that are longer at a key of the animation, in the scene's units, for finer shadows. Not of a
        /// scene description
        max_edge: Option<f64> = None, OptionKind::Number(NumberRange::Positive), "LENGTH", "";
        /// Points of the grid at which it is found how much of the sky the parts that stand still leave to those that
        /// move; 0: they hide nothing from them, and only receive shadows
        still_points: usize = VisibilityGridOptions::default().points,
            OptionKind::Whole { least: 0, most: 1 << 24, what: "a number of points" }, "N", "";
    }
}

/// A number of single precision with the digits that it was written with.
fn of_single(x: f32) -> f64 {
    x.to_string().parse().unwrap_or(f64::from(x))
}

impl JobOptions for MovingJob {
    fn fields() -> Vec<&'static OptionField> {
        Self::FIELDS.iter().chain(PictureBake::FIELDS).collect()
    }

    fn heading_of(name: &str) -> Option<&'static str> {
        (!PictureBake::has(name) && name != "method").then_some("Parts that move")
    }

    fn set_paths(&mut self, given: GivenPaths<'_>) {
        self.sphere_table =
            given("sphere_table").and_then(|paths| paths.into_iter().next()).or(self.sphere_table.take());
    }

    fn check_together(&self, given: &Given<'_>) -> Result<(), OptionError> {
        let refused = |option: &str, message: String| Err(OptionError::new(option, message));
        self.bake.check_together(given)?;
        self.exp_method()?;
        if given.has("exponential") && self.method != MovingMethod::Exponentials {
            return refused("exponential", "only of @method exponentials; leave the option out".to_owned());
        }
        if !self.group.is_multiple_of(16) {
            return refused("group", format!("expected a multiple of 16, found {}", self.group));
        }
        if given.has("far") && self.group == 0 {
            return refused("far", "only of groups of vertices; give @group N too, or leave the option out".to_owned());
        }
        if (1..8).contains(&self.still_points) {
            return refused("still_points", format!("expected 0, or 8 points at least, found {}", self.still_points));
        }
        let is_other =
            |path: &&PathBuf| path.extension().is_none_or(|found| !found.eq_ignore_ascii_case("safetensors"));
        match self.sphere_table.as_ref().filter(is_other) {
            Some(path) => {
                refused("sphere_table", format!("expected a name that ends in .safetensors, found {}", path.display()))
            }
            None => Ok(()),
        }
    }
}

/// A scene that moves as it was read.
pub struct ReadMoving {
    /// The scene.
    pub moving: MovingScene,
    /// Whether a part of it begins anew by itself, so that it never comes to rest.
    pub is_endless: bool,
}

impl MovingJob {
    /// Reads or makes a scene, and takes over the transfer that a baked file holds as far as it suits `order`; with
    /// `takes_transfer` false, as of a scene that is traced, nothing of it. The job hears what a user should know.
    ///
    /// # Errors
    /// [`RenderError::OfJob`] for options that the scene has no use for; else those of [`MovingScene::read`],
    /// [`OpenScene::animated`] and [`MovingScene::animated`].
    pub fn read(
        &self,
        open: OpenScene,
        (order, takes_transfer): (Option<usize>, bool),
        memory: MemoryLimit,
        work: &mut Job<'_>,
    ) -> Result<ReadMoving, RenderError> {
        let source = open.source().clone();
        let name = source.name();
        if source.has_extension(&["json"]) {
            if source.animation.is_some() {
                let text = "only of glTF files; a scene description says which animations its entities play";
                return Err(OptionError::new("animation", text).into());
            }
            if self.max_edge.is_some() {
                let text = "not of a scene description; leave the option out";
                return Err(OptionError::new("max_edge", text).into());
            }
            let options = source.read_options(memory.bytes());
            let (moving, reports) = MovingScene::read(&source.scene, &options)?;
            for (file, report) in &reports {
                let place = file.display().to_string();
                report.remarks_with_options().iter().for_each(|text| work.note(&place, text));
            }
            // The span of the scene does not tell which of its animations begin anew.
            let description = SceneDescription::read(&source.scene, options.allow_outside)?;
            let is_endless = description.entities.iter().any(|entity| entity.is_looped);
            return Ok(ReadMoving { moving, is_endless });
        }
        let (animated, baked) = open.animated(takes_transfer, work)?;
        let animation = match &source.animation {
            Some(asked) => Some(animated.animation(asked)?),
            None => (!animated.animations().is_empty()).then_some(0),
        };
        if animation.is_none() {
            work.note(&name, "has no animation; it is shown as it stands");
        }
        let animated = match self.max_edge {
            Some(max_edge) => animated.split_edges(animation, max_edge as f32)?,
            None => animated,
        };
        let mut moving = MovingScene::animated(animated, animation)?;
        if let Some(baked) = &baked
            && let Some(text) = moving.keep_baked(baked, order, self.bake.bounces)
        {
            work.note(&name, &text);
        }
        Ok(ReadMoving { moving, is_endless: false })
    }

    /// The light paths of the parts, of `order` bands, or as many as those have that are baked.
    #[must_use]
    pub fn light(&self, moving: &MovingScene, order: Option<usize>) -> BakeOptions {
        self.bake.light(order.or_else(|| moving.order()).unwrap_or(BakeOptions::default().order))
    }

    /// Splits triangles, so that there are vertices where shadows of what moves fall, and says where these are too few.
    /// The job that is watched has the step `split`.
    ///
    /// # Errors
    /// Those of [`PictureBake::splitting`] and [`MovingScene::split`].
    pub fn split(
        &self,
        moving: &mut MovingScene,
        light: &BakeOptions,
        name: &str,
        mut work: Job<'_>,
    ) -> Result<(), RenderError> {
        if self.bake.no_split {
            return Ok(());
        }
        let all = moving.parts().iter().map(|part| part.scene.vertex_count()).sum();
        let adaptive = self.bake.splitting(all, light.clone().albedo(AlbedoMode::None))?;
        let split = moving.split(&MovingSplitOptions::default().adaptive(adaptive), work.step("split"))?;
        for (what, counts, limit) in [("stands still", split.still, COARSE), ("moves", split.moving, COARSE_BODY)] {
            if let Some(SplitCounts { after, edge, .. }) = counts.filter(|counts| counts.edge > limit) {
                let text = format!(
                    "has {after} vertices of what {what}, too few for the shadows of what moves: edges there are up to \
                     {edge:.1} times its size; @max_vertices allows more"
                );
                work.note(name, &text);
            }
        }
        Ok(())
    }

    /// Bakes what the parts lack, and prepares the shading; for a light that has suns with what they need. With
    /// `files` each bake is kept in a file of its own, whose name begins with that of the checkpoint; those that were
    /// kept are returned, to be removed when all pictures are done. `watched` does each bake, which prints as what it
    /// is, by a job.
    ///
    /// # Errors
    /// [`RenderError::OfJob`] for bakes that take more memory than allowed; else those of [`MovingScene::bake_part`]
    /// and
    /// [`MovingShading::with_table`].
    pub fn prepare<E: From<RenderError>>(
        &self,
        moving: &mut MovingScene,
        light: &BakeOptions,
        has_suns: bool,
        (memory, files): (MemoryLimit, Option<&JobFiles>),
        watched: &mut BakeOne<'_, E>,
    ) -> Result<(MovingShading, Vec<JobFiles>), E> {
        moving.expect_order(light.order)?;
        let table = self.table(light.order)?;
        let bake = self.bakes(light).direct(has_suns);
        let lacking = moving.lacking(self.method, &bake);
        let bytes = moving.bytes(&lacking, &bake);
        memory.check("what is baked of the parts", bytes, "a lower @order").map_err(RenderError::from)?;
        let mut kept = Vec::with_capacity(lacking.len());
        for one in &lacking {
            let own =
                files.map(|files| JobFiles::kept_in(files.output().to_owned(), one.checkpoint(files.checkpoint())));
            watched(&one.to_string(), own.as_ref(), &mut |job| moving.bake_part(one, &bake, job))?;
            kept.extend(own);
        }
        if self.sphere_bounce {
            moving.color_spheres();
        }
        moving.bake_lamps(light.order)?;
        let options = MovingOptions::default()
            .method(self.method)
            .order(light.order)
            .fields(self.field_options())
            .spheres(self.sphere_options().map_err(RenderError::from)?)
            .bounce(self.sphere_bounce);
        Ok((MovingShading::with_table(options, table)?, kept))
    }

    /// The exponential.
    fn exp_method(&self) -> Result<ExpMethod, OptionError> {
        match self.exponential.parse::<ExpMethod>() {
            Ok(method) if method.is_fast() => Ok(method),
            _ => {
                let text = "expected grid, optimal-linear or hybrid[:NORM], of a norm above 0";
                Err(OptionError::new("exponential", format!("{text}, found {}", self.exponential)))
            }
        }
    }

    /// What fields hide.
    fn field_options(&self) -> ShadowFieldOptions {
        let options = ShadowFieldOptions::default().interpolation(self.interpolation);
        let negligible = self.negligible.unwrap_or(options.negligible);
        options.negligible(negligible)
    }

    /// What spheres hide.
    fn sphere_options(&self) -> Result<ShadowOptions, OptionError> {
        let options = ShadowOptions::default().method(self.exp_method()?).group(self.group);
        Ok(options.far(self.far as f32).cut(self.cut as f32).share_overlaps(!self.no_share_overlaps))
    }

    /// The table of spheres, kept in a file if one is named. One that is there says itself of which clamp and tolerance
    /// it is; order and window are those asked for.
    fn table(&self, order: usize) -> Result<LogTable, RenderError> {
        let mut options = LogTableOptions::default().order(order);
        options.window = self.sphere_window;
        let Some(file) = &self.sphere_table else { return Ok(LogTable::new(&options)?) };
        // What cannot be read is told, or made anew, below.
        if let Ok(kept) = read_log_table(file) {
            let LogTableOptions { clamp, tolerance, .. } = *kept.options();
            options = options.clamp(clamp).tolerance(tolerance);
        }
        Ok(cached_log_table(file, &options)?)
    }

    /// The bakes of parts.
    fn bakes(&self, light: &BakeOptions) -> MovingBakeOptions {
        let bake = MovingBakeOptions::default();
        let (spheres, visibility) = (bake.spheres.clone(), VisibilityGridOptions::default());
        let (count, deformed) = (self.spheres.unwrap_or(spheres.count), self.spheres.or(bake.deformed_spheres));
        bake.transfer(light.clone().albedo(AlbedoMode::None))
            .field(FieldOptions::default().order(light.order))
            .spheres(spheres.count(count))
            .deformed_spheres(deformed)
            .visibility(visibility.order(light.order).points(self.still_points))
            .still_hides(self.still_points > 0)
    }

    /// Refuses an order that shadows of what moves do not have.
    ///
    /// # Errors
    /// [`OptionError`].
    pub fn check_order(order: Option<usize>) -> Result<(), OptionError> {
        match order.filter(|order| *order > Transfer::MAX_ORDER) {
            Some(_) => {
                let message = format!("shadows of what moves have an order of 1 to {}", Transfer::MAX_ORDER);
                Err(OptionError::new("order", message))
            }
            None => Ok(()),
        }
    }
}

/// Does one of several bakes: what it is, the file that it is kept in, and the work.
pub type BakeOne<'a, E> = dyn FnMut(&str, Option<&JobFiles>, &mut OneBake<'_>) -> Result<(), E> + 'a;

/// One bake, done by a job.
pub type OneBake<'a> = dyn FnMut(Job<'_>) -> Result<(), RenderError> + 'a;

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn options_that_cannot_be_are_refused_by_name() {
        for (asked, expected) in [
            (json!({"exponential": "hybrid:2"}), "exponential: only of method exponentials"),
            (
                json!({"method": "exponentials", "exponential": "eigen"}),
                "exponential: expected grid, optimal-linear or",
            ),
            (json!({"method": "exponentials", "exponential": "hybrid:0"}), "exponential: expected grid"),
            (json!({"far": 0.1}), "far: only of groups of vertices; give group N too"),
            (json!({"far": 1.5, "group": 16}), "far: expected a number from 0 to 1, found 1.5"),
            (json!({"group": 15}), "group: expected a multiple of 16, found 15"),
            (json!({"still_points": 7}), "still_points: expected 0, or 8 points at least, found 7"),
            (json!({"negligible": 13}), "negligible: expected a solid angle from 0 to 4π steradians, found 13"),
            (
                json!({"sphere_table": "a.json"}),
                "sphere_table: expected a name that ends in .safetensors, found a.json",
            ),
            (json!({"max_vertices": 9, "no_split": true}), "max_vertices: not with no_split"),
        ] {
            let error = MovingJob::from_values(asked.as_object().unwrap().clone()).unwrap_err().to_string();
            assert!(error.starts_with(expected), "{asked}: {error}");
        }
        let hybrid = json!({"method": "exponentials", "exponential": "hybrid:4.8"});
        let job = MovingJob::from_values(hybrid.as_object().unwrap().clone()).unwrap();
        assert_eq!(job.exp_method(), Ok(ExpMethod::Hybrid { limit: 4.8 }), "the norm of the paper");
    }

    #[test]
    fn a_job_has_the_defaults_of_the_library() {
        let job = MovingJob::default();
        assert_eq!(
            (job.field_options(), job.sphere_options()),
            (ShadowFieldOptions::default(), Ok(ShadowOptions::default()))
        );
        assert_eq!(job.bakes(&BakeOptions::default()), MovingBakeOptions::default());
    }
}
