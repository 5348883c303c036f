//! Nonlinear fit of zonal lobes to transfer.

use std::time::Duration;

use derive_setters::Setters;
use lobe_io::{Job, Portions, parallel};
use lobe_sh::expansion::optimal_linear_direction;
use lobe_sh::{Dir, ShVec};

use crate::compression::compress::{energy, relative};
use crate::error::PrtError;
use crate::job::meter::Meter;
use crate::transfer::transfer::{Channels, Transfer};
use crate::zonal::bfgs::minimize;
use crate::zonal::lobes::{LobeProblem, Lobes, unit_lobe};
use crate::zonal::zonal_transfer::ZonalTransfer;

/// Directions among which starts are looked for, all in one half-space: a lobe and its opposite span the same
/// functions. At order 8 a lobe's main part is twice as wide as their distance.
const CANDIDATES: usize = 128;

/// Starts from the candidates, besides the linear direction.
const STARTS: usize = 2;

/// Two starts whose axes are closer than this, by the cosine, are one.
const APART: f64 = 0.8;

/// The first guess of the inverse curvature, for a function of norm 1; the search learns a better one.
const FIRST: f64 = 0.05;

/// No step of the search turns the axes by more than about this, in radians.
const LONGEST: f64 = 0.3;

/// A gain of squared error over squared norm that is not worth a step: that of rounding the coefficients to `f32`.
const TOLERANCE: f64 = 1e-14;

/// Work between two reports, about.
const WAVE: Duration = Duration::from_millis(200);

/// Options of [`fit_zonal`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Setters, serde::Serialize, serde::Deserialize)]
#[serde(default)]
#[non_exhaustive]
pub struct ZonalFitOptions {
    /// Lobes for each receiver, 1 to 8.
    pub lobes: usize,
    /// Whether axes are optimized. Otherwise a single lobe is that of the closed form, and further ones are chosen
    /// among fixed directions.
    pub optimize: bool,
    /// The most steps of each search.
    pub steps: usize,
}

impl Default for ZonalFitOptions {
    fn default() -> Self {
        Self { lobes: 1, optimize: true, steps: 100 }
    }
}

/// The report of a fit: its errors.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
#[non_exhaustive]
pub struct ZonalFitReport {
    /// For every receiver the sum of the squared differences of its coefficients, all channels, roundings included.
    pub squared_errors: Vec<f64>,
    /// The sum of these.
    pub squared_error: f64,
    /// The root of that over the sum of the squares of all coefficients; 0 where both are 0.
    pub relative_error: f64,
    /// The root of the largest over the squares of the same receiver; 0 where all transfer is zero.
    pub worst_relative_error: f64,
}

/// Approximates the transfer of every receiver by zonal lobes ([Sloan 2005]), with the least sum of squared differences
/// over all channels that the searches find.
///
/// One lobe begins in closed form: its axis is the optimal linear direction of the luminance, its coefficients the
/// projection onto it (of unshadowed transfer that leaves nothing). More are added one by one: the further axis begins
/// where a lobe could take most of what is left, then all axes move together, by BFGS with the coefficients eliminated
/// by linear least squares. Every number of lobes begins with the solution of one less, so the error does not rise with
/// it (test `the_error_falls_with_every_lobe`).
///
/// Transfer without a linear part has its first axis among fixed directions; that of zero or constant transfer is +z.
/// The result does not depend on the number of threads.
///
/// The job is told several times in a second how many receivers are done.
///
/// # Errors
/// [`PrtError::Options`] if the number of lobes is not 1 to 8 or the job is to be kept in a file,
/// [`PrtError::Cancelled`] if the job was told to stop.
pub fn fit_zonal(
    transfer: &Transfer,
    options: &ZonalFitOptions,
    job: Job<'_>,
) -> Result<(ZonalTransfer, ZonalFitReport), PrtError> {
    let (order, channels) = (transfer.order(), transfer.channels());
    ZonalTransfer::new(order, channels, options.lobes, Vec::new(), Vec::new())?;
    let candidates = Candidates::new(order);
    let width = order * order * channels.count();
    let mut meter = Meter::new(transfer.receivers(), job)?;
    let mut axes = Vec::with_capacity(transfer.receivers() * options.lobes);
    let mut coefficients = Vec::new();
    let mut rest = transfer.coefficients();
    let mut portions = Portions::new(WAVE, 4 * rayon::current_num_threads());
    while !rest.is_empty() {
        let (rows, later) = rest.split_at(rest.len().min(portions.size().saturating_mul(width)));
        let search = || Search::new(order, channels, &candidates, options);
        let stored = |search: &mut Search<'_>, k: usize| search.stored(&rows[k * width..][..width]);
        let fits = portions.time(|| parallel::map_with(rows.len() / width, &search, &stored));
        rest = later;
        meter.step(fits.len());
        meter.go_on()?;
        for (of_axes, of_coefficients) in fits {
            axes.extend(of_axes);
            coefficients.extend(of_coefficients);
        }
    }
    let zonal = ZonalTransfer::new(order, channels, options.lobes, axes, coefficients)?;
    let report = report(transfer, &zonal, width);
    Ok((zonal, report))
}

fn report(transfer: &Transfer, zonal: &ZonalTransfer, width: usize) -> ZonalFitReport {
    let errors: Vec<(f64, f64)> = parallel::map(transfer.receivers(), &|r| {
        let row = &transfer.coefficients()[r * width..][..width];
        let square = |(a, b): (&f32, &f32)| (f64::from(*a) - f64::from(*b)).powi(2);
        let error: f64 = row.iter().zip(&zonal.decode(r)).map(square).sum();
        (error, energy(row))
    });
    let worst = errors.iter().filter(|(_, energy)| *energy > 0.0).map(|(error, energy)| error / energy);
    let worst_relative_error = worst.fold(0.0, f64::max).sqrt();
    let (squared_error, all) = errors.iter().fold((0.0, 0.0), |sum, one| (sum.0 + one.0, sum.1 + one.1));
    let squared_errors = errors.into_iter().map(|(error, _)| error).collect();
    ZonalFitReport { squared_errors, squared_error, relative_error: relative(squared_error, all), worst_relative_error }
}

/// Directions over a half-space and their lobes.
struct Candidates {
    dirs: Vec<Dir>,
    lobes: Vec<Vec<f64>>,
}

impl Candidates {
    fn new(order: usize) -> Self {
        // The upper half of a spiral of twice as many points, the pole among them.
        let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
        let spiral = |k: usize| Dir::from_angles((1.0 - k as f64 / CANDIDATES as f64).acos(), golden * k as f64);
        let dirs: Vec<Dir> = (0..CANDIDATES).map(spiral).collect();
        let lobes = dirs.iter().map(|d| unit_lobe(*d, order)).collect();
        Self { dirs, lobes }
    }

    /// The directions along which a further lobe gains most, a few that are apart.
    fn best(&self, problem: &LobeProblem) -> Vec<Dir> {
        let mut gains: Vec<(f64, Dir)> =
            self.lobes.iter().zip(&self.dirs).map(|(u, d)| (problem.gain(u), *d)).collect();
        let mut best: Vec<Dir> = Vec::with_capacity(STARTS);
        while best.len() < STARTS {
            let highest = gains.iter().copied().reduce(|a, b| if b.0 > a.0 { b } else { a });
            let Some((_, dir)) = highest else { break };
            best.push(dir);
            gains.retain(|(_, d)| d.dot(dir).abs() < APART);
        }
        best
    }
}

/// The state of a thread that fits one receiver after the other.
struct Search<'a> {
    problem: LobeProblem,
    candidates: &'a Candidates,
    options: &'a ZonalFitOptions,
    order: usize,
    channels: Channels,
}

impl<'a> Search<'a> {
    fn new(order: usize, channels: Channels, candidates: &'a Candidates, options: &'a ZonalFitOptions) -> Self {
        Self { problem: LobeProblem::new(order, channels.count()), candidates, options, order, channels }
    }

    /// The lobes of one receiver as they are stored: axes are rounded first, coefficients are those of least squares
    /// for them.
    fn stored(&mut self, row: &[f32]) -> (Vec<[f32; 3]>, Vec<f32>) {
        // Fit the lobes to the normalized row.
        let energy = self.problem.set(row);
        let lobes = self.fitted(row, energy);
        // Orient the axes, and round them as they are stored.
        let oriented =
            lobes.axes.iter().enumerate().map(|(k, axis)| if self.is_backward(&lobes, k) { -*axis } else { *axis });
        let axes: Vec<[f32; 3]> = oriented.map(|d| d.to_array().map(|x| x as f32)).collect();
        let rounded: Vec<Dir> = axes.iter().map(|a| crate::zonal::zonal_transfer::dir(*a)).collect();
        // Solve for the coefficients of the rounded axes.
        let scale = energy.sqrt();
        let coefficients = self.problem.solve(&rounded).coefficients;
        (axes, coefficients.into_iter().map(|z| (scale * z) as f32).collect())
    }

    /// A lobe and its opposite span the same functions; we take the axis along which the linear part is positive.
    fn is_backward(&self, lobes: &Lobes, k: usize) -> bool {
        let count = self.channels.count();
        let linear = |c: usize| lobes.coefficients[(k * count + c) * self.order + 1];
        self.order > 1 && (0..count).map(linear).sum::<f64>() < 0.0
    }

    fn fitted(&mut self, row: &[f32], energy: f64) -> Lobes {
        let mut lobes = self.problem.solve(&[]);
        if energy == 0.0 {
            return self.problem.solve(&vec![Dir::Z; self.options.lobes]);
        }
        for count in 0..self.options.lobes {
            // Start a further lobe where it gains most of the residual; the first also from the linear direction.
            self.problem.solve(&lobes.axes);
            let mut starts = self.candidates.best(&self.problem);
            if count == 0
                && let Some(linear) = self.linear(row)
            {
                starts.insert(0, linear);
                starts.truncate(if self.options.optimize { starts.len() } else { 1 });
            }
            // Minimize over all axes from each start, and keep the best.
            let with = |start: Dir| lobes.axes.iter().copied().chain([start]).collect::<Vec<Dir>>();
            let mut best: Option<Lobes> = None;
            for start in starts {
                let start = with(start);
                let found = if self.options.optimize { self.descend(&start) } else { self.problem.solve(&start) };
                if best.as_ref().is_none_or(|best| found.cost < best.cost) {
                    best = Some(found);
                }
            }
            lobes = best.unwrap_or_else(|| unreachable!("there is a candidate"));
        }
        lobes
    }

    /// The optimal linear direction of the luminance; none if the linear part is rounding.
    fn linear(&self, row: &[f32]) -> Option<Dir> {
        const NOTHING: f64 = 1e-7;
        let n = self.order * self.order;
        let luminance = |i: usize| match self.channels {
            Channels::Gray => f64::from(row[i]),
            Channels::Rgb => {
                let [r, g, b] = [row[i], row[n + i], row[2 * n + i]].map(f64::from);
                lobe_sh::Rgb::new(r, g, b).luminance()
            }
        };
        let f: Vec<f64> = (0..n).map(luminance).collect();
        let linear: f64 = f.iter().skip(1).take(3).map(|f| f * f).sum();
        let all: f64 = f.iter().map(|f| f * f).sum();
        let f = ShVec::from_vec(f).unwrap_or_else(|| unreachable!("n² coefficients"));
        if linear <= NOTHING * NOTHING * all { None } else { optimal_linear_direction(&f) }
    }

    /// Minimizes over all axes. The variables are vectors of any length that point along the axes,
    /// `∂/∂x = (1 - s sᵀ)/|x| ∂/∂s`.
    fn descend(&mut self, start: &[Dir]) -> Lobes {
        let mut x: Vec<f64> = start.iter().flat_map(|d| d.to_array()).collect();
        let problem = &mut self.problem;
        let mut best = problem.solve(start);
        minimize(&mut x, [FIRST, LONGEST, TOLERANCE], self.options.steps, |x, gradient| {
            let axes: Option<Vec<Dir>> = x.as_chunks::<3>().0.iter().map(|v| Dir::new(*v)).collect();
            let Some(axes) = axes else { return f64::INFINITY };
            let lobes = problem.solve(&axes);
            for (k, (v, out)) in x.as_chunks::<3>().0.iter().zip(gradient.as_chunks_mut::<3>().0).enumerate() {
                let length = v.iter().map(|v| v * v).sum::<f64>().sqrt();
                *out = problem.slope(&lobes, k).map(|slope| slope / length);
            }
            let cost = lobes.cost;
            if cost < best.cost {
                best = lobes;
            }
            cost
        });
        best
    }
}
