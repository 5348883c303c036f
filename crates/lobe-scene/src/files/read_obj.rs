//! Wavefront OBJ reader, with the materials of MTL files.

use std::collections::{BTreeSet, HashMap};
use std::{iter, mem};

use crate::error::SceneError;
use crate::files::obj::lines::{Line, bytes_of_text, for_each_line, is_utf16, text_of};
use crate::files::obj::materials::{MtlMaterial, read_mtl};
use crate::files::obj::smoothing::{NormalSums, Smoothing, split};
use crate::files::picture::decode;
use crate::files::polygon::Triangulator;
use crate::files::source::{Source, emission_unused};
use crate::scene::material::{Material, TextureUse};
use crate::scene::mesh::MeshParts;
use crate::scene::near_origin::{from_origin, note_of_rounding, noticeable_rounding, origin_of};
use crate::scene::scene::Scene;
use crate::scene::texture::linear_from_srgb;
use crate::scene::texture::{Texture, Wrap};
use crate::scene::up::Up;

/// Reads one mesh for each object, group and material.
///
/// OBJ indexes positions, texture coordinates and normals separately. Each combination that a face uses becomes a
/// vertex, in the order of first use. Where normals are missing, vertices of several smoothing groups, or of flat faces in several
/// planes, are copied behind these; those of one group have one normal at each position of the file, in whichever meshes they are.
pub(crate) fn read(bytes: &[u8], source: &mut Source<'_>, up: Up) -> Result<Scene, SceneError> {
    if is_utf16(bytes) {
        return Err(source.invalid(NOT_UTF16));
    }
    let mut obj = Obj::default();
    obj.current.name = UNNAMED.to_owned();
    source.count_bytes(bytes_of_text(bytes))?;
    let text = text_of(bytes);
    if text.lines().any(|line| line.starts_with(POLYPAINT)) {
        source.note(format!("colors of vertices in comments ({POLYPAINT}) are not used"));
    }
    for_each_line(&text, |line| {
        obj.read_line(&line, source)?;
        obj.count_lists(COUNTED_AT_ONCE, source)
    })?;
    obj.count_lists(1, source)?;
    obj.finish_model();
    let origin = obj.move_near_origin(source);
    obj.tell_of_colors(source);
    let mut triangulator = Triangulator::new();
    let mut shapes = Vec::with_capacity(obj.models.len());
    for model in &obj.models {
        shapes.push(obj.shape(model, up, &mut triangulator, source)?);
    }
    let sums = obj.normal_sums(&shapes, up, source)?;
    // The last one of a name counts.
    let materials = obj.materials.iter().enumerate().map(|(index, material)| (material.name.as_str(), index)).collect();
    let mut meshes = Vec::new();
    for shape in shapes {
        let made = shape.made_normals(&sums);
        let parts = obj.mesh_parts(shape, &made, &materials, up, source);
        meshes.extend(source.mesh(parts)?.map(|mesh| mesh.with_made_normals(&made)));
    }
    triangulator.note_filled(source);
    if meshes.is_empty() {
        return Err(source.no_triangles());
    }
    let (materials, textures) = read_materials(&obj.materials, source)?;
    let scene = Scene::new(meshes, materials, textures).map_err(|error| error.within(source.name))?;
    Ok(scene.moved(up.to_world(origin)))
}

const NOT_UTF16: &str = "expected UTF-8 or Latin-1, found UTF-16";

/// Bytes of lists that grow before they are counted.
const COUNTED_AT_ONCE: u64 = 1 << 20;

/// A list takes up to so many times the bytes of its items, as it doubles when it is full.
const GROWN: u64 = 2;

/// Statements that change no triangle: parts of free-form curves and surfaces, which are noted by themselves, and how
/// programs show a file.
const SILENT: [&str; 21] = [
    "vp", "cstype", "deg", "bmat", "step", "parm", "trim", "hole", "scrv", "sp", "end", "con", "mg", "ctech", "stech",
    "lod", "bevel", "c_interp", "d_interp", "cdc", "res",
];

/// The beginning of comments that sculpting programs write colors of vertices in.
const POLYPAINT: &str = "#MRGB";

/// The name of a mesh that has none in its file.
const UNNAMED: &str = "unnamed_object";

/// The index of a texture coordinate or normal that a corner does not have.
const NONE: u32 = u32::MAX;

/// Colors of vertices up to here overshoot 1, such as by a filter; larger ones are bytes.
const MOST_ABOVE_ONE: f32 = 2.0;

/// Indices of position, texture coordinate and normal.
type Corner = [u32; 3];

/// The content of a file.
#[derive(Default)]
struct Obj {
    /// As the file has them, until all are known.
    places: Vec<[f64; 3]>,
    /// Then from an origin near those that faces use.
    positions: Vec<[f32; 3]>,
    /// Colors of positions; those at the end may be missing.
    colors: Vec<Option<[f32; 3]>>,
    /// What stands for a whole color.
    whole: f32,
    uvs: Vec<[f32; 2]>,
    normals: Vec<[f32; 3]>,
    materials: Vec<MtlMaterial>,
    /// The names of the files of materials.
    libraries: BTreeSet<String>,
    models: Vec<Model>,
    /// The model that is being read.
    current: Model,
    /// What the last line `s` says.
    smoothing: Smoothing,
    /// Corners and faces of the models that are finished.
    finished: [usize; 2],
    /// Bytes of the lists that are counted.
    counted: u64,
}

/// The faces of an object or a group that are of one material.
#[derive(Default)]
struct Model {
    name: String,
    /// The name of the material.
    material: Option<String>,
    corners: Vec<Corner>,
    faces: Vec<Face>,
}

impl Model {
    /// Edges of faces, by the numbers of their positions: all but the last one of each.
    fn edges(&self) -> impl Iterator<Item = [usize; 2]> {
        let starts = iter::once(0).chain(self.faces.iter().map(|face| face.end));
        let ranges = starts.zip(&self.faces).map(|(start, face)| start..face.end);
        ranges.flat_map(|range| self.corners[range].windows(2)).map(|pair| [pair[0][0] as usize, pair[1][0] as usize])
    }
}

struct Face {
    /// The end of its corners, which begin at the end of the face before.
    end: usize,
    line: usize,
    smoothing: Smoothing,
}

/// A model with its vertices.
struct Shape<'a> {
    model: &'a Model,
    /// The corners that became vertices.
    corners: Vec<Corner>,
    triangles: Vec<[u32; 3]>,
    /// How the normals of each triangle are made.
    smoothing: Vec<Smoothing>,
    /// Whether normals are made: some corner has none.
    lacks_normals: bool,
}

impl Obj {
    fn read_line(&mut self, line: &Line<'_>, source: &mut Source<'_>) -> Result<(), SceneError> {
        let invalid = |source: &Source<'_>, what: &str| {
            let Line { number, keyword, rest } = line;
            Err(source.invalid(format!("line {number}: expected {what} after {keyword}, found `{rest}`")))
        };
        match line.keyword {
            "v" => {
                match line.numbers().filter(|numbers| numbers.iter().all(|c: &f64| (*c as f32).is_finite())).as_deref()
                {
                    Some(&[x, y, z]) => self.places.push([x, y, z]),
                    // A weight divides, as in the renderers that heed it.
                    Some(&[x, y, z, w]) if w != 0.0 => self.places.push([x, y, z].map(|c| c / w)),
                    Some(&[x, y, z, r, g, b, ..]) => {
                        self.places.push([x, y, z]);
                        self.colors.resize(self.places.len() - 1, None);
                        self.colors.push(Some([r, g, b].map(|c| c as f32)));
                    }
                    _ => return invalid(source, "three coordinates, and a weight or a color"),
                }
            }
            "vt" => match line.numbers().as_deref() {
                Some(&[u, v, ..]) => self.uvs.push([u, v]),
                Some(&[u]) => self.uvs.push([u, 0.0]),
                _ => return invalid(source, "two texture coordinates"),
            },
            "vn" => match line.numbers().as_deref() {
                Some(&[x, y, z, ..]) => self.normals.push([x, y, z]),
                _ => return invalid(source, "three coordinates"),
            },
            "f" => self.read_face(line, source)?,
            "o" | "g" => {
                self.finish_model();
                self.current.name = if line.rest.is_empty() { UNNAMED } else { line.rest }.to_owned();
            }
            "usemtl" => {
                let material = Some(line.rest.to_owned());
                if self.current.material != material {
                    self.finish_model();
                    self.current.material = material;
                }
            }
            "s" => match line.words().next().and_then(Smoothing::of) {
                Some(smoothing) => self.smoothing = smoothing,
                None => source.note(format!(
                    "line {}: expected the number of a smoothing group or off after s, found `{}`, which is not used",
                    line.number, line.rest
                )),
            },
            "mtllib" => self.read_mtl(&line.rest.replace('\\', "/"), source)?,
            "curv" | "curv2" | "surf" => source.note("free-form curves and surfaces are not used"),
            "p" | "l" => source.note("points and lines are left out"),
            "usemap" => source.note("usemap is not used: textures are those of the materials"),
            "call" | "csh" => source.note(format!("{} is not used: what it brings is missing", line.keyword)),
            keyword if SILENT.contains(&keyword) => {}
            _ => source.note(format!("{} is not used", line.short_keyword())),
        }
        Ok(())
    }

    fn read_face(&mut self, line: &Line<'_>, source: &mut Source<'_>) -> Result<(), SceneError> {
        let counts = [self.places.len(), self.uvs.len(), self.normals.len()];
        let before = self.current.corners.len();
        for word in line.words() {
            let Some(corner) = corner_of(word, counts) else {
                let message = format!("line {}: expected corners such as 1, 1/2 or 1//3, found `{word}`", line.number);
                return Err(source.invalid(message));
            };
            self.current.corners.push(corner);
        }
        if self.current.corners.len() < before + 3 {
            self.current.corners.truncate(before);
            source.note("faces of fewer than three corners are left out");
        } else {
            let (end, smoothing) = (self.current.corners.len(), self.smoothing);
            self.current.faces.push(Face { end, line: line.number, smoothing });
        }
        Ok(())
    }

    /// Reads a file of materials, once. A missing one, and what is not understood of it, is no error: shapes are known
    /// without.
    fn read_mtl(&mut self, file: &str, source: &mut Source<'_>) -> Result<(), SceneError> {
        if !self.libraries.insert(file.to_owned()) {
            return Ok(());
        }
        match source.referenced_file(file) {
            Ok(bytes) if is_utf16(&bytes) => source.note(format!("{file}: {NOT_UTF16}")),
            Ok(bytes) => {
                let (materials, notes) = read_mtl(&bytes, file);
                notes.into_iter().for_each(|note| source.note(note));
                self.materials.extend(materials);
            }
            Err(error @ SceneError::Refused { .. }) => return Err(error),
            // Several names in one line, none of which has a space then.
            Err(SceneError::Io { .. }) if file.contains(char::is_whitespace) => {
                for name in file.split_whitespace() {
                    self.read_mtl(name, source)?;
                }
            }
            Err(error) => source.note(format!("materials are missing, their surfaces are white: {error}")),
        }
        Ok(())
    }

    /// Counts the bytes of all lists against the limit, where they have grown by some.
    fn count_lists(&mut self, least: u64, source: &mut Source<'_>) -> Result<(), SceneError> {
        let [corners, faces] = self.finished;
        let bytes = |count: usize, each: usize| (count as u64).saturating_mul(each as u64).saturating_mul(GROWN);
        let lists = [
            // As the file has them, and from the origin.
            bytes(self.places.len(), size_of::<[f64; 3]>() + size_of::<[f32; 3]>()),
            bytes(self.colors.len(), size_of::<Option<[f32; 3]>>()),
            bytes(self.uvs.len(), size_of::<[f32; 2]>()),
            bytes(self.normals.len(), size_of::<[f32; 3]>()),
            bytes(corners + self.current.corners.len(), size_of::<Corner>()),
            bytes(faces + self.current.faces.len(), size_of::<Face>()),
            bytes(self.models.len(), size_of::<Model>()),
        ];
        let grown = lists.into_iter().fold(0, u64::saturating_add).saturating_sub(self.counted);
        if grown < least {
            return Ok(());
        }
        self.counted += grown;
        source.count_bytes(grown)
    }

    /// Ends the model that is being read, unless it is empty; the next has the same name and material.
    fn finish_model(&mut self) {
        if !self.current.faces.is_empty() {
            let next =
                Model { name: self.current.name.clone(), material: self.current.material.clone(), ..Model::default() };
            let model = mem::replace(&mut self.current, next);
            self.finished = [self.finished[0] + model.corners.len(), self.finished[1] + model.faces.len()];
            self.models.push(model);
        }
    }

    /// Lets the positions count from an origin near those that faces use: numbers of `f32` are coarse far away.
    fn move_near_origin(&mut self, source: &mut Source<'_>) -> [f64; 3] {
        let places = mem::take(&mut self.places);
        let corners = self.models.iter().flat_map(|model| &model.corners);
        let origin = origin_of(corners.filter_map(|&[v, ..]| places.get(v as usize).copied()));
        let rounding = noticeable_rounding(&places, self.models.iter().flat_map(Model::edges), origin);
        rounding.into_iter().for_each(|rounding| source.note(note_of_rounding(rounding)));
        self.positions = places.into_iter().map(|place| from_origin(place, origin)).collect();
        origin
    }

    /// Finds out what stands for a whole color: 1, or 255 where there are colors above 1 as bytes have them.
    fn tell_of_colors(&mut self, source: &mut Source<'_>) {
        let channels = || self.colors.iter().flatten().flatten();
        let largest = channels().copied().fold(0.0, f32::max);
        let are_bytes = largest > MOST_ABOVE_ONE && largest <= 255.0;
        self.whole = if are_bytes { 255.0 } else { 1.0 };
        if are_bytes {
            source.note(format!("colors of vertices go up to {largest}: they are taken as bytes, divided by 255"));
        } else if channels().any(|c| !(0.0..=1.0).contains(c)) {
            source.note("colors of vertices are outside of 0 to 1, and moved there");
        }
    }

    /// The vertices of a model and its triangles.
    fn shape<'a>(
        &self,
        model: &'a Model,
        up: Up,
        triangulator: &mut Triangulator,
        source: &mut Source<'_>,
    ) -> Result<Shape<'a>, SceneError> {
        let (mut corners, indices) = self.vertices(model, source)?;
        let count = indices.len() - 2 * model.faces.len();
        source.count(corners.len(), count)?;
        let positions = self.positions_of(&corners, up);
        let mut triangles = Vec::with_capacity(count);
        let mut smoothing = Vec::with_capacity(count);
        let mut start = 0;
        for face in &model.faces {
            triangulator.push(&indices[start..face.end], &positions, &mut triangles);
            smoothing.resize(triangles.len(), face.smoothing.under(source.options.missing_normals));
            start = face.end;
        }
        let lacks_normals = corners.iter().any(|&[.., vn]| vn == NONE);
        let needed = if lacks_normals { split(&positions, &triangles, &smoothing) } else { None };
        if let Some(flat) = needed {
            source.count(flat.added.len(), 0)?;
            let added: Vec<Corner> = flat.added.iter().map(|&vertex| corners[vertex as usize]).collect();
            corners.extend(added);
            triangles = flat.triangles;
        }
        Ok(Shape { model, corners, triangles, smoothing, lacks_normals })
    }

    fn positions_of(&self, corners: &[Corner], up: Up) -> Vec<[f32; 3]> {
        corners.iter().map(|&[v, ..]| up.to_world(self.positions[v as usize])).collect()
    }

    /// The normals around all positions; none if none are to be made.
    fn normal_sums(&self, shapes: &[Shape<'_>], up: Up, source: &Source<'_>) -> Result<NormalSums, SceneError> {
        if shapes.iter().all(|shape| !shape.lacks_normals || shape.smoothing.iter().all(|&s| s == Smoothing::Off)) {
            return Ok(NormalSums::default());
        }
        source.check_bytes((self.positions.len() as u64).saturating_mul(NormalSums::BYTES))?;
        let mut sums = NormalSums::new(self.positions.len());
        for shape in shapes {
            for (triangle, &smoothing) in shape.triangles.iter().zip(&shape.smoothing) {
                let places = triangle.map(|vertex| shape.corners[vertex as usize][0]);
                sums.add(smoothing, places, places.map(|v| up.to_world(self.positions[v as usize])));
            }
        }
        Ok(sums)
    }

    /// The mesh of a shape, with its `made` normals if there are any.
    fn mesh_parts(
        &self,
        shape: Shape<'_>,
        made: &[[f32; 3]],
        materials: &HashMap<&str, usize>,
        up: Up,
        source: &mut Source<'_>,
    ) -> MeshParts {
        let Shape { model, corners, triangles, .. } = shape;
        let name = &model.name;
        // Programs write sRGB-encoded vertex colors.
        let linear = |c: f32| linear_from_srgb(f64::from((c / self.whole).clamp(0.0, 1.0)));
        let color = |v: u32| self.colors.get(v as usize).copied().flatten();
        let colors = |[v, ..]: &Corner| color(*v).map(|[r, g, b]| [linear(r), linear(g), linear(b), 1.0]);
        // In OBJ v points upwards.
        let uvs = |[_, vt, _]: &Corner| self.uvs.get(*vt as usize).map(|&[u, v]| [u, 1.0 - v]);
        let normals = |[.., vn]: &Corner| self.normals.get(*vn as usize).map(|&n| up.to_world(n));
        let given = complete(&corners, normals, name, "normals", source);
        MeshParts {
            positions: self.positions_of(&corners, up),
            triangles,
            normals: if made.is_empty() { given } else { made.to_vec() },
            tangents: Vec::new(),
            uvs: [complete(&corners, uvs, name, "texture coordinates", source), Vec::new()],
            lightmap_uvs: Vec::new(),
            colors: complete(&corners, colors, name, "colors", source),
            material: material_of(model, materials, !self.libraries.is_empty(), source),
            source: None,
            halved: Vec::new(),
            name: name.clone(),
        }
    }

    /// The distinct corners of a model in the order of first use, and for each corner of its faces the index of its own.
    fn vertices(&self, model: &Model, source: &Source<'_>) -> Result<(Vec<Corner>, Vec<u32>), SceneError> {
        let counts = [self.positions.len(), self.uvs.len(), self.normals.len()];
        let (mut distinct, mut places) = (Vec::new(), HashMap::new());
        let mut indices = Vec::with_capacity(model.corners.len());
        let mut start = 0;
        for &Face { end, line, .. } in &model.faces {
            for &corner in &model.corners[start..end] {
                for (k, what) in ["vertex", "texture coordinate", "normal"].iter().enumerate() {
                    let (found, count) = (u64::from(corner[k]) + 1, counts[k]);
                    if found > count as u64 && (k == 0 || corner[k] != NONE) {
                        let message = format!("line {line}: the face uses {what} {found}, but there are {count}");
                        return Err(source.invalid(message));
                    }
                }
                indices.push(*places.entry(corner).or_insert_with(|| {
                    distinct.push(corner);
                    distinct.len() as u32 - 1
                }));
            }
            start = end;
        }
        Ok((distinct, indices))
    }
}

impl Shape<'_> {
    /// The normals that are made at its vertices, zero where it has flat triangles only; none if the file gives normals.
    fn made_normals(&self, sums: &NormalSums) -> Vec<[f32; 3]> {
        if !self.lacks_normals {
            return Vec::new();
        }
        let mut groups = vec![Smoothing::Off; self.corners.len()];
        let smoothed = self.triangles.iter().zip(&self.smoothing).filter(|&(_, &group)| group != Smoothing::Off);
        for (triangle, &group) in smoothed {
            triangle.iter().for_each(|&vertex| groups[vertex as usize] = group);
        }
        groups.iter().zip(&self.corners).map(|(&group, &[v, ..])| sums.normal(group, v)).collect()
    }
}

/// The index of the material of a model. Where libraries were read and none of them has it, that is noted.
fn material_of(
    model: &Model,
    materials: &HashMap<&str, usize>,
    names_library: bool,
    source: &mut Source<'_>,
) -> Option<usize> {
    let name = model.material.as_deref()?;
    let found = materials.get(name).copied();
    if found.is_none() && !materials.is_empty() {
        source.note(format!("material {name:?} is in none of the libraries; its faces are white"));
    } else if found.is_none() && !names_library {
        source.note("materials are named, and no library that has them (mtllib): surfaces are white");
    }
    found
}

/// An attribute of all corners; empty, with a note, if only some have it.
fn complete<T>(
    corners: &[Corner],
    attribute: impl Fn(&Corner) -> Option<T>,
    mesh: &str,
    what: &str,
    source: &mut Source<'_>,
) -> Vec<T> {
    let values: Vec<T> = corners.iter().filter_map(attribute).collect();
    if values.len() == corners.len() {
        return values;
    }
    if !values.is_empty() {
        source.note(format!("mesh `{mesh}` has {what} at some vertices only, which are not used"));
    }
    Vec::new()
}

/// A corner `v`, `v/vt`, `v//vn` or `v/vt/vn`. Numbers begin at 1; negative ones count from the end so far.
fn corner_of(word: &str, counts: [usize; 3]) -> Option<Corner> {
    let mut corner = [NONE; 3];
    let mut parts = word.split('/');
    for (k, count) in counts.iter().enumerate() {
        let Some(part) = parts.next() else { break };
        if part.is_empty() && k > 0 {
            continue;
        }
        let number: i64 = part.parse().ok()?;
        let index = if number < 0 { number.checked_add(*count as i64)? } else { number - 1 };
        // The last number stands for none.
        corner[k] = u32::try_from(index).ok().filter(|&index| index != NONE)?;
    }
    (parts.next().is_none() && corner[0] != NONE).then_some(corner)
}

/// A texture; none, with a note, where its file is missing, elsewhere or no picture: shapes and colors are known without, and names
/// are often those of another machine.
fn read_texture(file: &str, source: &mut Source<'_>) -> Result<Option<Texture>, SceneError> {
    let bytes = source.referenced_file(file);
    match bytes.and_then(|bytes| decode(&bytes, file, [Wrap::Repeat; 2], source)) {
        Ok(texture) => Ok(Some(texture)),
        Err(error @ SceneError::Refused { .. }) => Err(error),
        Err(error) => {
            source.note(format!("a texture is missing, its surfaces have their color alone: {error}"));
            Ok(None)
        }
    }
}

fn read_materials(
    materials: &[MtlMaterial],
    source: &mut Source<'_>,
) -> Result<(Vec<Material>, Vec<Texture>), SceneError> {
    let (mut read, mut textures, mut places) = (Vec::new(), Vec::new(), HashMap::new());
    for material in materials {
        let name = &material.name;
        let mut diffuse = material.diffuse.unwrap_or([1.0; 3]);
        if diffuse == [0.0; 3] && material.diffuse_texture.is_some() {
            source.note(format!("material `{name}`: Kd is 0, which would hide map_Kd, and taken as 1"));
            diffuse = [1.0; 3];
        }
        let mut result = Material::matte(name, diffuse.map(|c| source.unit(c, &format!("material `{name}`: Kd"))));
        if let Some(file) = &material.diffuse_texture {
            let texture = match places.get(file) {
                Some(&texture) => texture,
                None => {
                    let texture = read_texture(file, source)?.map(|texture| {
                        textures.push(texture);
                        textures.len() - 1
                    });
                    places.insert(file, texture);
                    texture
                }
            };
            let of = |texture| TextureUse { texture, uv_set: 0, uv_map: TextureUse::UV_UNCHANGED };
            result.base_color_texture = texture.map(of);
            // Leaves and fences; renderers differ in whether it cuts holes.
            if texture.is_some_and(|texture: usize| textures[texture].texels().iter().any(|texel| texel[3] < u8::MAX)) {
                source.note(format!("material `{name}`: the alpha of map_Kd is not used, surfaces are opaque"));
            }
        }
        if material.is_transparent {
            source.note(format!("material `{name}` is transparent, and taken as opaque"));
        }
        if material.emissive != [0.0; 3] {
            if !source.options.finish {
                source.note(emission_unused(name));
            }
            result.emissive = material.emissive.map(|c| c.max(0.0));
        }
        read.push(result);
    }
    Ok((read, textures))
}
