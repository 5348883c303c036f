//! The techniques of environment mapping against the light itself, as numbers.

use std::f64::consts::PI;

use lobe_env::{EnvMap, bundled, irradiance_at, irradiance_map_brute_force, project_env};
use lobe_figures::{
    BlinnNewell, CubeMapped, Exhibit, ExhibitSolid, MatteByMap, MatteBySh, Paraboloids, Shading, SphereMapped,
    SurfacePoint, Torus, TracedMirror, compare_shadings,
};
use lobe_image::{ErrorReport, compare};
use lobe_render::{Camera, View};
use lobe_sh::encoding::IrradiancePolynomial;
use lobe_sh::{Coefficient, Dir, Rgb};

/// A ball and a tilted torus before a perspective eye on the side of -x.
fn scenes() -> [Exhibit; 2] {
    let camera = Camera::perspective(View::ALONG_X, 4.0, 0.3);
    let torus = Torus { axis: Dir::new([-0.6, 0.25, 0.75]).unwrap(), major: 0.7, minor: 0.3 };
    [ExhibitSolid::Ball { radius: 1.0 }, ExhibitSolid::Torus(torus)].map(|solid| Exhibit { solid, camera, samples: 1 })
}

/// A smooth light without any symmetry, with details 20° wide.
fn smooth(s: Dir) -> Rgb<f32> {
    let f = |k: f64| 2.0 + (3.0 * s.x() + k).sin() * (2.0 * s.y()).cos() + (4.0 * s.z() - k * s.y()).sin();
    Rgb::new(f(0.3) as f32, f(1.1) as f32, f(2.0) as f32)
}

/// The four techniques with maps of about `2 size²` texels.
fn mirrors(size: usize, source: &(impl Fn(Dir) -> Rgb<f32> + Sync)) -> [(&'static str, Box<dyn Shading>); 4] {
    [
        ("Blinn-Newell", Box::new(BlinnNewell::sampled(size, source))),
        ("sphere map", Box::new(SphereMapped::sampled(size * 3 / 2, source))),
        ("cube map", Box::new(CubeMapped::sampled(size / 2, source))),
        ("paraboloids", Box::new(Paraboloids::sampled(size, source))),
    ]
}

fn errors(size: usize, source: impl Fn(Dir) -> Rgb<f32> + Sync) -> [[ErrorReport; 2]; 4] {
    let scenes = scenes().map(|scene| (scene.solid, scene.points(80, 80)));
    mirrors(size, &source).map(|(_, mirror)| {
        scenes.each_ref().map(|(solid, points)| {
            let traced = TracedMirror { source: &source, solid: *solid, bounces: 0 };
            compare_shadings(points, mirror.as_ref(), &traced)
        })
    })
}

#[test]
fn mirrors_agree_with_the_traced_reflection_to_second_order() {
    let sizes = [32, 64, 128];
    let all = sizes.map(|size| errors(size, smooth));
    for (k, (name, _)) in mirrors(16, &smooth).iter().enumerate() {
        for (solid, shape) in ["ball", "torus"].into_iter().enumerate() {
            let of = |i: usize| all[i][k][solid].relative_rmse;
            let orders = [(of(0) / of(1)).log2(), (of(1) / of(2)).log2()];
            println!("{name:13} {shape:6} {:.2e} {:.2e} {:.2e}  orders {orders:.2?}", of(0), of(1), of(2));
        }
    }
    for (k, (name, _)) in mirrors(16, &smooth).iter().enumerate() {
        for (solid, shape) in ["ball", "torus"].into_iter().enumerate() {
            let of = |i: usize| all[i][k][solid].relative_rmse;
            let order = (of(0) / of(2)).log2() / 2.0;
            // Around the direction behind its ball a sphere map is of first order; this torus shows it.
            let least = if *name == "sphere map" { 1.0 } else { 1.85 };
            assert!(order > least, "{name} on the {shape}: {:.2e} to {:.2e}, order {order:.2}", of(0), of(2));
            assert!(of(2) < 5e-3, "{name} on the {shape} with size 128: {:.2e}", of(2));
        }
    }
}

#[test]
fn mirrors_of_a_photograph_are_within_the_resampling_error() {
    let map = bundled::sunset().map();
    for size in [128, 256] {
        for ((name, mirror), reports) in
            mirrors(size, &|s| map.radiance(s)).iter().zip(errors(size, |s| map.radiance(s)))
        {
            // The resampling error of a technique: that of the light towards directions spread evenly.
            let even: Vec<SurfacePoint> =
                even_directions(20_000).map(|s| SurfacePoint { position: [0.0; 3], normal: s, view: s }).collect();
            let resampling = compare_shadings(&even, mirror.as_ref(), &|p: &SurfacePoint| map.radiance(p.normal));
            println!(
                "{name:13} size {size}: RMSE of the map {:.4}, ball {:.4}, torus {:.4}; peak {:.0}",
                resampling.rmse,
                reports[0].rmse,
                reports[1].rmse,
                map.texels().iter().fold(0.0_f32, |m, t| m.max(t.r))
            );
            for report in reports {
                // A map of the same texels has none.
                let within = report.rmse <= 3.0 * resampling.rmse + 1e-7;
                assert!(within, "{name}, size {size}: {} beside {}", report.rmse, resampling.rmse);
            }
        }
    }
}

/// Directions of a Fibonacci lattice.
fn even_directions(count: usize) -> impl Iterator<Item = Dir> {
    let golden = PI * (3.0 - 5.0_f64.sqrt());
    (0..count).map(move |i| {
        let z = 1.0 - (2 * i + 1) as f64 / count as f64;
        Dir::from_angles(z.acos(), golden * i as f64)
    })
}

#[test]
fn matte_techniques_agree_with_brute_force() {
    for bundled in bundled::all() {
        // The lamps of the studio are small and bright.
        let [most_by_map, most_by_sh] = match bundled.name {
            "sunset" => [0.003, 0.02],
            _ => [0.02, 0.12],
        };
        let map = bundled.map();
        let white = Rgb::splat(1.0);
        let points: Vec<SurfacePoint> = scenes().iter().flat_map(|scene| scene.points(30, 30)).collect();
        let normals: Vec<Dir> = points.iter().map(|p| p.normal).collect();
        let narrow = |e: Rgb<f64>| Rgb::<f32>::narrow(e.scale(1.0 / PI)).to_array();
        let truth: Vec<[f32; 3]> = irradiance_at(&map, &normals).into_iter().map(narrow).collect();
        let error = |shading: &dyn Shading| {
            let values: Vec<[f32; 3]> = points.iter().map(|p| shading.radiance(p).to_array()).collect();
            compare(&values, &truth).relative_rmse
        };
        let by_map = |width: usize| {
            let irradiance: EnvMap =
                irradiance_map_brute_force(&map, width, width / 2, lobe_io::Job::default()).unwrap();
            error(&MatteByMap { irradiance, albedo: white })
        };
        let polynomial = IrradiancePolynomial::from_radiance_sh(&project_env(&map, 3));
        let by_sh = error(&MatteBySh { irradiance: polynomial, albedo: white });
        let (coarse, fine) = (by_map(16), by_map(32));
        println!(
            "{}: relative RMSE: map 16 x 8 {coarse:.4}, map 32 x 16 {fine:.4}, nine coefficients {by_sh:.4}",
            bundled.name
        );
        assert!(fine < most_by_map && fine < 0.35 * coarse, "{}: irradiance maps: {coarse} and {fine}", bundled.name);
        assert!(by_sh < most_by_sh, "{}: nine coefficients: {by_sh}", bundled.name);
    }
}
