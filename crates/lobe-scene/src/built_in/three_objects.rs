//! Three objects that move over a ground.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DQuat, DVec3};

use crate::built_in::shapes::Shape;
use crate::motion::animated_scene::AnimatedScene;
use crate::motion::animation::{Animation, Channel, Property};
use crate::motion::rig::Rig;
use crate::motion::sampler::{Interpolation, Sampler};
use crate::motion::shape::Part;
use crate::scene::material::Material;
use crate::scene::transform::Trs;

/// The time after which the motion repeats, in seconds.
const PERIOD: f64 = 4.0;

/// Keys of each path: cubic splines through positions and velocities of 32 keys are off by less than 0.1 mm.
const KEYS: usize = 32;

/// Three objects that move over a ground: a ball, a cube and a ring over a square of side 8 at z = 0.
///
/// ```text
///   w = 2π t / 4 s
///   ball   radius 0.5, at (2.4 cos w, 2.4 sin w, 0.9 - 0.35 cos 2w)
///   cube   side 0.9,  at (0, 0, 1), turning about (1, 1, 1) once
///   ring   radii 0.7 and 0.2, at (0.5 sin w, 0, 2.9 + 0.2 sin 2w), turning about x once
/// ```
///
/// No two ever touch. The animation `move` takes 4 seconds and can be [looped](crate::Animation::looped). The ground has `cells` × `cells` cells
/// and is gray (0.6), the ball has `cells` vertices around and is red, the cube's faces have `cells / 3` cells along each side and
/// are green, the ring is blue.
///
/// # Panics
/// If `cells` is below 6.
#[must_use]
pub fn three_objects(cells: usize) -> AnimatedScene {
    assert!(cells >= 6, "{cells} cells, expected at least 6");
    let (mut ground, mut ball, mut cube) = (Shape::default(), Shape::default(), Shape::default());
    ground.parallelogram(DVec3::new(-4.0, -4.0, 0.0), [DVec3::X * 8.0, DVec3::Y * 8.0], (cells, cells));
    ball.ball(DVec3::ZERO, 0.5, cells);
    cube.cuboid(DVec3::splat(-0.45), DVec3::splat(0.45), [cells / 3; 3]);
    let all = [("ground", ground), ("ball", ball), ("cube", cube), ("ring", ring(cells))];
    let colors = [[0.6; 3], [0.7, 0.25, 0.2], [0.25, 0.6, 0.25], [0.25, 0.35, 0.7]];
    let materials = all.iter().zip(colors).map(|((name, _), color)| Material::matte(name, color)).collect();
    let names: Vec<_> = all.iter().map(|&(name, _)| name.to_owned()).collect();
    let own = all.into_iter().enumerate().map(|(k, (name, shape))| shape.into_mesh(name, k)).collect::<Vec<_>>();
    let channels = channels();
    let nodes = names.into_iter().enumerate().map(|(node, name)| (name, at_rest(&channels, node), None)).collect();
    let parts = own.iter().enumerate().map(|(node, mesh)| Part::rigid(mesh, node)).collect();
    let animation = Animation { name: Some("move".to_owned()), channels };
    // At rest, all objects stand where they are at time zero.
    AnimatedScene::standing(&own, materials, Rig::upright(nodes), parts, Vec::new(), vec![animation])
}

/// The paths of nodes 1, 2 and 3.
fn channels() -> Vec<Channel> {
    let speed = TAU / PERIOD;
    let ball = |t: f64| {
        let (sin, cos) = (speed * t).sin_cos();
        let (sin2, cos2) = (2.0 * speed * t).sin_cos();
        let velocity = [-2.4 * sin, 2.4 * cos, 0.7 * sin2].map(|v| v * speed);
        with_tangents([2.4 * cos, 2.4 * sin, 0.9 - 0.35 * cos2], velocity)
    };
    let cube = |_| with_tangents([0.0, 0.0, 1.0], [0.0; 3]);
    let ring = |t: f64| {
        let (sin, cos) = (speed * t).sin_cos();
        let (sin2, cos2) = (2.0 * speed * t).sin_cos();
        with_tangents([0.5 * sin, 0.0, 2.9 + 0.2 * sin2], [0.5 * speed * cos, 0.0, 0.4 * speed * cos2])
    };
    let path = |node, values: &dyn Fn(f64) -> [f64; 9]| Channel {
        node,
        property: Property::Translation,
        sampler: Sampler::of_formula((PERIOD, KEYS), Interpolation::CubicSpline, values),
    };
    // Between keys a quarter turn apart, rotations about one axis turn at constant speed.
    let turn = |node, axis: DVec3| Channel {
        node,
        property: Property::Rotation,
        sampler: Sampler::of_formula((PERIOD, 4), Interpolation::Linear, |t| {
            DQuat::from_axis_angle(axis.normalize(), 4.0 * FRAC_PI_2 * t / PERIOD).to_array()
        }),
    };
    vec![path(1, &ball), path(2, &cube), turn(2, DVec3::ONE), path(3, &ring), turn(3, DVec3::X)]
}

/// A key of a spline: the velocity, the position, and the velocity.
fn with_tangents([x, y, z]: [f64; 3], [u, v, w]: [f64; 3]) -> [f64; 9] {
    [u, v, w, x, y, z, u, v, w]
}

fn at_rest(channels: &[Channel], node: usize) -> Trs {
    let path = channels.iter().find(|channel| channel.node == node && channel.property == Property::Translation);
    Trs {
        translation: path.map_or(DVec3::ZERO, |path| DVec3::from_array(path.sampler.vector_at(0.0))),
        ..Trs::IDENTITY
    }
}

/// A ring about the z axis: `cells` vertices along it, half as many around, its vertices shared but for the seams.
fn ring(cells: usize) -> Shape {
    let mut ring = Shape::default();
    ring.surface((cells, cells / 2), |u, v| {
        let ((sin_u, cos_u), (sin_v, cos_v)) = ((TAU * u).sin_cos(), (TAU * v).sin_cos());
        let normal = DVec3::new(cos_u * cos_v, sin_u * cos_v, sin_v);
        (DVec3::new(0.7 * cos_u, 0.7 * sin_u, 0.0) + 0.2 * normal, normal)
    });
    ring
}
