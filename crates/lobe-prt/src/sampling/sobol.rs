//! Sobol' points with Owen scrambling: sequences that fill the unit square evenly.

/// The odd constant of `SplitMix64`, 2⁶⁴ divided by the golden ratio.
const GOLDEN: u64 = 0x9E37_79B9_7F4A_7C15;

/// A bijection of 64 bits that looks random: the finaliser of `SplitMix64` [Steele, Lea and Flood 2014].
pub(crate) fn mix(z: u64) -> u64 {
    let z = z.wrapping_add(GOLDEN);
    let z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// A number that depends on all of `words` and on their order.
pub(crate) fn hash(words: impl IntoIterator<Item = u64>) -> u64 {
    words.into_iter().fold(0, |state, word| mix(state.rotate_left(23) ^ word))
}

/// Randomized sequences of points in the unit square, one for each bounce of a path.
///
/// Each is the two-dimensional sequence of Sobol', scrambled by the method of Owen: of any `2^k` points from the start
/// on, every elementary rectangle of area `2^-k` holds exactly one, and each point by itself is uniform in the square,
/// so that sums over points are unbiased. The scrambling is by a hash [Laine and Karras 2011]; the sequences of later
/// bounces are taken in an order of their own, scrambled alike, so that bounces are independent of each other
/// [Burley 2020]. Tests: `the_first_points_of_any_power_of_two_fill_every_elementary_rectangle`,
/// `each_point_is_uniform_over_the_seeds`.
#[derive(Clone, Debug)]
pub(crate) struct Sobol {
    bounces: Vec<Scramble>,
}

#[derive(Clone, Copy, Debug)]
struct Scramble {
    order: Option<u32>,
    u: u32,
    v: u32,
}

impl Sobol {
    /// The sequences of a place. Equal places, such as vertices along seams of texture coordinates, have equal ones,
    /// and `0` and `-0` are equal.
    pub(crate) fn at_place(seed: u64, place: impl Iterator<Item = f32>, bounces: usize) -> Self {
        let bits = place.map(|c| u64::from((c + 0.0).to_bits()));
        Self::new(hash([seed].into_iter().chain(bits)), bounces)
    }

    /// The sequences that belong to `key`: of the first direction, and of `bounces` more.
    pub(crate) fn new(key: u64, bounces: usize) -> Self {
        let scramble = |bounce: usize| {
            let bits = |k: u64| (mix(key ^ mix(3 * bounce as u64 + k)) >> 32) as u32;
            Scramble { order: (bounce > 0).then(|| bits(0)), u: bits(1), v: bits(2) }
        };
        Self { bounces: (0..=bounces).map(scramble).collect() }
    }

    /// Point number `index` of the sequence of a bounce, in [0, 1)².
    pub(crate) fn point(&self, index: u32, bounce: usize) -> [f32; 2] {
        let Scramble { order, u, v } = self.bounces[bounce];
        let index = order.map_or(index, |seed| scrambled_low_first(index.reverse_bits(), seed).reverse_bits());
        [unit(scrambled_low_first(index, u)), unit(scrambled_low_first(second(index), v))]
    }
}

/// The indices below `count`, in an order in which neighbors lie close together in the square, for all seeds alike:
/// that of a Z-curve through the unscrambled points. Scrambling exchanges halves of elementary intervals and leaves
/// points of one square of the quadtree in one square.
pub(crate) fn coherent_order(count: u32) -> Vec<u32> {
    let spread = |bits: u32| (0..16).fold(0_u32, |z, k| z | (bits >> (16 + k) & 1) << (2 * k));
    let place = |i: &u32| spread(i.reverse_bits()) | spread(second(*i).reverse_bits()) << 1;
    let mut order: Vec<u32> = (0..count).collect();
    order.sort_by_cached_key(place);
    order
}

/// The second coordinate of point `index`, its first binary digit in the lowest place.
///
/// Column j of its matrix is row j of Pascal's triangle modulo 2, and `C(j, i)` is odd if and only if the binary digits
/// of i are among those of j (Lucas): place i is the sum of all places j that contain i, which takes one step for each
/// binary digit of a place.
fn second(index: u32) -> u32 {
    let mut x = index;
    for (shift, mask) in [(1, 0x5555_5555), (2, 0x3333_3333), (4, 0x0F0F_0F0F), (8, 0x00FF_00FF), (16, 0x0000_FFFF)] {
        x ^= (x >> shift) & mask;
    }
    x
}

/// Flips each binary digit by a hash of the digits before it, where the lowest place comes first: every step carries
/// upwards only [Laine and Karras 2011].
fn scrambled_low_first(x: u32, seed: u32) -> u32 {
    let mut x = x.wrapping_add(seed);
    for even in [0x6C50_B47C_u32, 0xB82F_1E52, 0xC7AF_E638, 0x8D22_F6E6] {
        x ^= x.wrapping_mul(even);
    }
    x
}

/// The number in [0, 1) with these binary digits, the lowest place first. 24 of them fit.
fn unit(low_first: u32) -> f32 {
    const ULP: f32 = 1.0 / 16_777_216.0;
    (low_first.reverse_bits() >> 8) as f32 * ULP
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_second_coordinate_is_that_of_its_recurrence() {
        for index in [0, 1, 2, 3, 5, 1023, 0x8000_0001, 0xDEAD_BEEF] {
            let (mut expected, mut column) = (0_u32, 1_u32 << 31);
            for place in 0..32 {
                expected ^= if index >> place & 1 == 1 { column } else { 0 };
                column ^= column >> 1;
            }
            assert_eq!(second(index).reverse_bits(), expected, "index {index}");
        }
    }

    #[test]
    fn the_first_points_of_any_power_of_two_fill_every_elementary_rectangle() {
        let sobol = Sobol::new(7, 2);
        for bounce in 0..3 {
            for k in 0..=8 {
                let points: Vec<_> = (0..1 << k).map(|i| sobol.point(i, bounce)).collect();
                for wide in 0..=k {
                    let (columns, rows) = (1_usize << wide, 1_usize << (k - wide));
                    let mut count = vec![0; columns * rows];
                    for [u, v] in &points {
                        count[(u * columns as f32) as usize * rows + (v * rows as f32) as usize] += 1;
                    }
                    assert!(count.iter().all(|&c| c == 1), "bounce {bounce}, {columns} x {rows}: {count:?}");
                }
            }
        }
    }

    /// χ² of 64 cells has mean 63 and standard deviation 11.2; six of them above is out of reach by chance.
    const MOST_CHI_SQUARE: f64 = 63.0 + 6.0 * 11.2;

    #[test]
    fn each_point_is_uniform_over_the_seeds() {
        const SEEDS: u64 = 6400;
        for bounce in 0..2 {
            for index in [0, 1, 2, 5, 100] {
                let mut count = [0.0; 64];
                let mut mean = [0.0; 2];
                for seed in 0..SEEDS {
                    let p = Sobol::new(hash([1, seed]), 1).point(index, bounce);
                    count[(p[0] * 8.0) as usize * 8 + (p[1] * 8.0) as usize] += 1.0;
                    (0..2).for_each(|k| mean[k] += f64::from(p[k]) / SEEDS as f64);
                }
                let expected = SEEDS as f64 / 64.0;
                let chi_square: f64 = count.iter().map(|c: &f64| (c - expected).powi(2) / expected).sum();
                assert!(chi_square < MOST_CHI_SQUARE, "bounce {bounce}, point {index}: chi² {chi_square} of 64 cells");
                // The mean of 6400 uniform numbers has a standard deviation of 0.0036.
                assert!(mean.iter().all(|m| (m - 0.5).abs() < 6.0 * 0.0036), "point {index}: mean {mean:?}");
            }
        }
    }

    #[test]
    fn bounces_of_one_path_are_independent() {
        let (seeds, points) = (400, 64);
        let mut covariance = 0.0;
        for seed in 0..seeds {
            let sobol = Sobol::new(hash([2, seed]), 1);
            for i in 0..points {
                let centered = |bounce| f64::from(sobol.point(i, bounce)[0]) - 0.5;
                covariance += centered(0) * centered(1) / (seeds as f64 * f64::from(points));
            }
        }
        // Of 25600 products with a standard deviation of 1/12 each.
        assert!(covariance.abs() < 6.0 / 12.0 / 160.0, "covariance {covariance}");
    }

    #[test]
    fn the_coherent_order_keeps_neighbors_close_whatever_the_seed() {
        for count in [1, 7, 256, 1000] {
            let mut sorted = coherent_order(count);
            sorted.sort_unstable();
            assert!(sorted.iter().copied().eq(0..count), "a permutation of {count}");
        }
        let sobol = Sobol::new(3, 0);
        let step = |a: u32, b: u32| {
            let (p, q) = (sobol.point(a, 0), sobol.point(b, 0));
            (p[0] - q[0]).hypot(p[1] - q[1])
        };
        let length = |order: &[u32]| order.windows(2).map(|w| step(w[0], w[1])).sum::<f32>();
        let (ordered, plain) = (length(&coherent_order(1024)), length(&(0..1024).collect::<Vec<_>>()));
        assert!(ordered < 0.12 * plain, "way through the points {ordered}, unordered {plain}");
    }
}
