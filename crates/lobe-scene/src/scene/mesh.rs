//! Meshes: triangles that share a material.

use glam::{DVec3, Vec3};

use crate::error::SceneError;
use crate::scene::tangents::corner_tangents;
use crate::scene::vertex_normals::angle_weighted_normals;

/// The parts of a [`Mesh`]. Empty vectors stand for missing attributes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshParts {
    /// The name in messages.
    pub name: String,
    /// Points, z up, in the world or from a [`Scene::origin`](crate::Scene::origin) there.
    pub positions: Vec<[f32; 3]>,
    /// Three indices of `positions` for each triangle, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Directions of any length, one for each position. Computed from the triangles where missing or zero.
    pub normals: Vec<[f32; 3]>,
    /// For each triangle the tangents at its corners, for a [`NormalMap`](crate::NormalMap): the direction of u along the surface,
    /// of any length, and in the fourth number the sign `w`. [`Mesh::with_tangents`] computes them.
    pub tangents: Vec<[[f32; 4]; 3]>,
    /// Two sets of texture coordinates, one pair for each position; (0, 0) is the top left corner of a texture.
    pub uvs: [Vec<[f32; 2]>; 2],
    /// Texture coordinates of a lightmap where they are neither of these sets, one pair for each position.
    pub lightmap_uvs: Vec<[f32; 2]>,
    /// Linear color and alpha for each position, factors of the material's base color.
    pub colors: Vec<[f32; 4]>,
    /// Index into the materials of the scene. Without one a mesh is white and double-sided.
    pub material: Option<usize>,
    /// The origin of the mesh in its file.
    pub source: Option<MeshSource>,
    /// The edges whose middles the last vertices are, in their order: two earlier vertices each, or one twice for a
    /// copy of it. Splitting appends to them, so that the vertices before are those of the file.
    pub halved: Vec<[u32; 2]>,
}

/// The origin of a mesh in a glTF file: one primitive, as one node shows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MeshSource {
    /// Index of the node. A mesh that several nodes show becomes several meshes of the scene.
    pub node: usize,
    /// Index of the mesh.
    pub mesh: usize,
    /// Index of the primitive within the mesh.
    pub primitive: usize,
}

/// Triangles that share a material. Everything is finite and every index in range.
///
/// Vertices keep their number and order, duplicates and unused ones included, so that values computed for them can be
/// written back to their file. Triangles without area are dropped and counted; in an [`AnimatedScene`](crate::AnimatedScene)
/// triangles may lose their area, and gain it, and stay.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    parts: MeshParts,
    dropped: usize,
    made_normals: usize,
}

impl Mesh {
    /// Checks the parts, drops triangles without area, computes missing normals and normalizes the others. Tangents become
    /// unit vectors perpendicular to the normals, or zero where they have no such part, and their `w` becomes 1 or -1.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] if a number is not finite, an index out of range, an attribute not as long as the
    /// positions, the tangents not as many as the triangles, or no triangle has an area.
    pub fn new(parts: MeshParts) -> Result<Self, SceneError> {
        Self::keeping(parts, |_| false)
    }

    /// The same, but of triangles without area those stay that are to be kept: they may open in a pose.
    pub(crate) fn keeping(parts: MeshParts, is_kept: impl Fn([u32; 3]) -> bool) -> Result<Self, SceneError> {
        let mut parts = parts;
        if let Err(message) = check(&parts) {
            return Err(SceneError::Invalid { place: place_of(&parts), message });
        }
        let before = parts.triangles.len();
        let positions = &parts.positions;
        let stays = |t: [u32; 3]| double_area(t.map(|i| positions[i as usize])) > 0.0 || is_kept(t);
        if !parts.tangents.is_empty() {
            let mut triangles = parts.triangles.iter();
            parts.tangents.retain(|_| triangles.next().is_some_and(|&t| stays(t)));
        }
        parts.triangles.retain(|&t| stays(t));
        let dropped = before - parts.triangles.len();
        if parts.triangles.is_empty() {
            let message = match before {
                0 => "expected triangles, found none".to_string(),
                _ => format!("expected triangles with an area, found {before} without"),
            };
            return Err(SceneError::Invalid { place: place_of(&parts), message });
        }
        let made_normals = complete_normals(&mut parts);
        complete_tangents(&mut parts);
        Ok(Self { parts, dropped, made_normals })
    }

    /// The name in messages.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.parts.name
    }

    /// Points, z up. Those of a scene's meshes count from its [`Scene::origin`](crate::Scene::origin).
    #[must_use]
    pub fn positions(&self) -> &[[f32; 3]] {
        &self.parts.positions
    }

    /// The shading normal of each position, a unit vector.
    #[must_use]
    pub fn normals(&self) -> &[[f32; 3]] {
        &self.parts.normals
    }

    /// For each triangle the tangents at its corners, `[x, y, z, w]`: unit vectors along u, perpendicular to the normals, or zero, and
    /// the sign of `w (N × T)`, which runs against v. Empty where the mesh has none.
    #[must_use]
    pub fn tangents(&self) -> &[[[f32; 4]; 3]] {
        &self.parts.tangents
    }

    /// Three indices for each triangle.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.parts.triangles
    }

    /// Texture coordinates of set 0 or 1; empty where the mesh has none.
    ///
    /// # Panics
    /// If `set` is above 1.
    #[must_use]
    pub fn uvs(&self, set: usize) -> &[[f32; 2]] {
        &self.parts.uvs[set]
    }

    /// The texture coordinates of a lightmap: a third set where there is one, else the second, else the first.
    #[must_use]
    pub fn lightmap_uvs(&self) -> &[[f32; 2]] {
        let sets = [&self.parts.lightmap_uvs[..], self.uvs(1)];
        sets.into_iter().find(|set| !set.is_empty()).unwrap_or_else(|| self.uvs(0))
    }

    /// The third set of texture coordinates, which only a lightmap uses; empty where the mesh has none.
    #[must_use]
    pub fn third_uvs(&self) -> &[[f32; 2]] {
        &self.parts.lightmap_uvs
    }

    /// Linear color and alpha for each position; empty where the mesh has none.
    #[must_use]
    pub fn colors(&self) -> &[[f32; 4]] {
        &self.parts.colors
    }

    /// Index into the materials of the scene.
    #[must_use]
    pub fn material(&self) -> Option<usize> {
        self.parts.material
    }

    /// The origin of the mesh in its file.
    #[must_use]
    pub fn source(&self) -> Option<MeshSource> {
        self.parts.source
    }

    /// The edges whose middles the last vertices are, in their order; empty where nothing was split. The ends of an
    /// edge are earlier vertices, middles among them.
    #[must_use]
    pub fn halved(&self) -> &[[u32; 2]] {
        &self.parts.halved
    }

    /// The number of triangles without area that were dropped.
    #[must_use]
    pub fn dropped_triangles(&self) -> usize {
        self.dropped
    }

    /// The number of normals that were missing or zero and were computed.
    #[must_use]
    pub fn made_normals(&self) -> usize {
        self.made_normals
    }

    /// The corners of one triangle.
    ///
    /// # Panics
    /// If there is no such triangle.
    #[must_use]
    pub fn corners(&self, triangle: usize) -> [[f32; 3]; 3] {
        self.parts.triangles[triangle].map(|i| self.parts.positions[i as usize])
    }

    /// The same mesh with other positions, which keep the area of every triangle.
    pub(crate) fn with_positions(mut self, position: impl Fn([f32; 3]) -> [f32; 3]) -> Self {
        self.parts.positions.iter_mut().for_each(|p| *p = position(*p));
        self
    }

    /// The same mesh with normals that were made of more than its own triangles: unit vectors, or zero where those that it made
    /// of its own stay. None for a mesh whose normals were given.
    pub(crate) fn with_made_normals(mut self, made: &[[f32; 3]]) -> Self {
        let pairs = self.parts.normals.iter_mut().zip(made);
        pairs.filter(|(_, made)| **made != [0.0; 3]).for_each(|(own, made)| *own = *made);
        self.made_normals = self.made_normals.max(made.len());
        self
    }

    /// The same mesh with tangents computed from texture coordinates of this set, as MikkTSpace does [Mikkelsen 2008], which glTF
    /// asks for; without such coordinates with none.
    ///
    /// ```text
    ///   T_v ∝ Σ_t α_t normalize(T_t - N (N·T_t))      T_t = ∂p/∂u of triangle t, α_t = its angle at vertex v in the plane of N
    ///   w = -sign of the triangle's area in (u, v)
    /// ```
    ///
    /// The sum goes over triangles of the same `w` around all vertices of one position, normal and place in the texture. v runs
    /// downwards, hence the sign. A triangle without area in the texture adds nothing and takes what its vertices have, the sum of
    /// `w = 1` first; where that is zero, it keeps its normals.
    ///
    /// The test `tangents_are_those_of_mikktspace` compares them. Three things differ. MikkTSpace groups triangles by their edges, too:
    /// those that meet in a vertex but in no edge are apart there. There, a triangle without area in the texture is of the side of a
    /// neighbor. And the mesh is taken as it stands, in the world if it was read from a file: there a node that stretches or shears it
    /// has been at work before.
    ///
    /// # Panics
    /// If `set` is above 1.
    #[must_use]
    pub fn with_tangents(mut self, set: usize) -> Self {
        let MeshParts { positions, normals, uvs, triangles, .. } = &self.parts;
        self.parts.tangents = match &uvs[set][..] {
            [] => Vec::new(),
            uvs => corner_tangents(positions, normals, uvs, triangles),
        };
        self
    }

    /// The same mesh without tangents.
    pub(crate) fn without_tangents(mut self) -> Self {
        self.parts.tangents = Vec::new();
        self
    }

    /// The same mesh, of another material.
    pub(crate) fn with_material(mut self, material: Option<usize>) -> Self {
        self.parts.material = material;
        self
    }

    /// The same mesh under maps of points, of normals and of tangents: all triangles stay, those that have lost their area in a pose
    /// too. Triangles that are `flipped`, by a mirror, run around the other way.
    pub(crate) fn mapped(
        self,
        position: impl Fn([f32; 3]) -> [f32; 3],
        normal: impl Fn([f32; 3]) -> [f32; 3],
        tangent: impl Fn([f32; 3]) -> [f32; 3],
        flipped: bool,
    ) -> Result<Self, SceneError> {
        let mut parts = self.parts;
        parts.positions.iter_mut().for_each(|p| *p = position(*p));
        parts.normals.iter_mut().for_each(|n| *n = normal(*n));
        parts.map_tangents(tangent);
        if flipped {
            parts.flip();
        }
        if let Err(message) = check_numbers(&parts) {
            return Err(SceneError::invalid(&place_of(&parts), message));
        }
        complete_normals(&mut parts);
        complete_tangents(&mut parts);
        Ok(Self { parts, ..self })
    }

    /// The same vertices and triangles, elsewhere: all triangles stay, those that lose their area too. Empty normals stand
    /// for missing ones, and so do empty tangents, of which there is else one for each vertex. Triangles that are
    /// `flipped` run around the other way.
    pub(crate) fn posed(
        &self,
        positions: Vec<[f32; 3]>,
        normals: Vec<[f32; 3]>,
        tangents: &[[f32; 4]],
        flipped: bool,
    ) -> Result<Self, SceneError> {
        let mut parts = MeshParts { positions, normals, tangents: Vec::new(), ..self.parts.clone() };
        if flipped {
            parts.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        if !tangents.is_empty() {
            parts.tangents = parts.triangles.iter().map(|t| t.map(|i| tangents[i as usize])).collect();
        }
        if let Err(message) = check_numbers(&parts) {
            return Err(SceneError::invalid(&place_of(&parts), message));
        }
        let made_normals = complete_normals(&mut parts);
        complete_tangents(&mut parts);
        Ok(Self { parts, dropped: self.dropped, made_normals })
    }

    /// The same mesh without triangles that have lost their area in a pose, and how many those are. All may be gone.
    pub(crate) fn without_flat_triangles(mut self) -> (Self, usize) {
        let MeshParts { positions, triangles, tangents, .. } = &mut self.parts;
        let has_area = |t: &[u32; 3]| double_area(t.map(|i| positions[i as usize])) > 0.0;
        let before = triangles.len();
        if !tangents.is_empty() {
            let mut of = triangles.iter();
            tangents.retain(|_| of.next().is_some_and(has_area));
        }
        triangles.retain(has_area);
        let flat = before - triangles.len();
        self.dropped += flat;
        (self, flat)
    }

    /// The same surface with other vertices, of which each has the attributes of one `from` which it was made, and
    /// with texture coordinates of a lightmap for them, in the first set that is free. Triangles keep their order.
    pub(crate) fn with_lightmap(mut self, from: &[u32], triangles: Vec<[u32; 3]>, uvs: Vec<[f32; 2]>) -> Self {
        fn taken<T: Copy>(values: &mut Vec<T>, from: &[u32]) {
            if !values.is_empty() {
                *values = from.iter().map(|&i| values[i as usize]).collect();
            }
        }
        let parts = &mut self.parts;
        taken(&mut parts.positions, from);
        taken(&mut parts.normals, from);
        parts.uvs.iter_mut().for_each(|uvs| taken(uvs, from));
        taken(&mut parts.colors, from);
        parts.triangles = triangles;
        parts.lightmap_uvs = Vec::new();
        match parts.uvs.iter_mut().find(|set| set.is_empty()) {
            Some(free) => *free = uvs,
            None => parts.lightmap_uvs = uvs,
        }
        self
    }

    /// The parts of the mesh, to be changed and made into another mesh.
    #[must_use]
    pub fn into_parts(self) -> MeshParts {
        self.parts
    }
}

impl MeshParts {
    /// Replaces the directions of all tangents.
    pub(crate) fn map_tangents(&mut self, tangent: impl Fn([f32; 3]) -> [f32; 3]) {
        for [x, y, z, _] in self.tangents.as_flattened_mut() {
            [*x, *y, *z] = tangent([*x, *y, *z]);
        }
    }

    /// Lets all triangles run around the other way, as in a mirror, which also turns the signs of tangents around.
    pub(crate) fn flip(&mut self) {
        self.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        for corners in &mut self.tangents {
            corners.swap(1, 2);
            corners.iter_mut().for_each(|[.., w]| *w = -*w);
        }
    }
}

/// The largest coordinate of a mesh: areas and edge functions of `f32` stay far from infinity.
pub(crate) const LARGEST_COORDINATE: f32 = 1e15;

fn place_of(parts: &MeshParts) -> String {
    if parts.name.is_empty() { "mesh".to_string() } else { format!("mesh `{}`", parts.name) }
}

/// Checks everything that must hold before an index is used.
fn check(parts: &MeshParts) -> Result<(), String> {
    let count = parts.positions.len();
    if u32::try_from(count).is_err() {
        return Err(format!("expected at most {} vertices, found {count}", u32::MAX));
    }
    check_numbers(parts)?;
    check_attribute("texture coordinates of set 0", &parts.uvs[0], count)?;
    check_attribute("texture coordinates of set 1", &parts.uvs[1], count)?;
    check_attribute("texture coordinates of a lightmap", &parts.lightmap_uvs, count)?;
    check_attribute("colors", &parts.colors, count)?;
    check_tangents(parts)?;
    check_halved(parts)?;
    if let Some(i) = parts.colors.iter().position(|color| color.iter().any(|c| !(0.0..=1.0).contains(c))) {
        return Err(format!("expected colors from 0 to 1, found {:?} at vertex {i}", parts.colors[i]));
    }
    for (t, triangle) in parts.triangles.iter().enumerate() {
        if let Some(i) = triangle.iter().find(|&&i| i as usize >= count) {
            return Err(format!("triangle {t} uses vertex {i}, but there are {count} vertices"));
        }
    }
    Ok(())
}

/// Checks positions and normals.
fn check_numbers(parts: &MeshParts) -> Result<(), String> {
    let count = parts.positions.len();
    check_attribute("positions", &parts.positions, count)?;
    if let Some(i) = parts.positions.iter().position(|p| p.iter().any(|c| c.abs() > LARGEST_COORDINATE)) {
        let p = parts.positions[i];
        return Err(format!("expected coordinates of at most {LARGEST_COORDINATE:e}, found {p:?} at vertex {i}"));
    }
    check_attribute("normals", &parts.normals, count)
}

fn check_tangents(parts: &MeshParts) -> Result<(), String> {
    let (count, found) = (parts.triangles.len(), parts.tangents.len());
    if found != 0 && found != count {
        return Err(format!("expected tangents at the corners of {count} triangles, found those of {found}"));
    }
    match parts.tangents.iter().position(|corners| !corners.as_flattened().iter().all(|c| c.is_finite())) {
        None => Ok(()),
        Some(t) => Err(format!("expected finite tangents, found {:?} at triangle {t}", parts.tangents[t])),
    }
}

/// The ends of an edge stand before its middle.
fn check_halved(parts: &MeshParts) -> Result<(), String> {
    let (count, halved) = (parts.positions.len(), &parts.halved);
    let Some(first) = count.checked_sub(halved.len()) else {
        return Err(format!("expected at most {count} halved edges, one for each vertex, found {}", halved.len()));
    };
    let is_late = |(k, ends): (usize, &[u32; 2])| ends.iter().any(|&end| end as usize >= first + k);
    match halved.iter().enumerate().position(is_late) {
        None => Ok(()),
        Some(k) => Err(format!("expected ends of edges before their middle {}, found {:?}", first + k, halved[k])),
    }
}

fn check_attribute<const N: usize>(what: &str, values: &[[f32; N]], count: usize) -> Result<(), String> {
    if !values.is_empty() && values.len() != count {
        return Err(format!("expected {count} {what}, one for each vertex, found {}", values.len()));
    }
    match values.iter().position(|value| !value.iter().all(|c| c.is_finite())) {
        None => Ok(()),
        Some(i) => Err(format!("expected finite {what}, found {:?} at vertex {i}", values[i])),
    }
}

/// Twice the area of a triangle, in `f64`, where neither the products overflow nor small ones vanish.
pub(crate) fn double_area(corners: [[f32; 3]; 3]) -> f64 {
    let [a, b, c] = corners.map(|p| Vec3::from(p).as_dvec3());
    (b - a).cross(c - a).length()
}

/// Computes missing normals and normalizes all of them; returns the number computed.
fn complete_normals(parts: &mut MeshParts) -> usize {
    let unit = |n: [f32; 3]| Vec3::from(n).as_dvec3().try_normalize();
    let given: Vec<Option<DVec3>> = match parts.normals.len() {
        0 => vec![None; parts.positions.len()],
        _ => parts.normals.iter().map(|&n| unit(n)).collect(),
    };
    let missing = given.iter().filter(|n| n.is_none()).count();
    let made = if missing > 0 { angle_weighted_normals(&parts.positions, &parts.triangles) } else { Vec::new() };
    let complete = given.iter().enumerate().map(|(i, n)| n.map_or_else(|| made[i], |n| n.as_vec3().to_array()));
    parts.normals = complete.collect();
    missing
}

/// Makes tangents unit vectors perpendicular to the normals, or zero.
fn complete_tangents(parts: &mut MeshParts) {
    let wide = |v: [f32; 3]| DVec3::from(v.map(f64::from));
    for (triangle, corners) in parts.triangles.iter().zip(&mut parts.tangents) {
        for (&i, tangent) in triangle.iter().zip(corners) {
            let [x, y, z, w] = *tangent;
            let (t, n) = (wide([x, y, z]), wide(parts.normals[i as usize]));
            let [x, y, z] = (t - n * n.dot(t)).normalize_or_zero().as_vec3().to_array();
            *tangent = [x, y, z, if w < 0.0 { -1.0 } else { 1.0 }];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quad() -> MeshParts {
        MeshParts {
            name: "quad".into(),
            positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..MeshParts::default()
        }
    }

    fn refusal(change: impl FnOnce(&mut MeshParts)) -> String {
        let mut parts = quad();
        change(&mut parts);
        Mesh::new(parts).unwrap_err().to_string()
    }

    #[test]
    fn triangles_without_area_are_dropped_and_counted_and_vertices_stay() {
        let mut parts = quad();
        parts.positions.extend([[0.0, 0.0, 0.0], [2.0, 2.0, 0.0]]);
        // Two equal indices, two equal positions, three points on a line.
        parts.triangles.extend([[0, 0, 1], [0, 4, 1], [0, 2, 5]]);
        let mesh = Mesh::new(parts).unwrap();
        assert_eq!(mesh.dropped_triangles(), 3, "dropped");
        assert_eq!(mesh.triangles(), [[0, 1, 2], [0, 2, 3]], "kept");
        assert_eq!(mesh.positions().len(), 6, "duplicates and unused vertices stay");
    }

    #[test]
    fn tiny_triangles_are_no_degenerate_ones() {
        let mut parts = quad();
        for p in &mut parts.positions {
            *p = p.map(|c| c * 1e-30);
        }
        let mesh = Mesh::new(parts).unwrap();
        assert_eq!(mesh.dropped_triangles(), 0, "a square of 1e-30");
        assert_eq!(mesh.normals()[0], [0.0, 0.0, 1.0], "its normal");
    }

    #[test]
    fn given_normals_are_normalized_and_zero_ones_are_made() {
        let mut parts = quad();
        parts.normals = vec![[0.0, 3.0, 4.0], [0.0; 3], [2.0, 0.0, 0.0], [0.0, 0.0, -1e-20]];
        let mesh = Mesh::new(parts).unwrap();
        assert_eq!(mesh.normals(), [[0.0, 0.6, 0.8], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]], "unit");
        assert_eq!(mesh.made_normals(), 1, "made");
    }

    #[test]
    fn tangents_are_made_perpendicular_to_the_normals_and_go_with_their_triangles() {
        let mut parts = quad();
        // The second triangle has no area; of the first, one tangent is along the normal.
        parts.triangles.insert(1, [0, 0, 1]);
        let [first, dropped, last] = [[0.0, 3.0, 4.0, -2.0], [7.0; 4], [5.0, 0.0, 0.0, 1.0]];
        parts.tangents = vec![[first, first, [0.0, 0.0, 1.0, 0.0]], [dropped; 3], [last; 3]];
        let mesh = Mesh::new(parts).unwrap();
        let y = [0.0, 1.0, 0.0, -1.0];
        assert_eq!(mesh.tangents(), [[y, y, [0.0, 0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0, 1.0]; 3]], "tangents");
        let mirrored = mesh.mapped(|[x, y, z]| [-x, y, z], |n| n, |[x, y, z]| [-x, y, z], true).unwrap();
        assert_eq!(mirrored.triangles()[0], [0, 2, 1], "corners of the mirrored mesh");
        let y = [0.0, 1.0, 0.0, 1.0];
        assert_eq!(mirrored.tangents()[0], [y, [0.0, 0.0, 0.0, -1.0], y], "with their tangents");
        assert_eq!(mirrored.tangents()[1], [[-1.0, 0.0, 0.0, -1.0]; 3], "the other way");
    }

    #[test]
    fn what_cannot_be_a_mesh_is_refused_in_one_line() {
        let cases = [
            (refusal(|p| p.triangles[1][2] = 4), "mesh `quad`: triangle 1 uses vertex 4, but there are 4 vertices"),
            (
                refusal(|p| p.positions[2][1] = f32::NAN),
                "mesh `quad`: expected finite positions, found [1.0, NaN, 0.0] at vertex 2",
            ),
            (refusal(|p| p.triangles.clear()), "mesh `quad`: expected triangles, found none"),
            (
                refusal(|p| p.triangles = vec![[0, 0, 1]; 1_000_000]),
                "mesh `quad`: expected triangles with an area, found 1000000 without",
            ),
            (refusal(|p| p.colors = vec![[1.0; 4]; 3]), "mesh `quad`: expected 4 colors, one for each vertex, found 3"),
            (
                refusal(|p| p.uvs[1] = vec![[f32::INFINITY, 0.0]; 4]),
                "mesh `quad`: expected finite texture coordinates of set 1, found [inf, 0.0] at vertex 0",
            ),
            (
                refusal(|p| p.tangents = vec![[[1.0; 4]; 3]]),
                "mesh `quad`: expected tangents at the corners of 2 triangles, found those of 1",
            ),
        ];
        for (found, expected) in cases {
            assert_eq!(found, expected, "refusal");
        }
    }
}
