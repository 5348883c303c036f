//! Texture coordinates of a lightmap.

use std::collections::HashMap;
use std::ops::ControlFlow;

use lobe_io::Job;
use lobe_scene::{Mesh, MeshParts, Scene, SceneError, UnwrapOptions, UnwrapReport, built_in};

fn unwrapped(scene: &Scene, options: &UnwrapOptions) -> (Scene, UnwrapReport) {
    scene.unwrapped(options, Job::default()).unwrap()
}

fn of(parts: impl IntoIterator<Item = MeshParts>) -> Scene {
    Scene::new(parts.into_iter().map(|p| Mesh::new(p).unwrap()).collect(), vec![], vec![]).unwrap()
}

/// A triangle of some size, with some coordinates.
fn triangle(size: f32, sets: usize) -> MeshParts {
    let positions = vec![[0.0, 0.0, 0.0], [size, 0.0, 0.0], [0.0, size, size]];
    let mut parts = MeshParts { positions, triangles: vec![[0, 1, 2]], ..MeshParts::default() };
    (0..sets).for_each(|set| parts.uvs[set] = vec![[set as f32, 0.5]; 3]);
    parts
}

/// The most triangles around a center of a texel, that are more than a hundredth of a texel inside.
fn most_at_a_center(scene: &Scene, width: usize) -> usize {
    const INSIDE: f64 = 0.01;
    let mut counts: HashMap<(usize, usize), usize> = HashMap::new();
    for mesh in scene.meshes() {
        for t in mesh.triangles() {
            let [a, b, c] = t.map(|i| mesh.lightmap_uvs()[i as usize].map(|x| f64::from(x) * width as f64));
            let cross =
                |p: [f64; 2], q: [f64; 2], r: [f64; 2]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
            let sign = cross(a, b, c).signum();
            let range = |k: usize| {
                let all = [a[k], b[k], c[k]];
                let (min, max) = (all.iter().fold(f64::MAX, |m, x| m.min(*x)), all.iter().fold(0.0, |m, x| x.max(m)));
                min.floor().max(0.0) as usize..(max.ceil() as usize).min(width)
            };
            for (x, y) in range(1).flat_map(|y| range(0).map(move |x| (x, y))) {
                let center = [x as f64 + 0.5, y as f64 + 0.5];
                let depth = |p: [f64; 2], q: [f64; 2]| {
                    sign * cross(p, q, center) / (q[0] - p[0]).hypot(q[1] - p[1]).max(1e-300)
                };
                if [(a, b), (b, c), (c, a)].into_iter().all(|(p, q)| depth(p, q) > INSIDE) {
                    *counts.entry((x, y)).or_insert(0) += 1;
                }
            }
        }
    }
    counts.into_values().max().unwrap_or(0)
}

#[test]
fn every_triangle_has_a_place_of_its_own_and_its_vertices_keep_what_they_had() {
    for (name, scene) in [
        ("ball", built_in::ball_over_ground(24)),
        ("furnace", built_in::named("furnace").unwrap()),
        ("still life", built_in::named("still-life").unwrap()),
    ] {
        let options = UnwrapOptions::default().texels(256);
        let (found, report) = unwrapped(&scene, &options);
        assert_eq!(most_at_a_center(&found, 256), 1, "{name}: triangles at one center");
        assert!(report.coverage > 0.2 && report.charts >= 2, "{name}: {report:?}");
        assert_eq!((report.vertices_before, report.vertices), (scene.vertex_count(), found.vertex_count()), "{name}");
        for (before, after) in scene.meshes().iter().zip(found.meshes()) {
            assert_eq!(before.material(), after.material(), "{name}");
            for (old, new) in before.triangles().iter().zip(after.triangles()) {
                for (&i, &j) in old.iter().zip(new) {
                    let (i, j) = (i as usize, j as usize);
                    assert_eq!(before.positions()[i], after.positions()[j], "{name}: a position");
                    assert_eq!(before.normals()[i], after.normals()[j], "{name}: a normal");
                    if !before.uvs(0).is_empty() {
                        assert_eq!(before.uvs(0)[i], after.uvs(0)[j], "{name}: coordinates of set 0");
                    }
                    let uv = after.lightmap_uvs()[j];
                    assert!(uv.iter().all(|c| (0.0..=1.0).contains(c)), "{name}: {uv:?}");
                }
            }
        }
    }
}

#[test]
fn coordinates_are_the_first_set_that_a_mesh_does_not_have() {
    for sets in 0..3 {
        let scene = of([triangle(1.0, sets)]);
        let (found, _) = unwrapped(&scene, &UnwrapOptions::default().texels(16));
        let mesh = &found.meshes()[0];
        for set in 0..sets {
            assert_eq!(mesh.uvs(set), scene.meshes()[0].uvs(set), "set {set} of {sets}");
        }
        let new = if sets < 2 { mesh.uvs(sets) } else { mesh.third_uvs() };
        assert_eq!(mesh.lightmap_uvs(), new, "of {sets} sets");
        let sides = |k: usize| new.iter().map(|uv| uv[k]).fold(0.0, f32::max) - new[0][k].min(new[1][k]).min(new[2][k]);
        assert!(sides(0) * sides(1) > 0.1, "of {sets} sets: {new:?}");
    }
}

#[test]
fn scale_and_threads_change_nothing() {
    let uvs = |scene: &Scene| {
        let (found, report) = unwrapped(scene, &UnwrapOptions::default().texels(128));
        (found.meshes().iter().map(|mesh| mesh.lightmap_uvs().to_vec()).collect::<Vec<_>>(), report)
    };
    let scene = built_in::ball_over_ground(12);
    let (expected, report) = uvs(&scene);
    for power in [-80, -20, 20, 30] {
        let scale = f32::powi(2.0, power);
        let scaled = |mesh: &Mesh| {
            let mut parts = mesh.clone().into_parts();
            parts.positions.iter_mut().for_each(|p| *p = p.map(|c| c * scale));
            parts
        };
        let (found, scaled) = uvs(&of(scene.meshes().iter().map(scaled).map(|p| MeshParts { material: None, ..p })));
        assert!(found == expected, "2^{power}: other coordinates");
        let part = scaled.texel_size / report.texel_size / f64::from(scale);
        assert!((part - 1.0).abs() < 1e-12, "2^{power}: texels of {part} of the size");
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert!(pool.install(|| uvs(&scene)).0 == expected, "one thread");
}

#[test]
fn what_has_hardly_an_area_is_unwrapped_with_the_rest() {
    let sliver = |height: f32| MeshParts {
        positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, height, 0.0]],
        triangles: vec![[0, 1, 2]],
        ..MeshParts::default()
    };
    let options = UnwrapOptions::default().texels(64);
    for parts in [vec![sliver(1e-30)], vec![sliver(1e-7), triangle(1.0, 0)], vec![triangle(1e-12, 0)]] {
        let (found, report) = unwrapped(&of(parts.clone()), &options);
        assert_eq!(found.triangle_count(), parts.len(), "{report:?}");
        let all = found.meshes().iter().flat_map(Mesh::lightmap_uvs).flatten();
        assert!(all.clone().all(|c| (0.0..=1.0).contains(c)), "{parts:?}: {:?}", all.collect::<Vec<_>>());
    }
}

#[test]
fn texels_have_the_size_that_is_asked_for() {
    let scene = of([triangle(3.0, 0)]);
    let options = UnwrapOptions::default().texels(128).texel_size(Some(0.05));
    let (found, report) = unwrapped(&scene, &options);
    assert!((report.texel_size / 0.05 - 1.0).abs() < 1e-5, "{report:?}");
    let [a, b] = [0, 1].map(|i| found.meshes()[0].lightmap_uvs()[found.meshes()[0].triangles()[0][i] as usize]);
    let length = 128.0 * f64::from(b[0] - a[0]).hypot(f64::from(b[1] - a[1]));
    assert!((length / 60.0 - 1.0).abs() < 0.01, "an edge of 3 in texels of 0.05: {length}");
}

#[test]
fn what_does_not_fit_is_refused_in_one_line() {
    let scene = built_in::ball_over_ground(8);
    let refusal = |options: &UnwrapOptions| scene.unwrapped(options, Job::default()).unwrap_err().to_string();
    let options = UnwrapOptions::default().texels(64);
    let cases = [
        (refusal(&options.clone().texels(0)), "expected a width of 1 to 16384 texels, found 0"),
        (refusal(&options.clone().padding(300)), "expected a padding of 0 to 256 texels, found 300"),
        (refusal(&options.clone().chart_angle(90.0)), "expected a chart angle above 0 and below 90 degrees, found 90"),
        (refusal(&options.clone().texel_size(Some(-1.0))), "expected a texel size above 0, found -1"),
    ];
    for (found, expected) in cases {
        assert_eq!(found, expected, "refusal");
    }
    for options in [options.clone().texel_size(Some(1e-3)), options.clone().padding(40), options.texels(4)] {
        let found = refusal(&options);
        let (texels, padding) = (options.texels, options.padding);
        let expected =
            format!("with a padding of {padding} texels would not fit into {texels} x {texels}: more texels");
        assert!(found.contains(&expected) && !found.contains('\n'), "{options:?}: {found}");
    }
}

#[test]
fn unwrapping_stops_where_its_watch_says_so() {
    let mut watch = |_: &lobe_io::Progress| ControlFlow::Break(());
    let job = Job::default().watched_by(&mut watch);
    let result = built_in::ball_over_ground(64).unwrapped(&UnwrapOptions::default(), job);
    assert!(matches!(result, Err(SceneError::Cancelled)), "{:?}", result.map(|(_, report)| report));
}

#[test]
fn a_hundred_thousand_triangles_are_unwrapped() {
    let scene = built_in::ball_over_ground(190);
    assert!(scene.triangle_count() > 100_000, "{} triangles", scene.triangle_count());
    let (found, report) = unwrapped(&scene, &UnwrapOptions::default());
    assert_eq!(most_at_a_center(&found, 1024), 1, "{report:?}");
}
