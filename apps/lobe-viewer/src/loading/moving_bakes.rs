//! Bakes of the parts of what moves.

use lobe::motion::{MovingBakeOptions, MovingScene};
use lobe::prt::{BakeMode, BakeOptions};
use lobe::shadow::{FieldOptions, SphereFitMethod, SphereFitOptions};

/// Paths from each vertex for the transfer of parts.
const SAMPLES: u32 = 64;

/// Directions traced from each point around a part for its field.
const FIELD_RAYS: u32 = 128;

/// Points that spheres are fitted to: fewer than the library takes, so that a fit ends in seconds.
const FIT_SAMPLES: usize = 1500;

/// Times as many spheres for a part that changes its shape: it has limbs.
const DEFORMED: usize = 4;

/// Whether all transfer of a scene that was opened is baked here, without reflections: then suns that cast shadows by
/// themselves are no part of its light. What came baked may reflect them.
pub(crate) fn leaves_suns(opened: &MovingScene) -> bool {
    opened.order().is_none()
}

/// The options of the transfer of parts.
pub(crate) fn moving_transfer_options(order: usize) -> BakeOptions {
    BakeOptions::default().mode(BakeMode::Shadowed).order(order).samples(SAMPLES)
}

/// The options of the bakes of moving parts of the window, with `count` spheres for a part that keeps its shape. `still_hides` says
/// whether what stands still hides the sky from what moves.
#[must_use]
pub fn moving_bake_options(
    order: usize,
    method: SphereFitMethod,
    count: usize,
    still_hides: bool,
) -> MovingBakeOptions {
    let transfer = moving_transfer_options(order);
    let field = FieldOptions::default().order(order).rays(FIELD_RAYS);
    let spheres = SphereFitOptions::default().method(method).count(count).samples(FIT_SAMPLES);
    let options = MovingBakeOptions::default().transfer(transfer).field(field).spheres(spheres);
    options.deformed_spheres(Some(DEFORMED * count)).still_hides(still_hides)
}
