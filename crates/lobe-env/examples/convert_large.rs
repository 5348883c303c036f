//! Time and memory of the conversion of a panorama to a cube of 1024, step by step.
//!
//! `RAYON_NUM_THREADS=2 /usr/bin/time -v target/release/examples/convert_large [IN [OUT]..]`
//!
//! IN is a lat-long picture; without it, a float panorama of 4096 x 2048 texels is made, with a sun as photographs have
//! it, of 672 texels that hold half of all light. Each OUT is a .ktx2, a .dds, or a picture, which becomes a cross.

use std::path::Path;
use std::time::Instant;

use lobe_env::{
    CubeHandedness, CubeLayout, CubeMap, CubeMipChain, CubeWriteOptions, EnvError, EnvMap, Mapping,
    PictureWriteOptions, Resample, resample, write_cube,
};
use lobe_image::write_picture;
use lobe_io::Job;
use lobe_sh::{Coefficient as _, Dir, Rgb};

/// The allocator of the command-line program.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

const WIDTH: usize = 4096;
const FACE: usize = 1024;

fn main() -> Result<(), EnvError> {
    let mut files = std::env::args().skip(1);
    let map = match files.next() {
        Some(file) => timed(&format!("read {file}"), || EnvMap::load(&file))?,
        None => EnvMap::from_fn(WIDTH, WIDTH / 2, sky_with_sun),
    };
    let to = Resample::to(Mapping::Cube, FACE, Mapping::Cube.height_for(FACE));
    let name = format!("{} x {} to a cube of {FACE}", map.width(), map.height());
    let mean = map.mean();
    let cube = timed(&name, || resample(map, &to, Job::default()))?;
    println!("mean {:?}, was {:?}", cube.mean(), mean);
    let cube = cube.into_cube_map()?;
    for file in files {
        timed(&format!("write {file}"), || write(Path::new(&file), &cube))?;
    }
    Ok(())
}

fn sky_with_sun(s: Dir) -> Rgb<f32> {
    const COS_OF_RADIUS: f64 = 0.99985;
    let sky = Rgb::new(1.0 + s.x() as f32, 2.0 + s.y() as f32, 1.5 + s.z() as f32);
    if s.x() * 0.6 + s.z() * 0.8 > COS_OF_RADIUS { sky + Rgb::splat(2e4) } else { sky }
}

fn timed<T>(what: &str, work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let result = work();
    println!("{:6.2} s  {what}", start.elapsed().as_secs_f64());
    result
}

fn write(file: &Path, cube: &CubeMap) -> Result<(), EnvError> {
    if file.extension().is_some_and(|extension| extension == "ktx2" || extension == "dds") {
        write_cube(file, &CubeMipChain::single(cube.clone()), &CubeWriteOptions::default())?;
        return Ok(());
    }
    let picture = cube.to_picture(CubeLayout::HorizontalCross, CubeHandedness::Right);
    write_picture(file, &picture, &PictureWriteOptions::default())?;
    Ok(())
}
