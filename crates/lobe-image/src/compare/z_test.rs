//! Statistical z-test of two Monte Carlo pictures for equal means.

use crate::error::ImageError;
use crate::pixel::{IntoPixel, Pixel};

/// Estimated means with their variances, and the degrees of freedom of those.
#[derive(Clone, Copy, Debug)]
pub struct Measured<'a, P = Pixel> {
    /// The means.
    pub means: &'a [P],
    /// The square of the standard error of each mean.
    pub variances: &'a [P],
    /// Degrees of freedom of each variance; infinite for one that is known.
    pub degrees_of_freedom: f64,
}

/// The result of a z-test of two Monte Carlo pictures.
///
/// ```text
///   z = (a - b) / √(v_a + v_b)             each pixel
///   bias      √N mean z                        normal of variance E z² if the means are equal
///   spread    s = Σ z² / (N E z²)              of mean 1; (s^⅓ - 1 + 1/9k) 3 √k is normal of variance 1, k = N (E z²)² / Var z²
/// ```
///
/// A sum of squares is skewed, the more the fewer there are. A gamma distribution of its mean and variance has shape k,
/// and the cube root of one is nearly normal ([Wilson and Hilferty 1931]): the false positive rate is right for few
/// pixels as well as for many (test `few_pixels_are_called_different_as_seldom_as_many`).
///
/// Where variances are estimated from `ν` differences, `z` is distributed after Student with as many degrees of freedom
/// as Welch gives the pair, so `E z² = ν/(ν-2)` and `E z⁴ = 3ν²/((ν-2)(ν-4))`. Pixels that neither picture samples
/// (both variances 0) count if they differ, and then as infinitely far.
///
/// A bias is significant in `mean_z` long before it is in any pixel. Differences that cancel, and underestimated
/// variances, raise `spread`; overestimated variances lower it, which is no failure.
///
/// Means are assumed to be normal: those of few paths that seldom find a sun are not, and fail.
///
/// [Wilson and Hilferty 1931]: https://doi.org/10.1073/pnas.17.12.684
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ZTest {
    /// The number of values compared in one channel.
    pub pixels: usize,
    /// The mean of z for red, green and blue; 0 if there is no bias.
    pub mean_z: [f64; 3],
    /// The probability of a mean that far from 0 by chance.
    pub p_bias: [f64; 3],
    /// The mean of z² as a multiple of its expectation; 1 if the variances are right.
    pub spread: [f64; 3],
    /// The probability of a mean of z² that large by chance.
    pub p_spread: [f64; 3],
}

/// The least degrees of freedom: the variance of Student's z² diverges at 4.
const LEAST_FREEDOM: f64 = 4.5;

impl ZTest {
    /// Compares two pictures pixel by pixel, two sets of receivers one by one.
    ///
    /// # Errors
    /// [`ImageError::Options`] if the lengths differ, nothing is compared, a variance is no number of 0 or more, or
    /// there are fewer than 5 degrees of freedom.
    pub fn new<A: IntoPixel, B: IntoPixel>(a: &Measured<'_, A>, b: &Measured<'_, B>) -> Result<Self, ImageError> {
        let count = a.means.len();
        if count == 0 || [a.variances.len(), b.means.len(), b.variances.len()] != [count; 3] {
            let found = [count, a.variances.len(), b.means.len(), b.variances.len()];
            return Err(ImageError::Options(format!("expected as many means as variances, found {found:?}")));
        }
        let freedom = a.degrees_of_freedom.min(b.degrees_of_freedom);
        if freedom.is_nan() || freedom < LEAST_FREEDOM {
            return Err(ImageError::Options(format!(
                "expected variances of at least 5 degrees of freedom, found {freedom}: take more sets of paths"
            )));
        }
        let mut test = Self { pixels: count, mean_z: [0.0; 3], p_bias: [1.0; 3], spread: [1.0; 3], p_spread: [1.0; 3] };
        for c in 0..3 {
            test.channel(c, a, b)?;
        }
        Ok(test)
    }

    /// Whether chance explains the differences at this level of significance, corrected for six tests (Šidák): all
    /// `p >= 1 - (1 - level)^(1/6)`.
    #[must_use]
    pub fn passes(&self, level: f64) -> bool {
        let each = 1.0 - (1.0 - level).powf(1.0 / 6.0);
        self.p_bias.iter().chain(&self.p_spread).all(|p| *p >= each)
    }

    fn channel<A: IntoPixel, B: IntoPixel>(
        &mut self,
        c: usize,
        a: &Measured<'_, A>,
        b: &Measured<'_, B>,
    ) -> Result<(), ImageError> {
        let (mut sum, mut squares, mut expected, mut scatter) = (0.0, 0.0, 0.0, 0.0);
        for i in 0..self.pixels {
            let (va, vb) = (nth(a.variances, i, c), nth(b.variances, i, c));
            if !(va >= 0.0 && vb >= 0.0) {
                return Err(ImageError::Options(format!("expected variances of 0 or more, found {va} and {vb}")));
            }
            let difference = nth(a.means, i, c) - nth(b.means, i, c);
            let z = if difference == 0.0 { 0.0 } else { difference / (va + vb).sqrt() };
            sum += z;
            squares += z * z;
            if va + vb > 0.0 {
                let v = welch(va, a.degrees_of_freedom, vb, b.degrees_of_freedom);
                // v/(v-2) and 3v²/((v-2)(v-4)) by their reciprocals, which hold for infinity, too.
                let r = v.recip();
                let square = 1.0 / (1.0 - 2.0 * r);
                expected += square;
                scatter += 3.0 * square / (1.0 - 4.0 * r) - square * square;
            }
        }
        self.mean_z[c] = sum / self.pixels as f64;
        if expected > 0.0 {
            self.p_bias[c] = two_sided(sum / expected.sqrt());
            self.spread[c] = squares / expected;
            let shape = expected * expected / scatter;
            let normal = (self.spread[c].cbrt() - 1.0 + 1.0 / (9.0 * shape)) * 3.0 * shape.sqrt();
            self.p_spread[c] = 0.5 * erfc(normal / 2.0_f64.sqrt());
        } else if squares > 0.0 {
            (self.p_bias[c], self.spread[c], self.p_spread[c]) = (0.0, f64::INFINITY, 0.0);
        }
        Ok(())
    }
}

/// Channel `c` of color `i`.
fn nth<P: IntoPixel>(colors: &[P], i: usize, c: usize) -> f64 {
    f64::from(colors[i].into()[c])
}

/// Degrees of freedom of `v_a + v_b` by Welch and Satterthwaite.
fn welch(va: f64, da: f64, vb: f64, db: f64) -> f64 {
    let (part, sum) = (va / (va + vb), va + vb);
    debug_assert!(sum > 0.0, "variances {va} and {vb}");
    (part * part / da + (1.0 - part) * (1.0 - part) / db).recip()
}

fn two_sided(z: f64) -> f64 {
    erfc(z.abs() / 2.0_f64.sqrt())
}

/// The complementary error function `2/√π ∫_x^∞ exp(-t²) dt`, relative error below 1e-10 for `x >= 0`.
///
/// ```text
///   x < 2    1 - 2/√π exp(-x²) Σ_k 2^k x^(2k+1) / (1·3·5···(2k+1))
///   x >= 2   exp(-x²)/√π · 1/(x + ½/(x + 1/(x + 3/2/(x + ...))))
/// ```
fn erfc(x: f64) -> f64 {
    if x < 0.0 {
        return 2.0 - erfc(-x);
    }
    let scale = (-x * x).exp() / std::f64::consts::PI.sqrt();
    if x < 2.0 {
        let (mut term, mut sum, mut k) = (x, x, 1.0);
        while term > 1e-17 * sum {
            term *= 2.0 * x * x / (2.0 * k + 1.0);
            sum += term;
            k += 1.0;
        }
        return 1.0 - 2.0 * scale * sum;
    }
    if x == f64::INFINITY {
        return 0.0;
    }
    let fraction = (1..=80).rev().fold(x, |tail, k| x + 0.5 * f64::from(k) / tail);
    scale / fraction
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_testkit::Random;

    #[test]
    fn the_error_function_has_its_tabulated_values() {
        let cases = [
            (0.0, 1.0),
            (0.5, 0.479_500_122_186_953_5),
            (1.0, 0.157_299_207_050_285_13),
            (2.0, 0.004_677_734_981_047_266),
            (3.0, 2.209_049_699_858_544e-5),
            (5.0, 1.537_459_794_428_035e-12),
        ];
        for (x, expected) in cases {
            assert!((erfc(x) / expected - 1.0).abs() < 1e-10, "erfc({x}) = {}", erfc(x));
            assert!((erfc(-x) - (2.0 - expected)).abs() < 1e-14, "erfc(-{x}) = {}", erfc(-x));
        }
    }

    /// Means of `sets` normal-ish numbers each, with their estimated variance.
    fn sampled(seed: u64, count: usize, sets: usize, bias: f64) -> (Vec<Pixel>, Vec<Pixel>) {
        let mut random = Random::new(seed);
        let one = |_| {
            let (mut sum, mut squares) = ([0.0; 3], [0.0; 3]);
            for _ in 0..sets {
                for c in 0..3 {
                    // The sum of twelve uniform numbers is close to normal, of variance 1.
                    let value = (0..12).map(|_| random.unit()).sum::<f64>() - 6.0 + bias;
                    sum[c] += value;
                    squares[c] += value * value;
                }
            }
            let n = sets as f64;
            let mean = sum.map(|s| s / n);
            let variance: [f64; 3] = std::array::from_fn(|c| (squares[c] / n - mean[c] * mean[c]).max(0.0) / (n - 1.0));
            (mean.map(|c| c as f32), variance.map(|c| c as f32))
        };
        (0..count).map(one).unzip()
    }

    fn test(a: &(Vec<Pixel>, Vec<Pixel>), b: &(Vec<Pixel>, Vec<Pixel>), sets: usize) -> ZTest {
        let of = |(means, variances): &(Vec<Pixel>, Vec<Pixel>)| (means.clone(), variances.clone());
        let ((am, av), (bm, bv)) = (of(a), of(b));
        let degrees_of_freedom = (sets - 1) as f64;
        let a = Measured { means: &am, variances: &av, degrees_of_freedom };
        let b = Measured { means: &bm, variances: &bv, degrees_of_freedom };
        ZTest::new(&a, &b).unwrap()
    }

    #[test]
    fn equal_means_pass_and_a_tenth_of_an_error_in_all_of_them_does_not() {
        let sets = 16;
        let (a, b) = (sampled(1, 4000, sets, 0.0), sampled(2, 4000, sets, 0.0));
        let fair = test(&a, &b, sets);
        assert!(fair.passes(0.01), "{fair:?}");
        // Each standard error is 0.35; the bias is a tenth of it and shows in the mean over 4000.
        let biased = test(&sampled(3, 4000, sets, 0.035), &b, sets);
        assert!(!biased.passes(0.01) && biased.p_spread[1] > 1e-3, "{biased:?}");
        let mut sure = sampled(4, 4000, sets, 0.0);
        sure.1.iter_mut().for_each(|v| *v = v.map(|c| 0.7 * c));
        let too_sure = test(&sure, &b, sets);
        assert!(!too_sure.passes(0.01) && too_sure.spread[0] > 1.1, "{too_sure:?}");
    }

    #[test]
    fn few_pixels_are_called_different_as_seldom_as_many() {
        // Pairs that differ by chance alone: p below a hundredth comes in a hundredth of them, be there 16 pixels or
        // 256. The normal approximation of a sum of 16 squares finds two and a half times as many, and thirty times
        // below 1e-4.
        for (pixels, pairs) in [(16, 1500), (256, 100)] {
            let sets = 16;
            let found = |seed: u64| {
                let of = |k: u64| sampled(1000 * k + seed, pixels, sets, 0.0);
                test(&of(1), &of(9), sets).p_spread.iter().filter(|p| **p < 0.01).count()
            };
            let count = (0..pairs).map(found).sum::<usize>() as f64 / 3.0;
            let expected = 0.01 * pairs as f64;
            let allowed = 4.0 * (expected / 3.0).sqrt();
            assert!(
                (count - expected).abs() < allowed,
                "{count} of {pairs} pairs of {pixels} pixels, expected {expected}"
            );
        }
    }

    #[test]
    fn what_is_not_sampled_counts_if_it_differs() {
        let zero = [[0.0_f32; 3]; 2];
        let mut other = zero;
        let measured = |means| Measured { means, variances: &zero, degrees_of_freedom: f64::INFINITY };
        assert!(ZTest::new(&measured(&zero), &measured(&zero)).unwrap().passes(0.01), "equal");
        other[1] = [0.0, 1e-6, 0.0];
        assert!(!ZTest::new(&measured(&zero), &measured(&other)).unwrap().passes(0.01), "different");
    }

    #[test]
    fn what_cannot_be_tested_is_refused() {
        let one = [[0.0_f32; 3]];
        let few = Measured { means: &one, variances: &one, degrees_of_freedom: 3.0 };
        let found = ZTest::new(&few, &few).unwrap_err().to_string();
        assert!(found.starts_with("expected variances of at least 5 degrees of freedom, found 3"), "{found}");
        let none = Measured { means: &one[..0], variances: &one[..0], degrees_of_freedom: 9.0 };
        assert!(ZTest::new(&none, &none).is_err(), "nothing");
    }
}
