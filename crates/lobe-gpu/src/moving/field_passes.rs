//! The passes that look up the fields of entities and multiply by what these leave visible.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use lobe_prt::Transfer;
use lobe_sh::rotation::RotationMatrices;
use lobe_sh::{Rgb, Rotation};
use lobe_shadow::{PlacedField, RadialInterpolation, ShadowFieldOptions, ShadowReceivers};

use crate::error::GpuError;
use crate::moving::field_parts::FieldParts;
use crate::renderer::kernel::{Kernel, Slot};
use crate::renderer::pass::Pass;
use crate::renderer::pieces::Piece;
use crate::renderer::renderer::Renderer;
use crate::renderer::shader::Shader;

/// The highest order: that of the products written as straight-line code.
pub(crate) const MOST_ORDER: usize = 6;

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

/// What a program of fields answers.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Answer {
    /// What is visible above the horizon; the buffer `radiance` is left as it is.
    Visibility,
    /// Visibility on all sides, and exit radiance by transfer of so many channels.
    Transfer(usize),
}

impl Answer {
    /// The answer to a response.
    pub(crate) fn to(response: FieldResponse<'_>) -> Self {
        match response {
            // What the cosine sends back is the work of the operator of the sky.
            FieldResponse::Cosine => Self::Visibility,
            FieldResponse::Transfer(transfer) => Self::Transfer(transfer.channels().count()),
        }
    }

    /// Numbers of transfer that a receiver of this order has.
    pub(crate) fn given(self, order: usize) -> usize {
        if let Self::Transfer(channels) = self { channels * order * order } else { 0 }
    }
}

/// The fields of entities on a device, and the programs that look them up.
pub(crate) struct FieldPasses {
    kernel: Kernel,
    look_up: Option<Kernel>,
    parts: FieldParts,
    order: usize,
    sizes: Sizes,
}

impl std::fmt::Debug for FieldPasses {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("FieldPasses").field("order", &self.order).field("sizes", &self.sizes).finish_non_exhaustive()
    }
}

impl FieldPasses {
    /// Uploads the fields of entities, and makes room for the light and for where the entities are.
    pub(crate) fn upload(
        renderer: &mut Renderer,
        order: usize,
        entities: &[PlacedField<'_>],
        answer: Answer,
        options: &ShadowFieldOptions,
    ) -> Result<Self, GpuError> {
        renderer.uniform("light", &[[0.0_f32; 4]; 64])?;
        let parts = FieldParts::upload(renderer, entities)?;
        let most = entities.len().max(1);
        renderer.upload("entities", &vec![EntityShape::zeroed(); most])?;
        renderer.upload("turns", &vec![0.0_f32; most * entries(order)])?;
        renderer.upload("no numbers", &[0.0_f32; 4])?;
        let channels = if let Answer::Transfer(channels) = answer { channels } else { 0 };
        let shader = Shader::new(&[])
            .constant("CHANNELS", channels)
            .constant("MOST_ENTITIES", most)
            .constant("LOOKED_UP", usize::from(!parts.is_whole()))
            .order(order)
            .product(order)
            .module("shadow_fields");
        let slots = [[Slot::Uniform; 2].as_slice(), &[Slot::Read; 6], &[Slot::Write; 2]].concat();
        let kernel = Kernel::new(renderer.context(), "shadow fields", &shader, &slots)?;
        let look_up = if parts.is_whole() { None } else { Some(FieldParts::kernel(renderer.context(), order)?) };
        let negligible = options.negligible as f32;
        let sizes = Sizes { receivers: 0, entities: entities.len() as u32, own: 0, negligible };
        Ok(Self { kernel, look_up, parts, order, sizes })
    }

    /// Bytes of what a receiver finds in all fields, looked up part by part; none where that is not needed.
    pub(crate) fn found_bytes(&self) -> u64 {
        self.parts.found_bytes(self.order)
    }

    /// Adds the passes of a piece of the `receivers`, with their transfer. What they see already is in a part of a buffer, number by
    /// number. Writes `visibility` and `radiance`.
    pub(crate) fn add(
        &self,
        renderer: &mut Renderer,
        piece: &Piece,
        given: &[f32],
        own: Option<(&str, Range<u64>)>,
    ) -> Result<(), GpuError> {
        let (found, seen) = (self.found_bytes(), 4 * (self.order * self.order) as u64);
        if self.look_up.is_some() && !renderer.has("found") {
            // The first piece is the longest.
            renderer.allocate("found", u64::from(piece.count()) * found)?;
        }
        let sizes = Sizes { receivers: piece.count(), own: u32::from(own.is_some()), ..self.sizes };
        renderer.uniform(&piece.of("sizes"), &sizes)?;
        let given_name = if given.is_empty() { "no numbers".into() } else { piece.of("given") };
        if !given.is_empty() {
            renderer.upload(&given_name, given)?;
        }
        if let Some(kernel) = &self.look_up {
            self.parts.add_look_ups(renderer, kernel, piece, found)?;
        }
        let mut pass = Pass::compute(piece.of("shadow fields"), &self.kernel, piece.count()).read(&piece.of("sizes"));
        for name in ["light", &piece.of("receivers"), "entities", "turns"] {
            pass = pass.read(name);
        }
        pass = match &self.look_up {
            Some(_) => pass.read_part("found", 0..u64::from(piece.count()) * found),
            None => pass.read("fields"),
        };
        pass = pass.read(&given_name);
        pass = match own {
            Some((name, part)) => pass.read_part(name, part),
            None => pass.read("no numbers"),
        };
        pass = pass.write_part("visibility", piece.part(seen));
        renderer.add(pass.write_part("radiance", piece.values()))
    }

    /// Moves the entities: the same as before, in the same order, elsewhere.
    pub(crate) fn place(&self, renderer: &Renderer, entities: &[PlacedField<'_>]) -> Result<(), GpuError> {
        if entities.len() != self.parts.firsts.len() {
            let (expected, found) = (self.parts.firsts.len(), entities.len());
            return Err(GpuError::Options(format!("expected the {expected} entities from before, found {found}")));
        }
        let (mut shapes, mut turns) = (Vec::new(), Vec::new());
        for (entity, first) in entities.iter().zip(&self.parts.firsts) {
            let is_turned = *entity.placement.rotation() != Rotation::IDENTITY;
            shapes.push(entity_shape(entity, *first, [turns.len() as u32, u32::from(is_turned)]));
            if is_turned {
                turns.extend(turn_entries(entity.placement.rotation(), self.order));
            }
        }
        renderer.update("entities", &shapes)?;
        renderer.update("turns", &turns)
    }

    /// Sets the light.
    pub(crate) fn set_light(&self, renderer: &Renderer, light: &[Rgb<f64>]) -> Result<(), GpuError> {
        let n = self.order * self.order;
        let mut vectors: Vec<[f32; 4]> =
            light.iter().take(n).map(|c| [c.r as f32, c.g as f32, c.b as f32, 0.0]).collect();
        vectors.resize(n, [0.0; 4]);
        renderer.update("light", &vectors)
    }
}

/// Refuses what the programs do not do.
pub(crate) fn check(
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
    if !receivers.own_visibility().is_empty() {
        return refuse("expected receivers without visibility of their own, found some".into());
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

/// Entries of the rotation of `order` bands.
pub(crate) fn entries(order: usize) -> usize {
    (0..order).map(|l| (2 * l + 1).pow(2)).sum()
}

/// The entries of a rotation, band after band and row after row.
pub(crate) fn turn_entries(rotation: &Rotation, order: usize) -> Vec<f32> {
    let matrices = RotationMatrices::<f32>::new(rotation, order);
    let rows = |l: isize| (-l..=l).flat_map(move |m| (-l..=l).map(move |k| (l, m, k)));
    (0..order as isize).flat_map(rows).map(|(l, m, k)| matrices.entry(l as usize, m, k)).collect()
}
