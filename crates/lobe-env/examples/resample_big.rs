//! Times the conversion of a large lat-long map to a cube.
use lobe_env::{EnvMap, Mapping, Resample, resample};
use lobe_sh::Rgb;
fn main() {
    let map = EnvMap::from_fn(4096, 2048, |s| Rgb::new(s.x() as f32 + 1.0, 1.0, 0.5));
    let start = std::time::Instant::now();
    let cube = resample(&map, &Resample::to(Mapping::Cube, 1024, 6144)).map(|m| m.texels()[5]);
    println!("{:?} {cube:?}", start.elapsed());
}
