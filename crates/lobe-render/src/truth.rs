//! Pictures by the path tracer, with what is known about each pixel.

use std::ops::ControlFlow;

use lobe_scene::{Bvh, Ray, Scene};
use lobe_sh::{Coefficient as _, Dir, Rgb};
use rayon::prelude::*;

use crate::estimate::{SampleCount, Spread};
use crate::path_tracer::{PIXEL_PURPOSE, Seen};
use crate::samples::SampleSet;
use crate::{Camera, DistantLight, PathOptions, PathTracer, Picture, RenderError};

/// How a picture is traced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TruthOptions {
    /// Columns, at least 1.
    pub width: usize,
    /// Rows, at least 1.
    pub height: usize,
    /// Paths for each pixel.
    pub count: SampleCount,
    /// What the paths are made of.
    pub paths: PathOptions,
}

/// A traced picture. Pixels are means over their square, the light showing where rays escape.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth {
    /// Radiance.
    pub mean: Picture,
    /// The variance of [`mean`](Truth::mean), pixel by pixel and channel by channel: the square of its standard error.
    pub variance: Picture,
    /// How many differences the variance was estimated from: the number of sets less one.
    pub degrees_of_freedom: usize,
    /// Base colour of what is seen first; black where nothing is.
    pub albedo: Picture,
    /// Unit normal to shade with, its components as channels, each from -1 to 1; its mean over the pixel.
    pub normal: Picture,
    /// Mean distance from the eye of what is seen, row by row; infinite where nothing is.
    pub depth: Vec<f32>,
    /// Which part of the pixel shows a surface, 0 to 1.
    pub coverage: Vec<f32>,
}

/// What is known about a pixel.
#[derive(Clone, Copy, Debug)]
struct Pixel {
    mean: Rgb<f32>,
    variance: Rgb<f32>,
    albedo: Rgb<f32>,
    normal: Rgb<f32>,
    depth: f32,
    coverage: f32,
}

/// Pixels between two calls of the progress function: seconds at most, and enough for many threads.
const PIXELS_AT_ONCE: usize = 2048;

/// Traces a picture of `scene`, whose tree is `bvh`, under `light`.
///
/// `progress` is told the part that is done, from 0 to 1, and says whether to go on. The same bits for any number of threads.
///
/// # Errors
/// [`RenderError::Options`] if the picture has no pixels or fewer than two sets of paths, [`RenderError::Cancelled`] if
/// `progress` said to stop.
pub fn render_truth(
    scene: &Scene,
    bvh: &Bvh,
    camera: &Camera,
    light: &DistantLight,
    options: &TruthOptions,
    mut progress: impl FnMut(f64) -> ControlFlow<()>,
) -> Result<Truth, RenderError> {
    let TruthOptions { width, height, count, paths } = *options;
    let pixels = width.checked_mul(height).filter(|&n| n > 0);
    let Some(pixels) = pixels else {
        return Err(RenderError::Options(format!("expected a picture with pixels, found {width} x {height}")));
    };
    if count.sets < 2 || count.per_set < 1 {
        let SampleCount { sets, per_set } = count;
        return Err(RenderError::Options(format!(
            "expected at least 2 sets of 1 path, found {sets} of {per_set}: a single one has no variance"
        )));
    }
    let tracer = PathTracer::new(scene, bvh, light, paths);
    let mut traced = Vec::with_capacity(pixels);
    while traced.len() < pixels {
        if progress(traced.len() as f64 / pixels as f64).is_break() {
            return Err(RenderError::Cancelled);
        }
        let next = traced.len()..(traced.len() + PIXELS_AT_ONCE).min(pixels);
        traced.par_extend(next.into_par_iter().map(|i| trace_pixel(&tracer, camera, light, options, i)));
    }
    // What is complete is kept, whatever the last call says.
    let _ = progress(1.0);
    let picture = |of: fn(&Pixel) -> Rgb<f32>| Picture::new(width, height, traced.iter().map(of).collect());
    Ok(Truth {
        mean: picture(|p| p.mean)?,
        variance: picture(|p| p.variance)?,
        degrees_of_freedom: count.sets - 1,
        albedo: picture(|p| p.albedo)?,
        normal: picture(|p| p.normal)?,
        depth: traced.iter().map(|p| p.depth).collect(),
        coverage: traced.iter().map(|p| p.coverage).collect(),
    })
}

fn trace_pixel(
    tracer: &PathTracer<'_>,
    camera: &Camera,
    light: &DistantLight,
    options: &TruthOptions,
    index: usize,
) -> Pixel {
    let TruthOptions { width, height, count, paths } = *options;
    let (x, y) = ((index % width) as f64, (index / width) as f64);
    let mut spread = Spread::default();
    let (mut albedo, mut normal) = (Rgb::<f64>::ZERO, Rgb::<f64>::ZERO);
    let (mut depth, mut hits) = (0.0, 0.0);
    for set in 0..count.sets {
        let samples = SampleSet::new(paths.seed, index as u64, set as u64);
        let mut sum = Rgb::<f64>::ZERO;
        for path in 0..count.per_set {
            let numbers = samples.path(path);
            let [dx, dy] = numbers.pair(PIXEL_PURPOSE);
            let (ray, towards) = eye_ray(camera, width, height, x + dx, y + dy);
            match tracer.see(&ray) {
                None => sum += light.radiance(towards),
                Some(Seen { albedo: a, normal: n, distance, node }) => {
                    albedo += a.widen();
                    normal += Rgb::from(n).widen();
                    depth += distance;
                    hits += 1.0;
                    if let Some(node) = node {
                        sum += tracer.radiance_of(&node, numbers);
                    }
                }
            }
        }
        spread.add(sum.scale((count.per_set as f64).recip()));
    }
    let estimate = spread.estimate();
    let part = (count.total() as f64).recip();
    Pixel {
        mean: Rgb::narrow(estimate.mean),
        variance: Rgb::narrow(estimate.variance),
        albedo: Rgb::narrow(albedo.scale(part)),
        normal: Rgb::narrow(normal.scale(part)),
        depth: if hits > 0.0 { (depth / hits) as f32 } else { f32::INFINITY },
        coverage: (hits * part) as f32,
    }
}

/// The ray through a point of a picture, in pixels from its top left corner, and its direction.
pub(crate) fn eye_ray(camera: &Camera, width: usize, height: usize, x: f64, y: f64) -> (Ray, Dir) {
    let half = 0.5 * height as f64;
    let (origin, towards) = camera.ray((x - 0.5 * width as f64) / half, (half - y) / half);
    (Ray::new(origin.map(|c| c as f32), towards.to_array().map(|c| c as f32)), towards)
}
