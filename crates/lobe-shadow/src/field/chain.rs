//! The chain of products for sixteen receivers side by side.

use lobe_sh::product::{product_into, product_of_blocks};
use lobe_sh::rotation::RotationMatrices;
use lobe_sh::simd::{LANES, Lanes, Machine, Wide, constant};
use lobe_sh::{Rgb, Zonal};
use pulp::{Simd, WithSimd};

use crate::field::field_grid::RadialInterpolation;
use crate::field::nearest_first::{Met, MetKind, Sights};
use crate::field::placed::{Expansions, LookUp, Placed, Positions, ZERO};
use crate::field::radiance_field::RadianceField;
use crate::lane_basis::LaneBasis;

/// What a receiver multiplies light by: `channels` expansions for each.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Response<'a> {
    /// The clamped cosine about the normal, over π.
    Cosine,
    /// Transfer vectors, row after row.
    Transfer { rows: &'a [f32], channels: usize },
}

/// A lamp where it is.
#[derive(Debug)]
pub(crate) struct PlacedLamp<'a> {
    pub(crate) field: &'a RadianceField,
    pub(crate) placement: crate::Placement,
    /// The middle of the lamp in the world.
    pub(crate) center: [f64; 3],
    pub(crate) turn: Option<RotationMatrices<f32>>,
}

/// Everything that receivers share.
#[derive(Debug)]
pub(crate) struct Chain<'a> {
    pub(crate) machine: Machine,
    pub(crate) order: usize,
    pub(crate) entities: Vec<Placed<'a>>,
    pub(crate) lamps: Vec<PlacedLamp<'a>>,
    pub(crate) negligible: f32,
    pub(crate) interpolation: RadialInterpolation,
    pub(crate) basis: LaneBasis,
    /// For each band the factor of the clamped cosine over π.
    pub(crate) cosine: Vec<f32>,
}

/// The receivers of one pass, up to sixteen; the last one fills up.
#[derive(Clone, Debug)]
pub(crate) struct Group<'a> {
    pub(crate) positions: Positions,
    /// None where the horizon is not to be looked at.
    pub(crate) normals: Option<[Lanes; 3]>,
    /// `order²` numbers for each, or nothing.
    pub(crate) own: [Option<&'a [f32]>; LANES],
    /// The number of each receiver.
    pub(crate) members: &'a [u32],
}

/// The buffers of a thread.
#[derive(Debug)]
pub(crate) struct ChainScratch {
    visible: Expansions,
    hidden: Expansions,
    product: Expansions,
    response: [Expansions; 3],
    /// The sums of channels.
    sums: [Lanes; 3],
    look_up: LookUp,
    sights: Sights,
    met: [Vec<Met>; LANES],
    /// For each entity the lanes that meet it, and the place of its occlusion, `order²` blocks, among those kept.
    meetings: Vec<Meeting>,
    occlusions: Vec<Lanes>,
    /// Those met at a step: the place of the occlusion, and 1 in the lanes that meet it.
    step: Vec<(usize, Lanes)>,
    lamp: LampScratch,
}

#[derive(Clone, Copy, Debug, Default)]
struct Meeting {
    lanes: u16,
    place: usize,
}

/// One receiver and the light of a lamp there.
#[derive(Debug, Default)]
struct LampScratch {
    seen: Vec<f32>,
    response: Vec<f32>,
    product: Vec<f32>,
    light: Vec<f32>,
    turned: Vec<f32>,
}

/// The factor of each band in the expansion of the clamped cosine over π towards a direction, `√(4π/(2l+1)) z_l/π`: the basis
/// functions there are multiplied by it.
pub(crate) fn cosine_factors(order: usize) -> Vec<f32> {
    let factors = Zonal::clamped_cosine(order).convolution_factors();
    factors.into_iter().map(|factor| (factor * std::f64::consts::FRAC_1_PI) as f32).collect()
}

impl Default for ChainScratch {
    fn default() -> Self {
        Self {
            visible: ZERO,
            hidden: ZERO,
            product: ZERO,
            response: [ZERO; 3],
            sums: [Lanes::ZERO; 3],
            look_up: LookUp::default(),
            sights: Sights::default(),
            met: Default::default(),
            meetings: Vec::new(),
            occlusions: Vec::new(),
            step: Vec::new(),
            lamp: LampScratch::default(),
        }
    }
}

impl Chain<'_> {
    fn len(&self) -> usize {
        self.order * self.order
    }

    /// The visibility of a group, one receiver after the other into `out`.
    pub(crate) fn visibility_into(&self, group: &Group<'_>, scratch: &mut ChainScratch, out: &mut [f32]) {
        scratch.sums = [Lanes::ZERO; 3];
        self.run(group, 0, scratch);
        for (lane, out) in out.chunks_exact_mut(self.len()).enumerate() {
            out.iter_mut().zip(&scratch.visible).for_each(|(out, v)| *out = v[lane]);
        }
    }

    /// The exit radiance of a group under distant light and the lamps: `Σ_i L_i (V T)_i`.
    ///
    /// `light` holds red, green and blue one after the other.
    pub(crate) fn shade_into(
        &self,
        group: &Group<'_>,
        response: Response<'_>,
        light: &[f32],
        scratch: &mut ChainScratch,
        out: &mut [Rgb<f32>],
    ) {
        let channels = self.response_into(group, response, scratch);
        scratch.sums = [Lanes::ZERO; 3];
        // Lamps are added on the way, with what is visible up to them.
        self.run(group, channels, scratch);
        let ChainScratch { visible, product, response, sums, .. } = scratch;
        for (c, response) in response[..channels].iter().enumerate() {
            let product = &mut product[..self.len()];
            product_of_blocks(self.machine, self.order, &visible[..self.len()], &response[..self.len()], product);
            // With one channel of the response all three of the light belong to it.
            for c in if channels == 1 { 0..3 } else { c..c + 1 } {
                for (t, l) in product.iter().zip(&light[c * self.len()..][..self.len()]) {
                    (0..LANES).for_each(|k| sums[c][k] += t[k] * l);
                }
            }
        }
        for (k, out) in out.iter_mut().enumerate() {
            *out = Rgb::new(sums[0][k], sums[1][k], sums[2][k]);
        }
    }

    /// Fills in what the group multiplies light by; the number of channels of that.
    fn response_into(&self, group: &Group<'_>, response: Response<'_>, scratch: &mut ChainScratch) -> usize {
        match response {
            Response::Cosine => {
                let normals = group.normals.unwrap_or([Lanes::ZERO; 3]);
                let out = &mut scratch.response[0];
                self.machine.arch().dispatch(Cosine {
                    basis: &self.basis,
                    factors: &self.cosine,
                    normals: &normals,
                    out,
                });
                1
            }
            Response::Transfer { rows, channels } => {
                let n = self.len();
                for (lane, member) in group.members.iter().enumerate() {
                    let row = &rows[*member as usize * channels * n..][..channels * n];
                    for (response, row) in scratch.response.iter_mut().zip(row.chunks_exact(n)) {
                        response.iter_mut().zip(row).for_each(|(t, x)| t[lane] = *x);
                    }
                }
                channels
            }
        }
    }

    /// Multiplies out what the entities leave visible, nearest first. Where a lamp is met, what the first `channels` of the
    /// response send back of it is added to the sums.
    fn run(&self, group: &Group<'_>, channels: usize, scratch: &mut ChainScratch) {
        let steps = self.meet(group, channels > 0, scratch);
        self.look_up(group, scratch);
        let mut is_open = self.begin(group, &mut scratch.visible);
        for step in 0..steps {
            self.meet_step(step, group, channels, scratch);
            if scratch.step.is_empty() {
                continue;
            }
            let ChainScratch { visible, hidden, product, occlusions, step, .. } = scratch;
            let [visible, hidden, product] = [visible, hidden, product].map(|f| &mut f[..self.len()]);
            self.machine.arch().dispatch(Gather { step, occlusions, out: hidden });
            // V (1 - O) = V - V O; the first entity of receivers in the open needs no product.
            let what = if is_open {
                &*hidden
            } else {
                product_of_blocks(self.machine, self.order, visible, hidden, product);
                product
            };
            self.machine.arch().dispatch(Subtract { from: visible, what });
            is_open = false;
        }
    }

    /// What is visible past the receivers' own entities; whether that is everything.
    fn begin(&self, group: &Group<'_>, visible: &mut Expansions) -> bool {
        visible[..self.len()].fill(Lanes::ZERO);
        visible[0] = Lanes::splat((4.0 * std::f32::consts::PI).sqrt());
        for (lane, own) in group.own.iter().enumerate() {
            for (v, own) in visible.iter_mut().zip(own.unwrap_or_default()) {
                v[lane] = *own;
            }
        }
        group.own.iter().all(Option::is_none)
    }

    /// Lists what each lane meets; the most of them.
    fn meet(&self, group: &Group<'_>, lamps: bool, scratch: &mut ChainScratch) -> usize {
        let ChainScratch { sights, met, .. } = scratch;
        sights.look(self.machine.arch(), &self.entities, &group.positions, group.normals.as_ref());
        for (lane, met) in met.iter_mut().enumerate() {
            met.clear();
            if lane >= group.members.len() {
                continue;
            }
            sights.add_occluders(lane, self.negligible, met);
            for (k, lamp) in self.lamps.iter().enumerate().filter(|_| lamps) {
                let towards = |c: usize| (lamp.center[c] - group.positions[c][lane]) as f32;
                met.push(Met::lamp(k, (0..3).map(|c| towards(c).powi(2)).sum()));
            }
            met.sort_unstable();
        }
        met.iter().map(Vec::len).max().unwrap_or(0)
    }

    /// Looks up the occlusion of all entities that a lane meets.
    fn look_up(&self, group: &Group<'_>, scratch: &mut ChainScratch) {
        let ChainScratch { met, meetings, occlusions, look_up, .. } = scratch;
        meetings.clear();
        meetings.resize(self.entities.len(), Meeting::default());
        for (lane, met) in met.iter().enumerate() {
            for met in met {
                if let MetKind::Occluder(k) = met.kind() {
                    meetings[k].lanes |= 1 << lane;
                }
            }
        }
        let mut end = 0;
        for (entity, meeting) in self.entities.iter().zip(meetings).filter(|(_, meeting)| meeting.lanes > 0) {
            meeting.place = end;
            end += self.len();
            if occlusions.len() < end {
                occlusions.resize(end, Lanes::ZERO);
            }
            let out = &mut occlusions[meeting.place..end];
            self.machine.arch().dispatch(Occlude { chain: self, entity, group, lanes: meeting.lanes, look_up, out });
        }
    }

    /// Lists the occlusions that the lanes meet at a step; the light of a lamp is sent back at once.
    fn meet_step(&self, step: usize, group: &Group<'_>, channels: usize, scratch: &mut ChainScratch) {
        scratch.step.clear();
        for lane in 0..group.members.len() {
            match scratch.met[lane].get(step).map(|met| met.kind()) {
                Some(MetKind::Occluder(k)) => {
                    let place = scratch.meetings[k].place;
                    let at = scratch.step.iter().position(|(other, _)| *other == place).unwrap_or_else(|| {
                        scratch.step.push((place, Lanes::ZERO));
                        scratch.step.len() - 1
                    });
                    scratch.step[at].1[lane] = 1.0;
                }
                Some(MetKind::Lamp(k)) => self.send_back(&self.lamps[k], group, lane, channels, scratch),
                None => {}
            }
        }
    }

    /// Adds the light of a lamp that a lane sends back, by what is visible to it now: `Σ_i S_i (V T)_i`.
    fn send_back(
        &self,
        lamp: &PlacedLamp<'_>,
        group: &Group<'_>,
        lane: usize,
        channels: usize,
        scratch: &mut ChainScratch,
    ) {
        let (n, full) = (self.len(), lamp.field.order() * lamp.field.order());
        let ChainScratch { visible, response, sums, lamp: buffers, .. } = scratch;
        let LampScratch { seen, response: own, product, light, turned } = buffers;
        let of_lane = |all: &Expansions, one: &mut Vec<f32>| {
            one.clear();
            one.extend(all[..n].iter().map(|x| x[lane]));
        };
        light.resize(3 * full, 0.0);
        product.resize(n, 0.0);
        turned.resize(n, 0.0);
        let point = lamp.placement.to_own([0, 1, 2].map(|c| group.positions[c][lane]));
        lamp.field.radiance_into(point, self.interpolation, light);
        of_lane(visible, seen);
        for c in 0..3 {
            if c < channels {
                of_lane(&response[c], own);
                product_into(seen, own, product);
            }
            let light = &light[c * full..][..n];
            let light = match &lamp.turn {
                None => light,
                Some(turn) => {
                    turn.apply_into(light, turned);
                    &*turned
                }
            };
            sums[c][lane] += product.iter().zip(light).map(|(t, l)| t * l).sum::<f32>();
        }
    }
}

/// The cosine about the normals.
struct Cosine<'a> {
    basis: &'a LaneBasis,
    factors: &'a [f32],
    normals: &'a [Lanes; 3],
    out: &'a mut Expansions,
}

impl WithSimd for Cosine<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let [x, y, z] = self.normals;
        for part in 0..Wide::<S>::PARTS {
            let normal = [Wide::load(simd, x, part), Wide::load(simd, y, part), Wide::load(simd, z, part)];
            self.basis.for_each(simd, normal, |l, i, y| {
                (y * constant(simd, self.factors[l])).store(&mut self.out[i], part);
            });
        }
    }
}

/// The occlusion by one entity.
struct Occlude<'a, 'f> {
    chain: &'a Chain<'f>,
    entity: &'a Placed<'f>,
    group: &'a Group<'a>,
    lanes: u16,
    look_up: &'a mut LookUp,
    out: &'a mut [Lanes],
}

impl WithSimd for Occlude<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { chain, entity, group, lanes, look_up, out } = self;
        entity.occlusion_into(simd, &group.positions, lanes, &chain.basis, look_up, out);
    }
}

/// What the lanes meet at a step, as one expansion.
struct Gather<'a> {
    step: &'a [(usize, Lanes)],
    occlusions: &'a [Lanes],
    out: &'a mut [Lanes],
}

impl WithSimd for Gather<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { step, occlusions, out } = self;
        for part in 0..Wide::<S>::PARTS {
            for (i, out) in out.iter_mut().enumerate() {
                let mut sum = constant(simd, 0.0);
                for (place, lanes) in step {
                    let occlusion = Wide::load(simd, &occlusions[place + i], part);
                    sum = Wide::load(simd, lanes, part).times_plus(occlusion, sum);
                }
                sum.store(out, part);
            }
        }
    }
}

struct Subtract<'a> {
    from: &'a mut [Lanes],
    what: &'a [Lanes],
}

impl WithSimd for Subtract<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for part in 0..Wide::<S>::PARTS {
            for (from, what) in self.from.iter_mut().zip(self.what) {
                (Wide::load(simd, from, part) - Wide::load(simd, what, part)).store(from, part);
            }
        }
    }
}
