//! Discrete Fourier transform along pairs of rows of a lat-long picture by FFT, and its inverse.

use std::sync::Arc;

use lobe_sh::Rgb;
use lobe_sh::simd::Machine;
use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlanner, FftPlannerScalar};

use crate::mapping::lat_long::sin_cos_pi;
use crate::projection::row_dft::RowSums;

// Two real rows u and v are one complex row z = u + iv. Its transform Z has those of both:
//
//     U_m = (Z_m + Z*_{w-m})/2        V_m = (Z_m - Z*_{w-m})/(2i)
//
// The columns lie at φ_x = π (w - 2x - 1)/w, so that Σ_x u(x) e^{imφ_x} = t_m U_m, t_m = e^{iπm(w - 1)/w}; and
// Σ_m A_m cos mφ_x + B_m sin mφ_x = Re Σ_m (A_m - iB_m) t_m e^{-2πimx/w}, half of which each of m and w - m gives.

/// The transform of rows of one width, waves `m < order`.
pub(crate) struct RowFft {
    fft: Arc<dyn Fft<f64>>,
    waves: Vec<Wave>,
}

/// `t_m/2`, and the places of `m` and `w - m` in the transform.
struct Wave {
    turn: Complex<f64>,
    at: usize,
    mirrored: usize,
}

impl RowFft {
    /// By AVX if the machine has it and `LOBE_SIMD` allows it.
    pub(crate) fn new(width: usize, order: usize) -> Self {
        let fft = if Machine::detect().is_plain() {
            FftPlannerScalar::new().plan_fft_forward(width)
        } else {
            FftPlanner::new().plan_fft_forward(width)
        };
        let wave = |m: usize| {
            // Reduced to a turn in integers: no digit is lost for any m.
            let step = (m as i128 * (width as i128 - 1)).rem_euclid(2 * width as i128);
            let (sin, cos) = sin_cos_pi(step as f64 / width as f64);
            Wave { turn: 0.5 * Complex::new(cos, sin), at: m % width, mirrored: (width - m % width) % width }
        };
        Self { fft, waves: (0..order).map(wave).collect() }
    }

    /// `Σ_x L(x) cos mφ_x` and `Σ_x L(x) sin mφ_x` of two rows.
    pub(crate) fn sums_into(&self, rows: [&[Rgb<f32>]; 2], sums: [&mut RowSums; 2], work: &mut FftWork) {
        let [red, green, blue] = &mut work.channels;
        let places = red.iter_mut().zip(green).zip(blue);
        for ((u, v), ((r, g), b)) in rows[0].iter().zip(rows[1]).zip(places) {
            *r = Complex::new(f64::from(u.r), f64::from(v.r));
            *g = Complex::new(f64::from(u.g), f64::from(v.g));
            *b = Complex::new(f64::from(u.b), f64::from(v.b));
        }
        self.transform(work);
        let [red, green, blue] = &work.channels;
        let [upper, lower] = sums;
        for ((&Wave { turn, at, mirrored }, upper), lower) in self.waves.iter().zip(upper).zip(lower) {
            let parts = |z: &[Complex<f64>]| {
                let (z, mirrored) = (z[at], z[mirrored].conj());
                let (u, v) = (z + mirrored, mirrored - z);
                [u * turn, Complex::new(-v.im, v.re) * turn]
            };
            let [[u_r, v_r], [u_g, v_g], [u_b, v_b]] = [parts(red), parts(green), parts(blue)];
            *upper = [Rgb::new(u_r.re, u_g.re, u_b.re), Rgb::new(u_r.im, u_g.im, u_b.im)];
            *lower = [Rgb::new(v_r.re, v_g.re, v_b.re), Rgb::new(v_r.im, v_g.im, v_b.im)];
        }
    }

    /// `Σ_m A_m cos mφ_x + B_m sin mφ_x` into every texel of two rows; `waves` are the `[A_m, B_m]` of each.
    pub(crate) fn synthesize_into(&self, waves: [&RowSums; 2], rows: [&mut [Rgb<f32>]; 2], work: &mut FftWork) {
        for channel in &mut work.channels {
            channel.fill(Complex::new(0.0, 0.0));
        }
        let [red, green, blue] = &mut work.channels;
        for ((&Wave { turn, at, mirrored }, u), v) in self.waves.iter().zip(waves[0]).zip(waves[1]) {
            let add = |z: &mut [Complex<f64>], u: [f64; 2], v: [f64; 2]| {
                let (u, v) = (Complex::new(u[0], -u[1]) * turn, Complex::new(v[0], -v[1]) * turn);
                z[at] += Complex::new(u.re - v.im, u.im + v.re);
                z[mirrored] += Complex::new(u.re + v.im, v.re - u.im);
            };
            add(red, [u[0].r, u[1].r], [v[0].r, v[1].r]);
            add(green, [u[0].g, u[1].g], [v[0].g, v[1].g]);
            add(blue, [u[0].b, u[1].b], [v[0].b, v[1].b]);
        }
        self.transform(work);
        let [red, green, blue] = &work.channels;
        let [upper, lower] = rows;
        for ((u, v), ((r, g), b)) in upper.iter_mut().zip(lower).zip(red.iter().zip(green).zip(blue)) {
            *u = Rgb::new(r.re as f32, g.re as f32, b.re as f32);
            *v = Rgb::new(r.im as f32, g.im as f32, b.im as f32);
        }
    }

    fn transform(&self, work: &mut FftWork) {
        for channel in &mut work.channels {
            self.fft.process_with_scratch(channel, &mut work.scratch);
        }
    }

    /// Room for one thread.
    pub(crate) fn work(&self) -> FftWork {
        let zeros = |count| vec![Complex::new(0.0, 0.0); count];
        FftWork {
            channels: [(); 3].map(|()| zeros(self.fft.len())),
            scratch: zeros(self.fft.get_inplace_scratch_len()),
        }
    }
}

/// The scratch space of one thread.
pub(crate) struct FftWork {
    /// Two rows of each channel.
    channels: [Vec<Complex<f64>>; 3],
    scratch: Vec<Complex<f64>>,
}

#[cfg(test)]
mod tests {
    use lobe_sh::Coefficient as _;
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
            fft.sums_into([&rows[0], &rows[1]], [upper, lower], &mut fft.work());
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
            let mut rows = [vec![Rgb::ZERO; width], vec![Rgb::ZERO; width]];
            let [upper, lower] = &mut rows;
            fft.synthesize_into([&waves[0], &waves[1]], [upper, lower], &mut fft.work());
            for (waves, row) in waves.iter().zip(&rows) {
                let mut expected = vec![Rgb::ZERO; width];
                RowDft::new(width, order).synthesise_into(waves, &mut expected);
                for (x, (found, expected)) in row.iter().zip(&expected).enumerate() {
                    let error = (found.widen() - expected.widen()).to_array().map(f64::abs);
                    assert!(error.iter().all(|e| *e < 2e-6 * order as f64), "width {width}, x {x}: {error:?}");
                }
            }
        }
    }
}
