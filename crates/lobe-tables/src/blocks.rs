//! Gaunt coefficients in blocks: the tensor as products of complex numbers, a fourth of its size.

use lobe_sh::basis::coefficient_index;
use lobe_sh::product::gaunt_coefficient;

/// The two basis functions `y_l^μ`, `y_l^-μ` of one `μ = |m|`, whose coefficients are read as a complex number
/// `z = f_l^μ + i f_l^-μ`, real for `μ = 0`. Ordered by `μ`, then by band.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct Node {
    pub(crate) mu: usize,
    pub(crate) l: usize,
}

impl Node {
    /// Real numbers in `z`.
    pub(crate) fn width(self) -> usize {
        if self.mu == 0 { 1 } else { 2 }
    }
}

// The four integrals of the cosines and sines of three μ with μ3 = μ1 + μ2 differ in sign alone, so that in
//
//   ∫ f g h ds = Σ Γ_ijk f_i g_j h_k
//
// they make one real part, D Re(z1 z2 z̄3), with D the integral of the three cosines. The triple of nodes stands for
// all distributions of f, g and h over it. With μ1 = 0 or all μ = 0 the formula holds with z1, or all z, real.

/// `D` for three nodes, ascending, `μ3 = μ1 + μ2`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Block {
    pub(crate) nodes: [Node; 3],
    pub(crate) constant: f64,
}

/// The non-zero blocks that products of two factors of orders `orders[0]`, `orders[1]`, to order `orders[2]`, need.
pub(crate) fn blocks(orders: [usize; 3]) -> Vec<Block> {
    let order = orders.into_iter().max().unwrap_or(0);
    let nodes: Vec<Node> = (0..order).flat_map(|mu| (mu..order).map(move |l| Node { mu, l })).collect();
    let mut blocks = Vec::new();
    for (n, &first) in nodes.iter().enumerate() {
        for &second in &nodes[n..] {
            let mu = first.mu + second.mu;
            // With μ1 = 0 the other two are interchangeable.
            let lowest = if first.mu == 0 { second.l } else { mu };
            for third in (lowest..order).map(|l| Node { mu, l }) {
                let [i, j, k] = [first, second, third].map(|node| coefficient_index(node.l, node.mu as isize));
                let block = Block { nodes: [first, second, third], constant: gaunt_coefficient(i, j, k) };
                if mu < order && block.constant != 0.0 && needed(block.nodes, orders) {
                    blocks.push(block);
                }
            }
        }
    }
    blocks
}

/// Whether two factors and the product can be distributed over the nodes.
fn needed([x, y, z]: [Node; 3], orders: [usize; 3]) -> bool {
    let fits = |nodes: [Node; 3]| nodes.into_iter().zip(orders).all(|(node, order)| node.l < order);
    [[x, y, z], [x, z, y], [y, x, z], [y, z, x], [z, x, y], [z, y, x]].into_iter().any(fits)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_stand_for_every_entry_of_the_tensor() {
        for order in 1..=6 {
            let entries: usize = blocks([order; 3])
                .iter()
                .map(|block| {
                    let [x, y, z] = block.nodes;
                    let real = if y.mu == 0 {
                        1
                    } else if x.mu == 0 {
                        2
                    } else {
                        4
                    };
                    let permutations = if x == z {
                        1
                    } else if x == y || y == z {
                        3
                    } else {
                        6
                    };
                    real * permutations
                })
                .sum();
            let tensor = lobe_sh::product::GauntTensor::new(order, order, order).coefficients().len();
            assert_eq!(entries, tensor, "order {order}");
        }
    }
}
