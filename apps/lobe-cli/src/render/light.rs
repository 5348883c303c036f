//! Light options of `lobe render`: a map or an expansion, its order, window and rotation.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{anyhow, bail};
use clap::Args;
use lobe::env::{EnvMap, SceneLight, Sun, SunChoice, read_suns};
use lobe::render::{Backdrop, Background, DistantLight};
use lobe::sh::expansion::Quantity;
use lobe::sh::sh_json::read_sh_json;
use lobe::sh::{Dir, Expansion as _, Rgb, Rotation, ShVec, Window};

use crate::args::input::without_options;
use crate::args::map_input::{MapInput, OF_MAP};
use crate::args::memory::MemoryLimit;
use crate::args::values;
use crate::run::talk::Talk;

/// Advice on a map that is too large or has pixels that are no numbers.
const CONVERT_FIRST: [&str; 2] =
    ["make it smaller with lobe env convert --max-texels", "lobe env convert --nonfinite zero makes them black"];

/// What lights the scene.
#[derive(Args)]
pub(crate) struct LightInput {
    /// The light: an environment map as for lobe project, bundled:NAME, or an expansion of radiance, a .sh.json file
    #[arg(long, value_name = "ENV")]
    env: PathBuf,
    /// Turn the light about +z by this angle, counterclockwise seen from above
    #[arg(long, value_name = "DEG", default_value = "0", allow_hyphen_values = true, value_parser = values::finite)]
    rotate_light: f64,
}

/// The expansion of the light.
#[derive(Args, Default)]
pub(crate) struct ExpansionInput {
    /// Light with the expansion of this order, 1 to 256 (transfer goes to 8) [default: of trace the map itself, of
    /// irradiance 3, else that of the transfer, or 4; a .sh.json file has its own]
    #[arg(long, value_name = "N", value_parser = values::order)]
    pub(crate) order: Option<usize>,
    /// A window for the expansion against ringing: hanning[:BAND], lanczos[:BAND[:POWER]], sinc4[:BAND] reach zero at that band
    /// [default: the order]; gauss:DEGREES; laplacian:PART leaves that part of the squared Laplacian
    #[arg(long, value_name = "KIND", value_parser = window)]
    window: Option<WindowKind>,
}

/// Suns of the light.
#[derive(Args, Default)]
pub(crate) struct SunInput {
    /// Suns that cast shadows by themselves, beside the expansion: auto finds in a map up to four, each of half a
    /// percent of its light at least; a number takes so many at most; a .json file of lobe env sun --json adds its
    /// own. A map that paths look up without --order keeps those that it has
    #[arg(long, value_name = "auto|none|N|FILE", default_value_t)]
    suns: SunChoice,
}

impl SunInput {
    /// All light in the expansion.
    pub(crate) fn none() -> Self {
        Self { suns: SunChoice::None }
    }

    /// Whether no suns are asked for.
    pub(crate) fn are_none(&self) -> bool {
        self.suns == SunChoice::None
    }

    /// The number of suns that is asked for.
    pub(crate) fn count(&self) -> Option<usize> {
        match self.suns {
            SunChoice::Count(count) => Some(count),
            _ => None,
        }
    }

    /// The suns of the file, if one is given.
    pub(crate) fn given(&self) -> anyhow::Result<Vec<Sun>> {
        match self.path() {
            Some(path) => read_suns(path).map_err(|error| anyhow!("--suns: {error}")),
            None => Ok(Vec::new()),
        }
    }

    /// Refuses to look for suns in a map if that takes more memory than allowed: a second map, of the sky without them.
    pub(crate) fn check_memory(
        &self,
        input: &LightInput,
        light: &ReadLight,
        memory: &MemoryLimit,
    ) -> anyhow::Result<()> {
        match &light.map {
            Some(map) if self.suns.looks() => {
                MapInput::of(input.path(), memory).check_work("looking for suns in", map, 2 * OF_MAP)
            }
            _ => Ok(()),
        }
    }

    /// Notes which suns of a map stand apart, that they are fewer than was asked for, or that others come on top of
    /// them.
    pub(crate) fn note(&self, split: &SceneLight, light: &ReadLight, name: &str, talk: Talk) {
        let suns = split.suns();
        if self.path().is_some() && light.has_sun() {
            talk.note(name, "has a sun of its own beside those of --suns; lobe env sun takes it out of the map");
        }
        if let Some(count) = self.count().filter(|count| suns.len() < *count) {
            let found = suns.len();
            talk.note(name, &format!("{found} of {count} suns were found; lobe env sun --count {count} says why"));
        }
        if suns.is_empty() || !self.suns.looks() {
            return;
        }
        note_apart(suns, split.mean().luminance(), name, talk);
    }

    /// The choice itself.
    pub(crate) fn choice(&self) -> &SunChoice {
        &self.suns
    }

    /// The file of suns, if one is given.
    pub(crate) fn path(&self) -> Option<&Path> {
        match &self.suns {
            SunChoice::File(path) => Some(path),
            _ => None,
        }
    }
}

/// Notes that suns of a map, whose mean luminance is that of all light, stand apart.
pub(crate) fn note_apart(suns: &[Sun], mean: f64, name: &str, talk: Talk) {
    let of_suns: f64 = suns.iter().map(|sun| sun.irradiance.luminance()).sum();
    // Negative texels may leave less light than the suns have.
    let percent = 100.0 * (of_suns / (4.0 * PI * mean)).clamp(0.0, 1.0);
    let (what, it) = match suns.len() {
        1 => ("a sun".to_owned(), "it"),
        count => (format!("{count} suns"), "them"),
    };
    let stands = if suns.len() == 1 { "stands" } else { "stand" };
    let text = format!("{what} of {percent:.0} % of the light {stands} apart; --suns none leaves {it} with the rest");
    talk.note(name, &text);
}

/// A window whose width may depend on the expansion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum WindowKind {
    Hanning(Option<f64>),
    /// The power of the sigma factors, and the band.
    Lanczos(f64, Option<f64>),
    /// Degrees.
    Gauss(f64),
    /// The part that is left.
    Laplacian(f64),
}

fn window(text: &str) -> Result<WindowKind, String> {
    let (kind, rest) = text.split_once(':').map_or((text, None), |(kind, rest)| (kind, Some(rest)));
    if let ("lanczos", Some((band, power))) = (kind, rest.and_then(|rest| rest.split_once(':'))) {
        return Ok(WindowKind::Lanczos(values::positive(power)?, Some(values::positive(band)?)));
    }
    match (kind, rest.map(values::positive).transpose()?) {
        ("hanning", band) => Ok(WindowKind::Hanning(band)),
        ("lanczos", band) => Ok(WindowKind::Lanczos(1.0, band)),
        ("sinc4", band) => Ok(WindowKind::Lanczos(4.0, band)),
        ("gauss", Some(degrees)) => Ok(WindowKind::Gauss(degrees)),
        ("laplacian", Some(part)) if part <= 1.0 => Ok(WindowKind::Laplacian(part)),
        ("gauss", None) => Err("expected the standard deviation in degrees, such as gauss:20".to_owned()),
        ("laplacian", _) => Err("expected the part that is left, up to 1, such as laplacian:0.5".to_owned()),
        _ => Err(format!("expected hanning, lanczos, sinc4, gauss or laplacian, found {kind:?}")),
    }
}

/// The light as suns and an expansion, and its map without the suns.
pub(crate) struct Split {
    pub(crate) light: SceneLight,
    /// None of an expansion.
    pub(crate) rest: Option<EnvMap>,
}

/// The light as it was read.
pub(crate) struct ReadLight {
    map: Option<Arc<EnvMap>>,
    expansion: Option<ShVec<Rgb<f64>>>,
}

impl LightInput {
    pub(crate) fn path(&self) -> &Path {
        &self.env
    }

    /// Reads the light, whose file takes no more memory than allowed.
    pub(crate) fn read(&self, memory: &MemoryLimit, talk: Talk) -> anyhow::Result<ReadLight> {
        let name = self.env.display().to_string();
        if !self.is_expansion() {
            let read = MapInput::of(&self.env, memory).read_lat_long(talk);
            let map = read.map_err(|error| without_options(error, CONVERT_FIRST))?;
            return Ok(ReadLight { map: Some(Arc::new(map)), expansion: None });
        }
        let file = read_sh_json(&self.env)?;
        if file.quantity != Quantity::Radiance {
            bail!("{name}: expected radiance, found {}; light is what arrives, not what it does", file.quantity);
        }
        Ok(ReadLight { map: None, expansion: Some(file.coefficients.to_rgb()) })
    }

    /// Refuses an expansion where light is looked up in a map.
    pub(crate) fn expect_map(&self) -> anyhow::Result<()> {
        if self.is_expansion() {
            let name = self.env.display();
            bail!("{name}: lobe render maps looks light up in a map; lobe env reconstruct makes one of an expansion");
        }
        Ok(())
    }

    /// Whether the file holds an expansion.
    fn is_expansion(&self) -> bool {
        self.env.display().to_string().ends_with(".json")
    }

    /// The turn of frame `k` of `frames`, which together go around once.
    pub(crate) fn turn(&self, k: usize, frames: usize) -> Rotation {
        let degrees = self.rotate_light + 360.0 * k as f64 / frames as f64;
        Rotation::from_axis_angle(Dir::Z, degrees.rem_euclid(360.0).to_radians())
    }
}

impl ExpansionInput {
    /// Whether the light is an expansion in any case.
    pub(crate) fn is_asked_of(&self, light: &ReadLight) -> bool {
        light.map.is_none() || self.order.is_some() || self.window.is_some()
    }

    /// The suns of the light, and the expansion of the rest under its window; of the order asked for, its own, or
    /// `default`. With it the map of the rest, if that is wanted and the light is a map.
    pub(crate) fn of(
        &self,
        light: &ReadLight,
        default: usize,
        SunInput { suns }: &SunInput,
        wants_rest: bool,
    ) -> anyhow::Result<Split> {
        let split = match (&light.expansion, &light.map) {
            (Some(f), _) => {
                let f = f.resized(self.order.unwrap_or(f.order()));
                SceneLight::of_expansion(f, suns).map(|light| (light, None))
            }
            (None, Some(map)) => {
                let order = self.order.unwrap_or(default);
                match wants_rest {
                    true => SceneLight::of_map_with_rest((**map).clone().into(), order, suns)
                        .and_then(|(light, rest)| Ok((light, Some(rest.into_env_map()?)))),
                    false => SceneLight::of_map(map, order, suns).map(|light| (light, None)),
                }
            }
            (None, None) => unreachable!("a light is a map or an expansion"),
        };
        let (split, rest) = split.map_err(|error| anyhow!("--suns: {error}"))?;
        let order = split.rest().order() as f64;
        let window = match self.window {
            None => return Ok(Split { light: split, rest }),
            Some(WindowKind::Hanning(band)) => Window::Hanning { width: band.unwrap_or(order) },
            Some(WindowKind::Lanczos(power, band)) => Window::Lanczos { width: band.unwrap_or(order), power },
            Some(WindowKind::Gauss(degrees)) => Window::Gauss { sigma: degrees.to_radians() },
            Some(WindowKind::Laplacian(part)) => Window::squared_laplacian_of(split.rest().coefficients(), part),
        };
        Ok(Split { light: split.windowed(&window), rest })
    }
}

impl ReadLight {
    /// Whether it is a map with a sun that stands apart unless that is asked for otherwise.
    pub(crate) fn has_sun(&self) -> bool {
        let split = |map: &EnvMap| SceneLight::of_map(map, 1, &SunChoice::Auto);
        self.map().and_then(|map| split(map).ok()).is_some_and(|split| !split.suns().is_empty())
    }

    /// The map; none if the light is an expansion.
    pub(crate) fn map(&self) -> Option<&EnvMap> {
        self.map.as_deref()
    }

    /// What the eye sees behind the scene.
    pub(crate) fn backdrop(&self, background: Background) -> Backdrop {
        background.backdrop(self.map.as_ref(), self.expansion.as_ref())
    }

    /// The light before it was made an expansion.
    pub(crate) fn as_it_is(&self) -> DistantLight {
        match (&self.map, &self.expansion) {
            (Some(map), _) => DistantLight::from_map(map.clone()),
            (None, Some(f)) => DistantLight::from_expansion(f.clone()),
            (None, None) => unreachable!("a light is a map or an expansion"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_have_a_kind_and_a_number() {
        assert_eq!(window("hanning"), Ok(WindowKind::Hanning(None)), "hanning");
        assert_eq!(window("sinc4:8"), Ok(WindowKind::Lanczos(4.0, Some(8.0))), "sinc4");
        assert_eq!(window("lanczos:8"), Ok(WindowKind::Lanczos(1.0, Some(8.0))), "lanczos");
        assert_eq!(window("lanczos:8:2.5"), Ok(WindowKind::Lanczos(2.5, Some(8.0))), "lanczos with a power");
        assert_eq!(window("gauss:12.5"), Ok(WindowKind::Gauss(12.5)), "gauss");
        assert_eq!(window("laplacian:0.5"), Ok(WindowKind::Laplacian(0.5)), "laplacian");
        let bad =
            ["gauss", "laplacian", "laplacian:2", "hanning:0", "hanning:x", "hanning:4:2", "lanczos:4:0", "lanczos::2"];
        for bad in bad.into_iter().chain(["lanczos:4:2:1", "box", ""]) {
            assert!(window(bad).is_err(), "{bad:?}");
        }
    }
}
