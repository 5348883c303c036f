//! The light of a rectangle in patches: one table for every picture on it.

use lobe_io::{Fingerprint, Job, RecordFormat};
use lobe_prt::fingerprint_arithmetic;
use lobe_sh::light::SphericalPolygon;
use lobe_sh::sphere::vector::{cross, length};
use lobe_sh::{Dir, Expansion as _, Rgb};

use crate::error::ShadowError;
use crate::field::axial::Axial;
use crate::field::bake_rows::{RowWork, bake_rows};
use crate::field::field_grid::FieldGrid;
use crate::field::lamp_surface::check_patches;
use crate::field::lamp_surface::{LampSurface, PatchedRectangle, Rectangle};
use crate::field::radiance_field::{OFF_PLANE, check_order, expect_rows};
use crate::field::radiance_field::{RadianceField, RadianceOptions};

/// Fingerprints of lamps among those of Lobe.
const PATCH_KIND: u64 = 23;

const PATCH_FORMAT: RecordFormat = RecordFormat {
    kind: *b"LAMP",
    version: 1,
    work: "bake of a lamp",
    arguments: "the rectangle, its patches or the options",
};

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
    rectangle: Rectangle,
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
    /// side, or for what [`FieldGrid::new`] refuses; [`ShadowError::Cancelled`] if the job says so, and those of its checkpoint, from
    /// which it is resumed.
    pub fn bake(
        rectangle: &Rectangle,
        patches: [usize; 2],
        options: &RadianceOptions,
        job: Job<'_>,
    ) -> Result<Self, ShadowError> {
        check_order(options.order)?;
        check_patches(patches)?;
        let grid = rectangle.grid([options.inner, options.outer], options.spheres, options.cells)?;
        let (total, width) = (patches[0] * patches[1], Axial::width(options.order));
        grid.check_bytes(total * width)?;
        let light: Vec<PatchLight> = (0..total).map(|k| PatchLight::new(rectangle.patch(patches, k))).collect();
        let axial = Axial::new(options.order);
        let work = RowWork {
            rows: total * grid.points(),
            width,
            rays: 0,
            format: PATCH_FORMAT,
            fingerprint: fingerprint(rectangle, patches, options),
        };
        let table = bake_rows(&work, None, job, &|| (), &|row, (): &mut (), out| {
            light[row / grid.points()].split_into(&grid, row % grid.points(), options.order, &axial, out);
        })?;
        Ok(Self { order: options.order, rectangle: *rectangle, grid, patches, table })
    }

    /// Where the lamp is, in its own frame.
    #[must_use]
    pub fn rectangle(&self) -> &Rectangle {
        &self.rectangle
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
        rectangle: Rectangle,
        grid: FieldGrid,
        order: usize,
        patches: [usize; 2],
        table: Vec<f32>,
    ) -> Result<Self, ShadowError> {
        check_patches(patches)?;
        let width = patches[0] * patches[1] * Axial::width(order);
        grid.check_bytes(width)?;
        expect_rows(&grid, width, &table)?;
        Ok(Self { order, rectangle, grid, patches, table })
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
        let (rectangle, patches, radiance) = (self.rectangle, self.patches, colors.to_vec());
        RadianceField::sampled(PatchedRectangle { rectangle, patches, radiance }, self.grid, self.order, rows)
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
        Self::colors_of_patches(self.patches, width, pixels)
    }

    /// [`PatchField::patch_colors`] for a field that is not baked yet.
    ///
    /// # Errors
    /// As there, and [`ShadowError::Options`] if there are not 1 to 64 patches along each side.
    pub fn colors_of_patches(
        patches: [usize; 2],
        width: usize,
        pixels: &[Rgb<f32>],
    ) -> Result<Vec<Rgb<f64>>, ShadowError> {
        check_patches(patches)?;
        if width == 0 || pixels.is_empty() || !pixels.len().is_multiple_of(width) {
            let message = format!("expected rows of {width} pixels, found {} in all", pixels.len());
            return Err(ShadowError::Invalid { place: "radiance field".to_owned(), message });
        }
        let height = pixels.len() / width;
        let mut colors = Vec::with_capacity(patches[0] * patches[1]);
        for j in 0..patches[1] {
            for i in 0..patches[0] {
                let columns = parts(i, patches[0], width);
                let mut sum = Rgb::new(0.0, 0.0, 0.0);
                for (y, part_y) in parts(j, patches[1], height) {
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

impl RadianceField {
    /// A rectangle of one radiance.
    ///
    /// # Errors
    /// As [`PatchField::bake`] and [`PatchField::with_colors`].
    pub fn rectangle(
        rectangle: &Rectangle,
        radiance: Rgb<f64>,
        options: &RadianceOptions,
    ) -> Result<Self, ShadowError> {
        PatchField::bake(rectangle, [1, 1], options, Job::default())?.with_colors(&[radiance])
    }

    /// The light around a surface. A ball takes the order of the options alone.
    ///
    /// # Errors
    /// As [`RadianceField::ball`], or [`PatchField::bake`] and [`PatchField::with_colors`].
    pub fn around(surface: &LampSurface, options: &RadianceOptions) -> Result<Self, ShadowError> {
        match surface {
            LampSurface::Ball { center, radius, radiance } => Self::ball(options.order, *center, *radius, *radiance),
            LampSurface::Rectangle(PatchedRectangle { rectangle, patches, radiance }) => {
                PatchField::bake(rectangle, *patches, options, Job::default())?.with_colors(radiance)
            }
        }
    }
}

/// The pixels that a patch covers along one axis, with the part of the patch that each has.
fn parts(patch: usize, patches: usize, pixels: usize) -> Vec<(usize, f64)> {
    let edge = |k: usize| k as f64 * pixels as f64 / patches as f64;
    let (from, to) = (edge(patch), edge(patch + 1));
    let last = (to.ceil() as usize).min(pixels);
    (from as usize..last).map(|x| (x, (to.min(x as f64 + 1.0) - from.max(x as f64)).max(0.0) / (to - from))).collect()
}

fn fingerprint(rectangle: &Rectangle, patches: [usize; 2], options: &RadianceOptions) -> Fingerprint {
    let Rectangle { corner, u, v, two_sided } = rectangle;
    let RadianceOptions { order, spheres, cells, inner, outer } = options;
    let mut all = Fingerprint::of_kind(PATCH_KIND);
    let whole = [patches[0], patches[1], usize::from(*two_sided), *order, *spheres, *cells];
    all.words(whole.into_iter().map(|n| n as u64));
    [corner, u, v].into_iter().flatten().chain([inner, outer]).for_each(|x| all.word(x.to_bits()));
    fingerprint_arithmetic(&mut all);
    all
}

/// A patch of radiance 1.
struct PatchLight {
    rectangle: Rectangle,
    normal: [f64; 3],
}

impl PatchLight {
    fn new(rectangle: Rectangle) -> Self {
        let area = cross(rectangle.u, rectangle.v);
        Self { rectangle, normal: area.map(|c| c / length(area)) }
    }

    /// `w(r) S` at a sample point, split; zero, as `row` is, behind it.
    fn split_into(&self, grid: &FieldGrid, point: usize, order: usize, axial: &Axial, row: &mut [f32]) {
        let Self { rectangle, normal } = self;
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
    }
}

#[cfg(test)]
mod tests {
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
}
