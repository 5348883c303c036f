//! Edge splitting: edges short enough, no cracks, the same surface.

use std::collections::HashMap;

use lobe_scene::{Mesh, MeshParts, Scene, SceneError, built_in};

type Edge = ([u32; 3], [u32; 3]);

fn bits(p: [f32; 3]) -> [u32; 3] {
    // -0 and 0 are one place.
    p.map(|c| (c + 0.0).to_bits())
}

/// For each edge, by the positions of its ends, its uses in one direction minus those in the other, in all meshes.
fn edges(scene: &Scene) -> HashMap<Edge, i32> {
    let mut edges = HashMap::new();
    for corners in scene.corners() {
        for k in 0..3 {
            let (a, b) = (bits(corners[k]), bits(corners[(k + 1) % 3]));
            let (edge, way) = if a < b { ((a, b), 1) } else { ((b, a), -1) };
            *edges.entry(edge).or_insert(0) += way;
        }
    }
    edges
}

/// Edges without a triangle on their other side: none of a closed surface.
fn open_edges(scene: &Scene) -> usize {
    edges(scene).values().filter(|&&count| count != 0).count()
}

fn longest_edge(scene: &Scene) -> f64 {
    let length = |p: [f32; 3], q: [f32; 3]| (0..3).map(|k| (f64::from(p[k]) - f64::from(q[k])).powi(2)).sum::<f64>();
    scene.corners().flat_map(|c| (0..3).map(move |k| length(c[k], c[(k + 1) % 3]))).fold(0.0, f64::max).sqrt()
}

fn area(scene: &Scene) -> f64 {
    let wide = |p: [f32; 3]| p.map(f64::from);
    scene
        .corners()
        .map(|c| {
            let [a, b, c] = c.map(wide);
            let (e, f): ([f64; 3], [f64; 3]) =
                (std::array::from_fn(|k| b[k] - a[k]), std::array::from_fn(|k| c[k] - a[k]));
            let n = [e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]];
            0.5 * n.iter().map(|c| c * c).sum::<f64>().sqrt()
        })
        .sum()
}

#[test]
fn split_edges_are_short_and_closed_surfaces_stay_closed_with_their_area() {
    for (name, scene, max_edge) in [
        ("box", built_in::closed_white_box(3), 0.2),
        ("ball", built_in::ball_over_ground(24), 0.13),
        ("cornell", built_in::cornell_box(8), 0.11),
        ("columns", built_in::columns_hall(1), 0.3),
    ] {
        let fine = scene.split_edges(max_edge).unwrap();
        let longest = longest_edge(&fine);
        assert!(longest <= f64::from(max_edge), "{name}: an edge of {longest}, allowed {max_edge}");
        assert!(fine.triangle_count() > scene.triangle_count(), "{name}: something was split");
        let (before, after) = (area(&scene), area(&fine));
        assert!((after / before - 1.0).abs() < 1e-5, "{name}: area {after}, before {before}");
        // A crack would be an edge whose neighbors were split otherwise: open edges on both of its sides.
        let border: i32 = edges(&scene).values().map(|count| count.abs()).sum();
        if border == 0 {
            assert_eq!(open_edges(&fine), 0, "{name}: cracks");
        }
        for (coarse, fine) in scene.meshes().iter().zip(fine.meshes()) {
            let count = coarse.positions().len();
            assert_eq!(&fine.positions()[..count], coarse.positions(), "{name}: the first vertices are the old ones");
        }
    }
    assert_eq!(open_edges(&built_in::closed_white_box(3)), 0, "the box is closed to begin with");
}

#[test]
fn a_closed_surface_of_long_and_short_triangles_in_two_meshes_stays_closed() {
    // A tetrahedron of very different edges, its last face in a mesh of its own: shared edges are split alike.
    let positions = vec![[0.0, 0.0, 0.0], [7.0, 0.1, 0.0], [0.3, 1.0, 0.2], [0.2, 0.4, 2.0]];
    let mesh = |triangles: Vec<[u32; 3]>| {
        Mesh::new(MeshParts { positions: positions.clone(), triangles, ..MeshParts::default() }).unwrap()
    };
    let meshes = vec![mesh(vec![[0, 2, 1], [0, 1, 3], [1, 2, 3]]), mesh(vec![[2, 0, 3]])];
    let scene = Scene::new(meshes, vec![], vec![]).unwrap();
    assert_eq!(open_edges(&scene), 0, "closed to begin with");
    for max_edge in [5.0, 1.0, 0.31, 0.1] {
        let fine = scene.split_edges(max_edge).unwrap();
        assert_eq!(open_edges(&fine), 0, "cracks at {max_edge}");
        assert!(longest_edge(&fine) <= f64::from(max_edge), "{} at {max_edge}", longest_edge(&fine));
    }
}

#[test]
fn new_vertices_take_the_mean_of_all_attributes() {
    let parts = MeshParts {
        positions: vec![[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2]],
        normals: vec![[1.0, 0.0, 1.0], [-1.0, 0.0, 1.0], [0.0, 0.0, 1.0]],
        uvs: [vec![[0.0, 0.0], [1.0, 0.5], [0.0, 1.0]], vec![]],
        colors: vec![[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.0], [0.0; 4]],
        ..MeshParts::default()
    };
    let scene = Scene::new(vec![Mesh::new(parts).unwrap()], vec![], vec![]).unwrap();
    let fine = scene.split_edges(2.0).unwrap();
    let mesh = &fine.meshes()[0];
    // √5 is the only edge that is too long.
    assert_eq!(mesh.positions()[3], [1.0, 0.5, 0.0], "position");
    assert_eq!(mesh.uvs(0)[3], [0.5, 0.75], "texture coordinates");
    assert_eq!(mesh.colors()[3], [0.0, 0.5, 0.0, 0.0], "color");
    let half = 0.5_f32.sqrt();
    let expected = [-half / 2.0, 0.0, half / 2.0 + 0.5];
    let length = expected.iter().map(|c| c * c).sum::<f32>().sqrt();
    let error = (0..3).map(|k| (mesh.normals()[3][k] - expected[k] / length).abs()).fold(0.0, f32::max);
    assert!(error < 1e-6, "normal {:?}", mesh.normals()[3]);
    assert_eq!(mesh.triangles().len(), 2, "one edge was split");
}

#[test]
fn lengths_that_cannot_be_are_refused() {
    let scene = built_in::closed_white_box(1);
    for max_edge in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        let error = scene.split_edges(max_edge).unwrap_err();
        assert!(matches!(error, SceneError::Options(_)), "{error:?}");
        assert_eq!(error.to_string(), format!("expected a longest edge above zero, found {max_edge}"), "message");
    }
    let error = scene.split_edges(1e-7).unwrap_err().to_string();
    assert_eq!(
        error, "edges of at most 0.0000001 would take more than 67108864 triangles: allow longer ones",
        "found by the area, before any work"
    );
    assert_eq!(scene.split_edges(100.0).unwrap().meshes(), scene.meshes(), "nothing is too long");
}

#[test]
fn halved_edges_are_halved_for_all_their_triangles_and_meshes() {
    let positions = vec![[0.0, 0.0, 0.0], [7.0, 0.1, 0.0], [0.3, 1.0, 0.2], [0.2, 0.4, 2.0]];
    let mesh = |triangles: Vec<[u32; 3]>| {
        Mesh::new(MeshParts { positions: positions.clone(), triangles, ..MeshParts::default() }).unwrap()
    };
    let meshes = vec![mesh(vec![[0, 2, 1], [0, 1, 3], [1, 2, 3]]), mesh(vec![[2, 0, 3]])];
    let mut scene = Scene::new(meshes, vec![], vec![]).unwrap();
    // The edge 0-2 by the second mesh alone; the two triangles at it have longer ones, which go with it.
    let (once, halved) = scene.halve_edges(|mesh, edge| mesh == 1 && edge == [2, 0]).unwrap();
    assert_eq!(open_edges(&once), 0, "cracks");
    for (mesh, (before, halved)) in once.meshes().iter().zip(scene.meshes().iter().zip(&halved)) {
        let middles = halved.iter().map(|ends| {
            let [p, q] = ends.map(|i| before.positions()[i as usize]);
            std::array::from_fn(|k| 0.5 * (p[k] + q[k]))
        });
        let new = &mesh.positions()[before.positions().len()..];
        assert_eq!(middles.collect::<Vec<[f32; 3]>>(), new, "the ends of the edges that new vertices halve");
    }
    let has = |p: [f32; 3], q: [f32; 3]| {
        let key = if bits(p) < bits(q) { (bits(p), bits(q)) } else { (bits(q), bits(p)) };
        edges(&once).contains_key(&key)
    };
    assert!(!has(positions[0], positions[2]), "the chosen edge is halved");
    assert!(!has(positions[0], positions[1]), "and the longest of its triangle");
    assert!(!has(positions[0], positions[3]), "and the longest of its triangle in the other mesh");
    let parts = |scene: &Scene| scene.meshes().iter().cloned().map(Mesh::into_parts).collect::<Vec<_>>();
    assert_eq!(parts(&scene.halve_edges(|_, _| false).unwrap().0), parts(&scene), "nothing chosen");

    // Towards one corner, again and again: halving longest edges at worst halves the smallest angle.
    let quality = |scene: &Scene| {
        let shape = |c: [[f32; 3]; 3]| {
            let side = |k: usize| {
                let (p, q) = (c[k], c[(k + 1) % 3]);
                (0..3).map(|i| (f64::from(p[i]) - f64::from(q[i])).powi(2)).sum::<f64>().sqrt()
            };
            let (a, b, c) = (side(0), side(1), side(2));
            let angle = |a: f64, b: f64, c: f64| ((b * b + c * c - a * a) / (2.0 * b * c)).clamp(-1.0, 1.0).acos();
            angle(a, b, c).min(angle(b, c, a)).min(angle(c, a, b))
        };
        scene.corners().map(shape).fold(f64::INFINITY, f64::min)
    };
    let before = quality(&scene);
    for _ in 0..12 {
        scene = scene.halve_edges(|_, edge| edge.contains(&0)).unwrap().0;
        assert_eq!(open_edges(&scene), 0, "cracks");
    }
    let after = quality(&scene);
    assert!(after > 0.499 * before, "the smallest angle: {after}, before {before}");
}
