//! The parts of a moving scene as a user takes them by the hand: where they are at first, and where hands put them.

use lobe::motion::{Moment, Motion, MovingPart, MovingScene};
use lobe::render::RenderError;
use lobe::scene::{Mesh, Scene};
use lobe::sh::sphere::vector::{length, sub};
use lobe::sh::{Dir, Rotation};
use lobe::shadow::{Placement, Track};
use serde::{Deserialize, Serialize};

/// Where a user has put a part.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Hand {
    pub(crate) position: [f64; 3],
    /// About +z, in radians, after the turn that it has at first.
    pub(crate) turn: f64,
    /// Its size over that which it has at first.
    pub(crate) scale: f64,
}

/// The parts of the scene.
#[derive(Clone, Debug)]
pub(crate) struct Cast {
    pub(crate) names: Vec<String>,
    /// Which stand still.
    pub(crate) is_still: Vec<bool>,
    /// The places of their own frames at first.
    pub(crate) rest: Vec<Placement>,
    /// The same, as hands have them.
    pub(crate) hands: Vec<Hand>,
    /// About how far each reaches from its middle.
    pub(crate) radii: Vec<f64>,
    /// Whether all can be moved by hand: none changes its shape.
    pub(crate) is_rigid: bool,
    /// Whether its transfer leaves suns to be lit by themselves.
    pub(crate) parts_suns: bool,
    /// The first and the last time, in seconds.
    pub(crate) span: [f64; 2],
    /// The most bands that its parts can have: those that came with transfer or a field have theirs.
    pub(crate) most_order: usize,
}

/// The parts of a scene at its first time.
pub(crate) fn cast(scene: &MovingScene, most_order: usize) -> Result<Cast, RenderError> {
    let span = scene.span();
    let moment = scene.at(span[0])?;
    let (mut rest, mut radii, mut first) = (Vec::new(), Vec::new(), 0);
    let world: Vec<[f64; 3]> = positions(moment.scene());
    for (number, part) in scene.parts().iter().enumerate() {
        let count: usize = part.scene.meshes().iter().map(|mesh| mesh.positions().len()).sum();
        let there = &world[first..first + count];
        first += count;
        let middle = mean(there);
        radii.push(there.iter().map(|p| length(sub(*p, middle))).fold(0.0, f64::max));
        rest.push(place_of(&moment, number));
    }
    let hand = |place: &Placement| Hand { position: place.translation(), turn: 0.0, scale: 1.0 };
    Ok(Cast {
        names: scene.parts().iter().map(|part| part.name.clone()).collect(),
        is_still: scene.parts().iter().map(|part| matches!(part.motion, Motion::Still)).collect(),
        is_rigid: scene.parts().iter().all(MovingPart::is_rigid),
        hands: rest.iter().map(hand).collect(),
        rest,
        radii,
        parts_suns: false,
        span,
        most_order,
    })
}

/// Parts are this small, or smaller, where an animation says that they have no size: `lobe_render` takes 1e-12 for 0.
const LEAST_SIZE: f64 = 1e-9;

/// The same parts where a user has put them, turned and scaled beside how they were at first, under the same lamps.
pub(crate) fn placed(scene: &MovingScene, rest: &[Placement], hands: &[Hand]) -> Result<MovingScene, RenderError> {
    let part = |((part, rest), hand): ((&MovingPart, &Placement), &Hand)| {
        let mut part = part.clone();
        if !matches!(part.motion, Motion::Still) {
            let turn = rest.rotation().then(Rotation::from_axis_angle(Dir::Z, hand.turn));
            // What comes out of nothing is as large as its triangles say.
            let size = if rest.scale() < LEAST_SIZE { 1.0 } else { rest.scale() };
            let place = Placement::new(hand.position, turn, size * hand.scale);
            part.motion = Motion::Track(Track::resting(place));
        }
        part
    };
    let parts = scene.parts().iter().zip(rest).zip(hands).map(part).collect();
    Ok(MovingScene::new(parts)?.with_lamps(scene.lamps().to_vec()))
}

/// The place of a part's own frame. That of its vertices counts from the origin of its triangles.
fn place_of(moment: &Moment<'_>, part: usize) -> Placement {
    let (frame, origin) = (moment.receivers_of(part).frame, moment.parts()[part].scene.origin());
    let (rotation, scale) = (*frame.rotation(), frame.scale());
    let turned = Placement::new([0.0; 3], rotation, scale).to_world(origin);
    Placement::new(sub(frame.translation(), turned), rotation, scale)
}

/// All vertices of a scene in the world.
fn positions(scene: &Scene) -> Vec<[f64; 3]> {
    let origin = scene.origin();
    let world = |p: &[f32; 3]| std::array::from_fn(|k| f64::from(p[k]) + origin[k]);
    scene.meshes().iter().flat_map(Mesh::positions).map(world).collect()
}

fn mean(points: &[[f64; 3]]) -> [f64; 3] {
    std::array::from_fn(|k| points.iter().map(|p| p[k]).sum::<f64>() / points.len().max(1) as f64)
}

#[cfg(test)]
mod tests {
    use lobe::motion::MovingLamp;
    use lobe::scene::built_in;
    use lobe::sh::Rgb;
    use lobe::shadow::LampSurface;

    use super::*;

    /// A ball far from the middle of its own frame, which a track has turned, enlarged and moved, under a lamp.
    fn turned() -> MovingScene {
        let place = Placement::new([1.0, -2.0, 3.0], Rotation::from_euler_zyz(0.4, 1.1, -2.0), 2.5);
        let scene = built_in::ball_over_ground(8).moved([1e5, 2e5, -3e4]);
        let ball = MovingPart::new("ball", scene, Motion::Track(Track::resting(place)));
        let surface = LampSurface::ball(0.1, Rgb::new(1.0, 2.0, 3.0));
        let lamp = MovingLamp::shaped("lamp", surface, Track::resting(Placement::IDENTITY));
        MovingScene::new(vec![ball]).unwrap().with_lamps(vec![lamp])
    }

    #[test]
    fn parts_that_are_taken_by_the_hand_stay_as_they_were_and_so_do_lamps() {
        for scene in [turned(), MovingScene::animated(built_in::three_objects(8), Some(0)).unwrap()] {
            let known = cast(&scene, 4).unwrap();
            let by_hand = placed(&scene, &known.rest, &known.hands).unwrap();
            let [time, _] = scene.span();
            let [found, expected] = [&by_hand, &scene].map(|scene| positions(scene.at(time).unwrap().scene()));
            assert_eq!(found.len(), expected.len(), "as many vertices");
            let size = expected.iter().map(|p| length(sub(*p, expected[0]))).fold(0.0, f64::max);
            let apart = found.iter().zip(&expected).map(|(a, b)| length(sub(*a, *b))).fold(0.0, f64::max);
            assert!(apart < 1e-6 * size, "{apart} apart, of {size}");
            assert_eq!(by_hand.lamps().len(), scene.lamps().len(), "the lamps");
        }
    }

    #[test]
    fn hands_turn_and_scale_what_was_turned_and_scaled() {
        let scene = turned();
        let mut known = cast(&scene, 4).unwrap();
        (known.hands[0].turn, known.hands[0].scale) = (0.5, 2.0);
        let by_hand = placed(&scene, &known.rest, &known.hands).unwrap();
        let found = place_of(&by_hand.at(0.0).unwrap(), 0);
        let expected = Rotation::from_euler_zyz(0.4, 1.1, -2.0).then(Rotation::from_axis_angle(Dir::Z, 0.5));
        let angle = found.rotation().rotate_dir(Dir::X).angle_to(expected.rotate_dir(Dir::X));
        assert!(angle < 1e-7 && (found.scale() - 5.0).abs() < 1e-12, "{angle} and {}", found.scale());
    }
}
