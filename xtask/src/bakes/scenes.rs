//! The scenes that no package has: coarse walls, parts stuck into each other, and a box with a mesh in it.

use crate::bakes::shapes::Shapes;
use crate::bakes::vectors::{Vector, add, normalized, scaled};

const WHITE: Vector = [0.75; 3];
const GREEN: Vector = [0.15, 0.5, 0.12];
const RED: Vector = [0.6, 0.08, 0.07];
const BLUE: Vector = [0.2, 0.3, 0.6];
const WOOD: Vector = [0.5, 0.32, 0.18];
const DARK: Vector = [0.3; 3];
const YELLOW: Vector = [0.75, 0.55, 0.1];
const GRASS: Vector = [0.35, 0.38, 0.25];

const X: Vector = [1.0, 0.0, 0.0];
const Z: Vector = [0.0, 0.0, 1.0];

/// Shapes that stand as they are.
impl Shapes {
    fn cuboid(&mut self, name: &str, low: Vector, high: Vector, color: Vector) {
        self.block(name, [low, high], (Z, 0.0), [0.0; 3], color);
    }

    /// A sheet of two triangles.
    fn wall(&mut self, name: &str, o: Vector, u: Vector, v: Vector, color: Vector) {
        self.sheet(name, [o, u, v], [1, 1], color);
    }

    /// A wall in a plane of equal y, around an opening: four sheets of two triangles.
    fn wall_with_window(&mut self, [x0, x1]: [f64; 2], y: f64, [wx0, wx1, wz0, wz1]: [f64; 4], top: f64) {
        let sheets = [[x0, x1, 0.0, wz0], [x0, x1, wz1, top], [x0, wx0, wz0, wz1], [wx1, x1, wz0, wz1]];
        for (k, [a, b, c, d]) in sheets.into_iter().enumerate() {
            let (u, v) = ([b - a, 0.0, 0.0], [0.0, 0.0, d - c]);
            self.wall(&format!("Window wall {x0}.{k}"), [a, y, c], v, u, WHITE);
        }
    }
}

/// An open box of walls of two triangles, with a knot in it.
pub(super) fn cornell() -> Shapes {
    let mut s = Shapes::default();
    s.wall("Floor", [-1.0, -1.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], WHITE);
    s.wall("Ceiling", [-1.0, -1.0, 2.0], [0.0, 2.0, 0.0], [2.0, 0.0, 0.0], WHITE);
    s.wall("Back", [-1.0, 1.0, 0.0], [2.0, 0.0, 0.0], [0.0, 0.0, 2.0], WHITE);
    s.wall("Left", [-1.0, -1.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0], RED);
    s.wall("Right", [1.0, -1.0, 0.0], [0.0, 0.0, 2.0], [0.0, 2.0, 0.0], GREEN);
    s.knot("Knot", [0.0, 0.1, 0.62], [0.6, 0.13], [128, 16], WHITE);
    s
}

/// A furnished room of some 6000 triangles with a wide window.
pub(super) fn room() -> Shapes {
    let mut s = Shapes::default();
    s.sheet("Floor", [[-3.0, -2.5, 0.0], [6.0, 0.0, 0.0], [0.0, 5.0, 0.0]], [12, 10], WOOD);
    s.sheet("Ceiling", [[-3.0, -2.5, 3.0], [0.0, 5.0, 0.0], [6.0, 0.0, 0.0]], [10, 12], WHITE);
    s.sheet("Wall.001", [[-3.0, -2.5, 0.0], [0.0, 5.0, 0.0], [0.0, 0.0, 3.0]], [10, 6], WHITE);
    s.sheet("Wall.002", [[3.0, -2.5, 0.0], [0.0, 0.0, 3.0], [0.0, 5.0, 0.0]], [6, 10], BLUE);
    s.sheet("Wall.003", [[-3.0, 2.5, 0.0], [6.0, 0.0, 0.0], [0.0, 0.0, 3.0]], [12, 6], WHITE);
    s.sheet("Wall.004", [[-3.0, -2.5, 0.0], [0.0, 0.0, 0.8], [6.0, 0.0, 0.0]], [2, 12], WHITE);
    s.sheet("Wall.005", [[-3.0, -2.5, 2.4], [0.0, 0.0, 0.6], [6.0, 0.0, 0.0]], [2, 12], WHITE);
    s.sheet("Wall.006", [[-3.0, -2.5, 0.8], [0.0, 0.0, 1.6], [1.0, 0.0, 0.0]], [4, 2], WHITE);
    s.sheet("Wall.007", [[2.0, -2.5, 0.8], [0.0, 0.0, 1.6], [1.0, 0.0, 0.0]], [4, 2], WHITE);
    s.cuboid("Table top", [-1.0, 0.2, 0.7], [1.0, 1.4, 0.76], WOOD);
    for (k, [x, y]) in [[-0.9, 0.3], [0.9, 0.3], [-0.9, 1.3], [0.9, 1.3]].into_iter().enumerate() {
        s.rod(&format!("Leg.{k}"), [[x, y, 0.0], [x, y, 0.72]], 0.05, 24, WOOD);
    }
    s.ball("Ball.1", [-0.5, 0.8, 0.96], [0.2; 3], [32, 16], RED);
    s.ball("Ball.2", [1.9, -0.4, 0.4], [0.4; 3], [32, 16], WHITE);
    s.knot("Knot", [0.4, 0.8, 1.0], [0.28, 0.06], [96, 12], GREEN);
    s.cuboid("Shelf", [-2.95, -0.5, 0.0], [-2.5, 1.5, 1.1], WHITE);
    s.cuboid("Chest", [2.0, 1.3, 0.0], [2.9, 2.3, 0.7], RED);
    s.cuboid("Rug", [-1.6, -0.6, 0.0], [1.6, 1.8, 0.02], RED);
    s
}

/// A robot whose parts stick into each other.
pub(super) fn robot() -> Shapes {
    let mut s = Shapes::default();
    s.cuboid("Torso", [-0.45, -0.25, 1.0], [0.45, 0.25, 1.9], YELLOW);
    s.cuboid("Hips", [-0.35, -0.22, 0.85], [0.35, 0.22, 1.05], DARK);
    s.rod("Neck", [[0.0, 0.0, 1.7], [0.0, 0.0, 2.25]], 0.1, 12, DARK);
    s.ball("Head", [0.0, 0.0, 2.3], [0.34, 0.3, 0.3], [24, 12], YELLOW);
    s.cuboid("Visor", [-0.22, -0.34, 2.22], [0.22, -0.1, 2.4], DARK);
    for (side, x) in [("L", -1.0), ("R", 1.0)] {
        let named = |name: &str| format!("{name}.{side}");
        let elbow = [0.75 * x, -0.05, 1.25];
        s.ball(&named("Shoulder"), [0.5 * x, 0.0, 1.75], [0.17; 3], [16, 10], DARK);
        s.rod(&named("Upper arm"), [[0.42 * x, 0.0, 1.75], elbow], 0.1, 12, YELLOW);
        s.ball(&named("Elbow"), elbow, [0.13; 3], [12, 8], DARK);
        s.rod(&named("Fore arm"), [elbow, [0.7 * x, -0.55, 1.05]], 0.085, 12, YELLOW);
        let hand = [[-0.1, -0.1, -0.08], [0.1, 0.1, 0.08]];
        s.block(&named("Hand"), hand, (X, 20.0), [0.7 * x, -0.6, 1.03], DARK);
        s.rod(&named("Leg"), [[0.2 * x, 0.0, 1.0], [0.22 * x, 0.0, 0.1]], 0.13, 12, YELLOW);
        s.ball(&named("Knee"), [0.21 * x, -0.03, 0.52], [0.17; 3], [12, 8], DARK);
        let foot = [0.22 * x - 0.16, 0.22 * x + 0.16];
        s.cuboid(&named("Foot"), [foot[0], -0.34, 0.0], [foot[1], 0.18, 0.16], DARK);
    }
    s
}

/// A house of two rooms under a gable roof, all walls of two triangles.
pub(super) fn house() -> Shapes {
    let mut s = Shapes::default();
    s.wall("Ground", [-12.0, -12.0, -0.02], [24.0, 0.0, 0.0], [0.0, 24.0, 0.0], GRASS);
    s.wall("Floor", [-5.0, -2.5, 0.0], [10.0, 0.0, 0.0], [0.0, 5.0, 0.0], WOOD);
    s.wall("Ceiling", [-5.0, -2.5, 2.7], [0.0, 5.0, 0.0], [10.0, 0.0, 0.0], WHITE);
    s.wall("North", [-5.0, 2.5, 0.0], [10.0, 0.0, 0.0], [0.0, 0.0, 2.7], WHITE);
    s.wall_with_window([-5.0, 0.0], -2.5, [-4.0, -1.0, 0.3, 2.3], 2.7);
    s.wall_with_window([0.0, 5.0], -2.5, [1.5, 3.5, 0.9, 2.1], 2.7);
    s.wall("West", [-5.0, -2.5, 0.0], [0.0, 5.0, 0.0], [0.0, 0.0, 2.7], RED);
    s.wall("East", [5.0, -2.5, 0.0], [0.0, 0.0, 2.7], [0.0, 5.0, 0.0], WHITE);
    s.wall("Middle.1", [0.0, -2.5, 0.0], [0.0, 3.4, 0.0], [0.0, 0.0, 2.7], WHITE);
    s.wall("Middle.2", [0.0, 1.9, 0.0], [0.0, 0.6, 0.0], [0.0, 0.0, 2.7], WHITE);
    s.wall("Middle.3", [0.0, 0.9, 2.1], [0.0, 1.0, 0.0], [0.0, 0.0, 0.6], WHITE);
    s.wall("Roof.1", [-5.5, -3.0, 2.6], [11.0, 0.0, 0.0], [0.0, 3.0, 1.6], RED);
    s.wall("Roof.2", [-5.5, 3.0, 2.6], [0.0, -3.0, 1.6], [11.0, 0.0, 0.0], RED);
    s.cuboid("Sofa.1", [-4.6, 1.5, 0.1], [-2.2, 2.4, 0.45], BLUE);
    s.cuboid("Sofa.2", [-4.6, 2.1, 0.4], [-2.2, 2.45, 0.9], BLUE);
    s.cuboid("Table", [-3.6, -0.1, 0.36], [-2.2, 0.7, 0.42], WOOD);
    for (k, [x, y]) in [[-3.5, 0.0], [-2.3, 0.0], [-3.5, 0.6], [-2.3, 0.6]].into_iter().enumerate() {
        s.cuboid(&format!("Table leg.{k}"), [x - 0.04, y - 0.04, 0.0], [x + 0.04, y + 0.04, 0.38], WOOD);
    }
    s.cuboid("Cupboard", [-1.4, 1.9, 0.0], [-0.4, 2.48, 1.6], WHITE);
    s.ball("Vase", [-2.9, 0.3, 0.62], [0.2; 3], [24, 12], WHITE);
    s
}

/// A room whose walls are boxes of twelve single-sided triangles, which overlap in the corners.
pub(super) fn room_of_boxes() -> Shapes {
    /// The thickness of the walls.
    const T: f64 = 0.2;
    let (mut s, far, top) = (Shapes::default(), 2.0 + T, 2.4 + T);
    s.cuboid("Floor", [-far, -far, -T], [far, far, 0.0], WHITE);
    s.cuboid("Ceiling", [-far, -far, 2.4], [far, far, top], WHITE);
    s.cuboid("Wall.001", [-far, -far, -T], [-2.0, far, top], RED);
    s.cuboid("Wall.002", [2.0, -far, -T], [far, far, top], GREEN);
    s.cuboid("Wall.003", [-far, 2.0, -T], [far, far, top], WHITE);
    s.cuboid("Front.1", [-far, -far, -T], [far, -2.0, 0.6], WHITE);
    s.cuboid("Front.2", [-far, -far, 2.1], [far, -2.0, top], WHITE);
    s.cuboid("Front.3", [-far, -far, -T], [-1.6, -2.0, top], WHITE);
    s.cuboid("Front.4", [1.6, -far, -T], [far, -2.0, top], WHITE);
    s.block("Chest", [[-0.4, -0.4, -0.05], [0.4, 0.4, 0.7]], (Z, 30.0), [-0.6, 0.5, 0.0], WHITE);
    s.block("Block", [[-0.3, -0.3, 0.0], [0.3, 0.3, 1.2]], (Z, -20.0), [0.8, 1.0, 0.0], BLUE);
    s
}

/// Rods that go through a block.
pub(super) fn rods() -> Shapes {
    let mut s = Shapes::default();
    s.cuboid("Block", [-0.6; 3], [0.6; 3], WHITE);
    let rods = [
        ([1.0, 0.2, 0.1], 0.12, RED),
        ([0.1, 1.0, 0.3], 0.1, GREEN),
        ([-0.2, 0.3, 1.0], 0.15, BLUE),
        ([1.0, 1.0, 0.6], 0.08, WOOD),
        ([-1.0, 0.8, 0.5], 0.08, RED),
    ];
    for (k, (direction, radius, color)) in rods.into_iter().enumerate() {
        let end = scaled(normalized(direction), 1.5);
        s.rod(&format!("Rod.{k}"), [scaled(end, -1.0), end], radius, 12, color);
    }
    s
}

/// A ball and a block on a plate.
pub(super) fn plate() -> Shapes {
    let mut s = Shapes::default();
    s.cuboid("Plate", [-2.0, -2.0, -0.1], [2.0, 2.0, 0.0], WHITE);
    s.ball("Ball", add([-0.6, -0.2, 0.0], [0.0, 0.0, 0.5]), [0.5; 3], [32, 16], RED);
    s.block("Block", [[-0.4, -0.4, 0.0], [0.4, 0.4, 0.7]], (Z, 25.0), [0.7, 0.3, 0.0], BLUE);
    s
}
