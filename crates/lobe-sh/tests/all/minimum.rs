//! The certified minimum against searches that are independent of it, against closed forms, and where nothing is
//! unique.

use std::f64::consts::PI;

use lobe_sh::expansion::eval_with_gradient;
use lobe_sh::extrema::{Extremum, certified_maximum, certified_minimum};
use lobe_sh::{Dir, Expansion, Rotation, ShVec, Zonal};
use lobe_testkit::{Random, directions, fibonacci_sphere};

const TOLERANCE: f64 = 1e-6;

fn rms(f: &impl Expansion<f64>) -> f64 {
    (f.dot(f) / (4.0 * PI)).sqrt()
}

/// The least value on a grid, 40 points for each coefficient, its three lowest points followed downhill by the gradient
/// alone.
fn brute_force(f: &ShVec<f64>, grid: &[[f64; 3]], components: &[Vec<f64>; 3], values: &mut [f64]) -> f64 {
    f.eval_many_into(components.each_ref().map(Vec::as_slice), values);
    let mut order: Vec<usize> = (0..grid.len()).collect();
    order.select_nth_unstable_by(3, |&a, &b| values[a].total_cmp(&values[b]));
    order[..3].iter().map(|&k| descended(f, Dir::from_unit(grid[k]))).fold(f64::INFINITY, f64::min)
}

/// Steps against the gradient, shortened until they go down, lengthened where they do.
fn descended(f: &ShVec<f64>, mut s: Dir) -> f64 {
    let (mut value, mut gradient) = eval_with_gradient(f, s);
    let mut step = 1e-2;
    for _ in 0..400 {
        let v = s.to_array();
        let Some(next) = Dir::new([0, 1, 2].map(|k| v[k] - step * gradient[k])) else { break };
        let (lower, slope) = eval_with_gradient(f, next);
        if lower < value {
            let settled = value - lower < 1e-12;
            (s, value, gradient) = (next, lower, slope);
            step *= 1.5;
            if settled {
                break;
            }
        } else {
            step *= 0.3;
            if step < 1e-12 {
                break;
            }
        }
    }
    value
}

fn assert_holds(min: &Extremum, least: f64, f: &impl Expansion<f64>, what: &str) {
    let rms = rms(f);
    assert!(min.lo <= least && least <= min.hi + 2.0 * TOLERANCE * rms, "{what}: {min:?} against {least}");
    assert!(min.hi - min.lo <= TOLERANCE * rms, "{what}: {min:?} is wider than 1e-6 of {rms}");
    let shown = f.eval(min.dir);
    assert!(min.lo <= shown && shown <= min.hi, "{what}: {shown} towards {:?} of {min:?}", min.dir);
}

/// Random functions: white, like light that fades band by band, and with a strong mean.
fn random_function(random: &mut Random, order: usize, kind: usize) -> ShVec<f64> {
    let mut f = ShVec::from_vec(random.signed_vec(order * order)).unwrap();
    for l in 0..order {
        let factor = match kind % 3 {
            0 => 1.0,
            1 => 1.0 / (1.0 + (l * l) as f64),
            _ => 20.0 * 0.4_f64.powi(l as i32),
        };
        f.band_mut(l).iter_mut().for_each(|c| *c *= factor);
    }
    f
}

fn check_random_functions(order: usize, count: usize) {
    let grid = fibonacci_sphere(40 * order * order);
    let components = [0, 1, 2].map(|k| grid.iter().map(|v| v[k]).collect::<Vec<f64>>());
    let mut values = vec![0.0; grid.len()];
    let mut random = Random::new(order as u64);
    for case in 0..count {
        let f = random_function(&mut random, order, case);
        let least = brute_force(&f, &grid, &components, &mut values);
        let min = certified_minimum(f.coefficients(), TOLERANCE);
        assert_holds(&min, least, &f, &format!("order {order}, case {case}"));
    }
}

macro_rules! random_functions {
    ($($name:ident $order:literal $count:literal),*) => {$(
        #[test]
        fn $name() {
            check_random_functions($order, $count);
        }
    )*};
}

// 10000 in all.
random_functions!(
    the_interval_holds_the_brute_force_minimum_at_order_2 2 2000, the_interval_holds_the_brute_force_minimum_at_order_3 3 2000,
    the_interval_holds_the_brute_force_minimum_at_order_4 4 1500, the_interval_holds_the_brute_force_minimum_at_order_5 5 1500,
    the_interval_holds_the_brute_force_minimum_at_order_6 6 1200, the_interval_holds_the_brute_force_minimum_at_order_7 7 800,
    the_interval_holds_the_brute_force_minimum_at_order_8 8 500, the_interval_holds_the_brute_force_minimum_at_order_9 9 300,
    the_interval_holds_the_brute_force_minimum_at_order_10 10 200
);

/// The least value of a zonal function: a dense search in one variable, refined by golden sections.
fn zonal_minimum(z: &Zonal) -> f64 {
    let at = |theta: f64| z.eval(theta.cos());
    let steps = 4000;
    let best =
        (0..=steps).min_by(|&a, &b| at(PI * f64::from(a) / 4e3).total_cmp(&at(PI * f64::from(b) / 4e3))).unwrap();
    let (mut a, mut b) = (PI * f64::from(best - 1) / 4e3, PI * f64::from(best + 1) / 4e3);
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    for _ in 0..80 {
        let (p, q) = (b - ratio * (b - a), a + ratio * (b - a));
        if at(p) < at(q) { b = q } else { a = p }
    }
    at(0.5 * (a + b))
}

#[test]
fn rings_of_equal_minima_are_found_about_every_axis() {
    let mut random = Random::new(3);
    for order in [2, 3, 4, 6, 10] {
        // An impulse, whose negative rings are the reason for all this, and something random.
        let impulse = Zonal::about(Dir::Z, &ShVec::impulse(order, Dir::Z, 1.0));
        for z in [impulse, Zonal::new(random.signed_vec(order))] {
            let least = zonal_minimum(&z);
            let axes = [Dir::X, Dir::Y, -Dir::Z, Dir::from_unit(random.direction())];
            for axis in &axes[if order > 6 { 2 } else { 0 }..] {
                let f = z.towards(*axis, 1.0);
                let min = certified_minimum(f.coefficients(), TOLERANCE);
                assert_holds(&min, least, &f, &format!("order {order} about {axis:?}"));
            }
        }
    }
}

#[test]
fn single_bands_have_their_closed_minima() {
    // The lowest value of P_l is that of its first trough; |y_ll| is largest on the equator.
    for axis in [Dir::X, Dir::Z, Dir::from_angles(1.0, 2.0)] {
        for (l, trough) in [(1, -1.0), (2, -0.5), (4, -3.0 / 7.0)] {
            let mut z = vec![0.0; l + 1];
            z[l] = (4.0 * PI / (2 * l + 1) as f64).sqrt();
            let f = Zonal::new(z).towards(axis, 1.0);
            let min = certified_minimum(f.coefficients(), TOLERANCE);
            assert_holds(&min, trough, &f, &format!("P_{l} about {axis:?}"));
        }
    }
    for l in [2, 3, 5, 9] {
        let mut f = ShVec::<f64>::zero(l + 1);
        *f.band_mut(l).last_mut().unwrap() = 1.0;
        let min = certified_minimum(f.coefficients(), TOLERANCE);
        let least = -f.eval(Dir::X).abs();
        assert_holds(&min, least, &f, &format!("y_{l}^{l}"));
    }
}

#[test]
fn rotation_turns_the_minimum_along() {
    let mut random = Random::new(9);
    for order in [3, 5, 8] {
        let f = random_function(&mut random, order, 1);
        let before = certified_minimum(f.coefficients(), TOLERANCE);
        for _ in 0..10 {
            let rotation = Rotation::from_quaternion(random.quaternion()).unwrap();
            let after = certified_minimum(f.rotated(&rotation).coefficients(), TOLERANCE);
            let width = 2.0 * TOLERANCE * rms(&f);
            assert!((after.hi - before.hi).abs() < width, "order {order}: {before:?} became {after:?}");
            let angle = rotation.rotate_dir(before.dir).angle_to(after.dir);
            assert!(angle < 1e-4, "order {order}: the direction is {angle} off");
        }
    }
}

#[test]
fn constants_zero_and_nothing_have_their_minimum() {
    assert_eq!(certified_minimum::<f64>(&[], TOLERANCE).hi, 0.0, "order 0");
    for order in [1, 3, 4, 10] {
        let zero = certified_minimum(ShVec::<f64>::zero(order).coefficients(), TOLERANCE);
        assert_eq!((zero.lo, zero.hi), (0.0, 0.0), "zero of order {order}");
        for value in [1.0, -2.5, 1e-30, 1e200] {
            let f = ShVec::<f64>::constant(order, value);
            let min = certified_minimum(f.coefficients(), TOLERANCE);
            let close = min.lo <= value && value <= min.hi && min.hi - min.lo < 1e-12 * value.abs();
            assert!(close, "{value} of order {order}: {min:?}");
        }
    }
}

#[test]
fn nearly_constant_functions_end_too() {
    let mut random = Random::new(12);
    for size in [1e-3, 1e-7, 1e-12, 1e-17] {
        let mut f = &ShVec::from_vec(random.signed_vec(64)).unwrap() * size;
        f[0] = 1.0;
        let min = certified_minimum(f.coefficients(), TOLERANCE);
        let least = directions().iter().map(|v| f.eval(Dir::from_unit(*v))).fold(f64::INFINITY, f64::min);
        assert!(min.lo <= least && min.hi - min.lo <= 1.1e-6 * rms(&f), "{size}: {min:?} against {least}");
    }
}

#[test]
fn functions_of_any_size_scale() {
    let f = ShVec::from_vec(Random::new(13).signed_vec(25)).unwrap();
    let one = certified_minimum(f.coefficients(), TOLERANCE);
    for exponent in [-1040, -600, -30, 30, 600, 1000] {
        // In two steps: one alone would leave the range of numbers.
        let scale = |x: f64| x * 2.0_f64.powi(exponent / 2) * 2.0_f64.powi(exponent - exponent / 2);
        let min = certified_minimum(f.map(scale).coefficients(), TOLERANCE);
        // The smallest have lost digits.
        let expected = scale(one.hi);
        assert!((min.hi / expected - 1.0).abs() < 1e-6, "2^{exponent}: {} against {expected}", min.hi);
    }
}

#[test]
fn finer_tolerances_narrow_the_interval() {
    for order in [3, 4, 7, 10] {
        let f = ShVec::from_vec(Random::new(14).signed_vec(order * order)).unwrap();
        for tolerance in [1e-1, 1e-3, 1e-6, 1e-9, 1e-11, 1e-12, 0.0] {
            let min = certified_minimum(f.coefficients(), tolerance);
            let width = (min.hi - min.lo) / rms(&f);
            // What rounding leaves, as documented.
            let finest = 4e-12;
            let what = format!("order {order}, {tolerance} of the root mean square: {width}");
            assert!(width >= 0.0 && width <= tolerance.max(finest), "{what}");
        }
    }
}

#[test]
fn the_maximum_mirrors_the_minimum() {
    for order in [2, 3, 6] {
        let f = ShVec::from_vec(Random::new(15).signed_vec(order * order)).unwrap();
        let (max, min) = (certified_maximum(f.coefficients(), 1e-6), certified_minimum((-&f).coefficients(), 1e-6));
        assert_eq!((max.lo, max.hi, max.dir), (-min.hi, -min.lo, min.dir), "order {order}");
        let above = directions().iter().map(|v| f.eval(Dir::from_unit(*v))).fold(f64::NEG_INFINITY, f64::max);
        assert!(above <= max.hi && f.eval(max.dir) >= max.lo, "order {order}: {above} and {max:?}");
    }
}

#[test]
fn numbers_that_are_not_finite_leave_everything_open() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for order in [1, 3, 5] {
            let mut f = vec![0.5; order * order];
            f[order * order - 1] = bad;
            let min = certified_minimum(&f, TOLERANCE);
            assert_eq!((min.lo, min.hi), (f64::NEG_INFINITY, f64::INFINITY), "{bad} at order {order}");
        }
    }
}
