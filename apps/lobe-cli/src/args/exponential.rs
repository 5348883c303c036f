//! Names of exponentials, and the parts of what is taken to be rounding.

use lobe::sh::ExpMethod;

use crate::args::values;

/// An exponential that is fast enough for one of every receiver.
pub(crate) fn fast_exponential(text: &str) -> Result<ExpMethod, String> {
    match text.parse::<ExpMethod>() {
        Ok(method) if method.is_fast() => Ok(method),
        _ => Err("expected grid, optimal-linear or hybrid[:NORM], of a norm above 0".to_owned()),
    }
}

/// The least eigenvalue of a logarithm, as a part of the largest.
pub(crate) fn clamp(text: &str) -> Result<f64, String> {
    match values::finite(text)? {
        x if x > 0.0 && x <= 1.0 => Ok(x),
        x => Err(format!("expected a part above 0 and up to 1, found {x}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_receiver_has_an_exponential_that_is_fast() {
        assert_eq!(fast_exponential("hybrid:4.8"), Ok(ExpMethod::Hybrid { limit: 4.8 }), "the norm of the paper");
        for slow in ["eigen", "series:12", "hybrid:0"] {
            assert!(fast_exponential(slow).is_err(), "{slow}");
        }
    }
}
