//! Work after a bake that somebody watches and stops.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod cloth;

use std::ops::ControlFlow;

use cloth::{cloth, with_threads};
use lobe_prt::{
    Channels, CompressOptions, CompressedTransfer, Progress, PrtError, ZonalFitOptions, error_curve,
    error_curve_watched, fit_zonal, fit_zonal_watched,
};

/// What long work calls.
type OnProgress<'a> = &'a mut dyn FnMut(&Progress) -> ControlFlow<()>;

/// Watches work to its end, then stops it at every call: what it gives when nobody stops it.
fn watched<T>(what: &str, work: impl Fn(OnProgress<'_>) -> Result<T, PrtError>) -> T {
    let mut seen: Vec<Progress> = Vec::new();
    let result = work(&mut |progress| {
        seen.push(*progress);
        ControlFlow::Continue(())
    });
    assert!(seen.len() > 2, "{what} was called {} times", seen.len());
    let (first, last) = (seen[0], seen[seen.len() - 1]);
    assert_eq!((first.done, last.done), (0, last.total), "{what}: the first and the last call");
    assert!(seen.is_sorted_by_key(|progress| progress.done), "{what} never goes back");
    assert!(first.seconds_left().is_none() && last.seconds_left() == Some(0.0), "{what}: {first:?}, {last:?}");
    for stop_at in (1..=seen.len()).step_by(1 + seen.len() / 8) {
        let mut calls = 0;
        let stopped = work(&mut |_| {
            calls += 1;
            if calls >= stop_at { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        assert!(matches!(stopped, Err(PrtError::Cancelled)), "{what} stopped at call {stop_at}");
    }
    result.unwrap()
}

#[test]
fn compression_curves_and_fits_say_how_far_they_are_and_stop_when_they_are_told_to() {
    let transfer = cloth(16, 3, Channels::Rgb);
    for (clusters, components) in [(1, 4), (8, 3), (5, 0), (16, 2)] {
        let options = CompressOptions { clusters, components, ..CompressOptions::default() };
        let what = format!("compression to {clusters} clusters of {components}");
        if clusters == 1 {
            // There is nothing to search for.
            let stopped = CompressedTransfer::new_watched(&transfer, &options, &mut |_| ControlFlow::Break(()));
            assert!(matches!(stopped, Err(PrtError::Cancelled)), "{what}");
            continue;
        }
        let found = watched(&what, |progress| CompressedTransfer::new_watched(&transfer, &options, progress));
        assert_eq!(found, CompressedTransfer::new(&transfer, &options).unwrap(), "{what}");
    }
    let options = CompressOptions::default();
    let (clusters, components) = ([1, 4, 8], [0, 2]);
    let curve = watched("curve", |progress| error_curve_watched(&transfer, &clusters, &components, &options, progress));
    assert_eq!(curve, error_curve(&transfer, &clusters, &components, &options).unwrap(), "curve");
    let options = ZonalFitOptions { lobes: 2, ..ZonalFitOptions::default() };
    // How many receivers are fitted between two calls depends on the threads; what is found does not.
    let fit = with_threads(3, || watched("fit", |progress| fit_zonal_watched(&transfer, &options, progress)));
    assert_eq!(fit, fit_zonal(&transfer, &options).unwrap(), "fit");
}
