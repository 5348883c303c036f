//! The chain of products for a few receivers side by side.

use lobe_sh::{Rgb, RotationMatrices, Zonal, product_into};

use crate::field::axial::Axial;
use crate::field::lane_basis::LaneBasis;
use crate::field::lanes::{LANES, Lanes};
use crate::field::nearest_first::{Met, MetKind, add_occluders};
use crate::field::placed::Placed;
use crate::{RadialInterpolation, RadianceField};

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
    pub(crate) turn: Option<RotationMatrices<f32>>,
}

/// Everything that receivers share.
#[derive(Debug)]
pub(crate) struct Chain<'a> {
    pub(crate) order: usize,
    pub(crate) entities: Vec<Placed<'a>>,
    pub(crate) lamps: Vec<PlacedLamp<'a>>,
    pub(crate) negligible: f64,
    pub(crate) interpolation: RadialInterpolation,
    pub(crate) basis: LaneBasis,
    /// For each band the factor of the clamped cosine over π.
    pub(crate) cosine: Vec<f32>,
}

/// The receivers of one pass, at most [`LANES`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Group<'a> {
    pub(crate) positions: &'a [[f32; 3]],
    /// As many, or none where the horizon is not to be looked at.
    pub(crate) normals: &'a [[f32; 3]],
    /// `order²` numbers for each, or nothing.
    pub(crate) own: [Option<&'a [f32]>; LANES],
}

/// The buffers of a thread.
#[derive(Debug)]
pub(crate) struct ChainScratch {
    visible: Vec<Lanes<f32>>,
    hidden: Vec<Lanes<f32>>,
    product: Vec<Lanes<f32>>,
    response: Vec<Lanes<f32>>,
    row: Vec<f32>,
    spare: Vec<f32>,
    lamp: Vec<f32>,
    zonal: Vec<Lanes<f32>>,
    factors: Vec<f32>,
    met: [Vec<Met>; LANES],
    sizes: Vec<(u64, Met)>,
}

/// The factor of each band in the expansion of the clamped cosine over π towards a direction, `√(4π/(2l+1)) z_l/π`: the basis
/// functions there are multiplied by it.
pub(crate) fn cosine_factors(order: usize) -> Vec<f32> {
    let factors = Zonal::clamped_cosine(order).convolution_factors();
    factors.into_iter().map(|factor| (factor * std::f64::consts::FRAC_1_PI) as f32).collect()
}

impl Chain<'_> {
    pub(crate) fn scratch(&self) -> ChainScratch {
        let n = self.order * self.order;
        let lanes = || vec![Lanes([0.0; LANES]); n];
        ChainScratch {
            visible: lanes(),
            hidden: lanes(),
            product: lanes(),
            response: vec![Lanes([0.0; LANES]); 3 * n],
            row: vec![0.0; n],
            spare: vec![0.0; Axial::width(self.order)],
            lamp: vec![0.0; 3 * n],
            zonal: vec![Lanes([0.0; LANES]); self.order],
            factors: vec![0.0; self.order],
            met: Default::default(),
            sizes: Vec::new(),
        }
    }

    /// The visibility of a group, lane by lane into `out`.
    pub(crate) fn visibility_into(&self, group: &Group<'_>, scratch: &mut ChainScratch, out: &mut [f32]) {
        self.run(group, 0, scratch, &mut |_, _, _| {});
        let n = self.order * self.order;
        for (lane, out) in out.chunks_exact_mut(n).enumerate() {
            out.iter_mut().zip(&scratch.visible).for_each(|(out, v)| *out = v.0[lane]);
        }
    }

    /// The exit radiance of a group under distant light and the lamps: `Σ_i L_i (V T)_i`.
    ///
    /// `light` holds red, green and blue one after the other. `first` is the number of the first receiver.
    pub(crate) fn shade_into(
        &self,
        group: &Group<'_>,
        response: Response<'_>,
        first: usize,
        light: &[f32],
        scratch: &mut ChainScratch,
        out: &mut [Rgb<f32>],
    ) {
        let n = self.order * self.order;
        let channels = self.response_into(group, response, first, scratch);
        // Lamps are added on the way, with what is visible up to them.
        let mut of_lamps = [[0.0_f32; 3]; LANES];
        self.run(group, channels, scratch, &mut |lane, channel, sent| of_lamps[lane][channel] += sent);
        let ChainScratch { visible, product, response, .. } = scratch;
        let mut sums = [[0.0_f32; 3]; LANES];
        for c in 0..3 {
            if c < channels {
                product_into(visible, &response[c * n..][..n], product);
            }
            let mut sum = Lanes([0.0; LANES]);
            for (t, l) in product.iter().zip(&light[c * n..][..n]) {
                (0..LANES).for_each(|k| sum.0[k] += t.0[k] * l);
            }
            (0..LANES).for_each(|k| sums[k][c] = sum.0[k] + of_lamps[k][c]);
        }
        for (out, [r, g, b]) in out.iter_mut().zip(sums) {
            *out = Rgb::new(r, g, b);
        }
    }

    /// Fills in what the group multiplies light by; the number of channels of that.
    fn response_into(
        &self,
        group: &Group<'_>,
        response: Response<'_>,
        first: usize,
        scratch: &mut ChainScratch,
    ) -> usize {
        let n = self.order * self.order;
        match response {
            Response::Cosine => {
                let normal = [0, 1, 2].map(|k| {
                    Lanes(std::array::from_fn(|lane| group.normals.get(lane).map_or(0.0, |normal| normal[k])))
                });
                let out = &mut scratch.response;
                self.basis.for_each(normal, |l, i, y| out[i] = y * Lanes([self.cosine[l]; LANES]));
                1
            }
            Response::Transfer { rows, channels } => {
                for lane in 0..group.positions.len() {
                    let row = &rows[(first + lane) * channels * n..][..channels * n];
                    scratch.response.iter_mut().zip(row).for_each(|(t, x)| t.0[lane] = *x);
                }
                channels
            }
        }
    }

    /// Multiplies out what the entities leave visible, nearest first. Where a lamp is met, `sent(lane, channel, radiance)`
    /// gets what the first `channels` of the response send back of it.
    fn run(
        &self,
        group: &Group<'_>,
        channels: usize,
        scratch: &mut ChainScratch,
        sent: &mut dyn FnMut(usize, usize, f32),
    ) {
        let steps = self.meet(group, channels > 0, scratch);
        // Begin with what is visible past the receivers' own entities.
        let one = (4.0 * std::f32::consts::PI).sqrt();
        let mut is_open = true;
        for (i, v) in scratch.visible.iter_mut().enumerate() {
            *v = Lanes([if i == 0 { one } else { 0.0 }; LANES]);
        }
        for (lane, own) in group.own.iter().enumerate() {
            if let Some(own) = own {
                is_open = false;
                scratch.visible.iter_mut().zip(*own).for_each(|(v, own)| v.0[lane] = *own);
            }
        }
        for step in 0..steps {
            let any = self.hidden_at(step, group, channels, scratch, sent);
            if !any {
                continue;
            }
            let ChainScratch { visible, hidden, product, .. } = scratch;
            // V (1 - O) = V - V O; the first entity of receivers in the open needs no product.
            if is_open {
                visible.iter_mut().zip(&*hidden).for_each(|(v, o)| *v -= *o);
                is_open = false;
            } else {
                product_into(visible, hidden, product);
                visible.iter_mut().zip(&*product).for_each(|(v, p)| *v -= *p);
            }
        }
    }

    /// Lists what each lane meets; the most of them.
    fn meet(&self, group: &Group<'_>, lamps: bool, scratch: &mut ChainScratch) -> usize {
        scratch.met.iter_mut().for_each(Vec::clear);
        for (lane, point) in group.positions.iter().enumerate() {
            let met = &mut scratch.met[lane];
            let normal = group.normals.get(lane).copied();
            add_occluders(&self.entities, *point, normal, self.negligible, &mut scratch.sizes, met);
            if lamps {
                for (k, lamp) in self.lamps.iter().enumerate() {
                    let center = lamp.placement.to_world(lamp.field.center());
                    let towards: [f64; 3] = std::array::from_fn(|c| center[c] - f64::from(point[c]));
                    met.push(Met::lamp(k, towards));
                }
            }
            met.sort_unstable();
        }
        scratch.met.iter().map(Vec::len).max().unwrap_or(0)
    }

    /// What each lane meets at a step: occlusion goes to its lane of `hidden`, the light of a lamp is sent back at once.
    /// Returns whether there is any occlusion.
    fn hidden_at(
        &self,
        step: usize,
        group: &Group<'_>,
        channels: usize,
        scratch: &mut ChainScratch,
        sent: &mut dyn FnMut(usize, usize, f32),
    ) -> bool {
        let mut any = false;
        let mut axes = [[0.0; LANES], [0.0; LANES], [1.0; LANES]].map(Lanes);
        scratch.hidden.fill(Lanes([0.0; LANES]));
        scratch.zonal.fill(Lanes([0.0; LANES]));
        for lane in 0..group.positions.len() {
            match scratch.met[lane].get(step).map(|met| met.kind()) {
                Some(MetKind::Occluder(k)) => {
                    let towards = self.entities[k].towards(group.positions[lane]);
                    any = true;
                    let ChainScratch { hidden, zonal, row, spare, factors, .. } = scratch;
                    let axis = self.entities[k].occlusion_into(towards, self.interpolation, spare, factors, row);
                    hidden.iter_mut().zip(&*row).for_each(|(o, x)| o.0[lane] = *x);
                    zonal.iter_mut().zip(&*factors).for_each(|(o, x)| o.0[lane] = *x);
                    (0..3).for_each(|c| axes[c].0[lane] = axis[c]);
                }
                Some(MetKind::Lamp(k)) => {
                    self.send_back(&self.lamps[k], group, lane, channels, scratch, sent);
                }
                None => {}
            }
        }
        if any {
            let ChainScratch { hidden, zonal, .. } = scratch;
            self.basis.for_each(axes, |l, i, y| hidden[i] += zonal[l] * y);
        }
        any
    }

    /// The light of a lamp that a lane sends back, by what is visible to it now: `Σ_i S_i (V T)_i`.
    fn send_back(
        &self,
        lamp: &PlacedLamp<'_>,
        group: &Group<'_>,
        lane: usize,
        channels: usize,
        scratch: &mut ChainScratch,
        sent: &mut dyn FnMut(usize, usize, f32),
    ) {
        let n = self.order * self.order;
        let full = lamp.field.order() * lamp.field.order();
        let ChainScratch { visible, response, row, spare, lamp: light, .. } = scratch;
        light.resize(3 * full, 0.0);
        let point = lamp.placement.to_own(group.positions[lane].map(f64::from));
        lamp.field.radiance_into(point, self.interpolation, light);
        let lane_of = |x: &[Lanes<f32>]| -> Vec<f32> { x.iter().map(|x| x.0[lane]).collect() };
        let seen = lane_of(visible);
        for c in 0..3 {
            if c < channels {
                product_into(&seen, &lane_of(&response[c * n..][..n]), row);
            }
            let light = &light[c * full..][..n];
            let light = match &lamp.turn {
                None => light,
                Some(turn) => {
                    turn.apply_into(light, &mut spare[..n]);
                    &spare[..n]
                }
            };
            sent(lane, c, row.iter().zip(light).map(|(t, l)| t * l).sum());
        }
    }
}
