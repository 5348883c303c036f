//! Light of the surfaces of a scene that stands still: by what its file or another holds, or what is baked for it.

use std::path::Path;

use anyhow::{anyhow, bail};
use lobe::env::{LobeTable, MappedMap, PrefilterOptions, cube_source, prefilter_ggx};
use lobe::io::Job;
use lobe::prt::{
    AnyTransfer, BakeMode, Baked, CompressedTransfer, FittedVertices, GlossyLobe, Recipe, Transfer, TransferMatrices,
};
use lobe_gpu::{Environment, GlossyMesh, SplitSum, Storage, SunsApart, SurfaceShading};

use crate::cli::args::{Arguments, ModeName};
use crate::cli::progress::progress;
use crate::loading::bake::{GlossyBake, SceneData, bake_glossy, bake_options, bake_scene};
use crate::loading::kept_transfer::{KeptTransfer, to_vectors};
use crate::loading::materials::{gltf_shading, reflections_of};
use crate::loading::mode::Mode;
use crate::loading::places::Places;
use crate::loading::sky_source::OpenedSky;
use crate::loading::suns::{bake_direct, suns_apart};
use lobe::render::Surfaces;

/// Bands without another choice, where nothing is baked yet.
pub(crate) const ORDER: usize = 4;

/// The lobe of `--mode glossy` without another choice, as of `lobe render`.
const LOBE: GlossyLobe = GlossyLobe::Ggx(0.3);

/// The roughness of `--mode specular` without another choice.
const ROUGHNESS: f64 = 0.5;

/// What lights surfaces.
pub(crate) enum Shown {
    /// Irradiance of normals, of this order.
    Irradiance(usize),
    /// Transfer of vertices or texels in a mode, its part without reflections where suns or materials need it, and the
    /// meshes that shine instead, or what all surfaces reflect.
    Transfer {
        mode: Mode,
        transfer: Transfer,
        direct: Option<Transfer>,
        places: Places,
        glossy: Vec<GlossyBake>,
        reflections: Option<SplitSum>,
    },
    /// Transfer in clusters.
    Clusters(Mode, CompressedTransfer),
    /// Transfer matrices of all vertices, by one lobe.
    Matrices(TransferMatrices, GlossyLobe),
    /// Microfacets of one roughness.
    Specular(SplitSum, f64),
}

impl Shown {
    /// What the arguments ask for: read or baked; `baked` is what the file of the scene holds. With suns beside the
    /// expansion, or materials, also what these need is baked.
    pub(crate) fn new(
        arguments: &Arguments,
        data: &SceneData,
        baked: Option<Box<Baked>>,
        sky: &OpenedSky,
        has_suns: bool,
    ) -> anyhow::Result<Self> {
        arguments.check_surfaces()?;
        if arguments.surfaces() == Surfaces::Matte {
            return Self::lit(arguments, data, baked, &sky.map, has_suns);
        }
        let shown = Self::lit(arguments, data, baked, &sky.map, true)?;
        let Self::Transfer {
            mode, transfer, direct, places: places @ (Places::Vertices | Places::WithoutAlbedo), ..
        } = shown
        else {
            bail!("--surfaces gltf: expected transfer of vertices, found a lightmap; lobe render baked shows it");
        };
        let reflections =
            Some(reflections_of(sky, has_suns, Job::default().watched_by(&mut progress("prefiltering")))?);
        Ok(Self::Transfer { mode, transfer, direct, places, glossy: Vec::new(), reflections })
    }

    fn lit(
        arguments: &Arguments,
        data: &SceneData,
        baked: Option<Box<Baked>>,
        sky: &MappedMap,
        needs_direct: bool,
    ) -> anyhow::Result<Self> {
        let mode = match arguments.mode {
            ModeName::Irradiance => Mode::Irradiance,
            ModeName::Shadowed => Mode::Shadowed,
            ModeName::Interreflected => Mode::Interreflected,
            ModeName::Difference => Mode::Difference,
            ModeName::Glossy => return Self::glossy(arguments, data),
            ModeName::Specular => return Self::specular(arguments, sky),
            ModeName::Fields | ModeName::Exponentials => {
                bail!("--mode fields and exponentials: of scenes that move, with --headless; leave the option out")
            }
        };
        if let Some(file) = &arguments.transfer {
            let name = file.display();
            let KeptTransfer::Vectors(transfer, recipe, places) = read_kept(arguments, data, file)? else {
                bail!("--transfer {name}: transfer matrices; ask for --mode glossy");
            };
            let found = mode_of(&recipe);
            if mode.bakes() != [found] {
                bail!("--transfer {name}: baked as {0}; ask for --mode {0}", found.name());
            }
            let of = Kept { name: &name.to_string(), mode, recipe: &recipe, needs_direct };
            return of.shown(arguments, data, (transfer, places));
        }
        if let Some(file) = baked {
            if mode == Mode::Irradiance {
                return Ok(Self::Irradiance(arguments.order.map_or(file.transfer.order(), usize::from)));
            }
            let found = mode_of(&file.recipe);
            if !mode.bakes().iter().all(|needed| *needed == found) {
                let (wanted, found, name) = (mode.title().to_lowercase(), found.name(), &data.name);
                bail!("--mode {wanted}: {name} was baked as {found}; ask for that, or for the scene it was baked from");
            }
            let places = Places::vertices(&file.recipe);
            let of = Kept { name: &data.name, mode, recipe: &file.recipe, needs_direct };
            return of.shown(arguments, data, (file.transfer.into(), places));
        }
        Self::baked(arguments, mode, data, needs_direct)
    }

    fn baked(arguments: &Arguments, mode: Mode, data: &SceneData, needs_direct: bool) -> anyhow::Result<Self> {
        let (order, samples) = (arguments.order.map_or(ORDER, usize::from), arguments.samples);
        let needs_direct = needs_direct && mode == Mode::Interreflected;
        let mut baked = Vec::new();
        for &mode in mode.bakes().iter().chain(needs_direct.then_some(&BakeMode::Shadowed)) {
            let options = bake_options(mode, order, samples);
            let (transfer, _) = bake_scene(data, &options, progress(format!("{} transfer", mode.name())))?;
            baked.push((mode, transfer));
        }
        let is_shining = mode == Mode::Interreflected && arguments.surfaces() == Surfaces::Matte;
        let glossy = if is_shining { bake_glossy(data, order, samples, progress("metals"))? } else { Vec::new() };
        let of = |mode: BakeMode| baked.iter().find(|(found, _)| *found == mode).map(|(_, transfer)| transfer);
        Ok(match mode.transfer(of)? {
            Some(transfer) => {
                let direct = of(BakeMode::Shadowed).filter(|_| needs_direct).cloned();
                Self::Transfer { mode, transfer, direct, places: Places::Vertices, glossy, reflections: None }
            }
            None => Self::Irradiance(order),
        })
    }

    fn glossy(arguments: &Arguments, data: &SceneData) -> anyhow::Result<Self> {
        let matrices = if let Some(file) = &arguments.transfer {
            let KeptTransfer::Matrices(matrices) = read_kept(arguments, data, file)? else {
                bail!("--transfer {}: of what diffuses light; ask for the --mode of its bake", file.display());
            };
            expect_order(arguments, &file.display().to_string(), matrices.order())?;
            matrices
        } else {
            let order = arguments.order.map_or(ORDER, usize::from);
            // Three channels of single precision.
            let bytes = size_of::<f32>() * 3 * order.pow(4) * data.scene.vertex_count();
            arguments.limits.check_memory("transfer matrices", bytes as u64).map_err(|line| anyhow!(line))?;
            let options = bake_options(BakeMode::Interreflected, order, arguments.samples);
            let mut watch = progress("transfer matrices");
            let job = Job::default().watched_by(&mut watch);
            FittedVertices::all(&data.scene)?.bake_matrices(&data.bvh, &options, job)?.0
        };
        Ok(Self::Matrices(matrices, arguments.lobe.unwrap_or(LOBE)))
    }

    fn specular(arguments: &Arguments, sky: &MappedMap) -> anyhow::Result<Self> {
        let options = PrefilterOptions::default();
        let mut watch = progress("prefiltering");
        let source = cube_source(sky, options.size, Job::default())?;
        let levels = prefilter_ggx(&source, &options, Job::default().watched_by(&mut watch))?;
        let environment = Environment::of_levels(&levels, options.roughness)?;
        let split = SplitSum { environment, lobes: LobeTable::correlated() };
        Ok(Self::Specular(split, arguments.roughness.unwrap_or(ROUGHNESS)))
    }

    /// The bands of the light that is shown; microfacets reflect all of it.
    pub(crate) fn order(&self) -> usize {
        match self {
            Self::Irradiance(order) => *order,
            Self::Transfer { transfer, .. } => transfer.order(),
            Self::Clusters(_, compressed) => compressed.order(),
            Self::Matrices(matrices, _) => matrices.order(),
            Self::Specular(..) => ORDER,
        }
    }

    /// The meshes that shine among matte ones, for a device.
    pub(crate) fn meshes(&self) -> Vec<GlossyMesh<'_>> {
        match self {
            Self::Transfer { glossy, .. } => glossy.iter().map(GlossyBake::on_device).collect(),
            _ => Vec::new(),
        }
    }

    /// How a device shows so many suns with it.
    pub(crate) fn suns(&self, count: usize) -> SunsApart<'_> {
        match self {
            Self::Irradiance(_) => suns_apart(Mode::Irradiance, true, None, count),
            Self::Transfer { mode, direct, .. } => suns_apart(*mode, true, direct.as_ref(), count),
            Self::Clusters(mode, _) => suns_apart(*mode, true, None, count),
            Self::Matrices(..) | Self::Specular(..) => SunsApart::No,
        }
    }

    /// How a device shows it.
    pub(crate) fn shading<'a>(&'a self, meshes: &'a [GlossyMesh<'a>], storage: Storage) -> SurfaceShading<'a> {
        match self {
            Self::Irradiance(order) => SurfaceShading::Irradiance(*order),
            Self::Transfer { mode, transfer, direct, places, reflections, .. } => {
                let of = (transfer, direct_of(*mode, transfer, direct.as_ref()));
                let gltf = reflections.as_ref().and_then(|all| gltf_shading(of, places, all, storage));
                gltf.unwrap_or_else(|| places.shading(transfer, meshes, storage))
            }
            Self::Clusters(_, compressed) => SurfaceShading::Clusters(compressed),
            Self::Matrices(matrices, lobe) => SurfaceShading::Glossy(matrices, *lobe, storage),
            Self::Specular(split, roughness) => SurfaceShading::Specular(split, *roughness),
        }
    }
}

/// The part without reflections of transfer in a mode.
fn direct_of<'a>(mode: Mode, transfer: &'a Transfer, direct: Option<&'a Transfer>) -> Option<&'a Transfer> {
    if mode == Mode::Shadowed { Some(transfer) } else { direct }
}

/// Transfer that a file holds.
struct Kept<'a> {
    name: &'a str,
    mode: Mode,
    recipe: &'a Recipe,
    /// Whether the part without reflections is needed where there are any.
    needs_direct: bool,
}

impl Kept<'_> {
    /// Clusters stay clusters where a device can show them, which it cannot beside transfer without reflections.
    fn shown(
        &self,
        arguments: &Arguments,
        data: &SceneData,
        (transfer, places): (AnyTransfer, Places),
    ) -> anyhow::Result<Shown> {
        let Self { name, mode, recipe, needs_direct } = *self;
        expect_order(arguments, name, transfer.order())?;
        let needs_direct = needs_direct && mode == Mode::Interreflected;
        let is_gltf = arguments.surfaces() == Surfaces::MetallicRoughness;
        match (transfer, places) {
            (AnyTransfer::Compressed(compressed), Places::Vertices) if !needs_direct && !is_gltf => {
                Ok(Shown::Clusters(mode, compressed))
            }
            (transfer, places) => {
                let transfer = to_vectors(transfer, name, &arguments.limits).map_err(|line| anyhow!(line))?;
                let mut watch = progress("direct transfer");
                let job = Job::default().watched_by(&mut watch);
                let direct = || bake_direct(data, (recipe, transfer.order()), &places, job);
                let direct = needs_direct.then(direct).transpose()?;
                Ok(Shown::Transfer { mode, transfer, direct, places, glossy: Vec::new(), reflections: None })
            }
        }
    }
}

fn read_kept(arguments: &Arguments, data: &SceneData, file: &Path) -> anyhow::Result<KeptTransfer> {
    KeptTransfer::read(data, file, &arguments.limits).map_err(|line| anyhow!(line))
}

/// The light paths of a bake.
fn mode_of(recipe: &Recipe) -> BakeMode {
    recipe.mode.unwrap_or(BakeMode::Interreflected)
}

/// Refuses to show more bands than a file has.
fn expect_order(arguments: &Arguments, name: &str, found: usize) -> anyhow::Result<()> {
    match arguments.order.map(usize::from) {
        Some(order) if order > found => {
            bail!("--order {order}: {name} was baked to order {found}; ask for that or less")
        }
        _ => Ok(()),
    }
}
