//! Environments by name.

use std::path::Path;
use std::sync::Arc;

use anyhow::Context as _;
use lobe::env::{
    EnvError, EnvMap, Ground, MappedMap, PreethamSky, SceneLight, Sky as _, SunChoice, project_map, read_map,
    read_map_bytes, reconstruct, sky_map,
};
use lobe::image::FileFormat;
use lobe::prt::Transfer;
use lobe::sh::expansion::Quantity;
use lobe::sh::sh_json::{ShFile, read_sh_json, read_sh_json_bytes};
use lobe::sh::{Dir, Rgb, ShVec};
use lobe_gpu::{Context, Environment};

use crate::loading::limits::{ReadLimits, plain};
use crate::loading::place::given;
use crate::loading::shrunk::shrunk;
use crate::loading::task::Control;

/// The sky that the window opens with.
pub(crate) const FIRST: &str = "made:evening";

/// The skies that need no file, and their names for people.
pub(crate) const BUILT_IN: [(&str, &str); 5] = [
    ("made:evening", "Evening"),
    ("made:noon", "Noon"),
    ("bundled:sunset", "Sunset by the sea"),
    ("bundled:studio", "Studio"),
    ("made:even", "Even white"),
];

/// The ending of files of expansions, whose radiance is a sky too.
const EXPANSION: &str = ".sh.json";

/// Rows of the picture of an expansion: projected again, band 7 is back to 10⁻⁴ ([`reconstruct`]).
const EXPANSION_HEIGHT: usize = 512;

/// Rows of skies that are made by formula.
const MADE_HEIGHT: usize = 256;

/// Luminance of Preetham's sky in thousands of candela per square meter becomes radiance near 1.
const SKY_SCALE: f64 = 0.06;

/// The sun that is drawn into a made sky: wider than the real one, so that a few texels show it, with an irradiance that is a
/// multiple of the sky's own.
const SUN_HALF_ANGLE: f64 = 0.035;

/// An environment map with the name it has for people.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct OpenedSky {
    /// The name for people.
    pub name: String,
    /// The map.
    pub map: Arc<MappedMap>,
    /// Its expansion, of the highest order of the window.
    pub light: Arc<ShVec<Rgb<f64>>>,
    /// The same in two parts: suns, and the expansion of the rest.
    pub(crate) split: Arc<SceneLight>,
    /// The suns that are looked for in the map.
    pub(crate) choice: SunChoice,
    /// The map for a device to show: the same, or one in fewer texels where textures there have not as many.
    pub(crate) shown: Arc<MappedMap>,
}

/// Whether a file is an environment, by its name: a picture, a folder with the faces of a cube, or an expansion.
pub(crate) fn is_sky(path: &Path) -> bool {
    FileFormat::of_name(path).is_some() || path.is_dir() || is_expansion(path)
}

/// Whether a file is an expansion, by its name.
pub(crate) fn is_expansion(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().to_ascii_lowercase().ends_with(EXPANSION))
}

/// The radiance of an expansion as a picture; below zero where it rings.
fn open_expansion(source: &Path, name: &str) -> anyhow::Result<MappedMap> {
    let file = read_expansion(source)?;
    if file.quantity != Quantity::Radiance {
        anyhow::bail!("{name}: expected the radiance of surroundings, found {}", file.quantity);
    }
    Ok(reconstruct(&file.coefficients.to_rgb(), 2 * EXPANSION_HEIGHT, EXPANSION_HEIGHT).into())
}

/// Reads an environment: a picture file, an expansion of radiance (.sh.json), a folder with the six faces of a cube, `bundled:NAME`, or `made:NAME` with evening, noon or even, which are made by formula.
///
/// # Errors
/// One line that says what is wrong with the file or the name.
pub fn open_sky(source: &Path, limits: &ReadLimits) -> anyhow::Result<OpenedSky> {
    open_sky_with(source, limits, &SunChoice::None)
}

/// The same with suns beside the expansion, as [`SceneLight::of_map`].
pub(crate) fn open_sky_with(source: &Path, limits: &ReadLimits, suns: &SunChoice) -> anyhow::Result<OpenedSky> {
    let (name, map) = read_sky(source, limits)?;
    OpenedSky::of(name, map).with_suns(source, suns)
}

/// The name and the map of an environment, which is expanded after that.
pub(crate) fn read_sky(source: &Path, limits: &ReadLimits) -> anyhow::Result<(String, MappedMap)> {
    let text = source.to_string_lossy().into_owned();
    let title = BUILT_IN.iter().find(|(name, _)| *name == text).map(|(_, title)| (*title).to_owned());
    let name = title.unwrap_or_else(|| source.file_name().unwrap_or_default().to_string_lossy().into_owned());
    let map = match text.strip_prefix("made:") {
        Some("evening") => made_sky(1.32, 0.6, 16.0, [1.0, 0.62, 0.3])?.into(),
        Some("noon") => made_sky(0.6, 0.6, 16.0, [1.0, 0.95, 0.86])?.into(),
        Some("even") => EnvMap::from_fn(16, 8, |_| Rgb::new(1.0, 1.0, 1.0)).into(),
        Some(_) => anyhow::bail!("{text}: there is no such sky; there are made:evening, made:noon and made:even"),
        None if is_expansion(source) => open_expansion(source, &name)?,
        None => match given(source) {
            Some(bytes) => read_map_bytes(&bytes, &name, &limits.map()).map_err(plain)?.0.into_base(),
            None => read_map(source, &limits.map()).map_err(plain)?.0.into_base(),
        },
    };
    Ok((name, map))
}

impl OpenedSky {
    /// A map with its expansion, which is made now.
    pub(crate) fn of(name: String, map: MappedMap) -> Self {
        let light = Arc::new(project_map(&map, Transfer::MAX_ORDER));
        let (map, split) = (Arc::new(map), Arc::new(SceneLight::from((*light).clone())));
        Self { name, shown: map.clone(), map, light, split, choice: SunChoice::None }
    }

    /// The same with suns beside the expansion of the rest; those of a file of an expansion are not looked for.
    fn with_suns(self, source: &Path, suns: &SunChoice) -> anyhow::Result<Self> {
        let (split, choice) = if is_expansion(source) {
            (SceneLight::of_expansion((*self.light).clone(), suns), SunChoice::None)
        } else if *suns == SunChoice::None {
            return Ok(self);
        } else {
            (SceneLight::of_map(&self.map, Transfer::MAX_ORDER, suns), suns.clone())
        };
        Ok(Self { split: Arc::new(split.context("--suns")?), choice, ..self })
    }

    /// The map without the suns that stand apart, which are taken out now: what shiny surfaces reflect beside them.
    ///
    /// # Errors
    /// As [`SceneLight::of_map_with_rest`].
    pub(crate) fn without_suns(&self) -> Result<Arc<MappedMap>, EnvError> {
        if self.split.suns().is_empty() || self.choice == SunChoice::None {
            return Ok(self.map.clone());
        }
        // Of the light no band is needed.
        let (_, rest) = SceneLight::of_map_with_rest((*self.map).clone(), 1, &self.choice)?;
        Ok(Arc::new(rest))
    }

    /// The suns of the sky, and the expansion of the rest to an order.
    pub(crate) fn split_to(&self, order: usize) -> SceneLight {
        SceneLight::new(self.split.rest().resized(order), self.split.suns().to_vec())
    }

    /// The same for a device whose textures have at most so many texels along each side.
    fn shown_within(self, most: usize) -> Self {
        match shrunk(&self.map, most) {
            Some(smaller) => Self { shown: Arc::new(smaller), ..self },
            None => self,
        }
    }
}

/// A clear sky over a gray ground, with a sun whose irradiance is `strength` times the sky's.
fn made_sky(theta: f64, phi: f64, strength: f64, tint: [f64; 3]) -> anyhow::Result<EnvMap> {
    let sky = PreethamSky::new(3.0, Dir::from_angles(theta, phi))?;
    let sun = sky.sun();
    let horizontal = std::f64::consts::PI * SKY_SCALE * 4.0;
    let disc = std::f64::consts::TAU * (1.0 - SUN_HALF_ANGLE.cos());
    let radiance = Rgb::from(tint.map(|c| c * strength * horizontal / (4.0 * disc)));
    let ground = Ground { albedo: Rgb::new(0.22, 0.2, 0.18), sun: Rgb::from(tint.map(|c| c * 6.0)) };
    let map = sky_map(&sky, &ground, 2 * MADE_HEIGHT, MADE_HEIGHT);
    let cos = SUN_HALF_ANGLE.cos();
    // Saturated blue has a negative channel, which is no light.
    let positive = |c: f32| f64::from(c.max(0.0)) * SKY_SCALE;
    Ok(EnvMap::from_fn(2 * MADE_HEIGHT, MADE_HEIGHT, |s| {
        let Rgb { r, g, b } = map.radiance(s);
        let sky = Rgb::new(positive(r), positive(g), positive(b));
        let all = if s.dot(sun) > cos { sky + radiance } else { sky };
        Rgb::new(all.r as f32, all.g as f32, all.b as f32)
    }))
}

/// Opens an environment beside the window, for textures of `most` texels along each side; between reading and expanding it can be stopped.
pub(crate) fn open(
    control: &Control<OpenedSky>,
    source: &Path,
    (limits, suns): (&ReadLimits, &SunChoice),
    most: usize,
) -> Result<(), String> {
    control.stage(format!("reading {}", source.file_name().unwrap_or_default().to_string_lossy()));
    let (name, map) = read_sky(source, limits).map_err(|error| error.to_string())?;
    if control.is_cancelled() {
        return Ok(());
    }
    control.stage(format!("expanding {name}, {} x {} texels", map.width(), map.height()));
    let opened = OpenedSky::of(name, map).with_suns(source, suns).map_err(|error| format!("{error:#}"))?;
    let opened = opened.shown_within(most);
    if !control.is_cancelled() {
        control.send(opened);
    }
    Ok(())
}

/// Reads an expansion of any quantity.
pub(crate) fn read_expansion(path: &Path) -> anyhow::Result<ShFile> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    Ok(match given(path) {
        Some(bytes) => read_sh_json_bytes(&bytes, &name)?,
        None => read_sh_json(path)?,
    })
}

/// A sky for a device to show, in fewer texels where a texture there has not as many, which takes time: in a window, that of
/// [`OpenedSky::shown`].
pub(crate) fn on_device(context: &Context, map: &MappedMap) -> Environment {
    match shrunk(map, context.max_texture_side() as usize) {
        Some(smaller) => Environment::from(&smaller),
        None => Environment::from(map),
    }
}

#[cfg(test)]
mod tests {
    use lobe::env::Mapping;

    use super::*;

    #[test]
    fn a_sky_is_shrunk_for_the_device_where_it_is_opened_and_keeps_its_map() {
        let map = MappedMap::from_fn(Mapping::Angular, 20, 20, |_| Rgb::new(1.0, 1.0, 1.0));
        let sky = OpenedSky::of("even".into(), map).shown_within(8);
        assert!(sky.shown.width() <= 8 && sky.map.width() == 20, "{} of {}", sky.shown.width(), sky.map.width());
        let same = sky.clone().shown_within(sky.map.width());
        assert!(Arc::ptr_eq(&same.shown, &sky.shown), "what fits is shared");
    }
}
