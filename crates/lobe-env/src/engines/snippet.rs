//! Programs that load the files of a light into an engine, with the numbers of that light.
//!
//! A template has its places for numbers in double braces: `coefficients`, with an ending of each number as in
//! `coefficients:f`, `suns` as JSON in the engine's frame, `suns:rust` and `suns:csharp` as rows of numbers,
//! `suns:usda` as lights of a stage.

use lobe_sh::encoding::EngineFrame;
use lobe_sh::{Rgb, ShL2};
use serde_json::json;

use crate::engines::coefficients;
use crate::engines::engine::Engine;
use crate::engines::usd_lights::usd_lights;
use crate::sky::sun_extraction::Sun;

/// The program of an engine.
pub(crate) fn filled(engine: Engine, template: &str, light: &ShL2<Rgb<f64>>, suns: &[Sun]) -> String {
    let facts = engine.facts();
    let mut text = template.to_owned();
    let mut put = |place: &str, value: &str| text = text.replace(&format!("{{{{{place}}}}}"), value);
    if let Some(form) = facts.form {
        put("coefficients", &coefficients::list(form, light, ""));
        put("coefficients:f", &coefficients::list(form, light, "f"));
    }
    put("suns", &as_json(facts.frame, suns));
    put("suns:rust", &rows(facts.frame, suns, "", ["[", "]"]));
    put("suns:csharp", &rows(facts.frame, suns, "f", ["new[] { ", " }"]));
    put("suns:usda", &usd_lights(facts.frame, suns));
    put("version", env!("CARGO_PKG_VERSION"));
    text
}

/// Suns as a list that JavaScript, Python and the language of Godot read.
fn as_json(frame: EngineFrame, suns: &[Sun]) -> String {
    let one = |sun: &Sun| {
        let irradiance = sun.irradiance.to_array();
        let direction = frame.dir(sun.direction).to_array();
        json!({ "direction": direction, "irradiance": irradiance, "diameter": sun.angular_diameter.to_degrees() })
            .to_string()
    };
    let all: Vec<String> = suns.iter().map(one).collect();
    format!("[{}]", all.join(",\n  "))
}

/// Suns as rows of seven numbers: direction, irradiance, diameter in degrees.
fn rows(frame: EngineFrame, suns: &[Sun], ending: &str, [open, close]: [&str; 2]) -> String {
    let one = |sun: &Sun| {
        let diameter = [sun.angular_diameter.to_degrees()];
        let numbers = frame.dir(sun.direction).to_array().into_iter().chain(sun.irradiance.to_array()).chain(diameter);
        let numbers: Vec<String> = numbers.map(|x| format!("{:?}{ending}", x as f32)).collect();
        format!("{open}{}{close}", numbers.join(", "))
    };
    let all: Vec<String> = suns.iter().map(one).collect();
    all.join(",\n    ")
}
