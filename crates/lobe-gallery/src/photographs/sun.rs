//! Section about a photograph whose sun is taken out.

use lobe::env::{SunOptions, extract_sun};
use lobe::image::{Picture, Tone};
use lobe::sh::Rgb;

use crate::error::Drawn;
use crate::page::{Canvas, Sky, digits, percent};

/// The section, of a photograph with a sun.
pub(crate) fn sun(canvas: &mut Canvas<'_>, sky: &Sky) -> Drawn {
    let (name, width) = (sky.bundled.name, canvas.size.picture);
    canvas.step()?;
    let Some(report) = extract_sun(&sky.map, &SunOptions::default()) else { unreachable!("{name} has a sun") };
    let rest = report.rest.into_env_map()?;
    let tone = Tone::PHOTOGRAPH.fixed_for(&Picture::from(&rest));
    let picture = Picture::from(&rest).resized(width, width / 2);
    canvas.figure(&sky.file("without-sun.png"), (&picture, &tone), width, "The sky without its sun.")?;
    let sun = report.sun;
    let [before, after] = [sky.map.mean(), rest.mean()].map(Rgb::luminance);
    canvas.table(
        &["the sun", ""],
        &[
            vec!["towards".into(), sun.direction.to_array().map(digits).join("  ")],
            vec!["irradiance facing it, R G B".into(), sun.irradiance.to_array().map(digits).join("  ")],
            vec!["diameter".into(), format!("{}°", digits(sun.angular_diameter.to_degrees()))],
            vec!["its share of all light".into(), percent(1.0 - after / before)],
        ],
    );
    canvas.command(&format!("lobe env sun bundled:{name} -o sky-without-sun.exr"));
    Ok(())
}
