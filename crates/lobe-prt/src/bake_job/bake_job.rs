//! The options of a bake: what is asked for, as a command line, a file or a program asks.

use std::path::{Path, PathBuf};

use lobe_io::{
    Given, GivenPaths, JobOptions, MemoryLimit, NumberRange, OptionError, OptionField, OptionKind, SharingOptions,
    WorkOptions, options,
};
use lobe_scene::{Scene, SceneSource, UnwrapOptions};
use serde::{Deserialize, Serialize};

use crate::bake::options::{AlbedoMode, BakeMode, BakeOptions};
use crate::compression::compress::CompressOptions;
use crate::compression::compression_options::CompressionOptions;
use crate::error::PrtError;
use crate::finishing::finish::FinishOptions;
use crate::fit::adaptive::AdaptiveOptions;
use crate::transfer::transfer::Transfer;
use crate::transfer::transfer_parts::TransferParts;

/// When a scene is unwrapped for a lightmap.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum UnwrapMode {
    /// Where its own coordinates, in set 1 or else 0, overlap or are missing.
    #[default]
    Auto,
    /// In any case.
    Always,
    /// Never: coordinates that overlap or are missing are refused.
    Never,
}

options! {
    /// A bake: a scene, where and how its transfer is found, and where it is written.
    ///
    /// ```
    /// use lobe_io::{Job, JobOptions};
    /// use lobe_prt::BakeJob;
    ///
    /// let folder = tempfile::tempdir()?;
    /// let asked = serde_json::json!({
    ///     "scene": "built-in:ball", "order": 2, "samples": 16, "no_split": true,
    ///     "output": folder.path().join("ball.glb"),
    /// });
    /// let job = BakeJob::from_values(asked.as_object().cloned().unwrap_or_default())?;
    /// let done = job.run(Job::default())?;
    /// assert!(done.report.rays > 0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub struct BakeJob with
        source: SceneSource, packing: CompressionOptions, work: WorkOptions, sharing: SharingOptions
    {
        /// The scene with transfer at its vertices, or in textures with `texels`, a .glb file; or the transfer alone, a
        /// .safetensors file, as which `mode` glossy and `grid` are written; of `texels` also an .exr picture with a
        /// layer for each coefficient
        #[serde(serialize_with = "lobe_io::as_text_if_any")]
        output: Option<PathBuf> = None, OptionKind::File, "OUT", "";
        /// The light that is baked
        mode: BakeMode = BakeOptions::default().mode, OptionKind::Name(BakeMode::NAMES), "MODE", "";
        /// The order (number of bands): n² coefficients, three times as many where light meets colors
        order: usize = BakeOptions::default().order,
            OptionKind::Whole { least: 1, most: Transfer::MAX_ORDER as u64, what: "an order (number of bands)" },
            "N", "";
        /// Paths from each vertex; powers of two are distributed best
        samples: Option<u32> = None,
            OptionKind::Whole { least: 1, most: BakeOptions::MAX_SAMPLES as u64, what: "a number of paths" }, "N",
            "1024, or up to 4096 where their noise is above 2 %";
        /// With `mode` interreflected and glossy: reflections at most
        bounces: usize = BakeOptions::default().bounces,
            OptionKind::Whole { least: 0, most: BakeOptions::MAX_BOUNCES as u64, what: "a number of reflections" },
            "B", "";
        /// With `mode` interreflected and glossy: leave out reflections that carry less than this part of the energy; 0
        /// keeps all
        energy_stop: f64 = BakeOptions::default().energy_stop, OptionKind::Number(NumberRange::Part), "X", "";
        /// The same seed gives the same bytes
        seed: u64 = BakeOptions::default().seed,
            OptionKind::Whole { least: 0, most: u64::MAX, what: "a number" }, "S", "";
        /// Where the albedo of the surface itself is; not of `mode` glossy and `grid`, whose matrices never have it
        albedo: Option<AlbedoMode> = None, OptionKind::Name(&[
            ("vertex", "In the transfer: what is shown has the detail of vertices"),
            ("none", "Nowhere: lobe render, or your shader, multiplies by the base color of each pixel, which has the \
                textures' detail"),
        ]), "WHERE", "none if a texture colors any surface, else vertex";
        /// Keep the transfer of the backs of double-sided surfaces in the file, too, for the side from which corners
        /// run clockwise. Without it lobe render bakes those that it shows, and other programs have none. Only in a
        /// .glb without compression
        backs: bool = false, OptionKind::Flag, "", "";
        /// With `mode` interreflected: the parts of the transfer in the file. Pictures under suns need both, and bake
        /// the direct one on the way where a file holds the whole alone. Only in a .glb without compression
        parts: TransferParts = TransferParts::Whole, OptionKind::Name(&[
            ("whole", "Direct and reflected light as one"),
            ("direct,reflected", "Direct light by itself, too, so that reflected light is the rest: a quarter more time"),
        ]), "PARTS", "";
        /// Split triangles first until no edge is longer than this, in the scene's unit of length
        max_edge: Option<f64> = None, OptionKind::Number(NumberRange::Positive), "L", "";
        /// Split triangles where transfer between vertices is farthest off, until that is less than this part of it, or
        /// there are `max_vertices`
        adaptive: Option<f64> = None, OptionKind::Number(NumberRange::Positive), "X",
            "0.01; none are split for a .safetensors file, nor after @max_edge";
        /// Leave edges that are shorter than this
        min_edge: Option<f64> = None, OptionKind::Number(NumberRange::Positive), "L",
            "1/1024 of the scene's diagonal";
        /// The most vertices that splitting may leave the scene, spent where transfer is farthest off
        max_vertices: Option<usize> = None,
            OptionKind::Whole { least: 1, most: u32::MAX as u64, what: "a number of vertices" }, "N",
            "four times those of the scene, at least 20000";
        /// Bake at the vertices that the scene has, however few
        no_split: bool = false, OptionKind::Flag, "", "";
        /// Bake at the W × W texels of a lightmap instead of at vertices, with the normals that normal maps have there,
        /// in texture coordinates of set 1 or else 0 that do not overlap, or of an unwrapping
        texels: Option<usize> = None,
            OptionKind::Whole { least: 1, most: UnwrapOptions::MOST_TEXELS as u64, what: "a number of texels" },
            "W", "";
        /// With `texels`: whether to unwrap the scene into texture coordinates of its own
        unwrap: UnwrapMode = UnwrapMode::Auto, OptionKind::Name(&[
            ("auto", "Where its own coordinates, in set 1 or else 0, overlap or are missing"),
            ("always", "In any case"),
            ("never", "Never: coordinates that overlap or are missing are refused"),
        ]), "WHEN", "";
        /// With `texels`: empty texels around each chart of a scene that is unwrapped
        padding: u32 = UnwrapOptions::default().padding,
            OptionKind::Whole { least: 0, most: UnwrapOptions::MOST_PADDING as u64, what: "a number of texels" },
            "TEXELS", "";
        /// With `texels`: the side of a texel on the surfaces of a scene that is unwrapped, in its unit of length
        texel_size: Option<f64> = None, OptionKind::Number(NumberRange::Positive), "L",
            "the smallest with which all charts fit";
        /// With `texels`: the largest angle in degrees between a triangle and its chart where the scene is unwrapped:
        /// smaller ones distort less and cut more
        chart_angle: f64 = UnwrapOptions::default().chart_angle, OptionKind::Number(NumberRange::Acute), "DEGREES", "";
        /// With `texels`: whether to average texels that differ by their noise alone
        denoise: bool = FinishOptions::default().denoise, OptionKind::Switch, "SWITCH", "";
        /// Bake the light that arrives at points in space, as matrices: NX × NY × NZ points in the scene's box
        grid: Option<[usize; 3]> = None, OptionKind::Wholes { count: 3, least: 2, most: 4096 }, "NX,NY,NZ", "";
        /// With `grid`: two corners of the box, whose corners are points
        grid_box: Option<[f64; 6]> = None, OptionKind::Numbers(6), "X0,Y0,Z0,X1,Y1,Z1",
            "the scene's box, with points in the middle of as many equal parts";
    }
}

/// Options that ask for splitting where transfer is off.
const OF_ADAPTIVE: [&str; 3] = ["adaptive", "min_edge", "max_vertices"];

/// Options of lightmaps beside their width.
const OF_TEXELS: [&str; 5] = ["unwrap", "padding", "texel_size", "chart_angle", "denoise"];

impl JobOptions for BakeJob {
    fn fields() -> Vec<&'static OptionField> {
        let own = SceneSource::fields().into_iter().chain(Self::FIELDS);
        own.chain(CompressionOptions::FIELDS).chain(WorkOptions::FIELDS).chain(SharingOptions::FIELDS).collect()
    }

    fn heading_of(name: &str) -> Option<&'static str> {
        match name {
            "max_edge" | "no_split" => Some("Splitting"),
            "texels" => Some("Lightmaps"),
            "grid" | "grid_box" => Some("Points in space"),
            name if OF_ADAPTIVE.contains(&name) => Some("Splitting"),
            name if OF_TEXELS.contains(&name) => Some("Lightmaps"),
            name if CompressionOptions::has(name) => CompressionOptions::heading_of(name),
            name if SharingOptions::has(name) => SharingOptions::heading_of(name),
            name if SceneSource::has(name) => SceneSource::heading_of(name),
            _ => None,
        }
    }

    fn contraries(name: &str) -> &'static [&'static str] {
        match name {
            "no_split" => &OF_ADAPTIVE,
            name if OF_ADAPTIVE.contains(&name) => &["no_split"],
            _ => &[],
        }
    }

    fn set_paths(&mut self, given: GivenPaths<'_>) {
        self.source.set_paths(given);
        self.output = given("output").and_then(|paths| paths.into_iter().next()).or(self.output.take());
        self.sharing.set_paths(given);
    }

    fn check_together(&self, given: &Given<'_>) -> Result<(), OptionError> {
        self.source.check_together(given)?;
        self.sharing.check_together(given)?;
        self.check_light(given)?;
        self.check_points(given)?;
        self.check_output(given)
    }
}

fn refused<T>(option: &str, message: &str) -> Result<T, OptionError> {
    Err(OptionError::new(option, message))
}

impl BakeJob {
    /// Options of light that would be ignored.
    fn check_light(&self, given: &Given<'_>) -> Result<(), OptionError> {
        if let Some(option) = given.first_of(&["bounces", "energy_stop"]).filter(|_| !self.mode.reflects()) {
            return refused(option, "only of @mode interreflected and glossy");
        }
        if self.mode == BakeMode::Glossy && self.is_elsewhere() {
            return refused("mode", "glossy light is at vertices only; @grid bakes matrices by itself");
        }
        if self.albedo == Some(AlbedoMode::None) && self.has_matrices() {
            return refused("albedo", "matrices never have the albedo; leave it out");
        }
        match given.first_of(&CompressionOptions::NAMES) {
            Some(option) if self.has_matrices() => refused(option, "of transfer vectors only, not of matrices"),
            Some(option) if self.texels.is_some() => refused(option, "of transfer at vertices, not of @texels"),
            _ => Ok(()),
        }
    }

    /// Options of points that would be ignored, or are of other points.
    fn check_points(&self, given: &Given<'_>) -> Result<(), OptionError> {
        if self.texels.is_some() && self.grid.is_some() {
            return refused("grid", "not with @texels; leave one of them out");
        }
        if self.grid_box.is_some() && self.grid.is_none() {
            return refused("grid_box", "only with @grid");
        }
        if let Some(option) = given.first_of(&OF_TEXELS).filter(|_| self.texels.is_none()) {
            return refused(option, "only with @texels");
        }
        if let Some(option) = given.first_of(&OF_ADAPTIVE).filter(|_| self.no_split) {
            return refused(option, "not with @no_split, by which nothing is split");
        }
        match given.first_of(&["max_edge"]).or(given.first_of(&OF_ADAPTIVE)) {
            Some(option) if self.is_elsewhere() => refused(option, "light is not at vertices with @texels and @grid"),
            _ => Ok(()),
        }
    }

    /// Outputs that cannot hold what is baked.
    fn check_output(&self, given: &Given<'_>) -> Result<(), OptionError> {
        let others =
            given.first_of(&["texels", "grid", "shard", "merge"]).or(given.first_of(&CompressionOptions::NAMES));
        let has_parts = self.parts != TransferParts::Whole;
        for option in [self.backs.then_some("backs"), has_parts.then_some("parts")].into_iter().flatten() {
            if let Some(other) = others {
                return refused(option, &format!("not with @{other}; leave one of them out"));
            }
        }
        if has_parts && self.mode != BakeMode::Interreflected {
            return refused("parts", "only of @mode interreflected, which has reflected light; ask for whole");
        }
        let Some(output) = &self.output else { return Ok(()) };
        let refuse = |message: String| Err(OptionError::new("output", format!("{}: {message}", output.display())));
        if self.backs && !self.is_glb() {
            return refused("backs", "only of a .glb, which holds the sides of its surfaces; leave the option out");
        }
        if has_parts && !self.is_glb() {
            return refused("parts", "only of a .glb; ask for whole");
        }
        if self.is_glb() && self.has_matrices() {
            return refused("output", "@mode glossy and @grid are written as .safetensors");
        }
        let endings: &[&str] = match (self.sharing.shard, self.texels, self.has_matrices()) {
            (Some(_), _, _) | (None, _, true) => &["safetensors"],
            (None, Some(_), false) => &["glb", "safetensors", "exr"],
            (None, None, false) => &["glb", "safetensors"],
        };
        if endings.iter().any(|ending| ends_in(output, ending)) {
            return Ok(());
        }
        let names: Vec<String> = endings.iter().map(|ending| format!(".{ending}")).collect();
        refuse(format!("expected a name that ends in {}", names.join(" or ")))
    }

    /// Whether light is baked at other points than vertices.
    #[must_use]
    pub fn is_elsewhere(&self) -> bool {
        self.texels.is_some() || self.grid.is_some()
    }

    /// Whether results are matrices.
    #[must_use]
    pub fn has_matrices(&self) -> bool {
        self.mode == BakeMode::Glossy || self.grid.is_some()
    }

    /// Whether the output is a scene with its transfer.
    #[must_use]
    pub fn is_glb(&self) -> bool {
        self.output.as_deref().is_some_and(|output| ends_in(output, "glb"))
    }

    /// Whether the user asked for any triangles to be split.
    #[must_use]
    pub fn asks_to_split(&self) -> bool {
        self.max_edge.is_some() || self.asks_to_split_by_error()
    }

    /// Whether that is where transfer is off.
    fn asks_to_split_by_error(&self) -> bool {
        self.adaptive.is_some() || self.min_edge.is_some() || self.max_vertices.is_some()
    }

    /// Whether triangles are split where transfer is off: of a scene that the output holds too, or that of all shards,
    /// which have no output yet.
    #[must_use]
    pub fn is_split(&self) -> bool {
        let has_scene = self.is_glb() || self.sharing.shard.is_some() || self.output.is_none();
        let is_left_open = has_scene && self.mode != BakeMode::Glossy && self.max_edge.is_none() && !self.no_split;
        !self.is_elsewhere() && (is_left_open || self.asks_to_split_by_error())
    }

    /// The limit of memory.
    #[must_use]
    pub fn memory(&self) -> MemoryLimit {
        self.work.memory()
    }

    /// The light paths, for a scene.
    #[must_use]
    pub fn light(&self, scene: &Scene) -> BakeOptions {
        let defaults = BakeOptions::default();
        let own = if self.has_matrices() { defaults.albedo } else { AlbedoMode::of_scene(scene) };
        let mut options = defaults
            .mode(self.mode)
            .order(self.order)
            .bounces(self.bounces)
            .energy_stop(self.energy_stop)
            .seed(self.seed)
            .albedo(self.albedo.unwrap_or(own));
        options.samples = self.samples;
        options
    }

    /// How triangles of a scene are split where transfer is off, by bakes with these light paths.
    ///
    /// # Errors
    /// [`PrtError::OfJob`] if the scene has more vertices than it may have after that.
    pub fn splitting(&self, scene: &Scene, light: BakeOptions) -> Result<AdaptiveOptions, PrtError> {
        let found = scene.vertex_count();
        if self.max_vertices.is_some_and(|most| most < found) {
            let message = format!("expected at least the {found} vertices that the scene begins with");
            return Err(OptionError::new("max_vertices", message).into());
        }
        let defaults = AdaptiveOptions::default().bake(light);
        let error = self.adaptive.unwrap_or(defaults.error);
        Ok(defaults.error(error).min_edge(self.min_edge.map(|edge| edge as f32)).max_vertices(self.max_vertices))
    }

    /// How a scene is unwrapped into so many texels.
    pub(crate) fn unwrapping(&self, width: usize) -> UnwrapOptions {
        UnwrapOptions::default()
            .texels(width)
            .padding(self.padding)
            .texel_size(self.texel_size)
            .chart_angle(self.chart_angle)
    }

    /// Whether an option says how to unwrap.
    pub(crate) fn shapes_charts(&self) -> bool {
        let Self { padding, texel_size, chart_angle, .. } = Self::default();
        (self.padding, self.texel_size, self.chart_angle) != (padding, texel_size, chart_angle)
    }

    /// What is done with texels.
    pub(crate) fn finishing(&self) -> FinishOptions {
        FinishOptions::default().denoise(self.denoise)
    }

    /// How transfer is compressed, if it is.
    #[must_use]
    pub fn compression(&self) -> Option<CompressOptions> {
        self.packing.is_asked().then(|| self.packing.of_transfer())
    }
}

/// Whether the name of a file has this ending, in letters of any case.
pub(crate) fn ends_in(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|found| found.eq_ignore_ascii_case(ending))
}
