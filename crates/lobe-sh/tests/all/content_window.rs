//! The window that depends on the content: none towards the light, smooth away from it.

use std::f64::consts::PI;

use lobe_sh::expansion::optimal_linear_direction;
use lobe_sh::ringing::ContentWindow;
use lobe_sh::sphere::SphereQuadrature;
use lobe_sh::{Coefficient as _, Dir, Expansion as _, Rgb, Rotation, Sh, ShVec, Window, Zonal};
use lobe_testkit::{Random, directions, fibonacci_sphere};

const WINDOWS: [Window; 5] = [
    Window::Hanning { width: 6.0 },
    Window::Lanczos { width: 6.0, power: 4.0 },
    Window::Gauss { sigma: 0.3 },
    Window::SquaredLaplacian { lambda: 0.00420855331055888 },
    Window::PunctualLight,
];

/// The 26 axes and diagonals of the cube come first among the test directions.
const SUNS: usize = 26;

fn all_directions() -> impl Iterator<Item = Dir> {
    directions().into_iter().chain(fibonacci_sphere(2000)).map(Dir::from_unit)
}

fn random(order: usize, seed: u64) -> ShVec<Rgb<f64>> {
    let mut random = Random::new(seed);
    let mut f = ShVec::zero(order);
    f.coefficients_mut().fill_with(|| Rgb::new(random.signed(), random.signed(), random.signed()));
    f
}

fn largest(c: Rgb<f64>) -> f64 {
    c.to_array().into_iter().fold(0.0, |m, x| m.max(x.abs()))
}

/// The value at the peak and the least value of a function about +z.
fn extremes(f: impl Fn(Dir) -> f64) -> [f64; 2] {
    let least = (0..=3600).map(|k| f(Dir::from_angles(f64::from(k) * PI / 3600.0, 0.7)));
    [f(Dir::Z), least.fold(f64::INFINITY, f64::min)]
}

#[test]
fn the_weight_is_one_at_the_light_and_zero_from_the_threshold_on() {
    for v in directions() {
        let r = Dir::from_unit(v);
        let content = ContentWindow { dir: Some(r), window: WINDOWS[0] };
        assert!((content.weight(r) - 1.0).abs() < 1e-14, "at {r:?}: {}", content.weight(r));
        for n in all_directions() {
            let (t, w) = (n.dot(r), content.weight(n));
            let published = ((t - 0.07) / 0.93).max(0.0).powf(0.8);
            assert!((w - published).abs() < 1e-14 && (0.0..=1.0).contains(&w), "n·r = {t}: {w} against {published}");
            assert!(t > 0.07 || w == 0.0, "n·r = {t}: {w}");
        }
    }
}

#[test]
fn the_blend_is_raw_towards_the_light_windowed_behind_it_and_between_them_elsewhere() {
    for (seed, window) in WINDOWS.into_iter().enumerate() {
        let f = random(6, seed as u64);
        let smooth = f.windowed(&window);
        let content = ContentWindow::of(&f, window);
        let r = optimal_linear_direction(&f).unwrap();
        assert_eq!(content.dir, Some(r), "one direction for all channels, that of the luminance");
        let at_light = largest(content.eval(&f, r) - f.eval(r));
        assert!(at_light < 1e-13, "{window}: {at_light} from the raw function towards the light");
        for n in all_directions() {
            let (raw, smooth, found) = (f.eval(n), smooth.eval(n), content.eval(&f, n));
            let w = content.weight(n);
            let blend = raw.scale(w) + smooth.scale(1.0 - w);
            assert!(largest(found - blend) < 1e-13, "{window}, {n:?}: {found:?} against {blend:?}");
            for c in 0..3 {
                let [raw, smooth, found] = [raw, smooth, found].map(|v| v.channel(c));
                assert!(found >= raw.min(smooth) - 1e-13, "{window}, {n:?}: {found} below {raw} and {smooth}");
                assert!(n.dot(r) > 0.07 || (found - smooth).abs() < 1e-13, "{window}, {n:?}: {found}, not {smooth}");
            }
        }
    }
}

#[test]
fn numbers_colors_and_fixed_orders_agree() {
    let f = random(4, 8);
    let window = WINDOWS[0];
    let luminance = f.map(Rgb::luminance);
    let content = ContentWindow::of(&f, window);
    let fixed: Sh<16, Rgb<f32>> =
        Sh::from(std::array::from_fn(|i| Rgb::new(f[i].r as f32, f[i].g as f32, f[i].b as f32)));
    let projected = content.project(&f, 5).map(Rgb::luminance);
    let of_luminance = content.project(&luminance, 5);
    for i in 0..25 {
        let (a, b) = (projected[i], of_luminance[i]);
        assert!((a - b).abs() < 1e-13, "coefficient {i}: {a} against {b}");
    }
    for n in all_directions() {
        let [a, b] = [content.eval(&f, n).luminance(), content.eval(&luminance, n)];
        assert!((a - b).abs() < 1e-13, "{n:?}: {a} against {b}");
        let single = ContentWindow::of(&fixed, window).eval(&fixed, n);
        assert!((f64::from(single.luminance()) - a).abs() < 1e-5, "{n:?}: {single:?} against {a}");
    }
}

#[test]
fn rotation_commutes_with_the_window_and_with_its_projection() {
    let f = random(5, 3);
    let content = ContentWindow::of(&f, WINDOWS[3]);
    let projected = content.project(&f, 7);
    for seed in 0..20 {
        let rotation = Rotation::from_quaternion(Random::new(seed).quaternion()).unwrap();
        let turned = f.rotated(&rotation);
        let turned_content = ContentWindow::of(&turned, WINDOWS[3]);
        for n in all_directions() {
            let [a, b] = [turned_content.eval(&turned, rotation.rotate_dir(n)), content.eval(&f, n)];
            // The infinite slope at the threshold makes 1e-9 of a rounding of 1e-16 a little further on.
            assert!(largest(a - b) < 1e-10, "turn {seed}, {n:?}: {a:?} against {b:?}");
        }
        let difference = &turned_content.project(&turned, 7) - &projected.rotated(&rotation);
        let worst = difference.coefficients().iter().fold(0.0_f64, |m, c| m.max(largest(*c)));
        assert!(worst < 1e-12, "turn {seed}: the projections differ by {worst}");
    }
}

#[test]
fn without_a_direction_the_window_is_everywhere() {
    let mut flat = random(4, 5);
    flat.band_mut(1).fill(Rgb::splat(0.0));
    let mut endless = random(4, 5);
    endless[2] = Rgb::splat(f64::INFINITY);
    for f in [flat, random(1, 2), ShVec::zero(3), ShVec::zero(0)] {
        let content = ContentWindow::of(&f, WINDOWS[0]);
        assert_eq!(content.dir, None, "{f:?}");
        let smooth = f.windowed(&WINDOWS[0]);
        assert_eq!(content.project(&f, f.order()), smooth, "projected");
        for n in all_directions() {
            let [a, b] = [content.eval(&f, n), smooth.eval(n)];
            assert!(largest(a - b) < 1e-14, "{n:?}: {a:?} against {b:?}");
        }
    }
    assert_eq!(ContentWindow::of(&endless, WINDOWS[0]).dir, None, "band 1 is not finite");
}

#[test]
fn the_projection_is_that_of_a_fine_quadrature() {
    // About +z the kink lies between rows, so that rules on either side of it converge: u^0.8 at u = 0 by a substitution.
    let f = random(5, 11);
    let content = ContentWindow { dir: Some(Dir::Z), window: WINDOWS[1] };
    let order = 8;
    let found = content.project(&f, order);
    let mut expected = ShVec::<Rgb<f64>>::zero(order);
    let mut energy = 0.0;
    let mut add = |z: f64, weight: f64| {
        for k in 0..32 {
            let phi = 2.0 * PI * f64::from(k) / 32.0;
            let n = Dir::new([(1.0 - z * z).sqrt() * phi.cos(), (1.0 - z * z).sqrt() * phi.sin(), z]).unwrap();
            let value = content.eval(&f, n);
            let weight = weight * 2.0 * PI / 32.0;
            energy += weight * value.to_array().iter().map(|c| c * c).sum::<f64>();
            for (i, y) in lobe_sh::eval_basis(n, order).into_iter().enumerate() {
                expected[i] += value.scale(weight * y);
            }
        }
    };
    for (x, w) in lobe_sh::sphere::gauss_legendre(80) {
        add(0.07 - 0.5 * 1.07 * (1.0 + x), 0.5 * 1.07 * w);
        // z = 0.07 + 0.93 v^5: u^0.8 becomes v^4.
        let v = 0.5 * (1.0 + x);
        add(0.07 + 0.93 * v.powi(5), 0.5 * w * 0.93 * 5.0 * v.powi(4));
    }
    for i in 0..order * order {
        let error = largest(found[i] - expected[i]);
        assert!(error < 1e-13, "coefficient {i}: {:?} against {:?}", found[i], expected[i]);
    }
    let found = content.energy(&f);
    assert!((found / energy - 1.0).abs() < 1e-13, "energy {found} against {energy}");
}

#[test]
fn projections_approach_the_energy_of_the_blend() {
    let f = random(6, 4);
    for window in WINDOWS {
        let content = ContentWindow::of(&f, window);
        let energy = content.energy(&f);
        let rule = SphereQuadrature::of_degree(200);
        let sampled = rule.integrate(|n| content.eval(&f, n).to_array().iter().map(|c| c * c).sum());
        assert!((sampled / energy - 1.0).abs() < 1e-5, "{window}: energy {energy}, sampled {sampled}");
        let mut before = f64::INFINITY;
        for order in [3, 6, 9, 12, 24] {
            let g = content.project(&f, order);
            let lost = 1.0 - g.dot(&g).to_array().iter().sum::<f64>() / energy;
            assert!(lost >= 0.0 && lost < before, "{window}, order {order}: {lost} lost, {before} before");
            before = lost;
        }
        assert!(before < 1e-4, "{window}: order 24 loses {before}");
    }
}

#[test]
fn suns_keep_their_peak_and_ring_less() {
    let lambda = Window::SquaredLaplacian { lambda: 0.00420855331055888 };
    let peak = 36.0 / (4.0 * PI);
    for v in &directions()[..SUNS] {
        let sun = Dir::from_unit(*v);
        let f = ShVec::<f64>::impulse(6, sun, 1.0);
        for window in [lambda, WINDOWS[0]] {
            let (smooth, content) = (f.windowed(&window), ContentWindow::of(&f, window));
            let least = |g: &dyn Fn(Dir) -> f64| all_directions().map(g).fold(f64::INFINITY, f64::min);
            let [raw, blend] = [least(&|n| f.eval(n)), least(&|n| content.eval(&f, n))];
            assert!(blend > raw + 0.1, "{window}, {sun:?}: least value {blend}, raw {raw}");
            let [kept, lowered] = [content.eval(&f, sun), smooth.eval(sun)];
            assert!((kept - peak).abs() < 1e-12, "{window}, {sun:?}: peak {kept} of {peak}");
            assert!(lowered < 0.6 * peak, "{window}, {sun:?}: the plain window leaves {lowered} of {peak}");
        }
    }
    let f = Zonal::impulse(6).towards(Dir::Z, 1.0);
    let content = ContentWindow::of(&f, WINDOWS[0]);
    let [peak, least] = extremes(|n| content.eval(&f, n));
    let [_, raw] = extremes(|n| f.eval(n));
    assert!((peak - 2.865).abs() < 5e-4 && (least + 0.257).abs() < 5e-4, "peak {peak}, least value {least}");
    assert!((raw + 0.477).abs() < 5e-4, "least value of the raw sun: {raw}");
}

#[test]
fn the_projection_of_a_sun_loses_what_is_stated() {
    let f = ShVec::<f64>::impulse(6, Dir::Z, 1.0);
    let content = ContentWindow::of(&f, Window::Hanning { width: 6.0 });
    for (order, stated, its_peak) in [(6, 0.1921, 2.521), (8, 0.0216, 2.899), (12, 0.0069, 2.874)] {
        let g = content.project(&f, order);
        let lost = (1.0 - g.dot(&g) / content.energy(&f)).sqrt();
        let [peak, _] = extremes(|n| g.eval(n));
        assert!((lost - stated).abs() < 1e-4, "order {order} loses {lost} of the root mean square");
        assert!((peak - its_peak).abs() < 1e-3, "order {order} has the peak {peak}");
    }
}
