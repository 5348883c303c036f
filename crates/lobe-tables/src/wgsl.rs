//! The basis and products in WGSL: the recurrence of [`lobe_sh::basis::Basis`] unrolled, with its constants, and the straight-line
//! products of `lobe-sh`.

use std::fmt::Write as _;

use lobe_sh::basis::{Basis, coefficient_count, coefficient_index};

use crate::text::Function;

/// The highest order that shaders evaluate: eight of transfer, and the ninth band of the clamped cosine.
const HIGHEST_ORDER: usize = 9;

/// The module `basis`: one function for each order.
pub(crate) fn basis(header: &str) -> String {
    let constants = Basis::<f64>::new(HIGHEST_ORDER);
    let mut text = format!("{header}\n{DOC}");
    for order in 1..=HIGHEST_ORDER {
        function(&mut text, &constants, order);
    }
    text
}

const DOC: &str = "\
// The real orthonormal basis y_i, orders 1 to 9, by the recurrence of `lobe_sh::basis::Basis` with its constants: near the
// poles w = |z| - 1 is exact and neighboring functions differ by the small q, so that nothing is lost to rounding.
// Names: p_M_L is the Legendre function of column M = |m| and band L with its normalization and without sin^m, q_M_L its
// difference to the band before; c_M + i s_M = (x + iy)^M; co_M and so_M the same with the sign of z.
";

fn function(text: &mut String, constants: &Basis<f64>, order: usize) {
    let count = coefficient_count(order);
    let _ = write!(
        text,
        "\n// The basis of order {order} towards the unit vector s, y_0 to y_{}.\n\
         fn order_{order}_basis(s: vec3f) -> array<f32, {count}> {{\n",
        count - 1
    );
    if order > 1 {
        text.push_str("    let side = select(1.0, -1.0, s.z < 0.0);\n    let w = s.z * side - 1.0;\n");
    }
    let mut values = vec![String::new(); count];
    for m in 0..order {
        match m {
            0 => {}
            1 => text.push_str("    let c_1 = s.x;\n    let s_1 = s.y;\n"),
            _ => {
                let k = m - 1;
                let _ = writeln!(text, "    let c_{m} = s.x * c_{k} - s.y * s_{k};");
                let _ = writeln!(text, "    let s_{m} = s.x * s_{k} + s.y * c_{k};");
            }
        }
        if m > 0 && m + 1 < order {
            let _ = writeln!(text, "    let co_{m} = c_{m} * side;\n    let so_{m} = s_{m} * side;");
        }
        column(text, &mut values, constants, (order, m));
    }
    let bands: Vec<String> = (0..order).map(|l| values[l * l..(l + 1) * (l + 1)].join(", ")).collect();
    let _ = writeln!(text, "    return array<f32, {count}>(\n        {}\n    );\n}}", bands.join(",\n        "));
}

/// The functions of one `m`, of all bands: what they need, and their values.
fn column(text: &mut String, values: &mut [String], constants: &Basis<f64>, (order, m): (usize, usize)) {
    let _ = writeln!(text, "    let p_{m}_{m} = {};", number(constants.diagonal(m)));
    for l in m..order {
        if l > m {
            let [a, b, g] = constants.step(m, l).map(number);
            let k = l - 1;
            let before = if k == m { String::new() } else { format!("{b} * q_{m}_{k} + ") };
            let _ = writeln!(text, "    let q_{m}_{l} = {before}({g} + {a} * w) * p_{m}_{k};");
            let _ = writeln!(text, "    let p_{m}_{l} = p_{m}_{k} + q_{m}_{l};");
        }
        let odd = (l - m) % 2 == 1;
        if m == 0 {
            let side = if odd { " * side" } else { "" };
            values[coefficient_index(l, 0)] = format!("p_0_{l}{side}");
        } else {
            let o = if odd { "o" } else { "" };
            values[coefficient_index(l, m as isize)] = format!("p_{m}_{l} * c{o}_{m}");
            values[coefficient_index(l, -(m as isize))] = format!("p_{m}_{l} * s{o}_{m}");
        }
    }
}

/// The `f32` nearest to a constant, as WGSL reads it.
pub(crate) fn number(x: f64) -> String {
    format!("{:?}", x as f32)
}

/// The module `product`: products of two expansions of one order, to that order, which `functions` are after order 1.
pub(crate) fn product<'a>(header: &str, functions: impl Iterator<Item = (usize, Function<'a>)>) -> String {
    let mut text = format!(
        "{header}\n// Products of expansions of one order, cut off at that order: the straight-line code of `lobe_sh::product::product_into`.\n"
    );
    // y_0² = y_0/√(4π).
    let first = number((4.0 * std::f64::consts::PI).sqrt().recip());
    let _ = write!(
        text,
        "\nfn order_1_product(a: array<f32, 1>, b: array<f32, 1>) -> array<f32, 1> {{\n    return array<f32, 1>(a[0] * b[0] * {first});\n}}\n"
    );
    for (order, function) in functions {
        let array = format!("array<f32, {}>", coefficient_count(order));
        let _ =
            write!(text, "\nfn order_{order}_product(a: {array}, b: {array}) -> {array} {{\n    var out: {array};\n");
        function.body(&mut text, number);
        text.push_str("    return out;\n}\n");
    }
    text
}
