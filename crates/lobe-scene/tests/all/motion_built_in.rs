//! Built-in scenes in motion.

use lobe_scene::{AnimatedScene, Bounds, EntityKind, Mesh, built_in};

use crate::motion::{close, posed};

fn same_at_both_ends(scene: &AnimatedScene) {
    let end = scene.animations()[0].duration();
    let (first, last) = (posed(scene, 0.0), posed(scene, end));
    for (a, b) in first.meshes().iter().zip(last.meshes()) {
        assert!(close(a.positions(), b.positions(), 1e-5), "{} ends where it began", a.name());
    }
}

#[test]
fn three_objects_move_over_the_ground_and_never_through_it_or_each_other() {
    let scene = built_in::three_objects(24);
    same_at_both_ends(&scene);
    let kinds: Vec<_> = scene.entities().iter().map(lobe_scene::Entity::kind).collect();
    use EntityKind::{Rigid, Static};
    assert_eq!(kinds, [Static, Rigid, Rigid, Rigid], "the ground and three objects");
    for k in 0..40 {
        let pose = scene.pose(0, 0.1 * f64::from(k)).unwrap();
        let low = pose.scene().meshes()[1..].iter().flat_map(Mesh::positions).map(|p| p[2]).fold(f32::MAX, f32::min);
        assert!(low > 0.0, "{low} at {k}: above the ground");
        let radii = [0.5, 0.45 * 3_f64.sqrt(), 0.9];
        let places: Vec<_> =
            scene.entities()[1..].iter().map(|entity| pose.place(entity).similarity().unwrap()).collect();
        for (i, j) in [(0, 1), (0, 2), (1, 2)] {
            let (a, b) = (places[i].translation, places[j].translation);
            let apart = (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt() - radii[i] - radii[j];
            assert!(apart > 0.0, "{apart} between the balls around {i} and {j} at {k}");
        }
    }
    // The path of the ball, between keys too.
    for t in [0.1, 0.37, 2.9] {
        let w = std::f64::consts::TAU * t / 4.0;
        let expected = [2.4 * w.cos(), 2.4 * w.sin(), 0.9 - 0.35 * (2.0 * w).cos()];
        let found = scene.pose(0, t).unwrap().place(&scene.entities()[1]).translation();
        let off = (0..3).map(|k| (found[k] - expected[k]).abs()).fold(0.0, f64::max);
        assert!(off < 1e-4, "{off} off its circle at {t}");
    }
}

/// Six times the volume, by the divergence theorem.
fn volume(mesh: &Mesh) -> f64 {
    let corners = (0..mesh.triangles().len()).map(|t| mesh.corners(t).map(|p| p.map(f64::from)));
    let box_product = |[a, b, c]: [[f64; 3]; 3]| {
        a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])
    };
    corners.map(box_product).sum()
}

#[test]
fn the_figure_walks_on_the_ground_and_keeps_its_volume() {
    let scene = built_in::walking_figure(24);
    same_at_both_ends(&scene);
    let figure = &scene.entities()[1];
    assert_eq!((figure.kind(), figure.skin()), (EntityKind::Deformed, Some(0)), "a skin");
    assert!(figure.vertices().len() > 4000, "{} vertices", figure.vertices().len());
    let Bounds { min, max } = scene.own_scene(figure).unwrap().bounds();
    assert!(min[2] == 0.0 && (1.7..1.8).contains(&max[2]), "from {} to {}", min[2], max[2]);
    let bound = volume(&scene.rest().meshes()[1]);
    let (mut front, mut back) = (f32::MAX, f32::MIN);
    for k in 0..32 {
        let mesh = &posed(&scene, 1.1 * f64::from(k) / 32.0).meshes()[1].clone();
        let low = mesh.positions().iter().map(|p| p[2]).fold(f32::MAX, f32::min);
        assert!((-0.012..0.003).contains(&low), "the lower foot at {low} in frame {k}");
        let ratio = volume(mesh) / bound;
        assert!((0.93..1.07).contains(&ratio), "{ratio} of its volume in frame {k}");
        (front, back) = mesh.positions().iter().fold((front, back), |(f, b), p| (f.min(p[1]), b.max(p[1])));
    }
    assert!(front < -0.4 && back > 0.4, "it takes steps: {front} to {back}");
}

#[test]
fn neighbors_in_the_figure_stay_neighbors() {
    let scene = built_in::walking_figure(24);
    let longest = |mesh: &Mesh| {
        let of = |t: usize| {
            let [a, b, c] = mesh.corners(t);
            [(a, b), (b, c), (c, a)].map(|(p, q)| (0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f32>().sqrt())
        };
        (0..mesh.triangles().len()).flat_map(of).fold(0.0, f32::max)
    };
    let bound = longest(&scene.rest().meshes()[1]);
    for k in 0..8 {
        let found = longest(&posed(&scene, 1.1 * f64::from(k) / 8.0).meshes()[1]);
        assert!(found < 2.0 * bound, "an edge of {found}, of {bound} where it is bound, in frame {k}");
    }
}
