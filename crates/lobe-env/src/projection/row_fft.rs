//! Discrete Fourier transform along pairs of rows of a lat-long picture by FFT, and its inverse.

use lobe_fft::{Complex, Registers, Transform};
use lobe_sh::simd::Machine;
use lobe_sh::{Coefficient, Real as _};

use crate::mapping::lat_long::sin_cos_pi;
use crate::projection::row_dft::RowSums;

// Two real rows u and v are one complex row z = u + iv. Its transform Z has those of both:
//
//     U_m = (Z_m + Z*_{w-m})/2        V_m = (Z_m - Z*_{w-m})/(2i)
//
// The columns lie at φ_x = π (w - 2x - 1)/w, so that Σ_x u(x) e^{imφ_x} = t_m U_m, t_m = e^{iπm(w - 1)/w}; and
// Σ_m A_m cos mφ_x + B_m sin mφ_x = Re Σ_m (A_m - iB_m) t_m e^{-2πimx/w}, half of which each of m and w - m gives.

/// Channels of a color.
const MOST_CHANNELS: usize = 3;

/// The transform of rows of one width, waves `m < order`.
pub(crate) struct RowFft {
    transform: Transform,
    waves: Vec<Wave>,
}

/// `t_m/2`, and the places of `m` and `w - m` in the transform.
struct Wave {
    turn: Complex<f64>,
    at: usize,
    mirrored: usize,
}

impl RowFft {
    /// By the widest registers, unless `LOBE_SIMD` forbids them.
    pub(crate) fn new(width: usize, order: usize) -> Self {
        let registers = if Machine::detect().is_plain() { Registers::Plain } else { Registers::Widest };
        let wave = |m: usize| {
            // Reduced to a turn in integers: no digit is lost for any m.
            let step = (m as i128 * (width as i128 - 1)).rem_euclid(2 * width as i128);
            let (sin, cos) = sin_cos_pi(step as f64 / width as f64);
            Wave { turn: 0.5 * Complex::new(cos, sin), at: m % width, mirrored: (width - m % width) % width }
        };
        Self { transform: Transform::new(width, registers), waves: (0..order).map(wave).collect() }
    }

    /// `Σ_x L(x) cos mφ_x` and `Σ_x L(x) sin mφ_x` of two rows.
    pub(crate) fn sums_into<C: Coefficient>(
        &self,
        rows: [&[C]; 2],
        sums: [&mut RowSums<C::Wide>; 2],
        work: &mut FftWork,
    ) {
        for (c, channel) in work.channels.iter_mut().enumerate() {
            for ((u, v), z) in rows[0].iter().zip(rows[1]).zip(channel) {
                *z = Complex::new(u.channel(c).to_f64(), v.channel(c).to_f64());
            }
        }
        self.transform(work);
        let [upper, lower] = sums;
        for ((wave, upper), lower) in self.waves.iter().zip(upper).zip(lower) {
            // Of each channel the sums of both rows.
            let mut parts = [[Complex::new(0.0, 0.0); 2]; MOST_CHANNELS];
            for (parts, z) in parts.iter_mut().zip(&work.channels) {
                let (z, mirrored) = (z[wave.at], z[wave.mirrored].conj());
                let (u, v) = (z + mirrored, mirrored - z);
                *parts = [u * wave.turn, Complex::new(-v.im, v.re) * wave.turn];
            }
            for (row, out) in [upper, lower].into_iter().enumerate() {
                *out = [C::Wide::from_channels(|c| parts[c][row].re), C::Wide::from_channels(|c| parts[c][row].im)];
            }
        }
    }

    /// `Σ_m A_m cos mφ_x + B_m sin mφ_x` into every texel of two rows; `waves` are the `[A_m, B_m]` of each.
    pub(crate) fn synthesize_into<C: Coefficient>(
        &self,
        waves: [&RowSums<C::Wide>; 2],
        rows: [&mut [C]; 2],
        work: &mut FftWork,
    ) {
        for (c, z) in work.channels.iter_mut().enumerate() {
            z.fill(Complex::new(0.0, 0.0));
            for ((&Wave { turn, at, mirrored }, u), v) in self.waves.iter().zip(waves[0]).zip(waves[1]) {
                let of_row = |row: &[C::Wide; 2]| Complex::new(row[0].channel(c), -row[1].channel(c)) * turn;
                let (u, v) = (of_row(u), of_row(v));
                z[at] += Complex::new(u.re - v.im, u.im + v.re);
                z[mirrored] += Complex::new(u.re + v.im, v.re - u.im);
            }
        }
        self.transform(work);
        let [upper, lower] = rows;
        let channels = &work.channels;
        for (x, (u, v)) in upper.iter_mut().zip(lower).enumerate() {
            *u = C::from_channels(|c| C::Scalar::from_f64(channels[c][x].re));
            *v = C::from_channels(|c| C::Scalar::from_f64(channels[c][x].im));
        }
    }

    fn transform(&self, work: &mut FftWork) {
        for channel in &mut work.channels {
            self.transform.apply(channel, &mut work.scratch);
        }
    }

    /// Room for one thread and rows of some channels.
    pub(crate) fn work(&self, channels: usize) -> FftWork {
        let row = vec![Complex::ZERO; self.transform.length()];
        FftWork { channels: vec![row; channels], scratch: self.transform.scratch() }
    }
}

/// The scratch space of one thread.
pub(crate) struct FftWork {
    /// Two rows of each channel.
    channels: Vec<Vec<Complex<f64>>>,
    scratch: Vec<Complex<f64>>,
}

#[cfg(test)]
mod tests {
    use lobe_sh::Rgb;
    use lobe_testkit::Random;

    use super::*;
    use crate::projection::row_dft::RowDft;

    fn random_row(width: usize, seed: u64) -> Vec<Rgb<f32>> {
        let mut random = Random::new(seed);
        (0..width).map(|_| Rgb::from([(); 3].map(|()| random.signed() as f32))).collect()
    }

    #[test]
    fn both_rows_have_their_direct_sums() {
        for (width, order) in [(1, 5), (2, 7), (3, 1), (17, 40), (64, 33), (1000, 256)] {
            let rows = [random_row(width, 1), random_row(width, 2)];
            let fft = RowFft::new(width, order);
            let mut sums = [vec![[Rgb::ZERO; 2]; order], vec![[Rgb::ZERO; 2]; order]];
            let [upper, lower] = &mut sums;
            fft.sums_into([&rows[0], &rows[1]], [upper, lower], &mut fft.work(3));
            for (row, sums) in rows.iter().zip(&sums) {
                let mut expected = vec![[Rgb::ZERO; 2]; order];
                RowDft::new(width, order).add_sums(&[row], &mut expected);
                for (m, (found, expected)) in sums.iter().zip(&expected).enumerate() {
                    let error = (0..2).flat_map(|part| (found[part] - expected[part]).to_array());
                    let error = error.fold(0.0_f64, |worst, e| worst.max(e.abs()));
                    assert!(error < 1e-14 * width as f64, "width {width}, m {m}: {found:?} against {expected:?}");
                }
            }
        }
    }

    #[test]
    fn synthesis_of_both_rows_is_the_sum_of_their_waves() {
        for (width, order) in [(1, 5), (2, 7), (17, 40), (64, 33), (1000, 256)] {
            let mut random = Random::new(3);
            let mut waves = || -> Vec<[Rgb<f64>; 2]> {
                (0..order).map(|_| [(); 2].map(|()| Rgb::from([(); 3].map(|()| random.signed())))).collect()
            };
            let waves = [waves(), waves()];
            let fft = RowFft::new(width, order);
            let mut rows = [vec![Rgb::<f32>::ZERO; width], vec![Rgb::<f32>::ZERO; width]];
            let [upper, lower] = &mut rows;
            fft.synthesize_into([&waves[0], &waves[1]], [upper, lower], &mut fft.work(3));
            for (waves, row) in waves.iter().zip(&rows) {
                let mut expected = vec![Rgb::<f32>::ZERO; width];
                RowDft::new(width, order).synthesise_into(&[waves], &mut [&mut expected]);
                for (x, (found, expected)) in row.iter().zip(&expected).enumerate() {
                    let error = (found.widen() - expected.widen()).to_array().map(f64::abs);
                    assert!(error.iter().all(|e| *e < 2e-6 * order as f64), "width {width}, x {x}: {error:?}");
                }
            }
        }
    }
}
