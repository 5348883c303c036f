//! Undersampled source texels: additional samples from the side of the source.

use lobe_io::parallel;

use crate::mapping::solid_angles::SolidAngles;
use crate::resample::sample_points::{Sampler, midpoints};

/// A source texel that lacks at least this fraction of its energy in the target is sampled from its own side too.
const UNDERSAMPLED: f64 = 0.5;

/// An additional sample: one source texel in the footprint of a target texel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AdditionalSample {
    pub(crate) target: u32,
    pub(crate) source: u32,
    pub(crate) weight: f32,
}

/// The additional samples of source texels with the given solid angles that have `energies` in the target.
pub(crate) fn additional_samples(
    sampler: &Sampler,
    solid_angles: &SolidAngles,
    energies: &[f64],
) -> Vec<AdditionalSample> {
    let width = sampler.source.width;
    let of_row = |y: usize| {
        let mut extras = Vec::new();
        for (x, energy) in energies[y * width..][..width].iter().enumerate() {
            let solid_angle = solid_angles.get(x, y);
            if solid_angle - energy >= UNDERSAMPLED * solid_angle && solid_angle > 0.0 {
                add(sampler, [x, y], 1.0 - energy / solid_angle, &mut extras);
            }
        }
        extras
    };
    parallel::map(sampler.source.height, &of_row).concat()
}

/// Adds four samples in a source texel, which together carry `share` of it.
fn add(sampler: &Sampler, texel: [usize; 2], share: f64, extras: &mut Vec<AdditionalSample>) {
    let (source, target) = (sampler.source, sampler.target);
    let mut nodes = Vec::new();
    crate::mapping::texel_quadrature::nodes_into(
        source.mapping,
        [source.width, source.height],
        texel,
        &midpoints(2),
        &mut nodes,
    );
    for (s, weight) in nodes {
        let index = target.texel(target.point(sampler.to_target(s)));
        let number = texel[1] * source.width + texel[0];
        extras.push(AdditionalSample { target: index as u32, source: number as u32, weight: (share * weight) as f32 });
    }
}
