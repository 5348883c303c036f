//! The operations common to all expansions, whether the order is known at compile time or at run time.

use crate::basis::basis::Basis;
use crate::basis::index::{band_range, order_of_slice};
use crate::by_type::{by_type, of_each_type};
use crate::prelude::*;
use crate::scalar::Coefficient;
use crate::scalar::luminance;
use crate::sphere::Dir;

/// A function on the sphere, `f(s) = Σ_i f_i y_i(s)`, given by its coefficients in index order `i = l(l+1) + m`.
///
/// Implemented by [`Sh`](crate::Sh) (order known at compile time) and [`ShVec`](crate::ShVec) (at run time).
pub trait Expansion<T: Coefficient>: Clone {
    /// The coefficients, `n²` of them.
    fn coefficients(&self) -> &[T];

    /// The coefficients, to change.
    fn coefficients_mut(&mut self) -> &mut [T];

    /// The order `n`: the number of bands, one more than the highest band.
    fn order(&self) -> usize {
        order_of_slice(self.coefficients())
    }

    /// The `2l+1` coefficients of band `l`, `m` from `-l` to `l`.
    ///
    /// # Panics
    /// If `l >= order`.
    fn band(&self, l: usize) -> &[T] {
        &self.coefficients()[band_range(l)]
    }

    /// The coefficients of band `l`, to change.
    ///
    /// # Panics
    /// If `l >= order`.
    fn band_mut(&mut self, l: usize) -> &mut [T] {
        &mut self.coefficients_mut()[band_range(l)]
    }

    /// The integral over the sphere of the product of two functions, channel by channel.
    ///
    /// ```text
    ///   ∫ f g ds = Σ_i f_i g_i
    /// ```
    ///
    /// If the orders differ, the missing coefficients of the shorter one are zero. Summed in `f64`.
    fn dot(&self, other: &impl Expansion<T>) -> T {
        dot(self.coefficients(), other.coefficients())
    }

    /// The value `f(s)` towards `s`, summed in `f64`.
    fn eval(&self, s: Dir) -> T {
        let (coefficients, value) = (self.coefficients(), &mut [T::ZERO][..]);
        by_type!(T: coefficients; mut value => eval(coefficients, s, value));
        value[0]
    }

    /// The values towards many directions, given as slices of their x, y and z, one value each in `out`.
    ///
    /// Computed in the coefficients' own precision, a block of directions at a time.
    ///
    /// # Panics
    /// If the four slices differ in length.
    fn eval_many_into(&self, components: [&[T::Scalar]; 3], out: &mut [T]) {
        Basis::<T::Scalar>::with_shared(self.order(), |basis| {
            basis.eval_expansion_into(self.coefficients(), components, out);
        });
    }

    /// The energy of every band, `Σ_m f_lm²`, channel by channel; it does not change under rotation.
    fn band_energies(&self) -> Vec<T> {
        (0..self.order()).map(|l| dot(self.band(l), self.band(l))).collect()
    }

    /// The mean over the sphere, `f_00 / √(4π)`; zero for order 0.
    fn mean(&self) -> T {
        let y_00 = (4.0 * core::f64::consts::PI).sqrt().recip();
        self.coefficients().first().map_or(T::ZERO, |c| T::narrow(c.widen().scale(y_00)))
    }
}

of_each_type! {
    pub(super) fn eval(coefficients: &[T], s: Dir, value: &mut [T]) {
        let order = order_of_slice(coefficients);
        let mut sum = <T as Coefficient>::Wide::ZERO;
        Basis::<f64>::with_shared(order, |basis| {
            basis.for_each(s.to_array(), order, |i, y| sum += coefficients[i].widen().scale(y));
        });
        value[0] = T::narrow(sum);
    }
}

/// An expansion whose order is part of its type, so that a function can return it without being told the order.
///
/// Functions whose name ends in `_as` return any such type: [`project_as`](crate::project_as),
/// [`ShVec::product_as`](crate::ShVec::product_as), [`Zonal::towards_as`](crate::Zonal::towards_as),
/// [`Light::project_as`](crate::Light::project_as). [`Sh`](crate::Sh) is one; an engine can make its own type another, and then
/// gets its own type back:
///
/// ```
/// use lobe_sh::{Dir, Expansion, FixedOrder, Rgb, project_as};
///
/// #[derive(Clone)]
/// struct Probe([Rgb<f32>; 4]);
///
/// impl Expansion<Rgb<f32>> for Probe {
///     fn coefficients(&self) -> &[Rgb<f32>] {
///         &self.0
///     }
///
///     fn coefficients_mut(&mut self) -> &mut [Rgb<f32>] {
///         &mut self.0
///     }
/// }
///
/// impl FixedOrder for Probe {
///     type Value = Rgb<f32>;
///     const ORDER: usize = 2;
///
///     fn zero() -> Self {
///         Self([Rgb::default(); 4])
///     }
/// }
///
/// let sky = |s: Dir| Rgb::new(1.0, 1.0, 1.0 + 0.5 * s.z() as f32);
/// let probe = project_as::<Probe>(1, sky);
/// assert!((probe.eval(Dir::Z).b - 1.5).abs() < 1e-6);
/// ```
pub trait FixedOrder: Expansion<<Self as FixedOrder>::Value> {
    /// The type of one coefficient.
    type Value: Coefficient;

    /// The order `n`: the number of bands, so that there are `n²` coefficients.
    const ORDER: usize;

    /// The function that is zero everywhere.
    #[must_use]
    fn zero() -> Self;

    /// The function with these coefficients: those beyond `n²` are left out, missing ones are zero.
    #[must_use]
    fn from_coefficients(coefficients: &[Self::Value]) -> Self {
        let mut f = <Self as FixedOrder>::zero();
        for (f, c) in f.coefficients_mut().iter_mut().zip(coefficients) {
            *f = *c;
        }
        f
    }
}

/// `Σ_i a_i b_i` over the common length, in `f64`.
fn dot<T: Coefficient>(a: &[T], b: &[T]) -> T {
    let mut sum = T::Wide::ZERO;
    for (a, b) in a.iter().zip(b) {
        sum += a.widen() * b.widen();
    }
    T::narrow(sum)
}

/// The optimal linear direction: the direction of band 1, for colors that of their luminance.
///
/// ```text
///   d = (-f_3, -f_1, f_2) / |..|
/// ```
///
/// `None` below order 2, and if band 1 is zero or not finite.
#[must_use]
pub fn optimal_linear_direction<T: Coefficient>(f: &impl Expansion<T>) -> Option<Dir> {
    match f.coefficients() {
        [_, y, z, x, ..] => {
            let [x, y, z] = [*x, *y, *z].map(|c| luminance(c.widen()));
            Dir::new([-x, -y, z])
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expansion::{ShL2, ShVec};
    use crate::scalar::Rgb;
    use crate::sphere::quadrature::SphereQuadrature;
    use lobe_testkit::Random;

    fn random(order: usize, seed: u64) -> ShVec<f64> {
        ShVec::from_vec(Random::new(seed).signed_vec(order * order)).unwrap()
    }

    #[test]
    fn dot_energy_and_mean_are_their_integrals() {
        let (f, g) = (random(6, 1), random(4, 2));
        let rule = SphereQuadrature::of_degree(10);
        let close = |what: &str, found: f64, integral: f64| {
            assert!((found - integral).abs() < 1e-12, "{what}: {found} against {integral}");
        };
        close("dot", f.dot(&g), rule.integrate(|s| f.eval(s) * g.eval(s)));
        close("the other way", g.dot(&f), f.dot(&g));
        close("energy", f.band_energies().iter().sum(), rule.integrate(|s| f.eval(s) * f.eval(s)));
        close("mean", f.mean(), rule.integrate(|s| f.eval(s)) / (4.0 * core::f64::consts::PI));
    }

    #[test]
    fn bands_are_their_coefficients() {
        let mut f = ShL2::from([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0_f32]);
        assert_eq!(
            (f.band(0), f.band(1), f.band(2)),
            (&[0.0][..], &[1.0, 2.0, 3.0][..], &[4.0, 5.0, 6.0, 7.0, 8.0][..])
        );
        f.band_mut(1).fill(-1.0);
        assert_eq!(f.coefficients()[..5], [0.0, -1.0, -1.0, -1.0, 4.0], "after a change of band 1");
        assert_eq!(f.band_energies(), [0.0, 3.0, 190.0], "energies");
    }

    #[test]
    fn the_mean_of_a_constant_is_the_constant() {
        let color = Rgb::new(0.25_f32, 1.0, 3.0);
        let mean = ShL2::constant(color).mean();
        assert!((mean - color).to_array().iter().all(|d| d.abs() < 1e-6), "{mean:?}");
    }
}
