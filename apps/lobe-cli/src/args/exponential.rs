//! Names of exponentials, and the parts of what is taken to be rounding.

use lobe::sh::ExpMethod;

use crate::args::values;

/// The norm above which `hybrid` halves: at 1 it is nearest to the truth among those of the example `exponential_errors`.
const HYBRID_LIMIT: f64 = 1.0;

/// The most terms of a series of products; `e^x` to rounding needs fewer for any sum of logarithms that leaves light.
const MOST_TERMS: usize = 100;

/// An exponential of one function.
pub(crate) fn exponential(text: &str) -> Result<ExpMethod, String> {
    match text {
        "eigen" => Ok(ExpMethod::Eigen),
        _ => match text.strip_prefix("series:") {
            Some(terms) => values::whole(terms, 1, MOST_TERMS, "a number of terms").map(ExpMethod::ProductSeries),
            None => fast_exponential(text)
                .map_err(|_| "expected grid, optimal-linear, hybrid, series:P or eigen".to_owned()),
        },
    }
}

/// An exponential that is fast enough for one of every receiver.
pub(crate) fn fast_exponential(text: &str) -> Result<ExpMethod, String> {
    match text {
        "grid" => Ok(ExpMethod::Grid),
        "optimal-linear" => Ok(ExpMethod::OptimalLinear),
        "hybrid" => Ok(ExpMethod::Hybrid { limit: HYBRID_LIMIT }),
        _ => Err("expected grid, optimal-linear or hybrid".to_owned()),
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
    fn exponentials_have_names_and_a_series_its_terms() {
        assert_eq!(exponential("series:12"), Ok(ExpMethod::ProductSeries(12)), "a series");
        assert_eq!(exponential("grid"), fast_exponential("grid"), "one of both");
        for bad in ["series:0", "series", "Grid", ""] {
            assert!(exponential(bad).is_err(), "{bad:?}");
        }
        assert!(fast_exponential("eigen").is_err(), "seconds for each receiver");
    }
}
