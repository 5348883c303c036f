//! Shadows of spheres by exponentials against chained products, per receiver, on one thread; see the README beside this file.

#![allow(clippy::unwrap_used, reason = "a benchmark fails by panicking")]

use std::hint::black_box;
use std::time::Instant;

use lobe_sh::{Dir, Expansion as _, ShVec, Zonal, len, product_into};
use lobe_shadow::{LogTable, LogTableOptions, Occluder, ShadowOptions, SphereReceivers, SphereShadows};
use lobe_testkit::Random;

/// Receivers that are timed together: few, so that other programs seldom come between; and those of the chain.
const RECEIVERS: usize = 128;
const CHAINS: usize = 2;

/// Repetitions, taken in turns; the fastest counts.
const REPETITIONS: usize = 200;

fn main() {
    println!("ns per receiver    products      shexp   ratio   with hierarchy   ratio   grouped");
    // In the one thread of a pool: nothing is handed from thread to thread.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.install(|| {
        for order in [3, 4, 6] {
            let table = LogTable::new(&LogTableOptions::default().order(order)).unwrap();
            for count in [8, 32, 128, 512] {
                row(order, count, &table);
            }
        }
    });
}

fn row(order: usize, count: usize, table: &LogTable) {
    let mut random = Random::new(1);
    let spheres = figure(count, &mut random);
    let positions: Vec<[f32; 3]> =
        (0..RECEIVERS).map(|_| [1.5 + random.signed() as f32, random.signed() as f32, 0.0]).collect();
    let normals = vec![[0.0, 0.0, 1.0]; RECEIVERS];
    let receivers = SphereReceivers::new(&positions, &normals).unwrap();
    let plain = ShadowOptions::default().cut(0.0);
    let all = [plain, ShadowOptions::default(), ShadowOptions::default().group(64)]
        .map(|options| SphereShadows::new(table, &spheres, &options).unwrap());
    let factors = factors(order, &spheres, &positions[..CHAINS]);
    let mut best = [f64::INFINITY; 4];
    for _ in 0..REPETITIONS {
        best[0] = best[0].min(seconds(|| chains(order, count, &factors)) / CHAINS as f64);
        for (best, shadows) in best[1..].iter_mut().zip(&all) {
            let run = || shadows.visibility(black_box(&receivers));
            *best = best.min(seconds(run) / RECEIVERS as f64);
        }
    }
    let [products, exponential, hierarchy, grouped] = best.map(|seconds| 1e9 * seconds);
    println!(
        "order {order}, {count:3} {products:12.0} {exponential:10.0} {:7.1} {hierarchy:16.0} {:7.1} {grouped:9.0}",
        products / exponential,
        products / hierarchy
    );
}

fn seconds<T>(mut run: impl FnMut() -> T) -> f64 {
    let start = Instant::now();
    black_box(run());
    start.elapsed().as_secs_f64()
}

/// Spheres of a figure of about two units above the ground: clusters, as limbs are.
fn figure(count: usize, random: &mut Random) -> Vec<Occluder> {
    let limbs: Vec<[f64; 3]> = (0..8).map(|_| [random.signed(), random.signed(), 1.2 + random.unit()]).collect();
    let scale = (16.0 / count as f64).sqrt().min(1.0);
    let sphere = |k: usize, random: &mut Random| {
        let s = random.direction();
        let offset = 0.4 * random.unit();
        let center = [0, 1, 2].map(|c| (limbs[k % limbs.len()][c] + offset * s[c]) as f32);
        Occluder::new(center, (scale * (0.1 + 0.15 * random.unit())) as f32)
    };
    (0..count).map(|k| sphere(k, random)).collect()
}

/// What each sphere leaves visible, as each receiver sees it, turned already: only the products are timed.
fn factors(order: usize, spheres: &[Occluder], positions: &[[f32; 3]]) -> Vec<f32> {
    let mut out = Vec::new();
    for p in positions {
        for sphere in spheres {
            let to = [0, 1, 2].map(|k| f64::from(sphere.center[k] - p[k]));
            let d = to.iter().map(|c| c * c).sum::<f64>().sqrt();
            let hidden = Zonal::cone(order, (f64::from(sphere.radius) / d).min(1.0).asin());
            let visible = &ShVec::constant(order, 1.0) + &hidden.towards(Dir::new(to).unwrap(), -1.0);
            out.extend(visible.coefficients().iter().map(|c| *c as f32));
        }
    }
    out
}

fn chains(order: usize, count: usize, factors: &[f32]) -> f32 {
    let n = len(order);
    let mut sum = 0.0;
    for factors in black_box(factors).chunks_exact(count * n) {
        let (mut all, mut next) = (factors[..n].to_vec(), vec![0.0; n]);
        for factor in factors.chunks_exact(n).skip(1) {
            product_into(&all, factor, &mut next);
            std::mem::swap(&mut all, &mut next);
        }
        sum += all[0];
    }
    sum
}
