//! An occlusion field where its entity is.

use std::borrow::Cow;

use lobe_sh::{Rotation, RotationMatrices};

use crate::field::occlusion_field::toward_middle;
use crate::{OcclusionField, Placement, RadialInterpolation};

/// An occlusion field with its place, prepared for lookups whose results are in the directions of the world.
#[derive(Debug)]
pub(crate) struct Placed<'a> {
    field: &'a OcclusionField,
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

    /// The occlusion at a point from where the middle is seen `towards` there: the factors of its zonal part into `zonal`,
    /// the rest into `rest`, both in the world. Returns the axis of the former. `scratch` has `order + order²` places.
    #[inline]
    pub(crate) fn occlusion_into(
        &self,
        towards: [f64; 3],
        interpolation: RadialInterpolation,
        scratch: &mut [f32],
        zonal: &mut [f32],
        rest: &mut [f32],
    ) -> [f32; 3] {
        let d = towards.map(|c| -c as f32);
        let offset = self.to_own.map(|row| row[0] * d[0] + row[1] * d[1] + row[2] * d[2]);
        self.field.grid().stencil(offset, interpolation).sum_into(&self.rows, scratch);
        let (z, g) = scratch.split_at(zonal.len());
        zonal.copy_from_slice(z);
        match &self.turn {
            None => rest.copy_from_slice(g),
            Some(turn) => turn.apply_into(g, rest),
        }
        // At the middle itself nothing is zonal, whatever the axis.
        toward_middle(d).unwrap_or([0.0, 0.0, 1.0])
    }
}
