//! Rotation of one band: three rotations about z between two exchanges of y and z.

use std::fmt::Write as _;

use lobe_sh::basis::{band_range, coefficient_count};
use lobe_sh::rotation::AxisPermutation;

use crate::graph::{Graph, Value, signed};
use crate::text::Function;

/// Bands that have code of their own: those below have closed forms, those above share a loop.
const BANDS: std::ops::RangeInclusive<usize> = 3..=7;

/// Entries of the exchange this near to 0 and ±1 are those.
const ROUNDING: f64 = 1e-14;

/// The exchange of y and z.
const EXCHANGE: [[i8; 3]; 3] = [[1, 0, 0], [0, 0, 1], [0, 1, 0]];

/// One file for each band, and their index.
pub(crate) fn files(header: &str) -> Vec<(String, String)> {
    let mut index = format!("{header}\n{INDEX}");
    let mut files = Vec::new();
    for l in BANDS {
        let _ = writeln!(index, "#[rustfmt::skip]\npub(crate) mod band_{l};");
        files.push((format!("band_{l}.rs"), file(header, l)));
    }
    files.push(("mod.rs".into(), index));
    files
}

const INDEX: &str = "\
//! The rotation of bands 3 to 7 by `Z(α) J Z(-β) J Z(γ)` as straight-line code: the exchange `J` of y and z with its
//! constants, its zeros left out.
//!
//! `p`, `q` and `r` hold the turns by γ, -β and α: the cosine of `m` times the angle in place `2(m - 1)`, the sine behind it.

#![allow(clippy::too_many_lines, reason = \"straight-line code\")]

";

fn file(header: &str, l: usize) -> String {
    let (graph, results) = build(l);
    let side = 2 * l + 1;
    let turns = ["p", "q", "r"].map(|name| format!("{name}: &[T::Scalar; {}]", 2 * BANDS.end())).join(", ");
    let function = Function {
        doc: format!("Rotates band {l}."),
        seen_by: "crate",
        signature: format!("rotate<T: Term>({turns}, f: &[T; {side}], out: &mut [T; {side}])"),
        graph: &graph,
        results: &results,
    };
    format!("{header}\nuse crate::rotation::term::{{Term, number as k}};\n\n{}", function.source_to_fuse())
}

/// The coefficients of the rotated band, from its coefficients `f` and the turns `p`, `q` and `r`.
fn build(l: usize) -> (Graph, Vec<Value>) {
    let mut graph = Graph::default();
    let exchange = exchange(l);
    let band: Vec<Value> = (0..=2 * l).map(|i| graph.input(('f', i))).collect();
    let band = turn(&mut graph, 'p', &band);
    let band = multiply(&mut graph, &exchange, &band);
    let band = turn(&mut graph, 'q', &band);
    let band = multiply(&mut graph, &exchange, &band);
    let band = turn(&mut graph, 'r', &band);
    (graph, band)
}

/// A rotation about z by one of the angles: `f_-m' = cos f_-m + sin f_m` and `f_m' = cos f_m - sin f_-m`.
fn turn(graph: &mut Graph, by: char, band: &[Value]) -> Vec<Value> {
    let l = band.len() / 2;
    let mut turned = band.to_vec();
    for m in 1..=l {
        let [cos, sin] = [0, 1].map(|k| graph.input((by, 2 * (m - 1) + k)));
        let (minus, plus) = (band[l - m], band[l + m]);
        let (a, b) = (graph.mul(cos, minus), graph.mul(sin, plus));
        turned[l - m] = graph.add(a, b);
        let (a, b) = (graph.mul(cos, plus), graph.mul(sin, minus));
        turned[l + m] = graph.add(a, signed(b, true));
    }
    turned
}

fn multiply(graph: &mut Graph, matrix: &[Vec<f64>], band: &[Value]) -> Vec<Value> {
    let row = |row: &Vec<f64>| {
        let entries = row.iter().zip(band).filter(|(entry, _)| **entry != 0.0);
        entries.fold(None, |sum, (entry, value)| {
            let term = graph.scale(*entry, *value);
            graph.add(sum, term)
        })
    };
    matrix.iter().map(row).collect()
}

/// The matrix that exchanges y and z in band `l`; it is symmetric.
fn exchange(l: usize) -> Vec<Vec<f64>> {
    let exchange = AxisPermutation::from_matrix(EXCHANGE).unwrap_or(AxisPermutation::IDENTITY);
    let column = |i: usize| {
        let mut f = vec![0.0_f64; coefficient_count(l + 1)];
        f[i] = 1.0;
        exchange.apply_in_place(&mut f);
        f[band_range(l)].iter().map(|c| if (c - c.round()).abs() < ROUNDING { c.round() } else { *c }).collect()
    };
    band_range(l).map(column).collect()
}
