//! Windows of the irradiance of a sun, where three bands have closed forms.

use lobe_sh::extrema::{certified_maximum, certified_minimum};
use lobe_sh::filter::scale_bands_in_place;
use lobe_sh::{Dir, Expansion as _, ShVec, Window, Zonal};

/// The irradiance of a sun under factors `w_1` and `w_2`, in units of its mean.
fn irradiance_of_sun(w: [f64; 2]) -> ShVec<f64> {
    let mut f = ShVec::<f64>::impulse(3, Dir::from_angles(0.8, 2.0), 4.0).convolved(&Zonal::clamped_cosine(3));
    scale_bands_in_place(f.coefficients_mut(), &[1.0, w[0], w[1]]);
    f
}

fn least(f: &ShVec<f64>) -> f64 {
    certified_minimum(f.coefficients(), 0.0).hi
}

fn peak(f: &ShVec<f64>) -> f64 {
    certified_maximum(f.coefficients(), 0.0).lo
}

#[test]
fn powers_of_sinc_end_the_ringing_of_irradiance_at_their_known_widths() {
    for (power, known) in
        [(2.0, 2.2978440634), (3.0, 2.8510978922), (4.0, 3.3144634591), (6.0, 4.0869319006), (8.0, 4.7351630653)]
    {
        let (mut low, mut high) = (2.0_f64, 6.0);
        for _ in 0..60 {
            let width = 0.5 * (low + high);
            let window = Window::Lanczos { width, power };
            if least(&irradiance_of_sun([window.factor(1), window.factor(2)])) < 0.0 {
                high = width;
            } else {
                low = width;
            }
        }
        assert!((low - known).abs() < 1e-9, "sinc to the power {power}: width {low} against {known}");
    }
}

#[test]
fn the_edge_of_non_negative_factors_has_its_known_points() {
    // Sharpest, the factors of the last row of Sloan's table with the first raised to the edge, and least changed.
    for w in [[0.838525492, 1.0], [0.757800715, 0.412749060], [0.857890, 0.909395]] {
        let at = least(&irradiance_of_sun(w));
        let beyond = least(&irradiance_of_sun([w[0] + 1e-5, w[1]]));
        assert!(at.abs() < 2e-6 && beyond < at - 1e-6, "{w:?}: least value {at}, beyond it {beyond}");
    }
    let sharpest = peak(&irradiance_of_sun([0.838525492, 1.0]));
    assert!((sharpest - 3.927050983).abs() < 1e-8, "peak {sharpest}");
}

#[test]
fn the_window_of_punctual_lights_leaves_their_known_extremes() {
    let window = Window::PunctualLight;
    let bare = irradiance_of_sun([1.0, 1.0]);
    let f = bare.windowed(&window);
    // 1 + 1.84 z + 0.9125 (3z² - 1)/2, lowest at z = -0.672.
    let known = 0.54375 - 1.84 * 1.84 / (4.0 * 1.36875);
    assert!((least(&f) - known).abs() < 1e-12 && (known + 0.0746).abs() < 5e-5, "{} against {known}", least(&f));
    assert!(
        (peak(&f) - 3.7525).abs() < 1e-12 && (peak(&bare) - 4.25).abs() < 1e-12,
        "peaks {} {}",
        peak(&f),
        peak(&bare)
    );
}
