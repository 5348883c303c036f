//! Compression of transfer by clustered principal components: options, reports, and the choice among solutions.

use derive_setters::Setters;
use lobe_io::{Job, parallel};

use crate::compression::compressed_table::bytes;
use crate::compression::compressed_table::{CompressedTable, WeightBits};
use crate::compression::cpca::{Clustering, Cpca};
use crate::compression::pca::Rows;
use crate::error::PrtError;
use crate::job::meter::Meter;
use crate::transfer::transfer::Transfer;

/// Clusters that [`compress_table_within`] tries, besides one and as many as fit without components.
const CLUSTERS_TRIED: [usize; 6] = [4, 16, 64, 256, 1024, 4096];

/// Options of [`compress_table`] and [`CompressedTransfer::new`](crate::CompressedTransfer::new).
#[derive(Clone, Copy, Debug, PartialEq, Setters, serde::Serialize, serde::Deserialize)]
#[serde(default)]
#[non_exhaustive]
pub struct CompressOptions {
    /// The most clusters, 1 to 65536. One gives ordinary principal components (PCA).
    pub clusters: usize,
    /// Directions in each cluster. None gives vector quantization (VQ). More than a row has numbers are never stored.
    pub components: usize,
    /// The number format of weights.
    pub weights: WeightBits,
    /// The most iterations after the last doubling of the clusters.
    pub iterations: usize,
    /// An iteration that lowers the error by less than this part of it is the last.
    pub tolerance: f64,
}

impl Default for CompressOptions {
    fn default() -> Self {
        Self { clusters: 64, components: 8, weights: WeightBits::F32, iterations: 24, tolerance: 1e-3 }
    }
}

impl CompressOptions {
    /// The most clusters: their numbers are 16 bits wide.
    pub const MAX_CLUSTERS: usize = 65536;

    /// The most components: a row of the highest order in color has as many numbers.
    pub const MAX_COMPONENTS: usize = 3 * Transfer::MAX_ORDER * Transfer::MAX_ORDER;

    fn check(&self) -> Result<(), PrtError> {
        if !(1..=Self::MAX_CLUSTERS).contains(&self.clusters) {
            let message = format!("expected 1 to {} clusters, found {}", Self::MAX_CLUSTERS, self.clusters);
            return Err(PrtError::Options(message));
        }
        if !(0.0..=1.0).contains(&self.tolerance) {
            return Err(PrtError::Options(format!("expected a tolerance of 0 to 1, found {}", self.tolerance)));
        }
        Ok(())
    }
}

/// The report of a compression: its error and its size.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
#[non_exhaustive]
pub struct CompressReport {
    /// Clusters there are, at most as many as asked for.
    pub clusters: usize,
    /// Directions in each.
    pub components: usize,
    /// The sum over all numbers of the squared difference from what is decoded, roundings included.
    pub squared_error: f64,
    /// The root of that over the sum of the squares; 0 where both are 0.
    pub relative_error: f64,
    /// Bytes before, four a number.
    pub bytes_before: usize,
    /// Bytes after: the clusters' numbers, the weights and the bases.
    pub bytes: usize,
    /// Bytes before for each byte after.
    pub ratio: f64,
    /// The squared error before rounding, at the start and after every iteration with all clusters; it may rise for a
    /// moment where a cluster was moved to another place.
    pub iterations: Vec<f64>,
}

/// Compresses a table, rows of `width` numbers, by clustered principal components ([Sloan 2003]).
///
/// ```text
///   x_r ≈ m_k + Σ_j w_rj b_kj
/// ```
///
/// The error is the sum of squared differences; for transfer vectors that is, up to a factor, the mean squared error of
/// exit radiance under lights with equal and independent coefficients.
///
/// Two clusterings are tried, one doubled from principal components and one begun with those of vector quantization,
/// and the better is taken: the error is never above that of PCA with as many components, nor of VQ with as many
/// clusters, but for rounding (test `clustered_components_are_never_worse_than_either_part`). The result does not
/// depend on the number of threads.
///
/// Time grows with rows · clusters · (components + 1) · width for every iteration; and, for rows wider than a cluster
/// is numerous, with the cube of the number of its rows.
///
/// The job is told after every iteration how many steps are done at most: as if no iteration were the last before it
/// has to be, so that the time left is seldom more than it says.
///
/// # Errors
/// [`PrtError::Options`] for options out of range or a job that is to be kept in a file; [`PrtError::Invalid`] if the
/// table is no whole number of rows, or has numbers that are not finite; [`PrtError::Cancelled`] if the job was told to
/// stop.
pub fn compress_table(
    rows: &[f32],
    width: usize,
    options: &CompressOptions,
    job: Job<'_>,
) -> Result<(CompressedTable, CompressReport), PrtError> {
    options.check()?;
    let rows = checked(rows, width)?;
    let components = options.components.min(width);
    let solver = Cpca::new(rows, options.iterations, options.tolerance);
    let mut meter = Meter::new(steps_to_best(&solver, options.clusters, components), job)?;
    let best = best(&solver, options.clusters, components, &mut meter);
    meter.go_on()?;
    Ok(encoded(rows, &best, components, options.weights))
}

/// The compression of least error among those of at most `bytes` bytes, whatever the numbers of clusters and
/// components.
///
/// PCA with as many components as fit and VQ with as many clusters are among the candidates, so neither is better at
/// equal cost. The clusters and components of `options` are not read.
///
/// # Errors
/// As for [`compress_table`], and [`PrtError::Options`] if not even one cluster without components fits.
pub fn compress_table_within(
    rows: &[f32],
    width: usize,
    most_bytes: usize,
    options: &CompressOptions,
    job: Job<'_>,
) -> Result<(CompressedTable, CompressReport), PrtError> {
    let options = CompressOptions { clusters: 1, components: 0, ..*options };
    options.check()?;
    let rows = checked(rows, width)?;
    let cost = |clusters, components| bytes(rows.count(), width, clusters, components, options.weights);
    // List the candidates: for each number of clusters the most components that fit.
    let mut candidates: Vec<(usize, usize)> = Vec::new();
    for clusters in std::iter::once(1).chain(CLUSTERS_TRIED).filter(|k| *k <= rows.count().max(1)) {
        let fitting = (0..=width).take_while(|components| cost(clusters, *components) <= most_bytes);
        candidates.extend(fitting.last().map(|components| (clusters, components)));
    }
    // Add vector quantization with the most clusters that fit.
    let highest = rows.count().clamp(1, CompressOptions::MAX_CLUSTERS);
    let codes = most_bytes.saturating_sub(rows.count() * 2) / (4 * width);
    candidates.extend((codes >= 2).then_some((codes.min(highest), 0)));
    let solver = Cpca::new(rows, options.iterations, options.tolerance);
    let steps = candidates.iter().map(|&(clusters, components)| steps_to_best(&solver, clusters, components)).sum();
    let mut meter = Meter::new(steps, job)?;
    // Solve each candidate, and keep that of least error.
    let mut least: Option<(CompressedTable, CompressReport)> = None;
    for (clusters, components) in candidates {
        let end = meter.done() + steps_to_best(&solver, clusters, components);
        let solution = best(&solver, clusters, components, &mut meter);
        meter.reach(end);
        meter.go_on()?;
        let solved = encoded(rows, &solution, components, options.weights);
        if least.as_ref().is_none_or(|least| solved.1.squared_error < least.1.squared_error) {
            least = Some(solved);
        }
    }
    least.ok_or_else(|| {
        PrtError::Options(format!("expected room for {} bytes at least, found {most_bytes}", cost(1, 0)))
    })
}

/// A point of [`error_curve`].
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct CurvePoint {
    /// The most clusters.
    pub clusters: usize,
    /// Directions in each.
    pub components: usize,
    /// The squared error with exact weights.
    pub squared_error: f64,
    /// The root of that over the sum of the squares; 0 where both are 0.
    pub relative_error: f64,
    /// Bytes with weights as the options have them.
    pub bytes: usize,
}

/// The error of every number of components with every number of clusters, as the figures of [Sloan 2003] show it.
///
/// Each solution begins from those with the next smaller number of clusters, and of components, so that the error
/// falls, or stays, along both (test `the_error_falls_with_clusters_and_components`). Points come in ascending order,
/// components outside.
///
/// The job is told after every iteration, as by [`compress_table`].
///
/// # Errors
/// [`PrtError::Options`] if a number of clusters is not 1 to 65536 or the job is to be kept in a file,
/// [`PrtError::Cancelled`] if it was told to stop.
pub fn error_curve(
    transfer: &Transfer,
    clusters: &[usize],
    components: &[usize],
    options: &CompressOptions,
    job: Job<'_>,
) -> Result<Vec<CurvePoint>, PrtError> {
    let ascending = |values: &[usize]| {
        let mut values = values.to_vec();
        values.sort_unstable();
        values.dedup();
        values
    };
    let (clusters, components) = (ascending(clusters), ascending(components));
    for clusters in &clusters {
        CompressOptions { clusters: *clusters, ..*options }.check()?;
    }
    let width = transfer.order() * transfer.order() * transfer.channels().count();
    let rows = Rows::new(transfer.coefficients(), width);
    let solver = Cpca::new(rows, options.iterations, options.tolerance);
    let energy = energy(transfer.coefficients());
    let mut meter = Meter::new(steps_of_curve(&solver, &clusters, &components), job)?;
    let mut fewer_components: Vec<Clustering> = Vec::new();
    let mut points = Vec::new();
    for components in components {
        let stored = components.min(width);
        let mut solutions: Vec<Clustering> = Vec::new();
        for (i, clusters) in clusters.iter().enumerate() {
            // Grow the solution from the one with fewer clusters.
            let start = solutions.last().cloned().unwrap_or_else(|| solver.one(stored));
            let mut solution = solver.grown(start, *clusters, stored, &mut meter);
            // Try also the one with fewer components, and take the better.
            if let Some(fewer) = fewer_components.get(i) {
                solution = solution.better(solver.with_components(fewer, stored, &mut meter));
            }
            meter.go_on()?;
            let squared_error = solution.error();
            points.push(CurvePoint {
                clusters: *clusters,
                components,
                squared_error,
                relative_error: relative(squared_error, energy),
                bytes: bytes(rows.count(), width, solution.spaces.len(), stored, options.weights),
            });
            solutions.push(solution);
        }
        fewer_components = solutions;
    }
    Ok(points)
}

/// The better of the clusters doubled from principal components and those of vector quantization.
fn best(solver: &Cpca<'_>, clusters: usize, components: usize, meter: &mut Meter<'_>) -> Clustering {
    let from_one = solver.grown(solver.one(components), clusters, components, meter);
    if clusters == 1 || components == 0 {
        return from_one;
    }
    let quantized = solver.grown(solver.one(0), clusters, 0, meter);
    from_one.better(solver.with_components(&quantized, components, meter))
}

/// The steps of [`best`] at most.
fn steps_to_best(solver: &Cpca<'_>, clusters: usize, components: usize) -> usize {
    let steps = solver.steps_to_grow(1, clusters, components);
    if clusters == 1 || components == 0 {
        return steps;
    }
    steps + solver.steps_to_grow(1, clusters, 0) + solver.steps_to_settle(clusters, components)
}

/// The steps of [`error_curve`] at most.
fn steps_of_curve(solver: &Cpca<'_>, clusters: &[usize], components: &[usize]) -> usize {
    let of_components = |(i, &components): (usize, &usize)| {
        let starts = std::iter::once(&1).chain(clusters);
        let grown = starts.zip(clusters).map(|(from, to)| solver.steps_to_grow(*from, *to, components));
        let settled = clusters.iter().map(|k| if i > 0 { solver.steps_to_settle(*k, components) } else { 0 });
        grown.chain(settled).sum::<usize>()
    };
    components.iter().enumerate().map(of_components).sum()
}

fn encoded(
    rows: Rows<'_>,
    clustering: &Clustering,
    components: usize,
    weights: WeightBits,
) -> (CompressedTable, CompressReport) {
    let table = CompressedTable::encode(rows, &clustering.of_row, &clustering.spaces, components, weights);
    let (squared_error, energy) = difference(rows, &table);
    let (bytes_before, bytes) = (4 * rows.count() * rows.width(), table.bytes());
    let report = CompressReport {
        clusters: table.cluster_count(),
        components,
        squared_error,
        relative_error: relative(squared_error, energy),
        bytes_before,
        bytes,
        ratio: bytes_before as f64 / bytes.max(1) as f64,
        iterations: clustering.history.clone(),
    };
    (table, report)
}

fn checked(rows: &[f32], width: usize) -> Result<Rows<'_>, PrtError> {
    if width == 0 || !rows.len().is_multiple_of(width) {
        let message = format!("expected rows of {width} numbers, found {} in all", rows.len());
        return Err(PrtError::invalid("table", message));
    }
    if let Some(at) = rows.iter().position(|x| !x.is_finite()) {
        let message = format!("expected finite numbers, found {} in row {}", rows[at], at / width);
        return Err(PrtError::invalid("table", message));
    }
    Ok(Rows::new(rows, width))
}

/// Squared error of the decoded rows, and the sum of the squares of the rows themselves; summed in the order of the
/// rows.
fn difference(rows: Rows<'_>, table: &CompressedTable) -> (f64, f64) {
    let one = |r: usize| {
        let mut decoded = vec![0.0; rows.width()];
        table.decode_into(r, &mut decoded);
        let row = rows.row(r as u32);
        let error: f64 = row.iter().zip(&decoded).map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2)).sum();
        (error, energy(row))
    };
    let each: Vec<(f64, f64)> = parallel::map(rows.count(), &one);
    each.into_iter().fold((0.0, 0.0), |sum, one| (sum.0 + one.0, sum.1 + one.1))
}

pub(crate) fn energy(values: &[f32]) -> f64 {
    values.iter().map(|x| f64::from(*x).powi(2)).sum()
}

pub(crate) fn relative(squared_error: f64, energy: f64) -> f64 {
    if energy > 0.0 { (squared_error / energy).sqrt() } else { squared_error.sqrt() }
}
