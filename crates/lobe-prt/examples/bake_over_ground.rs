//! Bakes a scene from a file, set on a ground, and says how long that took.
//!
//! `cargo run --release -p lobe-prt --example bake_over_ground -- bunny.obj 70000 2` splits edges until there are about
//! 70 000 vertices, a third of them in the ground, and bakes them with two bounces; with 0 it bakes shadows alone.

use std::error::Error;
use std::time::Instant;

use lobe_io::Job;
use lobe_prt::{BakeMode, BakeOptions, Receivers, bake};
use lobe_scene::{Bvh, Material, Mesh, MeshParts, Scene, SceneReadOptions, read_scene};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let file = arguments.next().ok_or("expected the name of a file")?;
    let vertices: usize = arguments.next().map_or(Ok(70_000), |n| n.parse())?;
    let bounces: usize = arguments.next().map_or(Ok(2), |n| n.parse())?;
    let (object, _) = read_scene(&file, &SceneReadOptions::default())?;
    let bounds = object.bounds();
    let mut edge = 0.5 * (bounds.max[0] - bounds.min[0]);
    let mut split = object;
    while split.vertex_count() < vertices * 2 / 3 {
        split = split.split_edges(edge)?;
        edge *= 0.93;
    }
    let scene = over_ground(split, vertices / 3)?;
    let start = Instant::now();
    let bvh = Bvh::new(&scene);
    let receivers = Receivers::at_vertices(&scene)?;
    let (count, triangles) = (receivers.len(), scene.triangle_count());
    println!("{count} vertices, {triangles} triangles, tree in {:.2} s", start.elapsed().as_secs_f64());
    let mode = if bounces == 0 { BakeMode::Shadowed } else { BakeMode::Interreflected };
    let options = BakeOptions::default().mode(mode).bounces(bounces).energy_stop(0.0);
    let (_, report) = bake(&scene, &bvh, &receivers, &options, Job::default())?;
    let rate = report.rays as f64 / report.seconds / 1e6;
    println!("order 4, 1024 samples, {bounces} bounces: {rate:.2} million rays/s, {report:?}");
    Ok(())
}

/// The scene above a square of four times its width, of about `vertices` vertices.
fn over_ground(scene: Scene, vertices: usize) -> Result<Scene, Box<dyn Error>> {
    let (bounds, origin) = (scene.bounds(), scene.origin());
    let (mut meshes, mut materials, textures) = scene.into_parts();
    let cells = (vertices as f32).sqrt() as u32;
    let side = 4.0 * (bounds.max[0] - bounds.min[0]).max(bounds.max[1] - bounds.min[1]);
    let corner = [0, 1].map(|k| 0.5 * (bounds.min[k] + bounds.max[k] - side));
    let mut ground = MeshParts { name: "ground".to_string(), material: Some(materials.len()), ..MeshParts::default() };
    for i in 0..=cells {
        for j in 0..=cells {
            let at = |k: usize, n: u32| corner[k] + side * n as f32 / cells as f32;
            ground.positions.push([at(0, i), at(1, j), bounds.min[2]]);
            if i < cells && j < cells {
                let a = i * (cells + 1) + j;
                ground.triangles.extend([[a, a + cells + 1, a + 1], [a + 1, a + cells + 1, a + cells + 2]]);
            }
        }
    }
    materials.push(Material::matte("ground", [0.6, 0.5, 0.4]));
    meshes.push(Mesh::new(ground)?);
    Ok(Scene::new(meshes, materials, textures)?.moved(origin))
}
