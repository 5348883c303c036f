//! Irradiance in packed constants at many normals, sixteen at once.

use crate::scalar::Rgb;
use crate::simd::{Kernel, LANES, Lanes};
#[cfg(feature = "simd")]
use crate::simd::{Wide, constant};

/// The vectors of [`PackedIrradiance::to_vectors`](crate::encoding::PackedIrradiance::to_vectors) at each normal of blocks: `out` has a color for each normal that there is.
pub(super) struct EvalPacked<'a> {
    pub(super) vectors: [[f32; 4]; 7],
    pub(super) normals: &'a [[Lanes; 3]],
    pub(super) out: &'a mut [Rgb<f32>],
}

impl Kernel for EvalPacked<'_> {
    type Output = ();

    #[cfg(feature = "simd")]
    #[inline(always)]
    fn wide<S: pulp::Simd>(self, simd: S) {
        for (n, out) in self.normals.iter().zip(self.out.chunks_mut(LANES)) {
            let mut colors = [Lanes::ZERO; 3];
            for part in 0..Wide::<S>::PARTS {
                let [x, y, z] =
                    [Wide::load(simd, &n[0], part), Wide::load(simd, &n[1], part), Wide::load(simd, &n[2], part)];
                let (linear, quadratic, difference) =
                    ([x, y, z], [x * y, y * z, z * z, z * x], x.times_minus(x, y * y));
                for c in 0..3 {
                    let (a, b) = (self.vectors[c], self.vectors[3 + c]);
                    let mut linear_sum = constant(simd, a[3]);
                    for k in 0..3 {
                        linear_sum = linear[k].times_plus(constant(simd, a[k]), linear_sum);
                    }
                    let mut sum = difference * constant(simd, self.vectors[6][c]);
                    for k in 0..4 {
                        sum = quadratic[k].times_plus(constant(simd, b[k]), sum);
                    }
                    (linear_sum + sum).store(&mut colors[c], part);
                }
            }
            interleave(&colors, out);
        }
    }

    fn plain(self) {
        for (n, out) in self.normals.iter().zip(self.out.chunks_mut(LANES)) {
            let mut colors = [Lanes::ZERO; 3];
            for lane in 0..LANES {
                let [x, y, z] = [n[0].0[lane], n[1].0[lane], n[2].0[lane]];
                let quadratic = [x * y, y * z, z * z, z * x];
                for (c, color) in colors.iter_mut().enumerate() {
                    let (a, b) = (self.vectors[c], self.vectors[3 + c]);
                    let linear_sum = a[0] * x + a[1] * y + a[2] * z + a[3];
                    let sum: f32 = b.iter().zip(quadratic).map(|(b, q)| b * q).sum();
                    color.0[lane] = linear_sum + sum + self.vectors[6][c] * (x * x - y * y);
                }
            }
            interleave(&colors, out);
        }
    }
}

/// Channels of sixteen colors as colors.
#[inline(always)]
fn interleave([r, g, b]: &[Lanes; 3], out: &mut [Rgb<f32>]) {
    for (lane, out) in out.iter_mut().enumerate() {
        *out = Rgb::new(r.0[lane], g.0[lane], b.0[lane]);
    }
}

#[cfg(test)]
mod tests {
    use alloc::vec;
    use alloc::vec::Vec;

    use lobe_testkit::Random;

    use super::*;
    use crate::batch::dir_batch::DirBatch;
    use crate::encoding::packed_irradiance::PackedIrradiance;
    use crate::expansion::ShVec;
    use crate::simd::Machine;
    use crate::sphere::Dir;

    /// Sums of ten terms of size 1 in single precision.
    const ERROR: f64 = 2e-6;

    #[test]
    fn every_machine_has_the_value_of_each_normal() {
        let values = Random::new(6).signed_vec(27);
        let radiance = (0..9).map(|i| Rgb::new(values[i], values[9 + i], values[18 + i])).collect();
        let packed = PackedIrradiance::from_radiance_sh(&ShVec::from_vec(radiance).unwrap());
        let normals: Vec<Dir> = lobe_testkit::directions().into_iter().map(Dir::from_unit).collect();
        for count in [0, 1, LANES, normals.len()] {
            let batch: DirBatch = normals[..count].iter().copied().collect();
            for machine in Machine::available() {
                let mut found = vec![Rgb::new(f32::NAN, f32::NAN, f32::NAN); count];
                let vectors = packed.to_vectors();
                machine.run(EvalPacked { vectors, normals: batch.blocks(), out: &mut found });
                for (n, found) in normals.iter().zip(found) {
                    let expected = packed.eval(*n);
                    for (a, b) in [(found.r, expected.r), (found.g, expected.g), (found.b, expected.b)] {
                        let off = (f64::from(a) - b).abs();
                        assert!(off < ERROR, "{}, {n:?}: {a}, {b}", machine.name());
                    }
                }
            }
        }
    }
}
