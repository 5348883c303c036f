//! A photograph, and what its figures share.

use lobe::env::bundled::Bundled;
use lobe::env::{EnvMap, project_env};
use lobe::figures::Ball;
use lobe::image::{Exposure, Picture, Tone};
use lobe::render::View;
use lobe::sh::expansion::optimal_linear_direction;
use lobe::sh::{Dir, Expansion as _, Rgb, ShVec};

/// The highest order of the sweep over orders, that of the figures in the papers.
pub(crate) const SWEEP: usize = 6;

/// The color around the balls: black stays black at any exposure.
pub(crate) const BACKDROP: Rgb<f32> = Rgb::new(0.0, 0.0, 0.0);

/// The display value of the mean radiance of a photograph beside its reconstructions, which are smooth: brighter
/// than middle gray, so that what is darker than the mean can be told apart.
const MEAN_KEY: f64 = 0.3;

/// The data that the figures of one photograph share.
pub(crate) struct Sky {
    pub(crate) bundled: Bundled,
    pub(crate) map: EnvMap,
    /// The radiance at order [`SWEEP`].
    pub(crate) radiance: ShVec<Rgb<f64>>,
    /// Exposure for the photograph and its reconstructions: by the mean, which they share.
    pub(crate) tone: Tone,
}

impl Sky {
    pub(crate) fn new(bundled: Bundled) -> Self {
        let map = bundled.map();
        let radiance = project_env(&map, SWEEP);
        let exposure = Exposure::Fixed(MEAN_KEY / radiance.mean().luminance());
        let tone = Tone { exposure, ..Tone::PHOTOGRAPH };
        Self { bundled, map, radiance, tone }
    }

    /// The name of a file about this photograph.
    pub(crate) fn file(&self, what: &str) -> String {
        format!("{}-{what}", self.bundled.name)
    }

    /// The photograph, `width` wide.
    pub(crate) fn photograph(&self, width: usize) -> Picture {
        Picture::from(&self.map).resized(width, width / 2)
    }

    /// The column and the row of the brightest texel.
    pub(crate) fn brightest(&self) -> (usize, usize) {
        let map = &self.map;
        let luminance = |i: &usize| map.texels()[*i].luminance();
        let brightest = (0..map.texels().len()).max_by(|a, b| luminance(a).total_cmp(&luminance(b))).unwrap_or(0);
        (brightest % map.width(), brightest / map.width())
    }

    /// A direction at so many degrees from +z, so many degrees around it from where the light comes from on the whole.
    pub(crate) fn beside_the_light(&self, from_above: f64, around: f64) -> Dir {
        let light = optimal_linear_direction(&self.radiance).unwrap_or(Dir::Z);
        Dir::from_angles(from_above.to_radians(), light.phi() + around.to_radians())
    }
}

/// A ball `size` wide, seen from a direction.
pub(crate) fn ball_from(size: usize, eye: Dir) -> Ball {
    Ball::new(size).seen(View::from_eye(eye))
}

/// All values of an expansion at the texel centers of the map.
pub(crate) fn values_like(f: &ShVec<Rgb<f64>>, map: &EnvMap) -> Vec<Rgb<f32>> {
    lobe::env::reconstruct(f, map.width(), map.height()).texels().to_vec()
}

/// The energy of an expansion over all bands and channels, `∫ f² ds`.
pub(crate) fn energy(f: &ShVec<Rgb<f64>>) -> f64 {
    let e = f.dot(f);
    e.r + e.g + e.b
}

/// `|f - g| / |g|`.
pub(crate) fn relative(f: &ShVec<Rgb<f64>>, g: &ShVec<Rgb<f64>>) -> f64 {
    (energy(&(f - g))).sqrt() / energy(g).sqrt()
}
