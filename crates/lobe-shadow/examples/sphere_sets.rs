//! Compares variational sphere sets with those of the medial axis.
//!
//! `cargo run --release -p lobe-shadow --example sphere_sets -- bunny.obj suzi.glb` prints a table for the files and
//! for a torus and a star made by formula: the summed outside volume over the volume of the solid by the variational
//! method, by the medial axis as published with as many and with twice as many spheres, and by the medial axis when
//! its spheres shrink to their own points; whether half the spheres do no worse; and time and rounds of the
//! variational fit.

#[path = "../tests/all/shapes/mod.rs"]
mod shapes;

use std::error::Error;
use std::f64::consts::TAU;
use std::path::Path;
use std::time::Instant;

use lobe_io::Job;
use lobe_scene::{Mesh, MeshParts, Scene, SceneReadOptions, read_scene};
use lobe_shadow::{SphereFitMethod, SphereFitOptions, fit_spheres};

fn main() -> Result<(), Box<dyn Error>> {
    let mut scenes = Vec::new();
    for file in std::env::args().skip(1) {
        let (scene, _) = read_scene(&file, &SceneReadOptions::default())?;
        scenes.push((Path::new(&file).file_stem().unwrap_or_default().to_string_lossy().into_owned(), scene));
    }
    scenes.push(("torus".to_owned(), torus()?));
    scenes.push(("star".to_owned(), shapes::prongs()));
    println!(
        "mesh        n  variational  medial n  medial 2n  half suffice  shrunk n  shrunk 2n  half suffice  seconds  rounds  certainty"
    );
    for (name, scene) in &scenes {
        for count in [8, 16, 32, 64] {
            row(name, scene, count)?;
        }
    }
    Ok(())
}

fn row(name: &str, scene: &Scene, count: usize) -> Result<(), Box<dyn Error>> {
    let options = SphereFitOptions::default().count(count);
    let start = Instant::now();
    let (_, report) = fit_spheres(scene, &options, Job::default())?;
    let seconds = start.elapsed().as_secs_f64();
    let medial = |count: usize, shrink: bool| -> Result<f64, Box<dyn Error>> {
        let options = options.clone().count(count).method(SphereFitMethod::MedialAxis).shrink(shrink);
        let (_, report) = fit_spheres(scene, &options, Job::default())?;
        Ok(report.outside_volume / report.solid_volume)
    };
    let ours = report.outside_volume / report.solid_volume;
    print!("{name:10} {count:2}  {ours:11.4}");
    for shrink in [false, true] {
        let (same, twice) = (medial(count, shrink)?, medial(2 * count, shrink)?);
        print!("  {same:8.4}  {twice:9.4}  {:12}", if ours <= twice { "yes" } else { "no" });
    }
    println!("  {seconds:7.2}  {:6}  {:9.3}", report.history.len() - 1, report.certainty);
    Ok(())
}

/// A torus about the z axis, of radii 1 and 0.3.
fn torus() -> Result<Scene, Box<dyn Error>> {
    let (around, across) = (96_u32, 32_u32);
    let mut parts = MeshParts { name: "torus".to_owned(), ..MeshParts::default() };
    for i in 0..around {
        for j in 0..across {
            let (u, v) = (TAU * f64::from(i) / f64::from(around), TAU * f64::from(j) / f64::from(across));
            let r = 1.0 + 0.3 * v.cos();
            parts.positions.push([r * u.cos(), r * u.sin(), 0.3 * v.sin()].map(|x| x as f32));
            let at = |i: u32, j: u32| (i % around) * across + j % across;
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            parts.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    scene(parts)
}

fn scene(parts: MeshParts) -> Result<Scene, Box<dyn Error>> {
    Ok(Scene::new(vec![Mesh::new(parts)?], Vec::new(), Vec::new())?)
}
