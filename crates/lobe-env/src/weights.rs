//! What each texel of one map sees of another.
//!
//! ```text
//!   V_ts = r_t W_ts c_s        Σ_s V_ts = 1        W_ts = Σ_samples of t, weight × share of s in the interpolant there
//! ```

use std::ops::Range;

use lobe_sh::{Coefficient, Rgb};
use rayon::prelude::*;

use crate::extras::Extra;
use crate::patch::Tile;
use crate::sample_points::{Chunk, Sampler};
use crate::solid_angles::SolidAngles;
use crate::sparse_sum::{BLOCK, SparseSum};
use crate::view::{Light, View, Views};

/// The target is worked on in about this many parts, whatever the number of threads.
const CHUNKS: usize = 128;
/// But none has fewer rows: what a part costs must not outweigh its samples.
const LEAST_ROWS: usize = 8;
/// The sums of so many parts are held at once; waiting for the last of them costs little if they are many.
const CHUNKS_TOGETHER: usize = 32;
/// Of more samples than this not what they see is kept from pass to pass, 20 bytes each, but where they lie.
const MOST_VIEWS: usize = 1 << 22;
/// And of more than this nothing is kept: up to 1.5 GiB, where no patches fit.
const MOST_SAMPLES: usize = 1 << 27;

/// What passes need not find again, for each chunk.
enum Kept {
    Views(Vec<Views>),
    Samples(Vec<Chunk>),
    Nothing,
}

/// The weights between two maps.
pub(crate) struct Weights<'a> {
    sampler: &'a Sampler,
    /// Of the texels of the target.
    solid_angles: SolidAngles,
    kept: Kept,
    extras: Vec<Extra>,
    /// `c_s`; nothing while all are 1.
    factors: Vec<f32>,
}

impl<'a> Weights<'a> {
    /// With all factors 1.
    pub(crate) fn new(sampler: &'a Sampler) -> Self {
        let mut weights = Self {
            sampler,
            solid_angles: SolidAngles::new(sampler.target),
            kept: Kept::Nothing,
            extras: Vec::new(),
            factors: Vec::new(),
        };
        let samples = sampler.estimate();
        let chunks = 0..weights.chunks();
        weights.kept = if samples <= MOST_VIEWS {
            Kept::Views(chunks.into_par_iter().map(|chunk| weights.views(chunk)).collect())
        } else if samples <= MOST_SAMPLES {
            Kept::Samples(chunks.into_par_iter().map(|chunk| sampler.chunk(weights.rows(chunk))).collect())
        } else {
            Kept::Nothing
        };
        weights
    }

    pub(crate) fn sampler(&self) -> &Sampler {
        self.sampler
    }

    /// Multiplies the factor of every texel of the source.
    pub(crate) fn scale(&mut self, factor: impl Fn(usize) -> f32 + Sync) {
        self.factors.resize(self.sampler.source.len(), 1.0);
        self.factors.par_iter_mut().enumerate().for_each(|(s, own)| *own *= factor(s));
    }

    /// Every texel of the target, from the light of those of the source.
    pub(crate) fn gather(&self, light: &[Light]) -> Vec<Rgb<f32>> {
        let (source, target) = (self.sampler.source, self.sampler.target);
        let mut out = vec![Rgb::ZERO; target.len()];
        out.par_chunks_mut(self.chunk_rows() * target.width).enumerate().for_each(|(chunk, out)| {
            let top = self.rows(chunk).start;
            self.for_each_texel(chunk, false, |[x, y], view| {
                let [r, g, b, weight] = view.total(light, source.width);
                if weight > 0.0 {
                    out[(y - top) * target.width + x] = Rgb::narrow(Rgb::new(r, g, b).scale(1.0 / weight));
                }
            });
        });
        out
    }

    /// For each texel of the source `E_s = Σ_t Ω_t V_ts`, its energy in the target.
    pub(crate) fn energies(&self) -> Vec<f64> {
        let mut sums = vec![0.0; self.sampler.source.len()];
        self.add_energies(&mut sums, false, 1.0);
        sums
    }

    /// How the energies change with a change `a_s` of the logarithms of the factors: `Σ_t Ω_t V_ts (a_s - Σ_u V_tu a_u)`.
    pub(crate) fn changes(&self, a: &[f32]) -> Vec<f64> {
        let mut sums = vec![0.0; self.sampler.source.len()];
        let width = self.sampler.source.width;
        self.spread_onto(&mut sums, false, |view, scale, sums| {
            let value = |source: usize| f64::from(a[source]);
            let mut mean = 0.0;
            view.for_each(width, |source, weight| mean += weight * value(source));
            mean /= view.sum();
            view.for_each(width, |source, weight| sums.add(source, scale * weight * (value(source) - mean)));
        });
        sums
    }

    /// Counts extras in, and corrects the energies that were found without them.
    pub(crate) fn add_extras(&mut self, mut extras: Vec<Extra>, energies: &mut [f64]) {
        if extras.is_empty() {
            return;
        }
        extras.par_sort_by_key(|extra| extra.target);
        // What those texels of the target gave before the extras counted, and what they give with them.
        self.extras = extras.iter().map(|extra| Extra { weight: 0.0, ..*extra }).collect();
        self.add_energies(energies, true, -1.0);
        self.extras = extras;
        self.add_energies(energies, true, 1.0);
    }

    /// Adds to the energies, times `sign`, what all texels of the target give, or only those with extras.
    fn add_energies(&self, energies: &mut [f64], only_extras: bool, sign: f64) {
        let width = self.sampler.source.width;
        self.spread_onto(energies, only_extras, |view, scale, sums| {
            let scale = sign * scale;
            for quad in view.quads {
                let (first, [a, b, c, d]) = (quad.first as usize, quad.weights);
                sums.add_pair(first, [scale * f64::from(a), scale * f64::from(b)]);
                sums.add_pair(first + width, [scale * f64::from(c), scale * f64::from(d)]);
            }
            for &(source, weight) in view.shares {
                sums.add(source as usize, scale * f64::from(weight));
            }
        });
    }

    /// Lets all texels of the target, or only those with extras, add to the sums: `add(view, Ω_t r_t, sums)`.
    fn spread_onto(&self, sums: &mut [f64], only_extras: bool, add: impl Fn(View<'_>, f64, &mut SparseSum) + Sync) {
        let spread = |&chunk: &usize| {
            let mut sums = SparseSum::new(self.sampler.source.len());
            if !only_extras || !self.extras_of(chunk).is_empty() {
                self.for_each_texel(chunk, only_extras, |[x, y], view| {
                    let sum = view.sum();
                    if sum > 0.0 {
                        add(view, self.solid_angles.get(x, y) / sum, &mut sums);
                    }
                });
            }
            sums
        };
        let chunks: Vec<usize> = (0..self.chunks()).collect();
        for chunks in chunks.chunks(CHUNKS_TOGETHER) {
            let parts: Vec<SparseSum> = chunks.par_iter().map(spread).collect();
            sums.par_chunks_mut(BLOCK).enumerate().for_each(|(block, sums)| {
                parts.iter().for_each(|part| part.add_block(block, sums));
            });
        }
    }

    /// How many rows of the target each chunk has.
    fn chunk_rows(&self) -> usize {
        self.sampler.target.height.div_ceil(CHUNKS).max(LEAST_ROWS)
    }

    fn chunks(&self) -> usize {
        self.sampler.target.height.div_ceil(self.chunk_rows())
    }

    fn rows(&self, chunk: usize) -> Range<usize> {
        let (rows, height) = (self.chunk_rows(), self.sampler.target.height);
        chunk * rows..height.min((chunk + 1) * rows)
    }

    /// Calls `texel(place, view)` for the texels of a chunk, or only those with extras.
    fn for_each_texel(&self, chunk: usize, only_extras: bool, mut texel: impl FnMut([usize; 2], View<'_>)) {
        let (source, target) = (self.sampler.source, self.sampler.target);
        let extras = self.extras_of(chunk);
        if extras.is_empty() && (only_extras || self.factors.is_empty()) {
            return self.for_each_seen(chunk, |_| !only_extras, texel);
        }
        let extras_in = |Tile { x, y, width, height }: Tile| {
            let first = y * target.width + x;
            extras_between(extras, first..first + (height - 1) * target.width + width)
        };
        let mut balanced = Views::default();
        self.for_each_seen(
            chunk,
            |tile| !only_extras || !extras_in(tile).is_empty(),
            |[x, y], view| {
                let own = extras_in(Tile { x, y, width: 1, height: 1 });
                if own.is_empty() && only_extras {
                    return;
                }
                if own.is_empty() && self.factors.is_empty() {
                    return texel([x, y], view);
                }
                let factor = |s: u32| self.factors.get(s as usize).copied().unwrap_or(1.0);
                balanced.clear();
                if self.factors.is_empty() {
                    balanced.quads.extend_from_slice(view.quads);
                } else {
                    balanced.quads.extend(view.quads.iter().map(|quad| quad.scaled(&self.factors, source.width)));
                }
                balanced.shares.extend(view.shares.iter().map(|&(s, weight)| (s, weight * factor(s))));
                balanced.shares.extend(own.iter().map(|extra| (extra.source, extra.weight * factor(extra.source))));
                texel([x, y], balanced.all());
            },
        );
    }

    /// Calls `texel(place, view)` for the texels of the wanted tiles of a chunk with what their own samples see.
    #[inline(always)]
    fn for_each_seen(&self, chunk: usize, wants: impl Fn(Tile) -> bool, texel: impl FnMut([usize; 2], View<'_>)) {
        let source = self.sampler.source;
        match &self.kept {
            Kept::Views(chunks) => chunks[chunk].for_each(wants, texel),
            Kept::Samples(chunks) => chunks[chunk].for_each(source, wants, texel),
            Kept::Nothing => self.sampler.chunk(self.rows(chunk)).for_each(source, wants, texel),
        }
    }

    /// What the texels of a chunk see.
    fn views(&self, chunk: usize) -> Views {
        let mut views = Views::default();
        self.sampler.chunk(self.rows(chunk)).for_each(
            self.sampler.source,
            |_| true,
            |place, view| {
                views.quads.extend_from_slice(view.quads);
                views.shares.extend_from_slice(view.shares);
                views.end_texel(place);
            },
        );
        views
    }

    /// The extras of a chunk.
    fn extras_of(&self, chunk: usize) -> &[Extra] {
        let (rows, width) = (self.rows(chunk), self.sampler.target.width);
        extras_between(&self.extras, rows.start * width..rows.end * width)
    }

    /// Forgets what was kept, or keeps no more than where samples lie.
    #[cfg(test)]
    pub(crate) fn forget(&mut self, all: bool) {
        let samples = || (0..self.chunks()).map(|chunk| self.sampler.chunk(self.rows(chunk))).collect();
        self.kept = if all { Kept::Nothing } else { Kept::Samples(samples()) };
    }
}

/// Those of some texels of the target, among extras in the order of their targets.
#[inline]
fn extras_between(extras: &[Extra], targets: Range<usize>) -> &[Extra] {
    let (Some(first), Some(last)) = (extras.first(), extras.last()) else { return &[] };
    // Of most chunks only a few rows have any.
    if targets.end <= first.target as usize || targets.start > last.target as usize {
        return &[];
    }
    let before = |end: usize| extras.partition_point(|e| (e.target as usize) < end);
    &extras[before(targets.start)..before(targets.end)]
}
