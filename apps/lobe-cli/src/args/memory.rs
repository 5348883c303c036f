//! Memory limit: work that would take more is refused before it begins.

use std::fs::{self, File};
use std::io::Read as _;
use std::path::Path;

use anyhow::bail;
use clap::Args;
use lobe::image::{ExrLayers, FileFormat, PictureReadOptions};

use crate::args::values;

/// Bytes in memory while a file is read for each of the file: it, its numbers, and what is made of them; of a scene its triangles.
/// Measured 2.0 of a table, 3.0 of a scene, which a bake made finer.
pub(crate) const COPIES: u64 = 3;

/// Bytes of a gibibyte.
const GIB: f64 = (1_u64 << 30) as f64;

/// The limit without another choice, that of pictures: the most common machines have 8 GiB, and half of it is left for
/// the rest.
pub(crate) const GIB_BY_DEFAULT: f64 = PictureReadOptions::MAX_BYTES as f64 / GIB;

/// `--max-memory`. The scene is held against it when it is read, and the other work when that is known, each alone.
#[derive(Args)]
pub(crate) struct MemoryLimit {
    /// The most memory, in GiB, of a scene with its instances and its tree, and of work and files beside it. More is
    /// refused. 4 hold some 12 million triangles, which take about a minute to read; each instance counts
    #[arg(long, value_name = "GIB", default_value_t = GIB_BY_DEFAULT, value_parser = values::positive)]
    max_memory: f64,
}

impl MemoryLimit {
    /// A limit in GiB.
    pub(crate) fn of(gib: f64) -> Self {
        Self { max_memory: gib }
    }

    /// The limit in GiB.
    pub(crate) fn gib(&self) -> f64 {
        self.max_memory
    }

    /// The limit in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        (self.max_memory * GIB) as u64
    }

    /// Refuses a file of numbers that takes more than that while it is read, in any form: itself, its numbers, and what is made of
    /// them. One that cannot be read is left to its reader, which says so.
    pub(crate) fn check_file(&self, path: &Path, instead: &str) -> anyhow::Result<()> {
        let name = path.display().to_string();
        let check = |bytes: u64| self.check(&name, COPIES.saturating_mul(bytes), instead);
        check(fs::metadata(path).map_or(0, |file| file.len()))?;
        let mut begin = [0; 4];
        let is_exr = File::open(path).and_then(|mut file| file.read_exact(&mut begin)).is_ok()
            && matches!(FileFormat::of_bytes(&begin, &name), Ok(FileFormat::OpenExr));
        if is_exr && let Ok(bytes) = fs::read(path) {
            check(ExrLayers::bytes_in_memory(&bytes, &name)?)?;
        }
        Ok(())
    }

    /// Refuses the work `what`, which takes at most `bytes`, if that is above the limit or the system does not give it;
    /// `instead` is what a user can ask for then.
    pub(crate) fn check(&self, what: &str, bytes: u64, instead: &str) -> anyhow::Result<()> {
        if bytes as f64 > self.max_memory * GIB {
            let (gib, limit) = (bytes as f64 / GIB, self.max_memory);
            bail!(
                "{what} takes up to {bytes} bytes of memory ({gib:.1} GiB), more than the limit of {limit} GiB; ask for \
                 {instead}, or raise the limit with --max-memory"
            );
        }
        if !is_there(bytes) {
            bail!(
                "{what} takes up to {bytes} bytes of memory, which the system does not give; ask for {instead}, or make memory \
                 free"
            );
        }
        Ok(())
    }
}

/// Whether the system gives this many bytes in one piece. They are given back: the work itself would abort if refused.
fn is_there(bytes: u64) -> bool {
    let mut probe = Vec::<u8>::new();
    let is_there = usize::try_from(bytes).is_ok_and(|bytes| probe.try_reserve_exact(bytes).is_ok());
    // The compiler may leave out an allocation that is not used.
    std::hint::black_box(&probe);
    is_there
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_takes_too_much_is_refused_with_its_bytes() {
        let limit = MemoryLimit { max_memory: 0.5 };
        assert!(limit.check("--size 8x8", 1 << 29, "less").is_ok(), "the limit itself");
        let error = limit.check("--size 8x8", (1 << 29) + 1, "a smaller one").unwrap_err().to_string();
        assert_eq!(
            error,
            "--size 8x8 takes up to 536870913 bytes of memory (0.5 GiB), more than the limit of 0.5 GiB; ask for a smaller one, \
             or raise the limit with --max-memory"
        );
        let limit = MemoryLimit { max_memory: f64::MAX };
        let error = limit.check("--size 8x8", u64::MAX, "less").unwrap_err().to_string();
        assert!(error.contains("18446744073709551615 bytes of memory, which the system does not give"), "{error}");
    }
}
