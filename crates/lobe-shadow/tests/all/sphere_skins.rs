//! Sphere sets that move with joints.

use lobe_shadow::{Skin, SkinnedMesh, SphereSet};

const STILL: [[f64; 4]; 3] = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

struct Strip {
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    joints: [[u16; 4]; 6],
    weights: Vec<[f32; 4]>,
}

/// A strip from x = 0 to 2, its left end on joint 3, its right end on joint 5, both at its middle.
fn strip() -> Strip {
    let positions = (0..3).flat_map(|x| [[x as f32, 0.0, 0.0], [x as f32, 1.0, 0.0]]).collect();
    let triangles = vec![[0, 2, 1], [1, 2, 3], [2, 4, 3], [3, 4, 5]];
    let weights = [[2.0, 0.0, 0.0, 0.0], [1.0, 1.0, 0.0, 0.0], [0.0, 3.0, 0.0, 0.0]];
    Strip { positions, triangles, joints: [[3, 5, 0, 0]; 6], weights: (0..6).map(|v| weights[v / 2]).collect() }
}

#[test]
fn spheres_take_the_joints_of_the_nearest_place() {
    let Strip { positions, triangles, joints, weights } = strip();
    let mesh = SkinnedMesh { positions: &positions, triangles: &triangles, joints: &joints, weights: &weights };
    let centers = vec![[-1.0, 0.5, 0.3], [1.0, 0.5, 0.2], [3.0, 0.5, 0.0], [0.5, 0.5, 0.1]];
    let set = SphereSet::new(centers, vec![0.5; 4]).unwrap().bind(&mesh).unwrap();
    let share = |sphere: usize, joint: u16| -> f32 {
        let skin = set.skin().unwrap();
        skin.joints()[sphere].iter().zip(skin.weights()[sphere]).filter(|(j, _)| **j == joint).map(|(_, w)| w).sum()
    };
    // At x = 0.5, half of (2, 0) and half of (1, 1), scaled to sum to 1.
    for (sphere, left) in [1.0, 0.5, 0.0, 0.75].into_iter().enumerate() {
        assert!((share(sphere, 3) - left).abs() < 1e-6, "sphere {sphere}: {} of joint 3", share(sphere, 3));
        assert!((share(sphere, 5) - (1.0 - left)).abs() < 1e-6, "sphere {sphere}: {} of joint 5", share(sphere, 5));
    }
    let mut matrices = vec![STILL; 6];
    matrices[5][2][3] = 4.0;
    let posed = set.posed(&matrices).unwrap();
    for (sphere, z) in [0.3, 0.2 + 2.0, 4.0, 0.1 + 1.0].into_iter().enumerate() {
        assert!((posed[sphere].center[2] - z).abs() < 1e-6, "sphere {sphere}: {:?}", posed[sphere]);
        assert!((posed[sphere].radius - 0.5).abs() < 1e-9, "sphere {sphere}: {:?}", posed[sphere]);
    }
}

#[test]
fn radii_follow_the_mean_scale_of_the_joints_and_never_collapse() {
    let skin = Skin::new(vec![[0, 1, 0, 0]], vec![[0.5, 0.5, 0.0, 0.0]]).unwrap();
    let set = SphereSet::new(vec![[0.0; 3]], vec![2.0]).unwrap().with_skin(skin).unwrap();
    let stretched = [[8.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    let posed = set.posed(&[stretched, STILL]).unwrap();
    assert!((posed[0].radius - 3.0).abs() < 1e-12, "the mean of 2 · 2 and 2 · 1, found {}", posed[0].radius);
    // Half a turn about z: the blended matrix has determinant 0.
    let turned = [[-1.0, 0.0, 0.0, 0.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    assert!((set.posed(&[turned, STILL]).unwrap()[0].radius - 2.0).abs() < 1e-12, "turned against each other");
}

#[test]
fn spheres_far_from_the_frame_of_their_mesh_are_posed_from_there() {
    let quarter_turn = [[0.0, -1.0, 0.0, 5.0], [1.0, 0.0, 0.0, 6.0], [0.0, 0.0, 1.0, 7.0]];
    let set = SphereSet::new(vec![[1.0, 0.0, 0.5]], vec![2.0]).unwrap().with_origin([1e6, 0.0, 0.0]).unwrap();
    let posed = set.posed(&[quarter_turn]).unwrap();
    assert_eq!(posed[0].center, [5.0, 1e6 + 7.0, 7.5], "a million away, turned");
}

#[test]
fn joints_that_do_not_fit_are_refused() {
    let Strip { positions, triangles, joints, weights } = strip();
    let mesh = SkinnedMesh { positions: &positions, triangles: &triangles, joints: &joints, weights: &weights };
    let set = || SphereSet::new(vec![[0.0; 3]], vec![1.0]).unwrap();
    let bind = |mesh: SkinnedMesh<'_>| set().bind(&mesh).unwrap_err().to_string();
    assert_eq!(
        bind(SkinnedMesh { triangles: &[], ..mesh }),
        "expected a mesh with triangles to bind to, found none",
        ""
    );
    assert_eq!(
        bind(SkinnedMesh { triangles: &[[0, 1, 6]], ..mesh }),
        "expected vertices below 6, found [0, 1, 6] at triangle 0",
        "index"
    );
    assert_eq!(
        bind(SkinnedMesh { joints: &joints[1..], ..mesh }),
        "expected joints and weights of 6 vertices, found 5 and 6",
        "joints"
    );
    for bad in [f32::NAN, -1.0, f32::INFINITY] {
        let message = bind(SkinnedMesh { weights: &[[bad; 4]; 6], ..mesh });
        assert!(message.starts_with("expected weights of at least 0, found "), "{message}");
    }
    let message = bind(SkinnedMesh { weights: &[[0.0; 4]; 6], ..mesh });
    assert!(message.starts_with("expected weights of at least 0, some more, found "), "{message}");
    let bound = set().bind(&mesh).unwrap();
    assert_eq!(
        bound.posed(&[STILL; 3]).unwrap_err().to_string(),
        "expected a matrix for joint 3 of sphere 0, found 3",
        "too few matrices"
    );
    let mut broken = [STILL; 6];
    broken[2][1][1] = f64::NAN;
    assert!(bound.posed(&broken).unwrap_err().to_string().ends_with("at joint 2"), "a matrix that is none");
    assert_eq!(SphereSet::default().posed(&[]).unwrap(), [], "no spheres need no joints");
}
