//! Weights between two maps that keep both constants and the energy of every texel.
//!
//! ```text
//!   L'_t = Σ_s V_ts (L_s + q_s max(0, L_s - m))            V_ts = r_t W_ts c_s,   Σ_s V_ts = 1
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
// so its weights are multiplied by c_s = Ω_s/E_s, and normalised again, in turns (Sinkhorn and Knopp 1967). That
// converges quickly where the samples merely beat against the texels, slowly where energy has to wander: at poles, rims
// and edges. So it is done a few times, and q_s = Ω_s/E_s - 1 is what then is missing. It is given to the texel itself as
// far as it is brighter than the mean m of the map: a constant is still constant, nothing becomes negative, and a sun,
// L_s >> m, has
//
//     E_s (L_s + q_s (L_s - m)) = Ω_s L_s - (Ω_s - E_s) m
//
// its energy but for a part q_s m/L_s. What is not brighter lacks q_s, which sums to 0 around any place.

/// The target is worked on in this many parts, whatever the number of threads.
const CHUNKS: usize = 64;
/// More samples than this are not kept from pass to pass but found again each time: 768 MiB.
const MOST_KEPT: usize = 1 << 26;
/// Passes that find out what each texel of the source is given; the last one is for what then is still missing.
const PASSES: usize = 3;
/// A texel of the source whose solid angle is this many times what the samples see is sampled from its own side too.
const HARDLY_SEEN: f32 = 2.0;

/// A sample from the side of the source: it belongs to a texel of the target and sees one texel of the source.
#[derive(Clone, Copy, Debug)]
struct Extra {
    target: u32,
    source: u32,
    weight: f32,
}

/// The weights between two maps.
pub(crate) struct Balance<'a> {
    sampler: &'a Sampler,
    source: SolidAngles,
    target: SolidAngles,
    kept: Option<Vec<Chunk>>,
    extras: Vec<Extra>,
    /// `c_s`.
    factors: Vec<f32>,
    /// `q_s`.
    missing: Vec<f32>,
}

impl<'a> Balance<'a> {
    pub(crate) fn new(sampler: &'a Sampler) -> Self {
        let mut balance = Self {
            sampler,
            source: SolidAngles::new(sampler.source),
            target: SolidAngles::new(sampler.target),
            kept: None,
            extras: Vec::new(),
            factors: vec![1.0; sampler.source.len()],
            missing: Vec::new(),
        };
        if sampler.estimate() <= MOST_KEPT {
            balance.kept = Some(balance.ranges().into_par_iter().map(|texels| sampler.chunk(texels)).collect());
        }
        for pass in 0..PASSES {
            let seen = balance.seen();
            let ratios = balance.ratios(&seen);
            if pass + 1 == PASSES {
                balance.missing = ratios.into_iter().map(|ratio| ratio - 1.0).collect();
                break;
            }
            if pass == 0 {
                balance.add_extras(&ratios);
            }
            for (factor, ratio) in balance.factors.iter_mut().zip(&ratios) {
                *factor *= if *ratio < HARDLY_SEEN { *ratio } else { 1.0 };
            }
        }
        balance
    }

    /// Every texel of the target, from the texels of the source.
    pub(crate) fn gather(&self, map: &MappedMap) -> Vec<Rgb<f32>> {
        let (texels, mean) = (map.texels(), Rgb::<f32>::narrow(map.mean()));
        let parts: Vec<Vec<Rgb<f32>>> = self
            .ranges()
            .into_par_iter()
            .map(|range| {
                let mut out = Vec::with_capacity(range.len());
                self.for_each_texel(range, |_, samples, extras| {
                    let (mut light, mut sum): (Rgb<f64>, f64) = (Rgb::ZERO, 0.0);
                    self.for_each_weight(samples, extras, |index, weight| {
                        let texel = texels[index];
                        let above = |c: usize| (texel.channel(c) - mean.channel(c)).max(0.0);
                        let bright = Rgb::<f32>::from_channels(above);
                        light += (texel + bright.scale(self.missing[index])).widen().scale(weight);
                        sum += weight;
                    });
                    out.push(if sum > 0.0 { Rgb::narrow(light.scale(1.0 / sum)) } else { Rgb::ZERO });
                });
                out
            })
            .collect();
        parts.concat()
    }

    fn ranges(&self) -> Vec<Range<usize>> {
        let count = self.sampler.target.len();
        let size = count.div_ceil(CHUNKS);
        (0..count.div_ceil(size)).map(|c| c * size..count.min((c + 1) * size)).collect()
    }

    /// Calls `texel(number, samples, extras)` for all texels of a chunk.
    fn for_each_texel(&self, range: Range<usize>, mut texel: impl FnMut(usize, &[Sample], &[Extra])) {
        let made;
        let chunk = match &self.kept {
            Some(chunks) => &chunks[range.start / self.sampler.target.len().div_ceil(CHUNKS)],
            None => {
                made = self.sampler.chunk(range);
                &made
            }
        };
        let mut samples = chunk.samples.as_slice();
        let mut extras = &self.extras[self.extras.partition_point(|e| (e.target as usize) < chunk.texels.start)..];
        for (index, count) in chunk.texels.clone().zip(&chunk.counts) {
            let (own, rest) = samples.split_at(*count as usize);
            let (own_extras, rest_extras) =
                extras.split_at(extras.iter().take_while(|e| e.target as usize == index).count());
            texel(index, own, own_extras);
            (samples, extras) = (rest, rest_extras);
        }
    }

    /// Calls `f(texel of the source, weight with its factor)`.
    #[inline(always)]
    fn for_each_weight(&self, samples: &[Sample], extras: &[Extra], mut f: impl FnMut(usize, f64)) {
        for sample in samples {
            for (index, weight) in self.sampler.source.taps(sample.point()).iter() {
                f(index, f64::from(sample.weight) * f64::from(weight * self.factors[index]));
            }
        }
        for extra in extras {
            let index = extra.source as usize;
            f(index, f64::from(extra.weight) * f64::from(self.factors[index]));
        }
    }

    /// The solid angle that each texel of the source has in the target.
    fn seen(&self) -> Vec<SparseSum> {
        let width = self.sampler.target.width;
        self.ranges()
            .into_par_iter()
            .map(|range| {
                let mut seen = SparseSum::new(self.sampler.source.len());
                self.for_each_texel(range, |index, samples, extras| {
                    let mut sum = 0.0;
                    self.for_each_weight(samples, extras, |_, weight| sum += weight);
                    if sum > 0.0 {
                        let scale = self.target.get(index % width, index / width) / sum;
                        self.for_each_weight(samples, extras, |index, weight| seen.add(index, scale * weight));
                    }
                });
                seen
            })
            .collect()
    }

    /// The solid angle of each texel of the source over the one that it has in the target; 1 where it shows nothing.
    fn ratios(&self, seen: &[SparseSum]) -> Vec<f32> {
        let width = self.sampler.source.width;
        let mut ratios = vec![1.0; self.sampler.source.len()];
        ratios.par_chunks_mut(BLOCK).enumerate().for_each(|(block, ratios)| {
            let mut sums = [0.0; BLOCK];
            for part in seen {
                part.add_block(block, &mut sums);
            }
            for (i, ratio) in ratios.iter_mut().enumerate() {
                let index = block * BLOCK + i;
                let solid_angle = self.source.get(index % width, index / width);
                if solid_angle > 0.0 {
                    *ratio = (solid_angle / sums[i]) as f32;
                }
            }
        });
        ratios
    }

    /// Samples the texels of the source of which the target sees too little.
    fn add_extras(&mut self, ratios: &[f32]) {
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
                let balance = Balance::new(&sampler);
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
        let mut balance = Balance::new(&sampler);
        let kept = balance.gather(&map);
        balance.kept = None;
        assert!(balance.gather(&map) == kept, "the two differ");
    }
}
