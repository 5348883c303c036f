//! Zonal products: a zonal function about +z times a general one.

use std::collections::BTreeMap;

use lobe_sh::basis::coefficient_index;
use lobe_sh::product::gaunt_coefficient;

use crate::cover::{Edge, multiply_at_source};
use crate::graph::{Graph, Value, signed};

// c = h f with h = Σ_l z_l y_l0 is a product with a matrix that joins coefficients of equal m only, and whose entries
// depend on |m|:
//
//   c_lm = Σ_l' M^μ_ll' f_l'm        M^μ_ll' = M^μ_l'l = Σ_k z_k Γ(k0, lμ, l'μ)        μ = |m|
//
// so the entries are made once for both signs of m and both orders of l and l'.

/// The coefficients of the product of order `order`, from inputs `z` (one for each band) and `f`.
pub(crate) fn build(order: usize) -> (Graph, Vec<Value>) {
    let mut graph = Graph::default();
    let places: Vec<[usize; 3]> =
        (0..order).flat_map(|mu| (mu..order).flat_map(move |l| (mu..=l).map(move |k| [mu, k, l]))).collect();
    let mut edges = Vec::new();
    for (sink, &[mu, k, l]) in places.iter().enumerate() {
        for source in 0..order {
            let constant = gaunt_coefficient(
                coefficient_index(source, 0),
                coefficient_index(k, mu as isize),
                coefficient_index(l, mu as isize),
            );
            if constant != 0.0 {
                edges.push(Edge { source, sink, constant });
            }
        }
    }
    let matrix = entries(&mut graph, &edges, places.len());
    let entry: BTreeMap<[usize; 3], Value> = places.into_iter().zip(matrix).collect();
    let mut out = Vec::new();
    for l in 0..order {
        for m in -(l as isize)..=l as isize {
            let mu = m.unsigned_abs();
            let mut sum = None;
            for k in mu..order {
                let f = graph.input(('f', coefficient_index(k, m)));
                let product = graph.mul(entry[&[mu, k.min(l), k.max(l)]], f);
                sum = graph.add(sum, product);
            }
            out.push(sum);
        }
    }
    (graph, out)
}

/// The sums `Σ constant · z`, one for each sink.
fn entries(graph: &mut Graph, edges: &[Edge], count: usize) -> Vec<Value> {
    let mut sums = vec![None; count];
    let mut of_constant: BTreeMap<(usize, u64), Value> = BTreeMap::new();
    for (edge, at_source) in edges.iter().zip(multiply_at_source(edges)) {
        let z = graph.input(('z', edge.source));
        if at_source {
            let product = graph.scale(edge.constant, z);
            sums[edge.sink] = graph.add(sums[edge.sink], product);
        } else {
            let gathered = of_constant.entry((edge.sink, edge.constant.abs().to_bits())).or_default();
            *gathered = graph.add(*gathered, signed(z, edge.constant < 0.0));
        }
    }
    for ((sink, constant), gathered) in of_constant {
        let product = graph.scale(f64::from_bits(constant), gathered);
        sums[sink] = graph.add(sums[sink], product);
    }
    sums
}
