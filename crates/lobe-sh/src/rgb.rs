//! A color as three independent channels.

use std::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

use serde::{Deserialize, Serialize};

use crate::Real;

/// A linear color: red, green and blue with Rec. 709 primaries unless the data says otherwise.
///
/// Serialized as `[r, g, b]`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "[S; 3]", into = "[S; 3]")]
#[serde(bound(serialize = "S: Serialize + Clone", deserialize = "S: Deserialize<'de>"))]
#[repr(C)]
pub struct Rgb<S = f32> {
    /// Red.
    pub r: S,
    /// Green.
    pub g: S,
    /// Blue.
    pub b: S,
}

impl<S> Rgb<S> {
    /// A color from its channels.
    #[inline(always)]
    pub const fn new(r: S, g: S, b: S) -> Self {
        Self { r, g, b }
    }

    /// The channels in order.
    #[inline(always)]
    pub fn to_array(self) -> [S; 3] {
        [self.r, self.g, self.b]
    }
}

impl<S: Real> Rgb<S> {
    /// Relative luminance `0.2126 r + 0.7152 g + 0.0722 b` (ITU-R BT.709).
    #[must_use]
    pub fn luminance(self) -> S {
        self.r * S::from_f64(0.2126) + self.g * S::from_f64(0.7152) + self.b * S::from_f64(0.0722)
    }
}

impl<S> From<[S; 3]> for Rgb<S> {
    fn from([r, g, b]: [S; 3]) -> Self {
        Self { r, g, b }
    }
}

impl<S> From<Rgb<S>> for [S; 3] {
    fn from(c: Rgb<S>) -> Self {
        [c.r, c.g, c.b]
    }
}

macro_rules! channelwise {
    ($trait:ident, $method:ident, $op:tt) => {
        impl<S: Real> $trait for Rgb<S> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, o: Self) -> Self {
                Self::new(self.r $op o.r, self.g $op o.g, self.b $op o.b)
            }
        }
    };
}

channelwise!(Add, add, +);
channelwise!(Sub, sub, -);
channelwise!(Mul, mul, *);

impl<S: Real> Neg for Rgb<S> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self::new(-self.r, -self.g, -self.b)
    }
}

impl<S: Real> AddAssign for Rgb<S> {
    #[inline(always)]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl<S: Real> SubAssign for Rgb<S> {
    #[inline(always)]
    fn sub_assign(&mut self, o: Self) {
        *self = *self - o;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_has_luminance_one_and_green_the_most_of_it() {
        assert!((Rgb::new(1.0_f64, 1.0, 1.0).luminance() - 1.0).abs() < 1e-15, "white");
        assert_eq!(Rgb::new(0.0, 2.0, 0.0).luminance(), 2.0 * 0.7152, "green");
    }

    #[test]
    fn arithmetic_acts_on_each_channel() {
        let (a, b) = (Rgb::new(1.0, 2.0, 3.0), Rgb::new(4.0, -5.0, 0.5));
        assert_eq!((a + b, a - b), (Rgb::new(5.0, -3.0, 3.5), Rgb::new(-3.0, 7.0, 2.5)), "sum and difference");
        assert_eq!((a * b, -a), (Rgb::new(4.0, -10.0, 1.5), Rgb::new(-1.0, -2.0, -3.0)), "product and negative");
        let mut c = a;
        c += b;
        c -= a;
        assert_eq!(<[f64; 3]>::from(c), b.to_array(), "there and back");
    }
}
