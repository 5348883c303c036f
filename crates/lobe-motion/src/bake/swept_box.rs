//! The box that the moving parts of a scene sweep.

use std::f64::consts::PI;

use lobe_scene::{AnimatedScene, Mesh};
use lobe_shadow::{Placement, Track};

use crate::scene::moving_part::{Motion, MovingPart};
use crate::scene::moving_scene::MovingScene;
use lobe_render::RenderError;

/// Parts of an arc along which a track turns: its points are then within `1 - cos 2.5°`, a thousandth of the radius, of
/// the box of the ends of these parts. Grids reach as much farther.
const ARC: f64 = PI / 36.0;

/// Parts of equal time of an animation, at each of which it is looked at, and once between any two keys that are
/// closer.
const PARTS: f64 = 256.0;

/// Vertices that are posed in all, so that files of many keys and vertices take seconds: then as many times as that
/// allows are taken of those that there are, in golden steps, which fall in with no rhythm.
const MOST_POSED: usize = 1 << 28;

/// The box of all parts that move, over all of the scene's [span](MovingScene::span); none if nothing moves.
///
/// What a track carries is linear in time between its keys, but for arcs. An animation is looked at over one period, at
/// all of its keys and between them, and where a track carries it, in its own frame: its box there is carried as a
/// whole, whatever part of the period meets whatever place of the track. So no rhythm of an animation that begins anew
/// falls between the times.
pub(crate) fn swept_box(scene: &MovingScene) -> Result<Option<[[f64; 3]; 2]>, RenderError> {
    let mut swept = Swept(None);
    for part in scene.parts() {
        if let Motion::Track(track) = &part.motion {
            swept.add_carried(part.scene.world_bounds(), track);
        }
    }
    if let Some((animated, animation)) = scene.animation() {
        swept.add_animated(scene.parts(), animated, animation)?;
    }
    for carried in scene.all_carried() {
        let mut own = Swept(None);
        own.add_animated(&scene.parts()[carried.parts.clone()], &carried.scene, carried.animation)?;
        own.0.into_iter().for_each(|own| swept.add_carried(own, &carried.track));
    }
    Ok(swept.0)
}

fn corners([min, max]: [[f64; 3]; 2]) -> [[f64; 3]; 8] {
    std::array::from_fn(|corner| std::array::from_fn(|k| if corner >> k & 1 == 1 { max[k] } else { min[k] }))
}

/// The keys of a track, and times between two that turn.
fn times_of_track(track: &Track) -> Vec<f64> {
    let keys = track.keys();
    let mut times: Vec<f64> = keys.iter().map(|key| key.time).collect();
    for pair in keys.windows(2) {
        let [a, b] = [0, 1].map(|k| pair[k].placement.rotation().to_quaternion());
        let cos: f64 = (0..4).map(|k| a[k] * b[k]).sum();
        let angle = 2.0 * cos.abs().min(1.0).acos();
        times.extend(between(pair[0].time, pair[1].time, (angle / ARC).ceil() as usize));
    }
    times
}

/// The keys of an animation, and times between them; at most `most`, but one.
fn times_of_animation(keys: &[f64], most: usize) -> Vec<f64> {
    let mut times = keys.to_vec();
    if let [begin, .., end] = keys {
        // However many keys there are, what turns for long between two of them is looked at as often as if it were
        // alone.
        let parts = |pair: &[f64]| (PARTS * (pair[1] - pair[0]) / (end - begin)).ceil().max(2.0) as usize;
        keys.windows(2).for_each(|pair| times.extend(between(pair[0], pair[1], parts(pair))));
    }
    if times.len() > most.max(1) {
        times.sort_unstable_by(f64::total_cmp);
        let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
        let place = |k: usize| (k as f64 * golden).fract() * times.len() as f64;
        return (0..most.max(1)).map(|k| times[place(k) as usize]).collect();
    }
    times
}

/// The times that part the one between two into equal parts.
fn between(begin: f64, end: f64, parts: usize) -> impl Iterator<Item = f64> {
    (1..parts).map(move |k| k as f64 / parts as f64).map(move |t| (1.0 - t) * begin + t * end)
}

struct Swept(Option<[[f64; 3]; 2]>);

impl Swept {
    fn add(&mut self, p: [f64; 3]) {
        let [min, max] = self.0.get_or_insert([p, p]);
        for k in 0..3 {
            min[k] = min[k].min(p[k]);
            max[k] = max[k].max(p[k]);
        }
    }

    /// Adds a box that a track carries.
    fn add_carried(&mut self, own: [[f64; 3]; 2], track: &Track) {
        let corners = corners(own);
        for time in times_of_track(track) {
            let by: Placement = track.at(time);
            corners.iter().for_each(|corner| self.add(by.to_world(*corner)));
        }
    }

    /// Adds the parts that an animation moves, over all of its period.
    fn add_animated(
        &mut self,
        parts: &[MovingPart],
        animated: &AnimatedScene,
        animation: usize,
    ) -> Result<(), RenderError> {
        let entities: Vec<_> = parts.iter().filter_map(MovingPart::entity).collect();
        if entities.is_empty() {
            return Ok(());
        }
        let keys = animated.animations()[animation].key_times();
        for time in times_of_animation(&keys, MOST_POSED / animated.rest().vertex_count().max(1)) {
            let posed = animated.pose(animation, time)?;
            let (meshes, origin) = (posed.scene().meshes(), posed.scene().origin());
            for p in entities.iter().flat_map(|entity| meshes[entity.meshes()].iter().flat_map(Mesh::positions)) {
                self.add(std::array::from_fn(|k| f64::from(p[k]) + origin[k]));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use lobe_scene::built_in;
    use lobe_sh::{Dir, Rotation};
    use lobe_shadow::Key;

    use super::*;

    fn key(time: f64, x: f64, angle: f64) -> Key {
        Key { time, placement: Placement::new([x, 0.0, 0.0], Rotation::from_axis_angle(Dir::X, angle), 1.0) }
    }

    /// The farthest that the moving parts are outside of a box at any of many times, in parts of its diagonal.
    fn farthest_outside(scene: &MovingScene, [min, max]: [[f64; 3]; 2]) -> f64 {
        let [begin, end] = scene.span();
        let mut farthest = 0.0_f64;
        // A prime number of parts, so that times fall together with no key but the first and the last.
        for time in between(begin, end, 1999) {
            let (all, placed) = scene.placed_at(time).unwrap();
            let origin = all.origin();
            let counts = placed.iter().map(|part| part.surface.positions.len());
            let is_moving = scene.parts().iter().map(|part| !matches!(part.motion, Motion::Still));
            let is_moving = counts.zip(is_moving).flat_map(|(count, is_moving)| std::iter::repeat_n(is_moving, count));
            let positions = all.meshes().iter().flat_map(Mesh::positions);
            for (p, _) in positions.zip(is_moving).filter(|(_, is_moving)| *is_moving) {
                for k in 0..3 {
                    let p = f64::from(p[k]) + origin[k];
                    farthest = farthest.max(min[k] - p).max(p - max[k]);
                }
            }
        }
        farthest / (0..3).map(|k| (max[k] - min[k]).powi(2)).sum::<f64>().sqrt()
    }

    #[test]
    fn the_rhythm_of_a_looped_animation_never_falls_between_the_times() {
        let animated = || built_in::three_objects(8);
        let period = animated().animations()[0].duration();
        // Even parts of the track would meet the same pose again and again.
        for periods in [32.0, 64.0, 128.0, 256.0] {
            let mut scene = MovingScene::without_parts();
            let track = Track::new(vec![key(0.0, 0.0, 0.0), key(periods * period, 0.0, 0.0)]).unwrap();
            scene.add_animated("objects", (animated(), 0, true), None, track).unwrap();
            let swept = swept_box(&scene).unwrap().unwrap();
            let outside = farthest_outside(&scene, swept);
            assert!(outside < 1e-3, "{periods} periods: {outside} of the diagonal outside of {swept:?}");
        }
    }

    #[test]
    fn a_turn_between_two_keys_that_are_close_is_in_the_box() {
        let ball = built_in::ball_over_ground(16).part([1]).unwrap();
        let keys = vec![key(0.0, 0.0, 0.0), key(50.1, 0.0, 0.0), key(50.9, 3.0, 0.95 * PI), key(100.0, 3.0, 0.95 * PI)];
        let motion = Motion::Track(Track::new(keys).unwrap());
        let scene = MovingScene::new(vec![MovingPart::new("ball", ball, motion)]).unwrap();
        let swept = swept_box(&scene).unwrap().unwrap();
        let outside = farthest_outside(&scene, swept);
        assert!(outside < 1e-3, "{outside} of the diagonal outside of {swept:?}");
    }

    #[test]
    fn all_keys_of_an_animation_are_among_the_times_unless_they_are_too_many() {
        let keys: Vec<f64> = (0..1000).map(|k| 0.1 * f64::from(k)).collect();
        let times = times_of_animation(&keys, 1 << 20);
        assert!(keys.iter().all(|key| times.contains(key)), "{} times", times.len());
        let two = times_of_animation(&[0.0, 1.0], 1 << 20);
        assert!(two.len() as f64 > PARTS, "{} times between two keys", two.len());
        let mut last = keys.clone();
        last.push(2.0 * keys[999]);
        let between = times_of_animation(&last, 1 << 20).into_iter().filter(|time| *time > keys[999]).count();
        assert!(between as f64 > 0.49 * PARTS, "{between} times in the half of the period that has no keys");
        let mut few = times_of_animation(&keys, 100);
        few.sort_unstable_by(f64::total_cmp);
        few.dedup();
        assert_eq!(few.len(), 100, "as many as are allowed, all different");
        let widest = few.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
        assert!(widest < 0.03 * keys[999], "no part is left out: {widest} of {}", keys[999]);
    }
}
