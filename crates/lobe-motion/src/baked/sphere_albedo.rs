//! The albedo of spheres that stand for a part of a scene: that of the surface next to each.

use lobe_scene::{Hit, Scene};
use lobe_sh::Rgb;
use lobe_shadow::SphereSet;

/// Points of the surface at which its color is taken.
const POINTS: usize = 4096;

/// The mean albedo of the surface that each sphere stands for, by area: of evenly spread points those to which the
/// sphere is nearest. One that is nearest to none takes the mean of all.
pub(crate) fn sphere_albedos(scene: &Scene, spheres: &SphereSet) -> Vec<Rgb<f32>> {
    let mut sums = vec![([0.0_f64; 3], 0_usize); spheres.len()];
    let mut all = ([0.0_f64; 3], 0_usize);
    let add = |(sum, count): &mut ([f64; 3], usize), color: [f32; 4]| {
        (0..3).for_each(|c| sum[c] += f64::from(color[c]));
        *count += 1;
    };
    for hit in even_points(scene) {
        let surface = scene.surface(&hit);
        add(&mut all, surface.base_color);
        let position = std::array::from_fn(|k| f64::from(surface.position[k]) + scene.origin()[k]);
        if let Some(nearest) = nearest(spheres, position) {
            add(&mut sums[nearest], surface.base_color);
        }
    }
    let mean = |(sum, count): ([f64; 3], usize)| sum.map(|c| (c / count.max(1) as f64).clamp(0.0, 1.0) as f32);
    sums.into_iter().map(|of_one| Rgb::from(mean(if of_one.1 > 0 { of_one } else { all }))).collect()
}

/// The sphere whose surface is nearest to a point of the mesh's own frame, or that it is deepest in.
fn nearest(spheres: &SphereSet, p: [f64; 3]) -> Option<usize> {
    let depth = |k: usize| {
        let center = spheres.center(k);
        (0..3).map(|i| (p[i] - center[i]).powi(2)).sum::<f64>().sqrt() - f64::from(spheres.radii()[k])
    };
    (0..spheres.len()).min_by(|a, b| depth(*a).total_cmp(&depth(*b)))
}

/// Points of the surface, one in each of [`POINTS`] equal parts of its area, triangle after triangle.
fn even_points(scene: &Scene) -> impl Iterator<Item = Hit> {
    let area = |[a, b, c]: [[f32; 3]; 3]| {
        let side = |p: [f32; 3]| -> [f64; 3] { std::array::from_fn(|k| f64::from(p[k]) - f64::from(a[k])) };
        let n = lobe_sh::sphere::vector::cross(side(b), side(c));
        0.5 * n.iter().map(|x| x * x).sum::<f64>().sqrt()
    };
    let mut ends = Vec::with_capacity(scene.triangle_count());
    let mut total = 0.0;
    for corners in scene.corners() {
        total += area(corners);
        ends.push(total);
    }
    (0..POINTS).map(move |k| {
        let at = total * (k as f64 + 0.5) / POINTS as f64;
        let triangle = ends.partition_point(|end| *end < at).min(ends.len() - 1);
        // Places in the triangle: the additive sequence of the plastic number (Roberts 2018), folded at the diagonal.
        let [u, v] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_2].map(|step| (0.5 + step * k as f64).fract());
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        Hit { t: 0.0, triangle: triangle as u32, u: u as f32, v: v as f32 }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_scene::built_in;

    #[test]
    fn each_sphere_has_the_color_of_what_it_stands_for() {
        // A ground of 0.6 below z = 0, and a red ball about (0, 0, 1.5).
        let scene = built_in::ball_over_ground(16);
        let spheres = SphereSet::new(vec![[0.0, 0.0, -50.0], [0.0, 0.0, 1.5], [0.0, 0.0, 1.5]], vec![50.0, 1.0, 0.1]);
        let found = sphere_albedos(&scene, &spheres.unwrap());
        let expected = [[0.6, 0.6, 0.6], [0.7, 0.25, 0.2]];
        for (found, expected) in found.iter().zip(expected) {
            let off = found.to_array().iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(off < 0.05, "{found:?}, expected {expected:?}");
        }
        let mean = found[2].to_array();
        assert!(mean[0] > 0.59 && mean[1] > 0.5, "nothing is nearest to the small one, which takes the mean: {mean:?}");
    }

    #[test]
    fn scene_and_spheres_may_count_from_different_origins() {
        let by = [64.0, -32.0, 16.0];
        let albedos = |scene: &Scene, moved: [f32; 3]| {
            let center = |z: f32| [moved[0], moved[1], z + moved[2]];
            sphere_albedos(scene, &SphereSet::new(vec![center(-50.0), center(1.5)], vec![50.0, 1.0]).unwrap())
        };
        let scene = built_in::ball_over_ground(16);
        let expected = albedos(&scene, [0.0; 3]);
        let found = albedos(&scene.moved(by), by.map(|c| c as f32));
        assert_eq!(found, expected, "the scene counts from {by:?}, the spheres from zero");
    }
}
