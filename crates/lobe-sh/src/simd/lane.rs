//! The numbers of which registers hold several.

use core::fmt::Debug;

use pulp::Simd;

use crate::scalar::Real;

/// `f32` or `f64`, and what registers of it do.
pub trait Lane: Real {
    /// As many numbers as a register of `S` holds.
    type Register<S: Simd>: Copy + Debug + Send + Sync + 'static;

    /// The numbers of a register.
    #[doc(hidden)]
    fn count<S: Simd>() -> usize;

    /// One number in every lane.
    #[doc(hidden)]
    fn splat<S: Simd>(simd: S, value: Self) -> Self::Register<S>;

    /// A slice as whole registers, and what is left.
    #[doc(hidden)]
    fn registers<S: Simd>(slice: &[Self]) -> (&[Self::Register<S>], &[Self]);

    /// The same to write to.
    #[doc(hidden)]
    fn registers_mut<S: Simd>(slice: &mut [Self]) -> (&mut [Self::Register<S>], &mut [Self]);

    /// `a + b`.
    #[doc(hidden)]
    fn add<S: Simd>(simd: S, a: Self::Register<S>, b: Self::Register<S>) -> Self::Register<S>;

    /// `a - b`.
    #[doc(hidden)]
    fn sub<S: Simd>(simd: S, a: Self::Register<S>, b: Self::Register<S>) -> Self::Register<S>;

    /// `a b`.
    #[doc(hidden)]
    fn mul<S: Simd>(simd: S, a: Self::Register<S>, b: Self::Register<S>) -> Self::Register<S>;

    /// `a / b`.
    #[doc(hidden)]
    fn div<S: Simd>(simd: S, a: Self::Register<S>, b: Self::Register<S>) -> Self::Register<S>;

    /// `√a`.
    #[doc(hidden)]
    fn sqrt<S: Simd>(simd: S, a: Self::Register<S>) -> Self::Register<S>;

    /// `a b + c`, rounded once where the machine can.
    #[doc(hidden)]
    fn mul_add<S: Simd>(simd: S, a: Self::Register<S>, b: Self::Register<S>, c: Self::Register<S>)
    -> Self::Register<S>;

    /// `-a`.
    #[doc(hidden)]
    fn neg<S: Simd>(simd: S, a: Self::Register<S>) -> Self::Register<S>;

    /// The smaller of each two.
    #[doc(hidden)]
    fn min<S: Simd>(simd: S, a: Self::Register<S>, b: Self::Register<S>) -> Self::Register<S>;

    /// The larger of each two.
    #[doc(hidden)]
    fn max<S: Simd>(simd: S, a: Self::Register<S>, b: Self::Register<S>) -> Self::Register<S>;

    /// `then` where `a < b`, `or` elsewhere.
    #[doc(hidden)]
    fn if_less<S: Simd>(simd: S, ab: [Self::Register<S>; 2], then_or: [Self::Register<S>; 2]) -> Self::Register<S>;

    /// Whether `a < b` in any lane.
    #[doc(hidden)]
    fn any_less<S: Simd>(simd: S, a: Self::Register<S>, b: Self::Register<S>) -> bool;
}

/// Registers of a number by the functions of pulp for it.
macro_rules! lane {
    ($number:ty, $register:ident, $lanes:ident, $splat:ident, $registers:ident, $registers_mut:ident, $add:ident, $sub:ident,
     $mul:ident, $div:ident, $sqrt:ident, $mul_add:ident, $xor:ident, $min:ident, $max:ident, $less:ident,
     $to_bits:ident, $from_bits:ident, $select:ident, $first_true:ident) => {
        impl Lane for $number {
            type Register<S: Simd> = S::$register;

            #[inline(always)]
            fn count<S: Simd>() -> usize {
                S::$lanes
            }

            #[inline(always)]
            fn splat<S: Simd>(simd: S, value: Self) -> S::$register {
                simd.$splat(value)
            }

            #[inline(always)]
            fn registers<S: Simd>(slice: &[Self]) -> (&[S::$register], &[Self]) {
                S::$registers(slice)
            }

            #[inline(always)]
            fn registers_mut<S: Simd>(slice: &mut [Self]) -> (&mut [S::$register], &mut [Self]) {
                S::$registers_mut(slice)
            }

            #[inline(always)]
            fn add<S: Simd>(simd: S, a: S::$register, b: S::$register) -> S::$register {
                simd.$add(a, b)
            }

            #[inline(always)]
            fn sub<S: Simd>(simd: S, a: S::$register, b: S::$register) -> S::$register {
                simd.$sub(a, b)
            }

            #[inline(always)]
            fn mul<S: Simd>(simd: S, a: S::$register, b: S::$register) -> S::$register {
                simd.$mul(a, b)
            }

            #[inline(always)]
            fn div<S: Simd>(simd: S, a: S::$register, b: S::$register) -> S::$register {
                simd.$div(a, b)
            }

            #[inline(always)]
            fn sqrt<S: Simd>(simd: S, a: S::$register) -> S::$register {
                simd.$sqrt(a)
            }

            #[inline(always)]
            fn mul_add<S: Simd>(simd: S, a: S::$register, b: S::$register, c: S::$register) -> S::$register {
                simd.$mul_add(a, b, c)
            }

            #[inline(always)]
            fn neg<S: Simd>(simd: S, a: S::$register) -> S::$register {
                simd.$xor(a, simd.$splat(-0.0))
            }

            #[inline(always)]
            fn min<S: Simd>(simd: S, a: S::$register, b: S::$register) -> S::$register {
                simd.$min(a, b)
            }

            #[inline(always)]
            fn max<S: Simd>(simd: S, a: S::$register, b: S::$register) -> S::$register {
                simd.$max(a, b)
            }

            #[inline(always)]
            fn if_less<S: Simd>(simd: S, [a, b]: [S::$register; 2], [then, or]: [S::$register; 2]) -> S::$register {
                // By their bits: the selection of numbers is a call of pulp that is compiled without AVX2.
                let (then, or) = (simd.$to_bits(then), simd.$to_bits(or));
                simd.$from_bits(simd.$select(simd.$less(a, b), then, or))
            }

            #[inline(always)]
            fn any_less<S: Simd>(simd: S, a: S::$register, b: S::$register) -> bool {
                simd.$first_true(simd.$less(a, b)) < S::$lanes
            }
        }
    };
}

lane!(
    f32,
    f32s,
    F32_LANES,
    splat_f32s,
    as_simd_f32s,
    as_mut_simd_f32s,
    add_f32s,
    sub_f32s,
    mul_f32s,
    div_f32s,
    sqrt_f32s,
    mul_add_e_f32s,
    xor_f32s,
    min_f32s,
    max_f32s,
    less_than_f32s,
    transmute_u32s_f32s,
    transmute_f32s_u32s,
    select_u32s,
    first_true_m32s
);
lane!(
    f64,
    f64s,
    F64_LANES,
    splat_f64s,
    as_simd_f64s,
    as_mut_simd_f64s,
    add_f64s,
    sub_f64s,
    mul_f64s,
    div_f64s,
    sqrt_f64s,
    mul_add_e_f64s,
    xor_f64s,
    min_f64s,
    max_f64s,
    less_than_f64s,
    transmute_u64s_f64s,
    transmute_f64s_u64s,
    select_u64s,
    first_true_m64s
);
