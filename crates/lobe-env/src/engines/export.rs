//! A map's light as the files of engines.

use std::path::{Path, PathBuf};

use lobe_image::{PictureWriteOptions, PictureWriteReport, TexelFormat};
use lobe_io::{IoError, Job, StagedFile};
use lobe_sh::encoding::EngineForm;

use crate::engines::coefficients;
use crate::engines::engine::{Engine, EngineFacts};
use crate::engines::export_options::ExportOptions;
use crate::engines::exported_file::ExportedFile;
use crate::engines::light_parts::{LightParts, Part};
use crate::engines::read_me;
use crate::engines::snippet;
use crate::error::EnvError;
use crate::files::babylon_env::encode_babylon_env;
use crate::files::write::{CubeWriteOptions, encode_cube, encode_env};
use crate::map::cube_mip_chain::CubeMipChain;
use crate::map::mapped_map::MappedMap;
use crate::sky::sun_extraction::Sun;

/// The size of the faces of irradiance, which has no detail.
const DIFFUSE_SIZE: usize = 64;

/// The name of the text beside the files.
const READ_ME: &str = "README.md";

/// What was exported.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ExportReport {
    /// The suns that stand apart.
    pub suns: Vec<Sun>,
    /// The files, and what their formats clamp.
    pub files: Vec<(PathBuf, PictureWriteReport)>,
}

impl Engine {
    /// The names of the files that [`export_light`] writes for it.
    #[must_use]
    pub fn files(self) -> Vec<&'static str> {
        items(self).iter().map(Item::name).chain([READ_ME]).collect()
    }
}

/// A file that an engine gets.
enum Item {
    Panorama(&'static str, Part),
    Cube(&'static str, Part),
    Chain(&'static str),
    Diffuse(&'static str),
    BabylonEnv(&'static str),
    Coefficients(&'static str),
    /// A program and its template.
    Program(&'static str, &'static str),
}

impl Item {
    fn name(&self) -> &'static str {
        match self {
            Self::Panorama(name, _)
            | Self::Cube(name, _)
            | Self::Chain(name)
            | Self::Diffuse(name)
            | Self::BabylonEnv(name)
            | Self::Coefficients(name)
            | Self::Program(name, _) => name,
        }
    }
}

fn items(engine: Engine) -> &'static [Item] {
    use Item::{BabylonEnv, Chain, Coefficients, Cube, Diffuse, Panorama, Program};
    use Part::{Whole, WithoutSuns};
    match engine {
        Engine::Three => &[
            Chain("specular.ktx2"),
            Panorama("sky.hdr", Whole),
            Coefficients("light-probe.json"),
            Program("sky.mjs", include_str!("snippets/three.mjs")),
        ],
        Engine::Babylon => &[
            BabylonEnv("light.env"),
            Panorama("sky.hdr", Whole),
            Coefficients("coefficients.json"),
            Program("sky.mjs", include_str!("snippets/babylon.mjs")),
        ],
        Engine::PlayCanvas => &[
            Cube("light.dds", WithoutSuns),
            Cube("sky.dds", Whole),
            Coefficients("coefficients.json"),
            Program("sky.mjs", include_str!("snippets/playcanvas.mjs")),
        ],
        Engine::Filament => &[
            Chain("light.ktx"),
            Cube("sky.ktx", Whole),
            Coefficients("sh.txt"),
            Program("sky.mjs", include_str!("snippets/filament.mjs")),
        ],
        Engine::Bevy => &[
            Chain("specular.ktx2"),
            Diffuse("diffuse.ktx2"),
            Cube("sky.ktx2", Whole),
            Program("sky.rs", include_str!("snippets/bevy.rs.txt")),
        ],
        Engine::Blender => &[Panorama("sky.exr", Whole), Program("sky.py", include_str!("snippets/blender.py.txt"))],
        Engine::Godot => &[
            Panorama("light.hdr", WithoutSuns),
            Coefficients("coefficients.json"),
            Program("sky.gd", include_str!("snippets/godot.gd")),
        ],
        Engine::Unity => &[
            Panorama("light.hdr", WithoutSuns),
            Panorama("sky.hdr", Whole),
            Coefficients("coefficients.json"),
            Program("LobeSky.cs", include_str!("snippets/unity.cs")),
        ],
        Engine::Unreal => &[
            Panorama("light.hdr", WithoutSuns),
            Coefficients("coefficients.json"),
            Program("sky.py", include_str!("snippets/unreal.py.txt")),
        ],
        Engine::Mitsuba => &[Panorama("sky.exr", Whole), Program("sky.py", include_str!("snippets/mitsuba.py.txt"))],
        Engine::Usd => &[Panorama("sky.exr", Whole), Program("sky.usda", include_str!("snippets/usd.usda"))],
        Engine::Khronos => &[
            Chain("specular.ktx2"),
            Diffuse("diffuse.ktx2"),
            Panorama("sky.hdr", Whole),
            Program("lookup.glsl", include_str!("snippets/khronos.glsl")),
        ],
    }
}

/// The files of a map's light for one engine, which [`export_light`] writes; `name` stands for the map in them.
///
/// # Errors
/// Those of [`export_light`], but for writing.
pub fn exported_files(
    map: &MappedMap,
    engine: Engine,
    name: &str,
    options: &ExportOptions,
    job: Job<'_>,
) -> Result<Vec<ExportedFile>, EnvError> {
    options.check()?;
    let mut parts = LightParts::new(map, &options.suns, options.size, options.tolerance)?;
    let mut fewer = parts.limited(engine, map, options)?;
    files_of(engine, fewer.as_mut().unwrap_or(&mut parts), name, job)
}

/// Writes a map's light for engines, a folder for each in `folder`: the chain, cubes and pictures with the faces, the
/// frame and the roughness that the engine reads, its coefficients, a program that loads them, and a text that says
/// what is what. `name` stands for the map in them.
///
/// Files are renamed into place when all of them are on the disk: where one cannot be made, none is written.
///
/// # Errors
/// [`EnvError::Options`] for a size of faces that is no power of two or too small, and the errors of
/// [`prefilter_ggx`](crate::prefilter_ggx), [`SceneLight::of_map`](crate::SceneLight::of_map) and of writing.
///
/// ```
/// use lobe_env::{Engine, ExportOptions, bundled, export_light};
/// use lobe_io::Job;
///
/// # let folder = tempfile::tempdir()?;
/// # let folder = folder.path();
/// let options = ExportOptions::default().size(16);
/// export_light(folder, &bundled::studio().map(), &[Engine::Three, Engine::Blender], "studio", &options,
/// Job::default())?; assert!(folder.join("three/specular.ktx2").exists() && folder.join("blender/sky.exr").exists());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn export_light(
    folder: impl AsRef<Path>,
    map: &MappedMap,
    engines: &[Engine],
    name: &str,
    options: &ExportOptions,
    mut job: Job<'_>,
) -> Result<ExportReport, EnvError> {
    options.check()?;
    let mut parts = LightParts::new(map, &options.suns, options.size, options.tolerance)?;
    let mut report = ExportReport { suns: parts.suns(false).to_vec(), files: Vec::new() };
    let mut made = Vec::with_capacity(engines.len());
    for engine in engines {
        let mut fewer = parts.limited(*engine, map, options)?;
        made.push(files_of(*engine, fewer.as_mut().unwrap_or(&mut parts), name, job.reborrow())?);
    }
    // All of them are known before a folder is made.
    let mut staged = Vec::new();
    for (engine, files) in engines.iter().zip(made) {
        let folder = folder.as_ref().join(engine.name());
        std::fs::create_dir_all(&folder).map_err(|source| IoError::io(&folder, source))?;
        for file in files {
            let path = folder.join(&file.name);
            let write = StagedFile::write(&path, |out| out.write_all(&file.bytes));
            staged.push((write.map_err(|source| IoError::io(&path, source))?, path.clone()));
            report.files.push((path, file.report));
        }
    }
    for (file, path) in staged {
        file.publish().map_err(|source| IoError::io(&path, source))?;
    }
    Ok(report)
}

/// The files of an engine, the text last.
fn files_of(
    engine: Engine,
    parts: &mut LightParts<'_>,
    name: &str,
    mut job: Job<'_>,
) -> Result<Vec<ExportedFile>, EnvError> {
    let mut files = Vec::new();
    for item in items(engine) {
        files.push(file_of(engine, item, parts, job.reborrow())?);
    }
    let suns = parts.suns(engine.facts().traces_paths).len();
    let text = read_me::text(engine, name, &files, suns);
    files.push(ExportedFile::text(READ_ME, "this text", text));
    Ok(files)
}

fn file_of(
    engine: Engine,
    item: &Item,
    parts: &mut LightParts<'_>,
    mut job: Job<'_>,
) -> Result<ExportedFile, EnvError> {
    let EngineFacts { panorama_turn, faces, chain, form, traces_paths, .. } = engine.facts();
    let options = CubeWriteOptions::default().handedness(faces);
    let texels = |name: &str| if name.ends_with(".ktx") { TexelFormat::R11G11B10F } else { TexelFormat::Rgba16F };
    let made = ExportedFile::new;
    Ok(match item {
        Item::Panorama(name, part) => {
            let map = parts.panorama(*part, panorama_turn, job.step("convert"))?;
            made(
                name,
                &pictured("lat-long picture", *part, parts),
                encode_env(Path::new(name), &map, &PictureWriteOptions::default())?,
            )
        }
        Item::Cube(name, part) => {
            let cube = CubeMipChain::single(parts.cube(*part, job.step("convert"))?);
            let options = options.texels(texels(name));
            made(name, &pictured("cube", *part, parts), encode_cube(Path::new(name), &cube, &options)?)
        }
        Item::Chain(name) => {
            let light = *parts.light();
            let chain = parts.chain(chain.unwrap_or_default(), job)?;
            let what = format!("prefiltered cube, {} levels from {} texels", chain.levels().len(), chain.base().size());
            let options = options.texels(texels(name)).light(Some(light));
            made(name, &what, encode_cube(Path::new(name), chain, &options)?)
        }
        Item::Diffuse(name) => {
            let cube = CubeMipChain::single(parts.diffuse(DIFFUSE_SIZE)?);
            made(name, "cube of irradiance over π", encode_cube(Path::new(name), &cube, &options.texels(texels(name)))?)
        }
        Item::BabylonEnv(name) => {
            let light = *parts.light();
            let what = "prefiltered cube as small pictures, and irradiance as a polynomial";
            made(name, what, encode_babylon_env(parts.chain(chain.unwrap_or_default(), job)?, &light)?)
        }
        Item::Coefficients(name) => {
            let form = form.unwrap_or(EngineForm::Filament);
            let what = format!("nine colors of spherical harmonics, of {}", form.quantity());
            ExportedFile::text(name, &what, coefficients::file(form, parts.light()))
        }
        Item::Program(name, template) => {
            let text = snippet::filled(engine, template, parts.light(), parts.suns(traces_paths));
            ExportedFile::text(name, "loads all this", text)
        }
    })
}

fn pictured(what: &str, part: Part, parts: &LightParts<'_>) -> String {
    match part {
        Part::WithoutSuns if !parts.suns(false).is_empty() => format!("{what} of all but the suns"),
        Part::WithoutSuns => format!("{what} of what lights the scene"),
        Part::Whole => format!("{what} of the whole sky"),
    }
}
