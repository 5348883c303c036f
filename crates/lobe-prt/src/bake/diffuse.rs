//! Diffuse transfer: the vectors of matte receivers by Monte Carlo sampling.

use lobe_scene::{Bvh, Ray, Scene, SurfaceRays};
use lobe_sh::{Dir, Expansion as _, Zonal};

use crate::bake::basis_sum::BasisSum;
use crate::bake::tracer::{PathEnd, Tracer};
use crate::job::chunks::{Estimator, Tally};
use crate::receivers::planes::is_below;
use crate::sampling::sobol::Sobol;
use crate::sampling::warp::Frame;
use crate::{AlbedoMode, BakeMode, BakeOptions, Channels, Receivers};

/// The estimator of transfer vectors.
///
/// ```text
///   Tᵢ = ρ/π ∫ max(n·s, 0) (path from s) ds ≈ ρ/N Σ_k w_k yᵢ(s_k),    paths k of N that escape
/// ```
///
/// Each path starts in a cosine-weighted direction, leaves along `s_k` and has met the albedos whose product is `w_k`.
/// One that starts below the planes of the triangles around the receiver ends there, as one that meets a surface.
#[derive(Debug)]
pub(crate) struct Diffuse<'a> {
    tracer: Tracer<'a>,
    receivers: &'a Receivers,
    options: &'a BakeOptions,
    pub(crate) bounces: usize,
    pub(crate) channels: Channels,
    order: Vec<u32>,
    cosine: Zonal,
}

/// The buffers of a thread.
pub(crate) struct Scratch {
    sum: BasisSum,
    directions: Vec<[f32; 3]>,
    occluded: Vec<bool>,
}

impl<'a> Diffuse<'a> {
    pub(crate) fn new(scene: &'a Scene, bvh: &'a Bvh, receivers: &'a Receivers, options: &'a BakeOptions) -> Self {
        Self {
            tracer: Tracer(SurfaceRays::new(scene, bvh)),
            receivers,
            options,
            bounces: options.most_bounces(),
            channels: options.channels_for(scene, receivers.is_gray()),
            order: options.path_order(),
            cosine: Zonal::clamped_cosine(options.order),
        }
    }

    fn unshadowed(&self, receiver: usize, row: &mut [f32]) -> Tally {
        let albedo = self.albedo(receiver);
        let normal = Dir::from_f32(self.receivers.normals()[receiver]).unwrap_or(Dir::Z);
        let cosine = self.cosine.towards(normal, std::f64::consts::FRAC_1_PI);
        for (row, albedo) in row.chunks_exact_mut(self.bands()).zip(albedo) {
            row.iter_mut().zip(cosine.coefficients()).for_each(|(t, c)| *t = (albedo * c) as f32);
        }
        Tally { rays: 0, energy: vec![mean(albedo)], left: 0.0 }
    }

    fn shadowed(&self, seed: u64, receiver: usize, scratch: &mut Scratch, row: &mut [f32]) -> Tally {
        let (sobol, frame, origin) = self.start(seed, receiver);
        let Scratch { sum, directions, occluded } = scratch;
        // Trace shadow rays in cosine-weighted directions, all at once.
        directions.clear();
        directions.extend(self.order.iter().map(|&index| frame.cosine(sobol.point(index, 0))));
        occluded.resize(directions.len(), false);
        if self.tracer.0.is_tinted() {
            return self.shadowed_through_glass(receiver, origin, scratch, row);
        }
        self.tracer.0.occluded_from_into(origin, directions, occluded);
        // Add the basis in the directions that see the light.
        let planes = self.receivers.planes(receiver);
        let (mut escaped, mut met) = (0_u32, 0_u32);
        for (direction, occluded) in directions.iter().zip(occluded) {
            if is_below(planes, *direction) {
                continue;
            }
            if *occluded {
                met += 1;
            } else {
                sum.push(*direction, [1.0; 3]);
                escaped += 1;
            }
        }
        // Scale the sums by the albedo, channel by channel.
        let factors = self.factors(receiver);
        let (first, others) = row.split_at_mut(self.bands());
        sum.take_into([1.0; 3], first);
        for (row, factor) in others.chunks_exact_mut(self.bands()).zip(&factors[1..]) {
            row.iter_mut().zip(&*first).for_each(|(t, sum)| *t = (f64::from(*sum) * factor) as f32);
        }
        first.iter_mut().for_each(|t| *t = (f64::from(*t) * factors[0]) as f32);
        let [escaped, met] = [escaped, met].map(|n| f64::from(n) * mean(factors));
        Tally { rays: u64::from(self.options.samples), energy: vec![escaped], left: met }
    }

    /// The same where glass tints the light: each direction in which it goes has a color.
    fn shadowed_through_glass(
        &self,
        receiver: usize,
        origin: [f32; 3],
        scratch: &mut Scratch,
        row: &mut [f32],
    ) -> Tally {
        let (planes, factors) = (self.receivers.planes(receiver), self.factors(receiver));
        let (mut escaped, mut met) = (0.0, 0.0);
        for &direction in scratch.directions.iter().filter(|direction| !is_below(planes, **direction)) {
            match self.tracer.0.passes_through(&Ray::new(origin, direction)) {
                Some(tint) => {
                    scratch.sum.push(direction, tint);
                    escaped += mean([0, 1, 2].map(|c| f64::from(tint[c]) * factors[c]));
                }
                None => met += mean(factors),
            }
        }
        scratch.sum.take_into(factors, row);
        Tally { rays: u64::from(self.options.samples), energy: vec![escaped], left: met }
    }

    fn interreflected(&self, seed: u64, receiver: usize, scratch: &mut Scratch, row: &mut [f32]) -> Tally {
        let (sobol, frame, origin) = self.start(seed, receiver);
        let factors = self.factors(receiver);
        let energy = |throughput: [f32; 3]| (0..3).map(|c| f64::from(throughput[c]) * factors[c]).sum::<f64>() / 3.0;
        let planes = self.receivers.planes(receiver);
        let mut tally = Tally { energy: vec![0.0; self.bounces + 1], ..Tally::default() };
        for &index in &self.order {
            // Start a path in a cosine-weighted direction.
            let direction = frame.cosine(sobol.point(index, 0));
            if is_below(planes, direction) {
                continue;
            }
            // Follow it to its end.
            let ray = Ray::new(origin, direction);
            match self.tracer.follow(ray, self.bounces, &sobol, index, &mut tally.rays) {
                // Add the basis where the path escapes, times its throughput.
                PathEnd::Escaped { direction, throughput, bounce } => {
                    scratch.sum.push(direction, throughput);
                    tally.energy[bounce] += energy(throughput);
                }
                PathEnd::Left { throughput } => tally.left += energy(throughput),
                PathEnd::Absorbed => {}
            }
        }
        scratch.sum.take_into(factors, row);
        tally
    }

    /// The sequences, the axes and the origin of a receiver's paths.
    fn start(&self, seed: u64, receiver: usize) -> (Sobol, Frame, [f32; 3]) {
        let (position, normal) = (self.receivers.positions()[receiver], self.receivers.normals()[receiver]);
        let sobol = Sobol::at_place(seed, position.into_iter().chain(normal), self.bounces);
        (sobol, Frame::about(normal), self.tracer.origin_above(position, self.receivers.lift(receiver)))
    }

    fn albedo(&self, receiver: usize) -> [f64; 3] {
        match self.options.albedo {
            AlbedoMode::Vertex => self.receivers.albedos()[receiver].map(f64::from),
            AlbedoMode::None => [1.0; 3],
        }
    }

    /// The factors of the sums over escaping paths, by channel.
    fn factors(&self, receiver: usize) -> [f64; 3] {
        self.albedo(receiver).map(|rho| rho / f64::from(self.options.samples))
    }

    fn bands(&self) -> usize {
        self.options.order * self.options.order
    }
}

fn mean(channels: [f64; 3]) -> f64 {
    channels.iter().sum::<f64>() / 3.0
}

impl Estimator for Diffuse<'_> {
    type Scratch = Scratch;

    fn receivers(&self) -> usize {
        self.receivers.len()
    }

    fn row(&self) -> usize {
        self.bands() * self.channels.count()
    }

    fn paths(&self) -> usize {
        self.order.len()
    }

    fn scratch(&self) -> Scratch {
        // Visibility alone has no hue, unless by glass.
        let channels =
            if self.options.mode.reflects() || self.tracer.0.is_tinted() { self.channels.count() } else { 1 };
        Scratch { sum: BasisSum::new(self.options.order, channels), directions: Vec::new(), occluded: Vec::new() }
    }

    fn seed(&self) -> u64 {
        self.options.seed
    }

    fn estimate(&self, seed: u64, receiver: usize, scratch: &mut Scratch, row: &mut [f32]) -> Tally {
        match self.options.mode {
            BakeMode::Unshadowed => self.unshadowed(receiver, row),
            BakeMode::Shadowed => self.shadowed(seed, receiver, scratch, row),
            BakeMode::Interreflected | BakeMode::Glossy => self.interreflected(seed, receiver, scratch, row),
        }
    }
}
