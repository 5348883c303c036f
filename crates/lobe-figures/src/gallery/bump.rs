//! Bump mapping: normals perturbed by a height field.

use lobe_sh::{Dir, Rgb};

use crate::gallery::exhibit::{Shading, SurfacePoint};
use lobe_sh::sphere::vector::{Vec3, add, cross, scale, sub, tangents_along_z};

/// The step of the central differences, in the unit of the surface: their error and the rounding of the height are
/// both near 1e-10 of a height field that changes over lengths of 1.
const STEP: f64 = 1e-5;

/// The normal of a surface that is raised by `F(u, v)` along its normal.
///
/// ```text
///   P' = P + F n        P'_u ≈ P_u + F_u n,   P'_v ≈ P_v + F_v n        (F n_u, F n_v are left out: F is small)
///   N' = P'_u × P'_v = N + F_u (n × P_v) - F_v (n × P_u)                N = P_u × P_v,   n = N/|N|
/// ```
///
/// Whichever way `u` and `v` run over the surface, the direction of `N'` is the same (test
/// `the_parameters_of_the_surface_do_not_matter`). None if `P_u` and `P_v` are parallel. [Blinn 1978].
#[must_use]
pub fn bumped_normal(p_u: [f64; 3], p_v: [f64; 3], f_u: f64, f_v: f64) -> Option<Dir> {
    let base = cross(p_u, p_v);
    let n = Dir::new(base)?.to_array();
    Dir::new(add(base, sub(scale(cross(n, p_v), f_u), scale(cross(n, p_u), f_v))))
}

/// A surface whose normals are perturbed as if it were raised by a height field, shaded by another technique.
///
/// ```text
///   L = inner(n')        n' by bumped_normal, with P_u, P_v two unit vectors across n and F_u, F_v central differences
/// ```
///
/// The height is a function of the position, so it has neither poles nor seams on any shape. With a mirror inside this
/// is environment-mapped bump mapping: each point reflects by its perturbed normal. Outline and shadows stay those of
/// the smooth shape, and a direction reflected below the surface is looked up as any other.
#[derive(Clone, Copy, Debug)]
pub struct Bumped<S, H> {
    /// The shading of the perturbed point.
    pub inner: S,
    /// The height above the surface at a position, in its unit; small against the radii of the shape.
    pub height: H,
}

impl<S: Shading, H: Fn([f64; 3]) -> f64 + Sync> Shading for Bumped<S, H> {
    fn radiance(&self, at: &SurfacePoint) -> Rgb<f32> {
        let [u, v] = tangents_along_z(at.normal.to_array());
        let slope = |t: Vec3| {
            let shifted = |h: f64| (self.height)(add(at.position, scale(t, h)));
            (shifted(STEP) - shifted(-STEP)) / (2.0 * STEP)
        };
        let normal = bumped_normal(u, v, slope(u), slope(v)).unwrap_or(at.normal);
        self.inner.radiance(&SurfacePoint { normal, ..*at })
    }
}

/// A height field of round bumps in a cubic pattern, `amplitude` high, `2π/frequency` apart.
///
/// ```text
///   F(p) = a sin(f x) sin(f y) sin(f z)
/// ```
pub fn bumps(amplitude: f64, frequency: f64) -> impl Fn([f64; 3]) -> f64 + Sync + Copy {
    move |p: [f64; 3]| amplitude * p.iter().map(|c| (frequency * c).sin()).product::<f64>()
}

#[cfg(test)]
mod tests {
    use lobe_testkit::{Random, directions};

    use super::*;
    use crate::gallery::torus::Torus;
    use lobe_sh::sphere::vector::dot;

    /// The normal that [`Bumped`] finds.
    fn perturbed(position: Vec3, normal: Dir, height: impl Fn(Vec3) -> f64 + Sync) -> Vec3 {
        let seen = |p: &SurfacePoint| Rgb::from(p.normal.to_array().map(|c| c as f32));
        let n = Bumped { inner: seen, height }.radiance(&SurfacePoint { position, normal, view: normal });
        n.to_array().map(f64::from)
    }

    #[test]
    fn the_parameters_of_the_surface_do_not_matter() {
        let mut random = Random::new(6);
        for _ in 0..300 {
            let [u, v] = tangents_along_z(random.direction());
            let (f_u, f_v) = (random.signed(), random.signed());
            let expected = bumped_normal(u, v, f_u, f_v).unwrap();
            // Other parameters s, t: P_s = a P_u + b P_v, and F_s alike.
            let (a, b, c, d) = (random.signed(), random.signed(), random.signed(), random.signed());
            if a * d - b * c < 0.05 {
                continue;
            }
            let mixed = |a: f64, b: f64| add(scale(u, a), scale(v, b));
            let found = bumped_normal(mixed(a, b), mixed(c, d), a * f_u + b * f_v, c * f_u + d * f_v).unwrap();
            assert!(found.angle_to(expected) < 1e-13, "{found:?} and {expected:?}");
        }
    }

    #[test]
    fn the_normal_is_that_of_the_raised_surface_to_first_order() {
        // The raised ball is the surface |p| = 1 + F(p/|p|), of which the exact normal is known.
        for amplitude in [1e-3, 1e-4] {
            let height = bumps(amplitude, 5.0);
            for s in directions() {
                let exact_slope: Vec3 = std::array::from_fn(|k| {
                    let f = |h: f64| height(std::array::from_fn(|i| s[i] + if i == k { h } else { 0.0 }));
                    (f(1e-5) - f(-1e-5)) / 2e-5
                });
                let along_sphere = sub(exact_slope, scale(s, dot(s, exact_slope)));
                let exact = Dir::new(sub(s, scale(along_sphere, 1.0 / (1.0 + height(s))))).unwrap();
                let found = Dir::new(perturbed(s, Dir::new(s).unwrap(), height)).unwrap();
                // F is left out against 1 where it multiplies the slope 5a: 5a². The test's colors are f32.
                let limit = 10.0 * amplitude * amplitude + 2e-7;
                assert!(found.angle_to(exact) < limit, "height {amplitude} at {s:?}: {}", found.angle_to(exact));
            }
        }
    }

    #[test]
    fn a_bump_on_the_torus_tilts_the_normal_away_from_its_top() {
        let torus = Torus { axis: Dir::Z, major: 0.7, minor: 0.3 };
        let top = [0.7, 0.0, 0.3];
        let height = |p: Vec3| 0.02 * (-50.0 * dot(sub(p, top), sub(p, top))).exp();
        for (dx, dy) in [(0.05, 0.0), (-0.05, 0.0), (0.0, 0.05), (0.0, -0.05)] {
            let p: Vec3 = [0.7 + dx, dy, (0.3_f64.powi(2) - dx * dx).sqrt()];
            let smooth = torus.normal(p);
            let n = perturbed(p, smooth, height);
            let tilt = dx * (n[0] - smooth.x()) + dy * (n[1] - smooth.y());
            assert!(tilt > 1e-3, "beside the bump at ({dx}, {dy}) the normal leans outwards: {tilt}");
        }
    }

    #[test]
    fn without_slope_nothing_changes() {
        for s in directions() {
            let n = Dir::new(s).unwrap();
            let found = Dir::new(perturbed(s, n, |_| 3.0)).unwrap();
            assert!(found.angle_to(n) < 2e-7, "at {s:?}: {found:?}");
        }
    }
}
