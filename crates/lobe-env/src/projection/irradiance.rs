//! Irradiance of a map for every normal, by spherical harmonics and by brute force.

use std::f64::consts::PI;

use lobe_io::{Job, Progress, parallel};
use lobe_sh::filter::convolve_in_place;
use lobe_sh::simd::Machine;
use lobe_sh::{Coefficient, Dir, Expansion, Rgb, ShVec, Zonal};
use pulp::NullaryFnOnce;
use web_time::Instant;

use crate::error::EnvError;
use crate::map::cube_map::CubeMap;
use crate::map::env_map::EnvMap;
use crate::map::finite::{all_finite, expect_finite};
use crate::map::mapped_map::MappedMap;
use crate::mapping::lat_long::sin_cos_pi;
use crate::mapping::mapping::Mapping;
use crate::projection::horizon::Horizon;
use crate::projection::project_map::project_map;
use crate::projection::reconstruct::reconstruct;

/// Partial sums kept side by side: a register of 256 bits for each channel, or two of 128.
const LANES: usize = 8;

/// Additions in each lane before its sum is widened to `f64`: more of them would cost digits (16384 columns in one
/// run: 8e-6 of a constant sky), fewer would cost time.
const RUN: usize = 32;

/// The least columns: those of a map with fewer are split. By two Gauss nodes the horizon is followed through an eighth
/// of a turn, but not through half of one.
const LEAST_COLUMNS: usize = 8;

/// The irradiance `E` of a surface that faces each of `normals`, by summing over all texels.
///
/// ```text
///   E(n) = ∫ L(s) max(n·s, 0) ds  ≈  Σ_texels L max(n·V, 0)        V = ∫_texel s ds
/// ```
///
/// `V` is exact, so a texel wholly above or below the horizon of `n` counts exactly. A texel that the horizon cuts is
/// clipped: its part above the horizon counts half of `n·V` and half of `∫ |n·s| ds`, which is in closed form in one
/// dimension and by two Gauss nodes in the other. So `E(n) - E(-n)` is `n·e` of the
/// [`vector_irradiance`](crate::vector_irradiance()) up to rounding, however large the texels
/// (`the_net_irradiance_is_the_difference_of_both_sides`). `E` of a constant sky is `π` to 5e-5 with 16 rows (test
/// `brute_force_irradiance_of_a_constant_sky_is_pi`). Columns wider than an eighth of a turn are split: with few columns
/// and 64 rows it is `π` to 5e-5, with a single row to 1.5e-2 (test `few_columns_see_a_constant_sky_too`). `1/π` is not
/// included.
///
/// The cost is four multiply-adds and a maximum for each texel and normal: with
///
/// ```text
///   V = δ (a_y c cos φ_x, a_y c sin φ_x, b_y)
///   a_y = ∫_row sin²θ dθ      b_y = ∫_row sin θ cos θ dθ      c = sin(π/w)/(π/w)      δ = 2π/w
/// ```
///
/// `n·V` is `a_y h_x + n_z b_y δ`, where `h_x` depends on the normal and the column alone. Short runs of each row are
/// summed in `f32` and added up in `f64`, with a relative rounding error below 1e-6 (test `long_rows_lose_no_digits`).
/// In parallel over the normals; the same bits for any number of threads.
#[must_use]
pub fn irradiance_at(map: &EnvMap, normals: &[Dir]) -> Vec<Rgb<f64>> {
    let texels = Texels::new(map);
    texels.towards(normals)
}

/// Normals between two reports of progress.
const REPORTED: usize = 1024;

/// The name of the sums in messages.
const IRRADIANCE: &str = "the irradiance";

/// The irradiance towards the texel centers of a map of `width` x `height`, by summing over all texels of `map`.
///
/// The slow reference for [`irradiance_map`]; see [`irradiance_at`]. Progress counts texels of the result, on the calling
/// thread. The job cannot be resumed.
///
/// # Errors
/// [`EnvError::Options`] if a side is 0 or there are more texels than a map may have, if the irradiance of finite light
/// is more than `f32` holds, or for a job with a checkpoint; [`EnvError::Cancelled`] if the callback cancelled it.
pub fn irradiance_map_brute_force(
    map: &EnvMap,
    width: usize,
    height: usize,
    mut job: Job<'_>,
) -> Result<EnvMap, EnvError> {
    job.expect_no_checkpoint().map_err(EnvError::Options)?;
    MappedMap::check(Mapping::LatLong, width, height)?;
    let mut out = EnvMap::new(width, height, vec![Rgb::ZERO; width * height])?;
    let (start, total) = (Instant::now(), width * height);
    let mut report = |done| {
        let stop = job.report(&Progress { done, total, elapsed: start.elapsed(), ..Progress::default() }).is_break();
        if stop { Err(EnvError::Cancelled) } else { Ok(()) }
    };
    let texels = Texels::new(map);
    for first in (0..total).step_by(REPORTED) {
        report(first)?;
        let part = first..total.min(first + REPORTED);
        let normals: Vec<Dir> = part.clone().map(|i| out.dir(i % width, i / width)).collect();
        for (texel, irradiance) in out.texels_mut()[part].iter_mut().zip(texels.towards(&normals)) {
            *texel = Rgb::narrow(irradiance);
        }
    }
    report(total)?;
    expect_finite(out.texels(), IRRADIANCE, || all_finite(map.texels()))?;
    Ok(out)
}

/// The irradiance towards the texel centers of a cube of faces of `size`, by the expansion of `order` bands.
///
/// # Errors
/// [`EnvError::Options`] if there can be no cube of this size.
pub fn irradiance_cube(map: &MappedMap, order: usize, size: usize) -> Result<CubeMap, EnvError> {
    CubeMap::check_size(size)?;
    let irradiance = irradiance_sh(map, order);
    let cube = CubeMap::from_fn(size, |n| Rgb::narrow(irradiance.eval(n)));
    expect_finite(cube.texels(), IRRADIANCE, || all_finite(map.texels()))?;
    Ok(cube)
}

/// The expansion of the irradiance: the radiance convolved with the clamped cosine. `1/π` is not included.
///
/// ```text
///   E_lm = A_l L_lm        A = π, 2π/3, π/4, 0, -π/24, 0, ..
/// ```
///
/// From the map's own texels, in any mapping; see [`project_map`](crate::project_map()).
#[must_use]
pub fn irradiance_sh(map: &MappedMap, order: usize) -> ShVec<Rgb<f64>> {
    let mut f = project_map(map, order);
    convolve_in_place(f.coefficients_mut(), &Zonal::clamped_cosine(order));
    f
}

/// The irradiance towards the texel centers of a lat-long map of `width` x `height`, by spherical harmonics of `order`.
///
/// # Errors
/// [`EnvError::Options`] if a side is 0 or there are more texels than a map may have, or if the irradiance of finite light
/// is more than `f32` holds: it is up to π times the light.
pub fn irradiance_map(map: &MappedMap, order: usize, width: usize, height: usize) -> Result<EnvMap, EnvError> {
    MappedMap::check(Mapping::LatLong, width, height)?;
    let out = reconstruct(&irradiance_sh(map, order), width, height);
    expect_finite(out.texels(), IRRADIANCE, || all_finite(map.texels()))?;
    Ok(out)
}

/// The texels as planes, with the factors of `n·V`; columns of a map with fewer than [`LEAST_COLUMNS`] in equal parts.
struct Texels {
    width: usize,
    /// `width` rounded up to [`LANES`]; the rest of each row is black.
    stride: usize,
    /// Red, green and blue, row after row.
    planes: [Vec<f32>; 3],
    /// `δ a_y c` and `δ b_y` of every row.
    rows: Vec<(f64, f64)>,
    /// `cos φ_x` and `sin φ_x` of every column.
    columns: Vec<(f64, f64)>,
    horizon: Horizon,
}

impl Texels {
    fn new(map: &EnvMap) -> Self {
        let parts = LEAST_COLUMNS.div_ceil(map.width());
        let (width, height) = (parts * map.width(), map.height());
        let stride = width.next_multiple_of(LANES);
        let mut planes = [(); 3].map(|()| vec![0.0; stride * height]);
        for y in 0..height {
            let row = map.row(y);
            for x in 0..width {
                for (plane, channel) in planes.iter_mut().zip(row[x / parts].to_array()) {
                    plane[y * stride + x] = channel;
                }
            }
        }
        let columns = (0..width).map(|x| {
            let (sin, cos) = sin_cos_pi((width as f64 - 2.0 * x as f64 - 1.0) / width as f64);
            (cos, sin)
        });
        let horizon = Horizon::new(width, height);
        Self { width, stride, planes, rows: row_vectors(width, height), columns: columns.collect(), horizon }
    }

    /// `E(n)` for every normal, in parallel.
    fn towards(&self, normals: &[Dir]) -> Vec<Rgb<f64>> {
        let towards = |scratch: &mut Vec<f32>, k: usize| self.irradiance(normals[k], scratch);
        parallel::map_with(normals.len(), &|| vec![0.0_f32; self.stride], &towards)
    }

    /// `E(n)`; `scratch` has `stride` places.
    fn irradiance(&self, n: Dir, scratch: &mut [f32]) -> Rgb<f64> {
        for (h, (cos, sin)) in scratch.iter_mut().zip(&self.columns) {
            *h = (n.x() * cos + n.y() * sin) as f32;
        }
        let mut sum = Machine::detect().arch().dispatch(WholeTexels { texels: self, h: scratch, n_z: n.z() });
        debug_assert!(scratch.len() >= self.width, "the padding is black, whatever its cosine");
        // The sum took all light of a texel that the horizon cuts from the texel's mean direction: replace that by the
        // clipped one.
        self.horizon.for_each_cut(n, |x, y, both| {
            let ((a, b), (cos, sin)) = (self.rows[y], self.columns[x]);
            let taken = a * (n.x() * cos + n.y() * sin) + n.z() * b;
            let texel = Rgb::from([0, 1, 2].map(|c| f64::from(self.planes[c][y * self.stride + x])));
            // (both + taken)/2 - max(taken, 0)
            sum += texel.scale(0.5 * (both - taken.abs()));
        });
        sum
    }
}

/// The sum over all texels as if the horizon cut none: a type, to be compiled for the machine's instructions. Products are
/// not fused with sums, so that every machine finds the same bits.
struct WholeTexels<'a> {
    texels: &'a Texels,
    h: &'a [f32],
    n_z: f64,
}

impl NullaryFnOnce for WholeTexels<'_> {
    type Output = Rgb<f64>;

    #[inline(always)]
    fn call(self) -> Rgb<f64> {
        let Self { texels, h, n_z } = self;
        let mut sum = Rgb::ZERO;
        for (y, &(a, b)) in texels.rows.iter().enumerate() {
            let row = texels.planes.each_ref().map(|plane| &plane[y * texels.stride..][..texels.stride]);
            sum += row_sum(h, row, a as f32, (n_z * b) as f32);
        }
        sum
    }
}

/// `δ c ∫_row sin²θ dθ` and `δ ∫_row sin θ cos θ dθ` of every row.
///
/// ```text
///   ∫ sin²θ = (Δ - sin Δ cos 2θ_c)/2      ∫ sin θ cos θ = (sin Δ sin 2θ_c)/2      Δ = π/h
/// ```
pub(crate) fn row_vectors(width: usize, height: usize) -> Vec<(f64, f64)> {
    let delta = 2.0 * PI / width as f64;
    let chord = sin_cos_pi(1.0 / width as f64).0 * width as f64 / PI;
    let sin_step = sin_cos_pi(1.0 / height as f64).0;
    let row = |y: usize| {
        let (sin, cos) = sin_cos_pi((2 * y + 1) as f64 / height as f64);
        (0.5 * delta * chord * (PI / height as f64 - sin_step * cos), 0.5 * delta * sin_step * sin)
    };
    (0..height).map(row).collect()
}

/// `Σ_x L(x) max(a h_x + b, 0)` of one row, channel by channel.
#[inline(always)]
fn row_sum(h: &[f32], row: [&[f32]; 3], a: f32, b: f32) -> Rgb<f64> {
    let h = h.as_chunks::<LANES>().0;
    let row = row.map(|channel| &channel.as_chunks::<LANES>().0[..h.len()]);
    let mut total = Rgb::ZERO;
    for start in (0..h.len()).step_by(RUN) {
        let run = start..h.len().min(start + RUN);
        let row = row.map(|channel| &channel[run.clone()]);
        let mut sums = [[0.0_f32; LANES]; 3];
        for (k, h) in h[run].iter().enumerate() {
            for lane in 0..LANES {
                let cosine = a * h[lane] + b;
                // Not `max`: it would spend two more instructions on NaN.
                let cosine = if cosine > 0.0 { cosine } else { 0.0 };
                for c in 0..3 {
                    sums[c][lane] += row[c][k][lane] * cosine;
                }
            }
        }
        total += Rgb::from(sums.map(|lanes| lanes.iter().copied().map(f64::from).sum()));
    }
    total
}
