//! Structs of options: what is asked for, as a table of fields and as JSON.

use std::path::PathBuf;

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use super::field::{OptionError, OptionField};

/// A struct whose fields are options, see [`options!`](crate::options!).
pub trait JobOptions: Serialize + DeserializeOwned + Default {
    /// All options, in the order of help.
    #[must_use]
    fn fields() -> Vec<&'static OptionField>;

    /// Whether there is an option of this name.
    #[must_use]
    fn has(name: &str) -> bool {
        Self::fields().iter().any(|field| field.name == name)
    }

    /// Refuses what cannot be had together, and what would be ignored.
    ///
    /// # Errors
    /// The first [`OptionError`].
    fn check_together(&self, _given: &Given<'_>) -> Result<(), OptionError> {
        Ok(())
    }

    /// The heading under which help has an option, if that is none of the first.
    #[must_use]
    fn heading_of(_name: &str) -> Option<&'static str> {
        None
    }

    /// The options of a table of values, with defaults for those that are not in it, or are null.
    ///
    /// # Errors
    /// [`OptionError`] for a name that is none of an option, a value of another type or out of its range, and what
    /// cannot be had together.
    fn from_values(mut values: Map<String, Value>) -> Result<Self, OptionError> {
        values.retain(|_, value| !value.is_null());
        check_values(&Self::fields(), &values)?;
        let options: Self = serde_json::from_value(Value::Object(values.clone()))
            .map_err(|error| OptionError::new("", error.to_string()))?;
        options.check_together(&Given(&values))?;
        Ok(options)
    }

    /// The default of an option that is left open, in words, where it is another than in the table that the option is
    /// of.
    #[must_use]
    fn left_open_of(field: &OptionField) -> &'static str {
        field.left_open
    }

    /// The options that give way to this one, where it is asked for over others: its contraries.
    #[must_use]
    fn contraries(_name: &str) -> &'static [&'static str] {
        &[]
    }

    /// Takes paths as the system has them, which need not be text, in place of their texts.
    fn set_paths(&mut self, _given: GivenPaths<'_>) {}

    /// The values of all options that are not their defaults.
    #[must_use]
    fn values(&self) -> Map<String, Value> {
        let defaults = table(&Self::default());
        let mut values = table(self);
        values.retain(|name, value| defaults.get(name) != Some(value));
        values
    }

    /// The default of an option, if it has one.
    #[must_use]
    fn default_of(name: &str) -> Option<Value> {
        table(&Self::default()).remove(name).filter(|value| !value.is_null())
    }

    /// Refuses values that are out of their ranges, and what cannot be had together.
    ///
    /// # Errors
    /// The first [`OptionError`].
    fn check(&self) -> Result<(), OptionError> {
        let values = self.values();
        // A number that JSON does not have, which no range holds.
        let is_lost = |(name, value): (&String, &Value)| value.is_null().then(|| name.clone());
        if let Some(name) = values.iter().find_map(is_lost) {
            return Err(OptionError::new(name, "expected a finite number"));
        }
        check_values(&Self::fields(), &values)?;
        self.check_together(&Given(&values))
    }
}

/// The paths that were given for an option, by its name.
pub type GivenPaths<'a> = &'a dyn Fn(&str) -> Option<Vec<PathBuf>>;

/// The options that somebody asked for.
#[derive(Clone, Copy, Debug)]
pub struct Given<'a>(&'a Map<String, Value>);

impl Given<'_> {
    /// Whether this one is.
    #[must_use]
    pub fn has(&self, name: &str) -> bool {
        self.0.contains_key(name)
    }

    /// The first of these that is.
    #[must_use]
    pub fn first_of(&self, names: &[&'static str]) -> Option<&'static str> {
        names.iter().copied().find(|name| self.has(name))
    }
}

/// All options, those that are left open as null.
fn table(options: &impl Serialize) -> Map<String, Value> {
    match serde_json::to_value(options) {
        Ok(Value::Object(all)) => all,
        _ => Map::new(),
    }
}

/// Refuses names that are none of these, and values that are out of their ranges.
fn check_values(fields: &[&OptionField], values: &Map<String, Value>) -> Result<(), OptionError> {
    for (name, value) in values {
        let Some(field) = fields.iter().find(|field| field.name == name) else {
            let nearest = fields.iter().map(|field| field.name).min_by_key(|known| distance(known, name));
            let hint = nearest.map_or_else(String::new, |known| format!("; @{known} is the nearest"));
            return Err(OptionError::new(name, format!("there is no such option{hint}")));
        };
        field.kind.check(value).map_err(|refusal| OptionError::of(name, &refusal))?;
    }
    Ok(())
}

/// The edit distance of two words: the least number of letters that are put in, left out or replaced.
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut above_left = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let replaced = above_left + usize::from(x != *y);
            above_left = row[j + 1];
            row[j + 1] = replaced.min(row[j].min(above_left) + 1);
        }
    }
    row[b.len()]
}

/// Declares a struct of options: for each a doc comment, which is its help, its type, its default, its
/// [kind](crate::OptionKind), what stands for a value in help, and the default of what is left open, in words.
///
/// The struct has serde's traits, in which it is a flat table, a setter for each option, and
/// [`JobOptions`](crate::JobOptions) by the crate. Options of other such structs are part of it after `with`. Fields in
/// a last block `unasked { .. }` are set by programs alone: users are not asked for them, and no file keeps them.
///
/// ```
/// use lobe_io::{JobOptions, OptionError, OptionKind, options};
///
/// options! {
///     /// How a sky is drawn.
///     pub struct SkyOptions {
///         /// Bands, which are squared coefficients
///         order: usize = 4, OptionKind::Whole { least: 1, most: 8, what: "an order" }, "N", "";
///     }
/// }
///
/// impl JobOptions for SkyOptions {
///     fn fields() -> Vec<&'static lobe_io::OptionField> {
///         Self::FIELDS.iter().collect()
///     }
/// }
///
/// let asked = serde_json::from_str(r#"{"order": 9}"#).unwrap();
/// let error = SkyOptions::from_values(asked).unwrap_err();
/// assert_eq!(error.to_string(), "order: expected an order from 1 to 8, found 9");
/// assert_eq!(SkyOptions::default().order(3).values()["order"], 3);
/// ```
#[macro_export]
macro_rules! options {
    (
        $(#[$meta:meta])*
        pub struct $name:ident $(with $($base:ident: $base_type:ty),+)? {
            $(
                $(#[doc = $doc:expr])+
                $(#[serde($($serde:tt)*)])?
                $field:ident: $type:ty = $default:expr, $kind:expr, $value_name:expr, $left_open:expr;
            )+
            $(unasked {
                $(
                    $(#[doc = $own_doc:expr])+
                    $own:ident: $own_type:ty = $own_default:expr;
                )+
            })?
        }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(default)]
        #[non_exhaustive]
        pub struct $name {
            $($(
                /// The options of another table, which are of the same job.
                #[serde(flatten)]
                pub $base: $base_type,
            )+)?
            $(
                $(#[doc = $doc])+
                $(#[serde($($serde)*)])?
                pub $field: $type,
            )+
            $($(
                $(#[doc = $own_doc])+
                #[serde(skip)]
                pub $own: $own_type,
            )+)?
        }

        impl Default for $name {
            /// The defaults of all options.
            fn default() -> Self {
                Self { $($($base: Default::default(),)+)? $($field: $default,)+ $($($own: $own_default,)+)? }
            }
        }

        impl $name {
            /// The options of this struct alone, in the order of help.
            pub const FIELDS: &'static [$crate::OptionField] = &[
                $($crate::OptionField::new(
                    stringify!($field),
                    ($kind, $value_name, $left_open),
                    concat!($($doc),+),
                ),)+
            ];

            $($(
                #[doc = concat!("The same with another `", stringify!($base), "`.")]
                #[must_use]
                pub fn $base(mut self, $base: $base_type) -> Self {
                    self.$base = $base;
                    self
                }
            )+)?

            $(
                #[doc = concat!("The same with another `", stringify!($field), "`.")]
                #[must_use]
                pub fn $field(mut self, $field: $type) -> Self {
                    self.$field = $field;
                    self
                }
            )+

            $($(
                #[doc = concat!("The same with another `", stringify!($own), "`.")]
                #[must_use]
                pub fn $own(mut self, $own: $own_type) -> Self {
                    self.$own = $own;
                    self
                }
            )+)?
        }
    };
}

#[cfg(test)]
#[expect(dead_code, unreachable_pub, reason = "made by the macro, for the crates that use it")]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::options::kind::{NumberRange, OptionKind};

    options! {
        /// Where.
        pub struct Place {
            /// A file
            file: String = String::new(), OptionKind::File, "FILE", "";
            /// Which axis is up
            up: Option<String> = None, OptionKind::Name(&[("y", "y"), ("z", "z")]), "AXIS", "y";
        }
    }

    options! {
        /// What.
        pub struct Work with place: Place {
            /// Bands
            order: usize = 4, OptionKind::Whole { least: 1, most: 8, what: "an order" }, "N", "";
            /// A length, not with `flat`
            max_edge: Option<f64> = None, OptionKind::Number(NumberRange::Positive), "L", "none";
            /// Flat
            flat: bool = false, OptionKind::Flag, "", "";
        }
    }

    impl JobOptions for Work {
        fn fields() -> Vec<&'static OptionField> {
            Place::FIELDS.iter().chain(Self::FIELDS).collect()
        }

        fn check_together(&self, given: &Given<'_>) -> Result<(), OptionError> {
            if self.flat && given.has("max_edge") {
                return Err(OptionError::new("max_edge", "not with @flat"));
            }
            Ok(())
        }
    }

    fn read(value: Value) -> Result<Work, OptionError> {
        let Value::Object(values) = value else { panic!("expected a table") };
        Work::from_values(values)
    }

    #[test]
    fn what_is_asked_for_is_written_as_it_was_read_and_defaults_are_left_out() {
        let asked = json!({"file": "a.glb", "max_edge": 2, "up": "z"});
        let work = read(asked).unwrap();
        assert_eq!((work.place.file.as_str(), work.order, work.max_edge), ("a.glb", 4, Some(2.0)));
        assert_eq!(Value::Object(work.values()), json!({"file": "a.glb", "max_edge": 2.0, "up": "z"}));
        assert_eq!(read(Value::Object(work.values())), Ok(work), "the same again");
        assert_eq!(read(json!({"order": null})), Ok(Work::default()), "null leaves open");
        assert_eq!(Work::default_of("order"), Some(json!(4)));
        assert_eq!(Work::default_of("max_edge"), None);
    }

    #[test]
    fn refusals_name_the_option() {
        for (asked, expected) in [
            (json!({"order": 9}), "order: expected an order from 1 to 8, found 9"),
            (json!({"up": "x"}), "up: expected y or z, found \"x\""),
            (json!({"orders": 3}), "orders: there is no such option; order is the nearest"),
            (json!({"max_edge": 1.0, "flat": true}), "max_edge: not with flat"),
        ] {
            assert_eq!(read(asked.clone()).unwrap_err().to_string(), expected, "{asked}");
        }
        let changed = Work::default().order(0);
        assert_eq!(changed.check().unwrap_err().to_string(), "order: expected an order from 1 to 8, found 0");
    }
}
