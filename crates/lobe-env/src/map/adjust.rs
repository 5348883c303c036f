//! Exposure, clamping and blackening of negative texels.

use lobe_io::parallel;
use lobe_sh::{Coefficient, Rgb};

use crate::error::EnvError;
use crate::map::mapped_map::MappedMap;

/// Multiplies the radiance of a map by `2^stops`.
///
/// # Errors
/// [`EnvError::Options`] if a finite channel of some texel would not be finite; then the map is as it was.
pub fn expose_in_place(map: &mut MappedMap, stops: f64) -> Result<(), EnvError> {
    let factor = stops.exp2();
    scale_in_place(map, Rgb::new(factor, factor, factor))
}

/// Multiplies each channel of a map.
///
/// # Errors
/// [`EnvError::Options`] if a finite channel of some texel would not be finite; then the map is as it was.
pub fn scale_in_place(map: &mut MappedMap, factor: Rgb<f64>) -> Result<(), EnvError> {
    let scaled =
        |texel: &Rgb<f32>| Rgb::<f32>::from_channels(|c| (f64::from(texel.channel(c)) * factor.channel(c)) as f32);
    let is_lost = |texel: &Rgb<f32>| {
        let after = scaled(texel);
        (0..3).any(|c| texel.channel(c).is_finite() && !after.channel(c).is_finite())
    };
    let lost = parallel::map(map.height(), &|y| map.row(y).iter().filter(|texel| is_lost(texel)).count());
    let lost: usize = lost.into_iter().sum();
    if lost > 0 {
        let [r, g, b] = factor.to_array();
        let texels = if lost == 1 { "1 texel" } else { &format!("{lost} texels") };
        let message =
            format!("multiplied by {r} {g} {b}, {texels} would be brighter than {:e}, the most there is", f32::MAX);
        return Err(EnvError::Options(message));
    }
    let width = map.width();
    parallel::rows(map.texels_mut(), width, &|_, row| row.iter_mut().for_each(|texel| *texel = scaled(texel)));
    Ok(())
}

/// The report of clamping.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct ClampReport {
    /// The number of texels above the limit.
    pub texels: usize,
    /// The largest channel of any texel, before.
    pub largest: f32,
    /// The mean radiance before.
    pub mean_before: Rgb<f64>,
    /// The mean radiance after.
    pub mean_after: Rgb<f64>,
}

impl ClampReport {
    /// The fraction of the energy of each channel that is lost, from 0 to 1; 0 for a channel without any.
    #[must_use]
    pub fn removed(&self) -> Rgb<f64> {
        Rgb::from_channels(|c| {
            let before = self.mean_before.channel(c);
            if before == 0.0 { 0.0 } else { 1.0 - self.mean_after.channel(c) / before }
        })
    }
}

/// Scales every texel with a channel above `limit` down to it: the color keeps its hue, and energy is lost.
///
/// The report says how much.
///
/// # Errors
/// [`EnvError::Options`] if `limit` is negative or not a number.
pub fn clamp_in_place(map: &mut MappedMap, limit: f32) -> Result<ClampReport, EnvError> {
    if limit.is_nan() || limit < 0.0 {
        return Err(EnvError::Options(format!("a radiance to clamp to is 0 or more, but {limit} was given")));
    }
    let mean_before = map.mean();
    let channel = |texel: &Rgb<f32>| texel.r.max(texel.g).max(texel.b);
    let rows: Vec<(f32, usize)> = parallel::map(map.height(), &|y| {
        let largest = map.row(y).iter().map(channel).fold(f32::NEG_INFINITY, f32::max);
        (largest, map.row(y).iter().filter(|texel| channel(texel) > limit).count())
    });
    let largest = rows.iter().map(|(largest, _)| *largest).fold(f32::NEG_INFINITY, f32::max);
    let texels = rows.iter().map(|(_, texels)| *texels).sum();
    let width = map.width();
    parallel::rows(map.texels_mut(), width, &|_, row| {
        for texel in row.iter_mut().filter(|texel| channel(texel) > limit) {
            // In f64: the quotient rounds the largest channel to the limit, never above it by more than its last digit.
            let scale = f64::from(limit) / f64::from(channel(texel));
            *texel = Rgb::from_channels(|c| ((f64::from(texel.channel(c)) * scale) as f32).min(limit));
        }
    });
    Ok(ClampReport { texels, largest, mean_before, mean_after: map.mean() })
}

/// The report of blackening negative channels.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct BlackenReport {
    /// The number of texels with a negative channel.
    pub texels: usize,
    /// The lowest channel of any texel, before; 0 if none was negative.
    pub lowest: f32,
    /// The increase of the mean radiance.
    pub added: Rgb<f64>,
}

/// Sets every negative channel to 0: light cannot be negative, but filters that resize pictures overshoot beside bright
/// lights.
///
/// That adds energy, which the filter moved to the bright light. If that light is a sun, extract it first
/// ([`extract_sun`](crate::extract_sun)): the negative texels beside it are then subtracted from it. NaN is left
/// unchanged.
pub fn blacken_negative_in_place(map: &mut MappedMap) -> BlackenReport {
    let before = map.mean();
    let channel = |texel: &Rgb<f32>| texel.r.min(texel.g).min(texel.b);
    let rows: Vec<(f32, usize)> = parallel::map(map.height(), &|y| {
        let lowest = map.row(y).iter().map(channel).fold(0.0, f32::min);
        (lowest, map.row(y).iter().filter(|texel| channel(texel) < 0.0).count())
    });
    let lowest = rows.iter().map(|(lowest, _)| *lowest).fold(0.0, f32::min);
    let texels = rows.iter().map(|(_, texels)| *texels).sum();
    let width = map.width();
    parallel::rows(map.texels_mut(), width, &|_, row| {
        for texel in row.iter_mut().filter(|texel| channel(texel) < 0.0) {
            *texel = Rgb::from_channels(|c| if texel.channel(c) < 0.0 { 0.0 } else { texel.channel(c) });
        }
    });
    BlackenReport { texels, lowest, added: map.mean() - before }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::bundled;
    use crate::mapping::mapping::Mapping;

    #[test]
    fn a_stop_doubles_the_light() {
        let mut map = MappedMap::from(bundled::studio().map());
        let before = map.mean();
        expose_in_place(&mut map, 1.0).unwrap();
        assert_eq!(map.mean(), before.scale(2.0), "one stop up");
        expose_in_place(&mut map, -1.0).unwrap();
        assert_eq!(map.mean(), before, "and down again");
    }

    #[test]
    fn each_channel_is_scaled_by_its_own_factor() {
        let mut map = MappedMap::from_fn(Mapping::LatLong, 8, 4, |_| Rgb::new(1.0, 2.0, 3.0));
        scale_in_place(&mut map, Rgb::new(3.0, 0.5, 0.0)).unwrap();
        assert!(map.texels().iter().all(|t| *t == Rgb::new(3.0, 1.0, 0.0)), "{:?}", map.texels()[0]);
    }

    #[test]
    fn what_would_be_infinite_is_refused_and_the_map_stays_whole() {
        let mut map = MappedMap::from_fn(Mapping::LatLong, 8, 4, |_| Rgb::new(1.0, 2.0, 0.0));
        let before = map.clone();
        for stops in [200.0, 128.0, f64::INFINITY, f64::NAN] {
            let error = expose_in_place(&mut map, stops);
            assert!(matches!(error, Err(EnvError::Options(_))) && map == before, "{stops} stops: {error:?}");
        }
        for factor in [Rgb::new(1e300, 1.0, 1.0), Rgb::new(1.0, -1e39, 1.0), Rgb::new(1.0, 1.0, f64::INFINITY)] {
            let error = scale_in_place(&mut map, factor);
            assert!(matches!(error, Err(EnvError::Options(_))) && map == before, "times {factor:?}: {error:?}");
        }
        expose_in_place(&mut map, 126.0).unwrap();
        assert_eq!(map.texels()[0].g, 2.0_f32.powi(127), "as bright as it can be");
    }

    #[test]
    fn negative_channels_become_black_and_the_light_that_adds_is_reported() {
        let mut map = MappedMap::from_fn(Mapping::EqualArea, 10, 10, |_| Rgb::new(1.0, 1.0, 1.0));
        map.texels_mut()[3] = Rgb::new(-4.0, 2.0, -0.5);
        let report = blacken_negative_in_place(&mut map);
        assert_eq!(map.texels()[3], Rgb::new(0.0, 2.0, 0.0), "what was not negative stays");
        assert!(report.texels == 1 && report.lowest == -4.0, "{report:?}");
        let error =
            (report.added - Rgb::new(0.04, 0.0, 0.005)).to_array().into_iter().fold(0.0, |w: f64, e| w.max(e.abs()));
        assert!(error < 1e-12, "a hundredth of what was missing: {report:?}");
        assert_eq!(
            blacken_negative_in_place(&mut map),
            BlackenReport { texels: 0, lowest: 0.0, added: Rgb::ZERO },
            "again"
        );
    }

    #[test]
    fn clamping_reports_what_is_lost_and_keeps_the_hue() {
        let mut map = MappedMap::from_fn(Mapping::EqualArea, 10, 10, |_| Rgb::new(1.0, 1.0, 1.0));
        map.texels_mut()[7] = Rgb::new(50.0, 100.0, 25.0);
        let report = clamp_in_place(&mut map, 2.0).unwrap();
        assert_eq!(map.texels()[7], Rgb::new(1.0, 2.0, 0.5), "the hue stays");
        assert!(report.texels == 1 && report.largest == 100.0, "{report:?}");
        // All texels have the same solid angle: means are plain means.
        let (before, after) = ((99.0 + 100.0) / 100.0, (99.0 + 2.0) / 100.0);
        assert!(
            (report.mean_before.g - before).abs() < 1e-12 && (report.mean_after.g - after).abs() < 1e-12,
            "{report:?}"
        );
        let removed = Rgb::new(49.0 / 149.0, 98.0 / 199.0, 24.5 / 124.0);
        let found = report.removed();
        let error = (found - removed).to_array().into_iter().fold(0.0, |worst: f64, e| worst.max(e.abs()));
        assert!(error < 1e-12, "{found:?} against {removed:?}");
        let error = clamp_in_place(&mut map, f32::NAN).unwrap_err().to_string();
        assert_eq!(error, "a radiance to clamp to is 0 or more, but NaN was given");
    }
}
