//! Parsers of numbers, directions, colors and orders, which several sub-commands share.

use lobe::sh::basis::MAX_ORDER;
use lobe::sh::{Dir, Rgb};

/// The most rows a written picture may have: 8192 x 16384 texels take 1.5 GiB.
const MAX_ROWS: usize = 8192;

/// `N` finite numbers, separated by commas.
pub(crate) fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let example = ["0", "0", "1", "0", "1", "0", "-1", "0", "0"][..N.min(9)].join(",");
    let parts: Vec<&str> = text.split(',').map(str::trim).collect();
    if parts.len() != N {
        return Err(format!("expected {N} numbers with commas between them, such as {example}; found {}", parts.len()));
    }
    let mut out = [0.0; N];
    for (out, part) in out.iter_mut().zip(parts) {
        *out = finite(part)?;
    }
    Ok(out)
}

/// One finite number.
pub(crate) fn finite(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x.is_finite() => Ok(x),
        _ => Err(format!("expected a finite number, found {text:?}")),
    }
}

/// A direction: three numbers, not all zero, of any length.
pub(crate) fn dir(text: &str) -> Result<Dir, String> {
    Dir::new(numbers(text)?).ok_or_else(|| "0,0,0 points nowhere; give a vector that is not zero".to_owned())
}

/// A finite number above 0.
pub(crate) fn positive(text: &str) -> Result<f64, String> {
    match finite(text)? {
        x if x > 0.0 => Ok(x),
        x => Err(format!("expected a number above 0, found {x}")),
    }
}

/// The least eigenvalue of a logarithm, as a part of the largest.
pub(crate) fn clamp(text: &str) -> Result<f64, String> {
    match finite(text)? {
        x if x > 0.0 && x <= 1.0 => Ok(x),
        x => Err(format!("expected a part above 0 and up to 1, found {x}")),
    }
}

/// An angle from 0 to 90 degrees.
pub(crate) fn quarter_turn(text: &str) -> Result<f64, String> {
    match finite(text)? {
        x if (0.0..=90.0).contains(&x) => Ok(x),
        x => Err(format!("expected an angle from 0 to 90 degrees, found {x}")),
    }
}

/// A color of light: three numbers, none negative.
pub(crate) fn color(text: &str) -> Result<Rgb<f64>, String> {
    let channels: [f64; 3] = numbers(text)?;
    match channels.into_iter().find(|c| *c < 0.0) {
        Some(c) => Err(format!("no channel of a color is negative, but one is {c}")),
        None => Ok(Rgb::from(channels)),
    }
}

/// A color of light, or one number for all its channels.
pub(crate) fn gray_or_color(text: &str) -> Result<Rgb<f64>, String> {
    if text.contains(',') { color(text) } else { color(&[text; 3].join(",")) }
}

/// A color of a surface: three numbers from 0 to 1.
pub(crate) fn albedo(text: &str) -> Result<Rgb<f64>, String> {
    let albedo = color(text)?;
    match albedo.to_array().into_iter().find(|c| *c > 1.0) {
        Some(c) => Err(format!("no surface reflects more light than it gets, but one channel is {c}")),
        None => Ok(albedo),
    }
}

/// An order: the number of bands.
pub(crate) fn order(text: &str) -> Result<usize, String> {
    whole(text, 1, MAX_ORDER, "an order (number of bands)")
}

/// The number of rows of a picture twice as wide as high.
pub(crate) fn rows(text: &str) -> Result<usize, String> {
    whole(text, 1, MAX_ROWS, "a number of rows")
}

/// A whole number from `low` to `high`.
pub(crate) fn whole(text: &str, low: usize, high: usize, what: &str) -> Result<usize, String> {
    match text.parse::<usize>() {
        Ok(n) if (low..=high).contains(&n) => Ok(n),
        _ => Err(format!("expected {what} from {low} to {high}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_may_be_negative_and_have_blanks_between_them() {
        assert_eq!(numbers("-1, 2.5e-3,0"), Ok([-1.0, 0.0025, 0.0]), "three numbers");
    }

    #[test]
    fn too_few_too_many_and_no_numbers_are_refused() {
        for (text, part) in [
            ("1,2", "such as 0,0,1; found 2"),
            ("1,2,3,4", "found 4"),
            ("", "found 1"),
            ("1,,3", "expected a finite number, found \"\""),
            ("1,x,3", "found \"x\""),
            ("1,nan,3", "found \"nan\""),
            ("1,1e999,3", "found \"1e999\""),
        ] {
            let message = numbers::<3>(text).unwrap_err();
            assert!(message.ends_with(part), "{text:?}: {message}");
        }
    }

    #[test]
    fn directions_are_normalized_and_zero_is_none() {
        assert_eq!(dir("0,0,-5"), Ok(-Dir::Z), "down");
        assert!(dir("0,0,0").unwrap_err().contains("points nowhere"), "zero");
    }

    #[test]
    fn one_number_is_that_of_all_channels() {
        assert_eq!(gray_or_color("0.25"), Ok(Rgb::new(0.25, 0.25, 0.25)), "one");
        assert_eq!(gray_or_color("1,2,3"), Ok(Rgb::new(1.0, 2.0, 3.0)), "three");
        assert!(gray_or_color("-1").unwrap_err().contains("negative"), "below 0");
        assert!(gray_or_color("1,2").unwrap_err().contains("found 2"), "two");
    }

    #[test]
    fn orders_and_sizes_have_limits() {
        assert_eq!([order("1"), order("256"), rows("8192")], [Ok(1), Ok(256), Ok(8192)], "limits");
        for bad in ["0", "257", "-1", "3.0", "", "three", "99999999999999999999999"] {
            assert_eq!(order(bad).unwrap_err(), "expected an order (number of bands) from 1 to 256", "{bad:?}");
        }
        assert!(rows("0").is_err() && rows("8193").is_err(), "rows");
    }
}
