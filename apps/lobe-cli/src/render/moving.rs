//! Scenes that move in `lobe render`: their files, the times of the pictures, and the bakes that their parts lack.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use anyhow::bail;
use clap::{Args, ValueEnum};
use lobe::image::AnimatedPng;
use lobe::prt::{AlbedoMode, BakeOptions};
use lobe::render::{
    MovingBakeOptions, MovingMethod, MovingOptions, MovingScene, MovingShading, MovingSplitOptions, SplitCounts,
    VisibilityGridOptions,
};
use lobe::sh::ExpMethod;
use lobe::shadow::{
    FieldOptions, LogTable, LogTableOptions, RadialInterpolation, SceneDescription, ShadowFieldOptions, ShadowOptions,
    cached_log_table, read_log_table,
};

use crate::args::exponential::fast_exponential;
use crate::args::memory::MemoryLimit;
use crate::args::open_scene::OpenScene;
use crate::args::scene_input::tell;
use crate::args::scene_pose::PoseInput;
use crate::args::values;
use crate::args::vertex_budget::VertexBudget;
use crate::render::pictures::Pictures;
use crate::run::bake_watch::{Checkpoint, watched};
use crate::run::talk::Talk;

/// Pictures for each second of `--frames A..B`, as films have.
const FRAMES_PER_SECOND: f64 = 24.0;

/// The fewest pictures for each second: the time of every picture is then a number.
const LEAST_FRAMES_PER_SECOND: f64 = 1e-300;

/// The most points of a grid, of which each takes `order²` numbers. A larger number is taken for a typing error.
const MAX_STILL_POINTS: usize = 1 << 24;

/// Edges that are longer than this part of what moves blur its shadow.
const COARSE: f64 = 0.2;

/// Where bakes are kept until all pictures are done.
pub(crate) struct Keep<'a> {
    /// Their files are beside the output.
    pub(crate) output: &'a Path,
    /// Whether those that are there are forgotten.
    pub(crate) is_fresh: bool,
    pub(crate) talk: Talk,
}

/// A scene that can be shaded.
pub(crate) struct Prepared {
    pub(crate) shading: MovingShading,
    /// The files of its bakes.
    pub(crate) kept: Vec<Checkpoint>,
}

/// What is asked of the bakes of parts.
pub(crate) struct AskedBake {
    pub(crate) order: Option<usize>,
    pub(crate) bounces: Option<usize>,
}

/// Options of scenes that move.
#[derive(Args)]
#[command(next_help_heading = "Scenes that move")]
pub(crate) struct MovingInput {
    /// With --frames A..B: pictures for each second, 1/65 to 1000 in an animated .png; at others, .exr pictures are written without it
    /// [default: 24]
    #[arg(long, value_name = "N", value_parser = frames_per_second)]
    fps: Option<f64>,
    /// Begin anew when the animation or all tracks have ended; without this they rest there
    #[arg(long = "loop")]
    is_looped: bool,
    /// shexp: the exponential: values on a grid of directions; the best linear function of single spheres; that after halving, then
    /// squared [default: grid]
    #[arg(long, value_name = "grid|optimal-linear|hybrid[:NORM]", value_parser = fast_exponential)]
    exponential: Option<ExpMethod>,
    /// fields, shexp: spheres fitted to each part that is deformed, and in shexp to each that moves [default: 64 and 16]
    #[arg(long, value_name = "K", value_parser = spheres)]
    spheres: Option<usize>,
    /// fields, shexp: light that spheres send on, one bounce
    #[arg(long)]
    sphere_bounce: bool,
    /// fields, shexp: the table of spheres, a .safetensors file of lobe spheres table, of any clamp and tolerance; made and written if
    /// it is not there
    #[arg(long, value_name = "FILE")]
    sphere_table: Option<PathBuf>,
    /// fields, shexp: the width of a window on what single spheres leave visible, in bands [default: none]
    #[arg(long, value_name = "H", value_parser = values::positive)]
    sphere_window: Option<f64>,
    /// fields, shexp: how fields are interpolated between their spheres: linear has kinks that a moving shadow shows, cubic has
    /// none for twice the reads [default: linear]
    #[arg(long, value_enum)]
    interpolation: Option<InterpolationName>,
    /// fields, shexp: vertices, a multiple of 16, for which spheres far away are summed once; 0: for each vertex [default: 0]
    #[arg(long, value_name = "N", value_parser = group)]
    group: Option<usize>,
    /// fields, shexp: with --group, spheres are far away where its radius is at most this part of their distance, 0 to 1: the less, the
    /// nearer to no groups [default: 0.05]
    #[arg(long, value_name = "X", value_parser = part)]
    far: Option<f32>,
    /// fields, shexp: spheres near each other count as one where what holds them all reaches at most this part of its distance, 0 to 1; 0:
    /// each counts by itself [default: 0.2]
    #[arg(long, value_name = "X", value_parser = part)]
    cut: Option<f32>,
    /// fields, shexp: every sphere hides all that it covers, as published; without this those that overlap share it
    #[arg(long)]
    no_share_overlaps: bool,
    /// fields, shexp: for each vertex the fields that look smallest are left out, up to this solid angle in all, in steradians; 0: none
    /// [default: 0.0063, a thousandth of a hemisphere]
    #[arg(long, value_name = "SR", value_parser = solid_angle)]
    negligible: Option<f64>,
    /// fields, shexp: split edges that are longer at a key of the animation, in the scene's units; light is at
    /// vertices, and what morph targets stretch has too few. Not of a scene description
    #[arg(long, value_name = "LENGTH", value_parser = values::positive)]
    max_edge: Option<f64>,
    /// fields, shexp: points of the grid at which it is found how much of the sky the parts that stand still leave to those that
    /// move; 0: they hide nothing from them, and only receive shadows [default: 4096]
    #[arg(long, value_name = "N", value_parser = still_points)]
    still_points: Option<usize>,
}

#[derive(Clone, Copy, ValueEnum)]
enum InterpolationName {
    Linear,
    Cubic,
}

impl From<InterpolationName> for RadialInterpolation {
    fn from(name: InterpolationName) -> Self {
        match name {
            InterpolationName::Linear => Self::Linear,
            InterpolationName::Cubic => Self::Cubic,
        }
    }
}

fn frames_per_second(text: &str) -> Result<f64, String> {
    match values::positive(text)? {
        few if few < LEAST_FRAMES_PER_SECOND => {
            Err(format!("expected {LEAST_FRAMES_PER_SECOND:e} pictures for each second at least, found {few:e}"))
        }
        fps => Ok(fps),
    }
}

/// Vertices that are still near each other in every scene.
const MOST_IN_GROUP: usize = 4096;

fn group(text: &str) -> Result<usize, String> {
    match values::whole(text, 0, MOST_IN_GROUP, "a number of vertices")? {
        odd if !odd.is_multiple_of(16) => Err(format!("expected a multiple of 16, found {odd}")),
        group => Ok(group),
    }
}

fn part(text: &str) -> Result<f32, String> {
    match values::finite(text)? {
        x if (0.0..=1.0).contains(&x) => Ok(x as f32),
        x => Err(format!("expected a part from 0 to 1, found {x}")),
    }
}

/// A solid angle, up to that of the whole sphere.
fn solid_angle(text: &str) -> Result<f64, String> {
    match values::finite(text)? {
        x if (0.0..=4.0 * PI).contains(&x) => Ok(x),
        x => Err(format!("expected a solid angle from 0 to 4π steradians, found {x}")),
    }
}

fn spheres(text: &str) -> Result<usize, String> {
    values::whole(text, 1, 4096, "a number of spheres")
}

fn still_points(text: &str) -> Result<usize, String> {
    match values::whole(text, 0, MAX_STILL_POINTS, "a number of points")? {
        few @ 1..8 => Err(format!("expected 0, or 8 points at least, found {few}")),
        points => Ok(points),
    }
}

impl MovingInput {
    /// Whether an option asks for a scene that moves; its name for messages.
    pub(crate) fn asked(&self) -> Option<&'static str> {
        let asked = [(self.fps.is_some(), "--fps"), (self.is_looped, "--loop")];
        let asked = asked.into_iter().find_map(|(is_asked, name)| is_asked.then_some(name));
        asked.or_else(|| self.asked_of_shading())
    }

    /// Whether options of shading are given, which the truth ignores; the name of one.
    pub(crate) fn asked_of_shading(&self) -> Option<&'static str> {
        [
            (self.exponential.is_some(), "--exponential"),
            (self.spheres.is_some(), "--spheres"),
            (self.sphere_bounce, "--sphere-bounce"),
            (self.sphere_table.is_some(), "--sphere-table"),
            (self.sphere_window.is_some(), "--sphere-window"),
            (self.interpolation.is_some(), "--interpolation"),
            (self.group.is_some(), "--group"),
            (self.far.is_some(), "--far"),
            (self.cut.is_some(), "--cut"),
            (self.no_share_overlaps, "--no-share-overlaps"),
            (self.negligible.is_some(), "--negligible"),
            (self.max_edge.is_some(), "--max-edge"),
            (self.still_points.is_some(), "--still-points"),
        ]
        .into_iter()
        .find_map(|(is_asked, name)| is_asked.then_some(name))
    }

    /// The file of the table of spheres.
    pub(crate) fn table_path(&self) -> Option<&Path> {
        self.sphere_table.as_deref()
    }

    /// Refuses options that contradict each other.
    pub(crate) fn check(
        &self,
        pose: &PoseInput,
        pictures: &Pictures,
        method: Option<MovingMethod>,
    ) -> anyhow::Result<()> {
        let has_range = pictures.is_range();
        if has_range && pose.time.is_some() {
            bail!("--time: --frames A..B says the times; leave one of them out");
        }
        if self.fps.is_some() && !has_range {
            bail!("--fps: only of --frames A..B; leave the option out");
        }
        if let Some(fps) = self.fps
            && pictures.is_png()
            && self.seconds_in_animation().is_none()
        {
            let shown = AnimatedPng::<Vec<u8>>::SECONDS;
            bail!(
                "--fps: an animated .png shows each picture for {} to {} seconds, found {fps:?} pictures for each second; \
                 give another number, or -o FILE.exr",
                shown.start(),
                shown.end()
            );
        }
        if self.exponential.is_some() && method != Some(MovingMethod::Exponentials) {
            bail!("--exponential: only of --mode shexp; leave the option out");
        }
        if self.far.is_some() && self.group.unwrap_or_default() == 0 {
            bail!("--far: only of groups of vertices; give --group N too, or leave the option out");
        }
        if let Some(file) = &self.sphere_table {
            crate::args::output::check_safetensors(file)?;
        }
        Ok(())
    }

    /// The time of a picture, in seconds: of frame `frame` of a range, else the one that was asked for.
    pub(crate) fn time_of(&self, pose: &PoseInput, frame: Option<usize>) -> f64 {
        match frame {
            Some(frame) => frame as f64 * self.seconds_per_frame(),
            None => pose.seconds(),
        }
    }

    /// The time from one picture of a range to the next.
    fn seconds_per_frame(&self) -> f64 {
        self.fps.unwrap_or(FRAMES_PER_SECOND).recip()
    }

    /// The same in an animation; none if that cannot show pictures for so short or so long.
    pub(crate) fn seconds_in_animation(&self) -> Option<f64> {
        Some(self.seconds_per_frame()).filter(|seconds| AnimatedPng::<Vec<u8>>::SECONDS.contains(seconds))
    }

    /// Reads or makes the scene, and says whether a part of it begins anew by itself, so that it never comes to rest. If bakes of it are
    /// of use, and a baked file holds some, it brings along those that suit.
    pub(crate) fn read(&self, open: OpenScene<'_>, bake: Option<&AskedBake>) -> anyhow::Result<(MovingScene, bool)> {
        let (input, talk, name) = (open.input, open.talk, open.input.name());
        if input.has_extension(&["json"]) {
            if input.pose.animation.is_some() {
                bail!("--animation: only of glTF files; a scene description says which animations its entities play");
            }
            if self.max_edge.is_some() {
                bail!("--max-edge: not of a scene description; leave the option out");
            }
            let options = input.checked_options(open.memory)?;
            let (moving, reports) = MovingScene::read(input.path(), &options)?;
            reports.iter().for_each(|(file, report)| tell(report, &file.display().to_string(), talk));
            // The span of the scene does not tell which of its animations begin anew.
            let description = SceneDescription::read(input.path(), options.allow_outside)?;
            let is_endless = description.entities.iter().any(|entity| entity.is_looped);
            return Ok((moving.looped(self.is_looped), is_endless));
        }
        let (animated, baked) = open.animated(bake.is_some())?;
        let animation = match &input.pose.animation {
            Some(asked) => Some(animated.animation(asked)?),
            None => (!animated.animations().is_empty()).then_some(0),
        };
        if animation.is_none() {
            talk.note(&name, "has no animation; it is shown as it stands");
        }
        let animated = match self.max_edge {
            Some(max_edge) => animated.split_edges(animation, max_edge as f32)?,
            None => animated,
        };
        let mut moving = MovingScene::animated(animated, animation)?.looped(self.is_looped);
        if let (Some(asked), Some(baked)) = (bake, &baked)
            && let Some(note) = moving.keep_baked(baked, asked.order, asked.bounces)
        {
            talk.note(&name, &note);
        }
        Ok((moving, false))
    }

    /// Notes which pictures show what has come to its end.
    pub(crate) fn note_end(&self, moving: &MovingScene, times: &[f64], name: &str, talk: Talk) {
        let [begin, end] = moving.span();
        if self.is_looped || begin >= end {
            return;
        }
        match times.iter().position(|time| *time >= end) {
            Some(first) if times.len() == 1 => {
                if times[first] == end {
                    return;
                }
                talk.note(name, &format!("has come to its end at {end:.3} s and rests there; --loop begins anew"));
            }
            Some(first) if first + 1 < times.len() => {
                let alike = times.len() - first;
                let text =
                    format!("comes to its end at {end:.3} s: the last {alike} pictures are alike; --loop begins anew");
                talk.note(name, &text);
            }
            _ => {}
        }
    }

    /// Splits triangles, so that there are vertices where shadows of what moves fall.
    pub(crate) fn split(
        moving: &mut MovingScene,
        budget: &VertexBudget,
        transfer: &BakeOptions,
        name: &str,
        talk: Talk,
    ) -> anyhow::Result<()> {
        if budget.no_split {
            return Ok(());
        }
        let all = moving.parts().iter().map(|part| part.scene.vertex_count()).sum();
        let adaptive = budget.options_of(all)?.bake(transfer.clone().albedo(AlbedoMode::None));
        let options = MovingSplitOptions::default().adaptive(adaptive);
        let split = watched(talk, "split", |job| moving.split(&options, job))?;
        let Ok(split) = split else { bail!("stopped while triangles were split, of which nothing is kept") };
        for (what, counts) in [("stands still", split.still), ("moves", split.moving)] {
            if let Some(SplitCounts { after, edge, .. }) = counts.filter(|counts| counts.edge > COARSE) {
                let text = format!(
                    "has {after} vertices of what {what}, too few for the shadows of what moves: edges there are up to \
                     {edge:.1} times its size; --max-vertices allows more"
                );
                talk.note(name, &text);
            }
        }
        Ok(())
    }

    /// Bakes what the parts lack, and prepares the shading.
    pub(crate) fn prepare(
        &self,
        moving: &mut MovingScene,
        method: MovingMethod,
        transfer: &BakeOptions,
        memory: &MemoryLimit,
        keep: &Keep<'_>,
    ) -> anyhow::Result<Prepared> {
        moving.expect_order(transfer.order)?;
        let table = self.table(transfer.order)?;
        let bake = self.bake_options(transfer);
        let lacking = moving.lacking(method, &bake);
        memory.check("what is baked of the parts", moving.bytes(&lacking, &bake), "a lower --order")?;
        let beside = Checkpoint::beside(keep.output);
        let mut kept = Vec::with_capacity(lacking.len());
        for one in &lacking {
            let file = Checkpoint::at(one.checkpoint(beside.path()));
            if keep.is_fresh {
                file.discard()?;
            }
            file.watched_one(keep.talk, &one.to_string(), |job| moving.bake_part(one, &bake, job))?;
            kept.push(file);
        }
        if self.sphere_bounce {
            moving.color_spheres();
        }
        moving.bake_lamps(transfer.order)?;
        for name in moving.hides_nothing(method) {
            keep.talk.note(name, "encloses no volume and changes its shape: it hides no light from other parts");
        }
        let options = MovingOptions::default()
            .method(method)
            .order(transfer.order)
            .fields(self.field_options())
            .spheres(self.sphere_options())
            .bounce(self.sphere_bounce);
        Ok(Prepared { shading: MovingShading::with_table(options, table)?, kept })
    }

    /// What fields hide.
    fn field_options(&self) -> ShadowFieldOptions {
        let defaults = ShadowFieldOptions::default();
        let (interpolation, negligible) = (defaults.interpolation, defaults.negligible);
        defaults
            .interpolation(self.interpolation.map_or(interpolation, Into::into))
            .negligible(self.negligible.unwrap_or(negligible))
    }

    /// What spheres hide.
    fn sphere_options(&self) -> ShadowOptions {
        let defaults = ShadowOptions::default();
        defaults
            .method(self.exponential.unwrap_or(defaults.method))
            .group(self.group.unwrap_or(defaults.group))
            .far(self.far.unwrap_or(defaults.far))
            .cut(self.cut.unwrap_or(defaults.cut))
            .share_overlaps(!self.no_share_overlaps)
    }

    /// The table of spheres, kept in a file if one is named. One that is there says itself of which clamp and tolerance it is; order and
    /// window are those asked for.
    fn table(&self, order: usize) -> anyhow::Result<LogTable> {
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
    fn bake_options(&self, transfer: &BakeOptions) -> MovingBakeOptions {
        let bake = MovingBakeOptions::default();
        let (spheres, visibility) = (bake.spheres.clone(), bake.visibility.clone());
        let (count, points) = (self.spheres.unwrap_or(spheres.count), self.still_points.unwrap_or(visibility.points));
        let deformed = self.spheres.or(bake.deformed_spheres);
        bake.transfer(transfer.clone().albedo(AlbedoMode::None))
            .field(FieldOptions::default().order(transfer.order))
            .spheres(spheres.count(count))
            .deformed_spheres(deformed)
            .visibility(VisibilityGridOptions::default().order(transfer.order).points(points))
            .still_hides(points > 0)
    }
}
