//! Polygon light: Lambert's formula for irradiance, clipped at the horizon.

use lobe_sh::Dir;

use crate::area_light::area_light::from_vec3;
use crate::area_light::area_light::{AreaLight, PointLight};
use crate::area_light::vector_irradiance::VectorIrradiance;
use crate::error::EnvError;
use lobe_sh::sphere::vector::{Vec3, add_scaled, cross, dot, length, sub};

/// A plane polygon, convex or not, that emits radiance 1 to the side from which its vertices run counter-clockwise.
///
/// Lambert's formula ([Baum, Rushmeier and Winget 1989]): with the vertices `v_i` as seen from the receiver,
///
/// ```text
///   e = ½ Σ_i γ_i (v_{i+1} × v_i)/|v_{i+1} × v_i|        γ_i = the angle between v_i and v_{i+1}
///   E = n·e of the polygon, cut along the horizon of n
/// ```
///
/// The sum comes from Stokes' theorem, so concave polygons need no triangles; those parts of the cut that run along the
/// horizon cancel where they overlap. Each cross product is formed from `v_i` and the edge, `γ` with `atan2`. For small
/// polygons the terms, of size `a/d`, cancel to `(a/d)²`: the relative error grows to `1e-15 d/a` (test
/// `small_polygons_keep_their_digits`).
///
/// Degenerate cases: a receiver behind the polygon or in its plane (edge-on) gets 0, so does one on the polygon itself;
/// a polygon without area gives 0. Vertices that do not lie in a plane, or edges that cross, are the caller's error:
/// the sum is still that of the contour, the side is that of the mean normal.
///
/// [Baum, Rushmeier and Winget 1989]: https://doi.org/10.1145/74334.74367
#[derive(Clone, Debug, PartialEq)]
pub struct PolygonLight {
    vertices: Vec<Vec3>,
    /// `½ Σ v_i × v_{i+1}` about the first vertex: the normal, as long as the area.
    area: Vec3,
    centroid: Vec3,
}

impl PolygonLight {
    /// The polygon of these vertices.
    ///
    /// # Errors
    /// [`EnvError::Options`] for fewer than three vertices, or if a coordinate is not finite.
    pub fn new(vertices: Vec<[f64; 3]>) -> Result<Self, EnvError> {
        if vertices.len() < 3 {
            return Err(EnvError::Options(format!(
                "a polygon needs three vertices at least, found {}",
                vertices.len()
            )));
        }
        if let Some(v) = vertices.iter().find(|v| !v.iter().all(|c| c.is_finite())) {
            return Err(EnvError::Options(format!("a polygon needs finite vertices, found {v:?}")));
        }
        let (area, centroid) = area_and_centroid(&vertices);
        Ok(Self { vertices, area, centroid })
    }

    /// The rectangle (or parallelogram) `center ± half_u ± half_v` that shines towards `half_u × half_v`.
    ///
    /// # Errors
    /// [`EnvError::Options`] if a coordinate is not finite.
    pub fn rectangle(center: [f64; 3], half_u: [f64; 3], half_v: [f64; 3]) -> Result<Self, EnvError> {
        let corner = |u: f64, v: f64| add_scaled(add_scaled(center, half_u, u), half_v, v);
        Self::new(vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)])
    }

    /// The vertices, counter-clockwise as seen from the side that shines.
    #[must_use]
    pub fn vertices(&self) -> &[[f64; 3]] {
        &self.vertices
    }

    /// The area.
    #[must_use]
    pub fn area(&self) -> f64 {
        length(self.area)
    }

    /// The vertices as seen from `point`; `None` from behind or edge-on.
    fn seen_from(&self, point: Vec3) -> Option<Vec<Vec3>> {
        let in_front = dot(self.area, sub(point, self.vertices[0])) > 0.0;
        in_front.then(|| self.vertices.iter().map(|v| sub(*v, point)).collect())
    }
}

impl AreaLight for PolygonLight {
    fn irradiance(&self, point: [f64; 3], normal: Dir) -> f64 {
        let n = normal.to_array();
        self.seen_from(point).map_or(0.0, |contour| dot(n, contour_vector(&above_horizon(&contour, n))).max(0.0))
    }

    fn vector_irradiance(&self, point: [f64; 3]) -> VectorIrradiance<f64> {
        self.seen_from(point).map_or_else(VectorIrradiance::default, |contour| from_vec3(contour_vector(&contour)))
    }

    fn as_point(&self) -> PointLight {
        // A polygon without area shines nowhere, whatever its normal.
        PointLight { position: self.centroid, normal: Some(Dir::new(self.area).unwrap_or(Dir::Z)), area: self.area() }
    }
}

/// The area vector of a plane polygon and the centroid of its area; the mean of the vertices where it has none.
fn area_and_centroid(vertices: &[Vec3]) -> (Vec3, Vec3) {
    let origin = vertices[0];
    let triangles = || vertices.windows(2).skip(1).map(|pair| (sub(pair[0], origin), sub(pair[1], origin)));
    let mut area = [0.0; 3];
    for (a, b) in triangles() {
        area = add_scaled(area, cross(a, b), 0.5);
    }
    let square = dot(area, area);
    let mut centroid = origin;
    if square > 0.0 {
        for (a, b) in triangles() {
            let share = 0.5 * dot(cross(a, b), area) / square;
            centroid = add_scaled(add_scaled(centroid, a, share / 3.0), b, share / 3.0);
        }
    } else {
        for v in vertices {
            centroid = add_scaled(centroid, sub(*v, origin), 1.0 / vertices.len() as f64);
        }
    }
    (area, centroid)
}

/// `∫ s ds` over the inside of a closed contour around the origin, clockwise as seen from there.
fn contour_vector(contour: &[Vec3]) -> Vec3 {
    let mut sum = [0.0; 3];
    for (i, &a) in contour.iter().enumerate() {
        let b = contour[(i + 1) % contour.len()];
        // b × a = -(a × (b - a))
        let normal = cross(sub(b, a), a);
        let sine = length(normal);
        if sine > 0.0 {
            sum = add_scaled(sum, normal, 0.5 * sine.atan2(dot(a, b)) / sine);
        }
    }
    sum
}

/// The part of a contour where `n·v >= 0`, closed along the horizon.
fn above_horizon(contour: &[Vec3], n: Vec3) -> Vec<Vec3> {
    let mut above = Vec::with_capacity(contour.len() + 2);
    for (i, &a) in contour.iter().enumerate() {
        let b = contour[(i + 1) % contour.len()];
        let (height_a, height_b) = (dot(n, a), dot(n, b));
        if height_a >= 0.0 {
            above.push(a);
        }
        if (height_a >= 0.0) != (height_b >= 0.0) {
            above.push(add_scaled(a, sub(b, a), height_a / (height_a - height_b)));
        }
    }
    above
}
