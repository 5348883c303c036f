//! Two lamps and an even sky become nine numbers, and are found in them again.
//!
//! `cargo run -p lobe --example 05_find_the_lights`

use std::error::Error;

use lobe::sh::light::Normalization;
use lobe::sh::light_extraction::{LightFitOptions, LightMetric, extract_lights};
use lobe::sh::{Coefficient as _, Dir, Light, Rgb};

pub(crate) fn main() -> Result<(), Box<dyn Error>> {
    let order = 5;
    let [warm, cold] = [Dir::from_angles(0.6, 0.3), Dir::from_angles(1.2, 3.4)];
    let lights = [
        Light::Directional { dir: warm, color: Rgb::new(2.0, 1.5, 1.0) },
        Light::Directional { dir: cold, color: Rgb::new(0.4, 0.6, 1.0) },
        Light::Ambient { color: Rgb::splat(0.2) },
    ];
    let [a, b, c] = lights.map(|light| light.project(order, Normalization::Projected));
    let light = &(&a? + &b?) + &c?;

    let options = LightFitOptions::default().count(2).refine(true).metric(LightMetric::Radiance);
    let found = extract_lights(&light, &options)?;
    for light in &found.lights {
        let (theta, phi) = (light.dir.theta().to_degrees(), light.dir.phi().to_degrees());
        println!("a light at {theta:5.1}° from +z, azimuth {phi:6.1}°: {:.3?}", light.intensity.to_array());
    }
    println!("ambient {:.3?}", found.ambient.to_array());

    for planted in [warm, cold] {
        let nearest = found.lights.iter().map(|light| light.dir.angle_to(planted)).fold(f64::MAX, f64::min);
        assert!(nearest < 1e-3, "{planted:?} is missed by {nearest} rad: {found:?}");
    }
    assert!((found.ambient.g - 0.2).abs() < 1e-3, "{:?}", found.ambient);
    Ok(())
}
