//! Mirrors by dual paraboloid mapping.

use lobe_sh::{Coefficient, Dir, Rgb};

use crate::gallery::exhibit::{Shading, SurfacePoint};
use crate::gallery::square_texture::SquareTexture;

/// Half the width of the band in which the two textures are mixed, as `|r_x|`: 5.7° on either side of the seam. Wider
/// hides nothing more and wastes texels.
const BAND: f64 = 0.1;

/// A perfect mirror that looks its reflected direction up in two parabolic mirrors, each of which shows a hemisphere.
///
/// ```text
///   r = 2 (n·v) n - v
///   front  p = (-r_y, r_z)/(1 + r_x)        back  p = (r_y, r_z)/(1 - r_x)
///   L = w front(p) + (1 - w) back(p)        w = clamp(½ + r_x/(2b), 0, 1),  b = 0.1
/// ```
///
/// The classic sum of both textures, black outside their discs, shows a dark seam along `r_x = 0`, because bilinear
/// lookups at the rim mix with black. A choice by the sign of `r_x` leaves an edge where the two disagree. Here each
/// texture reaches beyond its hemisphere, where the formula for `p` holds just as well, and the two are mixed over a
/// band of `|r_x| < b` in which both are valid:
///
/// ```text
///   |p| = √((1 - r_x)/(1 + r_x)) <= √((1 + b)/(1 - b)) = 1.106        (front; for the back with -r_x)
/// ```
///
/// So the texture spans `|p_x|, |p_y| <= 1.106` and two texels, and the result is continuous (test
/// `the_seam_of_the_paraboloids_does_not_show`). The error falls with the square of the texel size (test
/// `mirrors_agree_with_the_traced_reflection_to_second_order`). Heidrich and Seidel 1998; the band is ours.
#[derive(Clone, Debug, PartialEq)]
pub struct Paraboloids {
    front: SquareTexture,
    back: SquareTexture,
    /// The texture shows `|p_x|, |p_y| <= reach`.
    reach: f64,
}

impl Paraboloids {
    /// The mirror whose two textures have `size` x `size` samples of `source` each.
    ///
    /// # Panics
    /// If `size` is less than 8: there would be no room for the rims.
    #[must_use]
    pub fn sampled(size: usize, source: impl Fn(Dir) -> Rgb<f32> + Sync) -> Self {
        assert!(size >= 8, "a paraboloid needs at least 8 texels across, not {size}");
        let rim = ((1.0 + BAND) / (1.0 - BAND)).sqrt();
        // Two texels of 2 reach/size each beyond the rim: reach = rim + 2 (2 reach/size)
        let reach = rim / (1.0 - 4.0 / size as f64);
        let side = |facing: f64| SquareTexture::from_fn(size, &|x, y| source(direction(facing, reach * x, reach * y)));
        Self { front: side(1.0), back: side(-1.0), reach }
    }

    /// The light from the direction `r`.
    #[must_use]
    pub fn lookup(&self, r: Dir) -> Rgb<f32> {
        let weight = (0.5 + 0.5 * r.x() / BAND).clamp(0.0, 1.0);
        let look = |texture: &SquareTexture, facing: f64| {
            let scale = 1.0 / ((1.0 + facing * r.x()) * self.reach);
            texture.lookup(-facing * r.y() * scale, r.z() * scale)
        };
        if weight == 1.0 {
            return look(&self.front, 1.0);
        }
        if weight == 0.0 {
            return look(&self.back, -1.0);
        }
        look(&self.front, 1.0).scale(weight as f32) + look(&self.back, -1.0).scale((1.0 - weight) as f32)
    }
}

impl Shading for Paraboloids {
    fn radiance(&self, at: &SurfacePoint) -> Rgb<f32> {
        self.lookup(at.reflected())
    }
}

/// The direction at `p = (x, y)` of the paraboloid that faces `±x`, inside its disc and beyond.
///
/// ```text
///   s = (±(1 - q), ∓2x, 2y)/(1 + q)        q = x² + y²
/// ```
fn direction(facing: f64, x: f64, y: f64) -> Dir {
    let q = x * x + y * y;
    Dir::from_unit([facing * (1.0 - q), -facing * 2.0 * x, 2.0 * y].map(|c| c / (1.0 + q)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn smooth(s: Dir) -> Rgb<f32> {
        Rgb::new((2.0 + s.x() - s.y()) as f32, (1.5 + s.y() * s.z()) as f32, (2.0 * s.z()).exp() as f32)
    }

    #[test]
    fn the_seam_of_the_paraboloids_does_not_show() {
        let mirror = Paraboloids::sampled(32, smooth);
        for edge in [0.0, BAND, -BAND] {
            for k in 0..60 {
                let phi = 0.1047 * f64::from(k);
                let at = |x: f64| {
                    let r = (1.0 - x * x).sqrt();
                    mirror.lookup(Dir::from_unit([x, r * phi.cos(), r * phi.sin()]))
                };
                let (below, above) = (at(edge - 1e-7), at(edge + 1e-7));
                let step = (below.b - above.b).abs().max((below.r - above.r).abs());
                assert!(step < 1e-5, "at x = {edge}, azimuth {phi}: {below:?} and {above:?}");
            }
        }
    }

    #[test]
    fn in_the_band_the_mixture_is_as_right_as_elsewhere() {
        let mirror = Paraboloids::sampled(64, smooth);
        let worst = |low: f64, high: f64| {
            (0..4000).fold(0.0_f64, |worst, k| {
                let x = low + (high - low) * f64::from(k) / 4000.0;
                let (r, phi) = ((1.0 - x * x).sqrt(), 2.4 * f64::from(k));
                let s = Dir::from_unit([x, r * phi.cos(), r * phi.sin()]);
                worst.max(f64::from((mirror.lookup(s).b - smooth(s).b).abs()))
            })
        };
        let (band, beside, all) = (worst(-BAND, BAND), worst(BAND, 0.3), worst(-1.0, 1.0));
        println!("largest error in the band {band:.1e}, beside it {beside:.1e}, anywhere {all:.1e}");
        assert!(band < 1.2 * all && all < 0.02, "band {band}, beside {beside}, anywhere {all}");
    }
}
