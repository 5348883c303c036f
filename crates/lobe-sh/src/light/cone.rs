//! A disc of constant radiance: the light of a sphere, and of a cone with a hard edge.

use std::f64::consts::PI;

use crate::Zonal;

impl Zonal {
    /// Radiance 1 within `half_angle` (radians, in `[0, π]`) of the axis, 0 outside.
    ///
    /// It is also what a sphere of radius `r` at distance `d` sends, with `half_angle = asin(r/d)`. With `a` the half
    /// angle and `c = cos a` ([Sloan 2008] A3, where band 3 is misprinted):
    ///
    /// ```text
    ///   z_0 = √π (1 - c)                     = 2√π sin²(a/2)
    ///   z_l = √(π/(2l+1)) (P_{l-1}(c) - P_{l+1}(c))
    ///       = √(π (2l+1)) sin² a P_l'(c) / (l(l+1))            P_{l+1}' = P_{l-1}' + (2l+1) P_l
    /// ```
    ///
    /// The second form of each line is computed: nothing cancels, so that small discs keep all their digits. The tests
    /// `hard_cones_equal_quadrature` (1e-12) and `small_cones_keep_their_digits` (relative 1e-12) bound the error.
    /// With `half_angle` 0 it is zero, with π the constant 1.
    ///
    /// # Panics
    /// If `half_angle` is outside `[0, π]`.
    ///
    /// [Sloan 2008]: https://www.ppsloan.org/publications/StupidSH36.pdf
    #[must_use]
    pub fn cone(order: usize, half_angle: f64) -> Self {
        assert!((0.0..=PI).contains(&half_angle), "the half angle of a cone lies in [0, π], it is not {half_angle}");
        let cosine = half_angle.cos();
        let sine_squared = half_angle.sin().powi(2);
        // P_{l-1}, P_l and P_{l-1}', P_l'
        let (mut p_before, mut p) = (0.0, 1.0);
        let (mut slope_before, mut slope) = (0.0, 0.0);
        let band = |l: usize| {
            if l == 0 {
                return 2.0 * PI.sqrt() * (0.5 * half_angle).sin().powi(2);
            }
            let lf = l as f64;
            (slope_before, slope) = (slope, slope_before + (2.0 * lf - 1.0) * p);
            (p_before, p) = (p, ((2.0 * lf - 1.0) * cosine * p - (lf - 1.0) * p_before) / lf);
            (PI * (2.0 * lf + 1.0)).sqrt() * sine_squared * slope / (lf * (lf + 1.0))
        };
        Self::new((0..order).map(band).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_testkit::golden_f64s;

    /// From a hundredth of a degree to the whole sphere, evenly in the logarithm, and the angles of the golden values.
    pub(crate) fn half_angles() -> Vec<f64> {
        let spread = (0..=60).map(|k| 0.01 * 18000.0_f64.powf(f64::from(k) / 60.0));
        spread.chain([0.5, 2.0, 8.0, 12.5, 30.0, 45.0, 90.0, 120.0]).map(|a| a.min(180.0).to_radians()).collect()
    }

    #[test]
    fn hard_cones_equal_quadrature() {
        for a in half_angles() {
            for order in 1..=10 {
                let c = a.cos();
                let expected = Zonal::project(order, &[c], 8, |t| f64::from(u8::from(t > c)));
                for (l, (z, q)) in Zonal::cone(order, a).coefficients().iter().zip(expected.coefficients()).enumerate()
                {
                    assert!((z - q).abs() < 1e-12, "{} degrees, order {order}, band {l}: {z}, {q}", a.to_degrees());
                }
            }
        }
    }

    #[test]
    fn hard_cones_have_their_golden_coefficients() {
        for degrees in ["0.5", "2", "8", "15", "30", "45", "60", "90", "120", "180"] {
            let cone = Zonal::cone(8, degrees.parse::<f64>().unwrap().to_radians());
            for (l, (z, golden)) in
                cone.coefficients().iter().zip(golden_f64s(&format!("/cone_zh/{degrees}"))).enumerate()
            {
                assert!((z - golden).abs() < 1e-14, "{degrees} degrees, band {l}: {z} against {golden}");
            }
        }
    }

    // Where (l+1) a is small, P_l(cos t) = J_0((l + ½) t) + O(t²), and the integral of the first two terms of its
    // series is z_l = √π √(2l+1) a²/2 (1 - (l² + l + ⅔) a²/8 .. ), good to a relative O((l a)⁴).
    #[test]
    fn small_cones_keep_their_digits() {
        for a in [1e-4, 1e-6, 1e-9, 1e-100_f64] {
            for (l, z) in Zonal::cone(10, a).coefficients().iter().enumerate() {
                let lf = l as f64;
                // ∫_0^a (1 - l(l+1) t²/4)(t - t³/6) dt
                let ratio = 1.0 - (lf * (lf + 1.0) + 2.0 / 3.0) * a * a / 8.0;
                let expected = (PI * (2.0 * lf + 1.0)).sqrt() * 0.5 * a * a * ratio;
                assert!((z / expected - 1.0).abs() < 1e-12, "a {a}, band {l}: {z} against {expected}");
            }
        }
    }

    #[test]
    fn the_whole_sphere_is_the_constant_and_no_cone_is_zero() {
        for (l, z) in Zonal::cone(20, PI).coefficients().iter().enumerate() {
            let expected = if l == 0 { 2.0 * PI.sqrt() } else { 0.0 };
            assert!((z - expected).abs() < 1e-14, "band {l}: {z}");
        }
        assert_eq!(Zonal::cone(4, 0.0), Zonal::new(vec![0.0; 4]), "a half angle of 0");
        assert_eq!(Zonal::cone(0, 1.0).order(), 0, "order 0");
    }

    #[test]
    #[should_panic(expected = "half angle of a cone")]
    fn a_half_angle_beyond_the_sphere_is_refused() {
        let _ = Zonal::cone(2, 3.2);
    }
}
