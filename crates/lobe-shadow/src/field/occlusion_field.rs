//! The object occlusion field: what an entity hides of the sky at every point around it.

use lobe_sh::simd::LANES;
use lobe_sh::{Dir, ShVec};

use crate::error::ShadowError;
use crate::field::axial::Axial;
use crate::field::field_grid::{FieldGrid, RadialInterpolation};

/// The orders a field may have.
const ORDERS: std::ops::RangeInclusive<usize> = 1..=8;

/// Numbers behind the last row, so that registers are filled from the end of any row.
const SPARE: usize = LANES;

/// What an entity hides of the sky, at sample points on concentric spheres around it and between them.
///
/// ```text
///   O_i(p) = ∫ (1 - V(p, s)) y_i(s) ds           V(p, s) = 0 where the ray from p towards s meets the entity, else 1
/// ```
///
/// This is the object occlusion field of [Zhou et al. 2005], with the occlusion `O = 1 - V` in place of the visibility, so
/// that what is far away is small: it is scaled by `w(r)` ([`FieldGrid`]), which makes it tend to a constant, and is exactly
/// 0 for nothing. Points and directions are in the frame of the entity.
///
/// Each vector is stored in two parts, one that is zonal about the direction `d` to the middle of the entity and the rest:
///
/// ```text
///   w(r) O_lm = z_l y_lm(d) + g_lm
/// ```
///
/// `z` and `g` are interpolated, and `y` is evaluated in the direction itself, because the turning of `O` with that direction
/// is most of what changes from sample to sample. A ball has no rest.
///
/// Beyond the last sphere `O` falls as `1/r²`. There the entity is within a cap of solid angle `Ω <= 2π (1 - √(1 - (R/r)²))`,
/// truth and extrapolation each have `‖O‖² <= Ω`, and what differs is the shape and the direction of a spot: the direction
/// by at most `R/r_last` radians, and of a ball band `l` by the part `l(l+1)/8 (R/r_last)²`. The test `beyond_the_last_sphere_occlusion_falls_with_the_solid_angle` measures it.
///
/// Samples inside the solid hold what is seen from the nearest samples outside, see [`bake_field`](crate::bake_field).
///
/// [Zhou et al. 2005]: https://doi.org/10.1145/1073204.1073332
#[derive(Clone, Debug)]
pub struct OcclusionField {
    grid: FieldGrid,
    order: usize,
    /// `z` and `g` of every sample point, then [`SPARE`] zeros.
    rows: Vec<f32>,
    axial: Axial,
}

impl PartialEq for OcclusionField {
    fn eq(&self, other: &Self) -> bool {
        (&self.grid, self.order, &self.rows) == (&other.grid, other.order, &other.rows)
    }
}

impl OcclusionField {
    /// A field from its parts: `z` and `g`, `order + order²` numbers for each [point](FieldGrid::points) of the grid.
    ///
    /// # Errors
    /// [`ShadowError::Invalid`] if the order is not 1 to 8, there are more or fewer numbers, or one is not finite.
    pub fn new(grid: FieldGrid, order: usize, mut rows: Vec<f32>) -> Result<Self, ShadowError> {
        let invalid = |message: String| Err(ShadowError::Invalid { place: "occlusion field".to_owned(), message });
        if !ORDERS.contains(&order) {
            return invalid(format!("expected an order of 1 to 8, found {order}"));
        }
        let width = Axial::width(order);
        if rows.len() != grid.points() * width {
            let (points, found) = (grid.points(), rows.len());
            return invalid(format!("expected {width} numbers for each of {points} points, found {found} in all"));
        }
        if let Some(at) = rows.iter().position(|x| !x.is_finite()) {
            let point = at / width;
            return invalid(format!("expected finite coefficients, found {} at point {point}", rows[at]));
        }
        rows.resize(rows.len() + SPARE, 0.0);
        Ok(Self { grid, order, rows, axial: Axial::new(order) })
    }

    /// A field of `w(r) O` at the points of a grid, `order²` numbers each.
    pub(crate) fn from_scaled(grid: FieldGrid, order: usize, scaled: &[f32]) -> Result<Self, ShadowError> {
        let (axial, width) = (Axial::new(order), Axial::width(order));
        let mut rows = vec![0.0; grid.points() * width];
        for (point, (f, row)) in scaled.chunks_exact(order * order).zip(rows.chunks_exact_mut(width)).enumerate() {
            let axis = Dir::new(grid.offset(point).map(|c| -c)).map(Dir::to_array);
            axial.split_into(axis, f, row);
        }
        Self::new(grid, order, rows)
    }

    /// The sample points.
    #[must_use]
    pub fn grid(&self) -> &FieldGrid {
        &self.grid
    }

    /// Number of bands.
    #[must_use]
    pub fn order(&self) -> usize {
        self.order
    }

    /// `z` and `g` of every sample point, `order + order²` numbers each.
    #[must_use]
    pub fn rows(&self) -> &[f32] {
        &self.rows[..self.rows.len() - SPARE]
    }

    /// The same with numbers behind the last row.
    #[inline]
    pub(crate) fn padded_rows(&self) -> &[f32] {
        &self.rows
    }

    /// Numbers of a row.
    #[inline]
    pub(crate) fn width(&self) -> usize {
        Axial::width(self.order)
    }

    /// The bytes of the rows in `f32`.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(self.rows())
    }

    /// The occlusion at a point of the entity's frame, in its directions.
    ///
    /// At the center, where there is no direction from it, and inside the solid the value is defined too, see
    /// [`OcclusionField`].
    ///
    /// # Panics
    /// If a coordinate is not finite.
    #[must_use]
    pub fn occlusion_at(&self, point: [f64; 3], interpolation: RadialInterpolation) -> ShVec<f32> {
        assert!(point.iter().all(|c| c.is_finite()), "a point is finite, it is not {point:?}");
        let n = self.order * self.order;
        let center = self.grid.center();
        let offset: [f32; 3] = std::array::from_fn(|k| ((point[k] - center[k]) / self.grid.radius()) as f32);
        let mut row = vec![0.0; Axial::width(self.order)];
        self.grid.stencil(offset, interpolation).sum_into(self.rows(), &mut row);
        let (z, g) = row.split_at(self.order);
        let mut out = g.to_vec();
        if let Some(axis) = toward_middle(offset) {
            self.axial.add_zonal(axis, z, &mut vec![0.0; n], &mut out);
        }
        ShVec::from_vec(out).unwrap_or_else(|| unreachable!("order² places were made"))
    }

    /// The visibility of the sky there, `1 - O`.
    ///
    /// # Panics
    /// As [`OcclusionField::occlusion_at`].
    #[must_use]
    pub fn visibility_at(&self, point: [f64; 3], interpolation: RadialInterpolation) -> ShVec<f32> {
        let mut v = ShVec::constant(self.order, 1.0);
        v -= &self.occlusion_at(point, interpolation);
        v
    }

    /// The same field of fewer bands.
    ///
    /// # Errors
    /// [`ShadowError::Options`] if it does not have as many.
    pub fn truncated(&self, order: usize) -> Result<Self, ShadowError> {
        if !(1..=self.order).contains(&order) {
            return Err(ShadowError::Options(format!(
                "expected an order of 1 to {}, which the field has, found {order}",
                self.order
            )));
        }
        let split = |row: &'_ [f32]| -> Vec<f32> { [&row[..order], &row[self.order..][..order * order]].concat() };
        Self::new(self.grid, order, self.rows().chunks_exact(self.width()).flat_map(split).collect())
    }
}

/// The unit vector from a point to the middle, given where the point is from there; `None` at the middle.
#[inline]
pub(crate) fn toward_middle([x, y, z]: [f32; 3]) -> Option<[f32; 3]> {
    let scale = -1.0 / (x * x + y * y + z * z).sqrt();
    scale.is_finite().then_some([x * scale, y * scale, z * scale])
}
