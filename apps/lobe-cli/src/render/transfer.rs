//! Transfer to render with: read from a baked file, or baked on the way.

use std::path::{Path, PathBuf};

use anyhow::bail;
use lobe::env::DfgTable;
use lobe::prt::{
    AnyTransfer, BakeOptions, Baked, Lightmap, Mode, Receivers, Transfer, TransferMatrices, bake, bake_matrices,
    read_any_transfer, read_baked_within, read_lightmap, read_matrices,
};
use lobe::render::{Camera, SceneHit, ViewOptions};
use lobe::scene::{Bvh, ReadOptions, Scene, read_scene_and_attributes};
use lobe::sh::{Coefficient as _, Expansion as _, Rgb, ShVec, Zonal, convolved};
use rayon::prelude::*;
use serde_json::Value;

use crate::args::memory::MemoryLimit;
use crate::args::scene_input::SceneInput;
use crate::args::values;
use crate::render::backs::{Backs, seen_from_behind};
use crate::run::bake_watch::watched;
use crate::run::talk::Talk;

/// What to do where a bake takes long.
const BAKE_FIRST: &str = "lobe bake can be stopped and continued, and what it writes can be rendered";

/// Cosines and roughnesses of the table of reflectances, which are then within a hundredth but for grazing views.
const DFG_SIZE: usize = 64;

/// What transfer is asked for.
pub(crate) struct Asked {
    pub(crate) mode: Mode,
    pub(crate) order: Option<usize>,
    pub(crate) samples: Option<usize>,
    pub(crate) bounces: Option<usize>,
    /// The lobe of glossy surfaces; without one they are matte.
    pub(crate) lobe: Option<Lobe>,
    /// Where transfer is that was baked before.
    pub(crate) file: Option<PathBuf>,
}

/// A lobe of reflection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Lobe {
    /// By its exponent.
    Phong(f64),
    /// By α.
    Ggx(f64),
}

impl Lobe {
    fn zonal(self, order: usize) -> Zonal {
        match self {
            Self::Phong(exponent) => Zonal::phong(order, exponent),
            Self::Ggx(alpha) => Zonal::ggx(order, alpha),
        }
    }

    fn reflectance(self) -> Reflectance {
        match self {
            Self::Phong(_) => Reflectance::Base,
            Self::Ggx(alpha) => Reflectance::Microfacets(DfgTable::new(DFG_SIZE), alpha.sqrt()),
        }
    }
}

/// Reads `phong:E` or `ggx:ALPHA`.
pub(crate) fn parse_lobe(text: &str) -> Result<Lobe, String> {
    let expected = "expected phong:E with an exponent of 0 or more, or ggx:ALPHA with 0 to 1";
    let (kind, number) = text.split_once(':').ok_or(expected)?;
    match (kind, values::finite(number)?) {
        ("phong", exponent) if exponent >= 0.0 => Ok(Lobe::Phong(exponent)),
        ("ggx", alpha) if (0.0..=1.0).contains(&alpha) => Ok(Lobe::Ggx(alpha)),
        _ => Err(expected.to_owned()),
    }
}

/// What the places of a scene do to light.
pub(crate) struct SceneTransfer {
    places: Places,
    front: Response,
    /// Of as many places as are seen from behind.
    back: Option<Backs>,
    /// How glossy surfaces reflect; none where they are matte.
    shine: Option<(Lobe, Reflectance)>,
    /// What the front was baked with.
    options: BakeOptions,
    /// Where it was read; none if it was baked on the way.
    file: Option<String>,
}

/// Where transfer is known.
pub(crate) enum Places {
    Vertices,
    Texels(Lightmap),
}

impl Places {
    /// The places around what is seen, and how much it shows of each.
    pub(crate) fn around(&self, scene: &Scene, hit: &SceneHit<'_>) -> [(usize, f64); 4] {
        match self {
            Self::Vertices => {
                let [a, b, c] = hit.corners();
                [a, b, c, (a.0, 0.0)]
            }
            Self::Texels(lightmap) => lightmap.texels_at(scene, hit.hit()),
        }
    }
}

/// What receivers do to light.
pub(crate) enum Response {
    Matte(AnyTransfer),
    Glossy(TransferMatrices),
}

/// What receivers send back of one light.
enum Sent {
    Matte(Vec<Rgb<f32>>),
    /// The light that arrives, blurred by the lobe: its value in the mirrored direction is what is sent.
    Glossy(Vec<ShVec<Rgb<f64>>>),
}

/// A scene under one light.
pub(crate) struct Lit<'a> {
    scene: &'a Scene,
    transfer: &'a SceneTransfer,
    front: Sent,
    back: Option<(&'a Backs, Sent)>,
}

/// The part of the light that a glossy surface sends back.
pub(crate) enum Reflectance {
    /// The base color.
    Base,
    /// What microfacets of this roughness reflect of even light, their color along the normal the base color.
    Microfacets(DfgTable, f64),
}

impl Reflectance {
    fn of(&self, hit: &SceneHit<'_>) -> Rgb<f64> {
        match self {
            Self::Base => hit.albedo,
            Self::Microfacets(table, roughness) => {
                table.lookup(hit.normal.dot(hit.view).max(0.0), *roughness).reflectance(hit.albedo)
            }
        }
    }
}

impl SceneTransfer {
    pub(crate) fn order(&self) -> usize {
        self.front.order()
    }

    /// Bakes the backs of double-sided surfaces, as far as this view shows them: files hold none.
    pub(crate) fn bake_backs(
        &mut self,
        scene: &Scene,
        bvh: &Bvh,
        camera: &Camera,
        view: &ViewOptions,
        memory: &MemoryLimit,
        talk: Talk,
    ) -> anyhow::Result<()> {
        let seen = seen_from_behind(scene, bvh, camera, view, &self.places, talk)?;
        if seen.is_empty() {
            return Ok(());
        }
        check_memory(memory, scene, seen.len(), &self.options, self.shine.is_some())?;
        if let Some(file) = &self.file {
            let (count, options) = (seen.len(), &self.options);
            let places = if matches!(self.places, Places::Vertices) { "vertices" } else { "texels" };
            let text = format!(
                "holds fronts of surfaces; the backs of {count} {places}, which are seen, are baked now from {} paths each",
                options.samples
            );
            talk.note(file, &text);
        }
        let is_glossy = self.shine.is_some();
        self.back = Some(Backs::bake(scene, bvh, &self.places, &seen, &self.options, is_glossy, talk)?);
        Ok(())
    }

    pub(crate) fn lit<'a>(&'a self, scene: &'a Scene, light: &ShVec<Rgb<f64>>) -> Lit<'a> {
        let sent = |response: &Response| response.sent(light, self.shine.as_ref().map(|(lobe, _)| *lobe));
        let back = self.back.as_ref().map(|backs| (backs, sent(&backs.response)));
        Lit { scene, transfer: self, front: sent(&self.front), back }
    }
}

impl Response {
    /// Bakes it at some receivers.
    pub(crate) fn bake(
        scene: &Scene,
        bvh: &Bvh,
        receivers: &Receivers,
        options: &BakeOptions,
        is_glossy: bool,
        talk: Talk,
    ) -> anyhow::Result<Self> {
        let baked = watched(talk, "bake", |show| {
            if is_glossy {
                bake_matrices(scene, bvh, receivers, options, show).map(|(matrices, _)| Self::Glossy(matrices))
            } else {
                bake(scene, bvh, receivers, options, show).map(|(transfer, _)| Self::Matte(transfer.into()))
            }
        })?;
        baked.or_else(|_| bail!("stopped while transfer was baked, of which nothing is kept; {BAKE_FIRST}"))
    }

    fn order(&self) -> usize {
        match self {
            Self::Matte(transfer) => transfer.order(),
            Self::Glossy(matrices) => matrices.order(),
        }
    }

    /// Matrices are told the lobe.
    fn sent(&self, light: &ShVec<Rgb<f64>>, lobe: Option<Lobe>) -> Sent {
        match (self, lobe) {
            (Self::Matte(transfer), _) => Sent::Matte(transfer.exit_radiance(light.coefficients())),
            (Self::Glossy(matrices), Some(lobe)) => {
                let zonal = lobe.zonal(matrices.order());
                let blurred = |p| convolved(&matrices.incident(p, light.coefficients()), &zonal);
                Sent::Glossy((0..matrices.points()).into_par_iter().map(blurred).collect())
            }
            (Self::Glossy(_), None) => unreachable!("matrices are baked for a lobe"),
        }
    }
}

impl Sent {
    fn of(&self, receiver: usize, hit: &SceneHit<'_>) -> Rgb<f64> {
        match self {
            Self::Matte(values) => values[receiver].widen(),
            Self::Glossy(blurred) => blurred[receiver].eval(hit.reflected()),
        }
    }
}

impl Lit<'_> {
    /// What is seen of a place, between vertices or texels.
    pub(crate) fn radiance(&self, hit: &SceneHit<'_>) -> Rgb<f64> {
        let (sent, backs) = match &self.back {
            _ if hit.is_front => (&self.front, None),
            Some((backs, sent)) => (sent, Some(backs)),
            None => unreachable!("backs were baked for the rays of this picture"),
        };
        let mut sum = Rgb::ZERO;
        for (place, part) in self.transfer.places.around(self.scene, hit) {
            let receiver = backs.map_or(place, |backs| backs.receiver(place));
            sum += sent.of(receiver, hit).scale(part);
        }
        match &self.transfer.shine {
            Some((_, reflectance)) => reflectance.of(hit) * sum,
            None => sum,
        }
    }
}

/// Reads a scene that was baked, or a file of transfer beside a scene, or reads and bakes a scene.
pub(crate) fn prepare(
    input: &SceneInput,
    asked: &Asked,
    memory: &MemoryLimit,
    talk: Talk,
) -> anyhow::Result<(Scene, Bvh, SceneTransfer)> {
    if let Some(order) = asked.order.filter(|&order| order > Transfer::MAX_ORDER) {
        bail!("--order: transfer has an order of 1 to {}, found {order}", Transfer::MAX_ORDER);
    }
    let (scene, transfer) = match (&asked.file, input.gltf_file()) {
        (Some(file), _) => read_beside(input, file, asked, talk)?,
        (None, Some(path)) if asked.lobe.is_none() && is_baked(path, &input.options())? => {
            read(input, path, asked, talk)?
        }
        _ => return bake_now(input, asked, memory, talk),
    };
    let bvh = Bvh::new(&scene);
    Ok((scene, bvh, transfer))
}

fn is_baked(path: &Path, options: &ReadOptions) -> anyhow::Result<bool> {
    let (_, _, attributes) = read_scene_and_attributes(path, options)?;
    Ok(!attributes.asset_extras()["lobe"].is_null())
}

fn read(input: &SceneInput, path: &Path, asked: &Asked, talk: Talk) -> anyhow::Result<(Scene, SceneTransfer)> {
    let name = input.name();
    let Baked { scene, transfer, recipe, report, .. } = read_baked_within(path, &input.options())?;
    for note in &report.notes {
        talk.note(&name, note);
    }
    asked.check(&name, &recipe, transfer.order())?;
    Ok((scene, asked.of_file(name, &recipe, Places::Vertices, Response::Matte(transfer.into()))))
}

/// A scene, and its transfer from a file that `lobe bake` wrote without the scene.
fn read_beside(input: &SceneInput, file: &Path, asked: &Asked, talk: Talk) -> anyhow::Result<(Scene, SceneTransfer)> {
    let name = file.display().to_string();
    let scene = input.read(talk)?;
    let vertices = scene.vertex_count();
    let check_vertices = |found: usize| match found == vertices {
        true => Ok(()),
        false => bail!("{name}: expected transfer of {vertices} vertices as {} has, found {found}", input.name()),
    };
    if asked.lobe.is_some() {
        let (matrices, recipe) = read_matrices(file)?;
        asked.check(&name, &recipe, matrices.order())?;
        check_vertices(matrices.points())?;
        return Ok((scene, asked.of_file(name, &recipe, Places::Vertices, Response::Glossy(matrices))));
    }
    let is_picture = file.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr"));
    let (transfer, recipe) = if is_picture {
        let (transfer, recipe) = read_lightmap(file)?;
        (transfer.into(), recipe)
    } else {
        read_any_transfer(file)?
    };
    asked.check(&name, &recipe, transfer.order())?;
    let width = transfer.receivers().isqrt();
    let places = if is_picture || recipe["texels"] == width {
        Places::Texels(Lightmap::new(&scene, width)?)
    } else {
        check_vertices(transfer.receivers())?;
        Places::Vertices
    };
    Ok((scene, asked.of_file(name, &recipe, places, Response::Matte(transfer))))
}

impl Asked {
    /// Refuses options that cannot be had of transfer that was baked before.
    fn check(&self, name: &str, recipe: &Value, order: usize) -> anyhow::Result<()> {
        for (option, is_given) in [("--bake-samples", self.samples.is_some()), ("--bounces", self.bounces.is_some())] {
            if is_given {
                bail!("{option}: {name} is baked already; leave the option out, or render the scene it was baked from");
            }
        }
        let wanted = if self.lobe.is_some() { "glossy" } else { mode_name(self.mode) };
        // A recipe that does not say is believed.
        let found = recipe["mode"].as_str().unwrap_or(wanted);
        if found != wanted {
            bail!("--mode {wanted}: {name} was baked as {found}; ask for that, or render the scene it was baked from");
        }
        if let Some(asked) = self.order.filter(|&asked| asked > order) {
            bail!("--order {asked}: {name} was baked to order {order}; bake it to a higher one");
        }
        Ok(())
    }

    /// Transfer as it was read. Its recipe says how backs are baked: as its fronts were.
    fn of_file(&self, name: String, recipe: &Value, places: Places, front: Response) -> SceneTransfer {
        let defaults = BakeOptions::default().mode(self.mode).order(front.order());
        let number = |key: &str| recipe[key].as_u64();
        let options = defaults
            .clone()
            .samples(number("samples").and_then(|n| u32::try_from(n).ok()).unwrap_or(defaults.samples))
            .bounces(number("bounces").and_then(|n| usize::try_from(n).ok()).unwrap_or(defaults.bounces))
            .energy_stop(recipe["energy_stop"].as_f64().unwrap_or(defaults.energy_stop))
            .seed(number("seed").unwrap_or(defaults.seed));
        SceneTransfer { places, front, back: None, shine: self.shine(), options, file: Some(name) }
    }

    fn shine(&self) -> Option<(Lobe, Reflectance)> {
        self.lobe.map(|lobe| (lobe, lobe.reflectance()))
    }
}

fn bake_now(
    input: &SceneInput,
    asked: &Asked,
    memory: &MemoryLimit,
    talk: Talk,
) -> anyhow::Result<(Scene, Bvh, SceneTransfer)> {
    let scene = input.read(talk)?;
    let defaults = BakeOptions::default();
    let options = defaults
        .clone()
        .mode(asked.mode)
        .order(asked.order.unwrap_or(defaults.order))
        .samples(asked.samples.map_or(defaults.samples, |n| n as u32))
        .bounces(asked.bounces.unwrap_or(defaults.bounces));
    check_memory(memory, &scene, scene.vertex_count(), &options, asked.lobe.is_some())?;
    let (receivers, bvh) = (Receivers::at_vertices(&scene)?, Bvh::new(&scene));
    let front = Response::bake(&scene, &bvh, &receivers, &options, asked.lobe.is_some(), talk)?;
    let transfer =
        SceneTransfer { places: Places::Vertices, front, back: None, shine: asked.shine(), options, file: None };
    Ok((scene, bvh, transfer))
}

/// Refuses to bake what takes too much memory: rows of numbers that grow, and what they make of a light.
fn check_memory(
    memory: &MemoryLimit,
    scene: &Scene,
    count: usize,
    options: &BakeOptions,
    is_glossy: bool,
) -> anyhow::Result<()> {
    let (bands, channels) = (options.order.pow(2), options.channels_for(scene, scene.is_gray()).count());
    let (numbers, lit) = if is_glossy { (bands * bands, 3 * 8 * bands) } else { (bands, 3 * 4) };
    let bytes = ((2 * 4 * numbers * channels + lit) as u64).saturating_mul(count as u64);
    let what = format!("transfer of {count} vertices at order {}", options.order);
    memory.check(&what, bytes, "a lower --order")
}

fn mode_name(mode: Mode) -> &'static str {
    match mode {
        Mode::Unshadowed => "unshadowed",
        Mode::Shadowed => "shadowed",
        Mode::Interreflected => "interreflected",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lobes_have_a_kind_and_a_number() {
        assert_eq!(
            (parse_lobe("phong:20"), parse_lobe("ggx:0.25")),
            (Ok(Lobe::Phong(20.0)), Ok(Lobe::Ggx(0.25))),
            "lobes"
        );
        for bad in ["phong", "phong:-1", "ggx:2", "ggx:x", "box:1", ""] {
            assert!(parse_lobe(bad).is_err(), "{bad:?}");
        }
    }
}
