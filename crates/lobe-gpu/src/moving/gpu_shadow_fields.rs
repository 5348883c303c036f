//! Precomputed shadow fields on the device.

use lobe_sh::Rgb;
use lobe_shadow::{PlacedField, ShadowFieldOptions, ShadowReceivers};

use crate::moving::field_passes::{Answer, FieldPasses, FieldResponse, check};
use crate::moving::receiver_shapes::{ReceiverShape, planes, receiver_shapes, white_receiver_shapes};
use crate::renderer::pieces::{VALUE, cut};
use crate::renderer::renderer::Renderer;
use crate::{Context, GpuError};

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
    fields: FieldPasses,
    receivers: usize,
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
        let (n, count, answer) = (order * order, receivers.len(), Answer::to(response));
        let mut renderer = Renderer::new(context);
        let fields = FieldPasses::upload(&mut renderer, order, entities, answer, options)?;
        renderer.allocate("visibility", 4 * (n * count) as u64)?;
        renderer.allocate("radiance", VALUE * count as u64)?;
        let (each, seen) = (answer.given(order), 4 * n as u64);
        let largest = [size_of::<ReceiverShape>() as u64, 4 * each as u64, fields.found_bytes()];
        let pieces = cut(context, "receivers", count, largest.into_iter().fold(0, u64::max), &[seen, VALUE])?;
        let transfer = if let FieldResponse::Transfer(transfer) = response { transfer.coefficients() } else { &[] };
        for piece in &pieces {
            let of = |numbers: &'_ [f32], each: usize| {
                numbers.get(each * piece.items.start..each * piece.items.end).unwrap_or_default().to_vec()
            };
            let shapes = match response {
                FieldResponse::Cosine => receiver_shapes(receivers, piece.items.clone()),
                // Their albedo is in their transfer.
                FieldResponse::Transfer(_) => white_receiver_shapes(receivers, piece.items.clone()),
            };
            renderer.upload(&piece.of("receivers"), &shapes)?;
            let own = of(receivers.own_visibility(), n);
            let name = piece.of("own");
            if !own.is_empty() {
                renderer.upload(&name, &planes(&own, n))?;
            }
            let own = (!own.is_empty()).then(|| (name.as_str(), 0..seen * u64::from(piece.count())));
            fields.add(&mut renderer, piece, &of(transfer, each), own)?;
        }
        fields.place(&renderer, entities)?;
        Ok(Self { renderer, fields, receivers: count })
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
        self.fields.place(&self.renderer, entities)
    }

    /// The exit radiance of every receiver under distant light, as
    /// [`ShadowFields::shade`](lobe_shadow::ShadowFields::shade) or
    /// [`ShadowFields::shade_transfer`](lobe_shadow::ShadowFields::shade_transfer).
    ///
    /// # Errors
    /// [`GpuError::Device`] if the device fails.
    pub fn exit_radiance(&self, light: &[Rgb<f64>]) -> Result<Vec<Rgb<f32>>, GpuError> {
        self.fields.set_light(&self.renderer, light)?;
        self.renderer.run()?;
        let values: Vec<[f32; 4]> = self.renderer.read("radiance", self.receivers)?;
        Ok(values.into_iter().map(|[r, g, b, _]| Rgb::new(r, g, b)).collect())
    }
}
