//! Panoramas by their XMP: which part of the sphere a photograph shows.
//!
//! ```text
//!   FullPanoWidthPixels, FullPanoHeightPixels                        the whole panorama, 360° by 180°
//!   CroppedAreaImageWidthPixels, CroppedAreaImageHeightPixels        this picture, before it was scaled
//!   CroppedAreaLeftPixels, CroppedAreaTopPixels                      where it lies
//!   PoseHeadingDegrees, PosePitchDegrees, PoseRollDegrees            how the camera was held
//! ```
//!
//! [Google 2013]. Phones and cameras of 360° write them, and programs that scale a photograph keep them.

use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, PI};

use crate::error::EnvError;
use crate::files::cropped::Padding;
use crate::files::cropped::Shown;

/// The only projection whose pictures are lat-long.
const EQUIRECTANGULAR: &str = "equirectangular";

/// The angles of the camera.
const POSES: [&str; 3] = ["PoseHeadingDegrees", "PosePitchDegrees", "PoseRollDegrees"];

/// Sides that differ by less, in texels, are the same: writers round halves up or down.
const ROUNDING: f64 = 1.0;

/// The part by which two sides of a picture may have been scaled unlike, besides rounding.
const SAME_SCALE: f64 = 0.01;

type Properties = BTreeMap<String, String>;

/// The part of the sphere that a picture of this size shows; none if the properties tell of no crop. Remarks for the
/// caller go to `told`; `place` stands for the file in messages.
///
/// # Errors
/// [`EnvError::UnknownMapping`] if the panorama has another projection, or the picture would lie outside of it.
pub(crate) fn shown(
    properties: &Properties,
    [width, height]: [usize; 2],
    padding: Padding,
    place: &str,
    told: &mut Vec<String>,
) -> Result<Option<Shown>, EnvError> {
    let in_doubt = |message: String| EnvError::UnknownMapping { place: place.into(), message };
    if let Some(other) = other_projection(properties) {
        return Err(in_doubt(format!(
            "its XMP says that it is a {other} panorama, and only {EQUIRECTANGULAR} ones are read"
        )));
    }
    told.extend(POSES.iter().filter_map(|pose| {
        let degrees = number(properties, pose).filter(|degrees| *degrees != 0.0)?;
        Some(format!("{pose}={degrees} of its XMP is not applied; turn the map where that matters"))
    }));
    let Some(crop) = Crop::of(properties, [width, height], told) else { return Ok(None) };
    let Crop { full, size, corner } = crop;
    let scales = [width as f64 / size[0], height as f64 / size[1]];
    let rounded = ROUNDING / size[0].min(size[1]);
    if (scales[0] / scales[1] - 1.0).abs() > SAME_SCALE + rounded {
        told.push(format!(
            "its XMP is of a picture of {} x {}, which this one is not, of {width} x {height}; it is ignored",
            size[0], size[1]
        ));
        return Ok(None);
    }
    if size[0] > full[0] + ROUNDING || corner[1] < -ROUNDING || corner[1] + size[1] > full[1] + ROUNDING {
        return Err(in_doubt(format!("its XMP places it outside of the whole panorama: {}", crop.told())));
    }
    if crop.is_whole() && width == 2 * height {
        return Ok(None);
    }
    let rest = match padding {
        _ if crop.is_whole() => "",
        Padding::Black => "; the rest is black",
        Padding::Edge => "; the rest is as its edges",
    };
    told.push(format!("a panorama, as its XMP says: {}{rest}", crop.told()));
    // What is a texel too high by rounding ends at the poles.
    let elevation = |row: f64| (FRAC_PI_2 - PI * row / full[1]).clamp(-FRAC_PI_2, FRAC_PI_2);
    let part = (size[0] / full[0]).min(1.0);
    Ok(Some(Shown {
        columns: [corner[0] / full[0], part],
        elevations: [elevation(corner[1] + size[1]), elevation(corner[1])],
    }))
}

/// A remark on properties that would matter, where something else says what the picture is.
pub(crate) fn passed_over(properties: &Properties, size: [usize; 2]) -> Option<String> {
    let crop = Crop::of(properties, size, &mut Vec::new()).filter(|crop| !crop.is_whole()).map(|crop| crop.told());
    let what = other_projection(properties).map(|other| format!("{other} projection")).or(crop)?;
    Some(format!("what its XMP says is passed over: {what}"))
}

fn other_projection(properties: &Properties) -> Option<&str> {
    let projection = properties.get("ProjectionType").map(String::as_str);
    projection.filter(|projection| !projection.eq_ignore_ascii_case(EQUIRECTANGULAR))
}

/// A property that is a number.
fn number(properties: &Properties, name: &str) -> Option<f64> {
    properties.get(name)?.parse().ok().filter(|number: &f64| number.is_finite())
}

/// Where a picture lies in the whole panorama, in texels of that.
#[derive(Debug)]
struct Crop {
    full: [f64; 2],
    size: [f64; 2],
    /// Column and row of the upper left corner.
    corner: [f64; 2],
}

impl Crop {
    /// The crop that the properties tell of; none, and a remark, if they do not say of what.
    fn of(properties: &Properties, stored: [usize; 2], told: &mut Vec<String>) -> Option<Self> {
        let side = |name: &str| number(properties, name).filter(|side| *side > 0.0);
        let full = [side("FullPanoWidthPixels"), side("FullPanoHeightPixels")];
        let size = [side("CroppedAreaImageWidthPixels"), side("CroppedAreaImageHeightPixels")];
        let corner = ["CroppedAreaLeftPixels", "CroppedAreaTopPixels"].map(|name| number(properties, name));
        let full = match full {
            [Some(width), Some(height)] => [width, height],
            [Some(width), None] => [width, 0.5 * width],
            [None, Some(height)] => [2.0 * height, height],
            [None, None] => {
                if size.iter().chain(&corner).any(Option::is_some) {
                    told.push("its XMP tells of a crop without the size of the whole panorama; it is ignored".into());
                }
                return None;
            }
        };
        let size = [0, 1].map(|k| size[k].unwrap_or(stored[k] as f64));
        if corner.iter().any(Option::is_none) && [0, 1].iter().any(|k| size[*k] != full[*k]) {
            told.push("its XMP does not say where the crop lies; it is taken to lie in the middle".into());
        }
        let corner = [0, 1].map(|k| corner[k].unwrap_or(0.5 * (full[k] - size[k])));
        Some(Self { full, size, corner })
    }

    fn is_whole(&self) -> bool {
        let same = |k: usize| (self.size[k] - self.full[k]).abs() < ROUNDING;
        same(0) && same(1) && self.corner == [0.0; 2]
    }

    fn told(&self) -> String {
        let ([width, height], [full_width, full_height], [left, top]) = (self.size, self.full, self.corner);
        format!("{width} x {height} texels from column {left} and row {top} on of {full_width} x {full_height}")
    }
}
