//! Scene: all triangles with their materials and textures.

use glam::{DVec3, Vec3};

use crate::error::SceneError;
use crate::scene::material::{Alpha, Material, TextureUse};
use crate::scene::mesh::Mesh;
use crate::scene::near_origin::near_origin;
use crate::scene::ray::{Hit, Ray};
use crate::scene::texture::Texture;

/// A scene of meshes, materials and textures. It has at least one triangle; every index is in range.
///
/// Triangles are counted through all meshes in their order: that index is stored in a [`Hit`].
///
/// A scene far from the origin of its world is stored near its own, [`Scene::origin`], where numbers of `f32` are
/// precise. All positions of its meshes, surfaces, rays and receivers count from there; cameras, grids and files are
/// of the world.
#[derive(Clone, Debug)]
pub struct Scene {
    meshes: Vec<Mesh>,
    materials: Vec<Material>,
    textures: Vec<Texture>,
    /// The index of the first triangle of each mesh, then the number of all triangles.
    starts: Box<[usize]>,
    /// The index of the first vertex of each mesh, then the number of all vertices.
    vertex_starts: Box<[usize]>,
    origin: [f64; 3],
}

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Bounds {
    /// The corner of the smallest coordinates.
    pub min: [f32; 3],
    /// The corner of the largest coordinates.
    pub max: [f32; 3],
}

/// The surface at a hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// The point from [`Scene::origin`], interpolated from the corners of the triangle: more precise than along the ray.
    pub position: [f32; 3],
    /// The unit normal of the triangle's plane, on the side from which its corners run counter-clockwise.
    pub geometric_normal: [f32; 3],
    /// The unit normal interpolated from the vertices.
    pub vertex_normal: [f32; 3],
    /// The unit shading normal: that of the vertices, tilted by the [`NormalMap`](crate::NormalMap) of the material if there is one.
    pub shading_normal: [f32; 3],
    /// Linear color and alpha: base color, texture and vertex color multiplied, of glass that lets light through the part
    /// that is reflected.
    pub base_color: [f32; 4],
    /// Index of the mesh.
    pub mesh: usize,
}

impl Scene {
    /// A scene of meshes. Their materials index `materials`, whose textures index `textures`.
    ///
    /// If they are far from the origin, meshes are moved near it; [`Scene::origin`] is the way back.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] without any mesh, with more than 2³² - 1 triangles, if an index is out of range, if a base
    /// color, metallic, roughness or transmission is not from 0 to 1, or if an emission, a map of a texture or the scale of a
    /// normal map is not finite.
    pub fn new(meshes: Vec<Mesh>, materials: Vec<Material>, textures: Vec<Texture>) -> Result<Self, SceneError> {
        let invalid = |message: String| Err(SceneError::invalid("scene", message));
        if meshes.is_empty() {
            return invalid("expected triangles, found none".to_string());
        }
        for mesh in &meshes {
            if let Some(index) = mesh.material().filter(|&index| index >= materials.len()) {
                let (name, count) = (mesh.name(), materials.len());
                return invalid(format!("mesh `{name}` is of material {index}, but there are {count}"));
            }
        }
        for material in &materials {
            if let Some(used) = material.textures().find(|used| used.texture >= textures.len()) {
                let (name, index, count) = (&material.name, used.texture, textures.len());
                return invalid(format!("material `{name}` uses texture {index}, but there are {count}"));
            }
        }
        for material in &materials {
            material.check().map_err(|message| SceneError::invalid("scene", message))?;
        }
        let starts = starts_of(meshes.iter().map(|mesh| mesh.triangles().len()));
        let vertex_starts = starts_of(meshes.iter().map(|mesh| mesh.positions().len()));
        let count = starts[meshes.len()];
        if u32::try_from(count).is_err() {
            return invalid(format!("expected fewer than 2^32 triangles, found {count}"));
        }
        let Bounds { min, max } = bounds_of(&meshes);
        let (meshes, origin) = near_origin(meshes, min, max);
        Ok(Self { meshes, materials, textures, starts, vertex_starts, origin })
    }

    /// The meshes.
    #[must_use]
    pub fn meshes(&self) -> &[Mesh] {
        &self.meshes
    }

    /// The materials, to which meshes refer by index.
    #[must_use]
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// The textures, to which materials refer by index.
    #[must_use]
    pub fn textures(&self) -> &[Texture] {
        &self.textures
    }

    /// The same scene without [`NormalMap`](crate::NormalMap)s and tangents. Its textures keep their places.
    #[must_use]
    pub fn without_normal_maps(mut self) -> Self {
        self.meshes = self.meshes.into_iter().map(Mesh::without_tangents).collect();
        self.materials.iter_mut().for_each(|material| material.normal_map = None);
        self
    }

    /// The point of the world from which positions of this scene count; zero unless it is far from there.
    ///
    /// Its lighting does not depend on its place: a scene moved as a whole has the same positions and the same light,
    /// bit by bit, if its file moves it by a node.
    #[must_use]
    pub fn origin(&self) -> [f64; 3] {
        self.origin
    }

    /// The same scene, moved in the world.
    #[must_use]
    pub fn moved(self, by: [f64; 3]) -> Self {
        let origin = [0, 1, 2].map(|k| self.origin[k] + by[k]);
        Self { origin, ..self }
    }

    /// The meshes, whose positions count from [`Scene::origin`], materials and textures, to be changed and made into
    /// another scene. That is at the same place once it is [moved](Scene::moved) by the origin of this one.
    #[must_use]
    pub fn into_parts(self) -> (Vec<Mesh>, Vec<Material>, Vec<Texture>) {
        (self.meshes, self.materials, self.textures)
    }

    /// The same scene with its meshes elsewhere: as many, of as many triangles. They count from the same origin.
    pub(crate) fn with_meshes(&self, meshes: Vec<Mesh>) -> Self {
        debug_assert_eq!(
            meshes.iter().map(|mesh| mesh.triangles().len()).sum::<usize>(),
            self.triangle_count(),
            "triangles"
        );
        let Self { materials, textures, starts, origin, .. } = self;
        Self {
            vertex_starts: starts_of(meshes.iter().map(|mesh| mesh.positions().len())),
            meshes,
            materials: materials.clone(),
            textures: textures.clone(),
            starts: starts.clone(),
            origin: *origin,
        }
    }

    /// Number of triangles in all meshes.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        self.starts[self.meshes.len()]
    }

    /// Number of vertices in all meshes.
    #[must_use]
    pub fn vertex_count(&self) -> usize {
        self.vertex_starts[self.meshes.len()]
    }

    /// The index of the first vertex of a mesh among those of all meshes.
    ///
    /// # Panics
    /// If there is no such mesh.
    #[must_use]
    pub fn first_vertex(&self, mesh: usize) -> usize {
        assert!(mesh < self.meshes.len(), "mesh {mesh} of {}", self.meshes.len());
        self.vertex_starts[mesh]
    }

    /// The mesh of the triangle with this index, and the triangle's index in it.
    ///
    /// # Panics
    /// If there is no such triangle.
    #[must_use]
    pub fn locate(&self, triangle: usize) -> (usize, usize) {
        assert!(triangle < self.triangle_count(), "triangle {triangle} of {}", self.triangle_count());
        let mesh = self.starts.partition_point(|&start| start <= triangle) - 1;
        (mesh, triangle - self.starts[mesh])
    }

    /// The corners of all triangles, in the order of their indices.
    pub fn corners(&self) -> impl Iterator<Item = [[f32; 3]; 3]> {
        self.meshes.iter().flat_map(|mesh| {
            let positions = mesh.positions();
            mesh.triangles().iter().map(|t| t.map(|i| positions[i as usize]))
        })
    }

    /// The material of a mesh: white where the mesh has none.
    ///
    /// # Panics
    /// If there is no such mesh.
    #[must_use]
    pub fn material(&self, mesh: usize) -> &Material {
        static WHITE: Material = Material::WHITE;
        self.meshes[mesh].material().map_or(&WHITE, |index| &self.materials[index])
    }

    /// The smallest box around all positions, which count from [`Scene::origin`].
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        bounds_of(&self.meshes)
    }

    /// The same box in the world, as cameras and grids take it: the corners of the smallest and of the largest
    /// coordinates.
    #[must_use]
    pub fn world_bounds(&self) -> [[f64; 3]; 2] {
        let Bounds { min, max } = self.bounds();
        [min, max].map(|corner| [0, 1, 2].map(|k| f64::from(corner[k]) + self.origin[k]))
    }

    /// Linear color and alpha of a vertex: base color, texture and vertex color multiplied.
    ///
    /// # Panics
    /// If there is no such mesh or vertex.
    #[must_use]
    pub fn vertex_base_color(&self, mesh: usize, vertex: usize) -> [f32; 4] {
        let of = |set: usize| self.meshes[mesh].uvs(set).get(vertex).copied();
        let color = self.meshes[mesh].colors().get(vertex).copied();
        self.material(mesh).reflected(self.base_color(self.material(mesh), [of(0), of(1)], color))
    }

    /// The surface at a hit.
    ///
    /// # Panics
    /// If the hit is of another scene and its triangle does not exist here.
    #[must_use]
    pub fn surface(&self, hit: &Hit) -> Surface {
        let (mesh_index, triangle) = self.locate(hit.triangle as usize);
        let (mesh, material) = (&self.meshes[mesh_index], self.material(mesh_index));
        let indices = mesh.triangles()[triangle].map(|i| i as usize);
        let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
        let [a, b, c] = indices.map(|i| Vec3::from(mesh.positions()[i]).as_dvec3());
        let position = blend(mesh.positions(), indices, weights);
        let geometric = (b - a).cross(c - a).normalize_or(DVec3::Z);
        let of_vertices = DVec3::from(blend(mesh.normals(), indices, weights).map(f64::from)).normalize_or(geometric);
        let shading = match material.normal_map {
            Some(_) => self.mapped_normal(mesh_index, triangle, weights, of_vertices),
            None => of_vertices,
        };
        Surface {
            position,
            geometric_normal: geometric.as_vec3().to_array(),
            vertex_normal: of_vertices.as_vec3().to_array(),
            shading_normal: shading.as_vec3().to_array(),
            base_color: material.reflected(self.color_within(mesh, material, indices, weights)),
            mesh: mesh_index,
        }
    }

    /// Base color, texture and vertex color at a hit, multiplied.
    fn color_at(&self, hit: &Hit) -> [f32; 4] {
        let (mesh_index, triangle) = self.locate(hit.triangle as usize);
        let mesh = &self.meshes[mesh_index];
        let indices = mesh.triangles()[triangle].map(|i| i as usize);
        let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
        self.color_within(mesh, self.material(mesh_index), indices, weights)
    }

    /// The same at a place of a triangle, given by the weights of its corners.
    fn color_within(&self, mesh: &Mesh, material: &Material, indices: [usize; 3], weights: [f32; 3]) -> [f32; 4] {
        let uvs = [0, 1].map(|set| match mesh.uvs(set) {
            [] => None,
            // Without a texture they say nothing.
            _ if material.base_color_texture.is_none() => None,
            uvs => Some(blend(uvs, indices, weights)),
        });
        let color = if mesh.colors().is_empty() { None } else { Some(blend(mesh.colors(), indices, weights)) };
        self.base_color(material, uvs, color)
    }

    /// The probability that a ray stops at a hit: 0 in the holes of an alpha mask, and in between where light goes
    /// [straight through](Material::straight_through) a part of the surface. There, on average over many rays, each light is
    /// dimmed as by a film without thickness; its direction does not change, and [`Scene::tint`] says how its hue does.
    ///
    /// # Panics
    /// As [`Scene::surface`].
    #[must_use]
    pub fn opacity(&self, hit: &Hit) -> f32 {
        let (mesh, _) = self.locate(hit.triangle as usize);
        let material = self.material(mesh);
        if !material.has_holes() {
            return 1.0;
        }
        let color = self.color_at(hit);
        match material.alpha {
            Alpha::Mask(cutoff) if color[3] < cutoff => 0.0,
            _ => 1.0 - material.through(color),
        }
    }

    /// The factor of each channel for light that does not [stop](Scene::stops) at a hit.
    ///
    /// Glass tints light by its base color relative to the mean of its channels. [`Scene::opacity`] has the mean
    /// already.
    ///
    /// # Panics
    /// As [`Scene::surface`].
    #[must_use]
    pub fn tint(&self, hit: &Hit) -> [f32; 3] {
        let material = self.material(self.locate(hit.triangle as usize).0);
        if material.is_clear() { material.tint(self.color_at(hit)) } else { [1.0; 3] }
    }

    /// Whether light may take on a hue on its way straight through surfaces: there is colored glass.
    #[must_use]
    pub fn is_tinted(&self) -> bool {
        (0..self.meshes.len()).any(|mesh| self.material(mesh).is_clear()) && !self.is_gray()
    }

    /// Whether a ray stops at a hit: at random with the probability [`Scene::opacity`], by a number that depends on the ray
    /// and on the triangle alone, so that a ray decides alike whenever it is asked.
    ///
    /// # Panics
    /// As [`Scene::surface`].
    #[must_use]
    pub fn stops(&self, ray: &Ray, hit: &Hit) -> bool {
        let opacity = self.opacity(hit);
        opacity >= 1.0 || (opacity > 0.0 && number_of(ray, hit.triangle) < opacity)
    }

    /// Whether any surface has holes or lets light through, so that rays need [`Scene::stops`].
    #[must_use]
    pub fn has_holes(&self) -> bool {
        (0..self.meshes.len()).any(|mesh| self.material(mesh).has_holes())
    }

    /// The same scene with or without light going [straight through](Material::straight_through) all materials that let it.
    #[must_use]
    pub fn with_straight_through(mut self, straight_through: bool) -> Self {
        self.materials.iter_mut().for_each(|material| material.straight_through = straight_through);
        self
    }

    /// Whether no base color, its texture or vertex color has a hue, so that light stays gray.
    #[must_use]
    pub fn is_gray(&self) -> bool {
        let is_gray = |&[r, g, b, _]: &[f32; 4]| r == g && g == b;
        self.materials.iter().all(|material| is_gray(&material.base_color))
            && self.color_textures().all(Texture::is_gray)
            && self.meshes.iter().all(|mesh| mesh.colors().iter().all(is_gray))
    }

    /// The textures of base colors.
    fn color_textures(&self) -> impl Iterator<Item = &Texture> {
        let mut is_color = vec![false; self.textures.len()];
        self.materials.iter().filter_map(|m| m.base_color_texture).for_each(|used| is_color[used.texture] = true);
        self.textures.iter().zip(is_color).filter_map(|(texture, is_color)| is_color.then_some(texture))
    }

    fn base_color(&self, material: &Material, uvs: [Option<[f32; 2]>; 2], color: Option<[f32; 4]>) -> [f32; 4] {
        let mut product = material.base_color;
        let mut multiply = |factor: [f32; 4]| (0..4).for_each(|k| product[k] *= factor[k]);
        if let Some(used) = material.base_color_texture
            && let Some(uv) = uvs[used.uv_set]
        {
            multiply(self.textures[used.texture].sample(TextureUse::map(used.uv_map, uv)));
        }
        if let Some(color) = color {
            multiply(color);
        }
        product
    }
}

/// The sum of all counts before each, then of all.
fn starts_of(counts: impl Iterator<Item = usize>) -> Box<[usize]> {
    let mut starts = vec![0];
    for count in counts {
        starts.push(starts[starts.len() - 1] + count);
    }
    starts.into()
}

fn bounds_of(meshes: &[Mesh]) -> Bounds {
    let mut bounds = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for &p in meshes.iter().flat_map(Mesh::positions) {
        bounds = (bounds.0.min(p.into()), bounds.1.max(p.into()));
    }
    Bounds { min: bounds.0.into(), max: bounds.1.into() }
}

/// A number from 0 to 1 that a ray draws at a triangle: a hash of the bits of both.
fn number_of(ray: &Ray, triangle: u32) -> f32 {
    let mix = |hash: u64, word: u32| {
        let hash = (hash ^ u64::from(word)).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        hash ^ hash >> 29
    };
    let words = [ray.origin, ray.direction].into_iter().flatten().map(f32::to_bits).chain([triangle]);
    let hash = mix(words.fold(0, mix), 0);
    (hash >> 40) as f32 / 16_777_216.0
}

/// Barycentric interpolation, in `f64` until the end.
#[inline]
pub(crate) fn blend<const N: usize>(values: &[[f32; N]], indices: [usize; 3], weights: [f32; 3]) -> [f32; N] {
    std::array::from_fn(|k| {
        (0..3).map(|i| f64::from(values[indices[i]][k]) * f64::from(weights[i])).sum::<f64>() as f32
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::mesh::MeshParts;
    use crate::scene::texture::Wrap;

    fn triangle(name: &str, material: Option<usize>) -> MeshParts {
        MeshParts {
            name: name.into(),
            positions: vec![[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]],
            triangles: vec![[0, 1, 2]],
            material,
            ..MeshParts::default()
        }
    }

    #[test]
    fn triangles_are_counted_through_all_meshes() {
        let mut two = triangle("two", None);
        two.triangles.push([2, 1, 0]);
        let meshes = [two, triangle("one", None)].map(|parts| Mesh::new(parts).unwrap());
        let scene = Scene::new(meshes.to_vec(), vec![], vec![]).unwrap();
        let located: Vec<_> = (0..3).map(|t| scene.locate(t)).collect();
        assert_eq!(located, [(0, 0), (0, 1), (1, 0)], "mesh and triangle");
        assert_eq!((scene.triangle_count(), scene.vertex_count()), (3, 6), "counts");
        assert_eq!([0, 1].map(|mesh| scene.first_vertex(mesh)), [0, 3], "first vertices");
        assert_eq!(scene.bounds(), Bounds { min: [0.0; 3], max: [2.0, 2.0, 0.0] }, "bounds");
    }

    #[test]
    fn base_colors_texture_and_vertex_color_multiply() {
        let mut parts = triangle("painted", Some(0));
        parts.uvs[1] = vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        parts.colors = vec![[1.0, 0.5, 1.0, 1.0]; 3];
        let texture = Texture::new(1, 1, vec![[255, 255, 0, 128]], [Wrap::Repeat; 2]);
        let used = TextureUse { texture: 0, uv_set: 1, uv_map: TextureUse::UV_UNCHANGED };
        let material = Material {
            base_color: [0.5, 0.5, 0.5, 1.0],
            base_color_texture: Some(used),
            alpha: Alpha::Mask(0.5),
            ..Material::WHITE
        };
        let scene = Scene::new(vec![Mesh::new(parts).unwrap()], vec![material], vec![texture]).unwrap();
        let hit = Hit { t: 1.0, triangle: 0, u: 0.25, v: 0.5 };
        let surface = scene.surface(&hit);
        assert_eq!(surface.position, [0.5, 1.0, 0.0], "position");
        assert_eq!(surface.base_color, [0.5, 0.25, 0.0, 128.0 / 255.0], "color");
        assert_eq!(scene.vertex_base_color(0, 2), surface.base_color, "the same at a vertex");
        assert_eq!((surface.geometric_normal, surface.shading_normal), ([0.0, 0.0, 1.0], [0.0, 0.0, 1.0]), "normals");
        assert!(scene.has_holes() && scene.opacity(&hit) == 1.0, "alpha 128/255 reaches the cutoff 0.5");
    }

    #[test]
    fn rays_pass_a_film_as_often_as_its_opacity_says() {
        for (alpha, transmission, color, opacity, reflected) in [
            (Alpha::Blend, 0.0, [0.2, 0.4, 0.6, 0.25], 0.25, 0.2),
            (Alpha::Opaque, 0.5, [0.2, 0.4, 0.6, 0.25], 0.8, 0.125),
            (Alpha::Blend, 0.5, [1.0, 1.0, 1.0, 0.5], 0.25, 1.0),
            (Alpha::Opaque, 1.0, [1.0; 4], 0.0, 0.0),
            (Alpha::Opaque, 0.0, [0.2, 0.4, 0.6, 0.25], 1.0, 0.2),
        ] {
            let material =
                Material { base_color: color, alpha, transmission, straight_through: true, ..Material::WHITE };
            let mesh = Mesh::new(triangle("film", Some(0))).unwrap();
            let scene = Scene::new(vec![mesh], vec![material], vec![]).unwrap();
            let hit = Hit { t: 1.0, triangle: 0, u: 0.25, v: 0.5 };
            assert!((scene.opacity(&hit) - opacity).abs() < 1e-6, "{alpha:?}, {transmission}: {}", scene.opacity(&hit));
            let found = scene.surface(&hit).base_color[0];
            assert!((found - reflected).abs() < 1e-6, "{alpha:?}, {transmission}: reflects {found}");
            let count = 1 << 16;
            let ray = |i: i32| Ray::new([i as f32, 0.5, 1.0], [0.0, 1e-3 * i as f32, -1.0]);
            let stopped = (0..count).filter(|&i| scene.stops(&ray(i), &hit)).count() as f32 / count as f32;
            // Five standard deviations of a coin.
            assert!((stopped - opacity).abs() < 0.01, "{alpha:?}, {transmission}: {stopped} stop of {opacity}");
            let opaque = scene.with_straight_through(false);
            assert_eq!((opaque.opacity(&hit), opaque.has_holes()), (1.0, false), "opaque unless asked for");
        }
    }

    #[test]
    fn light_through_colored_glass_has_its_color_and_no_other_light_has() {
        let pane = |material: Material| {
            let mesh = Mesh::new(triangle("pane", Some(0))).unwrap();
            Scene::new(vec![mesh], vec![material], vec![]).unwrap()
        };
        let hit = Hit { t: 1.0, triangle: 0, u: 0.25, v: 0.5 };
        let color = [0.5, 0.25, 0.75, 0.5];
        for (alpha, transmission, expected) in [
            (Alpha::Opaque, 1.0, [0.5, 0.25, 0.75]),
            (Alpha::Opaque, 0.5, [0.25, 0.125, 0.375]),
            (Alpha::Blend, 1.0, [0.75, 0.625, 0.875]),
        ] {
            let glass = Material { base_color: color, alpha, transmission, straight_through: true, ..Material::WHITE };
            let scene = pane(glass.clone());
            let through = scene.tint(&hit).map(|c| c * (1.0 - scene.opacity(&hit)));
            let off = (0..3).map(|c| (through[c] - expected[c]).abs()).fold(0.0, f32::max);
            assert!(off < 1e-6 && scene.is_tinted(), "{alpha:?}, {transmission}: {through:?}, not {expected:?}");
            let opaque = pane(Material { straight_through: false, ..glass.clone() });
            assert!(!opaque.is_tinted() && opaque.tint(&hit) == [1.0; 3], "opaque unless asked for");
            let gray = pane(Material { base_color: [0.5, 0.5, 0.5, 0.5], ..glass });
            assert!(!gray.is_tinted() && gray.tint(&hit) == [1.0; 3], "gray glass has no hue");
        }
        let film = Material { base_color: color, alpha: Alpha::Blend, straight_through: true, ..Material::WHITE };
        assert!(!pane(film).is_tinted(), "what a film leaves uncovered has no hue");
    }

    #[test]
    fn a_hue_anywhere_makes_a_scene_colorful() {
        let scene = |base: f32, vertex: f32, texel: u8| {
            let parts = MeshParts { colors: vec![[1.0, 1.0, vertex, 0.5]; 3], ..triangle("a", Some(0)) };
            let texture = Texture::new(1, 1, vec![[255, texel, 255, 7]], [Wrap::Repeat; 2]);
            let base_color_texture = Some(TextureUse { texture: 0, uv_set: 0, uv_map: TextureUse::UV_UNCHANGED });
            let material = Material { base_color: [base, 1.0, 1.0, 0.0], base_color_texture, ..Material::WHITE };
            Scene::new(vec![Mesh::new(parts).unwrap()], vec![material], vec![texture]).unwrap()
        };
        assert!(scene(1.0, 1.0, 255).is_gray(), "alpha is no hue");
        for (base, vertex, texel) in [(0.9, 1.0, 255), (1.0, 0.9, 255), (1.0, 1.0, 254)] {
            assert!(!scene(base, vertex, texel).is_gray(), "{base}, {vertex}, {texel}");
        }
    }

    #[test]
    fn indices_out_of_range_and_empty_scenes_are_refused() {
        let refusal = |meshes, materials| Scene::new(meshes, materials, vec![]).unwrap_err().to_string();
        assert_eq!(refusal(vec![], vec![]), "scene: expected triangles, found none", "empty");
        let mesh = Mesh::new(triangle("a", Some(1))).unwrap();
        let found = refusal(vec![mesh], vec![Material::WHITE]);
        assert_eq!(found, "scene: mesh `a` is of material 1, but there are 1", "material");
        let used = TextureUse { texture: 0, uv_set: 0, uv_map: TextureUse::UV_UNCHANGED };
        let material = Material { name: "m".into(), base_color_texture: Some(used), ..Material::WHITE };
        let found = refusal(vec![Mesh::new(triangle("a", Some(0))).unwrap()], vec![material]);
        assert_eq!(found, "scene: material `m` uses texture 0, but there are 0", "texture");
    }
}
