//! A white ball under a photograph: by nine coefficients, by every texel, and how far the two are apart.
//!
//! `cargo run -p lobe --example 02_light_a_ball`

use std::error::Error;

use lobe::env::{bundled, irradiance_at, project_env};
use lobe::figures::Ball;
use lobe::image::{Sheet, Tone, compare, error_map};
use lobe::sh::{Dir, Rgb, Zonal};

pub(crate) fn main() -> Result<(), Box<dyn Error>> {
    let sky = bundled::sunset().map();
    let (ball, black) = (Ball::new(96), Rgb::new(0.0, 0.0, 0.0));

    // Irradiance for every normal at once: each band of the light times one number, π, 2π/3, π/4.
    let irradiance = project_env(&sky, 3).convolved(&Zonal::clamped_cosine(3));
    let fast = ball.lit_by_sh(black, &irradiance);

    // The truth: for each pixel's normal the sum over all texels.
    let normals: Vec<Dir> = ball.normals().into_iter().map(|(_, n)| n).collect();
    let truth = ball.lit_by_values(black, &irradiance_at(&sky, &normals));

    let error = compare(fast.pixels(), truth.pixels());
    println!("relative RMS error {:.2} %, at most {:.4}", 100.0 * error.relative_rmse, error.max_abs);
    assert!(error.relative_rmse < 0.03, "{error:?}");

    let path = std::env::temp_dir().join("lobe-example-02.png");
    let difference = error_map(&fast, &truth, error.max_abs)?;
    let tone = Tone::PLAIN;
    let sheet = Sheet { columns: 3, margin: 8, background: [1.0; 3] };
    sheet.compose(&[tone.apply(&fast), tone.apply(&truth), difference]).write_png(&path, &tone)?;
    println!("the ball by nine coefficients, by every texel, and the difference: {}", path.display());
    Ok(())
}
