//! A bake as a piece of work: what is baked at which points, all at once or in shards, and the file of the results.

use std::borrow::Cow;
use std::path::Path;
use std::sync::{Arc, OnceLock};

use lobe_io::{Job, Shard};
use lobe_scene::{Bvh, Scene, UnwrapOptions};

use crate::bake::bake::{bake_on_disk_knowing, bake_shard_knowing};
use crate::bake::glossy::{Points as MatrixPoints, bake_points_on_disk, bake_points_shard};
use crate::bake::options::{BakeMode, BakeOptions, BakeReport};
use crate::bake::pilot::KnownPilot;
use crate::bake::transfer_grid::NeighborhoodGrid;
use crate::error::PrtError;
use crate::files::lightmap_file::write_lightmap;
use crate::files::lightmap_glb::LightmapGlb;
use crate::files::matrix_file::{write_matrices, write_neighborhood};
use crate::files::transfer_file::write_transfer;
use crate::finishing::finish::FinishOptions;
use crate::fit::adaptive::{AdaptiveOptions, AdaptiveReport, split_adaptively};
use crate::fit::fitted_vertices::FittedVertices;
use crate::fit::vertex_fit::{VertexFit, row_of_triangle, white_channels};
use crate::job::checkpoint::StoredRows;
use crate::receivers::receivers::Receivers;
use crate::receivers::texel_receivers::TexelReceivers;
use crate::recipe::Recipe;
use crate::transfer::transfer::{Channels, Transfer};
use crate::transfer::transfer_matrices::TransferMatrices;
use crate::transfer::transfer_rows::{StoredMatrices, StoredTransfer, TransferRows};

/// A bake of a scene whose points are known: at its vertices, at the texels of its lightmap, or in space.
///
/// ```
/// use lobe_io::{Job, Shard};
/// use lobe_prt::{BakeOptions, BakeWork};
/// use lobe_scene::built_in;
///
/// let work = BakeWork::at_vertices(built_in::ball_over_ground(4), BakeOptions::default().order(2).samples(16))?;
/// let folder = tempfile::tempdir()?;
/// let half = Shard::new(1, 2).unwrap();
/// let report = work.bake_shard(half, Job::default().kept_in(folder.path().join("half.safetensors")))?;
/// assert!(report.receivers <= work.points());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct BakeWork {
    scene: Arc<Scene>,
    /// Made when the first ray is traced, and kept for the shards that follow.
    bvh: OnceLock<Bvh>,
    /// The same for the pilot.
    pilot: KnownPilot,
    options: BakeOptions,
    points: Points,
    /// What is done with the texels of a lightmap.
    finish: FinishOptions,
    /// How the scene was unwrapped for them.
    unwrap: Option<UnwrapOptions>,
}

#[derive(Debug)]
enum Points {
    Vertices(Receivers),
    Texels(TexelReceivers),
    Grid(NeighborhoodGrid, Option<[f64; 6]>),
}

/// The results of a bake, in its checkpoint.
#[derive(Debug)]
pub enum BakedRows {
    /// Transfer vectors, each baked at its point.
    Transfer(StoredTransfer),
    /// Transfer vectors of vertices, fitted to the points around them.
    Fitted(Fitted<Transfer>),
    /// Transfer matrices of points in space.
    Matrices(StoredMatrices),
    /// Transfer matrices of vertices, fitted to the points around them: of glossy light.
    FittedMatrices(Fitted<TransferMatrices>),
}

/// Transfer of vertices that was fitted to moments in a checkpoint, which stays locked as long as this is there.
#[derive(Debug)]
pub struct Fitted<T> {
    transfer: T,
    #[cfg_attr(not(test), expect(dead_code, reason = "keeps the file locked"))]
    moments: StoredRows,
}

impl<T> Fitted<T> {
    /// The transfer.
    #[must_use]
    pub fn transfer(&self) -> &T {
        &self.transfer
    }
}

impl BakeWork {
    /// Transfer vectors at the vertices of a scene, of [`BakeMode::Glossy`] matrices, [fitted](crate::bake_vertices) to
    /// points all over its triangles.
    ///
    /// # Errors
    /// Those of [`Receivers::at_vertices`].
    pub fn at_vertices(scene: impl Into<Arc<Scene>>, options: BakeOptions) -> Result<Self, PrtError> {
        let scene = scene.into();
        let points = Points::Vertices(Receivers::at_vertices(&scene)?);
        Ok(Self::new(scene, points, options))
    }

    /// Transfer vectors at the texels of a lightmap of `width` × `width`.
    ///
    /// # Errors
    /// Those of [`TexelReceivers::new`].
    pub fn at_texels(scene: impl Into<Arc<Scene>>, width: usize, options: BakeOptions) -> Result<Self, PrtError> {
        let scene = scene.into();
        let points = Points::Texels(TexelReceivers::new(&scene, width)?);
        Ok(Self::new(scene, points, options))
    }

    /// Matrices of the light that arrives at `counts` points along the axes: between two corners, which are points, or else in the
    /// middle of as many equal parts of the scene's box, and so not at its sides, where floors and walls are.
    ///
    /// # Errors
    /// Those of [`NeighborhoodGrid::between`].
    pub fn in_grid(
        scene: impl Into<Arc<Scene>>,
        counts: [usize; 3],
        corners: Option<[f64; 6]>,
        options: BakeOptions,
    ) -> Result<Self, PrtError> {
        let scene = scene.into();
        let [min, max] = match corners {
            Some(numbers) => {
                let [a, b] = [0, 3].map(|first| [0, 1, 2].map(|k| numbers[first + k]));
                [[0, 1, 2].map(|k| a[k].min(b[k])), [0, 1, 2].map(|k| a[k].max(b[k]))]
            }
            None => {
                let [min, max] = scene.world_bounds();
                let half = |k: usize| (max[k] - min[k]) / (2 * counts[k]) as f64;
                [[0, 1, 2].map(|k| min[k] + half(k)), [0, 1, 2].map(|k| max[k] - half(k))]
            }
        };
        let points = Points::Grid(NeighborhoodGrid::between(min, max, counts)?, corners);
        Ok(Self::new(scene, points, options))
    }

    fn new(scene: Arc<Scene>, points: Points, options: BakeOptions) -> Self {
        let finish = FinishOptions { denoise: false, stitch: false };
        Self { scene, bvh: OnceLock::new(), pilot: KnownPilot::new(), options, points, finish, unwrap: None }
    }

    /// The same work, whose scene was [unwrapped](Scene::unwrapped) so, which the recipe says.
    #[must_use]
    pub fn unwrapped_by(self, unwrap: Option<UnwrapOptions>) -> Self {
        Self { unwrap, ..self }
    }

    /// The same work, whose texels are [finished](TexelReceivers::finished) so before they are written.
    #[must_use]
    pub fn finished_by(self, finish: FinishOptions) -> Self {
        Self { finish, ..self }
    }

    /// The scene.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The options.
    #[must_use]
    pub fn options(&self) -> &BakeOptions {
        &self.options
    }

    /// Points that are baked, each a step of the job: of vertices, which are fitted, triangles.
    #[must_use]
    pub fn points(&self) -> usize {
        match &self.points {
            Points::Vertices(_) => self.scene.triangle_count(),
            Points::Texels(texels) => texels.receivers().len(),
            Points::Grid(grid, _) => grid.counts().iter().product(),
        }
    }

    /// Vectors or matrices of each point.
    #[must_use]
    pub fn channels(&self) -> Channels {
        let is_gray = match &self.points {
            // Matrices have no albedo of their own.
            _ if self.has_matrices() => true,
            Points::Vertices(receivers) => receivers.is_gray(),
            Points::Texels(texels) => texels.receivers().is_gray(),
            Points::Grid(..) => true,
        };
        self.options.channels_for(&self.scene, is_gray)
    }

    /// Bytes of the results in a checkpoint, but for its header.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        let Points::Vertices(_) = &self.points else { return self.bytes_of(self.points()) };
        // Of a fit, the moments of triangles.
        let channels = white_channels(&self.scene, &self.options).count();
        let row = row_of_triangle(self.numbers_of_channel() * channels);
        (size_of::<f32>() as u64).saturating_mul((row * self.scene.triangle_count()) as u64)
    }

    /// Bytes of the numbers in the file of the results: of a lightmap all texels have some.
    #[must_use]
    pub fn file_bytes(&self) -> u64 {
        match &self.points {
            Points::Texels(texels) => self.bytes_of(texels.width() * texels.width()),
            Points::Vertices(receivers) => self.bytes_of(receivers.len()),
            Points::Grid(..) => self.bytes_of(self.points()),
        }
    }

    /// Splits the scene where its transfer at vertices is farthest off, see [`split_adaptively`].
    ///
    /// # Errors
    /// Those of [`split_adaptively`].
    pub fn split(&self, options: &AdaptiveOptions, job: Job<'_>) -> Result<(Scene, AdaptiveReport), PrtError> {
        split_adaptively(&self.scene, self.bvh(), options, job)
    }

    fn bytes_of(&self, points: usize) -> u64 {
        let numbers = self.numbers_of_channel() * self.channels().count();
        (points as u64).saturating_mul((size_of::<f32>() * numbers) as u64)
    }

    /// Numbers of the vector or matrix of a channel.
    fn numbers_of_channel(&self) -> usize {
        self.options.order.pow(if self.has_matrices() { 4 } else { 2 })
    }

    fn has_matrices(&self) -> bool {
        match &self.points {
            Points::Vertices(_) => self.options.mode == BakeMode::Glossy,
            Points::Texels(_) => false,
            Points::Grid(..) => true,
        }
    }

    pub(crate) fn bvh(&self) -> &Bvh {
        self.bvh.get_or_init(|| Bvh::new(&self.scene))
    }

    /// Bakes all points. The results stay in the checkpoint of the job; those of a fit are in memory, too.
    ///
    /// # Errors
    /// Those of [`bake_on_disk`](crate::bake_on_disk).
    pub fn bake(&self, job: Job<'_>) -> Result<(BakedRows, BakeReport), PrtError> {
        let (scene, bvh, options, pilot) = (&*self.scene, self.bvh(), &self.options, &self.pilot);
        match &self.points {
            Points::Vertices(receivers) => {
                let fitted = FittedVertices::of_receivers(scene, Cow::Borrowed(receivers));
                if self.has_matrices() {
                    let (numbers, moments, report) =
                        VertexFit::of_matrices(&fitted, bvh, options, pilot)?.run_on_disk(job)?;
                    let transfer = TransferMatrices::new(options.order, self.channels(), numbers)?;
                    return Ok((BakedRows::FittedMatrices(Fitted { transfer, moments }), report));
                }
                let (white, moments, report) = VertexFit::of_vectors(&fitted, bvh, options, pilot)?.run_on_disk(job)?;
                let transfer = fitted.colored(&white, options)?;
                Ok((BakedRows::Fitted(Fitted { transfer, moments }), report))
            }
            Points::Texels(texels) => {
                let (rows, report) = bake_on_disk_knowing(scene, bvh, texels.receivers(), options, job, pilot)?;
                Ok((BakedRows::Transfer(rows), report))
            }
            Points::Grid(grid, _) => {
                let points = MatrixPoints { positions: &grid.points(scene.origin()), receivers: None };
                let (rows, report) = bake_points_on_disk(scene, bvh, points, options, job, pilot)?;
                Ok((BakedRows::Matrices(rows), report))
            }
        }
    }

    /// Bakes the points of a shard, whose file is that of the job. [`lobe_io::merge_shards`] makes a checkpoint of the files of all
    /// shards, from which [`BakeWork::bake`] takes up everything.
    ///
    /// # Errors
    /// Those of [`bake_on_disk`](crate::bake_on_disk).
    pub fn bake_shard(&self, shard: Shard, job: Job<'_>) -> Result<BakeReport, PrtError> {
        let (scene, bvh, options, pilot) = (&*self.scene, self.bvh(), &self.options, &self.pilot);
        match &self.points {
            Points::Vertices(receivers) => {
                let fitted = FittedVertices::of_receivers(scene, Cow::Borrowed(receivers));
                match self.has_matrices() {
                    true => VertexFit::of_matrices(&fitted, bvh, options, pilot)?.run_shard(shard, job),
                    false => VertexFit::of_vectors(&fitted, bvh, options, pilot)?.run_shard(shard, job),
                }
            }
            Points::Texels(texels) => bake_shard_knowing(scene, bvh, texels.receivers(), options, shard, job, pilot),
            Points::Grid(grid, _) => {
                let points = MatrixPoints { positions: &grid.points(scene.origin()), receivers: None };
                bake_points_shard(scene, bvh, points, options, shard, job, pilot)
            }
        }
    }

    /// The record of this bake: the scene's hash, the options, the points and the report.
    #[must_use]
    pub fn recipe(&self, report: &BakeReport) -> Recipe {
        let recipe = Recipe::of_bake(&self.scene, &self.options, report);
        match &self.points {
            Points::Vertices(_) => recipe,
            Points::Texels(texels) => recipe.of_texels(texels.width(), &self.finish).unwrap(self.unwrap.clone()),
            Points::Grid(grid, corners) => recipe.grid(grid.counts()).grid_box(*corners),
        }
    }

    /// Writes results as a file of their own, .safetensors; of a lightmap as an .exr picture, or as a .glb with its
    /// scene, if the name ends so. The results of vertices may be [part of their scene](crate::BakedGlb) instead.
    ///
    /// # Errors
    /// [`PrtError::Options`] if the results are not of this kind of bake; [`PrtError::Io`] if the system refuses, and
    /// [`PrtError::Cancelled`] if the job was told to stop.
    pub fn write(
        &self,
        path: impl AsRef<Path>,
        baked: &BakedRows,
        recipe: &Recipe,
        job: Job<'_>,
    ) -> Result<(), PrtError> {
        let path = path.as_ref();
        match (&self.points, baked) {
            (Points::Vertices(_), BakedRows::Fitted(rows)) => write_transfer(path, &rows.transfer, recipe, job),
            (Points::Vertices(_), BakedRows::FittedMatrices(rows)) => write_matrices(path, &rows.transfer, recipe, job),
            (Points::Texels(texels), BakedRows::Transfer(rows)) => {
                let is = |name: &str| path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case(name));
                let finished = self.finished(texels, rows)?;
                let rows: &dyn TransferRows = finished.as_ref().map_or(rows, |finished| finished);
                let picture = texels.rows(rows)?;
                if is("exr") {
                    write_lightmap(path, &picture, recipe, job)
                } else if is("glb") {
                    LightmapGlb::of_scene(&self.scene, texels.width()).write(path, &picture, recipe, job)
                } else {
                    write_transfer(path, &picture, recipe, job)
                }
            }
            (Points::Grid(grid, _), BakedRows::Matrices(rows)) => write_neighborhood(path, grid, rows, recipe, job),
            _ => {
                let message = "expected the results of this bake: vectors of texels, matrices of a grid";
                Err(PrtError::Options(message.to_owned()))
            }
        }
    }
}

impl BakeWork {
    /// Writes results of texels as textures of a .glb that waits for them.
    ///
    /// # Errors
    /// As [`BakeWork::write`].
    pub fn write_into_glb(
        &self,
        path: impl AsRef<Path>,
        (glb, baked): (&LightmapGlb, &BakedRows),
        recipe: &Recipe,
        job: Job<'_>,
    ) -> Result<(), PrtError> {
        let (Points::Texels(texels), BakedRows::Transfer(rows)) = (&self.points, baked) else {
            return Err(PrtError::Options("expected the results of texels".to_owned()));
        };
        let finished = self.finished(texels, rows)?;
        let rows: &dyn TransferRows = finished.as_ref().map_or(rows, |finished| finished);
        glb.write(path, &texels.rows(rows)?, recipe, job)
    }

    /// The transfer of texels as it is written, if that is other than what was baked.
    fn finished(&self, texels: &TexelReceivers, rows: &StoredTransfer) -> Result<Option<Transfer>, PrtError> {
        if !self.finish.is_asked() {
            return Ok(None);
        }
        let (finished, _) = texels.finished(&self.scene, rows.load()?, &self.finish)?;
        Ok(Some(finished))
    }
}

impl BakedRows {
    /// The transfer vectors, unless there are matrices.
    #[must_use]
    pub fn as_transfer(&self) -> Option<&dyn TransferRows> {
        match self {
            Self::Transfer(rows) => Some(rows),
            Self::Fitted(rows) => Some(&rows.transfer),
            Self::Matrices(_) | Self::FittedMatrices(_) => None,
        }
    }

    /// The transfer vectors in memory, unless there are matrices.
    ///
    /// # Errors
    /// [`PrtError::Io`] if their file cannot be read.
    pub fn into_transfer(self) -> Result<Option<Transfer>, PrtError> {
        match self {
            Self::Transfer(rows) => rows.load().map(Some),
            Self::Fitted(rows) => Ok(Some(rows.transfer)),
            Self::Matrices(_) | Self::FittedMatrices(_) => Ok(None),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use lobe_io::merge_shards;
    use lobe_scene::built_in;

    use super::*;

    fn options() -> BakeOptions {
        BakeOptions::default().order(2).samples(16)
    }

    /// A work of each kind, with the ending of its file.
    fn works() -> [(BakeWork, &'static str); 5] {
        let ball = || built_in::ball_over_ground(6);
        let room = || built_in::named("cornell").unwrap();
        [
            (BakeWork::at_vertices(ball(), options()).unwrap(), "safetensors"),
            (BakeWork::at_vertices(ball(), options().mode(BakeMode::Glossy)).unwrap(), "safetensors"),
            (BakeWork::at_texels(room(), 16, options()).unwrap(), "safetensors"),
            (BakeWork::at_texels(room(), 16, options()).unwrap(), "exr"),
            (BakeWork::in_grid(ball(), [2, 3, 2], None, options()).unwrap(), "safetensors"),
        ]
    }

    fn bytes_written(work: &BakeWork, checkpoint: &Path, output: &Path) -> Vec<u8> {
        let (baked, report) = work.bake(Job::default().kept_in(checkpoint)).unwrap();
        work.write(output, &baked, &work.recipe(&report), Job::default()).unwrap();
        fs::read(output).unwrap()
    }

    #[test]
    fn every_kind_of_bake_has_the_same_bytes_from_shards_in_any_order() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for (kind, (work, ending)) in works().iter().enumerate() {
            let output = at(&format!("{kind}.{ending}"));
            let alone = bytes_written(work, &at(&format!("{kind}-alone")), &output);
            for count in [1, 2, 3, 7] {
                let mut points = 0;
                let mut parts: Vec<_> = (1..=count).map(|number| at(&format!("{kind}-{number}-{count}"))).collect();
                for (number, part) in (1..).zip(&parts) {
                    let shard = Shard::new(number, count).unwrap();
                    points += work.bake_shard(shard, Job::default().kept_in(part)).unwrap().receivers;
                }
                assert_eq!(points, work.points(), "kind {kind}: points of {count} shards");
                parts.reverse();
                let checkpoint = at(&format!("{kind}-of-{count}"));
                merge_shards(&parts, &checkpoint, Job::default()).unwrap();
                let merged = bytes_written(work, &checkpoint, &output);
                assert!(merged == alone, "kind {kind}: {count} shards give other bytes than one machine");
            }
        }
    }

    fn check_fitted(work: &BakeWork, transfer: &[f32], moments: &StoredRows) {
        let mode = work.options().mode;
        assert_eq!(work.file_bytes(), 4 * transfer.len() as u64, "{mode:?}: transfer of vertices");
        assert_eq!(work.bytes(), 4 * moments.load().unwrap().len() as u64, "{mode:?}: moments of triangles");
    }

    #[test]
    fn bytes_are_those_of_the_results() {
        for (kind, (work, _)) in works().iter().enumerate() {
            let folder = tempfile::tempdir().unwrap();
            let checkpoint = folder.path().join("checkpoint");
            let (baked, _) = work.bake(Job::default().kept_in(&checkpoint)).unwrap();
            let numbers = match baked {
                BakedRows::Transfer(rows) => rows.load().unwrap().coefficients().len(),
                BakedRows::Matrices(rows) => rows.load().unwrap().coefficients().len(),
                BakedRows::Fitted(Fitted { transfer, moments }) => {
                    check_fitted(work, transfer.coefficients(), &moments);
                    continue;
                }
                BakedRows::FittedMatrices(Fitted { transfer, moments }) => {
                    check_fitted(work, transfer.coefficients(), &moments);
                    continue;
                }
            };
            assert_eq!(work.bytes(), 4 * numbers as u64, "kind {kind}");
            assert!(work.file_bytes() >= work.bytes(), "kind {kind}: texels without a triangle have numbers, too");
        }
    }

    #[test]
    fn a_grid_without_corners_keeps_off_the_sides_and_corners_may_be_swapped() {
        let scene = Arc::new(built_in::ball_over_ground(4));
        let corners = |work: &BakeWork| match &work.points {
            Points::Grid(grid, _) => grid.corners(),
            other => panic!("expected a grid, found {other:?}"),
        };
        let inside = corners(&BakeWork::in_grid(Arc::clone(&scene), [2, 2, 4], None, options()).unwrap());
        let [min, max] = scene.world_bounds();
        for k in 0..3 {
            assert!(min[k] < inside[0][k] && inside[1][k] < max[k], "axis {k}: {inside:?} within {min:?} to {max:?}");
        }
        let swapped = BakeWork::in_grid(scene, [2, 2, 2], Some([1.0, -1.0, 2.0, -1.0, 1.0, 0.0]), options()).unwrap();
        assert_eq!(corners(&swapped), [[-1.0, -1.0, 0.0], [1.0, 1.0, 2.0]], "the corners of the box");
        let folder = tempfile::tempdir().unwrap();
        let job = Job::default().kept_in(folder.path().join("all"));
        let recipe = swapped.recipe(&swapped.bake_shard(Shard::WHOLE, job).unwrap());
        let box_of_recipe = Some([1.0, -1.0, 2.0, -1.0, 1.0, 0.0]);
        assert_eq!((recipe.grid, recipe.grid_box), (Some([2, 2, 2]), box_of_recipe), "what was asked for");
    }
}
