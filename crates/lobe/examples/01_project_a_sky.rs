//! A photographed sunset as nine colors, and what they keep of it.
//!
//! `cargo run -p lobe --example 01_project_a_sky`

use std::error::Error;

use lobe::env::{bundled, project_env};
use lobe::sh::basis::band_and_m;
use lobe::sh::{Dir, Expansion as _};

pub(crate) fn main() -> Result<(), Box<dyn Error>> {
    let sky = bundled::sunset().map();
    println!("{} x {} texels, mean radiance {:?}", sky.width(), sky.height(), sky.mean().to_array());

    // Every texel counts with its solid angle: the integral of the picture times each basis function.
    let light = project_env(&sky, 3);
    for (i, color) in light.coefficients().iter().enumerate() {
        let (l, m) = band_and_m(i);
        println!("l {l}, m {m:2}: {:8.4} {:8.4} {:8.4}", color.r, color.g, color.b);
    }

    // Coefficient 0 is the mean times √4π, whatever the order.
    let (kept, whole) = (light.mean(), sky.mean());
    assert!((kept.g - whole.g).abs() < 1e-6 * whole.g, "{kept:?} against {whole:?}");

    for (name, s) in [("up", Dir::Z), ("down", -Dir::Z), ("towards +x", Dir::X), ("towards -x", -Dir::X)] {
        let color = light.eval(s);
        println!("{name:10} {:7.3} {:7.3} {:7.3}", color.r, color.g, color.b);
    }
    let (up, down) = (light.eval(Dir::Z), light.eval(-Dir::Z));
    assert!(up.b > down.b, "the sky is bluer than the ground: {up:?} against {down:?}");
    Ok(())
}
