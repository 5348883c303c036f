//! Clustered principal components: their guarantees, on closed forms over a surface and on planted rows.

use crate::cloth::{cloth, with_threads};
use lobe_io::Job;
use lobe_prt::{
    Channels, CompressOptions, CompressReport, CompressedTable, CompressedTransfer, TableWeights, WeightBits,
    compress_table, compress_table_within, error_curve,
};
use lobe_sh::Rgb;
use lobe_testkit::Random;
use proptest::prelude::*;

/// The parts of a sum of squares that roundings to `f32` leave: of the rows, the bases and the weights.
const ROUNDING: f64 = 1e-12;

fn options(clusters: usize, components: usize) -> CompressOptions {
    CompressOptions::default().clusters(clusters).components(components)
}

fn energy(values: &[f32]) -> f64 {
    values.iter().map(|x| f64::from(*x).powi(2)).sum()
}

fn light(order: usize, seed: u64) -> Vec<Rgb<f64>> {
    let mut random = Random::new(seed);
    (0..order * order).map(|_| Rgb::new(random.signed(), random.signed(), random.signed())).collect()
}

#[test]
fn the_error_falls_with_clusters_and_components() {
    let (clusters, components) = ([1, 2, 8, 32], [0, 1, 2, 4, 8]);
    for (transfer, name) in [(cloth(24, 4, Channels::Gray), "gray"), (cloth(16, 3, Channels::Rgb), "color")] {
        let curve =
            error_curve(&transfer, &clusters, &components, &CompressOptions::default(), Job::default()).unwrap();
        for (i, point) in curve.iter().enumerate() {
            println!("{name}: {point:?}");
            if i % clusters.len() > 0 {
                let fewer = curve[i - 1];
                assert!(point.squared_error <= fewer.squared_error, "{name}: {fewer:?} then {point:?}");
            }
            if i >= clusters.len() {
                let fewer = curve[i - clusters.len()];
                assert!(point.squared_error <= fewer.squared_error, "{name}: {fewer:?} then {point:?}");
            }
        }
        let (first, last) = (curve[0].squared_error, curve[curve.len() - 1].squared_error);
        assert!(last < 1e-3 * first, "{name}: from {first} to {last}");
    }
}

#[test]
fn clustered_components_are_never_worse_than_either_part() {
    for transfer in [cloth(20, 4, Channels::Gray), cloth(14, 3, Channels::Rgb), cloth(14, 6, Channels::Gray)] {
        let bound = ROUNDING * energy(transfer.coefficients());
        let error = |clusters, components| {
            CompressedTransfer::new(&transfer, &options(clusters, components), Job::default()).unwrap().1.squared_error
        };
        for (clusters, components) in [(2, 1), (8, 3), (32, 4), (5, 2)] {
            let (both, pca, vq) = (error(clusters, components), error(1, components), error(clusters, 0));
            println!("{clusters} clusters, {components} components: {both}, PCA {pca}, VQ {vq}");
            assert!(both <= pca.min(vq) + bound, "{clusters}, {components}: {both} above {pca} or {vq}");
        }
    }
}

#[test]
fn at_equal_cost_neither_pca_nor_vq_is_better() {
    let transfer = cloth(24, 5, Channels::Gray);
    let (rows, width) = (transfer.coefficients(), 25);
    let count = rows.len() / width;
    for (bits, bytes) in [(WeightBits::F32, 12_000), (WeightBits::U8, 6_000)] {
        let base = CompressOptions::default().weights(bits);
        let (table, report) = compress_table_within(rows, width, bytes, &base, Job::default()).unwrap();
        assert!(table.bytes() <= bytes && table.bytes() == report.bytes, "{bits:?}: {report:?} in {bytes}");
        // As many components, and as many codes, as this many bytes hold.
        let most_components =
            (0..=width).rev().find(|n| count * n * bits.bytes() + 4 * (n + 1) * width <= bytes).unwrap();
        let most_codes = (bytes - 2 * count) / (4 * width);
        // One cluster needs no numbers of clusters, which the files store all the same.
        for (name, clusters, components, needless) in [("PCA", 1, most_components, 2 * count), ("VQ", most_codes, 0, 0)]
        {
            let (_, other) =
                compress_table(rows, width, &base.clusters(clusters).components(components), Job::default()).unwrap();
            println!(
                "{bits:?} in {bytes}: {}x{} {} against {name} {clusters}x{components} {}",
                report.clusters, report.components, report.relative_error, other.relative_error
            );
            assert!(other.bytes - needless <= bytes, "{name} costs {}", other.bytes);
            assert!(report.squared_error <= other.squared_error, "{bits:?}: {report:?} against {name} {other:?}");
        }
    }
    let least = 2 * count + 4 * width;
    let within = |bytes| compress_table_within(rows, width, bytes, &CompressOptions::default(), Job::default());
    assert_eq!(within(least).unwrap().1.bytes, least, "a mean");
    let refused = within(least - 1).unwrap_err().to_string();
    assert_eq!(refused, format!("expected room for {least} bytes at least, found {}", least - 1), "not even a mean");
}

#[test]
fn nothing_is_lost_at_full_rank_or_with_a_cluster_for_each() {
    let transfer = cloth(12, 4, Channels::Rgb);
    let energy = energy(transfer.coefficients());
    for (clusters, components) in [(1, 48), (4, 48), (3, 1000), (144, 0), (1000, 2)] {
        let (found, report) =
            CompressedTransfer::new(&transfer, &options(clusters, components), Job::default()).unwrap();
        assert!(report.squared_error < ROUNDING * energy, "{clusters} x {components}: {report:?}");
        assert!(report.components <= 48 && report.clusters <= 144, "{report:?}");
        assert_eq!(found.receivers(), 144, "receivers");
    }
}

/// Rows about `clusters` far-apart means, each varying along its own `rank` directions.
fn planted(clusters: usize, each: usize, width: usize, rank: usize, seed: u64) -> (Vec<f32>, Vec<usize>) {
    let mut random = Random::new(seed);
    let spaces: Vec<_> = (0..clusters)
        .map(|_| (random.signed_vec(width), (0..rank).map(|_| random.signed_vec(width)).collect::<Vec<_>>()))
        .collect();
    let (mut rows, mut of_row) = (Vec::new(), Vec::new());
    for r in 0..clusters * each {
        // Mixed, so that the order tells nothing.
        let k = r * 7 % clusters;
        let weights = random.signed_vec(rank);
        let (mean, directions) = &spaces[k];
        rows.extend((0..width).map(|i| {
            (4.0 * mean[i] + weights.iter().zip(directions).map(|(w, d)| 0.3 * w * d[i]).sum::<f64>()) as f32
        }));
        of_row.push(k);
    }
    (rows, of_row)
}

#[test]
fn planted_clusters_are_found() {
    for (clusters, rank, seed) in [(5, 2, 1), (8, 1, 2), (3, 4, 3), (16, 0, 4), (10, 3, 5)] {
        let (rows, planted) = planted(clusters, 60, 16, rank, seed);
        let (table, report) = compress_table(&rows, 16, &options(clusters, rank), Job::default()).unwrap();
        assert!(report.squared_error < ROUNDING * energy(&rows), "{clusters} clusters of rank {rank}: {report:?}");
        for (a, b) in [(0, 1), (0, clusters), (3, 3 + 5 * clusters), (7, 11)] {
            let together = table.clusters()[a] == table.clusters()[b];
            assert_eq!(together, planted[a] == planted[b], "{clusters} clusters of rank {rank}: rows {a} and {b}");
        }
    }
}

#[test]
fn the_last_iteration_has_the_least_error_and_it_rises_only_where_a_cluster_was_moved() {
    let transfer = cloth(40, 4, Channels::Gray);
    let (_, report) = CompressedTransfer::new(&transfer, &options(16, 2).tolerance(0.0), Job::default()).unwrap();
    println!("{:?}", report.iterations);
    assert!(report.iterations.len() > 3, "{:?}", report.iterations);
    let (first, last) = (report.iterations[0], report.iterations[report.iterations.len() - 1]);
    let least = report.iterations.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(last < first && last == least, "the last is the least: {:?}", report.iterations);
    // Only where a cluster was moved does the error rise, and it ends lower than it was.
    let rises = report.iterations.windows(2).filter(|e| e[1] > e[0]).count();
    assert!(rises <= 8, "{rises} rises: {:?}", report.iterations);
}

#[test]
fn decoding_is_the_sum_of_weighted_vectors_and_shading_its_scalar_product() {
    for (order, channels) in [(4, Channels::Gray), (3, Channels::Rgb)] {
        let transfer = cloth(16, order, channels);
        for weights in [WeightBits::F32, WeightBits::U16, WeightBits::U8] {
            let (found, _) =
                CompressedTransfer::new(&transfer, &options(6, 3).weights(weights), Job::default()).unwrap();
            let table = found.table();
            let light = light(order, 9);
            let shaded = found.exit_radiance(&light);
            let expected = found.to_transfer().exit_radiance(&light);
            for r in 0..found.receivers() {
                let w = |j: usize| match table.weights() {
                    TableWeights::F32(w) => f64::from(w[3 * r + j]),
                    TableWeights::U16(w) => f64::from(w[3 * r + j]) / 65535.0,
                    TableWeights::U8(w) => f64::from(w[3 * r + j]) / 255.0,
                };
                let start = usize::from(table.clusters()[r]) * 4 * table.width();
                for (i, x) in found.decode(r).iter().enumerate() {
                    let b = |j: usize| f64::from(table.bases()[start + j * table.width() + i]);
                    let sum = b(0) + (0..3).map(|j| w(j) * b(j + 1)).sum::<f64>();
                    assert!((f64::from(*x) - sum).abs() < 1e-6, "receiver {r}, number {i}: {x} against {sum}");
                }
                let (a, b) = (shaded[r], expected[r]);
                let error = (a.r - b.r).abs().max((a.g - b.g).abs()).max((a.b - b.b).abs());
                assert!(error < 3e-6, "{weights:?}, receiver {r}: {a:?} against {b:?}");
            }
        }
    }
}

/// The largest of a row's distances that rounding each weight to half a step can make, from the bases alone.
fn half_steps(table: &CompressedTable, row: usize) -> f64 {
    let steps = match table.weights().bits() {
        WeightBits::U8 => 255.0,
        _ => 65535.0,
    };
    let (width, count) = (table.width(), table.components() + 1);
    let bases = &table.bases()[usize::from(table.clusters()[row]) * count * width..][width..count * width];
    // Directions are orthogonal and as long as the range of their weights.
    bases.iter().map(|b| (f64::from(*b) * 0.5 / steps).powi(2)).sum::<f64>().sqrt()
}

#[test]
fn rounding_a_weight_moves_a_vector_by_at_most_half_a_step() {
    let transfer = cloth(24, 4, Channels::Gray);
    let (exact, _) = CompressedTransfer::new(&transfer, &options(8, 4), Job::default()).unwrap();
    for weights in [WeightBits::U16, WeightBits::U8] {
        let (found, report) =
            CompressedTransfer::new(&transfer, &options(8, 4).weights(weights), Job::default()).unwrap();
        let mut largest: f64 = 0.0;
        for r in 0..found.receivers() {
            let square = |(a, b): (&f32, &f32)| (f64::from(*a) - f64::from(*b)).powi(2);
            let distance = found.decode(r).iter().zip(&exact.decode(r)).map(square).sum::<f64>().sqrt();
            let bound = half_steps(found.table(), r);
            assert!(distance <= bound + 1e-6, "{weights:?}, receiver {r}: {distance} above {bound}");
            largest = largest.max(distance / (bound + 1e-6));
        }
        println!("{weights:?}: {report:?}, at most {largest} of half a step");
    }
}

#[test]
fn the_bytes_do_not_depend_on_the_number_of_threads() {
    let transfer = cloth(50, 4, Channels::Gray);
    let compressed = |threads| {
        with_threads(threads, || CompressedTransfer::new(&transfer, &options(12, 3), Job::default()).unwrap())
    };
    let (one, one_report) = compressed(1);
    for threads in [2, 3, 5] {
        let (other, report) = compressed(threads);
        assert_eq!(one, other, "{threads} threads");
        assert_eq!(one_report, report, "{threads} threads");
    }
    let light = light(4, 1);
    let shaded = |threads| with_threads(threads, || (one.exit_radiance(&light), transfer.exit_radiance(&light)));
    assert_eq!(shaded(1), shaded(3), "shading");
}

#[test]
fn degenerate_tables_are_compressed_like_others() {
    let report = |rows: &[f32], clusters, components| -> CompressReport {
        let (table, report) = compress_table(rows, 4, &options(clusters, components), Job::default()).unwrap();
        let error: f64 = table.decode().iter().zip(rows).map(|(a, b)| f64::from(a - b).powi(2)).sum();
        assert!((error - report.squared_error).abs() <= 1e-12, "{error} against {report:?}");
        report
    };
    assert_eq!(report(&[], 4, 2).squared_error, 0.0, "no rows");
    assert_eq!(report(&[0.0; 40], 4, 2).relative_error, 0.0, "zeros");
    let same = report(&[0.25; 40], 4, 2);
    assert_eq!((same.squared_error, same.clusters), (0.0, 1), "one row ten times");
    assert_eq!(report(&[1.0, 2.0, 3.0, 4.0], 4, 4).squared_error, 0.0, "one row");
    let two = [[1.0_f32, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0]].concat().repeat(9);
    assert_eq!(report(&two, 2, 0).squared_error, 0.0, "two rows nine times");
    let huge: Vec<f32> = two.iter().map(|x| x * 1e19).collect();
    assert_eq!(
        compress_table(&huge, 4, &options(2, 0), Job::default()).unwrap().1.relative_error,
        0.0,
        "large numbers"
    );
}

#[test]
fn tables_whose_rows_may_not_be_finite_are_refused() {
    let table = |weights, bases: Vec<f32>| CompressedTable::new(1, 1, vec![0, 1], weights, bases).map(|t| t.decode());
    let floats = |w: f32| TableWeights::F32(vec![0.0, w]);
    for (weights, bases, is_finite) in [
        (floats(1e3), vec![0.0, 0.0, 0.0, 3e38], false),
        (floats(-1.0), vec![0.0, 0.0, 3e38, 3e38], false),
        (floats(-1.0), vec![3e38, 3e38, 0.0, 3e38], false),
        (floats(1.0), vec![3e38, 0.0, 1e38, 2e38], true),
        (TableWeights::U8(vec![0, 255]), vec![0.0, 0.0, 3e38, 3e38], false),
        (TableWeights::U16(vec![0, 65535]), vec![0.0, 0.0, 1e38, 2e38], true),
    ] {
        match table(weights.clone(), bases.clone()) {
            Ok(rows) => assert!(is_finite && rows.iter().all(|x| x.is_finite()), "{weights:?}, {bases:?}: {rows:?}"),
            Err(error) => {
                let message = error.to_string();
                assert!(!is_finite && message.contains("exceed those of f32"), "{weights:?}, {bases:?}: {message}");
            }
        }
    }
}

#[test]
fn what_cannot_be_compressed_is_refused_in_one_line() {
    let refusal = |rows: &[f32], width, options: CompressOptions| {
        compress_table(rows, width, &options, Job::default()).unwrap_err().to_string()
    };
    assert_eq!(refusal(&[], 4, options(0, 2)), "expected 1 to 65536 clusters, found 0", "clusters");
    assert_eq!(refusal(&[0.0; 5], 4, options(1, 2)), "table: expected rows of 4 numbers, found 5 in all", "rows");
    assert_eq!(refusal(&[f32::NAN], 1, options(1, 0)), "table: expected finite numbers, found NaN in row 0", "NaN");
    let table = |width, clusters, weights| {
        CompressedTable::new(width, 1, clusters, TableWeights::F32(weights), vec![0.0; 8]).unwrap_err().to_string()
    };
    let weights = "compressed transfer: expected 1 weights for each of 1 receivers, found 2 in all";
    assert_eq!(table(2, vec![0], vec![0.0; 2]), weights, "weights");
    assert_eq!(table(4, vec![1], vec![0.0]), "compressed transfer: receiver 0 is in cluster 1 of 1", "cluster");
    let order = CompressedTransfer::from_table(
        2,
        Channels::Rgb,
        CompressedTable::new(4, 1, vec![0], TableWeights::F32(vec![0.0]), vec![0.0; 8]).unwrap(),
    );
    let message = "compressed transfer: expected vectors of 12 numbers, found 4";
    assert_eq!(order.unwrap_err().to_string(), message, "width");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn any_table_keeps_the_promises(
        values in prop::collection::vec(prop_oneof![4 => -2.0_f32..2.0, 1 => Just(0.5_f32)], 0..240),
        width in 1_usize..7,
        clusters in 1_usize..9,
        components in 0_usize..5,
    ) {
        let rows = &values[..values.len() / width * width];
        let bound = ROUNDING * energy(rows);
        let error = |clusters, components| compress_table(rows, width, &options(clusters, components), Job::default()).unwrap().1;
        let both = error(clusters, components);
        prop_assert!(both.squared_error <= error(1, components).squared_error + bound, "above PCA: {both:?}");
        prop_assert!(both.squared_error <= error(clusters, 0).squared_error + bound, "above VQ: {both:?}");
        prop_assert!(both.clusters <= clusters && both.components <= components, "{both:?}");
        if components >= width {
            prop_assert!(both.squared_error <= bound, "full rank: {both:?}");
        }
    }
}

#[test]
fn a_table_of_matrices_is_compressed_by_the_same_code() {
    // Rows of 81 numbers: outer products of the transfer vectors of order 3, as transfer matrices of a shiny surface
    // have.
    let transfer = cloth(20, 3, Channels::Gray);
    let outer = |t: &[f32]| t.iter().flat_map(|a| t.iter().map(move |b| a * b)).collect::<Vec<f32>>();
    let rows: Vec<f32> = transfer.coefficients().chunks(9).flat_map(outer).collect();
    let (table, report) = compress_table(&rows, 81, &options(6, 4), Job::default()).unwrap();
    println!("{report:?}");
    assert!(report.relative_error < 0.05 && table.width() == 81, "{report:?}");
    assert!(report.ratio > 5.0, "{} times smaller", report.ratio);
}

#[test]
fn more_components_than_numbers_are_refused_and_nothing_is_divided_by_none() {
    for components in [5, usize::MAX] {
        let refused =
            CompressedTable::new(4, components, vec![], TableWeights::F32(vec![]), vec![]).unwrap_err().to_string();
        let expected =
            format!("compressed transfer: expected at most 4 components, as many as numbers, found {components}");
        assert_eq!(refused, expected, "message");
    }
}
