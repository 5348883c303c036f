//! Environment section of the demo: the photograph.

use lobe::env::lat_long;
use lobe::image::{Picture, Tone};
use lobe::sh::Expansion as _;

use super::{Sky, Writer, digits};

impl Writer<'_> {
    pub(super) fn environment(&mut self, sky: &Sky) -> anyhow::Result<()> {
        let (map, name) = (&sky.map, sky.bundled.name);
        let file = sky.file("environment.png");
        let picture = Picture::from(map).resized(self.picture, self.picture / 2);
        self.write(&file, &picture, &Tone::PHOTOGRAPH)?;

        let luminance = |i: usize| f64::from(map.texels()[i].luminance());
        let brightest = (0..map.texels().len()).max_by(|a, b| luminance(*a).total_cmp(&luminance(*b))).unwrap_or(0);
        let (x, y) = (brightest % map.width(), brightest / map.width());
        let s = map.dir(x, y);
        let solid_angle = lat_long::solid_angle(map.width(), map.height(), y);
        let mean = sky.radiance.mean();
        let share = luminance(brightest) * solid_angle / (mean.luminance() * 4.0 * std::f64::consts::PI);

        let negative = map.texels().iter().filter(|c| c.to_array().iter().any(|x| *x < 0.0)).count();

        self.page.section(&format!("A photograph: {}", sky.bundled.title));
        self.page.figure(
            &file,
            self.picture,
            "The whole sphere of directions: +z on top, +x in the center, -y to the right of it.",
        );
        self.page.table(
            &["", ""],
            &[
                vec!["size".into(), format!("{} x {} texels", map.width(), map.height())],
                vec!["mean radiance, R G B".into(), [mean.r, mean.g, mean.b].map(digits).join("  ")],
                vec!["brightest luminance".into(), digits(luminance(brightest))],
                vec!["towards".into(), s.to_array().map(digits).join("  ")],
                vec!["its one texel's share of all light".into(), format!("{} %", digits(100.0 * share))],
                vec!["negative texels".into(), negative.to_string()],
            ],
        );
        if negative > 0 {
            self.page.text(
                "Negative texels, dark rings around bright lights, are in the file: whoever resized it used a filter that \
                 overshoots. Lobe keeps what it is given and says so.",
            );
        }
        self.page.command(&format!("lobe env info bundled:{name}"));
        Ok(())
    }
}
