//! Windows and dering of the expansion of a light.

use std::ops::RangeInclusive;

use eframe::egui::{ComboBox, Slider, Ui};
use lobe::sh::{DeringOptions, Rgb, ShVec, Window, deringed, windowed};
use serde::{Deserialize, Serialize};

use crate::widgets::within::within;

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
        let order = order as f64;
        ComboBox::from_label("Window").selected_text(Self::NAMES[self.number()]).show_ui(ui, |ui| {
            let choices = [Self::None, Self::Hanning(order), Self::Lanczos(order), Self::Gauss(0.3), Self::Dering];
            for choice in choices {
                let is_chosen = choice.number() == self.number();
                if ui.selectable_label(is_chosen, Self::NAMES[choice.number()]).clicked() && !is_chosen {
                    *self = choice;
                }
            }
        });
        match self {
            Self::Hanning(width) | Self::Lanczos(width) => {
                ui.add(
                    Slider::new(width, *WIDTHS.start()..=4.0 * order.max(1.0)).text("Width in bands").fixed_decimals(2),
                );
            }
            Self::Gauss(sigma) => {
                ui.add(Slider::new(sigma, SIGMAS).text("Width in radians").fixed_decimals(3));
            }
            Self::None | Self::Dering => {}
        }
    }
}
