//! Numbers that look random and are the same in every run.

/// 2⁶⁴ divided by the golden ratio, odd.
pub(crate) const GOLDEN: u64 = 0x9E37_79B9_7F4A_7C15;

/// A bijection of 64 bits that looks random: a step and the finalizer of `SplitMix64` (Steele, Lea and Flood 2014).
pub(crate) fn mix(z: u64) -> u64 {
    let z = z.wrapping_add(GOLDEN);
    let z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// The number in `[0, 1)` of the 53 highest bits.
pub(crate) fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 / (1_u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_numbers_are_those_of_the_published_generator() {
        // Of seed 0, by the code of Vigna that accompanies the paper.
        for (place, expected) in
            [0xE220_A839_7B1D_CDAF, 0x6E78_9E6A_A1B9_65F4, 0x06C4_5D18_8009_454F].into_iter().enumerate()
        {
            let found = mix((place as u64).wrapping_mul(GOLDEN));
            assert_eq!(found, expected, "number {place}");
        }
    }

    #[test]
    fn numbers_lie_between_0_and_1_and_their_mean_is_a_half() {
        const COUNT: u32 = 4096;
        assert_eq!((unit(0), unit(u64::MAX) < 1.0), (0.0, true), "the ends");
        let numbers = || (0..u64::from(COUNT)).map(|k| unit(mix(k)));
        let mean = numbers().sum::<f64>() / f64::from(COUNT);
        // Five standard deviations of the mean of so many.
        assert!((mean - 0.5).abs() < 5.0 / (12.0 * f64::from(COUNT)).sqrt(), "{mean}");
    }
}
