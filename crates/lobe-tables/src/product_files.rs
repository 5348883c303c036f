//! The files of products, and their indices: modules, costs, and the choice by the numbers of coefficients.

use std::fmt::Write as _;

use crate::graph::Cost;
use crate::product::{Kind, Product};
use crate::text::HEADER;

/// The files of products of one pair, names and texts.
pub(crate) fn of_pairs(products: &[Product]) -> Vec<(String, String)> {
    let mut files: Vec<(String, String)> =
        products.iter().map(|product| (format!("{}.rs", product.kind.module()), product.source())).collect();
    files.push(("mod.rs".into(), index(products)));
    files
}

/// The files for lanes: products of factors of one order to that order, squares, and products with zonal functions.
pub(crate) fn of_lanes(products: &[Product]) -> Vec<(String, String)> {
    let kinds = products.iter().filter(|product| match product.kind {
        Kind::General([a, b, out]) => a == b && a == out,
        Kind::Square(_) | Kind::Zonal(_) => true,
    });
    let mut files = Vec::new();
    let mut index = format!(
        "{HEADER}\n//! Products of sixteen pairs of expansions at once as straight-line code.\n\n\
         #![allow(clippy::too_many_lines, reason = \"straight-line code\")]\n\n"
    );
    for product in kinds {
        let _ = writeln!(index, "#[rustfmt::skip]\npub(crate) mod {};", product.kind.module());
        files.push((format!("{}.rs", product.kind.module()), product.source_for_lanes()));
    }
    files.push(("mod.rs".into(), index));
    files
}

/// The orders of the files of one pair that is multiplied by fused sums.
const FUSED: [usize; 2] = [3, 4];

/// Those files.
pub(crate) fn of_fused_pairs(products: &[Product]) -> Vec<(String, String)> {
    let mut files = Vec::new();
    let mut index = format!(
        "{HEADER}\n//! Products of one pair of expansions in `f32`, with fused sums, as straight-line code.\n\n\
         #![allow(clippy::too_many_lines, reason = \"straight-line code\")]\n\n"
    );
    for product in products.iter().filter(|product| FUSED.map(|n| Kind::General([n; 3])).contains(&product.kind)) {
        let _ = writeln!(index, "#[rustfmt::skip]\npub(crate) mod {};", product.kind.module());
        files.push((format!("{}.rs", product.kind.module()), product.source_to_fuse()));
    }
    files.push(("mod.rs".into(), index));
    files
}

/// `mod.rs`: the modules, the table of costs and the choice of a function by the numbers of coefficients.
fn index(products: &[Product]) -> String {
    let mut text = String::from(HEADER);
    text += "\n//! Products of expansions as straight-line code.\n\n";
    text += "#![allow(clippy::too_many_lines, reason = \"straight-line code\")]\n\n";
    for product in products {
        if is_long(product) {
            text += FOR_MANY;
            text += "\n";
        }
        let _ = writeln!(text, "#[rustfmt::skip]\nmod {};", product.kind.module());
    }
    text +=
        "\n#[cfg(test)]\nuse crate::product::cost::{ProductCost, ProductKind};\nuse crate::scalar::Coefficient;\n\n";
    text += COSTS_DOC;
    text += "#[cfg(test)]\n#[rustfmt::skip]\npub(crate) const PRODUCT_COSTS: &[ProductCost] = &[\n";
    for product in products {
        let Cost { multiplications, additions } = product.cost();
        let _ = writeln!(
            text,
            "    ProductCost {{ kind: ProductKind::{}, orders: {:?}, multiplications: {multiplications}, \
             additions: {additions} }},",
            product.kind.name(),
            product.kind.orders(),
        );
    }
    text += "];\n";
    for (name, doc, arguments, array) in CHOICES {
        let _ = write!(
            text,
            "\n{doc}#[inline]\n#[rustfmt::skip]\npub(crate) fn {name}<T: Coefficient>({arguments}, out: &mut [T])"
        );
        let square = array.is_empty();
        let lengths = if square { "(a.len(), out.len())" } else { &format!("({array}.len(), b.len(), out.len())") };
        let _ = write!(text, " -> bool {{\n    match {lengths} {{\n");
        for product in products.iter().filter(|product| product.kind.name().to_lowercase() == *name) {
            let (module, [a, b, out]) = (product.kind.module(), product.kind.lengths());
            if is_long(product) {
                let _ = writeln!(text, "        {FOR_MANY}");
            }
            let _ = if square {
                writeln!(text, "        ({a}, {out}) => {module}::product(fixed(a), fixed_mut(out)),")
            } else {
                writeln!(
                    text,
                    "        ({a}, {b}, {out}) => {module}::product(fixed({array}), fixed(b), fixed_mut(out)),"
                )
            };
        }
        text += "        _ => return false,\n    }\n    true\n}\n";
    }
    text + HELPERS
}

/// Products of more multiplications than these take long to compile, and have code only where many are wanted.
const MOST_MULTIPLICATIONS: usize = 300;

const FOR_MANY: &str = "#[cfg(feature = \"batch\")]";

fn is_long(product: &Product) -> bool {
    product.cost().multiplications > MOST_MULTIPLICATIONS
}

const COSTS_DOC: &str = "/// What every generated product costs. The generator counts the operations it writes; a test counts them again\n\
/// in the source.\n";

/// Name, doc, first arguments and name of the first factor of the functions that choose.
const CHOICES: [(&str, &str, &str, &str); 3] = [
    (
        "general",
        "/// The product `a b` if there is code for these orders; whether there is.\n",
        "a: &[T], b: &[T]",
        "a",
    ),
    ("square", "/// The square of `a` if there is code for these orders; whether there is.\n", "a: &[T]", ""),
    (
        "zonal",
        "/// The product of the zonal `z` and `b` if there is code for these orders; whether there is.\n",
        "z: &[T::Scalar], b: &[T]",
        "z",
    ),
];

const HELPERS: &str = "
/// A slice whose length was matched.
fn fixed<T, const N: usize>(slice: &[T]) -> &[T; N] {
    slice.try_into().unwrap_or_else(|_| unreachable!(\"the length was matched\"))
}

/// A slice whose length was matched.
fn fixed_mut<T, const N: usize>(slice: &mut [T]) -> &mut [T; N] {
    slice.try_into().unwrap_or_else(|_| unreachable!(\"the length was matched\"))
}
";
