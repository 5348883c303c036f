//! Balancing of resampling weights: constants and the energy of every source texel are kept.
//!
//! ```text
//!   L'_t = b Σ_s V_ts (L_s + q_s max(0, L_s - m_s))         V_ts = r_t W_ts c_s,   Σ_s V_ts = 1
//! ```

use lobe_io::parallel;
use lobe_sh::{Coefficient, Rgb};

use crate::error::EnvError;
use crate::map::mapped_map::MappedMap;
use crate::mapping::solid_angles::SolidAngles;
use crate::resample::lost::Lost;
use crate::resample::neighbor_clamp::NeighborClamp;
use crate::resample::passes::Passes;
use crate::resample::sample_points::Sampler;
use crate::resample::undersampled;
use crate::resample::weights::Weights;

// W_ts = Σ_samples of t, weight × bilinear weight of s at the sample: a mean of the source over the target's texel. The
// weights of a texel are normalized by r_t, which keeps constants. The energy of source texel s in the target is
//
//     E_s = Σ_t Ω_t V_ts       and should be Ω_s
//
// Factors c_s with E_s = Ω_s exist unless too few texels overlap [Sinkhorn and Knopp 1967]. Sinkhorn iteration
// multiplies c_s by Ω_s/E_s. In a_s = ln c_s that is, to first order, a step along the gradient Ω - E of a convex
// function, scaled by 1/E. Its second derivative
//
//     (M a)_s = Σ_t Ω_t V_ts (a_s - Σ_u V_tu a_u)
//
// is a graph Laplacian, whose eigenvalues relative to E lie between 0 and 1: steps of this length converge. They remove
// the beating of samples against texels in few passes, and are slow where energy has to move far: at poles, rims and
// edges. Each step goes on in the direction of the last one [Nesterov 1983], until the accuracy is reached that the
// light of this map needs.
//
// For large maps, in which the beats average out, no step is needed.
//
// The remaining deficit q_s = Ω_s/E_s - 1 is corrected at the texel itself, in proportion to its excess over the mean
// m_s of its neighbors: a uniform region stays uniform, nothing becomes negative, and a sun, L_s >> m_s, has
//
//     E_s (L_s + q_s (L_s - m_s)) = Ω_s L_s - (Ω_s - E_s) m_s
//
// its energy up to the fraction q_s m_s/L_s. The mean of the map then lacks exactly Σ (Ω_s - E_s) min(L_s, m_s): the
// error by which convergence is judged.
//
// What little the mean still lacks then is given to all texels in proportion: see `Lost`.
//
// Light that is not finite has no energy to keep: its texels are left out of these sums.

/// The most passes over all samples.
const MAX_PASSES: usize = 60;
/// The ratio of one step changes a weight by at most this factor; momentum adds to it.
const MOST_CHANGE: f64 = 2.0;

/// The weights between two maps, and what they are balanced against.
pub(crate) struct Balance<'a> {
    weights: Weights<'a>,
    /// Solid angles of the source's texels.
    solid_angles: SolidAngles,
}

impl<'a> Balance<'a> {
    /// Weights that are not balanced yet.
    fn new(sampler: &'a Sampler, passes: &mut Passes<'_>) -> Result<Self, EnvError> {
        Ok(Self { weights: Weights::new(sampler, passes)?, solid_angles: SolidAngles::new(sampler.source) })
    }

    /// Every texel of the target, from those of `map`, balanced as far as that map needs it.
    pub(crate) fn resample(
        sampler: &'a Sampler,
        mut map: MappedMap,
        passes: &mut Passes<'_>,
    ) -> Result<Vec<Rgb<f32>>, EnvError> {
        // Balance the weights.
        let mut balance = Self::new(sampler, passes)?;
        let (energies, _) = balance.balance(&map, passes)?;
        let factor = balance.lost(&energies, &map).factor();
        // Brighten each texel that exceeds its neighbors by the energy it would lose.
        balance.neighbor_clamp().add_excess(&mut map, |x, y| (balance.ratio(&energies, x, y) - 1.0) as f32);
        drop(energies);
        // Gather each target texel with the balanced weights.
        let mut gathered = balance.weights.gather(map.texels(), passes)?;
        // Give what the mean still lacks to all texels.
        if factor != Rgb::splat(1.0) {
            let scale = |_: usize, texels: &mut [Rgb<f32>]| texels.iter_mut().for_each(|l| *l = *l * factor);
            parallel::rows(&mut gathered, sampler.target.width, &scale);
        }
        Ok(gathered)
    }

    /// Finds the factors `c_s`; returns `E_s` of every texel and the number of passes.
    fn balance(&mut self, map: &MappedMap, passes: &mut Passes<'_>) -> Result<(Vec<f64>, usize), EnvError> {
        let mut count = 0;
        loop {
            count += 1;
            // Sum the energy that each source texel has in the target.
            let mut energies = self.weights.energies(passes)?;
            // Sample the texels that the target undersamples from the side of the source.
            if count == 1 {
                let extras = undersampled::additional_samples(self.weights.sampler(), &self.solid_angles, &energies);
                self.weights.add_extras(extras, &mut energies)?;
            }
            // Stop when the remaining deficits are below the limits.
            if count >= MAX_PASSES || self.lost(&energies, map).is_little() {
                return Ok((energies, count));
            }
            passes.another();
            // Scale the factors, and go on in the direction of the last step.
            let Self { weights, solid_angles } = self;
            let ratio = |x: usize, y: usize| {
                ratio(solid_angles.get(x, y), energies[y * map.width() + x]).clamp(1.0 / MOST_CHANGE, MOST_CHANGE)
            };
            weights.step(ratio, momentum(count));
        }
    }

    /// `Ω_s/E_s`.
    fn ratio(&self, energies: &[f64], x: usize, y: usize) -> f64 {
        ratio(self.solid_angles.get(x, y), self.energy(energies, x, y))
    }

    fn energy(&self, energies: &[f64], x: usize, y: usize) -> f64 {
        energies[y * self.weights.sampler().source.width + x]
    }

    /// The deficit `Ω_s - E_s`; 0 for a texel that no sample hits: a sliver too small to matter.
    fn missing(&self, energies: &[f64], x: usize, y: usize) -> f64 {
        let energy = self.energy(energies, x, y);
        if energy > 0.0 { self.solid_angles.get(x, y) - energy } else { 0.0 }
    }

    fn neighbor_clamp(&self) -> NeighborClamp<'_> {
        NeighborClamp::new(self.weights.sampler().source, &self.solid_angles)
    }

    /// The sums over the texels of `map` of what is lost.
    fn lost(&self, energies: &[f64], map: &MappedMap) -> Lost {
        let sums = self.neighbor_clamp().of_rows(map, |y, clamped| {
            let mut sums = Lost::default();
            for (x, (light, clamped)) in map.row(y).iter().zip(clamped).enumerate() {
                let solid_angle = self.solid_angles.get(x, y);
                // Texels outside the discs of a round picture may hold any value.
                if solid_angle > 0.0 {
                    sums.add(light.widen(), clamped.widen(), solid_angle, self.missing(energies, x, y));
                }
            }
            sums
        });
        sums.into_iter().fold(Lost::default(), |a, b| a + b)
    }
}

/// The part of the last change that step `k` repeats: 0 at first, then towards 1 a little faster than that of Nesterov,
/// `(k - 1)/(k + 2)`.
fn momentum(k: usize) -> f64 {
    if k == 1 { 0.0 } else { (k as f64 - 0.5) / (k + 1) as f64 }
}

/// `Ω_s/E_s`; 1 for a texel that no sample hits.
fn ratio(solid_angle: f64, energy: f64) -> f64 {
    if energy > 0.0 { solid_angle / energy } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use lobe_io::Job;
    use lobe_sh::Dir;

    use super::*;
    use crate::mapping::grid::Grid;
    use crate::mapping::mapping::Mapping;

    /// The largest deficit of a texel after the passes, relative to the mean texel: what the correction adds to it
    /// alone if it is bright. Of a sliver at the rim of a disc it may be more than half.
    const MOST_MISSING: f64 = 0.1;
    /// The same on average.
    const MEAN_MISSING: f64 = 0.005;

    /// Passes that nobody watches.
    fn unwatched() -> Passes<'static> {
        Passes::new(Job::default(), 0).unwrap()
    }

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
                let gray = vec![Rgb::splat(1.0); sampler.source.len()];
                let map = MappedMap::from_rows(source, sampler.source.width, sampler.source.height, gray);
                let mut balance = Balance::new(&sampler, &mut unwatched()).unwrap();
                let (energies, passes) = balance.balance(&map, &mut unwatched()).unwrap();
                let texel = 4.0 * std::f64::consts::PI / energies.len() as f64;
                let missing = |s: usize| balance.missing(&energies, s % map.width(), s / map.width()).abs() / texel;
                let missing: Vec<f64> = (0..energies.len()).map(missing).collect();
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
    fn maps_too_small_for_any_factors_have_light_that_is_a_number() {
        for (source, target) in Mapping::ALL.into_iter().flat_map(|s| Mapping::ALL.map(|t| (s, t))) {
            for (from, to) in [(8, 8), (8, 24), (24, 8)] {
                let sampler = Sampler::new(grid(source, from), grid(target, to), None);
                let suns = (0..sampler.source.len()).map(|k| Rgb::splat(if k % 5 == 0 { 1e4 } else { 1.0 })).collect();
                let map = MappedMap::from_rows(source, sampler.source.width, sampler.source.height, suns);
                let light = Balance::resample(&sampler, map, &mut unwatched()).unwrap();
                let is_number = |texel: &Rgb<f32>| texel.to_array().into_iter().all(f32::is_finite);
                assert!(light.iter().all(is_number), "{source} of {from} to {target} of {to} texels");
            }
        }
    }

    #[test]
    fn light_below_zero_takes_no_more_passes_than_light_above() {
        let sampler = Sampler::new(grid(Mapping::LatLong, 800), grid(Mapping::Cube, 600), None);
        let passes = |light: fn(Dir) -> Rgb<f32>| {
            let map = MappedMap::from_fn(Mapping::LatLong, sampler.source.width, sampler.source.height, light);
            let mut balance = Balance::new(&sampler, &mut unwatched()).unwrap();
            balance.balance(&map, &mut unwatched()).unwrap().1
        };
        let (above, below) = (passes(|_| Rgb::splat(1.0)), passes(|_| Rgb::splat(-1.0)));
        assert!(above == below && above < MAX_PASSES, "{above} passes for light of 1, {below} for light of -1");
        let around = passes(|s| Rgb::from(s.to_array().map(|c| c as f32)));
        assert!(around < MAX_PASSES, "{around} passes for light whose mean is 0");
    }

    #[test]
    fn samples_that_are_not_kept_are_found_again() {
        let sampler = Sampler::new(grid(Mapping::LatLong, 600), grid(Mapping::Cube, 300), None);
        let mut random = lobe_testkit::Random::new(3);
        let texels = (0..sampler.source.len()).map(|_| Rgb::new(random.unit() as f32, 0.0, 0.0)).collect();
        let map = MappedMap::from_rows(Mapping::LatLong, sampler.source.width, sampler.source.height, texels);
        let mut balance = Balance::new(&sampler, &mut unwatched()).unwrap();
        balance.balance(&map, &mut unwatched()).unwrap();
        let gathered = |balance: &Balance<'_>| balance.weights.gather(map.texels(), &mut unwatched()).unwrap();
        let kept = gathered(&balance);
        for all in [true, false] {
            balance.weights.forget(all);
            assert!(gathered(&balance) == kept, "with nothing kept: {all}; else samples only");
        }
    }

    /// The texels and energies.
    fn of_one_pass(weights: &Weights<'_>, map: &MappedMap) -> (Vec<Rgb<f32>>, Vec<f64>) {
        let texels = weights.gather(map.texels(), &mut unwatched()).unwrap();
        (texels, weights.energies(&mut unwatched()).unwrap())
    }

    /// The texels and energies found through windows with the given number of threads.
    fn found_by(threads: usize, weights: &Weights<'_>, map: &MappedMap) -> (Vec<Rgb<f32>>, Vec<f64>) {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| of_one_pass(weights, map))
    }

    #[test]
    fn windows_show_what_is_there() {
        // About as many texels in source and target, many fewer, many more; coarse enough to keep all views.
        for (from, to) in [(500_000, 400_000), (2_000, 900_000), (900_000, 60_000)] {
            let sampler = Sampler::new(grid(Mapping::LatLong, from), grid(Mapping::Cube, to), None);
            let map = MappedMap::from_fn(Mapping::LatLong, sampler.source.width, sampler.source.height, |s| {
                Rgb::new(1.5 + s.x() as f32, 1.0, 40.0 * s.z().max(0.0).powi(8) as f32)
            });
            let mut balance = Balance::new(&sampler, &mut unwatched()).unwrap();
            let mut energies = balance.weights.energies(&mut unwatched()).unwrap();
            let extras = undersampled::additional_samples(&sampler, &balance.solid_angles, &energies);
            balance.weights.add_extras(extras, &mut energies).unwrap();
            let (kept, energies) = of_one_pass(&balance.weights, &map);
            balance.weights.forget(true);
            let in_windows = balance.weights.texels_in_windows();
            assert!(2 * in_windows > kept.len(), "{from} to {to}: {in_windows} of {} texels in windows", kept.len());
            let (light, sums) = found_by(3, &balance.weights, &map);
            for (k, (found, kept)) in light.iter().zip(&kept).enumerate() {
                let error = (*found - *kept).to_array().map(|e| e.abs() / 40.0);
                assert!(error.iter().all(|e| *e < 1e-6), "{from} to {to}, texel {k}: {found:?}, not {kept:?}");
                assert!(found.g == 1.0, "{from} to {to}, texel {k}: a channel of 1 became {}", found.g);
            }
            // Relative to a texel's solid angle; sums in single precision have errors but no bias.
            let texel = 4.0 * std::f64::consts::PI / energies.len() as f64;
            let errors = || sums.iter().zip(&energies).map(|(found, kept)| (found - kept) / texel);
            let worst = errors().map(f64::abs).fold(0.0, f64::max);
            let mean = errors().sum::<f64>() / energies.len() as f64;
            assert!(worst < 2e-5 && mean.abs() < 1e-6, "{from} to {to}: energies off by {worst}, on average {mean}");
            assert!(
                found_by(1, &balance.weights, &map) == (light, sums),
                "{from} to {to}: one thread finds other bits"
            );
        }
    }
}
