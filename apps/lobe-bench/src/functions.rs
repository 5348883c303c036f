//! Functions on the sphere: basis, products, squares and rotations sixteen side by side, products and rotations one by one.

use std::hint::black_box;

use lobe::sh::batch::{DirBatch, ShBatch};
use lobe::sh::probes::{multiply_adds, multiply_adds_in, multiply_pairs, rotate_one};
use lobe::sh::rotation::RotationMatrices;
use lobe::sh::simd::{LANES, Machine};
use lobe::sh::sphere::even_directions;
use lobe::sh::{Dir, Rotation};

use crate::cost::{
    Cost, Level, basis_operations, product_operations, rotation_operations, square_operations, zonal_product_operations,
};
use crate::measure::{Bench, BenchJob, Pace};

/// Directions of a tile, whose basis stays in the first-level cache up to order 5.
const TILE: usize = 256;

/// Directions of a mesh, whose basis of order 6 leaves every cache: 144 MiB.
const MESH: usize = 1 << 20;

/// Pairs whose products stay in the second-level cache.
const PAIRS: usize = 512;

/// Functions that one rotation turns.
const TURNED: usize = 1024;

const NUMBER: f64 = size_of::<f32>() as f64;

/// Runs the jobs of this file.
pub(crate) fn run(bench: &mut Bench<'_>) {
    probe(bench);
    basis(bench);
    values(bench);
    products(bench);
    zonal_products(bench);
    product_of_one(bench);
    rotation(bench);
    rotation_of_one(bench);
    high_rotation_of_one(bench);
}

/// The probe of arithmetic, once where instructions are counted: its time is the floor itself.
fn probe(bench: &mut Bench<'_>) {
    let name = "multiply-adds";
    if matches!(bench.pace, Pace::Counted) && bench.wants_without_order(name) {
        let machine = Machine::detect();
        let (items, _) = multiply_adds_in(machine);
        let job = BenchJob { name, order: None, item: "register", items, cost: None, above: "" };
        bench.measure(&job, || {
            black_box(multiply_adds(machine, black_box(0.5), black_box(1.0)));
        });
    }
}

/// Coefficients of any value: what kernels do does not depend on them.
fn coefficients(order: usize, count: usize) -> Vec<f32> {
    // Small steps of an irrational angle, so that no two numbers are the same and none grows.
    (0..count * order * order).map(|k| (0.618 * k as f32).sin()).collect()
}

fn functions(order: usize, count: usize) -> ShBatch {
    ShBatch::from_planes(order, count, &coefficients(order, count))
}

/// Any rotation.
fn turn() -> Rotation {
    Rotation::from_axis_angle(Dir::from_angles(0.7, 1.9), 0.8)
}

fn basis(bench: &mut Bench<'_>) {
    for (name, count, orders, level) in [
        ("basis", TILE, &[3, 4, 6, 10][..], Level::WrittenToCache),
        ("basis-streamed", MESH, &[3, 4, 6, 10], Level::Written),
    ] {
        if !bench.wants(name) {
            continue;
        }
        let directions: DirBatch = even_directions(count).collect();
        for order in bench.orders(orders) {
            let mut out = ShBatch::zero(order, count);
            let bytes = NUMBER * (order * order) as f64;
            let job = BenchJob {
                name,
                order: Some(order),
                item: "direction",
                items: count,
                cost: Some(Cost { operations: basis_operations(order), bytes, level }),
                above: "high orders keep more sums than there are registers, and store the rest",
            };
            bench.measure(&job, || black_box(&mut out).set_basis(black_box(&directions)));
        }
    }
}

fn products(bench: &mut Bench<'_>) {
    for (name, is_square) in [("product", false), ("square", true)] {
        if !bench.wants(name) {
            continue;
        }
        for order in bench.orders(&[3, 4, 6]) {
            let (a, b, mut out) = (functions(order, PAIRS), functions(order, PAIRS), ShBatch::zero(order, PAIRS));
            let read = if is_square { 1.0 } else { 2.0 };
            let operations = if is_square { square_operations(order) } else { product_operations(order) };
            let bytes = NUMBER * (read + 1.0) * (order * order) as f64;
            let job = BenchJob {
                name,
                order: Some(order),
                item: if is_square { "function" } else { "pair" },
                items: PAIRS,
                cost: Some(Cost { operations, bytes, level: Level::Cache }),
                above: "the straight-line code of an order keeps more numbers alive than there are registers",
            };
            bench.measure(&job, || {
                if is_square {
                    black_box(&a).square_into(black_box(&mut out));
                } else {
                    black_box(&a).product_into(black_box(&b), black_box(&mut out));
                }
            });
        }
    }
}

/// The value of each function towards a direction of its own.
fn values(bench: &mut Bench<'_>) {
    let name = "eval";
    if !bench.wants(name) {
        return;
    }
    let directions: DirBatch = even_directions(TILE).collect();
    for order in bench.orders(&[3, 4, 6]) {
        let (f, mut out) = (functions(order, TILE), vec![0.0; TILE]);
        let n = (order * order) as f64;
        let job = BenchJob {
            name,
            order: Some(order),
            item: "function",
            items: TILE,
            cost: Some(Cost { operations: basis_operations(order) + 2.0 * n, bytes: NUMBER * n, level: Level::Cache }),
            above: "each coefficient is loaded for one multiplication",
        };
        bench.measure(&job, || black_box(&f).eval_into(black_box(&directions), black_box(&mut out)));
    }
}

/// Products with a zonal function for each.
fn zonal_products(bench: &mut Bench<'_>) {
    let name = "zonal-product";
    if !bench.wants(name) {
        return;
    }
    for order in bench.orders(&[3, 4, 6]) {
        let (f, mut out) = (functions(order, PAIRS), ShBatch::zero(order, PAIRS));
        // The blocks of other functions, of which there are more than of bands.
        let zonal = &f.blocks()[..PAIRS.div_ceil(LANES) * order];
        let bytes = NUMBER * (order + 2 * order * order) as f64;
        let job = BenchJob {
            name,
            order: Some(order),
            item: "pair",
            items: PAIRS,
            cost: Some(Cost { operations: zonal_product_operations(order), bytes, level: Level::Cache }),
            above: "the straight-line code of an order keeps more numbers alive than there are registers",
        };
        bench.measure(&job, || black_box(&f).zonal_product_into(black_box(zonal), black_box(&mut out)));
    }
}

/// Pairs one after the other, in the order of their coefficients.
fn product_of_one(bench: &mut Bench<'_>) {
    let name = "product-one";
    if !bench.wants(name) {
        return;
    }
    for order in bench.orders(&[3, 4, 6]) {
        let n = order * order;
        let (a, mut out) = (coefficients(order, PAIRS), vec![0.0; PAIRS * n]);
        let b: Vec<f32> = a.iter().rev().copied().collect();
        let bytes = NUMBER * 3.0 * n as f64;
        let job = BenchJob {
            name,
            order: Some(order),
            item: "pair",
            items: PAIRS,
            cost: Some(Cost { operations: product_operations(order), bytes, level: Level::Cache }),
            above: "one pair leaves lanes empty, and its sums wait for each other",
        };
        bench.measure(&job, || multiply_pairs(n, black_box(&a), black_box(&b), black_box(&mut out)));
    }
}

fn rotation(bench: &mut Bench<'_>) {
    let name = "rotation";
    if !bench.wants(name) {
        return;
    }
    for order in bench.orders(&[3, 4, 6]) {
        let matrices = RotationMatrices::<f32>::new(&turn(), order);
        let (f, mut out) = (functions(order, TURNED), ShBatch::zero(order, TURNED));
        let bytes = NUMBER * 2.0 * (order * order) as f64;
        let job = BenchJob {
            name,
            order: Some(order),
            item: "function",
            items: TURNED,
            cost: Some(Cost { operations: rotation_operations(order), bytes, level: Level::Cache }),
            above: "each entry of the matrices is loaded for every sixteen functions",
        };
        bench.measure(&job, || black_box(&f).rotated_into(&matrices, black_box(&mut out)));
    }
}

/// One function of a high order, turned without a matrix.
fn high_rotation_of_one(bench: &mut Bench<'_>) {
    let name = "rotation-one-f64";
    if !bench.wants(name) {
        return;
    }
    let turn = turn();
    for order in bench.orders(&[64, 128, 256]) {
        let f: Vec<f64> = (0..order * order).map(|k| (0.618 * k as f64).sin()).collect();
        let mut out = f.clone();
        let job =
            BenchJob { name, order: Some(order), item: "function", items: 1, cost: None, above: "in double precision" };
        bench.measure(&job, || turn.apply_into(black_box(&f), black_box(&mut out)));
    }
}

/// A function by a rotation that is new to it: no matrix is built.
fn rotation_of_one(bench: &mut Bench<'_>) {
    let name = "rotation-one";
    if !bench.wants(name) {
        return;
    }
    for order in bench.orders(&[3, 4, 6, 10]) {
        let (turn, f) = (turn(), coefficients(order, 1));
        let mut out = vec![0.0; f.len()];
        let job = BenchJob { name, order: Some(order), item: "function", items: 1, cost: None, above: "" };
        bench.measure(&job, || rotate_one(black_box(&turn), black_box(&f), black_box(&mut out)));
    }
}
