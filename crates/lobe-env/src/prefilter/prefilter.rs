//! Prefiltered environment maps for glossy reflection, by the split-sum approximation.
//!
//! # Derivation
//!
//! A surface with the reflectance function `f` and the normal `n` sends towards the eye, in direction `v`,
//!
//! ```text
//!   L_o(v) = ∫ L(l) f(v, l) (n·l) dl
//! ```
//!
//! which depends on `v` and `n`: four angles, too many for a table. For GGX microfacets
//! `f = D(h) F G / (4 (n·v)(n·l))`, with `h` half-way between `v` and `l`. [Karis 2013] splits the integral into two
//! factors, the mean of the light over the lobe, and the reflectance in uniform light:
//!
//! ```text
//!   L_o(v) ≈ g · R_A        g = ∫ L(l) w(l) dl / ∫ w(l) dl        R_A = ∫ f(v, l) (n·l) dl = F₀ A + B
//!
//!   A = `Dfg::scale`, B = `Dfg::bias`
//! ```
//!
//! 1. For the first factor assume a view along the normal: `v = n`, hence the reflected view `r` is `n`, too.
//!    The lobe is then radially symmetric about `r`, and the factor a function of `r` and of the roughness alone.
//! 2. Light is weighted as importance sampling of `D` weights it, by `n·l`. A facet normal `h` is drawn with the
//!    density `D(h) (n·h)`, and `l` is `n` reflected at `h`, with `dl = 4 (h·l) dh` and here `h·l = n·h`; so the
//!    density of `l` is `D(h)/4`, and `w(l) = D(h) (n·l)`, up to a constant that cancels.
//! 3. The second factor needs no light: [`dfg()`](crate::dfg()) is a table of two numbers for each view and roughness.
//!
//! For each level of the chain, with its `α`, the prefiltered radiance is therefore
//!
//! ```text
//!                 ∫ L(l) D_α(h) max(r·l, 0) dl                r + l
//!        g(r)  =  ────────────────────────────          h = ───────
//!                   ∫ D_α(h) max(r·l, 0) dl                 |r + l|
//! ```
//!
//! It is exact for uniform light, and for a surface seen along its normal except for the masking `G`.
//!
//! [Karis 2013]: https://blog.selfshadow.com/publications/s2013-shading-course/karis/s2013_pbs_epic_notes_v2.pdf

use std::ops::ControlFlow;

use lobe_image::mip_level_size;
use lobe_io::{Job, Progress, parallel};
use lobe_sh::{Coefficient, Dir, Rgb};
use web_time::Instant;

use crate::error::EnvError;
use crate::map::cube_average::averaged_to;
use crate::map::cube_map::CubeMap;
use crate::map::cube_mip_chain::CubeMipChain;
use crate::map::env_map::EnvMap;
use crate::map::finite::{all_finite, expect_finite};
use crate::map::mapped_map::MappedMap;
use crate::mapping::cube::FACES;
use crate::mapping::mapping::Mapping;
use crate::prefilter::brightness::Brightness;
use crate::prefilter::cell_tolerance::CellTolerance;
use crate::prefilter::cell_tree::CellTree;
use crate::prefilter::gather::{Shape, ZonalFilter, filter_tiles, is_mirror, shapes, texel_side, tiles};
use crate::prefilter::options::PrefilterOptions;
use crate::prefilter::options::check_tolerance;
use crate::reflection::specular_lobe::SpecularLobe;
use crate::reflection::specular_lobe::{CustomKernel, GgxKernel, Kernel, PowerKernel, integral};

/// The name of the sums in messages.
const FILTERED: &str = "the filtered light";

/// Tiles between two calls of a progress callback.
const TILES_TOGETHER: usize = 64;

/// The same for directions; a multiple of the four that share their cells.
const DIRS_TOGETHER: usize = 4096;

/// Prefilters a cube map with GGX lobes of increasing roughness.
///
/// ```text
///   level k:  g(r) = ∫ L(l) D(h) max(r·l, 0) dl / ∫ D(h) max(r·l, 0) dl        h half-way between r and l
///   roughness ρ_k = k/(levels - 1), α = ρ_k²        (RoughnessLevels::Linear)
/// ```
///
/// This is the first sum of the **split-sum approximation** ([Karis 2013]): normal, view and reflected view are assumed
/// to be one direction `r`, light is weighted with `n·l`, and the sum is divided by its weights, so the white furnace
/// is 1 in every texel of every level (test `the_white_furnace_is_exactly_one`). A shader multiplies it by the second
/// sum,
///
/// ```text
///   reflected(v, n) ≈ g(r) (F₀ A + B)        r = 2 (n·v) n - v        A, B of `dfg`(n·v, α)
/// ```
///
/// which is exact in uniform light; elsewhere the error is largest at grazing angles, where the true lobe is not
/// radially symmetric (test `the_split_sum_is_exact_in_even_light_and_near_it_elsewhere` has numbers).
///
/// Level 0 is the mirror: the source averaged over each texel. In every level the value of a texel is that of the
/// direction of its center. Linear in the source up to the tolerance; the same bits for any number of threads.
///
/// Progress counts texels of all levels, on the calling thread. The job cannot be resumed.
///
/// # Errors
/// [`EnvError::Options`] for a size of 0 or of too many texels, a last size beyond the first, a tolerance out of
/// its range, sums over finite light that are more than `f32` holds, or a job with a checkpoint; [`EnvError::Cancelled`] if
/// the callback cancelled it.
///
/// ```
/// use lobe_env::{CubeMap, PrefilterOptions, prefilter_ggx};
/// use lobe_io::Job;
/// use lobe_sh::{Coefficient as _, Rgb};
///
/// let sky = CubeMap::from_fn(32, |s| Rgb::splat(if s.z() > 0.9 { 10.0 } else { 0.5 }));
/// let options = PrefilterOptions::default().size(32).last_size(8);
/// let chain = prefilter_ggx(&sky, &options, Job::default())?;
/// assert_eq!(chain.levels().len(), 3);
/// assert_eq!(options.roughness.level_for_roughness(0.5, 3), 1.0);
/// # Ok::<(), lobe_env::EnvError>(())
/// ```
///
/// [Karis 2013]: https://blog.selfshadow.com/publications/s2013-shading-course/karis/s2013_pbs_epic_notes_v2.pdf
pub fn prefilter_ggx(source: &CubeMap, options: &PrefilterOptions, mut job: Job<'_>) -> Result<CubeMipChain, EnvError> {
    options.check()?;
    job.expect_no_checkpoint().map_err(EnvError::Options)?;
    // Share what all levels need: the tree of the source to the depth that the narrowest lobe asks for, or its levels.
    let count = options.levels();
    let size = |k: usize| mip_level_size(options.size, k);
    let alphas: Vec<f64> = (1..count).map(|k| options.alpha_of_level(k)).collect();
    let quadrature = Quadrature::new(source, options.tolerance, alphas.iter().map(|alpha| GgxKernel::new(*alpha)));
    let work = |k: usize| FACES * size(k) * size(k);
    let mut report = reporter(&mut job, (1..count).map(work).sum());
    // Average the source over the texels of the mirror's level.
    let mut levels = vec![averaged_to(source, options.size)];
    // Average it with the lobe of each rougher level.
    let mut before = 0;
    for (k, alpha) in (1..).zip(&alphas) {
        let mut part = |p: f64| report(before as f64 + p * work(k) as f64);
        levels.push(quadrature.filter(GgxKernel::new(*alpha), size(k), &mut part)?);
        before += work(k);
    }
    CubeMipChain::new(levels)
}

/// Tells whoever watches a job how many of `total` texels are done.
fn reporter(job: &mut Job<'_>, total: usize) -> impl FnMut(f64) -> ControlFlow<()> {
    let start = Instant::now();
    move |done| job.report(&Progress { done: done as usize, total, elapsed: start.elapsed(), ..Progress::default() })
}

/// Convolves a cube map with one lobe: for [`SpecularLobe::Phong`] and [`SpecularLobe::BlinnPhong`] a highlight map.
///
/// Integrated to `tolerance`; see [`PrefilterOptions::tolerance`], whose default serves here, too. The lobe integrates
/// to 1, so a constant map stays the same; see [`SpecularLobe::integral`] for the other normalization. A lobe far narrower than the source's texels gives the source averaged over each texel.
///
/// Progress counts texels of the result, on the calling thread. The job cannot be resumed.
///
/// # Errors
/// [`EnvError::Options`] if the lobe's parameter or the tolerance is out of its range, there can be no cube of this
/// size, sums over finite light are more than `f32` holds, or the job has a checkpoint; [`EnvError::Cancelled`] if the
/// callback cancelled it.
pub fn filter_lobe(
    source: &CubeMap,
    lobe: SpecularLobe,
    size: usize,
    tolerance: f64,
    job: Job<'_>,
) -> Result<CubeMap, EnvError> {
    lobe.check()?;
    match lobe {
        SpecularLobe::Ggx { alpha } => filter(source, || GgxKernel::new(alpha), size, tolerance, job),
        SpecularLobe::Phong { exponent } => filter(source, || PowerKernel::phong(exponent), size, tolerance, job),
        SpecularLobe::BlinnPhong { exponent } => filter(source, || PowerKernel::blinn(exponent), size, tolerance, job),
    }
}

/// Convolves a cube map with a radially symmetric kernel, a function of the cosine to the texel's direction.
///
/// ```text
///   g(r) = ∫ L(s) k(r·s) ds / ∫ k(r·s) ds
/// ```
///
/// Integrated to `tolerance`; see [`PrefilterOptions::tolerance`]. The kernel should be highest on its axis;
/// discontinuities and kinks cost time, and away from the horizon digits of the normalization. The job is that of
/// [`filter_lobe`].
///
/// # Errors
/// [`EnvError::Options`] if there can be no cube of this size, the tolerance is out of its range, the kernel has no
/// positive integral or no positive value at 1, sums over finite light are more than `f32` holds, or the job has a
/// checkpoint; [`EnvError::Cancelled`] if the callback cancelled it.
pub fn filter_zonal(
    source: &CubeMap,
    size: usize,
    tolerance: f64,
    kernel: impl Fn(f64) -> f64 + Sync,
    job: Job<'_>,
) -> Result<CubeMap, EnvError> {
    let total = integral(&CustomKernel(&kernel));
    if !(total > 0.0 && total.is_finite() && kernel(1.0) > 0.0) {
        let message =
            format!("a kernel must be positive on its axis and on the whole, but it is {} and {total}", kernel(1.0));
        return Err(EnvError::Options(message));
    }
    filter(source, || CustomKernel(&kernel), size, tolerance, job)
}

/// Convolves a cube map with a lobe, as a lat-long map of `width` x `height`, integrated to `tolerance`. The job is that of
/// [`filter_lobe`].
///
/// # Errors
/// [`EnvError::Options`] if the lobe's parameter or the tolerance is out of its range, there can be no picture of
/// this size, sums over finite light are more than `f32` holds, or the job has a checkpoint; [`EnvError::Cancelled`] if
/// the callback cancelled it.
pub fn filter_lobe_lat_long(
    source: &CubeMap,
    lobe: SpecularLobe,
    [width, height]: [usize; 2],
    tolerance: f64,
    mut job: Job<'_>,
) -> Result<EnvMap, EnvError> {
    job.expect_no_checkpoint().map_err(EnvError::Options)?;
    lobe.check()?;
    check_tolerance(tolerance)?;
    MappedMap::check(Mapping::LatLong, width, height)?;
    let mut out = EnvMap::from_rows(width, height, vec![Rgb::ZERO; width * height]);
    let dirs: Vec<Dir> = (0..width * height).map(|i| out.dir(i % width, i / width)).collect();
    let job = &mut job;
    let texels = match lobe {
        SpecularLobe::Ggx { alpha } => gather_towards(source, &|| GgxKernel::new(alpha), &dirs, tolerance, job),
        SpecularLobe::Phong { exponent } => {
            gather_towards(source, &|| PowerKernel::phong(exponent), &dirs, tolerance, job)
        }
        SpecularLobe::BlinnPhong { exponent } => {
            gather_towards(source, &|| PowerKernel::blinn(exponent), &dirs, tolerance, job)
        }
    }?;
    out.texels_mut().copy_from_slice(&texels);
    Ok(out)
}

fn gather_towards<K: Kernel>(
    source: &CubeMap,
    kernel: &impl Fn() -> K,
    dirs: &[Dir],
    tolerance: f64,
    job: &mut Job<'_>,
) -> Result<Vec<Rgb<f32>>, EnvError> {
    if is_mirror(&kernel(), source.size()) {
        return mirror_towards(source, dirs, job);
    }
    let quadrature = Quadrature::new(source, tolerance, std::iter::once(kernel()));
    let filter = quadrature.zonal_filter(kernel());
    let mut report = reporter(job, dirs.len());
    let mut texels = Vec::with_capacity(dirs.len());
    for part in dirs.chunks(DIRS_TOGETHER) {
        go_on(report(texels.len() as f64))?;
        let fours: Vec<&[Dir]> = part.chunks(4).collect();
        let found = parallel::map(fours.len(), &|k| filter.towards(fours[k]));
        texels.extend(found.into_iter().flatten());
    }
    go_on(report(texels.len() as f64))?;
    expect_finite(&texels, FILTERED, || all_finite(source.texels()))?;
    Ok(texels)
}

/// The light of a mirror towards each direction.
fn mirror_towards(source: &CubeMap, dirs: &[Dir], job: &mut Job<'_>) -> Result<Vec<Rgb<f32>>, EnvError> {
    let mut report = reporter(job, dirs.len());
    go_on(report(0.0))?;
    let texels: Vec<_> = dirs.iter().map(|s| source.radiance(*s)).collect();
    go_on(report(texels.len() as f64))?;
    // The weights of an interpolation may sum to a little more than 1.
    expect_finite(&texels, FILTERED, || all_finite(source.texels()))?;
    Ok(texels)
}

fn go_on(flow: ControlFlow<()>) -> Result<(), EnvError> {
    if flow.is_break() { Err(EnvError::Cancelled) } else { Ok(()) }
}

fn filter<K: Kernel>(
    source: &CubeMap,
    kernel: impl Fn() -> K,
    size: usize,
    tolerance: f64,
    mut job: Job<'_>,
) -> Result<CubeMap, EnvError> {
    job.expect_no_checkpoint().map_err(EnvError::Options)?;
    check_tolerance(tolerance)?;
    CubeMap::check_size(size)?;
    let texels = FACES * size * size;
    let mut report = reporter(&mut job, texels);
    let mut part = |p: f64| report(p * texels as f64);
    Quadrature::new(source, tolerance, std::iter::once(kernel())).filter(kernel(), size, &mut part)
}

/// What all levels share: the tree of the source, and how exact its cells have to be.
struct Quadrature<'a> {
    tree: CellTree<'a>,
    shapes: Vec<Vec<Shape>>,
    brightness: Brightness,
    tolerance: f64,
}

impl<'a> Quadrature<'a> {
    fn new<K: Kernel>(source: &'a CubeMap, tolerance: f64, kernels: impl Iterator<Item = K>) -> Self {
        let last = CellTree::last_depth(source.size());
        let brightness = Brightness::new(source, last);
        let blurring = kernels.filter(|kernel| !is_mirror(kernel, source.size()));
        let depth_for =
            |kernel| cell_tolerance(source, &kernel, tolerance, &brightness).depth_needed(brightness.steps(), last);
        let depth = blurring.map(depth_for).max().unwrap_or(0);
        Self { tree: CellTree::new(source, depth), shapes: shapes(depth), brightness, tolerance }
    }

    fn zonal_filter<K: Kernel>(&self, kernel: K) -> ZonalFilter<'_, K> {
        let cells = cell_tolerance(self.tree.source, &kernel, self.tolerance, &self.brightness);
        ZonalFilter::new(&self.tree, &self.shapes, &self.brightness, kernel, cells)
    }

    fn filter<K: Kernel>(
        &self,
        kernel: K,
        size: usize,
        progress: &mut dyn FnMut(f64) -> ControlFlow<()>,
    ) -> Result<CubeMap, EnvError> {
        let source = self.tree.source;
        if is_mirror(&kernel, source.size()) {
            go_on(progress(0.0))?;
            let mirror = averaged_to(source, size);
            go_on(progress(1.0))?;
            return Ok(mirror);
        }
        let filter = self.zonal_filter(kernel);
        let (side, tiles) = tiles(size);
        let mut out = vec![Rgb::ZERO; FACES * size * size];
        for (k, chunk) in tiles.chunks(TILES_TOGETHER).enumerate() {
            go_on(progress((k * TILES_TOGETHER) as f64 / tiles.len() as f64))?;
            filter_tiles(size, side, chunk, &mut out, &|dirs| filter.towards(dirs));
        }
        go_on(progress(1.0))?;
        expect_finite(&out, FILTERED, || all_finite(source.texels()))?;
        CubeMap::new(size, out)
    }
}

fn cell_tolerance(source: &CubeMap, kernel: &impl Kernel, tolerance: f64, brightness: &Brightness) -> CellTolerance {
    CellTolerance::new(kernel, tolerance, CellTree::last_depth(source.size()), texel_side(source), brightness.steps())
}
