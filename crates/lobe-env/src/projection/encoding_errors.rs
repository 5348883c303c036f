//! Errors of compact encodings of the irradiance under a map.

use lobe_io::{Job, Progress};
use lobe_sh::encoding::{EncodingError, IrradianceEncoding, encoding_error};
use lobe_sh::sphere::even_directions;
use lobe_sh::{Dir, Rgb, ShVec};
use web_time::Instant;

use crate::error::EnvError;
use crate::map::env_map::EnvMap;
use crate::projection::irradiance::{irradiance_at, irradiance_sh};

/// The order of the irradiance that is encoded. Of a single lamp the bands left out have an RMS of 2.4 % of the mean
/// (that of the clamped cosine beyond band 10, 0.0059 of 1/4); they concern only what is sampled or fitted over a
/// hemisphere.
const ORDER: usize = 12;

/// Normals towards which the encodings are compared with the sum over all texels.
const NORMALS: usize = 1024;

/// Normals between two reports, for each of which the map is prepared for summing.
const REPORTED: usize = 64;

/// The errors of all encodings.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct EncodingErrors {
    /// The mean irradiance of all channels over all normals, the unit of the errors.
    pub mean: f64,
    /// The error of each of [`IrradianceEncoding::ALL`].
    pub encodings: Vec<(IrradianceEncoding, EncodingError)>,
}

/// The irradiance under a map as it is given to encodings: of order 12.
#[must_use]
pub fn irradiance_to_encode(map: &EnvMap) -> ShVec<Rgb<f64>> {
    irradiance_sh(map, ORDER)
}

/// The error of every encoding of [`irradiance_to_encode`] against the sum over all texels, for 1024 normals that cover the
/// sphere evenly.
///
/// Progress counts normals. The job cannot be resumed.
///
/// # Errors
/// [`EnvError::Options`] for a job with a checkpoint; [`EnvError::Cancelled`] if the callback cancelled it.
pub fn encoding_errors(map: &EnvMap, mut job: Job<'_>) -> Result<EncodingErrors, EnvError> {
    job.expect_no_checkpoint().map_err(EnvError::Options)?;
    let start = Instant::now();
    let mut report = |done| {
        let progress = Progress { done, total: NORMALS, elapsed: start.elapsed(), ..Progress::default() };
        if job.report(&progress).is_break() { Err(EnvError::Cancelled) } else { Ok(()) }
    };
    let normals: Vec<Dir> = even_directions(NORMALS).collect();
    let mut truth = Vec::new();
    for normals in normals.chunks(REPORTED) {
        report(truth.len())?;
        truth.extend(normals.iter().copied().zip(irradiance_at(map, normals)));
    }
    report(NORMALS)?;
    let mean = truth.iter().flat_map(|(_, e)| e.to_array()).sum::<f64>() / (3 * NORMALS) as f64;
    let irradiance = irradiance_to_encode(map);
    let of = |encoding: IrradianceEncoding| (encoding, encoding_error(encoding, &irradiance, &truth));
    Ok(EncodingErrors { mean, encodings: IrradianceEncoding::ALL.into_iter().map(of).collect() })
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use lobe_sh::Coefficient as _;

    use super::*;

    #[test]
    fn nine_coefficients_hold_the_irradiance_of_two_bands_and_two_bands_do_not_that_of_three() {
        let map = EnvMap::from_fn(64, 32, |s| Rgb::splat(1.0 + 0.5 * s.z() as f32 + (s.x() * s.y()) as f32));
        let mut reported = Vec::new();
        let mut watch = |progress: &Progress| {
            reported.push(progress.done);
            ControlFlow::Continue(())
        };
        let found = encoding_errors(&map, Job::default().watched_by(&mut watch)).unwrap();
        assert_eq!((reported.len(), reported[1], reported[16]), (17, 64, 1024), "{reported:?}");
        assert!((found.mean / std::f64::consts::PI - 1.0).abs() < 1e-2, "{}", found.mean);
        let rms = |wanted| found.encodings.iter().find(|(encoding, _)| *encoding == wanted).unwrap().1.rms;
        let [two, three] = [IrradianceEncoding::Sh2, IrradianceEncoding::Sh3].map(rms);
        assert!(three < 2e-3 && two > 0.05, "{three} of order 3, {two} of order 2");
    }

    #[test]
    fn a_watch_stops_it() {
        let map = EnvMap::from_fn(8, 4, |_| Rgb::splat(1.0));
        let mut watch = |_: &Progress| ControlFlow::Break(());
        let stopped = encoding_errors(&map, Job::default().watched_by(&mut watch));
        assert!(matches!(stopped, Err(EnvError::Cancelled)), "{stopped:?}");
    }
}
