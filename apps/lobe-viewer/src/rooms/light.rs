//! The light of a room: the order of its expansion and what tames it, how its sky is turned, and the controls of all that.

use std::f64::consts::{PI, TAU};
use std::ops::RangeInclusive;
use std::sync::Arc;

use eframe::egui::{Response, Slider, SliderClamping, Ui};
use lobe::env::MappedMap;
use lobe::image::Curve;
use lobe::sh::{Dir, Rgb, Rotation, ShVec};

use crate::loading::sky_source::OpenedSky;
use crate::rooms::curve;
use crate::rooms::taming::Taming;

/// Exposure by keys goes so far either way: beyond it all is black or white.
pub(crate) const MOST_STOPS: f64 = 16.0;

/// Stops of a key.
const STOP: f64 = 0.5;

/// The light of a room in the hand that changes it.
pub(crate) struct LightHand<'a> {
    /// Number of bands, and the most.
    pub(crate) order: &'a mut usize,
    pub(crate) most_order: usize,
    /// What is done to the expansion; none where it is left alone.
    pub(crate) taming: Option<&'a mut Taming>,
    /// By which the sky is turned about +z, in radians, 0 to 2π.
    pub(crate) turn: &'a mut f64,
    /// By which it is tilted about +x before that, in radians, -π to π.
    pub(crate) tilt: &'a mut f64,
    /// Stops of exposure and the tone curve; none where nothing is exposed.
    pub(crate) exposed: Option<(&'a mut f64, &'a mut Curve)>,
}

impl LightHand<'_> {
    /// Turns the sky by a drag in parts of the height of the picture.
    pub(crate) fn turn_by(&mut self, right: f64, down: f64) {
        *self.turn = (*self.turn + PI * right).rem_euclid(TAU);
        *self.tilt = (*self.tilt + PI * down).clamp(-PI, PI);
    }

    /// Adds bands to those that can be had.
    pub(crate) fn change_order(&mut self, by: isize) {
        if by != 0 {
            let order = (*self.order).min(self.most_order);
            *self.order = order.saturating_add_signed(by).clamp(1, self.most_order);
        }
    }

    /// Adds steps of exposure.
    pub(crate) fn change_exposure(&mut self, steps: f64) {
        if let Some((exposure, _)) = self.exposed.as_mut().filter(|_| steps != 0.0) {
            **exposure = (**exposure + STOP * steps).clamp(-MOST_STOPS, MOST_STOPS);
        }
    }

    /// Chooses the next window, after the last none.
    pub(crate) fn next_window(&mut self) {
        if let Some(taming) = self.taming.as_deref_mut() {
            *taming = taming.next(*self.order);
        }
    }

    /// Switches dering on or off.
    pub(crate) fn switch_dering(&mut self) {
        if let Some(taming) = self.taming.as_deref_mut() {
            *taming = if taming.is_dering() { Taming::None } else { Taming::Dering };
        }
    }

    /// The order of the expansion, and what is done to it.
    pub(crate) fn expansion_controls(&mut self, ui: &mut Ui) {
        let slider = Slider::new(self.order, 1..=self.most_order).text("Order");
        ui.add(slider).on_hover_text("Number of bands (comma, point)");
        if let Some(taming) = self.taming.as_deref_mut() {
            taming.controls(ui, *self.order);
        }
    }

    /// How the sky is turned, the exposure and the tone curve.
    pub(crate) fn sky_controls(&mut self, ui: &mut Ui) {
        let hint = "Shift and drag, or Shift and arrows";
        angle(ui, self.turn, 0.0..=360.0, "Turn of the sky").on_hover_text(hint);
        angle(ui, self.tilt, -180.0..=180.0, "Tilt of the sky").on_hover_text(hint);
        if let Some((exposure, tone)) = &mut self.exposed {
            let slider = Slider::new(*exposure, -6.0..=6.0).text("Exposure").suffix(" stops").fixed_decimals(1);
            // Keys go farther than the slider, which does not take that back.
            ui.add(slider.clamping(SliderClamping::Edits)).on_hover_text("Less and more by [ and ]");
            curve::control(ui, tone);
        }
    }
}

/// Whether suns of the sky are apart from its expansion.
pub(crate) fn suns_control(ui: &mut Ui, has_suns: &mut bool) {
    let hint = "Suns of the sky cast shadows by themselves; else its expansion spreads them over the sky";
    ui.checkbox(has_suns, "Suns apart").on_hover_text(hint);
}

/// The rotation of a sky that is tilted about +x, then turned about +z.
pub(crate) fn sky_rotation(turn: f64, tilt: f64) -> Rotation {
    Rotation::from_axis_angle(Dir::X, tilt).then(Rotation::from_axis_angle(Dir::Z, turn))
}

/// A slider in degrees for an angle in radians. It rounds what is set by it, and not what a drag or time has made of the angle.
pub(crate) fn angle(ui: &mut Ui, radians: &mut f64, range: RangeInclusive<f64>, text: &str) -> Response {
    let mut degrees = radians.to_degrees();
    let slider = Slider::new(&mut degrees, range).text(text).suffix("°").fixed_decimals(0);
    let response = ui.add(slider.clamping(SliderClamping::Edits));
    if response.changed() {
        *radians = degrees.to_radians();
    }
    response
}

/// The map of a sky, the order, and what was done to the expansion.
type TamedKey = (Arc<MappedMap>, usize, Taming);

/// The tamed expansions of a sky, of all light and without suns, which remain while it turns.
#[derive(Debug, Default)]
pub(crate) struct TamedSky([Option<(TamedKey, ShVec<Rgb<f64>>)>; 2]);

impl TamedSky {
    /// The expansion to an order, tamed: of all light, or without suns.
    pub(crate) fn of(
        &mut self,
        sky: &OpenedSky,
        (order, is_without_suns): (usize, bool),
        taming: Taming,
    ) -> &ShVec<Rgb<f64>> {
        let is_other =
            |(map, kept_order, kept): &TamedKey| !Arc::ptr_eq(map, &sky.map) || (*kept_order, *kept) != (order, taming);
        let place = &mut self.0[usize::from(is_without_suns)];
        if place.as_ref().is_some_and(|(key, _)| is_other(key)) {
            *place = None;
        }
        let light = if is_without_suns { sky.split.rest() } else { &sky.light };
        let made = || ((sky.map.clone(), order, taming), taming.tamed(&light.resized(order)));
        &place.get_or_insert_with(made).1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_takes_a_band_from_those_that_can_be_had() {
        for (kept, most, by, expected) in [(8, 4, -1, 3), (8, 4, 1, 4), (4, 4, -1, 3), (1, 4, -1, 1), (3, 8, 1, 4)] {
            let (mut order, mut turn, mut tilt) = (kept, 0.0, 0.0);
            let (turn, tilt) = (&mut turn, &mut tilt);
            let mut hand = LightHand { order: &mut order, most_order: most, taming: None, turn, tilt, exposed: None };
            hand.change_order(by);
            assert_eq!(order, expected, "{by} to {kept} of at most {most}");
        }
    }
}
