//! Progress and cancellation of searches.

use std::ops::ControlFlow;

use crate::cloth::{cloth, with_threads};
use lobe_io::{Job, Progress};
use lobe_prt::{
    Channels, CompressOptions, CompressedTransfer, PrtError, ZonalFitOptions, compress_table, error_curve, fit_zonal,
};

/// Watches work to its end, then stops it at every call: what it gives when nobody stops it.
fn watched<T>(what: &str, work: impl Fn(Job<'_>) -> Result<T, PrtError>) -> T {
    let mut seen: Vec<Progress> = Vec::new();
    let result = work(Job::default().watched_by(&mut |progress| {
        seen.push(*progress);
        ControlFlow::Continue(())
    }));
    assert!(seen.len() > 2, "{what} was called {} times", seen.len());
    let (first, last) = (seen[0], seen[seen.len() - 1]);
    assert_eq!((first.done, last.done), (0, last.total), "{what}: the first and the last call");
    assert!(seen.is_sorted_by_key(|progress| progress.done), "{what} never goes back");
    assert!(first.seconds_left().is_none() && last.seconds_left() == Some(0.0), "{what}: {first:?}, {last:?}");
    for stop_at in (1..=seen.len()).step_by(1 + seen.len() / 8) {
        let mut calls = 0;
        let stopped = work(Job::default().watched_by(&mut |_| {
            calls += 1;
            if calls >= stop_at { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        }));
        assert!(matches!(stopped, Err(PrtError::Cancelled)), "{what} stopped at call {stop_at}");
    }
    result.unwrap()
}

#[test]
fn compression_curves_and_fits_say_how_far_they_are_and_stop_when_they_are_told_to() {
    let transfer = cloth(16, 3, Channels::Rgb);
    for (clusters, components) in [(1, 4), (8, 3), (5, 0), (16, 2)] {
        let options = CompressOptions::default().clusters(clusters).components(components);
        let what = format!("compression to {clusters} clusters of {components}");
        if clusters == 1 {
            // There is nothing to search for.
            let stopped = CompressedTransfer::new(
                &transfer,
                &options,
                Job::default().watched_by(&mut |_| ControlFlow::Break(())),
            );
            assert!(matches!(stopped, Err(PrtError::Cancelled)), "{what}");
            continue;
        }
        let found = watched(&what, |job| CompressedTransfer::new(&transfer, &options, job));
        assert_eq!(found, CompressedTransfer::new(&transfer, &options, Job::default()).unwrap(), "{what}");
    }
    let options = CompressOptions::default();
    let (clusters, components) = ([1, 4, 8], [0, 2]);
    let curve = watched("curve", |job| error_curve(&transfer, &clusters, &components, &options, job));
    assert_eq!(curve, error_curve(&transfer, &clusters, &components, &options, Job::default()).unwrap(), "curve");
    let options = ZonalFitOptions::default().lobes(2);
    // The number of receivers between two calls depends on the threads; the result does not.
    let fit = with_threads(3, || watched("fit", |job| fit_zonal(&transfer, &options, job)));
    assert_eq!(fit, fit_zonal(&transfer, &options, Job::default()).unwrap(), "fit");
}

#[test]
fn searches_refuse_a_checkpoint_that_they_would_not_keep() {
    let transfer = cloth(4, 2, Channels::Gray);
    let kept = || Job::default().kept_in("a.checkpoint");
    let options = CompressOptions::default();
    let refusals = [
        compress_table(transfer.coefficients(), 4, &options, kept()).map(drop).unwrap_err(),
        error_curve(&transfer, &[1], &[1], &options, kept()).map(drop).unwrap_err(),
        fit_zonal(&transfer, &ZonalFitOptions::default(), kept()).map(drop).unwrap_err(),
    ];
    for refusal in refusals {
        assert!(matches!(refusal, PrtError::Options(_)), "{refusal}");
        assert!(refusal.to_string().ends_with("found a.checkpoint"), "{refusal}");
    }
}
