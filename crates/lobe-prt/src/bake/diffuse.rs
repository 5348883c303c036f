//! Diffuse transfer: the vectors of matte receivers by Monte Carlo sampling.

use lobe_scene::{Bvh, Ray, Scene, SurfaceRays};
use lobe_sh::{Dir, Expansion as _, Zonal};

use crate::bake::basis_sum::BasisSum;
use crate::bake::options::{AlbedoMode, BakeMode, BakeOptions};
use crate::bake::pilot::Piloted;
use crate::bake::point_transfer::{PathStart, PointTransfer};
use crate::bake::tracer::{PathEnd, Starts, Tracer};
use crate::job::chunks::{Estimator, Tally};
use crate::receivers::planes::is_below;
use crate::receivers::receivers::Receivers;
use crate::sampling::sobol::Sobol;
use crate::sampling::warp::Frame;
use crate::transfer::transfer::Channels;

/// The estimator of transfer vectors of receivers.
#[derive(Debug)]
pub(crate) struct Diffuse<'a> {
    pub(crate) paths: DiffusePaths<'a>,
    receivers: &'a Receivers,
}

/// The paths from a point, summed into its transfer vector.
///
/// ```text
///   Tᵢ = ρ/π ∫ max(n·s, 0) (path from s) ds ≈ ρ/N Σ_k w_k yᵢ(s_k),    paths k of N that escape
/// ```
///
/// Each path starts in a cosine-weighted direction, leaves along `s_k` and has met the albedos whose product is `w_k`.
/// One that starts below the planes of the triangles around the receiver ends there, as one that meets a surface.
#[derive(Debug)]
pub(crate) struct DiffusePaths<'a> {
    tracer: Tracer<'a>,
    options: &'a BakeOptions,
    pub(crate) bounces: usize,
    pub(crate) channels: Channels,
    /// The numbers of the paths from a point, so that neighbors follow each other.
    order: Vec<u32>,
    cosine: Zonal,
    density: Density,
}

/// The density of the directions in which paths start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Density {
    /// That of a matte receiver.
    Cosine,
    /// Uniform over the hemisphere above the surface, so that shadowed transfer is `∫ V(s) yᵢ(s) ds`: what is seen of
    /// the sky.
    Hemisphere,
}

/// The buffers of a thread.
pub(crate) struct Scratch {
    sum: BasisSum,
    directions: Vec<[f32; 3]>,
    occluded: Vec<bool>,
    starts: Starts,
}

impl<'a> Diffuse<'a> {
    pub(crate) fn new(scene: &'a Scene, bvh: &'a Bvh, receivers: &'a Receivers, options: &'a BakeOptions) -> Self {
        let channels = options.channels_for(scene, receivers.is_gray());
        let paths = DiffusePaths::new(
            SurfaceRays::new(scene, bvh),
            options,
            options.path_order(options.first_samples()),
            channels,
        );
        Self { paths, receivers }
    }

    fn albedo(&self, receiver: usize) -> [f64; 3] {
        match self.paths.options.albedo {
            AlbedoMode::Vertex => self.receivers.albedos()[receiver].map(f64::from),
            AlbedoMode::None => [1.0; 3],
        }
    }
}

impl<'a> DiffusePaths<'a> {
    /// Paths of these numbers from each point.
    pub(crate) fn new(
        surfaces: SurfaceRays<'a>,
        options: &'a BakeOptions,
        order: Vec<u32>,
        channels: Channels,
    ) -> Self {
        let cosine = Zonal::clamped_cosine(options.order);
        let (tracer, bounces) = (Tracer(surfaces), options.most_bounces());
        Self { tracer, options, bounces, channels, order, cosine, density: Density::Cosine }
    }

    /// The same paths with directions of another density.
    pub(crate) fn with_density(self, density: Density) -> Self {
        Self { density, ..self }
    }

    fn unshadowed(&self, start: &PathStart<'_>, row: &mut [f32]) -> Tally {
        let normal = Dir::from_f32(start.normal).unwrap_or(Dir::Z);
        let cosine = self.cosine.towards(normal, std::f64::consts::FRAC_1_PI);
        for (row, albedo) in row.chunks_exact_mut(self.bands()).zip(start.albedo) {
            row.iter_mut().zip(cosine.coefficients()).for_each(|(t, c)| *t = (albedo * c) as f32);
        }
        Tally { rays: 0, energy: vec![mean(start.albedo)], left: 0.0 }
    }

    fn shadowed(&self, start: &PathStart<'_>, scratch: &mut Scratch, row: &mut [f32]) -> Tally {
        let (frame, origin) = self.frame_and_origin(start);
        // What is seen of the sky ends at the surface, wherever the normal to shade with points.
        let open = Frame::about(start.planes.first().copied().unwrap_or(start.normal));
        let Scratch { sum, directions, occluded, .. } = scratch;
        // Trace shadow rays, all at once.
        directions.clear();
        let direction = |point| match self.density {
            Density::Cosine => frame.cosine(point),
            Density::Hemisphere => open.hemisphere(point),
        };
        directions.extend(self.order.iter().map(|&index| direction(start.sobol.point(start.first + index, 0))));
        occluded.resize(directions.len(), false);
        if self.tracer.0.is_tinted() {
            return self.shadowed_through_glass(start, origin, scratch, row);
        }
        self.tracer.0.occluded_from_into(origin, directions, occluded);
        // Add the basis in the directions that see the light.
        let (mut escaped, mut met) = (0_u32, 0_u32);
        for (direction, occluded) in directions.iter().zip(occluded) {
            if is_below(start.planes, *direction) {
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
        let factors = self.factors(start);
        let (first, others) = row.split_at_mut(self.bands());
        sum.take_into([1.0; 3], first);
        for (row, factor) in others.chunks_exact_mut(self.bands()).zip(&factors[1..]) {
            row.iter_mut().zip(&*first).for_each(|(t, sum)| *t = (f64::from(*sum) * factor) as f32);
        }
        first.iter_mut().for_each(|t| *t = (f64::from(*t) * factors[0]) as f32);
        let [escaped, met] = [escaped, met].map(|n| f64::from(n) * mean(factors));
        Tally { rays: self.order.len() as u64, energy: vec![escaped], left: met }
    }

    /// The same where glass tints the light: each direction in which it goes has a color.
    fn shadowed_through_glass(
        &self,
        start: &PathStart<'_>,
        origin: [f32; 3],
        scratch: &mut Scratch,
        row: &mut [f32],
    ) -> Tally {
        let factors = self.factors(start);
        let (mut escaped, mut met) = (0.0, 0.0);
        for &direction in scratch.directions.iter().filter(|direction| !is_below(start.planes, **direction)) {
            match self.tracer.0.passes_through(&Ray::new(origin, direction)) {
                Some(tint) => {
                    let is_gray = self.density == Density::Hemisphere;
                    let tint = if is_gray { [tint.iter().sum::<f32>() / 3.0; 3] } else { tint };
                    scratch.sum.push(direction, tint);
                    escaped += mean([0, 1, 2].map(|c| f64::from(tint[c]) * factors[c]));
                }
                None => met += mean(factors),
            }
        }
        scratch.sum.take_into(factors, row);
        Tally { rays: self.order.len() as u64, energy: vec![escaped], left: met }
    }

    fn interreflected(&self, start: &PathStart<'_>, scratch: &mut Scratch, row: &mut [f32]) -> Tally {
        let (frame, origin) = self.frame_and_origin(start);
        let factors = self.factors(start);
        let energy = |throughput: [f32; 3]| (0..3).map(|c| f64::from(throughput[c]) * factors[c]).sum::<f64>() / 3.0;
        let mut tally = Tally { energy: vec![0.0; self.bounces + 1], ..Tally::default() };
        // Start paths in cosine-weighted directions.
        let Scratch { sum, starts, .. } = scratch;
        starts.clear();
        for &index in &self.order {
            let number = start.first + index;
            let direction = frame.cosine(start.sobol.point(number, 0));
            if !is_below(start.planes, direction) {
                starts.push(direction, number);
            }
        }
        // Follow them to their ends.
        let Tally { rays, energy: escaped, left } = &mut tally;
        self.tracer.follow_all(origin, starts, self.bounces, start.sobol, rays, |_, end| match end {
            // Add the basis where the path escapes, times its throughput.
            PathEnd::Escaped { direction, throughput, bounce } => {
                sum.push(direction, throughput);
                escaped[bounce] += energy(throughput);
            }
            PathEnd::Left { throughput } => *left += energy(throughput),
            PathEnd::Absorbed => {}
        });
        scratch.sum.take_into(factors, row);
        tally
    }

    /// The axes of the directions of a point, and the origin of its rays.
    fn frame_and_origin(&self, start: &PathStart<'_>) -> (Frame, [f32; 3]) {
        (Frame::about(start.normal), self.tracer.origin_above(start.position, start.lift))
    }

    /// The factors of the sums over escaping paths, by channel.
    fn factors(&self, start: &PathStart<'_>) -> [f64; 3] {
        let measure = if self.density == Density::Cosine { 1.0 } else { std::f64::consts::TAU };
        start.albedo.map(|rho| measure * rho / self.order.len() as f64)
    }

    fn bands(&self) -> usize {
        self.options.order * self.options.order
    }
}

impl PointTransfer for DiffusePaths<'_> {
    type Scratch = Scratch;

    fn row(&self) -> usize {
        self.bands() * self.channels.count()
    }

    fn count(&self) -> usize {
        self.order.len()
    }

    fn bounces(&self) -> usize {
        self.bounces
    }

    fn limit_bounces(&mut self, bounces: usize) {
        self.bounces = bounces;
    }

    fn set_count(&mut self, count: u32) {
        self.order = self.options.path_order(count);
    }

    fn scratch(&self) -> Scratch {
        // Visibility alone has no hue, unless by glass.
        let channels =
            if self.options.mode.reflects() || self.tracer.0.is_tinted() { self.channels.count() } else { 1 };
        Scratch {
            sum: BasisSum::new(self.options.order, channels),
            directions: Vec::new(),
            occluded: Vec::new(),
            starts: Starts::default(),
        }
    }

    fn tracer(&self) -> Option<&Tracer<'_>> {
        (self.options.mode != BakeMode::Unshadowed).then_some(&self.tracer)
    }

    fn transfer(&self, start: &PathStart<'_>, scratch: &mut Scratch, row: &mut [f32]) -> Tally {
        match self.options.mode {
            BakeMode::Unshadowed => self.unshadowed(start, row),
            BakeMode::Shadowed => self.shadowed(start, scratch, row),
            BakeMode::Interreflected | BakeMode::Glossy => self.interreflected(start, scratch, row),
        }
    }

    fn sampling_error(&self, start: &PathStart<'_>, scratch: &mut Scratch, row: &mut [f32]) -> bool {
        if self.options.mode == BakeMode::Unshadowed || self.density != Density::Cosine {
            return false;
        }
        let (frame, _) = self.frame_and_origin(start);
        for &index in &self.order {
            scratch.sum.push(frame.cosine(start.sobol.point(start.first + index, 0)), [1.0; 3]);
        }
        scratch.sum.take_into(self.factors(start), row);
        let normal = Dir::from_f32(start.normal).unwrap_or(Dir::Z);
        let cosine = self.cosine.towards(normal, std::f64::consts::FRAC_1_PI);
        for row in row.chunks_exact_mut(self.bands()) {
            row.iter_mut().zip(cosine.coefficients()).for_each(|(t, c)| *t -= *c as f32);
        }
        true
    }
}

fn mean(channels: [f64; 3]) -> f64 {
    channels.iter().sum::<f64>() / 3.0
}

impl Piloted for Diffuse<'_> {
    fn limit_bounces(&mut self, bounces: usize) {
        self.paths.limit_bounces(bounces);
    }

    fn set_samples(&mut self, samples: u32) {
        self.paths.set_count(samples);
    }
}

impl Estimator for Diffuse<'_> {
    type Scratch = Scratch;

    fn receivers(&self) -> usize {
        self.receivers.len()
    }

    fn row(&self) -> usize {
        self.paths.row()
    }

    fn paths(&self) -> usize {
        self.paths.count()
    }

    fn scratch(&self) -> Scratch {
        self.paths.scratch()
    }

    fn seed(&self) -> u64 {
        self.paths.options.seed
    }

    fn estimate(&self, seed: u64, receiver: usize, scratch: &mut Scratch, row: &mut [f32]) -> Tally {
        let (position, normal) = (self.receivers.positions()[receiver], self.receivers.normals()[receiver]);
        let start = PathStart {
            position,
            normal,
            lift: self.receivers.lift(receiver),
            planes: self.receivers.planes(receiver),
            albedo: self.albedo(receiver),
            sobol: &Sobol::at_place(seed, position.into_iter().chain(normal), self.paths.bounces),
            first: 0,
        };
        self.paths.transfer(&start, scratch, row)
    }
}
