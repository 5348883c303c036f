//! Bands, orders and the flat index.

/// The highest order (number of bands) that Lobe is tested for.
pub const MAX_ORDER: usize = 256;

/// The flat index `i = l(l+1) + m` of band `l` and `-l <= m <= l`.
#[inline(always)]
#[must_use]
pub const fn coefficient_index(l: usize, m: isize) -> usize {
    debug_assert!(m.unsigned_abs() <= l, "m must lie in -l..=l");
    (l * (l + 1)).strict_add_signed(m)
}

/// The band `l` and `m` of flat index `i`.
#[must_use]
pub const fn band_and_m(i: usize) -> (usize, isize) {
    let l = i.isqrt();
    (l, i as isize - (l * (l + 1)) as isize)
}

/// The number of coefficients of an expansion of order `n`: `n²`.
#[inline(always)]
#[must_use]
pub const fn coefficient_count(order: usize) -> usize {
    order * order
}

/// The order of an expansion of `len` coefficients; `None` if `len` is no perfect square.
#[must_use]
pub const fn order_of(len: usize) -> Option<usize> {
    let n = if len < SMALL_ROOTS.len() { SMALL_ROOTS[len] as usize } else { len.isqrt() };
    if n * n == len { Some(n) } else { None }
}

/// `⌊√len⌋`: for a single expansion of order 8 and below a root takes longer than much of the work.
const SMALL_ROOTS: [u8; 65] = {
    let mut roots = [0; 65];
    let mut len = 0;
    while len < roots.len() {
        roots[len] = len.isqrt() as u8;
        len += 1;
    }
    roots
};

/// The order of a slice of coefficients.
///
/// # Panics
/// If the length is no perfect square.
#[inline]
#[must_use]
pub(crate) fn order_of_slice<T>(coefficients: &[T]) -> usize {
    match order_of(coefficients.len()) {
        Some(order) => order,
        None => panic!("an expansion has n² coefficients, not {}", coefficients.len()),
    }
}

/// The flat indices of band `l`: `l²..(l+1)²`.
#[inline(always)]
#[must_use]
pub const fn band_range(l: usize) -> core::ops::Range<usize> {
    l * l..(l + 1) * (l + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flat_indices_count_up_through_the_bands() {
        let mut i = 0;
        for l in 0..70 {
            assert_eq!(band_range(l), i..i + 2 * l + 1, "band {l}");
            for m in -(l as isize)..=l as isize {
                assert_eq!(coefficient_index(l, m), i, "l {l}, m {m}");
                assert_eq!(band_and_m(i), (l, m), "i {i}");
                i += 1;
            }
        }
    }

    #[test]
    fn only_perfect_squares_have_an_order() {
        assert_eq!([0, 1, 4, 9, 4096].map(order_of), [0, 1, 2, 3, 64].map(Some), "squares");
        assert_eq!([2, 3, 8, 10, 4095].map(order_of), [None; 5], "others");
    }
}
