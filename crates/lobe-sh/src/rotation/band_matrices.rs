//! The matrices of all bands one after the other, from band 0 on, each column after column.

/// The number of entries of bands `0..l`: `Σ (2k+1)² = l(4l² - 1)/3`.
pub(crate) const fn first_entry(l: usize) -> usize {
    if l == 0 { 0 } else { l * (4 * l * l - 1) / 3 }
}

/// The matrix of band `l`.
pub(crate) fn band_columns<S>(columns: &[S], l: usize) -> &[S] {
    &columns[first_entry(l)..first_entry(l + 1)]
}
