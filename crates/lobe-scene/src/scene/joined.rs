//! Scenes taken apart and put together: some of the meshes, the same meshes elsewhere, and those of several scenes in one.
//! Meshes were checked when they were made, and keep all of their triangles, those that have lost their area in a pose too.

use std::collections::HashMap;

use glam::{DAffine3, DMat3, DVec3};

use crate::error::SceneError;
use crate::scene::mesh::Mesh;
use crate::scene::scene::Scene;

impl Scene {
    /// The scene of some of its meshes, in their order, with the materials and textures that they use.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] without any mesh.
    ///
    /// # Panics
    /// If there is no such mesh.
    pub fn part(&self, meshes: impl IntoIterator<Item = usize>) -> Result<Self, SceneError> {
        let meshes = meshes.into_iter().map(|index| self.meshes()[index].clone()).collect();
        Ok(self.of_meshes(meshes)?.moved(self.origin()))
    }

    /// The scene of other meshes that are of materials of this one, with those that they use and their textures.
    pub(crate) fn of_meshes(&self, meshes: Vec<Mesh>) -> Result<Self, SceneError> {
        let (mut materials, mut textures) = (Kept::default(), Kept::default());
        let meshes = meshes.into_iter().map(|mesh| {
            let material = mesh.material().map(|index| materials.place_of(index));
            mesh.with_material(material)
        });
        let meshes = meshes.collect();
        let material = |&index: &usize| {
            let mut material = self.materials()[index].clone();
            material.textures_mut().for_each(|used| used.texture = textures.place_of(used.texture));
            material
        };
        let materials = materials.all.iter().map(material).collect();
        let textures = textures.all.iter().map(|&index| self.textures()[index].clone()).collect();
        Self::new(meshes, materials, textures)
    }

    /// The same scene under an affine map, three rows `[a, b, c, t]`: a point p of the world goes to `(a b c) p + t`, normals by
    /// the inverse transpose. A map that mirrors turns the corners of triangles around, so that their fronts stay fronts.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] if the map is not finite or flattens space, or moves points beyond what `f32` holds.
    pub fn mapped(self, map: [[f64; 4]; 3]) -> Result<Self, SceneError> {
        let column = |k: usize| DVec3::new(map[0][k], map[1][k], map[2][k]);
        let linear = DMat3::from_cols(column(0), column(1), column(2));
        let affine = DAffine3::from_mat3_translation(linear, column(3));
        let determinant = linear.determinant();
        if !affine.is_finite() || determinant == 0.0 || !determinant.is_finite() {
            return Err(SceneError::invalid("scene", format!("expected a map that can be undone, found {map:?}")));
        }
        // Relative to where the origin goes, numbers stay as precise as they are.
        let origin = affine.transform_point3(DVec3::from(self.origin()));
        let normals = linear.inverse().transpose();
        let (meshes, materials, textures) = self.into_parts();
        let meshes = meshes.into_iter().map(|mesh| mapped_mesh(mesh, linear, normals, determinant < 0.0));
        Ok(Self::new(meshes.collect::<Result<_, _>>()?, materials, textures)?.moved(origin.to_array()))
    }

    /// The meshes of all parts in one scene, in this order, each with its materials.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] without any part, with more than 2³² - 1 triangles, or if parts are farther from each other than
    /// numbers of `f32` reach.
    pub fn joined(parts: impl IntoIterator<Item = Self>) -> Result<Self, SceneError> {
        let (mut meshes, mut materials, mut textures) = (Vec::new(), Vec::new(), Vec::new());
        let mut first = None;
        for part in parts {
            let origin = *first.get_or_insert(part.origin());
            let from = DVec3::from(part.origin()) - DVec3::from(origin);
            let (part_meshes, part_materials, part_textures) = part.into_parts();
            for mesh in part_meshes {
                let material = mesh.material().map(|index| index + materials.len());
                let mesh = mesh.with_material(material);
                let there = |p: [f32; 3]| (DVec3::from(p.map(f64::from)) + from).as_vec3().to_array();
                meshes.push(if from == DVec3::ZERO { mesh } else { mesh.mapped(there, |n| n, |t| t, false)? });
            }
            materials.extend(part_materials.into_iter().map(|mut material| {
                material.textures_mut().for_each(|used| used.texture += textures.len());
                material
            }));
            textures.extend(part_textures);
        }
        Ok(Self::new(meshes, materials, textures)?.moved(first.unwrap_or_default()))
    }
}

/// Indices of what is kept of a list, in the order in which it was asked for.
#[derive(Default)]
struct Kept {
    all: Vec<usize>,
    places: HashMap<usize, usize>,
}

impl Kept {
    /// The place of `index` among what is kept.
    fn place_of(&mut self, index: usize) -> usize {
        *self.places.entry(index).or_insert_with(|| {
            self.all.push(index);
            self.all.len() - 1
        })
    }
}

fn mapped_mesh(mesh: Mesh, linear: DMat3, normals: DMat3, is_mirror: bool) -> Result<Mesh, SceneError> {
    let vector = |v: [f32; 3]| DVec3::from(v.map(f64::from));
    let position = |p| (linear * vector(p)).as_vec3().to_array();
    let normal = |n| (normals * vector(n)).normalize_or_zero().as_vec3().to_array();
    let tangent = |t| (linear * vector(t)).normalize_or_zero().as_vec3().to_array();
    mesh.mapped(position, normal, tangent, is_mirror)
}

#[cfg(test)]
mod tests {
    use crate::built_in;
    use crate::bvh::bvh::Bvh;
    use crate::scene::mesh::{Mesh, MeshParts};
    use crate::scene::ray::Ray;
    use crate::scene::scene::Scene;

    const TURNED: [[f64; 4]; 3] = [[0.0, -2.0, 0.0, 1.0], [2.0, 0.0, 0.0, 2.0], [0.0, 0.0, 2.0, 3.0]];

    fn ball() -> Scene {
        built_in::named("ball").unwrap_or_else(|| built_in::ball_over_ground(8))
    }

    #[test]
    fn positions_and_normals_follow_the_map() {
        let (before, after) = (ball(), ball().mapped(TURNED).unwrap());
        for (a, b) in before.meshes().iter().zip(after.meshes()) {
            for (p, q) in a.positions().iter().zip(b.positions()) {
                let expected = [1.0 - 2.0 * p[1], 2.0 + 2.0 * p[0], 3.0 + 2.0 * p[2]];
                let found = [0, 1, 2].map(|k| f64::from(q[k]) + after.origin()[k]);
                let off = (0..3).map(|k| (f64::from(expected[k]) - found[k]).abs()).fold(0.0, f64::max);
                assert!(off < 1e-5, "{p:?} went to {found:?}");
            }
            for (n, m) in a.normals().iter().zip(b.normals()) {
                let off = (m[0] + n[1]).abs().max((m[1] - n[0]).abs()).max((m[2] - n[2]).abs());
                assert!(off < 1e-5, "{n:?} went to {m:?}");
            }
        }
    }

    #[test]
    fn fronts_stay_fronts_in_a_mirror() {
        let mirror = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0]];
        let scene = ball().mapped(mirror).unwrap();
        let down = Bvh::new(&scene).closest(&Ray::new([0.0, 0.0, -9.0], [0.0, 0.0, 1.0]));
        let Some(hit) = down else { panic!("the ball is above") };
        assert!(scene.surface(&hit).geometric_normal[2] < 0.0, "the front of what is hit from below is below");
    }

    #[test]
    fn parts_keep_their_places_and_materials() {
        let far = [[1.0, 0.0, 0.0, 1e6], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        let near = ball().mapped(far).unwrap();
        let moved = ball().mapped([[1.0, 0.0, 0.0, 1e6 + 4.0], far[1], far[2]]).unwrap();
        let both = Scene::joined([near.clone(), moved]).unwrap();
        assert_eq!(both.vertex_count(), 2 * near.vertex_count(), "all vertices");
        assert_eq!(both.materials().len(), 2 * near.materials().len(), "all materials");
        let [min, max] = both.world_bounds();
        let [first_min, first_max] = near.world_bounds();
        assert!((min[0] - first_min[0]).abs() < 1e-3, "{min:?} against {first_min:?}");
        assert!((max[0] - first_max[0] - 4.0).abs() < 1e-3, "{max:?} against {first_max:?}");
    }

    #[test]
    fn the_parts_of_a_scene_joined_are_the_scene() {
        let scene = built_in::cornell_box(8);
        let parts = (0..scene.meshes().len()).map(|mesh| scene.part([mesh]).unwrap());
        let joined = Scene::joined(parts).unwrap();
        for mesh in 0..scene.meshes().len() {
            let colors = [&scene, &joined].map(|scene| scene.vertex_base_color(mesh, 0));
            assert_eq!(joined.meshes()[mesh].positions(), scene.meshes()[mesh].positions(), "mesh {mesh}");
            assert_eq!(colors[0], colors[1], "the color of mesh {mesh}");
        }
        assert!(scene.part([0]).unwrap().materials().len() <= 1, "other materials are left out");
    }

    #[test]
    fn triangles_that_have_lost_their_area_in_a_pose_stay() {
        let ball = ball();
        let mesh = &ball.meshes()[0];
        let folded = mesh.posed(vec![[1.0, 2.0, 3.0]; mesh.positions().len()], Vec::new(), &[], false).unwrap();
        let scene = ball.with_meshes(std::iter::once(folded).chain(ball.meshes()[1..].iter().cloned()).collect());
        let count = scene.triangle_count();
        let (part, mapped) = (scene.part([0]).unwrap(), scene.clone().mapped(TURNED).unwrap());
        let joined = Scene::joined([part.clone(), part.clone().moved([9.0, 0.0, 0.0])]).unwrap();
        assert_eq!(part.triangle_count(), mesh.triangles().len(), "a part");
        assert_eq!(mapped.triangle_count(), count, "mapped");
        assert_eq!(joined.triangle_count(), 2 * part.triangle_count(), "joined");
    }

    #[test]
    fn what_is_known_of_meshes_is_kept() {
        let mut mesh = ball().meshes()[0].clone().into_parts();
        mesh.normals.clear();
        mesh.triangles.push([0; 3]);
        let scene = Scene::new(vec![Mesh::new(MeshParts { material: None, ..mesh }).unwrap()], vec![], vec![]).unwrap();
        let known = |scene: &Scene| (scene.meshes()[0].dropped_triangles(), scene.meshes()[0].made_normals());
        let expected = known(&scene);
        assert!(expected.0 == 1 && expected.1 > 0, "{expected:?}");
        let apart = Scene::joined([scene.clone().moved([1.0, 0.0, 0.0]), scene.clone()]).unwrap();
        for same in [scene.part([0]).unwrap(), scene.clone().mapped(TURNED).unwrap(), apart.part([1]).unwrap()] {
            assert_eq!(known(&same), expected, "dropped triangles and made normals");
        }
    }

    #[test]
    fn a_map_that_flattens_is_refused() {
        let flat = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0; 4]];
        let error = ball().mapped(flat).map(|_| ()).unwrap_err().to_string();
        assert!(error.contains("can be undone"), "{error}");
    }
}
