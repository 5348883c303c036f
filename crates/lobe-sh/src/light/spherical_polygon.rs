//! The exact expansion of a polygon of constant radiance, by integrals along its edges.

use core::f64::consts::PI;

use crate::basis::basis::Basis;
use crate::basis::index::{band_range, coefficient_index, order_of_slice};
use crate::error::ShError;
use crate::expansion::ShVec;
use crate::prelude::*;
use crate::rotation::Rotation;
use crate::sphere::Dir;
use crate::sphere::vector::{cross, dot, length, sub};

/// Two vertices whose directions are nearer to opposite than this (the sine of the angle) leave the great circle
/// between them undetermined: the receiver lies on the edge.
const ANTIPODAL_SINE: f64 = 1e-12;

/// The length of the vector irradiance (that of a hemisphere is π) from which on it gives the middle direction in place
/// of the sum of the vertices, which lies in the plane for a polygon around a receiver in that plane. Small polygons
/// use the vertices, because their vector irradiance is a difference of large terms.
const LARGE: f64 = 0.1;

/// A solid angle that exceeds half of the sphere by this fraction is half of the sphere but for rounding.
const HALF_TURN_ROUNDING: f64 = 1e-12;

/// A polygon as seen from the origin, of radiance 1 from both sides, its edges arcs of great circles.
///
/// The inside of the contour is the smaller of its two sides, so the vertices may run either way round, as the edge of
/// a window does when seen from inside and from outside. If both are equal, because the receiver lies in the plane of
/// the polygon and inside it, the inside is the hemisphere to the left of the contour. Concave contours need no
/// triangulation; in one that crosses itself each loop counts with its orientation.
///
/// By Stokes' theorem, because `Δy = -l(l+1) y`, the integral over the inside is one along the contour:
///
/// ```text
///   f_lm = ∫ y_lm ds = 1/(l(l+1)) Σ_e ∫_0^γ n_e · ∇y_lm dt                  l >= 1
/// ```
///
/// with `γ` the length of edge `e` and `n_e` the normal of its great circle, which points inside. In the frame of the
/// edge, where it runs along the equator from +x, the derivative northwards is a constant times a sine or cosine:
///
/// ```text
///   e_lm = 1/(l(l+1)) P̄_l^m'(0) sin(mγ)/m        e_l-m = 1/(l(l+1)) P̄_l^m'(0) (1 - cos mγ)/m        e_l0: γ for sin(mγ)/m
/// ```
///
/// These numbers, rotated from that frame into the world and summed over the edges, are the coefficients: exact at
/// every order, at the cost of one rotation for each edge. `P̄_l^m` is that of [`Basis`]; its derivative
/// at 0 vanishes for even `l - m`. `f_00` is the solid angle over `√(4π)`, from signed triangles (Van Oosterom and
/// Strackee 1983). The same boundary integral, for zonal functions and from three recurrences, is in [Wang and
/// Ramamoorthi 2018].
///
/// Errors, measured: 1e-12 against quadrature over triangles to order 10 (test
/// `polygons_equal_quadrature_over_their_triangles`). The terms of a polygon of angular size `a` are of size `a` and
/// cancel to `a²`: the relative error grows as `1e-15/a` (test `small_polygons_keep_their_digits`).
///
/// Coincident vertices and edges that run back contribute nothing. A contour without area gives zero.
///
/// [Wang and Ramamoorthi 2018]: https://doi.org/10.1145/3197517.3201291
#[derive(Clone, Debug, PartialEq)]
pub struct SphericalPolygon {
    /// Relative to the receiver, of any length.
    vertices: Vec<[f64; 3]>,
}

impl SphericalPolygon {
    /// The polygon of these vertices, given relative to the receiver, at any distance.
    ///
    /// # Errors
    /// [`ShError::Options`] for fewer than three vertices, a vertex that is not finite or is the receiver itself, and
    /// an edge whose ends lie in opposite directions, so that it passes through the receiver.
    pub fn new(vertices: Vec<[f64; 3]>) -> Result<Self, ShError> {
        if vertices.len() < 3 {
            let found = vertices.len();
            return Err(ShError::Options(format!("a polygon needs three vertices at least, found {found}")));
        }
        for (k, v) in vertices.iter().enumerate() {
            if !v.iter().all(|c| c.is_finite()) {
                return Err(ShError::Options(format!("vertex {k} of the polygon is not finite: {v:?}")));
            }
            if Dir::new(*v).is_none() {
                return Err(ShError::Options(format!("vertex {k} of the polygon is the receiver itself")));
            }
        }
        // Scale the polygon as a whole, which may be tiny or huge.
        let largest = vertices.iter().flatten().fold(0.0_f64, |m, c| m.max(c.abs()));
        let polygon = Self { vertices: vertices.into_iter().map(|v| v.map(|c| c / largest)).collect() };
        for (k, (a, b)) in polygon.edges().enumerate() {
            if dot(a, b) < 0.0 && length(cross(a, b)) <= ANTIPODAL_SINE * length(a) * length(b) {
                return Err(ShError::Options(format!(
                    "edge {k} of the polygon passes through the receiver: its ends lie in opposite directions"
                )));
            }
        }
        Ok(polygon)
    }

    /// The vertices relative to the receiver, scaled together so that the largest component is 1.
    #[must_use]
    pub fn vertices(&self) -> &[[f64; 3]] {
        &self.vertices
    }

    /// The part of a plane polygon above the horizon of `normal`, which is what lights the surface; empty if there is
    /// none.
    ///
    /// The polygon is clipped by the plane of the horizon. Pieces of a concave polygon stay joined along that plane,
    /// where their edges cancel.
    #[must_use]
    pub fn above(&self, normal: Dir) -> Self {
        let n = normal.to_array();
        let mut vertices = Vec::with_capacity(self.vertices.len() + 2);
        for (a, b) in self.edges() {
            let (height_a, height_b) = (dot(n, a), dot(n, b));
            if height_a >= 0.0 {
                vertices.push(a);
            }
            if (height_a >= 0.0) != (height_b >= 0.0) {
                let t = height_a / (height_a - height_b);
                vertices.push([0, 1, 2].map(|k| a[k] + t * (b[k] - a[k])));
            }
        }
        Self { vertices }
    }

    /// The solid angle inside, in `[0, 2π]`.
    #[must_use]
    pub fn solid_angle(&self) -> f64 {
        self.signed_solid_angle().abs()
    }

    /// The vector irradiance `∫ s ds` over the inside: a surface of normal `n` with all of the polygon above its
    /// horizon receives `n` times it (Lambert).
    ///
    /// ```text
    ///   ½ Σ_e γ_e n_e
    /// ```
    #[must_use]
    pub fn vector_irradiance(&self) -> [f64; 3] {
        let sign = orientation(self.signed_solid_angle());
        self.of_left_side().map(|c| sign * c)
    }

    /// `∫ s ds` over what lies to the left of the contour.
    fn of_left_side(&self) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for (a, b) in self.edges() {
            let normal = left_of(a, b);
            let sine = length(normal);
            if sine > 0.0 {
                let half = 0.5 * sine.atan2(dot(a, b)) / sine;
                sum = [0, 1, 2].map(|k| sum[k] + half * normal[k]);
            }
        }
        sum
    }

    /// The expansion of the polygon's light.
    #[must_use]
    pub fn project(&self, order: usize) -> ShVec<f64> {
        let mut f = ShVec::zero(order);
        self.project_into(crate::Expansion::coefficients_mut(&mut f));
        f
    }

    /// [`SphericalPolygon::project`] to the order that `out` has room for; what was there is overwritten.
    ///
    /// # Panics
    /// If `out.len()` is no perfect square.
    pub fn project_into(&self, out: &mut [f64]) {
        let order = order_of_slice(out);
        out.fill(0.0);
        if order == 0 {
            return;
        }
        let solid_angle = self.signed_solid_angle();
        let sign = orientation(solid_angle);
        let slopes = EquatorSlopes::new(order);
        let mut edge_frame = vec![0.0; out.len()];
        for edge in self.edges().filter_map(|(a, b)| Edge::new(a, b)) {
            slopes.integrate(edge.length, &mut edge_frame);
            edge.frame.apply_in_place(&mut edge_frame);
            for (f, e) in out.iter_mut().zip(&edge_frame) {
                *f += sign * e;
            }
        }
        out[0] = solid_angle.abs() / (4.0 * PI).sqrt();
    }

    fn edges(&self) -> impl Iterator<Item = ([f64; 3], [f64; 3])> + '_ {
        let next = self.vertices.iter().cycle().skip(1);
        self.vertices.iter().zip(next).map(|(a, b)| (*a, *b))
    }

    /// The sum of the triangles between every edge and a direction in the middle, in `[-2π, 2π]`: positive if the
    /// contour runs counter-clockwise as seen from outside the sphere, with its inside to the left.
    fn signed_solid_angle(&self) -> f64 {
        let Some(middle) = self.middle() else { return 0.0 };
        let sum: f64 = self.edges().map(|(a, b)| triangle_solid_angle(middle.to_array(), a, b)).sum();
        // Remove whole spheres: the smaller side is the inside.
        sum - 4.0 * PI * round_ties_even(sum / (4.0 * PI) * (1.0 - HALF_TURN_ROUNDING))
    }

    /// A direction on the side of the polygon on which its vertices lie.
    fn middle(&self) -> Option<Dir> {
        let mut vertices = [0.0; 3];
        for v in &self.vertices {
            let l = length(*v);
            vertices = [0, 1, 2].map(|k| vertices[k] + v[k] / l);
        }
        let left = self.of_left_side();
        if length(left) > LARGE {
            // Choose the side on which the vertices lie, unless their sum is nothing but rounding.
            let is_opposite = dot(left, vertices) < -LARGE * length(left);
            return Dir::new(if is_opposite { left.map(|c| -c) } else { left });
        }
        Dir::new(vertices).or_else(|| self.vertices.first().and_then(|v| Dir::new(*v)))
    }
}

/// The nearest whole number to one below 2⁵¹, the even one of two: adding 1.5·2⁵² leaves no bits for a fraction.
fn round_ties_even(x: f64) -> f64 {
    const NO_FRACTION: f64 = 6_755_399_441_055_744.0;

    (x + NO_FRACTION) - NO_FRACTION
}

/// 1 if the inside is to the left of the contour, -1 otherwise.
fn orientation(signed_solid_angle: f64) -> f64 {
    if signed_solid_angle < 0.0 { -1.0 } else { 1.0 }
}

/// `a × b`, the normal of the great circle from `a` to `b`, which lies to the left; short edges keep their digits.
fn left_of(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    cross(a, sub(b, a))
}

/// An arc of a great circle.
struct Edge {
    /// Takes +x to the start, +z to the normal of the circle, which lies to the left.
    frame: Rotation,
    length: f64,
}

impl Edge {
    /// `None` if the ends point the same way.
    fn new(a: [f64; 3], b: [f64; 3]) -> Option<Self> {
        let normal = left_of(a, b);
        let (start, pole) = (Dir::new(a)?, Dir::new(normal)?);
        let across = cross(pole.to_array(), start.to_array());
        let (x, z) = (start.to_array(), pole.to_array());
        let frame = Rotation::from_matrix([0, 1, 2].map(|k| [x[k], across[k], z[k]])).ok()?;
        Some(Self { frame, length: length(normal).atan2(dot(a, b)) })
    }
}

/// The derivatives `P̄_l^m'(0) / (l(l+1))` for odd `l - m`, zero for even, at the places `(l, m >= 0)`.
struct EquatorSlopes {
    slopes: Vec<f64>,
    order: usize,
}

impl EquatorSlopes {
    fn new(order: usize) -> Self {
        let mut slopes = vec![0.0; order * order];
        Basis::<f64>::with_shared(order, |basis| {
            for m in 0..order {
                // At z = 0 the recurrences are P_l = -b P_{l-2} and P_l' = a P_{l-1} - b P_{l-2}'.
                let (mut p_before, mut p) = (0.0, basis.diagonal(m));
                let (mut d_before, mut d) = (0.0, 0.0);
                for l in m + 1..order {
                    let step = basis.recurrence(m, l);
                    (d_before, d) = (d, step.a * p - step.b * d_before);
                    (p_before, p) = (p, -step.b * p_before);
                    slopes[coefficient_index(l, m as isize)] = d / (l * (l + 1)) as f64;
                }
            }
        });
        Self { slopes, order }
    }

    /// The integrals along the equator from `φ = 0` to `gamma` of the derivatives northwards, over `l(l+1)`.
    fn integrate(&self, gamma: f64, out: &mut [f64]) {
        out[band_range(0)].fill(0.0);
        for m in 0..self.order {
            let mf = m as f64;
            let half = (0.5 * mf * gamma).sin();
            let (cosine, sine) = if m == 0 { (gamma, 0.0) } else { ((mf * gamma).sin() / mf, 2.0 * half * half / mf) };
            for l in m.max(1)..self.order {
                let slope = self.slopes[coefficient_index(l, m as isize)];
                out[coefficient_index(l, m as isize)] = slope * cosine;
                if m > 0 {
                    out[coefficient_index(l, -(m as isize))] = slope * sine;
                }
            }
        }
    }
}

/// The solid angle of a triangle, positive if its corners run counter-clockwise as seen from outside the sphere.
///
/// ```text
///   tan(Ω/2) = a·(b × c) / (|a||b||c| + (a·b)|c| + (b·c)|a| + (c·a)|b|)
/// ```
///
/// The triple product is taken of differences, so that small triangles keep their digits.
fn triangle_solid_angle(a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> f64 {
    // Scaled to length 1, so that b - a is the difference of directions.
    let (lb, lc) = (length(b), length(c));
    let (b, c) = (b.map(|x| x / lb), c.map(|x| x / lc));
    let above = dot(a, cross(sub(b, a), sub(c, a)));
    2.0 * above.atan2(1.0 + dot(a, b) + dot(b, c) + dot(c, a))
}
