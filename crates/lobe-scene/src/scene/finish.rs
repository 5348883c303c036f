//! Scenes whose surfaces all have one finish, whatever their materials say.

use crate::error::SceneError;
use crate::scene::material::Material;
use crate::scene::scene::Scene;

impl Scene {
    /// The same scene with another roughness and metallic of all surfaces, from 0 to 1; `None` leaves those of the materials. A mesh
    /// without a material gets a white one.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] if one of them is not from 0 to 1.
    pub fn with_finish(self, roughness: Option<f32>, metallic: Option<f32>) -> Result<Self, SceneError> {
        if roughness.is_none() && metallic.is_none() {
            return Ok(self);
        }
        let origin = self.origin();
        let (mut meshes, mut materials, textures) = self.into_parts();
        if meshes.iter().any(|mesh| mesh.material().is_none()) {
            let white = materials.len();
            materials.push(Material::WHITE);
            let made = meshes.into_iter().map(|mesh| {
                let material = mesh.material().unwrap_or(white);
                mesh.with_material(Some(material))
            });
            meshes = made.collect();
        }
        for material in &mut materials {
            material.roughness = roughness.unwrap_or(material.roughness);
            material.metallic = metallic.unwrap_or(material.metallic);
        }
        Ok(Self::new(meshes, materials, textures)?.moved(origin))
    }
}

#[cfg(test)]
mod tests {
    use crate::built_in;
    use crate::scene::material::Material;
    use crate::scene::mesh::{Mesh, MeshParts};
    use crate::scene::scene::Scene;

    #[test]
    fn one_finish_is_that_of_all_surfaces_and_leaves_everything_else() {
        let scene = built_in::ball_over_ground(8).moved([1e7, 0.0, 0.0]);
        let shiny = scene.clone().with_finish(Some(0.25), None).unwrap();
        assert_eq!((shiny.origin(), shiny.bounds()), (scene.origin(), scene.bounds()), "the place");
        for (found, given) in shiny.materials().iter().zip(scene.materials()) {
            let expected = Material { roughness: 0.25, ..given.clone() };
            assert_eq!(found, &expected, "a material");
        }
        let same = scene.clone().with_finish(None, None).unwrap();
        assert_eq!(same.materials(), scene.materials(), "nothing is asked for");
    }

    #[test]
    fn a_mesh_without_a_material_has_the_finish_too_and_one_out_of_range_is_refused() {
        let parts = MeshParts {
            positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2]],
            ..MeshParts::default()
        };
        let scene = Scene::new(vec![Mesh::new(parts).unwrap()], vec![], vec![]).unwrap();
        let metal = scene.clone().with_finish(None, Some(1.0)).unwrap();
        assert_eq!(metal.material(0), &Material { metallic: 1.0, ..Material::WHITE }, "white metal");
        for wrong in [-0.1, 1.5, f32::NAN] {
            let error = scene.clone().with_finish(Some(wrong), None).unwrap_err().to_string();
            assert!(error.contains("expected base color, metallic, roughness"), "{wrong}: {error}");
        }
    }
}
