//! Pictures of everything around a point: projection, and maps of what an expansion holds.

use std::hint::black_box;

use lobe::env::{EnvMap, MappedMap, Mapping, project_env, project_map, reconstruct};
use lobe::sh::{Coefficient as _, Dir, Rgb, ShVec};

use crate::cost::{Cost, Level};
use crate::measure::{Bench, BenchJob};

/// Texels along the width and the height.
const SIZE: [usize; 2] = [2048, 1024];

/// Texels along a side of a cube.
const FACE: usize = 512;

/// Bytes of a texel: three `f32`.
const TEXEL: f64 = 12.0;

/// Runs the jobs of this file.
pub(crate) fn run(bench: &mut Bench<'_>) -> anyhow::Result<()> {
    project_lat_long(bench);
    project_cube(bench)?;
    reconstruct_map(bench);
    Ok(())
}

/// Any light: what is done does not depend on it.
fn light(s: Dir) -> Rgb<f32> {
    Rgb::new(1.0 + s.x() as f32, 2.0 + s.y() as f32, 0.5)
}

/// Operations of a texel along its row: three colors times its sines and cosines, or times a fast Fourier transform where that has
/// fewer (5 operations for each number and halving, half of them for a real row).
fn row_operations(order: usize) -> f64 {
    let by_fft = 3.0 * 2.5 * (SIZE[0] as f64).log2();
    ((6 * (2 * order - 1)) as f64).min(by_fft)
}

fn project_lat_long(bench: &mut Bench<'_>) {
    let name = "project";
    if !bench.wants(name) {
        return;
    }
    let map = EnvMap::from_fn(SIZE[0], SIZE[1], light);
    for order in bench.orders(&[3, 6, 64, 128, 256]) {
        let operations = row_operations(order);
        let job = BenchJob {
            name,
            order: Some(order),
            item: "texel",
            items: SIZE[0] * SIZE[1],
            cost: Some(Cost { operations, bytes: TEXEL, level: Level::Read }),
            above: "in double precision, and colors are parted into channels first",
        };
        bench.measure(&job, || {
            black_box(project_env(black_box(&map), order));
        });
    }
}

fn project_cube(bench: &mut Bench<'_>) -> anyhow::Result<()> {
    let name = "project-cube";
    if !bench.wants(name) {
        return Ok(());
    }
    let height = Mapping::Cube.height_for(FACE);
    let map = MappedMap::from_fn(Mapping::Cube, FACE, height, light);
    for order in bench.orders(&[3, 6]) {
        let n = order as f64;
        // The basis, its three products with the color, and the weight.
        let operations = n * (n + 1.0) + n * n + 4.0 * (n - 1.0) + 6.0 * n * n + 9.0;
        let job = BenchJob {
            name,
            order: Some(order),
            item: "texel",
            items: FACE * height,
            cost: Some(Cost { operations, bytes: TEXEL, level: Level::Read }),
            above: "exact moments of every texel in double precision, where the floor counts its middle in single precision",
        };
        bench.measure(&job, || {
            black_box(project_map(black_box(&map), order));
        });
    }
    Ok(())
}

fn reconstruct_map(bench: &mut Bench<'_>) {
    let name = "reconstruct";
    if !bench.wants(name) {
        return;
    }
    for order in bench.orders(&[3, 6, 64, 128, 256]) {
        let colors = (0..order * order).map(|k| Rgb::splat(1.0 / (1 + k) as f64)).collect();
        let Some(f) = ShVec::<Rgb<f64>>::from_vec(colors) else { continue };
        let job = BenchJob {
            name,
            order: Some(order),
            item: "texel",
            items: SIZE[0] * SIZE[1],
            cost: Some(Cost { operations: row_operations(order), bytes: TEXEL, level: Level::Written }),
            above: "in double precision, into pages that the system gives one by one",
        };
        bench.measure(&job, || {
            black_box(reconstruct(black_box(&f), SIZE[0], SIZE[1]));
        });
    }
}
