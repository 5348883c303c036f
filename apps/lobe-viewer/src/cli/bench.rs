//! Measurement of the passes of a frame.

use std::path::Path;

use lobe::scene::built_in;
use lobe_gpu::{BenchReport, PassTime, SceneViewOptions, ViewOutput};
use serde_json::json;

use crate::cli::args::Arguments;
use crate::cli::exponentials::{SPHERES, measure};
use crate::cli::prepared::{Prepared, prepare};
use crate::loading::scene_source::{self, OpenedScene, open_scene_for};

/// The size of a picture that is measured without another choice.
const SIZE: [u32; 2] = [1280, 720];

/// Runs of which the least time of each pass is kept.
const RUNS: usize = 10;

/// Frames over which the rate is the mean, at least.
const FRAMES: usize = 30;

/// Measures, and prints a table or JSON.
pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let opened = match arguments.cells {
        Some(cells) => OpenedScene::of_built_in("still-life", built_in::still_life(usize::from(cells))),
        None => {
            let source = arguments.scene.as_deref().unwrap_or(Path::new(scene_source::FIRST));
            open_scene_for(source, &arguments.limits, arguments.surfaces())?
        }
    };
    let (size, rays) = (arguments.size.unwrap_or(SIZE), arguments.rays.unwrap_or(1));
    // As the window draws what moves.
    let options = SceneViewOptions::default().width(size[0]).height(size[1]).rays(u32::from(rays));
    let options = options.shadow_side(arguments.shadow_side);
    let Prepared { context, view, light, suns, order, vertices, name, .. } =
        prepare(arguments, opened, &options.output(ViewOutput::Display))?;
    let rate = BenchReport::frames_per_second(&view, &light, FRAMES.max(usize::from(arguments.frames)))?;
    let report = BenchReport::of_view(&view, RUNS)?;
    let copied = BenchReport::copied_bytes_a_second(&context)?;
    let receivers = arguments.receivers as usize;
    let shadows = (receivers > 0).then(|| measure(&context, order, receivers)).transpose()?;
    let mode = arguments.mode.name();
    let floor = |bytes: u64| 1e3 * bytes as f64 / copied;
    let [width, height] = size;
    if arguments.json {
        let pass = |pass: &PassTime| {
            json!({
                "name": pass.name, "ms": pass.milliseconds, "bytes": pass.bytes, "floor_ms": floor(pass.bytes)
            })
        };
        let shadows = shadows.map(|found| {
            json!({
                "spheres": SPHERES, "receivers": receivers, "order": order, "ms": found.milliseconds, "bytes": found.bytes(),
                "floor_ms": floor(found.bytes()), "passes": found.passes.iter().map(pass).collect::<Vec<_>>()
            })
        });
        let text = json!({
            "machine": report.device, "scene": name, "vertices": vertices, "order": order,
            "mode": mode, "suns": suns, "size": size, "rays": rays, "frames_per_second": rate,
            "passes": report.passes.iter().map(pass).collect::<Vec<_>>(),
            "exponentials": shadows, "copied_bytes_per_second": copied,
        });
        println!("{text}");
        return Ok(());
    }
    print!("{report}");
    let bytes: u64 = report.passes.iter().map(|pass| pass.bytes).sum();
    let speed = 1e-9 * copied;
    println!(
        "floor of all passes: {:.3} ms, {:.3} MB at the {speed:.1} GB/s of a copy",
        floor(bytes),
        1e-6 * bytes as f64
    );
    println!("{name}: {vertices} vertices, {mode}, order {order}, {width} x {height}, {rays} x {rays} samples a pixel");
    if suns > 0 {
        println!("suns beside the expansion: {suns}, shadows of {0} x {0} texels", options.shadow_side);
    }
    println!("{rate:.1} frames a second with the sky turning");
    if let Some(found) = shadows {
        println!(
            "exponentials of {SPHERES} spheres at {receivers} receivers, order {order}: {:.3} ms; floor {:.3} ms, {:.3} MB",
            found.milliseconds,
            floor(found.bytes()),
            1e-6 * found.bytes() as f64
        );
        for PassTime { name, milliseconds, .. } in &found.passes {
            println!("  {name}: {} ms", milliseconds.map_or_else(|| "-".to_owned(), |ms| format!("{ms:.3}")));
        }
    }
    Ok(())
}
