//! Expansion types that functions can return without being told the order.

use crate::{Coefficient, Dir, Expansion, Sh, ShVec, Zonal};

/// An expansion whose order is part of its type, so that a function can return it without being told the order.
///
/// Functions whose name ends in `_as` return any such type: [`project_as`](crate::project_as),
/// [`product_as`](crate::product_as), [`Zonal::towards_as`](crate::Zonal::towards_as),
/// [`Light::project_as`](crate::Light::project_as). [`Sh`] is one; an engine can make its own type another, and then
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

impl<const N: usize, T: Coefficient> FixedOrder for Sh<N, T> {
    type Value = T;
    const ORDER: usize = Self::ORDER;

    fn zero() -> Self {
        Self::zero()
    }
}

impl<T: Coefficient> ShVec<T> {
    /// The expansion as a type of fixed order: cut off, or filled up with zeros.
    ///
    /// ```
    /// use lobe_sh::{Dir, ShL1, ShVec};
    ///
    /// let light = ShVec::impulse(5, Dir::Z, 1.0_f32);
    /// assert_eq!(light.to_fixed::<ShL1>(), ShL1::impulse(Dir::Z, 1.0));
    /// ```
    #[must_use]
    pub fn to_fixed<E: FixedOrder<Value = T>>(&self) -> E {
        E::from_coefficients(self.coefficients())
    }
}

impl Zonal {
    /// [`Zonal::towards`] to the order of the type that is asked for.
    #[must_use]
    pub fn towards_as<E: FixedOrder>(&self, axis: Dir, value: E::Value) -> E {
        let mut f = <E as FixedOrder>::zero();
        self.towards_into(axis, value, f.coefficients_mut());
        f
    }
}
