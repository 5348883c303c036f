//! Taming of the ringing of an expansion: the windows of `lobe sh window`, dering by radiance or by irradiance, and their controls.

use std::ops::RangeInclusive;

use eframe::egui::{ComboBox, Slider, SliderClamping, Ui};
use lobe::sh::filter::{scale_bands_in_place, width_of_peak};
use lobe::sh::ringing::DeringOptions;
use lobe::sh::{Coefficient, Expansion as _, ShVec, Window, Zonal};
use serde::{Deserialize, Deserializer, Serialize};

use crate::rooms::formulas::Formula;
use crate::widgets::within::within;

/// Widths of windows in bands, up to four times the highest order.
const WIDTHS: RangeInclusive<f64> = 1.5..=32.0;

/// Powers of sigma factors: below, a window of any width is nearly none, and above, nearly only the mean is left.
const POWERS: RangeInclusive<f64> = 0.25..=8.0;

/// The power of the sigma factors that have a name of their own.
const SINC4: f64 = 4.0;

/// Widths of heat kernels in radians.
const SIGMAS: RangeInclusive<f64> = 0.01..=1.2;

/// Weights of the squared Laplacian: by 1, a fifth is left of band 1.
const WEIGHTS: RangeInclusive<f64> = 0.0..=1.0;

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
    /// A power of the sigma factors of Lanczos.
    #[serde(deserialize_with = "kept_lanczos")]
    Lanczos {
        /// The band at which it is zero.
        width: f64,
        /// The power.
        power: f64,
    },
    /// The fourth power of the sigma factors, zero at this band.
    Sinc4(f64),
    /// The heat kernel of this width in radians.
    Gauss(f64),
    /// The least squares fit with this weight of the squared Laplacian.
    Laplacian(f64),
    /// The blur of a light from one direction before it is added to a probe of order 3.
    Punctual,
    /// The least change that leaves no radiance negative.
    Dering,
    /// The least change that leaves no irradiance negative.
    #[serde(rename = "dering-irradiance")]
    DeringIrradiance,
}

/// A Lanczos window as it was kept: before it had a power, its width alone.
fn kept_lanczos<'de, D: Deserializer<'de>>(kept: D) -> Result<(f64, f64), D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged)]
    enum Kept {
        Width(f64),
        Both { width: f64, power: f64 },
    }
    Ok(match Kept::deserialize(kept)? {
        Kept::Width(width) => (width, 1.0),
        Kept::Both { width, power } => (width, power),
    })
}

impl Taming {
    /// One of each kind, as it is chosen for an expansion of this order.
    fn choices(order: usize) -> [Self; 9] {
        let width = order as f64;
        [
            Self::None,
            Self::Hanning(width),
            Self::Lanczos { width, power: 1.0 },
            Self::Sinc4(width),
            Self::Gauss(0.3),
            Self::Laplacian(0.005),
            Self::Punctual,
            Self::Dering,
            Self::DeringIrradiance,
        ]
    }

    /// The name in the window.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::None => "None",
            Self::Hanning(_) => "Hanning",
            Self::Lanczos { .. } => "Lanczos",
            Self::Sinc4(_) => "Sinc4",
            Self::Gauss(_) => "Gauss",
            Self::Laplacian(_) => "Squared Laplacian",
            Self::Punctual => "Punctual lights",
            Self::Dering => "Dering by radiance",
            Self::DeringIrradiance => "Dering by irradiance",
        }
    }

    /// The next kind for an expansion of this order, after the last none.
    pub(crate) fn next(self, order: usize) -> Self {
        let choices = Self::choices(order);
        let number = choices.iter().position(|choice| choice.title() == self.title()).unwrap_or(0);
        choices[(number + 1) % choices.len()]
    }

    /// Whether it is dering, by either quantity.
    pub(crate) fn is_dering(self) -> bool {
        matches!(self, Self::Dering | Self::DeringIrradiance)
    }

    /// The window, where it is one.
    #[must_use]
    pub fn window(self) -> Option<Window> {
        match self {
            Self::None | Self::Dering | Self::DeringIrradiance => None,
            Self::Hanning(width) => Some(Window::Hanning { width }),
            Self::Lanczos { width, power } => Some(Window::Lanczos { width, power }),
            Self::Sinc4(width) => Some(Window::Lanczos { width, power: SINC4 }),
            Self::Gauss(sigma) => Some(Window::Gauss { sigma }),
            Self::Laplacian(lambda) => Some(Window::SquaredLaplacian { lambda }),
            Self::Punctual => Some(Window::PunctualLight),
        }
    }

    /// The options of dering for a function of this order, where it is dering.
    fn dering(self, order: usize) -> Option<DeringOptions> {
        match self {
            Self::Dering => Some(DeringOptions::default()),
            Self::DeringIrradiance => Some(DeringOptions::default().kernel(Zonal::clamped_cosine(order))),
            _ => None,
        }
    }

    /// Its formula.
    pub(crate) fn formula(self) -> Option<Formula> {
        match self {
            Self::None => None,
            Self::Hanning(_) => Some(Formula::HANNING),
            Self::Lanczos { .. } => Some(Formula::LANCZOS),
            Self::Sinc4(_) => Some(Formula::SINC4),
            Self::Gauss(_) => Some(Formula::GAUSS),
            Self::Laplacian(_) => Some(Formula::LAPLACIAN),
            Self::Punctual => Some(Formula::PUNCTUAL),
            Self::Dering => Some(Formula::DERING),
            Self::DeringIrradiance => Some(Formula::DERING_IRRADIANCE),
        }
    }

    /// The factors of the bands of a function, by which it is multiplied: all 1 where dering finds none, as of a negative mean.
    #[must_use]
    pub fn factors<T: Coefficient>(self, f: &ShVec<T>) -> Vec<f64> {
        match (self.dering(f.order()), self.window()) {
            (Some(dering), _) => f.deringed_with(&dering).1.factors,
            (_, Some(window)) => window.factors(f.order()),
            _ => vec![1.0; f.order()],
        }
    }

    /// The expansion with it.
    #[must_use]
    pub fn tamed<T: Coefficient>(self, f: &ShVec<T>) -> ShVec<T> {
        let mut tamed = f.clone();
        scale_bands_in_place(tamed.coefficients_mut(), &self.factors(f));
        tamed
    }

    /// Brings its numbers into their ranges.
    pub(crate) fn check(&mut self) {
        match self {
            Self::Hanning(width) | Self::Sinc4(width) => *width = within(*width, WIDTHS, 4.0),
            Self::Lanczos { width, power } => {
                (*width, *power) = (within(*width, WIDTHS, 4.0), within(*power, POWERS, 1.0));
            }
            Self::Gauss(sigma) => *sigma = within(*sigma, SIGMAS, 0.3),
            Self::Laplacian(lambda) => *lambda = within(*lambda, WEIGHTS, 0.005),
            Self::None | Self::Punctual | Self::Dering | Self::DeringIrradiance => {}
        }
    }

    /// A choice, and the numbers of what was chosen. `order` is that of the expansion.
    pub(crate) fn controls(&mut self, ui: &mut Ui, order: usize) {
        let shown = ComboBox::from_label("Window").selected_text(self.title()).show_ui(ui, |ui| {
            for choice in Self::choices(order) {
                let is_chosen = choice.title() == self.title();
                if ui.selectable_label(is_chosen, choice.title()).clicked() && !is_chosen {
                    *self = choice;
                }
            }
        });
        shown.response.on_hover_text("The next by W; dering on and off by D");
        match self {
            Self::Hanning(width) => width_or_peak(ui, width, order, |width| Window::Hanning { width }),
            Self::Lanczos { width, power } => {
                let of = *power;
                width_or_peak(ui, width, order, |width| Window::Lanczos { width, power: of });
                ui.add(Slider::new(power, POWERS).text("Power").fixed_decimals(2));
            }
            Self::Sinc4(width) => width_or_peak(ui, width, order, |width| Window::Lanczos { width, power: SINC4 }),
            Self::Gauss(sigma) => {
                ui.add(Slider::new(sigma, SIGMAS).text("Width in radians").fixed_decimals(3));
            }
            Self::Laplacian(lambda) => {
                let slider = Slider::new(lambda, WEIGHTS).logarithmic(true).text("Weight").fixed_decimals(5);
                ui.add(slider).on_hover_text("Of the squared Laplacian; 0 is no window");
            }
            Self::Punctual => {
                ui.weak("Made for order 3: later bands become zero.");
            }
            Self::None | Self::Dering | Self::DeringIrradiance => {}
        }
    }
}

/// The width of a window in bands, and beside it the peak that it leaves a unit impulse of this order, which finds the width.
fn width_or_peak(ui: &mut Ui, width: &mut f64, order: usize, window: impl Fn(f64) -> Window) {
    let (least, most) = (*WIDTHS.start(), 4.0 * order.max(1) as f64);
    // A width that was found by a peak has more digits than the slider rounds to, and one that is too large for this order is kept for
    // those that it was made for.
    let slider = Slider::new(width, least..=most).text("Width in bands").fixed_decimals(2);
    ui.add(slider.clamping(SliderClamping::Edits)).on_hover_text("The band at which the factors reach zero");
    if order < 2 {
        // An impulse of one band is its mean, under every window.
        return;
    }
    let peak_of = |width: f64| window(width).impulse_peak(order);
    let mut peak = peak_of(*width);
    let slider = Slider::new(&mut peak, peak_of(least)..=peak_of(most)).text("Peak of an impulse").fixed_decimals(3);
    let hint = "What the window leaves a unit impulse of this order at its peak; windows of one peak blur alike";
    let is_changed = ui.add(slider.clamping(SliderClamping::Edits)).on_hover_text(hint).changed();
    if is_changed && let Some(found) = width_of_peak(order, peak, &window) {
        *width = found.clamp(least, most);
    }
}

#[cfg(test)]
mod tests {
    use lobe::sh::{Dir, Rgb};

    use super::*;

    #[test]
    fn every_kind_is_kept_and_read_again_as_it_was() {
        for taming in Taming::choices(6) {
            let text = serde_json::to_string(&taming).unwrap();
            assert_eq!(serde_json::from_str::<Taming>(&text).ok(), Some(taming), "{text}");
        }
    }

    #[test]
    fn a_width_of_a_higher_order_is_kept_while_a_lower_one_is_shown() {
        for kept in [Taming::Hanning(32.0), Taming::Sinc4(32.0), Taming::Lanczos { width: 32.0, power: 2.0 }] {
            let show = |ui: &mut Ui, taming: &mut Taming| taming.controls(ui, 2);
            let mut harness = egui_kittest::Harness::builder().with_size([400.0, 300.0]).build_ui_state(show, kept);
            harness.run_steps(3);
            assert_eq!(*harness.state(), kept, "at order 2");
        }
    }

    #[test]
    fn what_older_versions_kept_is_read() {
        for (text, expected) in [
            (r#""none""#, Taming::None),
            (r#"{"hanning": 6.5}"#, Taming::Hanning(6.5)),
            (r#"{"lanczos": 9}"#, Taming::Lanczos { width: 9.0, power: 1.0 }),
            (r#"{"lanczos": 9.5}"#, Taming::Lanczos { width: 9.5, power: 1.0 }),
            (r#"{"gauss": 0.25}"#, Taming::Gauss(0.25)),
            (r#""dering""#, Taming::Dering),
        ] {
            assert_eq!(serde_json::from_str::<Taming>(text).ok(), Some(expected), "{text}");
        }
        assert!(serde_json::from_str::<Taming>(r#"{"lanczos": "wide"}"#).is_err(), "a width that is no number");
    }

    #[test]
    fn kinds_follow_each_other_in_a_circle_and_each_has_another_name_and_formula() {
        let choices = Taming::choices(4);
        for (number, choice) in choices.iter().enumerate() {
            assert_eq!(choice.next(4), choices[(number + 1) % choices.len()], "after {}", choice.title());
            for other in &choices[..number] {
                assert_ne!(other.title(), choice.title(), "names");
                assert_ne!(other.formula(), choice.formula(), "formulas");
            }
        }
    }

    #[test]
    fn an_expansion_is_tamed_as_the_library_does_by_every_kind_and_order() {
        for order in [1, 2, 3, 5] {
            let sun = ShVec::impulse(order, Dir::from_angles(1.1, 0.7), Rgb::new(3.0_f64, 2.0, 1.0));
            for taming in Taming::choices(order) {
                let expected = match (taming.dering(order), taming.window()) {
                    (Some(dering), _) => sun.deringed_with(&dering).0,
                    (None, Some(window)) => sun.windowed(&window),
                    (None, None) => sun.clone(),
                };
                assert_eq!(taming.tamed(&sun), expected, "{} of order {order}", taming.title());
            }
        }
    }

    #[test]
    fn dering_by_irradiance_leaves_more_light_than_by_radiance_and_no_irradiance_below_zero() {
        for order in [3, 4, 6] {
            let sun = ShVec::impulse(order, Dir::Z, 1.0_f64);
            let kept = |taming: Taming| {
                let tamed = taming.tamed(&sun);
                tamed.dot(&tamed)
            };
            let [by_radiance, by_irradiance, whole] =
                [Taming::Dering, Taming::DeringIrradiance, Taming::None].map(kept);
            let is_between = by_radiance < by_irradiance && by_irradiance < whole;
            assert!(is_between, "order {order}: {by_radiance}, {by_irradiance} of {whole}");
            let received = Taming::DeringIrradiance.tamed(&sun).convolved(&Zonal::clamped_cosine(order));
            let least = (0..=180).map(|k| received.eval(Dir::from_angles(f64::from(k).to_radians(), 0.0)));
            let least = least.fold(f64::INFINITY, f64::min);
            assert!(least > -1e-6, "order {order}: an irradiance of {least}");
        }
    }

    #[test]
    fn numbers_beyond_their_ranges_come_back_into_them() {
        let bad = [f64::NAN, f64::INFINITY, -1.0, 0.0, 1e300];
        for x in bad {
            let all = [
                Taming::Hanning(x),
                Taming::Lanczos { width: x, power: x },
                Taming::Sinc4(x),
                Taming::Gauss(x),
                Taming::Laplacian(x),
            ];
            for mut taming in all {
                taming.check();
                let factors = taming.window().map(|window| window.factors(8)).unwrap_or_default();
                let is_sound = factors.len() == 8 && factors.iter().all(|w| (-1e-12..=1.0).contains(w));
                assert!(is_sound, "{x}: {taming:?} has {factors:?}");
            }
        }
    }
}
