//! Logarithms and exponentials: a reference table, identities, and random clusters of spheres against the truth.

use std::f64::consts::PI;

use lobe_sh::exponential::{ExpMethod, Exponential, LOG_CLAMP, OptimalLinear, ZonalLogarithm, logarithm};
use lobe_sh::ringing::DeringOptions;
use lobe_sh::{Dir, Expansion as _, ShVec, Zonal, project};
use lobe_testkit::{Random, directions};

const METHODS: [ExpMethod; 5] = [
    ExpMethod::Eigen,
    ExpMethod::ProductSeries(4),
    ExpMethod::OptimalLinear,
    ExpMethod::Hybrid { limit: 1.0 },
    ExpMethod::Grid,
];

/// The error of the eigenvalue solver, relative to the function, with room.
const SOLVER: f64 = 1e-9;

/// Of the faint functions of `the_exponential_of_a_logarithm_is_the_function_where_nothing_is_clamped`: 2e-10 at most was found, at order 8, which is
/// the fourth power of their contrast.
const FAINT: f64 = 1e-9;

/// Of the means of `the_exponential_of_a_sum_is_the_chain_of_products`, by eigenvectors and on the grid.
const CHAIN_BOUNDS: [(usize, [f64; 2]); 4] =
    [(3, [1.1e-3, 1.1e-3]), (4, [2.4e-3, 2.6e-3]), (5, [4.8e-3, 5.7e-3]), (6, [8.4e-3, 1.15e-2])];

pub(crate) fn difference(a: &ShVec<f64>, b: &ShVec<f64>) -> f64 {
    let square = |f: &ShVec<f64>| f.dot(f);
    let mut rest = a.clone();
    rest -= b;
    (square(&rest) / square(b)).sqrt()
}

/// What a sphere leaves visible.
pub(crate) fn visible(order: usize, towards: Dir, half_angle: f64) -> ShVec<f64> {
    &ShVec::constant(order, 1.0) + &Zonal::cone(order, half_angle).towards(towards, -1.0)
}

fn random_direction(random: &mut Random) -> Dir {
    Dir::try_from(random.direction()).unwrap()
}

/// Spheres of 5° to 25° in random directions, as a figure nearby casts.
fn cluster(count: usize, random: &mut Random) -> Vec<(Dir, f64)> {
    (0..count).map(|_| (random_direction(random), (5.0 + 20.0 * random.unit()).to_radians())).collect()
}

fn sum_of_logarithms(order: usize, spheres: &[(Dir, f64)]) -> ShVec<f64> {
    let mut sum = ShVec::zero(order);
    for &(towards, half_angle) in spheres {
        sum += &Zonal::sphere_logarithm(order, half_angle, LOG_CLAMP).towards(towards, 1.0);
    }
    sum
}

/// The projection of what a cluster leaves visible, by quadrature: 1 where no sphere is.
fn truth(order: usize, spheres: &[(Dir, f64)]) -> ShVec<f64> {
    let cones: Vec<(Dir, f64)> = spheres.iter().map(|&(s, angle)| (s, angle.cos())).collect();
    project(order, 300, |s: Dir| if cones.iter().any(|(axis, cosine)| axis.dot(s) > *cosine) { 0.0 } else { 1.0 })
}

/// Computed apart from this code, by a dense eigenvalue solver: order 4, eigenvalues clamped at 0.02. Angles are rounded
/// to a hundredth of a degree; small spheres hide by the square of the angle, which moves the values by up to a hundredth of a degree over the angle.
#[test]
fn logarithms_of_spheres_are_those_of_the_reference_table() {
    let table = [
        (5.02, [-0.006893, -0.011872, -0.015241, -0.017882]),
        (14.94, [-0.067850, -0.112644, -0.138690, -0.152572]),
        (30.04, [-0.365455, -0.566571, -0.620842, -0.562830]),
        (44.92, [-1.303469, -1.935431, -1.874942, -1.371053]),
        (60.02, [-2.701775, -3.849996, -3.233583, -1.844928]),
        (90.0, [-6.206373, -6.124167, -1.487137, 1.461373]),
    ];
    for (degrees, expected) in table {
        let found = Zonal::sphere_logarithm(4, f64::to_radians(degrees), LOG_CLAMP);
        for (found, expected) in found.coefficients().iter().zip(expected) {
            let bound = (0.01 / degrees).max(1e-3);
            assert!((found - expected).abs() < bound * expected.abs(), "{degrees}°: {found} against {expected}");
        }
    }
}

/// `a` and `b` of single spheres of order 4: by another program from the logarithms of that table, then as they stand beside it. At 60° and 90° the two
/// differ by a tenth at most, and the first are right: they are what eigenvectors make of those very logarithms.
const OPTIMAL_LINEAR: [(f64, [f64; 2], [f64; 2]); 4] = [
    (30.04, [1.034148, 0.771305], [1.034148, 0.771305]),
    (44.92, [1.233619, 0.536735], [1.233631, 0.536724]),
    (60.02, [1.637749, 0.478182], [1.606860, 0.525830]),
    (90.0, [2.910364, 1.391886], [2.879563, 1.411437]),
];

#[test]
fn factors_of_the_optimal_linear_exponential_are_those_of_the_reference_table() {
    let table = OptimalLinear::new(4);
    for (degrees, exact, beside) in OPTIMAL_LINEAR {
        let f = Zonal::sphere_logarithm(4, degrees.to_radians(), LOG_CLAMP);
        let norm = f.coefficients()[1..].iter().map(|c| c * c).sum::<f64>().sqrt();
        let (a_less_one, b) = table.factors(norm);
        let a = 1.0 + a_less_one;
        println!("{degrees}°: {a:.6} {b:.6}");
        for (found, (exact, beside)) in [a, b].into_iter().zip(exact.into_iter().zip(beside)) {
            assert!((found - exact).abs() < 1e-3 * exact, "{degrees}°: {found} against {exact}");
            let bound = if degrees < 50.0 { 1e-3 } else { 0.1 };
            assert!((found - beside).abs() < bound * beside, "{degrees}°: {found}, and {beside} beside the table");
        }
    }
}

/// The bounds are the largest differences found at orders 3 to 6 when the clamp was chosen.
#[test]
fn the_exponential_of_a_logarithm_is_the_function_to_the_clamp() {
    for (order, bound) in [(3, 7.9e-2), (4, 5.2e-2), (5, 5.1e-2), (6, 3.9e-2)] {
        let exponential = Exponential::new(order, ExpMethod::Eigen);
        let mut worst = 0.0_f64;
        for degrees in 1..=90 {
            let g = visible(order, Dir::Z, f64::from(degrees).to_radians());
            worst = worst.max(difference(&exponential.of(&logarithm(&g, LOG_CLAMP)), &g));
        }
        println!("order {order}: {worst:.4}");
        assert!(worst < 1.02 * bound, "order {order}: {worst} against {bound}");
    }
}

#[test]
fn the_exponential_of_a_logarithm_is_the_function_where_nothing_is_clamped() {
    for order in 1..=8 {
        let exponential = Exponential::new(order, ExpMethod::Eigen);
        for s in directions() {
            let s = Dir::try_from(s).unwrap();
            let g = &ShVec::constant(order, 2.0) + &visible(order, s, 0.1);
            let back = exponential.of(&logarithm(&g, LOG_CLAMP));
            assert!(difference(&back, &g) < FAINT, "order {order}, {s:?}: {}", difference(&back, &g));
        }
    }
}

#[test]
fn a_constant_added_multiplies_the_exponential() {
    let mut random = Random::new(1);
    for order in 1..=6 {
        let f = sum_of_logarithms(order, &cluster(6, &mut random));
        let moved = &f + &ShVec::constant(order, -0.7);
        for method in METHODS {
            let exponential = Exponential::new(order, method);
            let mut expected = exponential.of(&f);
            expected *= f64::exp(-0.7);
            let found = difference(&exponential.of(&moved), &expected);
            assert!(found < 1e-13, "order {order}, {method:?}: {found}");
        }
    }
}

#[test]
fn the_hybrid_method_nears_the_eigenvectors_as_its_limit_shrinks() {
    let mut random = Random::new(2);
    for order in 3..=6 {
        let f = sum_of_logarithms(order, &cluster(6, &mut random));
        let exact = Exponential::new(order, ExpMethod::Eigen).of(&f);
        let errors: Vec<f64> = [1.0, 0.1, 0.01, 1e-3]
            .map(|limit| difference(&Exponential::new(order, ExpMethod::Hybrid { limit }).of(&f), &exact))
            .into();
        assert!(errors.windows(2).all(|pair| pair[1] < 0.5 * pair[0]), "order {order}: {errors:?}");
        assert!(errors[3] < 1e-3, "order {order}: {errors:?}");
        // As many squarings as there can be do not bring rounding up.
        for limit in [1e-6, 1e-12, 1e-18, 1e-300] {
            let error = difference(&Exponential::new(order, ExpMethod::Hybrid { limit }).of(&f), &exact);
            assert!(error < errors[3], "order {order}, limit {limit}: {error}");
        }
    }
}

#[test]
fn the_logarithm_of_a_constant_is_that_of_the_number_however_small_it_is() {
    assert_eq!(logarithm(&ShVec::constant(4, 1.0), LOG_CLAMP), ShVec::zero(4), "of 1");
    for value in [1e-300_f64, 1e-17, 1e-12, 1e-3, 0.4, 0.6, 1.0 - 1e-9, 2.5, 1e17, 1e300] {
        let found = logarithm(&ShVec::constant(4, value), LOG_CLAMP);
        let off = difference(&found, &ShVec::constant(4, value.ln()));
        // Next to 1 what is rounded is the number, not its logarithm.
        assert!(off <= 1e-13 + 1e-15 / value.ln().abs(), "ln {value} is off by {off} of it");
    }
}

#[test]
fn a_series_of_products_nears_the_eigenvectors_as_terms_are_added() {
    let f = sum_of_logarithms(4, &cluster(3, &mut Random::new(3)));
    let exact = Exponential::new(4, ExpMethod::Eigen).of(&f);
    let error = |terms| difference(&Exponential::new(4, ExpMethod::ProductSeries(terms)).of(&f), &exact);
    let errors: Vec<f64> = [1, 2, 4, 8].map(error).into();
    assert!(errors.windows(2).all(|pair| pair[1] < 0.5 * pair[0]), "{errors:?}");
    assert!(error(24) < SOLVER, "{}", error(24));
}

/// The most by which one more occluder may brighten the mean, relative to it. The logarithm of a small sphere rings above zero
/// around it; where the sphere itself stands in the dark already, what it brightens beside can be more.
const BRIGHTENS: f64 = 4e-3;

/// Of 24 spheres each.
const CLUSTERS: usize = 60;

#[test]
fn an_occluder_more_never_brightens_the_mean_beyond_its_ringing() {
    let mut random = Random::new(4);
    for order in [3, 4, 5, 6] {
        let logarithm = ZonalLogarithm::new(order, LOG_CLAMP);
        for method in [ExpMethod::Grid, ExpMethod::Eigen] {
            let exponential = Exponential::new(order, method);
            let (mut worst, mut brighter, mut all) = (0.0_f64, 0, 0);
            for _ in 0..CLUSTERS {
                let (mut before, mut sum) = (1.0, ShVec::zero(order));
                for (towards, angle) in cluster(24, &mut random) {
                    sum += &logarithm.of_sphere(angle).towards(towards, 1.0);
                    let mean = exponential.of(&sum).mean();
                    worst = worst.max(mean / before - 1.0);
                    brighter += usize::from(mean > before);
                    all += 1;
                    before = mean;
                }
            }
            println!("order {order}, {method:?}: brighter {brighter} times of {all}, by {worst:.1e} at most");
            assert!(worst <= BRIGHTENS, "order {order}, {method:?}: brighter by {worst}");
            assert!(100 * brighter <= all, "order {order}, {method:?}: brighter {brighter} times of {all}");
        }
    }
}

/// How much larger the mean error of 16 spheres is by logarithms that are nowhere above zero, at least and at most.
const DEARER: [f64; 2] = [2.0, 4.5];

#[test]
fn logarithms_that_are_nowhere_above_zero_never_brighten_the_mean_and_are_less_exact() {
    let mut random = Random::new(4);
    for order in [3, 4, 5, 6] {
        let exact = ZonalLogarithm::new(order, LOG_CLAMP);
        // Of whole degrees: as many as are looked up.
        let below = |degrees: usize| {
            let minus = exact.of_sphere((degrees as f64).to_radians()).towards(Dir::Z, -1.0);
            Zonal::about(Dir::Z, &minus.deringed_with(&DeringOptions::default()).0.map(|c: f64| -c))
        };
        let below: Vec<Zonal> = (0..=25).map(below).collect();
        let exponential = Exponential::new(order, ExpMethod::Grid);
        let whole = |angle: f64| angle.to_degrees().round() as usize;
        for k in 0..CLUSTERS {
            let (mut before, mut sum) = (1.0, ShVec::zero(order));
            for (towards, angle) in cluster(24, &mut random) {
                sum += &below[whole(angle)].towards(towards, 1.0);
                let mean = exponential.of(&sum).mean();
                assert!(mean < before, "order {order}, cluster {k}: {mean} after {before}");
                before = mean;
            }
        }
        let (mut error, mut usual) = (0.0, 0.0);
        for _ in 0..4 {
            let mut spheres = cluster(16, &mut random);
            spheres.iter_mut().for_each(|(_, angle)| *angle = (whole(*angle) as f64).to_radians());
            let truth = truth(order, &spheres);
            let mut sum = ShVec::zero(order);
            spheres.iter().for_each(|(towards, angle)| sum += &below[whole(*angle)].towards(*towards, 1.0));
            error += difference(&exponential.of(&sum), &truth) / 4.0;
            usual += difference(&exponential.of(&sum_of_logarithms(order, &spheres)), &truth) / 4.0;
        }
        println!("order {order}: {error:.3}, by usual logarithms {usual:.3}");
        assert!(error > DEARER[0] * usual && error < DEARER[1] * usual, "order {order}: {error} and {usual}");
    }
}

/// What large spheres behind one another leave: order, half angles in degrees, the mean with the first and with both. Their logarithms have few bands
/// for a deep valley, and ring high above zero beside it; the sum of two rings twice as high. The truth of both is that of the larger.
const BEHIND: [(usize, [f64; 2], [f64; 2]); 4] = [
    (3, [70.0, 65.0], [0.734, 0.952]),
    (4, [90.0, 90.0], [0.525, 0.599]),
    (5, [40.0, 40.0], [0.905, 0.988]),
    (6, [65.0, 60.0], [0.738, 0.785]),
];

#[test]
fn large_occluders_behind_one_another_brighten_the_mean_by_what_is_stated() {
    for (order, angles, expected) in BEHIND {
        let logarithm = ZonalLogarithm::new(order, LOG_CLAMP);
        let [first, second] = angles.map(|angle| logarithm.of_sphere(angle.to_radians()).towards(Dir::Z, 1.0));
        let exponential = Exponential::new(order, ExpMethod::Grid);
        let found = [exponential.of(&first).mean(), exponential.of(&(&first + &second)).mean()];
        println!("order {order}, {angles:?}: {found:.3?}");
        for (found, expected) in found.into_iter().zip(expected) {
            assert!((found - expected).abs() < 2e-3, "order {order}, {angles:?}: {found}, expected {expected}");
        }
    }
}

#[test]
fn the_fast_logarithm_of_a_zonal_function_is_that_of_any() {
    for order in 1..=8 {
        let fast = ZonalLogarithm::new(order, LOG_CLAMP);
        for degrees in [0.0, 2.0, 15.0, 40.0, 77.0, 90.0, 130.0_f64] {
            let g = visible(order, Dir::Z, degrees.to_radians());
            // A largest eigenvalue below 1 is where the two differ by intent.
            let brighter = &g + &ShVec::constant(order, 0.5);
            let found = fast.of(&Zonal::about(Dir::Z, &brighter)).towards(Dir::Z, 1.0);
            let expected = logarithm(&brighter, LOG_CLAMP);
            let rest = &found + &expected.map(|c| -c);
            let error = rest.dot(&rest).sqrt();
            assert!(error < SOLVER, "order {order}, {degrees} degrees: {found:?} against {expected:?}");
        }
    }
    let unknown = ZonalLogarithm::new(3, LOG_CLAMP).of(&Zonal::new(vec![f64::NAN; 3]));
    assert!(unknown.coefficients().iter().all(|c| c.is_nan()), "{unknown:?}");
    assert_eq!(ZonalLogarithm::new(0, LOG_CLAMP).of_sphere(0.3).order(), 0, "no coefficients");
}

/// The exponential of a function, projected by a rule that resolves it.
fn exact_projection(f: &ShVec<f64>) -> ShVec<f64> {
    project(f.order(), 60, |s: Dir| f.eval(s).exp())
}

#[test]
fn errors_stay_below_their_bounds() {
    let mut random = Random::new(6);
    for order in 1..=6 {
        for scale in [1e-3, 0.05, 0.3, 1.0] {
            let mut f = sum_of_logarithms(order, &cluster(3, &mut random));
            f *= scale;
            let eigen = Exponential::new(order, ExpMethod::Eigen).of(&f);
            for (method, expected) in [
                (ExpMethod::ProductSeries(1), &eigen),
                (ExpMethod::ProductSeries(4), &eigen),
                (ExpMethod::Grid, &exact_projection(&f)),
            ] {
                let exponential = Exponential::new(order, method);
                let bound = exponential.error_bound(&f).unwrap();
                let mut rest = exponential.of(&f);
                rest -= expected;
                let error = rest.dot(&rest).sqrt();
                assert!(error <= bound + SOLVER, "order {order}, {method:?} times {scale}: {error} above {bound}");
            }
        }
    }
    let f = sum_of_logarithms(4, &cluster(3, &mut random));
    for method in [ExpMethod::Eigen, ExpMethod::OptimalLinear, ExpMethod::Hybrid { limit: 1.0 }] {
        let bound = Exponential::new(4, method).error_bound(&f);
        assert_eq!(bound, None, "{method:?} is not bounded");
    }
}

/// The mean difference of 40 clusters of eight, relative to the product; a few percent more than was found.
#[test]
fn the_exponential_of_a_sum_is_the_chain_of_products() {
    const CLUSTERS: usize = 40;
    for (order, bounds) in CHAIN_BOUNDS {
        let mut random = Random::new(7);
        let methods = [ExpMethod::Eigen, ExpMethod::Grid];
        let exponentials = methods.map(|method| Exponential::new(order, method));
        let mut means = [0.0; 2];
        for _ in 0..CLUSTERS {
            let spheres = cluster(8, &mut random);
            let chain = chain(order, &spheres);
            let f = sum_of_logarithms(order, &spheres);
            for (mean, exponential) in means.iter_mut().zip(&exponentials) {
                *mean += difference(&exponential.of(&f), &chain) / CLUSTERS as f64;
            }
        }
        println!("order {order}: {means:.4?}");
        assert!(means.iter().zip(bounds).all(|(mean, bound)| *mean < bound), "order {order}: {means:?}");
    }
}

/// Spheres one after the other by truncated products.
fn chain(order: usize, spheres: &[(Dir, f64)]) -> ShVec<f64> {
    spheres.iter().fold(ShVec::constant(order, 1.0), |all, &(s, angle)| all.product(&visible(order, s, angle), order))
}

/// Errors of the methods at orders 3 to 6 with 16 spheres that others measured with clusters of their own, in the order of
/// [`METHODS`]: eigenvectors, four terms of the series, optimal linear, hybrid of limit 1, grid.
const MEASURED_BEFORE: [[f64; METHODS.len()]; 4] = [
    [0.119, 0.119, 0.153, 0.130, 0.124],
    [0.131, 0.139, 0.262, 0.162, 0.137],
    [0.120, 0.212, 0.369, 0.206, 0.129],
    [0.115, 1.11, 0.374, 0.246, 0.166],
];

/// The mean over clusters of the error relative to the truth: chained products, and every method.
#[test]
fn the_grid_is_nearer_to_the_truth_than_the_optimal_linear_and_the_hybrid_methods() {
    const CLUSTERS: usize = 12;
    for (order, before) in (3..).zip(MEASURED_BEFORE) {
        let mut random = Random::new(5);
        let mut errors = [0.0; METHODS.len() + 1];
        let exponentials = METHODS.map(|method| Exponential::new(order, method));
        for _ in 0..CLUSTERS {
            let spheres = cluster(16, &mut random);
            let truth = truth(order, &spheres);
            let chain = chain(order, &spheres);
            let f = sum_of_logarithms(order, &spheres);
            errors[0] += difference(&chain, &truth) / CLUSTERS as f64;
            for (error, exponential) in errors[1..].iter_mut().zip(&exponentials) {
                *error += difference(&exponential.of(&f), &truth) / CLUSTERS as f64;
            }
        }
        println!("order {order}: products {:.3}, then {METHODS:?} {:.3?}", errors[0], &errors[1..]);
        let [_, _, _, linear, hybrid, grid] = errors;
        assert!(grid < linear && grid < hybrid, "order {order}: {grid} against {linear} and {hybrid}");
        for ((method, error), before) in METHODS.iter().zip(&errors[1..]).zip(before) {
            assert!(*error <= before, "order {order}, {method:?}: {error}, and {before} was measured before");
        }
    }
}

#[test]
fn degenerate_functions_have_the_documented_values() {
    for order in 1..=4 {
        let nothing = logarithm(&ShVec::zero(order), LOG_CLAMP);
        assert!(difference(&nothing, &ShVec::constant(order, LOG_CLAMP.ln())) < 1e-14, "{nothing:?}");
        let one = ShVec::constant(order, 1.0);
        assert!(logarithm(&one, LOG_CLAMP).coefficients().iter().all(|c| c.abs() < 1e-14), "ln 1, order {order}");
        for method in METHODS {
            let found = difference(&Exponential::new(order, method).of(&ShVec::zero(order)), &one);
            assert!(found < 1e-14, "exp 0, {method:?}: {found}");
        }
    }
    assert_eq!(logarithm(&ShVec::zero(0), LOG_CLAMP).order(), 0, "no coefficients");
    for method in METHODS {
        assert_eq!(Exponential::new(0, method).of(&ShVec::zero(0)).order(), 0, "no coefficients, {method:?}");
        let unknown = Exponential::new(3, method).of(&ShVec::zero(3).map(|_: f64| f64::NAN));
        assert!(unknown.coefficients().iter().all(|c| c.is_nan()), "{method:?}: {unknown:?}");
    }
    let unknown = logarithm(&ShVec::zero(3).map(|_: f64| f64::NAN), LOG_CLAMP);
    assert!(unknown.coefficients().iter().all(|c| c.is_nan()), "{unknown:?}");
    let all = Zonal::sphere_logarithm(3, PI, LOG_CLAMP);
    let value = LOG_CLAMP.ln() / (1.0 - LOG_CLAMP);
    assert!((all.coefficients()[0] / (4.0 * PI).sqrt() - value).abs() < 1e-12, "inside a sphere: {all:?}");
}

/// The root mean square errors of the grid and of eigenvectors at orders 3 to 6, where two spheres of 40° to 80° hide the sky.
const LARGE: [(usize, [f64; 2]); 4] =
    [(3, [0.047, 0.026]), (4, [0.036, 0.020]), (5, [0.034, 0.020]), (6, [0.027, 0.017])];

#[test]
fn of_large_occluders_eigenvectors_are_the_nearer_ones_as_stated() {
    const CASES: usize = 40;
    let mut random = Random::new(9);
    for (order, stated) in LARGE {
        let mut errors = [0.0; 2];
        for _ in 0..CASES {
            let large = |random: &mut Random| (random_direction(random), (40.0 + 40.0 * random.unit()).to_radians());
            let spheres = [large(&mut random), large(&mut random)];
            let (sum, expected) = (sum_of_logarithms(order, &spheres), truth(order, &spheres));
            for (error, method) in errors.iter_mut().zip([ExpMethod::Grid, ExpMethod::Eigen]) {
                *error += difference(&Exponential::new(order, method).of(&sum), &expected) / CASES as f64;
            }
        }
        // The norm over the sphere, as a root mean square.
        let errors = errors.map(|error| error / (4.0 * PI).sqrt());
        println!("order {order}: {errors:.4?}");
        for (found, stated) in errors.into_iter().zip(stated) {
            assert!((found - stated).abs() < 1e-3, "order {order}: {found}, stated {stated}");
        }
        assert!(errors[1] < 0.85 * errors[0], "order {order}: {errors:?}");
    }
}

#[test]
fn exponentials_have_names_and_a_series_its_terms() {
    for (text, method) in [
        ("series:12", ExpMethod::ProductSeries(12)),
        ("grid", ExpMethod::Grid),
        ("optimal-linear", ExpMethod::OptimalLinear),
        ("hybrid", ExpMethod::Hybrid { limit: 1.0 }),
        ("hybrid:4.8", ExpMethod::Hybrid { limit: 4.8 }),
        ("eigen", ExpMethod::Eigen),
    ] {
        let found = text.parse::<ExpMethod>().expect(text);
        assert_eq!(found, method, "{text}");
        let is_slow = matches!(method, ExpMethod::Eigen | ExpMethod::ProductSeries(_));
        assert_eq!(found.is_fast(), !is_slow, "{text}");
    }
    for bad in
        ["series:0", "series:101", "series", "Grid", "", "hybrid:0", "hybrid:-1", "hybrid:nan", "hybrid:", "grid:1"]
    {
        assert!(bad.parse::<ExpMethod>().is_err(), "{bad:?}");
    }
}
