//! Light that left the range of `f32`.

use lobe_io::parallel;
use lobe_sh::Rgb;

use crate::error::EnvError;

/// Texels that one thread looks through at a time.
const TOGETHER: usize = 4096;

/// Whether every channel of every texel is finite.
pub(crate) fn all_finite(texels: &[Rgb<f32>]) -> bool {
    count_lost(texels) == 0
}

/// Fails if sums over a map are more than `f32` holds; `what` they are begins the message.
///
/// A map that is not finite itself makes sums that are not: they are let through, unless `was_finite`, which is only
/// asked then.
pub(crate) fn expect_finite(sums: &[Rgb<f32>], what: &str, was_finite: impl FnOnce() -> bool) -> Result<(), EnvError> {
    let lost = count_lost(sums);
    if lost == 0 || !was_finite() {
        return Ok(());
    }
    let texels = if lost == 1 { "1 texel" } else { &format!("{lost} texels") };
    let message =
        format!("{what}: the sums of {texels} are more than {:e}, the most there is; darken the map", f32::MAX);
    Err(EnvError::Options(message))
}

/// The number of texels with a channel that is not finite.
fn count_lost(texels: &[Rgb<f32>]) -> usize {
    let of_part = |k: usize| {
        let part = &texels[k * TOGETHER..texels.len().min((k + 1) * TOGETHER)];
        part.iter().filter(|texel| !is_finite(texel)).count()
    };
    parallel::map(texels.len().div_ceil(TOGETHER), &of_part).into_iter().sum()
}

fn is_finite(texel: &Rgb<f32>) -> bool {
    texel.r.is_finite() && texel.g.is_finite() && texel.b.is_finite()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_the_sums_made_infinite_is_refused() {
        let (dark, bright) = (Rgb::new(1.0, -2.0, f32::MAX), Rgb::new(1.0, f32::INFINITY, 1.0));
        assert!(all_finite(&[dark; 3]) && !all_finite(&[dark, bright]), "a single channel counts");
        assert!(expect_finite(&[dark; 3], "light", || true).is_ok(), "the brightest number is one");
        assert!(expect_finite(&[bright], "light", || false).is_ok(), "it was infinite before");
        let error = expect_finite(&[dark, bright], "light", || true).unwrap_err().to_string();
        assert_eq!(error, "light: the sums of 1 texel are more than 3.4028235e38, the most there is; darken the map");
    }
}
