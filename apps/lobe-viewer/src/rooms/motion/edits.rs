//! The parameters of the room of motion, which a user changes.

use std::path::PathBuf;

use lobe::env::Sun;
use lobe::image::Curve;
use lobe::motion::MovingMethod;
use lobe::render::Background;
use lobe::scene::built_in;
use lobe::sh::{Expansion as _, Rgb, Rotation, ShVec};
use serde::{Deserialize, Serialize};

use crate::loading::limits::ReadLimits;
use crate::loading::moving_light::LitOn;
use crate::loading::moving_source::built_in_moving;
use crate::rooms::formulas::Formula;
use crate::rooms::light::{LightHand, MOST_STOPS, sky_rotation};
use crate::rooms::motion::cast::Hand;
use crate::rooms::motion::player::{Asked, Fit, MOST_ORDER, Source};
use crate::rooms::taming::Taming;
use crate::widgets::tone::Look;
use crate::widgets::within::within;

/// The most spheres of a part.
pub(crate) const MOST_SPHERES: usize = 64;

/// The farthest from the origin that a part is kept, in meters, and how much larger or smaller than it was.
const FARTHEST: f64 = 1e6;
pub(crate) const SCALES: std::ops::RangeInclusive<f64> = 1e-3..=1e3;

/// How what moves is seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum MotionView {
    /// Parts hide the sky by shadow fields.
    #[default]
    Fields,
    /// By exponentials of sums of spheres.
    Exponentials,
    /// Paths are traced while nothing moves.
    Truth,
    /// All three beside each other.
    Beside,
}

impl MotionView {
    /// All of them, in the order of the window.
    pub const ALL: [Self; 4] = [Self::Fields, Self::Exponentials, Self::Truth, Self::Beside];

    /// The name in the window.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::Fields => "Shadow fields",
            Self::Exponentials => "Spheres, SH exponentials",
            Self::Truth => "Truth by rays",
            Self::Beside => "All three beside each other",
        }
    }

    /// The pictures, from left to right.
    pub(crate) fn panes(self) -> &'static [Self] {
        match self {
            Self::Fields => &[Self::Fields],
            Self::Exponentials => &[Self::Exponentials],
            Self::Truth => &[Self::Truth],
            Self::Beside => &[Self::Fields, Self::Exponentials, Self::Truth],
        }
    }

    /// How parts hide the sky in one picture; none in the truth.
    pub(crate) fn method(self) -> Option<MovingMethod> {
        match self {
            Self::Fields => Some(MovingMethod::Fields),
            Self::Exponentials => Some(MovingMethod::Exponentials),
            Self::Truth | Self::Beside => None,
        }
    }
}

/// What moves, how its shadows are computed, its light, and where a user has put its parts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
#[non_exhaustive]
pub struct MotionEdits {
    /// The scene: a file, or a built-in one.
    pub source: PathBuf,
    /// Files of fields and spheres for its parts.
    pub files: Vec<PathBuf>,
    /// How it is seen.
    pub view: MotionView,
    /// Number of bands of the light, and of all that is baked.
    pub order: usize,
    /// What is done to the expansion of the light.
    pub taming: Taming,
    /// Whether suns of the sky are apart from its expansion and cast shadows by themselves.
    pub has_suns: bool,
    /// By which the sky is turned about +z, in radians.
    pub turn: f64,
    /// By which it is tilted about +x before that, in radians.
    pub tilt: f64,
    /// Stops of exposure above that which fits the first picture.
    pub exposure: f64,
    /// The tone curve.
    #[serde(with = "crate::rooms::curve")]
    pub tone: Curve,
    /// What is behind the scene.
    #[serde(with = "crate::rooms::background")]
    pub background: Background,
    /// Whether parts are where the user has put them, and not where the animation does.
    pub is_by_hand: bool,
    /// Whether the spheres are drawn.
    pub has_spheres: bool,
    /// Where the light of moments is computed.
    pub(crate) lit_on: LitOn,
    /// The spheres of exponentials.
    pub(crate) fit: Fit,
    pub(crate) hands: Vec<Hand>,
}

impl Default for MotionEdits {
    fn default() -> Self {
        Self {
            source: built_in_moving(built_in::MOVING_NAMES[0]),
            files: Vec::new(),
            view: MotionView::Fields,
            order: 4,
            taming: Taming::None,
            has_suns: true,
            turn: 0.0,
            tilt: 0.0,
            exposure: 0.0,
            tone: Curve::default(),
            background: Background::Env,
            is_by_hand: false,
            has_spheres: false,
            lit_on: LitOn::default(),
            fit: Fit::default(),
            hands: Vec::new(),
        }
    }
}

impl MotionEdits {
    /// The same for another scene, of which nothing was moved yet.
    pub(crate) fn of_scene(&self, source: PathBuf) -> Self {
        Self { source, files: Vec::new(), is_by_hand: false, hands: Vec::new(), ..self.clone() }
    }

    /// The ways by which the pictures are lit.
    pub(crate) fn methods(&self) -> Vec<MovingMethod> {
        self.view.panes().iter().filter_map(|pane| pane.method()).collect()
    }

    /// What is to be opened.
    pub(crate) fn wanted(&self, limits: ReadLimits) -> Source {
        Source { path: self.source.clone(), files: self.files.clone(), limits }
    }

    /// What is to be shown of a time under a light, of which suns are apart.
    pub(crate) fn asks(&self, time: f64, light: ShVec<Rgb<f64>>, suns: Vec<Sun>) -> Asked {
        let hands = self.is_by_hand.then(|| self.hands.clone());
        Asked { time, methods: self.methods(), light, suns, fit: self.fit, lit_on: self.lit_on, hands }
    }

    /// Asks again for what needs no other bakes than a moment that is lit already.
    pub(crate) fn return_to(&mut self, asked: &Asked) {
        (self.order, self.fit) = (asked.light.order(), asked.fit);
        let is_of =
            |view: &MotionView| view.panes().iter().filter_map(|pane| pane.method()).eq(asked.methods.iter().copied());
        if !is_of(&self.view) {
            self.view = MotionView::ALL.into_iter().find(is_of).unwrap_or(self.view);
        }
    }

    /// What is seen, and what it is compared with.
    pub(crate) fn formulas(&self) -> Vec<Formula> {
        let of = |pane: &MotionView| match pane {
            MotionView::Fields => &[Formula::FIELDS][..],
            MotionView::Exponentials => &[Formula::EXPONENTIALS],
            _ => &[Formula::TRUTH, Formula::RMS],
        };
        let ways = (!self.methods().is_empty()).then_some([Formula::MOVING, Formula::PRODUCT]);
        let panes = self.view.panes().iter().flat_map(of).copied();
        ways.into_iter().flatten().chain(panes).chain(self.taming.formula()).collect()
    }

    /// The rotation of the sky.
    #[must_use]
    pub fn rotation(&self) -> Rotation {
        sky_rotation(self.turn, self.tilt)
    }

    /// How light is shown.
    pub(crate) fn look(&self) -> Look {
        Look { stops: self.exposure, curve: self.tone }
    }

    /// Its light, to be changed; of what came baked only as many bands can be had as that has.
    pub(crate) fn light(&mut self, most_order: usize) -> LightHand<'_> {
        let Self { order, taming, turn, tilt, exposure, tone, .. } = self;
        let (taming, exposed) = (Some(taming), Some((exposure, tone)));
        LightHand { order, most_order, taming, turn, tilt, exposed }
    }

    /// Brings its numbers into their ranges.
    pub(crate) fn check(&mut self) {
        let first = Self::default();
        self.order = self.order.clamp(1, MOST_ORDER);
        self.taming.check();
        self.turn = within(self.turn, 0.0..=std::f64::consts::TAU, first.turn);
        self.tilt = within(self.tilt, -std::f64::consts::PI..=std::f64::consts::PI, first.tilt);
        self.exposure = within(self.exposure, -MOST_STOPS..=MOST_STOPS, first.exposure);
        self.fit.count = self.fit.count.clamp(1, MOST_SPHERES);
        for hand in &mut self.hands {
            hand.position = hand.position.map(|c| within(c, -FARTHEST..=FARTHEST, 0.0));
            hand.turn = within(hand.turn, -FARTHEST..=FARTHEST, 0.0);
            hand.scale = within(hand.scale, SCALES, 1.0);
        }
    }
}
