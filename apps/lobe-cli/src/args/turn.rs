//! Rotations as options: axis and angle, quaternion, matrix or Euler angles.

use anyhow::bail;
use clap::Args;
use lobe::sh::{Dir, Rotation, ShError};

use crate::args::values;

/// The rotation R, given in one of four ways.
#[derive(Args)]
pub(crate) struct Turn {
    #[command(flatten)]
    by: By,
    /// With --axis: by how many degrees, counterclockwise as seen from the tip of the axis
    #[arg(long, value_name = "DEG", requires = "axis", conflicts_with_all = ["quat", "matrix", "euler_zyz"])]
    #[arg(allow_hyphen_values = true, value_parser = values::finite)]
    angle: Option<f64>,
}

#[derive(Args)]
#[group(required = true, multiple = false)]
struct By {
    /// Turn about this axis, a vector of any length but 0, by --angle
    #[arg(long, value_name = "X,Y,Z", requires = "angle", allow_hyphen_values = true, value_parser = values::dir)]
    axis: Option<Dir>,
    /// Turn by this unit quaternion
    #[arg(long, value_name = "X,Y,Z,W", allow_hyphen_values = true, value_parser = values::numbers::<4>)]
    quat: Option<[f64; 4]>,
    /// Turn by this orthonormal matrix of determinant +1, row after row; it multiplies column vectors
    #[arg(long, value_name = "M00,M01,...,M22", allow_hyphen_values = true, value_parser = values::numbers::<9>)]
    matrix: Option<[f64; 9]>,
    /// Turn by C degrees about +z, then by B about +y, then by A about +z, all about axes that stay where they are; it takes
    /// +z to the angle B from +z and the azimuth A
    #[arg(long, value_name = "A,B,C", allow_hyphen_values = true, value_parser = values::numbers::<3>)]
    euler_zyz: Option<[f64; 3]>,
}

impl Turn {
    pub(crate) fn rotation(&self) -> anyhow::Result<Rotation> {
        match (&self.by, self.angle) {
            (By { axis: Some(axis), .. }, Some(degrees)) => Ok(Rotation::from_axis_angle(*axis, radians(degrees))),
            (By { quat: Some(quat), .. }, _) => {
                Rotation::from_quaternion(*quat).map_err(|e| option_error("--quat", &e))
            }
            (By { matrix: Some(m), .. }, _) => {
                let rows = [[m[0], m[1], m[2]], [m[3], m[4], m[5]], [m[6], m[7], m[8]]];
                Rotation::from_matrix(rows).map_err(|e| match e {
                    ShError::Mirror { determinant } => anyhow::anyhow!(
                        "--matrix: expected a rotation, found a mirror (determinant {determinant:.6}); \
                         exchange two of its rows, or change the signs of one"
                    ),
                    other => option_error("--matrix", &other),
                })
            }
            (By { euler_zyz: Some(angles), .. }, _) => {
                let [alpha, beta, gamma] = angles.map(radians);
                Ok(Rotation::from_euler_zyz(alpha, beta, gamma))
            }
            _ => bail!("no rotation given: --axis with --angle, --quat, --matrix or --euler-zyz says how to turn"),
        }
    }
}

/// An angle in degrees, first brought into one turn, so that many turns cost no digits.
fn radians(degrees: f64) -> f64 {
    degrees.rem_euclid(360.0).to_radians()
}

fn option_error(option: &str, error: &impl std::fmt::Display) -> anyhow::Error {
    anyhow::anyhow!("{option}: {error}")
}
