//! Camera options of `lobe render`: the eye, its target, the field of view and the size of the picture.

use std::str::FromStr;

use anyhow::anyhow;
use clap::Args;
use lobe::render::{Camera, ViewPoint};
use lobe::scene::Scene;

use crate::args::values;

/// The most pixels on a side.
const MAX_SIDE: usize = 16384;

/// The camera and the picture.
#[derive(Args)]
pub(crate) struct ViewInput {
    /// Columns and rows of the picture
    #[arg(long, value_name = "WxH", default_value = "512x384")]
    size: Size,
    /// Where the eye is
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = values::numbers::<3>)]
    eye: Option<[f64; 3]>,
    /// What it looks at, in the middle of the picture [default: the middle of the scene]
    #[arg(long, value_name = "X,Y,Z", requires = "eye", allow_hyphen_values = true, value_parser = values::numbers::<3>)]
    target: Option<[f64; 3]>,
    /// Instead of --eye: degrees of the eye from +x towards +y and above the horizon, from where all of the scene is in
    /// view [default: -63,20]
    #[arg(long, value_name = "AZIMUTH,HEIGHT", conflicts_with = "eye", allow_hyphen_values = true, value_parser = values::numbers::<2>)]
    orbit: Option<[f64; 2]>,
    /// The angle from the lower to the upper edge of the picture, above 0 and below 180 degrees
    #[arg(long, value_name = "DEG", default_value_t = ViewPoint::FOV, value_parser = values::finite)]
    fov: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Size {
    width: usize,
    height: usize,
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || format!("expected columns x rows, each from 1 to {MAX_SIDE}, such as 640x480");
        let (width, height) = text.split_once('x').ok_or_else(expected)?;
        let side = |text| values::whole(text, 1, MAX_SIDE, "a side").map_err(|_| expected());
        Ok(Self { width: side(width)?, height: side(height)? })
    }
}

impl ViewInput {
    pub(crate) fn size(&self) -> (usize, usize) {
        (self.size.width, self.size.height)
    }

    pub(crate) fn camera(&self, scene: &Scene) -> anyhow::Result<Camera> {
        self.camera_around(scene.world_bounds())
    }

    /// Refuses a view that no scene has.
    pub(crate) fn check(&self) -> anyhow::Result<()> {
        // A box beside the eye, which so is not its middle, whatever the scene will be.
        let corner = self.eye.unwrap_or_default();
        let bounds = [corner, corner.map(|c| c + 1.0)];
        self.camera_around(bounds).map(drop)
    }

    /// The camera for a box in the world.
    pub(crate) fn camera_around(&self, bounds: [[f64; 3]; 2]) -> anyhow::Result<Camera> {
        let view = match (self.eye, self.orbit) {
            (Some(eye), _) => ViewPoint::At { eye, target: self.target },
            (None, Some([azimuth, height])) => ViewPoint::Orbit { azimuth, height },
            (None, None) => ViewPoint::default(),
        };
        view.camera(bounds, self.fov).map_err(|error| anyhow!("--{error}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_two_numbers() {
        assert_eq!("640x480".parse(), Ok(Size { width: 640, height: 480 }), "a size");
        for bad in ["640", "640x", "x480", "0x4", "4x99999", "4X4", "-1x4", "4x4x4"] {
            assert!(bad.parse::<Size>().is_err(), "{bad:?}");
        }
    }
}
