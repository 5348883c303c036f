//! Names of exponentials, and the parts of what is taken to be rounding.

use lobe::sh::ExpMethod;

use crate::args::values;

/// The norm above which `hybrid` halves unless it names another one: at 1 it is nearest to the truth among those of the example
/// `exponential_errors`.
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
                .map_err(|why| why.replace(" or hybrid[:NORM]", ", hybrid[:NORM], series:P or eigen")),
        },
    }
}

/// An exponential that is fast enough for one of every receiver.
pub(crate) fn fast_exponential(text: &str) -> Result<ExpMethod, String> {
    match text {
        "grid" => Ok(ExpMethod::Grid),
        "optimal-linear" => Ok(ExpMethod::OptimalLinear),
        "hybrid" => Ok(ExpMethod::Hybrid { limit: HYBRID_LIMIT }),
        _ => match text.strip_prefix("hybrid:") {
            Some(limit) => match values::finite(limit)? {
                limit if limit > 0.0 => Ok(ExpMethod::Hybrid { limit }),
                limit => Err(format!("expected a norm above 0, found {limit}")),
            },
            None => Err("expected grid, optimal-linear or hybrid[:NORM]".to_owned()),
        },
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
        assert_eq!(exponential("hybrid:4.8"), Ok(ExpMethod::Hybrid { limit: 4.8 }), "the norm of the paper");
        for bad in ["series:0", "series", "Grid", "", "hybrid:0", "hybrid:-1", "hybrid:nan", "hybrid:"] {
            assert!(exponential(bad).is_err(), "{bad:?}");
        }
        assert!(fast_exponential("eigen").is_err(), "seconds for each receiver");
    }
}
