//! Light that spheres send on: one bounce.

use lobe_io::parallel;
use lobe_sh::product::product_into;
use lobe_sh::simd::{Lanes, Wide, constant};
use lobe_sh::{Coefficient as _, Rgb};
use pulp::{Arch, Simd, WithSimd};

use crate::accumulate::aim::{ReceiverBlock, ReceiverLanes, aim};
use crate::accumulate::shares::{COSINE_OVER_PI, MONOMIALS, monomials, to_monomials};
use crate::accumulate::sky_light::SkyLight;
use crate::accumulate::sphere_tree::{Node, SphereTree};
use crate::error::ShadowError;

/// What spheres of diffuse material reflect of the sky, made by [`bounce`](crate::SphereShadows::bounce) for
/// [`reflected_irradiance`](crate::SphereShadows::reflected_irradiance).
///
/// A sphere of albedo `ρ` under the light `L` that reaches it has the exit radiance `ρ E(n)/π`, and seen from afar, from the
/// direction `-s`, the mean of that over its disc: a second convolution with the clamped cosine,
///
/// ```text
///   B(s) = ρ/π² Σ_l A_l² (-1)^l Σ_m L_lm y_lm(s)
/// ```
///
/// `L` is the light of the sky times what the other spheres leave visible of it at the sphere's center. A receiver gets `π B
/// sin²θ max(n·s, 0)` of a sphere. Spheres behind each other share what they hide together: the sum is scaled down so that as
/// much of the cosine is filled as the visibility has hidden.
///
/// This is an approximation in every step: one bounce, no light from the ground to the spheres, no shadow on the ground between
/// them and the receiver, the first three bands. The test `a_bounce_brings_irradiance_nearer_to_the_traced_truth` measures it.
#[derive(Clone, Debug)]
pub struct Bounce {
    /// For every node of the tree, the coefficients of [`MONOMIALS`] in three channels.
    radiance: Vec<[[f32; 3]; MONOMIALS]>,
}

impl Bounce {
    /// For the spheres of a tree, sphere `k` of albedo `albedo[k]`. `visibility_at` tells what a leaf sees of the
    /// sky from its center, in every lane.
    pub(crate) fn new(
        tree: &SphereTree,
        sky: &SkyLight,
        albedo: &[Rgb<f32>],
        visibility_at: impl Fn(&Node) -> Vec<Lanes> + Sync,
    ) -> Result<Self, ShadowError> {
        let invalid = |message: String| Err(ShadowError::Invalid { place: "albedo".to_owned(), message });
        if let Some(k) = albedo.iter().position(|a| !a.to_array().iter().all(|a| (0.0..=1.0).contains(a))) {
            return invalid(format!("expected numbers from 0 to 1, found {:?} for sphere {k}", albedo[k]));
        }
        let leaves: Vec<Node> = tree.nodes.iter().copied().filter(Node::is_leaf).collect();
        let sphere_of = |node: &Node| tree.spheres[node.place as usize] as usize;
        if let Some(leaf) = leaves.iter().find(|leaf| sphere_of(leaf) >= albedo.len()) {
            return invalid(format!(
                "expected one for every sphere, found {}, none for {}",
                albedo.len(),
                sphere_of(leaf)
            ));
        }
        let mut radiance = vec![[[0.0; 3]; MONOMIALS]; tree.nodes.len()];
        let of_leaf = |leaf: &Node| {
            let visible: Vec<Rgb<f64>> = visibility_at(leaf).iter().map(|v| Rgb::splat(f64::from(v[0]))).collect();
            reflected(&visible, sky, albedo[sphere_of(leaf)])
        };
        let of_leaves = parallel::map(leaves.len(), &|k| of_leaf(&leaves[k]));
        leaves.iter().zip(of_leaves).for_each(|(leaf, of_leaf)| radiance[leaf.place as usize] = of_leaf);
        for node in tree.nodes.iter().rev().filter(|node| !node.is_leaf()) {
            radiance[node.place as usize] = mean(&tree.nodes[node.children()], &radiance);
        }
        Ok(Self { radiance })
    }

    /// Whether it may be of the spheres of a tree: there are as many.
    pub(crate) fn is_of(&self, tree: &SphereTree) -> bool {
        self.radiance.len() == tree.nodes.len()
    }

    /// The irradiance of sixteen receivers in red, green and blue, of which `white` is that from a white sky of radiance 1.
    pub(crate) fn reflected(
        &self,
        arch: Arch,
        at: &ReceiverBlock,
        [near, far]: [&[Node]; 2],
        white: &Lanes,
    ) -> [Lanes; 3] {
        let mut irradiance = [Lanes::ZERO; 3];
        arch.dispatch(Reflected { bounce: self, at, near, far, white, irradiance: &mut irradiance });
        irradiance
    }
}

/// The monomials of `B(s)`.
fn reflected(visible: &[Rgb<f64>], sky: &SkyLight, albedo: Rgb<f32>) -> [[f32; 3]; MONOMIALS] {
    let mut light = vec![Rgb::ZERO; visible.len()];
    product_into(visible, &sky.light, &mut light);
    let mut b = [[0.0; 3]; MONOMIALS];
    for (i, (b, light)) in b.iter_mut().zip(&light).enumerate() {
        let l = i.isqrt();
        let sign = if l == 1 { -1.0 } else { 1.0 };
        let factor = sign * COSINE_OVER_PI[l].powi(2);
        for c in 0..3 {
            b[c] = factor * f64::from(albedo.channel(c)) * light.channel(c);
        }
    }
    let channel = |c: usize| to_monomials(std::array::from_fn(|i| b[i][c]));
    let channels = [channel(0), channel(1), channel(2)];
    std::array::from_fn(|i| channels.map(|channel| channel[i] as f32))
}

/// The mean over children by what they hide.
fn mean(children: &[Node], radiance: &[[[f32; 3]; MONOMIALS]]) -> [[f32; 3]; MONOMIALS] {
    let area = |node: &Node| node.count * node.radius * node.radius;
    let all: f32 = children.iter().map(area).sum();
    let weight = |node: &Node| if all > 0.0 { area(node) / all } else { 0.0 };
    let mut out = [[0.0; 3]; MONOMIALS];
    for child in children {
        let child_radiance = &radiance[child.place as usize];
        for (out, b) in out.as_flattened_mut().iter_mut().zip(child_radiance.as_flattened()) {
            *out += weight(child) * b;
        }
    }
    out
}

/// To be compiled for the machine's registers.
struct Reflected<'a> {
    bounce: &'a Bounce,
    at: &'a ReceiverBlock,
    near: &'a [Node],
    far: &'a [Node],
    white: &'a Lanes,
    irradiance: &'a mut [Lanes; 3],
}

impl WithSimd for Reflected<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let splat = |value| constant(simd, value);
        let pi = splat(std::f32::consts::PI);
        for part in 0..Wide::<S>::PARTS {
            let at = ReceiverLanes::load(simd, self.at, part);
            let mut sums = [splat(0.0); 3];
            let mut filled = splat(0.0);
            for node in self.near.iter().chain(self.far) {
                let seen = aim::<S, true>(simd, &at, node.center, node.radius);
                let [x, y, z] = seen.towards;
                let [nx, ny, nz] = at.normal;
                let cosine = (nx * x + ny * y + nz * z).max(splat(0.0));
                let share = node.share.towards(simd, seen.towards);
                let factor = seen.sin_squared * cosine * share * splat(node.count);
                filled = filled + factor;
                let mut b = [splat(0.0); 3];
                for (monomial, row) in
                    monomials(simd, seen.towards).into_iter().zip(&self.bounce.radiance[node.place as usize])
                {
                    for c in 0..3 {
                        b[c] = monomial.times_plus(splat(row[c]), b[c]);
                    }
                }
                for c in 0..3 {
                    sums[c] = factor.times_plus(b[c], sums[c]);
                }
            }
            // What the visibility has hidden of the cosine, over what the spheres would fill one by one.
            let hidden = splat(1.0) - Wide::load(simd, self.white, part) * splat(std::f32::consts::FRAC_1_PI);
            let share = (hidden * filled.max(splat(f32::MIN_POSITIVE)).recip()).max(splat(0.0)).min(splat(1.0));
            for (sum, block) in sums.into_iter().zip(&mut *self.irradiance) {
                (pi * share * sum).store(block, part);
            }
        }
    }
}
