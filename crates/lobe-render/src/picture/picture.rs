//! A picture in linear light.

use lobe_env::EnvMap;
use lobe_sh::{Coefficient, Rgb};
use rayon::prelude::*;

use crate::RenderError;

/// A picture: rows from the top, linear light, no alpha.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    width: usize,
    height: usize,
    pixels: Vec<Rgb<f32>>,
}

impl Picture {
    /// A picture from its pixels, row by row from the top.
    ///
    /// # Errors
    /// [`RenderError::Invalid`] if there are not `width × height` pixels.
    pub fn new(width: usize, height: usize, pixels: Vec<Rgb<f32>>) -> Result<Self, RenderError> {
        if width.checked_mul(height) != Some(pixels.len()) {
            let found = pixels.len();
            return Err(RenderError::Invalid(format!("a {width} x {height} picture cannot have {found} pixels")));
        }
        Ok(Self { width, height, pixels })
    }

    /// A picture of one color.
    #[must_use]
    pub fn filled(width: usize, height: usize, color: Rgb<f32>) -> Self {
        Self { width, height, pixels: vec![color; width * height] }
    }

    /// The picture whose pixel in column `x` and row `y` is `f(x, y)`; rows are computed in parallel.
    #[must_use]
    pub fn from_fn(width: usize, height: usize, f: impl Fn(usize, usize) -> Rgb<f32> + Sync) -> Self {
        let mut picture = Self::filled(width, height, Rgb::ZERO);
        picture.for_each_row(|y, row| {
            for (x, pixel) in row.iter_mut().enumerate() {
                *pixel = f(x, y);
            }
        });
        picture
    }

    /// Calls `f` with every row number and row, in parallel.
    pub(crate) fn for_each_row(&mut self, f: impl Fn(usize, &mut [Rgb<f32>]) + Sync) {
        if self.width > 0 {
            self.pixels.par_chunks_mut(self.width).enumerate().for_each(|(y, row)| f(y, row));
        }
    }

    /// Number of columns.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Number of rows.
    #[must_use]
    pub fn height(&self) -> usize {
        self.height
    }

    /// All pixels, row by row from the top.
    #[must_use]
    pub fn pixels(&self) -> &[Rgb<f32>] {
        &self.pixels
    }

    /// All pixels, to change.
    pub fn pixels_mut(&mut self) -> &mut [Rgb<f32>] {
        &mut self.pixels
    }

    /// The pixel in column `x`, row `y`.
    ///
    /// # Panics
    /// If it lies outside the picture.
    #[must_use]
    pub fn pixel(&self, x: usize, y: usize) -> Rgb<f32> {
        assert!(x < self.width && y < self.height, "no pixel ({x}, {y}) in {} x {}", self.width, self.height);
        self.pixels[y * self.width + x]
    }

    /// The picture with every pixel changed by `f`.
    #[must_use]
    pub fn map(&self, f: impl Fn(Rgb<f32>) -> Rgb<f32>) -> Self {
        Self { width: self.width, height: self.height, pixels: self.pixels.iter().map(|&c| f(c)).collect() }
    }

    /// The mean color, summed in `f64`; zero for an empty picture.
    #[must_use]
    pub fn mean(&self) -> Rgb<f64> {
        let mut sum = Rgb::<f64>::ZERO;
        for pixel in &self.pixels {
            sum += pixel.widen();
        }
        sum.scale((self.pixels.len().max(1) as f64).recip())
    }

    /// Copies `other` into this picture with its top left pixel at column `left`, row `top`; what lies outside is
    /// left out.
    pub fn paste(&mut self, other: &Self, left: isize, top: isize) {
        for y in 0..other.height {
            for x in 0..other.width {
                if let Some(pixel) = self.pixel_mut(left + x as isize, top + y as isize) {
                    *pixel = other.pixels[y * other.width + x];
                }
            }
        }
    }

    /// Covers the part `coverage` (0 to 1) of a pixel with `color`; pixels outside the picture are left out.
    pub fn blend(&mut self, x: isize, y: isize, color: Rgb<f32>, coverage: f64) {
        if let Some(pixel) = self.pixel_mut(x, y) {
            *pixel = mix(*pixel, color, coverage);
        }
    }

    fn pixel_mut(&mut self, x: isize, y: isize) -> Option<&mut Rgb<f32>> {
        let (x, y) = (usize::try_from(x).ok()?, usize::try_from(y).ok()?);
        if x < self.width { self.pixels.get_mut(y * self.width + x) } else { None }
    }
}

impl From<&EnvMap> for Picture {
    /// The lat-long picture of an environment, texel by texel.
    ///
    /// ```
    /// use lobe_env::bundled;
    /// use lobe_render::{Picture, Tone};
    ///
    /// let sky = Picture::from(&bundled::sunset().map());
    /// let png = sky.resized(256, 128).to_png(&Tone::PHOTOGRAPH)?;
    /// # assert_eq!(&png[1..4], b"PNG");
    /// # Ok::<(), lobe_render::RenderError>(())
    /// ```
    fn from(map: &EnvMap) -> Self {
        Self { width: map.width(), height: map.height(), pixels: map.texels().to_vec() }
    }
}

/// `(1 - t) a + t b`, with `t` held to `[0, 1]`.
pub(crate) fn mix(a: Rgb<f32>, b: Rgb<f32>, t: f64) -> Rgb<f32> {
    let t = t.clamp(0.0, 1.0) as f32;
    a.scale(1.0 - t) + b.scale(t)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbered(width: usize, height: usize) -> Picture {
        Picture::from_fn(width, height, |x, y| Rgb::new(x as f32, y as f32, 1.0))
    }

    #[test]
    fn a_wrong_number_of_pixels_is_refused() {
        let error = Picture::new(3, 2, vec![Rgb::ZERO; 5]).unwrap_err().to_string();
        assert_eq!(error, "a 3 x 2 picture cannot have 5 pixels", "{error}");
        assert!(Picture::new(usize::MAX, 2, Vec::new()).is_err(), "the product overflows");
    }

    #[test]
    fn the_picture_of_an_environment_has_its_texels_in_place() {
        let map = EnvMap::from_fn(6, 3, |s| Rgb::new(s.x() as f32, s.y() as f32, s.z() as f32));
        let picture = Picture::from(&map);
        assert_eq!((picture.width(), picture.height()), (6, 3), "size");
        for y in 0..3 {
            for x in 0..6 {
                assert_eq!(picture.pixel(x, y), map.texel(x, y), "({x}, {y})");
            }
        }
    }

    #[test]
    fn pasting_leaves_out_what_lies_outside() {
        for (left, top) in [(0, 0), (-2, -1), (3, 2), (9, 9), (-9, 0)] {
            let mut canvas = Picture::filled(5, 4, Rgb::ZERO);
            canvas.paste(&numbered(4, 3), left, top);
            for y in 0..4 {
                for x in 0..5 {
                    let (u, v) = (x as isize - left, y as isize - top);
                    let inside = (0..4).contains(&u) && (0..3).contains(&v);
                    let expected = if inside { Rgb::new(u as f32, v as f32, 1.0) } else { Rgb::ZERO };
                    assert_eq!(canvas.pixel(x, y), expected, "pixel ({x}, {y}), pasted at ({left}, {top})");
                }
            }
        }
    }

    #[test]
    fn the_mean_is_that_of_every_channel() {
        assert_eq!(numbered(5, 3).mean(), Rgb::new(2.0, 1.0, 1.0), "columns 0 to 4, rows 0 to 2");
        assert_eq!(Picture::filled(0, 7, Rgb::ZERO).mean(), Rgb::ZERO, "an empty picture");
    }
}
