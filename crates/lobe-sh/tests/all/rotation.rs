//! Rotation of expansions: independent routes against each other, and the algebra of rotations.

use std::f64::consts::{FRAC_PI_2, PI};

use lobe_sh::basis::Basis;
use lobe_sh::rotation::{AxisPermutation, RotationMatrices};
use lobe_sh::sphere::SphereQuadrature;
use lobe_sh::{Dir, Expansion as _, Rgb, Rotation, ShL3, ShVec, Zonal};
use lobe_testkit::{Random, directions, golden, golden_f64s};

/// How far routes may differ, for coefficients in [-1, 1): measured at 1e-14 for order 16 and 5e-14 for order 64 between
/// exchanges and matrices. The quadrature's own rounding is the rest.
const TOLERANCE: f64 = 1e-12;

fn random_expansion(order: usize, seed: u64) -> ShVec<f64> {
    ShVec::from_vec(Random::new(seed).signed_vec(order * order)).expect("n² coefficients")
}

fn worst_difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len(), "lengths");
    a.iter().zip(b).fold(0.0, |worst, (a, b)| if (a - b).abs() <= worst { worst } else { (a - b).abs() })
}

/// Random ones, all 24 of the axes, tiny angles, half turns, `β` at and next to 0 and π.
fn rotations(random_count: usize) -> Vec<Rotation> {
    let mut random = Random::new(7);
    let mut all: Vec<Rotation> =
        (0..random_count).map(|_| Rotation::from_quaternion(random.quaternion()).expect("a unit quaternion")).collect();
    all.extend(AxisPermutation::all().filter_map(|p| p.rotation()));
    for angle in [1e-15, 1e-9, 1e-4, PI, PI - 1e-9] {
        all.push(Rotation::from_axis_angle(Dir::from_unit(random.direction()), angle));
        all.push(Rotation::from_axis_angle(Dir::X, angle));
    }
    for beta in [0.0, 1e-17, 1e-8, FRAC_PI_2, PI - 1e-8, PI] {
        all.push(Rotation::from_euler_zyz(1.1, beta, -0.4));
    }
    all
}

/// The third route, that knows no rotation of coefficients: `∫ f(R⁻¹ s) y_i(s) ds` by exact quadrature.
fn rotated_by_quadrature(rotation: &Rotation, f: &ShVec<f64>) -> ShVec<f64> {
    let order = f.order();
    let basis = Basis::<f64>::new(order);
    let mut y = vec![0.0; order * order];
    let mut g = vec![0.0; order * order];
    let back = rotation.inverse();
    for (s, weight) in SphereQuadrature::of_degree(2 * (order - 1)).points() {
        basis.eval_into(back.rotate_dir(s).to_array(), &mut y);
        let value: f64 = y.iter().zip(f.coefficients()).map(|(y, f)| y * f).sum();
        basis.eval_into(s.to_array(), &mut y);
        for (g, y) in g.iter_mut().zip(&y) {
            *g += weight * value * y;
        }
    }
    ShVec::from_vec(g).expect("n² coefficients")
}

fn rotated_by_matrices(rotation: &Rotation, f: &ShVec<f64>) -> ShVec<f64> {
    let mut g = ShVec::zero(f.order());
    RotationMatrices::new(rotation, f.order()).apply_into(f.coefficients(), g.coefficients_mut());
    g
}

fn check_routes(rotation: &Rotation, order: usize, with_quadrature: bool) {
    let f = random_expansion(order, order as u64);
    let by_swaps = f.rotated(rotation);
    let by_matrices = rotated_by_matrices(rotation, &f);
    let error = worst_difference(by_swaps.coefficients(), by_matrices.coefficients());
    assert!(error < TOLERANCE, "order {order}, {rotation:?}: exchanges and matrices differ by {error:e}");
    if with_quadrature {
        let by_quadrature = rotated_by_quadrature(rotation, &f);
        let error = worst_difference(by_swaps.coefficients(), by_quadrature.coefficients());
        assert!(error < TOLERANCE, "order {order}, {rotation:?}: exchanges and quadrature differ by {error:e}");
    }
}

#[test]
fn every_route_agrees_at_every_order() {
    for order in 1..=16 {
        for rotation in rotations(4) {
            check_routes(&rotation, order, true);
        }
    }
    for order in [17, 20, 31, 32, 48] {
        for rotation in rotations(1).iter().step_by(5) {
            check_routes(rotation, order, false);
        }
    }
}

/// In units of the last place of the length of a band: three rotations about z and two exchanges in `f32`. Measured:
/// 3.4.
const SINGLE_ROUNDINGS: f64 = 6.0;

#[test]
fn rotations_in_single_precision_are_those_in_double_to_a_few_roundings() {
    let mut worst = 0.0_f64;
    for order in 1..=11 {
        for rotation in rotations(200) {
            let f = random_expansion(order, 90 + order as u64);
            let single: Vec<f32> = f.coefficients().iter().map(|x| *x as f32).collect();
            let double: Vec<f64> = single.iter().copied().map(f64::from).collect();
            let (mut found, mut expected) = (vec![f32::NAN; single.len()], vec![f64::NAN; single.len()]);
            rotation.apply_into(&single, &mut found);
            rotation.apply_into(&double, &mut expected);
            let mut in_place = single.clone();
            rotation.apply_in_place(&mut in_place);
            assert_eq!(found, in_place, "order {order}, {rotation:?}: into another place, and in place");
            for l in 0..order {
                let band = l * l..(l + 1) * (l + 1);
                let length = expected[band.clone()].iter().fold(0.0_f64, |length, x| length.hypot(*x));
                for (found, expected) in found[band.clone()].iter().zip(&expected[band]) {
                    let error = (f64::from(*found) - expected).abs() / length / f64::from(f32::EPSILON);
                    assert!(error < SINGLE_ROUNDINGS, "order {order}, band {l}, {rotation:?}: {error} roundings");
                    worst = worst.max(error);
                }
            }
        }
    }
    assert!(worst > 0.1, "{worst} roundings: it cannot be exact");
}

#[test]
fn every_band_and_every_channel_is_turned_alike_at_every_order() {
    for rotation in rotations(20) {
        let f: Vec<f32> = Random::new(91).signed_vec(64).iter().map(|x| *x as f32).collect();
        let mut all = vec![0.0; 64];
        rotation.apply_into(&f, &mut all);
        for order in 1..8 {
            let count = order * order;
            let mut some = vec![0.0; count];
            rotation.apply_into(&f[..count], &mut some);
            // Order 2 and the straight-line code near the poles round alike: both are the closed forms of bands 1 and
            // 2.
            assert_eq!(some, all[..count], "order {order}, {rotation:?}");
            let colors: Vec<Rgb<f32>> = f[..count].iter().map(|x| Rgb::new(*x, -x, 0.5 * x)).collect();
            let mut turned = vec![Rgb::new(0.0, 0.0, 0.0); count];
            rotation.apply_into(&colors, &mut turned);
            let expected: Vec<Rgb<f32>> = some.iter().map(|x| Rgb::new(*x, -x, 0.5 * x)).collect();
            assert_eq!(turned, expected, "colors of order {order}, {rotation:?}");
        }
    }
}

#[test]
fn every_route_agrees_at_order_64() {
    for (k, rotation) in rotations(4).iter().enumerate() {
        check_routes(rotation, 64, k < 2);
    }
}

#[test]
fn orders_above_64_rotate_too() {
    let order = 130;
    let f = random_expansion(order, 3);
    let rotation = Rotation::from_euler_zyz(0.5, 1.0, 2.0);
    let error =
        worst_difference(f.rotated(&rotation).coefficients(), rotated_by_matrices(&rotation, &f).coefficients());
    assert!(error < TOLERANCE, "order {order}: exchanges and matrices differ by {error:e}");
}

#[test]
fn rotation_commutes_with_evaluation() {
    for (order, count) in [(1, 4), (3, 4), (6, 4), (16, 2), (64, 1), (256, 1)] {
        let f = random_expansion(order, 50 + order as u64);
        for rotation in rotations(count).iter().step_by(if order > 16 { 9 } else { 1 }) {
            let g = f.rotated(rotation);
            for v in directions() {
                let s = Dir::from_unit(v);
                let (got, expected) = (g.eval(rotation.rotate_dir(s)), f.eval(s));
                let allowed = TOLERANCE * order as f64;
                assert!((got - expected).abs() < allowed, "order {order}, towards {v:?}: {got} against {expected}");
            }
        }
    }
}

#[test]
fn a_light_towards_x_turned_by_90_degrees_about_z_lies_towards_y() {
    let light = ShVec::impulse(8, Dir::X, 1.0);
    let turned = light.rotated(&Rotation::from_axis_angle(Dir::Z, FRAC_PI_2));
    let expected = ShVec::impulse(8, Dir::Y, 1.0);
    let error = worst_difference(turned.coefficients(), expected.coefficients());
    assert!(error < 1e-14, "off by {error:e}");
    let brightest = directions()
        .into_iter()
        .max_by(|a, b| turned.eval(Dir::from_unit(*a)).total_cmp(&turned.eval(Dir::from_unit(*b))));
    assert_eq!(brightest, Some([0.0, 1.0, 0.0]), "the brightest direction");
}

#[test]
fn the_golden_rotation_is_reproduced() {
    let r = golden_f64s("/rotation/R");
    assert_eq!(golden("/rotation/meaning"), "g(s)=f(R^T s)", "the meaning of the golden value");
    let matrix = [0, 1, 2].map(|i| [r[3 * i], r[3 * i + 1], r[3 * i + 2]]);
    let rotation = Rotation::from_matrix(matrix).unwrap();
    // a_i = ((37 i + 11) mod 19 - 9) / 10
    let f = ShVec::from_vec((0..36).map(|i| ((37 * i + 11) % 19 - 9) as f64 / 10.0).collect()).unwrap();
    let expected = golden_f64s("/rotation/out");
    for (route, g) in [("exchanges", f.rotated(&rotation)), ("matrices", rotated_by_matrices(&rotation, &f))] {
        let error = worst_difference(g.coefficients(), &expected);
        assert!(error < 1e-12, "{route}: off by {error:e}");
    }
}

#[test]
fn rotations_of_functions_compose_and_invert() {
    for order in [2, 4, 9, 33] {
        let f = random_expansion(order, 9);
        let all = rotations(6);
        for (a, b) in all.iter().zip(all.iter().rev()) {
            let (one, two) = (f.rotated(&a.then(*b)), f.rotated(a).rotated(b));
            let error = worst_difference(one.coefficients(), two.coefficients());
            assert!(error < TOLERANCE, "order {order}, {a:?} then {b:?}: {error:e}");
            let back = f.rotated(a).rotated(&a.inverse());
            let error = worst_difference(back.coefficients(), f.coefficients());
            assert!(error < TOLERANCE, "order {order}, {a:?} and back: {error:e}");
        }
    }
}

#[test]
fn the_energy_of_every_band_is_kept() {
    let f = random_expansion(64, 13);
    for rotation in rotations(3) {
        let (before, after) = (f.band_energies(), f.rotated(&rotation).band_energies());
        for (l, (a, b)) in before.iter().zip(&after).enumerate() {
            assert!((a - b).abs() < 1e-12 * a.max(1.0), "band {l}: {a} became {b}");
        }
    }
}

#[test]
fn the_matrices_are_orthogonal() {
    for rotation in rotations(1).iter().step_by(6) {
        let matrices = RotationMatrices::<f64>::new(rotation, 64);
        for l in [0, 1, 2, 5, 15, 31, 63] {
            let last = l as isize;
            let mut worst = 0.0_f64;
            for m in -last..=last {
                for n in -last..=last {
                    let sum: f64 = (-last..=last).map(|k| matrices.entry(l, m, k) * matrices.entry(l, n, k)).sum();
                    worst = worst.max((sum - if m == n { 1.0 } else { 0.0 }).abs());
                }
            }
            assert!(worst < TOLERANCE, "band {l}, {rotation:?}: M Mᵀ is {worst:e} off the identity");
        }
    }
}

#[test]
fn the_linear_band_is_the_matrix_itself() {
    for rotation in rotations(5) {
        let r = rotation.matrix();
        let expected = [[r[1][1], -r[1][2], r[1][0]], [-r[2][1], r[2][2], -r[2][0]], [r[0][1], -r[0][2], r[0][0]]];
        let matrices = RotationMatrices::<f64>::new(&rotation, 2);
        for m in -1..=1 {
            for n in -1..=1 {
                let (found, expected) = (matrices.entry(1, m, n), expected[(m + 1) as usize][(n + 1) as usize]);
                assert_eq!(found, expected, "entry ({m}, {n}) of band 1");
            }
        }
    }
}

#[test]
fn a_quarter_turn_about_x_has_the_known_values() {
    let matrices = RotationMatrices::<f64>::new(&Rotation::from_axis_angle(Dir::X, FRAC_PI_2), 6);
    let mut counts = Vec::new();
    for l in 0..6 {
        let last = l as isize;
        let all = (-last..=last).flat_map(|m| (-last..=last).map(move |n| (m, n)));
        let sizes: Vec<f64> = all.map(|(m, n)| matrices.entry(l, m, n).abs()).filter(|e| *e > 1e-14).collect();
        counts.push(sizes.len());
        let known: &[f64] = match l {
            2 => &[0.5, 0.866025403784439, 1.0],
            3 => &[0.25, 0.612372435695794, 0.790569415042095, 0.968245836551854, 1.0],
            _ => continue,
        };
        for size in sizes {
            assert!(known.iter().any(|k| (k - size).abs() < 1e-14), "band {l}: {size} is none of {known:?}");
        }
    }
    assert_eq!(counts, [1, 3, 7, 13, 21, 31], "entries that do not vanish");
}

#[test]
fn a_zonal_lobe_turns_with_its_axis() {
    let lobe = Zonal::new(Random::new(17).signed_vec(20));
    let upright = lobe.towards(Dir::Z, 1.0);
    for rotation in rotations(20) {
        let expected = lobe.towards(rotation.rotate_dir(Dir::Z), 1.0);
        let turned: ShVec<f64> = upright.rotated(&rotation);
        let error = worst_difference(turned.coefficients(), expected.coefficients());
        assert!(error < 1e-12, "{rotation:?}: off by {error:e}");
    }
}

/// Band by band a sum of zonal lobes about `2l + 1` axes, rotated by turning the axes (Nowrouzezahrai et al. 2012).
#[test]
fn sums_of_zonal_lobes_turn_with_their_axes() {
    let bands = golden("/zonal_lobes/bands").as_object().expect("an object").len();
    let f = random_expansion(bands, 31);
    let band =
        |v: &ShVec<f64>, l: usize| nalgebra::DVector::from_row_slice(&v.coefficients()[l * l..(l + 1) * (l + 1)]);
    for rotation in rotations(4) {
        let turned = f.rotated(&rotation);
        for l in 0..bands {
            let angles = golden_f64s(&format!("/zonal_lobes/bands/{l}"));
            let axes: Vec<Dir> = angles.chunks(2).map(|pair| Dir::from_angles(pair[0], pair[1])).collect();
            assert_eq!(axes.len(), 2 * l + 1, "band {l}: axes");
            let lobes = |turn: &dyn Fn(Dir) -> Dir| {
                let columns: Vec<_> = axes.iter().map(|d| band(&ShVec::impulse(bands, turn(*d), 1.0), l)).collect();
                nalgebra::DMatrix::from_columns(&columns)
            };
            let weights = lobes(&|d| d).lu().solve(&band(&f, l)).expect("axes that span the band");
            let found = lobes(&|d| rotation.rotate_dir(d)) * &weights;
            let (error, size) = ((found - band(&turned, l)).amax(), weights.amax());
            assert!(error < 1e-13 * (1.0 + size), "band {l}: off by {error:e}, with weights up to {size}");
            assert!(size < 100.0, "band {l}: the axes hardly span the band, weights of {size}");
        }
    }
}

#[test]
fn f32_and_colors_follow_f64() {
    for order in [2, 3, 6, 12, 40, 90] {
        let f = random_expansion(order, 23);
        let single = f.map(|c| c as f32);
        let color = f.map(|c| Rgb::new(c, -2.0 * c, 0.5 * c));
        for rotation in rotations(2).iter().step_by(3) {
            let g = f.rotated(rotation);
            let matrices = RotationMatrices::<f32>::new(rotation, order);
            let mut by_matrices = ShVec::<f32>::zero(order);
            matrices.apply_into(single.coefficients(), by_matrices.coefficients_mut());
            let (g_single, g_color) = (single.rotated(rotation), color.rotated(rotation));
            for i in 0..f.coefficients().len() {
                for g_single in [g_single[i], by_matrices[i]] {
                    // Rounding of f32 in sums of some ten terms of size 1.
                    let error = (f64::from(g_single) - g[i]).abs();
                    assert!(error < 2e-6, "order {order}, {i}: {g_single} against {}", g[i]);
                }
                assert_eq!(g_color[i], Rgb::new(g[i], -2.0 * g[i], 0.5 * g[i]), "order {order}, channels of {i}");
            }
        }
    }
}

#[test]
fn many_at_once_are_each_by_itself() {
    for (order, count) in [(1, 3), (3, 1), (4, 7), (6, 8), (6, 21), (10, 64)] {
        let rotation = Rotation::from_euler_zyz(0.2, 2.0, -1.0);
        let matrices = RotationMatrices::<f64>::new(&rotation, order);
        let src = Random::new(29).signed_vec(order * order * count);
        let mut dst = vec![f64::NAN; src.len()];
        matrices.apply_many_into(count, &src, &mut dst);
        for k in 0..count {
            let take = |all: &[f64]| all[k..].iter().step_by(count).copied().collect::<Vec<f64>>();
            let mut expected = vec![f64::NAN; order * order];
            matrices.apply_into(&take(&src), &mut expected);
            assert_eq!(take(&dst), expected, "order {order}, function {k} of {count}");
        }
    }
}

#[test]
fn planes_of_any_length_are_turned_to_their_end() {
    let rotation = Rotation::from_euler_zyz(0.2, 2.0, -1.0);
    for order in [1, 3, 4, 9] {
        let matrices = RotationMatrices::<f32>::new(&rotation, order);
        // Less than a block, a block, some; a tile of them, one with a rest, two and a rest.
        for count in [15, 16, 47, 128, 131, 300] {
            let src: Vec<f32> = Random::new(31).signed_vec(order * order * count).iter().map(|x| *x as f32).collect();
            let mut dst = vec![f32::NAN; src.len()];
            matrices.apply_many_into(count, &src, &mut dst);
            for k in 0..count {
                let take = |all: &[f32]| all[k..].iter().step_by(count).copied().collect::<Vec<f32>>();
                let mut expected = vec![f32::NAN; order * order];
                matrices.apply_into(&take(&src), &mut expected);
                for (x, y) in take(&dst).into_iter().zip(expected) {
                    assert!((x - y).abs() < 3e-6, "order {order}, function {k} of {count}: {x} against {y}");
                }
            }
        }
    }
}

#[test]
fn a_band_turns_the_same_whatever_the_order() {
    let f = random_expansion(20, 37);
    let rotation = Rotation::from_euler_zyz(-0.7, 0.9, 2.5);
    let whole = f.rotated(&rotation);
    for order in 0..20 {
        assert_eq!(f.resized(order).rotated(&rotation), whole.resized(order), "order {order}");
    }
    assert_eq!(ShL3::<f64>::from_slice(f.coefficients()).rotated(&rotation), ShL3::from_slice(whole.coefficients()));
}
