//! The light of lamps that reaches a part of a moving scene, past what is nearer than they.

use lobe_io::parallel;
use lobe_prt::Transfer;
use lobe_sh::Rgb;
use lobe_sh::product::product_into;
use lobe_shadow::{
    LocalLight, LogTable, Occluder, PlacedField, ShadowError, ShadowFields, ShadowReceivers, SphereShadows,
    relative_placement,
};

use crate::moving_options::MovingOptions;
use crate::scene::moment::Moment;
use crate::scene::moment::Surface;
use crate::scene::moving_part::HidesBy;
use lobe_render::RenderError;

/// Lamps and what may hide them, in the frame of a part's surface.
///
/// ```text
///   B = Σ_lamps Σ_i S_i (V T)_i        V = Π_nearer fields (1 - O) · Π_nearer parts exp(Σ_spheres log V_sphere)
/// ```
///
/// Nearer is what has its middle nearer to the receiver than that of the lamp. What a part hides from itself, by its
/// transfer or, if it is deformed, by its own spheres, counts as nearer than every lamp; grids of what stands still say
/// nothing of distances and hide no lamp.
pub(crate) struct LampLight<'a> {
    options: &'a MovingOptions,
    lamps: Vec<LocalLight<'a>>,
    fields: Vec<PlacedField<'a>>,
    bodies: Vec<Body<'a>>,
}

/// The spheres of one part.
struct Body<'a> {
    middle: [f64; 3],
    is_own: bool,
    shadows: SphereShadows<'a>,
}

/// Lamps whose visibility is held at a time, beside that of one body: of a block of vertices 2 MiB each at order 4, 8
/// MiB at order 8, however many lamps and bodies there are.
const LAMPS_AT_ONCE: usize = 16;

/// Receivers that a thread takes at a time: one with few bands is done in tens of nanoseconds.
pub(crate) const RECEIVERS_TOGETHER: usize = 64;

/// What receivers send back of lamps, past the visibility that they have of their own.
type SendBack<'a> = dyn Fn(&ShadowFields<'_>, &ShadowReceivers<'_>) -> Result<Vec<Rgb<f32>>, ShadowError> + Sync + 'a;

impl<'a> LampLight<'a> {
    /// The lamps of a moment as one of its parts is lit by them; nothing if there are none.
    pub(crate) fn of(
        moment: &'a Moment<'_>,
        receiver: usize,
        options: &'a MovingOptions,
        table: &'a LogTable,
    ) -> Result<Option<Self>, RenderError> {
        if moment.lamps.is_empty() {
            return Ok(None);
        }
        let frame = &moment.placed[receiver].surface.frame;
        let lamp = |lamp: &'a crate::scene::moving_lamp::PlacedLamp<'_>| {
            let placement = relative_placement(&lamp.placement, frame);
            lamp.field.as_deref().map(|field| LocalLight { field, placement })
        };
        let lamps = moment.lamps.iter().filter_map(lamp).collect();
        let mut all = Self { options, lamps, fields: Vec::new(), bodies: Vec::new() };
        for (index, (part, placed)) in moment.parts().iter().zip(&moment.placed).enumerate() {
            let is_own = index == receiver;
            if is_own && part.is_rigid() {
                continue;
            }
            match part.hides_by(options.method) {
                Some(HidesBy::Field(field)) => {
                    all.fields.push(PlacedField { field, placement: relative_placement(&placed.placement, frame) });
                }
                Some(HidesBy::Spheres) if !placed.spheres.is_empty() => {
                    let centers: Vec<[f64; 3]> = placed.spheres.iter().map(|s| frame.to_own(s.center)).collect();
                    let count = centers.len() as f64;
                    let middle = [0, 1, 2].map(|k| centers.iter().map(|c| c[k]).sum::<f64>() / count);
                    let occluder = |(center, sphere): (&[f64; 3], &lobe_shadow::WorldSphere)| {
                        Occluder::new(center.map(|c| c as f32), (sphere.radius / frame.scale()) as f32)
                    };
                    let spheres: Vec<Occluder> = centers.iter().zip(&placed.spheres).map(occluder).collect();
                    let shadows = SphereShadows::new(table, &spheres, &options.spheres)?;
                    all.bodies.push(Body { middle, is_own, shadows });
                }
                _ => {}
            }
        }
        Ok(Some(all))
    }

    /// Adds what receivers of a transfer send back.
    pub(crate) fn add_by_transfer(
        &self,
        surface: &Surface,
        transfer: &Transfer,
        out: &mut [Rgb<f32>],
    ) -> Result<(), RenderError> {
        self.add(surface, &|fields, receivers| fields.shade_transfer(receivers, transfer, &[]), out)
    }

    /// Adds what white receivers send back.
    pub(crate) fn add_by_cosine(&self, surface: &Surface, out: &mut [Rgb<f32>]) -> Result<(), RenderError> {
        self.add(surface, &|fields, receivers| fields.shade(receivers, &[]), out)
    }

    fn add(&self, surface: &Surface, send_back: &SendBack<'_>, out: &mut [Rgb<f32>]) -> Result<(), RenderError> {
        let receivers = ShadowReceivers::new(&surface.positions, &surface.normals)?;
        let fields = ShadowFields::new(self.options.order, &self.fields, self.options.fields.clone())?;
        let mut add = |fields: ShadowFields<'_>, receivers: &ShadowReceivers<'_>| -> Result<(), RenderError> {
            let found = send_back(&fields, receivers)?;
            out.iter_mut().zip(found).for_each(|(out, found)| *out += found);
            Ok(())
        };
        if self.bodies.is_empty() {
            return add(fields.with_lights(&self.lamps)?, &receivers);
        }
        for lamps in self.lamps.chunks(LAMPS_AT_ONCE) {
            for (lamp, own) in lamps.iter().zip(self.past_bodies(lamps, &receivers)) {
                let fields = fields.clone().with_lights(std::slice::from_ref(lamp))?;
                add(fields, &receivers.with_own_visibility(self.options.order, &own)?)?;
            }
        }
        Ok(())
    }

    /// For each lamp, what the bodies nearer than it leave visible at each receiver.
    fn past_bodies(&self, lamps: &[LocalLight<'_>], receivers: &ShadowReceivers<'_>) -> Vec<Vec<f32>> {
        let mut open = vec![0.0; self.options.order * self.options.order];
        open[0] = (4.0 * std::f32::consts::PI).sqrt();
        let mut visible = vec![open.repeat(receivers.len()); lamps.len()];
        for body in &self.bodies {
            let seen = body.shadows.visibility(receivers);
            for (lamp, visible) in lamps.iter().zip(&mut visible) {
                body.hide(lamp, receivers.positions(), (seen.as_slice(), open.len()), visible);
            }
        }
        visible
    }
}

impl Body<'_> {
    /// Multiplies what is visible of a lamp at receivers to which this body is nearer by what it leaves, `n` numbers of
    /// each.
    fn hide(&self, lamp: &LocalLight<'_>, positions: &[[f32; 3]], (seen, n): (&[f32], usize), visible: &mut [f32]) {
        let center = lamp.placement.to_world(lamp.field.center());
        parallel::rows(visible, RECEIVERS_TOGETHER * n, &|k, visible| {
            let first = k * RECEIVERS_TOGETHER;
            let seen = seen[first * n..].chunks_exact(n);
            let mut product = vec![0.0; n];
            for ((visible, seen), position) in visible.chunks_exact_mut(n).zip(seen).zip(&positions[first..]) {
                let square = |p: &[f64; 3]| (0..3).map(|c| (p[c] - f64::from(position[c])).powi(2)).sum::<f64>();
                if self.is_own || square(&self.middle) < square(&center) {
                    product_into(&*visible, seen, &mut product);
                    visible.copy_from_slice(&product);
                }
            }
        });
    }
}
