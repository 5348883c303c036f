//! Fields and spheres in files, and the parts that they are of.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use lobe_scene::{Entity, Mesh};
use lobe_shadow::{OcclusionField, ShadowError, Skeleton, SphereSet, read_field, read_spheres};

use crate::scene::moving_part::{Motion, MovingPart};
use crate::scene::moving_scene::MovingScene;
use lobe_render::RenderError;

/// How far what belongs to a mesh may be from it, as a part of its size: rounding, and a mesh that was split or
/// simplified.
const ABOUT: f64 = 0.05;

impl MovingScene {
    /// Gives a part the occlusion field in a file, in place of another or of one that would be baked: the part that it
    /// is around, of several the one that is nearest by middle and size. Returns its number.
    ///
    /// # Errors
    /// [`RenderError::Shadow`] with those of [`read_field`]; [`RenderError::Invalid`] if no part that keeps its shape
    /// is there, or several are equally near.
    pub fn set_field_from(&mut self, file: impl AsRef<Path>) -> Result<usize, RenderError> {
        let file = file.as_ref();
        let field = read_field(file)?;
        let place = around(&field);
        let off = |part: &MovingPart| {
            let (middle, reach) = ball_of(part);
            apart(middle, place.0) + (reach - place.1).abs()
        };
        let fitting = self.parts().iter().enumerate().filter(|(_, part)| part.is_rigid() && is_around(part, &field));
        let part = nearest(fitting, off)
            .ok_or_else(|| nowhere(file, "a field", place))?
            .map_err(|[a, b]| as_near(file, "a field", [a, b]))?;
        self.set_field(part, Arc::new(field));
        Ok(part)
    }

    /// Gives a part the spheres in a file, in place of others or of some that would be fitted: the entity that the file
    /// names, else the part that moves and keeps its shape within which the spheres are, of several the one whose box
    /// is nearest to theirs. Returns its number. A few spheres do not tell a cube from a ball of its size about the
    /// same middle: a description of the scene does, or spheres that name their entity.
    ///
    /// # Errors
    /// [`RenderError::Shadow`] with those of [`read_spheres`]; [`RenderError::Invalid`] if there is no such part,
    /// several are equally near, or the joints of the file are not those of the entity.
    pub fn set_spheres_from(&mut self, file: impl AsRef<Path>) -> Result<usize, RenderError> {
        let file = file.as_ref();
        let (part, set) = self.spheres_of_part(0..self.parts().len(), file)?;
        self.set_spheres(part, Arc::new(set));
        Ok(part)
    }

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

    /// Spheres of a file, with the part among these that they are of.
    fn spheres_of_part(&self, parts: Range<usize>, file: &Path) -> Result<(usize, SphereSet), RenderError> {
        let set = read_spheres(file)?;
        let entities = || parts.clone().filter_map(|k| Some((k, self.parts()[k].entity()?)));
        let named = match set.skeleton() {
            Some(skeleton) => Some(entity_of(skeleton, entities).ok_or_else(|| {
                let found = format!("found spheres of {}, which does not move here", label(skeleton));
                RenderError::invalid(file, format!("{found}: {}", expected_of(entities())))
            })?),
            // In a file in which one entity moves they can be of no other.
            None => entities().next().filter(|_| entities().count() == 1),
        };
        let index = match named {
            Some((index, _)) => index,
            None => self.part_around(parts, &set, file)?,
        };
        let part = &self.parts()[index];
        match (part.entity(), self.rig_of(index)) {
            (Some(entity), Some(rig)) => {
                let set = set.for_entity(rig, entity).map_err(|error| match error {
                    ShadowError::Options(message) => RenderError::invalid(file, message),
                    other => other.into(),
                })?;
                if let Some(morphs) = set.morphs() {
                    // They stand where morph targets stretch the part farthest.
                    let fitted = rig.morphed_scene(entity, morphs.weights())?;
                    let set = set.with_silhouette_of(&fitted);
                    let set = if part.is_rigid() { set.morphed_to(rig.morph_weights(entity)) } else { set };
                    return Ok((index, set));
                }
                expect_near(part, file, &set)?;
                Ok((index, set.with_silhouette_of(&part.scene)))
            }
            _ => Ok((index, of_rigid(part, file, set)?)),
        }
    }

    /// The part among these that moves and keeps its shape, and is where the spheres are.
    fn part_around(&self, parts: Range<usize>, set: &SphereSet, file: &Path) -> Result<usize, RenderError> {
        let [middle, half] = box_around(set);
        let off = |part: &MovingPart| apart(middle_of(part), middle) + apart(half_of(part), half);
        let moving = parts.map(|k| (k, &self.parts()[k]));
        let fitting = moving.filter(|(_, part)| {
            part.is_rigid()
                && !matches!(part.motion, Motion::Still)
                && outside(part, set).is_none()
                && is_as_large(part, half)
        });
        let what = "spheres that name no entity";
        nearest(fitting, off)
            .ok_or_else(|| nowhere(file, what, (middle, length(half))))?
            .map_err(|parts| as_near(file, what, parts))
    }
}

/// The field in a file that a description names for a part, which it must be around.
pub(crate) fn field_of(part: &MovingPart, file: &Path) -> Result<Arc<OcclusionField>, RenderError> {
    let field = read_field(file)?;
    if is_around(part, &field) {
        return Ok(Arc::new(field));
    }
    let (middle, reach) = (middle_of(part), length(half_of(part)));
    let message = format!(
        "expected the field of `{}`, around {middle:?} with a radius of about {reach:.4}, found one around {:?} with {:.4}; \
         bake it from that mesh",
        part.name,
        field.grid().center(),
        field.grid().radius()
    );
    Err(RenderError::invalid(file, message))
}

/// The spheres in a file that a description names for a part that moves as a whole.
pub(crate) fn rigid_spheres(part: &MovingPart, file: &Path) -> Result<Arc<SphereSet>, RenderError> {
    Ok(Arc::new(of_rigid(part, file, read_spheres(file)?)?))
}

/// Spheres that are of a part that no animation moves, and have no joints.
fn of_rigid(part: &MovingPart, file: &Path, set: SphereSet) -> Result<SphereSet, RenderError> {
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
    Ok(set.with_silhouette_of(&part.scene))
}

/// The entity that a skeleton is of: that of its name, of several the one of its node too; without a name that of its
/// node.
fn entity_of<'a, I: Iterator<Item = (usize, &'a Entity)>>(
    skeleton: &Skeleton,
    entities: impl Fn() -> I,
) -> Option<(usize, &'a Entity)> {
    let is_named = |entity: &Entity| entity.name() == skeleton.entity();
    let exactly = entities().find(|(_, entity)| entity.node() == skeleton.node() && is_named(entity));
    exactly.or_else(|| entities().find(|(_, entity)| skeleton.entity().is_some() && is_named(entity)))
}

fn expected_of<'a>(entities: impl Iterator<Item = (usize, &'a Entity)>) -> String {
    let names: Vec<String> = entities.map(|(_, entity)| label_of(entity)).collect();
    match names.len() {
        0 => "nothing moves in it by this animation; leave `spheres` out".to_owned(),
        _ => format!("expected one of {}", names.join(", ")),
    }
}

fn label(skeleton: &Skeleton) -> String {
    skeleton.entity().map_or_else(|| format!("node {}", skeleton.node()), |name| format!("`{}`", name.escape_debug()))
}

fn label_of(entity: &Entity) -> String {
    entity.name().map_or_else(|| format!("node {}", entity.node()), |name| format!("`{}`", name.escape_debug()))
}

/// The one among parts that is least off; two names if that is not one.
fn nearest<'a>(
    parts: impl Iterator<Item = (usize, &'a MovingPart)>,
    off: impl Fn(&MovingPart) -> f64,
) -> Option<Result<usize, [String; 2]>> {
    let mut found: Vec<(f64, usize, &MovingPart)> = parts.map(|(number, part)| (off(part), number, part)).collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    Some(match found.as_slice() {
        [] => return None,
        [a, b, ..] if a.0 == b.0 => Err([a.2.name.clone(), b.2.name.clone()]),
        [a, ..] => Ok(a.1),
    })
}

/// A ball: its center and its radius.
type Ball = ([f64; 3], f64);

fn nowhere(file: &Path, what: &str, (center, radius): Ball) -> RenderError {
    let message = format!(
        "found {what} around {center:.4?} with a radius of {radius:.4}, where no part of the scene is that could have it; \
         open the scene that it was made for"
    );
    RenderError::invalid(file, message)
}

fn as_near(file: &Path, what: &str, [a, b]: [String; 2]) -> RenderError {
    let message =
        format!("found {what}, and both `{a}` and `{b}` where it is; name the file in a description of the scene");
    RenderError::invalid(file, message)
}

/// Whether the sphere of a field is about the box of a part, and no larger than that of the box.
fn is_around(part: &MovingPart, field: &OcclusionField) -> bool {
    let ((center, radius), middle, half) = (around(field), middle_of(part), half_of(part));
    let (reach, widest) = (length(half), half.iter().fold(0.0_f64, |a, b| a.max(*b)));
    let off = apart(center, middle);
    off <= ABOUT * reach && radius <= (1.0 + ABOUT) * reach && (1.0 + ABOUT) * radius >= widest
}

fn around(field: &OcclusionField) -> Ball {
    (field.grid().center(), field.grid().radius())
}

/// Whether the box around spheres has at least half of the diagonal of that of a part: those of a smaller one fill no
/// more of it.
fn is_as_large(part: &MovingPart, half: [f64; 3]) -> bool {
    2.0 * length(half) >= length(half_of(part))
}

/// Refuses spheres of a file that are not about a part.
fn expect_near(part: &MovingPart, file: &Path, spheres: &SphereSet) -> Result<(), RenderError> {
    let Some(k) = outside(part, spheres) else { return Ok(()) };
    let message = format!(
        "expected spheres of `{}`, within {:.4} of {:?}, found number {k} at {:?} with the radius {}; fit them to that mesh",
        part.name,
        reach_of(part),
        middle_of(part),
        spheres.center(k),
        spheres.radii()[k]
    );
    Err(RenderError::invalid(file, message))
}

/// The first of some spheres that has its center farther from the middle of a part's box than the corners, or is larger
/// than that.
fn outside(part: &MovingPart, spheres: &SphereSet) -> Option<usize> {
    let (middle, reach) = (middle_of(part), reach_of(part));
    (0..spheres.len())
        .find(|&k| apart(spheres.center(k), middle) > reach || f64::from(spheres.radii()[k]) > 2.0 * reach)
}

fn reach_of(part: &MovingPart) -> f64 {
    (1.0 + ABOUT) * length(half_of(part))
}

fn middle_of(part: &MovingPart) -> [f64; 3] {
    let [min, max] = part.scene.world_bounds();
    std::array::from_fn(|k| 0.5 * (min[k] + max[k]))
}

fn half_of(part: &MovingPart) -> [f64; 3] {
    let [min, max] = part.scene.world_bounds();
    std::array::from_fn(|k| 0.5 * (max[k] - min[k]))
}

/// The middle of the box of a part, and the distance of its farthest vertex from it.
fn ball_of(part: &MovingPart) -> Ball {
    let (middle, origin) = (middle_of(part), part.scene.origin());
    let positions = part.scene.meshes().iter().flat_map(Mesh::positions);
    let off = |p: &[f32; 3]| apart(std::array::from_fn(|k| f64::from(p[k]) + origin[k]), middle);
    (middle, positions.map(off).fold(0.0, f64::max))
}

/// The middle of the box around spheres, and half of its sides.
fn box_around(spheres: &SphereSet) -> [[f64; 3]; 2] {
    let all = || (0..spheres.len()).map(|k| (spheres.center(k), f64::from(spheres.radii()[k])));
    let bound = |k: usize, sign: f64| all().map(|(c, r)| sign * c[k] + r).fold(f64::NEG_INFINITY, f64::max);
    [-1.0, 1.0].map(|sign| std::array::from_fn(|k| 0.5 * (bound(k, 1.0) + sign * bound(k, -1.0))))
}

fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
    length(std::array::from_fn(|k| a[k] - b[k]))
}

fn length(v: [f64; 3]) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}
