//! Identities between the operations, for any order, expansion and rotation.

use lobe_sh::basis::{complex_from_real, real_from_complex};
use lobe_sh::expansion::eval_with_gradient;
use lobe_sh::projection::least_squares;
use lobe_sh::sphere::SphereQuadrature;
use lobe_sh::{Dir, Expansion as _, Rotation, ShVec, Zonal};
use lobe_testkit::fibonacci_sphere;
use proptest::prelude::*;

/// Sums of some hundred terms of size 10.
const TOLERANCE: f64 = 1e-11;

/// Directions over the whole sphere, poles and seam included.
fn dir() -> impl Strategy<Value = Dir> {
    let anywhere = (-1.0..=1.0_f64, -3.2..3.2_f64).prop_map(|(z, phi)| Dir::from_angles(z.acos(), phi));
    let axes = prop::sample::select(vec![Dir::X, -Dir::X, Dir::Y, -Dir::Y, Dir::Z, -Dir::Z]);
    prop_oneof![4 => anywhere, 1 => axes]
}

fn rotation() -> impl Strategy<Value = Rotation> {
    (dir(), -7.0..7.0).prop_map(|(axis, angle)| Rotation::from_axis_angle(axis, angle))
}

/// Expansions of orders 1 to 8.
fn expansion() -> impl Strategy<Value = ShVec<f64>> {
    (1..=8_usize).prop_flat_map(|order| {
        prop::collection::vec(-1.0..1.0, order * order).prop_filter_map("n² coefficients", ShVec::from_vec)
    })
}

fn zonal() -> impl Strategy<Value = Zonal> {
    prop::collection::vec(-1.0..1.0, 0..9).prop_map(Zonal::new)
}

fn distance(a: &ShVec<f64>, b: &ShVec<f64>) -> f64 {
    let difference = a - b;
    difference.dot(&difference).sqrt()
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(128) })]

    #[test]
    fn convolution_commutes_with_rotation(f in expansion(), kernel in zonal(), turn in rotation()) {
        let (a, b) = (f.rotated(&turn).convolved(&kernel), f.convolved(&kernel).rotated(&turn));
        prop_assert!(distance(&a, &b) < TOLERANCE, "{a:?} against {b:?}");
    }

    #[test]
    fn rotation_keeps_dot_products(f in expansion(), g in expansion(), turn in rotation()) {
        let (before, after) = (f.dot(&g), f.rotated(&turn).dot(&g.rotated(&turn)));
        prop_assert!((before - after).abs() < TOLERANCE, "{before} became {after}");
    }

    #[test]
    fn dot_products_are_integrals(f in expansion(), g in expansion()) {
        let rule = SphereQuadrature::of_degree(f.order() + g.order() - 2);
        let (sum, integral) = (f.dot(&g), rule.integrate(|s| f.eval(s) * g.eval(s)));
        prop_assert!((sum - integral).abs() < TOLERANCE, "{sum} against {integral}");
    }

    #[test]
    fn gradients_turn_with_the_function(f in expansion(), turn in rotation(), s in dir()) {
        let (value, gradient) = eval_with_gradient(&f, s);
        let (turned_value, turned) = eval_with_gradient(&f.rotated(&turn), turn.rotate_dir(s));
        prop_assert!((value - turned_value).abs() < TOLERANCE, "value {value} became {turned_value}");
        for (row, found) in turn.matrix().iter().zip(turned) {
            let expected: f64 = row.iter().zip(gradient).map(|(r, g)| r * g).sum();
            prop_assert!((found - expected).abs() < 10.0 * TOLERANCE, "gradient {gradient:?} became {turned:?}");
        }
    }

    #[test]
    fn a_lobe_turns_as_its_axis_does(h in zonal(), axis in dir(), turn in rotation()) {
        let (a, b) = (h.towards(turn.rotate_dir(axis), 1.0), h.towards(axis, 1.0).rotated(&turn));
        prop_assert!(distance(&a, &b) < TOLERANCE, "{a:?} against {b:?}");
    }

    #[test]
    fn the_zonal_part_about_an_axis_has_the_value_there(f in expansion(), axis in dir()) {
        let (part, value) = (Zonal::about(axis, &f).eval(1.0), f.eval(axis));
        prop_assert!((part - value).abs() < TOLERANCE, "{part} against {value}");
    }

    #[test]
    fn the_complex_form_loses_nothing(f in expansion()) {
        let back = real_from_complex(&complex_from_real(f.coefficients()));
        prop_assert!(distance(&ShVec::from_vec(back).expect("n² coefficients"), &f) < 1e-14, "{f:?}");
    }

    #[test]
    fn samples_give_back_the_expansion(f in expansion()) {
        let samples = fibonacci_sphere(200).into_iter().map(Dir::from_unit).map(|s| (s, f.eval(s), 1.0 + s.x()));
        let fit = least_squares(f.order(), samples);
        prop_assert!(distance(&fit.sh, &f) < TOLERANCE, "{fit:?} against {f:?}");
    }
}
