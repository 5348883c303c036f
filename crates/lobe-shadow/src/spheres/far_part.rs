//! A triangle as a ball sees it: how much of it is nearer than the surface of the ball, and what solid angle the rest
//! fills.
//!
//! The plane of the triangle is at the signed height h over the center of the ball, positive where the normal n points
//! away from the center, and the ball cuts a disk of radius r₀ = √(R² - h²) out of it, about the foot of the center.
//! Let an edge of the triangle run at the signed distance d from the foot, positive where the foot is on the inner
//! side, from the place t₁ to t₂ along it (t = 0 is the place nearest to the foot). Pieces of it in the disk bound the
//! near part themselves; in the place of a piece outside, an arc of the circle with the same angle Δφ about the foot
//! does:
//!
//! ```text
//!   area of the near part     A  = Σ_in  d (t₂ - t₁) / 2  +  Σ_out r₀² Δφ / 2
//!   solid angle of the rest   Ω  = sign(h) Σ_out ( |h|/R Δφ - g(t₂) + g(t₁) )
//!                             g(t) = atan( |h| t / (d √(h² + d² + t²)) )
//! ```
//!
//! For the angle in the polar coordinates (r, φ) of the plane, `dω = |h| r dr dφ / (h² + r²)^{3/2}`, whose integral
//! over r from the circle to the edge, at r = d / cos φ, is `|h|/R - |h| / √(h² + r²)`; the integral of its second
//! term over φ is g. There is no jump where h changes its sign, since pieces outside keep away from the foot.

use glam::DVec3;

/// A surface split by a ball: integrals over its part inside and over that outside, seen from the center of the ball.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Split {
    /// Signed volume of the cones from the center to the part in the ball: Σ h A / 3.
    pub(crate) near_volume: f64,
    /// The vector area of the part in the ball: Σ n A.
    pub(crate) near_area: DVec3,
    /// Signed solid angle of the part outside.
    pub(crate) far_angle: f64,
}

impl Split {
    pub(crate) fn add(&mut self, other: Self) {
        self.near_volume += other.near_volume;
        self.near_area += other.near_area;
        self.far_angle += other.far_angle;
    }
}

/// The signed solid angle of a triangle seen from the origin, from -2π to 2π: positive where its normal points away
/// from there; 0 where the origin is in its plane. [Van Oosterom and Strackee 1983]
pub(crate) fn solid_angle([a, b, c]: [DVec3; 3]) -> f64 {
    let [la, lb, lc] = [a.length(), b.length(), c.length()];
    let volume = a.dot(b.cross(c));
    if volume == 0.0 {
        return 0.0;
    }
    2.0 * volume.atan2(la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb)
}

/// A triangle, its corners relative to the center of a ball of radius `radius`.
pub(crate) fn triangle_in_ball(corners: [DVec3; 3], radius: f64) -> Split {
    let [a, b, c] = corners;
    let doubled = (b - a).cross(c - a);
    let length = doubled.length();
    if length == 0.0 {
        return Split::default();
    }
    let square = radius * radius;
    if corners.iter().all(|p| p.length_squared() <= square) {
        return Split { near_volume: a.dot(doubled) / 6.0, near_area: doubled * 0.5, far_angle: 0.0 };
    }
    let normal = doubled / length;
    let h = normal.dot(a);
    let disk = square - h * h;
    if disk <= 0.0 {
        return Split { far_angle: solid_angle(corners), ..Split::default() };
    }
    let foot = normal * h;
    let plane = Plane { normal, h: h.abs(), radius, disk };
    let (mut area, mut angle) = (0.0, 0.0);
    for [p, q] in [[a, b], [b, c], [c, a]] {
        let (near, far) = plane.edge(p - foot, q - foot);
        area += near;
        angle += far;
    }
    Split { near_volume: h * area / 3.0, near_area: normal * area, far_angle: h.signum() * angle }
}

/// The plane of a triangle: its normal, |h|, R and r₀².
struct Plane {
    normal: DVec3,
    h: f64,
    radius: f64,
    disk: f64,
}

impl Plane {
    /// The terms of an edge between two points relative to the foot: of the near area, and of the far angle over
    /// sign(h).
    fn edge(&self, p: DVec3, q: DVec3) -> (f64, f64) {
        let edge = q - p;
        let length = edge.length();
        let along = edge / length;
        let (start, end) = (p.dot(along), q.dot(along));
        // An edge of length 0 has no direction, and a short one may be lost in the rounding of its ends.
        if start.is_nan() || end.is_nan() || start >= end {
            return (0.0, 0.0);
        }
        let d = self.normal.dot(p.cross(along));
        let chord = (self.disk - d * d).max(0.0).sqrt();
        let (enter, leave) = ((-chord).clamp(start, end), chord.clamp(start, end));
        let mut near = 0.5 * d * (leave - enter);
        let mut far = 0.0;
        for [t1, t2] in [[start, enter], [leave, end]] {
            if t2 > t1 {
                let angle = (d * (t2 - t1)).atan2(d * d + t1 * t2);
                near += 0.5 * self.disk * angle;
                far += self.h / self.radius * angle - self.angle_to(d, t2) + self.angle_to(d, t1);
            }
        }
        (near, far)
    }

    /// g(t); an edge through the foot has none.
    fn angle_to(&self, d: f64, t: f64) -> f64 {
        if d == 0.0 {
            return 0.0;
        }
        let distance = (self.h * self.h + d * d + t * t).sqrt();
        d.signum() * (self.h * t).atan2(d.abs() * distance)
    }
}
