//! Limits of files, as of the command `lobe`.

use anyhow::anyhow;
use lobe::env::{EnvError, MapReadOptions};
use lobe::image::{ImageError, PictureReadOptions, ReadOption};
use lobe::prt::PrtError;
use lobe::render::RenderError;
use lobe::scene::{SceneError, SceneReadOption, SceneReadOptions};

/// Bytes of a gibibyte.
const GIB: f64 = (1_u64 << 30) as f64;

/// The limit of memory without another choice, that of pictures.
const GIB_BY_DEFAULT: f64 = PictureReadOptions::MAX_BYTES as f64 / GIB;

/// Limits of reading, with the names and the defaults of the command `lobe`.
#[derive(Clone, Copy, Debug, PartialEq, clap::Args)]
#[non_exhaustive]
pub struct ReadLimits {
    /// Refuse a scene, with its instances and the tree over its triangles, transfer, or a picture, that takes more memory than this,
    /// in GiB
    #[arg(long, value_name = "GIB", default_value_t = GIB_BY_DEFAULT, value_parser = positive)]
    pub max_memory: f64,
    /// The most triangles, and the most vertices, that a file may hold, its instances counted
    #[arg(long, value_name = "N", default_value_t = SceneReadOptions::default().max_triangles, value_parser = whole)]
    pub max_triangles: usize,
    /// The most texels that an environment, or all textures of a scene together, may have
    #[arg(long, value_name = "N", default_value_t = PictureReadOptions::default().max_texels, value_parser = whole)]
    pub max_texels: usize,
    /// Trust files: they may name buffers, materials and pictures outside of their folder
    #[arg(long)]
    pub allow_outside: bool,
}

impl Default for ReadLimits {
    /// 4 GiB for a scene, and the limits of the library.
    fn default() -> Self {
        Self {
            max_memory: GIB_BY_DEFAULT,
            max_triangles: SceneReadOptions::default().max_triangles,
            max_texels: PictureReadOptions::default().max_texels,
            allow_outside: false,
        }
    }
}

impl ReadLimits {
    /// The options of reading a scene: transfer at its vertices has no room for normal maps.
    pub(crate) fn scene(&self) -> SceneReadOptions {
        let options = SceneReadOptions::default().normal_maps(false).max_bytes((self.max_memory * GIB) as u64);
        options.max_triangles(self.max_triangles).max_texels(self.max_texels).allow_outside(self.allow_outside)
    }

    /// Refuses a file whose numbers take more memory than that, in one line.
    pub(crate) fn check_memory(&self, name: &str, bytes: u64) -> Result<(), String> {
        if bytes as f64 <= self.max_memory * GIB {
            return Ok(());
        }
        let (gib, limit) = (bytes as f64 / GIB, self.max_memory);
        Err(format!(
            "{name}: takes up to {bytes} bytes of memory ({gib:.1} GiB), more than the limit of {limit} GiB; start with a higher \
             --max-memory"
        ))
    }

    /// The options of reading an environment.
    pub(crate) fn map(&self) -> MapReadOptions {
        let mut options = MapReadOptions::default().max_texels(self.max_texels);
        options.picture.max_bytes = (self.max_memory * GIB) as u64;
        options
    }
}

/// An error of reading in one line that names the options which would let a file in by their names on the command line, or what makes it one
/// that is read.
pub(crate) fn plain(error: impl Into<anyhow::Error>) -> anyhow::Error {
    let error = error.into();
    let scene = |found: &SceneError| match found {
        SceneError::Refused { place, message, option } => Some(match option {
            SceneReadOption::MaxTriangles => {
                format!("{place}: {message}: make it smaller, or start with a higher --max-triangles")
            }
            SceneReadOption::MaxTexels => {
                format!("{place}: {message}: make the textures smaller, or start with a higher --max-texels")
            }
            _ => format!("{place}: {message}: make the scene smaller, or start with a higher --max-memory"),
        }),
        _ => None,
    };
    let image = |found: &ImageError| match found {
        ImageError::Refused { place, message, option } => Some(match option {
            ReadOption::MaxBytes => format!("{place}: {message}; make it smaller, or start with a higher --max-memory"),
            _ => format!("{place}: {message}; make it smaller, or start with a higher --max-texels"),
        }),
        _ => None,
    };
    // Crates wrap the errors of those below.
    let said = error.chain().find_map(|cause| {
        let of_scene = cause.downcast_ref::<SceneError>().and_then(scene);
        of_scene.or_else(|| cause.downcast_ref::<ImageError>().and_then(image))
    });
    let within = || match (error.downcast_ref(), error.downcast_ref(), error.downcast_ref()) {
        (Some(EnvError::Image(found)), ..) => image(found),
        (Some(EnvError::UnknownMapping { place, message }), ..) => Some(format!(
            "{place}: {message}; make a map of it first: lobe env convert PHOTO --fisheye ... -o sky.exr, or with --from or --vertical-fov"
        )),
        (_, Some(PrtError::Scene(found)), _) => scene(found),
        (.., Some(RenderError::Scene(found))) => scene(found),
        (.., Some(RenderError::Prt(PrtError::Scene(found)))) => scene(found),
        _ => None,
    };
    match said.or_else(within) {
        Some(said) => anyhow!(said),
        None => error,
    }
}

fn positive(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|x| x.is_finite() && *x > 0.0);
    number.ok_or_else(|| format!("expected a number above 0, found '{text}'"))
}

fn whole(text: &str) -> Result<usize, String> {
    let most = usize::MAX >> 3;
    let number = text.parse::<usize>().ok().filter(|n| (1..=most).contains(n));
    number.ok_or_else(|| format!("expected a whole number from 1 to {most}, found '{text}'"))
}
