//! Choice of the suns of a light that stand apart from its expansion.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

/// Suns that [`SunChoice::Auto`] takes out at most. Each costs shadow rays of its own.
const MOST: usize = 4;

/// The part of all light that a sun of [`SunChoice::Auto`] has at least. One that is fainter changes a surface that
/// faces it by a few percent at most, as low orders do.
const LEAST_PART: f64 = 0.005;

/// Which suns of a light stand apart from its expansion.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(try_from = "String", into = "String"))]
#[non_exhaustive]
pub enum SunChoice {
    /// The suns and lamps that [`extract_suns`](crate::extract_suns) finds in a map: up to four, from the brightest
    /// on, each of half a percent of the light at least. None of an expansion.
    #[default]
    Auto,
    /// No suns: the expansion holds all light.
    None,
    /// So many at most, however faint.
    Count(usize),
    /// Those of a file ([`read_suns`](crate::read_suns)), in addition to all that a map or an expansion holds.
    File(PathBuf),
}

impl SunChoice {
    /// The most suns that may be asked for or given.
    pub const MAX: usize = 1024;

    /// Whether suns are looked for in a map, for which it is copied.
    #[must_use]
    pub fn looks(&self) -> bool {
        self.most().is_some()
    }

    /// The most suns that are looked for in a map; none if that is left alone.
    pub(crate) fn most(&self) -> Option<usize> {
        match self {
            Self::Auto => Some(MOST),
            Self::Count(count) if *count > 0 => Some(*count),
            _ => None,
        }
    }

    /// The part of all light that a sun has at least.
    pub(crate) fn least_part(&self) -> f64 {
        if *self == Self::Auto { LEAST_PART } else { 0.0 }
    }
}

impl FromStr for SunChoice {
    type Err = String;

    /// `auto`, `none`, a number up to 1024, or the path of a .json file.
    fn from_str(text: &str) -> Result<Self, String> {
        match (text, text.parse()) {
            ("auto", _) => Ok(Self::Auto),
            ("none", _) => Ok(Self::None),
            (_, Ok(count)) if count <= Self::MAX => Ok(Self::Count(count)),
            (path, Err(_)) if path.to_ascii_lowercase().ends_with(".json") => Ok(Self::File(path.into())),
            _ => {
                Err(format!("expected auto, none, a number up to {} or a .json file of suns, found {text}", Self::MAX))
            }
        }
    }
}

impl fmt::Display for SunChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Auto => f.write_str("auto"),
            Self::None => f.write_str("none"),
            Self::Count(count) => write!(f, "{count}"),
            Self::File(path) => path.display().fmt(f),
        }
    }
}

impl TryFrom<String> for SunChoice {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl From<SunChoice> for String {
    fn from(choice: SunChoice) -> Self {
        choice.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_choice_is_read_from_the_text_that_it_prints() {
        for text in ["auto", "none", "0", "3", "suns.json"] {
            assert_eq!(text.parse::<SunChoice>().map(|choice| choice.to_string()).as_deref(), Ok(text), "{text}");
        }
        for bad in ["", "1025", "-1", "all", "suns.txt"] {
            let error = bad.parse::<SunChoice>().unwrap_err();
            assert!(error.starts_with("expected auto, none,") && error.ends_with(bad), "{error}");
        }
    }
}
