//! Section about light that is turned about the vertical.

use std::f64::consts::TAU;

use lobe::figures::Ball;
use lobe::image::Tone;
use lobe::render::View;
use lobe::sh::sphere::even_directions;
use lobe::sh::{Dir, Expansion as _, Rgb, Rotation, ShVec, Zonal};

use crate::error::Drawn;
use crate::page::{BACKDROP, Canvas, Sky, digits, sheet};

/// Pictures in the strip, one every 45°.
const STEPS: usize = 8;

/// The order of the light that is turned: above the closed forms.
const ORDER: usize = 5;

/// Directions in which the turned light is compared with the old.
const SAMPLES: usize = 500;

pub(crate) fn rotation(canvas: &mut Canvas<'_>, sky: &Sky) -> Drawn {
    let name = sky.bundled.name;
    let irradiance = sky.radiance.resized(ORDER).convolved(&Zonal::clamped_cosine(ORDER));
    let ball = Ball::new(canvas.size.ball * 3 / 4).seen(View::three_quarter());
    let mut balls = Vec::new();
    let mut error = 0.0_f64;
    for step in 0..STEPS {
        let turn = Rotation::from_axis_angle(Dir::Z, (step as f64 / STEPS as f64) * TAU);
        let turned = irradiance.rotated(&turn);
        balls.push(ball.lit_by_sh(BACKDROP, &turned));
        error = error.max(largest_error(&irradiance, &turned, &turn));
    }
    let tone = Tone::OBJECT.fixed_for(&balls[0]);
    let strip = sheet(STEPS, 4, BACKDROP, &balls);
    let caption = "the light turned about +z by 0°, 45°, 90°, .. 315°";
    canvas.figure(&sky.file("rotation.png"), (&strip, &tone), strip.width(), caption)?;
    canvas.text(&format!(
        "Turning coefficients is exact, here the {} of order 5: between the turned expansion and the old one looked up in the \
         direction turned back, the largest difference over all normals and turns is {} of the mean irradiance.",
        ORDER * ORDER,
        digits(error / irradiance.mean().luminance())
    ));
    canvas.command(&format!("lobe sh rotate {name}.sh.json --axis 0,0,1 --angle 45 -o turned.sh.json"));
    Ok(())
}

/// The largest `|g(s) - f(R⁻¹ s)|` over directions everywhere and all channels.
fn largest_error(f: &ShVec<Rgb<f64>>, g: &ShVec<Rgb<f64>>, turn: &Rotation) -> f64 {
    let back = turn.inverse();
    even_directions(SAMPLES)
        .map(|s| {
            let difference = g.eval(s) - f.eval(back.rotate_dir(s));
            difference.to_array().iter().fold(0.0, |largest, d| d.abs().max(largest))
        })
        .fold(0.0, f64::max)
}
