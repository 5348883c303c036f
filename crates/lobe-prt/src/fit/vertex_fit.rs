//! Transfer at vertices by least squares.

use std::io;

use lobe_io::{Fingerprint, IoError, Job, Shard};
use lobe_scene::{Bvh, Scene};

use crate::bake::bake::{PreparedBake, check_of_vectors};
use crate::bake::pilot::KnownPilot;
use crate::fit::normal_equations::{NormalEquations, ReadRows};
use crate::fit::triangle_moments::TriangleMoments;
use crate::job::checkpoint::StoredRows;
use crate::job::fingerprint::{fingerprint_arithmetic, fingerprint_scene};
use crate::{AlbedoMode, BakeOptions, BakeReport, PrtError, Receivers, Transfer};

/// The weight of the regularization, for each square of the noise: what holds slopes is worth as much as what points
/// say is uncertain. With this and with a weight of .25 for all, default bakes are off by 3.7 and 4.0 % in a room of noise
/// .13, 2.7 and 3.1 % on a robot of .05, .4 and .7 % on a rabbit of .004.
const SMOOTHNESS: f64 = 25.0;

/// The least weight, which decides where nothing else does, and the largest, with which slopes count as values do.
const REGULARIZATION: [f64; 2] = [0.01, 1.0];

/// Bakes transfer at the vertices of a scene, so that transfer interpolated between them is as near as it can be to the
/// transfer of the surface.
///
/// ```text
///   minimize over the values v of the vertices
///   Σ over points k of  w_k ‖Σ_i v_i φ_i(p_k) - T(p_k)‖²  +  λ Σ over inner edges of  A (k·v)²
/// ```
///
/// Points lie in all triangles; w is the part of the area that each stands for, φ the hat functions that interpolate
/// between vertices, T the transfer of [`fn@crate::bake`] for a white receiver. The second sum holds changes of slope
/// across edges small: A is the area of the two triangles at an edge, and k·v the change. Its weight `λ = 25 σ²`, from
/// 0.01 to 1, follows the noise: σ is [`BakeReport::stderr_dc`].
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
    let receivers = Receivers::at_vertices(scene)?;
    let bake = prepare(scene, bvh, &receivers, options, &KnownPilot::new())?;
    if job.checkpoint().is_some() {
        let (rows, report) = bake.run_on_disk(|_| fingerprint(scene, options), job)?;
        return Ok((fitted(scene, &receivers, options, (&rows, report.stderr_dc))?, report));
    }
    let (rows, report) = bake.run(|_| fingerprint(scene, options), job)?;
    let row = rows.len() / scene.triangle_count().max(1);
    let read = |first: usize, out: &mut [f32]| {
        out.copy_from_slice(&rows[first * row..][..out.len()]);
        Ok(())
    };
    Ok((solved(scene, &receivers, options, (&read, report.stderr_dc))?, report))
}

/// The moments of all triangles, which stay in the file of the job.
pub(crate) fn moments_on_disk(
    scene: &Scene,
    bvh: &Bvh,
    receivers: &Receivers,
    options: &BakeOptions,
    job: Job<'_>,
    known: &KnownPilot,
) -> Result<(StoredRows, BakeReport), PrtError> {
    prepare(scene, bvh, receivers, options, known)?.run_on_disk(|_| fingerprint(scene, options), job)
}

/// A shard of them.
pub(crate) fn moments_shard(
    scene: &Scene,
    bvh: &Bvh,
    receivers: &Receivers,
    options: &BakeOptions,
    shard: Shard,
    job: Job<'_>,
    known: &KnownPilot,
) -> Result<BakeReport, PrtError> {
    prepare(scene, bvh, receivers, options, known)?.run_shard(|_| fingerprint(scene, options), shard, job)
}

/// The transfer of the vertices, from the moments of all triangles in a file and their noise.
pub(crate) fn fitted(
    scene: &Scene,
    receivers: &Receivers,
    options: &BakeOptions,
    (rows, noise): (&StoredRows, f64),
) -> Result<Transfer, PrtError> {
    let read = |first: usize, out: &mut [f32]| rows.read_into(first, out);
    solved(scene, receivers, options, (&read, noise)).map_err(|error| match error {
        PrtError::Io(IoError::Io { source, .. }) => IoError::io(rows.path(), source).into(),
        other => other,
    })
}

/// Numbers of the row of a triangle.
pub(crate) fn row_of_triangle(scene: &Scene, options: &BakeOptions) -> usize {
    crate::fit::triangle_moments::ELEMENT + 3 * vector(scene, options)
}

fn vector(scene: &Scene, options: &BakeOptions) -> usize {
    options.order * options.order * TriangleMoments::channels(scene, options).count()
}

fn prepare<'a>(
    scene: &'a Scene,
    bvh: &'a Bvh,
    receivers: &Receivers,
    options: &'a BakeOptions,
    known: &KnownPilot,
) -> Result<PreparedBake<TriangleMoments<'a>>, PrtError> {
    check_of_vectors(scene, bvh, options)?;
    let moments = TriangleMoments::new(scene, bvh, albedos(scene, receivers, options), options);
    Ok(PreparedBake::new(moments, options.energy_stop, known, TriangleMoments::limit_bounces))
}

/// The mean albedo of each triangle.
fn albedos(scene: &Scene, receivers: &Receivers, options: &BakeOptions) -> Vec<f64> {
    let mut first = 0;
    let mut albedos = Vec::with_capacity(scene.triangle_count());
    for mesh in scene.meshes() {
        let of_vertex = |v: u32| match options.albedo {
            AlbedoMode::Vertex => {
                receivers.albedos()[first + v as usize].iter().map(|&c| f64::from(c)).sum::<f64>() / 3.0
            }
            AlbedoMode::None => 1.0,
        };
        albedos.extend(mesh.triangles().iter().map(|t| t.iter().map(|&v| of_vertex(v)).sum::<f64>() / 3.0));
        first += mesh.positions().len();
    }
    albedos
}

/// The fingerprint of everything that decides the moments.
fn fingerprint(scene: &Scene, options: &BakeOptions) -> Fingerprint {
    /// The kind of this work among fingerprints.
    const KIND: u64 = 8;
    let mut fingerprint = Fingerprint::of_kind(KIND);
    fingerprint_scene(&mut fingerprint, scene);
    options.write_into(&mut fingerprint);
    fingerprint_arithmetic(&mut fingerprint);
    fingerprint
}

/// Solves for the transfer of the vertices, and multiplies it by their albedos.
fn solved(
    scene: &Scene,
    receivers: &Receivers,
    options: &BakeOptions,
    (read, noise): (ReadRows<'_>, f64),
) -> Result<Transfer, PrtError> {
    let refused = |source: io::Error| PrtError::from(IoError::Io { place: "the moments".to_owned(), source });
    let vector = vector(scene, options);
    let weight = (SMOOTHNESS * noise * noise).clamp(REGULARIZATION[0], REGULARIZATION[1]);
    let white = NormalEquations::new(scene, vector, weight, read).map_err(refused)?.solve(vector);
    let channels = options.channels_for(scene, receivers.is_gray());
    let bands = options.order * options.order;
    let mut rows = Vec::with_capacity(receivers.len() * bands * channels.count());
    for (albedo, white) in receivers.albedos().iter().zip(white.chunks_exact(vector)) {
        for c in 0..channels.count() {
            let factor = if options.albedo == AlbedoMode::None { 1.0 } else { albedo[c] };
            let own = if white.len() > bands { &white[c * bands..][..bands] } else { white };
            rows.extend(own.iter().map(|t| factor * t));
        }
    }
    Transfer::new(options.order, channels, rows)
}
