//! Ray casting: pictures of a scene of triangles, shaded by a function of the hit.

use derive_setters::Setters;
use lobe_image::Picture;
use lobe_io::Job;
use lobe_scene::{Bvh, Finish, Scene, SurfaceRays};
use lobe_sh::{Coefficient as _, Dir, Rgb};
use web_time::Instant;

use crate::camera::camera::Camera;
use crate::error::RenderError;
use crate::progressive::{in_portions, progress_of};
use crate::scene_view::silhouettes::{Again, Met, Sampled, place_in_pixel, silhouettes};
use crate::scene_view::sun_rays::SurfacePoint;

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
    /// Rays of a pixel in which a surface ends, or between which and the next one it does: the next power of two,
    /// spread so that each is alone in its column and in its row of the pixel. Up to the square of `rays`, such as 0,
    /// no pixel takes more than others.
    pub edge_rays: usize,
}

impl Default for ViewOptions {
    /// A picture of 512 × 384 pixels with 2 × 2 rays each, 16 where surfaces end.
    fn default() -> Self {
        Self { width: 512, height: 384, rays: 2, edge_rays: 16 }
    }
}

impl ViewOptions {
    /// The most bytes that a picture takes until it is written: its numbers twice as they are, compressed in blocks and as a
    /// file, and some room (test `work_takes_no_more_memory_than_is_said` of `lobe-cli`). What is known of its surfaces
    /// is forgotten before that, and takes less.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        (5 * size_of::<[f32; 4]>() as u64).saturating_mul(self.width as u64).saturating_mul(self.height as u64)
    }
}

/// A scene seen by a camera in its world: `radiance` of the hit where a ray from the eye hits, `background` of its
/// direction where it escapes.
///
/// The steps of `job` are pixels; it cannot be kept in a file.
///
/// Pixels are means over their square, by [`ViewOptions::rays`]; those in which surfaces end are looked at again, by
/// [`ViewOptions::edge_rays`]. A surface ends where a ray meets another mesh or another side than its neighbor, or
/// none, or where the surface has a crease of more than 12° or a step. What lies within it is left to the shading.
///
/// Surfaces that are not double-sided are black from behind, as they are baked and traced, and `radiance` is not asked.
/// A ray that passes an edge of an open body, through a gap such as that around an eye in its socket, meets the inside
/// of its skin: a gap no wider than two pixels, 40 % of the rays of five by five, takes the light of what is around it.
/// Of surfaces that are double-sided, `radiance` is asked for both sides: [`SceneHit::is_front`] says for which. The
/// same bits for any number of threads.
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
    Ok(ray_cast(scene, bvh, camera, options, &background, &radiance, job)?.0)
}

/// [`scene_picture`] by references, compiled once, not for every shading; and the coverage of each pixel, the part of
/// its rays that stop at surfaces.
pub(crate) fn ray_cast(
    scene: &Scene,
    bvh: &Bvh,
    camera: &Camera,
    options: &ViewOptions,
    background: &(dyn Fn(Dir) -> Rgb<f64> + Sync),
    radiance: &(dyn Fn(&SceneHit<'_>) -> Rgb<f64> + Sync),
    mut job: Job<'_>,
) -> Result<(Picture, Vec<f32>), RenderError> {
    job.expect_no_checkpoint().map_err(RenderError::Options)?;
    let ViewOptions { width, height, rays, edge_rays } = *options;
    let count = width.checked_mul(height).filter(|&pixels| pixels > 0 && rays > 0);
    let Some(count) = count else {
        return Err(RenderError::Options(format!(
            "expected a picture with pixels and rays, found {width} x {height} with {rays} rays along an axis"
        )));
    };
    let camera = camera.relative_to(scene.origin()).outside_of(bvh.bounds());
    let cast = Cast { surfaces: SurfaceRays::new(scene, bvh), camera, size: [width, height], background, radiance };
    let looks_again = edge_rays > rays.saturating_mul(rays);
    // Pixels of the second look are about a tenth, of four times as many rays.
    let first_part = if looks_again { count - count / 4 } else { count };
    let begin = Instant::now();
    let mut watch = |done: usize| {
        let is_stopped = job.report(&progress_of(done, count, 0, begin)).is_break() && done < count;
        if is_stopped { Err(RenderError::Cancelled) } else { Ok(()) }
    };
    // Average the rays of each pixel, in portions between which the job may stop.
    let places = |k: usize| [k % rays, k / rays].map(|k| (k as f64 + 0.5) / rays as f64);
    let pixel = |i: usize| cast.sampled(i, rays * rays, &places);
    let share = |done: usize, of: usize, part: usize| (done as u128 * part as u128 / of.max(1) as u128) as usize;
    let first = in_portions(Vec::new(), count, &pixel, &mut |done| watch(share(done.len(), count, first_part)))?;
    // Look again where surfaces end.
    let again = if looks_again { silhouettes(&first, width) } else { Vec::new() };
    let mut lights: Vec<Rgb<f32>> = first.iter().map(|pixel| pixel.light).collect();
    let mut coverage: Vec<f32> = first.iter().map(|pixel| pixel.coverage).collect();
    drop(first);
    let edge_rays = edge_rays.checked_next_power_of_two().unwrap_or(edge_rays);
    let pixel = |k: usize| cast.again(&again[k], edge_rays);
    let rest = count - first_part;
    let second = in_portions(Vec::new(), again.len(), &pixel, &mut |done| {
        watch(if again.len() == done.len() { count } else { first_part + share(done.len(), again.len(), rest) })
    })?;
    for (at, pixel) in again.iter().zip(second) {
        (lights[at.pixel], coverage[at.pixel]) = pixel;
    }
    Ok((Picture::new(width, height, lights)?, coverage))
}

/// Rays from an eye into a scene.
struct Cast<'a> {
    surfaces: SurfaceRays<'a>,
    camera: Camera,
    size: [usize; 2],
    background: &'a (dyn Fn(Dir) -> Rgb<f64> + Sync),
    radiance: &'a (dyn Fn(&SceneHit<'_>) -> Rgb<f64> + Sync),
}

/// What a ray brings to the eye.
struct Seen {
    light: Rgb<f64>,
    is_back: bool,
    met: Met,
}

impl Seen {
    /// 1 if the ray meets a surface, else 0.
    fn hits(&self) -> usize {
        usize::from(self.met != Met::NOTHING)
    }
}

impl Cast<'_> {
    /// Shades the nearest hit of the ray through a place of a pixel, or the background.
    fn along(&self, pixel: usize, place: [f64; 2]) -> Seen {
        let (x, y) = ((pixel % self.size[0]) as f64, (pixel / self.size[0]) as f64);
        let (ray, towards) = self.camera.ray_of_pixel(self.size, [x + place[0], y + place[1]]);
        let (hit, tint) = self.surfaces.closest_through(&ray);
        let tint = Rgb::from(tint).widen();
        let Some(hit) = hit else {
            return Seen { light: (self.background)(towards) * tint, is_back: false, met: Met::NOTHING };
        };
        let hit = SceneHit::new(self.surfaces.scene(), hit, towards);
        let light = if hit.is_lit { (self.radiance)(&hit) * tint } else { Rgb::ZERO };
        Seen { light, is_back: !hit.is_lit, met: hit.met }
    }

    /// A pixel by `count` rays through these places.
    fn sampled(&self, pixel: usize, count: usize, place: &dyn Fn(usize) -> [f64; 2]) -> Sampled {
        let first = self.along(pixel, place(0));
        let (met, mut is_edge) = (first.met, false);
        let (mut light, mut hits, mut backs) = (first.light, first.hits(), usize::from(first.is_back));
        for k in 1..count {
            let seen = self.along(pixel, place(k));
            light += seen.light;
            hits += seen.hits();
            backs += usize::from(seen.is_back);
            is_edge |= seen.met.is_apart(&met);
        }
        let part = (count as f64).recip();
        let light = Rgb::<f32>::narrow(light.scale(part));
        let [coverage, backs] = [hits, backs].map(|rays| (rays as f64 * part) as f32);
        Sampled { light, coverage, backs, met, is_edge }
    }

    /// The light and the coverage of a pixel in which a surface ends; of a gap, those of what is around it.
    fn again(&self, at: &Again, count: usize) -> (Rgb<f32>, f32) {
        let (mut light, mut hits, mut rays) = (Rgb::<f64>::ZERO, 0, 0);
        for k in 0..count {
            let seen = self.along(at.pixel, place_in_pixel(k, count));
            if seen.is_back && at.gap.is_some() {
                continue;
            }
            light += seen.light;
            hits += seen.hits();
            rays += 1;
        }
        let part = f64::from(rays).recip();
        match at.gap {
            Some(around) if rays == 0 => (around, 1.0),
            _ => (Rgb::narrow(light.scale(part)), (hits as f64 * part) as f32),
        }
    }
}

/// A point of a surface that the eye sees.
pub struct SceneHit<'a> {
    scene: &'a Scene,
    hit: lobe_scene::Hit,
    /// By which it is told apart from what other rays meet.
    met: Met,
    /// Towards the eye.
    pub view: Dir,
    /// The unit normal to shade with, tilted by a normal map if there is one, on the side that is seen.
    pub normal: Dir,
    /// Base color.
    pub albedo: Rgb<f64>,
    /// The normal of the vertices, without a normal map, on the side that is seen.
    vertex_normal: Dir,
    /// The same point for the light that falls on it.
    pub(crate) lit_at: SurfacePoint,
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
        let is_front = lobe_sh::sphere::vector::dot(towards.to_array(), geometric) < 0.0;
        let side = if is_front { 1.0 } else { -1.0 };
        let turned = |n: [f32; 3]| lobe_sh::sphere::vector::normalized(n.map(|c| side * f64::from(c)));
        let [r, g, b, _] = surface.base_color;
        let normal = Dir::from_unit(turned(surface.shading_normal));
        Self {
            scene,
            hit,
            lit_at: SurfacePoint { position: surface.position, plane: geometric.map(|c| side * c), normal },
            met: Met::new(surface.mesh, is_front, surface.position, surface.vertex_normal),
            view: -towards,
            normal,
            vertex_normal: Dir::from_unit(turned(surface.vertex_normal)),
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

    /// The finish of the surface.
    #[must_use]
    pub fn finish(&self) -> Finish {
        self.scene.finish(&self.hit)
    }

    /// The normal of the vertices, without a normal map, on the side that is seen.
    #[must_use]
    pub fn vertex_normal(&self) -> Dir {
        self.vertex_normal
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
        let r = lobe_sh::sphere::vector::normalized(std::array::from_fn(|k| twice * n[k] - v[k]));
        Dir::from_unit(r)
    }
}
