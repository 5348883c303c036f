//! Small encodings of irradiance: what all of them keep, and what each does beside the others.

use std::f64::consts::PI;

use lobe_sh::encoding::{IrradianceEncoding, PackedIrradiance5, Zh3, Zh3Axis, encoding_error};
use lobe_sh::rotation::tangent_frame;
use lobe_sh::sphere::SphereQuadrature;
use lobe_sh::{Coefficient, Dir, Expansion as _, Rgb, Rotation, Sh, ShVec, Zonal, eval_basis};
use lobe_testkit::{Random, directions, fibonacci_sphere};

/// What the channels add to the luminance; they sum to 1.
const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

const AXES: [Zh3Axis; 2] = [Zh3Axis::Luminance, Zh3Axis::PerChannel];

fn worst(a: Rgb<f64>, b: Rgb<f64>) -> f64 {
    (0..3)
        .map(|c| (a.channel(c) - b.channel(c)).abs())
        .fold(0.0, |worst, e| if e > worst || e.is_nan() { e } else { worst })
}

/// The irradiance of an ambient light and some colored lamps.
fn lamps(seed: u64, count: usize, order: usize) -> ShVec<Rgb<f64>> {
    let mut random = Random::new(seed);
    let mut e = ShVec::constant(order, Rgb::splat(random.unit()));
    for _ in 0..count {
        let color = Rgb::new(random.unit(), random.unit(), random.unit());
        e += &Zonal::clamped_cosine(order).towards(Dir::from_unit(random.direction()), color);
    }
    e
}

fn random_expansion(seed: u64, order: usize) -> ShVec<Rgb<f64>> {
    let mut random = Random::new(seed);
    let color = |_| Rgb::new(random.signed(), random.signed(), random.signed());
    ShVec::from_vec((0..order * order).map(color).collect()).unwrap()
}

#[test]
fn constant_light_is_exact_in_every_encoding_that_has_a_constant() {
    let white = ShVec::constant(8, Rgb::new(PI, 0.5, 0.0));
    for encoding in IrradianceEncoding::ALL {
        for v in directions().into_iter().step_by(5) {
            let normal = Dir::from_unit(v);
            let frame = tangent_frame(normal);
            let encoded = encoding.encode(&white, frame);
            for s in directions() {
                let n = Dir::from_unit(s);
                let above = n.dot(normal);
                if encoding.is_hemispherical() && above < 0.0 {
                    continue;
                }
                let factor = if encoding == IrradianceEncoding::Hl2Linear { 1.5 * above } else { 1.0 };
                let expected = Rgb::new(PI, 0.5, 0.0).scale(factor);
                let found = encoded.eval(n);
                assert!(worst(found, expected) < 2e-13, "{}, towards {s:?}: {found:?}", encoding.name());
            }
        }
    }
}

#[test]
fn names_differ_and_only_order_5_takes_more_than_nine_numbers_a_channel() {
    let names: Vec<_> = IrradianceEncoding::ALL.map(IrradianceEncoding::name).to_vec();
    for (k, name) in names.iter().enumerate() {
        assert!(!names[..k].contains(name), "{name} twice");
    }
    for encoding in IrradianceEncoding::ALL {
        let (rgb, one) = (encoding.floats(3), encoding.floats(1));
        let most = if encoding == IrradianceEncoding::Sh5 { 18 } else { 9 };
        assert!((9..=3 * most).contains(&rgb) && one <= most, "{}: {rgb} and {one}", encoding.name());
    }
}

/// One lamp that gives 1 to a surface facing it: what is found facing it, beside it and turned away.
#[test]
fn one_lamp_has_its_known_values() {
    let sun = Dir::from_angles(1.2, 0.4);
    let beside = tangent_frame(sun).rotate_dir(Dir::X);
    let e = Zonal::clamped_cosine(64).towards(sun, 1.0);
    // hallucinated: L_1/L_0 = √3, so that z_2 is √3 (0.08 + 0.6 √3) / √5 of that of the lamp.
    let share = 3.0_f64.sqrt() * (0.08 + 0.6 * 3.0_f64.sqrt()) / 5.0_f64.sqrt();
    let p_2 = |t: f64| 5.0 / 16.0 * 0.5 * (3.0 * t * t - 1.0);
    let linear = |t: f64| 0.25 + 0.5 * t;
    for (encoding, [front, side, back]) in [
        (IrradianceEncoding::Sh2, [0.75, 0.25, -0.25]),
        (IrradianceEncoding::Sh3, [17.0 / 16.0, 3.0 / 32.0, 1.0 / 16.0]),
        (IrradianceEncoding::Sh5, [31.0 / 32.0, 15.0 / 256.0, -1.0 / 32.0]),
        (IrradianceEncoding::NonLinearL1, [1.0, 0.125, 0.0]),
        (IrradianceEncoding::Zh3Projected(Zh3Axis::Luminance), [17.0 / 16.0, 3.0 / 32.0, 1.0 / 16.0]),
        (IrradianceEncoding::Zh3Solved(Zh3Axis::PerChannel), [17.0 / 16.0, 3.0 / 32.0, 1.0 / 16.0]),
        (IrradianceEncoding::Zh3Hallucinated(Zh3Axis::Luminance), [1.0, 0.0, -1.0].map(|t| linear(t) + share * p_2(t))),
    ] {
        let encoded = encoding.encode(&e, Rotation::IDENTITY);
        for (n, expected) in [(sun, front), (beside, side), (-sun, back)] {
            let found = encoded.eval(n);
            assert!((found - expected).abs() < 1e-14, "{} towards {n:?}: {found} against {expected}", encoding.name());
        }
    }
    for encoding in [IrradianceEncoding::AhdLinear, IrradianceEncoding::AhdSolved] {
        let encoded = encoding.encode(&e, Rotation::IDENTITY);
        for (n, expected) in [(sun, 1.0), (beside, 0.0), (-sun, 0.0)] {
            let found = encoded.eval(n);
            // The expansion ends at band 63.
            assert!((found - expected).abs() < 1e-5, "{} towards {n:?}: {found} against {expected}", encoding.name());
        }
    }
}

#[test]
fn bands_that_are_zonal_about_one_axis_are_kept_by_zh3() {
    let color = Rgb::new(1.0, 0.3, 0.7);
    for v in directions() {
        let axis = Dir::from_unit(v);
        let mut e = Zonal::new(vec![0.4, 1.3, -0.8]).towards(axis, color);
        e += &ShVec::constant(3, Rgb::new(0.1, 0.2, 0.3));
        for kind in AXES {
            for encoded in [Zh3::projected(&e, kind), Zh3::solved(&e, kind)] {
                for s in directions().into_iter().step_by(3) {
                    let n = Dir::from_unit(s);
                    let (found, expected) = (encoded.eval(n), e.eval(n));
                    assert!(worst(found, expected) < 1e-7, "axis {v:?} {kind:?}, {s:?}: {found:?}, not {expected:?}");
                }
            }
        }
    }
}

/// The squared error against bands 0 to 2, channels weighted as given, by quadrature.
fn squared_error(weights: [f64; 3], encoded: &Zh3<Rgb<f64>>, e: &ShVec<Rgb<f64>>) -> f64 {
    SphereQuadrature::of_degree(4).integrate(|n| {
        let d = encoded.eval(n) - e.eval(n);
        weights[0] * d.r * d.r + weights[1] * d.g * d.g + weights[2] * d.b * d.b
    })
}

/// The best weighted squared error with a given axis: the channels' linear vectors moved so that their luminance points along it.
fn error_with_axis(axis: Dir, e: &ShVec<Rgb<f64>>) -> f64 {
    let y = eval_basis(axis, 3);
    let mut left = 0.0;
    let mut vector = [0.0; 3];
    for (c, w) in LUMINANCE.into_iter().enumerate() {
        let band: Vec<f64> = e.band(2).iter().map(|x| x.channel(c)).collect();
        let along: f64 = band.iter().zip(&y[4..]).map(|(f, y)| f * y).sum::<f64>() * (4.0 * PI / 5.0).sqrt();
        left += w * (band.iter().map(|f| f * f).sum::<f64>() - along * along);
        for (sum, i) in vector.iter_mut().zip([3, 1, 2]) {
            *sum += w * e[i].channel(c) * if i == 2 { 1.0 } else { -1.0 };
        }
    }
    let [x, y, z] = axis.to_array();
    let along = vector[0] * x + vector[1] * y + vector[2] * z;
    let across = vector.iter().map(|v| v * v).sum::<f64>() - along * along;
    left + across
}

#[test]
fn the_solved_axis_is_the_best_of_a_dense_grid() {
    let grid: Vec<Dir> = fibonacci_sphere(4000).into_iter().map(Dir::from_unit).collect();
    for seed in 0..40 {
        let e = if seed % 2 == 0 { lamps(seed, 3, 3) } else { random_expansion(seed, 3) };
        let solved = squared_error(LUMINANCE, &Zh3::solved(&e, Zh3Axis::Luminance), &e);
        let projected = squared_error(LUMINANCE, &Zh3::projected(&e, Zh3Axis::Luminance), &e);
        let best = grid.iter().map(|d| error_with_axis(*d, &e)).fold(f64::INFINITY, f64::min);
        assert!(solved <= best + 1e-12, "seed {seed}: {solved} against {best} on the grid");
        assert!(solved <= projected + 1e-12, "seed {seed}: {solved} against {projected} projected");
        let own = |encoded: Zh3<Rgb<f64>>| squared_error([1.0; 3], &encoded, &e);
        let solved = own(Zh3::solved(&e, Zh3Axis::PerChannel));
        let projected = own(Zh3::projected(&e, Zh3Axis::PerChannel));
        assert!(solved <= projected + 1e-12, "seed {seed}, own axes: {solved} against {projected} projected");
    }
}

/// Encodings that turn with the light: all of the whole sphere but the cube.
#[test]
fn encodings_turn_with_the_light_where_they_can() {
    let mut random = Random::new(9);
    for seed in 0..10 {
        let e = lamps(seed, 3, 6);
        let turn = Rotation::from_quaternion(random.quaternion()).unwrap();
        let turned = e.rotated(&turn);
        for encoding in IrradianceEncoding::ALL.into_iter().filter(|e| !e.is_hemispherical()) {
            let (f, g) = (encoding.encode(&e, Rotation::IDENTITY), encoding.encode(&turned, Rotation::IDENTITY));
            let error = directions()
                .into_iter()
                .map(|v| worst(f.eval(Dir::from_unit(v)), g.eval(turn.rotate_dir(Dir::from_unit(v)))))
                .fold(0.0, f64::max);
            let is_cube =
                matches!(encoding, IrradianceEncoding::AmbientCubeAxes | IrradianceEncoding::AmbientCubeFitted);
            let equal = error < 1e-6;
            assert_eq!(equal, !is_cube, "{} of seed {seed}: turned light differs by {error}", encoding.name());
        }
    }
}

/// Those of a hemisphere turn with the light and the surface together.
#[test]
fn hemispherical_encodings_turn_with_light_and_surface() {
    let e = lamps(3, 3, 6);
    let turn = Rotation::from_axis_angle(Dir::from_angles(0.7, 0.2), 1.9);
    let turned = e.rotated(&turn);
    for encoding in IrradianceEncoding::ALL.into_iter().filter(|e| e.is_hemispherical()) {
        let frame = tangent_frame(Dir::from_angles(2.0, -1.0));
        let (f, g) = (encoding.encode(&e, frame), encoding.encode(&turned, frame.then(turn)));
        for v in directions() {
            let n = Dir::from_unit(v);
            let (a, b) = (f.eval(n), g.eval(turn.rotate_dir(n)));
            assert!(worst(a, b) < 1e-11, "{} towards {v:?}: {a:?}, turned {b:?}", encoding.name());
        }
    }
}

#[test]
fn encodings_that_promise_it_are_never_negative() {
    use IrradianceEncoding as E;
    for seed in 0..20 {
        let e = if seed % 2 == 0 { lamps(seed, 2, 12) } else { random_expansion(seed, 3) };
        for encoding in [E::NonLinearL1, E::AhdLinear, E::AhdSolved] {
            let encoded = encoding.encode(&e, Rotation::IDENTITY);
            for v in directions() {
                let found = encoded.eval(Dir::from_unit(v));
                let least = found.r.min(found.g).min(found.b);
                assert!(least >= 0.0, "{} of seed {seed}, towards {v:?}: {found:?}", encoding.name());
            }
        }
    }
}

#[test]
fn no_light_is_dark_and_nan_stays_in_its_channel() {
    let mut spoiled = lamps(1, 2, 4);
    spoiled[0].g = f64::NAN;
    spoiled[2].g = f64::NAN;
    let frame = tangent_frame(Dir::from_angles(1.0, 1.0));
    for encoding in IrradianceEncoding::ALL {
        for order in [0, 1, 3] {
            let dark = encoding.encode(&ShVec::<Rgb<f64>>::zero(order), frame).eval(Dir::Z);
            assert_eq!(dark, Rgb::ZERO, "{} of order {order}", encoding.name());
        }
        let found = encoding.encode(&spoiled, frame).eval(Dir::Z);
        let others = found.r.is_finite() && found.b.is_finite();
        assert!(others && found.g.is_nan(), "{}: {found:?}", encoding.name());
    }
}

#[test]
fn errors_are_those_of_their_definition() {
    let sun = Dir::from_angles(0.5, 2.0);
    let e = Zonal::clamped_cosine(24).towards(sun, 1.0);
    let truth: Vec<(Dir, f64)> =
        fibonacci_sphere(8000).into_iter().map(Dir::from_unit).map(|n| (n, n.dot(sun).max(0.0))).collect();
    // The mean irradiance of one lamp is 1/4; RMS 0.144338, largest 1/4, lowest -1/4 at order 2, 0.036084, 3/32 and -0.039583
    // at order 3, half the RMS, 15/256 and -1/32 at order 5: the squares are 1/6 of 1/8, 1/128 and 1/512.
    for (encoding, rms, max, lowest) in [
        (IrradianceEncoding::Sh2, 0.144338, 0.25, -0.25),
        (IrradianceEncoding::Sh3, 0.036084, 3.0 / 32.0, -0.039583),
        (IrradianceEncoding::Sh5, 0.018042, 15.0 / 256.0, -1.0 / 32.0),
    ] {
        let found = encoding_error(encoding, &e, &truth);
        let close = |a: f64, b: f64| (a - b).abs() < 1e-3 * b.abs();
        let all = close(found.rms, 4.0 * rms) && close(found.max, 4.0 * max) && close(found.lowest, lowest);
        assert!(all && found.mean < found.rms, "{}: {found:?}", encoding.name());
    }
    let nothing = encoding_error(IrradianceEncoding::Sh2, &e, &[]);
    assert!(nothing.mean.is_nan() && nothing.rms.is_nan(), "without values: {nothing:?}");
}

#[test]
fn order_5_is_the_irradiance_of_four_bands_towards_every_normal() {
    for seed in 0..5 {
        let radiance = random_expansion(seed, 5);
        let e = radiance.convolved(&Zonal::clamped_cosine(5));
        let encoded = IrradianceEncoding::Sh5.encode(&e, Rotation::IDENTITY);
        let packed = PackedIrradiance5::from_irradiance_sh(&e);
        // More bands are not kept, nor is what band 3 of a function that is no irradiance holds.
        let mut longer = e.resized(7);
        longer.band_mut(3).fill(Rgb::splat(1.0));
        longer.band_mut(5).fill(Rgb::splat(1.0));
        let cut = IrradianceEncoding::Sh5.encode(&longer, Rotation::IDENTITY);
        assert_eq!(cut, encoded, "seed {seed}: bands 3 and 5");
        for v in directions() {
            let n = Dir::from_unit(v);
            let expected = e.eval(n);
            for (what, found) in [("bands", encoded.eval(n)), ("vectors", packed.eval(n))] {
                assert!(worst(found, expected) < 1e-14, "{what} of seed {seed} towards {v:?}: {found:?}, {expected:?}");
            }
        }
    }
}

#[test]
fn a_shared_axis_leaves_gray_light_gray() {
    let gray = lamps(5, 3, 3).map(|c| Rgb::splat(c.luminance()));
    let one = gray.map(|c| c.r);
    for kind in AXES {
        for (a, b) in [
            (Zh3::projected(&gray, kind), Zh3::projected(&one, kind)),
            (Zh3::hallucinated(&gray, kind), Zh3::hallucinated(&one, kind)),
            (Zh3::solved(&gray, kind), Zh3::solved(&one, kind)),
        ] {
            for v in directions() {
                let n = Dir::from_unit(v);
                let (found, expected) = (a.eval(n), Rgb::splat(b.eval(n)));
                assert!(worst(found, expected) < 1e-9, "{kind:?} towards {v:?}: {found:?} against {expected:?}");
            }
        }
    }
}

#[test]
fn single_precision_is_enough() {
    let e = lamps(8, 3, 6);
    let single = e.map(Rgb::<f32>::narrow);
    let frame = tangent_frame(Dir::from_angles(2.2, 0.3));
    for encoding in IrradianceEncoding::ALL {
        let (wide, narrow) = (encoding.encode(&e, frame), encoding.encode(&single, frame));
        for v in directions() {
            let n = Dir::from_unit(v);
            let (a, b) = (wide.eval(n), narrow.eval(n).widen());
            assert!(worst(a, b) < 1e-4, "{} towards {v:?}: {a:?} against {b:?}", encoding.name());
        }
    }
}

/// Where no linear light says where, the axis is undefined and the last term left out: order 2 remains.
#[test]
fn without_a_linear_direction_zh3_is_order_2() {
    let mut e = Sh::<9, f64>::constant(1.0);
    e[6] = 0.5;
    for kind in AXES {
        for encoded in [Zh3::projected(&e, kind), Zh3::solved(&e, kind), Zh3::hallucinated(&e, kind)] {
            for v in directions() {
                let found = encoded.eval(Dir::from_unit(v));
                assert!((found - 1.0).abs() < 1e-14, "{kind:?} towards {v:?}: {found}");
            }
        }
    }
}

#[test]
fn an_encoding_keeps_as_many_numbers_as_it_says() {
    let sun = Zonal::clamped_cosine(9).towards(Dir::X, Rgb::new(1.0, 0.9, 0.8));
    for encoding in IrradianceEncoding::ALL {
        let numbers = encoding.encode(&sun, Rotation::IDENTITY).numbers();
        let count: usize = numbers.iter().map(|(_, values)| values.len()).sum();
        // What is hallucinated need not be kept.
        let found_again = if matches!(encoding, IrradianceEncoding::Zh3Hallucinated(_)) { 3 } else { 0 };
        assert_eq!(count, encoding.floats(3) + found_again, "{encoding}: {numbers:?}");
    }
}
