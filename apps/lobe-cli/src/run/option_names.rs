//! Names of options on the command line, where the library names them.

use lobe::io::{JobOptions as _, OptionError, flag, worded};
use lobe::motion::MovingJob;
use lobe::prt::BakeJob;
use lobe::render::{CameraOptions, ToneOptions, TransferSource};
use lobe::shadow::{FieldJob, SphereJob};

/// A text with the names that options have on the command line.
pub(crate) fn in_flags(text: &str) -> String {
    let is_known = |name: &str| {
        let of_bakes = BakeJob::has(name) || FieldJob::has(name) || SphereJob::has(name);
        of_bakes
            || TransferSource::has(name)
            || MovingJob::has(name)
            || CameraOptions::has(name)
            || ToneOptions::has(name)
    };
    worded(text, |name| is_known(name).then(|| flag(name)))
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
