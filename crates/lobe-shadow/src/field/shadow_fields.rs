//! Precomputed shadow fields: what many entities leave visible at receivers, and the light that these send back.

use derive_setters::Setters;
use lobe_io::parallel;
use lobe_prt::Transfer;
use lobe_sh::rotation::RotationMatrices;
use lobe_sh::simd::{LANES, Lanes, Machine};
use lobe_sh::{Rgb, Rotation, ShVec};

use crate::error::ShadowError;
use crate::field::chain::{Chain, ChainScratch, Group, PlacedLamp, Response, cosine_factors};
use crate::field::field_grid::RadialInterpolation;
use crate::field::occlusion_field::OcclusionField;
use crate::field::placed::Placed;
use crate::field::radiance_field::RadianceField;
use crate::lane_basis::LaneBasis;
use crate::placement::Placement;
use crate::receivers::ShadowReceivers;

/// An entity that hides the sky, and where it is.
#[derive(Clone, Copy, Debug)]
pub struct PlacedField<'a> {
    /// What it hides.
    pub field: &'a OcclusionField,
    /// Where.
    pub placement: Placement,
}

/// A lamp, and where it is.
#[derive(Clone, Copy, Debug)]
pub struct LocalLight<'a> {
    /// Its light.
    pub field: &'a RadianceField,
    /// Where.
    pub placement: Placement,
}

/// Options of [`ShadowFields`].
#[derive(Clone, Debug, PartialEq, Setters, serde::Serialize, serde::Deserialize)]
#[serde(default)]
#[non_exhaustive]
pub struct ShadowFieldOptions {
    /// Between the spheres of fields.
    pub interpolation: RadialInterpolation,
    /// At every receiver the entities that look smallest are left out, as many as have no more than this solid angle in all,
    /// in steradians, by their bounding spheres. Of exact functions that changes a coefficient of visibility by no more than
    /// `negligible √((2n - 1)/4π)`, and exit radiance by no more than `negligible ρ/π` times the largest radiance of the light;
    /// truncated ones overshoot, by less than a half of that in the test
    /// `what_is_left_out_changes_light_by_no_more_than_its_bound`. 0 leaves out none.
    pub negligible: f64,
}

impl Default for ShadowFieldOptions {
    /// A thousandth of a hemisphere is left out.
    fn default() -> Self {
        Self { interpolation: RadialInterpolation::Linear, negligible: 2e-3 * std::f64::consts::PI }
    }
}

/// Entities and lamps where they are, which hide and light receivers ([Zhou et al. 2005]).
///
/// ```text
///   V = V_own Π_k (1 - O_k)                  nearest entity first, each product cut off at the order
///   B = ρ Σ_i L_i (V T)_i + ρ Σ_lamps Σ_i S_i (V_lamp T)_i        T = max(n·s, 0)/π, V_lamp: of what is nearer than it
/// ```
///
/// Placements, receivers and light are in one frame. Of the rotations of the paper's loop, one of every looked-up vector at
/// every receiver, those of entities that are not turned in that frame are left out, and `V_own` and transfer of an entity
/// that moves are never turned: take the entity's own frame, by [`relative_placement`] for the others and by turning the
/// light once.
///
/// Receivers go through the products sixteen at a time, a lane of a vector register each, neighbors together, and on all
/// threads. Results depend neither on the threads nor on which receivers are asked together. Machines that round a product
/// and a sum together differ from others in the last digits.
///
/// Entities whose bounding spheres lie below the horizon of a receiver are left out, but not where the receiver's transfer is
/// given, which may come from there by way of other surfaces. The exact cosine is 0 there, that of `n` bands, `t_n`, is not. As `t_n` has no
/// further bands, its product with visibility that is cut off is that with the exact one, and what an entity in the cap `C` below the horizon would have
/// changed of exit radiance is
///
/// ```text
///   |ΔB| <= ρ max|L| ∫_C |t_n| ds        t_n(s) = Σ_(l<n) of max(n·s, 0)/π
/// ```
///
/// where nothing else hides the sky; of several the factors of the others come in, which are 1 and less but for their ringing. The integral at orders 3
/// and 4, 6, 8 (test `the_residue_of_a_truncated_cosine_below_the_horizon_is_what_is_stated`; those of fields keep it, test
/// `a_field_below_the_horizon_that_is_left_out_changes_exit_radiance_by_no_more_than_the_residue_in_its_cap`):
///
/// | `C` | 3, 4 | 6 | 8 |
/// |---|---|---|---|
/// | all below the horizon | 0.061 | 0.030 | 0.018 |
/// | a ball of nine tenths of its distance | 0.033 | 0.014 | 0.008 |
/// | a ball of a third of its distance | 0.006 | 0.002 | 0.001 |
///
/// The largest are of balls well below. As one of a third of its distance sinks through the horizon, exit radiance under a uniform sky jumps by less than
/// a thousandth of that in the open at order 4 (test `an_entity_that_sinks_below_the_horizon_leaves_with_a_small_step`).
///
/// Which entities are nearest is judged by their middles, and those of lamps. Entities may overlap each other and receivers
/// may lie within: a product of visibilities counts what both hide once, but truncated products of the same function ring,
/// as the test `overlapping_entities_hide_what_both_hide_once` shows.
///
/// [Zhou et al. 2005]: https://doi.org/10.1145/1073204.1073332
///
/// ```
/// use lobe_io::Job;
/// use lobe_scene::built_in;
/// use lobe_sh::{Expansion as _, Rotation};
/// use lobe_shadow::{PlacedField, FieldOptions, Placement, ShadowFieldOptions, ShadowFields, bake_field};
///
/// let options = FieldOptions::default().order(3).spheres(4).cells(4).rays(64);
/// let (field, _) = bake_field(&built_in::ball_over_ground(8), &options, Job::default())?;
/// let above = Placement::new([0.0, 0.0, 6.0], Rotation::IDENTITY, 1.0);
/// let fields = ShadowFields::new(3, &[PlacedField { field: &field, placement: above }], ShadowFieldOptions::default())?;
/// let visible = fields.visibility_at([0.0; 3], None, None)?;
/// assert!(visible.mean() < 0.95, "the scene above hides a part of the sky");
/// # Ok::<(), lobe_shadow::ShadowError>(())
/// ```
#[derive(Clone, Debug)]
pub struct ShadowFields<'a> {
    order: usize,
    entities: Vec<PlacedField<'a>>,
    lights: Vec<LocalLight<'a>>,
    options: ShadowFieldOptions,
}

impl<'a> ShadowFields<'a> {
    /// Entities, all of whose fields have `order` bands or more; of more the first are used. Without entities everything is
    /// visible.
    ///
    /// # Errors
    /// [`ShadowError::Options`] if the order is not 1 to 8 or above that of a field, or `negligible` is negative.
    pub fn new(order: usize, entities: &[PlacedField<'a>], options: ShadowFieldOptions) -> Result<Self, ShadowError> {
        if !(1..=8).contains(&order) {
            return Err(ShadowError::Options(format!("expected an order of 1 to 8, found {order}")));
        }
        if !(options.negligible >= 0.0 && options.negligible.is_finite()) {
            let message = format!("expected a negligible solid angle of 0 or above, found {}", options.negligible);
            return Err(ShadowError::Options(message));
        }
        for (k, entity) in entities.iter().enumerate() {
            expect_order("the field of entity", k, entity.field.order(), order)?;
        }
        Ok(Self { order, entities: entities.to_vec(), lights: Vec::new(), options })
    }

    /// The same with lamps.
    ///
    /// # Errors
    /// [`ShadowError::Options`] if one has fewer bands.
    pub fn with_lights(mut self, lights: &[LocalLight<'a>]) -> Result<Self, ShadowError> {
        for (k, light) in lights.iter().enumerate() {
            expect_order("the light of lamp", k, light.field.order(), self.order)?;
        }
        self.lights = lights.to_vec();
        Ok(self)
    }

    /// Number of bands.
    #[must_use]
    pub fn order(&self) -> usize {
        self.order
    }

    /// What is visible from one point. With a normal, entities below its horizon are left out: only what is above is of use
    /// then.
    ///
    /// # Errors
    /// [`ShadowError::Invalid`] if a number is not finite, the normal has not length 1, or `own` does not have `order²` numbers.
    pub fn visibility_at(
        &self,
        position: [f32; 3],
        normal: Option<[f32; 3]>,
        own: Option<&[f32]>,
    ) -> Result<ShVec<f32>, ShadowError> {
        let (positions, normals) = ([position], [normal.unwrap_or([0.0, 0.0, 1.0])]);
        let mut receivers = ShadowReceivers::new(&positions, &normals)?;
        if let Some(own) = own {
            receivers = receivers.with_own_visibility(self.order, own)?;
        }
        let group = self.group(&receivers, &[0], normal.is_some());
        let mut out = vec![0.0; self.order * self.order];
        self.chain().visibility_into(&group, &mut ChainScratch::default(), &mut out);
        Ok(ShVec::from_vec(out).unwrap_or_else(|| unreachable!("order² places were made")))
    }

    /// What is visible above the horizon of every receiver: `order²` numbers each.
    ///
    /// # Errors
    /// [`ShadowError::Options`] if the visibility of their own has another order.
    pub fn visibility(&self, receivers: &ShadowReceivers<'_>) -> Result<Vec<f32>, ShadowError> {
        self.check_own(receivers)?;
        let n = self.order * self.order;
        let chain = self.chain();
        Ok(self.of_groups(receivers, true, &vec![0.0; n], &|group, scratch, out| {
            chain.visibility_into(group, scratch, out);
        }))
    }

    /// The exit radiance of matte receivers under distant light, an expansion of any order, and the lamps.
    ///
    /// # Errors
    /// As [`ShadowFields::visibility`].
    pub fn shade(&self, receivers: &ShadowReceivers<'_>, light: &[Rgb<f64>]) -> Result<Vec<Rgb<f32>>, ShadowError> {
        self.check_own(receivers)?;
        let mut out = self.shade_with(receivers, Response::Cosine, light);
        for (k, out) in out.iter_mut().enumerate() {
            let [r, g, b] = receivers.albedo(k);
            *out = Rgb::new(out.r * r, out.g * g, out.b * b);
        }
        Ok(out)
    }

    /// The exit radiance of receivers whose transfer was baked: it is multiplied by what the entities leave visible, and by
    /// visibility of the receivers' own, if they have some: of what is in neither. Their albedo is in their transfer; that of
    /// the receivers is not used.
    ///
    /// Transfer of more bands than the fields is cut off.
    ///
    /// # Errors
    /// [`ShadowError::Options`] if the transfer has fewer bands, or is not that of as many receivers.
    pub fn shade_transfer(
        &self,
        receivers: &ShadowReceivers<'_>,
        transfer: &Transfer,
        light: &[Rgb<f64>],
    ) -> Result<Vec<Rgb<f32>>, ShadowError> {
        expect_order("the transfer of scene", 0, transfer.order(), self.order)?;
        if transfer.receivers() != receivers.len() {
            let (expected, found) = (receivers.len(), transfer.receivers());
            return Err(ShadowError::Options(format!("expected transfer of {expected} receivers, found {found}")));
        }
        let full = transfer.order() * transfer.order();
        let n = self.order * self.order;
        let cut: Vec<f32>;
        let rows = if full == n {
            transfer.coefficients()
        } else {
            cut = transfer.coefficients().chunks_exact(full).flat_map(|row| &row[..n]).copied().collect();
            &cut
        };
        self.check_own(receivers)?;
        Ok(self.shade_with(receivers, Response::Transfer { rows, channels: transfer.channels().count() }, light))
    }

    fn shade_with(&self, receivers: &ShadowReceivers<'_>, response: Response<'_>, light: &[Rgb<f64>]) -> Vec<Rgb<f32>> {
        let n = self.order * self.order;
        let mut channels = vec![0.0; 3 * n];
        for (i, color) in light.iter().take(n).enumerate() {
            (0..3).for_each(|c| channels[c * n + i] = color.to_array()[c] as f32);
        }
        let chain = self.chain();
        // Transfer may come from below the horizon, by way of other surfaces.
        let horizon = matches!(response, Response::Cosine);
        self.of_groups(receivers, horizon, &[Rgb::new(0.0, 0.0, 0.0)], &|group, scratch, out| {
            chain.shade_into(group, response, &channels, scratch, out);
        })
    }

    /// What `of` finds for every group of neighbors, with or without a horizon, as many values as `zero` has for each receiver, in the order of the
    /// receivers.
    fn of_groups<T: Copy + Send + Sync>(
        &self,
        receivers: &ShadowReceivers<'_>,
        horizon: bool,
        zero: &[T],
        of: &(dyn Fn(&Group<'_>, &mut ChainScratch, &mut [T]) + Sync),
    ) -> Vec<T> {
        let members = receivers.coherent_order();
        let width = zero.len();
        let mut found = zero.repeat(members.len());
        let of_group = |scratch: &mut ChainScratch, group: usize, out: &mut [T]| {
            let members = &members[group * LANES..][..out.len() / width];
            of(&self.group(receivers, members, horizon), scratch, out);
        };
        parallel::rows_with(&mut found, LANES * width, &ChainScratch::default, &of_group);
        let mut out = zero.repeat(members.len());
        for (member, found) in members.iter().zip(found.chunks_exact(width)) {
            out[*member as usize * width..][..width].copy_from_slice(found);
        }
        out
    }

    /// Everything prepared.
    fn chain(&self) -> Chain<'a> {
        let lamp = |light: &LocalLight<'a>| PlacedLamp {
            field: light.field,
            placement: light.placement,
            center: light.placement.to_world(light.field.center()),
            turn: (*light.placement.rotation() != Rotation::IDENTITY)
                .then(|| RotationMatrices::new(light.placement.rotation(), self.order)),
        };
        let placed = |e: &PlacedField<'a>| Placed::new(e.field, &e.placement, self.order, self.options.interpolation);
        Chain {
            machine: Machine::detect(),
            order: self.order,
            entities: self.entities.iter().map(placed).collect(),
            lamps: self.lights.iter().map(lamp).collect(),
            negligible: self.options.negligible as f32,
            interpolation: self.options.interpolation,
            basis: LaneBasis::new(self.order),
            cosine: cosine_factors(self.order),
        }
    }

    fn group<'r>(&self, receivers: &ShadowReceivers<'r>, members: &'r [u32], horizon: bool) -> Group<'r> {
        let (positions, normals) = (receivers.positions(), receivers.normals());
        let member = |lane: usize| members[lane.min(members.len() - 1)] as usize;
        Group {
            positions: std::array::from_fn(|c| std::array::from_fn(|lane| f64::from(positions[member(lane)][c]))),
            normals: horizon.then(|| [0, 1, 2].map(|c| Lanes(std::array::from_fn(|lane| normals[member(lane)][c])))),
            own: std::array::from_fn(|lane| {
                receivers.own(member(lane), receivers.own_width()).filter(|own| !own.is_empty())
            }),
            members,
        }
    }

    fn check_own(&self, receivers: &ShadowReceivers<'_>) -> Result<(), ShadowError> {
        let (expected, found) = (self.order * self.order, receivers.own_width());
        if found == 0 || found == expected {
            return Ok(());
        }
        Err(ShadowError::Options(format!(
            "expected visibility of {expected} numbers for each receiver, that of order {}, found {found}",
            self.order
        )))
    }
}

/// Where something is as seen from another frame: `frame⁻¹ of`. Placing all others so and turning the light by the inverse
/// of the frame's rotation leaves the vectors of receivers in that frame as they were baked.
#[must_use]
pub fn relative_placement(of: &Placement, frame: &Placement) -> Placement {
    let rotation = of.rotation().then(frame.rotation().inverse());
    Placement::new(frame.to_own(of.translation()), rotation, of.scale() / frame.scale())
}

fn expect_order(what: &str, k: usize, found: usize, expected: usize) -> Result<(), ShadowError> {
    if found >= expected {
        return Ok(());
    }
    Err(ShadowError::Options(format!("expected {what} {k} to have {expected} bands at least, found {found}")))
}
