//! Pictures by rays, to compare with: of the same camera, on the same grid of samples, with the surfaces of `lobe_scene`.

use lobe_image::Picture;
use lobe_prt::Lightmap;
use lobe_scene::{Bvh, Hit, Ray, Scene, SurfaceRays};
use lobe_sh::sphere::vector::{add, cross, dot, normalized, scale, sub};
use lobe_sh::{Coefficient as _, Dir, Rgb};

/// An eye, what it looks at, and half the angle of view.
#[derive(Clone, Copy)]
pub(crate) struct Eye {
    pub(crate) eye: [f64; 3],
    pub(crate) target: [f64; 3],
    pub(crate) half_angle: f64,
}

/// A point that the eye sees.
pub(crate) struct Seen<'a> {
    scene: &'a Scene,
    pub(crate) hit: Hit,
    pub(crate) view: Dir,
    pub(crate) normal: Dir,
    pub(crate) albedo: Rgb<f64>,
    pub(crate) is_front: bool,
}

/// Shades by values at the texels of a lightmap; backs are black.
pub(crate) fn by_texels<'a>(
    (scene, lightmap): (&'a Scene, &'a Lightmap),
    values: &'a [Rgb<f32>],
) -> impl Fn(&Seen<'_>) -> Rgb<f64> + Sync + 'a {
    move |seen| {
        let mut sum = Rgb::<f64>::ZERO;
        for (texel, weight) in lightmap.texels_at(scene, &seen.hit) {
            sum += values[texel].widen().scale(weight);
        }
        if seen.is_front { sum } else { Rgb::ZERO }
    }
}

impl Seen<'_> {
    /// The value between those of all vertices of the scene.
    pub(crate) fn blended<T>(&self, values: impl Fn(usize) -> T, add: impl Fn(&mut Rgb<f64>, T, f64)) -> Rgb<f64> {
        let (mesh, triangle) = self.scene.locate(self.hit.triangle as usize);
        let before: usize = self.scene.meshes()[..mesh].iter().map(|m| m.positions().len()).sum();
        let corners = self.scene.meshes()[mesh].triangles()[triangle].map(|i| before + i as usize);
        let (u, v) = (f64::from(self.hit.u), f64::from(self.hit.v));
        let mut sum = Rgb::<f64>::ZERO;
        for (corner, weight) in corners.into_iter().zip([1.0 - u - v, u, v]) {
            add(&mut sum, values(corner), weight);
        }
        sum
    }

    pub(crate) fn at_corners(&self, values: &[Rgb<f32>]) -> Rgb<f64> {
        self.blended(|corner| values[corner].widen(), |sum: &mut Rgb<f64>, value: Rgb<f64>, w| *sum += value.scale(w))
    }

    pub(crate) fn reflected(&self) -> Dir {
        let (n, v) = (self.normal.to_array(), self.view.to_array());
        Dir::from_unit(normalized(sub(scale(n, 2.0 * dot(n, v)), v)))
    }
}

/// Pixels as means over `rays * rays` rays; surfaces that are not double-sided are black from behind.
pub(crate) fn traced(
    scene: &Scene,
    eye: Eye,
    [width, height, rays]: [usize; 3],
    background: impl Fn(Dir) -> Rgb<f64> + Sync,
    shade: impl Fn(&Seen<'_>) -> Rgb<f64> + Sync,
) -> Picture {
    let bvh = Bvh::new(scene);
    let surfaces = SurfaceRays::new(scene, &bvh);
    let e = normalized(sub(eye.eye, eye.target));
    let right = normalized([-e[1], e[0], 0.0]);
    let (up, slope) = (cross(e, right), eye.half_angle.tan());
    let origin = sub(eye.eye, scene.origin()).map(|c| c as f32);
    let along = |x: f64, y: f64| {
        let half = 0.5 * height as f64;
        let (r, u) = ((x - 0.5 * width as f64) / half, (half - y) / half);
        let d = normalized(sub(add(scale(right, slope * r), scale(up, slope * u)), e));
        let Some(hit) = surfaces.closest(&Ray::new(origin, d.map(|c| c as f32))) else {
            return background(Dir::from_unit(d));
        };
        let surface = scene.surface(&hit);
        let is_front = dot(d, surface.geometric_normal.map(f64::from)) < 0.0;
        let side = if is_front { 1.0 } else { -1.0 };
        let [r, g, b, _] = surface.base_color;
        let seen = Seen {
            scene,
            hit,
            view: Dir::from_unit(scale(d, -1.0)),
            normal: Dir::from_unit(normalized(surface.shading_normal.map(|c| side * f64::from(c)))),
            albedo: Rgb::new(r, g, b).widen(),
            is_front,
        };
        if is_front || scene.material(surface.mesh).double_sided { shade(&seen) } else { Rgb::ZERO }
    };
    Picture::from_fn(width, height, |x, y| {
        let mut sum = Rgb::<f64>::ZERO;
        for k in 0..rays * rays {
            let at = |i: usize, k: usize| i as f64 + (k as f64 + 0.5) / rays as f64;
            sum += along(at(x, k % rays), at(y, k / rays));
        }
        sum.scale(1.0 / (rays * rays) as f64).to_array().map(|c| c as f32)
    })
}
