//! Scenes that move in `lobe render`: their files, the times of the pictures, and the bakes that their parts lack.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use anyhow::bail;
use clap::{Args, ValueEnum};
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
use crate::args::values;
use crate::args::vertex_budget::VertexBudget;
use crate::run::bake_watch::{Checkpoint, watched};
use crate::run::talk::Talk;

/// The most points of a grid, of which each takes `order²` numbers. A larger number is taken for a typing error.
const MAX_STILL_POINTS: usize = 1 << 24;

/// Edges of what stands still that are longer than this part of what moves blur its shadow.
const COARSE: f64 = 0.2;

/// What moves wants no shorter edges than this part of its size.
const COARSE_BODY: f64 = 0.25;

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

/// How parts that move are shaded.
#[derive(Args, Default)]
#[command(next_help_heading = "Parts that move")]
pub(crate) struct MovingInput {
    /// With --method exponentials: the exponential: values on a grid of directions; the best linear function of single
    /// spheres; that after halving, then squared [default: grid]
    #[arg(long, hide_short_help = true, value_name = "grid|optimal-linear|hybrid[:NORM]", value_parser = fast_exponential)]
    exponential: Option<ExpMethod>,
    /// Spheres fitted to each part that is deformed, and with --method exponentials to each that moves [default: 64 and
    /// 16]
    #[arg(long, value_name = "K", value_parser = spheres)]
    spheres: Option<usize>,
    /// Light that spheres send on, one bounce
    #[arg(long, hide_short_help = true)]
    sphere_bounce: bool,
    /// The table of spheres, a .safetensors file of lobe spheres table, of any clamp and tolerance; made and written if
    /// it is not there
    #[arg(long, hide_short_help = true, value_name = "FILE")]
    sphere_table: Option<PathBuf>,
    /// The width of a window on what single spheres leave visible, in bands [default: none]
    #[arg(long, hide_short_help = true, value_name = "H", value_parser = values::positive)]
    sphere_window: Option<f64>,
    /// How fields are interpolated between their spheres: linear has kinks that a moving shadow shows, cubic has
    /// none for twice the reads [default: linear]
    #[arg(long, hide_short_help = true, value_enum)]
    interpolation: Option<InterpolationName>,
    /// Vertices, a multiple of 16, for which spheres far away are summed once; 0: for each vertex [default: 0]
    #[arg(long, hide_short_help = true, value_name = "N", value_parser = group)]
    group: Option<usize>,
    /// With --group, spheres are far away where its radius is at most this part of their distance, 0 to 1: the less,
    /// the nearer to no groups [default: 0.05]
    #[arg(long, hide_short_help = true, value_name = "X", value_parser = part)]
    far: Option<f32>,
    /// Spheres near each other count as one where what holds them all reaches at most this part of its distance, 0 to
    /// 1; 0: each counts by itself [default: 0.2]
    #[arg(long, hide_short_help = true, value_name = "X", value_parser = part)]
    cut: Option<f32>,
    /// Every sphere hides all that it covers, as published; without this those that overlap share it
    #[arg(long, hide_short_help = true)]
    no_share_overlaps: bool,
    /// For each vertex the fields that look smallest are left out, up to this solid angle in all, in steradians; 0:
    /// none [default: 0.0063, a thousandth of a hemisphere]
    #[arg(long, hide_short_help = true, value_name = "SR", value_parser = solid_angle)]
    negligible: Option<f64>,
    /// Split edges that are longer at a key of the animation, in the scene's units, for finer shadows. Not of a scene
    /// description
    #[arg(long, hide_short_help = true, value_name = "LENGTH", value_parser = values::positive)]
    max_edge: Option<f64>,
    /// Points of the grid at which it is found how much of the sky the parts that stand still leave to those that
    /// move; 0: they hide nothing from them, and only receive shadows [default: 4096]
    #[arg(long, hide_short_help = true, value_name = "N", value_parser = still_points)]
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
    /// The file of the table of spheres.
    pub(crate) fn table_path(&self) -> Option<&Path> {
        self.sphere_table.as_deref()
    }

    /// Refuses options that contradict each other.
    pub(crate) fn check(&self, method: Option<MovingMethod>) -> anyhow::Result<()> {
        if self.exponential.is_some() && method != Some(MovingMethod::Exponentials) {
            bail!("--exponential: only of --method exponentials; leave the option out");
        }
        if self.far.is_some() && self.group.unwrap_or_default() == 0 {
            bail!("--far: only of groups of vertices; give --group N too, or leave the option out");
        }
        if let Some(file) = &self.sphere_table {
            crate::args::output::check_safetensors(file)?;
        }
        Ok(())
    }

    /// Reads or makes the scene, and says whether a part of it begins anew by itself, so that it never comes to rest. If bakes of it are
    /// of use, and a baked file holds some, it brings along those that suit.
    pub(crate) fn read(
        &self,
        open: OpenScene<'_>,
        is_looped: bool,
        bake: Option<&AskedBake>,
    ) -> anyhow::Result<(MovingScene, bool)> {
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
            return Ok((moving.looped(is_looped), is_endless));
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
        let mut moving = MovingScene::animated(animated, animation)?.looped(is_looped);
        if let (Some(asked), Some(baked)) = (bake, &baked)
            && let Some(note) = moving.keep_baked(baked, asked.order, asked.bounces)
        {
            talk.note(&name, &note);
        }
        Ok((moving, false))
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
        for (what, counts, limit) in [("stands still", split.still, COARSE), ("moves", split.moving, COARSE_BODY)] {
            if let Some(SplitCounts { after, edge, .. }) = counts.filter(|counts| counts.edge > limit) {
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
