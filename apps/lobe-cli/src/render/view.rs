//! Camera options of `lobe render`: the eye, its target, the field of view and the size of the picture.

use std::str::FromStr;

use clap::Args;
use lobe::io::JobArgs;
use lobe::render::{Camera, CameraOptions};
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
    #[command(flatten)]
    camera: JobArgs<CameraOptions>,
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
        Ok(self.camera.job().map(drop)?)
    }

    /// The camera for a box in the world.
    pub(crate) fn camera_around(&self, bounds: [[f64; 3]; 2]) -> anyhow::Result<Camera> {
        Ok(self.camera.job()?.camera(bounds)?)
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
