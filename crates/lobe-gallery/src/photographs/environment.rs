//! Section about a photograph as it is.

use std::f64::consts::PI;

use lobe::env::lat_long;
use lobe::image::Tone;
use lobe::sh::Expansion as _;

use crate::error::Drawn;
use crate::page::{Canvas, Sky, digits, percent};

pub(crate) fn environment(canvas: &mut Canvas<'_>, sky: &Sky) -> Drawn {
    let (map, name) = (&sky.map, sky.bundled.name);
    let width = canvas.size.picture;
    let caption = "The whole sphere of directions: +z on top, +x in the center, -y to the right of it.";
    canvas.figure(&sky.file("environment.png"), (&sky.photograph(width), &Tone::PHOTOGRAPH), width, caption)?;

    let (x, y) = sky.brightest();
    let luminance = f64::from(map.texels()[y * map.width() + x].luminance());
    let solid_angle = lat_long::solid_angle(map.width(), map.height(), y);
    let mean = sky.radiance.mean();
    let share = luminance * solid_angle / (mean.luminance() * 4.0 * PI);
    let negative = map.texels().iter().filter(|c| c.to_array().iter().any(|x| *x < 0.0)).count();
    canvas.table(
        &["", ""],
        &[
            vec!["size".into(), format!("{} x {} texels", map.width(), map.height())],
            vec!["mean radiance, R G B".into(), [mean.r, mean.g, mean.b].map(digits).join("  ")],
            vec!["brightest luminance".into(), digits(luminance)],
            vec!["towards".into(), map.dir(x, y).to_array().map(digits).join("  ")],
            vec!["its one texel's share of all light".into(), percent(share)],
            vec!["negative texels".into(), negative.to_string()],
        ],
    );
    if negative > 0 {
        canvas.text(
            "Negative texels, dark rings around bright lights, are in the file: whoever resized it used a filter that \
             overshoots. Lobe keeps what it is given and says so.",
        );
    }
    canvas.command(&format!("lobe env info bundled:{name}"));
    Ok(())
}
