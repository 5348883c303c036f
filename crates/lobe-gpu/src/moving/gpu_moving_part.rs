//! One part of a moving scene on the device, with all that hides the sky from it.

use std::f32::consts::FRAC_1_PI;

use lobe_sh::{Coefficient as _, Expansion as _, Rgb, ShVec};
use lobe_shadow::{LogTable, PlacedField, Placement, ShadowFieldOptions, ShadowReceivers, SkyLight, SphereShadows};

use crate::context::context::Context;
use crate::error::GpuError;
use crate::moving::field_passes::{Answer, FieldPasses, FieldResponse, check};
use crate::moving::receiver_shapes::{ReceiverShape, receiver_shapes};
use crate::moving::sky_light_passes::SkyLightPasses;
use crate::moving::sphere_passes::SpherePasses;
use crate::moving::still_grid::{GridPasses, StillGrid};
use crate::renderer::pieces::{Piece, VALUE, cut};
use crate::renderer::renderer::Renderer;

/// What may hide the sky from a part, whatever the moment.
#[derive(Clone, Copy, Debug)]
pub struct MovingObstacles<'a> {
    /// Entities with occlusion fields, up to 64, each somewhere.
    pub fields: &'a [PlacedField<'a>],
    /// How fields are looked up: linearly.
    pub options: &'a ShadowFieldOptions,
    /// What stands still, in the world.
    pub grids: &'a [StillGrid<'a>],
    /// Logarithms of spheres.
    pub table: &'a LogTable,
    /// Spheres at most.
    pub most_spheres: usize,
}

/// Where everything is at a moment: in the frame of the part, but for the frame itself.
#[derive(Clone, Copy, Debug)]
pub struct MovingPlaces<'a> {
    /// The frame of the part in the world.
    pub frame: Placement,
    /// The entities from before, in the same order.
    pub fields: &'a [PlacedField<'a>],
    /// The spheres, if there are any.
    pub spheres: Option<&'a SphereShadows<'a>>,
    /// The receivers, if the part was deformed; else they are where they were.
    pub receivers: Option<ShadowReceivers<'a>>,
}

/// A part of a moving scene under what moves and what stands still, on a device: `lobe_motion::MovingShading` of orders 1 to 6 without
/// lamps and without light that spheres send on, every sphere by itself.
///
/// ```text
///   B = ρ Σ_i L_i (V T)_i        V = Π_grids V_still · exp(Σ_spheres log V_sphere) · Π_fields (1 - O)
/// ```
///
/// `T` is transfer of the part, or the clamped cosine over π, then applied by the operator of [`SkyLight`]. `ρ` is the albedo of the
/// receivers; give them none if their transfer has it.
///
/// Passes `accumulate`, `still visibility`, `shadow fields` and `sky light`, as far as there is work for them, for as many pieces of the
/// receivers as the bindings of the device demand.
#[derive(Debug)]
pub struct GpuMovingPart {
    renderer: Renderer,
    order: usize,
    receivers: usize,
    pieces: Vec<Piece>,
    spheres: Option<SpherePasses>,
    grids: Vec<GridPasses>,
    fields: Option<FieldPasses>,
    /// None where there is transfer.
    sky_light: Option<SkyLightPasses>,
}

impl GpuMovingPart {
    /// Uploads receivers and what may hide the sky from them.
    ///
    /// # Errors
    /// [`GpuError::Options`] if the order is not 1 to 6, that of the table, or at most those of fields, grids and
    /// transfer, there are more than 64 entities, numbers of receivers differ, these have visibility of their own, or
    /// fields are to be interpolated otherwise than linearly; [`GpuError::Unsupported`] if anything is too large for
    /// the device; [`GpuError::Device`] if the device fails.
    pub fn new(
        context: &Context,
        order: usize,
        receivers: &ShadowReceivers<'_>,
        response: FieldResponse<'_>,
        obstacles: &MovingObstacles<'_>,
    ) -> Result<Self, GpuError> {
        check(order, obstacles.fields, receivers, response, obstacles.options)?;
        if obstacles.table.order() != order {
            let found = obstacles.table.order();
            return Err(GpuError::Options(format!("expected a table of order {order}, found {found}")));
        }
        let (count, seen) = (receivers.len(), 4 * (order * order) as u64);
        let mut renderer = Renderer::new(context);
        let spheres = match obstacles.most_spheres {
            0 => None,
            most => Some(SpherePasses::upload(&mut renderer, obstacles.table, most)?),
        };
        let upload = |(number, grid)| GridPasses::upload(&mut renderer, order, number, grid);
        let grids = obstacles.grids.iter().enumerate().map(upload).collect::<Result<Vec<_>, _>>()?;
        let answer = Answer::to(response);
        let is_cosine = matches!(answer, Answer::Visibility);
        let is_open = spheres.is_none() && grids.is_empty();
        let needs_fields = !is_cosine || is_open || !obstacles.fields.is_empty();
        let upload =
            |renderer: &mut Renderer| FieldPasses::upload(renderer, order, obstacles.fields, answer, obstacles.options);
        let fields = needs_fields.then(|| upload(&mut renderer)).transpose()?;
        let sky_light = is_cosine.then(|| SkyLightPasses::upload(&mut renderer, order)).transpose()?;
        renderer.allocate("radiance", VALUE * count as u64)?;
        let found = fields.as_ref().map_or(0, FieldPasses::found_bytes);
        let own =
            [size_of::<ReceiverShape>() as u64, 4 * answer.given(order) as u64, found].into_iter().fold(0, u64::max);
        let pieces = cut(context, "receivers", count, own, &[seen, VALUE])?;
        let mut part = Self { renderer, order, receivers: count, pieces, spheres, grids, fields, sky_light };
        part.add_passes(receivers, response)?;
        Ok(part)
    }

    fn add_passes(&mut self, receivers: &ShadowReceivers<'_>, response: FieldResponse<'_>) -> Result<(), GpuError> {
        let (renderer, seen) = (&mut self.renderer, 4 * (self.order * self.order) as u64);
        for piece in &self.pieces {
            renderer.upload(&piece.of("receivers"), &receiver_shapes(receivers, piece.items.clone()))?;
        }
        let all = seen * self.receivers as u64;
        // The buffer that has what receivers see so far.
        let mut last: Option<String> = None;
        if let Some(spheres) = &self.spheres {
            renderer.allocate("past spheres", all)?;
            self.pieces.iter().try_for_each(|piece| spheres.add(renderer, piece, ("past spheres", seen)))?;
            last = Some("past spheres".into());
        }
        for (number, grid) in self.grids.iter_mut().enumerate() {
            let output = format!("past grid {number}");
            renderer.allocate(&output, all)?;
            for piece in &self.pieces {
                grid.add(renderer, piece, (last.as_deref(), &output, seen))?;
            }
            last = Some(output);
        }
        if let Some(fields) = &self.fields {
            renderer.allocate("visibility", all)?;
            let (each, transfer) = match response {
                FieldResponse::Cosine => (0, &[][..]),
                FieldResponse::Transfer(transfer) => {
                    (transfer.channels().count() * self.order * self.order, transfer.coefficients())
                }
            };
            for piece in &self.pieces {
                let given = &transfer[each * piece.items.start..each * piece.items.end];
                fields.add(renderer, piece, given, last.as_deref().map(|name| (name, piece.part(seen))))?;
            }
            last = Some("visibility".into());
        }
        if let (Some(sky_light), Some(visibility)) = (&self.sky_light, &last) {
            self.pieces
                .iter()
                .try_for_each(|piece| sky_light.add(renderer, piece, (visibility.as_str(), seen), "radiance"))?;
        }
        Ok(())
    }

    /// The passes, and the buffer `radiance` that they write.
    #[must_use]
    pub fn renderer(&self) -> &Renderer {
        &self.renderer
    }

    /// Number of receivers.
    #[must_use]
    pub fn receivers(&self) -> usize {
        self.receivers
    }

    /// Shades the receivers at a moment under distant light, an expansion of radiance in the world. Does not wait for the device.
    ///
    /// # Errors
    /// [`GpuError::Options`] if entities or receivers are not as many as before, or spheres more than there is room for;
    /// [`GpuError::Device`] if the device fails.
    pub fn shade(&mut self, places: &MovingPlaces<'_>, light: &ShVec<Rgb<f64>>) -> Result<(), GpuError> {
        if let Some(receivers) = &places.receivers {
            if receivers.len() != self.receivers {
                let (expected, found) = (self.receivers, receivers.len());
                return Err(GpuError::Options(format!("expected the {expected} receivers from before, found {found}")));
            }
            for piece in &self.pieces {
                self.renderer.update(&piece.of("receivers"), &receiver_shapes(receivers, piece.items.clone()))?;
            }
        }
        match &mut self.spheres {
            Some(spheres) => spheres.set(&self.renderer, &self.pieces, places.spheres)?,
            None if places.spheres.is_some() => {
                return Err(GpuError::Options("expected no spheres, for which there is no room, found some".into()));
            }
            None => {}
        }
        self.grids.iter().try_for_each(|grid| grid.place(&self.renderer, &self.pieces, &places.frame))?;
        let light = light.rotated(&places.frame.rotation().inverse());
        if let Some(fields) = &self.fields {
            fields.place(&self.renderer, places.fields)?;
            fields.set_light(&self.renderer, light.coefficients())?;
        }
        if let Some(sky_light) = &self.sky_light {
            let sky = SkyLight::new(&light.map(Rgb::narrow), self.order)
                .map_err(|error| GpuError::Options(error.to_string()))?;
            sky_light.set(&self.renderer, &sky, FRAC_1_PI)?;
        }
        self.renderer.run()
    }

    /// The exit radiance of every receiver that was shaded last. Waits for the device.
    ///
    /// # Errors
    /// [`GpuError::Device`] if the device fails.
    pub fn radiance(&self) -> Result<Vec<Rgb<f32>>, GpuError> {
        let values: Vec<[f32; 4]> = self.renderer.read("radiance", self.receivers)?;
        Ok(values.into_iter().map(|[r, g, b, _]| Rgb::new(r, g, b)).collect())
    }
}
