//! The functions in WGSL, from the modules of `lobe-gpu`.

use std::path::Path;

use crate::items::{Item, code, items, needed};

/// The orders of what has an order.
const ORDERS: std::ops::RangeInclusive<usize> = 2..=6;

/// Modules in the order of the list, each with its functions that are offered; what they need comes along.
const OFFERED: &[(&str, &[&str])] = &[
    ("rotation", &["order_3_rotated"]),
    (
        "packed_irradiance",
        &["packed_irradiance_eval", "packed_irradiance_5_eval", "irradiance_matrix_eval", "irradiance_polynomial_eval"],
    ),
    (
        "irradiance_encoding",
        &[
            "non_linear_l1_eval",
            "zh3_eval",
            "zh3_per_channel_eval",
            "zh3_hallucinated_zonal",
            "zh3_hallucinated_zonal_per_channel",
            "ambient_cube_eval",
            "ahd_eval",
        ],
    ),
    ("hemisphere", &["h_basis_4_eval", "h_basis_6_eval", "hl2_eval", "hl2_linear_eval"]),
    ("window", &["hanning_window", "lanczos_window", "gauss_window", "squared_laplacian_window"]),
    ("octahedral", &["octahedral_uv_from_dir", "octahedral_dir_from_uv"]),
    ("clustered_sum", &["clustered_exit_radiance"]),
];

/// Modules of which only what is needed is taken.
const NEEDED: &[&str] = &["generated/basis", "generated/expansion", "elementary"];

/// The functions of an order, after `order_3_`.
const OF_ORDER: &[&str] = &["basis", "eval", "irradiance", "scaled_bands", "exit_radiance", "exit_radiance_rgb"];

/// A function as it is declared.
pub(super) struct Signature<'a> {
    pub(super) name: &'a str,
    pub(super) summary: &'a str,
    pub(super) arguments: Vec<(&'a str, &'a str)>,
    pub(super) result: &'a str,
}

/// The text of all functions, and the names of those that are offered.
pub(super) fn wgsl_library(folder: &Path) -> (String, Vec<String>) {
    let module = |name: &str| std::fs::read_to_string(folder.join(name).with_extension("wgsl")).unwrap();
    let mut text: String = NEEDED.iter().map(|name| module(name) + "\n").collect();
    let mut names: Vec<String> =
        ORDERS.flat_map(|order| OF_ORDER.iter().map(move |name| format!("order_{order}_{name}"))).collect();
    for (name, functions) in OFFERED {
        text.push_str(&module(name));
        text.push('\n');
        names.extend(functions.iter().map(ToString::to_string));
    }
    let all = items(&text);
    let offered: Vec<&str> = names.iter().map(String::as_str).collect();
    let texts: Vec<&str> = needed(&all, &offered).iter().map(|item| item.text).collect();
    (texts.join("\n\n") + "\n", names)
}

/// How a function is declared; the first line of its comment says what it computes.
pub(super) fn signature<'a>(all: &'a [Item<'a>], name: &str) -> Signature<'a> {
    let item = all.iter().find(|item| item.name == name).unwrap();
    let summary = item.text.lines().next().and_then(|line| line.strip_prefix("// ")).unwrap();
    let head = code(item.text).split_once('(').unwrap().1;
    let (list, rest) = head.split_once(") -> ").unwrap();
    let arguments = parts(list).into_iter().filter_map(|part| part.split_once(": ")).collect();
    Signature { name: item.name, summary, arguments, result: rest.split_once(" {").unwrap().0 }
}

/// The parts of a list between commas outside of angle brackets.
fn parts(list: &str) -> Vec<&str> {
    let (mut found, mut first, mut depth) = (Vec::new(), 0, 0);
    for (at, c) in list.char_indices() {
        match c {
            '<' => depth += 1,
            '>' => depth -= 1,
            ',' if depth == 0 => {
                found.push(list[first..at].trim());
                first = at + 1;
            }
            _ => {}
        }
    }
    found.push(list[first..].trim());
    found
}
