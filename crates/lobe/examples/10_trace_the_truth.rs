//! The same picture by transfer and by paths of light, and how far the two are apart.
//!
//! `cargo run --release -p lobe --example 10_trace_the_truth`

use std::error::Error;

use lobe::env::{bundled, project_env};
use lobe::image::{Tone, compare};
use lobe::io::Job;
use lobe::prt::{BakeMode, BakeOptions};
use lobe::render::{
    BakedScene, Camera, DistantLight, PathOptions, SampleCount, TruthOptions, ViewOptions, light_baked_scene,
    render_truth,
};
use lobe::scene::built_in;
use lobe::sh::Expansion as _;

pub(crate) fn main() -> Result<(), Box<dyn Error>> {
    let (width, height) = (64, 48);
    let camera = Camera::look_at([10.0, -11.0, 4.5], [0.0, 0.0, 1.6], 18_f64.to_radians()).ok_or("no direction")?;

    // Both are lit by the same function: the expansion of order 4.
    let light = project_env(&bundled::sunset().map(), 4);
    let options = BakeOptions::default().mode(BakeMode::Shadowed).order(4).samples(256);
    let baked = BakedScene::bake(built_in::ball_over_ground(24), &options, None, Job::default())?;
    let view = ViewOptions::default().width(width).height(height);
    let fast =
        light_baked_scene(&baked, &light.clone().into(), &camera, &view, |s| light.eval(s), Job::default())?.picture;

    // Shadows without interreflections, as the bake: no bounces.
    let paths = PathOptions::default().bounces(0);
    let options = TruthOptions::default().width(width).height(height).count(SampleCount::of(64)).paths(paths);
    let source = DistantLight::from_expansion(light.clone());
    let truth = render_truth(baked.scene(), baked.bvh(), &camera, &source, &options, Job::default())?;

    let error = compare(fast.pixels(), truth.mean.pixels());
    println!("by transfer and by paths: {:.1} % apart (RMS)", 100.0 * error.relative_rmse);
    for (name, picture) in [("transfer", &fast), ("truth", &truth.mean)] {
        let path = std::env::temp_dir().join(format!("lobe-example-10-{name}.png"));
        picture.write_png(&path, &Tone::PLAIN)?;
        println!("{}", path.display());
    }
    assert!(error.relative_rmse < 0.1, "{error:?}");
    Ok(())
}
