//! Parts of a moving scene: what stands still, what moves as a whole, and what changes its shape.

use std::sync::Arc;

use lobe_prt::{BakeOptions, Transfer};
use lobe_scene::{Entity, Scene};
use lobe_sh::Rgb;
use lobe_shadow::{OcclusionField, SphereSet, Track};

use crate::baked::kept_transfer::KeptTransfer;
use crate::baked::part_backs::PartBacks;
use crate::baked::visibility_grid::VisibilityGrid;
use crate::moving_options::MovingMethod;

/// How a part moves.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum Motion {
    /// It stands still.
    Still,
    /// It moves as a whole along a track.
    Track(Track),
    /// It is an entity of the scene's animated glTF file, which moves it as a whole.
    Node(Entity),
    /// It is such an entity and is deformed: by a skin, by morph targets, or by scales that differ.
    Deformed(Entity),
}

/// A part of a [`MovingScene`](crate::MovingScene).
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct MovingPart {
    /// The name in messages.
    pub name: String,
    /// Its triangles in its own frame; of a part that is deformed those that it was bound with.
    pub scene: Scene,
    /// How it moves.
    pub motion: Motion,
    /// The transfer of its vertices from itself alone, in its own frame. None of a part that is deformed.
    pub transfer: Option<Arc<Transfer>>,
    /// The part of that transfer that is without reflections, by which suns do not light what they light by rays.
    pub direct: Option<Arc<Transfer>>,
    /// Whether the transfer leaves out the albedo of the vertices.
    pub is_demodulated: bool,
    /// What it hides of the sky around it. None of a part that is deformed.
    pub field: Option<Arc<OcclusionField>>,
    /// The spheres that stand for it.
    pub spheres: Option<Arc<SphereSet>>,
    /// Of what stands still: the sky that it leaves visible where others move.
    pub visibility: Option<Arc<VisibilityGrid>>,
    /// The albedo of what each sphere stands for; none until it is needed.
    pub(crate) sphere_albedos: Vec<Rgb<f32>>,
    /// The transfer that a file holds of some vertices.
    pub(crate) kept: Option<Arc<KeptTransfer>>,
    /// The light paths of the transfer, if they are known.
    pub(crate) paths: Option<BakeOptions>,
    /// The transfer of the backs of some vertices.
    pub(crate) backs: Option<Arc<PartBacks>>,
}

/// What a part hides the sky by.
#[derive(Clone, Copy, Debug)]
pub(crate) enum HidesBy<'a> {
    Field(&'a OcclusionField),
    Spheres,
    Grid(&'a VisibilityGrid),
}

impl MovingPart {
    /// A part of which nothing is baked yet.
    #[must_use]
    pub fn new(name: impl Into<String>, scene: Scene, motion: Motion) -> Self {
        Self {
            name: name.into(),
            scene,
            motion,
            transfer: None,
            direct: None,
            is_demodulated: false,
            field: None,
            spheres: None,
            visibility: None,
            sphere_albedos: Vec::new(),
            kept: None,
            paths: None,
            backs: None,
        }
    }

    /// What it hides the sky by, of what it has: the one that the method prefers, else the other. Nothing if it has
    /// neither.
    pub(crate) fn hides_by(&self, method: MovingMethod) -> Option<HidesBy<'_>> {
        let field = self.field.as_deref().filter(|_| self.is_rigid()).map(HidesBy::Field);
        let spheres = self.spheres.is_some().then_some(HidesBy::Spheres);
        match (&self.motion, method) {
            (Motion::Still, _) => field.or(self.visibility.as_deref().map(HidesBy::Grid)),
            (_, MovingMethod::Fields) => field.or(spheres),
            (_, MovingMethod::Exponentials) => spheres.or(field),
        }
    }

    /// Whether suns may light it by rays: it has no transfer, or the direct part of that is known.
    pub(crate) fn parts_suns(&self) -> bool {
        !self.is_rigid() || self.transfer.is_none() || self.direct.is_some()
    }

    /// Whether it keeps its shape, so that transfer and fields can be baked for it.
    #[must_use]
    pub fn is_rigid(&self) -> bool {
        !matches!(self.motion, Motion::Deformed(_))
    }

    /// The entity of an animated file that it is.
    pub(crate) fn entity(&self) -> Option<&Entity> {
        match &self.motion {
            Motion::Node(entity) | Motion::Deformed(entity) => Some(entity),
            Motion::Still | Motion::Track(_) => None,
        }
    }
}
