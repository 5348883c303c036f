//! An occlusion field where its entity is.

use std::borrow::Cow;

use lobe_sh::{Rotation, RotationMatrices};

use crate::field::axial::Axial;
use crate::field::occlusion_field::toward_middle;
use crate::{OcclusionField, Placement, RadialInterpolation};

/// An occlusion field with its place, prepared for lookups whose results are in the directions of the world.
#[derive(Debug)]
pub(crate) struct Placed<'a> {
    field: &'a OcclusionField,
    axial: Axial,
    order: usize,
    /// The rows of the order in use: turned into the world, or in the entity's frame with `turn` left to do.
    rows: Cow<'a, [f32]>,
    turn: Option<RotationMatrices<f32>>,
    center: [f64; 3],
    radius: f64,
    /// `Rᵀ/s`, from differences in the world to those in the entity's frame.
    to_own: [[f32; 3]; 3],
}

impl<'a> Placed<'a> {
    /// `lookups` says how many will be asked for. If these are more than the field has rows, all rows are turned once
    /// instead of every result. An entity that is not turned needs neither.
    pub(crate) fn new(field: &'a OcclusionField, placement: &Placement, order: usize, lookups: usize) -> Self {
        let rotation = placement.rotation();
        let turn = (*rotation != Rotation::IDENTITY).then(|| RotationMatrices::new(rotation, order));
        let turn_rows = turn.is_some() && lookups >= field.grid().points();
        let rows = if turn_rows {
            Cow::Owned(field.turned_rows(order, turn.as_ref()))
        } else if order < field.order() {
            Cow::Owned(field.turned_rows(order, None))
        } else {
            Cow::Borrowed(field.rows())
        };
        let m = rotation.matrix();
        Self {
            field,
            axial: if order == field.order() { field.axial().clone() } else { Axial::new(order) },
            order,
            rows,
            turn: if turn_rows { None } else { turn },
            center: placement.to_world(field.grid().center()),
            radius: placement.scale() * field.grid().radius(),
            to_own: std::array::from_fn(|k| std::array::from_fn(|c| (m[c][k] / placement.scale()) as f32)),
        }
    }

    /// From a point of the world to the middle of the entity.
    #[inline]
    pub(crate) fn towards(&self, point: [f32; 3]) -> [f64; 3] {
        std::array::from_fn(|k| self.center[k] - f64::from(point[k]))
    }

    /// The radius of the bounding sphere in the world.
    #[inline]
    pub(crate) fn radius(&self) -> f64 {
        self.radius
    }

    /// The occlusion at a point from where the middle is seen `towards` there. `scratch` has `order + order²` places.
    #[inline]
    pub(crate) fn occlusion_into(
        &self,
        towards: [f64; 3],
        interpolation: RadialInterpolation,
        scratch: &mut [f32],
        out: &mut [f32],
    ) {
        let d = towards.map(|c| -c as f32);
        let offset = self.to_own.map(|row| row[0] * d[0] + row[1] * d[1] + row[2] * d[2]);
        let stencil = self.field.grid().stencil(offset, interpolation);
        stencil.sum_into(&self.rows, scratch);
        let (zonal, rest) = scratch.split_at_mut(self.order);
        match &self.turn {
            None => out.copy_from_slice(rest),
            Some(turn) => turn.apply_into(rest, out),
        }
        // The zonal part is evaluated in the world's direction and needs no rotation.
        if let Some(axis) = toward_middle(d) {
            self.axial.add_zonal(axis, zonal, rest, out);
        }
    }
}
