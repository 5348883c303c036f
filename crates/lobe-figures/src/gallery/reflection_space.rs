//! Reflection-space image-based rendering: any isotropic BRDF, from maps prefiltered for a few views.

use std::f64::consts::FRAC_PI_2;

use lobe_env::{Brdf, CubeMap, cube};
use lobe_io::parallel;
use lobe_sh::{Coefficient, Dir, Rgb};

use crate::gallery::exhibit::{Shading, SurfacePoint};
use crate::gallery::icosphere::Icosphere;
use crate::gallery::square_texture::SquareTexture;
use lobe_render::View;
use lobe_sh::sphere::vector::{Vec3, add, dot, normalized, scale, sub, tangents_along_z};

/// The least cosine between normal and view in a map: at 0 a reflectance function has no value.
const LEAST_COSINE: f64 = 0.01;

/// Nodes of the table of directional albedo: that of GGX is straight enough between cosines 1/128 apart.
const ALBEDO_NODES: usize = 129;

/// Reflection-space image-based rendering: the light that a surface sends to a few views, blended for all others.
///
/// For each of the vertices `v_k` of a subdivided icosahedron a map holds what a ball of the material sends to a far
/// eye at `v_k`, the reflectance function with all its dependence on the view integrated:
///
/// ```text
///   M_k(n) = ∫ f(v_k, l) L(l) max(n·l, 0) dl        at θ/90° (cos ψ, sin ψ) of the unit disc
/// ```
///
/// with `θ` the angle from `v_k` to `n` and `ψ` its azimuth in the picture of that eye: the angular map of what the
/// ball mirrors. (The picture of the ball itself, `sin θ` in place of `θ/90°`, has no room at its rim, where the
/// reflectance rises most.)
///
/// A view `v` lies in one triangle of vertices; their maps are warped to it and mixed:
///
/// ```text
///   r = 2 (n·v) n - v        n_k = (r + v_k)/|r + v_k|        L ≈ Σ w_k M_k(n_k)
/// ```
///
/// `n_k` is the normal that mirrors the view `v_k` into the same direction `r`: the warp keeps what is mirrored in its
/// place, so that a glossy reflection does not show double, and gives up the angle to the normal, which the blend
/// mends. The `w_k` are spherical barycentric weights. Where `v = v_k` nothing is approximated but the map's
/// resolution.
///
/// A point costs three lookups, whatever the reflectance function. After
/// [Cabral, Olano and Nemec 1999]; the closed form of the warp is ours.
///
/// The largest error of the blend is the rise of the reflectance towards grazing angles.
/// [`ReflectionSpace::normalized`] takes it out of the maps and puts it back where the surface is seen, by the
/// directional albedo `R_A`:
///
/// ```text
///   L ≈ R_A(n·v) Σ w_k M_k(n_k)/R_A(n_k·v_k)
/// ```
///
/// It is not part of their method, costs no more lookups, and makes uniform light exact. Errors of both against
/// brute force: test `more_views_bring_the_blend_towards_brute_force`.
#[derive(Clone, Debug)]
pub struct ReflectionSpace {
    sphere: Icosphere,
    maps: Vec<ViewMap>,
    /// `R_A` at cosines `i/(len - 1)`.
    albedo: Vec<f64>,
    normalized: bool,
}

/// The map of one view: the radiance that a ball sends to a far eye.
#[derive(Clone, Debug)]
struct ViewMap {
    view: View,
    towards: Dir,
    texture: SquareTexture,
}

impl ReflectionSpace {
    /// Prefilters the light for 12, 42, 162, .. views (0, 1, 2, .. `subdivisions`), each a map of `size` x `size`
    /// texels.
    ///
    /// Every texel of `source` counts as one light, so its texels must be small against the lobe: 16 x 16 texels a
    /// face, 6° each, for GGX of `α >= 0.3`; reduce a larger map first ([`CubeMipChain::averaged`]). The work is
    /// `views · ¾ size² · 6 source²` evaluations of the reflectance function, in parallel.
    ///
    /// # Panics
    /// If `size` is 0.
    ///
    /// [`CubeMipChain::averaged`]: lobe_env::CubeMipChain::averaged
    #[must_use]
    pub fn new(source: &CubeMap, brdf: &(impl Brdf + Sync), subdivisions: usize, size: usize) -> Self {
        // Place the views at the vertices of the icosphere, and take the texels as lights.
        let (sphere, lights) = (Icosphere::new(subdivisions), TexelLights::new(source));
        let map = |towards: &Dir| {
            // Integrate the BRDF over all lights for each texel of the map of a view.
            let view = View::from_eye(*towards);
            let texel = |x: f64, y: f64| {
                let radius = x.hypot(y);
                // Texels at the rim and beyond show the rim, where a reflectance function still has a value.
                let (sin, cos) = (FRAC_PI_2 * radius).min(LEAST_COSINE.acos()).sin_cos();
                let aside = if radius > 0.0 { sin / radius } else { 0.0 };
                let normal = Dir::from_unit(view.point([aside * x, aside * y, cos]));
                Rgb::narrow(lights.reflected(brdf, normal, *towards))
            };
            ViewMap { view, towards: *towards, texture: SquareTexture::from_fn(size, &texel) }
        };
        let maps = sphere.vertices.iter().map(map).collect();
        let albedo = tabulated(&|cos| brdf.directional_albedo(cos));
        Self { sphere, maps, albedo, normalized: false }
    }

    /// The same maps, mixed as multiples of the directional albedo.
    #[must_use]
    pub fn normalized(self) -> Self {
        Self { normalized: true, ..self }
    }

    /// `R_A`, linear between the nodes; not below a part in a million, so that one can divide by it.
    fn albedo(&self, cos: f64) -> f64 {
        let place = cos.clamp(0.0, 1.0) * (ALBEDO_NODES - 1) as f64;
        let low = (place as usize).min(ALBEDO_NODES - 2);
        let t = place - low as f64;
        ((1.0 - t) * self.albedo[low] + t * self.albedo[low + 1]).max(1e-6)
    }

    /// The number of views.
    #[must_use]
    pub fn views(&self) -> usize {
        self.maps.len()
    }
}

/// The directional albedo at the nodes of its table.
fn tabulated(albedo: &(dyn Fn(f64) -> f64 + Sync)) -> Vec<f64> {
    parallel::map(ALBEDO_NODES, &|i| albedo(i as f64 / (ALBEDO_NODES - 1) as f64))
}

impl Shading for ReflectionSpace {
    fn radiance(&self, at: &SurfacePoint) -> Rgb<f32> {
        // Find the triangle of views around the direction to the eye, and its barycentric weights.
        let r = at.reflected();
        let (views, weights) = self.sphere.locate(at.view);
        // Look the mirrored direction up in the map of each corner, and mix.
        let mut sum = Rgb::<f64>::ZERO;
        for (k, weight) in views.into_iter().zip(weights) {
            let (radiance, cos) = self.maps[k].lookup(r);
            let factor = if self.normalized { weight / self.albedo(cos) } else { weight };
            sum += radiance.widen().scale(factor);
        }
        // Put the directional albedo back, if the maps are taken relative to it.
        Rgb::narrow(if self.normalized { sum.scale(self.albedo(at.cos_view())) } else { sum })
    }
}

impl ViewMap {
    /// The light of the point of the ball that mirrors the view into the direction `r`; for the one direction behind
    /// the ball, any point of the rim. With it comes the cosine `n_k·v_k`.
    fn lookup(&self, r: Dir) -> (Rgb<f32>, f64) {
        let halfway = normalized(add(r.to_array(), self.towards.to_array()));
        let [right, up, cos] = self.view.project(halfway);
        let sin = right.hypot(up);
        let spread = if sin > 0.0 { sin.atan2(cos) / (FRAC_PI_2 * sin) } else { 0.0 };
        (self.texture.lookup(spread * right, spread * up), cos.max(LEAST_COSINE))
    }
}

/// The reference that [`ReflectionSpace`] approximates: the reflection integral at each point, by brute force.
#[derive(Clone, Debug)]
pub struct BruteForceReflection<B> {
    lights: TexelLights,
    brdf: B,
}

impl<B: Brdf> BruteForceReflection<B> {
    /// The surface of this reflectance function under the texels of `source`, each counted as one light.
    #[must_use]
    pub fn new(source: &CubeMap, brdf: B) -> Self {
        Self { lights: TexelLights::new(source), brdf }
    }
}

impl<B: Brdf + Sync> Shading for BruteForceReflection<B> {
    fn radiance(&self, at: &SurfacePoint) -> Rgb<f32> {
        Rgb::narrow(self.lights.reflected(&self.brdf, at.normal, at.view))
    }
}

/// The texels of a map as lights: the direction of each, and its radiance times its solid angle.
#[derive(Clone, Debug)]
struct TexelLights(Vec<(Vec3, Rgb<f64>)>);

impl TexelLights {
    fn new(source: &CubeMap) -> Self {
        let size = source.size();
        let light = |i: usize| {
            let (face, x, y) = (i / (size * size), i % size, i / size % size);
            let power = source.texel(face, x, y).widen().scale(cube::solid_angle(size, x, y));
            (source.dir(face, x, y).to_array(), power)
        };
        Self(parallel::map(cube::FACES * size * size, &light))
    }

    /// `Σ f(v, l) L max(n·l, 0) dl`, in the frame where `n` is +z and `v` lies over +x.
    fn reflected(&self, brdf: &impl Brdf, normal: Dir, view: Dir) -> Rgb<f64> {
        // Set up the frame in which `n` is +z and `v` lies over +x.
        let n = normal.to_array();
        let cos = normal.dot(view);
        let across = sub(view.to_array(), scale(n, cos));
        let sin = dot(across, across).sqrt();
        // Seen along the normal any frame will do.
        let x = if sin > 1e-9 { scale(across, 1.0 / sin) } else { tangents_along_z(n)[0] };
        let y = lobe_sh::sphere::vector::cross(n, x);
        let Some(v) = Dir::new([sin, 0.0, cos]) else { return Rgb::ZERO };
        // Add the lights above the horizon.
        let mut sum = Rgb::ZERO;
        for (l, power) in &self.0 {
            let height = dot(*l, n);
            if height > 0.0 {
                let local = Dir::from_unit([dot(*l, x), dot(*l, y), height]);
                sum += power.scale(brdf.eval(v, local) * height);
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use lobe_env::{Ggx, Lambert};

    use super::*;
    use crate::gallery::exhibit::{Exhibit, compare_shadings};
    use crate::gallery::solid::ExhibitSolid;
    use crate::gallery::torus::Torus;
    use lobe_render::Camera;

    /// A sky, a ground and a broad warm light to the upper right of the eye at -x.
    fn source() -> CubeMap {
        let lamp = Dir::new([-0.6, -0.7, 0.5]).unwrap();
        CubeMap::from_fn(16, |s| {
            let sky = 0.5 + 0.4 * s.z();
            let glow = 8.0 * (12.0 * (s.dot(lamp) - 1.0)).exp();
            Rgb::new((0.8 * sky + glow) as f32, (sky + 0.8 * glow) as f32, (1.3 * sky + 0.5 * glow) as f32)
        })
    }

    fn points(eye: Dir) -> Vec<SurfacePoint> {
        let camera = Camera::orthographic(View::from_eye(eye), 1.1);
        let torus = Torus { axis: eye, major: 0.7, minor: 0.3 };
        [ExhibitSolid::Ball { radius: 1.0 }, ExhibitSolid::Torus(torus)]
            .iter()
            .flat_map(|solid| Exhibit { solid: *solid, camera, samples: 1 }.points(20, 20))
            .collect()
    }

    #[test]
    fn more_views_bring_the_blend_towards_brute_force() {
        let (source, brdf) = (source(), Ggx { alpha: 0.3, f0: 0.04 });
        let truth = BruteForceReflection::new(&source, brdf);
        // The middle of a triangle of the icosahedron is farthest from its vertices.
        let eyes = [Dir::new([1.0, 1.0, 1.0]).unwrap(), Dir::new([-0.9, 0.3, 0.2]).unwrap(), -Dir::X];
        let error = |blend: &ReflectionSpace| {
            let all: Vec<f64> =
                eyes.iter().map(|eye| compare_shadings(&points(*eye), blend, &truth).relative_rmse).collect();
            println!("{} views, normalized {}: relative RMSE {all:.4?}", blend.views(), blend.normalized);
            all.into_iter().fold(0.0, f64::max)
        };
        let [few, more] = [0, 1].map(|subdivisions| {
            let blend = ReflectionSpace::new(&source, &brdf, subdivisions, 24);
            (error(&blend), error(&blend.normalized()))
        });
        assert!(few.0 < 0.4 && more.0 < 0.4 * few.0, "12 views {few:?}, 42 views {more:?}");
        assert!(few.1 < 0.65 * few.0 && more.1 < 0.4 * few.1, "normalized: 12 views {few:?}, 42 views {more:?}");
    }

    #[test]
    fn at_the_views_themselves_only_the_resolution_of_the_maps_is_left() {
        let (source, brdf) = (source(), Ggx { alpha: 0.4, f0: 0.04 });
        let truth = BruteForceReflection::new(&source, brdf);
        let eye = Icosphere::new(0).vertices[3];
        let error = |size| {
            let blend = ReflectionSpace::new(&source, &brdf, 0, size);
            compare_shadings(&points(eye), &blend, &truth).relative_rmse
        };
        let (coarse, fine) = (error(16), error(48));
        println!("relative RMSE {coarse:.4} with 16 x 16 texels, {fine:.4} with 48 x 48");
        assert!(fine < 0.02 && fine < 0.4 * coarse, "{coarse} and {fine}");
    }

    #[test]
    fn a_matte_ball_under_even_light_shows_its_albedo() {
        let even = CubeMap::from_fn(16, |_| Rgb::splat(1.0));
        let blend = ReflectionSpace::new(&even, &Lambert { albedo: 0.6 }, 0, 16);
        for p in points(-Dir::X) {
            let found = blend.radiance(&p).g;
            // Texels that the horizon cuts count by their middle.
            assert!((found - 0.6).abs() < 0.01, "{found} at {p:?}");
        }
    }
}
