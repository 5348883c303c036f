//! Texels whose places lie beyond a wall and would light its foot.
//!
//! A floor often goes on behind the wall that stands on it, outside of the room, under the open sky. A picture is shown
//! between the centers of its texels, so that those behind the wall would light its foot. Two kinds of them move:
//!
//! - A strip at the border of a chart, as narrow as a texel or two, is there for the picture's sake alone. Its places
//!   move to the side of the wall that the chart is on.
//! - A wider part is a surface of its own. The first texels behind the wall move all the same, from the side that sees
//!   much of the sky to the one that sees little: a dark line outside is hardly seen, a bright one inside is.
//!
//! Inside of a solid nobody sees anything: a place that is surrounded by the backs of surfaces moves out. Backs of
//! double-sided surfaces may be the walls of a room: they are a solid if hardly a path leads out of it.

use std::collections::HashMap;
use std::f64::consts::PI;

use glam::DVec3;
use lobe_scene::{Bvh, Hit, Ray, Scene, SurfaceRays};
use rayon::iter::{
    IndexedParallelIterator as _, IntoParallelIterator as _, ParallelExtend as _, ParallelIterator as _,
};

use crate::receivers::inset::wide;

/// The depth of texels that are of a surface of their own, whatever walls are around: two more of their chart lie
/// around them in all directions.
const DEEP: u8 = 3;

/// A wall is no part of the surface that it stands on: their normals are farther apart than the angle of this cosine.
const ALONG: f64 = 0.9;

/// Rays that tell how much of the sky a place sees: a sixteenth of it is seen by four of them.
const SKY_RAYS: usize = 64;

/// Light goes through a wall from places that see more than so many times as much of the sky. Where sides are more
/// alike, as of a wall in the open, what goes through is no more than what is there.
const BRIGHTER: usize = 2;

/// Inside of a solid so many of a hundred rays meet surfaces from behind, and none leaves.
const BACKS: usize = 75;

/// Reflections of the paths that look for a way out: doors lead from room to room.
const REFLECTIONS: usize = 16;

/// So many of [`SKY_RAYS`] paths leave a solid through cracks between its surfaces; through a small window more do.
const THROUGH_CRACKS: usize = 2;

/// Texels that one thread takes at once.
const PIECE: usize = 256;

/// What is known of a texel: the place of the surface that it shows, and whether its center is within.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shown {
    pub(crate) hit: Hit,
    pub(crate) is_inside: bool,
}

/// The texels of a picture, whose charts are known by their triangles.
pub(crate) struct Picture<'a> {
    pub(crate) width: usize,
    pub(crate) shown: &'a (dyn Fn(usize) -> Option<Shown> + Sync),
    pub(crate) charts: &'a [u32],
}

/// A point of the surface of a texel.
#[derive(Clone, Copy)]
struct Point {
    position: DVec3,
    /// Of the triangle, on the lit side.
    normal: DVec3,
}

/// The `texels` that light the foot of a wall from beyond it, by their numbers in the list, with a position that is
/// `margin` in front of it. Each texel has one of the `positions`.
pub(crate) fn moved_points(
    scene: &Scene,
    picture: &Picture<'_>,
    (texels, positions): (&[u32], &[[f32; 3]]),
    margin: f64,
) -> Vec<(usize, [f32; 3])> {
    let bvh = Bvh::new(scene);
    let mut moved = moved_strips((scene, &bvh), picture, (texels, positions), margin);
    let strips: HashMap<usize, [f32; 3]> = moved.iter().map(|&(number, p)| (texels[number] as usize, p)).collect();
    let walls = Walls { rays: SurfaceRays::new(scene, &bvh), picture, strips: &strips, margin };
    let first = |number: usize| Some((number, walls.darker_place(texels[number] as usize, positions[number])?));
    // One that has moved may still be behind another wall: its later place counts.
    moved.par_extend((0..texels.len()).into_par_iter().with_min_len(PIECE).filter_map(first));
    moved
}

/// Those in strips at the border of a chart.
fn moved_strips(
    (scene, bvh): (&Scene, &Bvh),
    picture: &Picture<'_>,
    (texels, positions): (&[u32], &[[f32; 3]]),
    margin: f64,
) -> Vec<(usize, [f32; 3])> {
    let depths = depths(picture);
    let moved = |number: usize| {
        let texel = texels[number] as usize;
        if depths[texel] == DEEP {
            return None;
        }
        let from = point(scene, &core_of(picture, &depths, texel)?);
        let to = Point { position: wide(positions[number]), ..point(scene, &(picture.shown)(texel)?.hit) };
        Some((number, in_front((scene, bvh), (from, to), margin)?))
    };
    (0..texels.len()).into_par_iter().with_min_len(PIECE).filter_map(moved).collect()
}

/// For each texel how many rings around it, itself among them, have their centers within its chart, up to [`DEEP`].
fn depths(picture: &Picture<'_>) -> Vec<u8> {
    let chart = |texel: usize| picture.chart_inside(texel);
    let mut depths: Vec<u8> =
        (0..picture.width * picture.width).map(|texel| u8::from(chart(texel).is_some())).collect();
    for depth in 1..DEEP {
        let is_deeper = |texel: usize| {
            let own = chart(texel);
            let is_own = |next: Option<usize>| next.is_some_and(|next| depths[next] >= depth && chart(next) == own);
            depths[texel] == depth && picture.around(texel, 1).all(is_own)
        };
        let deeper: Vec<usize> = (0..depths.len()).into_par_iter().filter(|&texel| is_deeper(texel)).collect();
        deeper.into_iter().for_each(|texel| depths[texel] = depth + 1);
    }
    depths
}

/// The place of the nearest texel of the same chart that is as deep in it as there are any near.
fn core_of(picture: &Picture<'_>, depths: &[u8], texel: usize) -> Option<Hit> {
    let chart = picture.chart(texel)?;
    let (x, y) = (texel % picture.width, texel / picture.width);
    let distance =
        |other: usize| (other % picture.width).abs_diff(x).pow(2) + (other / picture.width).abs_diff(y).pow(2);
    let near = picture
        .around(texel, usize::from(DEEP) + 1)
        .flatten()
        .filter(|&next| picture.chart_inside(next) == Some(chart));
    let best = near.min_by_key(|&next| (u8::MAX - depths[next], distance(next), next))?;
    (best != texel).then(|| (picture.shown)(best)).flatten().map(|shown| shown.hit)
}

/// The point that is in front of the first wall between two of one surface; none without a wall.
fn in_front((scene, bvh): (&Scene, &Bvh), (from, to): (Point, Point), margin: f64) -> Option<[f32; 3]> {
    // Between places of a surface that bends much the straight way is no way along it.
    if from.normal.dot(to.normal) < ALONG {
        return None;
    }
    let way = to.position - from.position;
    let ends = [from, to].map(|p| bvh.origin_above(p.position.as_vec3().to_array(), p.normal.as_vec3().to_array()));
    let is_wall = |hit: &Hit| {
        let is_along = point(scene, hit).normal.dot(from.normal).abs() > ALONG;
        !is_along && scene.opacity(hit) >= 1.0
    };
    let wall = bvh.closest_where(&Ray::between(ends[0], ends[1]), is_wall)?;
    let free = f64::from(wall.t) - margin / way.length();
    Some((from.position + way * free.max(0.0)).as_vec3().to_array())
}

/// What is seen from a place, of [`SKY_RAYS`].
#[derive(Clone, Copy)]
struct Sight {
    /// Rays that leave the scene.
    sky: usize,
    /// Whether it is that of a place inside of a solid.
    is_inside_a_solid: bool,
}

/// What is asked of the texels next to a wall.
struct Walls<'a> {
    rays: SurfaceRays<'a>,
    picture: &'a Picture<'a>,
    /// The texels that have moved already, with their places: their neighbors do not follow them.
    strips: &'a HashMap<usize, [f32; 3]>,
    margin: f64,
}

impl Walls<'_> {
    /// The place in front of a wall for a texel that lies behind it, as seen from a neighbor in much less light, or of
    /// any neighbor if the texel is inside a solid. Neighbors there count for nothing.
    fn darker_place(&self, texel: usize, position: [f32; 3]) -> Option<[f32; 3]> {
        let (scene, bvh) = (self.rays.scene(), self.rays.bvh());
        let chart = self.picture.chart(texel)?;
        let position = self.strips.get(&texel).copied().unwrap_or(position);
        let to = Point { position: wide(position), ..point(scene, &(self.picture.shown)(texel)?.hit) };
        let is_near = |next: &usize| self.picture.chart_inside(*next) == Some(chart) && !self.strips.contains_key(next);
        let across = |next: usize| {
            let from = point(scene, &(self.picture.shown)(next)?.hit);
            let place = in_front((scene, bvh), (from, to), self.margin)?;
            Some((self.sight(from), place)).filter(|(sight, _)| !sight.is_inside_a_solid)
        };
        let near = self.picture.around(texel, 1).flatten().filter(|&next| next != texel).filter(is_near);
        // The first of those that see as little.
        let (darkest, place) = near.filter_map(across).min_by_key(|&(sight, _)| sight.sky)?;
        let own = self.sight(to);
        (own.is_inside_a_solid || own.sky > BRIGHTER * darkest.sky).then_some(place)
    }

    /// What [`SKY_RAYS`] meet, which are as dense as what they bring to a diffuse surface.
    fn sight(&self, from: Point) -> Sight {
        let scene = self.rays.scene();
        let (mut sky, mut backs, mut single_sided) = (0, 0, 0);
        for k in 0..SKY_RAYS {
            // By this angle from one to the next, directions fill the disk below them evenly.
            let golden_angle = PI * (3.0 - 5.0_f64.sqrt());
            let direction = from.above((k as f64 + 0.5) / SKY_RAYS as f64, k as f64 * golden_angle);
            match self.closest(from, direction) {
                None => sky += 1,
                Some(hit) => {
                    let surface = scene.surface(&hit);
                    let is_behind = wide(surface.geometric_normal).dot(direction) > 0.0;
                    backs += usize::from(is_behind);
                    single_sided += usize::from(is_behind && !scene.material(surface.mesh).double_sided);
                }
            }
        }
        let is_most = |count: usize| sky == 0 && 100 * count >= BACKS * SKY_RAYS;
        let is_inside_a_solid = is_most(single_sided) || (is_most(backs) && self.has_no_way_out(from));
        Sight { sky, is_inside_a_solid }
    }

    /// Whether hardly any of [`SKY_RAYS`] paths leaves the scene.
    fn has_no_way_out(&self, from: Point) -> bool {
        let mut ways_out = (0..SKY_RAYS).filter(|&path| self.leaves(from, path));
        ways_out.nth(THROUGH_CRACKS).is_none()
    }

    /// Whether a path of [`REFLECTIONS`] leaves the scene.
    fn leaves(&self, from: Point, path: usize) -> bool {
        let mut place = from;
        for reflection in 0..=REFLECTIONS {
            let [a, b] = scattered((path * (REFLECTIONS + 1) + reflection) as u64);
            let direction = place.above(a, 2.0 * PI * b);
            let Some(hit) = self.closest(place, direction) else { return true };
            let next = point(self.rays.scene(), &hit);
            let side = if next.normal.dot(direction) > 0.0 { -1.0 } else { 1.0 };
            place = Point { normal: next.normal * side, ..next };
        }
        false
    }

    /// What a ray from a place meets.
    fn closest(&self, from: Point, direction: DVec3) -> Option<Hit> {
        let [position, above, direction] = [from.position, from.normal, direction].map(|v| v.as_vec3().to_array());
        self.rays.closest(&Ray::new(self.rays.bvh().origin_above(position, above), direction))
    }
}

impl Point {
    /// The direction above a point of the disk below it, by the square of its distance from the middle and by an angle.
    fn above(self, squared_radius: f64, angle: f64) -> DVec3 {
        let (x, y) = self.normal.any_orthonormal_pair();
        let (sin, cos) = angle.sin_cos();
        (x * cos + y * sin) * squared_radius.sqrt() + self.normal * (1.0 - squared_radius).sqrt()
    }
}

/// Two numbers from 0 to 1 that follow no pattern: in an even sequence paths would meet the same walls again.
fn scattered(number: u64) -> [f64; 2] {
    // Odd factors with as many ones as zeros spread each bit over those above it, the shifts over those below.
    let mut bits = (number + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    bits ^= bits >> 32;
    bits = bits.wrapping_mul(0xD6E8_FEB8_6659_FD93);
    bits ^= bits >> 32;
    [bits >> 32, bits & 0xFFFF_FFFF].map(|half| half as f64 / (1_u64 << 32) as f64)
}

fn point(scene: &Scene, hit: &Hit) -> Point {
    let surface = scene.surface(hit);
    let normal = wide(surface.geometric_normal);
    let side = if normal.dot(wide(surface.vertex_normal)) < 0.0 { -1.0 } else { 1.0 };
    Point { position: wide(surface.position), normal: normal * side }
}

impl Picture<'_> {
    /// The chart of the place that a texel shows.
    fn chart(&self, texel: usize) -> Option<u32> {
        (self.shown)(texel).map(|shown| self.charts[shown.hit.triangle as usize])
    }

    /// The same if the center of the texel is within it.
    fn chart_inside(&self, texel: usize) -> Option<u32> {
        (self.shown)(texel).filter(|shown| shown.is_inside).map(|shown| self.charts[shown.hit.triangle as usize])
    }

    /// The texels that are at most `steps` columns and rows away; none for each that is outside of the picture.
    fn around(&self, texel: usize, steps: usize) -> impl Iterator<Item = Option<usize>> {
        let (width, x, y) = (self.width, texel % self.width, texel / self.width);
        let inside = move |c: usize, step: usize| (c + step).checked_sub(steps).filter(|&c| c < width);
        (0..=2 * steps).flat_map(move |down| {
            (0..=2 * steps).map(move |across| Some(inside(y, down)? * width + inside(x, across)?))
        })
    }
}
