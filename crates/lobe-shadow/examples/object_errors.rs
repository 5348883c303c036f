//! The irradiance of receivers around several meshes, by every way, against traced rays: one table.
//!
//! A rabbit (the Stanford bunny), a monkey's head, a torus and a star of five prongs, each of radius 1, float over a plane that
//! hides nothing itself. Receivers lie on the plane and on the objects; those of an object see past it by rays, whichever way it
//! is hidden by the others. Prints the root mean square difference of irradiance from that of traced rays, relative to the root
//! mean square of that:
//!
//! * open: nothing hides the sky but a receiver's own object;
//! * fields: the chain of triple products of occlusion fields;
//! * products, SHEXP: the chain of triple products of what spheres leave visible, and the exponential of the sum of
//!   their logarithms, 16 or 64 for each object, which hide as much as it does (`SphereSet::with_silhouette_of`);
//! * exact: the visibility that rays find, cut off at the order: what no way can do better with, but by luck.
//!
//! ```sh
//! cargo run --release --package lobe-shadow --example object_errors
//! ```

#![allow(clippy::unwrap_used, reason = "an example fails by panicking")]

#[path = "../tests/all/shapes/mod.rs"]
mod shapes;

use lobe_io::Job;
use lobe_scene::{Bvh, Ray, Scene, SceneReadOptions, read_scene};
use lobe_sh::product::product_into;
use lobe_sh::sphere::even_directions;
use lobe_sh::{Dir, Expansion as _, Rgb, Rotation, ShVec, Zonal, eval_basis, project};
use lobe_shadow::{
    FieldOptions, LogTable, LogTableOptions, Occluder, OcclusionField, PlacedField, Placement, ShadowFieldOptions,
    ShadowFields, ShadowOptions, ShadowReceivers, SkyLight, SphereFitOptions, SphereSet, SphereShadows,
    VisibilityOptions, bake_field, bake_visibility, fit_spheres,
};
use lobe_testkit::Random;

const ORDERS: [usize; 3] = [3, 4, 6];

/// Spheres for each object.
const SPHERES: [usize; 2] = [16, 64];

/// Receivers along a side of the plane, of length 6, and on each object.
const SIDE: usize = 15;
const ON_OBJECT: usize = 60;

/// Rays of the truth from a receiver.
const RAYS: usize = 1 << 13;

/// The most bands.
const MOST: usize = 6;

/// Where the objects are.
const PLACES: [[f64; 3]; 4] = [[-1.2, -1.2, 1.1], [1.2, -1.1, 1.2], [-1.1, 1.2, 1.0], [1.2, 1.2, 1.3]];

/// The sky: twice as bright as its darkest part around its zenith, and a wide lobe from the side.
fn sky(s: Dir) -> f64 {
    let side = (0.6 * s.x() + 0.3 * s.y() + 0.742 * s.z()).max(0.0);
    1.0 + 0.5 * (1.0 + s.z()) + 4.0 * side.powi(6)
}

/// An object with all that stands for it.
struct Object {
    name: &'static str,
    scene: Scene,
    placement: Placement,
    field: OcclusionField,
    /// One for each of [`SPHERES`].
    sets: Vec<SphereSet>,
}

/// Receivers on one surface.
struct Receivers {
    name: &'static str,
    /// The object that they are on.
    on: Option<usize>,
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    /// What each sees past its own object, of [`MOST`] bands.
    own: Option<Vec<f32>>,
    /// The visibility of [`MOST`] bands, and the irradiance.
    truth: (Vec<f32>, Vec<f64>),
}

fn main() {
    let objects = objects();
    let parts: Vec<(&Scene, Placement)> = objects.iter().map(|object| (&object.scene, object.placement)).collect();
    let bvh = Bvh::new(&shapes::together(&parts));
    let mut all = vec![on_plane(&bvh)];
    all.extend((0..objects.len()).map(|on| on_object(&objects, on, &bvh)));
    println!(
        "| receivers on, order | open | fields | products of 16 | SHEXP of 16 | products of 64 | SHEXP of 64 | exact |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for receivers in &all {
        for order in ORDERS {
            let row: Vec<String> = errors(receivers, &objects, order).iter().map(|e| format!("{e:.4}")).collect();
            println!("| {}, {order} | {} |", receivers.name, row.join(" | "));
        }
    }
}

fn objects() -> Vec<Object> {
    let asset = |name: &str| {
        let path = format!("{}/../lobe-scene/assets/{name}", env!("CARGO_MANIFEST_DIR"));
        read_scene(path, &SceneReadOptions::default()).unwrap().0
    };
    let meshes = [
        ("bunny", asset("bunny.obj")),
        ("suzi", asset("suzi.glb")),
        ("torus", shapes::torus()),
        ("star", shapes::prongs()),
    ];
    let object = |((name, scene), place): ((&'static str, Scene), [f64; 3])| {
        let scene = of_radius_one(&scene);
        let turn = Rotation::from_axis_angle(Dir::X, 0.4 + place[0]);
        let field = FieldOptions::default().order(MOST).rays(512);
        let (field, _) = bake_field(&scene, &field, Job::default()).unwrap();
        let set = |count: usize| {
            let options = SphereFitOptions::default().count(count).samples(4000).rounds(20);
            fit_spheres(&scene, &options, Job::default()).unwrap().0.with_silhouette_of(&scene)
        };
        let sets = SPHERES.map(set).to_vec();
        Object { name, placement: Placement::new(place, turn, 1.0), field, sets, scene }
    };
    meshes.into_iter().zip(PLACES).map(object).collect()
}

/// A scene as large as a ball of radius 1 around the origin.
fn of_radius_one(scene: &Scene) -> Scene {
    let [min, max] = scene.world_bounds();
    let middle: [f64; 3] = std::array::from_fn(|k| 0.5 * (min[k] + max[k]));
    let origin = scene.origin();
    let square = |p: [f32; 3]| (0..3).map(|k| (f64::from(p[k]) + origin[k] - middle[k]).powi(2)).sum::<f64>();
    let radius = scene.corners().flatten().map(square).fold(0.0, f64::max).sqrt();
    shapes::together(&[(scene, Placement::new(middle.map(|c| -c / radius), Rotation::IDENTITY, radius.recip()))])
}

fn on_plane(bvh: &Bvh) -> Receivers {
    let at = |k: usize| 6.0 * (k as f32 / (SIDE - 1) as f32 - 0.5);
    let positions: Vec<[f32; 3]> = (0..SIDE * SIDE).map(|k| [at(k % SIDE), at(k / SIDE), 0.0]).collect();
    let normals = vec![[0.0, 0.0, 1.0]; positions.len()];
    let truth = traced(bvh, &positions, &normals);
    Receivers { name: "plane", on: None, positions, normals, own: None, truth }
}

/// Middles of triangles that are drawn by their area.
fn on_object(objects: &[Object], on: usize, bvh: &Bvh) -> Receivers {
    let Object { name, scene, placement, .. } = &objects[on];
    let origin = scene.origin();
    let corners: Vec<[[f64; 3]; 3]> =
        scene.corners().map(|t| t.map(|p| [0, 1, 2].map(|k| f64::from(p[k]) + origin[k]))).collect();
    let normal = |[a, b, c]: &[[f64; 3]; 3]| {
        let [u, v] = [b, c].map(|p| [0, 1, 2].map(|k| p[k] - a[k]));
        [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
    };
    let length = |v: [f64; 3]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
    let sums: Vec<f64> = corners
        .iter()
        .scan(0.0, |sum, triangle| {
            *sum += length(normal(triangle));
            Some(*sum)
        })
        .collect();
    let mut random = Random::new(on as u64 + 1);
    let (mut own_positions, mut own_normals) = (Vec::new(), Vec::new());
    for _ in 0..ON_OBJECT {
        let at = random.unit() * sums[sums.len() - 1];
        let triangle = &corners[sums.partition_point(|sum| *sum < at).min(sums.len() - 1)];
        let n = normal(triangle).map(|c| c / length(normal(triangle)));
        own_positions
            .push([0, 1, 2].map(|k| ((triangle[0][k] + triangle[1][k] + triangle[2][k]) / 3.0 - origin[k]) as f32));
        own_normals.push(n.map(|c| c as f32));
    }
    let options = VisibilityOptions::default().order(MOST).rays(2048);
    let in_own = bake_visibility(scene, &own_positions, &own_normals, &options, Job::default()).unwrap();
    // To the world.
    let turn = placement.rotation();
    let own = in_own.chunks_exact(MOST * MOST).flat_map(|row| {
        let row = ShVec::from_vec(row.iter().map(|c| f64::from(*c)).collect()).unwrap();
        row.rotated(turn).coefficients().iter().map(|c| *c as f32).collect::<Vec<_>>()
    });
    let own: Vec<f32> = own.collect();
    let normals: Vec<[f32; 3]> = own_normals
        .iter()
        .map(|n| turn.rotate_dir(Dir::new(n.map(f64::from)).unwrap()).to_array().map(|c| c as f32))
        .collect();
    let positions: Vec<[f32; 3]> = own_positions
        .iter()
        .map(|p| placement.to_world([0, 1, 2].map(|k| f64::from(p[k]) + origin[k])).map(|c| c as f32))
        .collect();
    let truth = traced(bvh, &positions, &normals);
    Receivers { name, on: Some(on), positions, normals, own: Some(own), truth }
}

/// The visibility and the irradiance that rays find.
fn traced(bvh: &Bvh, positions: &[[f32; 3]], normals: &[[f32; 3]]) -> (Vec<f32>, Vec<f64>) {
    let weight = 4.0 * std::f64::consts::PI / RAYS as f64;
    let (mut visibility, mut irradiance) = (Vec::new(), Vec::new());
    let directions: Vec<Dir> = even_directions(RAYS).collect();
    for (p, n) in positions.iter().zip(normals) {
        let origin = bvh.origin_above(*p, *n);
        let (mut seen, mut sum) = (vec![0.0; MOST * MOST], 0.0);
        for s in &directions {
            let towards = s.to_array().map(|c| c as f32);
            if bvh.is_occluded(&Ray::new(origin, towards)) {
                continue;
            }
            let cosine: f32 = (0..3).map(|k| n[k] * towards[k]).sum();
            sum += weight * sky(*s) * f64::from(cosine.max(0.0));
            seen.iter_mut().zip(eval_basis(*s, MOST)).for_each(|(v, y)| *v += weight * y);
        }
        visibility.extend(seen.iter().map(|v| *v as f32));
        irradiance.push(sum);
    }
    (visibility, irradiance)
}

/// The errors of all ways, in the order of the columns.
fn errors(receivers: &Receivers, objects: &[Object], order: usize) -> Vec<f64> {
    let n = order * order;
    let light = project(order, 40, |s: Dir| sky(s));
    let light = SkyLight::new(&light.map(|c| Rgb::new(c as f32, c as f32, c as f32)), order).unwrap();
    let cut =
        |rows: &[f32]| -> Vec<f32> { rows.chunks_exact(MOST * MOST).flat_map(|row| &row[..n]).copied().collect() };
    let white = ShVec::constant(order, 1.0_f32).into_vec();
    let own = receivers.own.as_deref().map_or_else(|| white.repeat(receivers.positions.len()), cut);
    let others: Vec<&Object> =
        objects.iter().enumerate().filter(|(k, _)| Some(*k) != receivers.on).map(|(_, object)| object).collect();
    let shadow_receivers = ShadowReceivers::new(&receivers.positions, &receivers.normals).unwrap();
    let error = |visibility: &[f32]| {
        let found =
            receivers.normals.iter().zip(visibility.chunks_exact(n)).map(|(n, v)| f64::from(light.irradiance(*n, v).g));
        let (mut off, mut all) = (0.0, 0.0);
        for (found, truth) in found.zip(&receivers.truth.1) {
            off += (found - truth).powi(2);
            all += truth * truth;
        }
        f64::sqrt(off / all)
    };
    // Fields.
    let cut_fields: Vec<OcclusionField> = others.iter().map(|object| object.field.truncated(order).unwrap()).collect();
    let placed: Vec<PlacedField<'_>> = cut_fields
        .iter()
        .zip(&others)
        .map(|(field, object)| PlacedField { field, placement: object.placement })
        .collect();
    let fields = ShadowFields::new(order, &placed, ShadowFieldOptions::default()).unwrap();
    let by_fields = fields.visibility(&shadow_receivers.with_own_visibility(order, &own).unwrap()).unwrap();
    let mut errors = vec![error(&own), error(&by_fields)];
    for set in 0..SPHERES.len() {
        let spheres: Vec<Occluder> = others
            .iter()
            .flat_map(|object| {
                let set = &object.sets[set];
                let place = &object.placement;
                (0..set.len()).map(|k| Occluder::new(place.to_world(set.center(k)).map(|c| c as f32), set.radii()[k]))
            })
            .collect();
        errors.push(error(&products(receivers, &spheres, &own, order)));
        let table = LogTable::new(&LogTableOptions::default().order(order)).unwrap();
        let shadows = SphereShadows::new(&table, &spheres, &ShadowOptions::default()).unwrap();
        let mut seen = shadows.visibility(&shadow_receivers);
        let mut product = vec![0.0; n];
        for (seen, own) in seen.chunks_exact_mut(n).zip(own.chunks_exact(n)) {
            product_into(&*seen, own, &mut product);
            seen.copy_from_slice(&product);
        }
        errors.push(error(&seen));
    }
    errors.push(error(&cut(&receivers.truth.0)));
    errors
}

/// The chain of triple products of what every sphere leaves visible, nearest first.
fn products(receivers: &Receivers, spheres: &[Occluder], own: &[f32], order: usize) -> Vec<f32> {
    let n = order * order;
    let mut out = own.to_vec();
    for (p, visible) in receivers.positions.iter().zip(out.chunks_exact_mut(n)) {
        let to = |sphere: &Occluder| [0, 1, 2].map(|k| f64::from(sphere.center[k]) - f64::from(p[k]));
        let distance = |sphere: &Occluder| to(sphere).iter().map(|c| c * c).sum::<f64>().sqrt();
        let mut order_of: Vec<&Occluder> = spheres.iter().collect();
        order_of.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
        let mut product = vec![0.0; n];
        for sphere in order_of {
            let angle = (f64::from(sphere.radius) / distance(sphere)).min(1.0).asin();
            let Some(axis) = Dir::new(to(sphere)) else { continue };
            let factor = &ShVec::constant(order, 1.0) + &Zonal::cone(order, angle).towards(axis, -1.0);
            let factor: Vec<f32> = factor.coefficients().iter().map(|c| *c as f32).collect();
            product_into(&*visible, &factor, &mut product);
            visible.copy_from_slice(&product);
        }
    }
    out
}
