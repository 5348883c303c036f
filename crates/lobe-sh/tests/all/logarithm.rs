//! Logarithms: what the exponential restores of a function from its own.

use lobe_sh::exponential::{ExpMethod, Exponential, LOG_CLAMP, logarithm};
use lobe_sh::{Dir, ShVec};

use crate::exponential::{difference, visible};

/// What two spheres of 0.6 and 0.4, 0.9 apart, in a sky that is brighter by 2, are off by when they come back, at orders 3 to 8; computed apart
/// from this code too, by a dense eigenvalue solver.
const COMES_BACK: [f64; 6] = [2.397e-7, 2.136e-6, 5.313e-6, 6.722e-6, 7.300e-6, 9.606e-6];

/// What half the contrast leaves of it, at least and at most: a sixteenth, and a part of that by the fifth power.
const LEFT_OF_HALF: [f64; 2] = [1.0 / 24.0, 1.0 / 16.0];

/// What comes back of orders 1 and 2, where the products of powers associate.
const BACK_TO_ROUNDING: f64 = 1e-13;

#[test]
fn what_comes_back_is_off_by_the_fourth_power_of_the_contrast() {
    for order in 1..=8 {
        let exponential = Exponential::new(order, ExpMethod::Eigen);
        let spheres = &visible(order, Dir::Z, 0.6) + &visible(order, Dir::from_angles(0.9, 0.0), 0.4);
        let off = |contrast: f64| {
            // 3 + contrast (V_1 - 1 + V_2 - 1).
            let mut g = spheres.clone();
            g *= contrast;
            g += &ShVec::constant(order, 3.0 - 2.0 * contrast);
            difference(&exponential.of(&logarithm(&g, LOG_CLAMP)), &g)
        };
        let errors = [1.0, 0.5].map(off);
        println!("order {order}: {errors:?}");
        if order <= 2 {
            assert!(errors[0] < BACK_TO_ROUNDING, "order {order}: {errors:?}");
            continue;
        }
        let expected = COMES_BACK[order - 3];
        assert!((errors[0] / expected - 1.0).abs() < 1e-3, "order {order}: {} against {expected}", errors[0]);
        let left = errors[1] / errors[0];
        assert!(left > LEFT_OF_HALF[0] && left < LEFT_OF_HALF[1], "order {order}: {left} is left of half the contrast");
    }
}
