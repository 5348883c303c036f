//! The light of a scene in two parts: suns, and the rest as an expansion.

use std::f64::consts::PI;

use lobe_sh::light::Normalization;
use lobe_sh::{Coefficient as _, Dir, Expansion as _, Light, Rgb, Rotation, ShVec, Window};

use crate::error::EnvError;
use crate::map::mapped_map::MappedMap;
use crate::projection::project_map::project_map;
use crate::sky::sun_choice::SunChoice;
use crate::sky::sun_extraction::{Sun, SunOptions};
use crate::sky::sun_file::read_suns;
use crate::sky::suns::{SunsReport, extract_suns};

/// Distant light as suns, which cast shadows by themselves, and the rest, an expansion of radiance.
///
/// ```text
///   L(s) = Σᵢ restᵢ yᵢ(s) + Σ_suns E_sun / Ω_sun   where s lies in the sun's disc of solid angle Ω_sun
/// ```
///
/// An expansion of low order spreads a sun over the sky, and its shadow over the scene. A sun that is a light of its
/// own has a shadow as sharp as its disc is small. An expansion alone is a light without suns.
///
/// ```
/// use lobe_env::{SceneLight, SunChoice, bundled, irradiance_at};
/// use lobe_sh::Dir;
///
/// let sky = bundled::sunset().map();
/// let light = SceneLight::of_map(&sky, 4, &SunChoice::Auto)?;
/// assert!(!light.suns().is_empty());
/// let (found, expected) = (light.irradiance(Dir::Z), irradiance_at(&sky, &[Dir::Z])[0]);
/// assert!((found.g / expected.g - 1.0).abs() < 0.02, "{found:?} {expected:?}");
/// # Ok::<(), lobe_env::EnvError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SceneLight {
    rest: ShVec<Rgb<f64>>,
    suns: Vec<Sun>,
    /// Of the expansions of both.
    windows: Vec<Window>,
}

impl From<ShVec<Rgb<f64>>> for SceneLight {
    /// A light without suns.
    fn from(rest: ShVec<Rgb<f64>>) -> Self {
        Self::new(rest, Vec::new())
    }
}

impl SceneLight {
    /// Suns beside an expansion that does not hold them.
    #[must_use]
    pub fn new(rest: ShVec<Rgb<f64>>, suns: Vec<Sun>) -> Self {
        Self { rest, suns, windows: Vec::new() }
    }

    /// The light of a map: the suns that the choice takes out of it or adds, and the rest to `order` bands. A map from
    /// which nothing is taken is projected as by [`project_map`].
    ///
    /// # Errors
    /// [`EnvError::File`] if a file of suns cannot be read.
    pub fn of_map(map: &MappedMap, order: usize, choice: &SunChoice) -> Result<Self, EnvError> {
        match taken_out(map, choice) {
            Some(found) => Ok(Self::new(project_map(&found.rest, order), found.suns)),
            None => Self::of_expansion(project_map(map, order), choice),
        }
    }

    /// [`SceneLight::of_map`], and the map without the suns that were taken out: what mirrors show beside them.
    ///
    /// # Errors
    /// As [`SceneLight::of_map`].
    pub fn of_map_with_rest(map: MappedMap, order: usize, choice: &SunChoice) -> Result<(Self, MappedMap), EnvError> {
        match taken_out(&map, choice) {
            Some(found) => Ok((Self::new(project_map(&found.rest, order), found.suns), found.rest)),
            None => Ok((Self::of_expansion(project_map(&map, order), choice)?, map)),
        }
    }

    /// The light of an expansion, beside the suns of the choice; none are looked for in it.
    ///
    /// # Errors
    /// [`EnvError::Options`] if a number of suns is asked for, [`EnvError::File`] if a file of suns cannot be read.
    pub fn of_expansion(rest: ShVec<Rgb<f64>>, choice: &SunChoice) -> Result<Self, EnvError> {
        match choice {
            SunChoice::Count(count) if *count > 0 => {
                let text = "an expansion holds no suns that can be taken out; give a map, or a file of suns";
                Err(EnvError::Options(text.to_owned()))
            }
            SunChoice::File(path) => Ok(Self::new(rest, read_suns(path)?)),
            _ => Ok(rest.into()),
        }
    }

    /// The same with a window on its expansions, that of the suns too; suns themselves stay as they are.
    #[must_use]
    pub fn windowed(mut self, window: &Window) -> Self {
        self.rest = self.rest.windowed(window);
        self.windows.push(*window);
        self
    }

    /// The expansion of all but the suns.
    #[must_use]
    pub fn rest(&self) -> &ShVec<Rgb<f64>> {
        &self.rest
    }

    /// The suns.
    #[must_use]
    pub fn suns(&self) -> &[Sun] {
        &self.suns
    }

    /// The expansion of the suns' discs, of as many bands as [`SceneLight::rest`].
    #[must_use]
    pub fn of_suns(&self) -> ShVec<Rgb<f64>> {
        let mut all = ShVec::zero(self.rest.order());
        for sun in &self.suns {
            let Sun { direction: dir, irradiance, .. } = *sun;
            let half_angle = 0.5 * sun.angular_diameter;
            // A point where the disc is too small for its radiance to be a number.
            let disc = Light::Cone { dir, half_angle, color: sun.radiance() };
            let point = Light::Directional { dir, color: irradiance };
            let of_disc = disc.project(self.rest.order(), Normalization::None);
            all += &of_disc
                .or_else(|_| point.project(self.rest.order(), Normalization::None))
                .unwrap_or_else(|_| ShVec::zero(self.rest.order()));
        }
        self.windows.iter().fold(all, |all, window| all.windowed(window))
    }

    /// The expansion of all light.
    #[must_use]
    pub fn whole(&self) -> ShVec<Rgb<f64>> {
        if self.suns.is_empty() { self.rest.clone() } else { &self.rest + &self.of_suns() }
    }

    /// The light turned: what was towards `s` is towards `R s`.
    #[must_use]
    pub fn rotated(&self, rotation: &Rotation) -> Self {
        let turned = |sun: &Sun| Sun { direction: rotation.rotate_dir(sun.direction), ..*sun };
        let suns = self.suns.iter().map(turned).collect();
        Self { rest: self.rest.rotated(rotation), suns, windows: self.windows.clone() }
    }

    /// The mean radiance over all directions.
    #[must_use]
    pub fn mean(&self) -> Rgb<f64> {
        let suns = self.suns.iter().fold(Rgb::ZERO, |all: Rgb<f64>, sun| all + sun.irradiance);
        self.rest.mean() + suns.scale((4.0 * PI).recip())
    }

    /// The radiance from direction `s`.
    #[must_use]
    pub fn radiance(&self, s: Dir) -> Rgb<f64> {
        let of = |sun: &Sun| sun.direction.angle_to(s) <= 0.5 * sun.angular_diameter;
        self.suns.iter().filter(|sun| of(sun)).fold(self.rest.eval(s), |all, sun| all + sun.radiance())
    }

    /// The irradiance of a surface that faces `normal`, from which nothing is hidden.
    #[must_use]
    pub fn irradiance(&self, normal: Dir) -> Rgb<f64> {
        let rest = self.rest.convolved(&lobe_sh::Zonal::clamped_cosine(self.rest.order())).eval(normal);
        self.suns.iter().fold(rest, |all, sun| all + sun.irradiance_at(normal))
    }
}

/// The suns of a map that the choice takes out, and the rest of it; none if suns are not looked for.
fn taken_out(map: &MappedMap, choice: &SunChoice) -> Option<SunsReport> {
    let mut most = choice.most()?;
    let least = choice.least_part() * 4.0 * PI * map.mean().luminance().abs();
    loop {
        let found = extract_suns(map, most, &SunOptions::default());
        let is_bright = |sun: &Sun| sun.irradiance.luminance() >= least;
        // The last suns stay in the map if they are faint. A glint that is brighter than the sun has come before it.
        let count = found.suns.iter().rposition(is_bright).map_or(0, |last| last + 1);
        if count == found.suns.len() {
            return Some(found);
        }
        if count == 0 {
            return None;
        }
        most = count;
    }
}
