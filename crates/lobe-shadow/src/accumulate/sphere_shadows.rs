//! Receivers under a sky that many spheres hide.

use derive_setters::Setters;
use lobe_io::parallel;
use lobe_sh::Rgb;
use lobe_sh::basis::coefficient_count;
use lobe_sh::exponential::ExpMethod;
use lobe_sh::simd::{LANES, Lanes, Machine};
use pulp::Arch;

use crate::accumulate::aim::ReceiverBlock;
use crate::accumulate::batch_exponential::BatchExponential;
use crate::accumulate::bounce::Bounce;
use crate::accumulate::log_table::LogTable;
use crate::accumulate::monic_columns::MonicColumns;
use crate::accumulate::occluder::Occluder;
use crate::accumulate::receiver_groups::{Group, sort_out};
use crate::accumulate::shares::Share;
use crate::accumulate::sky_light::{CHANNELS, SkyLight};
use crate::accumulate::sphere_tree::{Node, SphereTree, distance};
use crate::accumulate::sum_logarithms::add_logarithms;
use crate::error::ShadowError;
use crate::receivers::ShadowReceivers;

/// Options of [`SphereShadows`].
#[derive(Clone, Copy, Debug, PartialEq, Setters, serde::Serialize, serde::Deserialize)]
#[serde(default)]
#[non_exhaustive]
pub struct ShadowOptions {
    /// The exponential: [`ExpMethod::Grid`], [`ExpMethod::OptimalLinear`] or [`ExpMethod::Hybrid`].
    pub method: ExpMethod,
    /// Spheres under a node count as one where the node's reach is at most this part of its distance; 0 takes every sphere
    /// by itself.
    pub cut: f32,
    /// Receivers in a group, a multiple of 16: spheres far away are accumulated once for a group, as its center sees them.
    /// 0 takes every receiver by itself.
    pub group: usize,
    /// Spheres are far from a group where its radius is at most this part of their distance: the error of irradiance falls with it, by
    /// some tenths of a percent of the open sky at 0.1 (table in this crate's README).
    pub far: f32,
    /// Whether spheres that overlap share what they hide. Otherwise each of them hides it once more, as published.
    pub share_overlaps: bool,
}

/// Receivers that a thread takes at a time where they share nothing.
const AT_ONCE: usize = 16 * LANES;

impl Default for ShadowOptions {
    /// On the grid, nodes up to a fifth of their distance, every receiver by itself; groups take what is twenty times
    /// as far as they are large.
    fn default() -> Self {
        Self { method: ExpMethod::default(), cut: 0.2, group: 0, far: 0.05, share_overlaps: true }
    }
}

impl ShadowOptions {
    fn check(&self) -> Result<(), ShadowError> {
        let options = |message: String| Err(ShadowError::Options(message));
        for (name, value) in [("cut", self.cut), ("far", self.far)] {
            if !(0.0..=1.0).contains(&value) {
                return options(format!("expected {name} from 0 to 1, found {value}"));
            }
        }
        if !self.group.is_multiple_of(LANES) {
            return options(format!("expected groups of a multiple of {LANES} receivers, found {}", self.group));
        }
        Ok(())
    }
}

/// The shadows of spheres under a whole sky, by exponentials of sums of logarithms ([Ren et al. 2006]).
///
/// ```text
///   V = exp(Σ_spheres log V_sphere)        E(n) = ∫ V L max(n·s, 0) ds
/// ```
///
/// A receiver adds up the logarithms of all spheres, each from the table by its size and turned to its direction, takes the
/// exponential, and lets light and cosine through it. Sixteen receivers go together in lanes. Spheres in front of each other
/// count twice in the sum: the exponential darkens what the two hide together, and stays positive. How near the result is to the
/// truth is printed by the example `exponential_errors` for random spheres.
///
/// A sphere above the tangent plane of a receiver has `sin θ = r/d`. One whose center is lower than `r/3` shrinks, until it is
/// gone when it is all below the plane, and no sphere is nearer than its radius. So a receiver on the surface of a sphere that
/// looks outward is not hidden by it; a tenth of the radius below it loses a thirteenth of its light instead of all, because
/// spheres reach out of the surfaces for which they stand; at the center it loses three quarters. The result is continuous in
/// place and normal. The plane holds for baked transfer too: of light that comes to it from below, by way of other surfaces, spheres hide
/// nothing, where [`ShadowFields`](crate::ShadowFields) hide what the receiver itself would not see. Such paths pass other places than the receiver, so neither
/// is exact; the truth was between both in the test
/// `what_is_behind_a_surface_hides_its_baked_reflections_by_fields_and_not_by_spheres` of `lobe-motion`, less than 2 % from either. Without the plane, spheres that
/// reach out of a floor would darken it. Without spheres the sky is open. Results are the same for any number of threads.
///
/// ```
/// use lobe_sh::{Rgb, ShL2};
/// use lobe_shadow::{LogTable, LogTableOptions, Occluder, ShadowReceivers, ShadowOptions, SkyLight, SphereShadows};
///
/// let table = LogTable::new(&LogTableOptions::default().order(3))?;
/// let above = [Occluder::new([0.0, 0.0, 2.0], 1.0)];
/// let shadows = SphereShadows::new(&table, &above, &ShadowOptions::default())?;
/// let sky = SkyLight::new(&ShL2::constant(Rgb::new(1.0, 1.0, 1.0)), 3)?;
/// let under = ShadowReceivers::new(&[[0.0; 3]], &[[0.0, 0.0, 1.0]])?;
/// // The sphere hides sin²θ = 1/4 of the irradiance π.
/// let irradiance = shadows.irradiance(&under, &sky)?[0].g / std::f32::consts::PI;
/// assert!((irradiance - 0.75).abs() < 0.06, "{irradiance}");
/// # Ok::<(), lobe_shadow::ShadowError>(())
/// ```
///
/// [Ren et al. 2006]: https://doi.org/10.1145/1141911.1141982
#[derive(Clone, Debug)]
pub struct SphereShadows<'a> {
    table: &'a LogTable,
    tree: SphereTree,
    columns: MonicColumns,
    exponential: BatchExponential,
    arch: Arch,
    /// The spheres one by one.
    leaves: Vec<Node>,
    options: ShadowOptions,
}

impl<'a> SphereShadows<'a> {
    /// Prepares spheres, with a tree of its own over them.
    ///
    /// # Errors
    /// [`ShadowError::Options`] for options out of their range, [`ShadowError::Invalid`] as [`SphereTree::over`].
    pub fn new(table: &'a LogTable, spheres: &[Occluder], options: &ShadowOptions) -> Result<Self, ShadowError> {
        let tree = if options.share_overlaps { SphereTree::over(spheres) } else { SphereTree::unshared(spheres) };
        Self::with_tree(table, tree?, options)
    }

    /// Prepares spheres that are in a tree.
    ///
    /// # Errors
    /// [`ShadowError::Options`] for options out of their range.
    pub fn with_tree(table: &'a LogTable, mut tree: SphereTree, options: &ShadowOptions) -> Result<Self, ShadowError> {
        options.check()?;
        let exponential = BatchExponential::new(table.order(), options.method)?;
        if !options.share_overlaps {
            tree.unshare();
        }
        let shows = |node: &Node| node.is_leaf() && node.share != Share::Nothing;
        let leaves = tree.nodes.iter().copied().filter(shows).collect();
        Ok(Self {
            table,
            tree,
            columns: MonicColumns::new(),
            exponential,
            arch: Machine::detect().arch(),
            leaves,
            options: *options,
        })
    }

    /// The spheres that hide anything, each with the part of its disc that counts for a receiver that sees it in direction s: the
    /// factors of 1, x, y, z, xy, yz, z², xz, x² - y² in that part, which is cut off at 0 and 1; and last the square of
    /// the radius of the solid whose part it is, over that of its own. For shaders.
    pub fn shares(&self) -> impl Iterator<Item = (Occluder, [f32; 10])> {
        self.leaves.iter().map(|leaf| {
            let mut numbers = [1.0, 0., 0., 0., 0., 0., 0., 0., 0., (leaf.solid / leaf.radius).powi(2)];
            if let Share::Part(factors) = leaf.share {
                numbers[..9].copy_from_slice(&factors);
            }
            (self.tree.unit.of_world(Occluder::new(leaf.center, leaf.radius)), numbers)
        })
    }

    /// The expansions of what each receiver sees of the sky, one after the other: factors for products with transfer.
    #[must_use]
    pub fn visibility(&self, receivers: &ShadowReceivers<'_>) -> Vec<f32> {
        let n = coefficient_count(self.table.order());
        self.of_all(receivers, n, &|_, _, visibility, out| {
            for (k, row) in out.chunks_exact_mut(n).enumerate() {
                row.iter_mut().zip(visibility).for_each(|(out, v)| *out = v[k]);
            }
        })
    }

    /// The irradiance of each receiver from the sky.
    ///
    /// # Errors
    /// [`ShadowError::Options`] if the light is prepared for another order than the table's.
    pub fn irradiance(&self, receivers: &ShadowReceivers<'_>, sky: &SkyLight) -> Result<Vec<Rgb<f32>>, ShadowError> {
        self.irradiance_with(receivers, sky, None)
    }

    /// The irradiance of each receiver from the spheres that hide the sky, lit by the same sky.
    ///
    /// # Errors
    /// As [`SphereShadows::irradiance`], and [`ShadowError::Options`] if the bounce is of another number of spheres.
    pub fn reflected_irradiance(
        &self,
        receivers: &ShadowReceivers<'_>,
        sky: &SkyLight,
        bounce: &Bounce,
    ) -> Result<Vec<Rgb<f32>>, ShadowError> {
        if !bounce.is_of(&self.tree) {
            return Err(ShadowError::Options("expected a bounce of these spheres, found one of others".to_owned()));
        }
        self.irradiance_with(receivers, sky, Some(bounce))
    }

    /// What the spheres reflect of a sky, sphere `k` of albedo `albedo[k]`. Takes time in the square of their number.
    ///
    /// # Errors
    /// [`ShadowError::Options`] if the light is for another order; [`ShadowError::Invalid`] if a sphere has no albedo, or one
    /// is outside `[0, 1]`.
    pub fn bounce(&self, sky: &SkyLight, albedo: &[Rgb<f32>]) -> Result<Bounce, ShadowError> {
        self.check_order(sky)?;
        Bounce::new(&self.tree, sky, albedo, |leaf| self.visibility_at(leaf))
    }

    /// What a sphere sees of the sky from its center, past those that it does not overlap: the others are parts of the same
    /// surface.
    fn visibility_at(&self, leaf: &Node) -> Vec<Lanes> {
        let mut f = vec![Lanes::ZERO; coefficient_count(self.table.order())];
        let at = ReceiverBlock { position: leaf.center.map(Lanes::splat), normal: [Lanes::ZERO; 3] };
        let is_apart = |other: &Node| distance(leaf.center, other.center) >= leaf.radius + other.radius;
        let others: Vec<Node> = self.leaves.iter().copied().filter(is_apart).collect();
        self.add(&at, &others, false, &mut f);
        let mut room = vec![Lanes::ZERO; f.len()];
        self.exponential.of_block_with(&mut f, &mut room);
        f
    }

    fn irradiance_with(
        &self,
        receivers: &ShadowReceivers<'_>,
        sky: &SkyLight,
        bounce: Option<&Bounce>,
    ) -> Result<Vec<Rgb<f32>>, ShadowError> {
        self.check_order(sky)?;
        let flat = self.of_all(receivers, 3, &|at, nodes, visibility, out| {
            let irradiance = match bounce {
                None => sky.irradiance_of_block(self.arch, &at.normal, visibility),
                Some(bounce) => {
                    let [.., white] = sky.irradiance_of_block::<CHANNELS>(self.arch, &at.normal, visibility);
                    bounce.reflected(self.arch, at, [nodes.near, nodes.far], &white)
                }
            };
            for (k, row) in out.chunks_exact_mut(3).enumerate() {
                row.iter_mut().zip(&irradiance).for_each(|(out, channel)| *out = channel[k]);
            }
        });
        Ok(flat.as_chunks().0.iter().map(|rgb| Rgb::from(*rgb)).collect())
    }

    fn check_order(&self, sky: &SkyLight) -> Result<(), ShadowError> {
        if sky.order() != self.table.order() {
            let message =
                format!("expected light for order {}, that of the table, found {}", self.table.order(), sky.order());
            return Err(ShadowError::Options(message));
        }
        Ok(())
    }

    /// Hands the visibility of every sixteen receivers, the nodes that hide their sky, and room for `stride` numbers of each
    /// receiver to `write`; the numbers of all receivers, in their order.
    fn of_all(&self, receivers: &ShadowReceivers<'_>, stride: usize, write: &Write<'_>) -> Vec<f32> {
        let mut out = vec![0.0; receivers.len() * stride];
        if self.is_plain() {
            parallel::rows(&mut out, AT_ONCE * stride, &|group, out| {
                let first = (group * AT_ONCE) as u32;
                let members: Vec<u32> = (first..first + (out.len() / stride) as u32).collect();
                self.of_group(receivers, &members, out, write);
            });
            return out;
        }
        let order = receivers.coherent_order();
        let together = self.options.group.max(LANES);
        let groups: Vec<&[u32]> = order.chunks(together).collect();
        let of_groups: Vec<Vec<f32>> = parallel::map(groups.len(), &|group| {
            let mut values = vec![0.0; groups[group].len() * stride];
            self.of_group(receivers, groups[group], &mut values, write);
            values
        });
        for (members, values) in groups.into_iter().zip(&of_groups) {
            for (k, values) in members.iter().zip(values.chunks_exact(stride)) {
                out[*k as usize * stride..][..stride].copy_from_slice(values);
            }
        }
        out
    }

    /// Whether every receiver takes every sphere by itself.
    fn is_plain(&self) -> bool {
        self.options.cut == 0.0 && self.options.group == 0
    }

    /// The same for a group of receivers.
    fn of_group(&self, receivers: &ShadowReceivers<'_>, members: &[u32], out: &mut [f32], write: &Write<'_>) {
        let n = coefficient_count(self.table.order());
        let stride = out.len() / members.len().max(1);
        let (mut near, mut far) = (Vec::new(), Vec::new());
        let mut shared = vec![Lanes::ZERO; n];
        if !self.is_plain() {
            let group = Group::new(receivers, members, self.tree.unit);
            let limit = (self.options.group > 0).then_some(self.options.far);
            sort_out(&self.tree, &group, self.options.cut, limit, &mut near, &mut far);
            // Accumulate what is far once, as the center of the group sees it.
            let center = ReceiverBlock { position: group.center.map(Lanes::splat), normal: [Lanes::ZERO; 3] };
            self.add(&center, &far, false, &mut shared);
        }
        let nodes = Nodes { near: if self.is_plain() { &self.leaves } else { &near }, far: &far };
        let (mut f, mut room) = (shared.clone(), shared.clone());
        for (members, out) in members.chunks(LANES).zip(out.chunks_mut(LANES * stride)) {
            let at = ReceiverBlock::of(receivers, members, self.tree.unit);
            f.copy_from_slice(&shared);
            self.add(&at, nodes.near, true, &mut f);
            self.exponential.of_block_with(&mut f, &mut room);
            write(&at, &nodes, &f, out);
        }
    }

    fn add(&self, at: &ReceiverBlock, nodes: &[Node], plane: bool, sums: &mut [Lanes]) {
        add_logarithms(self.arch, self.table, &self.columns, at, nodes, plane, sums);
    }
}

/// What hides the sky of a group: nodes that every receiver sees from where it is, and such that all see alike.
struct Nodes<'a> {
    near: &'a [Node],
    far: &'a [Node],
}

/// Writes the numbers of sixteen receivers, from these, the nodes that hide their sky, and their visibility.
type Write<'a> = dyn Fn(&ReceiverBlock, &Nodes<'_>, &[Lanes], &mut [f32]) + Sync + 'a;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accumulate::log_table::LogTableOptions;
    use lobe_sh::ShL2;
    use lobe_testkit::Random;

    /// Narrower registers than the machine's, which take a block in several parts.
    fn narrower() -> Vec<Arch> {
        #[cfg(target_arch = "x86_64")]
        let v3 = pulp::x86::V3::try_new().map(Arch::V3);
        #[cfg(not(target_arch = "x86_64"))]
        let v3 = None;
        [Some(Arch::Scalar), v3].into_iter().flatten().collect()
    }

    #[test]
    fn what_stands_for_several_spheres_lies_where_they_hide_the_sky() {
        // The second is inside the first, and shares nothing; the third is apart.
        let spheres =
            [Occluder::new([0.0; 3], 1.0), Occluder::new([0.1, 0.0, 0.0], 0.3), Occluder::new([8.0, 0.0, 0.0], 1.0)];
        let table = LogTable::new(&LogTableOptions::default().order(2).tolerance(0.1)).unwrap();
        for (shared, hidden) in [(true, [1.0, 0.0, 1.0]), (false, [1.0, 0.09, 1.0])] {
            let options = ShadowOptions::default().share_overlaps(shared);
            let shadows = SphereShadows::new(&table, &spheres, &options).unwrap();
            let handed = SphereShadows::with_tree(&table, SphereTree::over(&spheres).unwrap(), &options).unwrap();
            assert_eq!(shadows.tree.nodes, handed.tree.nodes, "of a tree that was made before");
            let root = shadows.tree.unit.of_world(Occluder::new(shadows.tree.nodes[0].center, 0.0));
            let sum: f32 = hidden.iter().sum();
            let expected: f32 = hidden.iter().zip(&spheres).map(|(h, s)| h * s.center[0]).sum::<f32>() / sum;
            assert!((root.center[0] - expected).abs() < 1e-3, "shared {shared}: {root:?}, expected {expected}");
        }
    }

    #[test]
    fn shadows_do_not_depend_on_the_unit_of_length() {
        let table = LogTable::new(&LogTableOptions::default().order(3).tolerance(0.1)).unwrap();
        let mut random = Random::new(4);
        let mut within = |side: f64| [0, 1, 2].map(|_| (side * random.signed()) as f32);
        let spheres: Vec<Occluder> = (0..40).map(|_| Occluder::new(within(2.0), 0.4)).collect();
        let positions: Vec<[f32; 3]> = (0..50).map(|_| within(3.0)).collect();
        let normals = vec![[0.0, 0.6, 0.8]; positions.len()];
        for options in [ShadowOptions::default(), ShadowOptions::default().cut(0.0), ShadowOptions::default().group(16)]
        {
            let seen = |exponent: i32| {
                let by = 2.0_f32.powi(exponent);
                let scaled = |p: [f32; 3]| p.map(|c| by * c);
                let spheres: Vec<Occluder> =
                    spheres.iter().map(|s| Occluder::new(scaled(s.center), by * s.radius)).collect();
                let positions: Vec<[f32; 3]> = positions.iter().map(|p| scaled(*p)).collect();
                let receivers = ShadowReceivers::new(&positions, &normals).unwrap();
                SphereShadows::new(&table, &spheres, &options).unwrap().visibility(&receivers)
            };
            let ours = seen(0);
            for exponent in [-60, -30, 30, 60, 120] {
                assert_eq!(seen(exponent), ours, "2^{exponent} and {options:?}");
            }
        }
    }

    #[test]
    fn a_part_that_is_scaled_to_nothing_sees_spheres_far_away() {
        // In a frame of scale 1e-12 what is 2000 away is at 2e15, and its surface is a point.
        let table = LogTable::new(&LogTableOptions::default().order(3).tolerance(0.1)).unwrap();
        let normals = [[0.0, 0.0, 1.0]];
        let seen = |scale: f32, at: [f32; 3]| {
            let spheres = [Occluder::new([0.0, 300.0 / scale, 2000.0 / scale], 500.0 / scale)];
            let positions = [at];
            let receivers = ShadowReceivers::new(&positions, &normals).unwrap();
            SphereShadows::new(&table, &spheres, &ShadowOptions::default()).unwrap().visibility(&receivers)
        };
        let expected = seen(1.0, [0.0; 3]);
        for (scale, at) in [(1e-12, [0.3, -0.2, 0.1]), (1e-15, [1.0; 3]), (1e12, [1e-16; 3])] {
            let found = seen(scale, at);
            let off = found.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(off < 1e-5, "scale {scale}: {found:?}, expected {expected:?}");
        }
        // From farther than squares of lengths have numbers nothing is hidden.
        let far = seen(1.0, [3e38, -3e38, 1e30]);
        assert!(
            (far[0] - (4.0 * std::f32::consts::PI).sqrt()).abs() < 1e-5 && far[1..].iter().all(|v| v.abs() < 1e-5),
            "{far:?}"
        );
    }

    #[test]
    fn registers_of_every_width_find_the_same() {
        let mut random = Random::new(4);
        let mut within = |side: f64| [0, 1, 2].map(|_| (side * random.signed()) as f32);
        // Some are so near that they are beyond the polynomials.
        let spheres: Vec<Occluder> = (0..40).map(|_| Occluder::new(within(2.0), 0.6)).collect();
        let positions: Vec<[f32; 3]> = (0..50).map(|_| within(3.0)).collect();
        let normals = vec![[0.0, 0.6, 0.8]; positions.len()];
        let receivers = ShadowReceivers::new(&positions, &normals).unwrap();
        for order in [1, 3, 4, 8] {
            let table = LogTable::new(&LogTableOptions::default().order(order).tolerance(0.1)).unwrap();
            let sky = SkyLight::new(&ShL2::constant(Rgb::new(1.0, 2.0, 3.0)), order).unwrap();
            for method in [ExpMethod::Grid, ExpMethod::Hybrid { limit: 1.0 }] {
                let wide = SphereShadows::new(&table, &spheres, &ShadowOptions::default().method(method)).unwrap();
                let bounce = wide.bounce(&sky, &[Rgb::new(0.5, 0.6, 0.7); 40]).unwrap();
                let lit = |shadows: &SphereShadows<'_>| -> Vec<f32> {
                    let lit = shadows.irradiance(&receivers, &sky).unwrap().into_iter();
                    let lit = lit.chain(shadows.reflected_irradiance(&receivers, &sky, &bounce).unwrap());
                    shadows.visibility(&receivers).into_iter().chain(lit.flat_map(Rgb::to_array)).collect()
                };
                for arch in narrower() {
                    let mut narrow = wide.clone();
                    narrow.arch = arch;
                    narrow.exponential = narrow.exponential.with_arch(arch);
                    for (a, b) in lit(&wide).iter().zip(lit(&narrow)) {
                        assert!(
                            (a - b).abs() < 2e-5 * (1.0 + a.abs()),
                            "order {order}, {method:?}, {arch:?}: {a} and {b}"
                        );
                    }
                }
            }
        }
    }
}
