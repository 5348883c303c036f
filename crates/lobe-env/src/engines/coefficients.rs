//! Nine colors of a light as the files and the lists of numbers that engines read.

use lobe_sh::encoding::EngineForm;
use lobe_sh::{Rgb, ShL2};
use serde_json::json;

/// The 27 numbers of a radiance in a form, with an ending behind each that a language asks for.
pub(crate) fn list(form: EngineForm, light: &ShL2<Rgb<f64>>, ending: &str) -> String {
    // The programs of engines compute with these digits.
    let numbers = form.flat(&form.encode(light)).map(|x| format!("{:?}{ending}", x as f32));
    let rows: Vec<String> = numbers.chunks(if form.is_planar() { 9 } else { 3 }).map(|row| row.join(", ")).collect();
    rows.join(",\n    ")
}

/// The file of a form: for three.js the JSON of a `LightProbe`, for Filament the lines of its tool, for others JSON of
/// our own.
pub(crate) fn file(form: EngineForm, light: &ShL2<Rgb<f64>>) -> String {
    let colors = form.encode(light);
    let numbers = form.flat(&colors);
    match form {
        EngineForm::Three => light_probe(&numbers),
        EngineForm::Filament => {
            let line = |(place, Rgb { r, g, b }): (&str, Rgb<f64>)| format!("({r:?}, {g:?}, {b:?}); // {place}\n");
            form.places().into_iter().zip(colors).map(line).collect()
        }
        _ => {
            let of = form.quantity();
            let order = if form.is_planar() { "channel after channel" } else { "three channels of each" };
            pretty(
                &json!({ "form": form.name(), "of": of, "order": order, "places": form.places(), "numbers": numbers.to_vec() }),
            )
        }
    }
}

/// What `LightProbe.toJSON` of three.js writes, and its `ObjectLoader` reads.
fn light_probe(numbers: &[f64; 27]) -> String {
    // A number of its own for each light: the first digits of its colors.
    let bits = |k: usize| numbers[k].to_bits() >> 16;
    let uuid = format!(
        "{:08x}-{:04x}-4{:03x}-8{:03x}-{:012x}",
        bits(0) & 0xffff_ffff,
        bits(3) & 0xffff,
        bits(6) & 0xfff,
        bits(9) & 0xfff,
        bits(12)
    );
    let metadata = json!({ "version": 4.7, "type": "Object", "generator": "lobe" });
    let object =
        json!({ "uuid": uuid, "type": "LightProbe", "color": 0xff_ffff, "intensity": 1, "sh": numbers.to_vec() });
    pretty(&json!({ "metadata": metadata, "object": object }))
}

fn pretty(value: &serde_json::Value) -> String {
    format!("{value:#}\n")
}
