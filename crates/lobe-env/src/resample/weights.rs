//! Resampling weights between the texels of two maps.
//!
//! ```text
//!   V_ts = r_t W_ts c_s        Σ_s V_ts = 1        W_ts = Σ_samples of t, weight × bilinear weight of s at the sample
//! ```

use std::ops::Range;

use lobe_io::parallel;
use lobe_sh::{Coefficient, Rgb};
use rayon::prelude::*;

use crate::error::EnvError;
use crate::mapping::solid_angles::SolidAngles;
use crate::resample::footprint::{Footprint, Footprints, Tile};
use crate::resample::passes::Passes;
use crate::resample::sample_points::{Chunk, Sampled, Sampler};
use crate::resample::source_window::{WindowLight, WindowSums};
use crate::resample::sparse_sum::{BLOCK, SparseSum};
use crate::resample::undersampled::AdditionalSample;

/// The most that the logarithm of a factor gets, of either sign, where no factors would do; single precision ends at
/// 87.
const MOST_LOGARITHM: f64 = 40.0;

/// The target is divided into about this many chunks, whatever the number of threads.
const CHUNKS: usize = 128;
/// The fewest rows of a chunk: its fixed cost must not outweigh its samples.
const LEAST_ROWS: usize = 8;
/// The number of chunks whose sums are held at once; with many of them, waiting for the last one costs little.
const CHUNKS_TOGETHER: usize = 32;
/// Footprints, 20 bytes per sample, are kept from pass to pass up to this number of samples.
const MOST_VIEWS: usize = 1 << 22;
/// Above it, sample positions are kept up to this number: up to 1.5 GiB, where no patches fit.
const MOST_SAMPLES: usize = 1 << 27;

/// The results of sampling that a chunk keeps for the next pass.
enum Kept {
    Footprints(Vec<Footprints>),
    Samples(Vec<Chunk>),
    Nothing,
}

/// The weights between two maps.
pub(crate) struct Weights<'a> {
    sampler: &'a Sampler,
    /// Solid angles of the target's texels.
    solid_angles: SolidAngles,
    kept: Kept,
    extras: Vec<AdditionalSample>,
    /// `c_s`; empty while all are 1.
    factors: Vec<f32>,
    /// The logarithms of the factors before the last step went on.
    logarithms: Vec<f32>,
}

impl<'a> Weights<'a> {
    /// With all factors 1.
    pub(crate) fn new(sampler: &'a Sampler, passes: &mut Passes<'_>) -> Result<Self, EnvError> {
        let mut weights = Self {
            sampler,
            solid_angles: SolidAngles::new(sampler.target),
            kept: Kept::Nothing,
            extras: Vec::new(),
            factors: Vec::new(),
            logarithms: Vec::new(),
        };
        let samples = sampler.estimate();
        weights.kept = if samples <= MOST_VIEWS {
            Kept::Footprints(weights.of_chunks(passes, |chunk| weights.views(chunk))?)
        } else if samples <= MOST_SAMPLES {
            Kept::Samples(weights.of_chunks(passes, |chunk| sampler.chunk(weights.rows(chunk)))?)
        } else {
            passes.did(sampler.target.height)?;
            Kept::Nothing
        };
        Ok(weights)
    }

    pub(crate) fn sampler(&self) -> &Sampler {
        self.sampler
    }

    /// Multiplies the factor of each source texel `(x, y)` by `ratio(x, y)`, and repeats a part of what it and the last
    /// step have changed.
    pub(crate) fn step(&mut self, ratio: impl Fn(usize, usize) -> f64 + Sync, part: f64) {
        let (width, len) = (self.sampler.source.width, self.sampler.source.len());
        self.factors.resize(len, 1.0);
        self.logarithms.resize(len, 0.0);
        let mut rows: Vec<_> = self.factors.chunks_mut(width).zip(self.logarithms.chunks_mut(width)).collect();
        parallel::rows(&mut rows, 1, &|y, rows| {
            for (x, (factor, last)) in rows.iter_mut().flat_map(|(a, b)| a.iter_mut().zip(b.iter_mut())).enumerate() {
                let bounded = |logarithm: f64| logarithm.clamp(-MOST_LOGARITHM, MOST_LOGARITHM);
                let stepped = bounded((f64::from(*factor) * ratio(x, y)).ln());
                *factor = bounded(stepped + part * (stepped - f64::from(*last))).exp() as f32;
                *last = stepped as f32;
            }
        });
    }

    /// Every texel of the target, given the light of the source's texels.
    pub(crate) fn gather(&self, light: &[Rgb<f32>], passes: &mut Passes<'_>) -> Result<Vec<Rgb<f32>>, EnvError> {
        let (source, target) = (self.sampler.source, self.sampler.target);
        let of_chunk = |chunk: usize| {
            let mut out = vec![Rgb::ZERO; self.rows(chunk).len() * target.width];
            let top = self.rows(chunk).start;
            let mut set = |[x, y]: [usize; 2], (total, weight): (Rgb<f64>, f64)| {
                if weight > 0.0 {
                    out[(y - top) * target.width + x] = Rgb::narrow(total.scale(1.0 / weight));
                }
            };
            let (mut window_light, mut quads) = (WindowLight::default(), Vec::new());
            self.for_each_sampled(chunk, |sight| match sight {
                Sampled::Texel(place, view) => set(place, view.total(light, source.width)),
                Sampled::Patch(patch, window) => {
                    window_light.fill(window, light, source.width);
                    patch.for_each_texel_in(window, &mut quads, |place, quads| set(place, window_light.total(quads)));
                }
            });
            out
        };
        let mut texels = Vec::with_capacity(target.len());
        self.in_waves(of_chunk, |rows, parts| {
            parts.iter().for_each(|part| texels.extend_from_slice(part));
            passes.did(rows)
        })?;
        Ok(texels)
    }

    /// The energy of each source texel in the target, `E_s = Σ_t Ω_t V_ts`.
    pub(crate) fn energies(&self, passes: &mut Passes<'_>) -> Result<Vec<f64>, EnvError> {
        let mut sums = vec![0.0; self.sampler.source.len()];
        self.spread_onto(&mut sums, Some(passes), |chunk, sums| {
            let (mut window_sums, mut quads) = (WindowSums::default(), Vec::new());
            self.for_each_sampled(chunk, |sight| match sight {
                Sampled::Texel(place, view) => self.add_energy(place, view, 1.0, sums),
                Sampled::Patch(patch, window) => {
                    window_sums.clear(window);
                    patch.for_each_texel_in(window, &mut quads, |[x, y], quads| {
                        let sum = Footprint { quads, shares: &[] }.sum();
                        if sum > 0.0 {
                            window_sums.add(quads, (self.solid_angles.get(x, y) / sum) as f32);
                        }
                    });
                    window_sums.add_to(sums, window, self.sampler.source.width);
                }
            });
        })?;
        Ok(sums)
    }

    /// Adds extra samples and corrects the energies that were summed without them; all factors must still be 1.
    pub(crate) fn add_extras(
        &mut self,
        mut extras: Vec<AdditionalSample>,
        energies: &mut [f64],
    ) -> Result<(), EnvError> {
        debug_assert!(self.factors.is_empty() && self.extras.is_empty(), "extras come first, and once");
        if extras.is_empty() {
            return Ok(());
        }
        extras.par_sort_by_key(|extra| extra.target);
        self.extras = extras;
        self.spread_onto(energies, None, |chunk, sums| {
            self.for_each_with_extras(chunk, |place, without, with| {
                self.add_energy(place, without, -1.0, sums);
                self.add_energy(place, with, 1.0, sums);
            });
        })
    }

    /// Adds to `sums`, times `sign`, the energies of the source texels in the footprint of a target texel.
    #[inline(always)]
    fn add_energy(&self, [x, y]: [usize; 2], view: Footprint<'_>, sign: f64, sums: &mut SparseSum) {
        let (sum, width) = (view.sum(), self.sampler.source.width);
        if sum <= 0.0 {
            return;
        }
        let scale = sign * self.solid_angles.get(x, y) / sum;
        for quad in view.quads {
            let (first, [a, b, c, d]) = (quad.first as usize, quad.weights);
            sums.add_pair(first, [scale * f64::from(a), scale * f64::from(b)]);
            sums.add_pair(first + width, [scale * f64::from(c), scale * f64::from(d)]);
        }
        for &(source, weight) in view.shares {
            sums.add(source as usize, scale * f64::from(weight));
        }
    }

    /// Adds to `sums` what `add(chunk, sums)` adds for every chunk, in a pass that is counted or not.
    fn spread_onto(
        &self,
        sums: &mut [f64],
        mut passes: Option<&mut Passes<'_>>,
        add: impl Fn(usize, &mut SparseSum) + Sync,
    ) -> Result<(), EnvError> {
        let spread = |chunk: usize| {
            let mut sums = SparseSum::new(self.sampler.source.len());
            add(chunk, &mut sums);
            sums
        };
        self.in_waves(spread, |rows, parts| {
            parallel::rows(sums, BLOCK, &|block, sums| {
                parts.iter().for_each(|part| part.add_block(block, sums));
            });
            passes.as_mut().map_or(Ok(()), |passes| passes.did(rows))
        })
    }

    /// `make(chunk)` of all chunks, in a pass.
    fn of_chunks<T: Send>(
        &self,
        passes: &mut Passes<'_>,
        make: impl Fn(usize) -> T + Sync,
    ) -> Result<Vec<T>, EnvError> {
        let mut all = Vec::with_capacity(self.chunks());
        self.in_waves(make, |rows, parts| {
            all.extend(parts);
            passes.did(rows)
        })?;
        Ok(all)
    }

    /// Makes a part of each chunk, a few chunks at a time, and takes them in order: `take(rows, parts)`.
    fn in_waves<T: Send>(
        &self,
        make: impl Fn(usize) -> T + Sync,
        mut take: impl FnMut(usize, Vec<T>) -> Result<(), EnvError>,
    ) -> Result<(), EnvError> {
        for first in (0..self.chunks()).step_by(CHUNKS_TOGETHER) {
            let wave = first..self.chunks().min(first + CHUNKS_TOGETHER);
            let rows = self.rows(wave.end - 1).end - self.rows(first).start;
            take(rows, parallel::map(wave.len(), &|k| make(first + k)))?;
        }
        Ok(())
    }

    /// The number of target rows in each chunk.
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

    /// Calls `each` for all texels of a chunk, for whole patches where no factors and no extras interfere.
    fn for_each_sampled(&self, chunk: usize, each: impl FnMut(Sampled<'_>)) {
        self.for_each_balanced(chunk, self.factors.is_empty(), each);
    }

    fn for_each_balanced(&self, chunk: usize, through_windows: bool, mut each: impl FnMut(Sampled<'_>)) {
        let (source, extras) = (self.sampler.source, self.extras_of(chunk));
        let opens = |tile| through_windows && self.extras_in(extras, tile).is_empty();
        if extras.is_empty() && self.factors.is_empty() {
            return self.for_each_seen(chunk, |_| true, opens, each);
        }
        let mut balanced = Footprints::default();
        self.for_each_seen(
            chunk,
            |_| true,
            opens,
            |sight| {
                let Sampled::Texel(place, view) = sight else { return each(sight) };
                let own = self.extras_in(extras, Tile::of_texel(place));
                if own.is_empty() && self.factors.is_empty() {
                    return each(sight);
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
                each(Sampled::Texel(place, balanced.all()));
            },
        );
    }

    /// Calls `texel(place, view without its extras, view with them)` for the texels of a chunk that have extras.
    fn for_each_with_extras(&self, chunk: usize, mut texel: impl FnMut([usize; 2], Footprint<'_>, Footprint<'_>)) {
        let extras = self.extras_of(chunk);
        if extras.is_empty() {
            return;
        }
        let mut all = Footprints::default();
        self.for_each_seen(
            chunk,
            |tile| !self.extras_in(extras, tile).is_empty(),
            |_| false,
            only_texels(|place, view: Footprint<'_>| {
                let own = self.extras_in(extras, Tile::of_texel(place));
                if !own.is_empty() {
                    all.clear();
                    all.quads.extend_from_slice(view.quads);
                    all.shares.extend_from_slice(view.shares);
                    all.shares.extend(own.iter().map(|extra| (extra.source, extra.weight)));
                    texel(place, view, all.all());
                }
            }),
        );
    }

    /// Calls `each` for the texels in the wanted tiles of a chunk, or for whole patches where windows may be used;
    /// without extras.
    #[inline(always)]
    fn for_each_seen(
        &self,
        chunk: usize,
        wants: impl Fn(Tile) -> bool,
        opens: impl Fn(Tile) -> bool,
        mut each: impl FnMut(Sampled<'_>),
    ) {
        let source = self.sampler.source;
        match &self.kept {
            Kept::Footprints(chunks) => chunks[chunk].for_each(wants, |place, view| each(Sampled::Texel(place, view))),
            Kept::Samples(chunks) => chunks[chunk].for_each(source, wants, opens, each),
            Kept::Nothing => self.sampler.chunk(self.rows(chunk)).for_each(source, wants, opens, each),
        }
    }

    /// The footprints of the texels of a chunk.
    fn views(&self, chunk: usize) -> Footprints {
        let mut views = Footprints::default();
        let keep = only_texels(|place, view: Footprint<'_>| {
            views.quads.extend_from_slice(view.quads);
            views.shares.extend_from_slice(view.shares);
            views.end_texel(place);
        });
        self.sampler.chunk(self.rows(chunk)).for_each(self.sampler.source, |_| true, |_| false, keep);
        views
    }

    /// The extra samples of a chunk.
    fn extras_of(&self, chunk: usize) -> &[AdditionalSample] {
        let (rows, width) = (self.rows(chunk), self.sampler.target.width);
        extras_between(&self.extras, rows.start * width..rows.end * width)
    }

    /// The extra samples between the first and the last texel of a tile.
    #[inline]
    fn extras_in<'e>(
        &self,
        extras: &'e [AdditionalSample],
        Tile { x, y, width, height }: Tile,
    ) -> &'e [AdditionalSample] {
        let first = y * self.sampler.target.width + x;
        extras_between(extras, first..first + (height - 1) * self.sampler.target.width + width)
    }

    /// The number of target texels that are sampled through windows.
    #[cfg(test)]
    pub(crate) fn texels_in_windows(&self) -> usize {
        let mut count = 0;
        for chunk in 0..self.chunks() {
            self.for_each_sampled(chunk, |sight| {
                if let Sampled::Patch(patch, _) = sight {
                    count += patch.tile().len();
                }
            });
        }
        count
    }

    /// Forgets what was kept, or keeps only sample positions.
    #[cfg(test)]
    pub(crate) fn forget(&mut self, all: bool) {
        let samples = || (0..self.chunks()).map(|chunk| self.sampler.chunk(self.rows(chunk))).collect();
        self.kept = if all { Kept::Nothing } else { Kept::Samples(samples()) };
    }
}

/// The callback for calls without windows.
fn only_texels(mut texel: impl FnMut([usize; 2], Footprint<'_>)) -> impl FnMut(Sampled<'_>) {
    move |sight| match sight {
        Sampled::Texel(place, view) => texel(place, view),
        Sampled::Patch(..) => unreachable!("no window was opened"),
    }
}

/// The extra samples, sorted by target, of a range of target texels.
#[inline]
fn extras_between(extras: &[AdditionalSample], targets: Range<usize>) -> &[AdditionalSample] {
    let (Some(first), Some(last)) = (extras.first(), extras.last()) else { return &[] };
    // In most chunks only a few rows have extras.
    if targets.end <= first.target as usize || targets.start > last.target as usize {
        return &[];
    }
    let before = |end: usize| extras.partition_point(|e| (e.target as usize) < end);
    &extras[before(targets.start)..before(targets.end)]
}
