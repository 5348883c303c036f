//! Azimuthal projections onto a disc: the angle to the center becomes the radius, the azimuth is kept.

use std::f64::consts::PI;

use lobe_sh::Dir;
use lobe_sh::sphere::gauss_legendre;

use crate::mapping::lat_long::sin_cos_pi;

// With θ the angle to the direction C in the center of the disc and p = r (cos ψ, sin ψ) the point of the unit disc,
//
//     ball          r = sin(θ/2)      dΩ = sin θ dθ dψ = 4 r dr dψ
//     angular       r = θ/π           dΩ = π sin(πr) dr dψ
//     paraboloid    r = tan(θ/2)      dΩ = 4/(1+r²)² r dr dψ          (θ <= π/2)
//     orthographic  r = sin θ         dΩ = 1/√(1-r²) r dr dψ          (θ <= π/2)
//
// The solid angle of a texel is a line integral around it (Green): with F(r) = ∫_0^r dΩ/dψ = 1 - cos θ,
//
//     Ω = ∮ F dψ       dψ = (x dy - y dx)/r²
//
// that is, with G = F/r² (2, 2 sin²(πr/2)/r², 2/(1+r²), 1/(1+√(1-r²))), c ∫ G(c² + t²) dt along each straight edge, at
// the distance c from the center, and F(1) Δψ along the rim. Each edge is shared by two texels that see it from opposite
// sides, so the sums over a picture telescope, and the rim is all that is left.

/// The radius as a function of the angle to the center.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Profile {
    /// `r = sin(θ/2)`: a mirrored ball from far away.
    Ball,
    /// `r = θ/π`.
    Angular,
    /// `r = tan(θ/2)`, half of the sphere.
    Paraboloid,
    /// `r = sin θ`, half of the sphere.
    Orthographic,
}

/// The distance of a texel from a rim with a root, as that of a ball, in its sides, at which Gauss-Legendre nodes converge as fast as
/// elsewhere: the error of q nodes falls like `(2·(2·4 + 1))^-2q`, the root being 4.5 sides from the middle.
const BALL_MARGIN: f64 = 4.0;
/// Gauss nodes on a quarter of the radius: `2 sin²(πr/2)/r²` and `1/(1+r²)` have all digits with fewer.
const EDGE_NODES: usize = 10;
/// The longest piece of an edge that [`EDGE_NODES`] serve.
const EDGE_PIECE: f64 = 0.25;

impl Profile {
    /// The radius at the angle θ given by `cos θ` and `sin θ >= 0`.
    pub(crate) fn radius(self, cos: f64, sin: f64) -> f64 {
        match self {
            // Two forms, each without cancellation in its half.
            Self::Ball if cos > 0.0 => sin / (2.0 * (1.0 + cos)).sqrt(),
            Self::Ball => (0.5 * (1.0 - cos)).min(1.0).sqrt(),
            Self::Angular => (sin.atan2(cos) / PI).min(1.0),
            // Here, too: opposite the center 1 + cos θ has no digits, and 0/0 at last.
            Self::Paraboloid if cos > 0.0 => sin / (1.0 + cos),
            Self::Paraboloid => (1.0 - cos) / sin,
            Self::Orthographic => sin,
        }
    }

    /// `cos θ` and `sin θ / r`.
    fn cos_and_sin_over_radius(self, r: f64) -> (f64, f64) {
        match self {
            Self::Ball => (1.0 - 2.0 * r * r, 2.0 * ((1.0 - r) * (1.0 + r)).max(0.0).sqrt()),
            Self::Angular => {
                let (sin, cos) = sin_cos_pi(r);
                (cos, if r > 0.0 { sin / r } else { PI })
            }
            Self::Paraboloid => {
                let scale = 1.0 / (1.0 + r * r);
                ((1.0 - r) * (1.0 + r) * scale, 2.0 * scale)
            }
            Self::Orthographic => (root(r), 1.0),
        }
    }

    /// The angle θ at the radius `r`.
    fn theta(self, r: f64) -> f64 {
        match self {
            Self::Ball => 2.0 * r.min(1.0).asin(),
            Self::Angular => PI * r,
            Self::Paraboloid => 2.0 * r.atan(),
            Self::Orthographic => r.min(1.0).asin(),
        }
    }

    /// The solid angle per area of the unit disc at radius `r <= 1`.
    pub(crate) fn density(self, r: f64) -> f64 {
        match self {
            Self::Ball => 4.0,
            Self::Angular => PI * self.cos_and_sin_over_radius(r).1,
            Self::Paraboloid => 4.0 / ((1.0 + r * r) * (1.0 + r * r)),
            Self::Orthographic => 1.0 / root(r),
        }
    }

    /// The same at the angle θ given by its cosine; `None` if that takes the angle itself.
    pub(crate) fn density_towards(self, cos: f64) -> Option<f64> {
        match self {
            Self::Ball => Some(4.0),
            // 1 + r² = 2/(1 + cos θ).
            Self::Paraboloid => Some((1.0 + cos) * (1.0 + cos)),
            Self::Angular | Self::Orthographic => None,
        }
    }

    /// `F(r) = 1 - cos θ`: the solid angle within the radius, per radian.
    pub(crate) fn cap(self, r: f64) -> f64 {
        match self {
            Self::Ball => 2.0 * r * r,
            Self::Angular => {
                let sin = sin_cos_pi(0.5 * r).0;
                2.0 * sin * sin
            }
            Self::Paraboloid => 2.0 * r * r / (1.0 + r * r),
            Self::Orthographic => r * r / (1.0 + root(r)),
        }
    }

    /// `c ∫_a^b G(c² + t²) dt`.
    fn edge(self, c: f64, a: f64, b: f64) -> f64 {
        match self {
            Self::Ball => 2.0 * c * (b - a),
            Self::Paraboloid => {
                let s = (1.0 + c * c).sqrt();
                2.0 * c / s * ((b - a) * s).atan2(s * s + a * b)
            }
            Self::Angular => {
                let pieces = ((b - a) / EDGE_PIECE).ceil().max(1.0);
                let half = 0.5 * (b - a) / pieces;
                let piece = |k: usize| -> f64 {
                    let middle = a + (2 * k + 1) as f64 * half;
                    EDGE_RULE.with(|rule| rule.iter().map(|(x, w)| w * angular_g(c, middle + half * x)).sum())
                };
                c * half * (0..pieces as usize).map(piece).sum::<f64>()
            }
            Self::Orthographic => orthographic_edge(c, b) - orthographic_edge(c, a),
        }
    }
}

/// `√(1 - r²)`.
fn root(r: f64) -> f64 {
    ((1.0 - r) * (1.0 + r)).max(0.0).sqrt()
}

// The integral of c (1 - w)/(c² + t²), w = √(1 - c² - t²), is atan(t/c) + c asin(t/√(1 - c²)) - atan(t/(c w)). The two
// arctangents nearly cancel in the middle of the disc; as one, with 1 - w = (c² + t²)/(1 + w), they do not.

/// `c ∫_0^t G(c² + t²) dt` of the orthographic profile.
fn orthographic_edge(c: f64, t: f64) -> f64 {
    let half_chord = root(c);
    let w = ((half_chord - t) * (half_chord + t)).max(0.0).sqrt();
    let sine = (t / half_chord).clamp(-1.0, 1.0);
    c * sine.asin() - (t * c * (c * c + t * t) / (1.0 + w)).atan2(c * c * w + t * t)
}

thread_local! {
    static EDGE_RULE: Vec<(f64, f64)> = gauss_legendre(EDGE_NODES);
}

/// `2 sin²(πr/2)/r²` at `r² = c² + t²`.
fn angular_g(c: f64, t: f64) -> f64 {
    let r = c.hypot(t);
    let sin = sin_cos_pi(0.5 * r).0;
    if r > 0.0 { 2.0 * (sin / r) * (sin / r) } else { 0.5 * PI * PI }
}

/// The frame of a disc: the direction in its center, and the directions to the right and upwards.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    pub(crate) center: [f64; 3],
    pub(crate) right: [f64; 3],
    pub(crate) up: [f64; 3],
}

impl Frame {
    /// The direction of the point `p` of the unit disc, x to the right and y downwards.
    pub(crate) fn dir(&self, profile: Profile, p: [f64; 2]) -> Dir {
        let (cos, sin_over_radius) = profile.cos_and_sin_over_radius(p[0].hypot(p[1]));
        let (right, up) = (sin_over_radius * p[0], -sin_over_radius * p[1]);
        let v = [0, 1, 2].map(|k| cos * self.center[k] + right * self.right[k] + up * self.up[k]);
        Dir::from_unit(v)
    }

    /// The point of the unit disc in the direction `s`; opposite the center the right end of the rim.
    pub(crate) fn point(&self, profile: Profile, s: Dir) -> [f64; 2] {
        let along = |axis: [f64; 3]| s.x() * axis[0] + s.y() * axis[1] + s.z() * axis[2];
        let (cos, right, up) = (along(self.center), along(self.right), along(self.up));
        let sin = right.hypot(up);
        let r = profile.radius(cos, sin);
        if sin > 0.0 { [r * right / sin, -r * up / sin] } else { [r, 0.0] }
    }
}

/// A rectangle in the plane of the unit disc: `[x0, x1] × [y0, y1]`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rect {
    pub(crate) x: [f64; 2],
    pub(crate) y: [f64; 2],
}

impl Rect {
    /// The radius of the nearest point.
    pub(crate) fn nearest(&self) -> f64 {
        let nearest = |[a, b]: [f64; 2]| 0.0_f64.clamp(a, b);
        nearest(self.x).hypot(nearest(self.y))
    }

    /// The radius of the farthest point.
    fn farthest(&self) -> f64 {
        let farthest = |[a, b]: [f64; 2]| a.abs().max(b.abs());
        farthest(self.x).hypot(farthest(self.y))
    }

    /// The difference of θ between the nearest and the farthest point in the unit disc; 0 outside.
    pub(crate) fn theta_extent(&self, profile: Profile) -> f64 {
        profile.theta(self.farthest().min(1.0)) - profile.theta(self.nearest().min(1.0))
    }

    /// Whether no point of the rectangle lies inside the open unit disc.
    pub(crate) fn is_outside(&self) -> bool {
        self.nearest() >= 1.0
    }

    /// Whether the product rule converges fast: inside the disc and, where there is a root at the rim, away from it.
    pub(crate) fn is_far_from_rim(&self, profile: Profile) -> bool {
        let side = (self.x[1] - self.x[0]).max(self.y[1] - self.y[0]);
        let has_root = matches!(profile, Profile::Ball | Profile::Orthographic);
        let margin = if has_root { BALL_MARGIN * side } else { 0.0 };
        self.farthest() + margin <= 1.0
    }

    /// Whether the rectangle lies in the closed unit disc.
    fn is_inside(&self) -> bool {
        self.farthest() <= 1.0
    }

    /// The azimuths at which the rim crosses an edge, sorted.
    fn rim_crossings(&self) -> Vec<f64> {
        let mut angles = Vec::with_capacity(8);
        if self.is_inside() {
            return angles;
        }
        for sign in [-1.0, 1.0] {
            let other = |c: f64| sign * ((1.0 - c) * (1.0 + c)).sqrt();
            let within = |t: f64, [a, b]: [f64; 2]| (a..=b).contains(&t);
            angles
                .extend(self.x.iter().map(|&c| (c, other(c))).filter(|p| within(p.1, self.y)).map(|p| p.1.atan2(p.0)));
            angles
                .extend(self.y.iter().map(|&c| (other(c), c)).filter(|p| within(p.0, self.x)).map(|p| p.1.atan2(p.0)));
        }
        angles.sort_by(f64::total_cmp);
        angles
    }

    /// The angle of the rim inside the rectangle.
    fn rim_arc(&self) -> f64 {
        let inside = |angle: f64| {
            let (y, x) = angle.sin_cos();
            self.x[0] <= x && x <= self.x[1] && self.y[0] <= y && y <= self.y[1]
        };
        intervals(&self.rim_crossings()).filter(|(a, b)| inside(0.5 * (a + b))).map(|(a, b)| b - a).sum()
    }

    /// The radii at which the ray of azimuth ψ enters and leaves the part of the rectangle in the unit disc.
    pub(crate) fn ray(&self, sin: f64, cos: f64) -> (f64, f64) {
        let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
        for (slope, [a, b]) in [(cos, self.x), (sin, self.y)] {
            if slope != 0.0 {
                let (t0, t1) = (a / slope, b / slope);
                enter = enter.max(t0.min(t1));
                leave = leave.min(t0.max(t1));
            } else if a > 0.0 || b < 0.0 {
                leave = 0.0;
            }
        }
        (enter, leave)
    }
}

/// The intervals between sorted azimuths, around the circle.
fn intervals(sorted: &[f64]) -> impl Iterator<Item = (f64, f64)> + '_ {
    let next = |k: usize| sorted.get(k + 1).copied().unwrap_or_else(|| sorted[0] + 2.0 * PI);
    sorted.iter().enumerate().map(move |(k, &a)| (a, next(k)))
}

/// The exact solid angle of the part of the rectangle in the unit disc.
pub(crate) fn solid_angle(profile: Profile, rect: &Rect) -> f64 {
    solid_angle_within(profile, 1.0, rect)
}

/// [`solid_angle`] if the rim of the unit disc lies at the radius `rim` of the profile, which need not be 1.
///
/// Neither `F` nor the integrals along edges depend on the unit of length.
pub(crate) fn solid_angle_within(profile: Profile, rim: f64, rect: &Rect) -> f64 {
    if rect.is_outside() {
        return 0.0;
    }
    let edge = |c: f64, [a, b]: [f64; 2]| {
        if c.abs() >= 1.0 {
            return 0.0;
        }
        let half_chord = ((1.0 - c) * (1.0 + c)).sqrt();
        let (a, b) = (a.max(-half_chord), b.min(half_chord));
        if a < b { profile.edge(rim * c, rim * a, rim * b) } else { 0.0 }
    };
    let straight =
        edge(rect.x[1], rect.y) - edge(rect.x[0], rect.y) + edge(rect.y[1], rect.x) - edge(rect.y[0], rect.x);
    (straight + profile.cap(rim) * rect.rim_arc()).max(0.0)
}

/// Calls `node(point of the disc, weight)` for the nodes of a quadrature over the part of the rectangle in the disc.
///
/// Away from the rim the directions are analytic functions of the point: the product rule. Otherwise
/// Gauss-Legendre by the first rule in ψ between the azimuths where the shape has a corner, and by the second in θ
/// between the radii where the ray enters and leaves; the weights contain `sin θ`. The integrand is smooth between the
/// breaks for every profile, at the rim too.
pub(crate) fn nodes(profile: Profile, rect: &Rect, rules: [&[(f64, f64)]; 2], node: &mut impl FnMut([f64; 2], f64)) {
    if rect.is_outside() {
        return;
    }
    if rect.is_far_from_rim(profile) {
        let line = |[a, b]: [f64; 2], t: f64| 0.5 * (a + b + t * (b - a));
        let area = 0.25 * (rect.x[1] - rect.x[0]) * (rect.y[1] - rect.y[0]);
        for (s, weight) in rules[0] {
            for (t, inner) in rules[1] {
                let p = [line(rect.x, *s), line(rect.y, *t)];
                node(p, weight * inner * area * profile.density(p[0].hypot(p[1])));
            }
        }
        return;
    }
    let mut breaks = rect.rim_crossings();
    for x in rect.x {
        breaks.extend(rect.y.iter().filter(|&&y| x != 0.0 || y != 0.0).map(|y| y.atan2(x)));
    }
    breaks.sort_by(f64::total_cmp);
    for (a, b) in intervals(&breaks) {
        let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
        let (sin, cos) = middle.sin_cos();
        let (enter, leave) = rect.ray(sin, cos);
        if half <= 0.0 || leave <= enter {
            continue;
        }
        for (x, weight) in rules[0] {
            // Where an edge runs out to the rim of a ball, θ behaves like a root of ψ: a cubic that is flat at both
            // ends makes it smooth.
            let (sin, cos) = (middle + half * 0.5 * x * (3.0 - x * x)).sin_cos();
            let weight = weight * 1.5 * (1.0 - x * x);
            let (enter, leave) = rect.ray(sin, cos);
            let (from, to) = (profile.theta(enter), profile.theta(leave.max(enter)));
            let (middle_theta, half_theta) = (0.5 * (from + to), 0.5 * (to - from));
            for (t, inner) in rules[1] {
                let (sin_theta, cos_theta) = (middle_theta + half_theta * t).sin_cos();
                let r = profile.radius(cos_theta, sin_theta.max(0.0));
                node([r * cos, r * sin], weight * half * inner * half_theta * sin_theta);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PROFILES: [Profile; 4] = [Profile::Ball, Profile::Angular, Profile::Paraboloid, Profile::Orthographic];

    fn texels(w: usize, h: usize) -> impl Iterator<Item = Rect> {
        let at = |i: usize, n: usize| (2 * i) as f64 / n as f64 - 1.0;
        (0..w * h).map(move |i| {
            let (x, y) = (i % w, i / w);
            Rect { x: [at(x, w), at(x + 1, w)], y: [at(y, h), at(y + 1, h)] }
        })
    }

    #[test]
    fn solid_angles_of_a_disc_sum_to_the_whole() {
        for profile in PROFILES {
            for (w, h) in [(1, 1), (2, 2), (3, 3), (4, 7), (31, 31), (256, 100)] {
                let sum: f64 = texels(w, h).map(|rect| solid_angle(profile, &rect)).sum();
                let expected = 2.0 * PI * profile.cap(1.0);
                assert!((sum - expected).abs() < 1e-11, "{profile:?} {w} x {h}: {sum} against {expected}");
            }
        }
    }

    #[test]
    fn solid_angles_equal_the_sum_of_quadrature_nodes() {
        let rule = gauss_legendre(20);
        for profile in PROFILES {
            for (w, h) in [(1, 1), (2, 3), (8, 8), (9, 9), (20, 7)] {
                for rect in texels(w, h) {
                    let mut sum = 0.0;
                    nodes(profile, &rect, [&rule; 2], &mut |_, weight| sum += weight);
                    let exact = solid_angle(profile, &rect);
                    assert!((sum - exact).abs() < 1e-9, "{profile:?} {w} x {h} {rect:?}: {sum} against {exact}");
                }
            }
        }
    }
}
