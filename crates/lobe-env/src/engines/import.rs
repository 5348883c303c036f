//! Coefficients of engines, read back as the light that they are of.

use lobe_image::{ImageError, ktx_sh};
use lobe_sh::encoding::EngineForm;
use lobe_sh::{Rgb, ShL2};
use serde_json::Value;

use crate::error::EnvError;
use crate::files::babylon_env::{is_babylon_env, light_of_babylon_env};

/// The first bytes of KTX of version 1.
const KTX: &[u8] = b"\xabKTX 11";

/// Numbers of three bands in color.
const COUNT: usize = 27;

/// The radiance, in Lobe's frame, whose nine colors a file holds in the form of an engine; `name` stands for the file
/// in messages.
///
/// * **text**: 27 numbers, as a line for each color or in one; words, brackets, separators and what stands behind `//`
///   or `#` are left out. `cmgen` (`sh.txt`) and `lobe sh encode` write such lines.
/// * **JSON**: the first list of 27 numbers, or of nine times three, that stands anywhere in it: `LightProbe.toJSON` of
///   three.js, `lobe export`, `lobe sh encode --json`.
/// * **.ktx** of Filament's tool or of Lobe: its key `sh`.
/// * **.env** of Babylon.js: its polynomial.
///
/// The last two say themselves what they hold, and are read by [`EngineForm::Filament`] and [`EngineForm::Babylon`]
/// only. What Lobe writes and a `LightProbe` name their form, too, and no other is taken.
///
/// # Errors
/// [`EnvError::Image`] if there are no 27 numbers; [`EnvError::Options`] for a form that the file has not.
pub fn import_coefficients(bytes: &[u8], form: EngineForm, name: &str) -> Result<ShL2<Rgb<f64>>, EnvError> {
    let of_file = |own: EngineForm, kind: &str| {
        if own == form { Ok(()) } else { Err(EnvError::Options(format!("{name}: {kind} is of {own}, not of {form}"))) }
    };
    if is_babylon_env(bytes) {
        of_file(EngineForm::Babylon, "a .env")?;
        return light_of_babylon_env(bytes, name);
    }
    if bytes.starts_with(KTX) {
        of_file(EngineForm::Filament, "the key sh of a .ktx")?;
        let none = || invalid(name, "a .ktx with the key sh expected, but this one has none".into());
        let colors = ktx_sh(bytes, name)?.ok_or_else(none)?;
        return Ok(form.decode(&colors.map(Rgb::from)));
    }
    let text = str::from_utf8(bytes).map_err(|_| invalid(name, "text, a .ktx or a .env expected".into()))?;
    let text = text.trim_start_matches('\u{feff}');
    let (said, numbers) = match text.trim_start().starts_with(['{', '[']).then(|| serde_json::from_str(text)) {
        Some(Ok(value)) => (said_by_json(&value), of_json(&value).unwrap_or_default()),
        _ => (said_by_heading(text), of_text(text)),
    };
    if let Some(said) = said.filter(|said| said != form.name()) {
        return Err(EnvError::Options(format!("{name}: says that it holds {said}, not {form}")));
    }
    match <[f64; COUNT]>::try_from(numbers) {
        Ok(numbers) if numbers.iter().all(|x| x.is_finite()) => Ok(form.decode(&form.colors(&numbers))),
        Ok(_) => Err(invalid(name, "a number is not finite".into())),
        Err(found) => Err(invalid(name, format!("nine colors, {COUNT} numbers, expected, found {}", found.len()))),
    }
}

fn invalid(name: &str, message: String) -> EnvError {
    ImageError::Invalid { place: name.to_owned(), message }.into()
}

/// What the heading of `lobe sh encode` has behind its name and count.
const HEADING: &str = " floats, of ";

/// The name of the form in such a heading.
fn said_by_heading(text: &str) -> Option<String> {
    let heading = text.lines().find(|line| line.contains(HEADING))?;
    heading.split(',').next().map(|said| said.trim().to_owned())
}

/// The name of the form that JSON of ours or a `LightProbe` says it holds.
fn said_by_json(value: &Value) -> Option<String> {
    let ours = value["form"].as_str().or(value["encoding"].as_str());
    let is_probe = [value, &value["object"]].iter().any(|object| object["type"] == "LightProbe");
    ours.or(is_probe.then(|| EngineForm::Three.name())).map(str::to_owned)
}

/// The numbers of a text, line by line; those of C# may end in f. A line that names its numbers, as ours do, has words
/// in front of them.
fn of_text(text: &str) -> Vec<f64> {
    let mut numbers = Vec::new();
    for line in text.lines() {
        let line = line.split("//").next().unwrap_or_default().split('#').next().unwrap_or_default();
        let is_heading = line.contains(HEADING);
        let words = line.split(|c: char| c.is_whitespace() || ",;()[]{}".contains(c)).filter(|word| !word.is_empty());
        numbers.extend(words.filter(|_| !is_heading).filter_map(number));
    }
    numbers
}

/// A word that is a number: it begins as one, unlike the words nan and inf.
fn number(word: &str) -> Option<f64> {
    let begins = word.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
    word.trim_end_matches(['f', 'F']).parse().ok().filter(|_| begins)
}

/// The first list of 27 numbers, or of lists or objects with them, from the outside in.
fn of_json(value: &Value) -> Option<Vec<f64>> {
    if let Value::Array(items) = value {
        let numbers: Vec<f64> = items.iter().flat_map(flat).collect();
        if numbers.len() == COUNT {
            return Some(numbers);
        }
    }
    match value {
        Value::Array(items) => items.iter().find_map(of_json),
        Value::Object(entries) => entries.values().find_map(of_json),
        _ => None,
    }
}

/// The numbers of a value: itself, or those of a list, or of the list `values` of an object.
fn flat(value: &Value) -> Vec<f64> {
    match value {
        Value::Number(number) => number.as_f64().into_iter().collect(),
        Value::Array(items) => items.iter().flat_map(flat).collect(),
        Value::Object(entries) => entries.get("values").map(flat).unwrap_or_default(),
        _ => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use lobe_sh::Expansion as _;
    use lobe_testkit::Random;

    use super::*;
    use crate::engines::coefficients;

    fn light() -> ShL2<Rgb<f64>> {
        let values = Random::new(11).signed_vec(COUNT);
        ShL2::from(std::array::from_fn(|i| Rgb::new(values[3 * i], values[3 * i + 1], values[3 * i + 2])))
    }

    fn expect(found: &ShL2<Rgb<f64>>, most: f64, what: &str) {
        for (i, (a, b)) in found.coefficients().iter().zip(light().coefficients()).enumerate() {
            let error = (*a - *b).to_array().into_iter().fold(0.0, |worst: f64, e| worst.max(e.abs()));
            assert!(error <= most, "{what}, coefficient {i}: {a:?}, expected {b:?}");
        }
    }

    #[test]
    fn every_form_comes_back_from_its_file() {
        for form in EngineForm::ALL {
            let file = coefficients::file(form, &light());
            expect(&import_coefficients(file.as_bytes(), form, "test").unwrap(), 1e-15, form.name());
            // Snippets have the digits of f32.
            let list = coefficients::list(form, &light(), "");
            expect(&import_coefficients(list.as_bytes(), form, "test").unwrap(), 1e-6, form.name());
        }
    }

    #[test]
    fn lines_of_other_tools_are_read_without_their_remarks() {
        let form = EngineForm::Filament;
        let colors = form.encode(&light());
        let lines: String = (0..9)
            .map(|i| {
                let [r, g, b] = colors[i].to_array();
                format!("({r:?}, {g:?}, {b:?}); // L{i}, irradiance, pre-scaled base 3\n")
            })
            .collect();
        expect(&import_coefficients(lines.as_bytes(), form, "test").unwrap(), 1e-15, "a remark with a number");
        let rows: Vec<Vec<f64>> = colors.iter().map(|color| color.to_array().to_vec()).collect();
        let nested = serde_json::json!({ "a": [1, 2], "b": { "coefficients": rows } }).to_string();
        expect(&import_coefficients(nested.as_bytes(), form, "test").unwrap(), 1e-15, "nested JSON");
    }

    #[test]
    fn what_names_its_form_is_taken_for_no_other() {
        let error = |text: &str| import_coefficients(text.as_bytes(), EngineForm::Unity, "a").unwrap_err().to_string();
        let numbers = "1 ".repeat(COUNT);
        assert_eq!(
            error(&format!("packed, 27 floats, of E/pi, y up\n{numbers}")),
            "a: says that it holds packed, not unity"
        );
        for form in [EngineForm::Three, EngineForm::Godot] {
            let found = error(&coefficients::file(form, &light()));
            assert_eq!(found, format!("a: says that it holds {form}, not unity"), "{form}");
        }
    }

    #[test]
    fn what_holds_no_nine_colors_is_refused_with_their_number() {
        let error = |bytes: &[u8]| import_coefficients(bytes, EngineForm::Three, "test").unwrap_err().to_string();
        assert_eq!(error(b"1 2 3"), "test: nine colors, 27 numbers, expected, found 3");
        assert_eq!(error(b"{\"sh\": [1, 2]}"), "test: nine colors, 27 numbers, expected, found 0");
        assert_eq!(error(b"nan inf 1 2f -3.5F"), "test: nine colors, 27 numbers, expected, found 3");
        assert_eq!(error(b"\xff\xfe"), "test: text, a .ktx or a .env expected");
        let infinite = format!("1e999 {}", "1 ".repeat(COUNT - 1));
        assert_eq!(error(infinite.as_bytes()), "test: a number is not finite");
    }
}
