//! Several suns or lamps of a map, one after another.

use crate::map::mapped_map::MappedMap;
use crate::sky::no_sun::NoSun;
use crate::sky::sun_extraction::{Sun, SunOptions, take_sun};

/// The suns of a map, and the map without them.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct SunsReport {
    /// The lights extracted, from the brightest peak on.
    pub suns: Vec<Sun>,
    /// The map without them, see [`SunReport::rest`](crate::SunReport::rest).
    pub rest: MappedMap,
    /// Why there are no more, if they are fewer than were asked for.
    pub end: Option<NoSun>,
}

/// Extracts up to `count` suns or lamps by [`find_sun`](crate::find_sun()), each from the rest of those before. The
/// mean to which [`SunOptions::min_peak`] refers is that of the rest.
///
/// ```
/// use lobe_env::{SunOptions, bundled, extract_suns};
///
/// let lamps = extract_suns(&bundled::sunset().map(), 2, &SunOptions::default());
/// assert!(!lamps.suns.is_empty() && (lamps.suns.len() == 2) == lamps.end.is_none());
/// ```
#[must_use]
pub fn extract_suns(map: &MappedMap, count: usize, options: &SunOptions) -> SunsReport {
    let mut report = SunsReport { suns: Vec::new(), rest: map.clone(), end: None };
    for _ in 0..count {
        match take_sun(&mut report.rest, options) {
            Ok(sun) => report.suns.push(sun),
            Err(end) => {
                report.end = Some(end);
                break;
            }
        }
    }
    report
}
