//! Transfer at vertices that is fitted to the surfaces between them.

use lobe_io::Job;
use lobe_prt::{
    AlbedoMode, BakeMode, BakeOptions, FittedVertices, Receivers, Transfer, bake, bake_matrices, bake_vertices,
};
use lobe_scene::{Bvh, Mesh, MeshParts, Scene, built_in};

fn fitted(scene: &Scene, options: &BakeOptions) -> Transfer {
    bake_vertices(scene, &Bvh::new(scene), options, Job::default()).unwrap().0
}

fn options(mode: BakeMode) -> BakeOptions {
    BakeOptions::default().mode(mode).order(3).samples(256)
}

/// A closed box with normals of its faces, two triangles each.
fn block(min: [f32; 3], max: [f32; 3]) -> Mesh {
    let mut parts = MeshParts::default();
    for axis in 0..3 {
        for (side, end) in [(-1.0, min[axis]), (1.0, max[axis])] {
            let (u, v) = if side > 0.0 { ((axis + 1) % 3, (axis + 2) % 3) } else { ((axis + 2) % 3, (axis + 1) % 3) };
            let first = parts.positions.len() as u32;
            for (a, b) in [(min[u], min[v]), (max[u], min[v]), (max[u], max[v]), (min[u], max[v])] {
                let mut corner = [0.0; 3];
                (corner[axis], corner[u], corner[v]) = (end, a, b);
                let mut normal = [0.0; 3];
                normal[axis] = side;
                parts.positions.push(corner);
                parts.normals.push(normal);
            }
            parts.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|t| t.map(|i| first + i)));
        }
    }
    Mesh::new(parts).unwrap()
}

fn of_meshes(meshes: Vec<Mesh>) -> Scene {
    Scene::new(meshes, vec![], vec![]).unwrap()
}

#[test]
fn without_shadows_it_is_the_closed_form_where_normals_do_not_bend() {
    let scene = of_meshes(vec![block([0.0; 3], [1.0, 2.0, 3.0])]);
    let options = options(BakeMode::Unshadowed);
    let receivers = Receivers::at_vertices(&scene).unwrap();
    let (expected, _) = bake(&scene, &Bvh::new(&scene), &receivers, &options, Job::default()).unwrap();
    for (found, expected) in fitted(&scene, &options).coefficients().iter().zip(expected.coefficients()) {
        // The solver ends at 1e-8, and moments are rounded to f32.
        assert!((found - expected).abs() < 1e-5, "{found}, expected {expected}");
    }
}

#[test]
fn what_stands_alone_has_the_closed_form_however_few_paths() {
    let scene = of_meshes(vec![block([0.0; 3], [1.0, 2.0, 3.0])]);
    let expected = fitted(&scene, &options(BakeMode::Unshadowed));
    for mode in [BakeMode::Shadowed, BakeMode::Interreflected] {
        let found = fitted(&scene, &options(mode).samples(16));
        for (found, expected) in found.coefficients().iter().zip(expected.coefficients()) {
            // Sums in f32 of directions and of the closed form are off by 1e-6 each.
            assert!((found - expected).abs() < 1e-5, "{mode:?}: {found}, expected {expected}");
        }
    }
}

/// A long bar whose lower end is in a block, and the vertices of its sides there. Its sides are two triangles each.
fn bar_in_a_block() -> (Scene, Receivers, Vec<usize>) {
    let bar = block([-0.1, -0.1, -0.5], [0.1, 0.1, 8.0]);
    let scene = of_meshes(vec![bar, block([-1.0, -1.0, -1.0], [1.0, 1.0, 0.5])]);
    let receivers = Receivers::at_vertices(&scene).unwrap();
    let is_buried = |&v: &usize| receivers.normals()[v][2] == 0.0 && receivers.positions()[v][2] < 0.0;
    let buried: Vec<usize> = (0..24).filter(is_buried).collect();
    assert_eq!(buried.len(), 8, "two ends of each side");
    (scene, receivers, buried)
}

#[test]
fn a_vertex_inside_of_another_body_has_the_transfer_of_what_is_seen_of_its_triangles() {
    let (scene, receivers, buried) = bar_in_a_block();
    let options = options(BakeMode::Shadowed).albedo(AlbedoMode::None);
    let (sampled, _) = bake(&scene, &Bvh::new(&scene), &receivers, &options, Job::default()).unwrap();
    let fitted = fitted(&scene, &options);
    for v in buried {
        assert_eq!(sampled.vector(v, 0)[0], 0.0, "nothing is seen from there");
        // Half of the sky is seen from the sides, whose constant coefficient is 1/√4π; less of it near the block.
        let found = f64::from(fitted.vector(v, 0)[0]) * (4.0 * std::f64::consts::PI).sqrt();
        assert!((0.6..1.1).contains(&found), "vertex {v}: {found} of the light");
    }
}

#[test]
fn what_is_inside_of_the_other_body_changes_nothing() {
    let (bar, body) = (block([-0.1, -0.1, -0.5], [0.1, 0.1, 2.0]), block([-1.0, -1.0, -1.0], [1.0, 1.0, 0.5]));
    // Its top is a front, which buried sides of the bar see.
    let plate = block([-0.9, -0.9, -0.9], [0.9, 0.9, -0.7]);
    let options = options(BakeMode::Shadowed).albedo(AlbedoMode::None);
    let alone = fitted(&of_meshes(vec![bar.clone(), body.clone()]), &options);
    let with_plate = fitted(&of_meshes(vec![bar, body, plate]), &options);
    let of_bar = 0..24 * alone.vector(0, 0).len();
    let pairs = alone.coefficients()[of_bar.clone()].iter().zip(&with_plate.coefficients()[of_bar]);
    for (k, (expected, found)) in pairs.enumerate() {
        // The solver ends at 1e-8, and moments are rounded to f32.
        assert!((found - expected).abs() < 1e-5, "number {k}: {found}, expected {expected}");
    }
}

#[test]
fn a_vertex_inside_of_another_body_has_the_matrix_of_what_is_seen_of_its_triangles() {
    let (scene, receivers, buried) = bar_in_a_block();
    let (bvh, options) = (Bvh::new(&scene), options(BakeMode::Shadowed));
    let (sampled, _) = bake_matrices(&scene, &bvh, &receivers, &options, Job::default()).unwrap();
    let vertices = FittedVertices::all(&scene).unwrap();
    let (fitted, report) = vertices.bake_matrices(&bvh, &options, Job::default()).unwrap();
    assert_eq!((fitted.points(), report.receivers), (scene.vertex_count(), scene.triangle_count()), "matrices");
    for v in buried {
        assert_eq!(sampled.matrix(v, 0)[0], 0.0, "nothing is seen from there");
        // M_00 is the solid angle that is seen over 4π: half for the sides, less near the block.
        let found = 2.0 * fitted.matrix(v, 0)[0];
        assert!((0.6..1.1).contains(&found), "vertex {v}: {found} of the hemisphere");
    }
}

#[test]
fn matrices_of_a_body_alone_are_those_of_its_vertices() {
    let scene = of_meshes(vec![block([0.0; 3], [1.0, 2.0, 3.0])]);
    let (bvh, options) = (Bvh::new(&scene), options(BakeMode::Shadowed).samples(4096));
    let receivers = Receivers::at_vertices(&scene).unwrap();
    let (expected, _) = bake_matrices(&scene, &bvh, &receivers, &options, Job::default()).unwrap();
    let (found, _) = FittedVertices::all(&scene).unwrap().bake_matrices(&bvh, &options, Job::default()).unwrap();
    let off = found.coefficients().iter().zip(expected.coefficients()).map(|(a, b)| (a - b).abs());
    let worst = off.fold(0.0, f32::max);
    // Directions of 4096 paths, which are other ones in each, are off by about .01.
    assert!(worst < 0.02, "off by {worst}");
}

#[test]
fn the_backs_of_a_sheet_are_the_fronts_of_the_sheet_turned_over() {
    let sheet = |side: f32| {
        let positions: Vec<[f32; 3]> = (0..9).map(|k| [(k % 3) as f32, (k / 3) as f32, 0.2 * (k % 2) as f32]).collect();
        let normals = positions.iter().map(|[x, y, _]| [0.6 * side * (x - 1.0), 0.6 * side * (y - 1.0), side]);
        let unit = |n: [f32; 3]| n.map(|c| c / n.iter().map(|c| c * c).sum::<f32>().sqrt());
        let cells = [0, 1, 3, 4].into_iter().flat_map(|k| [[k, k + 1, k + 4], [k, k + 4, k + 3]]);
        // Corners keep their order, and points their places.
        let (normals, triangles) = (normals.map(unit).collect(), cells.collect());
        Mesh::new(MeshParts { positions, normals, triangles, ..MeshParts::default() }).unwrap()
    };
    let [scene, turned] =
        [1.0, -1.0].map(|side| of_meshes(vec![sheet(side), block([0.2, 0.4, -1.0], [0.9, 1.5, -0.3])]));
    let options = options(BakeMode::Shadowed);
    let sheet: Vec<usize> = (0..9).collect();
    let backs = FittedVertices::backs(&scene, &sheet).unwrap();
    let fronts = FittedVertices::some(&turned, &sheet).unwrap();
    let bake = |vertices: &FittedVertices<'_>, scene: &Scene| {
        vertices.bake(&Bvh::new(scene), &options, Job::default()).unwrap().0
    };
    let (found, expected) = (bake(&backs, &scene), bake(&fronts, &turned));
    for (found, expected) in found.coefficients().iter().zip(expected.coefficients()) {
        assert!((found - expected).abs() < 1e-5, "{found}, expected {expected}");
    }
    let fronts = bake(&FittedVertices::some(&scene, &sheet).unwrap(), &scene);
    assert!((found.vector(4, 0)[2] - fronts.vector(4, 0)[2]).abs() > 0.1, "fronts look the other way");
}

#[test]
fn some_vertices_have_the_values_of_a_fit_of_all() {
    let scene = built_in::ball_over_ground(24);
    let options = options(BakeMode::Shadowed);
    let all = fitted(&scene, &options);
    let ground = scene.meshes()[0].positions().len();
    let some: Vec<usize> = (ground + 100..ground + 160).rev().collect();
    let vertices = FittedVertices::some(&scene, &some).unwrap();
    let (found, _) = vertices.bake(&Bvh::new(&scene), &options, Job::default()).unwrap();
    for (k, &v) in some.iter().enumerate() {
        for (found, expected) in found.vector(k, 0).iter().zip(all.vector(v, 0)) {
            // A seventh of the noise of 256 paths, some .005 for these albedos.
            assert!((found - expected).abs() < 2e-3, "vertex {v}: {found}, expected {expected}");
        }
    }
}

#[test]
fn meshes_that_touch_have_one_value_where_they_do() {
    let half = |from: f32| {
        let parts = MeshParts {
            positions: [[from, 0.0], [from + 1.0, 0.0], [from + 1.0, 1.0], [from, 1.0]]
                .map(|[x, y]| [x, y, 0.0])
                .to_vec(),
            normals: vec![[0.0, 0.0, 1.0]; 4],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..MeshParts::default()
        };
        Mesh::new(parts).unwrap()
    };
    let scene = of_meshes(vec![half(0.0), half(1.0), block([0.7, 0.2, 0.3], [1.2, 0.9, 0.6])]);
    let fitted = fitted(&scene, &options(BakeMode::Shadowed));
    for (a, b) in [(1, 4), (2, 7)] {
        assert_eq!(fitted.vector(a, 0), fitted.vector(b, 0), "vertices {a} and {b}");
    }
    assert_ne!(fitted.vector(0, 0), fitted.vector(5, 0), "others have their own");
}

#[test]
fn the_mean_over_surfaces_is_that_of_the_surfaces_and_not_of_the_vertices() {
    // One sharp shadow on a floor of two triangles, whose corners see nothing of it.
    let floor = block([-2.0, -2.0, -0.5], [2.0, 2.0, 0.0]);
    let scene = of_meshes(vec![floor, block([-1.0, -1.0, 0.1], [1.0, 1.0, 0.3])]);
    let options = options(BakeMode::Shadowed).albedo(AlbedoMode::None).samples(4096);
    let fitted = fitted(&scene, &options);
    let receivers = Receivers::at_vertices(&scene).unwrap();
    // The four corners of the top of the floor; two of them belong to both triangles.
    let top: Vec<usize> = (0..24).filter(|&v| receivers.normals()[v][2] == 1.0).collect();
    let of = |v: usize| f64::from(fitted.vector(v, 0)[0]);
    let corners = scene.meshes()[0].triangles().iter().flatten().filter(|&&v| top.contains(&(v as usize)));
    let mean = corners.map(|&v| of(v as usize)).sum::<f64>() / 6.0;
    // Points all over the floor, by themselves.
    let count = 40;
    let at = |k: usize| -2.0 + 4.0 * (k as f32 + 0.5) / count as f32;
    let positions: Vec<_> = (0..count * count).map(|k| [at(k % count), at(k / count), 0.0]).collect();
    let normals = vec![[0.0, 0.0, 1.0]; positions.len()];
    let points = Receivers::new(positions, normals, vec![[1.0; 3]; count * count]).unwrap();
    let options = options.samples(256);
    let (expected, _) = bake(&scene, &Bvh::new(&scene), &points, &options, Job::default()).unwrap();
    let expected = (0..points.len()).map(|k| f64::from(expected.vector(k, 0)[0])).sum::<f64>() / points.len() as f64;
    // Both means have a noise of some thousandths.
    assert!((mean / expected - 1.0).abs() < 0.01, "mean {mean}, {expected} over the floor");
}

#[test]
fn a_closed_room_is_black_and_what_has_no_area_is_zero() {
    let closed = built_in::closed_white_box(2);
    let options = options(BakeMode::Interreflected);
    assert!(fitted(&closed, &options).coefficients().iter().all(|&t| t == 0.0), "no light enters");
    let parts = MeshParts {
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [5.0, 5.0, 5.0]],
        normals: vec![[0.0, 0.0, 1.0]; 4],
        triangles: vec![[0, 1, 2]],
        ..MeshParts::default()
    };
    let lone = of_meshes(vec![Mesh::new(parts).unwrap()]);
    let fitted = fitted(&lone, &options);
    assert!(fitted.vector(3, 0).iter().all(|&t| t == 0.0), "a vertex of no triangle");
    assert!(fitted.vector(0, 0)[0] > 0.1, "the others see the sky");
}

#[test]
fn rays_are_as_many_as_from_vertices() {
    let scene = built_in::ball_over_ground(24);
    let options = options(BakeMode::Shadowed);
    let (_, report) = bake_vertices(&scene, &Bvh::new(&scene), &options, Job::default()).unwrap();
    let ratio = report.rays as f64 / (scene.vertex_count() * 256) as f64;
    // Whole numbers of points in each triangle, four at least.
    assert!((0.9..1.2).contains(&ratio), "{ratio} of the rays");
}
