//! The source radiance field: the light of a lamp at every point around it.

use derive_setters::Setters;
use lobe_io::{Job, Progress};
use lobe_sh::vector::{add, cross, length};
use lobe_sh::{Dir, Expansion as _, Rgb, ShVec, SphericalPolygon, Zonal};
use rayon::prelude::*;

use crate::field::axial::Axial;
use crate::field::occlusion_field::toward_middle;
use crate::{FieldGrid, RadialInterpolation, ShadowError};

/// Patches at most, along each side of a rectangle.
const MOST_PATCHES: usize = 64;

/// Sample points nearer to the plane of the rectangle than this part of its radius are moved to its front by as much:
/// within the plane it has no solid angle, and all of a hemisphere on it.
const OFF_PLANE: f64 = 1e-6;

/// A lamp in the shape of a parallelogram.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    /// The corner of the first pixel of a picture on it.
    pub corner: [f64; 3],
    /// The edge along its rows.
    pub u: [f64; 3],
    /// The edge along its columns. It shines towards `u × v`.
    pub v: [f64; 3],
    /// Whether the back shines alike.
    pub two_sided: bool,
}

impl Rectangle {
    /// In the plane z = 0 around the origin, of this width along x and height along y, shining towards +z. Its rows go from +x to -x
    /// and its columns from +y to -y.
    #[must_use]
    pub fn upright([width, height]: [f64; 2], two_sided: bool) -> Self {
        let corner = [0.5 * width, 0.5 * height, 0.0];
        Self { corner, u: [-width, 0.0, 0.0], v: [0.0, -height, 0.0], two_sided }
    }
}

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
/// sampled like an [`OcclusionField`](crate::OcclusionField), each sample exact ([`SphericalPolygon`]).
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
        grid: FieldGrid,
        rows: Vec<f32>,
        axial: Axial,
    },
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

    /// A rectangle of one radiance.
    ///
    /// # Errors
    /// As [`PatchField::bake`].
    pub fn rectangle(
        rectangle: &Rectangle,
        radiance: Rgb<f64>,
        options: &RadianceOptions,
    ) -> Result<Self, ShadowError> {
        PatchField::bake(rectangle, [1, 1], options, Job::default())?.with_colors(&[radiance])
    }

    /// A field of `w(r) S` split at every point of a grid: red, green and blue one after the other.
    ///
    /// # Errors
    /// [`ShadowError::Invalid`] if a number is not finite, or there are more or fewer.
    pub(crate) fn sampled(grid: FieldGrid, order: usize, rows: Vec<f32>) -> Result<Self, ShadowError> {
        let width = 3 * Axial::width(order);
        expect_rows(&grid, width, &rows)?;
        Ok(Self { order, shape: Shape::Sampled { grid, rows, axial: Axial::new(order) } })
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

    /// The light at a point of the lamp's frame, in its directions. In a ball it comes from everywhere.
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
            Shape::Sampled { grid, rows, axial } => {
                let offset = offset.map(|c| (c / grid.radius()) as f32);
                let width = Axial::width(self.order);
                let mut sum = vec![0.0; 3 * width];
                grid.stencil(offset, interpolation).sum_into(rows, &mut sum);
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

/// The light of a rectangle patch by patch, for pictures and sequences of pictures on it.
///
/// ```text
///   S(p) = Σ_k L_k S_k(p)           L_k: mean radiance of patch k,   S_k: its light at radiance 1
/// ```
///
/// Light is linear in the pixels. One table of `order + order²` gray numbers for each point and patch serves every picture,
/// in `4 (order + order²) points · patches` bytes, where a field for each frame of a sequence takes three times as much: patches
/// are smaller if they are fewer than three times the frames. A frame costs one weighted sum of the tables. What a picture has of detail
/// within a patch is replaced by its mean, which low bands see only from nearer than about the size of the patch.
#[derive(Clone, Debug, PartialEq)]
pub struct PatchField {
    order: usize,
    grid: FieldGrid,
    patches: [usize; 2],
    /// For each patch `w(r) S_k` of every sample point, split at the direction to the middle.
    table: Vec<f32>,
}

impl PatchField {
    /// The field of a rectangle cut into `patches` of equal size along its rows and columns.
    ///
    /// # Errors
    /// [`ShadowError::Options`] if the rectangle has no area or is not finite, there are not 1 to 64 patches along each
    /// side, or for what [`FieldGrid::new`] refuses; [`ShadowError::Cancelled`] if the job says so. It cannot be resumed.
    pub fn bake(
        rectangle: &Rectangle,
        patches: [usize; 2],
        options: &RadianceOptions,
        mut job: Job<'_>,
    ) -> Result<Self, ShadowError> {
        job.expect_no_checkpoint().map_err(ShadowError::Options)?;
        check_order(options.order)?;
        let Rectangle { corner, u, v, .. } = *rectangle;
        check_patches(patches)?;
        let normal = cross(u, v);
        let radius = 0.5 * length(add(u, v)).max(length(add(u, v.map(|c| -c))));
        if !(length(normal).is_finite() && length(normal) > 0.0) {
            return Err(ShadowError::Options(format!(
                "expected a rectangle with an area, found edges {u:?} and {v:?}"
            )));
        }
        let center = std::array::from_fn(|k| corner[k] + 0.5 * (u[k] + v[k]));
        let range = [options.inner, options.outer];
        let grid = FieldGrid::new(center, radius, range, options.spheres, options.cells)?;
        let total = patches[0] * patches[1];
        grid.check_bytes(total * Axial::width(options.order))?;
        let mut table = Vec::with_capacity(total * grid.points() * Axial::width(options.order));
        for k in 0..=total {
            let progress = Progress { done: k, total, ..Progress::default() };
            if job.report(&progress).is_break() {
                return Err(ShadowError::Cancelled);
            }
            if k < total {
                table.extend(rows_of(&patch(rectangle, patches, k), &grid, options.order));
            }
        }
        Ok(Self { order: options.order, grid, patches, table })
    }

    /// Patches along the rows and along the columns.
    #[must_use]
    pub fn patches(&self) -> [usize; 2] {
        self.patches
    }

    /// The bytes of all tables.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(self.table.as_slice())
    }

    /// Number of bands.
    #[must_use]
    pub fn order(&self) -> usize {
        self.order
    }

    pub(crate) fn grid(&self) -> &FieldGrid {
        &self.grid
    }

    /// Patch after patch, the rows of all points.
    pub(crate) fn table(&self) -> &[f32] {
        &self.table
    }

    /// # Errors
    /// [`ShadowError::Invalid`] if there are no patches or too many, a number is not finite, or there are more or fewer.
    pub(crate) fn from_table(
        grid: FieldGrid,
        order: usize,
        patches: [usize; 2],
        table: Vec<f32>,
    ) -> Result<Self, ShadowError> {
        check_patches(patches)?;
        let width = patches[0] * patches[1] * Axial::width(order);
        grid.check_bytes(width)?;
        expect_rows(&grid, width, &table)?;
        Ok(Self { order, grid, patches, table })
    }

    /// The field of one radiance for each patch, row by row.
    ///
    /// # Errors
    /// [`ShadowError::Invalid`] if there are more or fewer, or one is not finite.
    pub fn with_colors(&self, colors: &[Rgb<f64>]) -> Result<RadianceField, ShadowError> {
        let invalid = |message: String| Err(ShadowError::Invalid { place: "radiance field".to_owned(), message });
        let patches = self.patches[0] * self.patches[1];
        if colors.len() != patches {
            return invalid(format!("expected a radiance for each of {patches} patches, found {}", colors.len()));
        }
        if let Some(bad) = colors.iter().find(|c| !c.to_array().iter().all(|c| (*c as f32).is_finite())) {
            return invalid(format!("expected finite radiance of single precision, found {bad:?}"));
        }
        let n = Axial::width(self.order);
        let mut rows = vec![0.0_f32; self.grid.points() * 3 * n];
        for (table, color) in self.table.chunks_exact(self.grid.points() * n).zip(colors) {
            let color = color.to_array().map(|c| c as f32);
            for (row, gray) in rows.chunks_exact_mut(3 * n).zip(table.chunks_exact(n)) {
                for (row, c) in row.chunks_exact_mut(n).zip(color) {
                    row.iter_mut().zip(gray).for_each(|(row, gray)| *row += c * gray);
                }
            }
        }
        RadianceField::sampled(self.grid, self.order, rows)
    }

    /// The field of a picture, `width` pixels in a row, the first at the corner of the rectangle.
    ///
    /// # Errors
    /// As [`PatchField::patch_colors`] and [`PatchField::with_colors`].
    pub fn with_picture(&self, width: usize, pixels: &[Rgb<f32>]) -> Result<RadianceField, ShadowError> {
        self.with_colors(&self.patch_colors(width, pixels)?)
    }

    /// The radiance of the patches under a picture, row by row: the mean of the pixels of each, those that it cuts counted by
    /// their part.
    ///
    /// # Errors
    /// [`ShadowError::Invalid`] if the pixels are no whole number of rows, at least one.
    pub fn patch_colors(&self, width: usize, pixels: &[Rgb<f32>]) -> Result<Vec<Rgb<f64>>, ShadowError> {
        if width == 0 || pixels.is_empty() || !pixels.len().is_multiple_of(width) {
            let message = format!("expected rows of {width} pixels, found {} in all", pixels.len());
            return Err(ShadowError::Invalid { place: "radiance field".to_owned(), message });
        }
        let height = pixels.len() / width;
        let mut colors = Vec::with_capacity(self.patches[0] * self.patches[1]);
        for j in 0..self.patches[1] {
            for i in 0..self.patches[0] {
                let columns = parts(i, self.patches[0], width);
                let mut sum = Rgb::new(0.0, 0.0, 0.0);
                for (y, part_y) in parts(j, self.patches[1], height) {
                    for &(x, part_x) in &columns {
                        let pixel = pixels[y * width + x].to_array();
                        sum += Rgb::from(pixel.map(|c| f64::from(c) * part_x * part_y));
                    }
                }
                colors.push(sum);
            }
        }
        Ok(colors)
    }
}

/// The pixels that a patch covers along one axis, with the part of the patch that each has.
fn parts(patch: usize, patches: usize, pixels: usize) -> Vec<(usize, f64)> {
    let edge = |k: usize| k as f64 * pixels as f64 / patches as f64;
    let (from, to) = (edge(patch), edge(patch + 1));
    let last = (to.ceil() as usize).min(pixels);
    (from as usize..last).map(|x| (x, (to.min(x as f64 + 1.0) - from.max(x as f64)).max(0.0) / (to - from))).collect()
}

fn patch(rectangle: &Rectangle, [columns, rows]: [usize; 2], k: usize) -> Rectangle {
    let (i, j) = ((k % columns) as f64, (k / columns) as f64);
    let (u, v) = (rectangle.u.map(|c| c / columns as f64), rectangle.v.map(|c| c / rows as f64));
    Rectangle { corner: std::array::from_fn(|c| rectangle.corner[c] + i * u[c] + j * v[c]), u, v, ..*rectangle }
}

/// `w(r) S` of a rectangle of radiance 1 at every sample point, split.
fn rows_of(rectangle: &Rectangle, grid: &FieldGrid, order: usize) -> Vec<f32> {
    let (axial, width) = (Axial::new(order), Axial::width(order));
    let mut rows = vec![0.0; grid.points() * width];
    let normal = cross(rectangle.u, rectangle.v).map(|c| c / length(cross(rectangle.u, rectangle.v)));
    rows.par_chunks_exact_mut(width).enumerate().for_each(|(point, row)| {
        let offset = grid.offset(point);
        let mut p: [f64; 3] = std::array::from_fn(|k| grid.center()[k] + offset[k]);
        let height: f64 = (0..3).map(|k| normal[k] * (p[k] - rectangle.corner[k])).sum();
        let least = OFF_PLANE * grid.radius();
        if height.abs() < least {
            p = std::array::from_fn(|k| p[k] + (least - height) * normal[k]);
        } else if height < 0.0 && !rectangle.two_sided {
            return;
        }
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[a, b]| -> [f64; 3] {
            std::array::from_fn(|k| rectangle.corner[k] + a * rectangle.u[k] + b * rectangle.v[k] - p[k])
        });
        // No point is on an edge once it is off the plane.
        if let Ok(polygon) = SphericalPolygon::new(corners.to_vec()) {
            let scale = grid.scale_at(length(offset));
            let light: Vec<f32> = polygon.project(order).coefficients().iter().map(|c| (c * scale) as f32).collect();
            let axis = Dir::new(offset.map(|c| -c)).map(Dir::to_array);
            axial.split_into(axis, &light, row);
        }
    });
    rows
}

fn check_patches(patches: [usize; 2]) -> Result<(), ShadowError> {
    if patches.iter().all(|n| (1..=MOST_PATCHES).contains(n)) {
        return Ok(());
    }
    Err(ShadowError::Options(format!("expected 1 to {MOST_PATCHES} patches along each side, found {patches:?}")))
}

/// Whether a table has `width` finite numbers for each point.
fn expect_rows(grid: &FieldGrid, width: usize, rows: &[f32]) -> Result<(), ShadowError> {
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

fn check_order(order: usize) -> Result<(), ShadowError> {
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
    fn parts_of_pixels_add_up_to_the_patch() {
        for (patches, pixels) in [(1, 1), (4, 4), (4, 10), (5, 3), (7, 64)] {
            let mut of_pixel = vec![0.0; pixels];
            for patch in 0..patches {
                let parts = parts(patch, patches, pixels);
                let sum: f64 = parts.iter().map(|(_, part)| part).sum();
                assert!((sum - 1.0).abs() < 1e-12, "{patch} of {patches} over {pixels}: {sum}");
                parts.iter().for_each(|(x, part)| of_pixel[*x] += part / patches as f64);
            }
            let even = of_pixel.iter().all(|sum| (sum * pixels as f64 - 1.0).abs() < 1e-12);
            assert!(even, "{patches} over {pixels}: {of_pixel:?}");
        }
    }

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
