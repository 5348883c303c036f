//! Precomputed shadow fields on the device.

use std::f64::consts::FRAC_1_PI;
use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use lobe_prt::Transfer;
use lobe_sh::{Rgb, Rotation, RotationMatrices, Zonal};
use lobe_shadow::{PlacedField, RadialInterpolation, ShadowFieldOptions, ShadowReceivers};

use crate::moving::field_parts::FieldParts;
use crate::renderer::kernel::{Kernel, Slot};
use crate::renderer::pass::Pass;
use crate::renderer::pieces::{Piece, VALUE, cut};
use crate::renderer::renderer::Renderer;
use crate::renderer::shader::Shader;
use crate::{Context, GpuError};

/// The highest order: that of the products written as straight-line code.
const MOST_ORDER: usize = 6;

/// Entities at most: each receiver keeps two numbers of every one.
const MOST_ENTITIES: usize = 64;

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Sizes {
    receivers: u32,
    entities: u32,
    own: u32,
    negligible: f32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct EntityShape {
    center: [f32; 4],
    to_own: [[f32; 4]; 3],
    radial: [f32; 4],
    grid: [u32; 4],
    turn: [u32; 4],
}

/// What receivers multiply light by, besides what the entities leave visible.
#[derive(Clone, Copy, Debug, Default)]
#[non_exhaustive]
pub enum FieldResponse<'a> {
    /// The clamped cosine and the albedo of the receivers; entities below the horizon are left out.
    #[default]
    Cosine,
    /// Transfer vectors of as many bands as are used.
    Transfer(&'a Transfer),
}

/// Receivers among entities with occlusion fields, on a device: [`ShadowFields`](lobe_shadow::ShadowFields) of orders 1 to 6, up
/// to 64 entities, interpolated linearly, without lamps.
///
/// ```text
///   V = V_own Π_k (1 - O_k)  nearest first        B = ρ Σ_i L_i (V T)_i
/// ```
///
/// One pass, `shadow fields`, for as many pieces of the receivers as the bindings of the device demand; before it passes
/// `look up fields` if the fields are larger than a binding. Entities may move between two calls. Positions are single precision here: the scene is to be near its
/// origin.
#[derive(Debug)]
pub struct GpuShadowFields {
    renderer: Renderer,
    receivers: usize,
    order: usize,
    /// The first number of each entity's field.
    fields: Vec<u32>,
}

impl GpuShadowFields {
    /// Uploads receivers and the fields of entities, each with its first place.
    ///
    /// # Errors
    /// [`GpuError::Options`] if the order is not 1 to 6 or above that of a field, there are more than 64 entities, numbers of
    /// receivers differ, or fields are to be interpolated otherwise than linearly; [`GpuError::Unsupported`] if anything is too
    /// large for the device; [`GpuError::Device`] if the device fails.
    pub fn new(
        context: &Context,
        order: usize,
        entities: &[PlacedField<'_>],
        receivers: &ShadowReceivers<'_>,
        response: FieldResponse<'_>,
        options: &ShadowFieldOptions,
    ) -> Result<Self, GpuError> {
        check(order, entities, receivers, response, options)?;
        let (n, count) = (order * order, receivers.len());
        let mut renderer = Renderer::new(context);
        renderer.uniform("light", &[[0.0_f32; 4]; 64])?;
        renderer.uniform("cosine", &cosine(order))?;
        let parts = FieldParts::upload(&mut renderer, entities)?;
        let most = entities.len().max(1);
        renderer.upload("entities", &vec![EntityShape::zeroed(); most])?;
        renderer.upload("turns", &vec![0.0_f32; most * entries(order)])?;
        renderer.allocate("visibility", 4 * (n * count) as u64)?;
        renderer.allocate("radiance", VALUE * count as u64)?;
        let given = Given::of(receivers, response, n);
        let (own, seen, found) = (size_of::<ReceiverShape>() as u64, 4 * n as u64, parts.found_bytes(order));
        let largest = own.max(4 * given.numbers() as u64).max(found);
        let pieces = cut(context, "receivers", count, largest, &[seen, VALUE])?;
        let shader = Shader::new(&[])
            .constant("CHANNELS", given.channels)
            .constant("MOST_ENTITIES", most)
            .constant("LOOKED_UP", usize::from(!parts.is_whole()))
            .order(order)
            .product(order)
            .module("shadow_fields");
        let slots = [[Slot::Uniform; 3].as_slice(), &[Slot::Read; 5], &[Slot::Write; 2]].concat();
        let kernel = Kernel::new(context, "shadow fields", &shader, &slots)?;
        let look_up = if parts.is_whole() { None } else { Some(FieldParts::kernel(context, order)?) };
        if let (Some(_), Some(first)) = (&look_up, pieces.first()) {
            renderer.allocate("found", u64::from(first.count()) * found)?;
        }
        let sizes = Sizes {
            receivers: 0,
            entities: entities.len() as u32,
            own: u32::from(!given.own.is_empty()),
            negligible: options.negligible as f32,
        };
        for piece in &pieces {
            renderer.uniform(&piece.of("sizes"), &Sizes { receivers: piece.count(), ..sizes })?;
            renderer.upload(&piece.of("receivers"), &receiver_shapes(receivers, piece.items.clone()))?;
            renderer.upload(&piece.of("given"), &given.of_piece(piece))?;
            if let Some(kernel) = &look_up {
                parts.add_look_ups(&mut renderer, kernel, piece, found)?;
            }
            let mut pass = Pass::compute(piece.of("shadow fields"), &kernel, piece.count()).read(&piece.of("sizes"));
            for name in ["light", "cosine", &piece.of("receivers"), "entities", "turns"] {
                pass = pass.read(name);
            }
            pass = match &look_up {
                Some(_) => pass.read_part("found", 0..u64::from(piece.count()) * found),
                None => pass.read("fields"),
            };
            pass = pass.read(&piece.of("given")).write_part("visibility", piece.part(seen));
            renderer.add(pass.write_part("radiance", piece.values()))?;
        }
        let fields = Self { renderer, receivers: count, order, fields: parts.firsts };
        fields.place(entities)?;
        Ok(fields)
    }

    /// The pass, and the buffers `visibility` and `radiance` that it writes.
    #[must_use]
    pub fn renderer(&self) -> &Renderer {
        &self.renderer
    }

    /// Moves the entities: the same as before, in the same order, elsewhere.
    ///
    /// # Errors
    /// [`GpuError::Options`] if there are more or fewer.
    pub fn place(&self, entities: &[PlacedField<'_>]) -> Result<(), GpuError> {
        if entities.len() != self.fields.len() {
            let (expected, found) = (self.fields.len(), entities.len());
            return Err(GpuError::Options(format!("expected the {expected} entities from before, found {found}")));
        }
        let (mut shapes, mut turns) = (Vec::new(), Vec::new());
        for (entity, first) in entities.iter().zip(&self.fields) {
            let is_turned = *entity.placement.rotation() != Rotation::IDENTITY;
            shapes.push(entity_shape(entity, *first, [turns.len() as u32, u32::from(is_turned)]));
            if is_turned {
                turns.extend(turn_entries(entity.placement.rotation(), self.order));
            }
        }
        self.renderer.update("entities", &shapes)?;
        self.renderer.update("turns", &turns)
    }

    /// The exit radiance of every receiver under distant light, as
    /// [`ShadowFields::shade`](lobe_shadow::ShadowFields::shade) or
    /// [`ShadowFields::shade_transfer`](lobe_shadow::ShadowFields::shade_transfer).
    ///
    /// # Errors
    /// [`GpuError::Device`] if the device fails.
    pub fn exit_radiance(&self, light: &[Rgb<f64>]) -> Result<Vec<Rgb<f32>>, GpuError> {
        let n = self.order * self.order;
        let mut vectors: Vec<[f32; 4]> =
            light.iter().take(n).map(|c| [c.r as f32, c.g as f32, c.b as f32, 0.0]).collect();
        vectors.resize(n, [0.0; 4]);
        self.renderer.update("light", &vectors)?;
        self.renderer.run()?;
        let values: Vec<[f32; 4]> = self.renderer.read("radiance", self.receivers)?;
        Ok(values.into_iter().map(|[r, g, b, _]| Rgb::new(r, g, b)).collect())
    }
}

fn check(
    order: usize,
    entities: &[PlacedField<'_>],
    receivers: &ShadowReceivers<'_>,
    response: FieldResponse<'_>,
    options: &ShadowFieldOptions,
) -> Result<(), GpuError> {
    let refuse = |message: String| Err(GpuError::Options(message));
    if !(1..=MOST_ORDER).contains(&order) {
        return refuse(format!("expected an order of 1 to {MOST_ORDER}, found {order}"));
    }
    if entities.len() > MOST_ENTITIES {
        return refuse(format!("expected at most {MOST_ENTITIES} entities, found {}", entities.len()));
    }
    if let Some(k) = entities.iter().position(|entity| entity.field.order() < order) {
        let found = entities[k].field.order();
        return refuse(format!("expected the field of entity {k} to have {order} bands at least, found {found}"));
    }
    if options.interpolation != RadialInterpolation::Linear {
        return refuse("expected fields to be interpolated linearly between spheres".into());
    }
    let own = receivers.own_visibility().len();
    if own != 0 && own != receivers.len() * order * order {
        return refuse(format!("expected visibility of {} numbers for each receiver, or none", order * order));
    }
    if let FieldResponse::Transfer(transfer) = response
        && (transfer.order() != order || transfer.receivers() != receivers.len())
    {
        let (found, count) = (transfer.order(), transfer.receivers());
        let expected = receivers.len();
        return refuse(format!(
            "expected transfer of order {order} for {expected} receivers, found order {found} for {count}"
        ));
    }
    Ok(())
}

fn entity_shape(entity: &PlacedField<'_>, first: u32, turn: [u32; 2]) -> EntityShape {
    let (grid, placement) = (entity.field.grid(), &entity.placement);
    let [x, y, z] = placement.to_world(grid.center()).map(|c| c as f32);
    let radius = placement.scale() * grid.radius();
    let m = placement.rotation().matrix();
    let row = |k: usize| {
        let [a, b, c] = [0, 1, 2].map(|c| (m[c][k] / radius) as f32);
        [a, b, c, 0.0]
    };
    let (at_radius, [within, beyond]) = grid.radial_steps();
    EntityShape {
        center: [x, y, z, radius as f32],
        to_own: [0, 1, 2].map(row),
        radial: [grid.range()[0], at_radius, within, beyond].map(|x| x as f32),
        grid: [grid.spheres() as u32, grid.cells() as u32, first, entity.field.order() as u32],
        turn: [turn[0], turn[1], 0, 0],
    }
}

/// The factor of each band of the clamped cosine over π, `√(4π/(2l+1)) z_l/π`.
fn cosine(order: usize) -> [[f32; 4]; 8] {
    let mut factors = [[0.0; 4]; 8];
    for (out, factor) in factors.iter_mut().zip(Zonal::clamped_cosine(order).convolution_factors()) {
        out[0] = (factor * FRAC_1_PI) as f32;
    }
    factors
}

/// Entries of the rotation of `order` bands.
fn entries(order: usize) -> usize {
    (0..order).map(|l| (2 * l + 1).pow(2)).sum()
}

/// The entries of a rotation, band after band and row after row.
fn turn_entries(rotation: &Rotation, order: usize) -> Vec<f32> {
    let matrices = RotationMatrices::<f32>::new(rotation, order);
    let rows = |l: isize| (-l..=l).flat_map(move |m| (-l..=l).map(move |k| (l, m, k)));
    (0..order as isize).flat_map(rows).map(|(l, m, k)| matrices.entry(l as usize, m, k)).collect()
}

/// Position, normal and albedo of a receiver, each with a fourth number.
type ReceiverShape = [f32; 12];

fn receiver_shapes(receivers: &ShadowReceivers<'_>, of: Range<usize>) -> Vec<ReceiverShape> {
    let some = of.clone().zip(&receivers.positions()[of.clone()]).zip(&receivers.normals()[of]);
    some.map(|((k, p), n)| {
        let [r, g, b] = receivers.albedo(k);
        [p[0], p[1], p[2], 1.0, n[0], n[1], n[2], 0.0, r, g, b, 0.0]
    })
    .collect()
}

/// What is known of receivers besides the entities: what they see themselves, and their transfer.
struct Given<'a> {
    own: &'a [f32],
    transfer: &'a [f32],
    channels: usize,
    /// Coefficients of an expansion.
    count: usize,
}

impl<'a> Given<'a> {
    fn of(receivers: &'a ShadowReceivers<'_>, response: FieldResponse<'a>, count: usize) -> Self {
        let (channels, transfer) = match response {
            FieldResponse::Cosine => (0, &[][..]),
            FieldResponse::Transfer(transfer) => (transfer.channels().count(), transfer.coefficients()),
        };
        Self { own: receivers.own_visibility(), transfer, channels, count }
    }

    /// Numbers of a receiver.
    fn numbers(&self) -> usize {
        self.count * (usize::from(!self.own.is_empty()) + self.channels)
    }

    /// The numbers of a piece: first what its receivers see, then their transfer.
    fn of_piece(&self, piece: &Piece) -> Vec<f32> {
        let some = |numbers: &[f32], each: usize| {
            numbers.get(each * piece.items.start..each * piece.items.end).unwrap_or_default().to_vec()
        };
        [some(self.own, self.count), some(self.transfer, self.count * self.channels)].concat()
    }
}
