//! Where a higher order is farther from the truth, why, and what a window does about it.

use lobe::render::{Curve2d, Picture, Tone, Truth, error_map};
use lobe::sh::{Coefficient as _, Expansion as _, Rgb, ShVec};

use super::lights::{BLACK, BLUE};
use super::transfer::{Hall, about_z, calmed};
use super::{SWEEP, Sky, Writer, digits, values_like};

/// What comes of light of one order.
struct Row {
    order: usize,
    plain: Found,
    calm: Found,
}

/// What comes of a light.
struct Found {
    psnr: f64,
    /// The lowest radiance of the light over its mean.
    lowest: f64,
    /// The part of the hall that sends less than nothing, in percent.
    below_zero: f64,
}

impl Writer<'_> {
    /// The hall of another sky under one that rings in it.
    pub(super) fn transfer_that_rings(&mut self, sky: &Sky, hall: &Hall) -> anyhow::Result<()> {
        let name = sky.bundled.name;
        self.page.section(&format!("{name}: light that rings in the hall"));
        (self.progress)("light that rings");
        let truth = hall.truth(sky, &about_z(0.0))?;
        let row = |order: usize| {
            let light = sky.radiance.resized(order);
            let [plain, calm] = [&light, &calmed(&light)].map(|light| Found::of(light, sky, hall, &truth));
            Row { order, plain, calm }
        };
        let rows: Vec<Row> = (1..=SWEEP).map(row).collect();
        let gain = |k: &usize| rows[*k].plain.psnr - rows[*k - 1].plain.psnr;
        let Some(worst) = (1..SWEEP).min_by(|a, b| gain(a).total_cmp(&gain(b))) else { unreachable!("orders") };
        let Row { order, plain, calm } = &rows[worst];
        self.page.text(&format!(
            "The same hall under another sky, in which order {order} comes out {} dB {} than the order before. Nearly all light comes \
             from two lamps. What is cut off them swings below zero elsewhere, to {} times the mean of the light, and {} % of the \
             hall send less than nothing. The next bands push the trough to other places, whence the steps of the table. A window \
             (Hanning, zero one band above the order) leaves {} times the mean and {} % of the hall below zero; it costs contrast, \
             and so is worth its price where the plain light rings, at order {order}: {} dB instead of {}.",
            digits(gain(&worst).abs()),
            if gain(&worst) < 0.0 { "lower" } else { "higher" },
            digits(plain.lowest),
            digits(plain.below_zero),
            digits(calm.lowest),
            digits(calm.below_zero),
            digits(calm.psnr),
            digits(plain.psnr),
        ));
        self.ringing_figures(sky, hall, &truth, *order)?;
        self.ringing_plot(sky, &rows)?;
        self.ringing_table(&rows);
        self.page.command(&format!(
            "lobe render hall.glb --env bundled:{name} --mode interreflected --order {order} -o rings.exr\n\
             lobe render hall.glb --env bundled:{name} --mode interreflected --order {order} --window hanning:{} -o calm.exr\n\
             lobe compare calm.exr truth.exr",
            order + 1
        ));
        Ok(())
    }

    /// Plain and windowed, each with what is below zero of it, and the truth.
    fn ringing_figures(&mut self, sky: &Sky, hall: &Hall, truth: &Truth, order: usize) -> anyhow::Result<()> {
        let light = sky.radiance.resized(order);
        let tone = Tone::PHOTOGRAPH.fixed_for(&truth.mean);
        let mean =
            truth.mean.pixels().iter().map(|p| p.widen().luminance()).sum::<f64>() / truth.mean.pixels().len() as f64;
        for (what, light) in [("plain", &light), ("windowed", &calmed(&light))] {
            let picture = hall.picture(sky, &about_z(0.0), light)?;
            let above = picture.map(|p| Rgb::from(p.to_array().map(|c| c.max(0.0))));
            let below = error_map(&picture, &above, 0.5 * mean)?;
            self.hall_figure(
                sky,
                hall,
                (&format!("{what}-{order}"), &picture, &tone),
                &format!("order {order}, {what}"),
            )?;
            let caption = format!("order {order}, {what}: what is below zero, white at half of the mean");
            self.hall_figure(sky, hall, (&format!("{what}-{order}-below"), &below, &Tone::PLAIN), &caption)?;
        }
        self.hall_figure(sky, hall, ("truth", &truth.mean, &tone), "the truth: paths of light")
    }

    fn hall_figure(
        &mut self,
        sky: &Sky,
        hall: &Hall,
        (what, picture, tone): (&str, &Picture, &Tone),
        caption: &str,
    ) -> anyhow::Result<()> {
        let file = sky.file(&format!("hall-{what}.png"));
        self.write(&file, picture, tone)?;
        self.page.figure(&file, hall.size[0], caption);
        Ok(())
    }

    fn ringing_plot(&mut self, sky: &Sky, rows: &[Row]) -> anyhow::Result<()> {
        let curve = |label, colour, of: fn(&Row) -> &Found| {
            let points = rows.iter().map(|row| [row.order as f64, of(row).psnr]).collect();
            Curve2d { label, colour, dashed: false, points }
        };
        let curves = [curve("plain", BLACK, |row| &row.plain), curve("windowed", BLUE, |row| &row.calm)];
        let ends = ([1.0, SWEEP as f64], 1.0, "");
        self.line_plot(&sky.file("hall-psnr.svg"), ends, &curves, "peak signal-to-noise ratio in dB over the order")
    }

    fn ringing_table(&mut self, rows: &[Row]) {
        let db = |found: &Found| format!("{} dB", digits(found.psnr));
        let percent = |found: &Found| format!("{} %", digits(found.below_zero));
        let cells = |row: &Row| {
            let Row { order, plain, calm } = row;
            let lowest = [plain, calm].map(|found| digits(found.lowest));
            let [plain_lowest, calm_lowest] = lowest;
            vec![order.to_string(), db(plain), plain_lowest, percent(plain), db(calm), calm_lowest, percent(calm)]
        };
        let rows: Vec<_> = rows.iter().map(cells).collect();
        let head = [
            "order",
            "PSNR",
            "lowest light / mean",
            "hall below zero",
            "windowed",
            "lowest light / mean",
            "hall below zero",
        ];
        self.page.table(&head, &rows);
    }
}

impl Found {
    fn of(light: &ShVec<Rgb<f64>>, sky: &Sky, hall: &Hall, truth: &Truth) -> Self {
        let luminances = values_like(light, &sky.map).into_iter().map(|c| c.widen().luminance());
        let seen = hall.seen(light, 0.0, truth);
        let dark = seen.iter().filter(|c| c.widen().luminance() < 0.0).count();
        Self {
            psnr: hall.psnr(light, std::slice::from_ref(truth)),
            lowest: luminances.fold(f64::INFINITY, f64::min) / light.mean().luminance(),
            below_zero: 100.0 * dark as f64 / seen.len() as f64,
        }
    }
}
