//! Errors of transfer that is interpolated between vertices, baked at them and fitted.
//!
//! `cargo run --release -p lobe-prt --example fit_errors -- built-in:cornell room.glb@20000` measures these scenes, the
//! second one split to as many vertices.
//!
//! ```text
//!   error² = Σ ⟨T - T', T - T''⟩ / Σ ⟨T', T''⟩    over points that are seen
//! ```
//!
//! T is interpolated, T' and T'' are two bakes at the points themselves, whose noise so adds nothing on average. A
//! coefficient of band l counts by 1/(l + 1)²; one of a matrix by both of its bands.

use std::collections::BTreeMap;
use std::error::Error;

use lobe_io::Job;
use lobe_prt::{
    AdaptiveOptions, AlbedoMode, BakeMode, BakeOptions, BakeReport, FittedVertices, PrtError, Receivers, bake,
    bake_matrices, split_adaptively,
};
use lobe_scene::{Bvh, Scene, SceneReadOptions, built_in, read_scene};

/// The vertices that a point lies between, and their weights.
type Corners = BTreeMap<usize, f64>;

/// Bands of transfer.
const ORDER: usize = 4;

/// Points at which it is compared.
const POINTS: usize = 1000;

/// Paths from each vertex, and of each of the two bakes there.
const PATHS: u32 = 1024;

/// What is baked.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Fronts,
    Backs,
    Matrices,
    /// The visibility of the sky: the first row of matrices of shadows alone.
    Visibility,
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("| scene | vertices | transfer | at vertices | fitted | rays of the fit |");
    println!("|---|---:|---|---:|---:|---:|");
    for argument in std::env::args().skip(1) {
        let (name, budget) = argument.split_once('@').map_or((&*argument, None), |(name, n)| (name, Some(n)));
        let read = match name.strip_prefix("built-in:") {
            Some(name) => built_in::named(name).ok_or("no such scene")?,
            None => read_scene(name, &SceneReadOptions::default().allow_outside(true))?.0,
        };
        let options =
            BakeOptions::default().mode(BakeMode::Interreflected).order(ORDER).samples(PATHS).albedo(AlbedoMode::None);
        let scene = match budget {
            Some(budget) => {
                let split = AdaptiveOptions::default().max_vertices(Some(budget.parse()?)).bake(options.clone());
                split_adaptively(&read, &Bvh::new(&read), &split, Job::default())?.0
            }
            None => read,
        };
        for kind in [Kind::Fronts, Kind::Backs, Kind::Matrices, Kind::Visibility] {
            let mode = if kind == Kind::Visibility { BakeMode::Shadowed } else { BakeMode::Interreflected };
            let found = measure(&scene, &options.clone().mode(mode), kind)?;
            let percent =
                |error: f64| if error.is_finite() { format!("{:.1} %", 100.0 * error) } else { String::new() };
            let [vertices, fitted] = found.errors.map(percent);
            let count = scene.vertex_count();
            println!("| {argument} | {count} | {kind:?} | {vertices} | {fitted} | {:.2} |", found.rays);
        }
    }
    Ok(())
}

struct Found {
    /// Of transfer at the vertices, and of fitted transfer; none if no point is seen.
    errors: [f64; 2],
    /// Rays of the fit, those of vertices being 1.
    rays: f64,
}

fn measure(scene: &Scene, options: &BakeOptions, kind: Kind) -> Result<Found, PrtError> {
    let (has_matrices, is_back) = (matches!(kind, Kind::Matrices | Kind::Visibility), kind == Kind::Backs);
    let bvh = Bvh::new(scene);
    let rows = |receivers: &Receivers, options: &BakeOptions| -> Result<(Vec<f32>, BakeReport), PrtError> {
        if has_matrices {
            let (found, report) = bake_matrices(scene, &bvh, receivers, options, Job::default())?;
            return Ok((found.coefficients().to_vec(), report));
        }
        let (found, report) = bake(scene, &bvh, receivers, options, Job::default())?;
        Ok((found.coefficients().to_vec(), report))
    };
    let side = |receivers: Receivers, which: &[usize]| {
        if is_back { receivers.backs(which) } else { receivers.subset(which) }
    };
    let all: Vec<usize> = (0..scene.vertex_count()).collect();
    // Bake the vertices, and fit them.
    let (sampled, report) = rows(&side(Receivers::at_vertices(scene)?, &all)?, options)?;
    let vertices = if is_back { FittedVertices::backs(scene, &all)? } else { FittedVertices::all(scene)? };
    let (fitted, of_fit) = if has_matrices {
        let (found, report) = vertices.bake_matrices(&bvh, options, Job::default())?;
        (found.coefficients().to_vec(), report)
    } else {
        let (found, report) = vertices.bake(&bvh, options, Job::default())?;
        (found.coefficients().to_vec(), report)
    };
    // Bake points between them twice.
    let (dense, corners) = dense(scene)?;
    let chosen = chosen(&dense);
    let points = side(Receivers::at_vertices(&dense)?, &chosen)?;
    let of_seed = |seed: u64| Ok::<_, PrtError>(rows(&points, &options.clone().samples(PATHS).seed(seed))?.0);
    let truth = [of_seed(1001)?, of_seed(1002)?];
    // Compare.
    let numbers = truth[0].len() / chosen.len();
    let weights = weights(numbers, kind);
    let errors = [&sampled, &fitted].map(|rows| {
        let (mut error, mut all) = (0.0, 0.0);
        for (k, &point) in chosen.iter().enumerate() {
            for (i, weight) in weights.iter().enumerate() {
                let [a, b] = [0, 1].map(|half: usize| f64::from(truth[half][k * numbers + i]));
                let found = |(vertex, part): (&usize, &f64)| part * f64::from(rows[vertex * numbers + i]);
                let found: f64 = corners[point].iter().map(found).sum();
                let is_seen = truth[0][k * numbers] != 0.0 && truth[1][k * numbers] != 0.0;
                let weight = if is_seen { *weight } else { 0.0 };
                error += weight * (found - a) * (found - b);
                all += weight * a * b;
            }
        }
        (error.max(0.0) / all).sqrt()
    });
    Ok(Found { errors, rays: of_fit.rays as f64 / report.rays.max(1) as f64 })
}

/// The weight of each number of a row.
fn weights(numbers: usize, kind: Kind) -> Vec<f64> {
    let bands = ORDER * ORDER;
    let of_band = |i: usize| 1.0 / (i.isqrt() + 1) as f64;
    let weight = |k: usize| match (kind, k / bands % bands) {
        (Kind::Matrices, row) => (of_band(row) * of_band(k % bands)).powi(2),
        (Kind::Visibility, 1..) => 0.0,
        _ => of_band(k % bands).powi(2),
    };
    (0..numbers).map(weight).collect()
}

/// A scene with vertices between those it has, and for each of them those of the scene and their weights.
fn dense(scene: &Scene) -> Result<(Scene, Vec<Corners>), PrtError> {
    let bounds = scene.bounds();
    let diagonal = (0..3).map(|k| (bounds.max[k] - bounds.min[k]).powi(2)).sum::<f32>().sqrt();
    // One vertex in sixteen is one of the scene, or in the middle of a long edge.
    let mut dense = scene.split_edges(diagonal / 48.0)?;
    for _ in 0..2 {
        dense = dense.halve_edges(|_, _| true)?.0;
    }
    let (mut all, mut first) = (Vec::with_capacity(dense.vertex_count()), 0);
    for (mesh, old) in dense.meshes().iter().zip(scene.meshes()) {
        let (begin, count) = (all.len(), old.positions().len());
        all.extend((first..first + count).map(|vertex| Corners::from([(vertex, 1.0)])));
        first += count;
        let new = mesh.positions().len() - count;
        for edge in &mesh.halved()[mesh.halved().len() - new..] {
            let mut middle = Corners::new();
            for (&vertex, weight) in edge.iter().flat_map(|&end| &all[begin + end as usize]) {
                *middle.entry(vertex).or_insert(0.0) += 0.5 * weight;
            }
            all.push(middle);
        }
    }
    Ok((dense, all))
}

/// Vertices of a scene, chosen by area.
fn chosen(scene: &Scene) -> Vec<usize> {
    let mut sums = vec![0.0; scene.vertex_count()];
    let mut first = 0;
    for mesh in scene.meshes() {
        for (number, triangle) in mesh.triangles().iter().enumerate() {
            let [a, b, c] = mesh.corners(number).map(|p| glam::Vec3::from(p).as_dvec3());
            let area = 0.5 * (b - a).cross(c - a).length();
            triangle.iter().for_each(|&v| sums[first + v as usize] += area / 3.0);
        }
        first += mesh.positions().len();
    }
    let mut all = 0.0;
    sums.iter_mut().for_each(|sum| (all, *sum) = (all + *sum, all + *sum));
    let mut random = lobe_testkit::Random::new(7);
    (0..POINTS).map(|_| sums.partition_point(|&sum| sum < random.unit() * all).min(sums.len() - 1)).collect()
}
