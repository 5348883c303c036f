//! Limit of memory: work that would take more is refused before it begins.

use std::hint;

use crate::options::field::OptionError;

/// Bytes of a gibibyte.
const GIB: f64 = (1_u64 << 30) as f64;

/// The most memory that work may take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MemoryLimit {
    gib: f64,
}

impl MemoryLimit {
    /// The limit in gibibytes without another choice: the most common machines have 8, and half of that is left for the
    /// rest.
    pub const DEFAULT_GIB: f64 = 4.0;

    /// A limit in gibibytes.
    #[must_use]
    pub fn of(gib: f64) -> Self {
        Self { gib }
    }

    /// A limit in bytes; none without one.
    #[must_use]
    pub fn of_bytes(bytes: Option<u64>) -> Self {
        Self { gib: bytes.map_or(f64::MAX, |bytes| bytes as f64 / GIB) }
    }

    /// The limit in gibibytes.
    #[must_use]
    pub fn gib(self) -> f64 {
        self.gib
    }

    /// The limit in bytes.
    #[must_use]
    pub fn bytes(self) -> u64 {
        (self.gib * GIB) as u64
    }

    /// Refuses the work `what`, which takes at most `bytes`, if that is above the limit or the system does not give it;
    /// `instead` is what a user can ask for then.
    ///
    /// # Errors
    /// [`OptionError`], whose message names the option `max_memory`.
    pub fn check(self, what: &str, bytes: u64, instead: &str) -> Result<(), OptionError> {
        let refused = |message: String| Err(OptionError::new("", message));
        // What is no number is no limit that anything keeps to.
        let is_within = bytes as f64 <= self.gib * GIB;
        if !is_within {
            let (found, limit) = (bytes as f64 / GIB, self.gib);
            return refused(format!(
                "{what} takes up to {bytes} bytes of memory ({found:.1} GiB), more than the limit of {limit} GiB; ask \
                 for {instead}, or raise the limit with @max_memory"
            ));
        }
        if !is_there(bytes) {
            return refused(format!(
                "{what} takes up to {bytes} bytes of memory, which the system does not give; ask for {instead}, or \
                 make memory free"
            ));
        }
        Ok(())
    }
}

/// Whether the system gives this many bytes in one piece. They are given back: the work itself would abort if refused.
fn is_there(bytes: u64) -> bool {
    let mut probe = Vec::<u8>::new();
    let is_there = usize::try_from(bytes).is_ok_and(|bytes| probe.try_reserve_exact(bytes).is_ok());
    // The compiler may leave out an allocation that is not used.
    hint::black_box(&probe);
    is_there
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_takes_too_much_is_refused_with_its_bytes() {
        let limit = MemoryLimit::of(0.5);
        assert!(limit.check("a map", 1 << 29, "less").is_ok(), "the limit itself");
        let error = limit.check("a map", (1 << 29) + 1, "a smaller one").unwrap_err().to_string();
        assert_eq!(
            error,
            "a map takes up to 536870913 bytes of memory (0.5 GiB), more than the limit of 0.5 GiB; ask for a smaller \
             one, or raise the limit with max_memory"
        );
        let error = MemoryLimit::of(f64::MAX).check("a map", u64::MAX, "less").unwrap_err().to_string();
        assert!(error.contains("18446744073709551615 bytes of memory, which the system does not give"), "{error}");
    }
}
