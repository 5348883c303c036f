//! The camera that orbits.

use lobe::scene::{Bvh, built_in};
use lobe_viewer::{Kept, Orbit, ReadLimits, SceneData, UserFolder, open_scene, vertex_under};

fn close(a: [f64; 3], b: [f64; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9)
}

#[test]
fn a_full_turn_comes_back_and_the_axis_is_never_reached() {
    let start = Orbit::default();
    let mut orbit = start;
    (0..8).for_each(|_| orbit.turn(0.25, 0.0));
    assert!(close(orbit.eye(), start.eye()), "{:?}, expected {:?}", orbit.eye(), start.eye());
    orbit.turn(0.0, 100.0);
    assert!(orbit.camera().is_some() && orbit.on_device().is_some(), "{orbit:?}");
    assert!(orbit.height < std::f64::consts::FRAC_PI_2, "{orbit:?}");
}

#[test]
fn what_is_under_the_pointer_follows_a_pan() {
    let mut orbit = Orbit::default();
    let point = orbit.target;
    assert!(orbit.project(point).is_some_and(|[x, y]| x.abs() + y.abs() < 1e-12), "the target is in the middle");
    // A tenth of the height to the right and down is 0.2 in units of half the height.
    orbit.pan(0.1, 0.1);
    let [right, up] = orbit.project(point).unwrap();
    assert!((right - 0.2).abs() < 1e-9 && (up + 0.2).abs() < 1e-9, "{right}, {up}");
}

#[test]
fn a_framed_box_is_in_the_picture_and_zoom_keeps_its_bounds() {
    let bounds = [[-3.0, 2.0, 0.0], [5.0, 4.0, 1.0]];
    let mut orbit = Orbit::default().framing(bounds);
    let [right, up] = orbit.project(bounds[1]).unwrap();
    assert!(right.abs() < 2.0 && up.abs() < 1.0, "{right}, {up}");
    for factor in [f64::NAN, 0.0, -1.0, f64::INFINITY] {
        let before = orbit;
        orbit.zoom(factor);
        assert_eq!(orbit, before, "{factor} is no zoom");
    }
    orbit.zoom(1e30);
    assert!(orbit.on_device().is_some(), "{orbit:?}");
}

#[test]
fn scenes_of_any_size_stay_framed_where_nothing_is_scrolled_and_at_the_next_start() {
    let folder = tempfile::tempdir().unwrap();
    let user = UserFolder::at(folder.path());
    let size = |orbit: &Orbit, radius: f64| radius * orbit.size_at(orbit.target).unwrap();
    let expected = size(&Orbit::default().framing([[-1.0; 3], [1.0; 3]]), 1.0);
    for radius in [1e-3, 1.0, 2300.0, 1e5] {
        let framed = Orbit::default().framing([[-radius; 3], [radius; 3]]);
        let mut orbit = framed;
        // As a room does in each frame.
        orbit.scroll(0.0);
        orbit.zoom(1.0);
        assert_eq!(orbit, framed, "a radius of {radius}");
        assert!((size(&orbit, radius) / expected - 1.0).abs() < 1e-9, "as large in the picture: {orbit:?}");
        let mut kept = Kept::default();
        kept.rooms.orbit = Some(framed);
        kept.write(&user);
        assert_eq!(Kept::read(&user).rooms.orbit, Some(framed), "a radius of {radius}, kept");
    }
}

#[test]
fn points_far_from_the_origin_are_framed_and_zoom_stays_outside_of_them() {
    for at in [0.0, 1.0, 1e4, 1e9] {
        let mut orbit = Orbit::default().framing([[at; 3]; 2]);
        assert!(orbit.camera().is_some() && orbit.on_device().is_some(), "framed: {orbit:?}");
        orbit.zoom(1e30);
        assert!(orbit.camera().is_some() && orbit.on_device().is_some(), "as near as can be: {orbit:?}");
    }
}

#[test]
fn the_vertex_under_a_point_is_where_that_point_projects() {
    let opened = open_scene("built-in:ball".as_ref(), &ReadLimits::default()).unwrap();
    let data = SceneData::new(opened.name, opened.scene);
    let orbit = Orbit::default().framing(data.scene.world_bounds());
    let top = orbit.project([0.0, 0.0, 2.4]).unwrap();
    let vertex = vertex_under(&data, &orbit, top[0], top[1]).unwrap();
    let [x, y, z] = vertex.position;
    let from_center = (x * x + y * y + (z - 1.5).powi(2)).sqrt();
    assert!((from_center - 1.0).abs() < 1e-5, "{vertex:?} lies on the ball");
    let place = orbit.project(vertex.position).unwrap();
    assert!((place[0] - top[0]).hypot(place[1] - top[1]) < 0.05, "{place:?}, expected near {top:?}");
    assert_eq!(vertex_under(&data, &orbit, 50.0, 50.0), None, "nothing is there");
    let scene = built_in::ball_over_ground(96);
    assert_eq!(scene.vertex_count(), data.scene.vertex_count(), "the scene of that name");
    assert_eq!(Bvh::new(&scene).triangle_count(), data.bvh.triangle_count(), "and its tree");
}
