//! Solids: what is inside a surface of triangles, and how much of it is in a ball.

use std::f64::consts::PI;

use glam::DVec3;
use lobe_scene::Scene;

use crate::error::ShadowError;
use crate::spheres::far_part::Split;
use crate::spheres::overlaps::Overlaps;
use crate::spheres::patch_tree::PatchTree;

/// A surface whose signed volume is below this part of the cube of its width is taken for flat: single precision of
/// the positions alone makes up to 1e-7.
const FLAT: f64 = 1e-6;

/// The tree takes up to 400 bytes for each triangle while it is made, and counts edges of its levels in 32 bits.
const MOST_TRIANGLES: usize = 1 << 26;

/// What is inside a surface of triangles, which need not be watertight.
///
/// How far a point x is inside is its generalized winding number, the signed solid angle of the surface around it:
///
/// ```text
///   w(x) = 1/(4π) Σ_T Ω_T(x)        1 inside a closed surface, 0 outside, in between near holes
/// ```
///
/// The volume in a ball of center c and radius R is the integral of w over it,
///
/// ```text
///   V_in(c, R) = ∫_{|x - c| < R} w(x) dx = Σ_T s_T ∫_{Ω_T} min(ρ, R)³/3 dω
/// ```
///
/// where the triangle T is at the distance ρ in the direction ω from c, and `s_T` is 1 where it faces away, -1 where
/// it faces c. The second form holds for any triangles: w is the flux of the field of a charge at x through them, and
/// that field integrated over a ball of charges is `(y - c)/3` at a place y in the ball and that of a charge `4π R³/3`
/// at c outside (Newton's shell theorem). Its derivatives are areas, so they come at no cost:
///
/// ```text
///   ∂V_in/∂R = R² Σ_T (solid angle of T farther than R)      ∂V_in/∂c = -Σ_T n_T (area of T nearer than R)
/// ```
///
/// Parts of a surface that overlap count twice where they do; [`fit_spheres`](crate::fit_spheres) counts them once. A
/// surface whose triangles face inwards is turned over.
///
/// Sources: [Jacobson, Kavan and Sorkine-Hornung 2013] for w. The test
/// `balls_at_faces_edges_and_corners_of_a_cube_are_cut_in_closed_form` finds `V_in` within 1e-13 of closed forms.
///
/// ```
/// use lobe_shadow::Solid;
///
/// let [o, x, y, z] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0_f32]];
/// let corner = Solid::new([[o, y, x], [o, z, y], [o, x, z], [x, y, z]])?;
/// assert!((corner.winding_number([0.1, 0.1, 0.1]) - 1.0).abs() < 1e-12);
/// // An eighth of a small ball about the right corner is inside.
/// let eighth = std::f64::consts::PI / 6.0 * 0.5_f64.powi(3);
/// assert!((corner.volume_in_ball([0.0, 0.0, 0.0], 0.5) - eighth).abs() < 1e-12);
/// # Ok::<(), lobe_shadow::ShadowError>(())
/// ```
pub struct Solid {
    tree: PatchTree,
    /// What the winding number counts too much; nothing until it is known.
    overlaps: Overlaps,
}

impl Solid {
    /// The solid inside triangles, given by their corners, counter-clockwise as seen from outside.
    ///
    /// # Errors
    /// [`ShadowError::Options`] if there are none, more than 2²⁶, a corner is not finite, or they are flat: without
    /// volume.
    pub fn new(corners: impl IntoIterator<Item = [[f32; 3]; 3]>) -> Result<Self, ShadowError> {
        let corners: Vec<_> = corners.into_iter().collect();
        if corners.is_empty() {
            return Err(ShadowError::Options("expected a mesh with triangles, found none".to_owned()));
        }
        if corners.len() > MOST_TRIANGLES {
            let message = format!("expected at most {MOST_TRIANGLES} triangles, found {}", corners.len());
            return Err(ShadowError::Options(message));
        }
        if let Some(bad) = corners.iter().position(|t| t.iter().flatten().any(|x| !x.is_finite())) {
            let message = format!("expected finite corners, found {:?} at triangle {bad}", corners[bad]);
            return Err(ShadowError::Options(message));
        }
        let mut solid = Self { tree: PatchTree::new(corners.into_iter()), overlaps: Overlaps::default() };
        let [min, max] = solid.tree.bounds();
        let volume = solid.signed_volume();
        let width = (max - min).max_element();
        if volume.abs() <= FLAT * width.powi(3) {
            let message = format!(
                "expected a mesh around a volume, found one of volume {volume:.3e} in a box {width:.3e} wide; give \
                 sheets a thickness"
            );
            return Err(ShadowError::Options(message));
        }
        if volume < 0.0 {
            solid.tree.turn_over();
        }
        Ok(solid)
    }

    /// The solid inside all meshes of a scene, in the frame of its positions.
    ///
    /// # Errors
    /// As [`Solid::new`].
    pub fn of_scene(scene: &Scene) -> Result<Self, ShadowError> {
        Self::new(scene.corners())
    }

    /// The generalized winding number of a point. On the surface it is the mean of those of its two sides, to
    /// rounding.
    #[must_use]
    pub fn winding_number(&self, point: [f64; 3]) -> f64 {
        self.winding(point.into())
    }

    /// `V_in`, the volume of the solid in a ball; of any radius, 0 and infinity among them for none and all of a
    /// closed one.
    #[must_use]
    pub fn volume_in_ball(&self, center: [f64; 3], radius: f64) -> f64 {
        self.inside(center.into(), radius)
    }

    /// The volume of a ball outside the solid (SOTV), `4π R³/3 - V_in`.
    #[must_use]
    pub fn volume_outside(&self, center: [f64; 3], radius: f64) -> f64 {
        self.outside(center.into(), radius)
    }

    /// The derivatives of [`Solid::volume_outside`] by the center and by the radius.
    #[must_use]
    pub fn volume_outside_slope(&self, center: [f64; 3], radius: f64) -> ([f64; 3], f64) {
        let (_, by_center, by_radius) = self.outside_and_slope(center.into(), radius);
        (by_center.to_array(), by_radius)
    }

    /// Whether every edge is used as often in one direction as in the other, so that w is a whole number everywhere.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.tree.is_closed()
    }

    /// The signed volume of the cones from the middle of the bounding box to all triangles: of a closed surface, its
    /// volume.
    #[must_use]
    pub fn signed_volume(&self) -> f64 {
        let [min, max] = self.tree.bounds();
        self.tree.cone_volume(0.5 * (min + max))
    }

    /// The solid whose volumes count overlaps once.
    pub(crate) fn without(self, overlaps: Overlaps) -> Self {
        Self { overlaps, ..self }
    }

    pub(crate) fn tree(&self) -> &PatchTree {
        &self.tree
    }

    pub(crate) fn winding(&self, point: DVec3) -> f64 {
        self.tree.angle(point) / (4.0 * PI)
    }

    pub(crate) fn inside(&self, center: DVec3, radius: f64) -> f64 {
        if radius <= 0.0 {
            return 0.0;
        }
        volume(&self.tree.seen(center, radius), radius) - self.overlaps.in_ball(center, radius).0
    }

    pub(crate) fn outside(&self, center: DVec3, radius: f64) -> f64 {
        4.0 / 3.0 * PI * radius.powi(3) - self.inside(center, radius)
    }

    /// The volume outside, and its derivatives by the center and by the radius.
    pub(crate) fn outside_and_slope(&self, center: DVec3, radius: f64) -> (f64, DVec3, f64) {
        if radius <= 0.0 {
            return (0.0, DVec3::ZERO, 0.0);
        }
        let seen = self.tree.seen(center, radius);
        let (excess, by_center, by_radius) = self.overlaps.in_ball(center, radius);
        let outside = 4.0 / 3.0 * PI * radius.powi(3) - volume(&seen, radius) + excess;
        (outside, seen.near_area + by_center, radius * radius * (4.0 * PI - seen.far_angle) + by_radius)
    }
}

/// `V_in` of what a ball sees.
fn volume(seen: &Split, radius: f64) -> f64 {
    // Nothing is farther than infinity.
    let far = if seen.far_angle == 0.0 { 0.0 } else { radius.powi(3) / 3.0 * seen.far_angle };
    seen.near_volume + far
}
