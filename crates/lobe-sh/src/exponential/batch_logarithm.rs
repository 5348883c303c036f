//! Logarithms of many functions at once.

#[cfg(feature = "simd")]
use core::f64::consts::PI;

#[cfg(feature = "simd")]
use pulp::Simd;

use crate::basis::index::coefficient_count;
use crate::batch::sh_batch::ShBatch;
use crate::expansion::{Expansion as _, ShVec};
#[cfg(feature = "simd")]
use crate::exponential::logarithm::slope_of_ln;
use crate::exponential::logarithm::{check_clamp, logarithm};
#[cfg(feature = "simd")]
use crate::product::gaunt::GauntTensor;
use crate::product::gaunt::MAX_GAUNT_ORDER;
use crate::simd::{Kernel, LANES, Lanes, Machine};
#[cfg(feature = "simd")]
use crate::simd::{Wide, rounded};

/// Replaces each function of a batch by its logarithm, which is that of [`logarithm`]: within 1e-6 of its norm (test
/// `logarithms_in_lanes_are_those_of_the_code_for_one`).
///
/// As many functions as a register holds `f64` find the eigenvalues of their product matrices together, by the rotations of Jacobi, in
/// the same order in all of them:
///
/// ```text
///   M ← Jᵀ M J        M_pq = 0 afterwards        t = tan φ = sgn(δ) 2 M_pq/(|δ| + √(δ² + 4 M_pq²)),   δ = M_qq - M_pp
/// ```
///
/// Angles of up to 45° let the sweeps over all pairs converge, at last by squares. `g - 1` is turned along, multiplied by `q` of the
/// eigenvalues, and turned back by the rotations in reverse: no matrix of eigenvectors is made. A function has the same result beside
/// any others, for one that has converged is turned no more. Functions without a logarithm have that of [`logarithm`].
///
/// ```
/// use lobe_sh::batch::ShBatch;
/// use lobe_sh::exponential::{LOG_CLAMP, logarithm, logarithm_batch_in_place};
/// use lobe_sh::{Dir, ShL2, ShVec, Zonal};
///
/// // What a sphere leaves visible of the sky, for two of them.
/// let visible = |towards| &ShVec::constant(3, 1.0_f32) + &Zonal::cone(3, 0.4).towards(towards, -1.0_f32);
/// let mut logarithms = ShBatch::from_functions(&[visible(Dir::Z), visible(Dir::X)]);
/// logarithm_batch_in_place(&mut logarithms, LOG_CLAMP);
///
/// let (of_second, alone) = (logarithms.function::<ShL2<f32>>(1), logarithm(&visible(Dir::X).map(f64::from), LOG_CLAMP));
/// assert!((f64::from(of_second[3]) - alone[3]).abs() < 1e-6, "{of_second:?} {alone:?}");
/// ```
///
/// # Panics
/// If `clamp` is not in `(0, 1]`, or the order is above [`MAX_GAUNT_ORDER`].
pub fn logarithm_batch_in_place(batch: &mut ShBatch, clamp: f64) {
    take_logarithms(Machine::detect(), batch, clamp);
}

fn take_logarithms(machine: Machine, batch: &mut ShBatch, clamp: f64) {
    check_clamp(clamp);
    let (order, count) = (batch.order(), batch.len());
    assert!(order <= MAX_GAUNT_ORDER, "logarithms of batches reach order {MAX_GAUNT_ORDER}, not {order}");
    if order > 0 {
        machine.run(Logarithms { order, count, clamp, blocks: batch.blocks_mut() });
    }
}

struct Logarithms<'a> {
    order: usize,
    /// The functions that there are.
    count: usize,
    clamp: f64,
    blocks: &'a mut [Lanes],
}

impl Kernel for Logarithms<'_> {
    type Output = ();

    #[cfg(feature = "simd")]
    #[inline(always)]
    fn wide<S: Simd>(self, simd: S) {
        let n = coefficient_count(self.order);
        let tensor = GauntTensor::new(self.order, self.order, self.order);
        let mut eigen = Jacobi::new(simd, n);
        for (group, blocks) in self.blocks.chunks_exact_mut(n).enumerate() {
            let functions = LANES.min(self.count - group * LANES);
            for part in 0..functions.div_ceil(S::F64_LANES) {
                eigen.take(&tensor, blocks, part);
                eigen.diagonalize();
                let largest = eigen.apply(self.clamp);
                eigen.store(blocks, part, self.clamp, &largest);
            }
        }
    }

    fn plain(self) {
        let n = coefficient_count(self.order);
        let mut f = ShVec::<f64>::zero(self.order);
        for (group, blocks) in self.blocks.chunks_exact_mut(n).enumerate() {
            for lane in 0..LANES.min(self.count - group * LANES) {
                for (c, block) in f.coefficients_mut().iter_mut().zip(&*blocks) {
                    *c = f64::from(block[lane]);
                }
                let found = logarithm(&f, self.clamp);
                for (block, c) in blocks.iter_mut().zip(found.coefficients()) {
                    block[lane] = *c as f32;
                }
            }
        }
    }
}

/// A function has converged when what is left beside the diagonal is this part of its matrix, as norms: of no concern to numbers of `f32`, however
/// small the clamp, which magnifies it by its inverse at most. Squares are what the last sweeps leave, so that it costs hardly any of them.
#[cfg(feature = "simd")]
const CONVERGED: f64 = 1e-13;

/// Sweeps at most: three to seven were found at orders 2 to 5.
#[cfg(feature = "simd")]
const MOST_SWEEPS: usize = 32;

/// As many `f64` as a register holds.
#[cfg(feature = "simd")]
type Many<S> = Wide<S, f64>;

/// The product matrix of a function in each lane, while it becomes diagonal.
#[cfg(feature = "simd")]
struct Jacobi<S: Simd> {
    simd: S,
    n: usize,
    /// The lower triangle, in rows of `n`.
    matrix: Vec<Many<S>>,
    /// `g - 1`, turned with the matrix; at last the logarithm.
    vector: Vec<Many<S>>,
    /// The cosines and sines of all rotations.
    rotations: Vec<[Many<S>; 2]>,
}

#[cfg(feature = "simd")]
impl<S: Simd> Jacobi<S> {
    #[inline(always)]
    fn new(simd: S, n: usize) -> Self {
        let zero = rounded::<S, f64>(simd, 0.0);
        Self { simd, n, matrix: vec![zero; n * n], vector: vec![zero; n], rotations: Vec::new() }
    }

    /// The place of an entry `M_ij` or `M_ji`.
    #[inline(always)]
    fn place(&self, i: usize, j: usize) -> usize {
        if i < j { j * self.n + i } else { i * self.n + j }
    }

    /// Takes the functions of a part of sixteen.
    #[inline(always)]
    fn take(&mut self, tensor: &GauntTensor, blocks: &[Lanes], part: usize) {
        let (simd, n) = (self.simd, self.n);
        for i in 0..n {
            let mut numbers = [0.0; LANES];
            for (number, c) in numbers.iter_mut().zip(&blocks[i].0[part * S::F64_LANES..][..S::F64_LANES]) {
                *number = f64::from(*c);
            }
            self.vector[i] = Many::load_array(simd, &numbers, 0);
        }
        self.matrix.fill(rounded::<S, f64>(simd, 0.0));
        for t in tensor.coefficients() {
            if t.j <= t.i {
                let entry = &mut self.matrix[t.i * n + t.j];
                *entry = rounded::<S, f64>(simd, t.value).times_plus(self.vector[t.k], *entry);
            }
        }
        self.vector[0] = self.vector[0] - rounded::<S, f64>(simd, (4.0 * PI).sqrt());
        self.rotations.clear();
    }

    /// Turns the matrices until they are diagonal, and the vectors with them.
    #[inline(always)]
    fn diagonalize(&mut self) {
        let (simd, n) = (self.simd, self.n);
        let (zero, one) = (rounded::<S, f64>(simd, 0.0), rounded::<S, f64>(simd, 1.0));
        let [beside, diagonal] = self.squares();
        let enough = rounded::<S, f64>(simd, CONVERGED * CONVERGED) * (beside + diagonal);
        // What is not a number has converged, too.
        let mut goes_on = enough.if_less(beside, one, zero);
        for _ in 0..MOST_SWEEPS {
            if !goes_on.any_above(zero) {
                break;
            }
            for q in 1..n {
                for p in 0..q {
                    self.rotate(p, q, goes_on);
                }
            }
            let [beside, _] = self.squares();
            goes_on = enough.if_less(beside, goes_on, zero);
        }
    }

    /// The squares of the entries beside the diagonal, summed, and of those on it.
    #[inline(always)]
    fn squares(&self) -> [Many<S>; 2] {
        let zero = rounded::<S, f64>(self.simd, 0.0);
        let (mut beside, mut diagonal) = (zero, zero);
        for i in 0..self.n {
            for j in 0..i {
                let entry = self.matrix[i * self.n + j];
                beside = entry.times_plus(entry, beside);
            }
            let entry = self.matrix[i * self.n + i];
            diagonal = entry.times_plus(entry, diagonal);
        }
        [beside + beside, diagonal]
    }

    /// Makes `M_pq` zero, `p < q`, where it goes on.
    #[inline(always)]
    fn rotate(&mut self, p: usize, q: usize, goes_on: Many<S>) {
        let (simd, n) = (self.simd, self.n);
        let (zero, one) = (rounded::<S, f64>(simd, 0.0), rounded::<S, f64>(simd, 1.0));
        let (entry, first, second) = (self.matrix[q * n + p], self.matrix[p * n + p], self.matrix[q * n + q]);
        let (gap, twice) = (second - first, entry + entry);
        let reach = gap.max(gap.negated()) + gap.times_plus(gap, twice * twice).sqrt();
        let tangent = zero.if_less(reach, gap.sign() * twice / reach, zero);
        let tangent = zero.if_less(goes_on, tangent, zero);
        let cos = tangent.times_plus(tangent, one).sqrt().recip();
        let sin = tangent * cos;
        self.matrix[p * n + p] = tangent.times_from(entry, first);
        self.matrix[q * n + q] = tangent.times_plus(entry, second);
        self.matrix[q * n + p] = zero.if_less(goes_on, zero, entry);
        for k in 0..n {
            if k == p || k == q {
                continue;
            }
            let (i, j) = (self.place(k, p), self.place(k, q));
            let (x, y) = (self.matrix[i], self.matrix[j]);
            self.matrix[i] = sin.times_from(y, cos * x);
            self.matrix[j] = sin.times_plus(x, cos * y);
        }
        let (x, y) = (self.vector[p], self.vector[q]);
        self.vector[p] = sin.times_from(y, cos * x);
        self.vector[q] = sin.times_plus(x, cos * y);
        self.rotations.push([cos, sin]);
    }

    /// Multiplies by `q` of the eigenvalues, and turns back. Returns the largest eigenvalue of each.
    #[inline(always)]
    fn apply(&mut self, clamp: f64) -> [f64; LANES] {
        let (simd, n) = (self.simd, self.n);
        let mut top = self.matrix[0];
        for i in 1..n {
            top = top.max(self.matrix[i * n + i]);
        }
        let mut largest = [0.0; LANES];
        top.store_array(&mut largest, 0);
        for i in 0..n {
            let mut factors = [0.0; LANES];
            self.matrix[i * n + i].store_array(&mut factors, 0);
            for lane in 0..S::F64_LANES {
                factors[lane] = slope_of_ln(factors[lane].max(clamp * largest[lane]));
            }
            self.vector[i] = self.vector[i] * Many::load_array(simd, &factors, 0);
        }
        let mut left = self.rotations.len();
        while left > 0 {
            for q in (1..n).rev() {
                for p in (0..q).rev() {
                    left -= 1;
                    let [cos, sin] = self.rotations[left];
                    let (x, y) = (self.vector[p], self.vector[q]);
                    self.vector[p] = sin.times_plus(y, cos * x);
                    self.vector[q] = sin.times_from(x, cos * y);
                }
            }
        }
        largest
    }

    /// Puts the logarithms in the place of the functions.
    #[inline(always)]
    fn store(&self, blocks: &mut [Lanes], part: usize, clamp: f64, largest: &[f64; LANES]) {
        let first = part * S::F64_LANES;
        let mut without = [None; LANES];
        for lane in 0..S::F64_LANES {
            without[lane] = without_matrix(blocks, first + lane, clamp, largest[lane]);
        }
        for i in 0..self.n {
            let mut numbers = [0.0; LANES];
            self.vector[i].store_array(&mut numbers, 0);
            for lane in 0..S::F64_LANES {
                let number = match without[lane] {
                    None => numbers[lane],
                    Some([first, _]) if i == 0 => first,
                    Some([_, rest]) => rest,
                };
                blocks[i][first + lane] = number as f32;
            }
        }
    }
}

/// The first coefficient and the others of a logarithm that does not come from eigenvalues: of a function that is not finite, or has no positive one.
#[cfg(feature = "simd")]
fn without_matrix(blocks: &[Lanes], lane: usize, clamp: f64, largest: f64) -> Option<[f64; 2]> {
    if !blocks.iter().all(|block| block[lane].is_finite()) {
        return Some([f64::NAN; 2]);
    }
    (largest <= 0.0).then(|| [clamp.ln() * (4.0 * PI).sqrt(), 0.0])
}

#[cfg(test)]
mod tests {
    use lobe_testkit::Random;

    use super::*;
    use crate::expansion::Zonal;
    use crate::exponential::logarithm::LOG_CLAMP;
    use crate::sphere::Dir;

    /// What logarithms in `f32` may be off, as a part of their norm: the rounding of each coefficient, and some more.
    const TOLERANCE: f64 = 1e-6;

    /// What cones leave visible.
    fn visible(order: usize, cones: usize, random: &mut Random) -> ShVec<f32> {
        let mut f = ShVec::constant(order, 1.0_f32);
        for _ in 0..cones {
            let cone = Zonal::cone(order, 0.1 + 1.4 * random.unit());
            f += &cone.towards(Dir::from_unit(random.direction()), -1.0);
        }
        f
    }

    /// Visibilities, noise that is negative in places, and what is tiny, large, or has no logarithm.
    fn functions(order: usize, count: usize, seed: u64) -> Vec<ShVec<f32>> {
        let mut random = Random::new(seed);
        let mut function = |k: usize| {
            let f = visible(order, k % 4, &mut random);
            match k % 12 {
                6 => ShVec::from_vec(random.signed_vec(order * order)).unwrap().map(|c: f64| c as f32),
                7 => ShVec::constant(order, 0.0),
                8 => ShVec::constant(order, -2.0),
                9 => ShVec::constant(order, 0.25),
                10 => f.map(|c| 1e-20 * c),
                11 => f.map(|c| 1e20 * c),
                _ => f,
            }
        };
        (0..count).map(&mut function).collect()
    }

    fn alone(f: &ShVec<f32>, clamp: f64) -> ShVec<f64> {
        logarithm(&f.map(f64::from), clamp)
    }

    #[test]
    fn logarithms_in_lanes_are_those_of_the_code_for_one() {
        for (order, count) in [(1, 25), (2, 37), (3, 40), (4, 33), (5, 17), (6, 12), (8, 3)] {
            for clamp in [LOG_CLAMP, 1e-4, 1.0] {
                let functions = functions(order, count, order as u64);
                for machine in Machine::available() {
                    let mut batch = ShBatch::from_functions(&functions);
                    take_logarithms(machine, &mut batch, clamp);
                    for (k, (found, f)) in batch.to_functions().iter().zip(&functions).enumerate() {
                        let expected = alone(f, clamp);
                        let off = &found.map(f64::from) - &expected;
                        let [off, norm] = [&off, &expected].map(|f| f.dot(f).sqrt());
                        let name = format!("{}, order {order}, clamp {clamp}, function {k}", machine.name());
                        assert!(off <= TOLERANCE * norm, "{name}: off by {off} of {norm}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_function_has_one_logarithm_beside_any_others() {
        for (order, count) in [(2, 20), (3, 33), (4, 18)] {
            let functions = functions(order, count, 5);
            for machine in Machine::available() {
                let mut together = ShBatch::from_functions(&functions);
                take_logarithms(machine, &mut together, LOG_CLAMP);
                for (k, (f, beside)) in functions.iter().zip(together.to_functions()).enumerate() {
                    let mut single = ShBatch::from_functions(std::slice::from_ref(f));
                    take_logarithms(machine, &mut single, LOG_CLAMP);
                    assert_eq!(single.to_functions(), [beside], "{}, order {order}, function {k}", machine.name());
                }
            }
        }
    }

    #[test]
    fn what_is_not_finite_has_no_logarithm_and_leaves_its_neighbors_theirs() {
        let functions = functions(3, 16, 9);
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            for machine in Machine::available() {
                let mut good = ShBatch::from_functions(&functions);
                let mut spoiled = functions.clone();
                spoiled[5][4] = bad;
                let mut batch = ShBatch::from_functions(&spoiled);
                take_logarithms(machine, &mut batch, LOG_CLAMP);
                take_logarithms(machine, &mut good, LOG_CLAMP);
                for (k, (found, expected)) in batch.to_functions().into_iter().zip(good.to_functions()).enumerate() {
                    let name = format!("{}, {bad}, function {k}", machine.name());
                    if k == 5 {
                        assert!(found.coefficients().iter().all(|c| c.is_nan()), "{name}: {found:?}");
                    } else {
                        assert_eq!(found, expected, "{name}");
                    }
                }
            }
        }
    }

    #[test]
    fn batches_of_nothing_stay_as_they_are() {
        for (order, count) in [(0, 3), (3, 0), (0, 0)] {
            let mut batch = ShBatch::zero(order, count);
            logarithm_batch_in_place(&mut batch, LOG_CLAMP);
            assert_eq!(batch, ShBatch::zero(order, count), "{count} functions of order {order}");
        }
    }

    #[test]
    #[should_panic(expected = "reach order 10, not 11")]
    fn orders_without_gaunt_coefficients_are_refused() {
        logarithm_batch_in_place(&mut ShBatch::zero(11, 1), LOG_CLAMP);
    }
}
