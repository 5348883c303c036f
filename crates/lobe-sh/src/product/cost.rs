//! The operations of the generated products, counted in their source and compared with published counts.

/// The factors of a generated product.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ProductKind {
    /// Two expansions.
    General,
    /// An expansion with itself.
    Square,
    /// A zonal function about +z and an expansion.
    Zonal,
}

/// The operations of one generated product, as its generator counted them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ProductCost {
    /// The kind of product.
    pub(crate) kind: ProductKind,
    /// The orders of the factors and of the product.
    pub(crate) orders: [usize; 3],
    /// Multiplications, those by a constant included.
    pub(crate) multiplications: usize,
    /// Additions and subtractions.
    pub(crate) additions: usize,
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::expansion::{Expansion as _, ShVec};
    use crate::product::gaunt::GauntTensor;
    use crate::product::generated::PRODUCT_COSTS;

    /// For coefficients of size one in `f64`: sums of some thousand terms.
    const ERROR: f64 = 1e-12;

    fn random(order: usize, seed: u64) -> ShVec<f64> {
        ShVec::from_vec(lobe_testkit::Random::new(seed).signed_vec(order * order)).expect("n² coefficients")
    }

    fn assert_close(mine: &ShVec<f64>, expected: &ShVec<f64>, error: f64, what: &str) {
        assert_eq!(mine.order(), expected.order(), "{what}: orders");
        for (i, (a, b)) in mine.coefficients().iter().zip(expected.coefficients()).enumerate() {
            assert!((a - b).abs() <= error, "{what}, coefficient {i}: {a} against {b}");
        }
    }

    /// Published multiplications and additions that ours must not exceed, and where they stand: general products in the
    /// comments of DirectXMath's `XMSHMultiply` and, at order 6 and for 6 x 6 to 3, in Sloan's "Stupid SH Tricks";
    /// squares and zonal products as counted for the same method.
    const PUBLISHED: [(ProductKind, [usize; 3], usize, usize); 15] = [
        (ProductKind::General, [2, 2, 2], 20, 6),
        (ProductKind::General, [3, 3, 3], 120, 74),
        (ProductKind::General, [4, 4, 4], 399, 274),
        (ProductKind::General, [5, 5, 5], 1135, 860),
        (ProductKind::General, [6, 6, 6], 2527, 1995),
        (ProductKind::General, [6, 6, 3], 933, 676),
        (ProductKind::Square, [2, 2, 2], 14, 3),
        (ProductKind::Square, [3, 3, 3], 77, 43),
        (ProductKind::Square, [4, 4, 4], 246, 157),
        (ProductKind::Square, [5, 5, 5], 699, 507),
        (ProductKind::Square, [6, 6, 6], 1556, 1189),
        (ProductKind::Zonal, [3, 3, 3], 34, 15),
        (ProductKind::Zonal, [4, 4, 4], 77, 41),
        (ProductKind::Zonal, [5, 5, 5], 159, 99),
        (ProductKind::Zonal, [6, 6, 6], 279, 187),
    ];

    /// Mixed orders have no published counts; ours need fewer than one multiplication and one addition for each of the
    /// two uses of an entry of the tensor, its entries being known.
    const NAIVE: [([usize; 3], usize); 8] = [
        ([6, 3, 3], 162),
        ([6, 3, 6], 703),
        ([6, 6, 3], 703),
        ([3, 3, 5], 162),
        ([4, 4, 7], 708),
        ([3, 2, 3], 37),
        ([4, 3, 4], 215),
        ([2, 2, 3], 21),
    ];

    fn cost(kind: ProductKind, orders: [usize; 3]) -> ProductCost {
        let found = PRODUCT_COSTS.iter().find(|cost| cost.kind == kind && cost.orders == orders);
        *found.unwrap_or_else(|| panic!("no generated {kind:?} product of orders {orders:?}"))
    }

    #[test]
    fn products_cost_no_more_than_published_ones() {
        for (kind, orders, multiplications, additions) in PUBLISHED {
            let mine = cost(kind, orders);
            assert!(
                mine.multiplications <= multiplications && mine.additions <= additions,
                "{mine:?} against {multiplications} multiplications and {additions} additions"
            );
        }
    }

    #[test]
    fn mixed_orders_cost_less_than_the_tensor() {
        for (orders, entries) in NAIVE {
            let mine = cost(ProductKind::General, orders);
            assert!(
                mine.multiplications < 2 * entries && mine.additions < entries,
                "{mine:?} against {entries} entries of the tensor"
            );
        }
    }

    /// The source of a generated product.
    fn source(cost: &ProductCost) -> String {
        let [a, b, out] = cost.orders;
        let orders = if a == b && b == out { format!("{a}") } else { format!("{a}_{b}_{out}") };
        let kind = format!("{:?}", cost.kind).to_lowercase();
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("src/product/generated/{kind}_{orders}.rs"));
        std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
    }

    #[test]
    fn the_source_holds_as_many_operators_as_the_table_says() {
        for cost in PRODUCT_COSTS {
            let source = source(cost);
            let body = source.split_once(") {\n").unwrap_or_else(|| panic!("{cost:?}: a function")).1;
            let count = |operators: &[&str]| operators.iter().map(|o| body.matches(o).count()).sum::<usize>();
            let counted = (count(&[" * ", ".scale("]), count(&[" + ", " - "]));
            assert_eq!(counted, (cost.multiplications, cost.additions), "{cost:?}");
            // Nothing computes in any other way, and no sign is changed on its own.
            for other in ["/", "(-", "= -", "mul_add", "sqrt"] {
                assert_eq!(body.matches(other).count(), 0, "{cost:?}: {other:?} in the source");
            }
        }
    }

    #[test]
    fn generated_products_equal_the_tensor() {
        for cost in PRODUCT_COSTS.iter().filter(|cost| cost.kind == ProductKind::General) {
            let [n_a, n_b, n_out] = cost.orders;
            for seed in 0..5 {
                let (a, b) = (random(n_a, 100 + seed), random(n_b, 200 + seed));
                let mut expected = ShVec::zero(n_out);
                let tensor = GauntTensor::new(n_a, n_b, n_out);
                tensor.product_into(a.coefficients(), b.coefficients(), expected.coefficients_mut());
                let what = format!("{:?}", cost.orders);
                assert_close(&a.product(&b, n_out), &expected, ERROR, &what);
                assert_close(&b.product(&a, n_out), &expected, ERROR, &format!("{what} exchanged"));
            }
        }
    }
}
