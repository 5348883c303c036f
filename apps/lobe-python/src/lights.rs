//! Analytic lights as functions on the sphere.

use lobe::sh::light::{Normalization, SphericalPolygon, directional_normalization};
use lobe::sh::{Dir, Expansion as _, Light, Rgb};
use numpy::PyArrayDyn;
use pyo3::prelude::*;

use crate::rows::{array_of, value_error};

/// A light of the kind, `(order², 3)`. `color` has one color, of a hemisphere sky and ground, of a gradient zenith, horizon and ground;
/// the half angle of
/// `towards` is in radians.
#[pyfunction]
pub(crate) fn light<'py>(
    py: Python<'py>,
    kind: &str,
    order: usize,
    towards: ([f64; 3], f64),
    vertices: Vec<[f64; 3]>,
    colors: Vec<[f64; 3]>,
    normalize: &str,
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let (direction, half_angle) = towards;
    let dir = Dir::from_unit(direction);
    let colors: Vec<Rgb<f64>> = colors.into_iter().map(Rgb::from).collect();
    let light = match (kind, &colors[..]) {
        ("ambient", &[color]) => Light::Ambient { color },
        ("directional", &[color]) => Light::Directional { dir, color },
        ("cone", &[color]) => Light::Cone { dir, half_angle, color },
        ("soft-cone", &[color]) => Light::SoftCone { dir, half_angle, color },
        ("polygon", &[color]) => {
            Light::Polygon { polygon: SphericalPolygon::new(vertices).map_err(value_error)?, color }
        }
        ("hemisphere", &[sky, ground]) => Light::Hemisphere { up: dir, sky, ground },
        ("gradient", &[zenith, horizon, ground]) => Light::Gradient { up: dir, zenith, horizon, ground },
        _ => {
            return Err(value_error(format!(
                "expected ambient, directional, cone, soft-cone or polygon with one color, hemisphere with two or gradient with three; \
                 found '{kind}' with {}",
                colors.len()
            )));
        }
    };
    let normalization = match normalize {
        "projected" => Normalization::Projected,
        "analytic" => Normalization::Analytic,
        "none" => Normalization::None,
        _ => return Err(value_error(format!("normalize: expected projected, analytic or none; found '{normalize}'"))),
    };
    let f = light.project(order, normalization).map_err(value_error)?;
    let numbers: Vec<f64> = f.coefficients().iter().flat_map(|c| c.to_array()).collect();
    array_of(py, numbers, &[order * order, 3])
}

/// The irradiance of a surface that faces a directional light of intensity 1 in an expansion of this order.
#[pyfunction]
pub(crate) fn irradiance_of_light(order: usize) -> f64 {
    directional_normalization(order)
}
