//! The one file of this crate with `unsafe`: no safe function reads the register of the vector unit.
#![cfg_attr(target_arch = "x86_64", allow(unsafe_code, reason = "two instructions that Rust has no safe function for"))]

/// Whether arithmetic of this thread meets a denormal number in `work`; `None` where the processor does not tell.
///
/// Processors of Intel leave their pipeline for some hundred cycles where a sum or a product has one. The flag for it
/// in the vector unit's register, MXCSR, is set by every x86, so that a test sees the trap on those too which pay
/// nothing.
pub fn meets_denormals(work: impl FnOnce()) -> Option<bool> {
    #[cfg(target_arch = "x86_64")]
    {
        clear_flags();
        work();
        Some(flags() & DENORMAL != 0)
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        work();
        None
    }
}

/// The bit of MXCSR that remembers a denormal operand.
#[cfg(target_arch = "x86_64")]
const DENORMAL: u32 = 1 << 1;

/// The bits of MXCSR that remember: the others are settings, which stay as they are.
#[cfg(target_arch = "x86_64")]
const FLAGS: u32 = 0x3f;

#[cfg(target_arch = "x86_64")]
fn flags() -> u32 {
    let mut register = 0_u32;
    // SAFETY: the instruction writes four bytes, to a number of four bytes.
    unsafe { std::arch::asm!("stmxcsr [{}]", in(reg) &raw mut register, options(nostack, preserves_flags)) };
    register & FLAGS
}

#[cfg(target_arch = "x86_64")]
fn clear_flags() {
    let mut register = 0_u32;
    // SAFETY: the first instruction writes four bytes, to a number of four bytes; the second reads them. Settings of
    // the register stay, and its flags may be changed by any code.
    unsafe {
        std::arch::asm!("stmxcsr [{}]", in(reg) &raw mut register, options(nostack, preserves_flags));
        register &= !FLAGS;
        std::arch::asm!("ldmxcsr [{}]", in(reg) &raw const register, options(nostack, preserves_flags));
    }
}

#[cfg(test)]
mod tests {
    use std::hint::black_box;

    use super::*;

    #[test]
    fn a_sum_with_a_denormal_number_is_noticed_and_one_without_is_not() {
        let sum = |a: f32, b: f32| {
            meets_denormals(|| {
                black_box(black_box(a) + black_box(b));
            })
        };
        let expected = |meets: bool| cfg!(target_arch = "x86_64").then_some(meets);
        assert_eq!(sum(f32::from_bits(7), 1.0), expected(true), "seven of the smallest numbers");
        assert_eq!(sum(f32::MIN_POSITIVE, 1.0), expected(false), "the smallest normal number");
        assert_eq!(sum(0.0, 1.0), expected(false), "zero");
    }
}
