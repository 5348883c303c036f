//! A sun of order 3 makes the far side darker than black; four cures and their price.
//!
//! `cargo run -p lobe --example 04_remove_ringing`

use std::error::Error;

use lobe::sh::extrema::certified_minimum;
use lobe::sh::ringing::DeringOptions;
use lobe::sh::{Dir, Expansion as _, ShVec, Window, Zonal};

pub(crate) fn main() -> Result<(), Box<dyn Error>> {
    let sun = ShVec::<f64>::impulse(3, Dir::X, 1.0);
    let irradiance = sun.convolved(&Zonal::clamped_cosine(3));
    let report = |name: &str, f: &ShVec<f64>| {
        // Not sampled but proven: nothing is below `lo`.
        let least = certified_minimum(f.coefficients(), 1e-9);
        println!("{name:20} facing {:.3}, least {:+.4}", f.eval(Dir::X), least.lo);
        least
    };

    let before = report("as it is", &irradiance);
    assert!(before.hi < -0.03, "it rings: {before:?}");

    report("Hanning, width 4", &irradiance.windowed(&Window::Hanning { width: 4.0 }));
    report("Gauss, 20°", &irradiance.windowed(&Window::Gauss { sigma: 20_f64.to_radians() }));
    report("for punctual lights", &irradiance.windowed(&Window::PunctualLight));

    let (calm, removed) = irradiance.deringed_with(&DeringOptions::default());
    let after = report("the least change", &calm);
    println!("factors of the bands {:.4?}, {:.1} % of the energy", removed.factors, 100.0 * removed.energy_removed);
    assert!(after.lo > -1e-6, "{after:?}");
    assert!((calm.mean() - irradiance.mean()).abs() < 1e-15, "the mean stays");
    Ok(())
}
