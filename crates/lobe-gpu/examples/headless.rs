//! A baked built-in scene under a turning sky, as a picture, with what each pass takes.
//!
//! ```sh
//! cargo run --release -p lobe-gpu --example headless -- OUT.png [FRAMES]
//! ```

use std::process::ExitCode;

use lobe_gpu::{
    BenchReport, Context, ContextOptions, Environment, GpuCamera, SceneView, SceneViewOptions, Storage, SurfaceShading,
    TurntableOptions, write_turntable,
};
use lobe_io::Job;
use lobe_prt::{BakeOptions, Receivers, bake};
use lobe_scene::{Bvh, built_in};
use lobe_sh::Dir;

const ORDER: usize = 4;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let Some(path) = arguments.first() else {
        eprintln!("usage: headless OUT.png [FRAMES]");
        return ExitCode::from(2);
    };
    let frames = arguments.get(1).and_then(|frames| frames.parse().ok()).unwrap_or(1);
    match run(path, frames) {
        Ok(report) => {
            print!("{report}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(2)
        }
    }
}

fn run(path: &str, frames: usize) -> Result<BenchReport, Box<dyn std::error::Error>> {
    let scene = built_in::columns_hall(6);
    let receivers = Receivers::at_vertices(&scene)?;
    let options = BakeOptions::default().order(ORDER).samples(128);
    let (transfer, _) = bake(&scene, &Bvh::new(&scene), &receivers, &options, Job::default())?;
    let sky = lobe_env::bundled::sunset().map();
    let context = Context::new(&ContextOptions::default())?;
    let shading = SurfaceShading::Vertices(&transfer, Storage::F32);
    let view_options = SceneViewOptions::default().width(640).height(400);
    let view = SceneView::new(&context, &scene, &shading, Some(&Environment::from(&*sky)), &view_options)?;
    let camera = GpuCamera::framing(scene.world_bounds(), Dir::from_angles(1.15, 0.6), 0.3);
    view.set_camera(&camera.ok_or("the angle is in range")?)?;
    print!("{}", view.renderer());
    let turntable = TurntableOptions::default().frames(frames);
    write_turntable(&view, &lobe_env::project_env(&sky, ORDER), &turntable, path, Job::default())?;
    Ok(BenchReport::of_view(&view, 5)?)
}
