//! How long a float panorama of 4096 x 2048 texels takes to become a cube of 1024, and how much memory.
//!
//! `RAYON_NUM_THREADS=2 /usr/bin/time -v target/release/examples/convert_large`

use std::time::Instant;

use lobe_env::{EnvError, MappedMap, Mapping, Resample, resample};
use lobe_sh::Rgb;

const WIDTH: usize = 4096;
const FACE: usize = 1024;

fn main() -> Result<(), EnvError> {
    let map = MappedMap::from_fn(Mapping::LatLong, WIDTH, WIDTH / 2, |s| {
        Rgb::new(1.0 + s.x() as f32, 2.0 + s.y() as f32, 1.5 + s.z() as f32)
    });
    let to = Resample::to(Mapping::Cube, FACE, Mapping::Cube.height_for(FACE));
    let start = Instant::now();
    let cube = resample(&map, &to)?;
    let seconds = start.elapsed().as_secs_f64();
    println!(
        "{WIDTH} x {} to a cube of {FACE} in {seconds:.2} s; mean {:?}, was {:?}",
        WIDTH / 2,
        cube.mean(),
        map.mean()
    );
    Ok(())
}
