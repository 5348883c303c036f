//! Verbs of expansions: what is done with an expansion, as methods of both types: `light.rotated(&turn).convolved(&kernel).deringed()`. The kernels beneath take slices.

use crate::expansion::{Expansion, FixedOrder, Sh, ShVec, Zonal};
use crate::filter::Window;
use crate::filter::kernel::convolve_in_place;
use crate::filter::window::window_in_place;
use crate::product::product::product_into;
use crate::ringing::dering::dering_in_place;
use crate::ringing::dering::{DeringOptions, DeringReport};
use crate::rotation::Rotation;
use crate::rotation::axis_permutation::mirror_in_place;
use crate::rotation::axis_permutation::{Axis, AxisPermutation};
use crate::scalar::Coefficient;

/// The methods, once for each type.
macro_rules! verbs {
    ([$($generics:tt)*] $type:ty) => {
        impl<$($generics)*> $type {
            /// The function turned by a rotation: what it shows towards `s`, the result shows towards `R s`.
            #[must_use]
            pub fn rotated(&self, rotation: &Rotation) -> Self {
                let mut g = self.clone();
                rotation.apply_into(self.coefficients(), g.coefficients_mut());
                g
            }

            /// The function moved by an exchange of axes.
            #[must_use]
            pub fn permuted(&self, permutation: &AxisPermutation) -> Self {
                self.changed(|f| permutation.apply_in_place(f))
            }

            /// The function mirrored at the plane through the origin that an axis is normal to.
            #[must_use]
            pub fn mirrored(&self, axis: Axis) -> Self {
                self.changed(|f| mirror_in_place(f, axis))
            }

            /// The convolution with a zonal kernel, such as irradiance; see [`convolve_in_place`].
            ///
            /// ```
            /// use lobe_sh::{Dir, Expansion as _, ShL2, Zonal};
            ///
            /// let sky = ShL2::constant(1.0_f64);
            /// let irradiance = sky.convolved(&Zonal::clamped_cosine(3));
            /// assert!((irradiance.eval(Dir::Z) - std::f64::consts::PI).abs() < 1e-14);
            /// ```
            #[must_use]
            pub fn convolved(&self, kernel: &Zonal) -> Self {
                self.changed(|f| convolve_in_place(f, kernel))
            }

            /// The function under a window.
            #[must_use]
            pub fn windowed(&self, window: &Window) -> Self {
                self.changed(|f| window_in_place(f, window))
            }

            /// The function made non-negative by the least change; see [`dering_in_place`], which leaves what it cannot help as it is.
            #[must_use]
            pub fn deringed(&self) -> Self {
                self.deringed_with(&DeringOptions::default()).0
            }

            /// The function made non-negative by a method, and what became of it; see [`dering_in_place`].
            ///
            /// ```
            /// use lobe_sh::ringing::DeringOptions;
            /// use lobe_sh::{Dir, Expansion as _, ShL2, Zonal};
            ///
            /// // The irradiance of a sun rings below zero on the far side.
            /// let irradiance = ShL2::impulse(Dir::Z, 1.0_f64).convolved(&Zonal::clamped_cosine(3));
            /// assert!(irradiance.eval(Dir::from_angles(2.1, 0.0)) < -0.03);
            /// let (calm, report) = irradiance.deringed_with(&DeringOptions::default());
            /// assert!(report.after[0].lo > -1e-9 && report.energy_removed < 0.17, "{report:?}");
            /// assert_eq!(calm, irradiance.deringed());
            /// ```
            #[must_use]
            pub fn deringed_with(&self, options: &DeringOptions) -> (Self, DeringReport) {
                let mut g = self.clone();
                let report = dering_in_place(g.coefficients_mut(), options);
                (g, report)
            }

            /// The product with another function, cut off at `order`; see [`product_into`].
            #[must_use]
            pub fn product(&self, other: &impl Expansion<T>, order: usize) -> ShVec<T> {
                let mut out = ShVec::zero(order);
                product_into(self.coefficients(), other.coefficients(), out.coefficients_mut());
                out
            }

            /// The product, cut off at the order of the type that is asked for.
            ///
            /// ```
            /// use lobe_sh::{Dir, Expansion as _, ShL1, ShL2};
            ///
            /// let f = ShL1::impulse(Dir::X, 1.0_f64);
            /// let square: ShL2<f64> = f.product_as(&f);
            /// assert!((square.eval(Dir::X) - f.eval(Dir::X).powi(2)).abs() < 1e-14);
            /// ```
            #[must_use]
            pub fn product_as<E: FixedOrder<Value = T>>(&self, other: &impl Expansion<T>) -> E {
                let mut out = E::zero();
                product_into(self.coefficients(), other.coefficients(), out.coefficients_mut());
                out
            }

            fn changed(&self, change: impl FnOnce(&mut [T])) -> Self {
                let mut g = self.clone();
                change(g.coefficients_mut());
                g
            }
        }
    };
}

verbs! { [const N: usize, T: Coefficient] Sh<N, T> }
verbs! { [T: Coefficient] ShVec<T> }
