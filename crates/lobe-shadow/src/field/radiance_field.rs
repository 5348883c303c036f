//! The source radiance field: the light of a lamp at every point around it.

use derive_setters::Setters;
use lobe_sh::sphere::vector::{add, cross, dot, length, sub};
use lobe_sh::{Dir, Expansion as _, Rgb, ShVec, Zonal};

use crate::error::ShadowError;
use crate::field::axial::Axial;
use crate::field::field_grid::{FieldGrid, RadialInterpolation};
use crate::field::lamp_surface::{LampSurface, PatchedRectangle, Rectangle};
use crate::field::occlusion_field::toward_middle;

/// Sample points nearer to the plane of a rectangle than this part of its radius have the light of its front: within the plane it has
/// no solid angle, and all of a hemisphere on it.
pub(crate) const OFF_PLANE: f64 = 1e-6;

/// The sample points of a radiance field.
#[derive(Clone, Debug, PartialEq, Setters, serde::Serialize, serde::Deserialize)]
#[serde(default)]
#[non_exhaustive]
pub struct RadianceOptions {
    /// Number of bands, 1 to 8.
    pub order: usize,
    /// Number of spheres, 2 at least.
    pub spheres: usize,
    /// Cells along each side of the octahedral grid of a sphere; even.
    pub cells: usize,
    /// The innermost sphere, in radii of the lamp.
    pub inner: f64,
    /// The outermost sphere, in radii of the lamp.
    pub outer: f64,
}

impl Default for RadianceOptions {
    fn default() -> Self {
        Self { order: 4, spheres: 16, cells: 16, inner: 0.25, outer: 8.0 }
    }
}

/// The light of a lamp at every point around it, in its own frame: the source radiance field of [Zhou et al. 2005].
///
/// ```text
///   S_i(p) = ∫ L(p, s) y_i(s) ds           L(p, s) = radiance that arrives at p from direction s
/// ```
///
/// A ball has a closed form at every point, zonal about the direction to its center ([`Zonal::cone`]). Rectangles are
/// sampled like an [`OcclusionField`](crate::OcclusionField), each sample exact ([`SphericalPolygon`](lobe_sh::light::SphericalPolygon)).
///
/// [Zhou et al. 2005]: https://doi.org/10.1145/1073204.1073332
#[derive(Clone, Debug)]
pub struct RadianceField {
    order: usize,
    shape: Shape,
}

/// The two forms of a field.
#[derive(Clone, Debug)]
pub(crate) enum Shape {
    Ball {
        center: [f64; 3],
        radius: f64,
        radiance: Rgb<f64>,
    },
    /// `w(r) S` of every sample point, split at the direction to the middle: red, green and blue one after the other.
    Sampled {
        source: Box<PatchedRectangle>,
        grid: FieldGrid,
        rows: Vec<f32>,
        axial: Axial,
        /// Of a rectangle that shines to one side.
        front: Option<Box<Front>>,
    },
}

/// The half space that a rectangle lights.
#[derive(Clone, Debug)]
pub(crate) struct Front {
    corner: [f64; 3],
    /// Of any length.
    normal: [f64; 3],
    /// The sample points that it lights, or whose light is that just in front of it.
    is_lit: Vec<bool>,
}

impl Front {
    fn new(rectangle: &Rectangle, grid: &FieldGrid) -> Self {
        let Rectangle { corner, u, v, .. } = *rectangle;
        let mut front = Self { corner, normal: cross(u, v), is_lit: Vec::new() };
        let least = OFF_PLANE * grid.radius() * length(front.normal);
        front.is_lit = (0..grid.points()).map(|p| front.height(add(grid.center(), grid.offset(p))) > -least).collect();
        front
    }

    /// The height of a point above the plane, times the length of the normal.
    fn height(&self, p: [f64; 3]) -> f64 {
        dot(self.normal, sub(p, self.corner))
    }
}

impl RadianceField {
    /// A ball of this radiance.
    ///
    /// # Errors
    /// [`ShadowError::Options`] if a number is not finite, the radius not above 0, or the order not 1 to 8.
    pub fn ball(order: usize, center: [f64; 3], radius: f64, radiance: Rgb<f64>) -> Result<Self, ShadowError> {
        check_order(order)?;
        // Light is computed in single precision.
        let colors = radiance.to_array().map(|c| f64::from(c as f32));
        let numbers = center.into_iter().chain(colors);
        if !(numbers.chain([radius]).all(f64::is_finite) && radius > 0.0) {
            let message =
                format!("expected a ball of finite radiance and radius above 0, found {radiance:?}, {radius}");
            return Err(ShadowError::Options(message));
        }
        Ok(Self { order, shape: Shape::Ball { center, radius, radiance } })
    }

    /// A field of `w(r) S` split at every point of a grid: red, green and blue one after the other.
    ///
    /// # Errors
    /// [`ShadowError::Invalid`] if a number is not finite, or there are more or fewer.
    pub(crate) fn sampled(
        source: PatchedRectangle,
        grid: FieldGrid,
        order: usize,
        rows: Vec<f32>,
    ) -> Result<Self, ShadowError> {
        let width = 3 * Axial::width(order);
        expect_rows(&grid, width, &rows)?;
        if let Some(bad) = source.radiance.iter().find(|c| !c.to_array().iter().all(|c| c.is_finite())) {
            let message = format!("expected finite radiance, found {bad:?}");
            return Err(ShadowError::Invalid { place: "radiance field".to_owned(), message });
        }
        let front = (!source.rectangle.two_sided).then(|| Box::new(Front::new(&source.rectangle, &grid)));
        let (source, axial) = (Box::new(source), Axial::new(order));
        Ok(Self { order, shape: Shape::Sampled { source, grid, rows, axial, front } })
    }

    /// What shines, for who traces rays to it.
    #[must_use]
    pub fn surface(&self) -> LampSurface {
        match &self.shape {
            Shape::Ball { center, radius, radiance } => {
                LampSurface::Ball { center: *center, radius: *radius, radiance: *radiance }
            }
            Shape::Sampled { source, .. } => LampSurface::Rectangle((**source).clone()),
        }
    }

    pub(crate) fn shape(&self) -> &Shape {
        &self.shape
    }

    /// Number of bands.
    #[must_use]
    pub fn order(&self) -> usize {
        self.order
    }

    /// The middle of the lamp in its own frame.
    #[must_use]
    pub fn center(&self) -> [f64; 3] {
        match &self.shape {
            Shape::Ball { center, .. } => *center,
            Shape::Sampled { grid, .. } => grid.center(),
        }
    }

    /// The bytes of its table; none for a ball.
    #[must_use]
    pub fn bytes(&self) -> usize {
        match &self.shape {
            Shape::Ball { .. } => 0,
            Shape::Sampled { rows, .. } => size_of_val(rows.as_slice()),
        }
    }

    /// The light at a point of the lamp's frame, in its directions. In a ball it comes from everywhere. In the plane of a rectangle that
    /// shines to one side, and behind it, there is none, and in front of it samples that lie behind do not count: a panel does not light
    /// what it hangs on (`a_panel_lights_nothing_behind_its_plane`).
    #[must_use]
    pub fn radiance_at(&self, point: [f64; 3], interpolation: RadialInterpolation) -> ShVec<Rgb<f32>> {
        let n = self.order * self.order;
        let mut channels = vec![0.0; 3 * n];
        self.radiance_into(point, interpolation, &mut channels);
        let colors = (0..n).map(|i| Rgb::new(channels[i], channels[n + i], channels[2 * n + i])).collect();
        ShVec::from_vec(colors).unwrap_or_else(|| unreachable!("order² places were made"))
    }

    /// [`RadianceField::radiance_at`], red, green and blue one after the other.
    pub(crate) fn radiance_into(&self, point: [f64; 3], interpolation: RadialInterpolation, out: &mut [f32]) {
        let offset: [f64; 3] = std::array::from_fn(|k| point[k] - self.center()[k]);
        match &self.shape {
            Shape::Ball { radius, radiance, .. } => {
                let cone = ball_light(self.order, offset, *radius);
                for (out, color) in out.chunks_exact_mut(self.order * self.order).zip(radiance.to_array()) {
                    out.iter_mut().zip(cone.coefficients()).for_each(|(out, c)| *out = (c * color) as f32);
                }
            }
            Shape::Sampled { grid, rows, axial, front, .. } => {
                if front.as_ref().is_some_and(|front| front.height(point) <= 0.0) {
                    out.fill(0.0);
                    return;
                }
                let offset = offset.map(|c| (c / grid.radius()) as f32);
                let width = Axial::width(self.order);
                let mut sum = vec![0.0; 3 * width];
                let mut stencil = grid.stencil(offset, interpolation);
                if let Some(front) = front {
                    stencil.keep(|p| front.is_lit[p]);
                }
                stencil.sum_into(rows, &mut sum);
                let n = self.order * self.order;
                let mut y = vec![0.0; n];
                for (out, sum) in out.chunks_exact_mut(n).zip(sum.chunks_exact(width)) {
                    out.copy_from_slice(&sum[self.order..]);
                    if let Some(axis) = toward_middle(offset) {
                        axial.add_zonal(axis, &sum[..self.order], &mut y, out);
                    }
                }
            }
        }
    }
}

fn ball_light(order: usize, offset: [f64; 3], radius: f64) -> ShVec<f64> {
    let distance = offset.iter().map(|c| c * c).sum::<f64>().sqrt();
    match Dir::new(offset.map(|c| -c)) {
        Some(axis) if distance > radius => Zonal::cone(order, (radius / distance).asin()).towards(axis, 1.0),
        _ => ShVec::constant(order, 1.0),
    }
}

/// Whether a table has `width` finite numbers for each point.
pub(crate) fn expect_rows(grid: &FieldGrid, width: usize, rows: &[f32]) -> Result<(), ShadowError> {
    let invalid = |message: String| Err(ShadowError::Invalid { place: "radiance field".to_owned(), message });
    if rows.len() != grid.points() * width {
        let (points, found) = (grid.points(), rows.len());
        return invalid(format!("expected {width} numbers for each of {points} points, found {found} in all"));
    }
    match rows.iter().find(|x| !x.is_finite()) {
        Some(bad) => invalid(format!("expected finite light, found {bad}")),
        None => Ok(()),
    }
}

pub(crate) fn check_order(order: usize) -> Result<(), ShadowError> {
    if (1..=8).contains(&order) {
        return Ok(());
    }
    Err(ShadowError::Options(format!("expected an order of 1 to 8, found {order}")))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn a_ball_sends_pi_over_its_square_distance() {
        let ball = RadianceField::ball(3, [1.0, 0.0, 0.0], 0.5, Rgb::new(1.0, 2.0, 4.0)).unwrap();
        let light = ball.radiance_at([11.0, 0.0, 0.0], RadialInterpolation::Linear);
        let irradiance = light.dot(&Zonal::clamped_cosine(3).towards(-Dir::X, Rgb::new(1.0_f32, 1.0, 1.0)));
        // Order 3 has 17/16 of the cosine towards a spot.
        let expected = PI * (0.5_f64 / 10.0).powi(2) * 17.0 / 16.0;
        assert!((f64::from(irradiance.g) / (2.0 * expected) - 1.0).abs() < 2e-3, "{irradiance:?}, expected {expected}");
    }
}
