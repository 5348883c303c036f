//! Triangle meshes of balloon plots.

use lobe_io::parallel;
use lobe_sh::Dir;

use crate::plot::cube::FACES;
use lobe_sh::sphere::vector::{Vec3, add, normalized, scale, sub, tangents_along_z};

/// The step of the central differences, in radians: their error and the rounding of `f` are both near 1e-8 for
/// functions of the size and smoothness of the basis.
const STEP: f64 = 1e-4;

/// A point of the surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vertex {
    /// `|f(s)| s`.
    pub(crate) position: Vec3,
    /// The outward normal.
    pub(crate) normal: Vec3,
    /// `f(s)`.
    pub(crate) value: f64,
}

/// The surface `|f(s)| s`.
#[derive(Clone, Debug)]
pub(crate) struct Mesh {
    pub(crate) vertices: Vec<Vertex>,
    pub(crate) triangles: Vec<[usize; 3]>,
}

impl Mesh {
    /// The surface over the six faces of the cube, with `cells × cells` pairs of triangles on each.
    pub(crate) fn of(cells: usize, f: &(dyn Fn(Dir) -> f64 + Sync)) -> Self {
        let side = cells + 1;
        // Equal angles along the face instead of equal lengths: the triangles are of nearly equal size.
        let at = |k: usize| (std::f64::consts::FRAC_PI_4 * (2.0 * k as f64 / cells as f64 - 1.0)).tan();
        let vertex = |i: usize| {
            let (face, y, x) = (i / (side * side), i / side % side, i % side);
            vertex(f, FACES[face].dir(at(x), at(y)))
        };
        let vertices = parallel::map(6 * side * side, &vertex);
        let mut triangles = Vec::with_capacity(12 * cells * cells);
        for face in 0..6 {
            for y in 0..cells {
                for x in 0..cells {
                    let i = (face * side + y) * side + x;
                    triangles.extend([[i, i + 1, i + side], [i + 1, i + side + 1, i + side]]);
                }
            }
        }
        Self { vertices, triangles }
    }

    /// The largest finite distance from the origin.
    pub(crate) fn extent(&self) -> f64 {
        self.vertices.iter().map(|v| v.value.abs()).filter(|r| r.is_finite()).fold(0.0, f64::max)
    }
}

/// The surface point towards `s`.
///
/// ```text
///   X(s) = r s,   r = |f|        normal ∝ r s - ∇r,   ∇r = sign(f) ∇f, the gradient along the sphere
/// ```
fn vertex(f: &dyn Fn(Dir) -> f64, s: Dir) -> Vertex {
    let value = f(s);
    let s = s.to_array();
    let mut normal = scale(s, value.abs());
    for tangent in tangents_along_z(s) {
        let shifted = |t: f64| Dir::new(add(s, scale(tangent, t))).map_or(value, f);
        let slope = (shifted(STEP) - shifted(-STEP)) / (2.0 * STEP);
        normal = sub(normal, scale(tangent, slope * value.signum()));
    }
    Vertex { position: scale(s, value.abs()), normal: normalized(normal), value }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_sh::sphere::vector::dot;

    #[test]
    fn the_surface_of_a_linear_function_is_two_spheres() {
        // |z| s lies on the spheres of radius 1/2 about (0, 0, ±1/2).
        for v in Mesh::of(9, &Dir::z).vertices {
            let center = [0.0, 0.0, 0.5_f64.copysign(v.value)];
            let outward = sub(v.position, center);
            assert!((dot(outward, outward).sqrt() - 0.5).abs() < 1e-12, "{:?} is not on the sphere", v.position);
            let off = sub(v.normal, scale(outward, 2.0));
            assert!(v.value.abs() < 1e-9 || dot(off, off).sqrt() < 1e-6, "normal {:?} at {:?}", v.normal, v.position);
        }
    }

    #[test]
    fn a_constant_is_a_sphere_of_that_radius() {
        let mesh = Mesh::of(4, &|_| -2.0);
        assert_eq!((mesh.vertices.len(), mesh.triangles.len()), (6 * 25, 12 * 16), "vertices and triangles");
        assert_eq!(mesh.extent(), 2.0, "the radius is |f|");
    }
}
