//! Ray casting: pictures of a scene of triangles, shaded by a function of the hit.

use derive_setters::Setters;
use lobe_image::Picture;
use lobe_io::Job;
use lobe_scene::{Bvh, Material, Ray, Scene, SurfaceRays};
use lobe_sh::{Coefficient as _, Dir, Rgb};
use web_time::Instant;

use crate::progressive::{in_portions, progress_of};
use crate::{Camera, RenderError};

/// The size and the sampling of a picture of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Setters)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[non_exhaustive]
pub struct ViewOptions {
    /// Columns, at least 1.
    pub width: usize,
    /// Rows, at least 1.
    pub height: usize,
    /// Rays per pixel and axis, at least 1, on a regular grid.
    pub rays: usize,
}

impl Default for ViewOptions {
    /// A picture of 512 × 384 pixels with 2 × 2 rays each.
    fn default() -> Self {
        Self { width: 512, height: 384, rays: 2 }
    }
}

impl ViewOptions {
    /// The most bytes that a picture takes until it is written: its numbers twice as they are, compressed in blocks and as a
    /// file, and some room (test `work_takes_no_more_memory_than_is_said` of `lobe-cli`).
    #[must_use]
    pub fn bytes(&self) -> u64 {
        (5 * size_of::<[f32; 3]>() as u64).saturating_mul(self.width as u64).saturating_mul(self.height as u64)
    }
}

/// A scene seen by a camera in its world: `radiance` of the hit where a ray from the eye hits, `background` of its
/// direction where it escapes.
///
/// The steps of `job` are pixels; it cannot be kept in a file.
///
/// Pixels are means over their square. Surfaces that are not double-sided are black from behind, as they are baked and
/// traced, and `radiance` is not asked. Of those that are, it is asked for both sides: [`SceneHit::is_front`] says for
/// which. The same bits for any number of threads.
///
/// # Errors
/// [`RenderError::Options`] if the picture has no pixels, a pixel no ray, or the job a file, [`RenderError::Cancelled`]
/// if the watch of the job said to stop.
pub fn scene_picture(
    scene: &Scene,
    bvh: &Bvh,
    camera: &Camera,
    options: &ViewOptions,
    background: impl Fn(Dir) -> Rgb<f64> + Sync,
    radiance: impl Fn(&SceneHit<'_>) -> Rgb<f64> + Sync,
    job: Job<'_>,
) -> Result<Picture, RenderError> {
    ray_cast(scene, bvh, camera, options, &background, &radiance, job)
}

/// [`scene_picture`] by references: compiled once, not for every shading.
pub(crate) fn ray_cast(
    scene: &Scene,
    bvh: &Bvh,
    camera: &Camera,
    options: &ViewOptions,
    background: &(dyn Fn(Dir) -> Rgb<f64> + Sync),
    radiance: &(dyn Fn(&SceneHit<'_>) -> Rgb<f64> + Sync),
    mut job: Job<'_>,
) -> Result<Picture, RenderError> {
    job.expect_no_checkpoint().map_err(RenderError::Options)?;
    let ViewOptions { width, height, rays } = *options;
    let pixels = width.checked_mul(height).filter(|&pixels| pixels > 0 && rays > 0);
    let Some(pixels) = pixels else {
        return Err(RenderError::Options(format!(
            "expected a picture with pixels and rays, found {width} x {height} with {rays} rays along an axis"
        )));
    };
    let camera = camera.relative_to(scene.origin()).outside_of(bvh.bounds());
    let surfaces = SurfaceRays::new(scene, bvh);
    // Shade the nearest hit along a ray, or the background.
    let radiance_along = |ray: &Ray, towards: Dir| {
        let (hit, tint) = surfaces.closest_through(ray);
        let tint = Rgb::from(tint).widen();
        let Some(hit) = hit else { return background(towards) * tint };
        let hit = SceneHit::new(scene, hit, towards);
        if hit.is_lit { radiance(&hit) * tint } else { Rgb::ZERO }
    };
    // Average the rays of a pixel.
    let pixel = |i: usize| {
        let (x, y) = ((i % width) as f64, (i / width) as f64);
        let mut sum = Rgb::<f64>::ZERO;
        for k in 0..rays * rays {
            let offset = |i: usize| (i as f64 + 0.5) / rays as f64;
            let (ray, towards) = camera.ray_of_pixel([width, height], [x + offset(k % rays), y + offset(k / rays)]);
            sum += radiance_along(&ray, towards);
        }
        Rgb::<f32>::narrow(sum.scale(((rays * rays) as f64).recip()))
    };
    // Compute the pixels in portions, between which the job may stop.
    let begin = Instant::now();
    let all = in_portions(Vec::new(), pixels, &pixel, &mut |done| {
        let is_stopped = job.report(&progress_of(done.len(), pixels, 0, begin)).is_break() && done.len() < pixels;
        if is_stopped { Err(RenderError::Cancelled) } else { Ok(()) }
    })?;
    Ok(Picture::new(width, height, all)?)
}

/// A point of a surface that the eye sees.
pub struct SceneHit<'a> {
    scene: &'a Scene,
    hit: lobe_scene::Hit,
    /// Towards the eye.
    pub view: Dir,
    /// The unit normal to shade with, tilted by a normal map if there is one, on the side that is seen.
    pub normal: Dir,
    /// Base color.
    pub albedo: Rgb<f64>,
    /// False for the back of a surface that is not double-sided.
    is_lit: bool,
    /// Whether the side with counter-clockwise corners is seen; if not, what [`lobe_prt::Receivers::at_vertices`] found
    /// is that of the other side, and this one needs [`lobe_prt::Receivers::backs`].
    pub is_front: bool,
}

impl<'a> SceneHit<'a> {
    fn new(scene: &'a Scene, hit: lobe_scene::Hit, towards: Dir) -> Self {
        let surface = scene.surface(&hit);
        let geometric = surface.geometric_normal.map(f64::from);
        let is_front = lobe_sh::vector::dot(towards.to_array(), geometric) < 0.0;
        let side = if is_front { 1.0 } else { -1.0 };
        let shading = lobe_sh::vector::normalized(surface.shading_normal.map(|c| side * f64::from(c)));
        let [r, g, b, _] = surface.base_color;
        Self {
            scene,
            hit,
            view: -towards,
            normal: Dir::from_unit(shading),
            albedo: Rgb::new(r, g, b).widen(),
            is_lit: is_front || scene.material(surface.mesh).double_sided,
            is_front,
        }
    }

    /// The point that the ray hits.
    #[must_use]
    pub fn hit(&self) -> &lobe_scene::Hit {
        &self.hit
    }

    /// The material of the surface.
    #[must_use]
    pub fn material(&self) -> &'a Material {
        let (mesh, _) = self.scene.locate(self.hit.triangle as usize);
        self.scene.material(mesh)
    }

    /// The three corners, each by its number among all vertices of the scene, and how near they are: their weights sum
    /// to 1.
    #[must_use]
    pub fn corners(&self) -> [(usize, f64); 3] {
        let (mesh, triangle) = self.scene.locate(self.hit.triangle as usize);
        let before = self.scene.first_vertex(mesh);
        let [a, b, c] = self.scene.meshes()[mesh].triangles()[triangle].map(|i| before + i as usize);
        let (u, v) = (f64::from(self.hit.u), f64::from(self.hit.v));
        [(a, 1.0 - u - v), (b, u), (c, v)]
    }

    /// The values of the corners, interpolated; the caller chooses those of the side that is hit.
    ///
    /// # Panics
    /// If `values` has none for a corner.
    #[must_use]
    pub fn at_corners(&self, values: &[Rgb<f32>]) -> Rgb<f64> {
        let mut sum = Rgb::<f64>::ZERO;
        for (corner, weight) in self.corners() {
            sum += values[corner].widen().scale(weight);
        }
        sum
    }

    /// The direction from which a mirror would show the eye its light, `2 (n·v) n - v`.
    #[must_use]
    pub fn reflected(&self) -> Dir {
        let (n, v) = (self.normal.to_array(), self.view.to_array());
        let twice = 2.0 * self.normal.dot(self.view);
        let r = lobe_sh::vector::normalized(std::array::from_fn(|k| twice * n[k] - v[k]));
        Dir::from_unit(r)
    }
}
