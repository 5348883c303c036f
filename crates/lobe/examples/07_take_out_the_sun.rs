//! The sun as a light of its own, and the rest of the sky as levels for rough mirrors.
//!
//! `cargo run -p lobe --example 07_take_out_the_sun`

use std::error::Error;

use lobe::env::{
    Mapping, PrefilterOptions, Resample, SunOptions, bundled, extract_sun, irradiance_sh, prefilter_ggx, resample,
};
use lobe::io::Job;
use lobe::sh::{Dir, Expansion as _};

pub(crate) fn main() -> Result<(), Box<dyn Error>> {
    let sky = bundled::sunset().map();
    let report = extract_sun(&sky, &SunOptions::default()).ok_or("there is no sun in the picture")?;
    let sun = report.sun;
    println!("the sun stands {:.1}° above the horizon", 90.0 - sun.direction.theta().to_degrees());
    println!("it is {:.2}° wide and brings {:.3?}", sun.angular_diameter.to_degrees(), sun.irradiance.to_array());

    // Irradiance of the ground: what the sun brings and what the rest brings is what all brings.
    let (all, rest) = (irradiance_sh(&sky, 5).eval(Dir::Z), irradiance_sh(&report.rest, 5).eval(Dir::Z));
    let together = rest.g + sun.irradiance_at(Dir::Z).g;
    println!("on the ground {:.4} with all in coefficients, {together:.4} with the sun apart", all.g);
    assert!((together / all.g - 1.0).abs() < 0.2, "{together} against {}", all.g);

    // Without the sun the levels have no bright disc that grows from level to level.
    let cube = resample(&report.rest, &Resample::to(Mapping::Cube, 32, 6 * 32), Job::default())?.into_cube_map()?;
    let options = PrefilterOptions::default().size(32).last_size(4);
    let chain = prefilter_ggx(&cube, &options, Job::default())?;
    for (k, level) in chain.levels().iter().enumerate() {
        let alpha = options.alpha_of_level(k);
        println!("level {k}: {:2} texels, α {alpha:.3}, up {:.3?}", level.size(), level.radiance(Dir::Z).to_array());
    }
    assert_eq!(chain.levels().len(), 4, "32, 16, 8, 4");
    Ok(())
}
