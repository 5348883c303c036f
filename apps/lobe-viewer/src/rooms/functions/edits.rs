//! The parameters of the room of functions, which a user changes.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::path::Path;

use eframe::egui::{ComboBox, Slider, Ui};
use lobe::figures::CrossSection;
use lobe::sh::{Dir, Expansion as _, Rgb, Rotation, ShVec, Zonal};
use serde::{Deserialize, Serialize};

use crate::loading::sky_source::read_expansion;
use crate::rooms::formulas::Formula;
use crate::rooms::light::LightHand;
use crate::rooms::taming::Taming;
use crate::widgets::coefficient_table::MOST;
use crate::widgets::within::within;

/// The highest order of the room, whose coefficients still fit beside the balloons.
pub(crate) const MAX_ORDER: usize = 8;

/// What is looked at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Study {
    /// A function that is turned, and its coefficients.
    #[default]
    Rotate,
    /// The product of two functions.
    Product,
    /// A light that rings, and what ends it.
    Ringing,
    /// Irradiance by an ambient cube while the light turns.
    AmbientCube,
}

impl Study {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Rotate, Self::Product, Self::Ringing, Self::AmbientCube];

    /// The name for people.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::Rotate => "Rotation",
            Self::Product => "Product",
            Self::Ringing => "Ringing",
            Self::AmbientCube => "Ambient cube",
        }
    }
}

/// The plane of polar plots.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Section {
    /// No plots.
    None,
    /// +x to the right, +z upwards.
    #[default]
    XZ,
    /// +y to the right, +z upwards.
    YZ,
    /// +x to the right, +y upwards.
    XY,
}

impl Section {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::None, Self::XZ, Self::YZ, Self::XY];

    /// The name for people.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::XZ => "x and z",
            Self::YZ => "y and z",
            Self::XY => "x and y",
        }
    }

    pub(crate) fn plane(self) -> Option<CrossSection> {
        match self {
            Self::None => None,
            Self::XZ => Some(CrossSection::XZ),
            Self::YZ => Some(CrossSection::YZ),
            Self::XY => Some(CrossSection::XY),
        }
    }
}

/// A function on the sphere, by name.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Shape {
    /// A function of the basis, of this band and number in it.
    Basis(usize, isize),
    /// All light from one direction.
    Impulse,
    /// `max(cos, 0)`.
    Cosine,
    /// 1 within an angle in degrees, 0 outside.
    Cone(f64),
    /// A Phong lobe of this exponent.
    Lobe(f64),
    /// That of a file which was opened.
    Opened,
}

impl Shape {
    fn title(self) -> &'static str {
        match self {
            Self::Basis(..) => "Function of the basis",
            Self::Impulse => "Impulse",
            Self::Cosine => "Clamped cosine",
            Self::Cone(_) => "Cone",
            Self::Lobe(_) => "Phong lobe",
            Self::Opened => "From a file",
        }
    }

    /// Its expansion, about an axis if it has one.
    #[must_use]
    pub fn expansion(self, order: usize, axis: Dir) -> ShVec<f64> {
        match self {
            Self::Basis(l, m) => {
                let mut f = ShVec::zero(order);
                // Of a function above the order nothing is left.
                if l < order {
                    f.band_mut(l)[m.saturating_add(l as isize).clamp(0, 2 * l as isize) as usize] = 1.0;
                }
                f
            }
            Self::Impulse => ShVec::impulse(order, axis, 1.0),
            Self::Cosine => Zonal::clamped_cosine(order).towards(axis, 1.0),
            Self::Cone(degrees) => Zonal::cone(order, degrees.to_radians()).towards(axis, 1.0),
            Self::Lobe(exponent) => Zonal::phong(order, exponent).towards(axis, 1.0),
            // Its numbers are those of the edits.
            Self::Opened => ShVec::zero(order),
        }
    }

    fn check(&mut self) {
        match self {
            Self::Basis(l, m) => {
                *l = (*l).min(MAX_ORDER - 1);
                *m = (*m).clamp(-(*l as isize), *l as isize);
            }
            Self::Cone(degrees) => *degrees = within(*degrees, 1.0..=180.0, 30.0),
            Self::Lobe(exponent) => *exponent = within(*exponent, 0.0..=64.0, 8.0),
            Self::Impulse | Self::Cosine | Self::Opened => {}
        }
    }

    /// A choice, also that of a file where there is one, and the numbers of what was chosen.
    pub(crate) fn controls(&mut self, ui: &mut Ui, label: &str, order: usize, has_file: bool) {
        ComboBox::from_label(label).selected_text(self.title()).show_ui(ui, |ui| {
            let all = [Self::Basis(2, 0), Self::Impulse, Self::Cosine, Self::Cone(30.0), Self::Lobe(8.0)];
            for shape in all.into_iter().chain(has_file.then_some(Self::Opened)) {
                let is_chosen = shape.title() == self.title();
                if ui.selectable_label(is_chosen, shape.title()).clicked() && !is_chosen {
                    *self = shape;
                }
            }
        });
        match self {
            Self::Basis(l, m) => {
                ui.add(Slider::new(l, 0..=order.saturating_sub(1)).text(format!("Band of {label}")));
                let most = *l as isize;
                *m = (*m).clamp(-most, most);
                ui.add(Slider::new(m, -most..=most).text(format!("Number in the band of {label}")));
            }
            Self::Cone(degrees) => {
                ui.add(Slider::new(degrees, 1.0..=180.0).text(format!("Half angle of {label}")).suffix("°"));
            }
            Self::Lobe(exponent) => {
                ui.add(Slider::new(exponent, 0.0..=64.0).text(format!("Exponent of {label}")));
            }
            Self::Impulse | Self::Cosine | Self::Opened => {}
        }
    }
}

/// A function of a file: of colors their luminance, up to the highest order of the room.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct OpenedFunction {
    /// The name of the file, and what its numbers are.
    pub name: String,
    /// The coefficients, band by band.
    pub coefficients: Vec<f64>,
}

impl OpenedFunction {
    /// Reads the expansion of a .sh.json file.
    ///
    /// # Errors
    /// One line that says what is wrong with the file.
    pub fn read(path: &Path) -> anyhow::Result<Self> {
        let file = read_expansion(path)?;
        let order = file.coefficients.to_rgb().order().min(MAX_ORDER);
        let luminance = file.coefficients.to_rgb().resized(order).map(Rgb::luminance);
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        Ok(Self { name: format!("{name}: {}", file.quantity), coefficients: luminance.coefficients().to_vec() })
    }

    fn expansion(&self, order: usize) -> ShVec<f64> {
        ShVec::from_vec(self.coefficients.clone()).map_or_else(|| ShVec::zero(order), |f| f.resized(order))
    }

    /// Its numbers in their range; none if they are not as many as an expansion has.
    fn checked(self) -> Option<Self> {
        let is_sound = self.coefficients.iter().all(|c| c.abs() <= MOST)
            && self.coefficients.len() <= MAX_ORDER * MAX_ORDER
            && ShVec::from_vec(self.coefficients.clone()).is_some();
        is_sound.then_some(self)
    }
}

/// All that is kept from one start to the next.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
#[non_exhaustive]
pub struct FunctionsEdits {
    /// What is looked at.
    pub study: Study,
    /// Number of bands.
    pub order: usize,
    /// The function.
    pub shape: Shape,
    /// Yaw, pitch and roll by which it is turned, in degrees.
    pub angles: [f64; 3],
    /// The other factor of a product.
    pub other: Shape,
    /// The angle between the axes of both, in degrees.
    pub between: f64,
    /// Half the angle of the light that rings, in degrees.
    pub half_angle: f64,
    /// What ends its ringing.
    pub taming: Taming,
    /// Where the light of the ambient cube is, in degrees.
    pub light_at: f64,
    /// How high above the horizon it is, in degrees.
    pub light_height: f64,
    /// The function of a file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub opened: Option<OpenedFunction>,
    /// Whether functions are shown on unfolded cubes, too.
    pub has_crosses: bool,
    /// The plane of polar plots.
    pub section: Section,
}

impl Default for FunctionsEdits {
    fn default() -> Self {
        Self {
            study: Study::default(),
            order: 4,
            shape: Shape::Basis(2, 1),
            angles: [30.0, 0.0, 0.0],
            other: Shape::Cosine,
            between: 40.0,
            half_angle: 20.0,
            taming: Taming::None,
            light_at: 20.0,
            light_height: 0.0,
            opened: None,
            has_crosses: true,
            section: Section::XZ,
        }
    }
}

impl FunctionsEdits {
    /// Brings its numbers into their ranges.
    pub(crate) fn check(&mut self) {
        let first = Self::default();
        self.order = self.order.clamp(1, MAX_ORDER);
        [&mut self.shape, &mut self.other].into_iter().for_each(Shape::check);
        self.taming.check();
        self.opened = self.opened.take().and_then(OpenedFunction::checked);
        if self.opened.is_none() && self.shape == Shape::Opened {
            self.shape = first.shape;
        }
        // The function of a file is the first factor only.
        if self.other == Shape::Opened {
            self.other = first.other;
        }
        self.angles = self.angles.map(|angle| within(angle, -180.0..=180.0, 0.0));
        self.between = within(self.between, 0.0..=180.0, first.between);
        self.half_angle = within(self.half_angle, 1.0..=90.0, first.half_angle);
        self.light_at = within(self.light_at, 0.0..=360.0, first.light_at);
        self.light_height = within(self.light_height, -90.0..=90.0, first.light_height);
    }

    /// Changes its light, or what stands for it: a turn and a tilt are those of the function, about +z and +x, or of the light of
    /// the ambient cube.
    pub(crate) fn with_light<R>(&mut self, change: impl FnOnce(&mut LightHand<'_>) -> R) -> R {
        let is_cube = self.study == Study::AmbientCube;
        let [mut yaw, pitch, mut roll] = self.angles.map(f64::to_radians);
        let (mut azimuth, mut height) = (self.light_at.to_radians(), self.light_height.to_radians());
        let before = [yaw, roll, azimuth, height];
        let taming = (self.study == Study::Ringing).then_some(&mut self.taming);
        let (turn, tilt) = if is_cube { (&mut azimuth, &mut height) } else { (&mut yaw, &mut roll) };
        // The cube is compared with order 3, and the order of the other studies is not seen there.
        let mut unseen = self.order;
        let order = if is_cube { &mut unseen } else { &mut self.order };
        let hand = &mut LightHand { order, most_order: MAX_ORDER, taming, turn, tilt, exposed: None };
        let result = change(hand);
        if [yaw, roll, azimuth, height] != before {
            let half_turns = |angle: f64| (angle + PI).rem_euclid(TAU) - PI;
            self.angles = [half_turns(yaw), pitch, half_turns(roll)].map(f64::to_degrees);
            self.light_at = azimuth.to_degrees();
            self.light_height = height.clamp(-FRAC_PI_2, FRAC_PI_2).to_degrees();
        }
        result
    }

    /// What the study computes.
    pub(crate) fn formulas(&self) -> Vec<Formula> {
        match self.study {
            Study::Rotate => vec![Formula::PROJECTION, Formula::ROTATION],
            Study::Product => vec![Formula::PRODUCT],
            Study::Ringing => [Some(Formula::CONE), self.taming.formula()].into_iter().flatten().collect(),
            Study::AmbientCube => vec![Formula::IRRADIANCE, Formula::AMBIENT_CUBE],
        }
    }

    /// The rotation of the study of rotations.
    #[must_use]
    pub fn rotation(&self) -> Rotation {
        let [yaw, pitch, roll] = self.angles.map(f64::to_radians);
        Rotation::from_yaw_pitch_roll(yaw, pitch, roll)
    }

    /// The function before it is turned.
    #[must_use]
    pub fn function(&self) -> ShVec<f64> {
        match (self.shape, &self.opened) {
            (Shape::Opened, Some(opened)) => opened.expansion(self.order),
            _ => self.shape.expansion(self.order, Dir::Z),
        }
    }

    /// The other factor, about an axis that leans from +z towards +x.
    #[must_use]
    pub fn other_factor(&self) -> ShVec<f64> {
        self.other.expansion(self.order, Dir::from_angles(self.between.to_radians(), 0.0))
    }

    /// The light that rings: a cone of radiance 1 about +z.
    #[must_use]
    pub fn ringing_light(&self) -> ShVec<f64> {
        Shape::Cone(self.half_angle).expansion(self.order, Dir::Z)
    }
}
