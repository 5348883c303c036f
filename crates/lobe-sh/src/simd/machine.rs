//! The instructions of the machine, and the kernels that use them.

#[cfg(feature = "simd")]
use alloc::format;

#[cfg(feature = "simd")]
use crate::error::ShError;

/// The instructions by which kernels run: those of AVX-512, of AVX2 with fused multiply-adds, of NEON, or plain code.
///
/// The environment variable `LOBE_SIMD`, `plain`, `avx2` or `avx512`, keeps every kernel of the process from wider
/// instructions than it names, except for the rays of `lobe-scene`, which hit the same by any. Programs refuse any other
/// value by [`check_limit`](Self::check_limit); here it is ignored.
///
/// Wide instructions round a product and a sum together. Results by them differ from those of plain code in the last
/// digits, and are the same by AVX2 and AVX-512, whatever the number of threads.
///
/// ```
/// use lobe_sh::simd::Machine;
///
/// // From wide to narrow; plain code runs everywhere.
/// let all: Vec<Machine> = Machine::available().collect();
/// assert_eq!(all.last().map(|machine| machine.name()), Some("plain"));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Machine(Instructions);

#[derive(Clone, Copy, Debug)]
enum Instructions {
    Plain,
    #[cfg(all(feature = "simd", target_arch = "x86_64"))]
    Avx2(pulp::x86::V3),
    #[cfg(all(feature = "simd", target_arch = "x86_64"))]
    Avx512(pulp::x86::V4),
    #[cfg(all(feature = "simd", target_arch = "aarch64"))]
    Neon(pulp::aarch64::Neon),
}

/// A computation that is written for lanes and, as the specification of what it computes, in plain code.
pub trait Kernel {
    /// The result.
    type Output;

    /// By lanes. To be marked `#[inline(always)]`, as all that it calls, or it is compiled without the instructions; closures
    /// cannot be marked, so that they have no place in it.
    #[cfg(feature = "simd")]
    fn wide<S: pulp::Simd>(self, simd: S) -> Self::Output;

    /// In plain code.
    fn plain(self) -> Self::Output;
}

impl Machine {
    /// Plain code.
    pub const PLAIN: Self = Self(Instructions::Plain);

    /// The widest instructions of this machine that `LOBE_SIMD` allows. Asked for once; without the feature `std`, plain code.
    #[must_use]
    pub fn detect() -> Self {
        #[cfg(feature = "simd")]
        {
            static WIDEST: std::sync::OnceLock<Machine> = std::sync::OnceLock::new();
            *WIDEST.get_or_init(|| Self::widest_within(std::env::var("LOBE_SIMD").ok().as_deref()))
        }
        #[cfg(not(feature = "simd"))]
        Self::PLAIN
    }

    /// Checks that `LOBE_SIMD` is not set, empty, or names instructions, of whatever kind of machine.
    ///
    /// ```
    /// use lobe_sh::simd::Machine;
    ///
    /// assert!(Machine::check_limit().is_ok(), "the tests are run without it");
    /// ```
    ///
    /// # Errors
    /// [`ShError::Options`] for another value, such as a typing error.
    #[cfg(feature = "simd")]
    pub fn check_limit() -> Result<(), ShError> {
        std::env::var_os("LOBE_SIMD").map_or(Ok(()), |limit| check_name(&limit))
    }

    /// The widest instructions that are no wider than those named; the widest of all if no name is known.
    #[cfg(feature = "simd")]
    fn widest_within(limit: Option<&str>) -> Self {
        let place = |name: &str| NAMES.iter().position(|known| *known == name);
        let first = limit.and_then(place).unwrap_or(0);
        Self::available().find(|machine| place(machine.name()) >= Some(first)).unwrap_or(Self::PLAIN)
    }

    /// All that this machine has, from wide to narrow.
    pub fn available() -> impl Iterator<Item = Self> {
        #[cfg(all(feature = "simd", target_arch = "x86_64"))]
        let wide =
            [pulp::x86::V4::try_new().map(Instructions::Avx512), pulp::x86::V3::try_new().map(Instructions::Avx2)];
        #[cfg(all(feature = "simd", target_arch = "aarch64"))]
        let wide = [pulp::aarch64::Neon::try_new().map(Instructions::Neon)];
        #[cfg(not(all(feature = "simd", any(target_arch = "x86_64", target_arch = "aarch64"))))]
        let wide = [None];
        wide.into_iter().flatten().chain([Instructions::Plain]).map(Self)
    }

    /// `avx512`, `avx2`, `neon` or `plain`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self.0 {
            Instructions::Plain => "plain",
            #[cfg(all(feature = "simd", target_arch = "x86_64"))]
            Instructions::Avx2(_) => "avx2",
            #[cfg(all(feature = "simd", target_arch = "x86_64"))]
            Instructions::Avx512(_) => "avx512",
            #[cfg(all(feature = "simd", target_arch = "aarch64"))]
            Instructions::Neon(_) => "neon",
        }
    }

    /// The same for [`pulp::WithSimd`], a computation that is its own plain code.
    #[cfg(feature = "simd")]
    #[must_use]
    pub fn arch(self) -> pulp::Arch {
        match self.0 {
            Instructions::Plain => pulp::Arch::Scalar,
            #[cfg(target_arch = "x86_64")]
            Instructions::Avx2(v3) => pulp::Arch::V3(v3),
            #[cfg(target_arch = "x86_64")]
            Instructions::Avx512(v4) => pulp::Arch::V4(v4),
            #[cfg(target_arch = "aarch64")]
            Instructions::Neon(neon) => pulp::Arch::Neon(neon),
        }
    }

    /// AVX2 with fused multiply-adds, which machines with AVX-512 have too.
    #[cfg(all(feature = "simd", target_arch = "x86_64"))]
    #[must_use]
    pub fn avx2(self) -> Option<pulp::x86::V3> {
        match self.0 {
            Instructions::Plain => None,
            Instructions::Avx2(v3) => Some(v3),
            Instructions::Avx512(v4) => Some(*v4),
        }
    }

    /// Whether kernels run in plain code.
    #[must_use]
    pub fn is_plain(self) -> bool {
        matches!(self.0, Instructions::Plain)
    }

    /// Runs a kernel.
    #[inline]
    pub fn run<K: Kernel>(self, kernel: K) -> K::Output {
        match self.0 {
            Instructions::Plain => kernel.plain(),
            #[cfg(all(feature = "simd", target_arch = "x86_64"))]
            Instructions::Avx2(v3) => v3.vectorize(Job(v3, kernel)),
            #[cfg(all(feature = "simd", target_arch = "x86_64"))]
            Instructions::Avx512(v4) => v4.vectorize(Job(v4, kernel)),
            #[cfg(all(feature = "simd", target_arch = "aarch64"))]
            Instructions::Neon(neon) => pulp::Simd::vectorize(neon, Job(neon, kernel)),
        }
    }
}

impl Machine {
    /// Runs a kernel that has one number at a time in a register, for which AVX-512 has nothing that AVX2 has not: it
    /// is compiled once less.
    #[inline]
    pub(crate) fn run_scalar<K: Kernel>(self, kernel: K) -> K::Output {
        #[cfg(all(feature = "simd", target_arch = "x86_64"))]
        if let Some(v3) = self.avx2() {
            return v3.vectorize(Job(v3, kernel));
        }
        #[cfg(all(feature = "simd", target_arch = "aarch64"))]
        if let Instructions::Neon(neon) = self.0 {
            return pulp::Simd::vectorize(neon, Job(neon, kernel));
        }
        kernel.plain()
    }
}

/// All instructions, from wide to narrow.
#[cfg(feature = "simd")]
const NAMES: [&str; 4] = ["avx512", "avx2", "neon", "plain"];

#[cfg(feature = "simd")]
fn check_name(limit: &std::ffi::OsStr) -> Result<(), ShError> {
    if limit.is_empty() || NAMES.iter().any(|known| limit == *known) {
        return Ok(());
    }
    let found = limit.to_string_lossy();
    Err(ShError::Options(format!(
        "LOBE_SIMD: expected plain, neon, avx2 or avx512, found `{found}`; correct or unset it"
    )))
}

/// A kernel with its instructions: a type, because closures are not compiled for them.
#[cfg(all(feature = "simd", any(target_arch = "x86_64", target_arch = "aarch64")))]
struct Job<S, K>(S, K);

#[cfg(all(feature = "simd", any(target_arch = "x86_64", target_arch = "aarch64")))]
impl<S: pulp::Simd, K: Kernel> pulp::NullaryFnOnce for Job<S, K> {
    type Output = K::Output;

    #[inline(always)]
    fn call(self) -> K::Output {
        self.1.wide(self.0)
    }
}

#[cfg(all(test, feature = "simd"))]
mod tests {
    use super::*;

    #[test]
    fn a_limit_keeps_from_wider_instructions_and_an_unknown_one_does_not() {
        let widest = Machine::available().next().map(Machine::name);
        assert_eq!(Some(Machine::widest_within(None).name()), widest, "no limit");
        assert_eq!(Some(Machine::widest_within(Some("fast")).name()), widest, "an unknown limit");
        assert_eq!(Machine::widest_within(Some("plain")).name(), "plain", "plain code");
        let names: Vec<_> = Machine::available().map(Machine::name).collect();
        if names.contains(&"avx2") {
            assert_eq!(Machine::widest_within(Some("avx2")).name(), "avx2", "of {names:?}");
        }
    }

    #[test]
    fn a_limit_that_names_no_instructions_is_refused() {
        for known in ["", "plain", "neon", "avx2", "avx512"] {
            assert!(check_name(known.as_ref()).is_ok(), "`{known}`");
        }
        for unknown in ["plains", "AVX2", " avx2", "sse", "0"] {
            let message = check_name(unknown.as_ref()).unwrap_err().to_string();
            let expected = "LOBE_SIMD: expected plain, neon, avx2 or avx512, found `";
            assert!(message.starts_with(expected) && message.contains(unknown), "{message}");
        }
    }

    #[test]
    fn all_ways_to_ask_for_instructions_agree() {
        for machine in Machine::available() {
            let is_scalar = matches!(machine.arch(), pulp::Arch::Scalar);
            assert_eq!(is_scalar, machine.is_plain(), "{}", machine.name());
            #[cfg(target_arch = "x86_64")]
            assert_eq!(machine.avx2().is_none(), machine.is_plain(), "{}", machine.name());
        }
    }
}
