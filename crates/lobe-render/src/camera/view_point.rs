//! Point of view of a picture: the place of its eye, or an orbit around the scene.

use lobe_io::OptionError;
use lobe_sh::Dir;
use lobe_sh::sphere::vector::{add, scale, sub};

use crate::camera::camera::Camera;
use crate::camera::view::View;
use crate::error::RenderError;

/// Where the eye is, and where it looks.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ViewPoint {
    /// At a point. Without a target it looks at the middle of the scene.
    At {
        /// The eye, in the world.
        eye: [f64; 3],
        /// What is in the middle of the picture.
        target: Option<[f64; 3]>,
    },
    /// Around the scene, so far away that the ball around it fills the height of the picture.
    Orbit {
        /// Of the eye, in degrees, from +x towards +y.
        azimuth: f64,
        /// Of the eye above the horizon, in degrees, -90 to 90.
        height: f64,
    },
}

impl Default for ViewPoint {
    /// In front: models of glTF face its +z, which is -y here; a little from the right and from above.
    fn default() -> Self {
        Self::Orbit { azimuth: -63.0, height: 20.0 }
    }
}

impl ViewPoint {
    /// The angle from the lower to the upper edge of a picture without another choice, in degrees.
    pub const FOV: f64 = 40.0;

    /// The camera for a box in the world, such as that of [`Scene::world_bounds`](lobe_scene::Scene::world_bounds), and
    /// an angle of `fov` degrees from the lower to the upper edge.
    ///
    /// ```text
    ///   eye = middle + R/sin(fov/2) (cos h cos a, cos h sin a, sin h)        of an orbit: azimuth a, height h,
    ///                                                                        R half of the diagonal of the box
    /// ```
    ///
    /// Straight above and below, the azimuth says nothing.
    ///
    /// # Errors
    /// [`RenderError::OfJob`] if the angle is not above 0 and below 180 degrees, the height of the eye not from -90
    /// to 90, an azimuth is not finite, or eye and target are one point.
    pub fn camera(&self, [min, max]: [[f64; 3]; 2], fov: f64) -> Result<Camera, RenderError> {
        let refused = |option: &str, message: String| Err(OptionError::new(option, message).into());
        if !(fov > 0.0 && fov < 180.0) {
            return refused("fov", format!("expected an angle above 0 and below 180 degrees, found {fov}"));
        }
        let half_angle = 0.5 * fov.to_radians();
        match *self {
            Self::At { eye, target } => {
                let target = target.unwrap_or_else(|| add(min, scale(sub(max, min), 0.5)));
                let camera = Camera::look_at(eye, target, half_angle);
                camera.map_or_else(|| refused("eye", format!("expected another point than the target {target:?}")), Ok)
            }
            Self::Orbit { azimuth, height } => {
                if !(azimuth.is_finite() && (-90.0..=90.0).contains(&height)) {
                    let message = format!("expected an angle, and one from -90 to 90, found {azimuth},{height}");
                    return refused("orbit", message);
                }
                let (polar, azimuth) = ((90.0 - height).to_radians(), azimuth.rem_euclid(360.0).to_radians());
                let towards_eye = View::from_eye(Dir::from_angles(polar, azimuth));
                Ok(Camera::framing(min, max, towards_eye, half_angle))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOX: [[f64; 3]; 2] = [[0.0, 0.0, 0.0], [2.0, 2.0, 2.0]];

    #[test]
    fn an_orbit_is_the_point_of_its_angles_around_the_middle() {
        let distance = 3.0_f64.sqrt() / 20.0_f64.to_radians().sin();
        for (azimuth, height, towards) in
            [(0.0, 0.0, [1.0, 0.0, 0.0]), (90.0, 0.0, [0.0, 1.0, 0.0]), (-30.0, 90.0, [0.0, 0.0, 1.0])]
        {
            let eye = towards.map(|c| 1.0 + distance * c);
            let at = ViewPoint::At { eye, target: None }.camera(BOX, ViewPoint::FOV).unwrap();
            let around = ViewPoint::Orbit { azimuth, height }.camera(BOX, ViewPoint::FOV).unwrap();
            for (right, up) in [(0.0, 0.0), (0.7, -0.4)] {
                let [p, q] = [at, around].map(|camera| camera.ray(right, up).0);
                let off = (0..3).map(|k| (p[k] - q[k]).abs()).fold(0.0, f64::max);
                assert!(off < 1e-9 * distance, "{azimuth}, {height}: {p:?} and {q:?}");
            }
        }
    }

    #[test]
    fn what_is_no_view_is_refused_by_the_name_of_the_option() {
        let at = ViewPoint::At { eye: [1.0; 3], target: Some([1.0; 3]) };
        let over = ViewPoint::Orbit { azimuth: 0.0, height: 91.0 };
        for (view, fov, name) in [(at, 40.0, "eye: "), (over, 40.0, "orbit: "), (ViewPoint::default(), 180.0, "fov: ")]
        {
            let error = view.camera(BOX, fov).unwrap_err().to_string();
            assert!(error.starts_with(name), "{error}");
        }
    }
}
