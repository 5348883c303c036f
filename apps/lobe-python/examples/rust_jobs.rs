//! The jobs of `peers/python/rust.py` without Python: the same calls of the library on as many numbers, results in new memory.
//!
//! Prints a line for each: the job, the precision, the size of the batch, and the least seconds of some runs.

use std::hint::black_box;
use std::time::Instant;

use lobe::env::project_lat_long;
use lobe::sh::basis::{Vectors, coefficient_count};
use lobe::sh::batch::{Functions, ShBatch, Tiled};
use lobe::sh::filter::scale_bands_in_place;
use lobe::sh::product::product_into;
use lobe::sh::rotation::RotationMatrices;
use lobe::sh::{Real, Rgb, Rotation, Zonal};
use rayon::prelude::*;

/// Seconds that a job is repeated for.
const REPEATED: f64 = 1.0;

/// Bands of all functions.
const ORDER: usize = 4;

/// Directions that a thread has at a time.
const BLOCK: usize = 512;

/// The least seconds of a job.
fn least(mut job: impl FnMut()) -> f64 {
    job();
    let (begun, mut best) = (Instant::now(), f64::INFINITY);
    while begun.elapsed().as_secs_f64() < REPEATED {
        let run = Instant::now();
        job();
        best = best.min(run.elapsed().as_secs_f64());
    }
    best
}

/// Numbers between -1 and 1 that have no pattern.
fn numbers<T: Real>(count: usize) -> Vec<T> {
    let turn = |k: usize| T::from_f64(2.0 * (k as f64 * 0.618_033_988_749_894_9).fract() - 1.0);
    (0..count).map(turn).collect()
}

/// New rows from rows, in parallel.
fn rows<T: Real>(rows: &[T], work: impl Fn(usize, &[T], &mut [T]) + Sync) -> Vec<T> {
    let count = coefficient_count(ORDER);
    let mut out = vec![T::ZERO; rows.len()];
    out.par_chunks_exact_mut(count)
        .zip(rows.par_chunks_exact(count))
        .enumerate()
        .for_each(|(k, (out, row))| work(k, row, out));
    out
}

/// Functions that are worked on side by side.
const TOGETHER: usize = 64;

/// The same in batches of single precision: `work` has those of some rows, and where the results belong.
fn batches(sources: &[&[f32]], work: impl Fn(&[ShBatch], &mut ShBatch) + Sync) -> Vec<f32> {
    let count = coefficient_count(ORDER);
    let mut out = vec![0.0; sources[0].len()];
    out.par_chunks_mut(TOGETHER * count).enumerate().for_each(|(k, out)| {
        let part = |source: &&[f32]| ShBatch::from_rows(ORDER, &source[k * TOGETHER * count..][..out.len()]);
        let from: Vec<ShBatch> = sources.iter().map(part).collect();
        let mut to = ShBatch::zero(ORDER, out.len() / count);
        work(&from, &mut to);
        to.rows_into(out);
    });
    out
}

/// Values of one function towards directions of any length.
fn values<T: Tiled>(f: &[T], directions: &[[T; 3]], vectors: AsVectors<T>) -> Vec<T> {
    let (mut out, functions) = (vec![T::ZERO; directions.len()], Functions::new(f, ORDER, 1));
    out.par_chunks_mut(BLOCK).zip(directions.par_chunks(BLOCK)).for_each(|(out, part)| {
        assert!(functions.eval_into(vectors(part), &mut [out]), "a vector without a direction");
    });
    out
}

/// Vectors of a precision.
type AsVectors<T> = for<'a> fn(&'a [[T; 3]]) -> Vectors<'a>;

fn jobs<T: Tiled>(name: &str, batch: usize, vectors: AsVectors<T>) {
    let count = coefficient_count(ORDER);
    let (a, b) = (numbers::<T>(batch * count), numbers::<T>(batch * count + 1).split_off(1));
    let tell = |job: &str, seconds: f64| println!("{job} {name} {batch} {seconds}");

    let directions: Vec<[T; 3]> = numbers::<T>(3 * batch).as_chunks().0.to_vec();
    tell("eval", least(|| drop(black_box(values(&a[..count], &directions, vectors)))));
    let turn = Rotation::from_euler_zyz(0.3, 1.1, -2.0);
    if let (Some(a), Some(b)) = (T::single_slice(&a), T::single_slice(&b)) {
        let matrices = RotationMatrices::new(&turn, ORDER);
        let rotate = |from: &[ShBatch], to: &mut ShBatch| from[0].rotated_into(&matrices, to);
        tell("rotate", least(|| drop(black_box(batches(&[a], rotate)))));
        let product = |from: &[ShBatch], to: &mut ShBatch| from[0].product_into(&from[1], to);
        tell("product", least(|| drop(black_box(batches(&[a, b], product)))));
    } else {
        let matrices = RotationMatrices::<T>::new(&turn, ORDER);
        tell("rotate", least(|| drop(black_box(rows(&a, |_, row, out| matrices.apply_into(row, out))))));
        let product = |k: usize, row: &[T], out: &mut [T]| product_into(row, &b[k * count..][..count], out);
        tell("product", least(|| drop(black_box(rows(&a, product)))));
    }
    let factors = Zonal::clamped_cosine(ORDER).convolution_factors();
    let convolve = |_: usize, row: &[T], out: &mut [T]| {
        out.copy_from_slice(row);
        scale_bands_in_place(out, &factors);
    };
    tell("convolve", least(|| drop(black_box(rows(&a, convolve)))));
}

/// Pictures twice as wide as high, of about `batch` pixels.
fn projection(batch: usize) {
    let height = (batch as f64 / 2.0).sqrt() as usize;
    let texels: Vec<Rgb<f32>> =
        numbers::<f32>(6 * height * height).as_chunks().0.iter().map(|c| Rgb::from(*c)).collect();
    let project = || {
        drop(black_box(project_lat_long(&texels, 2 * height, ORDER)));
    };
    println!("project f32 {batch} {}", least(project));
}

fn main() {
    for batch in [100_000, 1_000_000] {
        jobs::<f32>("f32", batch, |directions| Vectors::Single(directions));
        jobs::<f64>("f64", batch, |directions| Vectors::Double(directions));
        projection(batch);
    }
}
