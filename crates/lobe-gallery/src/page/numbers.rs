//! Numbers in words and tables.

/// A number in three significant digits.
pub(crate) fn digits(x: f64) -> String {
    match x.abs() {
        0.0 => "0".into(),
        size if !(1e-3..1e5).contains(&size) => format!("{x:.2e}"),
        size => format!("{x:.*}", (2 - size.log10().floor() as i32).max(0) as usize),
    }
}

/// A share in percent.
pub(crate) fn percent(share: f64) -> String {
    format!("{} %", digits(100.0 * share))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits() {
        let cases = [
            (0.0, "0"),
            (1.0, "1.00"),
            (-12.345, "-12.3"),
            (9876.5, "9876"),
            (0.00012345, "1.23e-4"),
            (0.0456, "0.0456"),
        ];
        for (x, expected) in cases {
            assert_eq!(digits(x), expected, "{x}");
        }
    }
}
