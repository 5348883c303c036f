//! Errors, sizes and times of occlusion fields, as tables: `field_errors [MESH.obj]`; `field_errors storage` prints that of storage alone.
//!
//! Every error is the root mean square difference of visibility from that of traced rays, relative to the occlusion
//! there: a field that knew of no occluder would have the error 1.

#[path = "../tests/all/shapes/mod.rs"]
mod shapes;

use std::time::Instant;

use lobe_io::Job;
use lobe_prt::{CompressOptions, WeightBits};
use lobe_scene::{Scene, SceneReadOptions, read_scene};
use lobe_sh::{Expansion as _, Rotation};
use lobe_shadow::{
    FieldOptions, FieldStorage, OcclusionField, PlacedField, Placement, RadialInterpolation, ShadowFieldOptions,
    ShadowFields, bake_field, read_field, write_field,
};
use lobe_testkit::Random;

/// Rays of the truth at a point, all of them within the cone that holds the entity.
const TRUTH_RAYS: usize = 1 << 12;

/// Receivers for each range of distances.
const RECEIVERS: usize = 80;

/// Distances in radii of the entity.
const RANGES: [[f64; 2]; 6] = [[0.05, 0.5], [0.5, 1.0], [1.0, 2.0], [2.0, 4.0], [4.0, 8.0], [8.0, 32.0]];

struct Case {
    name: String,
    scene: Scene,
    /// For each range the receivers and their visibility of order 8.
    truth: Vec<(Vec<[f32; 3]>, Vec<f32>)>,
}

impl Case {
    fn new(name: &str, scene: Scene) -> Self {
        let at = |k: usize| {
            let points = shapes::points_between(&scene, RANGES[k], RECEIVERS, k as u64);
            let truth = shapes::traced(&scene, &points, 8, TRUTH_RAYS);
            (points, truth)
        };
        let truth = (0..RANGES.len()).map(at).collect();
        Self { name: name.to_owned(), scene, truth }
    }

    fn bake(&self, options: &FieldOptions) -> OcclusionField {
        bake_field(&self.scene, options, Job::default()).unwrap_or_else(|e| panic!("{e}")).0
    }

    /// The error in each range, then in all of them.
    fn errors(&self, field: &OcclusionField, interpolation: RadialInterpolation) -> Vec<f64> {
        let n = field.order() * field.order();
        let found = |points: &[[f32; 3]]| -> Vec<f32> {
            let at = |p: &[f32; 3]| field.visibility_at(p.map(f64::from), interpolation).into_vec();
            points.iter().flat_map(at).collect()
        };
        let of_order = |truth: &[f32]| -> Vec<f32> { truth.chunks_exact(64).flat_map(|v| &v[..n]).copied().collect() };
        let ranges = self.truth.iter().map(|(points, truth)| (found(points), of_order(truth)));
        ranges.map(|(found, truth)| shapes::relative_error(&found, &truth, field.order())).collect()
    }
}

fn row(label: &str, errors: &[f64]) {
    // Within a ball there are no receivers.
    let cell = |e: &f64| if e.is_nan() { "–".to_owned() } else { format!("{e:.4}") };
    let cells: Vec<String> = errors.iter().map(cell).collect();
    println!("| {label} | {} |", cells.join(" | "));
}

fn head(first: &str) {
    let ranges: Vec<String> = RANGES.iter().map(|[a, b]| format!("{a} to {b} R")).collect();
    println!("\n| {first} | {} |", ranges.join(" | "));
    println!("|---|{}", "---|".repeat(RANGES.len()));
}

fn by_order(cases: &[Case]) {
    println!("\n## By order and distance\n\n16 spheres of 16 cells from 0.25 R to 8 R, 1024 rays.");
    head("entity, order");
    for case in cases {
        let field = case.bake(&FieldOptions::default().order(8));
        for order in [3, 4, 5, 6, 8] {
            let Ok(field) = field.truncated(order) else { continue };
            row(&format!("{}, {order}", case.name), &case.errors(&field, RadialInterpolation::Linear));
        }
    }
}

fn by_sampling(cases: &[Case]) {
    println!("\n## By sampling\n\nOrder 4, 512 rays.");
    head("entity, spheres × cells");
    for case in cases {
        for (spheres, cells) in [(4, 4), (8, 8), (16, 8), (8, 16), (16, 16), (32, 16), (16, 32)] {
            let field = case.bake(&FieldOptions::default().spheres(spheres).cells(cells).rays(512));
            row(&format!("{}, {spheres} × {cells}", case.name), &case.errors(&field, RadialInterpolation::Linear));
            if cells == 16 {
                row(
                    &format!("{}, {spheres} × {cells}, cubic", case.name),
                    &case.errors(&field, RadialInterpolation::Cubic),
                );
            }
        }
    }
    println!("\nOther choices, 16 × 16:");
    head("entity, choice");
    for case in cases {
        let base = FieldOptions::default().rays(512);
        for (name, options) in [
            ("as above", base.clone()),
            ("128 rays", base.clone().rays(128)),
            ("2048 rays", base.clone().rays(2048)),
            ("inside not filled", base.clone().fill_inside(false)),
            ("from 0.1 R", base.clone().inner(0.1)),
            ("from 0.5 R", base.clone().inner(0.5)),
            ("to 4 R", base.clone().outer(4.0)),
            ("to 16 R", base.clone().outer(16.0)),
        ] {
            row(&format!("{}, {name}", case.name), &case.errors(&case.bake(&options), RadialInterpolation::Linear));
        }
    }
}

fn storages(case: &Case) {
    println!("\n## Storage\n\n{}, order 4, 16 × 16.\n", case.name);
    let ranges: Vec<String> = RANGES.iter().map(|[a, b]| format!("{a} to {b} R")).collect();
    println!("| storage | bytes | of the numbers | {} |", ranges.join(" | "));
    println!("|---|---|---|{}", "---|".repeat(RANGES.len()));
    let field = case.bake(&FieldOptions::default());
    let Ok(folder) = tempfile::tempdir() else { return };
    let path = folder.path().join("f.field.safetensors");
    let clusters = |clusters, components| CompressOptions::default().clusters(clusters).components(components);
    for (name, storage) in [
        ("f32", FieldStorage::F32),
        ("f16", FieldStorage::F16),
        ("u8", FieldStorage::U8),
        ("8 clusters, 8 components", FieldStorage::Clustered(clusters(8, 8))),
        ("8 clusters, 8 components of u8", FieldStorage::Clustered(clusters(8, 8).weights(WeightBits::U8))),
        ("64 clusters, 4 components", FieldStorage::Clustered(clusters(64, 4))),
        ("128 clusters, 4 components", FieldStorage::Clustered(clusters(128, 4))),
        ("64 clusters, 6 components", FieldStorage::Clustered(clusters(64, 6))),
        ("128 clusters, 6 components", FieldStorage::Clustered(clusters(128, 6))),
        ("128 clusters, 6 components of u8", FieldStorage::Clustered(clusters(128, 6).weights(WeightBits::U8))),
        ("64 clusters, 8 components of u8", FieldStorage::Clustered(clusters(64, 8).weights(WeightBits::U8))),
        ("16 clusters, 4 components of u8", FieldStorage::Clustered(clusters(16, 4).weights(WeightBits::U8))),
    ] {
        let Ok(report) = write_field(&path, &field, &storage) else { continue };
        let Ok(back) = read_field(&path) else { continue };
        let errors = case.errors(&back, RadialInterpolation::Linear);
        row(&format!("{name} | {} | {:.5}", report.bytes, report.relative_error), &errors);
    }
}

fn sizes() {
    println!("\n## Bytes\n\n| spheres × cells | points | order 3 | order 4 | order 5 | order 6 | order 8 |");
    println!("|---|---|---|---|---|---|---|");
    for (spheres, cells) in [(8, 8), (16, 8), (16, 16), (32, 16), (32, 32)] {
        let points = spheres * (cells + 1) * (cells + 1) + 1;
        let cells_of: Vec<String> = [3, 4, 5, 6, 8].iter().map(|n| format!("{}", points * (n + n * n) * 4)).collect();
        println!("| {spheres} × {cells} | {points} | {} |", cells_of.join(" | "));
    }
}

/// Rings of entities around the origin, turned at random.
fn placements(count: usize) -> Vec<Placement> {
    let mut random = Random::new(5);
    (0..count)
        .map(|k| {
            let [x, y, z] = random.direction();
            let r = 2.5 + 0.7 * k as f64;
            let turn = Rotation::from_quaternion(random.quaternion()).unwrap_or_default();
            Placement::new([r * x, r * y, r * z.abs()], turn, 1.0)
        })
        .collect()
}

fn several(case: &Case) {
    println!("\n## Several entities\n\n{} times n, receivers within 1.5 of the origin.", case.name);
    println!("\n| entities, order | fields | exact factors | nothing left out | cubic |\n|---|---|---|---|---|");
    let full = case.bake(&FieldOptions::default().order(8));
    let mut random = Random::new(8);
    let points: Vec<[f32; 3]> = (0..40).map(|_| random.direction().map(|c| (1.5 * c * random.unit()) as f32)).collect();
    for count in [1, 2, 4, 8, 16] {
        let placements = placements(count);
        let parts: Vec<(&Scene, Placement)> = placements.iter().map(|p| (&case.scene, *p)).collect();
        let truth = shapes::traced(&shapes::together(&parts), &points, 8, TRUTH_RAYS);
        let alone: Vec<Vec<f32>> =
            parts.iter().map(|part| shapes::traced(&shapes::together(&[*part]), &points, 8, TRUTH_RAYS)).collect();
        for order in [3, 4, 6, 8] {
            let n = order * order;
            let cut = |v: &[f32]| -> Vec<f32> { v.chunks_exact(64).flat_map(|v| &v[..n]).copied().collect() };
            let Ok(field) = full.truncated(order) else { continue };
            let entities: Vec<PlacedField<'_>> =
                placements.iter().map(|p| PlacedField { field: &field, placement: *p }).collect();
            let chained = |options: ShadowFieldOptions| -> f64 {
                let Ok(fields) = ShadowFields::new(order, &entities, options) else { return f64::NAN };
                let at = |p: &[f32; 3]| fields.visibility_at(*p, None, None).map(lobe_sh::ShVec::into_vec);
                let found: Vec<f32> = points.iter().flat_map(|p| at(p).unwrap_or_default()).collect();
                shapes::relative_error(&found, &cut(&truth), order)
            };
            let exact: Vec<f32> = (0..points.len())
                .flat_map(|p| {
                    let mut order_of: Vec<usize> = (0..count).collect();
                    let square = |k: &usize| -> f64 {
                        let t = placements[*k].translation();
                        (0..3).map(|c| (t[c] - f64::from(points[p][c])).powi(2)).sum()
                    };
                    order_of.sort_by(|a, b| square(a).total_cmp(&square(b)));
                    let mut v = lobe_sh::ShVec::constant(order, 1.0_f32);
                    for k in order_of {
                        let mut out = lobe_sh::ShVec::zero(order);
                        let factor = &cut(&alone[k])[p * n..(p + 1) * n];
                        lobe_sh::product::product_into(v.coefficients(), factor, out.coefficients_mut());
                        v = out;
                    }
                    v.into_vec()
                })
                .collect();
            let options = ShadowFieldOptions::default();
            row(
                &format!("{count}, {order}"),
                &[
                    chained(options.clone()),
                    shapes::relative_error(&exact, &cut(&truth), order),
                    chained(options.clone().negligible(0.0)),
                    chained(options.interpolation(RadialInterpolation::Cubic)),
                ],
            );
        }
    }
}

fn main() {
    let begin = Instant::now();
    let argument = std::env::args().nth(1);
    if argument.as_deref() == Some("storage") {
        // The rabbit, the middle one of those whose sampling is printed.
        if let Some((name, scene)) = shapes::named().into_iter().nth(1) {
            storages(&Case::new(name, scene));
        }
        return;
    }
    let mut cases: Vec<Case> = match argument {
        None => shapes::named().into_iter().map(|(name, scene)| Case::new(name, scene)).collect(),
        Some(path) => {
            let (scene, _) = read_scene(&path, &SceneReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
            // Of radius 1 around the origin, like the shapes by formula.
            let bounds = scene.bounds();
            let middle: [f64; 3] = std::array::from_fn(|k| 0.5 * f64::from(bounds.min[k] + bounds.max[k]));
            let square = |p: [f32; 3]| (0..3).map(|k| (f64::from(p[k]) - middle[k]).powi(2)).sum::<f64>();
            let radius = scene.corners().flatten().map(square).fold(0.0, f64::max).sqrt();
            let place = Placement::new(middle.map(|c| -c / radius), Rotation::IDENTITY, 1.0 / radius);
            vec![Case::new(&path, shapes::together(&[(&scene, place)]))]
        }
    };
    println!("# Occlusion fields against rays");
    by_order(&cases);
    // The rabbit and the torus: neither fills its sphere, and both have an inside.
    cases.truncate(3);
    by_sampling(if cases.len() > 1 { &cases[1..] } else { &cases });
    sizes();
    storages(&cases[cases.len() / 2]);
    cases.truncate(2);
    if let Some(case) = cases.last() {
        several(case);
    }
    eprintln!("{:.0} s", begin.elapsed().as_secs_f64());
}
