//! Glossy transfer against theory by an independent route, and how far its lobe is from that of microfacets.
//!
//! The radiance of matrices of order n towards an eye is, but for the noise of the bake,
//!
//! ```text
//!   B(v) = ∫_Ω L_in(s) k_n(r·s) ds        k_n(t) = Σ_{l<n} (2l+1)/4π α_l P_l(t)        r = 2 (n·v) n - v
//! ```
//!
//! with Ω the hemisphere above the receiver and `L_in` the light that arrives there: rows of the matrix above order n
//! are not missed, since the kernel has no such bands. Without occluders the integral is one of polynomials and done
//! exactly; with them the path tracer finds `L_in` along directions of its own. The light is the order-n expansion of a
//! photographed sky.

use std::f64::consts::PI;

use lobe_env::{DfgTable, bundled, project_env};
use lobe_image::{Measured, ZTest};
use lobe_io::Job;
use lobe_prt::{BakeMode, BakeOptions, Channels, Receivers, TransferMatrices, bake_matrices};
use lobe_render::{
    Camera, DistantLight, PathOptions, PathReceiver, PathTracer, SampleCount, Surfaces, TruthOptions, render_truth,
};
use lobe_scene::{Bvh, Material, Scene, built_in};
use lobe_sh::sphere::{SphereQuadrature, gauss_legendre};
use lobe_sh::{Coefficient as _, Dir, Expansion as _, Rgb, ShVec, Zonal};
use rayon::prelude::*;

/// The order of the matrices, which hold those of lower orders.
const HIGHEST: usize = 6;
const ORDERS: [usize; 2] = [4, HIGHEST];

/// Receivers that are compared, on the ground and on the ball.
const VERTICES: usize = 16;

/// Independent sets of paths from each, and paths in each.
const SETS: usize = 16;
const PER_SET: usize = 512;

/// The significance level over all that a test compares: the probability that agreement is called bias.
const SIGNIFICANCE: f64 = 0.01;

/// A part of the light that must not be wrong unseen: an error so large in all receivers fails the test.
const FOUND: f64 = 0.02;

/// Directions to the eye: angle from the normal and about it.
const VIEWS: [[f64; 2]; 4] = [[0.0, 0.0], [0.5, 0.4], [0.9, 2.5], [1.3, 4.4]];

fn lobes(order: usize) -> [(&'static str, Zonal); 3] {
    [("GGX 0.3", Zonal::ggx(order, 0.3)), ("GGX 0.7", Zonal::ggx(order, 0.7)), ("Phong 12", Zonal::phong(order, 12.0))]
}

fn sky(order: usize) -> ShVec<Rgb<f64>> {
    project_env(&bundled::sunset().map(), order)
}

/// A ball over a ground, and receivers spread over both.
fn ball() -> (Scene, Receivers) {
    let scene = built_in::ball_over_ground(16);
    let all = Receivers::at_vertices(&scene).unwrap();
    let indices: Vec<usize> = (0..VERTICES).map(|k| (2 * k + 1) * all.len() / (2 * VERTICES)).collect();
    let receivers = all.subset(&indices).unwrap();
    (scene, receivers)
}

fn normal_of(receivers: &Receivers, v: usize) -> Dir {
    Dir::from_f32(receivers.normals()[v]).unwrap()
}

/// Two directions at right angles with `n` and with each other.
fn tangents(n: Dir) -> [Dir; 2] {
    let [x, y, z] = n.to_array();
    let u = Dir::new(if z.abs() < 0.9 { [-y, x, 0.0] } else { [0.0, -z, y] }).unwrap();
    let [a, b, c] = u.to_array();
    [u, Dir::new([y * c - z * b, z * a - x * c, x * b - y * a]).unwrap()]
}

/// The direction at angle `theta` from `n` and `phi` about it.
fn around(n: Dir, [theta, phi]: [f64; 2]) -> Dir {
    let [u, v] = tangents(n).map(Dir::to_array);
    let [x, y, z] = [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()];
    Dir::new(std::array::from_fn(|k| x * u[k] + y * v[k] + z * n.to_array()[k])).unwrap()
}

fn mirrored(n: Dir, v: Dir) -> Dir {
    let twice = 2.0 * n.dot(v);
    Dir::new(std::array::from_fn(|k| twice * n.to_array()[k] - v.to_array()[k])).unwrap()
}

fn matrices(scene: &Scene, receivers: &Receivers, mode: BakeMode, bounces: usize, seed: u64) -> TransferMatrices {
    let samples = PER_SET as u32;
    let options =
        BakeOptions::default().mode(mode).order(HIGHEST).samples(samples).bounces(bounces).energy_stop(0.0).seed(seed);
    bake_matrices(scene, &Bvh::new(scene), receivers, &options, Job::default()).unwrap().0
}

/// The exit radiance of each receiver, for each lobe and view of [`cases`].
type Sent = Vec<Vec<Rgb<f64>>>;

/// The lobes and views of an order, with names.
fn cases(order: usize) -> Vec<(String, Zonal, [f64; 2])> {
    let of = |(name, lobe): &(&str, Zonal)| VIEWS.map(|view| (format!("{name}, seen at {view:?}"), lobe.clone(), view));
    lobes(order).iter().flat_map(of).collect()
}

fn by_matrices(matrices: &TransferMatrices, receivers: &Receivers, order: usize) -> Sent {
    let light = sky(order);
    let sent = |(_, lobe, view): &(String, Zonal, [f64; 2])| {
        let of = |v: usize| {
            let n = normal_of(receivers, v);
            matrices.exit_radiance(v, light.coefficients(), lobe, n, around(n, *view))
        };
        (0..receivers.len()).map(of).collect()
    };
    cases(order).iter().map(sent).collect()
}

/// Means over sets and their variances.
fn mean_and_variance(sets: &[Sent], case: usize) -> (Vec<Rgb<f32>>, Vec<Rgb<f32>>) {
    let n = sets.len() as f64;
    let one = |v: usize| {
        let mean = sets.iter().fold(Rgb::<f64>::ZERO, |sum, set| sum + set[case][v].scale(n.recip()));
        let square = |set: &Sent| (set[case][v] - mean) * (set[case][v] - mean);
        let squares = sets.iter().fold(Rgb::<f64>::ZERO, |sum, set| sum + square(set));
        (Rgb::narrow(mean), Rgb::narrow(squares.scale((n * (n - 1.0)).recip())))
    };
    (0..sets[0][case].len()).map(one).unzip()
}

fn rms(values: impl IntoIterator<Item = Rgb<f64>>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for value in values {
        sum += value.to_array().iter().map(|c| c * c).sum::<f64>();
        count += 3.0;
    }
    f64::sqrt(sum / count)
}

/// Asserts that both differ by chance only, and that an error of [`FOUND`] would be detected. One set stands for an
/// exact value.
fn agree(what: &str, order: usize, claims: &[Sent], truths: &[Sent], tests: usize) {
    let level = 1.0 - (1.0 - SIGNIFICANCE).powf(1.0 / tests as f64);
    for (case, (name, _, _)) in cases(order).iter().enumerate() {
        let (a, va) = mean_and_variance(claims, case);
        let (b, vb, freedom) = match truths {
            [exact] => {
                let means: Vec<_> = exact[case].iter().map(|b| Rgb::narrow(*b)).collect();
                let zero = vec![Rgb::<f32>::ZERO; means.len()];
                (means, zero, f64::INFINITY)
            }
            sets => {
                let (means, variances) = mean_and_variance(sets, case);
                (means, variances, (sets.len() - 1) as f64)
            }
        };
        let measured = |means: &[Rgb<f32>]| {
            let a = Measured { means, variances: &va, degrees_of_freedom: (SETS - 1) as f64 };
            ZTest::new(&a, &Measured { means: &b, variances: &vb, degrees_of_freedom: freedom }).unwrap()
        };
        let test = measured(&a);
        let scale = rms(b.iter().map(|b| b.widen()));
        let error = rms(a.iter().zip(&b).map(|(a, b)| a.widen() - b.widen())) / scale;
        println!("{what}, order {order}, {name}: {:.2} % off, mean z {:.2?}", 100.0 * error, test.mean_z);
        assert!(test.passes(level), "{what}, order {order}, {name}: {error} of {scale}, {test:?}");
        let planted: Vec<_> = a.iter().map(|c| Rgb::narrow(c.widen().scale(1.0 + FOUND))).collect();
        let planted = measured(&planted);
        assert!(!planted.passes(level), "{what}, order {order}, {name}: {FOUND} too much is not seen, {planted:?}");
    }
}

#[test]
fn without_a_horizon_glossy_transfer_is_the_convolution_of_the_light_with_the_lobe() {
    // The matrix of a point in empty space is the identity.
    let rule = SphereQuadrature::of_degree(2 * HIGHEST - 2);
    for order in ORDERS {
        let bands = order * order;
        let identity = (0..bands * bands).map(|k| f32::from(u8::from(k % (bands + 1) == 0))).collect();
        let matrices = TransferMatrices::new(order, Channels::Gray, identity).unwrap();
        let light = sky(order);
        let n = Dir::new([0.3, -0.5, 0.8]).unwrap();
        for (name, lobe, view) in cases(order) {
            let v = around(n, view);
            let r = mirrored(n, v);
            let found = matrices.exit_radiance(0, light.coefficients(), &lobe, n, v).g;
            let expected = rule.integrate(|s| light.eval(s).g * lobe.eval(r.dot(s)));
            assert!((found - expected).abs() < 1e-12 * light[0].g, "order {order}, {name}: {found}, not {expected}");
        }
    }
}

/// `∫_Ω L(s) k_n(r·s) ds` over the hemisphere above `n`, exactly: the mean over azimuths leaves a polynomial in the
/// height above it, for Gauss' rule.
fn over_hemisphere(light: &ShVec<Rgb<f64>>, lobe: &Zonal, n: Dir, r: Dir) -> Rgb<f64> {
    let azimuths = 4 * HIGHEST;
    let mut sum = Rgb::<f64>::ZERO;
    for (x, weight) in gauss_legendre(2 * HIGHEST) {
        for k in 0..azimuths {
            let s = around(n, [f64::acos(0.5 + 0.5 * x), 2.0 * PI * k as f64 / azimuths as f64]);
            sum += light.eval(s).scale(0.5 * weight * 2.0 * PI / azimuths as f64 * lobe.eval(r.dot(s)));
        }
    }
    sum
}

#[test]
fn without_occluders_glossy_transfer_is_the_convolution_of_the_light_above_the_horizon() {
    let (scene, receivers) = ball();
    let baked: Vec<_> =
        (0..SETS as u64).map(|seed| matrices(&scene, &receivers, BakeMode::Unshadowed, 0, seed)).collect();
    for order in ORDERS {
        let claims: Vec<Sent> = baked.iter().map(|m| by_matrices(m, &receivers, order)).collect();
        let light = sky(order);
        let exact = |(_, lobe, view): &(String, Zonal, [f64; 2])| {
            let of = |v: usize| {
                let n = normal_of(&receivers, v);
                over_hemisphere(&light, lobe, n, mirrored(n, around(n, *view)))
            };
            (0..receivers.len()).map(of).collect()
        };
        let exact: Sent = cases(order).iter().map(exact).collect();
        agree("unshadowed", order, &claims, &[exact], ORDERS.len() * claims[0].len());
    }
}

/// `∫_Ω L_in(s) k_n(r·s) ds` set by set, with the light that paths of `bounces` bounces find.
fn by_arrivals(scene: &Scene, receivers: &Receivers, order: usize, bounces: usize) -> Vec<Sent> {
    let light = DistantLight::from_expansion(sky(order));
    let bvh = Bvh::new(scene);
    let tracer = PathTracer::new(scene, &bvh, &light, PathOptions::default().bounces(bounces));
    let cases = cases(order);
    let of_vertex = |v: usize| {
        let receiver = PathReceiver { albedo: Rgb::splat(1.0), ..PathReceiver::of(receivers, v) };
        let n = normal_of(receivers, v);
        let reflected: Vec<Dir> = cases.iter().map(|(_, _, view)| mirrored(n, around(n, *view))).collect();
        let mut sums = vec![vec![Rgb::<f64>::ZERO; cases.len()]; SETS];
        let count = SampleCount { sets: SETS, per_set: PER_SET };
        tracer.for_each_arrival(&receiver, v, &count, |set, s, radiance| {
            for (k, (_, lobe, _)) in cases.iter().enumerate() {
                sums[set][k] += radiance.scale(2.0 * PI / PER_SET as f64 * lobe.eval(reflected[k].dot(s)));
            }
        });
        sums
    };
    let by_vertex: Vec<_> = (0..receivers.len()).into_par_iter().map(of_vertex).collect();
    let of_case = |set: usize, case: usize| by_vertex.iter().map(|sums| sums[set][case]).collect();
    (0..SETS).map(|set| (0..cases.len()).map(|case| of_case(set, case)).collect()).collect()
}

#[test]
fn with_occluders_glossy_transfer_is_the_kernel_over_the_light_that_paths_find() {
    let (scene, receivers) = ball();
    for (mode, bounces) in [(BakeMode::Shadowed, 0), (BakeMode::Interreflected, 2)] {
        let seeds = 0..SETS as u64;
        let baked: Vec<_> = seeds.map(|seed| matrices(&scene, &receivers, mode, bounces, seed)).collect();
        for order in ORDERS {
            let claims: Vec<Sent> = baked.iter().map(|m| by_matrices(m, &receivers, order)).collect();
            let truths = by_arrivals(&scene, &receivers, order, bounces);
            agree(&format!("{mode:?}"), order, &claims, &truths, 2 * ORDERS.len() * claims[0].len());
        }
    }
}

/// The ball as a white metal of GGX microfacets.
fn metal(alpha: f64) -> Scene {
    let (meshes, mut materials, textures) = built_in::ball_over_ground(16).into_parts();
    let roughness = alpha.sqrt() as f32;
    let metal = Material { base_color: [1.0; 4], metallic: 1.0, roughness, ..Material::matte("metal", [1.0; 3]) };
    materials[1] = metal;
    Scene::new(meshes, materials, textures).unwrap()
}

/// Directions to the eye within 40° of the normal, and 54° to 69° from it.
const STEEP: [[f64; 2]; 3] = [[0.0, 0.0], [0.5, 1.0], [0.7, 3.0]];
const SLANTED: [[f64; 2]; 3] = [[0.95, 0.0], [1.1, 2.0], [1.2, 4.0]];

/// The relative RMS error of matrices of an order at the vertices of the ball against the path tracer, under two skies:
/// with the lobe alone, and scaled by the directional albedo of the microfacets.
fn off_from_microfacets(alpha: f64, order: usize, views: [[f64; 2]; 3]) -> [f64; 2] {
    let scene = metal(alpha);
    let bvh = Bvh::new(&scene);
    let all = Receivers::at_vertices(&scene).unwrap();
    let ground = scene.meshes()[0].positions().len();
    let indices: Vec<usize> =
        (0..VERTICES).map(|k| ground + (2 * k + 1) * (all.len() - ground) / (2 * VERTICES)).collect();
    let receivers = all.subset(&indices).unwrap();
    let matrices = matrices(&scene, &receivers, BakeMode::Shadowed, 0, 0);
    let lobe = Zonal::ggx(order, alpha);
    let paths = PathOptions::default().bounces(0).surfaces(Surfaces::MetallicRoughness);
    let options = TruthOptions::default().width(1).height(1).count(SampleCount::of(256)).paths(paths);
    let table = DfgTable::new(32);
    let (mut differences, mut truths) = ([Vec::new(), Vec::new()], Vec::new());
    for sky in [bundled::sunset(), bundled::studio()] {
        let expansion = project_env(&sky.map(), order);
        let light = DistantLight::from_expansion(expansion.clone());
        for v in 0..receivers.len() {
            let (n, place) = (normal_of(&receivers, v), receivers.positions()[v].map(f64::from));
            for view in views {
                let to_eye = around(n, view);
                let eye = std::array::from_fn(|k| place[k] + 0.1 * to_eye.to_array()[k]);
                // A pixel of a thousandth of the ball, its middle at the vertex.
                let camera = Camera::look_at(eye, place, 0.01).unwrap();
                let truth = render_truth(&scene, &bvh, &camera, &light, &options, Job::default()).unwrap();
                let truth = Rgb::from(truth.mean.pixels()[0]).widen();
                let sent = matrices.exit_radiance(v, expansion.coefficients(), &lobe, n, to_eye);
                let reflectance = table.lookup(n.dot(to_eye), alpha.sqrt()).reflectance(Rgb::splat(1.0));
                differences[0].push(sent - truth);
                differences[1].push(sent * reflectance - truth);
                truths.push(truth);
            }
        }
    }
    let scale = rms(truths);
    differences.map(|all| rms(all) / scale)
}

#[test]
#[ignore = "long: of the nightly group"]
fn how_far_the_kernel_is_from_microfacets_is_what_the_documentation_says() {
    // The table in the documentation of TransferMatrices, in percent: seen steeply and at a slant, each without and
    // with the reflectance.
    for (alpha, order, documented) in [
        (0.1, 4, [[20.7, 20.6], [17.4, 19.6]]),
        (0.2, 4, [[20.9, 17.5], [12.6, 15.3]]),
        (0.3, 4, [[30.2, 18.0], [23.5, 17.2]]),
        (0.3, 6, [[32.5, 18.8], [29.0, 19.7]]),
        (0.5, 4, [[63.0, 25.6], [60.9, 34.8]]),
        (0.7, 4, [[108.0, 33.0], [101.6, 55.2]]),
        (1.0, 4, [[201.9, 42.5], [153.5, 75.3]]),
    ] {
        let found = [STEEP, SLANTED].map(|views| off_from_microfacets(alpha, order, views).map(|x| 100.0 * x));
        println!("GGX {alpha}, order {order}: {found:.1?} % off from microfacets");
        for (found, documented) in found.into_iter().flatten().zip(documented.into_iter().flatten()) {
            let is_as_documented = (found - documented).abs() < 1.0 + 0.03 * documented;
            assert!(is_as_documented, "GGX {alpha}, order {order}: {found} %, documented {documented} %");
        }
    }
}
