//! Reconstruction section of the demo: the photograph from its first bands.

use std::f64::consts::PI;

use lobe::image::Picture;
use lobe::render::lat_long_picture_of;

use super::{SWEEP, Sky, Writer, digits, energy, values_like};

impl Writer<'_> {
    pub(super) fn reconstruction(&mut self, sky: &Sky) -> anyhow::Result<()> {
        let name = sky.bundled.name;
        self.page.section(&format!("{name}: what n² numbers remember"));
        self.page.text(
            "The same photograph from its expansion of order n, n² coefficients a channel. Low orders see only where \
             the light comes from; black patches are where the expansion rings below zero. \
             Most of the squared radiance sits in small lights, which no low order keeps; irradiance, below, hardly misses it.",
        );
        let width = self.picture * 35 / 64; // four to a row of the page
        let file = sky.file("same-exposure.png");
        self.write(&file, &Picture::from(&sky.map).resized(width, width / 2), &sky.tone)?;
        self.page.figure(&file, width, "the photograph at the exposure of the others");
        let whole = energy_of_map(sky);
        let mut rows = Vec::new();
        for order in 1..=SWEEP {
            let f = sky.radiance.resized(order);
            let file = sky.file(&format!("order-{order}.png"));
            self.write(&file, &lat_long_picture_of(width, width / 2, &f), &sky.tone)?;
            let caption = format!("order {order}, n² = {}", order * order);
            self.page.figure(&file, width, &caption);

            let kept = energy(&f);
            let lowest = values_like(&f, &sky.map).iter().map(|c| c.luminance()).fold(f32::INFINITY, f32::min);
            rows.push(vec![
                order.to_string(),
                (order * order).to_string(),
                format!("{} %", digits(100.0 * kept / whole)),
                digits(((whole - kept) / (3.0 * 4.0 * PI)).sqrt()),
                digits(f64::from(lowest)),
            ]);
        }
        let head =
            ["order", "coefficients", "squared radiance kept", "RMS difference of a channel", "lowest luminance"];
        self.page.table(&head, &rows);
        self.page.command(&format!(
            "lobe project bundled:{name} --order {SWEEP} -o {name}.sh.json\nlobe env reconstruct {name}.sh.json -o {name}-{SWEEP}.exr"
        ));
        Ok(())
    }
}

/// `∫ L² ds` of the map, all channels.
fn energy_of_map(sky: &Sky) -> f64 {
    let map = &sky.map;
    let solid_angle = |i: usize| lobe::env::lat_long::solid_angle(map.width(), map.height(), i / map.width());
    let squares = map.texels().iter().map(|c| c.to_array().map(|x| f64::from(x).powi(2)).iter().sum::<f64>());
    squares.enumerate().map(|(i, square)| square * solid_angle(i)).sum()
}
