//! Cosine and sine of angles, without the angles.

#[cfg(not(feature = "std"))]
use num_traits::Float as _;

/// Squares below this have lost digits to underflow; their roots are negligible against the rounding of 1.
const ZERO_SQUARE: f64 = 1e-280;

/// Cosine and sine of one angle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CosSin {
    pub(crate) cos: f64,
    pub(crate) sin: f64,
}

impl CosSin {
    /// Those of the angle from the first axis to the vector `(x, y)`, `|x|, |y| <= 1`; those of 0 for a vector that is
    /// negligible against the rounding of 1.
    pub(crate) fn of_vector(x: f64, y: f64) -> Self {
        Self::and_length(x, y).0
    }

    /// Those of the sum of both angles.
    #[inline(always)]
    pub(crate) fn and(self, other: Self) -> Self {
        Self { cos: self.cos * other.cos - self.sin * other.sin, sin: self.sin * other.cos + self.cos * other.sin }
    }

    /// [`CosSin::of_vector`], and the length of the vector; 0 for one that is negligible.
    #[inline]
    pub(crate) fn and_length(x: f64, y: f64) -> (Self, f64) {
        let square = x * x + y * y;
        if square < ZERO_SQUARE {
            return (Self { cos: 1.0, sin: 0.0 }, 0.0);
        }
        let length = square.sqrt();
        let scale = length.recip();
        (Self { cos: x * scale, sin: y * scale }, length)
    }
}

/// Cosine and sine of `α`, `β`, `γ` with `R = R_z(α) R_y(β) R_z(γ)`.
//
// The last column of R is (sin β cos α, sin β sin α, cos β). With any α at all,
//
//   R_z(-α) R = R_y(β) R_z(γ)   has the second row   (sin γ, cos γ, 0).
//
// γ from that row compensates the error of α: close to β = 0 and π the direction (cos α, sin α) is rounding noise,
// but the product of the three rotations is still R, without a threshold for "close". The rows and columns of R being
// unit vectors, β and γ need no scaling.
#[inline]
pub(crate) fn zyz_of(m: &[[f64; 3]; 3]) -> [CosSin; 3] {
    let (alpha, sin_beta) = CosSin::and_length(m[0][2], m[1][2]);
    let sin = alpha.cos * m[1][0] - alpha.sin * m[0][0];
    let cos = alpha.cos * m[1][1] - alpha.sin * m[0][1];
    [alpha, CosSin { cos: m[2][2], sin: sin_beta }, CosSin { cos, sin }]
}
