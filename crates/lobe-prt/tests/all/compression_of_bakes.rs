//! Clustered principal components on the transfer of real scenes.

use std::path::Path;

use crate::common::{baked, options};
use lobe_io::Job;
use lobe_prt::{
    BakeMode, CompressOptions, CompressedTransfer, Receivers, Transfer, compress_table, compress_table_within,
    error_curve,
};
use lobe_scene::{Scene, SceneReadOptions, built_in, read_scene};

/// The part of a sum of squares that roundings to `f32` leave: of the rows, the bases and the weights.
const ROUNDING: f64 = 1e-12;

/// The number of vertices of each scene that are compressed.
const RECEIVERS: usize = 500;

/// Transfer of order 3 with one bounce, at vertices spread over all of a scene.
fn transfer_of(scene: &Scene) -> Transfer {
    let all = Receivers::at_vertices(scene).unwrap();
    let pick = |v: &[[f32; 3]]| (0..RECEIVERS).map(|k| v[k * all.len() / RECEIVERS]).collect();
    let receivers = Receivers::new(pick(all.positions()), pick(all.normals()), pick(all.albedos())).unwrap();
    let options = options(BakeMode::Interreflected, 3, 64).bounces(1);
    baked(scene, &receivers, &options).0
}

fn energy(transfer: &Transfer) -> f64 {
    transfer.coefficients().iter().map(|t| f64::from(*t).powi(2)).sum()
}

/// A hall of columns and the head of a monkey.
fn bakes() -> [(&'static str, Transfer); 2] {
    let suzi = Path::new(env!("CARGO_MANIFEST_DIR")).join("../lobe-scene/assets/suzi.glb");
    let (suzi, _) = read_scene(suzi, &SceneReadOptions::default()).unwrap();
    [("hall", transfer_of(&built_in::columns_hall(1))), ("suzi", transfer_of(&suzi))]
}

#[test]
fn the_error_of_a_baked_scene_falls_with_clusters_and_components_to_zero_at_full_rank() {
    for (name, transfer) in bakes() {
        let width = transfer.coefficients().len() / transfer.receivers();
        let (clusters, components) = ([1, 4, 16], [0, 1, 2, 4, 8, width]);
        let bound = ROUNDING * energy(&transfer);
        let curve =
            error_curve(&transfer, &clusters, &components, &CompressOptions::default(), Job::default()).unwrap();
        println!("{name}: {} receivers of {width} numbers", transfer.receivers());
        for (i, point) in curve.iter().enumerate() {
            let (clusters, components) = (point.clusters, point.components);
            println!("  {clusters:3} x {components:2}: {:.2e}, {} bytes", point.relative_error, point.bytes);
            let before = [i.checked_sub(1).filter(|_| clusters > 1), i.checked_sub(3)];
            for fewer in before.into_iter().flatten().map(|i| curve[i]) {
                assert!(point.squared_error <= fewer.squared_error + bound, "{name}: {fewer:?} then {point:?}");
            }
            assert!(components < width || point.squared_error < bound, "{name}: at full rank {point:?}");
        }
        let whole = CompressOptions::default().clusters(4).components(width);
        let (_, report) = CompressedTransfer::new(&transfer, &whole, Job::default()).unwrap();
        assert!(report.squared_error < bound, "{name}: decoded at full rank {report:?}");
    }
}

#[test]
fn neither_pca_nor_vq_of_a_baked_scene_is_better_at_equal_cost() {
    for (name, transfer) in bakes() {
        let (rows, count) = (transfer.coefficients(), transfer.receivers());
        let width = rows.len() / count;
        for ratio in [2, 6] {
            let bytes = 4 * rows.len() / ratio;
            let base = CompressOptions::default();
            let (_, best) = compress_table_within(rows, width, bytes, &base, Job::default()).unwrap();
            let components = (0..=width).rev().find(|n| 4 * (count * n + (n + 1) * width) <= bytes).unwrap();
            let codes = (bytes - 2 * count) / (4 * width);
            // One cluster needs no numbers of clusters, which the files store all the same.
            for (kind, clusters, components, needless) in [("PCA", 1, components, 2 * count), ("VQ", codes, 0, 0)] {
                let options = base.clusters(clusters).components(components);
                let (_, other) = compress_table(rows, width, &options, Job::default()).unwrap();
                println!(
                    "{name} in {bytes} bytes: {} x {} {:.2e}, {kind} {clusters} x {components} {:.2e}",
                    best.clusters, best.components, best.relative_error, other.relative_error
                );
                assert!(other.bytes - needless <= bytes && best.bytes <= bytes, "{name}: {kind} costs {}", other.bytes);
                assert!(best.squared_error <= other.squared_error, "{name}: {best:?}, {kind} {other:?}");
            }
        }
    }
}
