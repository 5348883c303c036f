//! Triangles in pieces, each with its own vertices, materials and textures, where not all of them fit the bindings of a device.

use std::ops::Range;

use lobe_scene::{Mesh, Scene, TextureUse};

use crate::error::GpuError;
use crate::renderer::pieces::Piece;

/// Textures begin at multiples of this many texels, where a part of a buffer may begin.
pub(crate) const TEXTURE_STEP: usize = 64;

/// What one piece has at most.
#[derive(Clone, Debug)]
pub(crate) struct Most {
    /// Places of vertices. A piece ends at a multiple of `step`, where a part of every buffer of places may begin.
    pub(crate) places: usize,
    pub(crate) step: usize,
    pub(crate) triangles: usize,
    pub(crate) meshes: usize,
    pub(crate) texels: usize,
    /// Rows of a lightmap of this width.
    pub(crate) rows: usize,
    pub(crate) width: usize,
    /// Meshes that share no piece with others.
    pub(crate) alone: Vec<usize>,
}

impl Most {
    /// A limit of places alone.
    pub(crate) fn of_places(places: usize) -> Self {
        let most = usize::MAX;
        Self { places, step: 1, triangles: most, meshes: most, texels: most, rows: most, width: 0, alone: Vec::new() }
    }
}

/// Triangles that are drawn at once.
#[derive(Clone, Debug)]
pub(crate) struct SurfacePiece {
    /// Its number among several, and its places.
    pub(crate) places: Piece,
    /// Its triangles among `corners`.
    pub(crate) triangles: Range<usize>,
    pub(crate) meshes: Range<usize>,
    pub(crate) textures: Range<usize>,
    /// Of the lightmap.
    pub(crate) rows: Range<usize>,
}

/// The triangles of a scene in pieces.
#[derive(Clone, Debug)]
pub(crate) struct SurfacePieces {
    pub(crate) pieces: Vec<SurfacePiece>,
    /// The three places of each triangle among those of its piece, and its mesh among those of its piece.
    pub(crate) corners: Vec<[u32; 4]>,
    /// The number of each triangle in the scene, in the order of `corners`.
    pub(crate) numbers: Vec<u32>,
    pub(crate) order: PlaceOrder,
}

/// Which vertex is in which place: several if it is in several pieces.
#[derive(Clone, Debug, Default)]
pub(crate) struct PlaceOrder(Option<Vec<u32>>);

impl PlaceOrder {
    /// The values of vertices in their places.
    pub(crate) fn placed<T: Clone>(&self, values: Vec<T>) -> Vec<T> {
        match &self.0 {
            None => values,
            Some(order) => order.iter().map(|vertex| values[*vertex as usize].clone()).collect(),
        }
    }

    /// Whether places are vertices.
    pub(crate) fn is_as_given(&self) -> bool {
        self.0.is_none()
    }

    /// The places of some vertices, with the vertex in each; of those that are in several pieces several.
    pub(crate) fn places_of(&self, vertices: Range<usize>) -> impl Iterator<Item = (usize, usize)> {
        let placed = self.0.iter().flatten().map(|vertex| *vertex as usize).enumerate();
        placed.filter(move |(_, vertex)| vertices.contains(vertex))
    }

    /// The vertex in a place.
    pub(crate) fn vertex(&self, place: usize) -> usize {
        self.0.as_ref().map_or(place, |order| order[place] as usize)
    }

    /// How many places there are for so many vertices.
    pub(crate) fn len(&self, vertices: usize) -> usize {
        self.0.as_ref().map_or(vertices, Vec::len)
    }
}

impl SurfacePieces {
    /// Cuts a scene where it has more than a piece may have. One piece is the scene as it is.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] if one triangle or one texture is too large for a piece.
    pub(crate) fn new(scene: &Scene, most: &Most) -> Result<Self, GpuError> {
        let fits = scene.vertex_count() <= most.places
            && scene.triangle_count() <= most.triangles
            && scene.meshes().len() <= most.meshes
            && texel_starts(scene, 0..scene.textures().len()).1 <= most.texels
            && most.width <= most.rows;
        if fits { Ok(Self::whole(scene, most.width)) } else { Cutter::new(scene, most)?.run() }
    }

    /// Whether there is one piece.
    pub(crate) fn is_whole(&self) -> bool {
        self.order.is_as_given()
    }

    /// A name for what belongs to a piece: as it is for the only one.
    pub(crate) fn name(&self, piece: &SurfacePiece, name: &str) -> String {
        if self.is_whole() { name.into() } else { piece.places.of(name) }
    }

    /// The triangles of some meshes in a piece, among those of the piece.
    pub(crate) fn of_meshes(&self, piece: &SurfacePiece, meshes: &Range<usize>) -> Range<u32> {
        let corners = &self.corners[piece.triangles.clone()];
        let before = |end: usize| corners.partition_point(|c| piece.meshes.start + (c[3] as usize) < end) as u32;
        // Sorted by the lightmap, meshes come in any order.
        if meshes.start <= piece.meshes.start && piece.meshes.end <= meshes.end {
            return 0..corners.len() as u32;
        }
        before(meshes.start)..before(meshes.end)
    }

    fn whole(scene: &Scene, rows: usize) -> Self {
        let (mut first, mut corners) = (0, Vec::with_capacity(scene.triangle_count()));
        for (number, mesh) in scene.meshes().iter().enumerate() {
            corners.extend(mesh.triangles().iter().map(|[a, b, c]| [first + a, first + b, first + c, number as u32]));
            first += mesh.positions().len() as u32;
        }
        let piece = SurfacePiece {
            places: Piece { number: 0, items: 0..scene.vertex_count() },
            triangles: 0..corners.len(),
            meshes: 0..scene.meshes().len(),
            textures: 0..scene.textures().len(),
            rows: 0..rows,
        };
        let numbers = (0..corners.len() as u32).collect();
        Self { pieces: vec![piece], corners, numbers, order: PlaceOrder(None) }
    }
}

/// Where textures begin in a buffer of some of them, in texels, and the end of the last.
pub(crate) fn texel_starts(scene: &Scene, textures: Range<usize>) -> (Vec<u32>, usize) {
    let (mut starts, mut end) = (Vec::new(), 0);
    for texture in &scene.textures()[textures] {
        starts.push(end as u32);
        end += texture.texels().len().next_multiple_of(TEXTURE_STEP);
    }
    (starts, end)
}

/// The texture that a mesh is drawn with.
pub(crate) fn texture_of(scene: &Scene, mesh: usize) -> Option<TextureUse> {
    let uvs = |used: &TextureUse| scene.meshes()[mesh].uvs(used.uv_set);
    // Without coordinates a texture is left out.
    scene.material(mesh).base_color_texture.filter(|used| !uvs(used).is_empty())
}

/// The least range that has all textures that the material of a mesh names.
fn textures_of(scene: &Scene, mesh: usize) -> Range<usize> {
    let material = scene.material(mesh);
    let finish = [material.metallic_texture, material.roughness_texture, material.emissive_texture];
    let occlusion = material.occlusion_map.map(|map| map.used);
    let named = finish.into_iter().chain([occlusion, texture_of(scene, mesh)]).flatten();
    named.fold(0..0, |all, used| joined(&all, &(used.texture..used.texture + 1)))
}

/// Pieces while they are made: triangles go to the last one until it is full.
struct Cutter<'a> {
    scene: &'a Scene,
    most: &'a Most,
    out: SurfacePieces,
    order: Vec<u32>,
    /// The piece that each vertex was placed in last, from one, and its place there.
    placed: Vec<[u32; 2]>,
}

/// A triangle: its number, its mesh, the first vertex of that, the textures, the rows of the lightmap.
struct Triangle {
    number: u32,
    mesh: usize,
    corners: [u32; 3],
    textures: Range<usize>,
    rows: Range<usize>,
}

impl<'a> Cutter<'a> {
    fn new(scene: &'a Scene, most: &'a Most) -> Result<Self, GpuError> {
        if most.places < 3 || most.triangles == 0 || most.meshes == 0 {
            let message =
                "expected bindings of a triangle and its vertices at least, found smaller ones; take another device";
            return Err(GpuError::Unsupported { place: "surfaces".into(), message: message.into() });
        }
        let out =
            SurfacePieces { pieces: Vec::new(), corners: Vec::new(), numbers: Vec::new(), order: PlaceOrder(None) };
        Ok(Self { scene, most, out, order: Vec::new(), placed: vec![[0, 0]; scene.vertex_count()] })
    }

    fn run(mut self) -> Result<SurfacePieces, GpuError> {
        let (scene, mut first, mut number) = (self.scene, 0, 0);
        let mut triangles = Vec::with_capacity(scene.triangle_count());
        for (mesh, of) in scene.meshes().iter().enumerate() {
            let textures = textures_of(scene, mesh);
            for corners in of.triangles() {
                let rows = rows_of(of, corners, self.most.width);
                triangles.push(Triangle {
                    number,
                    mesh,
                    corners: corners.map(|c| first + c),
                    textures: textures.clone(),
                    rows,
                });
                number += 1;
            }
            first += of.positions().len() as u32;
        }
        if self.most.width > self.most.rows {
            // So that triangles of a piece are near each other in the lightmap.
            triangles.sort_by_key(|triangle| triangle.rows.start);
        }
        triangles.iter().try_for_each(|triangle| self.add(triangle))?;
        self.close();
        self.out.order = PlaceOrder(Some(self.order));
        Ok(self.out)
    }

    fn add(&mut self, triangle: &Triangle) -> Result<(), GpuError> {
        self.check(triangle)?;
        if !self.has_room(triangle) {
            self.close();
            let places = Piece { number: self.out.pieces.len(), items: self.order.len()..self.order.len() };
            let (at, mesh) = (self.out.corners.len(), triangle.mesh);
            let (textures, rows) = (triangle.textures.clone(), triangle.rows.clone());
            self.out.pieces.push(SurfacePiece { places, triangles: at..at, meshes: mesh..mesh + 1, textures, rows });
        }
        let number = self.out.pieces.len() as u32;
        let Some(piece) = self.out.pieces.last_mut() else { return Ok(()) };
        let places = triangle.corners.map(|vertex| {
            let [of, place] = &mut self.placed[vertex as usize];
            if *of != number {
                (*of, *place) = (number, (self.order.len() - piece.places.items.start) as u32);
                self.order.push(vertex);
            }
            *place
        });
        piece.places.items.end = self.order.len();
        piece.triangles.end += 1;
        // Of triangles that are sorted, a mesh may come before the first.
        let before = piece.meshes.start;
        piece.meshes = joined(&piece.meshes, &(triangle.mesh..triangle.mesh + 1));
        if piece.meshes.start < before {
            let shift = (before - piece.meshes.start) as u32;
            let of_piece = &mut self.out.corners[piece.triangles.start..];
            of_piece.iter_mut().for_each(|corner| corner[3] += shift);
        }
        piece.textures = joined(&piece.textures, &triangle.textures);
        piece.rows = joined(&piece.rows, &triangle.rows);
        let mesh = (triangle.mesh - piece.meshes.start) as u32;
        self.out.corners.push([places[0], places[1], places[2], mesh]);
        self.out.numbers.push(triangle.number);
        Ok(())
    }

    /// Whether a triangle fits the last piece.
    fn has_room(&self, triangle: &Triangle) -> bool {
        let (Some(piece), most) = (self.out.pieces.last(), self.most) else { return false };
        let number = self.out.pieces.len() as u32;
        let is_new = |vertex: &&u32| self.placed[**vertex as usize][0] != number;
        let places = piece.places.items.len() + triangle.corners.iter().filter(is_new).count();
        let meshes = joined(&piece.meshes, &(triangle.mesh..triangle.mesh + 1));
        let textures = joined(&piece.textures, &triangle.textures);
        let is_apart = meshes.len() > 1 && meshes.clone().any(|mesh| most.alone.contains(&mesh));
        places <= most.places
            && piece.triangles.len() < most.triangles
            && meshes.len() <= most.meshes
            && !is_apart
            && (textures == piece.textures || texel_starts(self.scene, textures).1 <= most.texels)
            && joined(&piece.rows, &triangle.rows).len() <= most.rows
    }

    /// Fills the places of the last piece up to where the next may begin.
    fn close(&mut self) {
        let filled = self.order.len().next_multiple_of(self.most.step);
        self.order.resize(filled, 0);
    }

    /// Refuses what no piece has room for.
    fn check(&self, triangle: &Triangle) -> Result<(), GpuError> {
        let refuse = |place: &str, message: String| Err(GpuError::Unsupported { place: place.into(), message });
        if !triangle.textures.is_empty() {
            let (found, most) = (texel_starts(self.scene, triangle.textures.clone()).1, self.most.texels);
            if found > most {
                return refuse(
                    "texels",
                    format!(
                        "expected textures of at most {most} texels, which one binding of this device holds, found {found}; make them \
                     smaller, or take another device"
                    ),
                );
            }
        }
        let (found, most) = (triangle.rows.len(), self.most.rows);
        if found > most {
            return refuse(
                "radiance",
                format!(
                    "expected triangles over at most {most} rows of the lightmap, which one binding of this device holds, found one over \
                 {found}; bake a smaller lightmap, or take another device"
                ),
            );
        }
        Ok(())
    }
}

/// The least range that has both; one that is empty has nothing.
fn joined(a: &Range<usize>, b: &Range<usize>) -> Range<usize> {
    match (a.is_empty(), b.is_empty()) {
        (true, _) => b.clone(),
        (_, true) => a.clone(),
        _ => a.start.min(b.start)..a.end.max(b.end),
    }
}

/// The rows of a lightmap that the shader `shade_lightmap` may read for a triangle: those of its corners, and one more on each side for the
/// interpolation and its rounding. They begin where a part of a buffer may.
fn rows_of(mesh: &Mesh, corners: &[u32; 3], width: usize) -> Range<usize> {
    if width == 0 {
        return 0..0;
    }
    let row = |corner: &u32| {
        let v = mesh.lightmap_uvs().get(*corner as usize).map_or(0.0, |uv| uv[1]);
        (v * width as f32 - 0.5).clamp(0.0, (width - 1) as f32)
    };
    let rows = corners.each_ref().map(row);
    let first = (rows.iter().copied().fold(f32::INFINITY, f32::min) as usize).saturating_sub(1);
    let end = (rows.iter().copied().fold(0.0, f32::max) as usize + 3).min(width);
    // Of four bytes a texel, as charts have.
    let step = TEXTURE_STEP / TEXTURE_STEP.min(1 << width.trailing_zeros().min(TEXTURE_STEP.trailing_zeros()));
    first / step * step..end
}
