//! Unwrapping by charts, those of all meshes in one picture.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread;
use std::time::Duration;

use lobe_io::{Job, Progress};
use uvunwrap::{Atlas, Density, Error, MeshInput, Options, OutputMesh, Stage};

use crate::error::SceneError;
use crate::scene::mesh::Mesh;
use crate::scene::scene::{Bounds, Scene};
use crate::unwrap::options::UnwrapOptions;

/// The time between two looks at the progress.
const LOOK: Duration = Duration::from_millis(20);

/// Bytes while a triangle is unwrapped, with its share of the vertices.
///
/// Measured: some 300 of a smooth surface of 500 000 triangles; where each has a chart of its own there is more.
const BYTES_OF_TRIANGLE: u64 = 1000;

/// A report of [`Scene::unwrapped`].
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct UnwrapReport {
    /// Pieces of the surfaces that are flattened one by one.
    pub charts: usize,
    /// Vertices before.
    pub vertices_before: usize,
    /// Vertices after: those at the border of charts are there once for each.
    pub vertices: usize,
    /// The side of a texel on a surface, in the unit of the scene.
    pub texel_size: f64,
    /// The part of the picture that shows surfaces, without what lies between charts.
    pub coverage: f64,
}

impl Scene {
    /// The most bytes that unwrapping takes beside the scene and its copy.
    #[must_use]
    pub fn bytes_to_unwrap(&self, options: &UnwrapOptions) -> u64 {
        let texels = (options.texels as u64).saturating_pow(2);
        texels + BYTES_OF_TRIANGLE * self.triangle_count() as u64
    }

    /// The scene with texture coordinates for a lightmap: each triangle of each mesh has a place of its own in one
    /// square picture.
    ///
    /// Surfaces are cut into charts, each is flattened by least squares conformal maps [Levy 2002] and then made
    /// as rigid as possible [Liu 2008], and all are packed with their padding. The crate uvunwrap does it; its
    /// results are the same on every machine, whatever the number of threads. The coordinates are the first set that a
    /// mesh does not have, so that textures keep theirs. Vertices at the border of charts are there once for each, with
    /// all their attributes; triangles keep their order. Meshes that are shown several times have a place for each.
    ///
    /// The scene is unwrapped as if its longest side were between 1 and 2: its scale changes nothing. Triangles too
    /// thin for a chart have no area in the picture, and show the nearest texel.
    ///
    /// The steps of `job` are triangles that are flattened. It cannot be kept in a file.
    ///
    /// # Errors
    /// [`SceneError::Options`] if an option is out of range, or if the charts with their padding do not fit into so
    /// many texels; [`SceneError::Cancelled`] if the watch of the job said to stop.
    pub fn unwrapped(&self, options: &UnwrapOptions, job: Job<'_>) -> Result<(Self, UnwrapReport), SceneError> {
        options.check()?;
        job.expect_no_checkpoint().map_err(SceneError::Options)?;
        let scale = unit_scale(self.bounds());
        let scaled: Vec<Vec<[f32; 3]>> =
            self.meshes().iter().map(|mesh| mesh.positions().iter().map(|p| p.map(|c| c * scale)).collect()).collect();
        let inputs: Vec<MeshInput<'_>> = scaled
            .iter()
            .zip(self.meshes())
            .map(|(positions, mesh)| MeshInput::new(positions, mesh.triangles().as_flattened()))
            .collect();
        let atlas = watched(&inputs, &settings(options, scale), self.triangle_count(), job)
            .map_err(|error| refusal(&error, options))?;
        if atlas.page_count > 1 {
            return Err(too_small(options, atlas.chart_count as usize));
        }
        let side = options.texels as f64;
        let part = [atlas.width, atlas.height].map(|texels| f64::from(texels) / side);
        let meshes = self.meshes().iter().zip(&atlas.meshes).map(|(mesh, found)| placed(mesh, found, part)).collect();
        let (_, materials, textures) = self.clone().into_parts();
        let unwrapped = Self::new(meshes, materials, textures)?.moved(self.origin());
        let report = UnwrapReport {
            charts: atlas.chart_count as usize,
            vertices_before: self.vertex_count(),
            vertices: unwrapped.vertex_count(),
            texel_size: 1.0 / (f64::from(atlas.texels_per_unit) * f64::from(scale)),
            coverage: f64::from(atlas.utilization) * part[0] * part[1],
        };
        Ok((unwrapped, report))
    }
}

/// A power of two, by which products are exact, that makes the longest side of a box 1 to 2.
fn unit_scale(Bounds { min, max }: Bounds) -> f32 {
    /// The digits of an `f32` after the first.
    const DIGITS: u32 = 23;
    /// What is added to its exponent.
    const BIAS: u32 = 127;
    let longest = (0..3).map(|k| max[k] - min[k]).fold(0.0, f32::max);
    // From the exponents of numbers whose inverses are normal ones, too.
    let exponent = (longest.to_bits() >> DIGITS).clamp(1, 2 * BIAS - 1);
    f32::from_bits((2 * BIAS - exponent) << DIGITS)
}

fn settings(options: &UnwrapOptions, scale: f32) -> Options {
    let page_size = options.texels as u32;
    let density = match options.texel_size {
        None => Density::Auto { page_size },
        Some(size) => {
            let texels_per_unit = (1.0 / (size * f64::from(scale))) as f32;
            Density::Fixed { texels_per_unit, page_size: Some(page_size) }
        }
    };
    Options { density, padding: options.padding, max_chart_angle: options.chart_angle as f32, ..Options::default() }
}

/// Unwraps while the job is told how far it is: from one thread, as it cannot be told from others.
fn watched(inputs: &[MeshInput<'_>], options: &Options, total: usize, mut job: Job<'_>) -> Result<Atlas, Error> {
    let (done, is_stopped) = (AtomicUsize::new(0), AtomicBool::new(false));
    let callback = |progress: uvunwrap::Progress| {
        let reached = match progress.stage {
            Stage::Segmenting => 0,
            Stage::Parameterizing => progress.done.min(total),
            _ => total,
        };
        done.store(reached, Ordering::Relaxed);
        !is_stopped.load(Ordering::Relaxed)
    };
    let work = || uvunwrap::generate_with_progress(inputs, options, callback);
    // A page has one thread.
    if cfg!(target_family = "wasm") {
        return work();
    }
    let begin = web_time::Instant::now();
    let mut look = |done: usize| {
        let progress = Progress { done, total, elapsed: begin.elapsed(), ..Progress::default() };
        if job.report(&progress).is_break() {
            is_stopped.store(true, Ordering::Relaxed);
        }
    };
    look(0);
    let atlas = thread::scope(|scope| {
        let worker = scope.spawn(work);
        while !worker.is_finished() {
            thread::sleep(LOOK);
            look(done.load(Ordering::Relaxed).min(total.saturating_sub(1)));
        }
        worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })?;
    look(total);
    if is_stopped.load(Ordering::Relaxed) { Err(Error::Cancelled) } else { Ok(atlas) }
}

/// A mesh with the coordinates that were found, which count in parts of a page.
fn placed(mesh: &Mesh, found: &OutputMesh, part: [f64; 2]) -> Mesh {
    let from: Vec<u32> = found.vertices.iter().map(|vertex| vertex.xref).collect();
    let uv = |uv: [f32; 2]| [0, 1].map(|k| (f64::from(uv[k]) * part[k]) as f32);
    let uvs = found.vertices.iter().map(|vertex| uv(vertex.uv)).collect();
    let triangles = found.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
    mesh.clone().with_lightmap(&from, triangles, uvs)
}

fn refusal(error: &Error, options: &UnwrapOptions) -> SceneError {
    match error {
        Error::Cancelled => SceneError::Cancelled,
        Error::ChartTooLarge { .. } | Error::AtlasTooLarge { .. } => too_small(options, 1),
        Error::InvalidOption { option: "density.page_size", .. } => too_small(options, 1),
        other => SceneError::Options(format!("unwrapping: {other}")),
    }
}

/// The refusal of a picture into which charts do not fit.
fn too_small(options: &UnwrapOptions, charts: usize) -> SceneError {
    let UnwrapOptions { texels, padding, texel_size, .. } = options;
    let less = match texel_size {
        Some(_) => "larger texels, or less padding",
        None => "or less padding",
    };
    let plural = if charts == 1 { "a chart" } else { &format!("{charts} charts") };
    SceneError::Options(format!(
        "{plural} with a padding of {padding} texels would not fit into {texels} x {texels}: more texels, {less}"
    ))
}
