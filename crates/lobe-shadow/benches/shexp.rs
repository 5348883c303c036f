//! Shadows of spheres by exponentials against chained products, per receiver, on one thread; see the README beside this file.

#![allow(clippy::unwrap_used, reason = "a benchmark fails by panicking")]

use std::hint::black_box;
use std::time::Instant;

use lobe_sh::basis::{Basis, coefficient_count};
use lobe_sh::batch::{DirBatch, ShBatch};
use lobe_sh::product::{product_into, product_of_blocks};
use lobe_sh::simd::{Kernel, LANES, Lanes, Machine, Wide, constant};
use lobe_sh::{Rgb, ShL2, Zonal};
use lobe_shadow::{LogTable, LogTableOptions, Occluder, ShadowOptions, ShadowReceivers, SkyLight, SphereShadows};
use lobe_testkit::Random;

/// Receivers that are timed together: few, so that other programs seldom come between; and those of the chain.
const RECEIVERS: usize = 128;
const CHAINS: usize = 4;

/// Repetitions, taken in turns; the fastest counts.
const REPETITIONS: usize = 200;

const UP: [f32; 3] = [0.0, 0.0, 1.0];

/// The highest order that is timed.
const HIGHEST: usize = 6;

/// Spheres whose factors are made together for sixteen receivers: they stay in the nearest cache.
const TOGETHER: usize = 8;

fn main() {
    println!(
        "                       chain of products    shexp                  irradiance             visibility         sixteen at once"
    );
    println!(
        "ns per receiver       products      whole visibility    ratios      chain    shexp ratio   cut     grouped   products      whole      ratios"
    );
    // In the one thread of a pool: nothing is handed from thread to thread.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.install(|| {
        for order in [3, 4, HIGHEST] {
            let table = LogTable::new(&LogTableOptions::default().order(order)).unwrap();
            for count in [8, 32, 128, 512] {
                row(order, count, &table);
            }
        }
    });
}

fn row(order: usize, count: usize, table: &LogTable) {
    let mut random = Random::new(1);
    let spheres = figure(count, &mut random);
    let positions: Vec<[f32; 3]> =
        (0..RECEIVERS).map(|_| [1.5 + random.signed() as f32, random.signed() as f32, 0.0]).collect();
    let normals = vec![UP; RECEIVERS];
    let receivers = ShadowReceivers::new(&positions, &normals).unwrap();
    let plain = ShadowOptions::default().cut(0.0).share_overlaps(false);
    let all = [plain, ShadowOptions::default(), ShadowOptions::default().group(64)]
        .map(|options| SphereShadows::new(table, &spheres, &options).unwrap());
    let sky = SkyLight::new(&ShL2::constant(Rgb::new(1.0, 1.0, 1.0)), order).unwrap();
    let chain = Chain::new(order, &spheres);
    let factors: Vec<f32> = positions[..CHAINS].iter().flat_map(|p| chain.factors(*p)).collect();
    let blocks = chain.blocks(&positions[..LANES]);
    expect_same(&chain, &positions[..LANES]);
    let mut best = [f64::INFINITY; 9];
    for _ in 0..REPETITIONS {
        let few = &positions[..CHAINS];
        for (best, run) in best.iter_mut().zip([
            &(|| chain.products(&factors)) as &dyn Fn() -> f32,
            &|| few.iter().map(|p| chain.visibility(*p)[0]).sum(),
            &|| few.iter().map(|p| chain.irradiance(*p).r).sum(),
        ]) {
            *best = best.min(seconds(run) / CHAINS as f64);
        }
        for (best, shadows) in best[3..6].iter_mut().zip(&all) {
            *best = best.min(seconds(|| shadows.visibility(black_box(&receivers))) / RECEIVERS as f64);
        }
        best[6] = best[6].min(seconds(|| all[0].irradiance(black_box(&receivers), &sky)) / RECEIVERS as f64);
        best[7] = best[7].min(seconds(|| chain.products_of_blocks(&blocks)) / LANES as f64);
        best[8] = best[8].min(seconds(|| chain.visibility_of_blocks(&positions[..LANES])) / LANES as f64);
    }
    let [products, whole, lit, visibility, cut, grouped, irradiance, together, whole_together] =
        best.map(|seconds| 1e9 * seconds);
    println!(
        "order {order}, {count:3} {products:12.0} {whole:10.0} {visibility:10.0} {:6.1} {:5.1} {lit:9.0} {irradiance:8.0} {:6.1} {cut:7.0} {grouped:8.0} {together:10.0} {whole_together:10.0} {:6.1} {:5.1}",
        products / visibility,
        whole / visibility,
        lit / irradiance,
        together / visibility,
        whole_together / visibility,
    );
}

/// The chain of sixteen receivers at once has the result of the chain of each by itself.
fn expect_same(chain: &Chain<'_>, positions: &[[f32; 3]]) {
    let found = chain.visibility_of_blocks(positions);
    for (lane, p) in positions.iter().enumerate() {
        for (found, expected) in found.iter().zip(chain.visibility(*p)) {
            assert!((found[lane] - expected).abs() < 1e-3, "receiver {lane}: {} and {expected}", found[lane]);
        }
    }
}

fn seconds<T>(run: impl Fn() -> T) -> f64 {
    let start = Instant::now();
    black_box(run());
    start.elapsed().as_secs_f64()
}

/// Spheres of a figure of about two units above the ground: clusters, as limbs are.
fn figure(count: usize, random: &mut Random) -> Vec<Occluder> {
    let limbs: Vec<[f64; 3]> = (0..8).map(|_| [random.signed(), random.signed(), 1.2 + random.unit()]).collect();
    let scale = (16.0 / count as f64).sqrt().min(1.0);
    let sphere = |k: usize, random: &mut Random| {
        let s = random.direction();
        let offset = 0.4 * random.unit();
        let center = [0, 1, 2].map(|c| (limbs[k % limbs.len()][c] + offset * s[c]) as f32);
        Occluder::new(center, (scale * (0.1 + 0.15 * random.unit())) as f32)
    };
    (0..count).map(|k| sphere(k, random)).collect()
}

/// What each sphere leaves visible, multiplied one after the other, a receiver at a time, in single precision.
struct Chain<'a> {
    order: usize,
    spheres: &'a [Occluder],
    basis: Basis<f32>,
    cosine: Vec<f32>,
}

impl<'a> Chain<'a> {
    fn new(order: usize, spheres: &'a [Occluder]) -> Self {
        let cosine = Zonal::clamped_cosine(order).convolution_factors();
        Self { order, spheres, basis: Basis::new(order), cosine: cosine.into_iter().map(|f| f as f32).collect() }
    }

    /// `1 - O` of every sphere: the closed form of a cone by the recurrence of Legendre polynomials, and the basis towards it.
    fn factors(&self, p: [f32; 3]) -> Vec<f32> {
        let n = coefficient_count(self.order);
        let mut out = vec![0.0; n * self.spheres.len()];
        for (sphere, row) in self.spheres.iter().zip(out.chunks_exact_mut(n)) {
            self.factor(sphere, p, row);
        }
        out
    }

    fn factor(&self, sphere: &Occluder, p: [f32; 3], row: &mut [f32]) {
        let to = [0, 1, 2].map(|k| sphere.center[k] - p[k]);
        let inverse = to.iter().map(|c| c * c).sum::<f32>().sqrt().recip();
        let sine = (sphere.radius * inverse).min(1.0);
        let c = (1.0 - sine * sine).sqrt();
        self.basis.eval_into(to.map(|c| c * inverse), row);
        // P_0 to P_n at the rim.
        let mut p = [1.0, c, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        for l in 1..self.order {
            p[l + 1] = ((2 * l + 1) as f32 * c * p[l] - l as f32 * p[l - 1]) / (l + 1) as f32;
        }
        for l in 0..self.order {
            // 2π ∫ P_l dz from the rim to the axis; the factor of y_l towards the axis (Funk and Hecke).
            let integral = if l == 0 { 1.0 - c } else { (p[l - 1] - p[l + 1]) / (2 * l + 1) as f32 };
            row[l * l..(l + 1) * (l + 1)].iter_mut().for_each(|y| *y *= -2.0 * std::f32::consts::PI * integral);
        }
        row[0] += (4.0 * std::f32::consts::PI).sqrt();
    }

    /// Chained products of factors that are there already.
    fn products(&self, factors: &[f32]) -> f32 {
        let n = coefficient_count(self.order);
        let mut sum = 0.0;
        for factors in black_box(factors).chunks_exact(self.spheres.len() * n) {
            let (mut all, mut next) = (factors[..n].to_vec(), vec![0.0; n]);
            for factor in factors.chunks_exact(n).skip(1) {
                product_into(&all, factor, &mut next);
                std::mem::swap(&mut all, &mut next);
            }
            sum += all[0];
        }
        sum
    }

    /// The factors of sixteen receivers side by side: `n²` blocks for each sphere.
    fn blocks(&self, positions: &[[f32; 3]]) -> Vec<Lanes> {
        let factors: Vec<Vec<f32>> = positions.iter().map(|p| self.factors(*p)).collect();
        (0..factors[0].len()).map(|i| Lanes(std::array::from_fn(|lane| factors[lane][i]))).collect()
    }

    /// [`products`](Self::products) of sixteen receivers at once.
    fn products_of_blocks(&self, factors: &[Lanes]) -> f32 {
        let n = coefficient_count(self.order);
        let (mut all, mut next) = (black_box(factors)[..n].to_vec(), vec![Lanes::ZERO; n]);
        for factor in factors.chunks_exact(n).skip(1) {
            product_of_blocks(Machine::detect(), self.order, &all, factor, &mut next);
            std::mem::swap(&mut all, &mut next);
        }
        all[0][0]
    }

    /// The whole [`visibility`](Self::visibility) of sixteen receivers at once: the factors of a few spheres, then their products.
    fn visibility_of_blocks(&self, positions: &[[f32; 3]]) -> Vec<Lanes> {
        let (machine, n) = (Machine::detect(), coefficient_count(self.order));
        let at = [0, 1, 2].map(|axis| Lanes(std::array::from_fn(|lane| black_box(positions)[lane][axis])));
        let (mut all, mut next) = (vec![Lanes::ZERO; n], vec![Lanes::ZERO; n]);
        let mut factors = ShBatch::zero(self.order, TOGETHER * LANES);
        let mut bands = [[Lanes::ZERO; HIGHEST]; TOGETHER];
        let mut towards = [[0.0; TOGETHER * LANES], [0.0; TOGETHER * LANES], [1.0; TOGETHER * LANES]];
        for (first, spheres) in self.spheres.chunks(TOGETHER).enumerate() {
            machine.run(Cones { order: self.order, spheres, at: &at, towards: &mut towards, bands: &mut bands });
            factors.set_basis(&DirBatch::from_components(towards.each_ref().map(<[f32; TOGETHER * LANES]>::as_slice)));
            for (k, (factor, bands)) in
                factors.blocks_mut().chunks_exact_mut(n).zip(&bands).take(spheres.len()).enumerate()
            {
                machine.run(Turned { order: self.order, bands, factor });
                if first + k == 0 {
                    all.copy_from_slice(factor);
                    continue;
                }
                product_of_blocks(machine, self.order, &all, factor, &mut next);
                std::mem::swap(&mut all, &mut next);
            }
        }
        all
    }

    fn visibility(&self, p: [f32; 3]) -> Vec<f32> {
        let n = coefficient_count(self.order);
        let (mut all, mut next, mut factor) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        let Some((first, rest)) = self.spheres.split_first() else { return all };
        self.factor(first, black_box(p), &mut all);
        for sphere in rest {
            self.factor(sphere, p, &mut factor);
            product_into(&all, &factor, &mut next);
            std::mem::swap(&mut all, &mut next);
        }
        all
    }

    /// With the clamped cosine about the normal, and a sky of one color in three channels.
    fn irradiance(&self, p: [f32; 3]) -> Rgb<f32> {
        let visibility = self.visibility(p);
        let (mut cosine, mut seen) = (vec![0.0; visibility.len()], vec![0.0; visibility.len()]);
        self.basis.eval_into(UP, &mut cosine);
        cosine.iter_mut().enumerate().for_each(|(i, y)| *y *= self.cosine[i.isqrt()]);
        product_into(&visibility, &cosine, &mut seen);
        let light = black_box([(4.0 * std::f32::consts::PI).sqrt(); 3]);
        Rgb::new(seen[0] * light[0], seen[0] * light[1], seen[0] * light[2])
    }
}

/// What hides nothing: `√4π y_00 = 1`.
const OPEN: f32 = 3.544_907_7;

/// The directions to some spheres from sixteen receivers, and for each band what the functions towards them are multiplied by in
/// `1 - O`, as in [`Chain::factor`].
struct Cones<'a> {
    order: usize,
    spheres: &'a [Occluder],
    at: &'a [Lanes; 3],
    towards: &'a mut [[f32; TOGETHER * LANES]; 3],
    bands: &'a mut [[Lanes; HIGHEST]; TOGETHER],
}

impl Kernel for Cones<'_> {
    type Output = ();

    #[inline(always)]
    fn wide<S: pulp::Simd>(self, simd: S) {
        for (k, (sphere, bands)) in self.spheres.iter().zip(self.bands).enumerate() {
            for part in 0..Wide::<S>::PARTS {
                let [x, y, z] = [0, 1, 2];
                let x = constant(simd, sphere.center[x]) - Wide::load(simd, &self.at[x], part);
                let y = constant(simd, sphere.center[y]) - Wide::load(simd, &self.at[y], part);
                let z = constant(simd, sphere.center[z]) - Wide::load(simd, &self.at[z], part);
                let inverse = x.times_plus(x, y.times_plus(y, z * z)).inverse_sqrt();
                for (axis, component) in [x, y, z].into_iter().enumerate() {
                    if let Some(place) = self.towards[axis][k * LANES..].get_mut(..LANES) {
                        (component * inverse).store_array(place, part);
                    }
                }
                let sine = (constant(simd, sphere.radius) * inverse).min(constant(simd, 1.0));
                let c = sine.times_from(sine, constant(simd, 1.0)).sqrt();
                let scale = |value: f32| constant(simd, value);
                let (mut before, mut now) = (scale(1.0), c);
                (scale(-2.0 * std::f32::consts::PI) * (scale(1.0) - c)).store(&mut bands[0], part);
                for l in 1..self.order {
                    let next = (scale((2 * l + 1) as f32 / (l + 1) as f32) * c)
                        .times_minus(now, scale(l as f32 / (l + 1) as f32) * before);
                    let factor = scale(-2.0 * std::f32::consts::PI / (2 * l + 1) as f32);
                    (factor * (before - next)).store(&mut bands[l], part);
                    (before, now) = (now, next);
                }
            }
        }
    }

    fn plain(self) {
        for (k, (sphere, bands)) in self.spheres.iter().zip(self.bands).enumerate() {
            for lane in 0..LANES {
                let to = [0, 1, 2].map(|axis| sphere.center[axis] - self.at[axis][lane]);
                let inverse = to.iter().map(|c| c * c).sum::<f32>().sqrt().recip();
                (0..3).for_each(|axis| self.towards[axis][k * LANES + lane] = to[axis] * inverse);
                let sine = (sphere.radius * inverse).min(1.0);
                let c = (1.0 - sine * sine).sqrt();
                let (mut before, mut now) = (1.0, c);
                bands[0][lane] = -2.0 * std::f32::consts::PI * (1.0 - c);
                for l in 1..self.order {
                    let next = ((2 * l + 1) as f32 * c * now - l as f32 * before) / (l + 1) as f32;
                    bands[l][lane] = -2.0 * std::f32::consts::PI / (2 * l + 1) as f32 * (before - next);
                    (before, now) = (now, next);
                }
            }
        }
    }
}

/// The basis towards a sphere becomes `1 - O` of it.
struct Turned<'a> {
    order: usize,
    bands: &'a [Lanes; HIGHEST],
    factor: &'a mut [Lanes],
}

impl Kernel for Turned<'_> {
    type Output = ();

    #[inline(always)]
    fn wide<S: pulp::Simd>(self, simd: S) {
        for part in 0..Wide::<S>::PARTS {
            for (l, band) in self.bands.iter().enumerate().take(self.order) {
                let band = Wide::load(simd, band, part);
                for y in &mut self.factor[l * l..(l + 1) * (l + 1)] {
                    (Wide::load(simd, y, part) * band).store(y, part);
                }
            }
            let first = &mut self.factor[0];
            (Wide::load(simd, first, part) + constant(simd, OPEN)).store(first, part);
        }
    }

    fn plain(self) {
        for (i, y) in self.factor.iter_mut().enumerate() {
            y.0.iter_mut().zip(&self.bands[i.isqrt()].0).for_each(|(y, band)| *y *= band);
        }
        self.factor[0].0.iter_mut().for_each(|y| *y += OPEN);
    }
}
