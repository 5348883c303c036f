//! The numbers of all fields in as many parts as the bindings of the device demand, and receivers that look them up part by part.

use bytemuck::{Pod, Zeroable};
use lobe_shadow::PlacedField;

use crate::context::context::Context;
use crate::error::GpuError;
use crate::renderer::kernel::{Kernel, Slot};
use crate::renderer::pass::Pass;
use crate::renderer::pieces::Piece;
use crate::renderer::renderer::Renderer;
use crate::renderer::shader::Shader;

/// The parts of the numbers of all fields.
pub(crate) struct FieldParts {
    /// The first number of each entity's field, among those of all.
    pub(crate) firsts: Vec<u32>,
    /// Where parts begin, and the end of the last: whole points.
    ends: Vec<usize>,
    entities: usize,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct PartShape {
    first: u32,
    end: u32,
    receivers: u32,
    entities: u32,
}

impl FieldParts {
    /// Uploads every field once, however many entities have it: as `fields`, or in parts `fields 0` and so on.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] if there are more numbers than words of 32 bits count, or a point of a field does not fit a binding.
    pub(crate) fn upload(renderer: &mut Renderer, entities: &[PlacedField<'_>]) -> Result<Self, GpuError> {
        let most = (renderer.context().max_storage_binding() / 4) as usize;
        let (mut numbers, mut firsts, mut ends) = (Vec::new(), Vec::<u32>::new(), vec![0]);
        for (k, entity) in entities.iter().enumerate() {
            let before = entities[..k].iter().position(|other| std::ptr::eq(other.field, entity.field));
            let first = numbers.len();
            let beyond = || unsupported("at most 4294967295 numbers in the fields of a scene", first);
            firsts.push(match before {
                Some(other) => firsts[other],
                None => u32::try_from(first).map_err(|_| beyond())?,
            });
            if before.is_some() {
                continue;
            }
            let (rows, order) = (entity.field.rows(), entity.field.order());
            let row = order + order * order;
            if row > most {
                return Err(unsupported(&format!("bindings of at least {} bytes", 4 * row), 4 * most));
            }
            for point in 1..=rows.len() / row {
                let (begin, end) = (ends.last().copied().unwrap_or(0), first + point * row);
                if end - begin > most {
                    ends.push(end - row);
                }
            }
            numbers.extend_from_slice(rows);
        }
        ends.push(numbers.len());
        let parts = Self { firsts, ends, entities: entities.len() };
        if parts.is_whole() {
            renderer.upload("fields", &numbers)?;
        } else {
            for (k, part) in parts.ends.windows(2).enumerate() {
                renderer.upload(&format!("fields {k}"), &numbers[part[0]..part[1]])?;
            }
        }
        Ok(parts)
    }

    /// Whether all numbers are in one buffer.
    pub(crate) fn is_whole(&self) -> bool {
        self.ends.len() <= 2
    }

    /// Bytes of what a receiver finds in all fields, looked up part by part; none where that is not needed.
    pub(crate) fn found_bytes(&self, order: usize) -> u64 {
        if self.is_whole() { 0 } else { 4 * (self.entities * (order + order * order)) as u64 }
    }

    /// The program that looks up a part.
    pub(crate) fn kernel(context: &Context, order: usize) -> Result<Kernel, GpuError> {
        let shader = Shader::new(&[]).order(order).module("look_up_fields");
        let slots = [Slot::Uniform, Slot::Read, Slot::Read, Slot::Read, Slot::Write];
        Kernel::new(context, "look up fields", &shader, &slots)
    }

    /// Adds the passes that look up all parts for a piece of the receivers, one after the other.
    pub(crate) fn add_look_ups(
        &self,
        renderer: &mut Renderer,
        kernel: &Kernel,
        piece: &Piece,
        found: u64,
    ) -> Result<(), GpuError> {
        for (k, part) in self.ends.windows(2).enumerate() {
            let (of, shape) = (format!("look up fields {k} of"), piece.of(&format!("fields {k} shape")));
            let (first, end) = (part[0] as u32, part[1] as u32);
            let value = PartShape { first, end, receivers: piece.count(), entities: self.entities as u32 };
            renderer.uniform(&shape, &value)?;
            let pass = Pass::compute(piece.of(&of), kernel, piece.count() * self.entities as u32).read(&shape);
            let pass = pass.read(&piece.of("receivers")).read("entities").read(&format!("fields {k}"));
            renderer.add(pass.write_part("found", 0..u64::from(piece.count()) * found))?;
        }
        Ok(())
    }
}

fn unsupported(expected: &str, found: usize) -> GpuError {
    GpuError::Unsupported { place: "fields".into(), message: format!("expected {expected}, found {found}") }
}
