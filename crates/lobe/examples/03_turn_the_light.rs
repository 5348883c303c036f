//! A day in 24 steps: light is turned without its picture, and the floor tells the time.
//!
//! `cargo run -p lobe --example 03_turn_the_light`

use std::error::Error;
use std::f64::consts::{PI, TAU};

use lobe::env::{bundled, project_env};
use lobe::sh::{Coefficient as _, Dir, Expansion as _, Rotation, Zonal};

pub(crate) fn main() -> Result<(), Box<dyn Error>> {
    let light = project_env(&bundled::sunset().map(), 4);
    let wall = Dir::X;
    let mut seen = Vec::new();
    for hour in 0..24_u32 {
        // The function turns about +z: what it showed towards s it shows towards R s.
        let turn = Rotation::from_axis_angle(Dir::Z, TAU * f64::from(hour) / 24.0);
        let turned = light.rotated(&turn);
        let lit = turned.convolved(&Zonal::clamped_cosine(4)).eval(wall).scale(1.0 / PI);
        println!("{hour:2} h  {:6.3} {:6.3} {:6.3}  {}", lit.r, lit.g, lit.b, "#".repeat((30.0 * lit.r) as usize));
        seen.push(lit.r);
    }
    // A rotation keeps the energy of each band, and a turn of the light is one of the wall the other way.
    let back = Rotation::from_axis_angle(Dir::Z, -TAU / 4.0).rotate_dir(wall);
    let expected = light.convolved(&Zonal::clamped_cosine(4)).eval(back).r / PI;
    assert!((seen[6] - expected).abs() < 1e-12, "{} against {expected}", seen[6]);
    Ok(())
}
