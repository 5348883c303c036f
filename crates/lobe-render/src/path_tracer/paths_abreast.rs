//! Paths abreast: each step of many paths is done for all of them before the next.

use lobe_scene::Ray;
use lobe_sh::sphere::vector::Vec3;
use lobe_sh::{Coefficient as _, Dir, Rgb};

use crate::path_tracer::distant_light::LightSample;
use crate::path_tracer::emitter::Emitter;
use crate::path_tracer::path_tracer::{Interaction, LightStrategy, PathStart, PathTracer, Purpose, is_below};

/// The state of paths that are followed abreast.
///
/// The steps of one path wait for each other, and for memory: where its direction lies in the table of the light, which
/// texel that is, what its ray meets. Those of different paths do not, so the processor works at several at once. Each
/// path has the numbers and the sums that it has alone, bit by bit (test
/// `paths_have_the_same_radiance_alone_and_abreast`).
struct PathsAbreast<'s> {
    starts: &'s [PathStart<'s>],
    /// Where each path is; none at its start.
    at: Vec<Option<Interaction>>,
    throughput: Vec<Rgb<f64>>,
    sums: Vec<Rgb<f64>>,
    /// Those that go on, in their order.
    going: Vec<usize>,
}

/// A direction that a path goes on in.
struct Drawn {
    path: usize,
    towards: Vec3,
    density: f64,
}

impl PathsAbreast<'_> {
    fn at(&self, path: usize) -> &Interaction {
        self.at[path].as_ref().unwrap_or(self.starts[path].at)
    }

    fn pair(&self, path: usize, purpose: Purpose, bounce: usize) -> [f64; 2] {
        self.starts[path].numbers.pair(purpose.at(bounce))
    }

    fn add(&mut self, path: usize, light: Rgb<f64>) {
        self.sums[path] += self.throughput[path] * light;
    }
}

impl PathTracer<'_> {
    /// One estimate for each path of the light that leaves its start, reflected by at most `bounces` surfaces before,
    /// under the distant light and these lamps.
    pub(crate) fn exit_radiances(
        &self,
        emitters: &[Emitter],
        starts: &[PathStart<'_>],
        bounces: usize,
    ) -> Vec<Rgb<f64>> {
        let (strategy, has_emission) = (self.options().strategy, self.has_emission());
        let count = starts.len();
        let mut paths = PathsAbreast {
            starts,
            at: (0..count).map(|_| None).collect(),
            throughput: vec![Rgb::splat(1.0); count],
            sums: vec![Rgb::ZERO; count],
            going: (0..count).collect(),
        };
        for bounce in 0..=bounces {
            // Add the light of directions drawn from the light.
            if strategy != LightStrategy::Bsdf {
                self.add_next_events(&mut paths, bounce);
            }
            if !emitters.is_empty() {
                self.add_emitted_light(&mut paths, emitters, bounce);
            }
            let is_last = bounce == bounces;
            if is_last && strategy == LightStrategy::NextEvent && !has_emission {
                break;
            }
            // Draw directions from the BSDFs, and trace their rays; at the last bounce it only matters which escape,
            // unless surfaces emit light.
            let (drawn, rays) = draw(&mut paths, bounce);
            paths.going.clear();
            if is_last && !has_emission {
                self.end(&mut paths, drawn, &rays);
            } else {
                self.go_on(&mut paths, drawn, &rays);
            }
        }
        paths.sums
    }

    /// Next-event estimation: adds the light that one direction drawn from the light brings to each interaction.
    fn add_next_events(&self, paths: &mut PathsAbreast<'_>, bounce: usize) {
        // Draw directions from the light.
        let numbers: Vec<_> = paths.going.iter().map(|&path| paths.pair(path, Purpose::Light, bounce)).collect();
        let samples = self.light().samples(&numbers);
        // Evaluate the BSDFs towards them.
        let (mut lit, mut rays) = (Vec::with_capacity(numbers.len()), Vec::with_capacity(numbers.len()));
        for (&path, LightSample { towards, met }) in paths.going.iter().zip(&samples) {
            let (at, s) = (paths.at(path), towards.to_array());
            let (value, density) = at.bsdf.eval(s);
            if density > 0.0 && !is_below(&at.planes, s) {
                lit.push((path, value, density, met));
                rays.push(Ray::new(at.origin, s.map(|c| c as f32)));
            }
        }
        // Trace the shadow rays, and weight what passes against the same directions drawn from the BSDFs.
        let is_alone = self.options().strategy == LightStrategy::NextEvent;
        for ((path, value, density, met), tint) in lit.into_iter().zip(self.pass(&rays)) {
            let Some(tint) = tint else { continue };
            let (radiance, of_light) = self.light().radiance_and_density(met);
            let weight = if is_alone { 1.0 } else { power_heuristic(of_light, density) };
            paths.add(path, (value * radiance * tint).scale(weight / of_light));
        }
    }

    /// Adds the light that one direction drawn from each emitter brings to each interaction.
    fn add_emitted_light(&self, paths: &mut PathsAbreast<'_>, emitters: &[Emitter], bounce: usize) {
        let count = paths.going.len() * emitters.len();
        let (mut lit, mut rays) = (Vec::with_capacity(count), Vec::with_capacity(count));
        for &path in &paths.going {
            let at = paths.at(path);
            let numbers = paths.pair(path, Purpose::Emitter, bounce);
            for emitter in emitters {
                let Some(sample) = emitter.sample(at.origin.map(f64::from), numbers) else { continue };
                let (value, density) = at.bsdf.eval(sample.towards);
                if density <= 0.0 || is_below(&at.planes, sample.towards) {
                    continue;
                }
                let t_max = (sample.distance * (1.0 - BEFORE_EMITTER)) as f32;
                let scale = sample.density.recip();
                lit.push((path, value * sample.radiance, scale));
                rays.push(Ray { t_max, ..Ray::new(at.origin, sample.towards.map(|c| c as f32)) });
            }
        }
        // The light of all lamps is added up before it takes the way of the path.
        let mut light = vec![Rgb::<f64>::ZERO; paths.sums.len()];
        for ((path, value, scale), tint) in lit.into_iter().zip(self.pass(&rays)) {
            if let Some(tint) = tint {
                light[path] += (value * tint).scale(scale);
            }
        }
        for k in 0..paths.going.len() {
            let path = paths.going[k];
            paths.add(path, light[path]);
        }
    }

    /// Adds the light of the last directions that escape.
    fn end(&self, paths: &mut PathsAbreast<'_>, drawn: Vec<Drawn>, rays: &[Ray]) {
        let mut escaped = Vec::with_capacity(drawn.len());
        for (drawn, tint) in drawn.into_iter().zip(self.pass(rays)) {
            if let Some(tint) = tint {
                paths.throughput[drawn.path] = paths.throughput[drawn.path] * tint;
                escaped.push(drawn);
            }
        }
        self.add_escaped(paths, &escaped);
    }

    /// Goes on from the surfaces that are hit, and adds the light of directions that escape.
    fn go_on(&self, paths: &mut PathsAbreast<'_>, drawn: Vec<Drawn>, rays: &[Ray]) {
        let hits = self.intersections(rays);
        let mut escaped = Vec::with_capacity(drawn.len());
        for ((drawn, ray), (hit, tint)) in drawn.into_iter().zip(rays).zip(hits) {
            let path = drawn.path;
            paths.throughput[path] = paths.throughput[path] * tint;
            match hit {
                None => escaped.push(drawn),
                Some(hit) => {
                    paths.at[path] = self.interaction(ray, &hit);
                    if let Some(at) = &paths.at[path] {
                        let emission = at.emission;
                        paths.add(path, emission);
                        paths.going.push(path);
                    }
                }
            }
        }
        if self.options().strategy != LightStrategy::NextEvent {
            self.add_escaped(paths, &escaped);
        }
    }

    /// Adds the light of directions drawn from the BSDFs.
    fn add_escaped(&self, paths: &mut PathsAbreast<'_>, escaped: &[Drawn]) {
        let is_alone = self.options().strategy == LightStrategy::Bsdf;
        let met = self.light().meet(escaped.iter().map(|drawn| Dir::from_unit(drawn.towards)));
        for (&Drawn { path, density, .. }, met) in escaped.iter().zip(&met) {
            let (radiance, of_light) = self.light().radiance_and_density(met);
            let weight = if is_alone { 1.0 } else { power_heuristic(density, of_light) };
            paths.sums[path] += (paths.throughput[path] * radiance).scale(weight);
        }
    }
}

/// Draws a direction from the BSDF of each path that goes on, and updates its throughput; leaves out paths that end.
fn draw(paths: &mut PathsAbreast<'_>, bounce: usize) -> (Vec<Drawn>, Vec<Ray>) {
    let (mut drawn, mut rays) = (Vec::with_capacity(paths.going.len()), Vec::with_capacity(paths.going.len()));
    for k in 0..paths.going.len() {
        let path = paths.going[k];
        let at = paths.at(path);
        let choice = || paths.starts[path].numbers.one(Purpose::Lobe.at(bounce));
        let Some(sample) = at.bsdf.sample(paths.pair(path, Purpose::Surface, bounce), choice) else { continue };
        if is_below(&at.planes, sample.towards) {
            continue;
        }
        rays.push(Ray::new(at.origin, sample.towards.map(|c| c as f32)));
        drawn.push(Drawn { path, towards: sample.towards, density: sample.density });
        paths.throughput[path] = paths.throughput[path] * sample.weight;
    }
    (drawn, rays)
}

/// The part of the way to an emitter at its end in which nothing hides it, such as the wall that it lies on.
const BEFORE_EMITTER: f64 = 1e-4;

/// The power heuristic with exponent 2 [Veach and Guibas 1995], `p² / (p² + q²)`: the weight of a direction drawn with
/// density `p > 0` by a strategy, where the other one would draw it with density `q ≥ 0`.
fn power_heuristic(p: f64, q: f64) -> f64 {
    // As ratios, so that squares of large densities do not overflow.
    let ratio = q / p;
    1.0 / (1.0 + ratio * ratio)
}

#[cfg(test)]
mod tests {
    use lobe_env::bundled;
    use lobe_prt::Receivers;
    use lobe_scene::{Bvh, built_in};
    use lobe_sh::Rotation;
    use lobe_shadow::{LampSurface, Placement};

    use super::*;
    use crate::path_tracer::distant_light::DistantLight;
    use crate::path_tracer::estimate::SampleCount;
    use crate::path_tracer::path_tracer::{PathOptions, PathReceiver};
    use crate::path_tracer::surfaces::Surfaces;

    #[test]
    fn paths_have_the_same_radiance_alone_and_abreast() {
        let scene = built_in::columns_hall(4);
        let bvh = Bvh::new(&scene);
        let light = DistantLight::from_map(bundled::sunset().map());
        let receivers = Receivers::at_vertices(&scene).unwrap();
        let lamp = LampSurface::ball(0.3, Rgb::splat(2.0));
        let lamps = [Emitter::new(&lamp, &Placement::new([0.0, 0.0, 2.0], Rotation::IDENTITY, 1.0))];
        for strategy in [LightStrategy::MultipleImportance, LightStrategy::Bsdf, LightStrategy::NextEvent] {
            let options = PathOptions { strategy, surfaces: Surfaces::MetallicRoughness, ..PathOptions::default() };
            let tracer = PathTracer::new(&scene, &bvh, &light, options);
            // From many places, so that paths differ in length.
            let places: Vec<_> = (0..receivers.len()).step_by(receivers.len() / 9).collect();
            let starts = places.iter().map(|&k| tracer.receiver_interaction(&PathReceiver::of(&receivers, k)));
            let starts: Vec<_> = starts.collect();
            let mut paths = Vec::new();
            for (at, place) in starts.iter().zip(places) {
                tracer.for_each_group(place, &SampleCount::of(16), |_, numbers| {
                    paths.extend(numbers.iter().map(|&numbers| PathStart { at, numbers }));
                });
            }
            let together = tracer.exit_radiances(&lamps, &paths, 3);
            let alone: Vec<_> = paths.chunks(1).flat_map(|path| tracer.exit_radiances(&lamps, path, 3)).collect();
            assert_eq!(together, alone, "{strategy:?}");
            assert!(together.iter().filter(|&&c| c != Rgb::ZERO).count() > 20, "{strategy:?}: {together:?}");
        }
    }
}
