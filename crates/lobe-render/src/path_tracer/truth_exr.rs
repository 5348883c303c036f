//! Traced pictures as OpenEXR files.

use std::fs;
use std::path::Path;

use lobe_image::{ExrAttribute, ExrLayers, Picture, Pixel};
use lobe_io::write_atomically;

use crate::error::RenderError;
use crate::path_tracer::reference::Truth;

/// The attribute that holds the degrees of freedom of the variance.
const FREEDOM: &str = "lobeDegreesOfFreedom";

/// The prefix of the channels of variance.
const VARIANCE: &str = "variance";

/// The channel of the part of a pixel that shows a surface.
const COVERAGE: &str = "coverage.A";

impl Truth {
    /// The bytes of an OpenEXR file of one part, 32-bit floats:
    ///
    /// | channels | |
    /// |---|---|
    /// | `R`, `G`, `B` | radiance |
    /// | `A` | its alpha, before [no backdrop](crate::Backdrop::None) alone: that of `coverage.A` |
    /// | `variance.R`, `.G`, `.B` | the variance of that mean |
    /// | `albedo.R`, `.G`, `.B` | base color |
    /// | `normal.X`, `.Y`, `.Z` | shading normal in the world |
    /// | `depth.Z` | distance from the eye |
    /// | `coverage.A` | the part of the pixel that shows a surface, as of [`Truth::coverage`] |
    ///
    /// # Errors
    /// [`RenderError::Invalid`] if the format cannot hold the picture.
    pub fn to_exr(&self) -> Result<Vec<u8>, RenderError> {
        let plane = |picture: &Picture, c: usize| picture.pixels().iter().map(|p| p[c]).collect();
        let (width, height) = (self.mean.width(), self.mean.height());
        let mut layers = ExrLayers::new(width, height);
        for (c, name) in ["R", "G", "B"].iter().enumerate() {
            layers.channel(*name, plane(&self.mean, c));
            layers.channel(format!("{VARIANCE}.{name}"), plane(&self.variance, c));
            layers.channel(format!("albedo.{name}"), plane(&self.albedo, c));
            layers.channel(format!("normal.{}", ["X", "Y", "Z"][c]), plane(&self.normal, c));
        }
        if let Some(alpha) = self.mean.alpha() {
            layers.channel("A", alpha.to_vec());
        }
        layers.channel("depth.Z", self.depth.clone());
        layers.channel(COVERAGE, self.coverage.clone());
        let freedom = i32::try_from(self.degrees_of_freedom).unwrap_or(i32::MAX);
        layers.attribute(FREEDOM, ExrAttribute::Integer(freedom));
        layers.into_bytes().map_err(|error| RenderError::Invalid {
            place: format!("a {width} x {height} picture as OpenEXR"),
            message: error.to_string(),
        })
    }

    /// Writes the picture as an OpenEXR file; nothing half-written ever has the final name.
    ///
    /// # Errors
    /// As [`Truth::to_exr`], and [`RenderError::Io`] if the file cannot be written.
    pub fn write_exr(&self, path: impl AsRef<Path>) -> Result<(), RenderError> {
        let path = path.as_ref();
        let bytes = self.to_exr()?;
        write_atomically(path, |file| file.write_all(&bytes)).map_err(RenderError::io(path))
    }
}

/// A traced picture from a file: what a comparison by chance needs of it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct TracedPicture {
    /// Radiance.
    pub mean: Picture,
    /// The variance of that mean.
    pub variance: Picture,
    /// The degrees of freedom of the variance; infinite ones if the file does not say.
    pub degrees_of_freedom: f64,
    /// The part of each pixel that shows a surface; empty if the file does not say.
    pub coverage: Vec<f32>,
}

/// Reads what [`Truth::write_exr`] wrote; everything is decoded once.
///
/// # Errors
/// [`RenderError::Io`] if the file cannot be read, [`RenderError::Image`] if it is no OpenEXR file, [`RenderError::Invalid`]
/// if it has no variance or a number in it is none.
pub fn read_traced_picture(path: impl AsRef<Path>) -> Result<TracedPicture, RenderError> {
    let path = path.as_ref();
    let bytes = fs::read(path).map_err(RenderError::io(path))?;
    read_traced_picture_bytes(&bytes, &path.display().to_string())
}

/// [`read_traced_picture`] from the bytes of a file, whose name stands in messages.
///
/// # Errors
/// As [`read_traced_picture`].
pub fn read_traced_picture_bytes(bytes: &[u8], name: &str) -> Result<TracedPicture, RenderError> {
    let layers = ExrLayers::from_bytes(bytes, name)?;
    let invalid = |message| RenderError::Invalid { place: name.to_owned(), message };
    let picture = |layer: &str| {
        let plane = |c: &str| layers.get(&format!("{layer}{c}"));
        let (Some(r), Some(g), Some(b)) = (plane("R"), plane("G"), plane("B")) else {
            return Err(invalid(format!(
                "expected channels {layer}R, .G and .B, found none; traced pictures as OpenEXR have them"
            )));
        };
        let pixels: Vec<Pixel> = r.iter().zip(g).zip(b).map(|((&r, &g), &b)| [r, g, b]).collect();
        let (width, height) = layers.size();
        if let Some(bad) = pixels.iter().position(|pixel| pixel.iter().any(|c| !c.is_finite())) {
            let (x, y) = (bad % width, bad / width);
            return Err(invalid(format!("expected numbers, found NaN or infinity at column {x}, row {y}")));
        }
        Ok(Picture::new(width, height, pixels)?)
    };
    let degrees_of_freedom = match layers.get_attribute(FREEDOM) {
        Some(ExrAttribute::Integer(count)) => f64::from(*count),
        _ => f64::INFINITY,
    };
    let variance = picture(&format!("{VARIANCE}."))?;
    let coverage = layers.get(COVERAGE).map(<[f32]>::to_vec).unwrap_or_default();
    Ok(TracedPicture { mean: picture("")?, variance, degrees_of_freedom, coverage })
}

#[cfg(test)]
mod tests {
    use lobe_image::{PictureReadOptions, read_picture_bytes};
    use lobe_sh::{Coefficient as _, Rgb};

    use super::*;

    #[test]
    fn what_is_written_is_read_again() {
        let numbered = |first: usize| Picture::from_fn(3, 2, |x, y| [(first + x + 3 * y) as f32; 3]);
        let truth = Truth {
            mean: numbered(0),
            variance: numbered(10),
            degrees_of_freedom: 15,
            albedo: numbered(20),
            normal: numbered(30),
            depth: vec![1.0; 6],
            coverage: vec![1.0; 6],
        };
        let bytes = truth.to_exr().unwrap();
        let traced = read_traced_picture_bytes(&bytes, "a.exr").unwrap();
        assert_eq!((&traced.variance, traced.degrees_of_freedom), (&truth.variance, 15.0), "variance");
        assert_eq!(traced.coverage, truth.coverage, "coverage");
        let (read, _) = read_picture_bytes(&bytes, "a.exr", &PictureReadOptions::default()).unwrap();
        assert_eq!(read.pixels(), truth.mean.pixels(), "radiance, as everybody reads it");
        assert_eq!(read, traced.mean, "radiance, read with its variance");
        let mut odd = truth;
        odd.variance.pixels_mut()[4][1] = f32::NAN;
        let found = read_traced_picture_bytes(&odd.to_exr().unwrap(), "a.exr").unwrap_err().to_string();
        assert_eq!(found, "a.exr: expected numbers, found NaN or infinity at column 1, row 1", "a number that is none");
    }

    #[test]
    fn pictures_without_variance_are_refused_in_one_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let map = lobe_env::EnvMap::from_fn(4, 2, |_| Rgb::splat(1.0));
        lobe_env::write_env(&path, &map, &lobe_env::PictureWriteOptions::default()).unwrap();
        let found = read_traced_picture(&path).unwrap_err().to_string();
        assert!(found.contains("a.exr: expected channels variance.R, .G and .B, found none"), "{found}");
        let found = read_traced_picture_bytes(b"no picture", "b.exr").unwrap_err().to_string();
        assert!(found.starts_with("b.exr: expected an OpenEXR picture"), "{found}");
    }
}
