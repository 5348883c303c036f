//! Options of the sample points around an entity or a lamp.

use lobe_io::{Given, JobOptions, OptionError, OptionField, OptionKind, options};

use crate::field::bake_field::FieldOptions;
use crate::field::radiance_field::RadianceOptions;

/// How often all numbers are held at once: as they are made, as a field, and encoded; then decoded for the report.
pub(crate) const COPIES: u64 = 3;

options! {
    /// Where a field has its sample points, see [`FieldGrid`](crate::FieldGrid), and how many bands it has there.
    pub struct FieldSampling {
        /// The order (number of bands)
        order: usize = FieldOptions::default().order,
            OptionKind::Whole { least: 1, most: FieldOptions::MAX_ORDER as u64, what: "an order (number of bands)" },
            "N", "";
        /// Concentric spheres of sample points around the entity
        spheres: usize = FieldOptions::default().spheres,
            OptionKind::Whole { least: 2, most: FieldOptions::MAX_SPHERES as u64, what: "a number of spheres" }, "N", "";
        /// Cells along each side of the octahedral grid of sample points on a sphere, an even number
        cells: usize = FieldOptions::default().cells,
            OptionKind::Whole { least: 2, most: FieldOptions::MAX_CELLS as u64, what: "a number of cells" }, "N", "";
        /// The innermost and the outermost sphere, in radii of the entity; of a lamp in half diagonals of the rectangle
        range: [f64; 2] = [FieldOptions::default().inner, FieldOptions::default().outer], OptionKind::Numbers(2),
            "INNER,OUTER", "";
    }
}

impl JobOptions for FieldSampling {
    fn fields() -> Vec<&'static OptionField> {
        Self::FIELDS.iter().collect()
    }

    fn check_together(&self, _given: &Given<'_>) -> Result<(), OptionError> {
        if self.cells % 2 == 1 {
            return Err(OptionError::new("cells", format!("expected an even number of cells, found {}", self.cells)));
        }
        let [inner, outer] = self.range;
        if !(inner > 0.0 && inner < outer) {
            let message = format!("expected radii above 0 that rise, found {inner},{outer}");
            return Err(OptionError::new("range", message));
        }
        Ok(())
    }
}

impl FieldSampling {
    /// The names of those that a field has, and visibility of an entity's own surface has not.
    pub const OF_POINTS: [&'static str; 3] = ["spheres", "cells", "range"];

    /// The options of an occlusion field.
    #[must_use]
    pub fn of_field(&self) -> FieldOptions {
        let [inner, outer] = self.range;
        let points = FieldOptions::default().spheres(self.spheres).cells(self.cells);
        points.inner(inner).outer(outer).order(self.order)
    }

    /// The options of the light around a lamp.
    #[must_use]
    pub fn of_lamp(&self) -> RadianceOptions {
        let [inner, outer] = self.range;
        let points = RadianceOptions::default().spheres(self.spheres).cells(self.cells);
        points.inner(inner).outer(outer).order(self.order)
    }

    /// Sample points.
    #[must_use]
    pub fn points(&self) -> usize {
        (self.cells + 1).pow(2) * self.spheres + 1
    }

    /// The most bytes of the rows of sample points while they are baked and written.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        COPIES * size_of::<f32>() as u64 * (self.points() * self.order * (self.order + 1)) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_job_has_the_defaults_of_the_library() {
        assert_eq!(FieldSampling::default().of_field(), FieldOptions::default());
        assert_eq!(FieldSampling::default().of_lamp(), RadianceOptions::default());
    }
}
