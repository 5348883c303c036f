//! Picture: a rectangle of pixels in linear light.

use lobe_io::parallel;

use crate::error::ImageError;
use crate::pixel::{BLACK, IntoPixel, Pixel, add, mix, scaled, widened};

/// A picture: rows from the top, linear light.
///
/// Few pictures have an [alpha](Picture::alpha): those of something in front of nothing. Their pixels hold the light
/// that it sends, which is that of the whole pixel (associated, or premultiplied).
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    width: usize,
    height: usize,
    pixels: Vec<Pixel>,
    /// None where all of it is opaque.
    alpha: Option<Vec<f32>>,
}

impl Picture {
    /// A picture from its pixels, row by row from the top.
    ///
    /// # Errors
    /// [`ImageError::Options`] if there are not `width × height` pixels.
    pub fn new(width: usize, height: usize, pixels: Vec<impl IntoPixel>) -> Result<Self, ImageError> {
        if width.checked_mul(height) != Some(pixels.len()) {
            let found = pixels.len();
            return Err(ImageError::Options(format!("a {width} x {height} picture cannot have {found} pixels")));
        }
        // In place: the vector keeps its memory where new and old items have the same size.
        Ok(Self { width, height, pixels: pixels.into_iter().map(Into::into).collect(), alpha: None })
    }

    /// A picture of one color.
    #[must_use]
    pub fn filled(width: usize, height: usize, color: impl IntoPixel) -> Self {
        Self { width, height, pixels: vec![color.into(); width * height], alpha: None }
    }

    /// The picture with an alpha: the part of each pixel that is covered, 0 to 1, row by row from the top.
    ///
    /// Pixels keep their numbers, which are taken as light in front of black: over a background `L` a pixel is
    /// `C + (1 - α) L` (Porter and Duff's *over* of associated colors).
    ///
    /// ```
    /// use lobe_image::{Picture, Tone};
    ///
    /// // White that covers a quarter of the pixel.
    /// let edge = Picture::filled(1, 1, [0.25; 3]).with_alpha(vec![0.25])?;
    /// assert_eq!(Tone::PLAIN.to_rgba_bytes(&edge), [255, 255, 255, 64]);
    /// # Ok::<(), lobe_image::ImageError>(())
    /// ```
    ///
    /// # Errors
    /// [`ImageError::Options`] if there is another number of values than of pixels.
    pub fn with_alpha(self, alpha: Vec<f32>) -> Result<Self, ImageError> {
        if alpha.len() != self.pixels.len() {
            let (width, height, found) = (self.width, self.height, alpha.len());
            return Err(ImageError::Options(format!("a {width} x {height} picture cannot have {found} alphas")));
        }
        Ok(Self { alpha: Some(alpha), ..self })
    }

    /// The part of each pixel that is covered, row by row from the top; none where all of it is opaque.
    ///
    /// [`Picture::map`] keeps it. What makes another picture of this one, such as [`Picture::resized`], leaves it out.
    #[must_use]
    pub fn alpha(&self) -> Option<&[f32]> {
        self.alpha.as_deref()
    }

    /// The picture whose pixel in column `x` and row `y` is `f(x, y)`; rows are computed in parallel.
    #[must_use]
    pub fn from_fn<P: IntoPixel>(width: usize, height: usize, f: impl Fn(usize, usize) -> P + Sync) -> Self {
        let mut picture = Self::filled(width, height, BLACK);
        picture.for_each_row(&|y, row| {
            for (x, pixel) in row.iter_mut().enumerate() {
                *pixel = f(x, y).into();
            }
        });
        picture
    }

    /// Calls `f` with every row number and row, in parallel.
    fn for_each_row(&mut self, f: &(dyn Fn(usize, &mut [Pixel]) + Sync)) {
        if self.width > 0 {
            parallel::rows(&mut self.pixels, self.width, f);
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
    pub fn pixels(&self) -> &[Pixel] {
        &self.pixels
    }

    /// All pixels, to change.
    pub fn pixels_mut(&mut self) -> &mut [Pixel] {
        &mut self.pixels
    }

    /// All pixels, row by row from the top, as any color of three channels.
    #[must_use]
    pub fn into_pixels<P: From<Pixel>>(self) -> Vec<P> {
        self.pixels.into_iter().map(P::from).collect()
    }

    /// The pixel in column `x`, row `y`.
    ///
    /// # Panics
    /// If it lies outside the picture.
    #[must_use]
    pub fn pixel(&self, x: usize, y: usize) -> Pixel {
        assert!(x < self.width && y < self.height, "no pixel ({x}, {y}) in {} x {}", self.width, self.height);
        self.pixels[y * self.width + x]
    }

    /// The picture with every pixel changed by `f`.
    #[must_use]
    pub fn map<P: IntoPixel>(&self, f: impl Fn(Pixel) -> P) -> Self {
        let pixels = self.pixels.iter().map(|&c| f(c).into()).collect();
        Self { width: self.width, height: self.height, pixels, alpha: self.alpha.clone() }
    }

    /// The mean color, summed in `f64`; zero for an empty picture.
    #[must_use]
    pub fn mean(&self) -> [f64; 3] {
        let sum = self.pixels.iter().fold([0.0; 3], |sum, pixel| add(sum, widened(*pixel)));
        scaled(sum, (self.pixels.len().max(1) as f64).recip())
    }

    /// Copies `other` into this picture with its top left pixel at column `left`, row `top`, clipped to this picture.
    pub fn paste(&mut self, other: &Self, left: isize, top: isize) {
        for y in 0..other.height {
            for x in 0..other.width {
                if let Some(pixel) = self.pixel_mut(left + x as isize, top + y as isize) {
                    *pixel = other.pixels[y * other.width + x];
                }
            }
        }
    }

    /// Covers the fraction `coverage` (0 to 1) of a pixel with `color`; pixels outside the picture are ignored.
    pub fn blend(&mut self, x: isize, y: isize, color: impl IntoPixel, coverage: f64) {
        if let Some(pixel) = self.pixel_mut(x, y) {
            *pixel = mix(*pixel, color, coverage);
        }
    }

    fn pixel_mut(&mut self, x: isize, y: isize) -> Option<&mut Pixel> {
        let (x, y) = (usize::try_from(x).ok()?, usize::try_from(y).ok()?);
        if x < self.width { self.pixels.get_mut(y * self.width + x) } else { None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbered(width: usize, height: usize) -> Picture {
        Picture::from_fn(width, height, |x, y| [x as f32, y as f32, 1.0])
    }

    #[test]
    fn a_wrong_number_of_pixels_is_refused() {
        let error = Picture::new(3, 2, vec![BLACK; 5]).unwrap_err().to_string();
        assert_eq!(error, "a 3 x 2 picture cannot have 5 pixels", "{error}");
        assert!(Picture::new(usize::MAX, 2, Vec::<Pixel>::new()).is_err(), "the product overflows");
    }

    #[test]
    fn a_wrong_number_of_alphas_is_refused() {
        let error = numbered(3, 2).with_alpha(vec![1.0; 5]).unwrap_err().to_string();
        assert_eq!(error, "a 3 x 2 picture cannot have 5 alphas", "{error}");
    }

    #[test]
    fn pasting_leaves_out_what_lies_outside() {
        for (left, top) in [(0, 0), (-2, -1), (3, 2), (9, 9), (-9, 0)] {
            let mut canvas = Picture::filled(5, 4, BLACK);
            canvas.paste(&numbered(4, 3), left, top);
            for y in 0..4 {
                for x in 0..5 {
                    let (u, v) = (x as isize - left, y as isize - top);
                    let inside = (0..4).contains(&u) && (0..3).contains(&v);
                    let expected = if inside { [u as f32, v as f32, 1.0] } else { BLACK };
                    assert_eq!(canvas.pixel(x, y), expected, "pixel ({x}, {y}), pasted at ({left}, {top})");
                }
            }
        }
    }

    #[test]
    fn the_mean_is_that_of_every_channel() {
        assert_eq!(numbered(5, 3).mean(), [2.0, 1.0, 1.0], "columns 0 to 4, rows 0 to 2");
        assert_eq!(Picture::filled(0, 7, BLACK).mean(), [0.0; 3], "an empty picture");
    }
}
