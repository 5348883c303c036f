//! Moving scenes by name.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::bail;
use lobe::render::{Motion, MovingPart, MovingScene};
use lobe::scene::{AnimatedScene, built_in, is_gltf};
use lobe::shadow::{SphereSet, read_field, read_spheres};

use crate::loading::file_kind::{DESCRIPTION, FileKind};
use crate::loading::limits::{ReadLimits, plain};
use crate::loading::scene_source::{BUILT_IN, ENDINGS, has_ending, open_scene};

/// How far a field or spheres may be from a part, and how much larger or smaller, in radii of the part: spheres reach out of it.
const FITS: f64 = 0.5;

/// Reads a scene that may move, repeated from its end: a .glb, .gltf or .vrm file with its first animation, a description (.json) as the
/// command `lobe render --mode fields` takes it, another scene, which stands still, or `built-in:NAME`.
///
/// # Errors
/// One line that says what is wrong with the file or the name.
pub fn open_moving(source: &Path, limits: &ReadLimits) -> anyhow::Result<MovingScene> {
    let text = source.to_string_lossy();
    let options = limits.scene();
    let moving = if let Some(name) = text.strip_prefix(BUILT_IN) {
        let Some(animated) = built_in::moving(name) else {
            let known = built_in::MOVING_NAMES.map(|known| format!("{BUILT_IN}{known}")).join(", ");
            bail!("{text}: there is no such moving scene in the program; there are {known}");
        };
        MovingScene::animated(animated, Some(0))?
    } else if has_ending(source, &[DESCRIPTION]) {
        MovingScene::read(source, &options).map_err(plain)?.0
    } else if is_gltf(source) {
        let (animated, _) = AnimatedScene::read(source, &options).map_err(plain)?;
        let animation = (!animated.animations().is_empty()).then_some(0);
        MovingScene::animated(animated, animation)?
    } else if has_ending(source, &ENDINGS) {
        MovingScene::animated(AnimatedScene::still(open_scene(source, limits)?.scene), None)?
    } else {
        let name = source.file_name().unwrap_or_default().to_string_lossy();
        bail!("{name}: not a scene that can move; there are .glb, .gltf, .vrm, .obj, .ply and descriptions, .json");
    };
    Ok(moving.looped(true))
}

/// Whether a source is a file, and not made by formula.
pub(crate) fn is_file(source: &Path) -> bool {
    !source.to_string_lossy().starts_with(BUILT_IN)
}

/// The name of a built-in moving scene as a source.
pub(crate) fn built_in_moving(name: &str) -> PathBuf {
    PathBuf::from(format!("{BUILT_IN}{name}"))
}

/// The same scene with fields and spheres from files, each of the part that it is nearest to.
///
/// # Errors
/// One line that says what is wrong with a file, or that no part is where it is.
pub(crate) fn with_files(scene: MovingScene, files: &[PathBuf]) -> anyhow::Result<MovingScene> {
    let mut scene = scene;
    for file in files {
        match FileKind::of(file).map_err(anyhow::Error::msg)? {
            FileKind::Field => {
                let field = read_field(file)?;
                let part = part_at(scene.parts(), field.grid().center(), field.grid().radius(), file)?;
                scene.set_field(part, Arc::new(field));
            }
            FileKind::Spheres => {
                let spheres = read_spheres(file)?;
                let (center, radius) = ball_of(&spheres);
                let part = part_at(scene.parts(), center, radius, file)?;
                scene.set_spheres(part, Arc::new(spheres));
            }
            _ => bail!("{}: expected an occlusion field or spheres", file.display()),
        }
    }
    Ok(scene)
}

/// The part that moves and keeps its shape whose ball is nearest to one, by its middle and its size.
fn part_at(parts: &[MovingPart], center: [f64; 3], radius: f64, file: &Path) -> anyhow::Result<usize> {
    let off = |part: &MovingPart| {
        let [min, max] = part.scene.world_bounds();
        let middle: [f64; 3] = std::array::from_fn(|k| 0.5 * (min[k] + max[k]));
        let reach = length(std::array::from_fn(|k| 0.5 * (max[k] - min[k])));
        let apart = length(std::array::from_fn(|k| middle[k] - center[k]));
        (apart + (reach - radius).abs()) / reach.max(f64::MIN_POSITIVE)
    };
    let moving =
        parts.iter().enumerate().filter(|(_, part)| !matches!(part.motion, Motion::Still | Motion::Deformed(_)));
    let nearest = moving.map(|(number, part)| (off(part), number)).min_by(|a, b| a.0.total_cmp(&b.0));
    match nearest {
        Some((off, number)) if off < FITS => Ok(number),
        _ => bail!(
            "{}: around {center:.2?} with a radius of {radius:.2}, where no part of the scene is; open the scene that it was made for \
             first",
            file.file_name().unwrap_or_default().to_string_lossy()
        ),
    }
}

/// The ball around spheres.
fn ball_of(spheres: &SphereSet) -> ([f64; 3], f64) {
    let all = || (0..spheres.len()).map(|k| (spheres.center(k), f64::from(spheres.radii()[k])));
    let bound = |k: usize, sign: f64| all().map(|(c, r)| sign * c[k] + r).fold(f64::NEG_INFINITY, f64::max);
    let [max, min] = [1.0, -1.0].map(|sign| std::array::from_fn::<f64, 3, _>(|k| sign * bound(k, sign)));
    let center = std::array::from_fn(|k| 0.5 * (min[k] + max[k]));
    (center, length(std::array::from_fn(|k| 0.5 * (max[k] - min[k]))))
}

fn length(v: [f64; 3]) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}
