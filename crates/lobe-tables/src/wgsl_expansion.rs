//! Expansions in color in WGSL, one function for each order, in straight lines.

use std::fmt::Write as _;

use lobe_sh::Zonal;
use lobe_sh::basis::coefficient_count;

use crate::wgsl::number;

/// The orders that are written: from the lowest that has a direction to the highest that transfer usually has.
const ORDERS: std::ops::RangeInclusive<usize> = 2..=6;

/// The module `expansion`: values, irradiance, bands with factors, products with transfer.
pub(crate) fn expansion(header: &str) -> String {
    let mut text = header.replacen("// ", "// uses: basis\n// ", 1) + DOC;
    for order in ORDERS {
        evaluations(&mut text, order);
        bands(&mut text, order);
        transfer(&mut text, order);
    }
    text
}

const DOC: &str = "
// Expansions in color of orders 2 to 6, as `lobe_sh::Expansion` has them: coefficient i is that of the basis function
// y_i.
";

/// A sum of products of coefficients, a line for each band; a band may have a factor, and be left out where it is 0.
fn sum(order: usize, factors: Option<&[f64]>, [a, b]: [&str; 2]) -> String {
    let band = |l: usize| -> Option<String> {
        let terms: Vec<String> = (l * l..(l + 1) * (l + 1)).map(|i| format!("{a}[{i}] * {b}[{i}]")).collect();
        let terms = terms.join(" + ");
        match factors {
            None => Some(terms),
            // Odd bands above 1 of the clamped cosine are zero, to rounding.
            Some(factors) => (l < 2 || l.is_multiple_of(2)).then(|| format!("{} * ({terms})", number(factors[l]))),
        }
    };
    let lines: Vec<String> = (0..order).filter_map(band).collect();
    format!("    return {};\n", lines.join("\n        + "))
}

/// Values towards a direction, and irradiance on a surface.
fn evaluations(text: &mut String, order: usize) {
    let count = coefficient_count(order);
    let value = sum(order, None, ["y", "f"]);
    let _ = write!(
        text,
        "
// The value of an expansion of order {order} in color towards the unit vector s: f(s) = sum_i f_i y_i(s).
// Coefficients of radiance give radiance, those of irradiance give irradiance.
fn order_{order}_eval(f: array<vec3f, {count}>, s: vec3f) -> vec3f {{
    let y = order_{order}_basis(s);
{value}}}
"
    );
    let factors = Zonal::clamped_cosine(order).convolution_factors();
    let value = sum(order, Some(&factors), ["y", "radiance"]);
    let _ = write!(
        text,
        "
// The irradiance of a surface with unit normal n under radiance of order {order}, without 1/pi.
// E(n) = sum_lm A_l L_lm y_lm(n), A_l of `lobe_sh::Zonal::clamped_cosine`: pi, 2 pi/3, pi/4, 0, -pi/24, 0.
fn order_{order}_irradiance(radiance: array<vec3f, {count}>, n: vec3f) -> vec3f {{
    let y = order_{order}_basis(n);
{value}}}
"
    );
}

/// Bands with factors.
fn bands(text: &mut String, order: usize) {
    let count = coefficient_count(order);
    let band = |l: usize| -> String {
        let all: Vec<String> = (l * l..(l + 1) * (l + 1)).map(|i| format!("f[{i}] * factors[{l}]")).collect();
        all.join(", ")
    };
    let lines: Vec<String> = (0..order).map(band).collect();
    let _ = write!(
        text,
        "
// The expansion of order {order} with each band multiplied by its factor, such as that of a window.
// As `lobe_sh::filter::scale_bands_in_place`.
fn order_{order}_scaled_bands(f: array<vec3f, {count}>, factors: array<f32, {order}>) -> array<vec3f, {count}> {{
    return array<vec3f, {count}>(
        {}
    );
}}
",
        lines.join(",\n        ")
    );
}

/// Products of light with transfer.
fn transfer(text: &mut String, order: usize) {
    let count = coefficient_count(order);
    let value = sum(order, None, ["light", "transfer"]);
    let kinds = [("", "gray transfer", "f32"), ("_rgb", "transfer in color", "vec3f")];
    for (ending, what, ty) in kinds {
        let _ = write!(
            text,
            "
// The exit radiance of a matte receiver with {what} of order {order}: B = sum_i L_i T_i.
// As `lobe_prt::Transfer::exit_radiance`.
fn order_{order}_exit_radiance{ending}(transfer: array<{ty}, {count}>, light: array<vec3f, {count}>) -> vec3f {{
{value}}}
"
        );
    }
}
