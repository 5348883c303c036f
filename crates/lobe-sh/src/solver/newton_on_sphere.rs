//! Ascent to a local maximum of a smooth function on the sphere by Newton's method.
//!
//! For functions that are no expansions, such as the sums of squares over channels that the encodings maximize: they
//! have one or two broad hills, where a few Newton steps suffice.

#[cfg(not(feature = "std"))]
use num_traits::Float as _;

use crate::sphere::Dir;
use crate::sphere::vector::{dot, tangents};

/// The most steps. Where the function is quadratic six suffice; the first ones may be halved.
const STEPS: usize = 60;

/// The angle of the finite differences of the gradient: `ε^{1/3}`, where truncation and rounding balance.
const DIFFERENCE: f64 = 6e-6;

/// The longest step, in radians.
const LONGEST_STEP: f64 = 0.5;

/// The step at which the ascent has converged, in radians.
const CONVERGED: f64 = 1e-13;

/// The relative loss of a value that counts as rounding when a step makes the gradient shorter.
const ROUNDING: f64 = 1e-14;

/// Ascends from `start` to a local maximum of the function whose value and gradient `f` returns; the part of the
/// gradient along `s` is ignored.
///
/// Newton's method in the tangent plane, its second derivatives from differences of gradients along three great
/// circles; steepest ascent where the function is not concave. A step that does not ascend is halved.
pub(crate) fn ascend(start: Dir, f: impl Fn(Dir) -> (f64, [f64; 3])) -> Dir {
    let mut at = start;
    let (mut value, mut gradient) = f(at);
    for _ in 0..STEPS {
        // Take the Newton step in the tangent plane.
        let [u, v] = tangents(at.to_array());
        let g = [dot(gradient, u), dot(gradient, v)];
        let step = newton_step(at, [u, v], g, &f);
        let length = step[0].hypot(step[1]);
        if length.is_nan() || length <= CONVERGED {
            break;
        }
        let towards = [0, 1, 2].map(|k| (step[0] * u[k] + step[1] * v[k]) / length);
        let mut angle = length.min(LONGEST_STEP);
        // Halve it until the function rises, or the gradient becomes shorter within rounding.
        let risen = loop {
            let next = along(at, towards, angle);
            let (next_value, next_gradient) = f(next);
            let flatter = tangent_length(next, next_gradient) < g[0].hypot(g[1]);
            if next_value > value || flatter && next_value >= value - ROUNDING * value.abs() {
                (at, value, gradient) = (next, next_value, next_gradient);
                break true;
            }
            angle *= 0.5;
            if angle < CONVERGED {
                break false;
            }
        };
        if !risen {
            break;
        }
    }
    at
}

/// The step in the tangent plane.
fn newton_step(at: Dir, [u, v]: [[f64; 3]; 2], g: [f64; 2], f: &impl Fn(Dir) -> (f64, [f64; 3])) -> [f64; 2] {
    let second = |t: [f64; 3]| {
        let slope = |angle: f64| {
            let there = along(at, t, angle);
            // The direction of the great circle there.
            let forward = [0, 1, 2].map(|k| t[k] * angle.cos() - at.to_array()[k] * angle.sin());
            dot(f(there).1, forward)
        };
        (slope(DIFFERENCE) - slope(-DIFFERENCE)) / (2.0 * DIFFERENCE)
    };
    let half = 0.5_f64.sqrt();
    let (uu, vv) = (second(u), second(v));
    let uv = second([0, 1, 2].map(|k| half * (u[k] + v[k]))) - 0.5 * (uu + vv);
    let determinant = uu * vv - uv * uv;
    if uu < 0.0 && determinant > 0.0 {
        [(uv * g[1] - vv * g[0]) / determinant, (uv * g[0] - uu * g[1]) / determinant]
    } else {
        let curvature = uu.abs().max(vv.abs()).max(uv.abs());
        if curvature > 0.0 { g.map(|g| g / curvature) } else { g }
    }
}

/// The direction at an angle from `at` along a unit tangent.
fn along(at: Dir, tangent: [f64; 3], angle: f64) -> Dir {
    let (sin, cos) = angle.sin_cos();
    let s = at.to_array();
    Dir::new([0, 1, 2].map(|k| cos * s[k] + sin * tangent[k])).unwrap_or(at)
}

/// The length of the part of `v` tangent to the sphere at `s`.
fn tangent_length(s: Dir, v: [f64; 3]) -> f64 {
    let along = dot(s.to_array(), v);
    (dot(v, v) - along * along).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_testkit::directions;

    #[test]
    fn the_top_is_found_from_everywhere_but_the_bottom() {
        let top = Dir::from_angles(0.8, -2.5);
        let f = |s: Dir| (s.dot(top).exp(), top.to_array().map(|c| c * s.dot(top).exp()));
        for v in directions() {
            let found = ascend(Dir::from_unit(v), f);
            assert!(found.angle_to(top) < 1e-9, "from {v:?}: {found:?}");
        }
    }

    #[test]
    fn a_flat_or_broken_function_is_left_where_it_is() {
        assert_eq!(ascend(Dir::Y, |_| (1.0, [0.0; 3])), Dir::Y, "flat");
        assert_eq!(ascend(Dir::Y, |_| (f64::NAN, [f64::NAN; 3])), Dir::Y, "not a number");
    }
}
