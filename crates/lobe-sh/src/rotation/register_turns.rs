//! The rotations about z of one rotation, with the multiples of all angles side by side.
//
// The angles of R = R_z(α) R_y(β) R_z(γ) stand in its matrix but for ρ = sin β:
//
//   -R_20 + i R_21 = ρ e^{iγ}        R_22 + iρ = e^{iβ}        R_02 + i R_12 = ρ e^{iα}
//
// So powers of these three complex numbers, of the second with its imaginary part in units of ρ, need no root: the root
// is computed meanwhile. Powers of 1/ρ² scale them afterwards, and one of 1/ρ those of odd multiples.

use std::arch::x86_64::{__m128, __m256, __m256d};

use pulp::x86::V3;

/// The matrix of a rotation, row by row.
pub(crate) type Matrix = [[f64; 3]; 3];

/// Numbers of a register.
pub(crate) const LANES: usize = 8;

/// `m` in each place of a register of cosines or of sines.
pub(crate) const WAVES: [usize; LANES] = [0, 2, 4, 6, 1, 3, 5, 7];

/// Least `sin²β` that is divided by: what the rounding of a matrix, 1e-15, becomes is 1e-9 then, no digit of `f32`.
pub(crate) const LEAST_SQUARE: f64 = 1e-6;

/// `cos ma` and `sin ma` for the `m` of [`WAVES`].
#[derive(Clone, Copy)]
pub(crate) struct ZTurn {
    pub(crate) cos: __m256,
    pub(crate) sin: __m256,
}

/// The three rotations about z, `γ`, `-β` and `α`.
#[derive(Clone, Copy)]
pub(crate) struct Turns {
    /// By `γ`, where odd `m` lack a factor `1/ρ`.
    pub(crate) gamma: ZTurn,
    /// The factor, 1 for even `m`.
    pub(crate) odd: __m256,
    /// By `-β`.
    pub(crate) beta: ZTurn,
    /// By `α`.
    pub(crate) alpha: ZTurn,
    /// By `α`, where odd `m` lack `1/ρ`.
    pub(crate) short_alpha: ZTurn,
    /// `1/ρ²`.
    pub(crate) inverse_square: __m256,
}

/// Powers of the three numbers, one in each place; the last is filled up.
#[derive(Clone, Copy)]
struct Power {
    re: __m256d,
    im: __m256d,
}

impl Power {
    /// The product, `units` being the squares of those of the imaginary parts.
    #[inline(always)]
    fn times(self, v: V3, units: __m256d, other: Self) -> Self {
        let both = v.avx._mm256_mul_pd(self.im, v.avx._mm256_mul_pd(units, other.im));
        Self {
            re: v.fma._mm256_fmsub_pd(self.re, other.re, both),
            im: v.fma._mm256_fmadd_pd(self.im, other.re, v.avx._mm256_mul_pd(self.re, other.im)),
        }
    }

    #[inline(always)]
    fn single(self, v: V3) -> [__m128; 2] {
        [v.avx._mm256_cvtpd_ps(self.re), v.avx._mm256_cvtpd_ps(self.im)]
    }
}

/// An even and an odd power in the halves of a register, real and imaginary parts.
#[inline(always)]
fn halves(v: V3, even: [__m128; 2], odd: [__m128; 2]) -> [__m256; 2] {
    [v.avx._mm256_set_m128(odd[0], even[0]), v.avx._mm256_set_m128(odd[1], even[1])]
}

/// The first three columns of both halves.
#[inline(always)]
fn columns(v: V3, rows: [__m256; 4]) -> [__m256; 3] {
    let [a, b, c, d] = rows;
    let (low, next_low) = (v.avx._mm256_unpacklo_ps(a, b), v.avx._mm256_unpacklo_ps(c, d));
    let (high, next_high) = (v.avx._mm256_unpackhi_ps(a, b), v.avx._mm256_unpackhi_ps(c, d));
    [
        v.avx._mm256_shuffle_ps::<0x44>(low, next_low),
        v.avx._mm256_shuffle_ps::<0xee>(low, next_low),
        v.avx._mm256_shuffle_ps::<0x44>(high, next_high),
    ]
}

impl ZTurn {
    #[inline(always)]
    fn scaled(self, v: V3, by: __m256) -> Self {
        Self { cos: v.avx._mm256_mul_ps(self.cos, by), sin: v.avx._mm256_mul_ps(self.sin, by) }
    }
}

impl Turns {
    /// For `m < 2 PARTS`; `square` is `sin²β`, at least [`LEAST_SQUARE`]. Powers and scales are rounded to `f32` once.
    #[inline(always)]
    pub(crate) fn new<const PARTS: usize>(v: V3, m: &Matrix, square: f64) -> Self {
        let units = pulp::cast([1.0, square, 1.0, 0.0]);
        let one =
            Power { re: pulp::cast([-m[2][0], m[2][2], m[0][2], 1.0]), im: pulp::cast([m[2][1], 1.0, m[1][2], 0.0]) };
        let two = one.times(v, units, one);
        let three = two.times(v, units, one);
        let zero = [v.avx._mm256_setzero_ps(); 2];
        let first: [__m128; 2] = [pulp::cast([1.0_f32; 4]), pulp::cast([0.0_f32; 4])];
        let mut rows = [halves(v, first, one.single(v)), halves(v, two.single(v), three.single(v)), zero, zero];
        if PARTS > 2 {
            let four = two.times(v, units, two);
            rows[2] = halves(v, four.single(v), three.times(v, units, two).single(v));
            if PARTS > 3 {
                let six = three.times(v, units, three);
                rows[3] = halves(v, six.single(v), four.times(v, units, three).single(v));
            }
        }
        let [a, b, c, d] = rows;
        Self::of_powers(v, columns(v, [a[0], b[0], c[0], d[0]]), columns(v, [a[1], b[1], c[1], d[1]]), square)
    }

    /// From the powers of each number, real and imaginary parts.
    #[inline(always)]
    fn of_powers(v: V3, re: [__m256; 3], im: [__m256; 3], square: f64) -> Self {
        let (root, inverse) = (square.sqrt(), 1.0 / square);
        let fourth = inverse * inverse;
        let even: __m128 = pulp::cast([1.0, inverse as f32, fourth as f32, (fourth * inverse) as f32]);
        let even = v.avx._mm256_set_m128(even, even);
        let one = v.avx._mm256_set1_ps(1.0);
        let odd = v.avx._mm256_blend_ps::<0xf0>(one, v.avx._mm256_set1_ps((root * inverse) as f32));
        let (gamma, alpha) = (ZTurn { cos: re[0], sin: im[0] }, ZTurn { cos: re[2], sin: im[2] });
        let short_alpha = alpha.scaled(v, even);
        Self {
            gamma: gamma.scaled(v, even),
            odd,
            beta: ZTurn { cos: re[1], sin: v.avx._mm256_mul_ps(im[1], v.avx._mm256_set1_ps(-root as f32)) },
            alpha: short_alpha.scaled(v, odd),
            short_alpha,
            inverse_square: v.avx._mm256_set1_ps(inverse as f32),
        }
    }
}
