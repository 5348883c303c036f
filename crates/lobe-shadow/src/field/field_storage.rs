//! Number formats of stored fields: single and half precision, eight bits, and clustered principal components.

use half::f16;
use lobe_io::Job;
use lobe_prt::{CompressOptions, CompressedTable, PrtError, TableWeights, WeightBits, compress_table};

use crate::error::ShadowError;

/// How the numbers of a field, of a lamp or of visibility are stored in a file. In memory they are always `f32`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum FieldStorage {
    /// As they are, four bytes each.
    #[default]
    F32,
    /// In half precision, two bytes each: to a part in 2048.
    F16,
    /// In 256 even steps between the least and the largest value of each coefficient, one byte each. The scale `w(r)` of a
    /// field keeps that range alike at all distances.
    U8,
    /// By clustered principal components of the sample points' vectors.
    Clustered(CompressOptions),
}

impl FieldStorage {
    /// [`FieldStorage::Clustered`] where nobody asks for other numbers: 128 clusters of 6 components, and weights of 8 bits. At order 4
    /// a field takes less than a third of the bytes of single precision, and shadows are as near to the truth beyond two radii.
    #[must_use]
    pub fn clustered() -> CompressOptions {
        CompressOptions::default().clusters(128).components(6).weights(WeightBits::U8)
    }
}

/// What a form of storage costs.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
#[non_exhaustive]
pub struct StorageReport {
    /// Bytes of the numbers.
    pub bytes: usize,
    /// Bytes of the same in `f32`.
    pub bytes_before: usize,
    /// The root of the sum of squared differences over that of squares.
    pub relative_error: f64,
    /// The largest difference of a coefficient, scaled as it is stored.
    pub largest_error: f64,
}

/// Encoded rows.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum StoredRows {
    /// As they are in memory.
    F32,
    F16(Vec<f16>),
    /// The least value of each coefficient, then the step of each; the numbers of steps.
    U8 {
        ranges: Vec<f32>,
        steps: Vec<u8>,
    },
    Clustered(CompressedTable),
}

impl StoredRows {
    /// Rows of `width` numbers in a form of storage.
    ///
    /// # Errors
    /// [`ShadowError::Options`] for options of the clusters out of range, or numbers beyond those of the form.
    pub(crate) fn encode(rows: &[f32], width: usize, storage: &FieldStorage) -> Result<Self, ShadowError> {
        Self::encode_in_shells(rows, width, rows.len() / width.max(1), storage)
    }

    /// The same of rows that lie in shells, `shell` of them in each and what is left in the last: each of four runs of neighboring shells has as
    /// many clusters as every other. What a field stores is scaled to numbers of one size, of which those near the surface
    /// differ most: clusters of all rows together would go there, and leave few for the shells beyond.
    pub(crate) fn encode_in_shells(
        rows: &[f32],
        width: usize,
        shell: usize,
        storage: &FieldStorage,
    ) -> Result<Self, ShadowError> {
        let too_large = |form: &str, most: f32| {
            let found = rows.iter().fold(0.0_f32, |most, x| most.max(x.abs()));
            if found <= most {
                return Ok(());
            }
            let message = format!("expected numbers up to {most:e} for storage {form}, found {found:e}: take f32");
            Err(ShadowError::Options(message))
        };
        Ok(match storage {
            FieldStorage::F32 => Self::F32,
            FieldStorage::F16 => {
                too_large("f16", f16::MAX.to_f32())?;
                Self::F16(rows.iter().map(|x| f16::from_f32(*x)).collect())
            }
            FieldStorage::U8 => {
                // Their difference is finite.
                too_large("u8", f32::MAX / 4.0)?;
                eight_bits(rows, width)
            }
            FieldStorage::Clustered(options) => Self::Clustered(clustered(rows, width, shell, options)?),
        })
    }

    /// The numbers of rows in even steps from the least value of each coefficient.
    pub(crate) fn steps_to_numbers(ranges: &[f32], steps: &[u8]) -> Vec<f32> {
        let (low, step) = ranges.split_at(ranges.len() / 2);
        let width = low.len().max(1);
        steps.iter().enumerate().map(|(i, k)| low[i % width] + step[i % width] * f32::from(*k)).collect()
    }

    /// The numbers again; none for those that are as they were.
    fn decode(&self) -> Option<Vec<f32>> {
        match self {
            Self::F32 => None,
            Self::F16(rows) => Some(rows.iter().map(|x| x.to_f32()).collect()),
            Self::U8 { ranges, steps } => Some(Self::steps_to_numbers(ranges, steps)),
            Self::Clustered(table) => Some(table.decode()),
        }
    }

    fn bytes(&self, rows: &[f32]) -> usize {
        match self {
            Self::F32 => size_of_val(rows),
            Self::F16(rows) => 2 * rows.len(),
            Self::U8 { ranges, steps } => 4 * ranges.len() + steps.len(),
            Self::Clustered(table) => {
                let of_weight = match table.weights() {
                    TableWeights::U8(_) => 1,
                    TableWeights::U16(_) => 2,
                    _ => 4,
                };
                table.rows() * (2 + table.components() * of_weight) + 4 * table.bases().len()
            }
        }
    }

    /// The cost of storing these rows, which were encoded.
    pub(crate) fn report(&self, rows: &[f32]) -> StorageReport {
        let (mut squares, mut errors, mut largest_error) = (0.0, 0.0, 0.0_f64);
        for (found, x) in self.decode().iter().flatten().zip(rows) {
            let difference = f64::from(*found) - f64::from(*x);
            squares += f64::from(*x).powi(2);
            errors += difference.powi(2);
            largest_error = largest_error.max(difference.abs());
        }
        let relative_error = if errors > 0.0 { (errors / squares).sqrt() } else { 0.0 };
        StorageReport { bytes: self.bytes(rows), bytes_before: size_of_val(rows), relative_error, largest_error }
    }
}

/// Runs of shells with clusters of their own. Rows of neighboring shells are alike, so that clusters in common are the better ones; of 1, 2,
/// 4, 8 and 16 runs, 4 halve the error of a rabbit's visibility beyond two radii and add a tenth to that near by.
const RUNS: usize = 4;

/// Clusters of rows in shells.
fn clustered(
    rows: &[f32],
    width: usize,
    shell: usize,
    options: &CompressOptions,
) -> Result<CompressedTable, ShadowError> {
    let count = rows.len() / width.max(1);
    let shells = (count / shell.max(1)).max(1);
    // The runs of neighboring shells that have clusters of their own. Options out of range are refused as those of one run.
    let is_in_range = (1..=CompressOptions::MAX_CLUSTERS).contains(&options.clusters);
    let runs = if is_in_range { shells.min(options.clusters).min(RUNS) } else { 1 };
    let begin = |run: usize| if run == runs { count } else { run * shells / runs * shell };
    let mut tables = Vec::with_capacity(runs);
    for run in 0..runs {
        let clusters = (run + 1) * options.clusters / runs - run * options.clusters / runs;
        let rows = &rows[begin(run) * width..begin(run + 1) * width];
        tables.push(compress_table(rows, width, &options.clusters(clusters), Job::default()).map_err(of_prt)?.0);
    }
    joined(width, &tables)
}

/// The rows of some tables one after the other, each in its clusters.
fn joined(width: usize, tables: &[CompressedTable]) -> Result<CompressedTable, ShadowError> {
    let components = tables.first().map_or(0, CompressedTable::components);
    let (mut clusters, mut bases, mut first) = (Vec::new(), Vec::new(), 0);
    for table in tables {
        // No number is above the last of as many clusters as were asked for.
        clusters.extend(table.clusters().iter().map(|k| first + k));
        bases.extend_from_slice(table.bases());
        first = first.wrapping_add(table.cluster_count() as u16);
    }
    let mut weights = tables.first().map_or(TableWeights::F32(Vec::new()), |table| table.weights().clone());
    for table in tables.iter().skip(1) {
        match (&mut weights, table.weights()) {
            (TableWeights::F32(all), TableWeights::F32(more)) => all.extend_from_slice(more),
            (TableWeights::U16(all), TableWeights::U16(more)) => all.extend_from_slice(more),
            (TableWeights::U8(all), TableWeights::U8(more)) => all.extend_from_slice(more),
            _ => unreachable!("the tables have the weights of one choice of options"),
        }
    }
    CompressedTable::new(width, components, clusters, weights, bases).map_err(of_prt)
}

/// An error of `lobe-prt` as one of this crate.
pub(crate) fn of_prt(error: PrtError) -> ShadowError {
    match error {
        PrtError::Cancelled => ShadowError::Cancelled,
        PrtError::Io(error) => ShadowError::Io(error),
        other => ShadowError::Options(other.to_string()),
    }
}

fn eight_bits(rows: &[f32], width: usize) -> StoredRows {
    let mut bounds = vec![(f32::INFINITY, f32::NEG_INFINITY); width];
    for row in rows.chunks_exact(width) {
        bounds.iter_mut().zip(row).for_each(|((low, high), x)| (*low, *high) = (low.min(*x), high.max(*x)));
    }
    let step = |(low, high): &(f32, f32)| (high - low) / 255.0;
    let steps = rows
        .iter()
        .enumerate()
        .map(|(i, x)| {
            let bounds = &bounds[i % width];
            let step = step(bounds);
            if step > 0.0 { ((x - bounds.0) / step).round() as u8 } else { 0 }
        })
        .collect();
    let ranges = bounds.iter().map(|(low, _)| *low).chain(bounds.iter().map(step)).collect();
    StoredRows::U8 { ranges, steps }
}
