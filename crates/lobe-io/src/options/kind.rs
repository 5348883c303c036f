//! Kinds of options: the values that one may have, as JSON and as text.

use std::f64::consts::PI;
use std::fmt::Write as _;

use serde_json::Value;

use crate::shard::Shard;

/// The values that an option may have.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum OptionKind {
    /// True or false, of which false is the default: to name it is to choose it.
    Flag,
    /// True or false, either of which may be the default: `on` or `off` as text.
    Switch,
    /// A whole number within a range.
    Whole {
        /// The least.
        least: u64,
        /// The most.
        most: u64,
        /// What is counted, with its article, such as "a number of texels".
        what: &'static str,
    },
    /// One of a few whole numbers.
    OneOf(&'static [u64]),
    /// A number.
    Number(NumberRange),
    /// As many whole numbers, each within a range.
    Wholes {
        /// How many.
        count: usize,
        /// The least.
        least: u64,
        /// The most.
        most: u64,
    },
    /// As many finite numbers.
    Numbers(usize),
    /// One of a few names, each with its meaning.
    Name(&'static [(&'static str, &'static str)]),
    /// Any text.
    Text,
    /// The path of a file.
    File,
    /// The paths of files, one or more.
    Files,
    /// A part of long work, see [`Shard`].
    Shard,
}

/// The range of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum NumberRange {
    /// Any finite number.
    Finite,
    /// A finite number above 0.
    Positive,
    /// From 0 to below 1.
    Part,
    /// From 0 to 1.
    Fraction,
    /// An angle above 0 and below 90 degrees.
    Acute,
    /// A solid angle from 0 to 4π steradians, that of the whole sphere.
    SolidAngle,
}

/// Why a value is refused.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Refusal {
    /// It is of another type; with what was expected and what was found.
    Type(String),
    /// It is out of its range; with the same.
    Range(String),
}

impl Refusal {
    /// What was expected and what was found.
    #[must_use]
    pub fn message(&self) -> &str {
        match self {
            Self::Type(message) | Self::Range(message) => message,
        }
    }
}

impl NumberRange {
    fn contains(self, x: f64) -> bool {
        match self {
            Self::Finite => x.is_finite(),
            Self::Positive => x.is_finite() && x > 0.0,
            Self::Part => (0.0..1.0).contains(&x),
            Self::Fraction => (0.0..=1.0).contains(&x),
            Self::Acute => x > 0.0 && x < 90.0,
            Self::SolidAngle => (0.0..=4.0 * PI).contains(&x),
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Finite => "a finite number",
            Self::Positive => "a number above 0",
            Self::Part => "a number from 0 to below 1",
            Self::Fraction => "a number from 0 to 1",
            Self::Acute => "an angle above 0 and below 90 degrees",
            Self::SolidAngle => "a solid angle from 0 to 4π steradians",
        }
    }
}

impl OptionKind {
    /// What is expected, in words.
    #[must_use]
    pub fn expected(&self) -> String {
        match self {
            Self::Flag => "true or false".to_owned(),
            Self::Switch => "on or off".to_owned(),
            Self::Whole { least, most, what } => format!("{what} from {least} to {most}"),
            Self::OneOf(numbers) => one_of(numbers.iter().map(u64::to_string)),
            Self::Number(range) => range.name().to_owned(),
            Self::Wholes { count, least, most } => format!("{count} whole numbers from {least} to {most}"),
            Self::Numbers(count) => format!("{count} finite numbers"),
            Self::Name(names) => one_of(names.iter().map(|(name, _)| (*name).to_owned())),
            Self::Text => "a text".to_owned(),
            Self::File => "the path of a file".to_owned(),
            Self::Files => "paths of files, one or more".to_owned(),
            Self::Shard => format!("a part I/N, such as 1/4, of at most {} parts", Shard::MAX_COUNT),
        }
    }

    /// Refuses another value.
    ///
    /// # Errors
    /// The [`Refusal`], which says what was expected and what was found.
    pub fn check(&self, value: &Value) -> Result<(), Refusal> {
        match self.holds(value) {
            Some(true) => Ok(()),
            Some(false) => Err(Refusal::Range(self.refused(value))),
            None => Err(Refusal::Type(self.refused(value))),
        }
    }

    /// Whether a value is within the range; `None` of another type.
    fn holds(&self, value: &Value) -> Option<bool> {
        match self {
            Self::Flag | Self::Switch => value.is_boolean().then_some(true),
            Self::Whole { least, most, .. } => is_whole_within(value, *least, *most).or(is_no_number(value)),
            Self::OneOf(numbers) => {
                is_whole_within(value, 0, u64::MAX).map(|_| value.as_u64().is_some_and(|n| numbers.contains(&n)))
            }
            Self::Number(range) => value.as_f64().map(|x| range.contains(x)).or(is_no_number(value)),
            Self::Wholes { count, least, most } => {
                let all: Option<Vec<bool>> =
                    value.as_array()?.iter().map(|n| is_whole_within(n, *least, *most)).collect();
                all.map(|all| all.len() == *count && all.iter().all(|is_within| *is_within))
            }
            Self::Numbers(count) => {
                let is_finite = |one: &Value| one.as_f64().map(f64::is_finite).or(is_no_number(one));
                let all: Option<Vec<bool>> = value.as_array()?.iter().map(is_finite).collect();
                all.map(|all| all.len() == *count && all.iter().all(|is_finite| *is_finite))
            }
            Self::Name(names) => value.as_str().map(|found| names.iter().any(|(name, _)| *name == found)),
            Self::Text | Self::File => value.is_string().then_some(true),
            Self::Files => {
                let files = value.as_array()?;
                files.iter().all(Value::is_string).then_some(!files.is_empty())
            }
            Self::Shard => value.as_str().map(|text| text.parse::<Shard>().is_ok()),
        }
    }

    fn refused(&self, value: &Value) -> String {
        format!("expected {}, found {value}", self.expected())
    }

    /// The value that a text says: numbers of several with commas between them.
    ///
    /// # Errors
    /// What was expected and what was found.
    pub fn parse(&self, text: &str) -> Result<Value, String> {
        let read = |text: &str| match self {
            Self::Flag | Self::Switch => [("on", true), ("off", false), ("true", true), ("false", false)]
                .into_iter()
                .find_map(|(name, value)| (name == text).then_some(Value::Bool(value))),
            Self::Whole { .. } | Self::OneOf(_) | Self::Wholes { .. } => text.parse::<u64>().ok().map(Value::from),
            // What is infinite or not a number becomes null, which no kind holds.
            Self::Number(_) | Self::Numbers(_) => text.parse::<f64>().ok().map(Value::from),
            Self::Name(_) | Self::Text | Self::File | Self::Files | Self::Shard => Some(Value::from(text)),
        };
        let value = match self {
            Self::Wholes { .. } | Self::Numbers(_) => {
                text.split(',').map(|part| read(part.trim())).collect::<Option<Vec<_>>>().map(Value::Array)
            }
            Self::Files => read(text).map(|file| Value::Array(vec![file])),
            _ => read(text),
        };
        let value = value.ok_or_else(|| format!("expected {}, found {text:?}", self.expected()))?;
        match self.check(&value) {
            Ok(()) => Ok(value),
            Err(_) => Err(format!("expected {}, found {text}", self.expected())),
        }
    }

    /// A value as text, as [`OptionKind::parse`] reads it.
    #[must_use]
    pub fn text_of(&self, value: &Value) -> String {
        match (self, value) {
            (Self::Switch | Self::Flag, Value::Bool(is_on)) => if *is_on { "on" } else { "off" }.to_owned(),
            (_, Value::String(text)) => text.clone(),
            // 60.0 is 60.
            (_, Value::Number(number)) => {
                let text = number.to_string();
                text.strip_suffix(".0").map_or(text.clone(), str::to_owned)
            }
            (_, Value::Array(all)) => all.iter().map(|one| self.text_of(one)).collect::<Vec<_>>().join(","),
            _ => value.to_string(),
        }
    }
}

/// False for a number that JSON does not have, which stands in a text: infinity, a long integer, and what is no number.
fn is_no_number(value: &Value) -> Option<bool> {
    let number: f64 = value.as_str()?.parse().ok()?;
    (!number.is_finite() || number.abs() >= 2_f64.powi(63)).then_some(false)
}

/// Whether a number is whole and within a range; `None` of what is no whole number.
fn is_whole_within(value: &Value, least: u64, most: u64) -> Option<bool> {
    let is_whole = value.is_u64() || value.is_i64();
    is_whole.then(|| value.as_u64().is_some_and(|n| (least..=most).contains(&n)))
}

/// `a, b or c`.
fn one_of(names: impl Iterator<Item = String>) -> String {
    let names: Vec<String> = names.collect();
    let mut text = String::new();
    for (k, name) in names.iter().enumerate() {
        let between = match names.len() - k {
            _ if k == 0 => "",
            1 => " or ",
            _ => ", ",
        };
        let _ = write!(text, "{between}{name}");
    }
    text
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    const KINDS: [OptionKind; 11] = [
        OptionKind::Flag,
        OptionKind::Switch,
        OptionKind::Whole { least: 1, most: 8, what: "an order" },
        OptionKind::OneOf(&[8, 16, 32]),
        OptionKind::Number(NumberRange::Positive),
        OptionKind::Wholes { count: 3, least: 2, most: 4096 },
        OptionKind::Numbers(2),
        OptionKind::Name(&[("vertex", ""), ("texture", ""), ("none", "")]),
        OptionKind::Text,
        OptionKind::File,
        OptionKind::Files,
    ];

    #[test]
    fn every_value_is_read_back_from_its_text() {
        let values = [
            json!(true),
            json!(false),
            json!(8),
            json!(16),
            json!(0.25),
            json!([2, 3, 4096]),
            json!([-1.5, 2.0]),
            json!("none"),
            json!("by moonlight"),
            json!("a b.glb"),
            json!(["a.safetensors"]),
        ];
        for (kind, value) in KINDS.iter().zip(&values) {
            assert_eq!(kind.check(value), Ok(()), "{kind:?} {value}");
            assert_eq!(kind.parse(&kind.text_of(value)).as_ref(), Ok(value), "{kind:?} as text");
        }
    }

    #[test]
    fn what_is_out_of_range_and_what_is_of_another_type_are_told_apart() {
        for (kind, value, expected) in [
            (KINDS[2], json!(9), Refusal::Range("expected an order from 1 to 8, found 9".to_owned())),
            (KINDS[2], json!(-1), Refusal::Range("expected an order from 1 to 8, found -1".to_owned())),
            (KINDS[2], json!(2.5), Refusal::Type("expected an order from 1 to 8, found 2.5".to_owned())),
            (KINDS[3], json!(9), Refusal::Range("expected 8, 16 or 32, found 9".to_owned())),
            (KINDS[4], json!(0.0), Refusal::Range("expected a number above 0, found 0.0".to_owned())),
            (
                KINDS[5],
                json!([2, 3]),
                Refusal::Range("expected 3 whole numbers from 2 to 4096, found [2,3]".to_owned()),
            ),
            (KINDS[7], json!("sky"), Refusal::Range("expected vertex, texture or none, found \"sky\"".to_owned())),
            (KINDS[7], json!(1), Refusal::Type("expected vertex, texture or none, found 1".to_owned())),
            (KINDS[0], json!("yes"), Refusal::Type("expected true or false, found \"yes\"".to_owned())),
            (KINDS[2], json!("1e30"), Refusal::Range("expected an order from 1 to 8, found \"1e30\"".to_owned())),
            (KINDS[4], json!("nan"), Refusal::Range("expected a number above 0, found \"nan\"".to_owned())),
            (KINDS[10], json!([]), Refusal::Range("expected paths of files, one or more, found []".to_owned())),
            (KINDS[6], json!([1.0, null]), Refusal::Type("expected 2 finite numbers, found [1.0,null]".to_owned())),
        ] {
            assert_eq!(kind.check(&value), Err(expected), "{kind:?} {value}");
        }
    }

    #[test]
    fn texts_that_say_no_value_are_refused_with_what_they_say() {
        for (kind, text, expected) in [
            (KINDS[2], "four", "expected an order from 1 to 8, found \"four\""),
            (KINDS[2], "9", "expected an order from 1 to 8, found 9"),
            (KINDS[4], "nan", "expected a number above 0, found nan"),
            (KINDS[4], "1e999", "expected a number above 0, found 1e999"),
            (KINDS[6], "1", "expected 2 finite numbers, found 1"),
            (KINDS[6], "1,,2", "expected 2 finite numbers, found \"1,,2\""),
            (KINDS[1], "maybe", "expected on or off, found \"maybe\""),
        ] {
            assert_eq!(kind.parse(text), Err(expected.to_owned()), "{kind:?} {text:?}");
        }
    }
}
