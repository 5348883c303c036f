//! Reference pictures by the path tracer: radiance with its variance, and auxiliary channels for each pixel.

use derive_setters::Setters;
use lobe_image::Picture;
use lobe_io::{Fingerprint, Job, Shard};
use lobe_prt::{fingerprint_finish, fingerprint_scene};
use lobe_scene::{Bvh, Scene};
use lobe_sh::{Coefficient as _, Rgb};
use web_time::Instant;

use crate::camera::camera::Camera;
use crate::error::RenderError;
use crate::path_tracer::distant_light::DistantLight;
use crate::path_tracer::emitter::Emitter;
use crate::path_tracer::estimate::{SampleCount, SetMeans};
use crate::path_tracer::path_tracer::{FIRST_PURPOSE, FirstHit, PathStart};
use crate::path_tracer::path_tracer::{PathOptions, PathTracer};
use crate::path_tracer::truth_checkpoint::{PIXEL, TracedPixel, TruthCheckpoint};
use crate::progressive::{in_portions, progress_of};

/// Options of [`render_truth`].
#[derive(Clone, Copy, Debug, PartialEq, Setters)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[non_exhaustive]
pub struct TruthOptions {
    /// Columns, at least 1.
    pub width: usize,
    /// Rows, at least 1.
    pub height: usize,
    /// Paths for each pixel.
    pub count: SampleCount,
    /// Options of the paths.
    pub paths: PathOptions,
}

impl Default for TruthOptions {
    /// A picture of 512 × 384 pixels with 64 paths each.
    fn default() -> Self {
        Self { width: 512, height: 384, count: SampleCount::of(64), paths: PathOptions::default() }
    }
}

/// A traced picture. Pixels are means over their square, [what is behind the light](DistantLight::seen) showing where
/// rays escape.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth {
    /// Radiance.
    pub mean: Picture,
    /// The variance of [`mean`](Truth::mean), pixel by pixel and channel by channel: the square of its standard error.
    pub variance: Picture,
    /// The degrees of freedom of the variance: the number of sets less one.
    pub degrees_of_freedom: usize,
    /// Base color of what is seen first; black where nothing is.
    pub albedo: Picture,
    /// Unit normal to shade with, its components as channels, each from -1 to 1; its mean over the pixel.
    pub normal: Picture,
    /// Mean distance from the eye of what is seen, row by row; infinite where nothing is.
    pub depth: Vec<f32>,
    /// The part of the pixel that shows a surface, 0 to 1; glass by the part of the light that it stops. Before [no
    /// backdrop](crate::Backdrop::None) it is the [alpha](Picture::alpha) of `mean`.
    pub coverage: Vec<f32>,
}

/// The kind of this work among fingerprints.
const KIND: u64 = 17;

/// Traces a picture of `scene`, whose tree is `bvh`, seen by a camera in its world, under `light`.
///
/// The steps of `job` are pixels. It can be [kept in](Job::kept_in) a file: pixels do not depend on each other, so a
/// picture that was stopped has all paths of some pixels and none of the others, and the same call continues to the
/// same bits. The same bits for any number of threads.
///
/// # Errors
/// [`RenderError::Options`] if the picture has no pixels or fewer than two sets of paths, [`RenderError::Cancelled`] if
/// the watch of the job said to stop, [`RenderError::Invalid`] if the file is that of another picture, or none, or in
/// use, [`RenderError::Io`] if it cannot be read or written.
pub fn render_truth(
    scene: &Scene,
    bvh: &Bvh,
    camera: &Camera,
    light: &DistantLight,
    options: &TruthOptions,
    job: Job<'_>,
) -> Result<Truth, RenderError> {
    render_truth_with_emitters(scene, bvh, camera, light, &[], options, job)
}

/// The same under lamps near by, too, which are in the scene's world. They light its surfaces, and are not seen themselves.
///
/// # Errors
/// As [`render_truth`].
pub fn render_truth_with_emitters(
    scene: &Scene,
    bvh: &Bvh,
    camera: &Camera,
    light: &DistantLight,
    emitters: &[Emitter],
    options: &TruthOptions,
    job: Job<'_>,
) -> Result<Truth, RenderError> {
    let traced = trace(scene, bvh, camera, (light, emitters), options, None, job)?;
    // Take the pixels apart into pictures.
    let TruthOptions { width, height, count, .. } = *options;
    let picture = |of: fn(&TracedPixel) -> Rgb<f32>| Picture::new(width, height, traced.iter().map(of).collect());
    let coverage: Vec<f32> = traced.iter().map(|p| p.coverage).collect();
    let mean = picture(|p| p.mean)?;
    Ok(Truth {
        mean: if light.is_transparent() { mean.with_alpha(coverage.clone())? } else { mean },
        variance: picture(|p| p.variance)?,
        degrees_of_freedom: count.sets - 1,
        albedo: picture(|p| p.albedo)?,
        normal: picture(|p| p.normal)?,
        depth: traced.iter().map(|p| p.depth).collect(),
        coverage,
    })
}

/// A shard of the pixels of [`render_truth_with_emitters`], row by row, which stay in the file of the job.
/// [`lobe_io::merge_shards`] makes a checkpoint of the files of all shards, from which that function takes up everything.
///
/// # Errors
/// As [`render_truth`]; [`RenderError::Options`] if the job is not kept in a file.
pub fn render_truth_shard(
    scene: &Scene,
    bvh: &Bvh,
    camera: &Camera,
    (light, emitters): (&DistantLight, &[Emitter]),
    options: &TruthOptions,
    shard: Shard,
    job: Job<'_>,
) -> Result<(), RenderError> {
    if job.checkpoint().is_none() {
        return Err(RenderError::Options("expected a job that is kept in a file, in which the shard stays".to_owned()));
    }
    trace(scene, bvh, camera, (light, emitters), options, Some(shard), job).map(drop)
}

/// All pixels, or those of a shard.
fn trace(
    scene: &Scene,
    bvh: &Bvh,
    camera: &Camera,
    (light, emitters): (&DistantLight, &[Emitter]),
    options: &TruthOptions,
    shard: Option<Shard>,
    mut job: Job<'_>,
) -> Result<Vec<TracedPixel>, RenderError> {
    let pixels = options.check()?;
    let range = shard.unwrap_or(Shard::WHOLE).range(pixels);
    let (first, count) = (range.start, range.len());
    let camera = &camera.relative_to(scene.origin()).outside_of(bvh.bounds());
    // Take up the pixels that are done already.
    let (mut checkpoint, known) = match job.checkpoint() {
        None => (None, Vec::new()),
        Some(path) => {
            let all = fingerprint(scene, camera, (light, emitters), options);
            let (checkpoint, known) = TruthCheckpoint::open(path, &all, pixels, shard)?;
            (Some(checkpoint), known)
        }
    };
    // Trace the others, and keep them while they are found.
    let tracer = PathTracer::new(scene, bvh, light, options.paths).with_emitters(emitters);
    let of = |i: usize| trace_pixel(&tracer, camera, light, options, first + i);
    let (resumed, begin) = (known.len(), Instant::now());
    in_portions(known, count, &of, &mut |done| {
        let progress = progress_of(done.len(), count, resumed, begin);
        // A picture that is complete counts as done, not as stopped.
        let is_stopped = job.report(&progress).is_break() && done.len() < count;
        if let Some(checkpoint) = &mut checkpoint {
            checkpoint.keep(done, is_stopped || done.len() == count)?;
        }
        if is_stopped { Err(RenderError::Cancelled) } else { Ok(()) }
    })
}

impl TruthOptions {
    /// The most bytes that tracing and writing a picture take: the numbers of each pixel four times, traced and on the way to
    /// the checkpoint, or in layers, as channels and compressed (test `work_takes_no_more_memory_than_is_said` of `lobe-cli`).
    #[must_use]
    pub fn bytes(&self) -> u64 {
        (4 * PIXEL as u64).saturating_mul(self.width as u64).saturating_mul(self.height as u64)
    }

    /// The number of pixels.
    fn check(&self) -> Result<usize, RenderError> {
        let Self { width, height, count: SampleCount { sets, per_set }, .. } = *self;
        if sets < 2 || per_set < 1 {
            return Err(RenderError::Options(format!(
                "expected at least 2 sets of 1 path, found {sets} of {per_set}: a single one has no variance"
            )));
        }
        let none = || RenderError::Options(format!("expected a picture with pixels, found {width} x {height}"));
        width.checked_mul(height).filter(|&n| n > 0).ok_or_else(none)
    }
}

/// The fingerprint of everything that decides this picture, as seen from the origin of the scene.
fn fingerprint(
    scene: &Scene,
    camera: &Camera,
    (light, emitters): (&DistantLight, &[Emitter]),
    options: &TruthOptions,
) -> Fingerprint {
    let TruthOptions { width, height, count, paths } = *options;
    let mut all = Fingerprint::of_kind(KIND);
    fingerprint_scene(&mut all, scene);
    scene.materials().iter().for_each(|material| fingerprint_finish(&mut all, scene, material));
    // Three rays determine a camera.
    for (right, up) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)] {
        let (origin, towards) = camera.ray(right, up);
        origin.into_iter().chain(towards.to_array()).for_each(|c| all.word(c.to_bits()));
    }
    light.write_into(&mut all);
    for number in [width, height, count.sets, count.per_set, paths.bounces] {
        all.word(number as u64);
    }
    for number in [paths.strategy as u64, paths.surfaces as u64, paths.seed] {
        all.word(number);
    }
    all.word(emitters.len() as u64);
    emitters.iter().for_each(|emitter| emitter.relative_to(scene.origin()).write_into(&mut all));
    all
}

fn trace_pixel(
    tracer: &PathTracer<'_>,
    camera: &Camera,
    light: &DistantLight,
    options: &TruthOptions,
    index: usize,
) -> TracedPixel {
    let TruthOptions { width, height, count, .. } = *options;
    let (x, y) = ((index % width) as f64, (index / width) as f64);
    let mut means = SetMeans::new(&count);
    let (mut albedo, mut normal) = (Rgb::<f64>::ZERO, Rgb::<f64>::ZERO);
    let (mut depth, mut hits) = (0.0, 0.0);
    tracer.for_each_group(index, &count, |_, numbers| {
        // Find what the eye sees.
        let (rays, towards): (Vec<_>, Vec<_>) = numbers
            .iter()
            .map(|numbers| {
                let [dx, dy] = numbers.pair(FIRST_PURPOSE);
                camera.ray_of_pixel([width, height], [x + dx, y + dy])
            })
            .unzip();
        let seen = tracer.first_hits(&rays);
        // Follow paths from there.
        let mut starts = Vec::with_capacity(seen.len());
        for ((hit, _), &numbers) in seen.iter().zip(numbers) {
            if let Some(FirstHit { interaction: Some(at), .. }) = hit {
                starts.push(PathStart { at, numbers });
            }
        }
        let mut radiance = tracer.radiances(&starts).into_iter();
        for ((hit, tint), towards) in seen.iter().zip(towards) {
            let Some(FirstHit { albedo: a, normal: n, distance, interaction }) = hit else {
                means.add(light.seen(towards) * *tint);
                continue;
            };
            albedo += a.widen();
            normal += Rgb::from(*n).widen();
            depth += distance;
            hits += 1.0;
            let leaves = match interaction {
                Some(at) => at.emission + radiance.next().unwrap_or(Rgb::ZERO),
                None => Rgb::ZERO,
            };
            means.add(leaves * *tint);
        }
    });
    let estimate = means.estimate();
    let part = (count.total() as f64).recip();
    TracedPixel {
        mean: Rgb::narrow(estimate.mean),
        variance: Rgb::narrow(estimate.variance),
        albedo: Rgb::narrow(albedo.scale(part)),
        normal: Rgb::narrow(normal.scale(part)),
        depth: if hits > 0.0 { (depth / hits) as f32 } else { f32::INFINITY },
        coverage: (hits * part) as f32,
    }
}
