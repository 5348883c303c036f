//! Irradiance section of the demo: a white ball under the sky, by spherical harmonics and by brute force.

use lobe::env::{irradiance_at, irradiance_map_brute_force};
use lobe::image::{Picture, Tone, color_bar, compare, error_map};
use lobe::io::Job;
use lobe::render::{Ball, View};
use lobe::sh::{Dir, Rgb, Zonal};

use super::{BACKDROP, SWEEP, Sky, Writer, digits, values_like};

/// The order that irradiance is usually stored at: nine coefficients.
const USUAL: usize = 3;

/// Rows of the grid of normals over which errors are measured.
const GRID: usize = 48;

impl Writer<'_> {
    /// Returns the balls as they are shown: by harmonics, by brute force, their difference.
    pub(super) fn irradiance(&mut self, sky: &Sky) -> anyhow::Result<[Picture; 3]> {
        let name = sky.bundled.name;
        self.page.section(&format!("{name}: nine numbers light a ball"));
        self.page.text(
            "A white Lambertian ball leaves E(n)/π. On the left E comes from nine coefficients a channel, in the middle \
             from a sum over every texel of the photograph for every pixel of the ball; on the right their difference.",
        );
        let irradiance = sky.radiance.resized(USUAL).convolved(&Zonal::clamped_cosine(USUAL));
        let ball = Ball::new(self.ball).seen(beside(sky.main_direction()));
        let normals: Vec<Dir> = ball.normals().into_iter().map(|(_, n)| n).collect();
        let truth = ball.lit_by_values(BACKDROP, &irradiance_at(&sky.map, &normals));
        let claim = ball.lit_by_sh(BACKDROP, &irradiance);
        let tone = Tone::OBJECT.fixed_for(&truth);
        let report = compare(claim.pixels(), truth.pixels());
        let width = self.ball * 4 / 3;

        let file = sky.file("ball-sh.png");
        self.write(&file, &claim, &tone)?;
        self.page.figure(&file, width, "order 3, 9 coefficients");
        let file = sky.file("ball-truth.png");
        self.write(&file, &truth, &tone)?;
        self.page.figure(&file, width, &format!("brute force, {} texels", sky.map.texels().len()));
        let file = sky.file("ball-error.png");
        let difference = error_map(&claim, &truth, report.max_abs)?;
        self.write(&file, &with_bar(&difference, report.max_abs), &Tone::PLAIN)?;
        self.page.figure(&file, width, "difference of the radiance they leave, and its scale");
        self.irradiance_table(sky)?;
        self.page.command(&format!(
            "lobe env irradiance bundled:{name} --order 3 -o {name}-irradiance.exr\n\
             lobe env irradiance bundled:{name} --method brute-force -o {name}-truth.exr"
        ));
        Ok([tone.apply(&claim), tone.apply(&truth), difference])
    }

    fn irradiance_table(&mut self, sky: &Sky) -> anyhow::Result<()> {
        (self.progress)("irradiance over the whole sphere, orders 1 to 6");
        let truth = irradiance_map_brute_force(&sky.map, 2 * GRID, GRID, Job::default())?;
        let peak = truth.texels().iter().flat_map(|c| c.to_array()).fold(0.0, f32::max);
        let rows: Vec<Vec<String>> = (1..=SWEEP)
            .map(|order| {
                let e = sky.radiance.resized(order).convolved(&Zonal::clamped_cosine(order));
                let values = values_like(&e, &truth);
                let report = compare(&values, truth.texels());
                let lowest = values.iter().flat_map(|c| c.to_array()).fold(f32::INFINITY, f32::min);
                vec![
                    order.to_string(),
                    (order * order).to_string(),
                    format!("{} %", digits(100.0 * report.relative_rmse)),
                    format!("{} %", digits(100.0 * report.max_abs / f64::from(peak))),
                    digits(f64::from(lowest)),
                ]
            })
            .collect();
        let head = ["order", "coefficients", "RMS error / mean", "largest error / peak", "lowest irradiance"];
        self.page.table(&head, &rows);
        self.page.text(
            "Measured towards all normals, not only those that the picture shows. Order 4 equals order 3 because the clamped \
             cosine has no band 3. A lowest irradiance below zero is ringing.",
        );
        Ok(())
    }
}

/// An error map with the scale of its colors below.
fn with_bar(map: &Picture, full_scale: f64) -> Picture {
    let height = map.height() / 7;
    let white = Rgb::new(1.0, 1.0, 1.0);
    let mut picture = Picture::filled(map.width(), map.height() + height, BACKDROP);
    picture.paste(map, 0, 0);
    picture.paste(&color_bar(map.width(), height, full_scale, white, BACKDROP), 0, map.height() as isize);
    picture
}

/// A view that shows the lit and the dark side: 60° round from the light, a little from above.
fn beside(light: Dir) -> View {
    View::from_eye(Dir::from_angles(75.0_f64.to_radians(), light.phi() + 60.0_f64.to_radians()))
}
