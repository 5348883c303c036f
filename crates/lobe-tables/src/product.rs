//! The products that have straight-line code: which factors and orders, and the function of each.

use crate::blocks;
use crate::graph::{Cost, Graph, Value};
use crate::plan::{self, Shape};
use crate::search;
use crate::text::{Function, HEADER};
use crate::zonal;

/// Orders that have products of their own.
const ORDERS: std::ops::RangeInclusive<usize> = 2..=6;

/// Mixed orders (factor, factor, product) that published techniques use; both orders of the factors.
const MIXED: [[usize; 3]; 8] = [[6, 6, 3], [6, 3, 3], [6, 3, 6], [3, 3, 5], [4, 4, 7], [3, 2, 3], [4, 3, 4], [2, 2, 3]];

/// The factors of a generated function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    General([usize; 3]),
    Square(usize),
    Zonal(usize),
}

/// A generated function.
pub(crate) struct Product {
    pub(crate) kind: Kind,
    graph: Graph,
    results: Vec<Value>,
}

/// Every product, made in parallel.
pub(crate) fn products() -> Vec<Product> {
    let general = ORDERS.map(|n| Kind::General([n; 3])).chain(MIXED.map(Kind::General));
    let kinds = general.chain(ORDERS.map(Kind::Square)).chain(ORDERS.map(Kind::Zonal));
    std::thread::scope(|scope| {
        let threads: Vec<_> = kinds.map(|kind| scope.spawn(move || Product::new(kind))).collect();
        threads
            .into_iter()
            .map(|thread| thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
            .collect()
    })
}

/// The products of two factors of one order, to that order.
pub(crate) fn of_one_order(products: &[Product]) -> impl Iterator<Item = (usize, Function<'_>)> {
    products.iter().filter_map(|product| match product.kind {
        Kind::General([a, b, out]) if a == b && a == out => Some((a, product.function())),
        _ => None,
    })
}

impl Kind {
    pub(crate) fn module(self) -> String {
        match self {
            Self::General([n, b, out]) if n == b && n == out => format!("general_{n}"),
            Self::General([a, b, out]) => format!("general_{a}_{b}_{out}"),
            Self::Square(n) => format!("square_{n}"),
            Self::Zonal(n) => format!("zonal_{n}"),
        }
    }

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::General(_) => "General",
            Self::Square(_) => "Square",
            Self::Zonal(_) => "Zonal",
        }
    }

    pub(crate) fn orders(self) -> [usize; 3] {
        match self {
            Self::General(orders) => orders,
            Self::Square(n) | Self::Zonal(n) => [n; 3],
        }
    }

    /// The numbers of coefficients: of the factors and of the product.
    pub(crate) fn lengths(self) -> [usize; 3] {
        let [a, b, out] = self.orders();
        let a = if let Self::Zonal(_) = self { a } else { a * a };
        [a, b * b, out * out]
    }
}

impl Product {
    fn new(kind: Kind) -> Self {
        let (graph, results) = match kind {
            Kind::Zonal(order) => zonal::build(order),
            Kind::General(orders) => gathered(Shape { orders, square: false }),
            Kind::Square(order) => gathered(Shape { orders: [order; 3], square: true }),
        };
        assert!(!results.iter().any(|&value| plan::is_negative(value)), "{kind:?} ends in a change of sign");
        Self { kind, graph, results }
    }

    pub(crate) fn cost(&self) -> Cost {
        self.graph.cost(&self.results)
    }

    pub(crate) fn source(&self) -> String {
        format!(
            "{HEADER}\nuse crate::scalar::Coefficient;\nuse crate::scalar::constant as k;\n\n{}",
            self.function().source()
        )
    }

    pub(crate) fn source_for_lanes(&self) -> String {
        let [a, b, out] = self.kind.lengths();
        let factors = match self.kind {
            Kind::Square(_) => format!("a: &[Lanes; {a}]"),
            Kind::Zonal(_) => format!("z: &[Lanes; {a}], f: &[Lanes; {b}]"),
            Kind::General(_) => format!("a: &[Lanes; {a}], b: &[Lanes; {b}]"),
        };
        let signature = format!("product<S: Simd>(simd: S, part: usize, {factors}, out: &mut [Lanes; {out}])");
        let function = Function { seen_by: "crate", signature, ..self.function() };
        format!(
            "{HEADER}\nuse pulp::Simd;\n\nuse crate::simd::{{Lanes, Wide, constant as k}};\n\n{}",
            function.source_for_lanes()
        )
    }

    /// Of one pair in `f32`, whose sums and products a machine fuses.
    pub(crate) fn source_to_fuse(&self) -> String {
        let [a, b, out] = self.kind.lengths();
        let signature = format!("product(a: &[f32; {a}], b: &[f32; {b}], out: &mut [f32; {out}])");
        let function = Function { seen_by: "crate", signature, ..self.function() };
        format!(
            "{HEADER}\nuse crate::product::fused_pair::Fuse as _;\nuse crate::scalar::constant as k;\n\n{}",
            function.source_to_fuse()
        )
    }

    fn function(&self) -> Function<'_> {
        let [a, b, out] = self.kind.lengths();
        let [order_a, order_b, order_out] = self.kind.orders();
        let (doc, arguments) = match self.kind {
            Kind::General(_) => (
                format!("The product of expansions of orders {order_a} and {order_b}, to order {order_out}."),
                format!("a: &[T; {a}], b: &[T; {b}]"),
            ),
            Kind::Square(n) => (format!("The square of an expansion of order {n}."), format!("a: &[T; {a}]")),
            Kind::Zonal(n) => (
                format!("The product of a zonal function about +z and an expansion of order {n}."),
                format!("z: &[T::Scalar; {a}], f: &[T; {b}]"),
            ),
        };
        Function {
            doc,
            seen_by: "super",
            signature: format!("product<T: Coefficient>({arguments}, out: &mut [T; {out}])"),
            graph: &self.graph,
            results: &self.results,
        }
    }
}

fn gathered(shape: Shape) -> (Graph, Vec<Value>) {
    let blocks = blocks::blocks(shape.orders);
    let chosen = search::choose(shape, &blocks);
    let chosen: Vec<&[plan::Gathered]> = chosen.iter().map(Vec::as_slice).collect();
    plan::build(shape, &blocks, &chosen)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::Op;
    use std::collections::BTreeMap;

    /// The results of arithmetic on given inputs.
    fn evaluate(graph: &Graph, results: &[Value], inputs: &BTreeMap<char, Vec<f64>>) -> Vec<f64> {
        let mut values = Vec::with_capacity(graph.len());
        for id in 0..graph.len() {
            values.push(match graph.op(id) {
                Op::Input((array, place)) => inputs[&array][place],
                Op::Scale(constant, x) => f64::from_bits(constant) * values[x],
                Op::Mul(x, y) => values[x] * values[y],
                Op::Add(x, y) => values[x] + values[y],
                Op::Sub(x, y) => values[x] - values[y],
            });
        }
        results.iter().map(|value| value.map_or(0.0, |term| values[term.id])).collect()
    }

    #[test]
    fn every_way_of_gathering_a_block_gives_the_product() {
        let shapes = [[2, 2, 2], [3, 3, 3], [4, 4, 4], [4, 3, 4], [3, 3, 5], [4, 4, 2]];
        for (orders, square) in shapes.map(|o| (o, false)).into_iter().chain([([3, 3, 3], true), ([4, 4, 4], true)]) {
            let shape = Shape { orders, square };
            let blocks = blocks::blocks(orders);
            let ways: Vec<_> = blocks.iter().map(|block| plan::ways(block, shape)).collect();
            let mut random = lobe_testkit::Random::new(7);
            for trial in 0..20 {
                let mut pick = |n: usize| random.next_u64() as usize % n;
                let chosen: Vec<&[plan::Gathered]> = ways.iter().map(|w| w[pick(w.len())].as_slice()).collect();
                let (graph, results) = plan::build(shape, &blocks, &chosen);
                let signs = results.iter().map(|value| value.is_some_and(|term| term.negative));
                let [a, b, out] = orders.map(|n| n * n);
                let (a, b) = (random.signed_vec(a), random.signed_vec(b));
                let b = if square { a.clone() } else { b };
                let mut expected = vec![0.0; out];
                lobe_sh::product::GauntTensor::new(orders[0], orders[1], orders[2]).product_into(&a, &b, &mut expected);
                let mine = evaluate(&graph, &results, &BTreeMap::from([('a', a), ('b', b)]));
                for (k, (mine, negative)) in mine.into_iter().zip(signs).enumerate() {
                    let mine = if negative { -mine } else { mine };
                    let difference = (mine - expected[k]).abs();
                    assert!(difference < 1e-13, "{shape:?}, trial {trial}, {k}: {mine} against {}", expected[k]);
                }
            }
        }
    }
}
