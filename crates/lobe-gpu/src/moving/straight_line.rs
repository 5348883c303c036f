//! Functions of lists of numbers for shaders, written out place by place.
//!
//! A list whose places are constants is in registers; one that a loop goes through is in memory, as shaders are compiled with
//! checks of their loops, which keep compilers from writing them out.

use std::fmt::Write as _;

/// Numbers of a vector of a list in a buffer.
pub(crate) const LANES: usize = 4;

/// The functions of module `accumulate` for one order and `fit` coefficients of a polynomial: `fitted` and `between_rows`, the
/// logarithm of one sphere by bands; `with_sphere`, which adds it to a sum; `with_point`, which adds a point of the grid to an
/// exponential; `leave`, which writes that.
pub(crate) fn accumulate(order: usize, fit: usize) -> String {
    let n = order * order;
    let mut text = String::new();
    let horner = |l: usize| {
        let coefficient = |k: usize| place("polynomials", l * fit + k);
        (0..fit - 1).rev().fold(coefficient(fit - 1), |p, k| format!("({p} * x + {})", coefficient(k))) + " * u"
    };
    list(&mut text, "fitted(x: f32, u: f32)", order, horner);
    let between = |l: usize| format!("mix(log_table[first + {l}u], log_table[first + {}u], t)", order + l);
    list(&mut text, "between_rows(first: u32, t: f32)", order, between);
    let parameters = format!("with_sphere(f: {0}, share: f32, factors: {1}, y: {0})", array(n), array(order));
    list(&mut text, &parameters, n, |i| format!("f[{i}] + share * factors[{}] * y[{i}]", i.isqrt()));
    let vectors = point_vectors(order);
    let _ = writeln!(text, "\nfn with_point(v: {0}, f: {0}, p: u32) -> {0} {{", array(n));
    for k in 0..vectors {
        let _ = writeln!(text, "    let g_{k} = grid[p * {vectors}u + {k}u];");
    }
    let at = |i: usize| format!("g_{}.{}", i / LANES, axis(i));
    let _ = writeln!(text, "    let value = {};", sum((1..n).map(|i| format!("f[{i}] * {}", at(i)))));
    let _ = writeln!(text, "    let weighted = {} * exp(value);", at(n));
    let terms: Vec<String> = (0..n).map(|i| format!("v[{i}] + weighted * {}", at(i))).collect();
    let _ = writeln!(text, "    return {}({});\n}}", array(n), terms.join(", "));
    let _ = writeln!(text, "\nfn leave(v: {}, factor: f32, r: u32, count: u32) {{", array(n));
    for i in 0..n {
        let _ = writeln!(text, "    visibility[{i}u * count + r] = factor * v[{i}];");
    }
    text.push_str("}\n");
    text
}

/// The functions of module `sky_light`: `seen_by`, the visibility of a receiver, and `along`, a row of the operator times that.
pub(crate) fn sky_light(order: usize) -> String {
    let n = order * order;
    let mut text = String::new();
    list(&mut text, "seen_by(r: u32, count: u32)", n, |i| format!("visibility[{i}u * count + r]"));
    let terms = (0..n).map(|i| format!("v[{i}] * operator_rows[first + {i}u].rgb"));
    let _ = writeln!(text, "\nfn along(v: {}, first: u32) -> vec3f {{\n    return {};\n}}", array(n), sum(terms));
    text
}

/// Vectors of a point of the grid: the basis, the weight, and what fills them up.
pub(crate) fn point_vectors(order: usize) -> usize {
    (order * order + 1).div_ceil(LANES)
}

/// A function that returns a list.
fn list(text: &mut String, head: &str, count: usize, number: impl Fn(usize) -> String) {
    let numbers: Vec<String> = (0..count).map(number).collect();
    let array = array(count);
    let _ = writeln!(text, "\nfn {head} -> {array} {{\n    return {array}({});\n}}", numbers.join(", "));
}

fn sum(terms: impl Iterator<Item = String>) -> String {
    // A list of one has none.
    terms.reduce(|sum, term| format!("{sum} + {term}")).unwrap_or_else(|| "0.0".to_owned())
}

fn array(count: usize) -> String {
    format!("array<f32, {count}>")
}

/// A number of a list of vectors.
fn place(list: &str, i: usize) -> String {
    format!("{list}[{}].{}", i / LANES, axis(i))
}

fn axis(i: usize) -> char {
    ['x', 'y', 'z', 'w'][i % LANES]
}
