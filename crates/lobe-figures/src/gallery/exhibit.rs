//! Exhibits: a shape before a camera, shaded point by point.

use lobe_io::parallel;
use lobe_sh::{Coefficient, Dir, Rgb};

use crate::gallery::solid::ExhibitSolid;
use lobe_image::{ErrorReport, Picture, compare};
use lobe_render::Camera;
use lobe_sh::sphere::vector::{add, dot, scale, sub};

/// A point of a surface, and the direction it is seen from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Its position.
    pub position: [f64; 3],
    /// The outward normal `n`.
    pub normal: Dir,
    /// The direction `v` towards the eye.
    pub view: Dir,
}

impl SurfacePoint {
    /// The direction `r = 2 (n·v) n - v` that a mirror shows at this point.
    ///
    /// `r` and `v` make the same angle with `n`, on opposite sides of it. It is what GLSL calls `reflect(-v, n)`.
    #[must_use]
    pub fn reflected(&self) -> Dir {
        let (n, v) = (self.normal.to_array(), self.view.to_array());
        let r = sub(scale(n, 2.0 * dot(n, v)), v);
        // Of unit length to rounding, which Dir::new removes.
        Dir::new(r).unwrap_or_else(|| unreachable!("{r:?} is as long as a unit vector"))
    }

    /// `n·v`, not below 0.
    #[must_use]
    pub fn cos_view(&self) -> f64 {
        self.normal.dot(self.view).max(0.0)
    }
}

/// A technique of shading: the light of the surroundings in, the radiance towards the eye out.
///
/// Environment mapping in its classic form: the surroundings are infinitely far away, so only directions count; the
/// surface neither shades nor mirrors itself.
pub trait Shading: Sync {
    /// The radiance that leaves the point towards its [`view`](SurfacePoint::view).
    fn radiance(&self, at: &SurfacePoint) -> Rgb<f32>;
}

impl<F: Fn(&SurfacePoint) -> Rgb<f32> + Sync> Shading for F {
    fn radiance(&self, at: &SurfacePoint) -> Rgb<f32> {
        self(at)
    }
}

/// A shape before a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exhibit {
    /// The shape.
    pub solid: ExhibitSolid,
    /// The eye.
    pub camera: Camera,
    /// Rays along each side of a pixel: a pixel is the mean of `samples²`, in fixed places on a regular grid.
    pub samples: usize,
}

impl Exhibit {
    /// The picture of the shape in front of `background`, the light from every direction.
    ///
    /// Pixels are means of linear light, so rims are smooth; a sun of a few texels keeps the jagged edge that its
    /// brightness forces on any mean. The same bits for any number of threads.
    ///
    /// # Panics
    /// If [`samples`](Exhibit::samples) is 0.
    #[must_use]
    pub fn picture(
        &self,
        width: usize,
        height: usize,
        background: impl Fn(Dir) -> Rgb<f32> + Sync,
        shading: &(impl Shading + ?Sized),
    ) -> Picture {
        self.shaded(width, height, &background, &|at: &SurfacePoint| shading.radiance(at))
    }

    /// The same by references: compiled once, not for every technique.
    fn shaded(
        &self,
        width: usize,
        height: usize,
        background: &(dyn Fn(Dir) -> Rgb<f32> + Sync),
        radiance: &(dyn Fn(&SurfacePoint) -> Rgb<f32> + Sync),
    ) -> Picture {
        assert!(self.samples > 0, "a pixel needs at least one ray");
        let n = self.samples;
        Picture::from_fn(width, height, |x, y| {
            let mut sum = Rgb::<f64>::ZERO;
            for k in 0..n * n {
                let offset = |i: usize| (i as f64 + 0.5) / n as f64;
                let (right, up) = place(width, height, x as f64 + offset(k % n), y as f64 + offset(k / n));
                let (origin, towards) = self.camera.ray(right, up);
                let seen = match self.seen(origin, towards) {
                    Some(point) => radiance(&point),
                    None => background(towards),
                };
                sum += seen.widen();
            }
            Rgb::narrow(sum.scale(((n * n) as f64).recip()))
        })
    }

    /// The points of the shape at the centers of the pixels of a picture, row by row; pixels beside it have none.
    #[must_use]
    pub fn points(&self, width: usize, height: usize) -> Vec<SurfacePoint> {
        let center = |i: usize| {
            let (right, up) = place(width, height, (i % width) as f64 + 0.5, (i / width) as f64 + 0.5);
            let (origin, towards) = self.camera.ray(right, up);
            self.seen(origin, towards)
        };
        (0..width * height).filter_map(center).collect()
    }

    /// The first intersection of a ray from outside with the shape.
    fn seen(&self, origin: [f64; 3], towards: Dir) -> Option<SurfacePoint> {
        let t = self.solid.hit(origin, towards, 0.0)?;
        let position = add(origin, scale(towards.to_array(), t));
        Some(SurfacePoint { position, normal: self.solid.normal(position), view: -towards })
    }
}

/// The difference of two shadings over given points, all weighted alike: over [`Exhibit::points`] it is the error of
/// the picture inside the shape.
#[must_use]
pub fn compare_shadings(
    points: &[SurfacePoint],
    image: &(impl Shading + ?Sized),
    reference: &(impl Shading + ?Sized),
) -> ErrorReport {
    compare(&radiances(points, &|p| image.radiance(p)), &radiances(points, &|p| reference.radiance(p)))
}

fn radiances(points: &[SurfacePoint], of: &(dyn Fn(&SurfacePoint) -> Rgb<f32> + Sync)) -> Vec<Rgb<f32>> {
    parallel::map(points.len(), &|i| of(&points[i]))
}

/// The place of a point of a picture in half heights right of and above its middle.
fn place(width: usize, height: usize, x: f64, y: f64) -> (f64, f64) {
    let half = 0.5 * height as f64;
    ((x - 0.5 * width as f64) / half, (half - y) / half)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use lobe_testkit::Random;

    use super::*;
    use crate::gallery::torus::Torus;
    use lobe_render::View;

    fn ball(samples: usize) -> Exhibit {
        let camera = Camera::orthographic(View::ALONG_X, 1.25);
        Exhibit { solid: ExhibitSolid::Ball { radius: 1.0 }, camera, samples }
    }

    #[test]
    fn the_reflected_direction_makes_the_same_angle_on_the_other_side() {
        let mut random = Random::new(2);
        for _ in 0..500 {
            let mut dir = || Dir::new(random.direction()).unwrap();
            let at = SurfacePoint { position: [0.0; 3], normal: dir(), view: dir() };
            let r = at.reflected();
            assert!((r.dot(at.normal) - at.view.dot(at.normal)).abs() < 1e-14, "angles to the normal: {at:?}");
            let middle: [f64; 3] = std::array::from_fn(|k| r.to_array()[k] + at.view.to_array()[k]);
            let along = dot(middle, at.normal.to_array());
            assert!((dot(middle, middle) - along * along).abs() < 1e-13, "n lies between r and v: {at:?}, {r:?}");
        }
    }

    #[test]
    fn the_ball_covers_the_area_of_its_disc() {
        let white = ball(4).picture(96, 80, |_| Rgb::ZERO, &|_: &SurfacePoint| Rgb::splat(1.0));
        let found = white.mean()[1] * 96.0 * 80.0;
        let expected = PI * (40.0_f64 / 1.25).powi(2);
        // Each of some 200 rim pixels has an error of about a sixteenth; they cancel.
        assert!((found / expected - 1.0).abs() < 2e-3, "{found} pixels instead of {expected}");
    }

    #[test]
    fn points_are_those_that_the_camera_sees() {
        let axis = Dir::new([-0.6, 0.2, 0.7]).unwrap();
        let torus = ExhibitSolid::Torus(Torus { axis, major: 0.7, minor: 0.3 });
        for scene in [ball(1), Exhibit { solid: torus, ..ball(1) }] {
            let points = scene.points(40, 40);
            assert!(points.len() > 300, "{} points", points.len());
            for p in points {
                assert!(p.normal.dot(p.view) >= 0.0, "a point that faces away is seen: {p:?}");
            }
        }
    }

    #[test]
    fn a_light_at_the_viewers_right_shows_on_the_right_side_of_the_ball() {
        // The eye at -x sees -y on its right; the normal halfway between -x and -y mirrors that light.
        let scene = ball(1);
        for (light, (right, up)) in [
            (-Dir::Y, (1.0, 0.0)),
            (Dir::Y, (-1.0, 0.0)),
            (Dir::Z, (0.0, 1.0)),
            (-Dir::Z, (0.0, -1.0)),
            (-Dir::X, (0.0, 0.0)),
        ] {
            let lamp = |s: Dir| Rgb::splat((60.0 * (s.dot(light) - 1.0)).exp() as f32);
            let picture = scene.picture(101, 101, |_| Rgb::ZERO, &|p: &SurfacePoint| lamp(p.reflected()));
            let brightest = (0..101 * 101).max_by(|a, b| picture.pixels()[*a][1].total_cmp(&picture.pixels()[*b][1]));
            let i = brightest.unwrap();
            let (x, y) = ((i % 101) as f64 + 0.5, (i / 101) as f64 + 0.5);
            let radius = 50.5 / 1.25 * 0.5_f64.sqrt();
            let expected = (50.5 + right * radius, 50.5 - up * radius);
            let off = (x - expected.0).hypot(y - expected.1);
            assert!(off < 1.5, "light {light:?}: brightest at ({x}, {y}), expected {expected:?}");
        }
    }

    #[test]
    fn what_stands_behind_the_eye_appears_mirrored() {
        // Turned around, the eye sees +y on its right; in the ball what is on that side is on the left.
        let scene = ball(1);
        let letter = |s: Dir| Rgb::splat(if s.x() < 0.0 && s.y() > 0.1 { 1.0 } else { 0.0 });
        let picture = scene.picture(64, 64, |_| Rgb::ZERO, &|p: &SurfacePoint| letter(p.reflected()));
        let side = |range: std::ops::Range<usize>| range.map(|x| f64::from(picture.pixel(x, 32)[1])).sum::<f64>();
        assert!(side(0..32) > 5.0 && side(32..64) == 0.0, "left {}, right {}", side(0..32), side(32..64));
    }
}
