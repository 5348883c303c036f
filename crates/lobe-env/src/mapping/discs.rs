//! Round pictures: the sphere on one disc, or on two beside each other, by an azimuthal projection.

use lobe_sh::Dir;

use crate::mapping::azimuthal::{self, Frame, Profile, Rect};
use crate::mapping::form::{Form, Obstacle, Pair, Rule};
use crate::mapping::taps::{Taps, for_each_corner};

/// The distance outside the unit disc within which a point still counts as on its rim: the rounding of `|p|²`.
const RIM_ROUNDING: f64 = 1e-14;

/// A mapping to discs that fill the picture.
pub(crate) struct Discs {
    pub(crate) name: &'static str,
    pub(crate) description: &'static str,
    pub(crate) profile: Profile,
    /// The frame of each disc, from the left.
    pub(crate) frames: &'static [Frame],
    /// The point at which the picture goes on across the rim at a point, both on unit discs: on the other disc, if there are two.
    pub(crate) across: fn([f64; 2]) -> [f64; 2],
    pub(crate) axes_again: &'static [(&'static str, [f64; 2])],
}

/// Across the rim of a disc that shows all of the sphere: the opposite point.
pub(crate) fn opposite(p: [f64; 2]) -> [f64; 2] {
    p.map(|c| -c)
}

impl Discs {
    /// The point of a disc of a texel's edges, for each disc with a part of it.
    fn rects(&self, [width, height]: Pair, [x, y]: Pair) -> impl Iterator<Item = (&Frame, Rect)> {
        assert!(x < width && y < height, "no texel ({x}, {y}) in a picture of {width} x {height}");
        let discs = self.frames.len();
        let down = move |j: usize| (2 * j) as f64 / height as f64 - 1.0;
        self.frames.iter().enumerate().filter_map(move |(k, frame)| {
            let across = |i: usize| ((2 * discs * i) as f64 / width as f64 - (2 * k + 1) as f64).clamp(-1.0, 1.0);
            let (x0, x1) = (across(x), across(x + 1));
            (x0 < x1).then(|| (frame, Rect { x: [x0, x1], y: [down(y), down(y + 1)] }))
        })
    }

    /// The disc of a point of the picture, and the point in its plane.
    fn on_plane(&self, u: f64, v: f64) -> (usize, [f64; 2]) {
        let discs = self.frames.len() as f64;
        let k = ((discs * u) as usize).min(self.frames.len() - 1);
        (k, [2.0 * discs * u - (2 * k + 1) as f64, 2.0 * v - 1.0])
    }

    /// The disc of a direction, and the cosine of the angle to its center.
    fn nearest(&self, s: Dir) -> (usize, f64) {
        let cos = |frame: &Frame| frame.center[0] * s.x() + frame.center[1] * s.y() + frame.center[2] * s.z();
        let first = (0, cos(&self.frames[0]));
        let rest = self.frames.iter().enumerate().skip(1);
        rest.fold(first, |best, (k, frame)| if cos(frame) > best.1 { (k, cos(frame)) } else { best })
    }

    /// The taps of point `p` of a disc, among those of the four texels around it that touch the disc.
    fn add_taps(&self, [width, height]: Pair, k: usize, p: [f64; 2], share: f64, taps: &mut Taps) {
        let discs = self.frames.len();
        let side = width as f64 / discs as f64;
        let (start, columns) = (k as f64 * side, k * width / discs..((k + 1) * width).div_ceil(discs));
        let corner = [start + 0.5 * (p[0] + 1.0) * side, 0.5 * (p[1] + 1.0) * height as f64];
        let nearest = |i: f64, start: f64, n: f64| {
            let edge = |i: f64| 2.0 * (i - start) / n - 1.0;
            0.0_f64.clamp(edge(i), edge(i + 1.0))
        };
        let mut own = Taps::NONE;
        for_each_corner(corner, |x, y, weight| {
            let exists = x >= columns.start as isize && x < columns.end as isize && (0..height as isize).contains(&y);
            let shown = nearest(x as f64, start, side).hypot(nearest(y as f64, 0.0, height as f64)) < 1.0;
            if exists && shown {
                own.push(y as usize * width + x as usize, weight);
            }
        });
        let sum: f32 = own.iter().map(|(_, weight)| weight).sum();
        for (index, weight) in own.iter() {
            taps.push(index, weight * (share as f32 / sum));
        }
    }
}

impl Form for Discs {
    fn name(&self) -> &'static str {
        self.name
    }

    fn description(&self) -> &'static str {
        self.description
    }

    fn dir_from_uv(&self, u: f64, v: f64) -> Option<Dir> {
        let (k, p) = self.on_plane(u, v);
        (p[0] * p[0] + p[1] * p[1] <= 1.0 + RIM_ROUNDING).then(|| self.frames[k].dir(self.profile, p))
    }

    fn uv_from_dir(&self, s: Dir) -> (f64, f64) {
        let (k, discs) = (self.nearest(s).0, self.frames.len());
        let p = self.frames[k].point(self.profile, s);
        let u = (p[0] + 1.0 + (2 * k) as f64) / (2 * discs) as f64;
        // Where two discs touch, the picture is that of the right one.
        let end = if k + 1 < discs { ((k + 1) as f64 / discs as f64).next_down() } else { 1.0 };
        (u.min(end), 0.5 + 0.5 * p[1])
    }

    fn solid_angle(&self, size: Pair, texel: Pair) -> f64 {
        self.rects(size, texel).map(|(_, rect)| azimuthal::solid_angle(self.profile, &rect)).sum()
    }

    fn density(&self, u: f64, v: f64) -> f64 {
        let (_, p) = self.on_plane(u, v);
        (4 * self.frames.len()) as f64 * self.profile.density(p[0].hypot(p[1]).min(1.0))
    }

    fn density_towards(&self, s: Dir) -> f64 {
        let scale = (4 * self.frames.len()) as f64;
        match self.profile.density_towards(self.nearest(s).1) {
            Some(density) => scale * density,
            None => {
                let (u, v) = self.uv_from_dir(s);
                self.density(u, v)
            }
        }
    }

    fn aspect(&self) -> Pair {
        [self.frames.len(), 1]
    }

    fn discs(&self) -> usize {
        self.frames.len()
    }

    fn axes_again(&self) -> &'static [(&'static str, [f64; 2])] {
        self.axes_again
    }

    fn limits(&self, [width, height]: Pair, p: [f64; 2]) -> [[f32; 2]; 2] {
        let discs = self.frames.len();
        let edge = |k: usize| k as f32 / discs as f32 * width as f32;
        let k = ((p[0] * discs as f64 / width as f64) as usize).min(discs - 1);
        let end = if k + 1 < discs { edge(k + 1).next_down() } else { width as f32 };
        [[edge(k), end], [0.0, height as f32]]
    }

    /// Blends over the last half texel before the rim: at the rim both sides have the same weight.
    fn taps(&self, size: Pair, [x, y]: [f64; 2]) -> Taps {
        let discs = self.frames.len();
        let (side, height) = (size[0] as f64 / discs as f64, size[1] as f64);
        let k = ((x / side) as usize).min(discs - 1);
        let p = [2.0 * (x - k as f64 * side) / side - 1.0, 2.0 * y / height - 1.0];
        let mut taps = Taps::NONE;
        let inner = (1.0 - 1.0 / side.min(height)).max(0.0);
        let r = p[0].hypot(p[1]);
        if r <= inner {
            self.add_taps(size, k, p, 1.0, &mut taps);
            return taps;
        }
        let scale = inner / r;
        let t = 0.5 * ((r - inner) / (1.0 - inner)).min(1.0);
        self.add_taps(size, k, p.map(|c| scale * c), 1.0 - t, &mut taps);
        self.add_taps(size, discs - 1 - k, (self.across)(p).map(|c| scale * c), t, &mut taps);
        taps
    }

    fn inner_part(&self, _size: Pair, _p: [f64; 2]) -> Option<[[f64; 2]; 2]> {
        None
    }

    fn add_nodes(&self, size: Pair, texel: Pair, rules: [&Rule; 2], out: &mut Vec<(Dir, f64)>) {
        for (frame, rect) in self.rects(size, texel) {
            azimuthal::nodes(self.profile, &rect, rules, &mut |p, weight| {
                out.push((frame.dir(self.profile, p), weight));
            });
        }
    }

    fn obstacle(&self, size: Pair, texel: Pair) -> Option<Obstacle> {
        let of_rect = |(_, rect): (&Frame, Rect)| Obstacle::Length(rect.theta_extent(self.profile));
        self.rects(size, texel).next().filter(|_| self.profile == Profile::Ball).map(of_rect)
    }

    /// The longest texel of a ball reaches from the rim inwards along its diagonal.
    fn worst_obstacle(&self, [width, height]: Pair) -> Option<Obstacle> {
        let diagonal = (2.0 / width as f64).hypot(2.0 / height as f64);
        let longest = Rect { x: [1.0 - diagonal, 1.0], y: [0.0; 2] };
        (self.profile == Profile::Ball).then(|| Obstacle::Length(longest.theta_extent(Profile::Ball)))
    }
}
