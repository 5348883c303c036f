//! Obstacles between a part of a moving scene and the sky, and the vertices that they hide it from.

use lobe_prt::Transfer;
use lobe_shadow::{Occluder, PlacedField, Placement, relative_placement};

use crate::baked::visibility_grid::VisibilityGrid;
use crate::moving_options::MovingMethod;
use crate::scene::moment::Moment;
use crate::scene::moment::PlacedPart;
use crate::scene::moving_part::HidesBy;
use crate::scene::moving_part::{Motion, MovingPart};

/// What hides the sky from a part at a moment, all other parts and that one too if it is deformed, in the frame of its
/// [receivers](PartReceivers), but for grids, which are in the world.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct PartObstacles<'a> {
    /// Parts by their occlusion fields.
    pub fields: Vec<PlacedField<'a>>,
    /// What stands still, by grids: of a part that moves.
    pub grids: Vec<&'a VisibilityGrid>,
    /// The spheres of parts.
    pub spheres: Vec<Occluder>,
}

/// The vertices of a part at a moment as receivers of light, for programs that shade them elsewhere than
/// [`MovingShading`](crate::MovingShading) does.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct PartReceivers<'a> {
    /// The frame of the positions and normals in the world.
    pub frame: Placement,
    /// Positions in that frame.
    pub positions: &'a [[f32; 3]],
    /// Unit normals in that frame.
    pub normals: &'a [[f32; 3]],
    /// What each sends back of red, green and blue.
    pub albedos: &'a [[f32; 3]],
    /// Transfer from the part itself, in that frame; none of a part that is deformed, or was not baked.
    pub transfer: Option<&'a Transfer>,
    /// Whether the transfer leaves the albedo out.
    pub is_demodulated: bool,
}

impl<'a> PartObstacles<'a> {
    pub(crate) fn of(moment: &'a Moment<'_>, receiver: usize, method: MovingMethod) -> Self {
        let is_moving = !matches!(moment.parts()[receiver].motion, Motion::Still);
        let frame = &moment.placed[receiver].surface.frame;
        let mut obstacles = Self::default();
        for (part, placed) in others(moment, receiver) {
            match part.hides_by(method) {
                Some(HidesBy::Field(field)) => {
                    let placement = relative_placement(&placed.placement, frame);
                    obstacles.fields.push(PlacedField { field, placement });
                }
                Some(HidesBy::Spheres) => obstacles.spheres.extend(placed.spheres.iter().map(|sphere| {
                    let center = frame.to_own(sphere.center).map(|c| c as f32);
                    Occluder::new(center, (sphere.radius / frame.scale()) as f32)
                })),
                // A grid is known where parts move.
                Some(HidesBy::Grid(grid)) if is_moving => obstacles.grids.push(grid),
                Some(HidesBy::Grid(_)) | None => {}
            }
        }
        obstacles
    }
}

impl Moment<'_> {
    /// What hides the sky from a part.
    ///
    /// # Panics
    /// If there is no such part.
    #[must_use]
    pub fn obstacles_of(&self, part: usize, method: MovingMethod) -> PartObstacles<'_> {
        PartObstacles::of(self, part, method)
    }

    /// The vertices of a part.
    ///
    /// # Panics
    /// If there is no such part.
    #[must_use]
    pub fn receivers_of(&self, part: usize) -> PartReceivers<'_> {
        let (surface, part) = (&self.placed[part].surface, &self.parts()[part]);
        PartReceivers {
            frame: surface.frame,
            positions: &surface.positions,
            normals: &surface.normals,
            albedos: &surface.albedos,
            transfer: part.transfer.as_deref().filter(|_| part.is_rigid()),
            is_demodulated: part.is_demodulated,
        }
    }

    /// Whether there are lamps.
    #[must_use]
    pub fn has_lamps(&self) -> bool {
        !self.lamps.is_empty()
    }
}

/// The parts that may hide the sky from a receiver.
fn others<'a>(moment: &'a Moment<'_>, receiver: usize) -> impl Iterator<Item = (&'a MovingPart, &'a PlacedPart)> {
    let parts = moment.parts().iter().zip(&moment.placed).enumerate();
    parts.filter(move |(index, (part, _))| *index != receiver || !part.is_rigid()).map(|(_, pair)| pair)
}

/// Those that do so by their spheres, in the order of [`PartObstacles::spheres`].
pub(crate) fn hiding_by_spheres<'a>(
    moment: &'a Moment<'_>,
    receiver: usize,
    method: MovingMethod,
) -> impl Iterator<Item = (&'a MovingPart, &'a PlacedPart)> {
    others(moment, receiver).filter(move |(part, _)| matches!(part.hides_by(method), Some(HidesBy::Spheres)))
}

/// The grids of all that stands still.
pub(crate) fn still_grids<'a>(moment: &'a Moment<'_>, method: MovingMethod) -> Vec<&'a VisibilityGrid> {
    let grid = |part: &'a MovingPart| match part.hides_by(method) {
        Some(HidesBy::Grid(grid)) => Some(grid),
        _ => None,
    };
    moment.parts().iter().filter_map(grid).collect()
}
