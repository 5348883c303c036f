//! Spheres that a description names for its entities.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use lobe_scene::Entity;
use lobe_shadow::{ShadowError, Skeleton, SphereSet, read_spheres};

use crate::moving::ABOUT;
use crate::{MovingPart, MovingScene, RenderError};

/// The spheres of a part that moves as a whole.
pub(crate) fn rigid_spheres(part: &MovingPart, file: &Path) -> Result<Arc<SphereSet>, RenderError> {
    let set = read_spheres(file)?;
    if let Some(skeleton) = set.skeleton() {
        let of = label(skeleton);
        let message = format!(
            "expected spheres of `{}`, which no animation moves, found those of its entity {of}; name an `animation`, or fit \
             spheres to the whole file, without --entity",
            part.name
        );
        return Err(RenderError::invalid(file, message));
    }
    if set.skin().is_some() {
        let message = format!("expected spheres of `{}`, which no animation moves, found some with joints", part.name);
        return Err(RenderError::invalid(file, message));
    }
    expect_near(part, file, &set)?;
    Ok(Arc::new(set))
}

impl MovingScene {
    /// Gives parts of an animated file, which are these, the spheres in files.
    pub(crate) fn take_spheres(&mut self, parts: Range<usize>, files: &[PathBuf]) -> Result<(), RenderError> {
        for file in files {
            let (index, set) = self.spheres_of_part(parts.clone(), file)?;
            let part = &mut self.parts_mut()[index];
            if part.spheres.is_some() {
                return Err(RenderError::invalid(file, format!("`{}` has spheres of another file already", part.name)));
            }
            part.spheres = Some(Arc::new(set));
        }
        Ok(())
    }

    /// Spheres of a file, with the part that they are of.
    fn spheres_of_part(&self, parts: Range<usize>, file: &Path) -> Result<(usize, SphereSet), RenderError> {
        let set = read_spheres(file)?;
        let moving = || parts.clone().filter_map(|k| Some((k, self.parts()[k].entity()?)));
        let found = match set.skeleton() {
            Some(skeleton) => entity_of(skeleton, moving),
            None => moving().next().filter(|_| moving().count() == 1),
        };
        let (Some((index, entity)), Some(rig)) = (found, self.rig_of(parts.start)) else {
            let names: Vec<String> = moving().map(|(_, entity)| label_of(entity)).collect();
            let expected = match names.len() {
                0 => "nothing moves in it by this animation; leave `spheres` out".to_owned(),
                _ => format!("expected one of {}", names.join(", ")),
            };
            let found = match set.skeleton() {
                Some(skeleton) => format!("found spheres of {}, which does not move here", label(skeleton)),
                None => "found spheres that do not say of which entity they are".to_owned(),
            };
            return Err(RenderError::invalid(file, format!("{found}: {expected}")));
        };
        let set = set.for_entity(rig, entity).map_err(|error| match error {
            ShadowError::Options(message) => RenderError::invalid(file, message),
            other => other.into(),
        })?;
        expect_near(&self.parts()[index], file, &set)?;
        Ok((index, set))
    }
}

/// The entity that a skeleton is of: that of its name, of several the one of its node too; without a name that of its node.
fn entity_of<'a, I: Iterator<Item = (usize, &'a Entity)>>(
    skeleton: &Skeleton,
    moving: impl Fn() -> I,
) -> Option<(usize, &'a Entity)> {
    let is_named = |entity: &Entity| entity.name() == skeleton.entity();
    let exactly = moving().find(|(_, entity)| entity.node() == skeleton.node() && is_named(entity));
    exactly.or_else(|| moving().find(|(_, entity)| skeleton.entity().is_some() && is_named(entity)))
}

fn label(skeleton: &Skeleton) -> String {
    skeleton.entity().map_or_else(|| format!("node {}", skeleton.node()), |name| format!("`{}`", name.escape_debug()))
}

fn label_of(entity: &Entity) -> String {
    entity.name().map_or_else(|| format!("node {}", entity.node()), |name| format!("`{}`", name.escape_debug()))
}

/// Refuses spheres of a file that are not about a part: none may have its center farther from the middle of the part's box than
/// the corners.
fn expect_near(part: &MovingPart, file: &Path, spheres: &SphereSet) -> Result<(), RenderError> {
    let [min, max] = part.scene.world_bounds();
    let middle: [f64; 3] = std::array::from_fn(|k| 0.5 * (min[k] + max[k]));
    let reach = (1.0 + ABOUT) * (0..3).map(|k| (0.5 * (max[k] - min[k])).powi(2)).sum::<f64>().sqrt();
    for (k, radius) in spheres.radii().iter().enumerate() {
        let center = spheres.center(k);
        let off = (0..3).map(|i| (center[i] - middle[i]).powi(2)).sum::<f64>().sqrt();
        if off > reach || f64::from(*radius) > 2.0 * reach {
            let message = format!(
                "expected spheres of `{}`, within {reach:.4} of {middle:?}, found number {k} at {center:?} with the radius {radius}; \
                 fit them to that mesh",
                part.name
            );
            return Err(RenderError::invalid(file, message));
        }
    }
    Ok(())
}
