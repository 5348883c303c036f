//! The same picture by transfer and by paths of light, and whether the difference is noise.
//!
//! `cargo run --release -p lobe --example 10_trace_the_truth`

use std::error::Error;

use lobe::env::{bundled, project_env};
use lobe::io::Job;
use lobe::prt::{BakeOptions, Mode, Receivers, bake};
use lobe::render::{
    Camera, DistantLight, PathOptions, SampleCount, Tone, TruthOptions, ViewOptions, compare, render_truth, scene_picture,
};
use lobe::scene::{Bvh, built_in};
use lobe::sh::Expansion as _;

pub(crate) fn main() -> Result<(), Box<dyn Error>> {
    let scene = built_in::ball_over_ground(24);
    let (bvh, receivers) = (Bvh::new(&scene), Receivers::at_vertices(&scene)?);
    let camera = Camera::look_at([10.0, -11.0, 4.5], [0.0, 0.0, 1.6], 18_f64.to_radians()).ok_or("no direction")?;
    let (width, height) = (64, 48);

    // Both are lit by the same function: the expansion of order 4.
    let light = project_env(&bundled::studio().map(), 4);
    let options = BakeOptions::default().mode(Mode::Shadowed).order(4).samples(256);
    let (transfer, _) = bake(&scene, &bvh, &receivers, &options, Job::default())?;
    let colors = transfer.exit_radiance(light.coefficients());
    let view = ViewOptions::default().width(width).height(height);
    let background = |s| light.eval(s);
    let fast = scene_picture(&scene, &bvh, &camera, &view, background, |hit| hit.at_corners(&colors), Job::default())?;

    let paths = PathOptions::default().bounces(0);
    let options = TruthOptions::default().width(width).height(height).count(SampleCount::of(64)).paths(paths);
    let truth = render_truth(&scene, &bvh, &camera, &DistantLight::from_expansion(light.clone()), &options, Job::default())?;

    let error = compare(fast.pixels(), truth.mean.pixels());
    println!("by transfer and by paths: {:.1} % apart (RMS)", 100.0 * error.relative_rmse);
    assert!(error.relative_rmse < 0.2, "{error:?}");
    for (name, picture) in [("transfer", &fast), ("truth", &truth.mean)] {
        let path = std::env::temp_dir().join(format!("lobe-example-10-{name}.png"));
        picture.write_png(&path, &Tone::PLAIN)?;
        println!("{}", path.display());
    }
    Ok(())
}
