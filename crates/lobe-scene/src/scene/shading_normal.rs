//! Shading normals tilted by normal maps.

use glam::DVec3;

use crate::scene::material::{NormalMap, TextureUse};
use crate::scene::scene::Scene;
use crate::scene::scene::blend;

impl Scene {
    /// Whether [`Surface::shading_normal`](crate::Surface::shading_normal) is tilted by a [`NormalMap`] anywhere: a mesh has one in its
    /// material, and the tangents and the texture coordinates that it needs.
    #[must_use]
    pub fn has_normal_maps(&self) -> bool {
        (0..self.meshes().len()).any(|mesh| self.normal_map(mesh).is_some())
    }

    /// The normal map of a mesh, if the mesh has what it needs.
    fn normal_map(&self, mesh: usize) -> Option<NormalMap> {
        let map = self.material(mesh).normal_map?;
        let own = &self.meshes()[mesh];
        (!own.tangents().is_empty() && !own.uvs(map.used.uv_set).is_empty()).then_some(map)
    }

    /// The unit normal to shade with at a place of a triangle of a mesh, where that of the vertices is `normal`: tilted as
    /// [`NormalMap`] says. The place is given by the weights of the corners.
    ///
    /// It may point below the triangle. Light is then treated as below any normal that tilts off it: directions below the plane
    /// of the triangle, on the side of the normal of the vertices, bring nothing.
    pub(crate) fn mapped_normal(&self, mesh: usize, triangle: usize, weights: [f32; 3], normal: DVec3) -> DVec3 {
        let Some(map) = self.normal_map(mesh) else { return normal };
        let own = &self.meshes()[mesh];
        let indices = own.triangles()[triangle].map(|i| i as usize);
        // Interpolate the tangent, and make it perpendicular to the normal.
        let [x, y, z, w] = blend(&own.tangents()[triangle], [0, 1, 2], weights).map(f64::from);
        let along = DVec3::new(x, y, z);
        let Some(tangent) = (along - normal * normal.dot(along)).try_normalize() else { return normal };
        let (tangent, w) = of_picture(map.used.uv_map, normal, tangent, w.signum());
        // Look the tilt up, and apply it.
        let uv = blend(own.uvs(map.used.uv_set), indices, weights);
        let texel = self.textures()[map.used.texture].sample_stored(TextureUse::map(map.used.uv_map, uv));
        tilted(texel, map.scale, [tangent, normal.cross(tangent) * w, normal])
    }
}

/// `T'` and `w'` of [`NormalMap`]: the tangent and the sign of a picture that does not lie in the texture coordinates as it is.
fn of_picture(uv_map: [[f32; 3]; 2], normal: DVec3, tangent: DVec3, w: f64) -> (DVec3, f64) {
    let [[a, b, _], [c, d, _]] = uv_map.map(|row| row.map(f64::from));
    let sign = if a * d - b * c < 0.0 { -1.0 } else { 1.0 };
    let along_u = sign * (d * tangent + c * w * normal.cross(tangent));
    (along_u.try_normalize().unwrap_or(tangent), sign * w)
}

/// The formula of [`NormalMap`] in the frame `T, w (N × T), N`.
fn tilted([x, y, z, _]: [f32; 4], scale: f32, [t, b, n]: [DVec3; 3]) -> DVec3 {
    let [x, y, z] = [x, y, z].map(|c| 2.0 * f64::from(c) - 1.0);
    let s = f64::from(scale);
    (s * x * t + s * y * b + z * n).normalize_or(n)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::material::Material;
    use crate::scene::mesh::{Mesh, MeshParts};
    use crate::scene::ray::Hit;
    use crate::scene::texture::{Texture, Wrap};

    const HIT: Hit = Hit { t: 1.0, triangle: 0, u: 0.25, v: 0.25 };

    /// A square of two triangles that faces +z, y up as v runs down, with a normal map of these texels side by side.
    fn square(texels: &[[u8; 4]], scale: f32, change: impl FnOnce(&mut MeshParts)) -> Scene {
        let mut parts = MeshParts {
            positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            uvs: [vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]], vec![]],
            material: Some(0),
            ..MeshParts::default()
        };
        change(&mut parts);
        let mesh = Mesh::new(parts).unwrap();
        let mesh = if mesh.tangents().is_empty() { mesh.with_tangents(0) } else { mesh };
        let used = TextureUse { texture: 0, uv_set: 0, uv_map: TextureUse::UV_UNCHANGED };
        let material = Material { normal_map: Some(NormalMap { used, scale }), ..Material::WHITE };
        let texture = Texture::new(texels.len(), 1, texels.to_vec(), [Wrap::Repeat; 2]);
        Scene::new(vec![mesh], vec![material], vec![texture]).unwrap()
    }

    fn assert_near(found: [f32; 3], expected: [f64; 3], what: &str) {
        let off = (0..3).map(|k| (f64::from(found[k]) - expected[k]).abs()).fold(0.0, f64::max);
        assert!(off < 1e-6, "{what}: {found:?}, expected {expected:?}");
    }

    /// The unit vector of a texel at a scale, in the frame of the square.
    fn of_texel([x, y, z, _]: [u8; 4], scale: f64) -> [f64; 3] {
        let part = |c: u8| 2.0 * f64::from(c) / 255.0 - 1.0;
        DVec3::new(scale * part(x), scale * part(y), part(z)).normalize().to_array()
    }

    #[test]
    fn red_tilts_along_u_and_green_against_v_as_far_as_the_scale_says() {
        for texel in [[255, 128, 200, 255], [40, 200, 180, 255], [128, 0, 128, 255]] {
            for scale in [1.0, 0.5, -2.0, 0.0] {
                let surface = square(&[texel], scale, |_| {}).surface(&HIT);
                let what = format!("{texel:?} at scale {scale}");
                assert_near(surface.shading_normal, of_texel(texel, scale.into()), &what);
                assert_eq!(
                    (surface.vertex_normal, surface.geometric_normal),
                    ([0.0, 0.0, 1.0], [0.0, 0.0, 1.0]),
                    "{what}"
                );
            }
        }
    }

    #[test]
    fn a_texel_that_tilts_nothing_leaves_the_normals_of_the_vertices() {
        // Halfway between texels of 127 and of 128, which eight bits can not hold.
        let normals = vec![[0.3, 0.0, 1.0], [0.0, 0.5, 1.0], [0.1, 0.2, 1.0], [0.0, 0.0, 1.0]];
        let flat = |parts: &mut MeshParts| {
            parts.normals.clone_from(&normals);
            parts.uvs[0] = vec![[0.5, 0.5]; 4];
            parts.tangents = vec![[[1.0, 0.0, 0.0, 1.0]; 3]; 2];
        };
        let scene = square(&[[127, 127, 255, 255], [128, 128, 255, 255]], 1.0, flat);
        let plain = scene.clone().without_normal_maps();
        assert!(scene.has_normal_maps() && !plain.has_normal_maps(), "one has a map, one has none");
        for triangle in [0, 1] {
            let [found, expected] = [&scene, &plain].map(|scene| scene.surface(&Hit { triangle, ..HIT }));
            assert_near(found.shading_normal, expected.shading_normal.map(f64::from), "as without the map");
        }
    }

    #[test]
    fn normals_are_interpolated_before_they_are_normalized() {
        let texels = [[255, 128, 128, 255], [128, 128, 255, 255]];
        // u = 1/2 is halfway between the two.
        let surface = square(&texels, 1.0, |_| {}).surface(&HIT);
        let [a, b] = texels.map(|texel| texel.map(|c| 2.0 * f64::from(c) / 255.0 - 1.0));
        let mean = DVec3::from([0, 1, 2].map(|k| a[k] + b[k])).normalize();
        assert_near(surface.shading_normal, mean.to_array(), "the mean");
    }

    #[test]
    fn what_lacks_tangents_or_texture_coordinates_or_a_direction_keeps_its_normals() {
        let texel = [[255, 128, 128, 255]];
        let mut cases = vec![
            ("no texture coordinates", square(&texel, 1.0, |parts| parts.uvs[0].clear())),
            ("no area in the texture", square(&texel, 1.0, |parts| parts.uvs[0] = vec![[0.5; 2]; 4])),
            ("a tangent along the normal", square(&texel, 1.0, |p| p.tangents = vec![[[0.0, 0.0, 1.0, 1.0]; 3]; 2])),
        ];
        let scene = square(&texel, 1.0, |_| {});
        let meshes = scene.meshes().iter().cloned().map(Mesh::without_tangents).collect();
        cases.push(("no tangents", scene.with_meshes(meshes)));
        for (what, scene) in cases {
            assert_eq!(scene.surface(&HIT).shading_normal, [0.0, 0.0, 1.0], "{what}");
        }
        // Between texels that are opposite there is none, as nothing has been normalized yet.
        let frame = [DVec3::X, DVec3::Y, DVec3::Z];
        assert_eq!(tilted([0.5, 0.5, 0.5, 1.0], 1.0, frame), DVec3::Z, "a sum of zero");
    }

    #[test]
    fn a_normal_map_colors_nothing() {
        let scene = square(&[[10, 20, 30, 255]], 1.0, |_| {});
        assert!(scene.is_gray(), "normals have no hue");
        assert_eq!(scene.surface(&HIT).base_color, [1.0; 4], "nor do they color");
    }

    #[test]
    fn tangents_follow_the_map_of_a_scene_and_its_mirror() {
        let texel = [200, 220, 220, 255];
        let [x, y, z] = of_texel(texel, 1.0);
        // A quarter turn about z, and a mirror that exchanges left and right.
        let turn = [[0.0, -1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        let mirror = [[-1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        for (map, expected) in [(turn, [-y, x, z]), (mirror, [-x, y, z])] {
            let scene = square(&[texel], 1.0, |_| {}).mapped(map).unwrap();
            assert_near(scene.surface(&HIT).shading_normal, expected, "turned or mirrored");
        }
    }

    #[test]
    fn tangents_of_a_scene_that_is_sheared_or_stretched_are_mapped_as_what_they_run_along() {
        let texel = [200, 220, 220, 255];
        let [a, b, c] = of_texel(texel, 1.0);
        let shear = [[1.0, 0.5, 0.3, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.4, 1.0, 0.0]];
        let along_a_diagonal = [[2.0, 1.0, 0.0, 0.0], [1.0, 2.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        for map in [shear, along_a_diagonal] {
            let mapped = |v: DVec3| DVec3::from(map.map(|[x, y, z, _]| DVec3::new(x, y, z).dot(v)));
            let n = mapped(DVec3::X).cross(mapped(DVec3::Y)).normalize();
            let t = mapped(DVec3::new(0.6, 0.8, 0.0)).normalize();
            let scene = square(&[texel], 1.0, |parts| parts.tangents = vec![[[0.6, 0.8, 0.0, 1.0]; 3]; 2]);
            let found = scene.mapped(map).unwrap().surface(&HIT).shading_normal;
            assert_near(found, (a * t + b * n.cross(t) + c * n).to_array(), "sheared or stretched");
        }
    }

    #[test]
    fn halves_of_triangles_have_the_normals_of_the_whole() {
        let texel = [200, 100, 220, 255];
        let fine = square(&[texel], 1.0, |_| {}).split_edges(0.3).unwrap();
        assert!(fine.triangle_count() > 16, "{} triangles", fine.triangle_count());
        for triangle in 0..fine.triangle_count() as u32 {
            let found = fine.surface(&Hit { triangle, ..HIT }).shading_normal;
            assert_near(found, of_texel(texel, 1.0), "a part");
        }
    }
}
