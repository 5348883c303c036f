//! Weights between two maps that keep both constants and the energy of every texel.
//!
//! ```text
//!   L'_t = Σ_s V_ts (L_s + q_s max(0, L_s - m_s))           V_ts = r_t W_ts c_s,   Σ_s V_ts = 1
//! ```

use std::ops::Range;

use lobe_sh::{Coefficient, Rgb};
use rayon::prelude::*;

use crate::MappedMap;
use crate::even_light::even_light;
use crate::sample_points::{Chunk, Sample, Sampler, midpoints};
use crate::solid_angles::SolidAngles;
use crate::sparse_sum::{BLOCK, SparseSum};

// W_ts = Σ_samples of t, weight × share of s in the interpolant there: a mean of the source over the target's texel. A
// constant stays constant because the weights of a texel are normalised. The energy of a texel s in the target is
//
//     E_s = Σ_t Ω_t V_ts       and should be Ω_s
//
// and such factors c_s there are, unless texels share too little [Sinkhorn and Knopp 1967]. First, c_s is multiplied by
// Ω_s/E_s a few times: that ends quickly where the samples merely beat against the texels, and slowly where energy has
// to wander: at poles, rims and edges. So for those follow steps of Newton's method in a_s = ln c_s: E changes by
//
//     M a,   (M a)_s = Σ_t Ω_t V_ts (a_s - Σ_u V_tu a_u)
//
// a graph's Laplacian, symmetric and positive but for constants, and M a = Ω - E is solved by conjugate gradients, as far
// as the light of the map at hand needs it [Brauer et al. 2017]. For large maps, in which the beats average out, nothing
// of that is done. q_s = Ω_s/E_s - 1 is what then is missing. It is given to the texel itself as far as it is brighter
// than the mean m_s of its neighbours: an even part of a map stays even, nothing becomes negative, and a sun, L_s >> m_s,
// has
//
//     E_s (L_s + q_s (L_s - m_s)) = Ω_s L_s - (Ω_s - E_s) m_s
//
// its energy but for a part q_s m_s/L_s. So what the mean of the map lacks is, exactly, Σ (Ω_s - E_s) min(L_s, m_s): the
// error by which all these steps are measured.

/// The target is worked on in this many parts, whatever the number of threads.
const CHUNKS: usize = 64;
/// The sums of so many of them are held at once.
const CHUNKS_TOGETHER: usize = 16;
/// Of more samples than this not the shares are kept from pass to pass, four of eight bytes each, but where they lie.
const MOST_SHARES: usize = 1 << 22;
/// And of more than this nothing is kept: 400 MiB.
const MOST_SAMPLES: usize = 1 << 27;
/// The most passes over all samples that find out what each texel of the source is given.
const MOST_PASSES: usize = 60;
/// So many of them adjust each texel for itself.
const OWN_PASSES: usize = 2;
/// No more passes if the mean of no channel is off by more than this.
const MEAN_ENOUGH: f64 = 5e-6;
/// And if it would not be off by more than this were the signs of what texels miss random: texels then have their energy.
const TEXELS_ENOUGH: f64 = 5e-5;
/// A texel of the source whose solid angle is this many times what the samples see is sampled from its own side too, and
/// no step changes a weight by more.
const HARDLY_SEEN: f32 = 2.0;

/// A sample from the side of the source: it belongs to a texel of the target and sees one texel of the source.
#[derive(Clone, Copy, Debug)]
struct Extra {
    target: u32,
    source: u32,
    weight: f32,
}

/// A texel of the source and its weight in one of the target.
type Share = (u32, f32);

/// What the samples of consecutive texels of the target see, `W_ts`; a texel of the source may come several times.
struct Shares {
    /// How many of the shares are those of each texel.
    counts: Vec<u32>,
    shares: Vec<Share>,
}

/// What passes need not find again, for each chunk.
enum Kept {
    Shares(Vec<Shares>),
    Samples(Vec<Chunk>),
    Nothing,
}

/// The weights between two maps.
pub(crate) struct Balance<'a> {
    sampler: &'a Sampler,
    /// Of the texels of the source.
    source: SolidAngles,
    /// Of the texels of the target.
    target: SolidAngles,
    kept: Kept,
    extras: Vec<Extra>,
    /// `c_s`.
    factors: Vec<f32>,
    /// Whether any of them is not 1.
    is_scaled: bool,
}

/// What a texel of the source has in the target, and what it lacks there.
#[derive(Clone, Copy, Debug, Default)]
struct Seen {
    /// `E_s`.
    energy: f32,
    /// `Ω_s - E_s`; 0 if no sample sees the texel, which then shows so little that there is nothing to lose.
    missing: f32,
}

impl Seen {
    /// `Ω_s/E_s`.
    fn ratio(self) -> f32 {
        if self.energy > 0.0 { 1.0 + self.missing / self.energy } else { 1.0 }
    }
}

impl<'a> Balance<'a> {
    /// Before it is balanced.
    fn new(sampler: &'a Sampler) -> Self {
        let mut balance = Self {
            sampler,
            source: SolidAngles::new(sampler.source),
            target: SolidAngles::new(sampler.target),
            kept: Kept::Nothing,
            extras: Vec::new(),
            factors: vec![1.0; sampler.source.len()],
            is_scaled: false,
        };
        let ranges = balance.ranges().into_par_iter();
        let samples = sampler.estimate();
        balance.kept = if samples <= MOST_SHARES {
            Kept::Shares(ranges.map(|texels| balance.shares(texels)).collect())
        } else if samples <= MOST_SAMPLES {
            Kept::Samples(ranges.map(|texels| sampler.chunk(texels)).collect())
        } else {
            Kept::Nothing
        };
        balance
    }

    /// Every texel of the target, from those of `map`, balanced as far as that map needs it.
    pub(crate) fn resample(sampler: &'a Sampler, map: &MappedMap) -> Vec<Rgb<f32>> {
        let mut balance = Self::new(sampler);
        let mut light = even_light(map, &balance.source);
        let (seen, _) = balance.balance(&light);
        // Those brighter than their neighbours with what they would lose.
        light.par_iter_mut().zip(map.texels()).zip(seen).for_each(|((light, texel), seen)| {
            *light = *texel + (*texel - *light).scale(seen.ratio() - 1.0);
        });
        balance.gather(&light)
    }

    /// Finds the factors; what then is missing, and after how many passes.
    fn balance(&mut self, even: &[Rgb<f32>]) -> (Vec<Seen>, usize) {
        let whole = self.energy(even);
        let mut passes = 0;
        loop {
            passes += 1;
            let mut energies = self.spread(None);
            if passes == 1 {
                self.add_extras(&mut energies);
            }
            let seen = self.seen(&energies);
            drop(energies);
            if passes >= MOST_PASSES || self.is_enough(|s| seen[s].missing, even, whole) {
                return (seen, passes);
            }
            self.is_scaled = true;
            if passes <= OWN_PASSES {
                for (factor, seen) in self.factors.iter_mut().zip(&seen) {
                    *factor *= seen.ratio().clamp(1.0 / HARDLY_SEEN, HARDLY_SEEN);
                }
            } else {
                let steps = self.newton(&seen, even, whole, &mut passes);
                for (factor, step) in self.factors.iter_mut().zip(steps) {
                    *factor *= step.clamp(-HARDLY_SEEN.ln(), HARDLY_SEEN.ln()).exp();
                }
            }
        }
    }

    /// `a` with `M a = Ω - E`, by conjugate gradients in which each texel's own part of M is divided out.
    fn newton(&self, seen: &[Seen], even: &[Rgb<f32>], whole: Rgb<f64>, passes: &mut usize) -> Vec<f32> {
        // What one texel lacks others have too much; rounding and unseen texels must not leave a rest.
        let sum = |value: fn(&Seen) -> f32| seen.iter().map(|s| f64::from(value(s))).sum::<f64>();
        let rest = sum(|s| s.missing) / sum(|s| s.energy);
        let mut residual: Vec<f32> =
            seen.iter().map(|s| (f64::from(s.missing) - rest * f64::from(s.energy)) as f32).collect();
        let divided = |s: usize, residual: f32| if seen[s].energy > 0.0 { residual / seen[s].energy } else { 0.0 };
        let dot = |residual: &[f32]| -> f64 {
            residual.iter().enumerate().map(|(s, r)| f64::from(*r) * f64::from(divided(s, *r))).sum()
        };
        let mut found = vec![0.0_f32; seen.len()];
        let mut step: Vec<f32> = residual.iter().enumerate().map(|(s, r)| divided(s, *r)).collect();
        let mut size = dot(&residual);
        while *passes < MOST_PASSES && size > 0.0 {
            *passes += 1;
            let change = self.spread(Some(&step));
            let along: f64 = step.iter().zip(&change).map(|(a, b)| f64::from(*a) * b).sum();
            if along <= 0.0 {
                break;
            }
            let length = (size / along) as f32;
            for (((found, residual), step), change) in found.iter_mut().zip(&mut residual).zip(&step).zip(&change) {
                *found += length * step;
                *residual -= length * *change as f32;
            }
            if self.is_enough(|s| residual[s], even, whole) {
                break;
            }
            let next = dot(&residual);
            let kept = (next / size) as f32;
            for (s, (step, residual)) in step.iter_mut().zip(&residual).enumerate() {
                *step = divided(s, *residual) + kept * *step;
            }
            size = next;
        }
        found
    }

    /// Every texel of the target, from the light of those of the source.
    fn gather(&self, light: &[Rgb<f32>]) -> Vec<Rgb<f32>> {
        let mut out = vec![Rgb::ZERO; self.sampler.target.len()];
        let size = self.chunk_size();
        out.par_chunks_mut(size).enumerate().for_each(|(chunk, out)| {
            let start = chunk * size;
            self.for_each_texel(start..start + out.len(), false, |index, shares| {
                let (mut texel, mut sum): (Rgb<f64>, f64) = (Rgb::ZERO, 0.0);
                for &(source, weight) in shares {
                    texel += light[source as usize].widen().scale(f64::from(weight));
                    sum += f64::from(weight);
                }
                if sum > 0.0 {
                    out[index - start] = Rgb::narrow(texel.scale(1.0 / sum));
                }
            });
        });
        out
    }

    fn chunk_size(&self) -> usize {
        self.sampler.target.len().div_ceil(CHUNKS)
    }

    fn ranges(&self) -> Vec<Range<usize>> {
        let (count, size) = (self.sampler.target.len(), self.chunk_size());
        (0..count.div_ceil(size)).map(|c| c * size..count.min((c + 1) * size)).collect()
    }

    /// Calls `texel(number, shares)` for the texels of a chunk, or only those with extras; a texel of the source may have
    /// several shares.
    fn for_each_texel(&self, range: Range<usize>, only_extras: bool, mut texel: impl FnMut(usize, &[Share])) {
        let mut extras = self.extras_of(&range);
        let mut balanced = Vec::new();
        self.for_each_seen(range, |index, seen| {
            let (own, rest) = extras.split_at(extras.iter().take_while(|e| e.target as usize == index).count());
            extras = rest;
            if own.is_empty() && only_extras {
                return;
            }
            if own.is_empty() && !self.is_scaled {
                return texel(index, seen);
            }
            let share = |&(source, weight): &Share| (source, weight * self.factors[source as usize]);
            balanced.clear();
            balanced.extend(seen.iter().map(share));
            balanced.extend(own.iter().map(|e| share(&(e.source, e.weight))));
            texel(index, &balanced);
        });
    }

    /// Calls `texel(number, shares)` for the texels of a chunk with what their own samples see.
    fn for_each_seen(&self, range: Range<usize>, mut texel: impl FnMut(usize, &[Share])) {
        let number = range.start / self.chunk_size();
        let mut scratch = Vec::new();
        let from_samples = |index: usize, samples: &[Sample]| {
            scratch.clear();
            self.add_shares(samples, &mut scratch);
            texel(index, &scratch);
        };
        match &self.kept {
            Kept::Nothing => self.sampler.chunk(range).for_each(from_samples),
            Kept::Samples(chunks) => chunks[number].for_each(from_samples),
            Kept::Shares(chunks) => {
                let Shares { counts, shares } = &chunks[number];
                let mut shares = shares.as_slice();
                for (index, count) in range.zip(counts) {
                    let (own, rest) = shares.split_at(*count as usize);
                    texel(index, own);
                    shares = rest;
                }
            }
        }
    }

    /// What the samples of a chunk see.
    fn shares(&self, range: Range<usize>) -> Shares {
        let mut all = Shares { counts: Vec::with_capacity(range.len()), shares: Vec::new() };
        self.for_each_seen(range, |_, shares| {
            all.counts.push(shares.len() as u32);
            all.shares.extend_from_slice(shares);
        });
        all
    }

    #[inline(always)]
    fn add_shares(&self, samples: &[Sample], shares: &mut Vec<Share>) {
        let grid = self.sampler.source;
        for sample in samples {
            if let Some(taps) = grid.inner_taps(sample.xy()) {
                shares.extend_from_slice(&taps.map(|(index, weight): Share| (index, sample.weight * weight)));
                continue;
            }
            for (index, weight) in grid.taps(sample.point()).iter() {
                shares.push((index as u32, sample.weight * weight));
            }
        }
    }

    /// For each texel of the source `Σ_t Ω_t V_ts`, or with `a` the sum `M a`.
    fn spread(&self, a: Option<&[f32]>) -> Vec<f64> {
        let mut sums = vec![0.0; self.sampler.source.len()];
        self.spread_onto(&mut sums, false, 1.0, a);
        sums
    }

    /// Adds to the sums, times `sign`, what all texels of the target give, or only those with extras.
    fn spread_onto(&self, sums: &mut [f64], only_extras: bool, sign: f64, a: Option<&[f32]>) {
        let width = self.sampler.target.width;
        let spread = |range: &Range<usize>| {
            let mut sums = SparseSum::new(self.sampler.source.len());
            if only_extras && self.extras_of(range).is_empty() {
                return sums;
            }
            self.for_each_texel(range.clone(), only_extras, |index, shares| {
                let sum: f64 = shares.iter().map(|(_, weight)| f64::from(*weight)).sum();
                if sum <= 0.0 {
                    return;
                }
                let scale = sign * self.target.get(index % width, index / width) / sum;
                let Some(a) = a else {
                    for &(source, weight) in shares {
                        sums.add(source as usize, scale * f64::from(weight));
                    }
                    return;
                };
                let value = |source: u32| f64::from(a[source as usize]);
                let mean = shares.iter().map(|(source, weight)| f64::from(*weight) * value(*source)).sum::<f64>() / sum;
                for &(source, weight) in shares {
                    sums.add(source as usize, scale * f64::from(weight) * (value(source) - mean));
                }
            });
            sums
        };
        for ranges in self.ranges().chunks(CHUNKS_TOGETHER) {
            let parts: Vec<SparseSum> = ranges.par_iter().map(spread).collect();
            sums.par_chunks_mut(BLOCK).enumerate().for_each(|(block, sums)| {
                parts.iter().for_each(|part| part.add_block(block, sums));
            });
        }
    }

    /// The extras of some texels of the target.
    fn extras_of(&self, range: &Range<usize>) -> &[Extra] {
        let before = |end: usize| self.extras.partition_point(|e| (e.target as usize) < end);
        &self.extras[before(range.start)..before(range.end)]
    }

    /// What each texel of the source has and lacks, with its energy in the target.
    fn seen(&self, energies: &[f64]) -> Vec<Seen> {
        let width = self.sampler.source.width;
        let mut seen = vec![Seen::default(); energies.len()];
        seen.par_chunks_mut(width).zip(energies.par_chunks(width)).enumerate().for_each(|(y, (seen, energies))| {
            for (x, (seen, energy)) in seen.iter_mut().zip(energies).enumerate() {
                let missing = (self.source.get(x, y) - energy) as f32;
                *seen = Seen { energy: *energy as f32, missing: if *energy > 0.0 { missing } else { 0.0 } };
            }
        });
        seen
    }

    /// Whether light has its energy, to the limits above, if texel `s` lacks the solid angle `missing(s)`.
    fn is_enough(&self, missing: impl Fn(usize) -> f32 + Sync, light: &[Rgb<f32>], whole: Rgb<f64>) -> bool {
        let sums = |(block, light): (usize, &[Rgb<f32>])| {
            let (mut net, mut squares): (Rgb<f64>, f64) = (Rgb::ZERO, 0.0);
            for (i, light) in light.iter().enumerate() {
                let missing = missing(block * BLOCK + i);
                // What shows nothing may hold anything.
                if missing != 0.0 {
                    let lost = light.widen().scale(f64::from(missing));
                    net += lost;
                    squares += (lost.r + lost.g + lost.b).powi(2);
                }
            }
            (net, squares)
        };
        let sums: Vec<_> = light.par_chunks(BLOCK).enumerate().map(sums).collect();
        let (net, squares) = sums.into_iter().fold((Rgb::ZERO, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
        let is_off = |net: f64, whole: f64| net.abs() > MEAN_ENOUGH * whole;
        let [r, g, b] = [0, 1, 2].map(|c| is_off(net.channel(c), whole.channel(c)));
        !(r || g || b || squares.sqrt() > TEXELS_ENOUGH * (whole.r + whole.g + whole.b))
    }

    /// The energy of light.
    fn energy(&self, light: &[Rgb<f32>]) -> Rgb<f64> {
        let width = self.sampler.source.width;
        let row = |(y, row): (usize, &[Rgb<f32>])| {
            let mut sum: Rgb<f64> = Rgb::ZERO;
            for (x, light) in row.iter().enumerate() {
                let solid_angle = self.source.get(x, y);
                // What shows nothing may hold anything.
                if solid_angle > 0.0 {
                    sum += light.widen().scale(solid_angle);
                }
            }
            sum
        };
        let rows: Vec<_> = light.par_chunks(width).enumerate().map(row).collect();
        rows.into_iter().fold(Rgb::ZERO, |sum, row| sum + row)
    }

    /// Samples the texels of the source of which the target sees too little, and sees again what they change.
    fn add_extras(&mut self, energies: &mut [f64]) {
        let width = self.sampler.source.width;
        let of_row = |(y, energies): (usize, &[f64])| {
            let mut extras = Vec::new();
            for (x, energy) in energies.iter().enumerate() {
                let solid_angle = self.source.get(x, y);
                let share = 1.0 - energy / solid_angle;
                if solid_angle > 0.0 && share >= 1.0 - 1.0 / f64::from(HARDLY_SEEN) {
                    self.add_extra([x, y], share, &mut extras);
                }
            }
            extras
        };
        let found: Vec<Vec<Extra>> = energies.par_chunks(width).enumerate().map(of_row).collect();
        self.extras = found.concat();
        if self.extras.is_empty() {
            return;
        }
        self.extras.sort_by_key(|extra| extra.target);
        // What those texels of the target gave before the extras counted, and what they give with them.
        let weights: Vec<f32> = self.extras.iter().map(|extra| extra.weight).collect();
        self.extras.iter_mut().for_each(|extra| extra.weight = 0.0);
        self.spread_onto(energies, true, -1.0, None);
        self.extras.iter_mut().zip(weights).for_each(|(extra, weight)| extra.weight = weight);
        self.spread_onto(energies, true, 1.0, None);
    }

    /// `share` of a texel of the source, from four points in it.
    fn add_extra(&self, texel: [usize; 2], share: f64, extras: &mut Vec<Extra>) {
        let (source, target) = (self.sampler.source, self.sampler.target);
        let mut nodes = Vec::new();
        let size = [source.width, source.height];
        crate::texel::nodes_into(source.mapping, size, texel, &midpoints(2), &mut nodes);
        for (s, weight) in nodes {
            let index = target.texel(target.point(self.sampler.to_target(s)));
            let number = texel[1] * source.width + texel[0];
            extras.push(Extra { target: index as u32, source: number as u32, weight: (share * weight) as f32 });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Mapping;
    use crate::taps::Grid;

    /// The most that may be missing of a texel after the passes, in parts of the mean texel: what then is added to it
    /// alone if it is bright. Of a sliver at the rim of a disc it may be more than half.
    const MOST_MISSING: f64 = 0.1;
    /// And on average.
    const MEAN_MISSING: f64 = 0.005;

    fn grid(mapping: Mapping, texels: usize) -> Grid {
        let aspect = mapping.height_for(12) as f64 / 12.0;
        let width = (texels as f64 / aspect).sqrt().round() as usize;
        Grid::new(mapping, width, mapping.height_for(width))
    }

    #[test]
    fn hardly_anything_of_any_texel_is_left_to_be_added() {
        for (from, to) in [(600, 600), (600, 100), (100, 600)] {
            for (source, target) in Mapping::ALL.into_iter().flat_map(|s| Mapping::ALL.map(|t| (s, t))) {
                let sampler = Sampler::new(grid(source, from), grid(target, to), None);
                let grey = vec![Rgb::splat(1.0); sampler.source.len()];
                let map = MappedMap::from_rows(source, sampler.source.width, sampler.source.height, grey);
                let (missing, passes) = Balance::new(&sampler).balance(map.texels());
                let texel = 4.0 * std::f64::consts::PI / missing.len() as f64;
                let missing: Vec<f64> = missing.iter().map(|seen| f64::from(seen.missing.abs()) / texel).collect();
                let worst = missing.iter().copied().fold(0.0, f64::max);
                let mean = missing.iter().sum::<f64>() / missing.len() as f64;
                println!(
                    "{source} {from} {target} {to}: missing at most {worst:.1e}, on average {mean:.1e}, {passes} passes"
                );
                assert!(
                    mean < MEAN_MISSING,
                    "{source} of {from} to {target} of {to} texels: {mean} is missing of each"
                );
                assert!(worst < MOST_MISSING, "{source} of {from} to {target} of {to} texels: {worst} is missing");
            }
        }
    }

    #[test]
    fn samples_that_are_not_kept_are_found_again() {
        let sampler = Sampler::new(grid(Mapping::LatLong, 600), grid(Mapping::Cube, 300), None);
        let mut random = lobe_testkit::Random::new(3);
        let texels = (0..sampler.source.len()).map(|_| Rgb::new(random.unit() as f32, 0.0, 0.0)).collect();
        let map = MappedMap::from_rows(Mapping::LatLong, sampler.source.width, sampler.source.height, texels);
        let mut balance = Balance::new(&sampler);
        balance.balance(map.texels());
        let kept = balance.gather(map.texels());
        balance.kept = Kept::Nothing;
        assert!(balance.gather(map.texels()) == kept, "with nothing kept");
        balance.kept = Kept::Samples(balance.ranges().into_iter().map(|texels| sampler.chunk(texels)).collect());
        assert!(balance.gather(map.texels()) == kept, "with samples kept");
    }
}
