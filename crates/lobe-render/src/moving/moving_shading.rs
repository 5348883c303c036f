//! Shading of moving scenes: what each vertex sends back of the sky that the other parts leave visible to it.

use std::f32::consts::FRAC_1_PI;

use derive_setters::Setters;
use lobe_sh::{Coefficient as _, Expansion as _, Rgb, ShVec};
use lobe_shadow::{
    LogTable, LogTableOptions, Occluder, PlacedField, ShadowFieldOptions, ShadowFields, ShadowOptions, ShadowReceivers,
    SkyLight, SphereReceivers, SphereShadows, relative_placement,
};

use crate::moving::moment::{PlacedPart, Surface};
use crate::{Moment, MovingPart, RenderError};

/// How moving parts hide the sky from others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum MovingMethod {
    /// By their occlusion fields where they have some, else by their spheres (precomputed shadow fields).
    #[default]
    Fields,
    /// By their spheres (SH exponentiation); parts that stand still by their fields, if they have some.
    Exponentials,
}

/// Options of shading a moving scene.
#[derive(Clone, Debug, Setters)]
#[non_exhaustive]
pub struct MovingOptions {
    /// How moving parts hide the sky.
    pub method: MovingMethod,
    /// Number of bands, 1 to 8.
    pub order: usize,
    /// Of products of fields.
    pub fields: ShadowFieldOptions,
    /// Of exponentials of sums of spheres.
    pub spheres: ShadowOptions,
    /// Whether spheres send light of the sky on, one bounce, in the mean albedo of what they stand for.
    pub bounce: bool,
}

impl Default for MovingOptions {
    /// Fields of order 4, without the light that moving parts send on.
    fn default() -> Self {
        Self {
            method: MovingMethod::Fields,
            order: 4,
            fields: ShadowFieldOptions::default(),
            spheres: ShadowOptions::default(),
            bounce: false,
        }
    }
}

/// Exit radiance at the vertices of a moving scene ([Zhou et al. 2005], [Ren et al. 2006]).
///
/// ```text
///   B = Σ_i L_i (V T)_i        V = Π_fields (1 - O) · exp(Σ_spheres log V_sphere)
/// ```
///
/// `T` is the transfer of the vertex from its own part, which was baked in the part's frame: light, fields and spheres are
/// taken to that frame, so that neither `T` nor `V` is ever rotated. Parts that are deformed have no transfer: there `T` is
/// albedo/π times the clamped cosine, and the part's own spheres hide the sky too. Light that is reflected between parts
/// is left out, but for what a baked part sends to itself, and [`MovingOptions::bounce`].
///
/// [Zhou et al. 2005]: https://doi.org/10.1145/1073204.1073332
/// [Ren et al. 2006]: https://doi.org/10.1145/1141911.1141982
#[derive(Clone, Debug)]
pub struct MovingShading {
    options: MovingOptions,
    table: LogTable,
}

/// What hides the sky from a part, in the frame of its surface.
struct Hiding<'a> {
    fields: Vec<PlacedField<'a>>,
    spheres: Vec<Occluder>,
    /// The albedo of each sphere.
    albedos: Vec<Rgb<f32>>,
}

impl MovingShading {
    /// Prepares the table of logarithms.
    ///
    /// # Errors
    /// [`RenderError::Shadow`] if the order is not 1 to 8.
    pub fn new(options: MovingOptions) -> Result<Self, RenderError> {
        let table = LogTable::new(&LogTableOptions::default().order(options.order))?;
        Ok(Self { options, table })
    }

    /// Number of bands.
    #[must_use]
    pub fn order(&self) -> usize {
        self.options.order
    }

    /// The exit radiance of every vertex of the moment's scene under distant light, an expansion of radiance of any order.
    ///
    /// # Errors
    /// [`RenderError::Shadow`] if transfer or a field has fewer bands than [`MovingOptions::order`], or is not of the part's
    /// vertices.
    pub fn exit_radiance(&self, moment: &Moment<'_>, light: &ShVec<Rgb<f64>>) -> Result<Vec<Rgb<f32>>, RenderError> {
        self.of_all_parts(moment, |part, placed, hiding| match &part.transfer {
            Some(_) if part.is_rigid() => self.shade_transfer(part, placed, hiding, light),
            _ => self.shade_cosine(&placed.surface, hiding, light),
        })
    }

    /// The same of the backs of all vertices, which no transfer is baked for: parts that keep their shape do not hide the sky
    /// from their own backs.
    ///
    /// # Errors
    /// As [`MovingShading::exit_radiance`].
    pub fn exit_radiance_of_backs(
        &self,
        moment: &Moment<'_>,
        light: &ShVec<Rgb<f64>>,
    ) -> Result<Vec<Rgb<f32>>, RenderError> {
        self.of_all_parts(moment, |_, placed, hiding| {
            let normals = placed.surface.normals.iter().map(|n| n.map(|c| -c)).collect();
            self.shade_cosine(&Surface { normals, ..placed.surface.clone() }, hiding, light)
        })
    }

    /// The values of all parts, one after the other.
    fn of_all_parts(
        &self,
        moment: &Moment<'_>,
        shade: impl Fn(&MovingPart, &PlacedPart, &Hiding<'_>) -> Result<Vec<Rgb<f32>>, RenderError>,
    ) -> Result<Vec<Rgb<f32>>, RenderError> {
        let mut all = Vec::with_capacity(moment.scene().vertex_count());
        for (index, (part, placed)) in moment.parts().iter().zip(&moment.placed).enumerate() {
            all.extend(shade(part, placed, &self.hiding(moment, index))?);
        }
        Ok(all)
    }

    /// What hides the sky from a part: all others, and itself if it is deformed.
    fn hiding<'a>(&self, moment: &'a Moment<'_>, receiver: usize) -> Hiding<'a> {
        let frame = &moment.placed[receiver].surface.frame;
        let mut hiding = Hiding { fields: Vec::new(), spheres: Vec::new(), albedos: Vec::new() };
        for (index, (part, placed)) in moment.parts().iter().zip(&moment.placed).enumerate() {
            if index == receiver && part.is_rigid() {
                continue;
            }
            let by_field = self.options.method == MovingMethod::Fields || matches!(part.motion, crate::Motion::Still);
            if let Some(field) = part.field.as_ref().filter(|_| by_field) {
                hiding.fields.push(PlacedField { field, placement: relative_placement(&placed.placement, frame) });
                continue;
            }
            let mean = placed.surface.mean_albedo();
            for sphere in &placed.spheres {
                let center = frame.to_own(sphere.center).map(|c| c as f32);
                hiding.spheres.push(Occluder::new(center, (sphere.radius / frame.scale()) as f32));
                hiding.albedos.push(mean);
            }
        }
        hiding
    }

    /// By the transfer of a part, of which the others hide a part.
    fn shade_transfer(
        &self,
        part: &MovingPart,
        placed: &PlacedPart,
        hiding: &Hiding<'_>,
        light: &ShVec<Rgb<f64>>,
    ) -> Result<Vec<Rgb<f32>>, RenderError> {
        let Some(transfer) = &part.transfer else { unreachable!("asked only of parts with transfer") };
        let (surface, order) = (&placed.surface, self.options.order);
        let light = surface.frame.rotation().inverse().rotated(light);
        let mut receivers = ShadowReceivers::new(&surface.positions, &surface.normals)?;
        let seen;
        let mut bounced = None;
        if !hiding.spheres.is_empty() {
            let shadows = SphereShadows::new(&self.table, &hiding.spheres, &self.options.spheres)?;
            let at = SphereReceivers::new(&surface.positions, &surface.normals)?;
            seen = shadows.visibility(&at);
            receivers = receivers.with_own_visibility(order, &seen)?;
            bounced = self.bounced(&shadows, &at, hiding, &light)?;
        }
        let fields = ShadowFields::new(order, &hiding.fields, self.options.fields.clone())?;
        let mut out = fields.shade_transfer(&receivers, transfer, light.coefficients())?;
        if part.is_demodulated {
            out.iter_mut().zip(&surface.albedos).for_each(|(out, albedo)| *out = tinted(*out, *albedo));
        }
        for (out, (more, albedo)) in out.iter_mut().zip(bounced.into_iter().flatten().zip(&surface.albedos)) {
            *out += tinted(more, *albedo);
        }
        Ok(out)
    }

    /// What spheres send on to receivers of albedo 1: exit radiance.
    fn bounced(
        &self,
        shadows: &SphereShadows<'_>,
        receivers: &SphereReceivers<'_>,
        hiding: &Hiding<'_>,
        light: &ShVec<Rgb<f64>>,
    ) -> Result<Option<Vec<Rgb<f32>>>, RenderError> {
        if !self.options.bounce {
            return Ok(None);
        }
        let sky = SkyLight::new(&light.map(Rgb::narrow), self.options.order)?;
        let bounce = shadows.bounce(&sky, &hiding.albedos)?;
        let with = shadows.irradiance_with_bounce(receivers, &sky, &bounce)?;
        let without = shadows.irradiance(receivers, &sky)?;
        let more = with.iter().zip(&without).map(|(with, without)| (*with - *without).scale(FRAC_1_PI));
        Ok(Some(more.collect()))
    }

    /// By the clamped cosine about normals.
    fn shade_cosine(
        &self,
        surface: &Surface,
        hiding: &Hiding<'_>,
        light: &ShVec<Rgb<f64>>,
    ) -> Result<Vec<Rgb<f32>>, RenderError> {
        let light = surface.frame.rotation().inverse().rotated(light);
        let receivers = SphereReceivers::new(&surface.positions, &surface.normals)?;
        let sky = SkyLight::new(&light.map(Rgb::narrow), self.options.order)?;
        let shadows = SphereShadows::new(&self.table, &hiding.spheres, &self.options.spheres)?;
        let irradiance = if hiding.fields.is_empty() {
            match self.options.bounce {
                true => {
                    let bounce = shadows.bounce(&sky, &hiding.albedos)?;
                    shadows.irradiance_with_bounce(&receivers, &sky, &bounce)?
                }
                false => shadows.irradiance(&receivers, &sky)?,
            }
        } else {
            let seen = shadows.visibility(&receivers);
            let receivers = ShadowReceivers::new(&surface.positions, &surface.normals)?;
            let receivers = receivers.with_own_visibility(self.options.order, &seen)?;
            let fields = ShadowFields::new(self.options.order, &hiding.fields, self.options.fields.clone())?;
            let seen = fields.visibility(&receivers)?;
            let rows = seen.chunks_exact(self.options.order * self.options.order).zip(&surface.normals);
            rows.map(|(visibility, normal)| sky.irradiance(*normal, visibility)).collect()
        };
        let lit = irradiance.iter().zip(&surface.albedos);
        Ok(lit.map(|(e, albedo)| tinted(e.scale(FRAC_1_PI), *albedo)).collect())
    }
}

fn tinted(light: Rgb<f32>, [r, g, b]: [f32; 3]) -> Rgb<f32> {
    Rgb::new(light.r * r, light.g * g, light.b * b)
}
