//! Transfer to render with: read from a baked file, or baked on the way.

use std::path::{Path, PathBuf};

use anyhow::bail;
use lobe::env::DfgTable;
use lobe::prt::{
    BakeOptions, Baked, Lightmap, Mode, Progress, PrtError, Receivers, Transfer, TransferMatrices, bake, bake_matrices,
    read_baked_within, read_lightmap, read_matrices, read_transfer,
};
use lobe::render::SceneHit;
use lobe::scene::{Bvh, ReadOptions, Scene, read_scene_and_attributes};
use lobe::sh::{Coefficient as _, Expansion as _, Rgb, ShVec, Zonal, convolved};
use rayon::prelude::*;
use serde_json::Value;

use crate::ctrl_c;
use crate::scene_input::SceneInput;
use crate::talk::Talk;
use crate::values;

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

/// A scene and what its places do to light.
pub(crate) struct Prepared {
    pub(crate) scene: Scene,
    transfer: SceneTransfer,
}

enum SceneTransfer {
    AtVertices(Transfer),
    AtTexels(Transfer, Lightmap),
    Glossy(TransferMatrices, Lobe, Reflectance),
}

/// What is sent back of one light.
pub(crate) enum Lit<'a> {
    AtVertices(Vec<Rgb<f32>>),
    AtTexels(Vec<Rgb<f32>>, &'a Lightmap, &'a Scene),
    /// The light that arrives at each vertex, blurred by the lobe: its value in the mirrored direction is what is sent.
    Glossy(Vec<ShVec<Rgb<f64>>>, &'a Reflectance),
}

/// The part of the light that a glossy surface sends back.
pub(crate) enum Reflectance {
    /// The base colour.
    Base,
    /// What microfacets of this roughness reflect of even light, their colour along the normal the base colour.
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

impl Prepared {
    pub(crate) fn order(&self) -> usize {
        match &self.transfer {
            SceneTransfer::AtVertices(transfer) | SceneTransfer::AtTexels(transfer, _) => transfer.order(),
            SceneTransfer::Glossy(matrices, ..) => matrices.order(),
        }
    }

    pub(crate) fn lit(&self, light: &ShVec<Rgb<f64>>) -> Lit<'_> {
        match &self.transfer {
            SceneTransfer::AtVertices(transfer) => Lit::AtVertices(transfer.exit_radiance(light.coefficients())),
            SceneTransfer::AtTexels(transfer, lightmap) => {
                Lit::AtTexels(transfer.exit_radiance(light.coefficients()), lightmap, &self.scene)
            }
            SceneTransfer::Glossy(matrices, lobe, reflectance) => {
                let zonal = lobe.zonal(matrices.order());
                let blurred = |p| convolved(&matrices.incident(p, light.coefficients()), &zonal);
                Lit::Glossy((0..matrices.points()).into_par_iter().map(blurred).collect(), reflectance)
            }
        }
    }
}

impl Lit<'_> {
    /// What is seen of a place, between vertices or texels.
    pub(crate) fn radiance(&self, hit: &SceneHit<'_>) -> Rgb<f64> {
        match self {
            Self::AtVertices(values) => hit.at_corners(values),
            Self::AtTexels(values, lightmap, scene) => {
                let parts = lightmap.texels_at(scene, hit.hit());
                parts.iter().fold(Rgb::ZERO, |sum, &(texel, part)| sum + values[texel].widen().scale(part))
            }
            Self::Glossy(blurred, reflectance) => {
                let (r, mut sum) = (hit.reflected(), Rgb::<f64>::ZERO);
                for (corner, weight) in hit.corners() {
                    sum += blurred[corner].eval(r).scale(weight);
                }
                reflectance.of(hit) * sum
            }
        }
    }
}

/// Reads a scene that was baked, or a file of transfer beside a scene, or reads and bakes a scene.
pub(crate) fn prepare(input: &SceneInput, asked: &Asked, talk: Talk) -> anyhow::Result<Prepared> {
    if let Some(order) = asked.order.filter(|&order| order > Transfer::MAX_ORDER) {
        bail!("--order: transfer has an order of 1 to {}, found {order}", Transfer::MAX_ORDER);
    }
    match (&asked.file, input.gltf_file()) {
        (Some(file), _) => read_beside(input, file, asked, talk),
        (None, Some(path)) if asked.lobe.is_none() && is_baked(path, &input.options())? => {
            read(input, path, asked, talk)
        }
        _ => bake_now(input, asked, talk),
    }
}

fn is_baked(path: &Path, options: &ReadOptions) -> anyhow::Result<bool> {
    let (_, _, attributes) = read_scene_and_attributes(path, options)?;
    Ok(!attributes.asset_extras()["lobe"].is_null())
}

fn read(input: &SceneInput, path: &Path, asked: &Asked, talk: Talk) -> anyhow::Result<Prepared> {
    let name = input.name();
    let Baked { scene, transfer, recipe, report, .. } = read_baked_within(path, &input.options())?;
    for note in &report.notes {
        talk.note(&name, note);
    }
    asked.check(&name, &recipe, transfer.order())?;
    Ok(Prepared { scene, transfer: SceneTransfer::AtVertices(transfer) })
}

/// A scene, and its transfer from a file that `lobe bake` wrote without the scene.
fn read_beside(input: &SceneInput, file: &Path, asked: &Asked, talk: Talk) -> anyhow::Result<Prepared> {
    let name = file.display().to_string();
    let scene = input.read(talk)?;
    let vertices = scene.vertex_count();
    let check_vertices = |found: usize| match found == vertices {
        true => Ok(()),
        false => bail!("{name}: expected transfer of {vertices} vertices as {} has, found {found}", input.name()),
    };
    if let Some(lobe) = asked.lobe {
        let (matrices, recipe) = read_matrices(file)?;
        asked.check(&name, &recipe, matrices.order())?;
        check_vertices(matrices.points())?;
        return Ok(Prepared { scene, transfer: SceneTransfer::Glossy(matrices, lobe, lobe.reflectance()) });
    }
    let is_picture = file.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr"));
    let (transfer, recipe) = if is_picture { read_lightmap(file)? } else { read_transfer(file)? };
    asked.check(&name, &recipe, transfer.order())?;
    let width = transfer.receivers().isqrt();
    if is_picture || recipe["texels"] == width {
        let lightmap = Lightmap::new(&scene, width)?;
        return Ok(Prepared { scene, transfer: SceneTransfer::AtTexels(transfer, lightmap) });
    }
    check_vertices(transfer.receivers())?;
    Ok(Prepared { scene, transfer: SceneTransfer::AtVertices(transfer) })
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
}

fn bake_now(input: &SceneInput, asked: &Asked, talk: Talk) -> anyhow::Result<Prepared> {
    let scene = input.read(talk)?;
    let defaults = BakeOptions::default();
    let options = BakeOptions {
        mode: asked.mode,
        order: asked.order.unwrap_or(defaults.order),
        samples: asked.samples.map_or(defaults.samples, |n| n as u32),
        bounces: asked.bounces.unwrap_or(defaults.bounces),
        ..defaults
    };
    let receivers = Receivers::at_vertices(&scene)?;
    let bar = talk.bar("bake", receivers.len() as u64);
    let show = &mut |progress: &Progress| {
        bar.set_position(progress.done as u64);
        ctrl_c::go_on()
    };
    ctrl_c::watch();
    let bvh = Bvh::new(&scene);
    let transfer = match asked.lobe {
        None => bake(&scene, &bvh, &receivers, &options, show).map(|(t, _)| SceneTransfer::AtVertices(t)),
        Some(lobe) => bake_matrices(&scene, &bvh, &receivers, &options, show)
            .map(|(matrices, _)| SceneTransfer::Glossy(matrices, lobe, lobe.reflectance())),
    };
    bar.finish_and_clear();
    match transfer {
        Err(PrtError::Cancelled) => bail!("stopped while transfer was baked, of which nothing is kept; {BAKE_FIRST}"),
        other => Ok(Prepared { scene, transfer: other? }),
    }
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
