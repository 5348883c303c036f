//! The basis towards as many directions at once as a register holds: the recurrence of [`lobe_sh::basis::Basis`] unrolled, with its constants.

use std::fmt::Write as _;

use lobe_sh::basis::{Basis, coefficient_count, coefficient_index};

/// The highest order with code of its own.
const HIGHEST_ORDER: usize = 10;

/// One file for each order, and their index.
pub(crate) fn files(header: &str) -> Vec<(String, String)> {
    let constants = Basis::<f64>::new(HIGHEST_ORDER);
    let mut index = format!("{header}\n{INDEX}");
    let mut files = Vec::new();
    for order in 1..=HIGHEST_ORDER {
        let _ = writeln!(index, "#[rustfmt::skip]\npub(crate) mod order_{order};");
        files.push((format!("order_{order}.rs"), file(header, &constants, order)));
    }
    files.push(("mod.rs".into(), index));
    files
}

const INDEX: &str = "\
//! The basis of orders 1 to 10 towards many directions at once as straight-line code: the recurrence of
//! [`Basis`](crate::basis::Basis) with its constants.
//!
//! Names: `p_M_L` is the Legendre function of column `M = |m|` and band `L` with its normalization and without `sin^m`,
//! `q_M_L` its difference to the band before; `c_M + i s_M = (x + iy)^M`; `co_M` and `so_M` the same with the sign of z,
//! `side`; `w = |z| - 1`. In the first step of a column the difference is a multiple of a constant.

#![allow(clippy::too_many_lines, reason = \"straight-line code\")]

";

fn file(header: &str, constants: &Basis<f64>, order: usize) -> String {
    let axes = match order {
        1 => "_",
        _ => "[x, y, z]",
    };
    let mut text = format!(
        "{header}\nuse pulp::Simd;\n\nuse crate::basis::places::Places;\nuse crate::simd::{{Lane, Wide, rounded as k}};\n\n\
         /// The {} functions of order {order}.\n#[inline(always)]\n\
         pub(crate) fn basis<S: Simd, T: Lane>(simd: S, {axes}: [Wide<S, T>; 3], out: &mut impl Places<S, T>) {{\n",
        coefficient_count(order)
    );
    if order > 2 {
        text.push_str("    let side = z.sign();\n    let high = z * side;\n    let w = high - k(simd, 1.0);\n");
    }
    for m in 0..order {
        match m {
            0 => {}
            1 => text.push_str("    let (c_1, s_1) = (x, y);\n"),
            _ => {
                let k = m - 1;
                let _ = writeln!(text, "    let c_{m} = y.times_from(s_{k}, x * c_{k});");
                let _ = writeln!(text, "    let s_{m} = x.times_plus(s_{k}, y * c_{k});");
            }
        }
        // Bands m + 3, m + 5, ..
        if m > 0 && m + 3 < order {
            let _ = writeln!(text, "    let (co_{m}, so_{m}) = (c_{m} * side, s_{m} * side);");
        }
        column(&mut text, constants, order, m);
    }
    text + "}\n"
}

/// The functions of one `m`, of all bands.
fn column(text: &mut String, constants: &Basis<f64>, order: usize, m: usize) {
    let diagonal = constants.diagonal(m);
    let first = number(diagonal);
    let put = |text: &mut String, l: usize, m: isize, value: String| {
        let _ = writeln!(text, "    out.put({}, {value});", coefficient_index(l, m));
    };
    let signed = m as isize;
    if m == 0 {
        put(text, 0, 0, first.clone());
    } else {
        put(text, m, signed, format!("c_{m} * {first}"));
        put(text, m, -signed, format!("s_{m} * {first}"));
    }
    for l in m + 1..order {
        let [a, b, g] = constants.step(m, l);
        if l == m + 1 {
            // The function is that of the diagonal times a z.
            let steep = number(a * diagonal);
            if m == 0 {
                put(text, l, 0, format!("z * {steep}"));
            } else {
                let _ = writeln!(text, "    let z_{m} = z * {steep};");
                put(text, l, signed, format!("z_{m} * c_{m}"));
                put(text, l, -signed, format!("z_{m} * s_{m}"));
            }
            if l + 1 < order {
                let _ = writeln!(text, "    let p_{m}_{l} = high * {steep};");
                let _ = writeln!(text, "    let q_{m}_{l} = w.times_plus({steep}, {});", number(g * diagonal));
            }
            continue;
        }
        let (k, odd) = (l - 1, (l - m) % 2 == 1);
        let step = format!("w.times_plus({}, {})", number(a), number(g));
        let _ = writeln!(text, "    let q_{m}_{l} = {step}.times_plus(p_{m}_{k}, q_{m}_{k} * {});", number(b));
        let _ = writeln!(text, "    let p_{m}_{l} = p_{m}_{k} + q_{m}_{l};");
        if m == 0 {
            put(text, l, 0, format!("p_0_{l}{}", if odd { " * side" } else { "" }));
        } else {
            let o = if odd { "o" } else { "" };
            put(text, l, signed, format!("p_{m}_{l} * c{o}_{m}"));
            put(text, l, -signed, format!("p_{m}_{l} * s{o}_{m}"));
        }
    }
}

/// The number nearest to a constant, in every lane.
fn number(x: f64) -> String {
    format!("k(simd, {x:?})")
}
