//! Products of expansions by every route, against goldens, quadrature and the laws of algebra.

use lobe_sh::basis::coefficient_count;
use lobe_sh::product::{GauntTensor, product_into, product_on_grid, square_into, zonal_product_into};
use lobe_sh::{Coefficient, Dir, Expansion, Rgb, ShVec, Zonal, project};
use lobe_testkit::{Random, golden_f64s};
use proptest::prelude::*;

/// For coefficients of size one in `f64`: sums of some thousand terms.
const ERROR: f64 = 1e-12;

/// The same in `f32`: some hundred terms of size one for each coefficient, half a unit of 1.2e-7 lost in each.
const ERROR_F32: f64 = 2e-5;

fn random(order: usize, seed: u64) -> ShVec<f64> {
    ShVec::from_vec(Random::new(seed).signed_vec(coefficient_count(order))).expect("n² coefficients")
}

fn assert_close(mine: &ShVec<f64>, expected: &ShVec<f64>, error: f64, what: &str) {
    assert_eq!(mine.order(), expected.order(), "{what}: orders");
    for i in 0..coefficient_count(mine.order()) {
        let (a, b) = (mine[i], expected[i]);
        assert!((a - b).abs() <= error, "{what}, coefficient {i}: {a} against {b}");
    }
}

/// The product by the definition: values multiplied, then projected at the degree of the integrand.
fn by_quadrature(a: &ShVec<f64>, b: &ShVec<f64>, order: usize) -> ShVec<f64> {
    project(order, a.order() + b.order() - 2, |s| a.eval(s) * b.eval(s))
}

#[test]
fn golden_products_come_out() {
    for n in 2..=6_usize {
        let rule = |p: usize, q: usize, modulus: usize, shift: f64, scale: f64| {
            let value = |i: usize| (((p * i + q) % modulus) as f64 - shift) / scale;
            ShVec::from_vec((0..coefficient_count(n)).map(value).collect()).unwrap()
        };
        assert_eq!(lobe_testkit::golden(&format!("/product/{n}/rule_a")), "((37i+11)%19-9)/10", "factor a");
        assert_eq!(lobe_testkit::golden(&format!("/product/{n}/rule_b")), "((23i+5)%17-8)/8", "factor b");
        let (a, b) = (rule(37, 11, 19, 9.0, 10.0), rule(23, 5, 17, 8.0, 8.0));
        let golden = ShVec::from_vec(golden_f64s(&format!("/product/{n}/c"))).unwrap();
        assert_close(&a.product(&b, n), &golden, ERROR, &format!("order {n}"));
    }
}

#[test]
fn products_equal_quadrature_at_every_mix_of_orders() {
    for n_a in 1..=7 {
        for n_b in 1..=7 {
            let (a, b) = (random(n_a, 10 + n_a as u64), random(n_b, 30 + n_b as u64));
            let expected = by_quadrature(&a, &b, 7);
            for n_out in 1..=7 {
                let what = format!("orders {n_a} x {n_b} -> {n_out}");
                assert_close(&a.product(&b, n_out), &expected.resized(n_out), ERROR, &what);
            }
        }
    }
    for [n_a, n_b, n_out] in [[9, 8, 10], [10, 10, 10], [11, 3, 4], [4, 4, 12], [16, 12, 14]] {
        let (a, b) = (random(n_a, 50), random(n_b, 51));
        let what = format!("orders {n_a} x {n_b} -> {n_out}");
        assert_close(&a.product(&b, n_out), &by_quadrature(&a, &b, n_out), ERROR, &what);
    }
}

#[test]
fn order_64_products_are_exact_too() {
    let (a, b) = (random(64, 1), random(64, 2));
    let full = a.product(&b, 127);
    for v in lobe_testkit::directions() {
        let s = Dir::from_unit(v);
        let (mine, expected) = (full.eval(s), a.eval(s) * b.eval(s));
        // The values themselves reach some hundreds.
        assert!((mine - expected).abs() < 1e-9, "towards {v:?}: {mine} against {expected}");
    }
    assert_close(&a.product(&b, 64), &full.resized(64), 1e-11, "cut off at order 64");
}

#[test]
fn products_without_coefficients_are_zero() {
    let nothing = ShVec::<f64>::zero(0);
    assert_eq!(nothing.product(&random(3, 1), 3), ShVec::zero(3), "a factor of order 0");
    assert_eq!(nothing.product(&random(11, 1), 3), ShVec::zero(3), "a factor of order 0 on a grid");
    assert_eq!(random(3, 1).product(&random(3, 2), 0), nothing, "a product of order 0");
}

#[test]
fn squares_equal_products_with_itself() {
    for n in 1..=12 {
        let a = random(n, n as u64);
        let mut square = ShVec::zero(n);
        square_into(a.coefficients(), square.coefficients_mut());
        assert_close(&square, &a.product(&a, n), ERROR, &format!("order {n}"));
    }
    let a = random(3, 1);
    let mut square = ShVec::zero(5);
    square_into(a.coefficients(), square.coefficients_mut());
    assert_close(&square, &a.product(&a, 5), ERROR, "order 3, to order 5");
}

#[test]
fn zonal_products_equal_products_with_the_expansion() {
    for n_z in 0..=8 {
        for n in 0..=8 {
            let zonal = Zonal::new(Random::new(n_z as u64).signed_vec(n_z));
            let (b, f) = (random(n, 7), zonal.towards(Dir::Z, 1.0));
            let mut mine = ShVec::zero(n);
            zonal_product_into(&zonal, b.coefficients(), mine.coefficients_mut());
            assert_close(&mine, &f.product(&b, n), ERROR, &format!("zonal order {n_z}, order {n}"));
        }
    }
}

#[test]
fn the_unit_element_is_the_constant_1() {
    for n in 1..=12 {
        let f = random(n, n as u64);
        assert_close(&f.product(&ShVec::constant(n, 1.0), n), &f, ERROR, &format!("order {n}"));
    }
}

#[test]
fn truncated_products_do_not_associate() {
    for n in 2..=6 {
        let [f, g, h] = [1, 2, 3].map(|seed| random(n, seed));
        let left = f.product(&g, n).product(&h, n);
        let right = f.product(&g.product(&h, n), n);
        let largest = (0..coefficient_count(n)).map(|i| (left[i] - right[i]).abs()).fold(0.0, f64::max);
        assert!(largest > 1e-3, "order {n}: (f g) h and f (g h) differ by {largest} only");
        let exact = f.product(&g, 2 * n - 1).product(&h, n);
        assert_close(&f.product(&g.product(&h, 2 * n - 1), n), &exact, ERROR, "untruncated products associate");
    }
}

#[test]
fn a_grid_equals_a_chain_of_untruncated_products() {
    for orders in [&[3, 3][..], &[2, 3, 4], &[4, 4, 4, 4], &[1, 6, 2, 3, 2]] {
        let factors: Vec<ShVec<f64>> = orders.iter().enumerate().map(|(k, &n)| random(n, k as u64)).collect();
        let slices: Vec<&[f64]> = factors.iter().map(Expansion::coefficients).collect();
        let mut chain = factors[0].clone();
        for factor in &factors[1..] {
            chain = chain.product(factor, chain.order() + factor.order() - 1);
        }
        for n in [1, 3, chain.order(), chain.order() + 2] {
            let what = format!("orders {orders:?} -> {n}");
            assert_close(&product_on_grid(&slices, n), &chain.resized(n), ERROR, &what);
        }
    }
}

#[test]
fn a_chain_of_truncated_products_differs_from_the_grid() {
    let [f, g, h] = [1, 2, 3].map(|seed| random(4, seed));
    let grid = product_on_grid(&[f.coefficients(), g.coefficients(), h.coefficients()], 4);
    let chain = f.product(&g, 4).product(&h, 4);
    let largest = (0..16).map(|i| (grid[i] - chain[i]).abs()).fold(0.0, f64::max);
    assert!(largest > 1e-3, "they differ by {largest} only");
    let other_way = product_on_grid(&[h.coefficients(), f.coefficients(), g.coefficients()], 4);
    assert_close(&other_way, &grid, ERROR, "another order of the factors");
}

#[test]
fn one_factor_or_none_on_a_grid_is_what_it_says() {
    let f = random(5, 1);
    assert_close(&product_on_grid(&[f.coefficients()], 5), &f, ERROR, "one factor");
    assert_close(&product_on_grid::<f64>(&[], 2), &ShVec::constant(2, 1.0), ERROR, "no factors");
}

/// Products of coefficients `T` by every function, compared with the tensor in `f64`, channel by channel.
fn check_type<T: Coefficient>(n: usize, seed: u64, error: f64) -> Result<(), TestCaseError> {
    let mut random = Random::new(seed);
    let mut expansion = || {
        let coefficient = |_| T::from_channels(|_| lobe_sh::Real::from_f64(random.signed()));
        ShVec::from_vec((0..coefficient_count(n)).map(coefficient).collect()).expect("n² coefficients")
    };
    let (a, b): (ShVec<T>, ShVec<T>) = (expansion(), expansion());
    let zonal = Zonal::new(Random::new(seed).signed_vec(n));
    let [mut general, mut square, mut by_zonal] = [(); 3].map(|()| ShVec::<T>::zero(n));
    product_into(a.coefficients(), b.coefficients(), general.coefficients_mut());
    square_into(a.coefficients(), square.coefficients_mut());
    zonal_product_into(&zonal, a.coefficients(), by_zonal.coefficients_mut());
    let tensor = GauntTensor::new(n, n, n);
    for channel in 0..T::CHANNELS {
        let alone = |f: &ShVec<T>| f.map(|c| lobe_sh::Real::to_f64(c.channel(channel)));
        for (what, mine, x, y) in [
            ("a b", &general, alone(&a), alone(&b)),
            ("a a", &square, alone(&a), alone(&a)),
            ("z a", &by_zonal, zonal.towards(Dir::Z, 1.0), alone(&a)),
        ] {
            let mut expected = ShVec::zero(n);
            tensor.product_into(x.coefficients(), y.coefficients(), expected.coefficients_mut());
            let mine = alone(mine);
            for i in 0..coefficient_count(n) {
                let (p, q) = (mine[i], expected[i]);
                prop_assert!((p - q).abs() < error, "{what}, order {n}, coefficient {i}: {p} against {q}");
            }
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 32, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn products_of_f32_are_those_of_f64(n in 1..=8_usize, seed: u64) {
        check_type::<f32>(n, seed, ERROR_F32)?;
    }

    #[test]
    fn products_of_f64_are_those_of_the_tensor(n in 1..=8_usize, seed: u64) {
        check_type::<f64>(n, seed, ERROR)?;
    }

    #[test]
    fn channels_of_colors_multiply_each_alone(n in 1..=8_usize, seed: u64) {
        check_type::<Rgb<f64>>(n, seed, ERROR)?;
        check_type::<Rgb<f32>>(n, seed, ERROR_F32)?;
    }

    #[test]
    fn products_commute_and_distribute(n in 1..=7_usize, seed: u64) {
        let [f, g, h] = [0, 1, 2].map(|k| random(n, seed.wrapping_add(k)));
        let commuted = (&f.product(&g, n), &g.product(&f, n));
        let distributed = (&f.product(&(&g + &h), n), &(&f.product(&g, n) + &f.product(&h, n)));
        for (what, (x, y)) in [("f g = g f", commuted), ("f (g + h) = f g + f h", distributed)] {
            for i in 0..coefficient_count(n) {
                prop_assert!((x[i] - y[i]).abs() < ERROR, "{what}, {i}: {} against {}", x[i], y[i]);
            }
        }
    }
}
