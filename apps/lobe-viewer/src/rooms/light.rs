//! The light of a room: windows and dering of its expansion, how its sky is turned, and the controls of all that.

use std::f64::consts::{PI, TAU};
use std::ops::RangeInclusive;
use std::sync::Arc;

use eframe::egui::{ComboBox, Response, Slider, SliderClamping, Ui};
use lobe::env::MappedMap;
use lobe::sh::{DeringOptions, Dir, Rgb, Rotation, ShVec, Window, deringed, windowed};
use serde::{Deserialize, Serialize};

use crate::loading::sky_source::OpenedSky;
use crate::rooms::formulas::Formula;
use crate::widgets::within::within;

/// Exposure by keys goes so far either way: beyond it all is black or white.
pub(crate) const MOST_STOPS: f64 = 16.0;

/// Stops of a key.
const STOP: f64 = 0.5;

/// Widths of windows in bands, up to four times the highest order.
const WIDTHS: RangeInclusive<f64> = 1.5..=32.0;

/// Widths of heat kernels in radians.
const SIGMAS: RangeInclusive<f64> = 0.01..=1.2;

/// What tames the ringing of an expansion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Taming {
    /// Nothing.
    #[default]
    None,
    /// A raised cosine that is zero at this band.
    Hanning(f64),
    /// The sigma factors of Lanczos, zero at this band.
    Lanczos(f64),
    /// The heat kernel of this width in radians.
    Gauss(f64),
    /// The least change that leaves nothing negative.
    Dering,
}

impl Taming {
    const NAMES: [&str; 5] = ["None", "Hanning", "Lanczos", "Gauss", "Dering"];

    /// One of each kind, as it is chosen for an expansion of this order.
    fn choices(order: usize) -> [Self; 5] {
        let order = order as f64;
        [Self::None, Self::Hanning(order), Self::Lanczos(order), Self::Gauss(0.3), Self::Dering]
    }

    fn number(self) -> usize {
        match self {
            Self::None => 0,
            Self::Hanning(_) => 1,
            Self::Lanczos(_) => 2,
            Self::Gauss(_) => 3,
            Self::Dering => 4,
        }
    }

    /// The window, where it is one.
    #[must_use]
    pub fn window(self) -> Option<Window> {
        match self {
            Self::None | Self::Dering => None,
            Self::Hanning(width) => Some(Window::Hanning { width }),
            Self::Lanczos(width) => Some(Window::Lanczos { width, power: 1.0 }),
            Self::Gauss(sigma) => Some(Window::Gauss { sigma }),
        }
    }

    /// Its formula.
    pub(crate) fn formula(self) -> Option<Formula> {
        match self {
            Self::None => None,
            Self::Hanning(_) => Some(Formula::HANNING),
            Self::Lanczos(_) => Some(Formula::LANCZOS),
            Self::Gauss(_) => Some(Formula::GAUSS),
            Self::Dering => Some(Formula::DERING),
        }
    }

    /// The expansion with it.
    #[must_use]
    pub fn tamed(self, light: &ShVec<Rgb<f64>>) -> ShVec<Rgb<f64>> {
        match (self, self.window()) {
            (Self::Dering, _) => deringed(light, &DeringOptions::default()).0,
            (_, Some(window)) => windowed(light, &window),
            _ => light.clone(),
        }
    }

    /// The same for one channel.
    #[must_use]
    pub fn tamed_gray(self, f: &ShVec<f64>) -> ShVec<f64> {
        match (self, self.window()) {
            (Self::Dering, _) => deringed(f, &DeringOptions::default()).0,
            (_, Some(window)) => windowed(f, &window),
            _ => f.clone(),
        }
    }

    /// Brings its width into its range.
    pub(crate) fn check(&mut self) {
        match self {
            Self::Hanning(width) | Self::Lanczos(width) => *width = within(*width, WIDTHS, 4.0),
            Self::Gauss(sigma) => *sigma = within(*sigma, SIGMAS, 0.3),
            Self::None | Self::Dering => {}
        }
    }

    /// A choice, and the strength of what was chosen. `order` is that of the expansion.
    pub(crate) fn controls(&mut self, ui: &mut Ui, order: usize) {
        let shown = ComboBox::from_label("Window").selected_text(Self::NAMES[self.number()]).show_ui(ui, |ui| {
            for choice in Self::choices(order) {
                let is_chosen = choice.number() == self.number();
                if ui.selectable_label(is_chosen, Self::NAMES[choice.number()]).clicked() && !is_chosen {
                    *self = choice;
                }
            }
        });
        shown.response.on_hover_text("The next by W; dering on and off by D");
        match self {
            Self::Hanning(width) | Self::Lanczos(width) => {
                let range = *WIDTHS.start()..=4.0 * order.max(1) as f64;
                ui.add(Slider::new(width, range).text("Width in bands").fixed_decimals(2));
            }
            Self::Gauss(sigma) => {
                ui.add(Slider::new(sigma, SIGMAS).text("Width in radians").fixed_decimals(3));
            }
            Self::None | Self::Dering => {}
        }
    }
}

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
    /// Stops of exposure; none where nothing is exposed.
    pub(crate) exposure: Option<&'a mut f64>,
}

impl LightHand<'_> {
    /// Turns the sky by a drag in parts of the height of the picture.
    pub(crate) fn turn_by(&mut self, right: f64, down: f64) {
        *self.turn = (*self.turn + PI * right).rem_euclid(TAU);
        *self.tilt = (*self.tilt + PI * down).clamp(-PI, PI);
    }

    /// Adds bands.
    pub(crate) fn change_order(&mut self, by: isize) {
        if by != 0 {
            *self.order = self.order.saturating_add_signed(by).clamp(1, self.most_order);
        }
    }

    /// Adds steps of exposure.
    pub(crate) fn change_exposure(&mut self, steps: f64) {
        if let Some(exposure) = self.exposure.as_deref_mut().filter(|_| steps != 0.0) {
            *exposure = (*exposure + STOP * steps).clamp(-MOST_STOPS, MOST_STOPS);
        }
    }

    /// Chooses the next window, after the last none.
    pub(crate) fn next_window(&mut self) {
        if let Some(taming) = self.taming.as_deref_mut() {
            let choices = Taming::choices(*self.order);
            *taming = choices[(taming.number() + 1) % choices.len()];
        }
    }

    /// Switches dering on or off.
    pub(crate) fn switch_dering(&mut self) {
        if let Some(taming) = self.taming.as_deref_mut() {
            *taming = if *taming == Taming::Dering { Taming::None } else { Taming::Dering };
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

    /// How the sky is turned, and the exposure.
    pub(crate) fn sky_controls(&mut self, ui: &mut Ui) {
        let hint = "Shift and drag, or Shift and arrows";
        angle(ui, self.turn, 0.0..=360.0, "Turn of the sky").on_hover_text(hint);
        angle(ui, self.tilt, -180.0..=180.0, "Tilt of the sky").on_hover_text(hint);
        if let Some(exposure) = self.exposure.as_deref_mut() {
            let slider = Slider::new(exposure, -6.0..=6.0).text("Exposure").suffix(" stops").fixed_decimals(1);
            // Keys go farther than the slider, which does not take that back.
            ui.add(slider.clamping(SliderClamping::Edits)).on_hover_text("Less and more by [ and ]");
        }
    }
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

/// The tamed expansion of a sky, which remains while it turns.
#[derive(Debug, Default)]
pub(crate) struct TamedSky(Option<(TamedKey, ShVec<Rgb<f64>>)>);

impl TamedSky {
    /// The expansion to an order, tamed.
    pub(crate) fn of(&mut self, sky: &OpenedSky, order: usize, taming: Taming) -> &ShVec<Rgb<f64>> {
        let is_other =
            |(map, kept_order, kept): &TamedKey| !Arc::ptr_eq(map, &sky.map) || (*kept_order, *kept) != (order, taming);
        if self.0.as_ref().is_some_and(|(key, _)| is_other(key)) {
            self.0 = None;
        }
        let made = || ((sky.map.clone(), order, taming), taming.tamed(&sky.light.resized(order)));
        &self.0.get_or_insert_with(made).1
    }
}
