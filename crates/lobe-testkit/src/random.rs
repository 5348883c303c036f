//! Seeded random numbers, directions and rotations for tests.

/// A small deterministic generator (`SplitMix64`, Steele, Lea and Flood 2014).
#[derive(Clone, Debug)]
pub struct Random {
    state: u64,
}

impl Random {
    /// A generator whose sequence depends on `seed` alone.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self { state: seed }
    }

    /// The next 64 bits.
    pub fn next_u64(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Uniform in `[0, 1)`.
    pub fn unit(&mut self) -> f64 {
        (self.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform in `[-1, 1)`.
    pub fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    /// `count` numbers uniform in `[-1, 1)`.
    pub fn signed_vec(&mut self, count: usize) -> Vec<f64> {
        (0..count).map(|_| self.signed()).collect()
    }

    /// A direction uniform on the sphere.
    pub fn direction(&mut self) -> [f64; 3] {
        let z = self.signed();
        let phi = 2.0 * std::f64::consts::PI * self.unit();
        let r = (1.0 - z * z).sqrt();
        [r * phi.cos(), r * phi.sin(), z]
    }

    /// A unit quaternion `[x, y, z, w]` uniform over all rotations (Shoemake 1992).
    pub fn quaternion(&mut self) -> [f64; 4] {
        let u = self.unit();
        let (sin_a, cos_a) = (2.0 * std::f64::consts::PI * self.unit()).sin_cos();
        let (sin_b, cos_b) = (2.0 * std::f64::consts::PI * self.unit()).sin_cos();
        let (p, q) = ((1.0 - u).sqrt(), u.sqrt());
        [p * sin_a, p * cos_a, q * sin_b, q * cos_b]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Means of 40000 samples of variance at most 1 stay within six standard errors of their expectation.
    const SAMPLES: usize = 40_000;
    const ALLOWED: f64 = 6.0 / 200.0;

    #[test]
    fn directions_and_rotated_axes_have_the_moments_of_uniform_ones() {
        let mut random = Random::new(3);
        let mut sums = [[0.0; 4]; 2];
        for _ in 0..SAMPLES {
            let [x, y, z, w] = random.quaternion();
            // The rotated z axis.
            let turned = [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)];
            for (sum, v) in sums.iter_mut().zip([random.direction(), turned]) {
                for (sum, value) in sum.iter_mut().zip([v[0], v[1], v[2], v[2] * v[2]]) {
                    *sum += value / SAMPLES as f64;
                }
            }
        }
        for [x, y, z, zz] in sums {
            assert!(x.abs().max(y.abs()).max(z.abs()) < ALLOWED, "means {x}, {y}, {z}, expected 0");
            assert!((zz - 1.0 / 3.0).abs() < ALLOWED, "mean of z² {zz}, expected 1/3");
        }
    }

    #[test]
    fn numbers_lie_in_their_interval_and_follow_the_seed() {
        let numbers = Random::new(1).signed_vec(1000);
        assert!(numbers.iter().all(|x| (-1.0..1.0).contains(x)), "in [-1, 1)");
        assert_eq!(numbers, Random::new(1).signed_vec(1000), "equal seeds");
        assert_ne!(numbers, Random::new(2).signed_vec(1000), "other seeds");
    }
}
