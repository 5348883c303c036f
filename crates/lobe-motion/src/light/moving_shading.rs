//! Shading of moving scenes: what each vertex sends back of the sky that the other parts leave visible to it.

use std::borrow::Cow;
use std::ops::Range;

use lobe_env::SceneLight;
use lobe_prt::Transfer;
use lobe_sh::{Rgb, ShVec};
use lobe_shadow::{LogTable, LogTableOptions, ShadowError};

use crate::bake::moving_bake::expect_order;
use crate::light::lamp_light::LampLight;
use crate::light::part_light::{Hiding, PartLight, tinted};
use crate::moving_options::{MovingMethod, MovingOptions};
use crate::scene::moment::Moment;
use crate::scene::moment::{PlacedPart, Surface};
use crate::scene::moving_part::MovingPart;
use lobe_render::RenderError;

/// Vertices that are shaded between two looks at whether to stop.
const AT_ONCE: usize = 1 << 15;

/// Exit radiance at the vertices of a moving scene ([Zhou et al. 2005], [Ren et al. 2006]).
///
/// ```text
///   B = Σ_i L_i (V T)_i        V = V_still Π_fields (1 - O) · exp(Σ_spheres log V_sphere)
/// ```
///
/// `T` is the transfer of the vertex from its own part, which was baked in the part's frame: light, fields and spheres
/// are taken to that frame, so that `T` is never rotated. `V_still` is looked up in the grids of what stands still.
/// Parts that are deformed have no transfer: there `T` is albedo/π times the clamped cosine, and the part's own spheres
/// hide the sky too. Light that is reflected between parts is left out, but for what a baked part sends to itself, and
/// [`MovingOptions::bounce`].
///
/// The direct light of suns is left to rays where all parts have the part `D` of their transfer without reflections:
/// `Σ_i S_i (V D)_i` of their expansion `S` is taken away.
///
/// [Lamps](crate::MovingLamp) add `Σ_i S_i (V T)_i` each, with `S` their light there and `V` what is nearer than they
/// leaves visible. `T` of a part counts as nearer than all of them, and what stands still hides them by fields alone: a
/// grid of visibility does not say how far things are.
///
/// [Zhou et al. 2005]: https://doi.org/10.1145/1073204.1073332
/// [Ren et al. 2006]: https://doi.org/10.1145/1141911.1141982
#[derive(Clone, Debug)]
pub struct MovingShading {
    options: MovingOptions,
    table: LogTable,
}

/// What the vertices of a part send back.
#[derive(Debug)]
pub(crate) struct Shaded {
    pub(crate) radiance: Vec<Rgb<f32>>,
    /// Whether the albedo is left out.
    pub(crate) is_white: bool,
}

/// The part of the light that vertices send back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LightPart {
    /// That of the sky and of lamps.
    Whole,
    /// That of the sky.
    Sky,
    /// That of the sky which no surface reflects but the last, as far as that part of the transfer is known.
    SkyOnce,
}

/// A callback between blocks of vertices; its error ends the work.
pub(crate) type Ask<'a> = &'a mut dyn FnMut() -> Result<(), RenderError>;

impl MovingShading {
    /// Prepares the table of logarithms.
    ///
    /// # Errors
    /// [`RenderError::Shadow`] if the order is not 1 to 8.
    pub fn new(options: MovingOptions) -> Result<Self, RenderError> {
        let table = LogTable::new(&LogTableOptions::default().order(options.order))?;
        Ok(Self { options, table })
    }

    /// The same with a table that was made before, by [`cached_log_table`](lobe_shadow::cached_log_table) or for
    /// another window.
    ///
    /// # Errors
    /// [`RenderError::Shadow`] if the table is of another order.
    pub fn with_table(options: MovingOptions, table: LogTable) -> Result<Self, RenderError> {
        if table.order() != options.order {
            let message = format!("expected a table of order {}, found {}", options.order, table.order());
            return Err(ShadowError::Options(message).into());
        }
        Ok(Self { options, table })
    }

    /// Number of bands.
    #[must_use]
    pub fn order(&self) -> usize {
        self.options.order
    }

    /// How parts are shaded.
    #[must_use]
    pub fn options(&self) -> &MovingOptions {
        &self.options
    }

    /// Logarithms of spheres.
    #[must_use]
    pub fn table(&self) -> &LogTable {
        &self.table
    }

    /// How parts hide the sky.
    #[must_use]
    pub fn method(&self) -> MovingMethod {
        self.options.method
    }

    /// The exit radiance of every vertex of the moment's scene under distant light, an expansion of radiance of any
    /// order.
    ///
    /// # Errors
    /// [`RenderError::Options`] if transfer or a field has fewer bands than [`MovingOptions::order`],
    /// [`RenderError::Shadow`] if transfer is not of the part's vertices.
    pub fn exit_radiance(&self, moment: &Moment<'_>, light: &ShVec<Rgb<f64>>) -> Result<Vec<Rgb<f32>>, RenderError> {
        Ok(tinted_parts(moment, self.fronts(moment, &light.clone().into(), &mut || Ok(()))?))
    }

    /// The same of the backs of all vertices. Those that [`MovingScene::bake_backs`](crate::MovingScene::bake_backs)
    /// has not baked are not shadowed by their own part, if it keeps its shape.
    ///
    /// # Errors
    /// As [`MovingShading::exit_radiance`].
    pub fn exit_radiance_of_backs(
        &self,
        moment: &Moment<'_>,
        light: &ShVec<Rgb<f64>>,
    ) -> Result<Vec<Rgb<f32>>, RenderError> {
        let all: Vec<usize> = (0..moment.scene().vertex_count()).collect();
        Ok(tinted_parts(moment, self.backs(moment, &light.clone().into(), &all, &mut || Ok(()))?))
    }

    /// What all vertices send back, part by part.
    pub(crate) fn fronts(
        &self,
        moment: &Moment<'_>,
        light: &SceneLight,
        ask: Ask<'_>,
    ) -> Result<Vec<Shaded>, RenderError> {
        self.fronts_of(LightPart::Whole, moment, light, ask)
    }

    /// What all vertices send back of some of the light.
    pub(crate) fn fronts_of(
        &self,
        which: LightPart,
        moment: &Moment<'_>,
        light: &SceneLight,
        ask: Ask<'_>,
    ) -> Result<Vec<Shaded>, RenderError> {
        self.of_all_parts(which, moment, light, |part, placed, lit| {
            let (transfer, direct) = match which {
                LightPart::SkyOnce => (part.direct.as_deref().or(part.transfer.as_deref()), None),
                LightPart::Whole | LightPart::Sky => (part.transfer.as_deref(), part.direct.as_deref()),
            };
            let mut all = Shaded { radiance: Vec::new(), is_white: part.transfer.is_none() || part.is_demodulated };
            let count = placed.surface.positions.len();
            for first in (0..count).step_by(AT_ONCE) {
                ask()?;
                let range = first..(first + AT_ONCE).min(count);
                let surface = placed.surface.some(range.clone(), 1.0);
                all.radiance.extend(match transfer.filter(|_| part.is_rigid()) {
                    Some(transfer) => {
                        let direct = direct.map(|direct| rows_of(direct, range.clone(), count));
                        let (rows, direct) = (rows_of(transfer, range, count)?, direct.transpose()?);
                        lit.by_transfer(&surface, (&rows, direct.as_deref()), part.is_demodulated)?
                    }
                    None => lit.by_cosine(&surface)?,
                });
            }
            Ok(all)
        })
    }

    /// What the backs of these vertices of all send back, in rising order; zero for others.
    pub(crate) fn backs(
        &self,
        moment: &Moment<'_>,
        light: &SceneLight,
        seen: &[usize],
        ask: Ask<'_>,
    ) -> Result<Vec<Shaded>, RenderError> {
        let mut first = 0;
        self.of_all_parts(LightPart::Whole, moment, light, |part, placed, lit| {
            ask()?;
            let count = placed.surface.positions.len();
            let range = seen.partition_point(|v| *v < first)..seen.partition_point(|v| *v < first + count);
            let begin = first;
            let seen = seen[range].iter().map(|vertex| vertex - begin);
            first += count;
            let is_white = part.transfer.is_none() || part.is_demodulated;
            let mut all = Shaded { radiance: vec![Rgb::new(0.0, 0.0, 0.0); count], is_white };
            let backs = part.backs.as_deref().filter(|_| part.is_rigid());
            let (baked, others): (Vec<usize>, Vec<usize>) =
                seen.partition(|vertex| backs.is_some_and(|backs| backs.has(*vertex)));
            if let Some(backs) = backs.filter(|_| !baked.is_empty()) {
                let surface = placed.surface.some(baked.iter().copied(), -1.0);
                let (rows, direct) = backs.transfer_of(&baked)?;
                let lit = lit.by_transfer(&surface, (&rows, direct.as_ref()), part.is_demodulated)?;
                baked.iter().zip(lit).for_each(|(vertex, lit)| all.radiance[*vertex] = lit);
            }
            if !others.is_empty() {
                let surface = placed.surface.some(others.iter().copied(), -1.0);
                for ((vertex, lit), albedo) in others.iter().zip(lit.by_cosine(&surface)?).zip(&surface.albedos) {
                    all.radiance[*vertex] = if is_white { lit } else { tinted(lit, *albedo) };
                }
            }
            Ok(all)
        })
    }

    /// The light whose suns are not in the radiance of vertices, because all parts leave them to rays: without suns if
    /// some do not.
    pub(crate) fn by_rays(&self, moment: &Moment<'_>, light: &SceneLight) -> SceneLight {
        let is_apart = moment.parts().iter().all(MovingPart::parts_suns);
        if is_apart { light.clone() } else { light.whole().into() }
    }

    /// Shades every part, given what others leave of the light.
    fn of_all_parts(
        &self,
        which: LightPart,
        moment: &Moment<'_>,
        light: &SceneLight,
        mut shade: impl FnMut(&MovingPart, &PlacedPart, &PartLight<'_>) -> Result<Shaded, RenderError>,
    ) -> Result<Vec<Shaded>, RenderError> {
        expect_order(moment.parts(), self.options.order)?;
        moment.lamps.iter().try_for_each(|lamp| lamp.expect_order(self.options.order))?;
        let (whole, light) = (light.whole(), &self.by_rays(moment, light));
        let mut options = self.options.clone();
        options.bounce &= which != LightPart::SkyOnce;
        let shade_one = |(index, (part, placed)): (usize, (&MovingPart, &PlacedPart))| {
            let hiding = Hiding::of(moment, index, &options, &whole);
            let lamps = match which {
                LightPart::Whole => LampLight::of(moment, index, &options, &self.table)?,
                LightPart::Sky | LightPart::SkyOnce => None,
            };
            let lit = PartLight::new(&options, &self.table, hiding, lamps, &placed.surface.frame, light)?;
            shade(part, placed, &lit).map_err(|error| error.of_part(&part.name))
        };
        moment.parts().iter().zip(&moment.placed).enumerate().map(shade_one).collect()
    }
}

/// The transfer of some of `count` receivers, which follow each other.
fn rows_of(transfer: &Transfer, range: Range<usize>, count: usize) -> Result<Cow<'_, Transfer>, RenderError> {
    if transfer.receivers() != count {
        let found = transfer.receivers();
        return Err(ShadowError::Options(format!("expected transfer of {count} vertices, found {found}")).into());
    }
    if range.len() == count {
        return Ok(Cow::Borrowed(transfer));
    }
    let width = transfer.order().pow(2) * transfer.channels().count();
    let rows = transfer.coefficients()[range.start * width..range.end * width].to_vec();
    Ok(Cow::Owned(Transfer::new(transfer.order(), transfer.channels(), rows)?))
}

/// The values of all parts one after the other, with the albedo of their vertices.
fn tinted_parts(moment: &Moment<'_>, parts: Vec<Shaded>) -> Vec<Rgb<f32>> {
    let mut all = Vec::with_capacity(moment.scene().vertex_count());
    for (Shaded { radiance, is_white }, placed) in parts.into_iter().zip(&moment.placed) {
        match is_white {
            true => {
                all.extend(radiance.into_iter().zip(&placed.surface.albedos).map(|(lit, albedo)| tinted(lit, *albedo)));
            }
            false => all.extend(radiance),
        }
    }
    all
}

impl Surface {
    /// Some of the vertices, their normals multiplied by 1 or -1.
    fn some(&self, which: impl Iterator<Item = usize> + Clone, side: f32) -> Self {
        Self {
            frame: self.frame,
            positions: which.clone().map(|vertex| self.positions[vertex]).collect(),
            normals: which.clone().map(|vertex| self.normals[vertex].map(|c| side * c)).collect(),
            albedos: which.map(|vertex| self.albedos[vertex]).collect(),
        }
    }
}
