//! Skies: their pictures, expansions and polynomial fits.
use std::f64::consts::{FRAC_PI_2, PI};

use lobe_env::{
    CieSky, EnvError, Ground, PreethamFit, PreethamSky, Sky, SkyFitOptions, damp_zonal_in_place, irradiance_at,
    project_env, sky_map, sky_sh, vector_irradiance,
};
use lobe_sh::basis::coefficient_index;
use lobe_sh::{Coefficient, Dir, Expansion, Rgb, ShVec, Zonal, eval_basis};
use lobe_testkit::directions;

const GROUND: Ground = Ground { albedo: Rgb::new(0.3, 0.2, 0.1), sun: Rgb::new(20.0, 18.0, 15.0) };

fn norm(f: &ShVec<Rgb<f64>>) -> f64 {
    f.coefficients().iter().flat_map(|c| c.to_array()).map(|c| c * c).sum::<f64>().sqrt()
}

fn preetham(turbidity: f64, sun: Dir) -> PreethamSky {
    PreethamSky::new(turbidity, sun).unwrap()
}

#[test]
fn the_picture_of_a_sky_has_the_coefficients_of_its_formula() {
    let sun = Dir::from_angles(0.9, 2.4);
    let check = |name: &str, sky: &dyn Fn() -> (ShVec<Rgb<f64>>, ShVec<Rgb<f64>>)| {
        let (formula, picture) = sky();
        let error = norm(&(&formula - &picture)) / norm(&formula);
        println!("{name}: {error:.1e}");
        // The texels of 512 x 256 sample the sky at their centers only.
        assert!(error < 1e-4, "{name}: {error:.1e}");
    };
    check("Preetham", &|| {
        let sky = preetham(3.0, sun);
        (sky_sh(&sky, &GROUND, 6), project_env(&sky_map(&sky, &GROUND, 512, 256), 6))
    });
    for kind in [1, 4, 7, 12, 16] {
        check(&format!("CIE {kind}"), &|| {
            let sky = CieSky::new(kind, sun, Rgb::new(2.0, 3.0, 4.0)).unwrap();
            (sky_sh(&sky, &GROUND, 6), project_env(&sky_map(&sky, &GROUND, 512, 256), 6))
        });
    }
}

#[test]
fn a_surface_under_a_sky_gets_what_the_sum_over_its_picture_gives() {
    let sky = preetham(4.0, Dir::from_angles(0.6, -2.0));
    let map = sky_map(&sky, &GROUND, 512, 256);
    let irradiance = sky_sh(&sky, &GROUND, 9).convolved(&Zonal::clamped_cosine(9));
    let normals: Vec<Dir> = directions().into_iter().map(|v| Dir::new(v).unwrap()).collect();
    let largest = irradiance_at(&map, &[sky.sun()])[0].g;
    for (n, expected) in normals.iter().zip(irradiance_at(&map, &normals)) {
        // Order 9 keeps all but a few thousandths of the irradiance.
        let error = (irradiance.eval(*n).g - expected.g) / largest;
        assert!(error.abs() < 4e-3, "facing {n:?}: {error}");
    }
    let e = vector_irradiance(&map);
    assert!(e.net(Dir::Z).g > 0.0 && e.luminance_dir().unwrap().z() > 0.5, "{e:?}");
}

#[test]
fn turning_the_sun_turns_the_sky() {
    for phi in [1.0, PI, -2.2] {
        let (still, turned) = (preetham(3.0, Dir::from_angles(0.8, 0.0)), preetham(3.0, Dir::from_angles(0.8, phi)));
        let rotation = lobe_sh::Rotation::from_axis_angle(Dir::Z, phi);
        let expected = sky_sh(&still, &GROUND, 6).rotated(&rotation);
        let error = norm(&(&sky_sh(&turned, &GROUND, 6) - &expected)) / norm(&expected);
        assert!(error < 1e-13, "φ = {phi}: {error}");
    }
}

#[test]
fn the_fit_has_the_errors_of_its_table() {
    let mut truth = Vec::new();
    for a in 0..=30 {
        for b in 0..=12 {
            let (turbidity, sun) =
                (2.0 + 8.0 * f64::from(b) / 12.0, Dir::from_angles(FRAC_PI_2 * f64::from(a) / 30.0, 0.7));
            truth.push((turbidity, sun, sky_sh(&preetham(turbidity, sun), &Ground::default(), 7)));
        }
    }
    for (sun_degree, turbidity_degree, mean_limit, largest_limit) in
        [(13, 7, 5e-4, 2.2e-3), (10, 5, 3e-3, 1.3e-2), (8, 4, 8e-3, 3.5e-2), (6, 3, 2.3e-2, 9.5e-2)]
    {
        let fit = PreethamFit::new(
            SkyFitOptions::default().order(7).sun_degree(sun_degree).turbidity_degree(turbidity_degree),
        )
        .unwrap();
        let errors: Vec<f64> =
            truth.iter().map(|(turbidity, sun, f)| norm(&(&fit.eval(*turbidity, *sun) - f)) / norm(f)).collect();
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        let largest = errors.iter().copied().fold(0.0, f64::max);
        println!("degrees {sun_degree}, {turbidity_degree}: mean {mean:.2e}, largest {largest:.2e}");
        assert!(mean < mean_limit, "degrees {sun_degree}, {turbidity_degree}: mean {mean}");
        assert!(largest < largest_limit, "degrees {sun_degree}, {turbidity_degree}: largest {largest}");
    }
}

#[test]
fn the_fit_stays_at_the_ends_of_its_ranges() {
    let fit = PreethamFit::new(SkyFitOptions::default().order(3).sun_degree(6).turbidity_degree(3)).unwrap();
    let low = Dir::from_angles(FRAC_PI_2, 0.4);
    assert_eq!(fit.eval(99.0, Dir::Z), fit.eval(10.0, Dir::Z), "turbidity 99");
    assert_eq!(fit.eval(0.0, Dir::Z), fit.eval(2.0, Dir::Z), "turbidity 0");
    let (below, on) = (fit.eval(3.0, Dir::from_angles(2.0, 0.4)), fit.eval(3.0, low));
    assert!(norm(&(&below - &on)) < 1e-12 * norm(&on), "the sun below the horizon");
    let refused = PreethamFit::new(SkyFitOptions::default().order(0));
    assert!(matches!(refused, Err(EnvError::Options(_))), "order 0: {refused:?}");
}

#[test]
fn the_fit_has_the_same_bits_for_any_number_of_threads() {
    let options = SkyFitOptions::default().order(3).sun_degree(3).turbidity_degree(2);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| PreethamFit::new(options).unwrap().eval(3.3, Dir::from_angles(0.5, 1.5)))
    };
    assert_eq!(with(1), with(3), "one thread against three");
}

#[test]
fn zonal_lanczos_damps_the_ringing_below_the_horizon() {
    let sky = sky_sh(&preetham(3.0, Dir::from_angles(0.7, 0.5)), &Ground::default(), 7);
    let mut damped = sky.clone();
    damp_zonal_in_place(damped.coefficients_mut());
    for i in 0..49_usize {
        let zonal = i == coefficient_index(i.isqrt(), 0);
        assert!(zonal || damped[i] == sky[i], "coefficient {i} is not zonal");
    }
    assert_eq!(damped[0], sky[0], "the mean");
    let ringing = |f: &ShVec<Rgb<f64>>| {
        let below = directions().into_iter().map(|v| Dir::new(v).unwrap()).filter(|s| s.z() < -0.3);
        below.map(|s| f.eval(s).g.abs()).fold(0.0, f64::max)
    };
    assert!(ringing(&damped) < 0.8 * ringing(&sky), "{} and {}", ringing(&damped), ringing(&sky));
    assert!(ringing(&sky) > 0.0 && sky.mean().g > Rgb::<f64>::ZERO.g, "there is a sky");
}

#[test]
fn damping_the_zonal_part_lowers_a_sun_by_half_at_the_zenith_and_little_below() {
    // Of the peak n²/4π of an impulse at the angle t from +z, Σ_l (2l + 1)/n² P_l(cos t)² (1 - sin(πl/n)/(πl/n)) is lost.
    for (order, degrees, expected) in
        [(6, 0.0, 0.4923), (6, 45.0, 0.0647), (4, 0.0, 0.4385), (4, 60.0, 0.0651), (6, 90.0, 0.0266_f64)]
    {
        let towards = Dir::from_angles(f64::to_radians(degrees), 0.4);
        let mut sun = ShVec::<f64>::zero(order);
        sun.coefficients_mut().copy_from_slice(&eval_basis(towards, order));
        let before = sun.eval(towards);
        damp_zonal_in_place(sun.coefficients_mut());
        let lost = 1.0 - sun.eval(towards) / before;
        assert!((lost - expected).abs() < 1e-4, "order {order}, {degrees}°: {lost} is lost, expected {expected}");
    }
}
