//! The light that reaches a part of a moving scene: that of the sky, past what other parts hide, and that of lamps.

use std::f32::consts::FRAC_1_PI;

use lobe_env::SceneLight;
use lobe_io::parallel;
use lobe_prt::Transfer;
use lobe_sh::product::product_into;
use lobe_sh::rotation::RotationMatrices;
use lobe_sh::{Coefficient as _, Expansion as _, Rgb, ShVec};
use lobe_shadow::{LogTable, Placement, ShadowFields, ShadowReceivers, SkyLight, SphereShadows};

use crate::baked::visibility_grid::VisibilityGrid;
use crate::light::lamp_light::{LampLight, RECEIVERS_TOGETHER};
use crate::light::part_obstacles::{PartObstacles, hiding_by_spheres, still_grids};
use crate::moving_options::MovingOptions;
use crate::scene::moment::Moment;
use crate::scene::moment::Surface;
use lobe_render::RenderError;

/// What hides the sky from a part, in the frame of its surface.
pub(crate) struct Hiding<'a> {
    obstacles: PartObstacles<'a>,
    /// The albedo of each sphere, dimmed by what stands still.
    albedos: Vec<Rgb<f32>>,
}

impl<'a> Hiding<'a> {
    /// All parts but the receiver, and that one too if it is deformed.
    pub(crate) fn of(
        moment: &'a Moment<'_>,
        receiver: usize,
        options: &MovingOptions,
        light: &ShVec<Rgb<f64>>,
    ) -> Self {
        let obstacles = PartObstacles::of(moment, receiver, options.method);
        let mut albedos = Vec::new();
        if options.bounce {
            let grids = still_grids(moment, options.method);
            for (part, placed) in hiding_by_spheres(moment, receiver, options.method) {
                let mean = || vec![placed.surface.mean_albedo(); placed.spheres.len()];
                let known = Some(&part.sphere_albedos).filter(|albedos| albedos.len() == placed.spheres.len());
                let of_part = known.cloned().unwrap_or_else(mean);
                let dim = |(sphere, albedo): (&lobe_shadow::WorldSphere, Rgb<f32>)| {
                    dimmed(albedo, &grids, sphere.center, options.order, light)
                };
                albedos.extend(placed.spheres.iter().zip(of_part).map(dim));
            }
        }
        Self { obstacles, albedos }
    }
}

/// The albedo times the part of the light of the sky that what stands still leaves at a point.
fn dimmed(
    albedo: Rgb<f32>,
    grids: &[&VisibilityGrid],
    point: [f64; 3],
    order: usize,
    light: &ShVec<Rgb<f64>>,
) -> Rgb<f32> {
    let all = (4.0 * std::f64::consts::PI).sqrt();
    let mut visible = vec![0.0; order * order];
    let mut out = albedo.to_array();
    for grid in grids {
        grid.visibility_into(point, &mut visible);
        for (c, out) in out.iter_mut().enumerate() {
            let of_sky = light[0].to_array()[c] * all;
            let there: f64 =
                light.coefficients().iter().zip(&visible).map(|(l, v)| l.to_array()[c] * f64::from(*v)).sum();
            *out *= if of_sky > 0.0 { (there / of_sky).clamp(0.0, 1.0) as f32 } else { 0.0 };
        }
    }
    Rgb::from(out)
}

/// The light that is left for receivers of one part, in their frame.
pub(crate) struct PartLight<'a> {
    options: &'a MovingOptions,
    grids: Vec<&'a VisibilityGrid>,
    albedos: Vec<Rgb<f32>>,
    /// None without spheres.
    shadows: Option<SphereShadows<'a>>,
    fields: ShadowFields<'a>,
    /// The frame, and from the directions of the world to its own.
    frame: Placement,
    turn: RotationMatrices<f32>,
    /// The expansion of all light, and that of suns that are left to rays.
    light: ShVec<Rgb<f64>>,
    suns: Option<ShVec<Rgb<f64>>>,
    /// Without those suns, and with them.
    sky: SkyLight,
    whole: SkyLight,
    /// None without lamps.
    lamps: Option<LampLight<'a>>,
}

impl<'a> PartLight<'a> {
    pub(crate) fn new(
        options: &'a MovingOptions,
        table: &'a LogTable,
        hiding: Hiding<'a>,
        lamps: Option<LampLight<'a>>,
        frame: &Placement,
        light: &SceneLight,
    ) -> Result<Self, RenderError> {
        let to_own = frame.rotation().inverse();
        let own = light.rotated(&to_own);
        let light = own.whole();
        let sky = |f: &ShVec<Rgb<f64>>| SkyLight::new(&f.map(Rgb::narrow), options.order);
        let Hiding { obstacles: PartObstacles { fields, grids, spheres }, albedos } = hiding;
        let shadows =
            (!spheres.is_empty()).then(|| SphereShadows::new(table, &spheres, &options.spheres)).transpose()?;
        Ok(Self {
            options,
            grids,
            albedos,
            shadows,
            fields: ShadowFields::new(options.order, &fields, options.fields.clone())?,
            frame: *frame,
            turn: RotationMatrices::new(&to_own, options.order),
            sky: sky(own.rest())?,
            whole: sky(&light)?,
            suns: (!own.suns().is_empty()).then(|| own.of_suns()),
            light,
            lamps,
        })
    }

    /// By the transfer of receivers from their own part, less that of suns by its direct part. White receivers get
    /// what spheres send on as it is.
    pub(crate) fn by_transfer(
        &self,
        surface: &Surface,
        (transfer, direct): (&Transfer, Option<&Transfer>),
        is_white: bool,
    ) -> Result<Vec<Rgb<f32>>, RenderError> {
        let seen = self.seen(surface)?;
        let mut receivers = ShadowReceivers::new(&surface.positions, &surface.normals)?;
        if let Some(seen) = &seen {
            receivers = receivers.with_own_visibility(self.options.order, seen)?;
        }
        let mut out = self.fields.shade_transfer(&receivers, transfer, self.light.coefficients())?;
        if let (Some(direct), Some(suns)) = (direct, &self.suns) {
            let of_suns = self.fields.shade_transfer(&receivers, direct, suns.coefficients())?;
            out.iter_mut().zip(of_suns).for_each(|(out, of_suns)| *out -= of_suns);
        }
        for ((out, more), albedo) in out.iter_mut().zip(self.sent_on(surface)?).zip(&surface.albedos) {
            *out += if is_white { more } else { tinted(more, *albedo) };
        }
        if let Some(lamps) = &self.lamps {
            lamps.add_by_transfer(surface, transfer, &mut out)?;
        }
        Ok(out)
    }

    /// By the clamped cosine about the normals of white receivers.
    pub(crate) fn by_cosine(&self, surface: &Surface) -> Result<Vec<Rgb<f32>>, RenderError> {
        let n = self.options.order * self.options.order;
        let receivers = ShadowReceivers::new(&surface.positions, &surface.normals)?;
        let seen = match self.seen(surface)? {
            Some(seen) => self.fields.visibility(&receivers.with_own_visibility(self.options.order, &seen)?)?,
            None => self.fields.visibility(&receivers)?,
        };
        let rows = seen.chunks_exact(n).zip(&surface.normals);
        let mut out: Vec<Rgb<f32>> =
            rows.map(|(visibility, normal)| self.sky.irradiance(*normal, visibility).scale(FRAC_1_PI)).collect();
        out.iter_mut().zip(self.sent_on(surface)?).for_each(|(out, more)| *out += more);
        if let Some(lamps) = &self.lamps {
            lamps.add_by_cosine(surface, &mut out)?;
        }
        Ok(out)
    }

    /// What spheres and what stands still leave of the sky at each receiver, `order²` numbers each; none if there is
    /// neither.
    fn seen(&self, surface: &Surface) -> Result<Option<Vec<f32>>, RenderError> {
        let mut seen = match &self.shadows {
            Some(shadows) => Some(shadows.visibility(&ShadowReceivers::new(&surface.positions, &surface.normals)?)),
            None => None,
        };
        let n = self.options.order * self.options.order;
        for grid in &self.grids {
            let mut found = vec![0.0; surface.positions.len() * n];
            parallel::rows(&mut found, RECEIVERS_TOGETHER * n, &|k, found| {
                let positions = &surface.positions[k * RECEIVERS_TOGETHER..];
                let mut in_world = vec![0.0; n];
                for (out, position) in found.chunks_exact_mut(n).zip(positions) {
                    grid.visibility_into(self.frame.to_world(position.map(f64::from)), &mut in_world);
                    self.turn.apply_into(&in_world, out);
                }
            });
            if let Some(before) = &seen {
                parallel::rows(&mut found, RECEIVERS_TOGETHER * n, &|k, found| {
                    let before = before[k * RECEIVERS_TOGETHER * n..].chunks_exact(n);
                    let mut product = vec![0.0; n];
                    for (out, before) in found.chunks_exact_mut(n).zip(before) {
                        product_into(&*out, before, &mut product);
                        out.copy_from_slice(&product);
                    }
                });
            }
            seen = Some(found);
        }
        Ok(seen)
    }

    /// What spheres send on to white receivers; nothing unless that is asked for.
    fn sent_on(&self, surface: &Surface) -> Result<Vec<Rgb<f32>>, RenderError> {
        let Some(shadows) = self.shadows.as_ref().filter(|_| self.options.bounce) else { return Ok(Vec::new()) };
        let receivers = ShadowReceivers::new(&surface.positions, &surface.normals)?;
        let bounce = shadows.bounce(&self.whole, &self.albedos)?;
        let irradiance = shadows.reflected_irradiance(&receivers, &self.whole, &bounce)?;
        Ok(irradiance.into_iter().map(|irradiance| irradiance.scale(FRAC_1_PI)).collect())
    }
}

pub(crate) fn tinted(light: Rgb<f32>, [r, g, b]: [f32; 3]) -> Rgb<f32> {
    Rgb::new(light.r * r, light.g * g, light.b * b)
}
