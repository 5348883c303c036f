//! Bundled environment maps: two small ones in the library, so that nothing needs to be downloaded.
//!
//! Both are from Poly Haven, CC0; `assets/README.md` of this crate gives source and facts.
//!
//! ```
//! let sunset = lobe_env::bundled::sunset();
//! let map = sunset.map();
//! assert_eq!((sunset.name, map.width(), map.height()), ("sunset", 512, 256));
//! ```

use lobe_image::{Picture, PictureReadOptions, read_picture_bytes};

use crate::error::EnvError;
use crate::map::env_map::EnvMap;

/// The prefix of a bundled map's name where a path is expected.
pub const PREFIX: &str = "bundled:";

/// An environment map inside the program.
#[derive(Clone, Copy, Debug)]
pub struct Bundled {
    /// A short name, without extension.
    pub name: &'static str,
    /// One line for a caption.
    pub title: &'static str,
    /// The OpenEXR file.
    pub bytes: &'static [u8],
}

impl Bundled {
    /// Decodes the map.
    #[must_use]
    pub fn map(&self) -> EnvMap {
        let read = read_picture_bytes(self.bytes, self.name, &PictureReadOptions::default());
        let lat_long = |picture: Picture| EnvMap::new(picture.width(), picture.height(), picture.into_pixels());
        match read.map_err(EnvError::from).and_then(|(picture, _)| lat_long(picture)) {
            Ok(map) => map,
            Err(error) => unreachable!("the test of the bundled maps reads this file: {error}"),
        }
    }
}

/// A square by the sea at sunset: a clear sky and a sun two texels wide 3° above the horizon, 36° to the right of the
/// center, its red channel up to 801.
#[must_use]
pub fn sunset() -> Bundled {
    let title = "a square by the sea, the sun on the horizon";
    Bundled { name: "sunset", title, bytes: include_bytes!("../../assets/sunset.exr") }
}

/// A dark photographer's studio with two bright lamps, the brighter one of radiance 3730.
#[must_use]
pub fn studio() -> Bundled {
    let title = "a dark photographer's studio, two bright lamps";
    Bundled { name: "studio", title, bytes: include_bytes!("../../assets/studio.exr") }
}

/// All bundled maps.
#[must_use]
pub fn all() -> [Bundled; 2] {
    [sunset(), studio()]
}

/// The bundled map of a name.
///
/// # Errors
/// [`EnvError::Options`] if there is none.
pub fn named(name: &str) -> Result<Bundled, EnvError> {
    all().into_iter().find(|map| map.name == name).ok_or_else(|| {
        let known = all().map(|map| format!("{PREFIX}{}", map.name)).join(" or ");
        EnvError::Options(format!("{PREFIX}{name}: there is no such map in the program; there is {known}"))
    })
}
