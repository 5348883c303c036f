//! Greedy factoring of SH products as published, for comparison: its counts are those of DirectXMath's products.

use std::collections::{BTreeMap, BTreeSet};

use crate::graph::Cost;

// Snyder (2006): take the pair (i, j) that the most triples (i, j, k) are left for; with d_k = Γ_ijk write
//
//   ta = Σ d_k a_k      c_i += ta b_j + tb a_j      t = a_i b_j + a_j b_i
//   tb = Σ d_k b_k      c_j += ta b_i + tb a_i      c_k += d_k t
//
// and strike the triples out. For i = j the second column has one line and t = a_i b_i; for i = j = k there is
// t alone. Of pairs with equally many triples the published counts take i = j first, then the smallest.

/// The cost of the product of two expansions whose triples `i <= j <= k` are factored so.
fn cost(mut triples: BTreeSet<[usize; 3]>) -> Cost {
    let mut cost = Cost::default();
    let mut begun = BTreeSet::new();
    while let Some((i, j, completions)) = best_pair(&triples) {
        let others = completions.iter().filter(|&&k| k != i && k != j).count();
        if i != j {
            cost.multiplications += 3 * others + 6;
            cost.additions += 2 * (others - 1) + 3;
        } else if others > 0 {
            cost.multiplications += 3 * others + 3;
            cost.additions += 2 * (others - 1) + 1;
        } else {
            cost.multiplications += 1;
        }
        let itself = completions.contains(&i);
        cost.multiplications += usize::from(itself);
        // The first term of a coefficient is no addition.
        let mut add = |k| cost.additions += usize::from(!begun.insert(k));
        completions.iter().for_each(|&k| add(k));
        if others > 0 {
            add(i);
            if i != j {
                add(j);
            }
        }
        for k in completions {
            let mut triple = [i, j, k];
            triple.sort_unstable();
            triples.remove(&triple);
        }
    }
    cost
}

fn best_pair(triples: &BTreeSet<[usize; 3]>) -> Option<(usize, usize, Vec<usize>)> {
    let mut completions: BTreeMap<(usize, usize), BTreeSet<usize>> = BTreeMap::new();
    for &[i, j, k] in triples {
        for (i, j, k) in [(i, j, k), (i, k, j), (j, k, i)] {
            completions.entry((i, j)).or_default().insert(k);
        }
    }
    let first = |&(i, j): &(usize, usize)| (i == j, std::cmp::Reverse((i, j)));
    let best = completions.into_iter().max_by_key(|(pair, all)| (all.len(), first(pair)))?;
    Some((best.0.0, best.0.1, best.1.into_iter().collect()))
}

#[test]
fn the_published_factoring_needs_the_published_operations() {
    let [orders, multiplications, additions] =
        ["/triple/order", "/triple/greedy_mul", "/triple/greedy_add"].map(lobe_testkit::golden_f64s);
    for (n, order) in orders.into_iter().enumerate() {
        let tensor = lobe_sh::product::GauntTensor::new(order as usize, order as usize, order as usize);
        let triples =
            tensor.coefficients().iter().map(|t| [t.i, t.j, t.k]).filter(|[i, j, k]| i <= j && j <= k).collect();
        let cost = cost(triples);
        let counted = [cost.multiplications as f64, cost.additions as f64];
        assert_eq!(counted, [multiplications[n], additions[n]], "order {order}");
    }
}
