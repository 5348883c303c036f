//! Rotation section of the demo: the light turned about the vertical.

use lobe::image::{Sheet, Tone};
use lobe::render::{Ball, View};
use lobe::sh::{Dir, Expansion as _, Rgb, Rotation, ShVec, Zonal, even_directions};

use super::{BACKDROP, Sky, Writer, digits};

/// Pictures in the strip, one every 45°.
const STEPS: usize = 8;

/// The order of the light that is turned: above the closed forms.
const ORDER: usize = 5;

impl Writer<'_> {
    pub(super) fn rotation(&mut self, sky: &Sky) -> anyhow::Result<()> {
        let name = sky.bundled.name;
        let irradiance = sky.radiance.resized(ORDER).convolved(&Zonal::clamped_cosine(ORDER));
        let ball = Ball::new(self.ball * 3 / 4).seen(View::three_quarter());
        let mut balls = Vec::new();
        let mut error = 0.0_f64;
        for step in 0..STEPS {
            let turn = Rotation::from_axis_angle(Dir::Z, (step as f64 / STEPS as f64) * std::f64::consts::TAU);
            let turned = irradiance.rotated(&turn);
            balls.push(ball.lit_by_sh(BACKDROP, &turned));
            error = error.max(largest_error(&irradiance, &turned, &turn));
        }
        let tone = Tone::OBJECT.fixed_for(&balls[0]);
        let file = sky.file("rotation.png");
        let sheet = Sheet { columns: STEPS, margin: 4, background: BACKDROP.into() }.compose(&balls);
        self.write(&file, &sheet, &tone)?;
        self.page.section(&format!("{name}: the sky turns, the numbers turn with it"));
        self.page.figure(&file, sheet.width(), "the light turned about +z by 0°, 45°, 90°, .. 315°");
        self.page.text(&format!(
            "Turning coefficients is exact, here the {} of order 5: between the turned expansion and the old one looked up in the \
             direction turned back, the largest difference over all normals and turns is {} of the mean irradiance.",
            ORDER * ORDER,
            digits(error / irradiance.mean().luminance())
        ));
        self.page.command(&format!("lobe sh rotate {name}.sh.json --axis 0,0,1 --angle 45 -o turned.sh.json"));
        Ok(())
    }
}

/// Directions in which the turned light is compared with the old.
const SAMPLES: usize = 500;

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
