//! Baking occlusion fields and the visibility of an entity's own surface.

use derive_setters::Setters;
use lobe_io::{Fingerprint, Job, RecordFormat, Shard};
use lobe_prt::{BakeOptions, FittedVertices, fingerprint_arithmetic, fingerprint_scene};
use lobe_scene::{Bvh, Scene};
use lobe_sh::Dir;

use crate::error::ShadowError;
use crate::field::axial::Axial;
use crate::field::bake_rows::{RowWork, bake_rows};
use crate::field::field_grid::FieldGrid;
use crate::field::field_storage::of_prt;
use crate::field::fill_inside::fill_inside;
use crate::field::occlusion_field::OcclusionField;
use crate::field::sky_rays::{Cap, RayScratch, SkyRays, turn_of};

/// Fingerprints of fields and of visibility among those of Lobe.
const FIELD_KIND: u64 = 20;
const VISIBILITY_KIND: u64 = 21;

const FIELD_FORMAT: RecordFormat = RecordFormat {
    kind: *b"OCCF",
    version: 2,
    work: "bake of an occlusion field",
    arguments: "the scene or the options",
};
const VISIBILITY_FORMAT: RecordFormat = RecordFormat {
    kind: *b"VISB",
    version: 1,
    work: "bake of visibility",
    arguments: "the scene, the receivers or the options",
};

/// The bounding sphere is taken this much larger, so that no rounding leaves a part of the entity out of its cap; beyond some thousand radii,
/// where the places of samples are rounded by more, it may, and hides less than 1e-6 of the sky.
const MARGIN: f64 = 1.0 + 1e-4;

/// Options of [`bake_field`].
///
/// The defaults were chosen by the tables of the example `field_errors`, which README.md shows: at order 4 a ball is 1 %, the
/// rabbit 3 % and a torus 6 % off between R and 2 R, and no more than 2.3 % beyond. Inside twice as many spheres lower the
/// error most, far outside twice as many cells; to end at 4 R costs more than it gains.
#[derive(Clone, Debug, PartialEq, Setters, serde::Serialize, serde::Deserialize)]
#[serde(default)]
#[non_exhaustive]
pub struct FieldOptions {
    /// Number of bands, 1 to 8.
    pub order: usize,
    /// Number of spheres, 2 at least.
    pub spheres: usize,
    /// Cells along each side of the octahedral grid of a sphere; even.
    pub cells: usize,
    /// The innermost sphere, in radii of the entity. From there to the center values are linear in r.
    pub inner: f64,
    /// The outermost sphere, in radii of the entity.
    pub outer: f64,
    /// Rays from each sample point, 1 to 2²⁰. Outside the bounding sphere all of them go towards the entity.
    pub rays: u32,
    /// Bakes with different seeds have independent errors.
    pub seed: u64,
    /// Whether samples inside the solid take what is seen from outside. Only comparisons want false.
    pub fill_inside: bool,
}

impl FieldOptions {
    /// The highest order.
    pub const MAX_ORDER: usize = 8;

    /// The most spheres of a job; larger numbers are taken for typing errors.
    pub const MAX_SPHERES: usize = 256;

    /// The most cells of a job along a side; larger numbers are taken for typing errors.
    pub const MAX_CELLS: usize = 256;

    /// The most rays from a sample point.
    pub const MAX_RAYS: u32 = 1 << 20;
}

impl Default for FieldOptions {
    fn default() -> Self {
        Self { order: 4, spheres: 16, cells: 16, inner: 0.25, outer: 8.0, rays: 1024, seed: 0, fill_inside: true }
    }
}

/// The report of a bake.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
#[non_exhaustive]
pub struct FieldReport {
    /// Sample points, those that coincide counted each.
    pub points: usize,
    /// Those inside the solid.
    pub inside: usize,
    /// Rays that looked for occlusion, those of work done before a resumption included.
    pub rays: u64,
    /// The bytes of the field in `f32`.
    pub bytes: usize,
}

/// Bakes the occlusion field of a scene, which is the entity. Its frame is the world of the scene.
///
/// From each sample point of the [`FieldGrid`] around the middle of the scene's box, rays of even directions ask where it
/// hides the sky: over the whole sphere inside the bounding sphere, else in the cap that holds it. Alpha masks and glass
/// let them through as in a bake of transfer. The field does not depend on the number of threads, and is resumed from the
/// job's checkpoint.
///
/// A sample point is taken to lie inside the solid where 95 % of its rays end, and 95 % of those at the back of a surface.
/// There the field holds the mean of the nearest samples outside, scaled as all samples are.
///
/// ```
/// use lobe_io::Job;
/// use lobe_scene::built_in;
/// use lobe_sh::Expansion as _;
/// use lobe_shadow::{FieldOptions, RadialInterpolation, bake_field};
///
/// let options = FieldOptions::default().order(3).spheres(4).cells(4).rays(64);
/// let (field, report) = bake_field(&built_in::ball_over_ground(8), &options, Job::default())?;
/// assert_eq!(report.points, 4 * 5 * 5 + 1);
/// let far = field.visibility_at([0.0, 0.0, 1e4], RadialInterpolation::Linear);
/// assert!((far.mean() - 1.0).abs() < 1e-5, "nothing is hidden from far away");
/// # Ok::<(), lobe_shadow::ShadowError>(())
/// ```
///
/// # Errors
/// [`ShadowError::Options`] for options out of range, [`ShadowError::Cancelled`] if the job says so, and those of its
/// checkpoint.
pub fn bake_field(
    scene: &Scene,
    options: &FieldOptions,
    job: Job<'_>,
) -> Result<(OcclusionField, FieldReport), ShadowError> {
    let (grid, samples, found) = rows_of(scene, options, None, job)?;
    let width = options.order * options.order;
    let mut inside = vec![false; grid.points()];
    let mut rows = vec![0.0; grid.points() * width];
    for (point, found) in samples.iter().zip(found.chunks_exact(width + 1)) {
        inside[*point] = found[width] > 0.0;
        rows[point * width..][..width].copy_from_slice(&found[..width]);
    }
    if options.fill_inside {
        fill_inside(&grid, &inside, width, &mut rows);
    }
    for point in 0..grid.points() {
        let first = grid.representative(point) * width;
        rows.copy_within(first..first + width, point * width);
    }
    let field = OcclusionField::from_scaled(grid, options.order, &rows)?;
    let report = FieldReport {
        points: grid.points(),
        inside: (0..grid.points()).filter(|point| inside[grid.representative(*point)]).count(),
        rays: samples.len() as u64 * u64::from(options.rays),
        bytes: field.bytes(),
    };
    Ok((field, report))
}

/// A shard of [`bake_field`], whose results stay in the file of the job. Returns how many sample points it has, and how many there
/// are in all. [`lobe_io::merge_shards`] makes a checkpoint of the files of
/// all shards, from which [`bake_field`] takes up everything.
///
/// # Errors
/// Those of [`bake_field`]; [`ShadowError::Options`] if the job is not kept in a file.
pub fn bake_field_shard(
    scene: &Scene,
    options: &FieldOptions,
    shard: Shard,
    job: Job<'_>,
) -> Result<[usize; 2], ShadowError> {
    if job.checkpoint().is_none() {
        return Err(ShadowError::Options("expected a job that is kept in a file, in which the shard stays".to_owned()));
    }
    let width = options.order * options.order;
    let (_, samples, rows) = rows_of(scene, options, Some(shard), job)?;
    Ok([rows.len() / (width + 1), samples.len()])
}

/// The grid, the sample points of which rows are found, and the rows of a shard of them: occlusion, and 1 of points inside.
fn rows_of(
    scene: &Scene,
    options: &FieldOptions,
    shard: Option<Shard>,
    job: Job<'_>,
) -> Result<(FieldGrid, Vec<usize>, Vec<f32>), ShadowError> {
    check(options.order, options.rays)?;
    let (middle, radius) = bounding_sphere(scene);
    let origin = scene.origin();
    let center = std::array::from_fn(|k| middle[k] + origin[k]);
    let grid = FieldGrid::new(center, radius * MARGIN, [options.inner, options.outer], options.spheres, options.cells)?;
    let width = options.order * options.order;
    grid.check_bytes(Axial::width(options.order))?;
    let bvh = Bvh::new(scene);
    let rays = SkyRays::new(scene, &bvh, options.order, options.rays);
    // Of sample points that coincide the first is sampled; the others are given its row.
    let samples = grid.representatives();
    let work = RowWork {
        rows: samples.len(),
        width: width + 1,
        rays: u64::from(options.rays),
        format: FIELD_FORMAT,
        fingerprint: fingerprint(scene, options),
    };
    // The last number of a row says whether the point is inside.
    let found = bake_rows(&work, shard, job, &RayScratch::default, &|k, scratch: &mut RayScratch, row| {
        let (occlusion, inside) = row.split_at_mut(width);
        inside[0] = f32::from(u8::from(sample(&rays, &grid, middle, samples[k], options.seed, scratch, occlusion)));
    })?;
    Ok((grid, samples, found))
}

/// The middle of the smallest box around all vertices of a scene, and the distance of the farthest vertex from there.
fn bounding_sphere(scene: &Scene) -> ([f64; 3], f64) {
    let bounds = scene.bounds();
    let center: [f64; 3] = std::array::from_fn(|k| 0.5 * (f64::from(bounds.min[k]) + f64::from(bounds.max[k])));
    let square = |p: [f32; 3]| (0..3).map(|k| (f64::from(p[k]) - center[k]).powi(2)).sum::<f64>();
    let farthest = scene.corners().flatten().map(square).fold(0.0, f64::max);
    (center, farthest.sqrt())
}

/// One sample: its scaled occlusion, and whether it is inside the solid.
fn sample(
    rays: &SkyRays<'_>,
    grid: &FieldGrid,
    middle: [f64; 3],
    point: usize,
    seed: u64,
    scratch: &mut RayScratch,
    out: &mut [f32],
) -> bool {
    let offset = grid.offset(point);
    let r = offset.iter().map(|c| c * c).sum::<f64>().sqrt();
    let position: [f32; 3] = std::array::from_fn(|k| (middle[k] + offset[k]) as f32);
    let outside = r > grid.radius();
    let cap = match Dir::new(offset.map(|c| -c)) {
        Some(axis) if outside => Cap { axis, cosine: (1.0 - (grid.radius() / r).powi(2)).sqrt() },
        _ => Cap::SPHERE,
    };
    rays.occlusion_into(position, cap, turn_of(seed, point as u64), scratch, out);
    let scale = grid.scale_at(r);
    out.iter_mut().for_each(|o| *o = (f64::from(*o) * scale) as f32);
    !outside && rays.is_inside(position, scratch)
}

fn check(order: usize, rays: u32) -> Result<(), ShadowError> {
    let most = FieldOptions::MAX_ORDER;
    if !(1..=most).contains(&order) {
        return Err(ShadowError::Options(format!("expected an order of 1 to {most}, found {order}")));
    }
    if !(1..=FieldOptions::MAX_RAYS).contains(&rays) {
        return Err(ShadowError::Options(format!("expected 1 to 2^20 rays, found {rays}")));
    }
    Ok(())
}

fn fingerprint(scene: &Scene, options: &FieldOptions) -> Fingerprint {
    // Whether samples inside are filled is decided when all is done.
    let FieldOptions { order, spheres, cells, inner, outer, rays, seed, fill_inside: _ } = options;
    let mut all = Fingerprint::of_kind(FIELD_KIND);
    fingerprint_scene(&mut all, scene);
    all.words([*order as u64, *spheres as u64, *cells as u64, u64::from(*rays), *seed].into_iter());
    [inner, outer].into_iter().for_each(|x| all.word(x.to_bits()));
    fingerprint_arithmetic(&mut all);
    all
}

/// Options of [`bake_visibility`].
#[derive(Clone, Debug, PartialEq, Setters, serde::Serialize, serde::Deserialize)]
#[serde(default)]
#[non_exhaustive]
pub struct VisibilityOptions {
    /// Number of bands, 1 to 8.
    pub order: usize,
    /// Rays from each receiver, 1 to 2²⁰.
    pub rays: u32,
    /// Bakes with different seeds have independent errors.
    pub seed: u64,
}

impl Default for VisibilityOptions {
    fn default() -> Self {
        Self { order: 4, rays: 1024, seed: 0 }
    }
}

/// The visibility of the sky at all vertices, mesh by mesh: that of the surface of an entity itself, fitted to points
/// all over its triangles as transfer is by [`lobe_prt::bake_vertices`]. Returns the rays that were traced, too.
///
/// Vertices have the visibility of [`bake_visibility`] if that is linear between them. One that is buried in another
/// part of the entity has that of what is seen of its triangles. A corner where flat faces meet has the mean of what
/// these see, not what is seen from its tip.
///
/// # Errors
/// As [`bake_field`].
pub fn bake_vertex_visibility(
    scene: &Scene,
    options: &VisibilityOptions,
    job: Job<'_>,
) -> Result<(Vec<f32>, u64), ShadowError> {
    check(options.order, options.rays)?;
    let bake = BakeOptions::default().order(options.order).samples(options.rays).seed(options.seed);
    let fit = || FittedVertices::all(scene)?.bake_visibility(&Bvh::new(scene), &bake, job);
    let (rows, report) = fit().map_err(of_prt)?;
    Ok((rows, report.rays))
}

/// The visibility of the sky at points of a scene's surface, hidden by the scene itself: `order²` numbers for each.
///
/// ```text
///   V_i = ∫ V(s) y_i(s) ds
/// ```
///
/// It is not multiplied by a cosine. Below the surface nothing is visible, where the surface has a back; so light from there
/// plays no role once the visibility is multiplied. `positions` count from [`Scene::origin`]; rays start above the surface
/// by [`Bvh::origin_above`]. Resumed and deterministic as [`bake_field`].
///
/// # Errors
/// As [`bake_field`]; [`ShadowError::Invalid`] if positions and normals differ in number or are not finite.
pub fn bake_visibility(
    scene: &Scene,
    positions: &[[f32; 3]],
    normals: &[[f32; 3]],
    options: &VisibilityOptions,
    job: Job<'_>,
) -> Result<Vec<f32>, ShadowError> {
    check(options.order, options.rays)?;
    let invalid = |message: String| Err(ShadowError::Invalid { place: "receivers".to_owned(), message });
    if positions.len() != normals.len() {
        return invalid(format!(
            "expected a normal for each of {} positions, found {}",
            positions.len(),
            normals.len()
        ));
    }
    if let Some(at) = positions.iter().zip(normals).position(|(p, n)| !p.iter().chain(n).all(|c| c.is_finite())) {
        return invalid(format!("receiver {at} is not finite: {:?}, {:?}", positions[at], normals[at]));
    }
    let mut all = Fingerprint::of_kind(VISIBILITY_KIND);
    fingerprint_scene(&mut all, scene);
    [positions, normals].into_iter().for_each(|vectors| all.floats(vectors.as_flattened()));
    all.words([options.order as u64, u64::from(options.rays), options.seed].into_iter());
    fingerprint_arithmetic(&mut all);
    let bvh = Bvh::new(scene);
    let rays = SkyRays::new(scene, &bvh, options.order, options.rays);
    let work = RowWork {
        rows: positions.len(),
        width: options.order * options.order,
        rays: u64::from(options.rays),
        format: VISIBILITY_FORMAT,
        fingerprint: all,
    };
    bake_rows(&work, None, job, &RayScratch::default, &|receiver, scratch: &mut RayScratch, row| {
        let origin = bvh.origin_above(positions[receiver], normals[receiver]);
        rays.occlusion_into(origin, Cap::SPHERE, turn_of(options.seed, receiver as u64), scratch, row);
        row.iter_mut().for_each(|v| *v = -*v);
        row[0] += (4.0 * std::f32::consts::PI).sqrt();
    })
}
