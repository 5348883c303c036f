//! Baked glTF files: reading scenes whose vertices carry transfer.

use std::path::Path;

use lobe_scene::{GltfReader, Scene, ScenePose, SceneReadOptions, SceneReadReport, is_gltf};
use serde_json::Value;

use crate::compression::compressed_transfer::CompressedTransfer;
use crate::error::PrtError;
use crate::files::baked_backs::{BakedBacks, read_backs, read_rows};
use crate::files::baked_compressed::read_compressed;
use crate::files::baked_extras::{check_version, expect_described, is_on_all, lobe_of, said};
use crate::files::baked_layout::{DIRECT, FRONT};
use crate::files::baked_shape::BakedShape;
use crate::files::lightmap_glb::{lightmap_in, read_lightmap_of_glb};
use crate::receivers::lightmap::Lightmap;
use crate::recipe::Recipe;
use crate::transfer::transfer::{Channels, Transfer};

/// A baked scene from a file.
#[derive(Clone, Debug)]
pub struct Baked {
    /// The scene.
    pub scene: Scene,
    /// The transfer of its vertices, mesh by mesh, or else of all texels of its lightmap.
    pub transfer: Transfer,
    /// The transfer of the backs of double-sided surfaces, if the file has that.
    pub backs: Option<BakedBacks>,
    /// The part of the transfer of the vertices without reflections, if the file has that.
    pub direct: Option<Transfer>,
    /// The lightmap, if the transfer is that of its texels.
    pub lightmap: Option<Lightmap>,
    /// The compressed form, of which `transfer` is made, if the file has that.
    pub compressed: Option<CompressedTransfer>,
    /// The options and versions that made the transfer.
    pub recipe: Recipe,
    /// The report of everything else in the file.
    pub report: SceneReadReport,
}

/// Reads a scene that [`BakedGlb`](crate::BakedGlb) or [`LightmapGlb`](crate::LightmapGlb) wrote.
///
/// # Errors
/// [`PrtError::Scene`] if the file is no scene; [`PrtError::Unsupported`] if it is of a newer version; [`PrtError::Invalid`] if
/// it carries no transfer, or not at every vertex, or of another type than it says.
pub fn read_baked(path: impl AsRef<Path>, options: &SceneReadOptions) -> Result<Baked, PrtError> {
    let path = path.as_ref();
    if !is_gltf(path) {
        return Err(PrtError::Unsupported {
            place: path.display().to_string(),
            message: "expected a baked .glb; bake the scene first".into(),
        });
    }
    Baked::of(&GltfReader::open(path, options)?)
}

/// [`read_baked`] from the bytes of a .glb or .gltf file that references no other; `name` stands in messages.
///
/// # Errors
/// As [`read_baked`], and [`PrtError::Scene`] if the bytes reference other files.
pub fn read_baked_bytes(bytes: &[u8], name: &str, options: &SceneReadOptions) -> Result<Baked, PrtError> {
    Baked::of(&GltfReader::open_bytes(bytes, name, options)?)
}

/// Whether a glTF file carries transfer.
#[must_use]
pub fn is_baked(gltf: &GltfReader) -> bool {
    !lobe_of(gltf).is_null()
}

/// The pose in which a glTF file was baked; none of a file that is not baked.
#[must_use]
pub fn baked_pose(gltf: &GltfReader) -> Option<ScenePose> {
    is_baked(gltf).then(|| Recipe::from(said(gltf, "recipe").clone()).pose())
}

/// The transfer of a baked glTF file, of whose scene it is.
#[derive(Clone, Debug)]
pub struct BakedTransfer {
    /// The transfer of the vertices, mesh by mesh.
    pub transfer: Transfer,
    /// The transfer of the backs of double-sided surfaces, if the file has that.
    pub backs: Option<BakedBacks>,
    /// The part of the transfer of the vertices without reflections, if the file has that.
    pub direct: Option<Transfer>,
    /// The compressed form, of which `transfer` is made, if the file has that.
    pub compressed: Option<CompressedTransfer>,
    /// The options and versions that made the transfer.
    pub recipe: Recipe,
}

impl BakedTransfer {
    /// Whether each mesh of a scene that was read from an open file carries transfer. Those without any area at rest, which
    /// animated scenes keep, do not.
    #[must_use]
    pub fn covers(gltf: &GltfReader, scene: &Scene) -> bool {
        is_baked(gltf) && is_on_all(gltf, scene)
    }

    /// The transfer at the vertices of a scene that was read from an open file.
    ///
    /// # Errors
    /// Those of [`read_baked`].
    pub fn of(gltf: &GltfReader, scene: &Scene) -> Result<Self, PrtError> {
        let (lobe, name) = (lobe_of(gltf), gltf.name());
        let ((order, channels), recipe) = about(gltf)?;
        if lobe["compression"].is_object() {
            let compressed = read_compressed(scene.meshes(), gltf, (order, channels), name)?;
            let transfer = compressed.to_transfer();
            return Ok(Self { transfer, backs: None, direct: None, compressed: Some(compressed), recipe });
        }
        let rows = |prefix: &str, channels: Channels| {
            let mut coefficients = Vec::new();
            for mesh in scene.meshes() {
                read_rows(mesh, gltf, prefix, (order, channels), name, &mut coefficients)?;
            }
            Transfer::new(order, channels, coefficients).map_err(|error| error.within(name))
        };
        let transfer = rows(FRONT, channels)?;
        let direct = match &lobe["direct"] {
            Value::Null => None,
            direct => Some(rows(DIRECT, check_channels(&direct["channels"], name)?)?),
        };
        let backs = read_backs(scene, gltf, (order, channels), name)?;
        Ok(Self { transfer, backs, direct, compressed: None, recipe })
    }
}

impl Baked {
    /// The scene of an open file with its transfer, in the pose in which it was baked.
    ///
    /// # Errors
    /// Those of [`read_baked`].
    pub fn of(gltf: &GltfReader) -> Result<Self, PrtError> {
        let (scene, mut report) = gltf.scene_in(&baked_pose(gltf).unwrap_or_default())?;
        report.assumed_animation = None;
        expect_described(gltf, &scene)?;
        let (format, recipe) = about(gltf)?;
        if let Some((transfer, width)) = read_lightmap_of_glb(gltf, format)? {
            let lightmap = Some(lightmap_in(&scene, width, gltf.name())?);
            return Ok(Self { scene, transfer, backs: None, direct: None, lightmap, compressed: None, recipe, report });
        }
        let BakedTransfer { transfer, backs, direct, compressed, recipe } = BakedTransfer::of(gltf, &scene)?;
        if let Ok(Some(what)) = BakedShape::of(&scene).differs(said(gltf, "shape"), &transfer) {
            report.notes.push(format!(
                "the scene does not stand as it was baked, {what}; its shadows and reflections are those of the bake: \
                 bake again"
            ));
        }
        Ok(Self { scene, transfer, backs, direct, lightmap: None, compressed, recipe, report })
    }
}

/// A scene from a glTF file, with its transfer if the file carries any.
#[derive(Clone, Debug)]
pub enum BakedOrScene {
    /// The file is baked.
    Baked(Box<Baked>),
    /// The file is not baked: the scene, and the report of everything else in the file.
    Scene(Scene, Box<SceneReadReport>),
}

impl From<Scene> for BakedOrScene {
    /// A scene of which there is nothing else to report.
    fn from(scene: Scene) -> Self {
        Self::Scene(scene, Box::default())
    }
}

/// Reads a .glb or .gltf file that may or may not be baked.
///
/// # Errors
/// As [`BakedOrScene::of`].
pub fn read_baked_or_scene(path: impl AsRef<Path>, options: &SceneReadOptions) -> Result<BakedOrScene, PrtError> {
    BakedOrScene::of(&GltfReader::open(path, options)?)
}

/// [`read_baked_or_scene`] from the bytes of a file that references no other; `name` stands in messages.
///
/// # Errors
/// As [`read_baked_or_scene`], and [`PrtError::Scene`] if the bytes reference other files.
pub fn read_baked_or_scene_bytes(
    bytes: &[u8],
    name: &str,
    options: &SceneReadOptions,
) -> Result<BakedOrScene, PrtError> {
    BakedOrScene::of(&GltfReader::open_bytes(bytes, name, options)?)
}

impl BakedOrScene {
    /// The scene of an open file, which may or may not be baked.
    ///
    /// # Errors
    /// Those of [`read_scene`](lobe_scene::read_scene) and, if the file carries transfer, those of [`read_baked`].
    pub fn of(gltf: &GltfReader) -> Result<Self, PrtError> {
        if is_baked(gltf) {
            return Ok(Self::Baked(Box::new(Baked::of(gltf)?)));
        }
        let (scene, report) = gltf.scene()?;
        expect_described(gltf, &scene)?;
        Ok(Self::Scene(scene, Box::new(report)))
    }
}

/// Order, channels and recipe of the transfer in an open file.
fn about(gltf: &GltfReader) -> Result<((usize, Channels), Recipe), PrtError> {
    let (lobe, name) = (lobe_of(gltf), gltf.name());
    let format = check_extras(lobe, name)?;
    let recipe = said(gltf, "recipe");
    if !(recipe.is_object() || recipe.is_null()) {
        return Err(PrtError::invalid(name, format!("expected a recipe in extras.lobe, found {recipe}")));
    }
    Ok((format, Recipe::from(recipe.clone()).understood(name)?))
}

/// Order and channels that `asset.extras.lobe` states.
fn check_extras(lobe: &Value, name: &str) -> Result<(usize, Channels), PrtError> {
    if lobe.is_null() {
        return Err(PrtError::invalid(name, "carries no transfer: bake it first, with `lobe bake`"));
    }
    check_version(lobe, name)?;
    let invalid = |what: &str, found: &Value| {
        Err(PrtError::invalid(name, format!("expected {what} in extras.lobe, found {found}")))
    };
    if lobe["quantity"] != "transfer" {
        return invalid("the quantity \"transfer\"", &lobe["quantity"]);
    }
    let order = match lobe["order"].as_u64() {
        Some(order @ 1..=8) => order as usize,
        _ => return invalid("an order of 1 to 8", &lobe["order"]),
    };
    Ok((order, check_channels(&lobe["channels"], name)?))
}

fn check_channels(found: &Value, name: &str) -> Result<Channels, PrtError> {
    match found.as_u64() {
        Some(1) => Ok(Channels::Gray),
        Some(3) => Ok(Channels::Rgb),
        _ => {
            let message = format!("expected 1 or 3 channels in extras.lobe, found {found}");
            Err(PrtError::invalid(name, message))
        }
    }
}
