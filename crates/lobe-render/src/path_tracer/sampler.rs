//! Random numbers for light transport: Owen-scrambled Sobol' points, the same for any number of threads.

/// A set of paths whose random numbers are stratified: the pairs for each purpose are points of a Sobol' sequence, with
/// an Owen scrambling and a shuffled order of its own.
///
/// The first two dimensions of Sobol's sequence have, in any `2^m` points that begin at a multiple of `2^m`, one point
/// in every rectangle of area `2^-m` whose sides are powers of two. Scrambling makes each point uniform, so sums are
/// unbiased for any number of points; shuffling their order makes pairs independent of each other ([Burley 2020]). Sets
/// of different seeds are independent: the variance of a mean is estimated between sets, not within one.
///
/// [Burley 2020]: https://jcgt.org/published/0009/04/01/
#[derive(Clone, Copy, Debug)]
pub(crate) struct SampleSet {
    seed: u64,
}

/// The numbers of one path, by what they are for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PathNumbers {
    seed: u64,
    index: u32,
}

impl SampleSet {
    /// The set of number `set` at place `place`: a pixel, a receiver.
    pub(crate) fn new(seed: u64, place: u64, set: u64) -> Self {
        Self { seed: mix(mix(mix(seed) ^ place) ^ set) }
    }

    /// The numbers of path `index`.
    pub(crate) fn path(self, index: usize) -> PathNumbers {
        // Beyond 2^32 paths the points would repeat.
        PathNumbers { seed: self.seed, index: index as u32 }
    }
}

impl PathNumbers {
    /// The pair of numbers in `(0, 1)` for `purpose`.
    pub(crate) fn pair(self, purpose: u32) -> [f64; 2] {
        let seed = mix(self.seed ^ u64::from(purpose));
        let more = mix(seed);
        let index = scrambled(self.index, seed as u32);
        [scrambled(index.reverse_bits(), (seed >> 32) as u32), scrambled(second_dimension(index), more as u32)]
            .map(unit)
    }

    /// A number in `(0, 1)` for `purpose`, which no pair has.
    pub(crate) fn one(self, purpose: u32) -> f64 {
        self.pair(purpose)[0]
    }
}

/// The middle of one of `2^32` pieces of `(0, 1)`.
fn unit(bits: u32) -> f64 {
    (f64::from(bits) + 0.5) / 4_294_967_296.0
}

// The second dimension of Sobol's sequence has direction numbers v_k = (1 + t)^k as polynomials over the two numbers 0
// and 1, the highest bit first. So the point of index i(t) = Σ i_k t^k is i(1 + t). As (1 + t)^s = 1 + t^s for a power
// of two s, the substitution is done by halves: (high t^s + low)(1 + t) = high(1 + t) t^s + (high + low)(1 + t).
fn second_dimension(index: u32) -> u32 {
    let mut x = index;
    for (s, low) in [(16, 0x0000_FFFF), (8, 0x00FF_00FF), (4, 0x0F0F_0F0F), (2, 0x3333_3333), (1, 0x5555_5555)] {
        x ^= (x >> s) & low;
    }
    x.reverse_bits()
}

/// Owen's scrambling: each bit is flipped or not depending on the seed and on all higher bits.
///
/// In reversed order the product with an even number does that: a bit of `x ^ x·even` depends on lower bits only. The
/// constants are those of [Vegdahl 2021].
///
/// [Vegdahl 2021]: https://psychopath.io/post/2021_01_30_building_a_better_lk_hash
fn scrambled(bits: u32, seed: u32) -> u32 {
    let mut x = bits.reverse_bits();
    x ^= x.wrapping_mul(0x3D20_ADEA);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6C56);
    x ^= x.wrapping_mul(0x53A2_2864);
    x.reverse_bits()
}

/// The finisher of `SplitMix64` (Steele, Lea and Flood 2014).
fn mix(x: u64) -> u64 {
    let z = x.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_second_dimension_is_the_one_of_pascals_triangle() {
        for index in [0_u32, 1, 2, 3, 5, 100, 0xDEAD_BEEF, u32::MAX] {
            let (mut v, mut expected) = (1_u32 << 31, 0);
            for k in 0..32 {
                if index >> k & 1 == 1 {
                    expected ^= v;
                }
                v ^= v >> 1;
            }
            assert_eq!(second_dimension(index), expected, "index {index}");
        }
    }

    #[test]
    fn every_rectangle_of_the_right_area_holds_one_point() {
        let m = 8;
        for purpose in 0..5 {
            let set = SampleSet::new(1, 2, 3);
            let points: Vec<_> = (0..1 << m).map(|i| set.path(i).pair(purpose)).collect();
            for across in 0..=m {
                let (columns, rows) = ((1 << across) as f64, (1 << (m - across)) as f64);
                let mut seen = vec![0; 1 << m];
                for [u, v] in &points {
                    seen[(u * columns) as usize + (v * rows) as usize * (1 << across)] += 1;
                }
                assert!(seen.iter().all(|&n| n == 1), "purpose {purpose}: {columns} x {rows} cells");
            }
        }
    }

    #[test]
    fn single_points_of_many_sets_are_uniform_and_independent() {
        // Moments of 20 000 numbers lie within six standard errors.
        let count = 20_000;
        let mut sums = [0.0; 5];
        for set in 0..count {
            let path = SampleSet::new(7, 0, set).path(0);
            let ([u, v], [w, _]) = (path.pair(0), path.pair(1));
            for (sum, value) in sums.iter_mut().zip([u, v, u * v, u * w, u * u]) {
                *sum += value / count as f64;
            }
        }
        for (k, expected) in [0.5, 0.5, 0.25, 0.25, 1.0 / 3.0].into_iter().enumerate() {
            let allowed = 6.0 * 0.3 / (count as f64).sqrt();
            assert!((sums[k] - expected).abs() < allowed, "moment {k}: {} against {expected}", sums[k]);
        }
    }
}
