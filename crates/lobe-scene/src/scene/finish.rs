//! The finish of surfaces: what their materials say besides a color, and scenes that have one finish everywhere.

use crate::error::SceneError;
use crate::scene::material::{Material, TextureUse};
use crate::scene::ray::Hit;
use crate::scene::scene::{Scene, blend};

/// What the material of a surface says of one of its points besides the color.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finish {
    /// 0 for plastics and stone, 1 for metals.
    pub metallic: f32,
    /// Perceptual roughness; its square is the α of GGX.
    pub roughness: f32,
    /// The part of the light from all around that reaches the point, by an [`OcclusionMap`](crate::OcclusionMap).
    pub occlusion: f32,
    /// Emitted radiance.
    pub emission: [f32; 3],
}

impl Scene {
    /// The finish at a hit: the numbers of the material, times its textures where the mesh has their coordinates.
    ///
    /// # Panics
    /// If the hit is of another scene and its triangle does not exist here.
    #[must_use]
    pub fn finish(&self, hit: &Hit) -> Finish {
        let (mesh, triangle) = self.locate(hit.triangle as usize);
        let (material, own) = (self.material(mesh), &self.meshes()[mesh]);
        let place = |used: TextureUse| {
            let (uvs, indices) = (own.uvs(used.uv_set), own.triangles()[triangle].map(|i| i as usize));
            let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
            (!uvs.is_empty()).then(|| TextureUse::map(used.uv_map, blend(uvs, indices, weights)))
        };
        let stored = |used: Option<TextureUse>, channel: usize| {
            let found = used.and_then(|used| Some(self.textures()[used.texture].sample_stored(place(used)?)[channel]));
            found.unwrap_or(1.0)
        };
        let occlusion =
            material.occlusion_map.map_or(1.0, |map| 1.0 + map.strength * (stored(Some(map.used), 0) - 1.0));
        let mut emission = material.emissive;
        if let Some(used) = material.emissive_texture.filter(|_| material.is_emissive())
            && let Some(at) = place(used)
        {
            let texel = self.textures()[used.texture].sample(at);
            emission.iter_mut().zip(texel).for_each(|(emission, factor)| *emission *= factor);
        }
        Finish {
            metallic: material.metallic * stored(material.metallic_texture, 2),
            roughness: material.roughness * stored(material.roughness_texture, 1),
            occlusion,
            emission,
        }
    }

    /// Whether any surface emits light.
    #[must_use]
    pub fn is_emissive(&self) -> bool {
        (0..self.meshes().len()).any(|mesh| self.material(mesh).is_emissive())
    }

    /// Whether any surface is a metal, in part at least.
    #[must_use]
    pub fn has_metals(&self) -> bool {
        (0..self.meshes().len()).any(|mesh| self.material(mesh).metallic > 0.0)
    }

    /// The same scene with another roughness and metallic of all surfaces, from 0 to 1; `None` leaves those of the
    /// materials and their textures. A mesh without a material gets a white one.
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
            if let Some(roughness) = roughness {
                (material.roughness, material.roughness_texture) = (roughness, None);
            }
            if let Some(metallic) = metallic {
                (material.metallic, material.metallic_texture) = (metallic, None);
            }
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
