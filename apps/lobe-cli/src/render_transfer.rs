//! Transfer to render with: read from a baked file, or baked on the way.

use std::ops::ControlFlow;
use std::path::Path;

use anyhow::bail;
use lobe::prt::{
    BakeOptions, Baked, Mode, Progress, Receivers, Transfer, TransferMatrices, bake, bake_matrices, read_baked,
};
use lobe::render::SceneHit;
use lobe::scene::{Bvh, ReadOptions, Scene, read_scene_and_attributes};
use lobe::sh::{Expansion as _, Rgb, ShVec, Zonal, convolved};
use rayon::prelude::*;

use crate::scene_input::SceneInput;
use crate::talk::Talk;
use crate::values;

/// What transfer is asked for.
pub(crate) struct Asked {
    pub(crate) mode: Mode,
    pub(crate) order: Option<usize>,
    pub(crate) samples: Option<usize>,
    pub(crate) bounces: Option<usize>,
    /// The lobe of glossy surfaces; without one they are matte.
    pub(crate) lobe: Option<Lobe>,
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

/// A scene and what its vertices do to light.
pub(crate) struct Prepared {
    pub(crate) scene: Scene,
    transfer: VertexTransfer,
}

enum VertexTransfer {
    Matte(Transfer),
    Glossy(TransferMatrices, Lobe),
}

/// What vertices send back of one light.
pub(crate) enum Lit {
    Matte(Vec<Rgb<f32>>),
    /// The light that arrives at each, blurred by the lobe: its value in the mirrored direction is what is sent.
    Glossy(Vec<ShVec<Rgb<f64>>>),
}

impl Prepared {
    pub(crate) fn order(&self) -> usize {
        match &self.transfer {
            VertexTransfer::Matte(transfer) => transfer.order(),
            VertexTransfer::Glossy(matrices, _) => matrices.order(),
        }
    }

    pub(crate) fn lit(&self, light: &ShVec<Rgb<f64>>) -> Lit {
        match &self.transfer {
            VertexTransfer::Matte(transfer) => Lit::Matte(transfer.exit_radiance(light.coefficients())),
            VertexTransfer::Glossy(matrices, lobe) => {
                let zonal = lobe.zonal(matrices.order());
                let blurred = |p| convolved(&matrices.incident(p, light.coefficients()), &zonal);
                Lit::Glossy((0..matrices.points()).into_par_iter().map(blurred).collect())
            }
        }
    }
}

impl Lit {
    /// What is seen of a place between vertices; glossy surfaces tint what they mirror by their base colour.
    pub(crate) fn radiance(&self, hit: &SceneHit<'_>) -> Rgb<f64> {
        match self {
            Self::Matte(values) => hit.at_corners(values),
            Self::Glossy(blurred) => {
                let (r, mut sum) = (hit.reflected(), Rgb::new(0.0, 0.0, 0.0));
                for (corner, weight) in hit.corners() {
                    let value = blurred[corner].eval(r);
                    sum += Rgb::new(weight * value.r, weight * value.g, weight * value.b);
                }
                hit.albedo * sum
            }
        }
    }
}

/// Reads a scene that was baked, or reads and bakes one that was not.
pub(crate) fn prepare(input: &SceneInput, asked: &Asked, talk: Talk) -> anyhow::Result<Prepared> {
    if let Some(order) = asked.order.filter(|&order| order > Transfer::MAX_ORDER) {
        bail!("--order: transfer has an order of 1 to {}, found {order}", Transfer::MAX_ORDER);
    }
    match input.gltf_file() {
        Some(path) if asked.lobe.is_none() && is_baked(path)? => read(input, path, asked, talk),
        _ => bake_now(input, asked, talk),
    }
}

fn is_baked(path: &Path) -> anyhow::Result<bool> {
    let (_, _, attributes) = read_scene_and_attributes(path, &ReadOptions::default())?;
    Ok(!attributes.asset_extras()["lobe"].is_null())
}

fn read(input: &SceneInput, path: &Path, asked: &Asked, talk: Talk) -> anyhow::Result<Prepared> {
    let name = input.name();
    let Baked { scene, transfer, recipe, report, .. } = read_baked(path)?;
    for note in &report.notes {
        talk.note(&name, note);
    }
    for (option, is_given) in [("--bake-samples", asked.samples.is_some()), ("--bounces", asked.bounces.is_some())] {
        if is_given {
            bail!("{option}: {name} is baked already; leave the option out, or render the scene it was baked from");
        }
    }
    let wanted = mode_name(asked.mode);
    // A recipe that does not say is believed.
    let found = recipe["mode"].as_str().unwrap_or(wanted);
    if found != wanted {
        bail!("--mode {wanted}: {name} was baked as {found}; ask for that, or render the scene it was baked from");
    }
    if let Some(order) = asked.order.filter(|&order| order > transfer.order()) {
        bail!("--order {order}: {name} was baked to order {}; bake it to a higher one", transfer.order());
    }
    Ok(Prepared { scene, transfer: VertexTransfer::Matte(transfer) })
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
        ControlFlow::Continue(())
    };
    let bvh = Bvh::new(&scene);
    let transfer = match asked.lobe {
        None => VertexTransfer::Matte(bake(&scene, &bvh, &receivers, &options, show)?.0),
        Some(lobe) => VertexTransfer::Glossy(bake_matrices(&scene, &bvh, &receivers, &options, None, show)?.0, lobe),
    };
    bar.finish_and_clear();
    Ok(Prepared { scene, transfer })
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
