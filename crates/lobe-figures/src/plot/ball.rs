//! A white Lambertian ball shaded by irradiance.

use std::f64::consts::PI;

use lobe_io::parallel;
use lobe_sh::{Coefficient, Dir, Expansion, Rgb};

use lobe_image::{Picture, mix};
use lobe_render::View;

/// Room around the disc, in pixels, for its smooth edge.
const MARGIN: f64 = 1.0;

/// A square picture of a white (albedo 1) Lambertian ball.
///
/// The ball shows, at every normal `n`, the radiance it leaves:
///
/// ```text
///   L_out(n) = E(n) / π
/// ```
///
/// A picture is painted from `E` as a function, as an expansion, or from values computed elsewhere for all
/// [`Ball::normals`] in one batch. The silhouette is smooth: pixels on the rim are mixed with the background by the
/// part that the disc covers.
#[derive(Clone, Copy, Debug)]
pub struct Ball {
    size: usize,
    view: View,
}

impl Ball {
    /// A ball in a picture of `size × size` pixels, seen along +x ([`View::ALONG_X`]).
    #[must_use]
    pub fn new(size: usize) -> Self {
        Self { size, view: View::ALONG_X }
    }

    /// The same ball seen from elsewhere.
    #[must_use]
    pub fn seen(self, view: View) -> Self {
        Self { view, ..self }
    }

    /// The number of columns and of rows.
    #[must_use]
    pub fn size(&self) -> usize {
        self.size
    }

    /// The pixels that show the ball, as indices into the picture row by row, each with the normal at its center.
    ///
    /// Pixels of the rim whose center lies outside the disc have the normal of the nearest point of the rim.
    #[must_use]
    pub fn normals(&self) -> Vec<(usize, Dir)> {
        let r = self.radius();
        (0..self.size * self.size)
            .filter(|&i| self.coverage(i) > 0.0)
            .map(|i| {
                let (right, up) = self.position(i);
                (i, self.view.dir_at(right / r, up / r))
            })
            .collect()
    }

    /// The ball in the colors `radiance(n)` over a background.
    #[must_use]
    pub fn picture(&self, background: Rgb<f32>, radiance: impl Fn(Dir) -> Rgb<f64> + Sync) -> Picture {
        self.painted(background, &radiance)
    }

    fn painted(&self, background: Rgb<f32>, radiance: &(dyn Fn(Dir) -> Rgb<f64> + Sync)) -> Picture {
        let normals = self.normals();
        let colors = parallel::map(normals.len(), &|i| radiance(normals[i].1));
        drop(normals);
        self.picture_from_values(background, &colors)
    }

    /// The ball in given colors, one for each of [`Ball::normals`] in their order.
    ///
    /// # Panics
    /// If there are not as many colors as normals.
    #[must_use]
    pub fn picture_from_values<T: Coefficient<Wide = Rgb<f64>>>(&self, background: Rgb<f32>, colors: &[T]) -> Picture {
        let normals = self.normals();
        assert_eq!(colors.len(), normals.len(), "one color is needed for each normal");
        let mut picture = Picture::filled(self.size, self.size, background);
        let pixels = picture.pixels_mut();
        for ((i, _), &color) in normals.into_iter().zip(colors) {
            pixels[i] = mix(background, Rgb::<f32>::narrow(color.widen()), self.coverage(i));
        }
        picture
    }

    /// The ball under the irradiance `E(n)`: radiance `E/π`.
    #[must_use]
    pub fn lit(&self, background: Rgb<f32>, irradiance: impl Fn(Dir) -> Rgb<f64> + Sync) -> Picture {
        self.painted(background, &|n| irradiance(n).scale(1.0 / PI))
    }

    /// The ball under given irradiances, one for each of [`Ball::normals`] in their order: radiance `E/π`.
    ///
    /// # Panics
    /// If there are not as many values as normals.
    #[must_use]
    pub fn lit_by_values(&self, background: Rgb<f32>, irradiance: &[Rgb<f64>]) -> Picture {
        let radiance: Vec<_> = irradiance.iter().map(|e| e.scale(1.0 / PI)).collect();
        self.picture_from_values(background, &radiance)
    }

    /// The ball under an irradiance expansion: radiance `E/π`. Where the expansion is negative the picture is too.
    #[must_use]
    pub fn lit_by_sh<T: Coefficient<Wide = Rgb<f64>>>(
        &self,
        background: Rgb<f32>,
        irradiance: &(impl Expansion<T> + Sync),
    ) -> Picture {
        self.lit(background, |n| irradiance.eval(n).widen())
    }

    fn radius(&self) -> f64 {
        (0.5 * self.size as f64 - MARGIN).max(0.5)
    }

    /// The position of the center of pixel `i`, to the right of and above the center of the picture.
    fn position(&self, i: usize) -> (f64, f64) {
        let middle = 0.5 * self.size as f64;
        let (x, y) = ((i % self.size) as f64 + 0.5, (i / self.size) as f64 + 0.5);
        (x - middle, middle - y)
    }

    /// The part of pixel `i` that the disc covers, its edge taken as straight within the pixel.
    fn coverage(&self, i: usize) -> f64 {
        let (right, up) = self.position(i);
        (self.radius() - right.hypot(up) + 0.5).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use lobe_sh::{ShVec, Zonal};

    use super::*;

    const BLACK: Rgb<f32> = Rgb::new(0.0, 0.0, 0.0);

    #[test]
    fn a_ball_under_constant_irradiance_is_flat() {
        let ball = Ball::new(65);
        let picture = ball.lit(Rgb::splat(0.25), |_| Rgb::splat(PI));
        let sh = ball.lit_by_sh(Rgb::splat(0.25), &ShVec::constant(3, Rgb::splat(PI)));
        for (x, y) in [(32, 32), (32, 3), (5, 40), (60, 32)] {
            assert_eq!(picture.pixel(x, y), [1.0; 3], "pixel ({x}, {y})");
            assert!((sh.pixel(x, y)[1] - 1.0).abs() < 1e-6, "by SH, pixel ({x}, {y}): {:?}", sh.pixel(x, y));
        }
        assert_eq!(picture.pixel(0, 0), [0.25; 3], "the background");
    }

    #[test]
    fn the_rim_covers_the_area_of_the_disc() {
        for size in [16, 33, 100] {
            let white = Ball::new(size).picture(BLACK, |_| Rgb::splat(1.0));
            let area = white.mean()[1] * (size * size) as f64;
            let disc = PI * (0.5 * size as f64 - MARGIN).powi(2);
            // A straight edge in place of an arc is wrong by a part of a pixel for every few pixels of the rim.
            assert!((area / disc - 1.0).abs() < 0.01, "size {size}: {area} pixels instead of {disc}");
        }
    }

    #[test]
    fn the_brightest_pixel_lies_where_the_light_is_seen() {
        for view in [View::ALONG_X, View::three_quarter()] {
            for towards in [[-1.0, 0.0, 0.0], [-1.0, -0.8, 0.3], [0.9, 0.5, 0.2], [-0.4, 0.5, -0.7], [0.4, 0.5, 0.7]] {
                let light = Dir::new(towards).unwrap();
                let [right, up, forward] = view.project(light.to_array());
                if forward < 0.1 {
                    continue;
                }
                let ball = Ball::new(101).seen(view);
                let picture = ball.lit_by_sh(BLACK, &Zonal::new(vec![1.0, 1.0]).towards(light, Rgb::splat(1.0_f64)));
                let (brightest, _) = picture
                    .pixels()
                    .iter()
                    .enumerate()
                    .fold((0, -1.0), |(i, best), (k, c)| if c[1] > best { (k, c[1]) } else { (i, best) });
                let (x, y) = ((brightest % 101) as f64 + 0.5, (brightest / 101) as f64 + 0.5);
                let expected = (50.5 + 49.5 * right, 50.5 - 49.5 * up);
                let off = (x - expected.0).hypot(y - expected.1);
                assert!(off < 1.5, "light {towards:?}: brightest at ({x}, {y}), expected {expected:?}");
            }
        }
    }

    #[test]
    fn values_in_the_order_of_the_normals_paint_the_same_ball() {
        let ball = Ball::new(48).seen(View::three_quarter());
        let f = |n: Dir| Rgb::new(n.x(), n.y(), n.z());
        let values: Vec<_> = ball.normals().into_iter().map(|(_, n)| f(n)).collect();
        assert!(ball.picture(BLACK, f) == ball.picture_from_values(BLACK, &values), "as radiance");
        assert!(ball.lit(BLACK, f) == ball.lit_by_values(BLACK, &values), "as irradiance");
    }
}
