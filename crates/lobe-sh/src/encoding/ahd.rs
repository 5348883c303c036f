//! Ambient, highlight and direction (AHD): irradiance as that of a constant and one directional light.

use core::f64::consts::PI;

use crate::encoding::ambient_cube::AXES;
use crate::encoding::{coefficient, not_negative, y_0};
use crate::expansion::expansion::optimal_linear_direction;
use crate::expansion::gradient::eval_with_gradient;
use crate::expansion::sh_vec::widened;
use crate::expansion::{Expansion, ShVec, Zonal};
use crate::scalar::{Coefficient, Real};
use crate::solver::newton_on_sphere::ascend;
use crate::sphere::Dir;

/// Starts of the search for the best direction, besides the linear direction: the faces and corners of the cube. They
/// suffice because the function is convolved with the cosine twice, so that its maxima are wide.
fn starts() -> impl Iterator<Item = Dir> {
    let corner = |k: usize| [4, 2, 1].map(|bit| if k & bit == 0 { 1.0 } else { -1.0 });
    AXES.into_iter().chain((0..8).map(corner)).filter_map(Dir::new)
}

/// Irradiance as ambient, highlight and direction: the irradiance of a constant and one directional light.
///
/// ```text
///   E(n) = A + H max(n·d, 0)
/// ```
///
/// Colors `A` and `H` and one direction `d` for all channels: nine numbers in color. Such light is kept exactly. `A`
/// and `H` are not negative, so neither is `E`. The encoding rotates with the light. The direction jumps where two
/// lights are equally strong: interpolate between neighbors with care.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Ahd<T = f32> {
    /// `A`, the irradiance of the constant light.
    pub ambient: T,
    /// `H`, the irradiance of a surface facing the light.
    pub highlight: T,
    /// `d`, towards the light.
    pub direction: Dir,
}

impl<T: Coefficient> Ahd<T> {
    /// The colors nearest to an irradiance in the mean square over all normals, for a given direction.
    ///
    /// ```text
    ///   [4π   π  ] [A]   [∫ E dn        ]
    ///   [π   2π/3] [H] = [∫ E max(n·d,0)] = [√(4π) E_00, Σ_l A_l Σ_m E_lm y_lm(d)]
    /// ```
    ///
    /// If one of them would be negative, it is zero and the other is the best alone.
    #[must_use]
    pub fn towards(direction: Dir, irradiance: &impl Expansion<T>) -> Self {
        Fitter::new(irradiance).towards(direction)
    }

    /// [`Ahd::towards`] the optimal linear direction of the luminance, the cheap choice; +z if there is none.
    #[must_use]
    pub fn linear(irradiance: &impl Expansion<T>) -> Self {
        Self::towards(optimal_linear_direction(irradiance).unwrap_or(Dir::Z), irradiance)
    }

    /// Colors and direction by least squares, summed over channels: the nearest encoding of this form.
    ///
    /// With the best colors for every direction, the error falls as `p_c(d) = ∫ E_c max(n·d,0) dn` grows,
    /// `∂error/∂p_c = -2 H_c`: Newton's method finds its maximum from the linear direction and 14 further starts (test
    /// `the_solved_direction_is_the_best_of_a_dense_grid`). +z if all directions are equal.
    #[must_use]
    pub fn solved(irradiance: &impl Expansion<T>) -> Self {
        let fitter = Fitter::new(irradiance);
        let first = optimal_linear_direction(irradiance).unwrap_or(Dir::Z);
        let mut best = (first, fitter.explained(first).0);
        for start in core::iter::once(first).chain(starts()) {
            let found = ascend(start, |d| fitter.explained(d));
            let explained = fitter.explained(found).0;
            if explained > best.1 {
                best = (found, explained);
            }
        }
        fitter.towards(best.0)
    }

    /// The irradiance of a surface with normal `n`.
    #[must_use]
    pub fn eval(&self, n: Dir) -> T {
        T::narrow(self.ambient.widen() + self.highlight.widen().scale(n.dot(self.direction).max(0.0)))
    }
}

/// The integrals of an irradiance that the fit needs.
struct Fitter<T: Coefficient> {
    /// `∫ E dn`.
    total: T::Wide,
    /// The irradiance convolved with the clamped cosine: `p(d)`.
    blurred: ShVec<T::Wide>,
}

impl<T: Coefficient> Fitter<T> {
    fn new(irradiance: &impl Expansion<T>) -> Self {
        let total = coefficient(irradiance, 0).scale(1.0 / y_0());
        Self { total, blurred: widened(irradiance).convolved(&Zonal::clamped_cosine(irradiance.order())) }
    }

    fn towards(&self, direction: Dir) -> Ahd<T> {
        let p = self.blurred.eval(direction);
        let colors = |c: usize| best_colors(self.total.channel(c), p.channel(c));
        Ahd {
            ambient: T::from_channels(|c| T::Scalar::from_f64(colors(c)[0])),
            highlight: T::from_channels(|c| T::Scalar::from_f64(colors(c)[1])),
            direction,
        }
    }

    /// The decrease of the squared error by the best colors for `d`, and its gradient.
    fn explained(&self, d: Dir) -> (f64, [f64; 3]) {
        let (p, slope) = eval_with_gradient(&self.blurred, d);
        let (mut value, mut gradient) = (0.0, [0.0; 3]);
        for c in 0..T::CHANNELS {
            let (total, p) = (self.total.channel(c), p.channel(c));
            let [a, h] = best_colors(total, p);
            // |E|² - |A + H cos - E|² at the minimum, where A and H are multiplied by their own equations.
            value += a * total + h * p;
            for (sum, d) in gradient.iter_mut().zip(slope) {
                *sum += 2.0 * h * d.channel(c);
            }
        }
        (value, gradient)
    }
}

/// `A` and `H`, not negative, from `∫ E` and `∫ E max(n·d, 0)`.
fn best_colors(total: f64, p: f64) -> [f64; 2] {
    // The inverse of the matrix has the determinant 8π²/3 - π² = 5π²/3.
    let ambient = (2.0 / 3.0 * total - p) * 3.0 / (5.0 * PI);
    let highlight = (4.0 * p - total) * 3.0 / (5.0 * PI);
    if highlight < 0.0 {
        [not_negative(total / (4.0 * PI)), 0.0]
    } else if ambient < 0.0 {
        [0.0, not_negative(p * 3.0 / (2.0 * PI))]
    } else {
        [ambient, highlight]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rotation::Rotation;
    use crate::scalar::Rgb;
    use crate::sphere::quadrature::SphereQuadrature;
    use lobe_testkit::{Random, directions, fibonacci_sphere};

    /// An irradiance of some lights.
    fn lights(random: &mut Random, order: usize) -> ShVec<Rgb<f64>> {
        let mut e = ShVec::constant(order, Rgb::splat(PI * random.unit()));
        for _ in 0..4 {
            let color = Rgb::new(random.unit(), random.unit(), random.unit());
            e += &Zonal::clamped_cosine(order).towards(Dir::from_unit(random.direction()), color);
        }
        e
    }

    #[test]
    fn one_light_and_a_constant_come_back() {
        let (ambient, highlight) = (Rgb::new(0.5_f64, 1.0, 0.25), Rgb::new(2.0, 0.5, 1.0));
        for v in directions() {
            let direction = Dir::from_unit(v);
            let mut e = Zonal::clamped_cosine(32).towards(direction, highlight);
            e += &ShVec::constant(32, ambient);
            for found in [Ahd::linear(&e), Ahd::solved(&e), Ahd::towards(direction, &e)] {
                let off = found.direction.angle_to(direction);
                assert!(off < 1e-7, "direction {v:?} off by {off}");
                for (what, a, b) in [("A", found.ambient, ambient), ("H", found.highlight, highlight)] {
                    let error = (0..3).map(|c| (a.channel(c) - b.channel(c)).abs()).fold(0.0, f64::max);
                    // What bands above 31 hold of the cosine's energy.
                    assert!(error < 1e-4, "{what} towards {v:?}: {a:?} against {b:?}");
                }
            }
        }
    }

    #[test]
    fn the_colors_are_least_squares() {
        let mut random = Random::new(5);
        let e = lights(&mut random, 3);
        let d = Dir::from_unit(random.direction());
        let found = Ahd::towards(d, &e);
        let rule = SphereQuadrature::of_degree(200);
        for (what, f) in [("1", (|_| 1.0) as fn(f64) -> f64), ("cos", |t| t.max(0.0))] {
            let left = rule.integrate(|n| f(n.dot(d)) * (found.eval(n).g - e.eval(n).g));
            assert!(left.abs() < 1e-3, "the residual is not perpendicular to {what}: {left}");
        }
    }

    #[test]
    fn the_solved_direction_is_the_best_of_a_dense_grid() {
        let mut random = Random::new(6);
        let grid: Vec<Dir> = fibonacci_sphere(4000).into_iter().map(Dir::from_unit).collect();
        for case in 0..20 {
            let e = lights(&mut random, 7);
            let fitter = Fitter::new(&e);
            let solved = fitter.explained(Ahd::solved(&e).direction).0;
            let best = grid.iter().map(|d| fitter.explained(*d).0).fold(f64::NEG_INFINITY, f64::max);
            assert!(solved >= best, "case {case}: {solved} against {best} on the grid");
        }
    }

    #[test]
    fn it_turns_with_the_light_and_is_never_negative() {
        let mut random = Random::new(7);
        for case in 0..20 {
            let e = if case % 2 == 0 {
                lights(&mut random, 5)
            } else {
                ShVec::from_vec(random.signed_vec(25)).unwrap().map(|x| Rgb::new(x, -x, 0.5 * x))
            };
            let turn = Rotation::from_quaternion(random.quaternion()).unwrap();
            let turned = e.rotated(&turn);
            for (f, g) in [(Ahd::linear(&e), Ahd::linear(&turned)), (Ahd::solved(&e), Ahd::solved(&turned))] {
                for v in directions() {
                    let s = Dir::from_unit(v);
                    let (a, b) = (f.eval(s), g.eval(turn.rotate_dir(s)));
                    let error = (0..3).map(|c| (a.channel(c) - b.channel(c)).abs()).fold(0.0, f64::max);
                    assert!(error < 1e-6, "case {case} towards {v:?}: {a:?}, turned {b:?}");
                    assert!(a.r >= 0.0 && a.g >= 0.0 && a.b >= 0.0, "case {case} towards {v:?}: {a:?}");
                }
            }
        }
    }

    #[test]
    fn no_light_a_constant_and_nan_have_defined_answers() {
        for (what, found) in [("linear", Ahd::linear(&ShVec::<f64>::zero(3))), ("solved", Ahd::solved(&ShVec::zero(0)))]
        {
            assert_eq!(found, Ahd { ambient: 0.0, highlight: 0.0, direction: Dir::Z }, "{what}");
        }
        let flat = Ahd::solved(&ShVec::constant(3, PI));
        assert!((flat.eval(Dir::X) - PI).abs() < 1e-14 && flat.highlight.abs() < 1e-14, "{flat:?}");
        let mut spoiled = ShVec::constant(2, Rgb::splat(1.0));
        spoiled[0].g = f64::NAN;
        let e = Ahd::solved(&spoiled).eval(Dir::Y);
        assert!((e.r - 1.0).abs() < 1e-14 && e.g.is_nan() && (e.b - 1.0).abs() < 1e-14, "{e:?}");
    }
}
