//! Options and report of the scene readers.

use derive_setters::Setters;

use crate::scene::up::Up;

/// Options of reading a scene.
#[derive(Clone, Debug, PartialEq, Setters, serde::Serialize, serde::Deserialize)]
#[serde(default)]
#[non_exhaustive]
pub struct SceneReadOptions {
    /// The up axis of OBJ and PLY files. glTF is always y-up.
    pub up: Up,
    /// The most triangles, and the most vertices, to which a file may expand. A small file can hold a mesh with a
    /// thousand instances.
    pub max_triangles: usize,
    /// The most texels to which all textures together may expand, four bytes each. A small file can hold a large
    /// picture of one color.
    pub max_texels: usize,
    /// Whether a file may name others outside of its folder: by an absolute path, by one that climbs out of the folder,
    /// or by a link. Only of files that are trusted: what they name is read, and may be copied into what is written.
    pub allow_outside: bool,
    /// The normals of meshes that have none.
    pub missing_normals: MissingNormals,
    /// The material of glTF meshes that have none.
    pub default_material: DefaultMaterial,
    /// The most bytes that the scene may take with its tree for tracing rays, about 64 for each vertex and 320 for each
    /// triangle of all instances, and four for each texel; and what is read and decoded for it beside that: buffers,
    /// pictures and materials, and what they hold compressed. There is no such limit unless it is set: set one to
    /// read files that are not trusted, because a small one can ask for a lot.
    pub max_bytes: u64,
    /// Whether light goes straight through blended materials, by their alpha, and through glass, by its transmission.
    pub straight_through: bool,
    /// Whether normal textures of glTF are read, with the tangents of the meshes that have them, 48 bytes for each triangle. Without
    /// this, and of an [`AnimatedScene`](crate::AnimatedScene), a note says that they are not used.
    pub normal_maps: bool,
    /// Whether textures of glTF are read that [`Scene::finish`](crate::Scene::finish) looks up: of metallic, roughness,
    /// occlusion and emission. Without this they are left out; matte surfaces need none.
    pub finish: bool,
    /// Where things stand that a glTF file moves. [`AnimatedScene`](crate::AnimatedScene) has all of their poses.
    pub pose: ScenePose,
}

/// Where things stand that a glTF file moves, by animations, skins and morph targets.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[non_exhaustive]
pub enum ScenePose {
    /// The beginning of the first animation, where nobody asks for a time: the report says which that is. Where the
    /// file has a fault in what moves, things stand at rest, with a note.
    #[default]
    Start,
    /// Where they are at a time: nodes as an animation has moved them, skins carried by their joints, morph targets
    /// with their weights. In a file without animations nodes and weights are those at rest.
    At {
        /// The animation by its name or its number; the first without either.
        animation: Option<String>,
        /// Seconds from its beginning.
        time: f64,
    },
    /// As the nodes stand at rest, with skins as they were bound and without morph targets: what bakes saw that do not
    /// record a time.
    Unposed,
}

impl ScenePose {
    /// The pose at a time of an animation, either of which may be left open.
    #[must_use]
    pub fn asked(animation: Option<String>, time: Option<f64>) -> Self {
        match (animation, time) {
            (None, None) => Self::Start,
            (animation, time) => Self::At { animation, time: time.unwrap_or(0.0) },
        }
    }
}

/// The normals of meshes that have none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum MissingNormals {
    /// Flat triangles in glTF, which asks for them; smooth ones in PLY, which does not say. In OBJ what the smoothing groups
    /// of the file say (`s`): faces of one group are smooth, those of none (`s off`) flat, and all are smooth where it has no groups.
    #[default]
    AsFormat,
    /// The normals of the triangles. Vertices are added where triangles of different planes share one.
    Flat,
    /// The mean of the normals around each vertex, weighted by the angles there; in OBJ around each position of the file, whatever its
    /// groups, materials and texture coordinates.
    Smooth,
}

/// The material of glTF meshes that have none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum DefaultMaterial {
    /// [`Material::WHITE`](crate::Material::WHITE), white on both sides: a mesh without a material is one of which
    /// nothing is known but its shape.
    #[default]
    White,
    /// What glTF says: a white metal of roughness 1, seen from the front only. Metals reflect no diffuse light, so that
    /// transfer is black on it.
    #[serde(rename = "gltf")]
    AsFormat,
}

impl SceneReadOptions {
    /// The most triangles that rays can be traced among.
    pub const MOST_TRIANGLES: usize = (1 << 31) - 1;

    /// The most texels whose bytes can be counted.
    pub const MOST_TEXELS: usize = usize::MAX >> 3;
}

impl Default for SceneReadOptions {
    /// y up, up to 2²⁶ triangles and vertices, up to 2²⁸ texels (1 GiB), no limit for all together, files within the
    /// folder only, normals as the format asks, white where there is no material, no light straight through, normal
    /// textures, those of a finish not, and the beginning of the first animation.
    fn default() -> Self {
        Self {
            up: Up::Y,
            max_triangles: 1 << 26,
            max_texels: 1 << 28,
            allow_outside: false,
            missing_normals: MissingNormals::AsFormat,
            default_material: DefaultMaterial::White,
            max_bytes: u64::MAX,
            straight_through: false,
            normal_maps: true,
            finish: false,
            pose: ScenePose::default(),
        }
    }
}

/// The report of reading a scene.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize)]
#[non_exhaustive]
pub struct SceneReadReport {
    /// Number of meshes of the scene.
    pub meshes: usize,
    /// Number of vertices, as many as in the file for each instance of a mesh.
    pub vertices: usize,
    /// Number of triangles that were kept.
    pub triangles: usize,
    /// Triangles without area, dropped.
    pub dropped_triangles: usize,
    /// Triangles at the place of others, kept: see [`Scene::coincident_triangles`](crate::Scene::coincident_triangles).
    pub coincident_triangles: usize,
    /// Vertices whose normal was missing or zero and was computed.
    pub made_normals: usize,
    /// The animation at whose beginning the scene stands though nobody asked for it ([`ScenePose::Start`]): its name in
    /// backquotes, or its number.
    pub assumed_animation: Option<String>,
    /// Features of the file that Lobe ignores, a line each; of more than a hundred the first, and the number of the
    /// others.
    pub notes: Vec<String>,
}

impl SceneReadReport {
    /// What the scene stands as though nobody asked for it, in one line, if its file moves.
    #[must_use]
    pub fn assumed_pose(&self) -> Option<String> {
        let animation = self.assumed_animation.as_ref()?;
        Some(format!("moves; it is taken at 0 s of its animation {animation}"))
    }

    /// [`SceneReadReport::remarks`] for who can choose another pose, by options that have `@` before their names.
    #[must_use]
    pub fn remarks_with_options(&self) -> Vec<String> {
        let assumed = self.assumed_pose();
        let said = |text: String| match assumed.as_ref() == Some(&text) {
            true => format!("{text}; @time and @animation choose another"),
            false => text,
        };
        self.remarks().into_iter().map(said).collect()
    }

    /// What a user should know, each in one line: the notes, and what was dropped, doubled or made.
    #[must_use]
    pub fn remarks(&self) -> Vec<String> {
        let Self { triangles, vertices, dropped_triangles, coincident_triangles, made_normals, .. } = *self;
        let mut all = self.notes.clone();
        all.extend(self.assumed_pose());
        if dropped_triangles > 0 {
            all.push(format!("triangles without area: {dropped_triangles}, dropped; {triangles} are left"));
        }
        if coincident_triangles > 0 {
            let text = "leave duplicates out to save memory";
            all.push(format!("triangles at the place of others: {coincident_triangles} of {triangles}; {text}"));
        }
        if made_normals > 0 {
            all.push(format!("normals missing or zero: {made_normals} of {vertices}, made from the triangles"));
        }
        all
    }
}
