//! A lat-long picture as a cube of six faces and as an octahedron; the light in them stays the same.
//!
//! `cargo run -p lobe --example 06_convert_a_map`

use std::error::Error;

use lobe::env::{
    CubeMipChain, CubeWriteOptions, MapReadOptions, Mapping, Resample, bundled, project_map, read_map, resample,
    write_cube,
};
use lobe::io::Job;

pub(crate) fn main() -> Result<(), Box<dyn Error>> {
    let sky = bundled::studio().map();
    let expected = project_map(&sky, 3);
    for (mapping, width) in [(Mapping::Cube, 64), (Mapping::Octahedral, 128), (Mapping::EqualArea, 128)] {
        let map = resample(&sky, &Resample::to(mapping, width, mapping.height_for(width)), Job::default())?;
        let light = project_map(&map, 3);
        let largest = (0..9).map(|i| (light[i].g - expected[i].g).abs()).fold(0.0, f64::max);
        println!(
            "{mapping:12} {:4} x {:4}: mean {:.5}, coefficients within {largest:.1e}",
            map.width(),
            map.height(),
            map.mean().g
        );
        assert!((map.mean().g - sky.mean().g).abs() < 1e-4 * sky.mean().g, "the energy stays");
        assert!(largest < 2e-3 * expected[0].g, "{largest} of {}", expected[0].g);
    }

    // As a texture for graphics hardware: six faces, half floats, all levels.
    let cube = resample(&sky, &Resample::to(Mapping::Cube, 64, 6 * 64), Job::default())?.into_cube_map()?;
    let path = std::env::temp_dir().join("lobe-example-06.ktx2");
    write_cube(&path, &CubeMipChain::averaged(cube), &CubeWriteOptions::default())?;
    let chain = read_map(&path, &MapReadOptions::default())?.0.into_chain()?;
    println!("{}: {} levels", path.display(), chain.levels().len());
    assert_eq!(chain.levels().len(), 7, "64, 32, .. 1");
    Ok(())
}
