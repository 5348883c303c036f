//! Shadow fields against a plain port of the paper's loop, on one thread.
//!
//! The peer does what the pseudo-code of Zhou et al. 2005 says, for every receiver and every entity, nearest first: it looks
//! up the visibility linearly in the radius and bilinearly in direction, rotates it with matrices that were prepared for the
//! entity, multiplies by the non-zero Gaunt coefficients in a loop, and ends with a double product for each channel. It leaves
//! out no entity. Both get the same receivers, entities and samples.

use std::hint::black_box;
use std::time::{Duration, Instant};

use criterion::{BenchmarkId, Criterion, Throughput};
use lobe_io::Job;
use lobe_scene::built_in;
use lobe_sh::product::GauntTensor;
use lobe_sh::rotation::RotationMatrices;
use lobe_sh::{Dir, Rgb, Rotation, Zonal};
use lobe_shadow::{
    FieldGrid, FieldOptions, OcclusionField, PlacedField, Placement, RadialInterpolation, ShadowFieldOptions,
    ShadowFields, ShadowReceivers, bake_field,
};
use lobe_testkit::Random;

const RECEIVERS: usize = 8192;
const ENTITIES: [usize; 2] = [8, 32];
const ORDERS: [usize; 3] = [3, 4, 6];

/// Receivers on a floor, and entities turned at random above it and beside each other.
struct Workload {
    field: OcclusionField,
    placements: Vec<Placement>,
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    light: Vec<Rgb<f64>>,
}

impl Workload {
    fn new(order: usize, entities: usize) -> Self {
        let options = FieldOptions::default().order(order).rays(64);
        let Ok((field, _)) = bake_field(&built_in::cornell_box(8), &options, Job::default()) else {
            unreachable!("options within their ranges")
        };
        let mut random = Random::new(1);
        let mut within = |side: f64| [side * random.signed(), side * random.signed()];
        let side = 3.0 * (entities as f64).sqrt();
        let places: Vec<[f64; 2]> = (0..entities).map(|_| within(side)).collect();
        let positions = (0..RECEIVERS).map(|_| within(side)).map(|[x, y]| [x as f32, y as f32, 0.0]).collect();
        let turn = |random: &mut Random| Rotation::from_quaternion(random.quaternion()).unwrap_or_default();
        let placements = places.iter().map(|[x, y]| Placement::new([*x, *y, 1.0], turn(&mut random), 1.0)).collect();
        let light = (0..order * order).map(|_| Rgb::new(random.signed(), random.signed(), random.signed())).collect();
        Self { field, placements, positions, normals: vec![[0.0, 0.0, 1.0]; RECEIVERS], light }
    }

    fn entities(&self) -> Vec<PlacedField<'_>> {
        self.placements.iter().map(|p| PlacedField { field: &self.field, placement: *p }).collect()
    }

    fn shade(&self, negligible: f64, receivers: usize) -> Vec<Rgb<f32>> {
        let options = ShadowFieldOptions::default().negligible(negligible);
        let receivers = ShadowReceivers::new(&self.positions[..receivers], &self.normals[..receivers]);
        let fields = ShadowFields::new(self.field.order(), &self.entities(), options);
        fields.and_then(|fields| fields.shade(&receivers?, &self.light)).unwrap_or_else(|e| unreachable!("{e}"))
    }
}

/// The plain port.
struct Plain<'a> {
    workload: &'a Workload,
    grid: FieldGrid,
    /// Visibility at the samples of every sphere.
    table: Vec<f32>,
    turns: Vec<RotationMatrices<f32>>,
    tensor: Vec<(usize, usize, usize, f32)>,
    radii: Vec<f32>,
}

impl<'a> Plain<'a> {
    fn new(workload: &'a Workload) -> Self {
        let (order, grid) = (workload.field.order(), *workload.field.grid());
        let at = |point: usize| {
            let offset = grid.offset(point);
            let p = std::array::from_fn(|k| grid.center()[k] + offset[k]);
            workload.field.visibility_at(p, RadialInterpolation::Linear).into_vec()
        };
        let tensor = GauntTensor::new(order, order, order);
        Self {
            workload,
            grid,
            table: (0..grid.points()).flat_map(at).collect(),
            turns: workload.placements.iter().map(|p| RotationMatrices::new(p.rotation(), order)).collect(),
            tensor: tensor.coefficients().iter().map(|t| (t.i, t.j, t.k, t.value as f32)).collect(),
            radii: (0..grid.spheres()).map(|k| grid.sphere_radius(k) as f32).collect(),
        }
    }

    fn shade(&self, receivers: usize) -> Vec<Rgb<f32>> {
        let Workload { field, placements, positions, normals, light } = self.workload;
        let (order, n) = (field.order(), field.order() * field.order());
        let cosine = Zonal::clamped_cosine(order);
        let (mut seen, mut turned, mut product) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        let mut near: Vec<(f64, usize)> = Vec::new();
        (0..receivers)
            .map(|k| {
                let p = positions[k].map(f64::from);
                let normal = Dir::from_f32(normals[k]).unwrap_or(Dir::Z);
                let mut visible = cosine.towards(normal, std::f32::consts::FRAC_1_PI).into_vec();
                near.clear();
                near.extend(placements.iter().enumerate().map(|(e, placement)| {
                    let t = placement.to_world(self.grid.center());
                    ((0..3).map(|c| (t[c] - p[c]).powi(2)).sum::<f64>(), e)
                }));
                near.sort_by(|a, b| a.0.total_cmp(&b.0));
                for (_, e) in &near {
                    self.look_up(placements[*e].to_own(p), &mut seen);
                    self.turns[*e].apply_into(&seen, &mut turned);
                    product.fill(0.0);
                    for (i, j, k, value) in &self.tensor {
                        product[*k] += value * visible[*i] * turned[*j];
                    }
                    std::mem::swap(&mut visible, &mut product);
                }
                let mut sum = Rgb::new(0.0, 0.0, 0.0);
                for (v, l) in visible.iter().zip(light) {
                    sum += Rgb::new(v * l.r as f32, v * l.g as f32, v * l.b as f32);
                }
                sum
            })
            .collect()
    }

    fn look_up(&self, p: [f64; 3], out: &mut [f32]) {
        let offset: [f32; 3] = std::array::from_fn(|k| (p[k] - self.grid.center()[k]) as f32);
        let r = offset.iter().map(|c| c * c).sum::<f32>().sqrt();
        // Linearly in the radius, between the spheres on both sides.
        let above = self.radii.partition_point(|x| *x <= r).clamp(1, self.radii.len() - 1);
        let (low, high) = (self.radii[above - 1], self.radii[above]);
        let t = ((r - low) / (high - low)).clamp(0.0, 1.0);
        // Bilinearly on the octahedral grid.
        let [x, y, z] = offset;
        let scale = 1.0 / (x.abs() + y.abs() + z.abs());
        let (x, y) = (x * scale, y * scale);
        let (u, v) = if z >= 0.0 { (x, y) } else { ((1.0 - y.abs()).copysign(x), (1.0 - x.abs()).copysign(y)) };
        let cells = self.grid.cells();
        let [(i, a), (j, b)] = [u, v].map(|c| {
            let c = 0.5 * (c + 1.0) * cells as f32;
            let k = (c as usize).min(cells - 1);
            (k, c - k as f32)
        });
        out.fill(0.0);
        let (side, width) = (cells + 1, out.len());
        for (sphere, of_sphere) in [(above - 1, 1.0 - t), (above, t)] {
            for (di, dj, weight) in
                [(0, 0, (1.0 - a) * (1.0 - b)), (1, 0, a * (1.0 - b)), (0, 1, (1.0 - a) * b), (1, 1, a * b)]
            {
                let row = (sphere * side + j + dj) * side + i + di;
                let row = &self.table[row * width..][..width];
                out.iter_mut().zip(row).for_each(|(out, x)| *out += of_sphere * weight * x);
            }
        }
    }
}

fn benches(c: &mut Criterion) {
    for entities in ENTITIES {
        let mut group = c.benchmark_group(format!("shade-{entities}-entities"));
        group.throughput(Throughput::Elements(RECEIVERS as u64));
        for order in ORDERS {
            let workload = Workload::new(order, entities);
            let plain = Plain::new(&workload);
            group.bench_function(BenchmarkId::new("plain", order), |b| b.iter(|| black_box(plain.shade(RECEIVERS))));
            group.bench_function(BenchmarkId::new("fields, none left out", order), |b| {
                b.iter(|| black_box(workload.shade(0.0, RECEIVERS)));
            });
            group.bench_function(BenchmarkId::new("fields", order), |b| {
                let negligible = ShadowFieldOptions::default().negligible;
                b.iter(|| black_box(workload.shade(negligible, RECEIVERS)));
            });
        }
    }
}

/// The least of a few times, taken in turns so that other work on the machine meets both alike.
fn ratios(orders: &[usize]) {
    println!(
        "\n| order | entities | receivers | plain, µs a receiver | plain / fields, none left out | plain / fields |"
    );
    println!("|---|---|---|---|---|---|");
    for &order in orders {
        for (entities, receivers) in [(8, RECEIVERS), (32, RECEIVERS), (32, 1024)] {
            let workload = Workload::new(order, entities);
            let plain = Plain::new(&workload);
            let negligible = ShadowFieldOptions::default().negligible;
            let mut least = [f64::INFINITY; 3];
            for _ in 0..9 {
                let runs: [&dyn Fn() -> Vec<Rgb<f32>>; 3] =
                    [&|| plain.shade(receivers), &|| workload.shade(0.0, receivers), &|| {
                        workload.shade(negligible, receivers)
                    }];
                for (least, run) in least.iter_mut().zip(runs) {
                    let begin = Instant::now();
                    black_box(run());
                    *least = least.min(begin.elapsed().as_secs_f64());
                }
            }
            let [plain, all, some] = least;
            println!(
                "| {order} | {entities} | {receivers} | {:.2} | {:.1} | {:.1} |",
                plain / receivers as f64 * 1e6,
                plain / all,
                plain / some
            );
        }
    }
}

fn main() {
    // An order as the first argument prints its ratios alone.
    let order = std::env::args().nth(1).and_then(|order| order.parse().ok());
    if rayon::ThreadPoolBuilder::new().num_threads(1).build_global().is_err() {
        return;
    }
    if let Some(order) = order {
        return ratios(&[order]);
    }
    ratios(&ORDERS);
    let mut c = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1))
        .configure_from_args();
    benches(&mut c);
    c.final_summary();
}
