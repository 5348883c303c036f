//! Lamps of a moving scene.

use std::borrow::Cow;
use std::sync::Arc;

use lobe_shadow::{Lamp, LampSurface, Placement, RadianceField, Track};

use lobe_render::RenderError;

/// A lamp near by, which moves along a track: its light at every point around it, which the parts hide from each other.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct MovingLamp {
    /// The name in messages.
    pub name: String,
    /// Its place over time.
    pub track: Track,
    /// What shines, if it was given instead of its light.
    pub surface: Option<LampSurface>,
    /// Its light; none of a surface until it is [baked](crate::MovingScene::bake_lamps).
    pub lamp: Option<Arc<Lamp>>,
}

/// A lamp where it is, with its light at that time.
#[derive(Clone, Debug)]
pub(crate) struct PlacedLamp<'a> {
    pub(crate) name: &'a str,
    pub(crate) placement: Placement,
    pub(crate) surface: Option<LampSurface>,
    pub(crate) field: Option<Cow<'a, RadianceField>>,
}

impl MovingLamp {
    /// A lamp of a surface in its own frame. Its light is made by
    /// [`MovingScene::bake_lamps`](crate::MovingScene::bake_lamps).
    #[must_use]
    pub fn shaped(name: impl Into<String>, surface: LampSurface, track: Track) -> Self {
        Self { name: name.into(), track, surface: Some(surface), lamp: None }
    }

    /// A lamp of this light, such as one from a file.
    #[must_use]
    pub fn new(name: impl Into<String>, lamp: Lamp, track: Track) -> Self {
        Self { name: name.into(), track, surface: None, lamp: Some(Arc::new(lamp)) }
    }

    /// The lamp at a time.
    pub(crate) fn placed_at(&self, time: f64) -> Result<PlacedLamp<'_>, RenderError> {
        let field = self.lamp.as_ref().map(|lamp| lamp.at(time)).transpose()?;
        let surface = self.surface.clone().or_else(|| field.as_ref().map(|field| field.surface()));
        Ok(PlacedLamp { name: &self.name, placement: self.track.at(time), surface, field })
    }

    /// Refuses a lamp without light, or of fewer bands.
    pub(crate) fn expect_order(&self, order: usize) -> Result<(), RenderError> {
        expect_order(&self.name, self.lamp.as_ref().map(|lamp| lamp.order()), order)
    }
}

impl PlacedLamp<'_> {
    /// Refuses a lamp without light, or of fewer bands.
    pub(crate) fn expect_order(&self, order: usize) -> Result<(), RenderError> {
        expect_order(self.name, self.field.as_ref().map(|field| field.order()), order)
    }
}

fn expect_order(name: &str, found: Option<usize>, order: usize) -> Result<(), RenderError> {
    let message = match found {
        Some(found) if found >= order => return Ok(()),
        Some(found) => format!(
            "lamp `{name}`: expected light of {order} bands at least, found {found}; ask for order {found}, or make it of a higher one"
        ),
        None => format!("lamp `{name}`: expected light that is baked, found none yet"),
    };
    Err(RenderError::Options(message))
}
