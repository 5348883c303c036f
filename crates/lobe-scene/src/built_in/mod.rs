//! Built-in scenes by formula: the same on every machine, each at any number of cells.
//!
//! Lengths are meters. All vertices are used and every triangle has an area.

// Read this file first, then `shapes`, from which all scenes are made, and a file for each of the larger ones; `three_objects` and
// `walking_figure` move. Uses `motion` and `scene`.

pub(crate) mod cave;
pub(crate) mod columns_hall;
pub(crate) mod shapes;
pub(crate) mod terrain;
pub(crate) mod three_objects;
pub(crate) mod walking_figure;

use glam::DVec3;

use crate::built_in::shapes::{Shape, scene};
use crate::{Material, Scene};

pub use crate::built_in::cave::cave;
pub use crate::built_in::columns_hall::columns_hall;
pub use crate::built_in::terrain::terrain;
pub use crate::built_in::three_objects::three_objects;
pub use crate::built_in::walking_figure::walking_figure;

/// The names that [`named`] knows.
pub const NAMES: [&str; 6] = ["ball", "columns", "cave", "terrain", "cornell", "furnace"];

/// The built-in scene of a name, in cells suitable for light at vertices; `None` if there is no such scene.
#[must_use]
pub fn named(name: &str) -> Option<Scene> {
    match name {
        "ball" => Some(ball_over_ground(96)),
        "columns" => Some(columns_hall(4)),
        "cave" => Some(cave(160)),
        "terrain" => Some(terrain(128)),
        "cornell" => Some(cornell_box(32)),
        "furnace" => Some(closed_white_box(16)),
        _ => None,
    }
}

/// A ball over a ground: radius 1, its center 1.5 above the middle of a square of side 8 at z = 0.
///
/// The ground has `cells` × `cells` cells, and its middle is a vertex if that is even; the ball has `cells` vertices
/// around. The ground is gray (0.6), the ball red (0.7, 0.25, 0.2).
///
/// # Panics
/// If `cells` is below 4.
#[must_use]
pub fn ball_over_ground(cells: usize) -> Scene {
    assert!(cells >= 4, "{cells} cells, expected at least 4");
    let mut ground = Shape::default();
    ground.parallelogram(DVec3::new(-4.0, -4.0, 0.0), [DVec3::X * 8.0, DVec3::Y * 8.0], (cells, cells));
    let mut ball = Shape::default();
    ball.ball(DVec3::new(0.0, 0.0, 1.5), 1.0, cells);
    let materials = vec![Material::matte("ground", [0.6; 3]), Material::matte("ball", [0.7, 0.25, 0.2])];
    scene(vec![ground.into_mesh("ground", 0), ball.into_mesh("ball", 1)], materials)
}

/// A Cornell box: 2 × 2 × 2 around (0, 0, 1), open towards -y, with two blocks and a skylight.
///
/// The left wall (x = -1) is red (0.63, 0.065, 0.05), the right one green (0.14, 0.45, 0.091), all else is (0.725,
/// 0.71, 0.68). The skylight in the ceiling, where the lamp would hang, is 0.5 × 0.5 about the z axis. The tall block
/// is 0.6 × 0.6 × 1.2 about (-0.35, 0.35), turned by 17°; the short one 0.6 × 0.6 × 0.6 about (0.35, -0.3), turned by
/// -17°. Walls have `cells` × `cells` cells facing inwards, blocks a third as many. It has texture coordinates for a
/// lightmap: each wall and each side of a block has a square of its own.
///
/// # Panics
/// If `cells` is not a multiple of 8, whose edges the skylight needs.
#[must_use]
pub fn cornell_box(cells: usize) -> Scene {
    assert!(cells > 0 && cells.is_multiple_of(8), "{cells} cells, expected a multiple of 8");
    let n = (cells, cells);
    let [x, y, z] = [DVec3::X * 2.0, DVec3::Y * 2.0, DVec3::Z * 2.0];
    let corner = DVec3::new(-1.0, -1.0, 0.0);
    let (mut white, mut red, mut green) = (Shape::default(), Shape::default(), Shape::default());
    white.parallelogram(corner, [x, y], n);
    white.parallelogram(corner + z, [y, x], n);
    white.parallelogram(corner + y, [x, z], n);
    let white = white.without(|p| p.z > 1.999 && p.x.abs() < 0.25 && p.y.abs() < 0.25);
    red.parallelogram(corner, [y, z], n);
    green.parallelogram(corner + x, [z, y], n);
    let block = |at: DVec3, height: f64, degrees: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let (a, b, c) = (DVec3::new(cos, sin, 0.0) * 0.6, DVec3::new(-sin, cos, 0.0) * 0.6, DVec3::Z * height);
        let foot = at - (a + b) / 2.0;
        let few = (cells / 3).max(1);
        let many = (few as f64 * height / 0.6).round() as usize;
        let mut block = Shape::default();
        block.parallelogram(foot + c, [a, b], (few, few));
        block.parallelogram(foot, [a, c], (few, many));
        block.parallelogram(foot + b, [c, a], (many, few));
        block.parallelogram(foot, [c, b], (many, few));
        block.parallelogram(foot + a, [b, c], (few, many));
        block
    };
    let shapes = [
        ("floor, ceiling and back", 0, white),
        ("left", 1, red),
        ("right", 2, green),
        ("tall block", 0, block(DVec3::new(-0.35, 0.35, 0.0), 1.2, 17.0)),
        ("short block", 0, block(DVec3::new(0.35, -0.3, 0.0), 0.6, -17.0)),
    ];
    let surfaces = shapes.iter().map(|(.., shape)| shape.surfaces()).sum::<usize>();
    let columns = (surfaces as f64).sqrt().ceil() as usize;
    let mut first = 0;
    let meshes = shapes.into_iter().map(|(name, material, shape)| {
        let square = first;
        first += shape.surfaces();
        shape.into_unfolded_mesh(name, material, square, columns)
    });
    let meshes = meshes.collect();
    let materials = vec![
        Material::matte("white", [0.725, 0.71, 0.68]),
        Material::matte("red", [0.63, 0.065, 0.05]),
        Material::matte("green", [0.14, 0.45, 0.091]),
    ];
    scene(meshes, materials)
}

/// A closed cube of side 2 around the origin, white inside (albedo 1), with `cells` × `cells` cells a side facing
/// inwards.
///
/// The white furnace of tests: all light emitted inside returns.
///
/// # Panics
/// If `cells` is zero.
#[must_use]
pub fn closed_white_box(cells: usize) -> Scene {
    assert!(cells > 0, "no cells");
    let mut cube = Shape::default();
    cube.cuboid(DVec3::NEG_ONE, DVec3::ONE, [cells; 3]);
    let material = Material { double_sided: false, ..Material::matte("white", [1.0; 3]) };
    scene(vec![cube.inside_out().into_mesh("box", 0)], vec![material])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Bounds, Mesh};

    /// Volume by the divergence theorem: positive where triangles face outwards.
    fn volume(mesh: &Mesh) -> f64 {
        let corner = |t: usize| mesh.corners(t).map(|p| DVec3::from(p.map(f64::from)));
        (0..mesh.triangles().len()).map(corner).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
    }

    #[test]
    fn all_scenes_have_clean_meshes_whose_normals_agree_with_their_triangles() {
        for name in NAMES {
            let scene = named(name).unwrap();
            for mesh in scene.meshes() {
                let (dropped, made) = (mesh.dropped_triangles(), mesh.made_normals());
                assert_eq!((dropped, made), (0, 0), "{name}, {}: triangles without area, missing normals", mesh.name());
                for (t, triangle) in mesh.triangles().iter().enumerate() {
                    let [a, b, c] = mesh.corners(t).map(|p| DVec3::from(p.map(f64::from)));
                    let n = (b - a).cross(c - a).normalize();
                    for &i in triangle {
                        let dot = n.dot(DVec3::from(mesh.normals()[i as usize].map(f64::from)));
                        assert!(dot > 0.3, "{name}, {}: cos {dot} at triangle {t}", mesh.name());
                    }
                }
            }
        }
        assert!(named("teapot").is_none(), "no such scene");
    }

    #[test]
    fn no_two_walls_of_the_room_share_a_place_of_its_lightmap() {
        let room = cornell_box(8);
        let squares = |mesh: &Mesh| -> Vec<([i32; 2], [f32; 3])> {
            let of = |(uv, normal): (&[f32; 2], &[f32; 3])| (uv.map(|c| (4.0 * c).floor() as i32), *normal);
            mesh.uvs(0).iter().zip(mesh.normals()).map(of).collect()
        };
        let all: Vec<_> =
            room.meshes().iter().enumerate().flat_map(|(k, m)| squares(m).into_iter().map(move |s| (k, s))).collect();
        assert_eq!(all.len(), room.vertex_count(), "every vertex has a place");
        let mut walls = std::collections::BTreeMap::new();
        for (mesh, (square, normal)) in all {
            assert!(square.iter().all(|c| (0..4).contains(c)), "{square:?} lies in the picture");
            let own = *walls.entry(square).or_insert((mesh, normal));
            assert_eq!(own, (mesh, normal), "{square:?} belongs to one wall");
        }
        assert_eq!(walls.len(), 15, "five walls and twice five sides");
    }

    #[test]
    fn the_ball_and_the_box_have_their_volumes() {
        let ball = volume(&ball_over_ground(256).meshes()[1]);
        let exact = 4.0 / 3.0 * std::f64::consts::PI;
        assert!((ball / exact - 1.0).abs() < 4e-4, "{ball}, expected {exact}");
        let cube = volume(&closed_white_box(5).meshes()[0]);
        assert!((cube + 8.0).abs() < 1e-6, "{cube}, expected -8: its triangles face inwards");
    }

    #[test]
    fn dimensions_are_as_documented() {
        for (scene, min, max) in [
            (ball_over_ground(8), [-4.0, -4.0, 0.0], [4.0, 4.0, 2.5]),
            (cornell_box(8), [-1.0, -1.0, 0.0], [1.0, 1.0, 2.0]),
            (closed_white_box(3), [-1.0; 3], [1.0; 3]),
            (columns_hall(1), [-4.0, -7.0, -0.25], [4.0, 7.0, 4.5]),
        ] {
            assert_eq!(scene.bounds(), Bounds { min, max }, "bounds of {}", scene.meshes()[0].name());
        }
        let middle = ball_over_ground(8).meshes()[0].positions().contains(&[0.0; 3]);
        assert!(middle, "the middle of the ground is a vertex");
    }
}
