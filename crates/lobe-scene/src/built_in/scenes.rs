//! The built-in scenes, by name.

use glam::DVec3;

use crate::built_in::shapes::{Shape, scene};
use crate::built_in::still_life::still_life;
use crate::built_in::three_objects::three_objects;
use crate::built_in::walking_figure::walking_figure;
use crate::motion::animated_scene::AnimatedScene;
use crate::scene::material::Material;
use crate::scene::scene::Scene;

/// The names that [`named`] knows.
pub const NAMES: [&str; 7] = ["ball", "columns", "cave", "terrain", "still-life", "cornell", "furnace"];

/// The built-in scene of a name, in cells suitable for light at vertices; `None` if there is no such scene.
#[must_use]
pub fn named(name: &str) -> Option<Scene> {
    match name {
        "ball" => Some(ball_over_ground(96)),
        "columns" => Some(columns_hall(4)),
        "cave" => Some(cave(160)),
        "terrain" => Some(terrain(128)),
        "still-life" => Some(still_life(128)),
        "cornell" => Some(cornell_box(32)),
        "furnace" => Some(closed_white_box(16)),
        _ => None,
    }
}

/// The names that [`moving`] knows.
pub const MOVING_NAMES: [&str; 2] = ["three-objects", "walking-figure"];

/// The built-in scene of a name that moves, in cells suitable for light at vertices; `None` if there is no such scene.
#[must_use]
pub fn moving(name: &str) -> Option<AnimatedScene> {
    match name {
        "three-objects" => Some(three_objects(64)),
        "walking-figure" => Some(walking_figure(24)),
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

/// A hall: a floor of 8 × 14 × 0.25 below z = 0, two rows of five columns, and a roof of 7 × 13 × 0.5 on them.
///
/// Columns are 4 high, of radius 0.4, at x = ±2 and y = -5, -2.5, 0, 2.5, 5. Floor and roof have `detail` cells to the
/// meter, columns `2 detail` to the meter up and `8 detail` around. Floor (0.55, 0.5, 0.45), columns (0.75, 0.72,
/// 0.65), roof (0.5, 0.3, 0.2).
///
/// # Panics
/// If `detail` is zero.
#[must_use]
pub fn columns_hall(detail: usize) -> Scene {
    assert!(detail > 0, "no detail");
    let (mut floor, mut columns, mut roof) = (Shape::default(), Shape::default(), Shape::default());
    let thin = detail.div_ceil(4);
    floor.cuboid(DVec3::new(-4.0, -7.0, -0.25), DVec3::new(4.0, 7.0, 0.0), [8 * detail, 14 * detail, thin]);
    roof.cuboid(DVec3::new(-3.5, -6.5, 4.0), DVec3::new(3.5, 6.5, 4.5), [7 * detail, 13 * detail, thin]);
    for x in [-2.0, 2.0] {
        for y in [-5.0, -2.5, 0.0, 2.5, 5.0] {
            columns.column(DVec3::new(x, y, 0.0), 0.4, 4.0, (8 * detail, 8 * detail));
        }
    }
    let meshes = vec![floor.into_mesh("floor", 0), columns.into_mesh("columns", 1), roof.into_mesh("roof", 2)];
    let materials = vec![
        Material::matte("floor", [0.55, 0.5, 0.45]),
        Material::matte("columns", [0.75, 0.72, 0.65]),
        Material::matte("roof", [0.5, 0.3, 0.2]),
    ];
    scene(meshes, materials)
}

/// Half the length, width and height of the cave.
const CAVE_RADII: DVec3 = DVec3::new(6.0, 4.0, 3.0);

/// The amplitude of its walls' roughness.
const CAVE_ROUGHNESS: f64 = 0.35;

/// A cave: an ellipsoid of half axes 6, 4 and 3 about (0, 0, 1), its walls rough by 0.35, its floor flat at z = -0.5.
///
/// It opens towards +x, where the walls within 28° of the axis are left out, and to the sky within 16° of the direction
/// (-0.5, 0.2, 1). Its surface faces inwards and is seen from both sides; `cells` vertices go around, `cells / 2` bands
/// from top to bottom. Its albedo is (0.55, 0.45, 0.35).
///
/// # Panics
/// If `cells` is below 16.
#[must_use]
pub fn cave(cells: usize) -> Scene {
    assert!(cells >= 16, "{cells} cells, expected at least 16");
    let mut ball = Shape::default();
    ball.ball(DVec3::ZERO, 1.0, cells);
    let (gate, light) = (DVec3::X, DVec3::new(-0.5, 0.2, 1.0).normalize());
    let is_open = |p: DVec3| {
        let s = p.normalize();
        s.dot(gate) > 28_f64.to_radians().cos() || s.dot(light) > 16_f64.to_radians().cos()
    };
    let cave = ball.inside_out().without(is_open).moved(|p| cave_wall(p.normalize()));
    scene(vec![cave.into_mesh("cave", 0)], vec![Material::matte("rock", [0.55, 0.45, 0.35])])
}

/// The wall in the direction `s` from the middle: waves of three lengths, and the floor.
fn cave_wall(s: DVec3) -> DVec3 {
    let wave = |f: f64, a: DVec3| (f * s.dot(a)).sin();
    let rough = 0.5 * wave(5.0, DVec3::new(0.6, -0.5, 0.8)) * wave(4.0, DVec3::new(-0.7, 0.9, 0.3))
        + 0.3 * wave(11.0, DVec3::new(0.2, 0.9, -0.6)) * wave(9.0, DVec3::new(0.9, 0.1, 0.5))
        + 0.2 * wave(23.0, DVec3::new(-0.8, 0.4, 0.5));
    let p = s * CAVE_RADII * (1.0 + CAVE_ROUGHNESS * rough / 3.0) + DVec3::Z;
    // Below the floor the wall is flattened to a hundredth, which keeps its triangles' areas positive.
    let floor = -0.5;
    if p.z < floor { DVec3::new(p.x, p.y, floor + 0.01 * (p.z - floor)) } else { p }
}

/// Half the side of the terrain.
const TERRAIN_HALF: f64 = 20.0;

/// A terrain: heights between -4 and 4 over a square of side 40 about the origin, in `cells` × `cells` cells.
///
/// ```text
///   h(x, y) = Σ_k  2 · 0.55^k sin( f_k (x cos a_k + y sin a_k) + k )       f_k = 0.21 · 1.7^k,  a_k = 2.4 k,  k = 0..6
/// ```
///
/// divided by 1.1 to stay within its bounds. Its albedo is (0.4, 0.42, 0.25); normals are those of the formula.
///
/// # Panics
/// If `cells` is zero.
#[must_use]
pub fn terrain(cells: usize) -> Scene {
    assert!(cells > 0, "no cells");
    let mut ground = Shape::default();
    ground.surface((cells, cells), |u, v| {
        let (x, y) = (TERRAIN_HALF * (2.0 * u - 1.0), TERRAIN_HALF * (2.0 * v - 1.0));
        let (height, [dx, dy]) = terrain_height(x, y);
        (DVec3::new(x, y, height), DVec3::new(-dx, -dy, 1.0).normalize())
    });
    scene(vec![ground.into_mesh("terrain", 0)], vec![Material::matte("grass", [0.4, 0.42, 0.25])])
}

/// Height and its slopes.
fn terrain_height(x: f64, y: f64) -> (f64, [f64; 2]) {
    let (mut height, mut slopes) = (0.0, [0.0; 2]);
    for k in 0..7 {
        let amplitude = 2.0 / 1.1 * 0.55_f64.powi(k);
        let frequency = 0.21 * 1.7_f64.powi(k);
        let (sin_a, cos_a) = (2.4 * f64::from(k)).sin_cos();
        let (sin, cos) = (frequency * (x * cos_a + y * sin_a) + f64::from(k)).sin_cos();
        height += amplitude * sin;
        slopes[0] += amplitude * frequency * cos_a * cos;
        slopes[1] += amplitude * frequency * sin_a * cos;
    }
    (height, slopes)
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
    use crate::scene::mesh::Mesh;
    use crate::scene::scene::Bounds;

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

    #[test]
    fn slopes_are_those_of_the_heights_and_heights_keep_their_bounds() {
        let e = 1e-5;
        for (x, y) in [(0.0, 0.0), (-19.0, 3.3), (7.7, 12.1)] {
            let (_, [dx, dy]) = terrain_height(x, y);
            let difference =
                |a: (f64, f64), b: (f64, f64)| (terrain_height(a.0, a.1).0 - terrain_height(b.0, b.1).0) / (2.0 * e);
            let (fx, fy) = (difference((x + e, y), (x - e, y)), difference((x, y + e), (x, y - e)));
            assert!((dx - fx).abs() < 1e-8 && (dy - fy).abs() < 1e-8, "{dx}, {dy}, expected {fx}, {fy}");
        }
        let bounds = terrain(64).bounds();
        assert!(bounds.min[2] >= -4.0 && bounds.max[2] <= 4.0, "{bounds:?}");
    }
}
