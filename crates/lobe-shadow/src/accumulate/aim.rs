//! The direction and the angle at which a receiver sees a sphere.

use lobe_sh::simd::{LANES, Lanes, Wide, constant};
use pulp::Simd;

use crate::accumulate::sphere_tree::Unit;
use crate::receivers::ShadowReceivers;

/// Sixteen receivers: places and unit normals, coordinate by coordinate.
#[derive(Clone, Debug)]
pub(crate) struct ReceiverBlock {
    pub(crate) position: [Lanes; 3],
    pub(crate) normal: [Lanes; 3],
}

impl ReceiverBlock {
    /// Those of up to sixteen numbers, in the units of a tree; the last one fills up.
    pub(crate) fn of(receivers: &ShadowReceivers<'_>, members: &[u32], unit: Unit) -> Self {
        let mut block = Self { position: [Lanes::ZERO; 3], normal: [Lanes::ZERO; 3] };
        for k in 0..LANES {
            let member = members[k.min(members.len() - 1)] as usize;
            let (position, normal) = (unit.scaled(receivers.positions()[member]), receivers.normals()[member]);
            for axis in 0..3 {
                block.position[axis][k] = position[axis];
                block.normal[axis][k] = normal[axis];
            }
        }
        block
    }
}

/// A part of a block in registers.
#[derive(Clone, Copy)]
pub(crate) struct ReceiverLanes<S: Simd> {
    position: [Wide<S>; 3],
    pub(crate) normal: [Wide<S>; 3],
}

impl<S: Simd> ReceiverLanes<S> {
    #[inline(always)]
    pub(crate) fn load(simd: S, block: &ReceiverBlock, part: usize) -> Self {
        // Array::map is not inlined where the instructions are.
        let ([px, py, pz], [nx, ny, nz]) = (&block.position, &block.normal);
        let load = |c| Wide::load(simd, c, part);
        Self { position: [load(px), load(py), load(pz)], normal: [load(nx), load(ny), load(nz)] }
    }
}

/// The direction to a sphere, and the square of the sine of its half angle.
pub(crate) struct Aim<S: Simd> {
    pub(crate) towards: [Wide<S>; 3],
    pub(crate) sin_squared: Wide<S>,
}

/// The height at which a sinking sphere counts, as a part of that of its top. With ½ half a sphere on the ground hid too little
/// (test `a_sphere_that_crosses_the_plane_hides_about_what_is_above`); with 0 the direction to a top straight above would be
/// undefined.
const SUNK: f32 = 0.25;

/// The part of its radius by which a sphere reaches out of the surface that it stands for and hides nothing yet: as far
/// as fitted spheres mostly do. Without this the sides of growing columns are 4 to 8 % darker than they are by many
/// spheres.
const RIM: f32 = 0.125;

/// Spheres sink from a third of the radius above the plane, where 4/3 of it are above, to the rim.
const SLOPE: f32 = 1.0 / (4.0 / 3.0 - RIM);

/// Below this square of a distance a direction is zero, and the reciprocal still is a number.
const NO_DISTANCE: f32 = 1e-30;

/// How a sphere hides the sky from receivers on surfaces.
///
/// With `c` the center seen from the receiver, `d = |c|`, `h = n·c` its height above the tangent plane and `r` the radius,
/// a sphere above the plane has `sin θ = r/d`. For all others two rules hold, which leave that as it is.
///
/// **Plane.** What is below the plane hides nothing: the cosine sees to that, but for what rings. A sphere whose center is
/// lower than a third of the radius sinks away: it counts as a smaller one at a quarter of the height of its top,
///
/// ```text
///   t = clamp((h + r - r/8)/(4/3 r - r/8), 0, 1)        r' = r √t        c' = c + n max(0, ¼ (h + r) - h)
/// ```
///
/// so that a surface is not hidden by the sphere that stands for what is behind it. Both begin at `h = r/3`.
///
/// **Ratio.** Spheres reach out of the surfaces for which they stand, and receivers on these are inside. No sphere is nearer
/// than its surface:
///
/// ```text
///   sin θ = r' / max(|c'|, r)
/// ```
///
/// A receiver an eighth of the radius below the surface, which looks outward, loses nothing of its light from straight
/// above instead of all of it; one at the center 72 %. The result is continuous in place and normal, in and out of the
/// sphere (test
/// `what_hides_is_continuous_through_the_surface_and_the_center`). The paper's own wording of such rules was not at hand.
///
/// Without a plane, `PLANE` being false, only the second rule holds, and a sphere around the receiver's own place hides
/// nothing.
#[inline(always)]
pub(crate) fn aim<S: Simd, const PLANE: bool>(simd: S, at: &ReceiverLanes<S>, center: [f32; 3], radius: f32) -> Aim<S> {
    let splat = |value| constant(simd, value);
    let (zero, r) = (splat(0.0), splat(radius));
    let [nx, ny, nz] = at.normal;
    let [px, py, pz] = at.position;
    let mut c = [splat(center[0]) - px, splat(center[1]) - py, splat(center[2]) - pz];
    let mut hiding = splat(radius * radius);
    if PLANE {
        let h = nx.times_plus(c[0], ny.times_plus(c[1], nz * c[2]));
        let top = h + r;
        // r t and r'² = r² t.
        let above = (splat(SLOPE) * (top - splat(RIM * radius))).max(zero).min(r);
        hiding = r * above;
        let lift = (splat(SUNK) * top - h).max(zero);
        c = [nx.times_plus(lift, c[0]), ny.times_plus(lift, c[1]), nz.times_plus(lift, c[2])];
    }
    let squared = c[0].times_plus(c[0], c[1].times_plus(c[1], c[2] * c[2]));
    if !PLANE {
        hiding = squared.if_less(splat(NO_DISTANCE), zero, hiding);
    }
    let inverse = squared.max(splat(NO_DISTANCE)).inverse_sqrt();
    let inverse_squared = inverse * inverse;
    let sin_squared = hiding * inverse_squared.min(splat((radius * radius).max(NO_DISTANCE).recip()));
    Aim { towards: [c[0] * inverse, c[1] * inverse, c[2] * inverse], sin_squared }
}
