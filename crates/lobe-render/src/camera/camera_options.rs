//! Options of the camera, of all pictures of scenes.

use lobe_io::{Given, JobOptions, NumberRange, OptionError, OptionField, OptionKind, options};

use crate::camera::camera::Camera;
use crate::camera::view_point::ViewPoint;
use crate::error::RenderError;

options! {
    /// Where a picture is taken from.
    pub struct CameraOptions {
        /// Where the eye is
        eye: Option<[f64; 3]> = None, OptionKind::Numbers(3), "X,Y,Z", "";
        /// What it looks at, in the middle of the picture
        target: Option<[f64; 3]> = None, OptionKind::Numbers(3), "X,Y,Z", "the middle of the scene";
        /// Instead of `eye`: degrees of the eye from +x towards +y and above the horizon, from where all of the scene is
        /// in view
        orbit: Option<[f64; 2]> = None, OptionKind::Numbers(2), "AZIMUTH,HEIGHT", "-63,20";
        /// The angle from the lower to the upper edge of the picture, above 0 and below 180 degrees
        fov: f64 = ViewPoint::FOV, OptionKind::Number(NumberRange::Positive), "DEG", "";
    }
}

impl JobOptions for CameraOptions {
    fn fields() -> Vec<&'static OptionField> {
        Self::FIELDS.iter().collect()
    }

    fn check_together(&self, _given: &Given<'_>) -> Result<(), OptionError> {
        if self.orbit.is_some() && self.eye.is_some() {
            return Err(OptionError::new("orbit", "not with @eye; leave one of them out"));
        }
        if self.target.is_some() && self.eye.is_none() {
            return Err(OptionError::new("target", "only with @eye; an orbit looks at the middle of the scene"));
        }
        // A box beside the eye, which so is not its middle, whatever the scene will be.
        let corner = self.eye.unwrap_or_default();
        match self.camera([corner, corner.map(|c| c + 1.0)]) {
            Err(RenderError::OfJob(error)) => Err(error),
            Err(error) => Err(OptionError::new("", error.to_string())),
            Ok(_) => Ok(()),
        }
    }
}

impl CameraOptions {
    /// The camera for a box in the world.
    ///
    /// # Errors
    /// Those of [`ViewPoint::camera`].
    pub fn camera(&self, bounds: [[f64; 3]; 2]) -> Result<Camera, RenderError> {
        let view = match (self.eye, self.orbit) {
            (Some(eye), _) => ViewPoint::At { eye, target: self.target },
            (None, Some([azimuth, height])) => ViewPoint::Orbit { azimuth, height },
            (None, None) => ViewPoint::default(),
        };
        view.camera(bounds, self.fov)
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn views_that_no_scene_has_are_refused_by_name() {
        for (asked, expected) in [
            (json!({"fov": 0}), "fov: expected a number above 0, found 0"),
            (json!({"fov": 180}), "fov: expected an angle above 0 and below 180 degrees, found 180"),
            (json!({"orbit": [0, 91]}), "orbit: "),
            (json!({"orbit": [0, 9], "eye": [0, 0, 1]}), "orbit: not with eye"),
            (json!({"target": [0, 0, 1]}), "target: only with eye"),
            (json!({"eye": [0, 0, 1], "target": [0, 0, 1]}), "eye: expected another point"),
        ] {
            let error = CameraOptions::from_values(asked.as_object().unwrap().clone()).unwrap_err().to_string();
            assert!(error.starts_with(expected), "{asked}: {error}");
        }
    }
}
