//! A compressed table: for each row a cluster and a few weights of the directions of that cluster.

use lobe_io::Numbers;
use lobe_sh::Rgb;

use crate::compression::pca::{Rows, Subspace};
use crate::error::PrtError;
use crate::transfer::weighted_rows::weighted;

/// The number format of a weight.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
pub enum WeightBits {
    /// As a floating-point number.
    #[default]
    F32,
    /// In 65535 steps of its range.
    U16,
    /// In 255 steps of its range.
    U8,
}

impl WeightBits {
    /// Bytes a weight takes.
    #[must_use]
    pub const fn bytes(self) -> usize {
        match self {
            Self::F32 => 4,
            Self::U16 => 2,
            Self::U8 => 1,
        }
    }
}

/// The weights of all rows: row by row, component by component.
///
/// Integers stand for `q / 65535` and `q / 255`, as normalized vertex attributes do.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum TableWeights {
    /// As they are.
    F32(Vec<f32>),
    /// In steps of 1/65535.
    U16(Vec<u16>),
    /// In steps of 1/255.
    U8(Vec<u8>),
}

impl<'a> From<&'a TableWeights> for Numbers<'a> {
    fn from(weights: &'a TableWeights) -> Self {
        match weights {
            TableWeights::F32(w) => Self::F32(w),
            TableWeights::U16(w) => Self::U16(w),
            TableWeights::U8(w) => Self::U8(w),
        }
    }
}

impl TableWeights {
    /// Their number format.
    #[must_use]
    pub fn bits(&self) -> WeightBits {
        match self {
            Self::F32(_) => WeightBits::F32,
            Self::U16(_) => WeightBits::U16,
            Self::U8(_) => WeightBits::U8,
        }
    }

    /// The number of weights.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::F32(w) => w.len(),
            Self::U16(w) => w.len(),
            Self::U8(w) => w.len(),
        }
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The weight in place `i`.
    fn get(&self, i: usize) -> f32 {
        match self {
            Self::F32(w) => w[i],
            Self::U16(w) => f32::from(w[i]) * self.step(),
            Self::U8(w) => f32::from(w[i]) * self.step(),
        }
    }

    /// The quantization step: the weight of one unit of the stored number.
    fn step(&self) -> f32 {
        match self {
            Self::F32(_) => 1.0,
            Self::U16(_) => 1.0 / 65535.0,
            Self::U8(_) => 1.0 / 255.0,
        }
    }
}

/// A table of rows in clusters, each with a mean and a few directions.
///
/// ```text
///   x_r ≈ m_k + Σ_j w_rj b_kj        k = clusters[r]
/// ```
///
/// Directions are as long as the range of their weights where these are integers, so that the weights lie in `[0, 1]`.
#[derive(Clone, Debug, PartialEq)]
pub struct CompressedTable {
    pub(crate) width: usize,
    pub(crate) components: usize,
    pub(crate) clusters: Vec<u16>,
    pub(crate) weights: TableWeights,
    /// For each cluster the mean, then the directions.
    pub(crate) bases: Vec<f32>,
}

impl CompressedTable {
    /// From its parts: for each row the cluster and `components` weights, for each cluster a mean and as many
    /// directions of `width` numbers.
    ///
    /// # Errors
    /// [`PrtError::Invalid`] if the parts do not fit together, or hold numbers that are not finite or that may not add up to finite ones.
    pub fn new(
        width: usize,
        components: usize,
        clusters: Vec<u16>,
        weights: TableWeights,
        bases: Vec<f32>,
    ) -> Result<Self, PrtError> {
        let invalid = |message: String| Err(PrtError::invalid("compressed transfer", message));
        if components > width {
            return invalid(format!("expected at most {width} components, as many as numbers, found {components}"));
        }
        let one = width.saturating_mul(components.saturating_add(1));
        if one == 0 || !bases.len().is_multiple_of(one) {
            return invalid(format!("expected {one} numbers for each cluster, found {} in all", bases.len()));
        }
        let count = bases.len() / one;
        if let Some(r) = clusters.iter().position(|k| usize::from(*k) >= count) {
            return invalid(format!("receiver {r} is in cluster {} of {count}", clusters[r]));
        }
        if weights.len() != clusters.len() * components {
            let (found, rows) = (weights.len(), clusters.len());
            return invalid(format!(
                "expected {components} weights for each of {rows} receivers, found {found} in all"
            ));
        }
        let bad_weight = match &weights {
            TableWeights::F32(w) => w.iter().find(|w| !w.is_finite()),
            _ => None,
        };
        if let Some(bad) = bases.iter().find(|b| !b.is_finite()).or(bad_weight) {
            return invalid(format!("expected finite numbers, found {bad}"));
        }
        let table = Self { width, components, clusters, weights, bases };
        if let Some(cluster) = table.overflowing_cluster() {
            return invalid(format!("the numbers of cluster {cluster} with weights of this size exceed those of f32"));
        }
        Ok(table)
    }

    /// A cluster of which a row may have a number that is not finite: one whose mean and largest weights add up to more.
    fn overflowing_cluster(&self) -> Option<usize> {
        let mut largest = vec![1.0; self.components];
        if let TableWeights::F32(weights) = &self.weights {
            largest.fill(0.0);
            for row in weights.chunks_exact(self.components.max(1)) {
                largest.iter_mut().zip(row).for_each(|(largest, w)| *largest = w.abs().max(*largest));
            }
        }
        let size = |of: &f32| f64::from(*of).abs();
        // Sums in f32 round up by less than a thousandth.
        let is_large = |sum: f64| sum > 0.999 * f64::from(f32::MAX);
        self.bases.chunks_exact(self.width * (self.components + 1)).position(|vectors| {
            let (mean, directions) = vectors.split_at(self.width);
            let mut sums: Vec<f64> = mean.iter().map(size).collect();
            for (direction, largest) in directions.chunks_exact(self.width).zip(&largest) {
                sums.iter_mut().zip(direction).for_each(|(sum, d)| *sum += size(largest) * size(d));
            }
            sums.into_iter().any(is_large)
        })
    }

    /// Rounds means and directions, and stores the weights of every row.
    pub(crate) fn encode(
        rows: Rows<'_>,
        of_row: &[u32],
        spaces: &[Subspace],
        components: usize,
        bits: WeightBits,
    ) -> Self {
        let width = rows.width();
        let (mut scratch, mut exact) = (Vec::new(), vec![0.0; of_row.len() * components]);
        for (r, k) in of_row.iter().enumerate() {
            let out = &mut exact[r * components..][..components];
            spaces[*k as usize].project(rows.row(r as u32), &mut scratch, |j, w| out[j] = w);
        }
        let ranges = match bits {
            WeightBits::F32 => vec![(0.0, 1.0); spaces.len() * components],
            WeightBits::U16 | WeightBits::U8 => ranges(of_row, &exact, spaces.len(), components),
        };
        let mut bases = Vec::with_capacity(spaces.len() * width * (components + 1));
        for (k, space) in spaces.iter().enumerate() {
            let directions = space.bases.chunks_exact(width);
            let ranges = &ranges[k * components..(k + 1) * components];
            let mut mean = space.mean.clone();
            let mut scaled = vec![0.0_f32; width * components];
            for ((b, (low, range)), out) in directions.zip(ranges).zip(scaled.chunks_exact_mut(width)) {
                mean.iter_mut().zip(b).for_each(|(m, b)| *m += low * b);
                out.iter_mut().zip(b).for_each(|(out, b)| *out = (range * b) as f32);
            }
            bases.extend(mean.into_iter().map(|m| m as f32));
            bases.extend(scaled);
        }
        let unit = |i: usize| {
            let (low, range) = ranges[of_row[i / components] as usize * components + i % components];
            if range > 0.0 { (exact[i] - low) / range } else { 0.0 }
        };
        let places = 0..exact.len();
        let weights = match bits {
            WeightBits::F32 => TableWeights::F32(exact.iter().map(|w| *w as f32).collect()),
            WeightBits::U16 => TableWeights::U16(places.map(|i| (unit(i) * 65535.0).round() as u16).collect()),
            WeightBits::U8 => TableWeights::U8(places.map(|i| (unit(i) * 255.0).round() as u8).collect()),
        };
        let clusters = of_row.iter().map(|k| *k as u16).collect();
        Self { width, components, clusters, weights, bases }
    }

    /// Numbers in a row.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.clusters.len()
    }

    /// Directions in each cluster.
    #[must_use]
    pub fn components(&self) -> usize {
        self.components
    }

    /// Number of clusters.
    #[must_use]
    pub fn cluster_count(&self) -> usize {
        self.bases.len() / (self.width * (self.components + 1))
    }

    /// The cluster of every row.
    #[must_use]
    pub fn clusters(&self) -> &[u16] {
        &self.clusters
    }

    /// The weights of every row.
    #[must_use]
    pub fn weights(&self) -> &TableWeights {
        &self.weights
    }

    /// For each cluster the mean, then the directions: `clusters · (components + 1)` vectors of `width` numbers.
    #[must_use]
    pub fn bases(&self) -> &[f32] {
        &self.bases
    }

    /// The bytes of clusters (none for one cluster), weights and bases.
    #[must_use]
    pub fn bytes(&self) -> usize {
        bytes(self.rows(), self.width, self.cluster_count(), self.components, self.weights.bits())
    }

    /// The numbers of one row, into `out`.
    ///
    /// # Panics
    /// If there is no such row, or `out` has not `width` places.
    pub fn decode_into(&self, row: usize, out: &mut [f32]) {
        assert_eq!(out.len(), self.width, "one place for each number of a row");
        let one = self.width * (self.components + 1);
        let mut vectors = self.bases[usize::from(self.clusters[row]) * one..][..one].chunks_exact(self.width);
        if let Some(mean) = vectors.next() {
            out.copy_from_slice(mean);
        }
        for (j, b) in vectors.enumerate() {
            let w = self.weights.get(row * self.components + j);
            out.iter_mut().zip(b).for_each(|(x, b)| *x += w * b);
        }
    }

    /// All rows.
    #[must_use]
    pub fn decode(&self) -> Vec<f32> {
        let mut out = vec![0.0; self.rows() * self.width];
        out.chunks_exact_mut(self.width).enumerate().for_each(|(r, out)| self.decode_into(r, out));
        out
    }

    /// The value of a linear function at every row, a color, from its values at the means and directions alone.
    pub(crate) fn colors_into(&self, of_vector: impl Fn(&[f32]) -> [f64; 3], out: &mut [Rgb<f32>]) {
        let step = f64::from(self.weights.step());
        let entry = |(i, v): (usize, &[f32])| {
            let step = if i.is_multiple_of(self.components + 1) { 1.0 } else { step };
            let [r, g, b] = of_vector(v).map(|c| (step * c) as f32);
            [r, g, b, 0.0]
        };
        let table: Vec<[f32; 4]> = self.bases.chunks_exact(self.width).enumerate().map(entry).collect();
        match &self.weights {
            TableWeights::F32(w) => weighted(&self.clusters, w, self.components, &table, out),
            TableWeights::U16(w) => weighted(&self.clusters, w, self.components, &table, out),
            TableWeights::U8(w) => weighted(&self.clusters, w, self.components, &table, out),
        }
    }
}

/// Bytes of a compressed table: a cluster's number for each row, the weights, the bases in `f32`.
pub(crate) fn bytes(rows: usize, width: usize, clusters: usize, components: usize, bits: WeightBits) -> usize {
    rows * (size_of::<u16>() + components * bits.bytes()) + 4 * clusters * (components + 1) * width
}

/// The least weight and the range of every component in every cluster.
fn ranges(of_row: &[u32], weights: &[f64], clusters: usize, components: usize) -> Vec<(f64, f64)> {
    let mut bounds = vec![(f64::INFINITY, f64::NEG_INFINITY); clusters * components];
    for (k, weights) in of_row.iter().zip(weights.chunks_exact(components.max(1))) {
        for (bounds, w) in bounds[*k as usize * components..].iter_mut().zip(weights) {
            *bounds = (bounds.0.min(*w), bounds.1.max(*w));
        }
    }
    let range = |(low, high): (f64, f64)| if low <= high { (low, high - low) } else { (0.0, 0.0) };
    bounds.into_iter().map(range).collect()
}
