//! Weights between two maps that keep both constants and the energy of every texel.
//!
//! ```text
//!   L'_t = Σ_s V_ts (L_s + q_s max(0, L_s - m_s))           V_ts = r_t W_ts c_s,   Σ_s V_ts = 1
//! ```

use std::ops::Range;

use lobe_sh::{Coefficient, Rgb};
use rayon::prelude::*;

use crate::MappedMap;
use crate::sample_points::{Chunk, Sample, Sampler, midpoints};
use crate::solid_angles::SolidAngles;

// W_ts = Σ_samples of t, weight × share of s in the interpolant there: a mean of the source over the target's texel. A
// constant stays constant because the weights of a texel are normalised. The energy of a texel s in the target is
//
//     E_s = Σ_t Ω_t V_ts       and should be Ω_s
//
// so its weights are multiplied by c_s = Ω_s/E_s, and normalised again, in turns [Sinkhorn and Knopp 1967]. That
// converges quickly where the samples merely beat against the texels, slowly where energy has to wander: at poles, rims
// and edges. So it is done a few times, for large maps, in which the beats average out, not at all, and
// q_s = Ω_s/E_s - 1 is what then is missing. It is given to the texel itself as far as it is brighter than the mean m_s
// of its neighbours: an even part of a map stays even, nothing becomes negative, and a sun, L_s >> m_s, has
//
//     E_s (L_s + q_s (L_s - m_s)) = Ω_s L_s - (Ω_s - E_s) m_s
//
// its energy but for a part q_s m_s/L_s. What is not brighter lacks q_s, which sums to 0 around any place.

/// The target is worked on in this many parts, whatever the number of threads.
const CHUNKS: usize = 64;
/// More samples than this are not kept from pass to pass but found again each time: 384 MiB.
const MOST_KEPT: usize = 1 << 25;
/// The most passes that find out what each texel of the source is given; the last one is for what then is missing.
const MOST_PASSES: usize = 24;
/// No more passes if the mean is off by less than this, as it is and as it would be by random signs: ten conversions make 1e-4.
const ENOUGH: f64 = 2e-5;
/// A texel of the source whose solid angle is this many times what the samples see is sampled from its own side too, and
/// no pass raises a weight by more.
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

/// The weights between two maps.
pub(crate) struct Balance<'a> {
    sampler: &'a Sampler,
    /// Of the texels of the source.
    source: SolidAngles,
    kept: Option<Vec<Chunk>>,
    extras: Vec<Extra>,
    /// `c_s`.
    factors: Vec<f32>,
    /// `q_s`.
    missing: Vec<f32>,
}

impl<'a> Balance<'a> {
    /// Balanced as far as `map` needs it.
    pub(crate) fn new(sampler: &'a Sampler, map: &MappedMap) -> Self {
        let mut balance = Self {
            sampler,
            source: SolidAngles::new(sampler.source),
            kept: None,
            extras: Vec::new(),
            factors: vec![1.0; sampler.source.len()],
            missing: Vec::new(),
        };
        if sampler.estimate() <= MOST_KEPT {
            balance.kept = Some(balance.ranges().into_par_iter().map(|texels| sampler.chunk(texels)).collect());
        }
        let target = SolidAngles::new(sampler.target);
        let light = balance.uncorrected(map);
        for pass in 1.. {
            let mut seen = balance.seen(|_| true, 1.0, &target);
            if pass == 1 {
                let (ratios, _) = balance.ratios(&seen, &light);
                balance.add_extras(&ratios, &mut seen, &target);
            }
            let (ratios, error) = balance.ratios(&seen, &light);
            if pass == MOST_PASSES || error < ENOUGH {
                // What shows so little that no sample falls into it has nothing to lose.
                let missing = |ratio: f32| if ratio.is_finite() { ratio - 1.0 } else { 0.0 };
                balance.missing = ratios.into_iter().map(missing).collect();
                break;
            }
            for (factor, ratio) in balance.factors.iter_mut().zip(&ratios) {
                *factor *= ratio.min(HARDLY_SEEN);
            }
        }
        balance
    }

    /// Every texel of the target, from the texels of the source.
    pub(crate) fn gather(&self, map: &MappedMap) -> Vec<Rgb<f32>> {
        let texels = self.corrected(map);
        let mut out = vec![Rgb::ZERO; self.sampler.target.len()];
        let size = self.chunk_size();
        out.par_chunks_mut(size).enumerate().for_each(|(chunk, out)| {
            let start = chunk * size;
            self.for_each_texel(
                start..start + out.len(),
                |_| true,
                |index, shares| {
                    let (mut light, mut sum): (Rgb<f64>, f64) = (Rgb::ZERO, 0.0);
                    for &(source, weight) in shares {
                        light += texels[source as usize].widen().scale(f64::from(weight));
                        sum += f64::from(weight);
                    }
                    if sum > 0.0 {
                        out[index - start] = Rgb::narrow(light.scale(1.0 / sum));
                    }
                },
            );
        });
        out
    }

    /// The texels of the source, those brighter than their neighbours with what they would lose.
    fn corrected(&self, map: &MappedMap) -> Vec<Rgb<f32>> {
        let width = map.width();
        let mut corrected = map.texels().to_vec();
        corrected.par_chunks_mut(width).zip(self.missing.par_chunks(width)).enumerate().for_each(
            |(y, (row, missing))| {
                for (x, (texel, missing)) in row.iter_mut().zip(missing).enumerate() {
                    let around = self.around(map, x, y);
                    *texel += Rgb::from_channels(|c| missing * (texel.channel(c) - around.channel(c)).max(0.0));
                }
            },
        );
        corrected
    }

    /// The mean of the up to eight neighbours of a texel in the picture that show something; without any, that texel.
    fn around(&self, map: &MappedMap, x: usize, y: usize) -> Rgb<f32> {
        let columns = x.saturating_sub(1)..map.width().min(x + 2);
        let (mut sum, mut count): (Rgb<f64>, f64) = (Rgb::ZERO, 0.0);
        for row in y.saturating_sub(1)..map.height().min(y + 2) {
            for (column, other) in columns.clone().zip(&map.row(row)[columns.clone()]) {
                if (column, row) != (x, y) && self.source.get(column, row) > 0.0 {
                    sum += other.widen();
                    count += 1.0;
                }
            }
        }
        if count > 0.0 { Rgb::narrow(sum.scale(1.0 / count)) } else { map.texel(x, y) }
    }

    fn chunk_size(&self) -> usize {
        self.sampler.target.len().div_ceil(CHUNKS)
    }

    fn ranges(&self) -> Vec<Range<usize>> {
        let (count, size) = (self.sampler.target.len(), self.chunk_size());
        (0..count.div_ceil(size)).map(|c| c * size..count.min((c + 1) * size)).collect()
    }

    /// Calls `texel(number, shares)` for those texels of a chunk that are wanted for their extras; a texel of the source
    /// may have several shares.
    fn for_each_texel(
        &self,
        range: Range<usize>,
        is_wanted: impl Fn(&[Extra]) -> bool,
        mut texel: impl FnMut(usize, &[Share]),
    ) {
        let made;
        let chunk = match &self.kept {
            Some(chunks) => &chunks[range.start / self.chunk_size()],
            None => {
                made = self.sampler.chunk(range);
                &made
            }
        };
        let mut samples = chunk.samples.as_slice();
        let mut extras = &self.extras[self.extras.partition_point(|e| (e.target as usize) < chunk.texels.start)..];
        let mut shares = Vec::new();
        for (index, count) in chunk.texels.clone().zip(&chunk.counts) {
            let (own, rest) = samples.split_at(*count as usize);
            let (own_extras, rest_extras) =
                extras.split_at(extras.iter().take_while(|e| e.target as usize == index).count());
            if is_wanted(own_extras) {
                shares.clear();
                self.add_shares(own, &mut shares);
                shares.extend(own_extras.iter().map(|e| (e.source, e.weight * self.factors[e.source as usize])));
                texel(index, &shares);
            }
            (samples, extras) = (rest, rest_extras);
        }
    }

    #[inline(always)]
    fn add_shares(&self, samples: &[Sample], shares: &mut Vec<Share>) {
        let grid = self.sampler.source;
        for sample in samples {
            if let Some(taps) = grid.inner_taps(sample.xy()) {
                let share = |(index, weight): Share| (index, sample.weight * weight * self.factors[index as usize]);
                shares.extend_from_slice(&taps.map(share));
                continue;
            }
            for (index, weight) in grid.taps(sample.point()).iter() {
                shares.push((index as u32, sample.weight * weight * self.factors[index]));
            }
        }
    }

    /// The solid angle, times `sign`, that each texel of the source has in those texels of the target that are wanted.
    fn seen(&self, is_wanted: impl Fn(&[Extra]) -> bool + Sync, sign: f64, target: &SolidAngles) -> Vec<SparseSum> {
        let width = self.sampler.target.width;
        let see = |range: Range<usize>| {
            let mut seen = SparseSum::new(self.sampler.source.len());
            self.for_each_texel(range, &is_wanted, |index, shares| {
                let sum: f64 = shares.iter().map(|(_, weight)| f64::from(*weight)).sum();
                if sum > 0.0 {
                    let scale = sign * target.get(index % width, index / width) / sum;
                    for &(source, weight) in shares {
                        seen.add(source as usize, scale * f64::from(weight));
                    }
                }
            });
            seen
        };
        self.ranges().into_par_iter().map(see).collect()
    }

    /// The solid angle of each texel of the source over the one that it has in the target, 1 where it shows nothing; and
    /// their differences in energy, in parts of all: the root of the sum of squares or the sum, whichever is larger.
    fn ratios(&self, seen: &[SparseSum], light: &[f32]) -> (Vec<f32>, f64) {
        let width = self.sampler.source.width;
        let mut ratios = vec![1.0; light.len()];
        let block_sums = |(block, (ratios, light)): (usize, (&mut [f32], &[f32]))| {
            let mut sums = [0.0; BLOCK];
            for part in seen {
                part.add_block(block, &mut sums);
            }
            let (mut squares, mut net, mut energy) = (0.0, 0.0, 0.0);
            for (i, (ratio, light)) in ratios.iter_mut().zip(light).enumerate() {
                let index = block * BLOCK + i;
                let solid_angle = self.source.get(index % width, index / width);
                if solid_angle > 0.0 {
                    *ratio = (solid_angle / sums[i]) as f32;
                    let missing = (solid_angle - sums[i]) * f64::from(*light);
                    squares += missing * missing;
                    net += missing;
                    energy += solid_angle * f64::from(*light);
                }
            }
            [squares, net, energy]
        };
        let sums: Vec<[f64; 3]> =
            ratios.par_chunks_mut(BLOCK).zip(light.par_chunks(BLOCK)).enumerate().map(block_sums).collect();
        let [squares, net, energy] = sums.iter().fold([0.0; 3], |a, b| [0, 1, 2].map(|k| a[k] + b[k]));
        (ratios, squares.sqrt().max(net.abs()) / energy)
    }

    /// What of the light of each texel of the source is not given back: as much as its neighbours have.
    fn uncorrected(&self, map: &MappedMap) -> Vec<f32> {
        let width = map.width();
        let mut light = vec![0.0; map.texels().len()];
        light.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
            for (x, (light, texel)) in row.iter_mut().zip(map.row(y)).enumerate() {
                let around = self.around(map, x, y);
                *light = (0..3).map(|c| texel.channel(c).min(around.channel(c))).sum();
            }
        });
        light
    }

    /// Samples the texels of the source of which the target sees too little, and sees again what they change.
    fn add_extras(&mut self, ratios: &[f32], seen: &mut Vec<SparseSum>, target: &SolidAngles) {
        let width = self.sampler.source.width;
        let found: Vec<Vec<Extra>> = ratios
            .par_chunks(BLOCK)
            .enumerate()
            .map(|(block, ratios)| {
                let mut extras = Vec::new();
                for (i, ratio) in ratios.iter().enumerate().filter(|(_, ratio)| **ratio >= HARDLY_SEEN) {
                    let index = block * BLOCK + i;
                    self.add_extra([index % width, index / width], 1.0 - 1.0 / f64::from(*ratio), &mut extras);
                }
                extras
            })
            .collect();
        self.extras = found.concat();
        self.extras.sort_by_key(|extra| extra.target);
        // What those texels of the target gave before the extras counted, and what they give with them.
        let weights: Vec<f32> = self.extras.iter().map(|extra| extra.weight).collect();
        self.extras.iter_mut().for_each(|extra| extra.weight = 0.0);
        seen.extend(self.seen(|extras| !extras.is_empty(), -1.0, target));
        self.extras.iter_mut().zip(weights).for_each(|(extra, weight)| extra.weight = weight);
        seen.extend(self.seen(|extras| !extras.is_empty(), 1.0, target));
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

/// Texels that are added up and held together.
const BLOCK: usize = 256;

/// A sum for each texel of the source, held in blocks, only where there is one.
struct SparseSum {
    /// 0 where there is none, or the place of the block, from 1.
    places: Vec<u32>,
    sums: Vec<[f64; BLOCK]>,
}

impl SparseSum {
    fn new(len: usize) -> Self {
        Self { places: vec![0; len.div_ceil(BLOCK)], sums: vec![[0.0; BLOCK]] }
    }

    #[inline(always)]
    fn add(&mut self, index: usize, value: f64) {
        let place = &mut self.places[index / BLOCK];
        if *place == 0 {
            *place = self.sums.len() as u32;
            self.sums.push([0.0; BLOCK]);
        }
        self.sums[*place as usize][index % BLOCK] += value;
    }

    fn add_block(&self, block: usize, sums: &mut [f64; BLOCK]) {
        let place = self.places[block];
        if place > 0 {
            for (sum, value) in sums.iter_mut().zip(&self.sums[place as usize]) {
                *sum += value;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Mapping;
    use crate::taps::Grid;

    /// The most that may be missing of a texel after the passes: what then is added to it alone if it is bright.
    const MOST_MISSING: f32 = 0.3;

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
                let balance = Balance::new(&sampler, &map);
                let worst = balance.missing.iter().fold(0.0, |worst: f32, q| worst.max(q.abs()));
                let mean = balance.missing.iter().map(|q| q.abs()).sum::<f32>() / balance.missing.len() as f32;
                println!("{source} {from} {target} {to}: missing at most {worst:.1e}, on average {mean:.1e}");
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
        let mut balance = Balance::new(&sampler, &map);
        let kept = balance.gather(&map);
        balance.kept = None;
        assert!(balance.gather(&map) == kept, "the two differ");
    }
}
