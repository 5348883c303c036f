//! Light of the surfaces of a scene that stands still: by what its file or another holds, or what is baked for it.

use anyhow::{anyhow, bail};
use lobe::env::{DfgTable, MappedMap, PrefilterOptions, cube_source, prefilter_ggx};
use lobe::io::Job;
use lobe::prt::{
    AnyTransfer, BakeMode, Baked, CompressedTransfer, GlossyLobe, Receivers, Recipe, Transfer, TransferMatrices,
    bake_matrices,
};
use lobe_gpu::{Environment, GlossyMesh, SplitSum, Storage, SurfaceShading};

use crate::cli::args::{Arguments, ModeName};
use crate::cli::told::progress;
use crate::loading::bake::{GlossyBake, SceneData, bake_glossy, bake_options, bake_scene};
use crate::loading::kept_transfer::KeptTransfer;
use crate::loading::mode::Mode;
use crate::loading::places::Places;

/// Bands without another choice, where nothing is baked yet.
pub(crate) const ORDER: usize = 4;

/// What lights surfaces.
pub(crate) enum Shown {
    /// Irradiance of normals, of this order.
    Irradiance(usize),
    /// Transfer of vertices or texels, and the meshes that shine instead.
    Transfer(Transfer, Places, Vec<GlossyBake>),
    /// Transfer in clusters.
    Clusters(CompressedTransfer),
    /// Transfer matrices of all vertices, by one lobe.
    Matrices(TransferMatrices, GlossyLobe),
    /// Microfacets of one roughness.
    Specular(SplitSum, f64),
}

impl Shown {
    /// What the arguments ask for: read or baked; `baked` is what the file of the scene holds.
    pub(crate) fn new(
        arguments: &Arguments,
        data: &SceneData,
        baked: Option<Box<Baked>>,
        sky: &MappedMap,
    ) -> anyhow::Result<Self> {
        let mode = match arguments.mode {
            ModeName::Unshadowed => Mode::Unshadowed,
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
            let kept = KeptTransfer::read(data, file, &arguments.limits).map_err(|line| anyhow!(line))?;
            let KeptTransfer::Vectors(transfer, recipe, places) = kept else {
                bail!("{}: transfer matrices; ask for --mode glossy", file.display());
            };
            return Self::kept(arguments, mode, &file.display().to_string(), (transfer, &recipe, places));
        }
        if let Some(file) = baked {
            let places = Places::vertices(&file.recipe);
            return Self::kept(arguments, mode, &data.name, (file.transfer.into(), &file.recipe, places));
        }
        Self::baked(arguments, mode, data)
    }

    /// Transfer that file `name` holds, if it is of this mode.
    fn kept(
        arguments: &Arguments,
        mode: Mode,
        name: &str,
        (transfer, recipe, places): (AnyTransfer, &Recipe, Places),
    ) -> anyhow::Result<Self> {
        let found = recipe.mode.unwrap_or(BakeMode::Interreflected);
        if mode == Mode::Unshadowed {
            return Ok(Self::Irradiance(arguments.order.map_or(transfer.order(), usize::from)));
        }
        if !mode.bakes().iter().all(|needed| *needed == found) {
            let (wanted, found) = (mode.title().to_lowercase(), found.name());
            bail!("--mode {wanted}: {name} was baked as {found}; ask for that, or for the scene it was baked from");
        }
        expect_order(arguments, name, transfer.order())?;
        Ok(match (transfer, places) {
            (AnyTransfer::Compressed(compressed), Places::Vertices) => Self::Clusters(compressed),
            (AnyTransfer::Compressed(compressed), places) => {
                Self::Transfer(compressed.to_transfer(), places, Vec::new())
            }
            (AnyTransfer::Zonal(lobes), places) => Self::Transfer(lobes.to_transfer(), places, Vec::new()),
            (AnyTransfer::Plain(transfer), places) => Self::Transfer(transfer, places, Vec::new()),
        })
    }

    fn baked(arguments: &Arguments, mode: Mode, data: &SceneData) -> anyhow::Result<Self> {
        let (order, samples) = (arguments.order.map_or(ORDER, usize::from), arguments.samples);
        let mut baked = Vec::new();
        for &mode in mode.bakes() {
            let options = bake_options(mode, order, samples);
            let (transfer, _) = bake_scene(data, &options, progress(format!("{} transfer", mode.name())))?;
            baked.push((mode, transfer));
        }
        let is_shining = mode == Mode::Interreflected;
        let glossy = if is_shining { bake_glossy(data, order, samples, progress("metals"))? } else { Vec::new() };
        let of = |mode: BakeMode| baked.iter().find(|(found, _)| *found == mode).map(|(_, transfer)| transfer);
        Ok(match mode.transfer(of)? {
            Some(transfer) => Self::Transfer(transfer, Places::Vertices, glossy),
            None => Self::Irradiance(order),
        })
    }

    fn glossy(arguments: &Arguments, data: &SceneData) -> anyhow::Result<Self> {
        let matrices = if let Some(file) = &arguments.transfer {
            let kept = KeptTransfer::read(data, file, &arguments.limits).map_err(|line| anyhow!(line))?;
            let KeptTransfer::Matrices(matrices) = kept else {
                bail!("{}: transfer of what diffuses light; ask for the mode of its bake, not glossy", file.display());
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
            let (receivers, job) = (Receivers::at_vertices(&data.scene)?, Job::default().watched_by(&mut watch));
            bake_matrices(&data.scene, &data.bvh, &receivers, &options, job)?.0
        };
        Ok(Self::Matrices(matrices, arguments.lobe))
    }

    fn specular(arguments: &Arguments, sky: &MappedMap) -> anyhow::Result<Self> {
        if let Some(file) = &arguments.transfer {
            bail!("--transfer {}: --mode specular has no transfer; leave the option out", file.display());
        }
        let options = PrefilterOptions::default();
        let mut watch = progress("prefiltering");
        let source = cube_source(sky, options.size, Job::default())?;
        let levels = prefilter_ggx(&source, &options, Job::default().watched_by(&mut watch))?;
        let environment = Environment::of_levels(&levels, options.roughness)?;
        Ok(Self::Specular(SplitSum { environment, dfg: DfgTable::default() }, arguments.roughness))
    }

    /// The bands of the light that is shown; microfacets reflect all of it.
    pub(crate) fn order(&self) -> usize {
        match self {
            Self::Irradiance(order) => *order,
            Self::Transfer(transfer, ..) => transfer.order(),
            Self::Clusters(compressed) => compressed.order(),
            Self::Matrices(matrices, _) => matrices.order(),
            Self::Specular(..) => ORDER,
        }
    }

    /// The meshes that shine among matte ones, for a device.
    pub(crate) fn meshes(&self) -> Vec<GlossyMesh<'_>> {
        match self {
            Self::Transfer(_, _, glossy) => glossy.iter().map(GlossyBake::on_device).collect(),
            _ => Vec::new(),
        }
    }

    /// How a device shows it.
    pub(crate) fn shading<'a>(&'a self, meshes: &'a [GlossyMesh<'a>], storage: Storage) -> SurfaceShading<'a> {
        match self {
            Self::Irradiance(order) => SurfaceShading::Irradiance(*order),
            Self::Transfer(transfer, places, _) => places.shading(transfer, meshes, storage),
            Self::Clusters(compressed) => SurfaceShading::Clusters(compressed),
            Self::Matrices(matrices, lobe) => SurfaceShading::Glossy(matrices, *lobe, storage),
            Self::Specular(split, roughness) => SurfaceShading::Specular(split, *roughness),
        }
    }
}

/// Refuses to show more bands than a file has.
fn expect_order(arguments: &Arguments, name: &str, found: usize) -> anyhow::Result<()> {
    match arguments.order.map(usize::from) {
        Some(order) if order > found => bail!("--order {order}: {name} was baked to order {found}; ask for that"),
        _ => Ok(()),
    }
}
