//! Watertight intersection of rays and triangles [Woop, Benthin and Wald 2013]: no ray falls between two triangles that
//! share an edge.

use crate::bvh::lanes::{Lanes, WIDTH};
use crate::bvh::ray_frame::RayFrame;
use crate::scene::ray::Hit;

/// A ray for watertight intersection: translated to the origin and sheared to the axis of its longest component.
///
/// ```text
///   k_z = axis of the longest component of d, and k_x, k_y the two after it
///   S = (d_x, d_y) / d_z
///   A = a - o,   A_x' = A_x - S_x A_z,   A_y' = A_y - S_y A_z
///   U = C_x' B_y' - C_y' B_x',   V, W likewise around the triangle
///   hit if U, V, W have no two different signs and do not sum to 0
///   t = (U A_z + V B_z + W C_z) / (U + V + W) / d_z
/// ```
///
/// Two triangles with a common edge compute the same two corners in this frame, bit by bit, and from them the same edge
/// function up to its sign. Rounding is monotonic, so the sign of a difference of rounded products is right or the
/// difference is 0; there, and for everything that is stored of a hit, products are computed in `f64`, where products
/// of two `f32` are exact. So no ray falls between them [Woop, Benthin and Wald 2013]. No operation is fused, or the
/// edge function would depend on the order of the corners.
///
/// The corners themselves are off by a few roundings: the triangles hit have their points moved by at most
/// [`SHEAR_ERROR`](crate::bvh::ray_frame::SHEAR_ERROR) · (`|A_x| + |A_z|`), each alike for all triangles that share it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShearedRay {
    origin: [f32; 3],
    /// `d_z`, the longest component of the ray's direction with its sign.
    longest: f32,
    kx: usize,
    ky: usize,
    kz: usize,
    shear: [f32; 2],
    t_max: f32,
}

impl ShearedRay {
    /// The ray of a frame, up to `t_max`.
    #[inline(always)]
    pub(crate) fn new(origin: [f32; 3], frame: &RayFrame, t_max: f32) -> Self {
        let kz = frame.kz as usize;
        let longest = frame.longest.copysign(frame.direction[kz % 3]);
        Self { origin, longest, kx: (kz + 1) % 3, ky: (kz + 2) % 3, kz, shear: frame.shear, t_max }
    }

    /// The lanes whose triangle may be hit, by the signs of rounded edge functions: conservative.
    #[inline(always)]
    pub(crate) fn candidates<L: Lanes>(&self, lanes: L, corners: &[[[f32; WIDTH]; 3]; 3]) -> u32 {
        let [kx, ky, kz] = [self.kx % 3, self.ky % 3, self.kz % 3];
        let origin = self.origin.map(|o| lanes.splat(o));
        let shear = self.shear.map(|s| lanes.splat(s));
        let mut x = [lanes.splat(0.0); 3];
        let mut y = x;
        for (k, corner) in corners.iter().enumerate() {
            let z = lanes.sub(lanes.load(&corner[kz]), origin[kz]);
            x[k] = lanes.sub(lanes.sub(lanes.load(&corner[kx]), origin[kx]), lanes.mul(shear[0], z));
            y[k] = lanes.sub(lanes.sub(lanes.load(&corner[ky]), origin[ky]), lanes.mul(shear[1], z));
        }
        let edge = |b: usize, c: usize| lanes.sub(lanes.mul(x[c], y[b]), lanes.mul(y[c], x[b]));
        let (u, v, w) = (edge(1, 2), edge(2, 0), edge(0, 1));
        let zero = lanes.splat(0.0);
        let least = lanes.min(lanes.min(u, v), w);
        let most = lanes.max(lanes.max(u, v), w);
        !(lanes.less(least, zero) & lanes.less(zero, most)) & ((1 << WIDTH) - 1)
    }

    /// The hit of one triangle, if it lies beyond 0 and up to the ray's end.
    #[inline(always)]
    pub(crate) fn hit(&self, corners: [[f32; 3]; 3], triangle: u32) -> Option<Hit> {
        let [kx, ky, kz] = [self.kx % 3, self.ky % 3, self.kz % 3];
        let relative = corners.map(|p| [p[kx] - self.origin[kx], p[ky] - self.origin[ky], p[kz] - self.origin[kz]]);
        let sheared = relative
            .map(|p| [f64::from(p[0] - self.shear[0] * p[2]), f64::from(p[1] - self.shear[1] * p[2]), f64::from(p[2])]);
        let edge = |b: usize, c: usize| sheared[c][0] * sheared[b][1] - sheared[c][1] * sheared[b][0];
        let weights = [edge(1, 2), edge(2, 0), edge(0, 1)];
        if weights.iter().any(|&w| w < 0.0) && weights.iter().any(|&w| w > 0.0) {
            return None;
        }
        let sum = weights[0] + weights[1] + weights[2];
        if sum == 0.0 {
            return None;
        }
        let depth = weights[0] * sheared[0][2] + weights[1] * sheared[1][2] + weights[2] * sheared[2][2];
        let t = (depth / (sum * f64::from(self.longest))) as f32;
        let is_on_ray = t > 0.0 && t <= self.t_max;
        is_on_ray.then_some(Hit { t, triangle, u: (weights[1] / sum) as f32, v: (weights[2] / sum) as f32 })
    }
}
