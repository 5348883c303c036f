//! Transfer at vertices by least squares.

use std::path::Path;

use lobe_io::{Fingerprint, IoError, Job, Shard};
use lobe_scene::{Bvh, Scene, SurfaceRays};

use crate::bake::bake::{PreparedBake, check_of_vectors, check_tree};
use crate::bake::diffuse::{Density, DiffusePaths};
use crate::bake::glossy::MatrixPaths;
use crate::bake::options::{AlbedoMode, BakeMode, BakeOptions, BakeReport};
use crate::bake::pilot::KnownPilot;
use crate::bake::point_transfer::PointTransfer;
use crate::error::PrtError;
use crate::fit::fitted_vertices::FittedVertices;
use crate::fit::normal_equations::{NormalEquations, ReadRows};
use crate::fit::surface_points::{SurfacePoints, gap};
use crate::fit::triangle_moments::{ELEMENT, TriangleMoments};
use crate::job::checkpoint::StoredRows;
use crate::job::chunks::Estimator;
use crate::job::fingerprint::fingerprint_arithmetic;
use crate::sampling::sobol::coherent_order;
use crate::transfer::transfer::{Channels, Transfer};
use crate::transfer::transfer_matrices::TransferMatrices;

/// The weight of the regularization, for each square of the noise: what holds slopes is worth as much as what points
/// say is uncertain. From 1024 paths a dim room of a house is off by 3.9 %, and by 5.6 % with one weight for all
/// triangles, from the noise of the whole house; a robot whose parts touch by 3.1 and 2.7 %.
const SMOOTHNESS: f64 = 25.0;

/// The least weight, which decides where nothing else does, and the largest, with which slopes count as values do.
const REGULARIZATION: [f64; 2] = [0.01, 1.0];

/// Bakes transfer at the vertices of a scene, so that transfer interpolated between them is as near as it can be to the
/// transfer of the surface.
///
/// ```text
///   minimize over the values v of the vertices
///   Σ over points k of  w_k ‖Σ_i v_i φ_i(p_k) - T(p_k)‖²  +  Σ over inner edges of  (λ_1 A_1 + λ_2 A_2) (k·v)²
///   λ = 25 σ²,  from 0.01 to 1      σ² = (1 - p) / (p N)
/// ```
///
/// Points lie in all triangles; w is the part of the area that each stands for, φ the hat functions that interpolate
/// between vertices, T the transfer of [`fn@crate::bake`] for a white receiver. The second sum holds changes of slope
/// across edges small: k·v is the change, A are the areas of the two triangles. Their weights λ follow the noise: a
/// part p of the N paths from a triangle escapes, weighted by throughput, and σ² is its variance over its square.
///
/// This is [Kavan, Bargteil and Sloan 2011]. The paths that a vertex would have are shared among the points around it,
/// so that the number of rays is the same and the noise is averaged over them.
///
/// - Vertices of one place and normal, in one mesh or in several, have one value: there is no seam. Where normals
///   differ, at a crease, each side has values of its own.
/// - Points inside of solids, or in gaps narrower than 1/1024 of the scene's diagonal, are seen by nobody. Their weight
///   is 1e-4: a vertex that is buried in another body takes its value from what can be seen of its triangles.
/// - Vertices without a triangle that has an area have zero transfer.
///
/// # Errors
/// Those of [`fn@crate::bake`].
pub fn bake_vertices(
    scene: &Scene,
    bvh: &Bvh,
    options: &BakeOptions,
    job: Job<'_>,
) -> Result<(Transfer, BakeReport), PrtError> {
    FittedVertices::all(scene)?.bake(bvh, options, job)
}

impl FittedVertices<'_> {
    /// Bakes the transfer vectors of these vertices, see [`bake_vertices`].
    ///
    /// # Errors
    /// Those of [`fn@crate::bake`].
    pub fn bake(&self, bvh: &Bvh, options: &BakeOptions, job: Job<'_>) -> Result<(Transfer, BakeReport), PrtError> {
        let (white, report) = VertexFit::of_vectors(self, bvh, options, &KnownPilot::new())?.run(job)?;
        Ok((self.colored(&white, options)?, report))
    }

    /// Bakes the transfer matrices of these vertices: those of [`bake_matrices`](crate::bake_matrices), fitted as
    /// vectors are by [`bake_vertices`]. Their albedo is not in them.
    ///
    /// Memory: `4 n⁴` bytes for each vertex and channel, and three times that for each triangle unless the job is
    /// [kept in a file](Job::kept_in).
    ///
    /// # Errors
    /// Those of [`fn@crate::bake`].
    pub fn bake_matrices(
        &self,
        bvh: &Bvh,
        options: &BakeOptions,
        job: Job<'_>,
    ) -> Result<(TransferMatrices, BakeReport), PrtError> {
        let (numbers, report) = VertexFit::of_matrices(self, bvh, options, &KnownPilot::new())?.run(job)?;
        let channels = options.channels_for(self.scene(), true);
        Ok((TransferMatrices::new(options.order, channels, numbers)?, report))
    }

    /// Bakes what these vertices see of the sky, fitted as transfer is: `∫ V(s) yᵢ(s) ds` over all directions above the
    /// surface, n² numbers for each. Glass lets the mean of its tint through. Of the options the order, the samples and
    /// the seed are used.
    ///
    /// # Errors
    /// Those of [`fn@crate::bake`].
    pub fn bake_visibility(
        &self,
        bvh: &Bvh,
        options: &BakeOptions,
        job: Job<'_>,
    ) -> Result<(Vec<f32>, BakeReport), PrtError> {
        let BakeOptions { order, samples, seed, .. } = *options;
        let options =
            BakeOptions { samples, ..BakeOptions::default().mode(BakeMode::Shadowed).order(order).seed(seed) };
        VertexFit::of_visibility(self, bvh, &options.albedo(AlbedoMode::None), &KnownPilot::new())?.run(job)
    }

    /// The transfer of the vertices, from that of white ones.
    pub(crate) fn colored(&self, white: &[f32], options: &BakeOptions) -> Result<Transfer, PrtError> {
        let channels = self.channels(options);
        let bands = options.order * options.order;
        let of_white = bands * white_channels(self.scene(), options).count();
        let mut rows = Vec::with_capacity(self.vertices().len() * bands * channels.count());
        for (&vertex, white) in self.vertices().iter().zip(white.chunks_exact(of_white)) {
            for (c, factor) in self.albedo(vertex, options).into_iter().enumerate().take(channels.count()) {
                let own = if white.len() > bands { &white[c * bands..][..bands] } else { white };
                rows.extend(own.iter().map(|t| factor * t));
            }
        }
        Transfer::new(options.order, channels, rows)
    }
}

/// The kinds of this work among fingerprints.
const VECTORS: u64 = 8;
const MATRICES: u64 = 10;
const VISIBILITY: u64 = 11;

/// A fit that is prepared: of vectors or of matrices.
pub(crate) struct VertexFit<'a, P> {
    fitted: &'a FittedVertices<'a>,
    options: &'a BakeOptions,
    bake: PreparedBake<TriangleMoments<'a, P>>,
    /// The kind of this work among fingerprints.
    kind: u64,
}

impl<'a> VertexFit<'a, DiffusePaths<'a>> {
    /// The fit of vectors of white vertices. The pilot may be known from a shard of the same bake.
    pub(crate) fn of_vectors(
        fitted: &'a FittedVertices<'a>,
        bvh: &'a Bvh,
        options: &'a BakeOptions,
        known: &KnownPilot,
    ) -> Result<Self, PrtError> {
        let channels = white_channels(fitted.scene(), options);
        Self::of_density(fitted, bvh, options, (Density::Cosine, channels), (VECTORS, known))
    }

    /// The fit of what is seen of the sky.
    fn of_visibility(
        fitted: &'a FittedVertices<'a>,
        bvh: &'a Bvh,
        options: &'a BakeOptions,
        known: &KnownPilot,
    ) -> Result<Self, PrtError> {
        Self::of_density(fitted, bvh, options, (Density::Hemisphere, Channels::Gray), (VISIBILITY, known))
    }

    fn of_density(
        fitted: &'a FittedVertices<'a>,
        bvh: &'a Bvh,
        options: &'a BakeOptions,
        (density, channels): (Density, Channels),
        kind: (u64, &KnownPilot),
    ) -> Result<Self, PrtError> {
        check_of_vectors(fitted.scene(), bvh, options)?;
        let points = SurfacePoints::new(fitted, options.first_samples());
        let order = options.path_order(points.paths);
        let paths = DiffusePaths::new(SurfaceRays::new(fitted.scene(), bvh), options, order, channels);
        let albedos = albedos(fitted, options);
        Ok(Self::new((fitted, points), (paths.with_density(density), albedos), options, kind))
    }
}

impl<'a> VertexFit<'a, MatrixPaths<'a>> {
    /// The fit of matrices.
    pub(crate) fn of_matrices(
        fitted: &'a FittedVertices<'a>,
        bvh: &'a Bvh,
        options: &'a BakeOptions,
        known: &KnownPilot,
    ) -> Result<Self, PrtError> {
        options.check()?;
        check_tree(fitted.scene(), bvh)?;
        let points = SurfacePoints::new(fitted, options.first_samples());
        let paths = MatrixPaths::new(SurfaceRays::new(fitted.scene(), bvh), options, coherent_order(points.paths));
        let white = vec![1.0; fitted.corners().len()];
        Ok(Self::new((fitted, points), (paths, white), options, (MATRICES, known)))
    }
}

impl<'a, P: PointTransfer> VertexFit<'a, P> {
    fn new(
        (fitted, points): (&'a FittedVertices<'a>, SurfacePoints<'a>),
        (paths, albedos): (P, Vec<f64>),
        options: &'a BakeOptions,
        (kind, known): (u64, &KnownPilot),
    ) -> Self {
        let moments = TriangleMoments { paths, points, albedos, gap: gap(fitted.scene()), seed: options.seed };
        Self { fitted, options, bake: PreparedBake::new(moments, options, known), kind }
    }

    /// The numbers of the vertices.
    fn run(self, job: Job<'_>) -> Result<(Vec<f32>, BakeReport), PrtError> {
        if job.checkpoint().is_some() {
            let (numbers, _, report) = self.run_on_disk(job)?;
            return Ok((numbers, report));
        }
        let Self { fitted, bake, .. } = self;
        let row = bake.estimator.row();
        let numbers = bake.estimator.paths.row();
        // Nothing is kept, so that nothing tells it from other work.
        let (rows, report) = bake.run(|_| Fingerprint::of_kind(0), job)?;
        let read = |first: usize, out: &mut [f32]| {
            out.copy_from_slice(&rows[first * row..][..out.len()]);
            Ok(())
        };
        Ok((solved((fitted, numbers), &read, "the moments".as_ref())?, report))
    }

    /// The numbers of the vertices, and the moments that they are fitted to, which stay in the file of the job.
    pub(crate) fn run_on_disk(self, job: Job<'_>) -> Result<(Vec<f32>, StoredRows, BakeReport), PrtError> {
        let fingerprint = self.fingerprint();
        let numbers = self.bake.estimator.paths.row();
        let (rows, report) = self.bake.run_on_disk(|_| fingerprint, job)?;
        let read = |first: usize, out: &mut [f32]| rows.read_into(first, out);
        Ok((solved((self.fitted, numbers), &read, rows.path())?, rows, report))
    }

    /// A shard of the moments.
    pub(crate) fn run_shard(self, shard: Shard, job: Job<'_>) -> Result<BakeReport, PrtError> {
        let fingerprint = self.fingerprint();
        self.bake.run_shard(|_| fingerprint, shard, job)
    }

    /// The fingerprint of everything that decides the moments.
    fn fingerprint(&self) -> Fingerprint {
        let mut fingerprint = Fingerprint::of_kind(self.kind);
        self.fitted.write_into(&mut fingerprint);
        self.options.write_into(&mut fingerprint);
        fingerprint_arithmetic(&mut fingerprint);
        fingerprint
    }
}

/// Numbers of the row of a triangle, of a fit of this many for each vertex.
pub(crate) fn row_of_triangle(numbers: usize) -> usize {
    ELEMENT + 3 * numbers
}

/// The channels of transfer without albedo.
pub(crate) fn white_channels(scene: &Scene, options: &BakeOptions) -> Channels {
    BakeOptions { albedo: AlbedoMode::None, channels: None, ..options.clone() }.channels_for(scene, true)
}

/// The mean albedo of each triangle.
fn albedos(fitted: &FittedVertices<'_>, options: &BakeOptions) -> Vec<f64> {
    let of_vertex =
        |vertex: u32| fitted.albedo(vertex as usize, options).iter().map(|&c| f64::from(c)).sum::<f64>() / 3.0;
    fitted.corners().iter().map(|t| t.iter().map(|&vertex| of_vertex(vertex)).sum::<f64>() / 3.0).collect()
}

/// Solves for the numbers of the vertices. The moments are read from a place.
fn solved(
    (fitted, numbers): (&FittedVertices<'_>, usize),
    read: ReadRows<'_>,
    place: &Path,
) -> Result<Vec<f32>, PrtError> {
    let weight = |variance: f64| (SMOOTHNESS * variance).clamp(REGULARIZATION[0], REGULARIZATION[1]);
    let solved = NormalEquations::new(fitted, numbers, &weight, read).and_then(|equations| equations.solve(read));
    solved.map_err(|source| IoError::io(place, source).into())
}
