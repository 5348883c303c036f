//! Receivers: the points that transfer is baked for.

use glam::Vec3;
use lobe_io::Fingerprint;
use lobe_scene::Scene;

use crate::error::PrtError;
use crate::receivers::inset::inset_positions;
use crate::receivers::planes::Planes;

/// The largest deviation of the length of a normal from 1: it was rounded, not scaled.
const UNIT_TOLERANCE: f32 = 1e-3;

/// Where a normal is farther off that of its triangle than the angle of this cosine, rays that are lifted along it would start too near
/// the surface, or below. A normal map may tilt it so far, and at the texels near a corner of a coarse body so does the normal of the
/// vertex: that of a smooth tetrahedron has the cosine 1/3 there.
const FAR_OFF: f32 = 0.5;

/// Points that receive light and send it back: each has a unit normal on its lit side and an albedo.
///
/// Those of a scene know the planes of the triangles they lie on. Light from above the normal to shade with but below
/// all these planes would come through the surface: receivers get none, in any mode that traces rays, as
/// surfaces that paths meet get none from below the plane of the triangle.
#[derive(Clone, Debug, PartialEq)]
pub struct Receivers {
    positions: Vec<[f32; 3]>,
    /// Where their other sides are; none at all if these are at the same positions.
    back_positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    albedos: Vec<[f32; 3]>,
    planes: Planes,
}

impl Receivers {
    /// Receivers with these positions, unit normals and linear albedos, on no triangles. Positions count from
    /// [`Scene::origin`].
    ///
    /// # Errors
    /// [`PrtError::Invalid`] if there are none, the lengths differ, a number is not finite, a normal is not of unit
    /// length to 1e-3, or an albedo is negative.
    pub fn new(positions: Vec<[f32; 3]>, normals: Vec<[f32; 3]>, albedos: Vec<[f32; 3]>) -> Result<Self, PrtError> {
        let invalid = |message: String| Err(PrtError::invalid("receivers", message));
        let (count, n, a) = (positions.len(), normals.len(), albedos.len());
        if count == 0 {
            return invalid("expected at least one, found none".to_string());
        }
        if n != count || a != count {
            return invalid(format!("expected a normal and an albedo for each of {count}, found {n} and {a}"));
        }
        for i in 0..count {
            let finite = |v: [f32; 3]| v.iter().all(|c| c.is_finite());
            let (position, normal, albedo) = (positions[i], normals[i], albedos[i]);
            if !finite(position) {
                return invalid(format!("expected finite positions, found {position:?} at {i}"));
            }
            if !finite(normal) || (Vec3::from(normal).length() - 1.0).abs() > UNIT_TOLERANCE {
                return invalid(format!("expected unit normals, found {normal:?} at {i}"));
            }
            if !finite(albedo) || albedo.iter().any(|&c| c < 0.0) {
                return invalid(format!("expected finite albedos of at least 0, found {albedo:?} at {i}"));
            }
        }
        Ok(Self { positions, back_positions: Vec::new(), normals, albedos, planes: Planes::default() })
    }

    /// Writes all of them into a fingerprint.
    pub(crate) fn write_into(&self, fingerprint: &mut Fingerprint) {
        for points in [&self.positions, &self.normals, &self.albedos] {
            fingerprint.floats(points.as_flattened());
        }
        self.planes.write_into(fingerprint);
    }

    /// The vertices of all meshes in their order, with the normals to shade with. The albedo is the base color: factor,
    /// texture and vertex color multiplied; metals are taken as matte.
    ///
    /// Vertices at the border of a mesh are moved into it by 2⁻¹⁷ of the largest coordinate of the scene: where a floor
    /// ends at a wall, its last vertices would else lie in the wall and see what is behind it.
    ///
    /// # Errors
    /// [`PrtError::Invalid`] if a vertex color is negative.
    pub fn at_vertices(scene: &Scene) -> Result<Self, PrtError> {
        let (mut normals, mut albedos) = (Vec::new(), Vec::new());
        for (m, mesh) in scene.meshes().iter().enumerate() {
            normals.extend_from_slice(mesh.normals());
            let albedo = |v| {
                let [r, g, b, _] = scene.vertex_base_color(m, v);
                [r, g, b]
            };
            albedos.extend((0..mesh.positions().len()).map(albedo));
        }
        let [positions, back_positions] = inset_positions(scene);
        let receivers = Self { back_positions, ..Self::new(positions, normals, albedos)? };
        Ok(receivers.on(Planes::at_vertices(scene)))
    }

    /// The other sides of the same vertices: [`Receivers::at_vertices`] of meshes turned inside out, for open meshes
    /// that are seen from both sides.
    ///
    /// # Errors
    /// As [`Receivers::at_vertices`].
    pub fn back_of_vertices(scene: &Scene) -> Result<Self, PrtError> {
        let front = Self::at_vertices(scene)?;
        front.backs(&(0..front.len()).collect::<Vec<_>>())
    }

    /// The other sides of some of them, in this order: their normals turned round. Vertices at the border of a mesh are
    /// moved into it as seen from that side.
    ///
    /// # Errors
    /// [`PrtError::Invalid`] if `which` is empty.
    ///
    /// # Panics
    /// If there is no such receiver.
    pub fn backs(&self, which: &[usize]) -> Result<Self, PrtError> {
        self.select(which, -1.0)
    }

    /// Some of them, in this order.
    ///
    /// # Errors
    /// [`PrtError::Invalid`] if `which` is empty.
    ///
    /// # Panics
    /// If there is no such receiver.
    pub fn subset(&self, which: &[usize]) -> Result<Self, PrtError> {
        self.select(which, 1.0)
    }

    /// Some of them, their normals multiplied by 1 or -1.
    fn select(&self, which: &[usize], factor: f32) -> Result<Self, PrtError> {
        let some = |all: &[[f32; 3]]| -> Vec<[f32; 3]> { which.iter().map(|&i| all[i]).collect() };
        let (positions, back_positions) = match (self.back_positions.is_empty(), factor < 0.0) {
            (true, _) => (some(&self.positions), Vec::new()),
            (false, false) => (some(&self.positions), some(&self.back_positions)),
            (false, true) => (some(&self.back_positions), some(&self.positions)),
        };
        let normals = which.iter().map(|&i| self.normals[i].map(|c| factor * c)).collect();
        let selected = Self { back_positions, ..Self::new(positions, normals, some(&self.albedos))? };
        Ok(selected.on(self.planes.select(which, factor)))
    }

    /// The same receivers on triangles of these planes.
    pub(crate) fn on(self, planes: Planes) -> Self {
        Self { planes, ..self }
    }

    /// Moves a receiver along its surface.
    pub(crate) fn move_to(&mut self, receiver: usize, position: [f32; 3]) {
        self.positions[receiver] = position;
    }

    /// The number of receivers, at least one.
    #[must_use]
    #[expect(clippy::len_without_is_empty, reason = "there is at least one")]
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Their positions.
    #[must_use]
    pub fn positions(&self) -> &[[f32; 3]] {
        &self.positions
    }

    /// Unit vectors towards their lit side.
    #[must_use]
    pub fn normals(&self) -> &[[f32; 3]] {
        &self.normals
    }

    /// The part of the light that each sends back, by channel.
    #[must_use]
    pub fn albedos(&self) -> &[[f32; 3]] {
        &self.albedos
    }

    /// The unit normals of the planes of the triangles that a receiver lies on, on its lit side; none if one of them is
    /// its own normal.
    ///
    /// # Panics
    /// If there is no such receiver.
    #[must_use]
    pub fn planes(&self, receiver: usize) -> &[[f32; 3]] {
        assert!(receiver < self.len(), "receiver {receiver} of {}", self.len());
        self.planes.of(receiver)
    }

    /// The unit vector along which the rays of a receiver are [lifted](lobe_scene::Bvh::origin_above) above its surface: its normal, or
    /// that of its triangle if it lies on one alone and the two are more than 60° off each other.
    ///
    /// # Panics
    /// If there is no such receiver.
    #[must_use]
    pub fn lift(&self, receiver: usize) -> [f32; 3] {
        lift_of(self.normals[receiver], self.planes(receiver))
    }

    /// Whether all albedos are gray.
    #[must_use]
    pub fn is_gray(&self) -> bool {
        self.albedos.iter().all(|[r, g, b]| r == g && g == b)
    }
}

/// The vector along which rays are lifted above a point with this normal on triangles in these planes.
pub(crate) fn lift_of(normal: [f32; 3], planes: &[[f32; 3]]) -> [f32; 3] {
    match planes {
        [plane] if Vec3::from(*plane).dot(Vec3::from(normal)) < FAR_OFF => *plane,
        _ => normal,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_scene::built_in;

    #[test]
    fn vertices_come_in_the_order_of_the_meshes() {
        let scene = built_in::ball_over_ground(8);
        let receivers = Receivers::at_vertices(&scene).unwrap();
        assert_eq!(receivers.len(), scene.vertex_count(), "all vertices");
        let ground = scene.meshes()[0].positions().len();
        assert_eq!(receivers.albedos()[0], [0.6; 3], "the ground first");
        assert_eq!(receivers.albedos()[ground], [0.7, 0.25, 0.2], "then the ball");
        let [fronts, backs] = inset_positions(&scene);
        assert_eq!(receivers.positions()[ground], fronts[ground], "its first vertex");
        assert!(!receivers.is_gray(), "the ball is red");
        let back = Receivers::back_of_vertices(&scene).unwrap();
        assert_eq!(back.normals()[0], [0.0, 0.0, -1.0], "the ground from below");
        assert_eq!(back.positions(), backs, "where backs are");
        let all: Vec<usize> = (0..back.len()).collect();
        assert_eq!(back.backs(&all).unwrap().positions(), fronts, "the backs of backs");
        let some = receivers.backs(&[ground, 0]).unwrap();
        assert_eq!((some.len(), some.albedos()[1]), (2, [0.6; 3]), "the ground second");
        assert_eq!(some.positions()[0], receivers.positions()[ground], "the ball first");
        assert_eq!(some.normals()[0], receivers.normals()[ground].map(|c| -c), "from inside");
        assert!(receivers.backs(&[]).is_err(), "none");
    }

    #[test]
    fn rays_are_lifted_along_the_triangle_where_the_normal_is_far_off_it() {
        let up = [0.0, 0.0, 1.0];
        for (normal, expected) in
            [(up, up), ([0.8, 0.0, 0.6], [0.8, 0.0, 0.6]), ([0.0, 0.96, 0.28], up), ([0.0, -0.6, -0.8], up)]
        {
            let mut planes = Planes::with_capacity(1);
            planes.push(normal, up, up);
            let one = Receivers::new(vec![[0.0; 3]], vec![normal], vec![[1.0; 3]]).unwrap().on(planes);
            assert_eq!(one.lift(0), expected, "the lift of {normal:?}");
        }
    }

    #[test]
    fn what_cannot_receive_is_refused_in_one_line() {
        let refusal = |p: f32, n: f32, a: f32| {
            let new = Receivers::new(vec![[p; 3]], vec![[0.0, 0.0, n]], vec![[a; 3]]);
            new.unwrap_err().to_string()
        };
        let cases = [
            (refusal(f32::NAN, 1.0, 1.0), "receivers: expected finite positions, found [NaN, NaN, NaN] at 0"),
            (refusal(0.0, 0.9, 1.0), "receivers: expected unit normals, found [0.0, 0.0, 0.9] at 0"),
            (
                refusal(0.0, 1.0, -1.0),
                "receivers: expected finite albedos of at least 0, found [-1.0, -1.0, -1.0] at 0",
            ),
            (
                Receivers::new(vec![], vec![], vec![]).unwrap_err().to_string(),
                "receivers: expected at least one, found none",
            ),
            (
                Receivers::new(vec![[0.0; 3]], vec![], vec![]).unwrap_err().to_string(),
                "receivers: expected a normal and an albedo for each of 1, found 0 and 0",
            ),
        ];
        for (found, expected) in cases {
            assert_eq!(found, expected, "refusal");
        }
    }
}
