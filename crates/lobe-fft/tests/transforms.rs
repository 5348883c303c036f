//! Transforms against the sums of their definition.

use std::f64::consts::TAU;

use lobe_fft::{Complex, Registers, Transform};

/// Lengths with and without small factors.
const LENGTHS: [usize; 7] = [1, 2, 15, 17, 64, 97, 360];

fn transformed(row: &[Complex<f64>], registers: Registers) -> Vec<Complex<f64>> {
    let transform = Transform::new(row.len(), registers);
    let mut out = row.to_vec();
    transform.apply(&mut out, &mut transform.scratch());
    out
}

#[test]
fn transforms_are_the_sums_of_their_definition() {
    for length in LENGTHS {
        let row: Vec<_> = (0..length).map(|j| Complex::new((j * j % 7) as f64 - 3.0, (j % 5) as f64)).collect();
        for registers in [Registers::Plain, Registers::Widest] {
            for (k, found) in transformed(&row, registers).into_iter().enumerate() {
                let wave = |j: usize| Complex::cis(-TAU * (j * k % length) as f64 / length as f64);
                let expected: Complex<f64> = row.iter().enumerate().map(|(j, z)| z * wave(j)).sum();
                let error = (found - expected).norm();
                assert!(error < 1e-13 * length as f64, "length {length}, wave {k}: {found} against {expected}");
            }
        }
    }
}

#[test]
#[should_panic(expected = "numbers of a row")]
fn a_row_of_another_length_is_refused() {
    let transform = Transform::new(8, Registers::Widest);
    transform.apply(&mut [Complex::ZERO; 16], &mut transform.scratch());
}
