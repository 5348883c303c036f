//! Light of the sky, made ready to fall on surfaces that see a part of it.

use lobe_sh::basis::coefficient_count;
use lobe_sh::product::{GauntTensor, MAX_GAUNT_ORDER, ProductMatrix};
use lobe_sh::simd::{Lanes, Machine, Wide, constant};
use lobe_sh::{Coefficient as _, Expansion, Rgb, ShVec, Zonal};
use pulp::{Arch, Simd, WithSimd};

use crate::accumulate::log_table::{MAX_TABLE_ORDER, rotation_factor};
use crate::error::ShadowError;
use crate::lane_basis::LaneBasis;

/// Bands of the clamped cosine at most. The first that is left out, of degree 10, has 0.5 % of the factor of the mean.
const COSINE_BANDS: usize = 9;

/// Channels of light, and one of uniform white, which tells how much of the cosine is hidden.
pub(crate) const CHANNELS: usize = 4;

/// The operator from visibility to irradiance under one sky.
///
/// ```text
///   E(n) = ∫ V L max(n·s, 0) ds = Σ_j A_j y_j(n) Σ_i G_ji V_i        G_ji = Σ_k Γ_jik L_k
/// ```
///
/// `L V` is multiplied out to all its bands and then convolved with the clamped cosine, whose factors `A_l` vanish for odd `l`
/// above 1: the product operator `H(n)` of the clamped cosine ([Sloan 2008], A8) applied to `L`, in the world's frame, for any
/// normal without a table. For visibility and light of their orders it is exact up to band 8 of the cosine.
///
/// [Sloan 2008]: https://www.ppsloan.org/publications/StupidSH36.pdf
#[derive(Clone, Debug)]
pub struct SkyLight {
    order: usize,
    /// The basis of the bands of the product that the clamped cosine is applied to.
    basis: LaneBasis,
    /// The row of the operator for each function of these bands; none where the clamped cosine has no band.
    rows: Vec<Option<usize>>,
    /// `A_j G_ji` for every function, `i`, and channel.
    operator: Vec<[f32; CHANNELS]>,
    /// The light itself, cut off or filled up to the order of the visibility.
    pub(crate) light: Vec<Rgb<f64>>,
}

impl SkyLight {
    /// For visibility of an order from 1 to 8, under `light`, radiance of any order.
    ///
    /// # Errors
    /// [`ShadowError::Options`] for another order of the visibility; [`ShadowError::Invalid`] if the light is not finite.
    pub fn new(light: &impl Expansion<Rgb<f32>>, order: usize) -> Result<Self, ShadowError> {
        if !(1..=MAX_TABLE_ORDER).contains(&order) {
            let message = format!("expected an order from 1 to {MAX_TABLE_ORDER}, found {order}");
            return Err(ShadowError::Options(message));
        }
        let light: Vec<Rgb<f64>> = light.coefficients().iter().map(|c| c.widen()).collect();
        if let Some(i) = light.iter().position(|c| !c.to_array().iter().all(|x| x.is_finite())) {
            let message = format!("expected finite light, found {:?} for coefficient {i}", light[i]);
            return Err(ShadowError::Invalid { place: "light".to_owned(), message });
        }
        let bands = (order + light.len().isqrt()).saturating_sub(1).clamp(1, COSINE_BANDS);
        let cosine = Zonal::clamped_cosine(bands);
        let mut numbers = 0..;
        let rows: Vec<Option<usize>> =
            (0..coefficient_count(bands)).map(|j| if has_cosine(j.isqrt()) { numbers.next() } else { None }).collect();
        let columns = coefficient_count(order);
        let mut operator = vec![[0.0_f64; CHANNELS]; numbers.start * columns];
        products(&light, bands, order, |j, i, products| {
            let Some(row) = rows[j] else { return };
            let factor = cosine.coefficients()[j.isqrt()] * rotation_factor(j.isqrt());
            let entry = &mut operator[row * columns + i];
            entry.iter_mut().zip(products).for_each(|(entry, product)| *entry += factor * product);
        });
        let operator = operator.iter().map(|row: &[f64; CHANNELS]| row.map(|x| x as f32)).collect();
        let mut light = light;
        light.resize(coefficient_count(order), Rgb::ZERO);
        Ok(Self { order, basis: LaneBasis::new(bands), rows, operator, light })
    }

    /// The order of the visibility.
    #[must_use]
    pub fn order(&self) -> usize {
        self.order
    }

    /// The operator, for shaders: each `j` of which it has a row, and that row, `A_j G_ji` for every `i`: red, green, blue, and
    /// what a white sky of radiance 1 has.
    pub fn operator(&self) -> impl Iterator<Item = (usize, &[[f32; 4]])> {
        let n = coefficient_count(self.order);
        let rows = self.rows.iter().enumerate();
        rows.filter_map(move |(j, row)| row.map(|row| (j, &self.operator[row * n..][..n])))
    }

    /// The irradiance of one receiver with the unit normal `normal`, from the `n²` coefficients of what it sees of the sky.
    ///
    /// # Panics
    /// If `visibility` has another order.
    #[must_use]
    pub fn irradiance(&self, normal: [f32; 3], visibility: &[f32]) -> Rgb<f32> {
        assert_eq!(
            visibility.len(),
            coefficient_count(self.order),
            "coefficients against those of order {}",
            self.order
        );
        let blocks: Vec<Lanes> = visibility.iter().map(|v| Lanes::splat(*v)).collect();
        let [r, g, b] = self.irradiance_of_block(Machine::detect().arch(), &normal.map(Lanes::splat), &blocks);
        Rgb::new(r[0], g[0], b[0])
    }

    /// Irradiance of sixteen receivers: of the first `C` of red, green, blue, and that under a white sky of radiance 1.
    pub(crate) fn irradiance_of_block<const C: usize>(
        &self,
        arch: Arch,
        normal: &[Lanes; 3],
        visibility: &[Lanes],
    ) -> [Lanes; C] {
        let mut out = [Lanes::ZERO; C];
        arch.dispatch(Apply { sky: self, normal, visibility, out: &mut out });
        out
    }
}

/// Parts of `∫ y_j y_i L ds` of the three channels of the light and of white, for `j` below `bands` and `i` below `order`: those of each pair add up
/// to it.
fn products(light: &[Rgb<f64>], bands: usize, order: usize, mut add: impl FnMut(usize, usize, [f64; CHANNELS])) {
    let white = (4.0 * std::f64::consts::PI).sqrt();
    // Bands beyond these have no part in products of the other two.
    let used = light.len().isqrt().clamp(1, bands + order - 1);
    if used <= MAX_GAUNT_ORDER {
        for t in GauntTensor::new(bands, order, used).coefficients() {
            let [r, g, b] = light.get(t.k).copied().unwrap_or(Rgb::ZERO).to_array();
            add(t.i, t.j, [r, g, b, if t.k == 0 { white } else { 0.0 }].map(|light| t.value * light));
        }
        return;
    }
    let (all, columns) = (coefficient_count(bands.max(order)), coefficient_count(order));
    for c in 0..CHANNELS {
        let mut channel = ShVec::zero(if c < 3 { used } else { 1 });
        if c < 3 {
            channel.coefficients_mut().iter_mut().zip(light).for_each(|(out, light)| *out = light.to_array()[c]);
        } else {
            channel[0] = white;
        }
        let matrix = ProductMatrix::new(&channel, bands.max(order));
        for (j, products) in matrix.entries().chunks_exact(all).take(coefficient_count(bands)).enumerate() {
            for (i, product) in products[..columns].iter().enumerate() {
                add(j, i, std::array::from_fn(|k| if k == c { *product } else { 0.0 }));
            }
        }
    }
}

/// Whether the clamped cosine has a band.
fn has_cosine(l: usize) -> bool {
    l <= 1 || l.is_multiple_of(2)
}

/// To be compiled for the machine's registers.
struct Apply<'a, const C: usize> {
    sky: &'a SkyLight,
    normal: &'a [Lanes; 3],
    visibility: &'a [Lanes],
    out: &'a mut [Lanes; C],
}

impl<const C: usize> WithSimd for Apply<'_, C> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let n = self.visibility.len();
        for part in 0..Wide::<S>::PARTS {
            let [x, y, z] = self.normal;
            let normal = [Wide::load(simd, x, part), Wide::load(simd, y, part), Wide::load(simd, z, part)];
            let mut basis = [constant(simd, 0.0); COSINE_BANDS * COSINE_BANDS];
            self.sky.basis.for_each(simd, normal, |_, j, y| basis[j] = y);
            let mut sums = [constant(simd, 0.0); C];
            for (row, y) in self.sky.rows.iter().zip(basis) {
                let Some(row) = *row else { continue };
                let mut along = [constant(simd, 0.0); C];
                for (v, entry) in self.visibility.iter().zip(&self.sky.operator[row * n..][..n]) {
                    let v = Wide::load(simd, v, part);
                    for c in 0..C {
                        along[c] = v.times_plus(constant(simd, entry[c]), along[c]);
                    }
                }
                for c in 0..C {
                    sums[c] = y.times_plus(along[c], sums[c]);
                }
            }
            for (sum, out) in sums.iter().zip(self.out.iter_mut()) {
                sum.store(out, part);
            }
        }
    }
}
