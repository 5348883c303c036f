//! Pictures of what the window shows, as files.

use std::env;
use std::path::{Path, PathBuf};

use eframe::egui::ColorImage;
use lobe::image::{ImageError, Picture, Tone, srgb_decode};
use lobe::io::Job;
use lobe_gpu::{
    Context, GlossyMesh, GpuCamera, GpuError, SceneView, SceneViewOptions, Storage, SurfaceShading, TurningLight,
    TurntableOptions,
};
use serde::{Deserialize, Serialize};

use crate::loading::backdrop::{Behind, write_frames};
use crate::loading::bake::{GlossyBake, SceneData};
use crate::loading::materials::Materials;
use crate::loading::places::Places;
use crate::loading::sky_source::OpenedSky;
use crate::loading::suns::ShownSuns;

/// The largest side of a picture, in pixels, and the most pictures of a turntable: what fits into a few gigabytes.
pub(crate) const MOST_PIXELS: u32 = 4096;
pub(crate) const MOST_FRAMES: usize = 360;

/// Samples of a pixel along each axis, at most.
pub(crate) const MOST_RAYS: u32 = 4;

/// Files of one name in a folder, of which the first number that is free is taken.
const MOST_FILES: usize = 10_000;

/// What is exported, and where to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
#[non_exhaustive]
pub struct ExportPlan {
    /// The folder of the files.
    pub folder: PathBuf,
    /// Columns and rows of pictures of the scene.
    pub size: [u32; 2],
    /// Samples of a pixel along each axis.
    pub rays: u32,
    /// Pictures of a turntable, in which the sky turns once around.
    pub frames: usize,
}

impl Default for ExportPlan {
    fn default() -> Self {
        Self { folder: pictures_folder(), size: [1280, 720], rays: 2, frames: 48 }
    }
}

impl ExportPlan {
    /// Brings its numbers into their ranges.
    pub(crate) fn check(&mut self) {
        self.size = self.size.map(|side| side.clamp(1, MOST_PIXELS));
        self.rays = self.rays.clamp(1, MOST_RAYS);
        self.frames = self.frames.clamp(2, MOST_FRAMES);
    }
}

/// The folder of the user's pictures: `$XDG_PICTURES_DIR`, or `Pictures` in the home folder if it is there, or that of the program.
fn pictures_folder() -> PathBuf {
    let set = |name: &str| env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let of_home = || set("HOME").or_else(|| set("USERPROFILE")).map(|home| home.join("Pictures"));
    let found = set("XDG_PICTURES_DIR").or_else(of_home).filter(|folder| folder.is_dir());
    found.or_else(|| env::current_dir().ok()).unwrap_or_default()
}

/// The first of `folder/stem-0001.png`, `folder/stem-0002.png`, .. that is not there yet.
///
/// # Errors
/// One line if the folder is none, or all numbers are taken.
pub(crate) fn next_free(folder: &Path, stem: &str) -> Result<PathBuf, String> {
    if !folder.is_dir() {
        return Err(format!("{}: no such folder; choose another in Export", folder.display()));
    }
    let numbered = |number: usize| folder.join(format!("{stem}-{number:04}.png"));
    let free = (1..MOST_FILES).map(numbered).find(|path| !path.exists());
    free.ok_or_else(|| format!("{}: {stem} has all its numbers; choose another folder in Export", folder.display()))
}

/// Writes the picture of a window as PNG.
///
/// # Errors
/// As [`Picture::write_png`].
pub(crate) fn write_window(path: &Path, image: &ColorImage) -> Result<(), ImageError> {
    let [width, height] = image.size;
    let light = |byte: u8| srgb_decode(f64::from(byte) / 255.0) as f32;
    let pixel = |x: usize, y: usize| {
        let color = image.pixels[y * width + x];
        [color.r(), color.g(), color.b()].map(light)
    };
    Picture::from_fn(width, height, pixel).write_png(path, &Tone::PLAIN)
}

/// A scene as the window shows it, to be rendered to a file.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct SceneExport {
    pub(crate) data: SceneData,
    /// Without one, the scene is lit by its normals, to this order.
    pub(crate) transfer: Option<std::sync::Arc<lobe::prt::Transfer>>,
    /// What that is of.
    pub(crate) places: Places,
    pub(crate) order: usize,
    pub(crate) glossy: Vec<GlossyBake>,
    pub(crate) materials: Option<Materials>,
    /// Of the sky in reflections.
    pub(crate) strength: f64,
    pub(crate) suns: ShownSuns,
    pub(crate) sky: Option<OpenedSky>,
    pub(crate) behind: Behind,
    pub(crate) light: TurningLight,
    pub(crate) camera: GpuCamera,
    pub(crate) tone: Tone,
}

impl SceneExport {
    /// Writes one picture, or of several frames an animation in which the sky turns once around, as `lobe-viewer --headless` does. The
    /// size, the samples and the number of frames are those of the plan; `path` ends on `.png`, `.exr` or `.hdr`.
    ///
    /// # Errors
    /// As [`lobe_gpu::write_turntable`].
    pub fn write(
        &self,
        context: &Context,
        plan: &ExportPlan,
        frames: usize,
        path: &Path,
        job: Job<'_>,
    ) -> Result<(), GpuError> {
        let meshes: Vec<GlossyMesh<'_>> = self.glossy.iter().map(GlossyBake::on_device).collect();
        let shading = match &self.transfer {
            Some(transfer) => {
                let materials = self.materials.as_ref();
                let gltf = materials.and_then(|all| all.shading(transfer, &self.places, Storage::F32));
                gltf.unwrap_or_else(|| self.places.shading(transfer, &meshes, Storage::F32))
            }
            None => SurfaceShading::Irradiance(self.order),
        };
        let [width, height] = plan.size;
        let options = SceneViewOptions::default().width(width).height(height).rays(plan.rays);
        let environment = self.behind.on_device(context, self.sky.as_ref().map(|sky| &*sky.shown));
        let shading = (&shading, self.suns.apart());
        let mut view = SceneView::with_suns(context, &self.data.scene, shading, environment.as_ref(), &options)?;
        view.set_reflection_strength(self.strength);
        view.set_camera(&self.camera)?;
        let alpha = self.behind.alpha(context, &self.data.scene, &options, &self.camera)?;
        let step = std::f64::consts::TAU / frames.max(1) as f64;
        let options = TurntableOptions::default().frames(frames).step(step).tone(self.tone);
        write_frames((&view, alpha.as_ref()), self.light.clone(), &options, path, job)
    }
}
