//! Names of options on the command line, where the library names them.

use lobe::io::{JobOptions as _, OptionError, worded};
use lobe::prt::BakeJob;

/// The argument without a dash.
pub(crate) const POSITIONAL: &str = "scene";

/// The argument with a letter of its own.
pub(crate) const OUTPUT: &str = "output";

/// The name of an option on the command line, without dashes before it.
pub(crate) fn dashed(name: &str) -> String {
    name.replace('_', "-")
}

/// A text with the names that options have on the command line.
pub(crate) fn in_flags(text: &str) -> String {
    /// Options that are named beside those of a bake.
    const OTHERS: [&str; 1] = ["entity"];
    let is_known = |name: &str| OTHERS.contains(&name) || BakeJob::fields().iter().any(|field| field.name == name);
    worded(text, |name| is_known(name).then(|| flag(name)))
}

/// The name of an option on the command line.
fn flag(name: &str) -> String {
    match name {
        POSITIONAL => "SCENE".to_owned(),
        OUTPUT => "-o".to_owned(),
        name => format!("--{}", dashed(name)),
    }
}

/// The refusal of an option in the names of the command line.
pub(crate) fn refusal(error: &OptionError) -> String {
    let message = in_flags(&error.message);
    match &*error.option {
        "" => message,
        option => format!("{}: {message}", flag(option)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_have_their_dashes_and_other_names_stay() {
        assert_eq!(in_flags("@max_edge of `@cube`, or @output"), "--max-edge of `@cube`, or -o");
        let error = OptionError::new("max_vertices", "not with @no_split");
        assert_eq!(refusal(&error), "--max-vertices: not with --no-split");
        assert_eq!(refusal(&OptionError::new("", "too much")), "too much");
    }
}
