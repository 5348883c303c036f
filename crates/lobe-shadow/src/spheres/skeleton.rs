//! Skeletons: which entity of an animated scene spheres stand for, and the joints that they are numbered by.

use std::collections::HashMap;

use lobe_scene::{AnimatedScene, Entity};
use serde::{Deserialize, Serialize};

use crate::error::ShadowError;
use lobe_io::one_line;

/// The entity of an animated scene that spheres stand for, with the joints of its skin in the order in which a
/// [`Skin`](crate::Skin) counts them.
///
/// Behind the joints of the skin, the node of the entity counts as one more: where a node has a skin and one of its meshes no
/// joints, that mesh moves with the node.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Skeleton {
    /// The name of the node that shows the entity.
    #[serde(default)]
    entity: Option<String>,
    /// The index of that node.
    node: usize,
    /// The names of the joints.
    #[serde(default)]
    joints: Vec<Option<String>>,
}

impl Skeleton {
    /// The skeleton of an entity that the node of this name, if any, and number shows, with the names of its skin's joints.
    #[must_use]
    pub fn new(entity: Option<String>, node: usize, joints: Vec<Option<String>>) -> Self {
        Self { entity, node, joints }
    }

    /// The skeleton of an entity; of one without a skin it has no joints.
    ///
    /// # Panics
    /// If the entity is of another scene, which has more skins.
    #[must_use]
    pub fn of(scene: &AnimatedScene, entity: &Entity) -> Self {
        let names = entity.skin().map(|skin| scene.skin_names(skin).1).unwrap_or_default();
        Self {
            entity: entity.name().map(str::to_owned),
            node: entity.node(),
            joints: names.into_iter().map(|name| name.map(str::to_owned)).collect(),
        }
    }

    /// The name of the node that shows the entity; many have none.
    #[must_use]
    pub fn entity(&self) -> Option<&str> {
        self.entity.as_deref()
    }

    /// The index of the node that shows the entity.
    #[must_use]
    pub fn node(&self) -> usize {
        self.node
    }

    /// The names of the joints of the skin; many have none.
    #[must_use]
    pub fn joints(&self) -> &[Option<String>] {
        &self.joints
    }

    /// The entity in messages.
    pub(crate) fn label(&self) -> String {
        match &self.entity {
            Some(name) => format!("`{}`", one_line(name)),
            None => format!("node {}", self.node),
        }
    }

    /// The number that each joint of this skeleton has in another, and last that of the node: by name if all have one and
    /// no two the same, else they must be in the same order.
    pub(crate) fn numbers_in(&self, other: &Self) -> Result<Vec<u16>, ShadowError> {
        let refuse = |message: String| Err(ShadowError::Options(message));
        let (expected, found) = (other.joints.len(), self.joints.len());
        if found != expected {
            let of = other.label();
            return refuse(format!(
                "expected spheres bound to the {expected} joints of {of}, found some bound to {found}; fit them to this entity"
            ));
        }
        let places: HashMap<&str, usize> = other.joints.iter().flatten().map(String::as_str).zip(0..).collect();
        let mine: HashMap<&str, usize> = self.joints.iter().flatten().map(String::as_str).zip(0..).collect();
        let mut numbers: Vec<usize> = (0..=found).collect();
        if mine.len() == found && other.joints.iter().all(Option::is_some) {
            for (number, name) in numbers.iter_mut().zip(self.joints.iter().flatten()) {
                let Some(place) = places.get(name.as_str()) else {
                    let (name, of) = (one_line(name), other.label());
                    return refuse(format!(
                        "found no joint `{name}` in {of}, which spheres are bound to; fit them to this entity"
                    ));
                };
                *number = *place;
            }
        } else if let Some(j) = (0..found).find(|&j| self.joints[j] != other.joints[j]) {
            let [expected, found] = [other, self].map(|skeleton| match &skeleton.joints[j] {
                Some(name) => format!("`{}`", one_line(name)),
                None => "one without a name".to_owned(),
            });
            let of = other.label();
            return refuse(format!(
                "expected {expected} as joint {j} of {of}, found {found}; fit spheres to this entity"
            ));
        }
        // As many as there are numbers of 16 bits, or spheres could not be bound to them.
        numbers.into_iter().map(expect_joint).collect()
    }
}

/// The number of a joint as sets of spheres keep it.
pub(crate) fn expect_joint(number: usize) -> Result<u16, ShadowError> {
    u16::try_from(number).map_err(|_| {
        let most = u16::MAX;
        ShadowError::Options(format!("expected at most {most} joints that spheres are bound to, found number {number}"))
    })
}
