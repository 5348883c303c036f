//! BSDFs: the reflection of light at a point of a surface, evaluated and sampled.

use std::f64::consts::PI;

use lobe_sh::{Coefficient as _, Rgb};

use crate::path_tracer::ggx::Facets;
use lobe_sh::sphere::vector::{Vec3, dot, tangents_along_z};

/// The reflection of light at a point towards one direction, in the world.
///
/// Matte: `f = ρ/π`. The metallic-roughness model of glTF 2.0 (appendix B.3 of its specification):
///
/// ```text
///   f = (1 - F) c/π + F D V       c = base (1 - metallic)      F₀ = 0.04 + (base - 0.04) metallic
///   F = F₀ + (1 - F₀) (1 - v·h)⁵     h = (v + l)/|v + l|       α = roughness²
/// ```
///
/// `D V` is that of [`Facets`]: one scattering only, so rough metals lose light. Its masking is height-correlated: the
/// specification says "Smith", its sample viewer and Filament use that form, and it is what the slopes of a surface do;
/// the appendix prints the separable form, which is an option
/// (test `separable_masking_leaves_less_of_rough_metals` has numbers).
pub(crate) struct Bsdf {
    /// Two tangents and the normal.
    frame: [Vec3; 3],
    diffuse: Rgb<f64>,
    mirror: Option<Mirror>,
}

struct Mirror {
    facets: Facets,
    f0: Rgb<f64>,
    /// Towards the viewer, in the frame, above the surface.
    v: Vec3,
    /// The probability of drawing from the microfacets rather than from the cosine lobe.
    share: f64,
}

/// A direction drawn from a BSDF.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BsdfSample {
    pub(crate) towards: Vec3,
    /// `f cos / density`.
    pub(crate) weight: Rgb<f64>,
    /// Density in sr⁻¹.
    pub(crate) density: f64,
}

/// Reflectance of dielectrics along the normal, as glTF has it.
pub(crate) const DIELECTRIC: f64 = 0.04;

/// The least probability of drawing from either of two lobes.
const LEAST_SHARE: f64 = 0.1;

impl Bsdf {
    /// A matte surface of this normal.
    pub(crate) fn matte(normal: Vec3, albedo: Rgb<f64>) -> Self {
        let [u, v] = tangents_along_z(normal);
        Self { frame: [u, v, normal], diffuse: albedo, mirror: None }
    }

    /// A surface of glTF's model seen from direction `view`. Seen from below its shading normal it has no mirror.
    pub(crate) fn metallic_roughness(normal: Vec3, base: Rgb<f64>, metallic: f64, facets: Facets, view: Vec3) -> Self {
        let mut bsdf = Self::matte(normal, base.scale(1.0 - metallic));
        let f0 = Rgb::from(base.to_array().map(|c| DIELECTRIC + (c - DIELECTRIC) * metallic));
        let v = bsdf.frame.map(|axis| dot(axis, view));
        if v[2] <= 0.0 {
            return bsdf;
        }
        let mirrored = fresnel(f0, v[2]).luminance();
        let matte = bsdf.diffuse.luminance() * (1.0 - mirrored);
        let share = match (mirrored > 0.0, matte > 0.0) {
            (true, true) => (mirrored / (mirrored + matte)).clamp(LEAST_SHARE, 1.0 - LEAST_SHARE),
            (_, false) => 1.0,
            (false, true) => 0.0,
        };
        bsdf.mirror = Some(Mirror { facets, f0, v, share });
        bsdf
    }

    /// `f cos` towards `s`, and the density with which [`Bsdf::sample`] draws it.
    pub(crate) fn eval(&self, s: Vec3) -> (Rgb<f64>, f64) {
        self.eval_in_frame(self.frame.map(|axis| dot(axis, s)))
    }

    /// A direction drawn with two numbers in `(0, 1)`, and a third one where there is a mirror; none if it would be below
    /// the surface or black.
    pub(crate) fn sample(&self, numbers: [f64; 2], choice: impl FnOnce() -> f64) -> Option<BsdfSample> {
        // Draw a direction from the microfacets or from the cosine lobe.
        let l = match &self.mirror {
            Some(mirror) if choice() < mirror.share => mirror.facets.sample(mirror.v, numbers),
            _ => cosine_weighted(numbers),
        };
        // Evaluate the BSDF and the density of both together.
        let (value, density) = self.eval_in_frame(l);
        if l[2] <= 0.0 || density <= 0.0 {
            return None;
        }
        let towards = std::array::from_fn(|k| (0..3).map(|i| l[i] * self.frame[i][k]).sum());
        // A matte surface weighs its albedo, without rounding.
        let weight = if self.mirror.is_none() { self.diffuse } else { value.scale(density.recip()) };
        Some(BsdfSample { towards, weight, density })
    }

    fn eval_in_frame(&self, l: Vec3) -> (Rgb<f64>, f64) {
        if l[2] <= 0.0 {
            return (Rgb::ZERO, 0.0);
        }
        let cosine = l[2] / PI;
        let Some(mirror) = &self.mirror else { return (self.diffuse.scale(cosine), cosine) };
        let h = lobe_sh::sphere::vector::normalized(lobe_sh::sphere::vector::add(mirror.v, l));
        let f = fresnel(mirror.f0, dot(mirror.v, h).clamp(0.0, 1.0));
        let lost = Rgb::from(f.to_array().map(|c| 1.0 - c));
        let value = lost * self.diffuse.scale(cosine) + f.scale(mirror.facets.reflectance(mirror.v, l) * l[2]);
        let density = mirror.share * mirror.facets.density(mirror.v, l) + (1.0 - mirror.share) * cosine;
        (value, density)
    }
}

/// Schlick's approximation of Fresnel's factor at the angle of this cosine.
pub(crate) fn fresnel(f0: Rgb<f64>, cos: f64) -> Rgb<f64> {
    let rest = (1.0 - cos).powi(5);
    Rgb::from(f0.to_array().map(|c| c + (1.0 - c) * rest))
}

/// A direction over +z with density `cos θ/π`.
fn cosine_weighted([u0, u1]: [f64; 2]) -> Vec3 {
    let radius = u1.sqrt();
    let (sin, cos) = (2.0 * PI * u0).sin_cos();
    [radius * cos, radius * sin, (1.0 - u1).sqrt()]
}

#[cfg(test)]
mod tests {
    use lobe_env::{Brdf as _, Ggx};
    use lobe_testkit::{ChiSquare, Random};

    use super::*;

    /// The directional albedo, and the mean of the weights' squares, from `count` samples.
    fn reflected(bsdf: &Bsdf, count: usize) -> Rgb<f64> {
        let mut random = Random::new(5);
        let mut sum = Rgb::<f64>::ZERO;
        for _ in 0..count {
            let numbers = [random.unit(), random.unit()];
            if let Some(sample) = bsdf.sample(numbers, || random.unit()) {
                let (value, density) = bsdf.eval(sample.towards);
                assert!((density / sample.density - 1.0).abs() < 1e-6, "densities {density}, {}", sample.density);
                let again = value.scale(1.0 / density);
                assert!((again - sample.weight).luminance().abs() < 1e-6, "{again:?} and {:?}", sample.weight);
                sum += sample.weight.scale(1.0 / count as f64);
            }
        }
        sum
    }

    fn tilted() -> (Vec3, Vec3) {
        let normal = lobe_sh::sphere::vector::normalized([0.3, -0.5, 0.8]);
        let [u, _] = tangents_along_z(normal);
        (normal, lobe_sh::sphere::vector::normalized(add_scaled(normal, u, 0.9)))
    }

    fn add_scaled(a: Vec3, b: Vec3, t: f64) -> Vec3 {
        std::array::from_fn(|k| a[k] + t * b[k])
    }

    #[test]
    fn a_matte_surface_reflects_its_albedo() {
        let albedo = Rgb::new(0.2, 0.5, 1.0);
        let found = reflected(&Bsdf::matte(tilted().0, albedo), 500);
        assert!((found - albedo).luminance().abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn directions_are_drawn_with_the_density_stated() {
        let (normal, view) = tilted();
        let (mut random, red) = (Random::new(6), Rgb::new(0.8, 0.2, 0.1));
        let glossy = |metallic, roughness| {
            Bsdf::metallic_roughness(normal, red, metallic, Facets::of_roughness(roughness, true), view)
        };
        for (name, bsdf) in [
            ("matte", Bsdf::matte(normal, red)),
            ("plastic", glossy(0.0, 0.6)),
            ("metal", glossy(1.0, 0.5)),
            ("half a metal", glossy(0.5, 1.0)),
        ] {
            let draw = || {
                let [a, b, choice] = [random.unit(), random.unit(), random.unit()];
                bsdf.sample([a, b], || choice).map(|sample| sample.towards)
            };
            let test = ChiSquare::new(200_000, draw, |s| bsdf.eval(s).1);
            // Chance passes 5 once in three million.
            assert!(test.z() < 5.0, "{name}: z = {}, {test:?}", test.z());
        }
    }

    #[test]
    fn a_white_metal_loses_what_single_scattering_loses() {
        let (normal, view) = tilted();
        for roughness in [0.1_f64, 0.4, 0.7, 1.0] {
            let bsdf =
                Bsdf::metallic_roughness(normal, Rgb::splat(1.0), 1.0, Facets::of_roughness(roughness, false), view);
            let ggx = Ggx { alpha: roughness * roughness, f0: 1.0 };
            let expected = ggx.directional_albedo(dot(normal, view));
            let found = reflected(&bsdf, 40_000).g;
            assert!((found - expected).abs() < 5e-3, "roughness {roughness}: {found} against {expected}");
        }
    }

    #[test]
    fn separable_masking_leaves_less_of_rough_metals() {
        // For α = 1 both are integrals of rational functions. Over all views 0.377 against 0.409, 7.9 % less.
        for cos in [1.0_f64, 0.5, 0.2] {
            let view = [(1.0 - cos * cos).sqrt(), 0.0, cos];
            let correlated = 1.0 - cos * (1.0 / cos).ln_1p();
            let separable = 2.0 * (1.0 - 2.0_f64.ln()) / (1.0 + cos);
            for (is_separable, expected) in [(false, correlated), (true, separable)] {
                let facets = Facets::of_roughness(1.0, is_separable);
                let bsdf = Bsdf::metallic_roughness([0.0, 0.0, 1.0], Rgb::splat(1.0), 1.0, facets, view);
                let found = reflected(&bsdf, 40_000).g;
                assert!((found - expected).abs() < 5e-3, "cosine {cos}, separable {is_separable}: {found}, {expected}");
            }
        }
    }

    #[test]
    fn plastic_reflects_no_more_than_it_gets() {
        let (normal, view) = tilted();
        for roughness in [0.05, 0.5, 1.0] {
            let bsdf =
                Bsdf::metallic_roughness(normal, Rgb::splat(1.0), 0.0, Facets::of_roughness(roughness, false), view);
            let found = reflected(&bsdf, 40_000).g;
            assert!(found < 1.005 && found > 0.8, "roughness {roughness}: {found}");
        }
    }

    #[test]
    fn a_surface_seen_from_below_its_normal_has_no_mirror() {
        let bsdf = Bsdf::metallic_roughness(
            [0.0, 0.0, 1.0],
            Rgb::splat(0.5),
            0.0,
            Facets::of_roughness(0.3, false),
            [0.6, 0.0, -0.8],
        );
        assert!(bsdf.mirror.is_none(), "matte");
    }
}
