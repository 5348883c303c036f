//! Symmetric eigenvalue problem: the largest eigenvalues and their eigenvectors, by block Krylov
//! iteration or by decomposing the whole.

use nalgebra::{DMatrix, SymmetricEigen};

use crate::sampling::sobol::mix;

/// Eigenvalues below this part of the trace are rounding. The covariance of `f64` sums has errors of some 1e-16, the
/// rows are `f32`.
pub(crate) const RANK_TOLERANCE: f64 = 1e-15;

/// A matrix of fewer rows than this many Krylov spaces have directions is decomposed as a whole, in some 10 n³
/// operations.
const WORTHWHILE: usize = 3;

/// Vectors that are followed beside those wanted: the last of these converge as fast as the first of those that are
/// left out are small.
const SPARE: usize = 4;

/// Products with the matrix between two solutions.
const STEPS: usize = 3;

/// `|A v - λ v|` at most, as a part of the trace. The error of λ is no larger, and at most its square over the distance
/// to the next eigenvalue that is left out.
const RESIDUAL: f64 = 1e-10;

/// The most restarts; a matrix that takes more is decomposed as a whole.
const RESTARTS: usize = 30;

/// Eigenvalues and eigenvectors of a symmetric matrix given by its upper half, the largest first, at most `count`,
/// those that are rounding left out.
pub(crate) fn leading(upper: &[f64], size: usize, count: usize) -> (Vec<f64>, Vec<f64>) {
    let at = |i: usize, j: usize| upper[i.min(j) * size + i.max(j)];
    let trace: f64 = (0..size).map(|i| at(i, i)).sum();
    if trace <= 0.0 {
        return (Vec::new(), Vec::new());
    }
    // Of the size of 1, so that nothing under- or overflows in the iteration.
    let matrix: Vec<f64> = (0..size * size).map(|k| at(k / size, k % size) / trace).collect();
    let krylov = (STEPS + 1) * (count + SPARE);
    let found = if WORTHWHILE * krylov <= size { by_krylov(&matrix, size, count) } else { None };
    let (values, vectors) = found.unwrap_or_else(|| whole(matrix, size, count));
    let rank = values.iter().take_while(|value| **value > RANK_TOLERANCE).count();
    let vectors = vectors.chunks_exact(size).take(rank).flat_map(|v| v.iter().map(|x| x * sign_of(v)));
    (values.iter().take(rank).map(|value| value * trace).collect(), vectors.collect())
}

/// The leading eigenvalues and eigenvectors by decomposing the whole matrix, which is given column after column.
fn whole(matrix: Vec<f64>, size: usize, count: usize) -> (Vec<f64>, Vec<f64>) {
    let eigen = SymmetricEigen::new(DMatrix::from_vec(size, size, matrix));
    let (values, vectors) = (eigen.eigenvalues.as_slice(), eigen.eigenvectors.as_slice());
    let order = largest_first(values, count);
    let of_order = order.iter().flat_map(|i| &vectors[i * size..][..size]);
    (order.iter().map(|i| values[*i]).collect(), of_order.copied().collect())
}

/// The places of the largest values.
fn largest_first(values: &[f64], count: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*b].total_cmp(&values[*a]));
    order.truncate(count);
    order
}

/// By block Krylov spaces with restarts [Golub and Underwood 1977]: `X, A X, .. A³ X` is made orthonormal, the small
/// matrix of A in these directions is decomposed, and its leading vectors are the next X. A block finds eigenvalues
/// that are equal. None if they are too close together to be found soon.
fn by_krylov(matrix: &[f64], size: usize, count: usize) -> Option<(Vec<f64>, Vec<f64>)> {
    let mut block = start(count + SPARE, size);
    for _ in 0..RESTARTS {
        // Build an orthonormal basis of the block Krylov space.
        let (basis, images) = krylov(matrix, size, &block);
        // Decompose the matrix projected onto it (Rayleigh and Ritz).
        let m = basis.len() / size;
        let product = |i: usize, j: usize| dot(&basis[i * size..][..size], &images[j * size..][..size]);
        let projected = (0..m * m).map(|k| product(k % m, k / m)).collect();
        let (values, parts) = whole(projected, m, count + SPARE);
        // Combine the leading Ritz vectors.
        let combined = |vectors: &[f64], k: usize| {
            let mut sum = vec![0.0; size];
            for (part, v) in parts[k * m..][..m].iter().zip(vectors.chunks_exact(size)) {
                sum.iter_mut().zip(v).for_each(|(sum, v)| *sum += part * v);
            }
            sum
        };
        let vectors: Vec<Vec<f64>> = (0..values.len()).map(|k| combined(&basis, k)).collect();
        // End when the residuals of all wanted vectors are small.
        let is_found = (0..count.min(values.len())).all(|i| {
            let image = combined(&images, i);
            let squares = image.iter().zip(&vectors[i]).map(|(a, v)| (a - values[i] * v).powi(2));
            squares.sum::<f64>().sqrt() <= RESIDUAL
        });
        if is_found {
            let vectors = vectors.into_iter().take(count).flatten().collect();
            return Some((values.into_iter().take(count).collect(), vectors));
        }
        // Restart from the Ritz vectors.
        block = vectors.into_iter().flatten().collect();
    }
    None
}

/// Vectors with a part along every eigenvector, always the same.
fn start(count: usize, size: usize) -> Vec<f64> {
    let number = |k: usize| (mix(k as u64) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0;
    (0..count * size).map(number).collect()
}

/// An orthonormal basis of `X, A X, .. A³ X`, and the product of the matrix with each of its vectors.
fn krylov(matrix: &[f64], size: usize, block: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let (mut basis, mut images): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
    let mut next = block.to_vec();
    for _ in 0..=STEPS {
        let before = basis.len();
        for v in next.chunks_exact(size) {
            if let Some(v) = orthonormalized(v.to_vec(), &basis) {
                basis.extend(v);
            }
        }
        next = products(matrix, size, &basis[before..]);
        images.extend(&next);
    }
    (basis, images)
}

/// The matrix times each of some vectors; a row of it is read once for all of them.
fn products(matrix: &[f64], size: usize, vectors: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; vectors.len()];
    for (i, row) in matrix.chunks_exact(size).enumerate() {
        for (k, v) in vectors.chunks_exact(size).enumerate() {
            out[k * size + i] = dot(row, v);
        }
    }
    out
}

/// An eigenvector and its negative are the same; we take the one whose largest element is positive.
fn sign_of(v: &[f64]) -> f64 {
    let largest = v.iter().copied().fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
    if largest < 0.0 { -1.0 } else { 1.0 }
}

/// Gram and Schmidt, twice for the digits; none if nothing of the vector is left.
pub(crate) fn orthonormalized(mut v: Vec<f64>, bases: &[f64]) -> Option<Vec<f64>> {
    let before = dot(&v, &v);
    for _ in 0..2 {
        for b in bases.chunks_exact(v.len()) {
            let along = dot(&v, b);
            v.iter_mut().zip(b).for_each(|(v, b)| *v -= along * b);
        }
    }
    let length = dot(&v, &v).sqrt();
    if length * length <= RANK_TOLERANCE * before || length == 0.0 {
        return None;
    }
    let scale = sign_of(&v) / length;
    v.iter_mut().for_each(|x| *x *= scale);
    Some(v)
}

/// In four partial sums, whatever the machine.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (a, a_rest) = a.as_chunks::<4>();
    let (b, b_rest) = b.as_chunks::<4>();
    let mut sums = [0.0; 4];
    for (a, b) in a.iter().zip(b) {
        for k in 0..4 {
            sums[k] += a[k] * b[k];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    ((sums[0] + sums[2]) + (sums[1] + sums[3])) + rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_testkit::Random;

    /// A symmetric matrix of 256 with these eigenvalues, the others 0.
    fn planted(values: &[f64], seed: u64) -> Vec<f64> {
        let mut random = Random::new(seed);
        let mut vectors: Vec<f64> = Vec::new();
        for _ in values {
            let v = orthonormalized(random.signed_vec(256), &vectors).unwrap();
            vectors.extend(v);
        }
        let at = |i: usize, j: usize| -> f64 {
            values.iter().zip(vectors.chunks_exact(256)).map(|(value, v)| value * v[i] * v[j]).sum()
        };
        (0..256 * 256).map(|k| at(k / 256, k % 256)).collect()
    }

    #[test]
    fn planted_eigenvalues_are_found_in_large_matrices_equal_ones_too() {
        for (name, values) in [
            ("few", vec![5.0, 2.0, 1.0, 1e-3]),
            ("equal", vec![2.0, 2.0, 2.0, 2.0, 2.0, 1.0, 1.0, 1.0, 0.5]),
            ("of many sizes", vec![1.0, 1e-4, 1e-8]),
            ("slowly falling", (0..100).map(|k| 3.0 * 0.9_f64.powi(k)).collect()),
        ] {
            let (matrix, trace) = (planted(&values, 7), values.iter().sum::<f64>());
            for count in [1, 4, 8] {
                assert!(WORTHWHILE * (STEPS + 1) * (count + SPARE) <= 256, "it is not decomposed as a whole");
                let (found, vectors) = leading(&matrix, 256, count);
                let expected = &values[..count.min(values.len())];
                assert_eq!(found.len(), expected.len(), "{name}, {count} of {expected:?}: {found:?}");
                for (a, b) in found.iter().zip(expected) {
                    assert!((a - b).abs() < 1e-13 * trace, "{name}, {count}: {a}, expected {b}");
                }
                for (k, v) in vectors.chunks_exact(256).enumerate() {
                    let image = products(&matrix, 256, v);
                    let rest = image.iter().zip(v).map(|(a, v)| (a - found[k] * v).powi(2));
                    let rest = rest.sum::<f64>().sqrt();
                    assert!(rest < 2.0 * RESIDUAL * trace, "{name}, {count}: A v - λ v of vector {k} is {rest}");
                    let along = (0..=k).map(|j| dot(v, &vectors[j * 256..][..256]) - f64::from(u8::from(j == k)));
                    let worst = along.map(f64::abs).fold(0.0, f64::max);
                    assert!(worst < 1e-12, "{name}, {count}: vector {k} is orthonormal to {worst}");
                }
            }
        }
    }
}
