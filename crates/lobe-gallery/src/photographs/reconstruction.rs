//! Section about the photograph from its first bands.

use std::f64::consts::PI;

use lobe::env::lat_long::solid_angle;
use lobe::figures::lat_long_picture_of;
use lobe::sh::expansion::Quantity;
use lobe::sh::sh_json::{ShFile, write_sh_json};

use crate::error::Drawn;
use crate::page::{Canvas, SWEEP, Sky, digits, energy, percent, values_like};

pub(crate) fn reconstruction(canvas: &mut Canvas<'_>, sky: &Sky) -> Drawn {
    let name = sky.bundled.name;
    // For the reader's own use.
    let path = canvas.begin_file(&format!("{name}.sh.json"))?;
    write_sh_json(path, &ShFile::new(Quantity::Radiance, sky.radiance.clone()))?;
    canvas.text(
        "The same photograph from its expansion of order n, n² coefficients a channel. Low orders see only where \
         the light comes from; black patches are where the expansion rings below zero. \
         Most of the squared radiance sits in small lights, which no low order keeps; irradiance, below, hardly misses it.",
    );
    let width = canvas.size.picture * 35 / 64; // four to a row of the page
    let caption = "the photograph at the exposure of the others";
    canvas.figure(&sky.file("same-exposure.png"), (&sky.photograph(width), &sky.tone), width, caption)?;
    let whole = energy_of_map(sky);
    let mut rows = Vec::new();
    for order in 1..=SWEEP {
        let f = sky.radiance.resized(order);
        let picture = lat_long_picture_of(width, width / 2, &f);
        let caption = format!("order {order}, n² = {}", order * order);
        canvas.figure(&sky.file(&format!("order-{order}.png")), (&picture, &sky.tone), width, &caption)?;

        let kept = energy(&f);
        let lowest = values_like(&f, &sky.map).iter().map(|c| c.luminance()).fold(f32::INFINITY, f32::min);
        rows.push(vec![
            order.to_string(),
            (order * order).to_string(),
            percent(kept / whole),
            digits(((whole - kept) / (3.0 * 4.0 * PI)).sqrt()),
            digits(f64::from(lowest)),
        ]);
    }
    let head = ["order", "coefficients", "squared radiance kept", "RMS difference of a channel", "lowest luminance"];
    canvas.table(&head, &rows);
    canvas.command(&format!(
        "lobe project bundled:{name} --order {SWEEP} -o {name}.sh.json\nlobe env reconstruct {name}.sh.json -o {name}-{SWEEP}.exr"
    ));
    Ok(())
}

/// `∫ L² ds` of the map, all channels.
fn energy_of_map(sky: &Sky) -> f64 {
    let map = &sky.map;
    let solid_angle = |i: usize| solid_angle(map.width(), map.height(), i / map.width());
    let squares = map.texels().iter().map(|c| c.to_array().map(|x| f64::from(x).powi(2)).iter().sum::<f64>());
    squares.enumerate().map(|(i, square)| square * solid_angle(i)).sum()
}
