//! Transfer at 48 numbers for a vertex in a few bytes, in a file that any glTF viewer opens.
//!
//! `cargo run --release -p lobe --example 09_compress_and_ship`

use std::error::Error;

use lobe::env::{bundled, project_env};
use lobe::image::compare;
use lobe::io::Job;
use lobe::prt::{
    BakeMode, BakeOptions, BakedGlb, CompressOptions, CompressedTransfer, Receivers, Recipe, WeightBits, bake,
    read_baked,
};
use lobe::scene::{Bvh, SceneReadOptions, built_in};
use lobe::sh::Expansion as _;

pub(crate) fn main() -> Result<(), Box<dyn Error>> {
    let scene = built_in::ball_over_ground(16);
    let receivers = Receivers::at_vertices(&scene)?;
    let options = BakeOptions::default().mode(BakeMode::Shadowed).order(4).samples(64);
    let (transfer, _) = bake(&scene, &Bvh::new(&scene), &receivers, &options, Job::default())?;
    let light = project_env(&bundled::sunset().map(), 4);
    let plain = transfer.exit_radiance(light.coefficients());

    for (clusters, components) in [(1, 4), (8, 4), (8, 8)] {
        let options = CompressOptions::default().clusters(clusters).components(components).weights(WeightBits::U8);
        let (compressed, report) = CompressedTransfer::new(&transfer, &options, Job::default())?;
        let seen = compare(&compressed.exit_radiance(light.coefficients()), &plain).relative_rmse;
        println!(
            "{clusters} clusters, {components} components: {:.1} times fewer bytes, error {:.1} % of the transfer, {:.1} % of its light",
            report.ratio,
            100.0 * report.relative_error,
            100.0 * seen,
        );
        assert!(seen < 0.2, "{seen}");
    }

    let (compressed, _) = CompressedTransfer::new(&transfer, &CompressOptions::default().clusters(8), Job::default())?;
    let path = std::env::temp_dir().join("lobe-example-09.glb");
    BakedGlb::of_scene(&scene).write_compressed(&path, &compressed, &Recipe::default())?;
    let baked = read_baked(&path, &SceneReadOptions::default())?;
    println!("{}: order {}, {} vertices", path.display(), baked.transfer.order(), baked.transfer.receivers());
    assert_eq!(baked.compressed, Some(compressed), "what was written is read");
    Ok(())
}
