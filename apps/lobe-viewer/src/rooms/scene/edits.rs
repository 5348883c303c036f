//! The parameters of the room of scenes, which a user changes.

use std::f64::consts::{PI, TAU};
use std::ops::RangeInclusive;
use std::path::PathBuf;

use lobe::image::Curve;
use lobe::prt::Transfer;
use lobe::render::Background;
use lobe::sh::light::Normalization;
use lobe::sh::{Dir, Light, Rgb, Rotation, ShError, ShVec};
use serde::{Deserialize, Serialize};

use crate::loading::materials::shines;
use crate::loading::mode::Mode;
use crate::loading::{scene_source, sky_source};
use crate::rooms::formulas::Formula;
use crate::rooms::light::{LightHand, MOST_STOPS, sky_rotation};
use crate::rooms::taming::Taming;
use crate::rooms::truth_light::Disc;
use crate::widgets::tone::Look;
use crate::widgets::within::within;
use lobe::render::Surfaces;

/// The most lamps.
pub(crate) const MOST_LAMPS: usize = 16;

/// Whether the picture is compared with the truth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Comparison {
    /// It is not.
    #[default]
    Off,
    /// The truth is shown in its place.
    Truth,
    /// Red where the picture is too bright, blue where it is too dark.
    Difference,
}

impl Comparison {
    /// All of them, in the order of the window.
    pub const ALL: [Self; 3] = [Self::Off, Self::Truth, Self::Difference];

    /// The name in the window.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::Off => "Picture",
            Self::Truth => "Truth by rays",
            Self::Difference => "Difference to the truth",
        }
    }
}

/// All that can be undone, and that is kept from one start to the next.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
#[non_exhaustive]
pub struct SceneEdits {
    /// The scene: a file, or a built-in one.
    pub scene: PathBuf,
    /// The sky: a file, or a built-in one.
    pub sky: PathBuf,
    /// Which light paths are shown.
    pub mode: Mode,
    /// Whether metals shine, where interreflections are shown.
    pub has_gloss: bool,
    /// Whether the picture is compared with the truth.
    pub comparison: Comparison,
    /// Number of bands of the light.
    pub order: usize,
    /// Paths from each vertex of its bakes: a power of two from 16 to 4096, to which others are lowered or raised.
    pub samples: u32,
    /// What is done to its expansion.
    pub taming: Taming,
    /// Whether suns of the sky are apart from its expansion and cast shadows by themselves.
    pub has_suns: bool,
    /// How surfaces reflect.
    pub surfaces: Surfaces,
    /// Factor of the sky's radiance.
    pub sky_strength: f64,
    /// By which the sky is turned about +z, in radians.
    pub turn: f64,
    /// By which it is tilted about +x before that, in radians.
    pub tilt: f64,
    /// Stops of exposure above that which fits the scene.
    pub exposure: f64,
    /// The tone curve.
    #[serde(with = "crate::rooms::curve")]
    pub tone: Curve,
    /// What is behind the scene.
    #[serde(with = "crate::rooms::background")]
    pub background: Background,
    /// Lights added by hand.
    pub lamps: Vec<SceneLamp>,
}

impl Default for SceneEdits {
    fn default() -> Self {
        Self {
            scene: scene_source::FIRST.into(),
            sky: sky_source::FIRST.into(),
            mode: Mode::default(),
            has_gloss: true,
            comparison: Comparison::Off,
            order: 4,
            samples: 256,
            taming: Taming::None,
            has_suns: true,
            surfaces: Surfaces::default(),
            sky_strength: 1.0,
            // The sun from the left of the first view, in whole degrees as its slider has them.
            turn: 160.0_f64.to_radians(),
            tilt: 0.0,
            exposure: 0.0,
            tone: Curve::default(),
            background: Background::Env,
            lamps: Vec::new(),
        }
    }
}

/// Paths that can be chosen: powers of 2 by these exponents.
pub(crate) const PATHS_LOG2: RangeInclusive<u32> = 4..=12;

/// The most paths that can be chosen and are no more than these, or the fewest.
pub(crate) fn paths(wanted: u32) -> u32 {
    1 << wanted.max(1).ilog2().clamp(*PATHS_LOG2.start(), *PATHS_LOG2.end())
}

impl SceneEdits {
    /// Brings its numbers into their ranges.
    pub(crate) fn check(&mut self) {
        let first = Self::default();
        self.order = self.order.clamp(1, Transfer::MAX_ORDER);
        self.samples = paths(self.samples);
        self.taming.check();
        self.sky_strength = within(self.sky_strength, 0.0..=8.0, first.sky_strength);
        self.turn = within(self.turn, 0.0..=TAU, first.turn);
        self.tilt = within(self.tilt, -PI..=PI, first.tilt);
        self.exposure = within(self.exposure, -MOST_STOPS..=MOST_STOPS, first.exposure);
        self.lamps.truncate(MOST_LAMPS);
        self.lamps.iter_mut().for_each(SceneLamp::check);
    }

    /// The rotation of the sky.
    #[must_use]
    pub fn rotation(&self) -> Rotation {
        sky_rotation(self.turn, self.tilt)
    }

    /// What lights the scene, and what that is compared with.
    pub(crate) fn formulas(&self) -> Vec<Formula> {
        let light = match self.mode {
            Mode::Irradiance => &[Formula::UNSHADOWED][..],
            Mode::Shadowed if self.has_materials() => &[Formula::TRANSFER, Formula::SHADOWED, Formula::SPLIT_SUM],
            Mode::Shadowed => &[Formula::TRANSFER, Formula::SHADOWED],
            Mode::Interreflected if self.has_materials() => {
                &[Formula::TRANSFER, Formula::INTERREFLECTED, Formula::SPLIT_SUM]
            }
            Mode::Interreflected if self.has_gloss => &[Formula::TRANSFER, Formula::INTERREFLECTED, Formula::GLOSSY],
            Mode::Interreflected => &[Formula::TRANSFER, Formula::INTERREFLECTED],
            Mode::Difference => &[Formula::TRANSFER, Formula::BOUNCES],
        };
        let truth = match self.comparison {
            Comparison::Off => &[][..],
            Comparison::Truth | Comparison::Difference => &[Formula::TRUTH, Formula::RMS],
        };
        let turned = [Some(Formula::ROTATION), self.taming.formula()];
        let all = light.iter().copied().chain(turned.into_iter().flatten());
        all.chain(truth.iter().copied()).collect()
    }

    /// Whether surfaces of the mode are to shine by their materials.
    pub(crate) fn has_materials(&self) -> bool {
        self.surfaces == Surfaces::MetallicRoughness && shines(self.mode)
    }

    /// How light is shown.
    pub(crate) fn look(&self) -> Look {
        Look { stops: self.exposure, curve: self.tone }
    }

    /// Its light, to be changed.
    pub(crate) fn light(&mut self) -> LightHand<'_> {
        let Self { order, taming, turn, tilt, exposure, tone, .. } = self;
        let (taming, exposed) = (Some(taming), Some((exposure, tone)));
        LightHand { order, most_order: Transfer::MAX_ORDER, taming, turn, tilt, exposed }
    }
}

/// A disc of light far away, such as a sun.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
#[non_exhaustive]
pub struct SceneLamp {
    /// Whether it shines.
    pub is_on: bool,
    /// In degrees, from +x towards +y.
    pub azimuth: f64,
    /// In degrees, from the horizon upwards.
    pub height: f64,
    /// Half its angle, in degrees.
    pub half_angle: f64,
    /// Its color, each channel 0 to 1.
    pub color: [f32; 3],
    /// The radiance that a white surface facing it reflects.
    pub strength: f64,
}

impl Default for SceneLamp {
    fn default() -> Self {
        Self { is_on: true, azimuth: -150.0, height: 30.0, half_angle: 5.0, color: [1.0, 0.9, 0.75], strength: 0.5 }
    }
}

impl SceneLamp {
    fn check(&mut self) {
        let first = Self::default();
        self.azimuth = within(self.azimuth, -180.0..=180.0, first.azimuth);
        self.height = within(self.height, -90.0..=90.0, first.height);
        self.half_angle = within(self.half_angle, 1.0..=90.0, first.half_angle);
        self.strength = within(self.strength, 0.0..=20.0, first.strength);
        self.color =
            std::array::from_fn(|k| within(f64::from(self.color[k]), 0.0..=1.0, f64::from(first.color[k])) as f32);
    }

    /// Towards the lamp.
    #[must_use]
    pub fn dir(&self) -> Dir {
        Dir::from_angles((90.0 - self.height).to_radians(), self.azimuth.to_radians())
    }

    /// The disc, for rays.
    pub(crate) fn disc(&self) -> Disc {
        let color = self.color.map(|c| f64::from(c) * self.strength);
        Disc { dir: self.dir(), half_angle: self.half_angle.to_radians(), color }
    }

    /// Its expansion, normalized so that the strength is what a white surface that faces it reflects.
    ///
    /// # Errors
    /// As [`Light::project`].
    pub fn project(&self, order: usize) -> Result<ShVec<Rgb<f64>>, ShError> {
        let color = Rgb::from(self.color.map(|c| f64::from(c) * self.strength));
        let light = Light::Cone { dir: self.dir(), half_angle: self.half_angle.to_radians(), color };
        light.project(order, Normalization::Projected)
    }
}
