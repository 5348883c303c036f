//! A figure that walks, with a skin.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DMat4, DQuat, DVec3};

use crate::built_in::shapes::Shape;
use crate::motion::animated_scene::AnimatedScene;
use crate::motion::animation::{Animation, Channel, Property};
use crate::motion::rig::Rig;
use crate::motion::sampler::{Interpolation, Sampler};
use crate::motion::shape::Part;
use crate::motion::skin::{Influences, Skin};
use crate::scene::material::Material;
use crate::scene::transform::Trs;

/// Joints with the places where they are bound, in meters, and their parents. The right side follows the left in the same
/// order.
const JOINTS: [(&str, [f64; 3], usize); 16] = [
    ("pelvis", [0.0, 0.0, 0.95], 0),
    ("spine", [0.0, 0.0, 1.12], 0),
    ("chest", [0.0, 0.0, 1.30], 1),
    ("head", [0.0, 0.0, 1.52], 2),
    ("left thigh", [0.10, 0.0, 0.92], 0),
    ("left shin", [0.105, 0.0, 0.50], 4),
    ("left foot", [0.11, 0.0, 0.09], 5),
    ("left upper arm", [0.20, 0.0, 1.42], 2),
    ("left forearm", [0.235, 0.0, 1.13], 7),
    ("left hand", [0.25, 0.0, 0.88], 8),
    ("right thigh", [-0.10, 0.0, 0.92], 0),
    ("right shin", [-0.105, 0.0, 0.50], 10),
    ("right foot", [-0.11, 0.0, 0.09], 11),
    ("right upper arm", [-0.20, 0.0, 1.42], 2),
    ("right forearm", [-0.235, 0.0, 1.13], 13),
    ("right hand", [-0.25, 0.0, 0.88], 14),
];

/// The first joints of the legs and of the arms, left and right, with the sign of x.
const SIDES: [(usize, usize, f64); 2] = [(4, 7, 1.0), (10, 13, -1.0)];

/// The time of two steps, in seconds.
const PERIOD: f64 = 1.1;

/// Keys of the walk, at even times.
const KEYS: usize = 32;

/// Half the height over which the weights go over from one joint to the next.
const BLEND: f64 = 0.07;

/// What is cut off a foot below, so that its sole is flat.
const SOLE: f64 = 0.015;

/// A cross-section: its center, and its radii along x and y.
type Station = ([f64; 3], [f64; 2]);

/// A figure 1.75 high that walks on the spot, facing -y, over a square ground of side 4 at z = 0.
///
/// Torso with head, legs, feet and arms are swept along their joints, `around` vertices around: about 9 `around`² in all,
/// 5200 for 24. A skin of 16 joints carries them; weights go over from joint to joint smoothly, at most two at a vertex. The
/// animation `walk` takes two steps in 1.1 seconds and can be [looped](crate::Animation::looped); the lower foot
/// touches the ground at each key. With `w = 2π t / 1.1 s` for the left side and π later for the right, forward positive,
///
/// ```text
///   thigh 0.45 cos w,   knee 0.08 + 0.95 ((1 - sin(w - 0.3)) / 2)³,   foot -0.7 (thigh - knee)
///   upper arm -0.4 cos w,   elbow 0.3 - 0.15 cos w,   pelvis 0.07 cos w about z,   spine and chest back again
/// ```
///
/// # Panics
/// If `around` is below 8.
#[must_use]
pub fn walking_figure(around: usize) -> AnimatedScene {
    assert!(around >= 8, "{around} vertices around, expected at least 8");
    let mut ground = Shape::default();
    ground.parallelogram(DVec3::new(-2.0, -2.0, 0.0), [DVec3::X * 4.0, DVec3::Y * 4.0], (around, around));
    let (body, joints) = body(around);
    let influences = match Influences::new(joints.into_iter()) {
        Ok(influences) => influences,
        Err(message) => unreachable!("each vertex has a joint: {message}"),
    };
    let own = vec![ground.into_mesh("ground", 0), body.moved(|p| p).into_mesh("figure", 1)];
    let materials = vec![Material::matte("ground", [0.6; 3]), Material::matte("figure", [0.6, 0.45, 0.35])];
    let count = JOINTS.len();
    let mut nodes: Vec<_> = (0..count).map(joint_node).collect();
    nodes.extend(["ground", "figure"].map(|name| (name.to_owned(), Trs::IDENTITY, None)));
    let parts = vec![Part::rigid(&own[0], count), Part::skinned(&own[1], count + 1, influences)];
    let skin = Skin {
        name: Some("figure".to_owned()),
        joints: (0..count).collect(),
        inverse_binds: JOINTS.iter().map(|&(_, at, _)| DMat4::from_translation(-DVec3::from(at))).collect(),
    };
    let animation = Animation { name: Some("walk".to_owned()), channels: walk() };
    AnimatedScene::standing(&own, materials, Rig::upright(nodes), parts, vec![skin], vec![animation])
}

fn joint_node(joint: usize) -> (String, Trs, Option<usize>) {
    let (name, at, parent) = JOINTS[joint];
    let parent = (joint > 0).then_some(parent);
    let from = parent.map_or([0.0; 3], |parent| JOINTS[parent].1);
    (name.to_owned(), Trs { translation: DVec3::from(at) - DVec3::from(from), ..Trs::IDENTITY }, parent)
}

/// The vertices, and for each its joints with weights.
fn body(around: usize) -> (Shape, Vec<Vec<(u16, f32)>>) {
    let (mut shape, mut joints) = (Shape::default(), Vec::new());
    let torso: [Station; 9] = [
        ([0.0, -0.01, 1.70], [0.075, 0.09]),
        ([0.0, -0.01, 1.62], [0.085, 0.105]),
        ([0.0, 0.0, 1.53], [0.055, 0.06]),
        ([0.0, 0.0, 1.47], [0.06, 0.06]),
        ([0.0, 0.0, 1.42], [0.18, 0.085]),
        ([0.0, 0.0, 1.28], [0.165, 0.11]),
        ([0.0, 0.0, 1.10], [0.13, 0.095]),
        ([0.0, 0.0, 0.97], [0.165, 0.11]),
        ([0.0, 0.0, 0.88], [0.14, 0.10]),
    ];
    sweep((&mut shape, &mut joints), &torso, (around, 2 * around), |p| {
        chain(p.z, [0, 1, 2, 3], [1.12, 1.30, 1.52], true)
    });
    for (leg, arm, side) in SIDES {
        let at = |x: f64, z: f64, r: f64| ([side * x, 0.0, z], [r, r]);
        let stations = [at(0.10, 0.90, 0.085), at(0.102, 0.75, 0.08), at(0.105, 0.50, 0.055), at(0.108, 0.36, 0.055)];
        let stations = [&stations[..], &[at(0.11, 0.12, 0.037), at(0.11, 0.09, 0.037)]].concat();
        let ([hip, knee, ankle], [shoulder, elbow, wrist]) = ([leg, leg + 1, leg + 2], [arm, arm + 1, arm + 2]);
        let of_leg = |p: DVec3| chain(p.z, [0, hip, knee, ankle], [0.92, 0.50, 0.09], false);
        sweep((&mut shape, &mut joints), &stations, (around, 3 * around / 2), of_leg);
        let stations = [at(0.20, 1.41, 0.055), at(0.215, 1.29, 0.046), at(0.235, 1.13, 0.037), at(0.245, 0.98, 0.034)];
        let hand = [at(0.25, 0.89, 0.026), ([side * 0.25, 0.0, 0.82], [0.022, 0.045]), at(0.25, 0.73, 0.015)];
        let of_arm = |p: DVec3| chain(p.z, [2, shoulder, elbow, wrist], [1.42, 1.13, 0.88], false);
        sweep((&mut shape, &mut joints), &[&stations[..], &hand].concat(), (around, 3 * around / 2), of_arm);
        foot((&mut shape, &mut joints), side * 0.11, (around, around / 2), ankle);
    }
    (shape, joints)
}

/// The weights of a chain of four joints at a height, going over at three heights; a chain may run up or down.
fn chain(z: f64, joints: [usize; 4], heights: [f64; 3], is_up: bool) -> Vec<(u16, f32)> {
    let sign = if is_up { 1.0 } else { -1.0 };
    // The part of each joint and all after it.
    let smooth = |t: f64| t * t * (3.0 - 2.0 * t);
    let beyond = heights.map(|height| smooth((0.5 + sign * (z - height) / (2.0 * BLEND)).clamp(0.0, 1.0)));
    let parts = [1.0 - beyond[0], beyond[0] - beyond[1], beyond[1] - beyond[2], beyond[2]];
    joints
        .into_iter()
        .zip(parts)
        .filter(|&(_, part)| part > 0.0)
        .map(|(joint, part)| (joint as u16, part as f32))
        .collect()
}

/// A limb through cross-sections from top to bottom, rounded at both ends.
fn sweep(
    (shape, joints): (&mut Shape, &mut Vec<Vec<(u16, f32)>>),
    stations: &[Station],
    (around, bands): (usize, usize),
    weights: impl Fn(DVec3) -> Vec<(u16, f32)>,
) {
    // Ends are half ellipsoids of an eighth of the rings each.
    let end = bands / 8;
    let ring = |j: usize| {
        let (inner, turn) = match j {
            _ if j < end => (0.0, 1.0 - j as f64 / end as f64),
            _ if j > bands - end => (1.0, 1.0 - (bands - j) as f64 / end as f64),
            _ => ((j - end) as f64 / (bands - 2 * end) as f64, 0.0),
        };
        let (center, radii) = station(stations, inner);
        let (sin, cos) = (FRAC_PI_2 * turn).sin_cos();
        let out = if inner < 0.5 { 1.0 } else { -1.0 };
        (center + DVec3::Z * (out * sin * 0.5 * (radii[0] + radii[1])), radii.map(|r| r * cos))
    };
    let at = |j: usize, i: usize| {
        let (center, radii) = ring(j);
        let (sin, cos) = (TAU * i as f64 / around as f64).sin_cos();
        let radii = if j == 0 || j == bands { [0.0; 2] } else { radii };
        (center + DVec3::new(radii[0] * cos, radii[1] * sin, 0.0), DVec3::Z)
    };
    shape.closed((around, bands), at);
    let all = [(0, 0)].into_iter().chain((1..bands).flat_map(|j| (0..around).map(move |i| (j, i)))).chain([(bands, 0)]);
    joints.extend(all.map(|(j, i)| weights(at(j, i).0)));
}

/// The cross-section at a part of the height, along a smooth curve through all.
fn station(stations: &[Station], part: f64) -> (DVec3, [f64; 2]) {
    let last = stations.len() - 1;
    let (top, bottom) = (stations[0].0[2], stations[last].0[2]);
    let z = top + part * (bottom - top);
    let k = (1..last).find(|&k| stations[k].0[2] <= z).unwrap_or(last);
    let ((from, r0), (to, r1)) = (stations[k - 1], stations[k]);
    let t = ((from[2] - z) / (from[2] - to[2])).clamp(0.0, 1.0);
    let smooth = t * t * (3.0 - 2.0 * t);
    let mix = |a: f64, b: f64| a + smooth * (b - a);
    (DVec3::new(mix(from[0], to[0]), mix(from[1], to[1]), z), [mix(r0[0], r1[0]), mix(r0[1], r1[1])])
}

/// A foot from heel to toe with a flat sole at z = 0.
fn foot(
    (shape, joints): (&mut Shape, &mut Vec<Vec<(u16, f32)>>),
    x: f64,
    (around, bands): (usize, usize),
    joint: usize,
) {
    let at = |j: usize, i: usize| {
        let t = PI * j as f64 / bands as f64;
        // Along y from 0.07 to -0.19; the instep is higher than the toes.
        let (y, part) = (-0.06 + 0.13 * t.cos(), if j == 0 || j == bands { 0.0 } else { t.sin().sqrt() });
        let height = 0.035 + 0.03 * (0.5 + 0.5 * t.cos());
        let (sin, cos) = (TAU * i as f64 / around as f64).sin_cos();
        let z = (height * (1.0 + part * cos) - SOLE).max(0.0);
        // Counter-clockwise seen from the heel: z, then x.
        (DVec3::new(x + 0.045 * part * sin, y, z), DVec3::Z)
    };
    shape.closed((around, bands), at);
    let count = 2 + around * (bands - 1);
    joints.extend(std::iter::repeat_n(vec![(joint as u16, 1.0)], count));
}

/// The rotation of each joint about x, forward positive, and about z, at a part of the period.
fn angles(t: f64) -> [[f64; 2]; 16] {
    let mut all = [[0.0; 2]; 16];
    let w = TAU * t / PERIOD;
    let yaw = 0.07 * w.cos();
    (all[0][1], all[1][1], all[2][1]) = (yaw, -yaw, -yaw);
    all[3][1] = yaw;
    for (side, (leg, arm, _)) in SIDES.into_iter().enumerate() {
        let w = w + PI * side as f64;
        let (thigh, knee) = (0.45 * w.cos(), 0.08 + 0.95 * (0.5 - 0.5 * (w - 0.3).sin()).powi(3));
        (all[leg][0], all[leg + 1][0], all[leg + 2][0]) = (thigh, -knee, -0.7 * (thigh - knee));
        (all[arm][0], all[arm + 1][0]) = (-0.4 * w.cos(), 0.3 - 0.15 * w.cos());
    }
    all
}

/// A leg that hangs down swings to -y when it turns about x by a negative angle.
fn rotation([forward, yaw]: [f64; 2]) -> DQuat {
    DQuat::from_rotation_z(yaw) * DQuat::from_rotation_x(-forward)
}

/// How far the pelvis is lowered so that the lower foot stands on the ground.
fn drop_of_pelvis(t: f64) -> f64 {
    let angles = angles(t);
    let mut places = [DMat4::IDENTITY; 16];
    for joint in 0..JOINTS.len() {
        let (_, trs, parent) = joint_node(joint);
        let own = Trs { rotation: rotation(angles[joint]), ..trs }.matrix();
        places[joint] = parent.map_or(DMat4::IDENTITY, |parent| places[parent]) * own;
    }
    let soles = SIDES.iter().flat_map(|&(leg, _, side)| {
        let foot = leg + 2;
        let bound = DVec3::from(JOINTS[foot].1);
        // Under the heel and under the toes, where the sole of `foot` is flat.
        [0.03, -0.15].map(|y| places[foot].transform_point3(DVec3::new(side * 0.11, y, 0.0) - bound).z)
    });
    soles.fold(f64::INFINITY, f64::min)
}

fn walk() -> Vec<Channel> {
    let timing = (PERIOD, KEYS);
    let turn = |joint: usize| Channel {
        node: joint,
        property: Property::Rotation,
        sampler: Sampler::of_formula(timing, Interpolation::Linear, |t| rotation(angles(t)[joint]).to_array()),
    };
    let [x, y, z] = JOINTS[0].1;
    let height = Channel {
        node: 0,
        property: Property::Translation,
        sampler: Sampler::of_formula(timing, Interpolation::Linear, |t| [x, y, z - drop_of_pelvis(t)]),
    };
    (0..JOINTS.len()).map(turn).chain([height]).collect()
}
